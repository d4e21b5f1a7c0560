//! The film: for each pixel of an image, the sums of the samples rendered so far.
//!
//! A sample is a row of numbers, its *channels*: first the colour, then those of the film's other layers.

mod file;
mod merge;
mod noise;
mod schedule;
mod sum;
#[cfg(test)]
mod tests;
mod tile;

pub(crate) use merge::{Conflict, SampleIndex};
pub(crate) use schedule::{Schedule, Unit};
pub(crate) use sum::CHUNK;
pub(crate) use tile::Grid;
pub use tile::Tile;

use std::ops::Range;

use glam::Vec3;

use crate::error::{Error, Result};

/// One RGB value per pixel, row by row.
pub(crate) type Plane = Vec<[f32; 3]>;

/// The sums of some pixels, row by row: the channels of the first pixel, then those of the second.
pub(crate) type Sums = Vec<f32>;

/// Number of channels of colour.
pub(crate) const COLOR: usize = 3;

/// Sums of the samples of some pixels of an image.
#[derive(Clone, Debug)]
pub struct Film {
    area: Tile,
    samples: Range<u32>,
    /// Number of channels of a sample.
    channels: usize,
    /// For each pixel of `area`, one past the last finished sample; [`ABSENT`] for pixels that
    /// belong to other films.
    done: Vec<u32>,
    /// Plane 0 holds the first kept sum of each pixel, plane 1 the second, and so on: the nodes of
    /// `sum.rs`, then the running sum of an incomplete chunk.
    sums: Vec<Sums>,
}

/// Marks a pixel that the film does not have.
const ABSENT: u32 = u32::MAX;

/// The result of a [`Unit`] of work.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct UnitSums {
    /// The samples that were rendered.
    pub unit: Unit,
    /// For each pixel, the sum of its chunk up to `unit.end`: the samples of the unit, added in
    /// order to [`Film::open_sums`].
    pub sums: Sums,
}

impl Film {
    /// Creates a film without any finished samples, for the samples `samples` of the pixels of
    /// `area`, each of `channels` numbers. The first sample must be the first of a chunk.
    ///
    /// # Errors
    /// [`Error::Resource`] if memory runs out.
    pub(crate) fn new(area: Tile, samples: Range<u32>, channels: usize) -> Result<Self> {
        let done = plane(area, samples.start, 1)?;
        Ok(Self { area, samples, channels, done, sums: Vec::new() })
    }

    /// Memory in bytes for a complete film and its means.
    pub(crate) fn memory(area: Tile, samples: Range<u32>, channels: usize) -> u64 {
        Self::most_bytes(area, samples, channels) + 4 * channels as u64 * area.pixels()
    }

    /// Largest size of a film in bytes, in memory and in a file.
    pub(crate) fn most_bytes(area: Tile, samples: Range<u32>, channels: usize) -> u64 {
        let chunks = (samples.end - samples.start).div_ceil(CHUNK);
        // Each pixel has at most one incomplete chunk, and at most two nodes per level, or one node
        // per level if the samples start with sample 0.
        let levels = u64::from(u32::BITS - chunks.leading_zeros());
        let sums = 1 + levels * if samples.start == 0 { 1 } else { 2 };
        area.pixels() * (4 + 4 * channels as u64 * sums)
    }

    /// The rectangle that contains the pixels of the film.
    pub fn area(&self) -> Tile {
        self.area
    }

    /// Number of channels of a sample.
    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// The samples that each pixel of the complete film has.
    pub(crate) fn samples(&self) -> Range<u32> {
        self.samples.clone()
    }

    /// The range of the pixels of the rows `rows` of the area.
    fn of_rows(&self, rows: Range<u32>) -> Range<usize> {
        let width = self.area.width as usize;
        rows.start as usize * width..rows.end as usize * width
    }

    /// One past the last sample that all pixels have finished.
    pub(crate) fn least_done(&self) -> u32 {
        self.done.iter().copied().min().unwrap_or(0).min(self.samples.end)
    }

    /// The first of `samples` that the pixels of `tile` lack, or `samples.end` if they lack none;
    /// `None` if it differs from pixel to pixel.
    fn first_lacking(&self, tile: Tile, samples: &Range<u32>) -> Option<u32> {
        let lacking = |done: u32| done.clamp(samples.start, samples.end);
        let first = lacking(self.done[self.row(tile, 0).start]);
        self.all(tile, |done| lacking(done) == first).then_some(first)
    }

    /// For each pixel of `unit`, the sum of the earlier samples of the same chunk. Empty if the
    /// unit starts a chunk.
    pub(crate) fn open_sums(&self, unit: Unit) -> Sums {
        if unit.first.is_multiple_of(CHUNK) {
            return Sums::new();
        }
        let sums = &self.sums[sum::sums(&(self.samples.start..unit.first)) - 1];
        let row = |row| &sums[self.of_pixels(self.row(unit.tile, row))];
        (0..unit.tile.height).flat_map(row).copied().collect()
    }

    /// The range of the channels of `pixels` in sums.
    fn of_pixels(&self, pixels: Range<usize>) -> Range<usize> {
        pixels.start * self.channels..pixels.end * self.channels
    }

    /// Whether each pixel of `unit` has exactly the samples before `unit.first`.
    pub(crate) fn is_next(&self, unit: Unit) -> bool {
        self.all(unit.tile, |done| done == unit.first)
    }

    /// Whether `is` holds for the end of the finished samples of each pixel of `tile`.
    fn all(&self, tile: Tile, is: impl Fn(u32) -> bool) -> bool {
        (0..tile.height).all(|row| self.done[self.row(tile, row)].iter().all(|&done| is(done)))
    }

    /// Adds the samples of `part`, which must be [next](Self::is_next).
    ///
    /// # Errors
    /// [`Error::Resource`] if memory runs out.
    pub(crate) fn add(&mut self, part: &UnitSums) -> Result<()> {
        let Unit { tile, first, end } = part.unit;
        // The new sum of an open chunk includes the old one, and overwrites it.
        let kept = sum::sums(&(self.samples.start..first / CHUNK * CHUNK));
        let node = end.is_multiple_of(CHUNK).then_some((0, first / CHUNK));
        let width = tile.width as usize * self.channels;
        for (row, sums) in (0..).zip(part.sums.chunks_exact(width)) {
            let row = self.row(tile, row);
            self.push(row.clone(), kept, node, sums)?;
            self.done[row].fill(end);
        }
        Ok(())
    }

    /// Adds the sums of a node, or of an incomplete chunk, to the `kept` sums of `pixels`, and
    /// returns the new number of kept sums.
    fn push(
        &mut self,
        pixels: Range<usize>,
        kept: usize,
        node: Option<(u32, u32)>,
        sums: &[f32],
    ) -> Result<usize> {
        let begin = self.samples.start / CHUNK;
        let index = kept - node.map_or(0, |node| sum::left_siblings(begin, node));
        self.make_room(index + 1)?;
        let (mut sums, place) = (sums.to_vec(), self.of_pixels(pixels));
        for left in self.sums[index..kept].iter().rev() {
            for (sum, left) in sums.iter_mut().zip(&left[place.clone()]) {
                *sum += left;
            }
        }
        self.sums[index][place].copy_from_slice(&sums);
        Ok(index + 1)
    }

    /// The mean colours of the finished samples; black for pixels without any.
    ///
    /// # Errors
    /// [`Error::Resource`] if memory runs out.
    pub fn means(&self) -> Result<Plane> {
        let mut means = plane(self.area, [0.0; 3], 1)?;
        let width = self.area.width as usize;
        for (row, means) in (0..).zip(means.chunks_exact_mut(width)) {
            let mut means = means.iter_mut();
            self.totals(row, |sums, count| {
                let sum = [sums[0], sums[1], sums[2]];
                *means.next().expect("a row has as many pixels") = mean(sum, count as f32);
            });
        }
        Ok(means)
    }

    /// Calls `take` for each pixel of row number `row` of the area with the sum of all its finished samples, channel by
    /// channel, and their number.
    pub(crate) fn totals(&self, row: u32, mut take: impl FnMut(&[f32], u32)) {
        let pixels = self.of_rows(row..row + 1);
        let mut totals = vec![0.0; self.channels];
        for (pixel, (end, kept)) in pixels.clone().zip(self.kept(pixels)) {
            let place = self.of_pixels(pixel..pixel + 1);
            let (sums, count) = (&self.sums[..kept], end - self.samples.start);
            if let [sums] = sums {
                // As in frames in real time, which have one sample.
                take(&sums[place], count);
            } else {
                sum::total(sums.iter().map(|sums| &sums[place.clone()]), &mut totals);
                take(&totals, count);
            }
        }
    }

    /// For each of `pixels`, one past its last finished sample, and the number of sums kept for it.
    fn kept(&self, pixels: Range<usize>) -> impl Iterator<Item = (u32, usize)> {
        let begin = self.samples.start;
        // Most pixels have as many samples as the pixel before them.
        let mut last = (begin, 0);
        self.done[pixels].iter().map(move |&done| {
            let done = if done == ABSENT { begin } else { done };
            if done != last.0 {
                last = (done, sum::sums(&(begin..done)));
            }
            last
        })
    }

    /// Keeps only the pixels for which `keep` returns true, given their x and y in the image. The
    /// samples of all other pixels are lost.
    pub(crate) fn retain(&mut self, keep: impl Fn(u32, u32) -> bool) {
        for (pixel, done) in (0..).zip(&mut self.done) {
            let (x, y) = self.area.pixel(pixel);
            if !keep(x, y) {
                *done = ABSENT;
            }
        }
    }

    /// Whether the film has exactly the pixels for which `has` returns true, given their x and y in
    /// the image.
    pub(crate) fn is_of(&self, has: impl Fn(u32, u32) -> bool) -> bool {
        (0..).zip(&self.done).all(|(pixel, &done)| {
            let (x, y) = self.area.pixel(pixel);
            has(x, y) == (done != ABSENT)
        })
    }

    /// One past the last finished sample of any pixel.
    pub(crate) fn most_done(&self) -> u32 {
        let done = self.done.iter().copied().filter(|&done| done != ABSENT);
        done.max().unwrap_or(self.samples.start)
    }

    /// Makes `end` the end of the film's samples. No pixel may have later ones.
    pub(crate) fn end_at(&mut self, end: u32) {
        assert!(self.most_done() <= end, "a pixel has samples after {end}");
        self.samples.end = end;
    }

    /// Extends the samples of the film to `end`, unless they end later already.
    pub(crate) fn grow(&mut self, end: u32) {
        self.samples.end = self.samples.end.max(end);
    }

    /// Number of pixels that the film has.
    pub(crate) fn pixels(&self) -> u64 {
        self.done.iter().filter(|&&done| done != ABSENT).count() as u64
    }

    /// Number of finished samples, over all pixels.
    pub fn samples_done(&self) -> u64 {
        let done = self.done.iter().filter(|&&done| done != ABSENT);
        done.map(|done| u64::from(done - self.samples.start)).sum()
    }

    /// Number of samples of the complete film, over all pixels.
    pub fn samples_to_do(&self) -> u64 {
        self.pixels() * u64::from(self.samples.end - self.samples.start)
    }

    /// Makes room for `sums` sums per pixel.
    fn make_room(&mut self, sums: usize) -> Result<()> {
        while self.sums.len() < sums {
            self.sums.push(plane(self.area, 0.0, self.channels)?);
        }
        Ok(())
    }

    /// The range of row number `row` of `tile` in planes.
    fn row(&self, tile: Tile, row: u32) -> Range<usize> {
        let Tile { x, y, width, .. } = self.area;
        let first = (tile.y - y + row) as usize * width as usize + (tile.x - x) as usize;
        first..first + tile.width as usize
    }
}

/// `sum / count`, or black if `count` is 0.
pub(crate) fn mean(sum: [f32; 3], count: f32) -> [f32; 3] {
    if count == 0.0 { [0.0; 3] } else { (Vec3::from(sum) / count).to_array() }
}

/// Allocates `numbers` times `value` for each pixel of `area`.
///
/// # Errors
/// [`Error::Resource`] if memory runs out.
pub(crate) fn plane<T: Clone>(area: Tile, value: T, numbers: usize) -> Result<Vec<T>> {
    let (mut plane, length) = (Vec::new(), area.pixels() as usize * numbers);
    plane.try_reserve_exact(length).map_err(|_| {
        let Tile { width, height, .. } = area;
        Error::Resource(format!("not enough memory for an image of {width} × {height} pixels"))
    })?;
    plane.resize(length, value);
    Ok(plane)
}

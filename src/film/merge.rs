//! Merges films with different pixels or samples into one film.

use std::ops::Range;

use super::{ABSENT, CHUNK, Film, sum};
use crate::error::Result;

/// A sample: the x and y of its pixel in the image, and its number.
pub(crate) type SampleIndex = (u32, u32, u32);

/// Why a film cannot be appended to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Conflict {
    /// Both films have this sample.
    Twice(SampleIndex),
    /// Neither film has this sample, but one has later samples of the pixel.
    Missing(SampleIndex),
}

impl Film {
    /// Appends all samples of `film`, which must be complete and have the same area as `self`. In
    /// each pixel that `film` has, its samples must directly follow those of `self`; otherwise the
    /// first conflict is returned, and `self` is no longer usable.
    ///
    /// # Errors
    /// [`Error::Resource`](crate::Error::Resource) if memory runs out.
    pub(crate) fn append(&mut self, film: &Self) -> Result<Option<Conflict>> {
        let start = film.samples.start;
        let mut first = 0;
        while let Some(run) = self.next_run(film, first) {
            let done = self.done[run.start];
            if done != start {
                let conflict = if done < start { Conflict::Missing } else { Conflict::Twice };
                return Ok(Some(conflict(self.sample(run.start, done.min(start)))));
            }
            first = run.end;
            self.append_run(film, run)?;
        }
        Ok(None)
    }

    /// The first unfinished sample, if any.
    pub(crate) fn missing(&self) -> Option<SampleIndex> {
        let pixel = self.done.iter().position(|&done| done < self.samples.end)?;
        Some(self.sample(pixel, self.done[pixel]))
    }

    /// Whether the sample is finished.
    pub(crate) fn has(&self, (x, y, sample): SampleIndex) -> bool {
        let pixel =
            (y - self.area.y) as usize * self.area.width as usize + (x - self.area.x) as usize;
        let done = self.done[pixel];
        done != ABSENT && (self.samples.start..done).contains(&sample)
    }

    fn sample(&self, pixel: usize, sample: u32) -> SampleIndex {
        let (x, y) = self.area.pixel(pixel as u32);
        (x, y, sample)
    }

    /// The next run of pixels that `film` has, at or after pixel number `first`. The pixels of the
    /// run are in one row and have the same number of samples in `self`.
    fn next_run(&self, film: &Self, first: usize) -> Option<Range<usize>> {
        let width = self.area.width as usize;
        let present = |pixel: &usize| film.done[*pixel] != ABSENT;
        let start = (first..self.done.len()).find(present)?;
        let row_end = start + width - start % width;
        let goes_on = |pixel: &usize| present(pixel) && self.done[*pixel] == self.done[start];
        let length = (start..row_end).take_while(goes_on).count();
        Some(start..start + length)
    }

    fn append_run(&mut self, film: &Self, pixels: Range<usize>) -> Result<()> {
        let Range { start, end } = film.samples;
        let mut kept = sum::sums(&(self.samples.start..start));
        let nodes = sum::nodes(start / CHUNK..end / CHUNK).map(Some).chain([None]);
        for (node, sums) in nodes.zip(&film.sums).take(sum::sums(&(start..end))) {
            let sums = &sums[film.of_pixels(pixels.clone())];
            kept = self.push(pixels.clone(), kept, node, sums)?;
        }
        self.done[pixels].fill(end);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::tests::{AREA, CHANNELS, rendered_film, want};

    /// Appends `films` in order, until a conflict.
    fn merged(samples: Range<u32>, films: &[&Film]) -> (Film, Option<Conflict>) {
        let mut merged = Film::new(AREA, samples, CHANNELS).unwrap();
        let conflict = films.iter().find_map(|film| merged.append(film).unwrap());
        (merged, conflict)
    }

    /// Merges films that are split by pixels, by samples, and by both.
    #[test]
    fn parts_merge_into_the_whole() {
        let (all, spp) = (|_: u32, _: u32| true, 333);
        let even = |x: u32, y: u32| (x + y / 3).is_multiple_of(2);
        let odd = move |x: u32, y: u32| !even(x, y);
        let splits: [Vec<Film>; 4] = [
            vec![rendered_film(0..spp, odd), rendered_film(0..spp, even)],
            vec![
                rendered_film(0..16, all),
                rendered_film(16..96, all),
                rendered_film(96..spp, all),
            ],
            vec![
                rendered_film(0..112, even),
                rendered_film(0..208, odd),
                rendered_film(112..spp, even),
                rendered_film(208..spp, odd),
            ],
            vec![rendered_film(0..spp, all)],
        ];
        for films in splits {
            let films: Vec<&Film> = films.iter().collect();
            let (merged, conflict) = merged(0..spp, &films);
            assert_eq!((conflict, merged.missing()), (None, None));
            assert_eq!(merged.means().unwrap(), want(spp));
        }
    }

    #[test]
    fn overlaps_and_gaps_are_reported() {
        let (all, right) = (|_: u32, _: u32| true, |x: u32, _: u32| x > 10);
        let conflict = |films: &[&Film]| merged(0..50, films).1;
        let [begin, end] = [rendered_film(0..32, all), rendered_film(32..50, all)];
        let [some, middle] = [rendered_film(0..50, right), rendered_film(16..32, all)];
        let at = |x, sample| (x, AREA.y, sample);
        assert_eq!(merged(0..50, &[&begin]).0.missing(), Some(at(AREA.x, 32)));
        assert_eq!(merged(0..50, &[&some]).0.missing(), Some(at(AREA.x, 0)));
        assert_eq!(merged(0..50, &[]).0.missing(), Some(at(AREA.x, 0)));
        assert_eq!(conflict(&[&end]), Some(Conflict::Missing(at(AREA.x, 0))));
        assert_eq!(conflict(&[&begin, &begin]), Some(Conflict::Twice(at(AREA.x, 0))));
        assert_eq!(conflict(&[&begin, &middle]), Some(Conflict::Twice(at(AREA.x, 16))));
        assert_eq!(conflict(&[&some, &begin]), Some(Conflict::Twice(at(11, 0))));
        assert!(begin.has(at(AREA.x, 31)) && !begin.has(at(AREA.x, 32)));
        assert!(some.has(at(11, 49)) && !some.has(at(10, 0)));
    }
}

//! The order in which the samples of a film are taken.

use super::Film;
use super::sum::CHUNK;
use super::tile::{Grid, Tile};

/// Samples of one chunk, of neighbouring pixels: what a worker renders at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// The pixels.
    pub tile: Tile,
    /// The first sample of each pixel.
    pub first: u32,
    /// The end of its samples.
    pub end: u32,
}

impl Unit {
    /// Samples of a pixel.
    pub fn samples(&self) -> u32 {
        self.end - self.first
    }

    /// Samples of all pixels.
    pub fn paths(&self) -> u64 {
        self.tile.pixels() * u64::from(self.samples())
    }
}

/// The units that a film still lacks, chunk after chunk over all pixels: whenever the work stops, the
/// image is equally good everywhere. (More samples of fewer pixels at once are not faster.)
#[derive(Debug)]
pub(crate) struct Schedule {
    area: Tile,
    /// Most paths of a unit, where a pixel's are not more.
    paths: u64,
    /// The end of all samples.
    end: u32,
    /// The samples that are taken now, ...
    first: u32,
    /// ... the tiles that are still to be looked at, ...
    tiles: Grid,
    /// ... and what is left of the one that was looked at last.
    rest: Vec<Tile>,
}

impl Schedule {
    /// For what `film` lacks of the samples before `end`, in units of at most `paths` paths or of one
    /// pixel.
    pub(crate) fn new(film: &Film, end: u32, paths: u32) -> Self {
        let (area, samples) = (film.area(), film.samples());
        let end = end.min(samples.end);
        let all = area.pixels() * u64::from(end.saturating_sub(samples.start));
        let mut schedule = Self {
            area,
            paths: all.min(paths.into()),
            end,
            first: 0,
            tiles: Grid::default(),
            rest: Vec::new(),
        };
        schedule.begin(film.least_done() / CHUNK * CHUNK);
        schedule
    }

    /// Takes the chunk that begins with sample `first`, if there is one.
    fn begin(&mut self, first: u32) {
        self.first = first;
        if first < self.end {
            self.tiles = Grid::new(self.area, self.paths / u64::from(self.chunk_end() - first));
        }
    }

    fn chunk_end(&self) -> u32 {
        self.end.min(self.first + CHUNK)
    }

    /// The next unit of `film`, for which this was made, and to which nothing was added since but what came
    /// of units from here.
    pub(crate) fn next(&mut self, film: &Film) -> Option<Unit> {
        loop {
            let tile = self.rest.pop().or_else(|| self.next_tile())?;
            // Earlier chunks that other workers still have count as done.
            let end = self.chunk_end();
            match film.first_lacking(tile, &(self.first..end)) {
                Some(first) if first < end => return Some(Unit { tile, first, end }),
                Some(_) => {}
                // An earlier run cut it into other units, or only a part of it is on the film.
                None => self.rest.extend(tile.halves()),
            }
        }
    }

    fn next_tile(&mut self) -> Option<Tile> {
        if let Some(tile) = self.tiles.next() {
            return Some(tile);
        }
        self.begin(self.chunk_end());
        self.tiles.next()
    }

    /// Most paths that a unit has.
    pub(crate) fn most_paths(&self) -> u64 {
        self.paths.max(u64::from(self.end.saturating_sub(self.first)).min(u64::from(CHUNK)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chunk after chunk, each pixel once, in units of the size that was asked for.
    #[test]
    fn all_samples_are_taken_once() {
        let area = Tile { x: 3, y: 2, width: 23, height: 9 };
        for (paths, samples) in
            [(1, 0..20), (100, 16..80), (1000, 0..4), (5000, 32..50), (1 << 20, 0..1)]
        {
            let film = Film::new(area, samples.clone()).unwrap();
            let mut schedule = Schedule::new(&film, samples.end, paths);
            let most = schedule.most_paths();
            assert!(most <= u64::from(paths.max(CHUNK)));
            let mut taken = vec![samples.start; area.pixels() as usize];
            let mut first = 0;
            while let Some(unit) = schedule.next(&film) {
                assert!(unit.paths() <= most && unit.first >= first && unit.end <= samples.end);
                assert!(unit.first.is_multiple_of(CHUNK) && unit.samples() <= CHUNK);
                first = unit.first;
                for pixel in 0..unit.tile.pixels() as u32 {
                    let (x, y) = unit.tile.pixel(pixel);
                    let taken = &mut taken[((y - area.y) * area.width + x - area.x) as usize];
                    assert_eq!(*taken, unit.first);
                    *taken = unit.end;
                }
            }
            assert!(taken.iter().all(|&end| end == samples.end));
        }
    }
}

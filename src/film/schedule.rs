//! The order in which the samples of a film are rendered.

use super::{CHUNK, Film, Grid, Tile};

/// Samples of one chunk for neighbouring pixels, which one worker renders together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// The pixels.
    pub tile: Tile,
    /// The first sample of each pixel.
    pub first: u32,
    /// One past the last sample of each pixel.
    pub end: u32,
}

impl Unit {
    /// Number of samples per pixel.
    pub fn samples(&self) -> u32 {
        self.end - self.first
    }

    /// Number of samples of all pixels.
    pub fn paths(&self) -> u64 {
        self.tile.pixels() * u64::from(self.samples())
    }
}

/// The units that a film still lacks, chunk after chunk over all pixels. The image is therefore
/// equally good everywhere whenever rendering stops. (Units with more samples of fewer pixels are
/// not faster.)
#[derive(Debug)]
pub(crate) struct Schedule {
    area: Tile,
    /// Largest number of paths per unit, unless a single pixel has more.
    paths: u64,
    /// One past the last sample to render.
    end: u32,
    /// First sample of the current chunk.
    first: u32,
    /// Tiles of the current chunk that are still to be examined.
    tiles: Grid,
    /// Remaining parts of the tile that was examined last.
    rest: Vec<Tile>,
}

impl Schedule {
    /// Schedules the samples before `end` that `film` lacks, in units of at most `paths` paths or
    /// of one pixel.
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

    /// Starts the chunk that begins with sample `first`, if that is before the end.
    fn begin(&mut self, first: u32) {
        self.first = first;
        if first < self.end {
            self.tiles = Grid::new(self.area, self.paths / u64::from(self.chunk_end() - first));
        }
    }

    fn chunk_end(&self) -> u32 {
        self.end.min(self.first + CHUNK)
    }

    /// Returns the next unit to render. `film` must be the film that the schedule was created for,
    /// with nothing added since except units of this schedule.
    pub(crate) fn next(&mut self, film: &Film) -> Option<Unit> {
        loop {
            let tile = self.rest.pop().or_else(|| self.next_tile())?;
            // Earlier chunks that other workers are still rendering count as finished.
            let end = self.chunk_end();
            match film.first_lacking(tile, &(self.first..end)) {
                Some(first) if first < end => return Some(Unit { tile, first, end }),
                Some(_) => {}
                // An earlier run cut the tile into other units, or the film has only some of its
                // pixels.
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

    /// Largest number of paths that a unit can have.
    pub(crate) fn most_paths(&self) -> u64 {
        self.paths.max(u64::from(self.end.saturating_sub(self.first)).min(u64::from(CHUNK)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units take chunk after chunk, contain each sample once, and respect the requested size.
    #[test]
    fn all_samples_are_taken_once() {
        let area = Tile { x: 3, y: 2, width: 23, height: 9 };
        for (paths, samples) in
            [(1, 0..20), (100, 16..80), (1000, 0..4), (5000, 32..50), (1 << 20, 0..1)]
        {
            let film = Film::new(area, samples.clone(), 3).unwrap();
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

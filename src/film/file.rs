//! The binary format of films.
//!
//! All numbers are little-endian. The file starts with a number for each pixel: one past its last
//! finished sample, or [`ABSENT`]. Then come the first kept sum of each pixel that has one, the
//! second of each pixel that has two, and so on.

use std::io::{self, Read, Write};
use std::ops::Range;

use super::{ABSENT, Film, Tile};

impl Film {
    /// Writes the film to `file`.
    ///
    /// # Errors
    /// If writing to `file` fails.
    pub(crate) fn write(&self, file: &mut impl Write) -> io::Result<()> {
        self.done.iter().try_for_each(|done| file.write_all(&done.to_le_bytes()))?;
        for (number, sums) in self.sums.iter().enumerate() {
            let pixels = sums.chunks_exact(self.channels).zip(self.kept(0..self.done.len()));
            for (sum, _) in pixels.filter(|(_, (_, kept))| *kept > number) {
                sum.iter().try_for_each(|value| file.write_all(&value.to_le_bytes()))?;
            }
        }
        Ok(())
    }

    /// Reads a film of the samples `samples` of the pixels of `area`, each of `channels` numbers.
    ///
    /// # Errors
    /// If reading `file` fails; [`io::ErrorKind::InvalidData`] if its content is not such a film,
    /// and [`io::ErrorKind::OutOfMemory`] if the film does not fit in memory.
    pub(crate) fn read(
        area: Tile,
        samples: Range<u32>,
        channels: usize,
        file: &mut impl Read,
    ) -> io::Result<Self> {
        let memory = |_| io::Error::from(io::ErrorKind::OutOfMemory);
        let mut film = Self::new(area, samples, channels).map_err(memory)?;
        let Range { start, end } = film.samples;
        for done in &mut film.done {
            let mut bytes = [0; 4];
            file.read_exact(&mut bytes)?;
            *done = u32::from_le_bytes(bytes);
            if !((start..=end).contains(done) || *done == ABSENT) {
                let message =
                    format!("a pixel's samples end at {done}, which is not in {start} to {end}");
                return Err(io::Error::new(io::ErrorKind::InvalidData, message));
            }
        }
        let most = film.kept(0..film.done.len()).map(|(_, kept)| kept).max().unwrap_or(0);
        film.make_room(most).map_err(memory)?;
        let mut planes = std::mem::take(&mut film.sums);
        for (number, sums) in planes.iter_mut().enumerate() {
            let pixels = sums.chunks_exact_mut(channels).zip(film.kept(0..film.done.len()));
            for (sum, _) in pixels.filter(|(_, (_, kept))| *kept > number) {
                for value in sum {
                    let mut bytes = [0; 4];
                    file.read_exact(&mut bytes)?;
                    *value = f32::from_le_bytes(bytes);
                    if value.is_nan() {
                        let message = "a sum of samples is not a number";
                        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
                    }
                }
            }
        }
        film.sums = planes;
        Ok(film)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Schedule;
    use crate::film::tests::{AREA, CHANNELS, rendered, rendered_film, totals};

    #[test]
    fn films_survive_a_round_trip() {
        let mut partly = Film::new(AREA, 16..333, CHANNELS).unwrap();
        partly.retain(|x, y| x * y % 3 > 0);
        let mut schedule = Schedule::new(&partly, 333, 100);
        for _ in 0..50 {
            let unit = schedule.next(&partly).unwrap();
            partly.add(&rendered(&partly, unit)).unwrap();
        }
        let empty = Film::new(AREA, 0..4, CHANNELS).unwrap();
        for film in [empty, partly, rendered_film(0..50, |x, _| x > 7)] {
            let mut bytes = Vec::new();
            film.write(&mut bytes).unwrap();
            let mut rest = &*bytes;
            let back = Film::read(AREA, film.samples(), CHANNELS, &mut rest).unwrap();
            assert!(rest.is_empty());
            assert_eq!(back.done, film.done);
            assert_eq!(back.means().unwrap(), film.means().unwrap());
            assert_eq!(totals(&back), totals(&film));
            for end in [0, 3, bytes.len() - 1] {
                let error =
                    Film::read(AREA, film.samples(), CHANNELS, &mut &bytes[..end]).unwrap_err();
                assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
            }
        }
    }

    #[test]
    fn impossible_sample_counts_are_rejected() {
        let area = Tile { width: 1, height: 1, ..AREA };
        let read = |done: u32| {
            let bytes: Vec<u8> = done.to_le_bytes().into_iter().chain([0; 200]).collect();
            Film::read(area, 16..50, CHANNELS, &mut &*bytes)
        };
        for done in [16, 17, 32, 48, 50, ABSENT] {
            assert!(read(done).is_ok(), "{done}");
        }
        for done in [0, 15, 51, 64, ABSENT - 1] {
            assert_eq!(read(done).unwrap_err().kind(), io::ErrorKind::InvalidData, "{done}");
        }
    }
}

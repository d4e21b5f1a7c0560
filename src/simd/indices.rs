//! Table indices, one in each lane, whose bounds are checked together.
//!
//! Measured (AVX-512, cycles of whole renders): compared with a check for each lane, spheres and
//! cornell with light samples take 0.96 of the cycles. `pick` alone accounts for a factor of 0.98.
//! The code of loops that use indices is a quarter shorter.
#![allow(unsafe_code)]

use super::{Float, Int, LANES, Lanes, Vec3x, first_bits, gather_rows, rows_of, splat_row};
use crate::math::{Row, Word};

/// Indices into a table of at least `end` entries, one in each lane, all below `end`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Indices {
    lanes: Lanes<u32>,
    end: usize,
    /// Whether all lanes are known to be 0.
    only: bool,
}

impl Indices {
    /// Checks that all lanes are below `end`.
    ///
    /// # Panics
    /// If a lane is not below `end`.
    #[inline(always)]
    pub(crate) fn new(lanes: Int, end: usize) -> Self {
        let last = end.checked_sub(1).expect("a table with at least one entry");
        let last = Int::splat(u32::try_from(last).unwrap_or(u32::MAX));
        assert!(lanes.le(last).bits() == first_bits(LANES), "all indices must be below {end}");
        Self { lanes: lanes.to_array(), end, only: false }
    }

    /// Does the same as [`Indices::new`], for tables that often have a single entry, which is then
    /// read only once for all lanes.
    #[inline(always)]
    pub(crate) fn of_few(lanes: Int, end: usize) -> Self {
        Self { only: end == 1, ..Self::new(lanes, end) }
    }

    pub(crate) fn lanes(&self) -> &Lanes<u32> {
        &self.lanes
    }

    /// Reads the rows of these entries of `table`.
    ///
    /// # Panics
    /// If the table has fewer than `end` entries.
    #[inline(always)]
    pub(crate) fn gather<T>(&self, table: &[T], row: impl Fn(&T) -> &Row) -> (Vec3x, Float) {
        assert!(self.end <= table.len());
        // SAFETY: all indices are below `end`, which is at most `table.len()`.
        let row = |index: u32| row(unsafe { table.get_unchecked(index as usize) });
        if self.only { splat_row(row(0)) } else { gather_rows(&self.lanes, row) }
    }

    /// Writes the rows of these entries of `table`. Lanes with the same entry must have the same
    /// row.
    ///
    /// # Panics
    /// If the table has fewer than `end` entries.
    #[inline(always)]
    pub(crate) fn scatter<T>(
        &self,
        table: &mut [T],
        row: impl Fn(&mut T) -> &mut Row,
        columns: (Vec3x, Float),
    ) {
        assert!(self.end <= table.len());
        for (words, &index) in rows_of(columns).into_iter().zip(&self.lanes) {
            // SAFETY: all indices are below `end`, which is at most `table.len()`.
            *row(unsafe { table.get_unchecked_mut(index as usize) }) = words;
        }
    }

    /// Reads these entries of `table`.
    ///
    /// # Panics
    /// If the table has fewer than `end` entries.
    #[inline(always)]
    pub(crate) fn pick(&self, table: &[u32]) -> Lanes<u32> {
        assert!(self.end <= table.len());
        let mut picked = self.lanes;
        for word in &mut picked {
            // SAFETY: all indices are below `end`, which is at most `table.len()`.
            *word = *unsafe { table.get_unchecked(*word as usize) };
        }
        picked
    }
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;

    use super::*;
    use crate::math::{Real, Stream, row};
    use glam::Vec3;

    #[test]
    fn entries_are_read_and_written() {
        let mut random = Stream::new(7);
        let mut table: Vec<[Row; 2]> =
            (0..40).map(|i| [[i; 4], row(Vec3::splat(i as f32), -1.0)]).collect();
        let words: Vec<u32> = (0..40).map(|i| i * i).collect();
        for _ in 0..100 {
            let lanes: Lanes<u32> = std::array::from_fn(|_| (random.bits() % 40) as u32);
            let indices = Indices::new(Int::new(lanes), table.len());
            assert_eq!(indices.pick(&words), lanes.map(|i| i * i));
            let (vector, number) = indices.gather(&table, |rows| &rows[1]);
            let few = Indices::of_few(Int::new(lanes), table.len());
            assert_eq!(few.gather(&table, |rows| &rows[1]).0[0].to_array(), vector[0].to_array());
            let only = Indices::of_few(Int::ZERO, 1).gather(&table[7..8], |rows| &rows[1]);
            assert_eq!(only.0[0].to_array(), [7.0; LANES]);
            assert_eq!(vector[2].to_array(), lanes.map(|i| i as f32));
            let changed = (vector, number + Float::splat(1.0));
            indices.scatter(&mut table, |rows| &mut rows[0], changed);
            for (i, rows) in (0..).zip(&mut table) {
                let written = row(Vec3::splat(i as f32), 0.0);
                assert_eq!(rows[0], if lanes.contains(&i) { written } else { [i; 4] });
                rows[0] = [i; 4];
            }
        }
    }

    #[test]
    fn indices_beyond_the_end_panic() {
        for lane in 0..LANES {
            let mut lanes = [0; LANES];
            lanes[lane] = 39;
            let lanes = Int::new(lanes);
            assert_eq!(Indices::new(lanes, 40).lanes()[lane], 39);
            let below = |end| catch_unwind(|| Indices::new(lanes, end)).is_ok();
            assert!(below(40) && !below(39) && !below(1) && !below(0), "lane {lane}");
        }
        for beyond in [40, 1 << 31, u32::MAX] {
            assert!(catch_unwind(|| Indices::new(Int::splat(beyond), 40)).is_err());
        }
        let longer = Indices::new(Int::splat(3), 41);
        let rows = [[0; 4]; 40];
        assert!(catch_unwind(|| longer.pick(&[0; 40])).is_err());
        assert!(catch_unwind(|| longer.gather(&rows, |row| row)).is_err());
        let zero = (Vec3x::ZERO, Float::ZERO);
        let scatter = || longer.scatter(&mut rows.clone(), |row| row, zero);
        assert!(catch_unwind(scatter).is_err());
    }
}

//! Random choice of the cell of a grid, by the inversion of tables, which keeps the stratification
//! of Sobol' points (Pharr et al., *Physically Based Rendering*, 4th ed., section A.5).

use rayon::prelude::*;

use crate::math::{Mask, Real, Word, min, whole};
use crate::shading::light::shares::shares;

/// Number of random numbers, which the rows, and the cells of each row, divide among them.
const ALL: u32 = 1 << 23;
/// Largest position in a cell.
const LAST: f32 = 1.0 - 1.0 / (1 << 24) as f32;

/// A distribution over the cells of a grid that is constant in each cell.
#[derive(Debug)]
pub(super) struct CellTable {
    /// One list, with an entry for each row.
    rows: Lists,
    /// For each row, a list with an entry for each cell. Its ends are 0 if the row is never chosen.
    cells: Lists,
}

/// Lists of the same length. Each divides the numbers below [`ALL`] among its entries.
#[derive(Debug)]
struct Lists {
    len: u32,
    /// For each entry, the numbers that choose it or those before it.
    ends: Vec<u32>,
    /// Entries 31, 63 and so on of each list, with which a search begins, because they are close
    /// together in memory.
    coarse: Vec<u32>,
}

/// Bits of the index that the coarse entries leave open.
const FINE: u32 = 5;

/// A chosen cell, and a position in it.
pub(super) struct Cell<R: Real> {
    pub(super) row: R::Word,
    pub(super) column: R::Word,
    /// Position along the row and across it, in [0, 1).
    pub(super) position: (R, R),
}

impl CellTable {
    /// Creates the table of a grid. `weights` returns the weights of the cells of a row, from left to
    /// right. Weights above 0 are never rounded to a probability of 0. Returns `None` if all are 0.
    pub(super) fn new(
        width: u32,
        height: u32,
        weights: impl Fn(u32) -> Vec<f64> + Sync,
    ) -> Option<Self> {
        let row = |index| {
            let weights = weights(index);
            let sum: f64 = weights.iter().sum();
            (sum, if sum > 0.0 { ends(&weights) } else { vec![0; width as usize] })
        };
        let rows: Vec<(f64, Vec<u32>)> = (0..height).into_par_iter().map(row).collect();
        let sums: Vec<f64> = rows.iter().map(|(sum, _)| *sum).collect();
        if !sums.iter().any(|&sum| sum > 0.0) {
            return None;
        }
        let cells = rows.into_iter().flat_map(|(_, ends)| ends).collect();
        Some(Self { rows: Lists::new(height, ends(&sums)), cells: Lists::new(width, cells) })
    }

    /// Chooses a cell by two uniform numbers in [0, 1).
    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, (u, v): (R, R)) -> Cell<R> {
        let (row, y) = self.rows.find(R::Word::splat(0), v);
        let (column, x) = self.cells.find(row, u);
        Cell { row, column, position: (x, y) }
    }

    /// The probability of a cell.
    #[inline(always)]
    pub(super) fn probability<R: Real>(&self, row: R::Word, column: R::Word) -> R {
        let (_, of_row) = self.rows.range::<R>(R::Word::splat(0), row);
        let (_, of_cell) = self.cells.range::<R>(row, column);
        R::from_word(of_row) * (1.0 / ALL as f32) * (R::from_word(of_cell) * (1.0 / ALL as f32))
    }
}

impl Lists {
    /// Creates lists of `len` entries from all their ends.
    fn new(len: u32, ends: Vec<u32>) -> Self {
        let coarse = |list: &[u32]| list.chunks_exact(1 << FINE).map(|ends| ends[31]).collect();
        let coarse = ends.chunks(len as usize).flat_map::<Vec<u32>, _>(coarse).collect();
        Self { len, ends, coarse }
    }

    /// Finds the number `u` in the lists `list`. Returns the entry, and the position of `u` in the
    /// range of numbers that choose it.
    #[inline(always)]
    fn find<R: Real>(&self, list: R::Word, u: R) -> (R::Word, R) {
        let number = u * ALL as f32;
        let (value, one) = (whole(number), R::Word::splat(1));
        let pick = |table: &[u32], first: u32, index: R::Word| {
            let first = list.wrapping_mul(R::Word::splat(first));
            R::pick(table, R::index(first.wrapping_add(index), table.len()))
        };
        // The number of ends that are at most `value`, bit by bit from the highest one. The last end
        // is above all values.
        let mut found = R::Word::splat(0);
        for bit in (0..32 - (self.len - 1).leading_zeros()).rev() {
            let more = found.wrapping_add(R::Word::splat(1 << bit));
            let inside = more.le(R::Word::splat(self.len - 1));
            let last = inside.select(more, one).wrapping_sub(one);
            let end = match bit < FINE {
                true => pick(&self.ends, self.len, last),
                false => pick(&self.coarse, self.len >> FINE, last >> FINE),
            };
            found = (inside & end.le(value)).select(more, found);
        }
        let (begin, share) = self.range::<R>(list, found);
        // Random numbers are multiples of 1/2 here, so that 1/4 more puts their mean in the middle.
        let within = (number + 0.25 - R::from_word(begin)) / R::from_word(share);
        (found, min(within, R::splat(LAST)))
    }

    /// The first number of the entries `index` of the lists `list`, and how many numbers choose them.
    #[inline(always)]
    fn range<R: Real>(&self, list: R::Word, index: R::Word) -> (R::Word, R::Word) {
        let zero = R::Word::splat(0);
        let at = |index: R::Word| R::pick(&self.ends, R::index(index, self.ends.len()));
        let place = list.wrapping_mul(R::Word::splat(self.len)).wrapping_add(index);
        let is_first = index.eq(zero);
        let before = is_first.select(place, place.wrapping_sub(R::Word::splat(1)));
        let begin = is_first.select(zero, at(before));
        (begin, at(place).wrapping_sub(begin))
    }
}

/// The sums of the shares of `weights` up to each of them.
fn ends(weights: &[f64]) -> Vec<u32> {
    let sum = |sum: &mut u32, share: u64| {
        *sum += share as u32;
        Some(*sum)
    };
    shares(weights, ALL.into()).into_iter().scan(0, sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use crate::simd::{Float, Int, LANES};

    /// Beside a search from the first entry to the last.
    #[test]
    fn searches_find_the_first_end_above_a_number() {
        let mut random = Stream::new(4);
        for len in [1, 2, 31, 32, 33, 63, 64, 65, 100, 1000] {
            let mut list = |_| {
                let weights: Vec<f64> = (0..len)
                    .map(|_| f64::from(random.uniform()) * f64::from(random.bits() as u32 % 3))
                    .collect();
                if weights.iter().sum::<f64>() > 0.0 { ends(&weights) } else { vec![0; len] }
            };
            let all: Vec<Vec<u32>> = (0..3).map(&mut list).collect();
            let lists = Lists::new(len as u32, all.concat());
            for (number, list) in (0..).zip(&all).filter(|(_, list)| list[len - 1] > 0) {
                for _ in 0..300 {
                    let u = random.uniform();
                    let want = list.iter().position(|&end| end > (u * ALL as f32) as u32).unwrap();
                    assert_eq!(lists.find::<f32>(number, u).0, want as u32, "{u} of {len}");
                    let lanes = lists.find(Int::splat(number), Float::splat(u)).0;
                    assert_eq!(lanes.to_array(), [want as u32; LANES], "{u} of {len}");
                }
            }
        }
    }

    #[test]
    fn cells_are_chosen_with_their_probability() {
        let weights = [[0.0, 1.0, 3.0], [0.0, 0.0, 0.0], [0.0, 1e-12, 0.0], [5.0, 0.0, 7.0]];
        let table = CellTable::new(3, 4, |row| weights[row as usize].to_vec()).unwrap();
        let mut random = Stream::new(1);
        let mut counts = [[0u32; 3]; 4];
        const SAMPLES: u32 = 1_000_000;
        for _ in 0..SAMPLES {
            let (u, v) = (random.uniform(), random.uniform());
            let Cell { row, column, position: (x, y) } = table.choose::<f32>((u, v));
            counts[row as usize][column as usize] += 1;
            assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y), "{x} {y}");
        }
        for row in 0..4 {
            for column in 0..3 {
                let p: f32 = table.probability::<f32>(row, column);
                let weight = weights[row as usize][column as usize];
                assert_eq!(p > 0.0, weight > 0.0, "{row} {column}");
                assert!((f64::from(p) - weight / 16.0).abs() < 1e-6);
                let (n, p) = (f64::from(SAMPLES), f64::from(p));
                let count = f64::from(counts[row as usize][column as usize]);
                assert!((count - n * p).abs() < 5.0 * (n * p).sqrt() + 2.0, "{row} {column}");
            }
        }
        assert!(CellTable::new(2, 2, |_| vec![0.0; 2]).is_none());
        let single = CellTable::new(1, 1, |_| vec![2.0]).unwrap();
        assert_eq!(single.probability::<f32>(0, 0), 1.0);
        let (x, y) = single.choose::<f32>((0.25, 0.75)).position;
        assert!((x - 0.25).abs() < 1e-6 && (y - 0.75).abs() < 1e-6, "{x} {y}");
    }
}

//! Weighted random choice in constant time, with integers only (the alias method, Walker 1974; the
//! table is built as in Vose 1991).

use super::shares::shares;
use crate::math::{Mask, Real, Row, Word};

/// A table that maps 32 random bits to an entry. Each entry is chosen by exactly
/// [`AliasTable::share`] of the 2^32 numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AliasTable {
    shares: Vec<u32>,
    /// Cells of equal size, which divide the 2^32 numbers. A row holds how many numbers of
    /// its cell choose the first entry, the index of that entry, and the index of the other entry.
    cells: Vec<Row>,
    /// Number of low bits that hold a number's position within its cell.
    rest: u32,
}

impl AliasTable {
    /// Builds the table for at most 2^31 weights, which must be finite, non-negative and not all 0.
    ///
    /// Every entry whose weight is not 0 receives a share of at least 1.
    ///
    /// # Panics
    /// If `weights` is empty.
    pub(crate) fn new(weights: &[f64]) -> Self {
        assert!(!weights.is_empty(), "an alias table needs at least one weight");
        // At least two cells, so that a position within a cell needs fewer than 32 bits.
        let count = weights.len().next_power_of_two().max(2);
        let rest = 32 - count.ilog2();
        let shares = shares(weights, 1 << 32);
        let size = 1u64 << rest;
        let mut left: Vec<u64> =
            shares.iter().copied().chain(std::iter::repeat(0)).take(count).collect();
        let mut cells: Vec<Row> =
            (0..count as u32).map(|entry| [size as u32, entry, entry, 0]).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) =
            (0..count).partition(|&cell| left[cell] < size);
        // In the cell of a small entry, a large entry takes the numbers that the small one does not
        // need.
        while let Some(cell) = small.pop() {
            let &from = large.last().expect("a small entry implies a large one");
            cells[cell] = [left[cell] as u32, cell as u32, from as u32, 0];
            left[from] -= size - left[cell];
            if left[from] < size {
                large.pop();
                small.push(from);
            }
        }
        let shares = shares.into_iter().map(|share| u32::try_from(share).unwrap_or(u32::MAX));
        Self { shares: shares.collect(), cells, rest }
    }

    /// Returns the entry that the number `bits` chooses.
    #[inline(always)]
    pub(crate) fn choose<R: Real>(&self, bits: R::Word) -> R::Word {
        let cell = R::index(bits >> self.rest, self.cells.len());
        let (words, _) = R::gather(&self.cells, cell, |cell| cell);
        let place = bits & R::Word::splat((1 << self.rest) - 1);
        let is_first = place.wrapping_add(R::Word::splat(1)).le(words[0].to_bits());
        is_first.select(words[1].to_bits(), words[2].to_bits())
    }

    /// Returns how many of the 2^32 numbers choose `entry`. Returns 2^32 − 1 if all do.
    pub(crate) fn share(&self, entry: u32) -> u32 {
        self.shares[entry as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    /// Counts the numbers that choose each entry, over all cells.
    fn counted(table: &AliasTable) -> Vec<u64> {
        let mut counts = vec![0; table.shares.len()];
        for &[first, entry, alias, _] in &table.cells {
            counts[entry as usize % table.shares.len()] += u64::from(first);
            counts[alias as usize] += (1 << table.rest) - u64::from(first);
            assert!((entry as usize) < table.shares.len() || first == 0);
        }
        counts
    }

    #[test]
    fn cells_add_up_to_the_shares() {
        let mut random = Stream::new(4);
        for count in [1, 2, 3, 7, 64, 1000, 70_000] {
            let weights: Vec<f64> = (0..count)
                .map(|_| {
                    if random.bits().is_multiple_of(5) {
                        0.0
                    } else {
                        1e-12 + f64::from(random.uniform())
                    }
                })
                .map(|w| w * w * w)
                .chain([1e-3])
                .collect();
            let table = AliasTable::new(&weights);
            let total: f64 = weights.iter().sum();
            for (entry, counted) in counted(&table).into_iter().enumerate() {
                let share = u64::from(table.share(entry as u32));
                assert!(share == counted && (share > 0) == (weights[entry] > 0.0), "{entry}");
                let want = weights[entry] / total * 4_294_967_296.0;
                // The sums are rounded, and each entry without weight shifts the others by one.
                assert!((share as f64 - want).abs() <= 2.0 + count as f64, "{share} {want}");
            }
        }
        let one = AliasTable::new(&[3.0]);
        assert_eq!((one.share(0), counted(&one)), (u32::MAX, vec![1 << 32]));
        assert_eq!([0, 77, u32::MAX].map(|bits| one.choose::<f32>(bits)), [0; 3]);
    }

    #[test]
    fn choices_follow_the_weights() {
        let weights: Vec<f64> = (1..=37).map(f64::from).collect();
        let table = AliasTable::new(&weights);
        let mut random = Stream::new(9);
        let (mut counts, n) = (vec![0u32; 37], 1_000_000);
        for _ in 0..n {
            counts[table.choose::<f32>(random.bits() as u32) as usize] += 1;
        }
        for (count, weight) in counts.into_iter().zip(weights) {
            let p = weight / 703.0;
            let deviation = (f64::from(n) * p * (1.0 - p)).sqrt();
            assert!((f64::from(count) - f64::from(n) * p).abs() < 5.0 * deviation);
        }
    }
}

//! Lists in structure-of-arrays form, filled at the end and read by vectors.

use std::ops::Range;

use crate::simd::{Int, LANES, set_lanes};

/// Rows of `N` words, column by column.
#[derive(Debug)]
pub(super) struct Columns<const N: usize> {
    len: usize,
    /// From one column to the next.
    stride: usize,
    words: Vec<u32>,
}

impl<const N: usize> Columns<N> {
    /// No rows, and room for `capacity`.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        // A vector may be stored at any place where a row is. An odd number of cache lines: columns
        // a power of two apart would share few sets of a cache.
        let lines = (capacity + LANES).div_ceil(16) | 1;
        Self { len: 0, stride: lines * 16, words: vec![0; N * lines * 16] }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds the rows of the lanes whose bits are set.
    #[inline(always)]
    pub(super) fn append(&mut self, rows: &[Int; N], bits: u32) {
        self.set(self.len, rows, bits);
        self.len += bits.count_ones() as usize;
    }

    /// Sets row `first` and the following to those of the lanes whose bits are set; what comes behind
    /// them, up to a whole vector, is overwritten.
    #[inline(always)]
    pub(super) fn set(&mut self, first: usize, rows: &[Int; N], bits: u32) {
        let set_lanes = set_lanes(bits);
        let mut words = &mut self.words[..];
        for row in rows {
            // Split, not indexed: fewer checks of bounds.
            let (column, rest) = words.split_at_mut(self.stride);
            row.shuffled(set_lanes).store(&mut column[first..]);
            words = rest;
        }
    }

    /// One number of all rows.
    pub(super) fn column(&self, column: usize) -> &[u32] {
        &self.words[column * self.stride..][..self.len]
    }

    /// Rows `first..`, one a lane; what is beyond the last is of no use.
    #[inline(always)]
    pub(super) fn rows(&self, first: usize) -> [Int; N] {
        let mut rows = [Int::ZERO; N];
        for (column, row) in rows.iter_mut().enumerate() {
            *row = Int::load(&self.words[column * self.stride + first..]);
        }
        rows
    }

    /// Repeats the last of `rows`, if there is one, up to a multiple of [`LANES`].
    pub(super) fn pad(&mut self, rows: Range<usize>) {
        if rows.is_empty() {
            return;
        }
        let full = rows.end.next_multiple_of(LANES);
        for column in self.words.chunks_exact_mut(self.stride) {
            let value = column[rows.end - 1];
            column[rows.end..full].fill(value);
        }
    }
}

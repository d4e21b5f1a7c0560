//! Lists in structure-of-arrays form, to which lanes are appended and from which vectors are read.

use std::ops::Range;

use crate::simd::{Int, LANES, set_lanes};

/// A list of rows of `N` words, stored column by column.
#[derive(Debug)]
pub(super) struct Columns<const N: usize> {
    len: usize,
    /// Number of words from one column to the next.
    stride: usize,
    words: Vec<u32>,
}

impl<const N: usize> Columns<N> {
    /// Creates an empty list with room for `capacity` rows.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        // A whole vector may be stored at any row. The number of cache lines is odd: if the
        // distance of columns were a power of two, they would share few sets of a cache.
        let lines = (capacity + LANES).div_ceil(16) | 1;
        Self { len: 0, stride: lines * 16, words: vec![0; N * lines * 16] }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends the rows of the lanes whose bits are set.
    #[inline(always)]
    pub(super) fn append(&mut self, rows: &[Int; N], bits: u32) {
        self.set(self.len, rows, bits);
        self.len += bits.count_ones() as usize;
    }

    /// Overwrites the rows from `first` on with the rows of the lanes whose bits are set. The rest
    /// of a whole vector is overwritten, too, with arbitrary values.
    #[inline(always)]
    pub(super) fn set(&mut self, first: usize, rows: &[Int; N], bits: u32) {
        let set_lanes = set_lanes(bits);
        let mut words = &mut self.words[..];
        for row in rows {
            // Splitting needs fewer bounds checks than indexing.
            let (column, rest) = words.split_at_mut(self.stride);
            row.shuffled(set_lanes).store(&mut column[first..]);
            words = rest;
        }
    }

    /// Replaces the contents with the rows of `from` at the indices `order`. There must be room for
    /// them.
    pub(super) fn reorder(&mut self, from: &Self, order: &[u32]) {
        let stride = self.stride;
        for (column, to) in self.words.chunks_exact_mut(stride).enumerate() {
            let from = from.column(column);
            for (to, &index) in to[..order.len()].iter_mut().zip(order) {
                *to = from[index as usize];
            }
        }
        self.len = order.len();
    }

    /// The words of all rows in column number `column`.
    pub(super) fn column(&self, column: usize) -> &[u32] {
        &self.words[column * self.stride..][..self.len]
    }

    /// As [`column`](Self::column), to change words.
    pub(super) fn column_mut(&mut self, column: usize) -> &mut [u32] {
        &mut self.words[column * self.stride..][..self.len]
    }

    /// The rows from `first` on, one per lane. Lanes beyond the last row have arbitrary values.
    #[inline(always)]
    pub(super) fn rows(&self, first: usize) -> [Int; N] {
        let mut rows = [Int::ZERO; N];
        for (column, row) in rows.iter_mut().enumerate() {
            *row = Int::load(&self.words[column * self.stride + first..]);
        }
        rows
    }

    /// Pads `rows` to a multiple of [`LANES`] by repeating the last row. An empty range is not
    /// padded.
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

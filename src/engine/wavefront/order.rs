//! Order: builds the rays of the next segment, optionally sorted so that neighbours start near each
//! other and have similar directions.

use super::cells::Cells;
use super::columns::Columns;
use super::paths::Paths;
use super::rays::Rays;

/// The paths that continue. Columns: path, cell.
pub(super) type Next = Columns<2>;

/// Builds the rays of the paths `next`, sorted by cell if `by_cell` is set, else in the given
/// order.
#[inline(never)]
pub(super) fn order(next: &Next, by_cell: bool, paths: &Paths, rays: &mut Rays) {
    if by_cell {
        rays.sort.list(next.column(1), next.column(0).iter().copied(), &mut rays.paths);
    } else {
        rays.paths.clear();
        rays.paths.extend_from_slice(next.column(0));
    }
    rays.fill(paths);
}

/// A counting sort by cell.
#[derive(Debug, Default)]
pub(super) struct CellSort {
    /// For each cell, the index of its next value.
    starts: Vec<u32>,
}

impl CellSort {
    /// Replaces the contents of `list` with `values`, sorted by `cells`. Values of the same cell stay
    /// in order.
    #[inline(always)]
    pub(super) fn list(
        &mut self,
        cells: &[u32],
        values: impl Iterator<Item = u32>,
        list: &mut Vec<u32>,
    ) {
        let bits = Cells::bits_for(cells.len());
        let leave_out = Cells::BITS - bits;
        self.starts.clear();
        self.starts.resize(1 << bits, 0);
        list.resize(cells.len(), 0);
        // These are slices because the pointer of a `Vec` would be loaded again after each write.
        let (starts, list) = (&mut self.starts[..], &mut list[..]);
        for &cell in cells {
            starts[(cell >> leave_out) as usize] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += std::mem::replace(start, sum);
        }
        for (value, &cell) in values.zip(cells) {
            let next = &mut starts[(cell >> leave_out) as usize];
            list[*next as usize] = value;
            *next += 1;
        }
    }
}

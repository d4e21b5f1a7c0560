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
        sort_by_cell(next, rays);
    } else {
        rays.paths.clear();
        rays.paths.extend_from_slice(next.column(0));
    }
    rays.fill(paths);
}

/// Sorts the paths by cell with a counting sort.
fn sort_by_cell(next: &Next, Rays { paths, starts, .. }: &mut Rays) {
    let bits = Cells::bits_for(next.len());
    let leave_out = Cells::BITS - bits;
    starts.clear();
    starts.resize(1 << bits, 0);
    paths.resize(next.len(), 0);
    // These are slices because the pointer of a `Vec` would be loaded again after each write.
    let (starts, paths) = (&mut starts[..], &mut paths[..]);
    for &cell in next.column(1) {
        starts[(cell >> leave_out) as usize] += 1;
    }
    let mut sum = 0;
    for start in starts.iter_mut() {
        sum += std::mem::replace(start, sum);
    }
    for (&path, &cell) in next.column(0).iter().zip(next.column(1)) {
        let next = &mut starts[(cell >> leave_out) as usize];
        paths[*next as usize] = path;
        *next += 1;
    }
}

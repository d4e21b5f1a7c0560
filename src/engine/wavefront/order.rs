//! Order: builds the rays of the next segment, optionally sorted so that neighbours start near each
//! other and have similar directions.

use super::{Columns, Paths, WaveRays};

/// The paths that continue. Columns: path, cell.
pub(super) type Next = Columns<2>;

/// Builds the rays of the paths `next`, sorted by their cells if `by_cell` is set, else in the given
/// order.
#[inline(never)]
pub(super) fn order(next: &Next, by_cell: bool, paths: &Paths, rays: &mut WaveRays) {
    if by_cell {
        rays.sort.list(next.column(1), next.column(0).iter().copied(), &mut rays.paths);
    } else {
        rays.paths.clear();
        rays.paths.extend_from_slice(next.column(0));
    }
    rays.fill(paths);
}

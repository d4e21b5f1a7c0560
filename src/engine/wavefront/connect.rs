//! Connect: traces shadow rays and adds the light of those that are not occluded.

use super::extend::trace;
use super::pass::Passing;
use super::{CellSort, Cells, Columns, Paths};
use crate::accel::{Accelerator, HitBatch, Kernel, RayBatch, RayVector};
use crate::engine::StageWork;
use crate::geometry::Ray;
use crate::math::{Real, Word};
use crate::simd::{Float, Indices, Int, LANES, Vec3x};

/// Shadow rays, and the light that each one adds if it is not occluded.
#[derive(Debug)]
pub(super) struct Shadows {
    capacity: usize,
    list: List,
    /// The same list, sorted. It has no room before it is needed.
    sorted: Option<List>,
    /// The cell of each ray, and the order in which rays are sorted.
    cells: Vec<u32>,
    order: Vec<u32>,
    sort: CellSort,
}

#[derive(Debug)]
struct List {
    rays: RayBatch,
    /// Radiance at the camera (3 columns), and path.
    light: Columns<4>,
}

impl List {
    fn with_capacity(capacity: usize) -> Self {
        Self { rays: RayBatch::with_capacity(capacity), light: Columns::with_capacity(capacity) }
    }
}

impl Shadows {
    /// Creates an empty list with room for `capacity` shadow rays.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            capacity,
            list: List::with_capacity(capacity),
            sorted: None,
            cells: Vec::new(),
            order: Vec::new(),
            sort: CellSort::default(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.list.rays.len()
    }

    pub(super) fn clear(&mut self) {
        self.list.rays.clear();
        self.list.light.clear();
    }

    /// Sorts the rays by cell. Rays to many lights, or to an environment, leave neighbouring vertices
    /// in all directions.
    #[inline(never)]
    pub(super) fn sort(&mut self, cells: &Cells) {
        let Self { list, order, sort, .. } = self;
        let sorted = self.sorted.get_or_insert_with(|| List::with_capacity(self.capacity));
        self.cells.clear();
        self.cells.reserve_exact(self.capacity + LANES);
        order.reserve_exact(self.capacity.saturating_sub(order.len()));
        for first in (0..list.rays.len()).step_by(LANES) {
            let Ray { origin, direction, .. } = list.rays.vector(first).ray();
            self.cells.extend_from_slice(&cells.of(origin, direction).to_array());
        }
        self.cells.truncate(list.rays.len());
        sort.list(&self.cells, 0.., order);
        sorted.rays.reorder(&mut list.rays, order);
        sorted.light.reorder(&list.light, order);
        std::mem::swap(list, sorted);
    }

    /// Appends the shadow rays of the lanes whose bits are set.
    #[inline(always)]
    pub(super) fn append(&mut self, rays: &RayVector, radiance: Vec3x, paths: &Indices, bits: u32) {
        self.list.rays.append(rays, bits);
        let [r, g, b] = radiance.0.map(Float::to_bits);
        self.list.light.append(&[r, g, b, Int::new(*paths.lanes())], bits);
    }
}

/// Traces the shadow rays and adds the light of those that are not occluded. There must be at least
/// one shadow ray. `passing` lets them through panes, if the scene has any. Returns the work, with that of the
/// kernel if `count` is set.
#[inline(never)]
pub(super) fn connect(
    (accelerator, kernel): (&Accelerator, Kernel),
    shadows: &mut Shadows,
    hits: &mut HitBatch,
    paths: &mut Paths,
    passing: Option<Passing<'_>>,
    count: bool,
) -> StageWork {
    let List { rays, light } = &mut shadows.list;
    let counters = trace(accelerator, kernel, true, rays, hits, count);
    let mut work = StageWork { counters, ..StageWork::of(rays.len()) };
    if let Some(passing) = passing {
        work.add(&passing.pass_shadows(rays, light, hits));
    }
    // Pad to whole vectors by repeating the last ray.
    light.pad(0..light.len());
    let last = hits.primitive[rays.len() - 1];
    hits.primitive[rays.len()..].fill(last);
    for first in (0..rays.len()).step_by(LANES) {
        let free = Int::load(&hits.primitive[first..]).eq(Int::splat(HitBatch::MISS));
        let [r, g, b, path] = light.rows(first);
        let light = Vec3x([r, g, b].map(Float::from_bits));
        paths.add_radiance(&paths.indices(path), light, free.bits());
    }
    work
}

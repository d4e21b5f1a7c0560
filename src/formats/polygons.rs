//! Triangles of polygons that a fan does not fill, by ear clipping.

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A polygon with more than three corners, as a fan of triangles about its first corner.
#[derive(Clone, Copy)]
pub(crate) struct Polygon {
    /// The index of its first triangle.
    pub(crate) first: u32,
    /// Number of its corners.
    pub(crate) corners: u32,
}

/// Largest share of a polygon's area that its fan may fold over, which is the rounding of corners on edges.
const FOLDED: f64 = 1e-5;
/// Largest number of corners of a polygon that is clipped, and largest sum of their squares for all polygons
/// of a mesh, which bounds the time. Other polygons keep their fan.
const MOST_CORNERS: u64 = 1 << 12;
const MOST_WORK: u64 = 1 << 30;

impl Polygon {
    /// The vertices at its corners. Its fan must not have been changed.
    fn corners(self, triangles: &[[u32; 3]]) -> impl Iterator<Item = u32> + '_ {
        let first = self.first as usize;
        let fan = &triangles[first..first + self.corners as usize - 2];
        fan[0][..2].iter().copied().chain(fan.iter().map(|triangle| triangle[2]))
    }

    /// Whether the fan folds over: some triangle of it faces the other way than the polygon.
    fn folds(self, triangles: &[[u32; 3]], positions: &[Vec3]) -> bool {
        let first = self.first as usize;
        let fan = &triangles[first..first + self.corners as usize - 2];
        let cross = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| positions[corner as usize].as_dvec3());
            (b - a).cross(c - a)
        };
        let whole: DVec3 = fan.iter().map(cross).sum();
        let least = -FOLDED * whole.dot(whole);
        fan.iter().any(|triangle| cross(triangle).dot(whole) < least)
    }

    /// As many triangles as the fan has, which fill the polygon as seen along its normal. Those that are not
    /// needed have no area. `None` if the polygon has no normal.
    fn clip(self, triangles: &[[u32; 3]], positions: &[Vec3]) -> Option<Vec<[u32; 3]>> {
        let corners: Vec<u32> = self.corners(triangles).collect();
        let at = |corner: &u32| positions[*corner as usize].as_dvec3().to_array();
        let points: Vec<[f64; 3]> = corners.iter().map(at).collect();
        let (mut flat, mut found) = (Vec::new(), Vec::<u32>::new());
        if !project3d_to_2d(&points, points.len(), &mut flat) {
            return None;
        }
        Earcut::new().earcut(flat.iter().copied(), &[], &mut found);
        let (clipped, _) = found.as_chunks::<3>();
        let area = |[a, b, c]: [usize; 3]| {
            let [[ax, ay], [bx, by], [cx, cy]] = [flat[a], flat[b], flat[c]];
            (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        };
        let own: f64 = (2..flat.len()).map(|i| area([0, i - 1, i])).sum();
        let theirs: f64 = clipped.iter().map(|corners| area(corners.map(|i| i as usize))).sum();
        let corner = |i: u32| corners[i as usize];
        let placed = clipped.iter().map(|&[a, b, c]| match own * theirs < 0.0 {
            true => [corner(a), corner(c), corner(b)],
            false => [corner(a), corner(b), corner(c)],
        });
        let spare = std::iter::repeat([corners[0]; 3]);
        Some(placed.chain(spare).take(corners.len() - 2).collect())
    }
}

/// Replaces the fans of polygons that fold over, such as most of concave ones. Returns what is ignored, if some are left.
pub(crate) fn clip_concave(
    positions: &[Vec3],
    triangles: &mut [[u32; 3]],
    polygons: &[Polygon],
) -> Option<&'static str> {
    let folds = |polygon: &&Polygon| polygon.folds(triangles, positions);
    let folded: Vec<Polygon> = polygons.par_iter().filter(folds).copied().collect();
    let mut work = 0;
    let within = |polygon: &Polygon| {
        let corners = u64::from(polygon.corners);
        work += if corners <= MOST_CORNERS { corners * corners } else { 0 };
        corners <= MOST_CORNERS && work <= MOST_WORK
    };
    let count = folded.len();
    let folded: Vec<Polygon> = folded.into_iter().filter(within).collect();
    let left = folded.len() < count;
    let clip = |polygon: &Polygon| Some((polygon.first, polygon.clip(triangles, positions)?));
    let clipped: Vec<_> = folded.par_iter().filter_map(clip).collect();
    for (first, new) in clipped {
        triangles[first as usize..][..new.len()].copy_from_slice(&new);
    }
    left.then_some("the outlines of concave faces with too many corners")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::cross;

    fn fan(count: u32) -> Vec<[u32; 3]> {
        (2..count).map(|i| [0, i - 1, i]).collect()
    }

    /// The triangles of a polygon, and their area along z, and without regard to the side.
    fn clipped(corners: &[[f32; 3]]) -> (Vec<[u32; 3]>, [f32; 2]) {
        let positions: Vec<Vec3> = corners.iter().map(|&c| c.into()).collect();
        let count = positions.len() as u32;
        let mut triangles = fan(count);
        clip_concave(&positions, &mut triangles, &[Polygon { first: 0, corners: count }]);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            cross(b - a, c - a).z / 2.0
        };
        let areas =
            [triangles.iter().map(area).sum(), triangles.iter().map(|t| area(t).abs()).sum()];
        (triangles, areas)
    }

    #[test]
    fn arrows_are_filled_from_every_corner_and_side() {
        let arrow = [[0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.0, 3.0, 0.0], [-2.0, -1.0, 0.0]];
        for turn in 0..4 {
            let mut corners = arrow;
            corners.rotate_left(turn);
            assert_eq!(clipped(&corners).1, [6.0, 6.0], "{turn}");
            corners.reverse();
            assert_eq!(clipped(&corners).1, [-6.0, 6.0], "{turn}");
        }
        // Not planar: seen along its normal, it is the same arrow.
        let bent = [[2.0, -1.0, 0.25], [0.0, 3.0, 0.0], [-2.0, -1.0, 0.25], [0.0, 0.0, 0.0]];
        assert_eq!(clipped(&bent).1, [6.0, 6.0]);
    }

    #[test]
    fn polygons_without_area_and_hostile_ones_end() {
        assert_eq!(clipped(&[[1.0, 2.0, 3.0]; 5]).0, fan(5));
        let line = [[0.0; 3], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert_eq!(clipped(&line).1, [0.0, 0.0]);
        // A star that crosses itself at random, with as many corners as may be clipped.
        let mut random = crate::math::random::Stream::new(3);
        let mut number = || (random.bits() % 1000) as f32;
        let star: Vec<_> = (0..MOST_CORNERS).map(|_| [number(), number(), number()]).collect();
        let (triangles, _) = clipped(&star);
        assert_eq!(triangles.len(), star.len() - 2);
    }
}

//! Pairs of triangles that form a parallelogram.

use glam::{DVec3, Vec3};

use super::rounded;

/// The corner q and the edges u and v of the parallelogram that two triangles form, if they do. Their front
/// is the side of u × v.
pub(crate) fn parallelogram(vertices: &[[f32; 3]], indices: &[[u32; 3]]) -> Option<[[f32; 3]; 3]> {
    let &[first, second] = indices else { return None };
    let at = |i: u32| vertices.get(i as usize).map(|&vertex| Vec3::from(vertex).as_dvec3());
    let length = |v: DVec3| v.dot(v).sqrt();
    (0..3).find_map(|corner| {
        let [q, n, p] = [0, 1, 2].map(|turn| first[(corner + turn) % 3]);
        // The second triangle has the edge from n to p in the other direction.
        let edge = (0..3).find(|&i| second[i] == p && second[(i + 1) % 3] == n)?;
        let (q, n, p, far) = (at(q)?, at(n)?, at(p)?, at(second[(edge + 2) % 3])?);
        let (u, v) = (n - q, p - q);
        let size = length(u) + length(v);
        let closed = length(n + v - far) <= 1e-5 * size;
        let has_area = length(u.cross(v)) > 1e-6 * size * size;
        (closed && has_area).then(|| [q, u, v].map(rounded))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_triangles() {
        let vertices =
            [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 1.0, 1.0], [0.0, 1.0, 1.0], [0.0, 3.0, 1.0]];
        let of = |indices: &[[u32; 3]]| parallelogram(&vertices, indices);
        for (first, second) in
            [([0, 1, 2], [0, 2, 3]), ([2, 0, 1], [3, 0, 2]), ([1, 2, 0], [2, 3, 0])]
        {
            let [q, u, v] = of(&[first, second]).unwrap();
            assert_eq!((q, u, v), ([2.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-2.0, 0.0, 0.0]));
        }
        // The other front, three triangles, another shape, other fronts, no common edge, no area.
        assert_eq!(of(&[[0, 2, 1], [0, 3, 2]]).unwrap()[1], [-2.0, 0.0, 0.0]);
        assert_eq!(of(&[[0, 1, 2], [0, 2, 3], [0, 3, 4]]), None);
        assert_eq!(of(&[[0, 1, 2], [0, 2, 4]]), None);
        assert_eq!(of(&[[0, 1, 2], [0, 3, 2]]), None);
        assert_eq!(of(&[[0, 1, 2], [3, 4, 0]]), None);
        assert_eq!(of(&[[0, 3, 4], [4, 3, 0]]), None);
        assert_eq!(of(&[[0, 1, 9], [0, 9, 3]]), None);
    }
}

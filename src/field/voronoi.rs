//! The cell of a point among others: what is nearer to it than to any other, cut out of a cube plane by plane.
//!
//! A corner that a cut makes is computed from the two ends of an edge in the same order for both faces beside it, so that what
//! meets is equal to the bit, and no tolerance decides what belongs together.

use glam::DVec3;

/// A cell: convex.
pub struct Cell<K> {
    point: DVec3,
    faces: Vec<Face<K>>,
}

struct Face<K> {
    /// The point on its other side; none of the cube that all is cut out of.
    beyond: Option<K>,
    /// Counter-clockwise seen from outside.
    corners: Vec<DVec3>,
}

impl<K: Copy + Ord> Cell<K> {
    /// All within a cube around the point, up to so far along each axis.
    pub fn within(point: DVec3, far: f64) -> Self {
        let side = |axis: usize, end: f64| {
            let [out, a, b] = [0, 1, 2].map(|i| DVec3::AXES[(axis + i) % 3] * far);
            let (out, b) = (out * end, b * end);
            Face { beyond: None, corners: [a + b, b - a, -a - b, a - b].map(|way| point + out + way).into() }
        };
        Self { point, faces: (0..6).map(|i| side(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 })).collect() }
    }

    /// No corner is farther from the point. Another point twice as far away cuts nothing off.
    pub fn reach(&self) -> f64 {
        let corners = self.faces.iter().flat_map(|face| &face.corners);
        corners.fold(0.0_f64, |most, corner| most.max(corner.distance_squared(self.point))).sqrt()
    }

    /// Cuts off what is nearer to another point.
    pub fn cut(&mut self, other: DVec3, name: K) {
        let (middle, across) = ((self.point + other) / 2.0, other - self.point);
        let beyond = |corner: DVec3| (corner - middle).dot(across);
        // Most others cut nothing off.
        if !self.faces.iter().flat_map(|face| &face.corners).any(|corner| beyond(*corner) > 0.0) {
            return;
        }
        let mut faces = Vec::with_capacity(self.faces.len() + 1);
        // From where the cut leaves a face to where it enters it: round the new face.
        let mut rim: Vec<[DVec3; 2]> = Vec::new();
        for face in &self.faces {
            let (mut corners, mut ends) = (Vec::with_capacity(face.corners.len() + 1), [None; 2]);
            for (i, &corner) in face.corners.iter().enumerate() {
                let next = face.corners[(i + 1) % face.corners.len()];
                let (here, there) = (beyond(corner), beyond(next));
                if here <= 0.0 {
                    corners.push(corner);
                }
                if (here <= 0.0) != (there <= 0.0) {
                    let leaves = here <= 0.0;
                    let (kept, lost, by, to) =
                        if leaves { (corner, next, here, there) } else { (next, corner, there, here) };
                    let end = kept + (lost - kept) * (by / (by - to));
                    corners.push(end);
                    ends[usize::from(!leaves)] = Some(end);
                }
            }
            if let [Some(leaves), Some(enters)] = ends {
                rim.push([leaves, enters]);
            }
            if corners.len() > 2 {
                faces.push(Face { beyond: face.beyond, corners });
            }
        }
        if let Some(corners) = round(rim) {
            faces.push(Face { beyond: Some(name), corners });
        }
        self.faces = faces;
    }

    /// The edges between faces, each with the points beyond both; not those on the cube.
    pub fn edges(&self) -> impl Iterator<Item = ([DVec3; 2], [K; 2])> {
        let sides = || {
            let named = self.faces.iter().filter_map(|face| Some((face.beyond?, &face.corners)));
            named.flat_map(|(name, corners)| {
                (0..corners.len()).map(move |i| (name, [corners[i], corners[(i + 1) % corners.len()]]))
            })
        };
        sides().filter(|(_, [from, to])| from != to).flat_map(move |(name, [from, to])| {
            let twins = sides().filter(move |(other, ends)| name < *other && *ends == [to, from]);
            twins.map(move |(other, _)| ([from, to], [name, other]))
        })
    }
}

/// The corners of a face from the pieces of its rim, each from its end to its start; none of what is no face.
fn round(mut rim: Vec<[DVec3; 2]>) -> Option<Vec<DVec3>> {
    rim.retain(|[end, start]| end != start);
    let [mut end, start] = rim.pop()?;
    let mut corners = vec![start];
    while end != start {
        corners.push(end);
        let next = rim.iter().position(|[_, start]| *start == end)?;
        end = rim.swap_remove(next)[0];
    }
    (corners.len() > 2).then_some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Aabb;
    use crate::field::tests::Samples;

    fn some(count: usize) -> Vec<DVec3> {
        let (mut samples, cube) = (Samples::new(8), Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)));
        (0..count).map(|_| samples.within(&cube)).collect()
    }

    fn cell_of(points: &[DVec3], own: usize) -> Cell<usize> {
        let mut cell = Cell::within(points[own], 3.0);
        points.iter().enumerate().filter(|(name, _)| *name != own).for_each(|(name, other)| cell.cut(*other, name));
        cell
    }

    /// On an edge three points are as near as any.
    #[test]
    fn three_points_are_the_nearest_to_an_edge() {
        let points = some(300);
        let mut seen = 0;
        for own in 0..points.len() {
            for ([from, to], beyond) in cell_of(&points, own).edges() {
                let at = from.lerp(to, 0.4);
                let nearest = points.iter().map(|point| point.distance(at)).fold(f64::INFINITY, f64::min);
                for name in [own, beyond[0], beyond[1]] {
                    assert!((points[name].distance(at) - nearest).abs() < 1e-9, "{own}: {at}");
                }
                seen += 1;
            }
        }
        // Most cells meet the cube that they are cut out of, and those within have some 40 edges.
        assert!(seen > 300 * 20, "{seen}");
    }

    /// What is no edge of a cell is none of its three cells: each is found three times.
    #[test]
    fn all_cells_of_an_edge_have_it() {
        let points = some(120);
        let mut edges = std::collections::BTreeMap::<[usize; 3], usize>::new();
        for own in 0..points.len() {
            for ([from, to], [a, b]) in cell_of(&points, own).edges() {
                let mut names = [own, a, b];
                names.sort_unstable();
                // Another cell ends it at the cube that it is itself cut out of.
                if from.abs().max(to.abs()).max_element() < 1.5 {
                    *edges.entry(names).or_default() += 1;
                }
            }
        }
        assert!(edges.len() > 300 && edges.values().all(|count| *count == 3), "{}", edges.len());
    }

    /// Where more than four cells meet, all to rounding.
    #[test]
    fn a_lattice_has_cubes() {
        let lattice: Vec<DVec3> =
            (0..125).map(|i| DVec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)) * 0.3).collect();
        let cell = cell_of(&lattice, 62);
        let long = cell.edges().filter(|([from, to], _)| from.distance(*to) > 1e-9);
        let middles = long.map(|([from, to], _)| {
            assert!((from.distance(to) - 0.3).abs() < 1e-9);
            ((from + to) / 0.3).round().as_i64vec3().to_array()
        });
        // Faces as thin as rounding have the same edges again.
        assert_eq!(middles.collect::<std::collections::BTreeSet<_>>().len(), 12);
    }
}

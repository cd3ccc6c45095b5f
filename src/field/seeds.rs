//! Points at random, one in each cube of a lattice, and the cells of space that are nearest to each.

use glam::{DVec3, I64Vec3};

use super::Aabb;
use super::noise::hash::{Cubes, cells_around, of_cell, shares};
use super::part::Sample;

/// Points at random, one in each cube of a lattice.
#[derive(Clone, Copy, Debug)]
pub struct Seeds {
    /// The cubes' edge.
    pub edge: f64,
    /// How far a point may be from the middle of its cube along each axis, as a share of half of the edge: 0 to 1.
    pub jitter: f64,
    /// What they start from.
    pub seed: u64,
}

/// Cubes to either side that may hold the nearest point: that of the own cube is at most √3 edges away, and what is beyond
/// the second cube at least 2.
const NEAREST_AROUND: i64 = 2;

/// Cubes to either side that may hold the neighbour across the nearest wall: the wall's foot is less than √3 from both points,
/// and so is the position from the wall.
const WALL_AROUND: i64 = 4;

/// Whole numbers of cubes are exact below.
const FARTHEST: f64 = 9e15;

impl Seeds {
    /// The points of the cubes that meet a box, at most so many; `None` of more.
    pub fn within(&self, around: &Aabb, most: usize) -> Option<Vec<DVec3>> {
        let cubes = Cubes::over(around, self.edge, most, FARTHEST)?;
        Some(cubes.iter().map(|cube| self.point(cube) * self.edge).collect())
    }

    /// Minus the distance to the nearest point.
    pub fn to_nearest(&self, position: DVec3) -> Sample {
        let Some((_, way)) = self.nearest(position) else { return (f64::NAN, DVec3::NAN) };
        let far = way.length();
        (-far * self.edge, if far > 0.0 { -way / far } else { DVec3::ZERO })
    }

    /// The depth in the cell of the nearest point: the distance to the nearest plane between it and another point.
    ///
    /// The plane's part between the two is that distance away along its normal, (d₂² − d₁²)/(2·|s₂ − s₁|), not (d₂ − d₁)/2.
    pub fn depth(&self, position: DVec3) -> Sample {
        let Some((own, way)) = self.nearest(position) else { return (f64::NAN, DVec3::NAN) };
        let at = position / self.edge;
        let (cube, square) = (at.floor().as_i64vec3(), way.length_squared());
        let from_own = square.sqrt();
        let mut best = (f64::INFINITY, DVec3::ZERO);
        let to_side = to_side(at);
        for ring in 0..=WALL_AROUND {
            // The plane to a point is at least half of how much farther that is.
            if self.least_of(ring, to_side) > from_own + 2.0 * best.0 {
                break;
            }
            cells_around(ring, |by| {
                let other = cube + by;
                let most = from_own + 2.0 * best.0;
                if other == own || self.least_square(other, at) > most * most {
                    return;
                }
                let there = at - self.point(other);
                let across = way - there;
                let length = across.length();
                if length > 0.0 {
                    let depth = (there.length_squared() - square) / (2.0 * length);
                    if depth < best.0 {
                        best = (depth, -across / length);
                    }
                }
            });
        }
        (best.0 * self.edge, best.1)
    }

    /// The cube of the nearest point and the way from that to a position, in edges; `None` where the position is none.
    fn nearest(&self, position: DVec3) -> Option<(I64Vec3, DVec3)> {
        let (at, cube) = (position / self.edge, self.cube(position)?);
        let mut nearest = (f64::INFINITY, cube, DVec3::ZERO);
        let to_side = to_side(at);
        for ring in 0..=NEAREST_AROUND {
            let least = self.least_of(ring, to_side);
            if least > 0.0 && least * least >= nearest.0 {
                break;
            }
            cells_around(ring, |by| {
                let other = cube + by;
                if self.least_square(other, at) >= nearest.0 {
                    return;
                }
                let way = at - self.point(other);
                let square = way.length_squared();
                if square < nearest.0 {
                    nearest = (square, other, way);
                }
            });
        }
        Some((nearest.1, nearest.2))
    }

    /// The cube of a position; `None` where it is none.
    pub(super) fn cube(&self, position: DVec3) -> Option<I64Vec3> {
        let at = position / self.edge;
        (at.is_finite() && at.abs().max_element() < FARTHEST).then(|| at.floor().as_i64vec3())
    }

    /// The point of a cube, in edges.
    pub(super) fn point(&self, cube: I64Vec3) -> DVec3 {
        cube.as_dvec3() + 0.5 + (shares(of_cell(cube, self.seed)) - 0.5) * self.jitter
    }

    /// No point of a ring of cubes is nearer to a position that is `to_side` away from its cube's nearest side.
    fn least_of(&self, ring: i64, to_side: f64) -> f64 {
        (ring - 1) as f64 + to_side + 0.5 * (1.0 - self.jitter)
    }

    /// The point of a cube is no nearer.
    fn least_square(&self, cube: I64Vec3, at: DVec3) -> f64 {
        let apart = (at - (cube.as_dvec3() + 0.5)).abs() - 0.5 * self.jitter;
        apart.max(DVec3::ZERO).length_squared()
    }
}

/// How far a position is from the nearest side of its cube, in edges.
fn to_side(at: DVec3) -> f64 {
    let within = at - at.floor();
    within.min(1.0 - within).min_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All points around, one by one, of which there are enough.
    fn all(seeds: &Seeds, at: DVec3) -> Vec<DVec3> {
        let mut points = Vec::new();
        for i in 0..11 * 11 * 11 {
            let by = I64Vec3::new(i % 11 - 5, i / 11 % 11 - 5, i / 121 - 5);
            points.push(seeds.point((at / seeds.edge).floor().as_i64vec3() + by) * seeds.edge);
        }
        points.sort_by(|a, b| a.distance(at).total_cmp(&b.distance(at)));
        points
    }

    #[test]
    fn the_nearest_point_and_wall_are_those_of_all_points() {
        for jitter in [0.0, 0.5, 1.0] {
            let seeds = Seeds { edge: 0.3, jitter, seed: 5 };
            for i in 0..400 {
                let at = DVec3::new(0.171 * f64::from(i % 20), -0.233 * f64::from(i / 20), 0.0137 * f64::from(i)) - 1.0;
                let points = all(&seeds, at);
                let (far, way) = seeds.to_nearest(at);
                assert!((far + points[0].distance(at)).abs() < 1e-12, "{at}");
                assert!((at - way * far).distance(points[0]) < 1e-9, "{at}");
                let to_plane = |other: &DVec3| ((points[0] + *other) / 2.0 - at).dot((*other - points[0]).normalize());
                let wanted = points[1..].iter().map(to_plane).fold(f64::INFINITY, f64::min);
                let (depth, slope) = seeds.depth(at);
                assert!((depth - wanted).abs() < 1e-12, "{at}: {depth} for {wanted}");
                // On the plane two are the nearest.
                let foot = all(&seeds, at - slope * depth);
                let apart = foot[1].distance(at - slope * depth) - foot[0].distance(at - slope * depth);
                assert!(apart.abs() < 1e-9, "{at}: {apart}");
            }
        }
    }

    #[test]
    fn no_place_is_no_number() {
        let seeds = Seeds { edge: 1.0, jitter: 1.0, seed: 0 };
        assert!(seeds.to_nearest(DVec3::NAN).0.is_nan() && seeds.depth(DVec3::splat(f64::INFINITY)).0.is_nan());
    }
}

//! The walls of closed foam: what is near to the border of the cells of space that are nearest to given points each.
//!
//! The cell of a point gives half of its own wall to each border, so that between two cells the wall is as thick as the mean
//! of both. In a cell the value is the depth of the hollow, exact outside of material, since hollows are convex. Within
//! material it is less than the distance and no steeper: at a border that of both sides is half of the thinnest wall of all.

use glam::DVec3;

use super::part::{Parts, Sample};
use super::part_tree::PartTree;
use super::{Aabb, Slope};

/// The walls around points.
pub struct Walls {
    points: Centres,
    tree: PartTree,
    /// Half of the wall of each point's cell.
    halves: Vec<f64>,
    thinnest: f64,
}

/// Points, whose values are minus the distances to them.
pub(super) struct Centres(pub(super) Vec<DVec3>);

impl Parts for Centres {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn part(&self, index: usize, position: DVec3) -> Sample {
        let way = position - self.0[index];
        let far = way.length();
        (-far, if far > 0.0 { -way / far } else { DVec3::ZERO })
    }

    fn core(&self, index: usize) -> Option<(Aabb, f64)> {
        Some((Aabb::new(self.0[index], self.0[index]), 0.0))
    }

    fn bounding_box(&self) -> Option<Aabb> {
        None
    }

    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: true }
    }
}

impl Walls {
    /// The walls of the cells of points, each with the thickness of its own; `None` of fewer than two, which have none
    /// between them.
    pub fn new(points: Vec<(DVec3, f64)>) -> Option<Self> {
        if points.len() < 2 {
            return None;
        }
        let (points, halves): (Vec<DVec3>, Vec<f64>) = points.into_iter().map(|(at, wall)| (at, wall / 2.0)).unzip();
        let thinnest = halves.iter().fold(f64::INFINITY, |least, half| least.min(*half));
        let points = Centres(points);
        Some(Self { tree: PartTree::new(&points)?, points, halves, thinnest })
    }

    /// The value at a position and its gradient.
    pub fn at(&self, position: DVec3) -> Sample {
        if !position.is_finite() {
            return (f64::NAN, DVec3::NAN);
        }
        let (own, (near, _)) = self.tree.best(&self.points, position);
        let (from, near) = (self.points.0[own as usize], -near);
        let square = position.distance_squared(from);
        let mut best = (f64::INFINITY, DVec3::ZERO);
        // The plane to a point is at least half of how much farther that is.
        let reach = |depth: f64| -(near + 2.0 * depth);
        self.tree.visit(position, reach(best.0), |other| {
            let across = self.points.0[other as usize] - from;
            let length = across.length();
            if length > 0.0 {
                let depth = (self.points.0[other as usize].distance_squared(position) - square) / (2.0 * length);
                if depth < best.0 {
                    best = (depth, across / length);
                }
            }
            reach(best.0)
        });
        let half = self.halves[own as usize];
        let (value, factor) = self.within(half - best.0.max(0.0), half);
        (value, best.1 * factor)
    }

    /// A value as it is told, and what its slope is multiplied by: it stays up to half of the thinnest half, and goes on so that
    /// it is the thinnest half at the border of every cell.
    fn within(&self, value: f64, half: f64) -> (f64, f64) {
        let knee = self.thinnest / 2.0;
        if value <= knee {
            return (value, 1.0);
        }
        let factor = (self.thinnest - knee) / (half - knee);
        (knee + (value - knee) * factor, factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;

    fn cube() -> Aabb {
        Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0))
    }

    fn some(count: usize) -> (Vec<(DVec3, f64)>, Walls) {
        let mut samples = Samples::new(3);
        let points: Vec<(DVec3, f64)> =
            (0..count).map(|_| (samples.within(&cube()), 0.02 + 0.1 * samples.next())).collect();
        let walls = Walls::new(points.clone()).expect("enough");
        (points, walls)
    }

    /// Where it is hollow, the value is minus the distance to the nearest of the own cell's planes, each half a wall nearer: of
    /// all points, one by one.
    #[test]
    fn hollows_are_as_deep_as_all_points_say() {
        let (points, walls) = some(500);
        let mut samples = Samples::new(4);
        let mut hollow = 0;
        for _ in 0..2000 {
            let at = samples.within(&cube());
            let nearest = |a: &&(DVec3, f64), b: &&(DVec3, f64)| a.0.distance(at).total_cmp(&b.0.distance(at));
            let own = points.iter().min_by(nearest).expect("some");
            let plane = |other: &(DVec3, f64)| ((own.0 + other.0) / 2.0 - at).dot((other.0 - own.0).normalize());
            let depth = points.iter().filter(|other| *other != own).map(plane).fold(f64::INFINITY, f64::min);
            let (value, slope) = walls.at(at);
            let wanted = own.1 / 2.0 - depth;
            assert_eq!(value > 0.0, wanted > 0.0, "{at}");
            if wanted <= 0.0 {
                hollow += 1;
                assert!((value - wanted).abs() < 1e-12, "{at}: {value} for {wanted}");
                assert!((slope.length() - 1.0).abs() < 1e-9 && walls.at(at + slope * (1e-6 - value)).0 > 0.0, "{at}");
            }
        }
        assert!(hollow > 500, "{hollow}");
    }

    /// Across the borders of cells, too, it is no steeper than 1.
    #[test]
    fn no_way_is_steeper_than_one() {
        let (_, walls) = some(500);
        let mut samples = Samples::new(5);
        for _ in 0..20_000 {
            let at = samples.within(&cube());
            let there = at + samples.within(&cube()) * 10.0_f64.powf(-1.0 - 3.0 * samples.next());
            let (first, second) = (walls.at(at).0, walls.at(there).0);
            assert!((first - second).abs() <= at.distance(there) * (1.0 + 1e-9) + 1e-12, "{at} {there}");
        }
        assert!(walls.at(DVec3::NAN).0.is_nan());
    }
}

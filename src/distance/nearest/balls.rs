//! A union of equal balls as a field that asks a tree for the balls that are near.
//!
//! Of hundreds of balls a handful may be nearest to a block's points. A program that is pruned bounds each of them to find
//! out which; a tree leaves out whole boxes of them.

use glam::{DVec3, Vec3};

use super::PointTree;
use crate::field::{
    Aabb, BATCH, EqualBalls, Evaluator, Expression, Field, Gradients, Hint, Hints, Interval, Points, Slope,
};

/// Fewer balls are bounded one by one in no more time.
const MANY: usize = 16;

/// So many points at a time: what is known of them stays in registers.
const LANES: usize = 16;

/// The union of balls of one radius: the radius less the distance from the nearest middle, everywhere. The values are those
/// of the expression that it is of, to the last bit.
pub struct BallsByTree {
    middles: PointTree,
    radius: f64,
    bounds: Option<Aabb>,
}

impl BallsByTree {
    /// The field of an expression [for values alone](Expression::for_values_alone), where that is a union of many equal
    /// balls.
    pub fn of(field: &Expression) -> Option<Self> {
        let EqualBalls { middles, radius } = field.equal_balls().filter(|balls| balls.middles.len() >= MANY)?;
        Some(Self { middles: PointTree::new(middles), radius, bounds: field.bounding_box() })
    }
}

impl Field for BallsByTree {
    fn bounding_box(&self) -> Option<Aabb> {
        self.bounds
    }

    /// Inside, where balls overlap, the union's surface is farther than that of each.
    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: false }
    }

    fn reference(&self, position: DVec3) -> f64 {
        let nearest = self.middles.nearest(position, None);
        nearest.map_or(f64::NEG_INFINITY, |(_, middle)| self.radius - middle.distance(position))
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(BallsEvaluator { balls: self, regions: Vec::new(), near: Vec::new(), middles: Vec::new() })
    }
}

/// Where points lie tells which balls are near: more narrowly than a region does.
struct BallsEvaluator<'a> {
    balls: &'a BallsByTree,
    regions: Vec<Aabb>,
    /// Numbers of the balls near the points asked last, and their middles, negated, from the points' origin.
    near: Vec<usize>,
    middles: Vec<Vec3>,
}

impl BallsEvaluator<'_> {
    fn collect(&mut self, points: &Points) {
        self.middles.clear();
        if let Some(around) = points.bounding_box() {
            self.balls.middles.near(around, &mut self.near);
            let from_origin = |number: &usize| (points.origin - self.balls.middles.point(*number)).as_vec3();
            self.middles.extend(self.near.iter().map(from_origin));
        }
    }
}

impl Evaluator for BallsEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
    }

    /// From the balls that may be nearest: to all of the region one is no farther than its farthest corner.
    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        self.balls.middles.near(*region, &mut self.near);
        let (mut nearest, mut within) = (f64::INFINITY, f64::INFINITY);
        for number in &self.near {
            let middle = self.balls.middles.point(*number);
            let (below, above) = (region.min - middle, middle - region.max);
            nearest = nearest.min(below.max(above).max(DVec3::ZERO).length());
            within = within.min(below.abs().max(above.abs()).length());
        }
        // Values are rounded to f32.
        let slack = 8.0 * f64::from(f32::EPSILON) * (self.balls.radius.abs() + within);
        Interval::new(self.balls.radius - within - slack, self.balls.radius - nearest + slack)
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { keeps_values: true, ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.collect(points);
        distances(points, &self.middles, self.balls.radius as f32, out);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.values(points, &mut out.value);
        for i in 0..points.len {
            let to = self.middles.iter().map(|middle| points.offset(i) + *middle);
            let to = to.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or_default();
            (out.dx[i], out.dy[i], out.dz[i]) = (-to.normalize_or_zero()).into();
        }
    }
}

#[multiversion::multiversion(targets = "simd")]
fn distances(points: &Points, middles: &[Vec3], radius: f32, out: &mut [f32; BATCH]) {
    let [x, y, z] = [&points.x, &points.y, &points.z].map(|along| along.as_chunks::<LANES>().0);
    let rows = out.as_chunks_mut::<LANES>().0.iter_mut().take(points.len.div_ceil(LANES));
    for (out, ((x, y), z)) in rows.zip(x.iter().zip(y).zip(z)) {
        let mut least = [f32::INFINITY; LANES];
        for middle in middles {
            for i in 0..LANES {
                let (dx, dy, dz) = (x[i] + middle.x, y[i] + middle.y, z[i] + middle.z);
                let square = dx * dx + dy * dy + dz * dz;
                least[i] = if square < least[i] { square } else { least[i] };
            }
        }
        *out = least.map(|least| radius - least.sqrt());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::cells::{Purpose, Random};
    use crate::field::{Graph, Names};

    /// Balls at random places, some twice, as an expression.
    fn balls(count: usize, seed: u64) -> Expression {
        let mut random = Random::new(seed, 0, Purpose::Split);
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let mut text = String::new();
        for i in 0..count {
            let [x, y, z] = [(); 3].map(|()| (random.unit() * 64.0).floor() / 16.0 + 1000.0);
            let ball = format!("0.14 - sqrt((x - {x})^2 + (y - {y})^2 + (z - {z})^2)");
            text = if i == 0 { ball } else { format!("max({text}, {ball})") };
        }
        let root = crate::field::Formula::parse(&text).compile(&mut graph, &names);
        Expression::new(&graph, root.expect("a sound formula")).for_values_alone()
    }

    #[test]
    fn values_are_those_of_the_expression_to_the_last_bit() {
        let field = balls(150, 3);
        let tree = BallsByTree::of(&field).expect("many equal balls");
        let (mut whole, mut by_tree) = (field.evaluator(), tree.evaluator());
        let mut random = Random::new(4, 0, Purpose::Split);
        let mut outside = 0;
        for round in 0..200 {
            let size = [0.0, 0.05, 0.4, 6.0][round % 4];
            let middle = DVec3::new(random.unit(), random.unit(), random.unit()) * 8.0 + 998.0;
            let mut points = Points::new(middle);
            for _ in 0..[1, 37, BATCH][round % 3] {
                points.push(Vec3::from_array([(); 3].map(|()| (random.unit() as f32 - 0.5) * size)));
            }
            let (mut want, mut got) = ([0.0; BATCH], [0.0; BATCH]);
            whole.values(&points, &mut want);
            by_tree.values(&points, &mut got);
            assert_eq!(want[..points.len], got[..points.len]);
            let region = Aabb::new(middle, middle).grown(f64::from(size) / 2.0);
            by_tree.enter(&region);
            let bounds = by_tree.bounds();
            by_tree.leave();
            for i in 0..points.len {
                assert!(bounds.contains(f64::from(got[i])), "{} in {bounds:?}", got[i]);
                assert!((f64::from(got[i]) - tree.reference(points.position(i))).abs() < 1e-5);
            }
            // As far apart as the region is wide, and no more.
            assert!(bounds.hi - bounds.lo < 2.0 * region.size().length() + 1e-3);
            let (mut want, mut got) = (Gradients::new(), Gradients::new());
            whole.gradients(&points, &mut want);
            by_tree.gradients(&points, &mut got);
            for i in 0..points.len {
                // Halfway between two middles either is right.
                outside += usize::from((want.gradient(i) - got.gradient(i)).length() > 1e-4);
            }
        }
        assert!(outside < 20, "{outside} gradients differ");
    }

    #[test]
    fn few_balls_are_left_as_they_are() {
        assert!(BallsByTree::of(&balls(MANY - 1, 1)).is_none());
        assert!(BallsByTree::of(&balls(MANY, 1)).is_some());
    }
}

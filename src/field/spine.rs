//! A smooth curve through points, with a frame that turns about it no more than it must.

use glam::DVec3;

/// A curve by its length: the cubic spline through points that lie close, and straight on beyond its ends.
#[derive(Clone, Debug)]
pub struct Spine {
    knots: Vec<Knot>,
}

/// A point of the curve.
#[derive(Clone, Copy, Debug)]
struct Knot {
    /// The way from the beginning.
    way: f64,
    at: DVec3,
    /// The change of place by the way, about 1 long.
    slope: DVec3,
    /// Where the frame's first axis points.
    across: DVec3,
}

/// The curve at one way.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// The place.
    pub at: DVec3,
    /// Its first derivative by the way.
    pub slope: DVec3,
    /// Its second derivative.
    pub curvature: DVec3,
    /// The frame: two axes across and the one along, of length 1.
    pub axes: [DVec3; 3],
}

impl Spine {
    /// Through points of which none is its neighbour, at least three. The frame's second axis at the beginning points as far
    /// as it can to `up`.
    pub fn new(points: &[DVec3], up: DVec3) -> Self {
        let ways = ways(points);
        let slopes = slopes(points, &ways);
        let along: Vec<DVec3> = slopes.iter().map(|slope| slope.normalize_or(DVec3::Z)).collect();
        let first = up.cross(along[0]);
        let mut across = if first.length() > 1e-9 { first.normalize() } else { along[0].any_orthonormal_vector() };
        let mut knots: Vec<Knot> = Vec::with_capacity(points.len());
        for i in 0..points.len() {
            if i > 0 {
                across = carried(across, points[i] - points[i - 1], along[i - 1], along[i]);
            }
            knots.push(Knot { way: ways[i], at: points[i], slope: slopes[i], across });
        }
        Self { knots }
    }

    /// The whole length.
    pub fn length(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot.way)
    }

    /// Where it turns by so much from one piece to the next that no circle goes through, and about how tightly.
    pub fn cusp(&self) -> Option<(DVec3, f64)> {
        const SHARP: f64 = 0.5;
        let chord = |pair: &[Knot; 2]| pair[1].at - pair[0].at;
        let mut turns = self.knots.array_windows::<3>().map(|[a, b, c]| {
            let (before, after) = (chord(&[*a, *b]), chord(&[*b, *c]));
            let angle = before.angle_between(after);
            (b.at, angle, before.length().min(after.length()) / angle)
        });
        turns.find(|(_, angle, _)| *angle > SHARP).map(|(at, _, radius)| (at, radius))
    }

    /// How many pieces there are between knots.
    pub fn pieces(&self) -> usize {
        self.knots.len() - 1
    }

    /// The ways at the ends of a piece.
    pub fn piece(&self, piece: usize) -> [f64; 2] {
        [self.knots[piece].way, self.knots[piece + 1].way]
    }

    /// The curve at a way; beyond the ends straight on.
    pub fn at(&self, way: f64) -> Station {
        let (knot, [at, slope, curvature]) = self.place(way);
        let along = slope.normalize_or(DVec3::Z);
        let across = carried(knot.across, at - knot.at, knot.slope.normalize_or(DVec3::Z), along);
        let first = (across - along * across.dot(along)).normalize_or(along.any_orthonormal_vector());
        Station { at, slope, curvature, axes: [first, along.cross(first), along] }
    }

    /// The knot before a way, and place, first and second derivative there.
    fn place(&self, way: f64) -> (Knot, [DVec3; 3]) {
        let last = self.knots.len() - 1;
        if way < 0.0 || way > self.knots[last].way {
            let knot = self.knots[if way < 0.0 { 0 } else { last }];
            // Its frame stays.
            let at = knot.at + (way - knot.way) * knot.slope;
            return (Knot { at, ..knot }, [at, knot.slope, DVec3::ZERO]);
        }
        let after = self.knots.partition_point(|knot| knot.way <= way).clamp(1, last);
        let [a, b] = [self.knots[after - 1], self.knots[after]];
        let step = b.way - a.way;
        let t = (way - a.way) / step;
        // The cubic of both places and slopes (Hermite), and its derivatives.
        let chord = (b.at - a.at) / step;
        let second = 3.0 * chord - 2.0 * a.slope - b.slope;
        let third = a.slope + b.slope - 2.0 * chord;
        let at = a.at + step * t * (a.slope + t * (second + t * third));
        let slope = a.slope + t * (2.0 * second + 3.0 * t * third);
        (a, [at, slope, (2.0 * second + 6.0 * t * third) / step])
    }

    /// The way of the place of the curve that is nearest to a position, near one that is known (Newton).
    pub fn foot(&self, position: DVec3, near: f64) -> f64 {
        const STEPS: usize = 20;
        let mut way = near;
        for _ in 0..STEPS {
            let (_, [at, slope, curvature]) = self.place(way);
            let off = position - at;
            let steep = slope.length_squared() - off.dot(curvature);
            // Beyond the centre of the curve's circle there is no nearest place to step to.
            let step = off.dot(slope) / if steep > 0.1 { steep } else { slope.length_squared() };
            way += step;
            if step.abs() <= 1e-13 * self.length() {
                break;
            }
        }
        way
    }
}

/// The lengths up to each point: of the circle through it and its neighbours between them.
fn ways(points: &[DVec3]) -> Vec<f64> {
    let chord = |i: usize| points[i + 1] - points[i];
    let mut ways = vec![0.0];
    for i in 0..points.len() - 1 {
        let turn = |other: usize| chord(i).angle_between(chord(other));
        let turns = [i.checked_sub(1), Some(i + 1).filter(|next| next + 1 < points.len())];
        let known: Vec<f64> = turns.into_iter().flatten().map(turn).collect();
        let angle = known.iter().sum::<f64>() / known.len().max(1) as f64;
        ways.push(ways[i] + chord(i).length() * (1.0 + angle * angle / 24.0));
    }
    ways
}

/// The slopes at the points of the spline whose second derivative goes on evenly over each point and does not change along the
/// first and the last piece (Thomas' algorithm).
fn slopes(points: &[DVec3], ways: &[f64]) -> Vec<DVec3> {
    let last = points.len() - 1;
    let step = |i: usize| ways[i + 1] - ways[i];
    let chord = |i: usize| (points[i + 1] - points[i]) / step(i);
    // Rows of the system: what stands before, on and after the diagonal, and the right side.
    let row = |i: usize| match i {
        0 => (0.0, 1.0, 1.0, 2.0 * chord(0)),
        i if i == last => (1.0, 1.0, 0.0, 2.0 * chord(last - 1)),
        i => {
            let (before, after) = (1.0 / step(i - 1), 1.0 / step(i));
            (before, 2.0 * (before + after), after, 3.0 * (before * chord(i - 1) + after * chord(i)))
        }
    };
    let (mut above, mut right): (Vec<f64>, Vec<DVec3>) = (Vec::new(), Vec::new());
    for i in 0..=last {
        let (before, on, after, side) = row(i);
        let (known, value) = if i == 0 { (0.0, DVec3::ZERO) } else { (above[i - 1], right[i - 1]) };
        let pivot = on - before * known;
        above.push(after / pivot);
        right.push((side - before * value) / pivot);
    }
    for i in (0..last).rev() {
        let next = right[i + 1];
        right[i] -= above[i] * next;
    }
    right
}

/// An axis across a curve, carried on by two reflections, so that it turns about the curve by nothing but rounding (Wang, Jüttler,
/// Zheng and Liu, Computation of rotation minimizing frames, 2008).
fn carried(across: DVec3, chord: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let reflected = |vector: DVec3, normal: DVec3| match normal.length_squared() {
        0.0 => vector,
        length => vector - 2.0 / length * normal.dot(vector) * normal,
    };
    let (across, along) = (reflected(across, chord), reflected(from, chord));
    let across = reflected(across, to - along);
    (across - to * across.dot(to)).normalize_or(to.any_orthonormal_vector())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(radius: f64, angle: f64, count: usize) -> Spine {
        let at = |i: usize| angle * i as f64 / count as f64;
        let points: Vec<DVec3> =
            (0..=count).map(|i| DVec3::new(radius * libm::cos(at(i)), radius * libm::sin(at(i)), 0.0)).collect();
        Spine::new(&points, DVec3::Z)
    }

    #[test]
    fn a_circle_is_one() {
        let spine = circle(2.0, 4.0, 200);
        assert!((spine.length() - 8.0).abs() < 1e-5, "{}", spine.length());
        for i in 0..=50 {
            let way = spine.length() * f64::from(i) / 50.0;
            let Station { at, slope, curvature, axes } = spine.at(way);
            assert!((at.length() - 2.0).abs() < 1e-7, "{at}");
            assert!((slope.length() - 1.0).abs() < 1e-4 && at.dot(slope).abs() < 2e-4, "{slope}");
            assert!((curvature.length() - 0.5).abs() < 5e-3, "{curvature} at {way}");
            // Flat, it turns about nothing: up stays up.
            assert!((axes[1] - DVec3::Z).length() < 1e-9 && (axes[0].cross(axes[1]) - axes[2]).length() < 1e-9);
            let off = at * 1.3 + DVec3::Z * 0.2;
            assert!((spine.foot(off, way + 0.03) - way).abs() < 1e-4);
        }
        // Beyond its ends it goes straight on.
        let before = spine.at(-1.0);
        assert!((before.at - DVec3::new(2.0, -1.0, 0.0)).length() < 1e-4, "{}", before.at);
    }

    #[test]
    fn frames_do_not_turn_about_a_helix() {
        let at = |i: usize| {
            let angle = i as f64 * 0.02;
            DVec3::new(libm::cos(angle), libm::sin(angle), 0.3 * angle)
        };
        let spine = Spine::new(&(0..700).map(at).collect::<Vec<_>>(), DVec3::Z);
        let step = 1e-4;
        for i in 1..100 {
            let way = spine.length() * f64::from(i) / 101.0;
            let (here, there) = (spine.at(way), spine.at(way + step));
            let turning = (there.axes[0] - here.axes[0]).dot(here.axes[1]) / step;
            assert!(turning.abs() < 1e-4, "{turning} at {way}");
        }
    }
}

//! A smooth curve through points, with a frame that turns about it no more than it must.

use glam::DVec3;

/// A curve by its length: the cubic spline through points that lie close, and straight on beyond its ends, or round and round
/// where it has none.
#[derive(Clone, Debug)]
pub struct Spine {
    knots: Vec<Knot>,
    is_closed: bool,
    /// By how much the frame turns about a closed curve on its way: radians a unit.
    twist: f64,
    /// By how much it has turned when it comes back.
    turn: f64,
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
        Self { knots, is_closed: false, twist: 0.0, turn: 0.0 }
    }

    /// Through points, at least three, and from the last one back to the first. A frame that turns no more than it must comes
    /// back turned; what is missing to the whole turn, and `turn` in radians beyond that, is spread evenly over the length.
    pub fn closed(points: &[DVec3], up: DVec3, turn: f64) -> Self {
        /// Points before the beginning and beyond the end: one counts (2 − √3) times as much as the one before it.
        const AROUND: usize = 28;
        let count = points.len();
        let ring: Vec<DVec3> =
            (0..count + 1 + 2 * AROUND).map(|i| points[(i + count * AROUND - AROUND) % count]).collect();
        let Self { knots, .. } = Self::new(&ring, up);
        let mut knots: Vec<Knot> = knots[AROUND..=AROUND + count].to_vec();
        let start = knots[0].way;
        knots.iter_mut().for_each(|knot| knot.way -= start);
        knots[count].slope = knots[0].slope;
        let along: Vec<DVec3> = knots.iter().map(|knot| knot.slope.normalize_or(DVec3::Z)).collect();
        let first = up.cross(along[0]);
        knots[0].across = if first.length() > 1e-9 { first.normalize() } else { along[0].any_orthonormal_vector() };
        for i in 1..=count {
            knots[i].across = carried(knots[i - 1].across, knots[i].at - knots[i - 1].at, along[i - 1], along[i]);
        }
        let (begun, come) = (knots[0].across, knots[count].across);
        let missing = libm::atan2(begun.dot(along[0].cross(come)), begun.dot(come));
        let twist = (missing + turn) / knots[count].way;
        Self { knots, is_closed: true, twist, turn }
    }

    /// Whether it ends where it begins.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// By how much the frame turns about the curve on its way: radians a unit.
    pub fn twist(&self) -> f64 {
        self.twist
    }

    /// The whole length.
    pub fn length(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot.way)
    }

    /// Where it turns by so much from one piece to the next that no circle goes through, and about how tightly.
    pub fn cusp(&self) -> Option<(DVec3, f64)> {
        const SHARP: f64 = 0.5;
        let chord = |pair: &[Knot; 2]| pair[1].at - pair[0].at;
        let count = self.knots.len();
        let seam = self.is_closed.then(|| [self.knots[count - 2], self.knots[0], self.knots[1]]);
        let mut turns = self.knots.array_windows::<3>().copied().chain(seam).map(|[a, b, c]| {
            let (before, after) = (chord(&[a, b]), chord(&[b, c]));
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

    /// The curve at a way; beyond the ends straight on, or on the next round.
    pub fn at(&self, way: f64) -> Station {
        // A round more is the turn more, so that nothing jumps where the next one begins.
        let beyond = if self.is_closed { self.turn * (way / self.length()).floor() } else { 0.0 };
        let way = self.on_round(way);
        let (knot, [at, slope, curvature]) = self.place(way);
        let along = slope.normalize_or(DVec3::Z);
        let across = carried(knot.across, at - knot.at, knot.slope.normalize_or(DVec3::Z), along);
        let first = (across - along * across.dot(along)).normalize_or(along.any_orthonormal_vector());
        let angle = self.twist * way + beyond;
        let first = if angle == 0.0 { first } else { first * libm::cos(angle) + along.cross(first) * libm::sin(angle) };
        Station { at, slope, curvature, axes: [first, along.cross(first), along] }
    }

    /// A way of a closed curve between its beginning and its end.
    fn on_round(&self, way: f64) -> f64 {
        if self.is_closed { way.rem_euclid(self.length()) } else { way }
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
            let (_, [at, slope, curvature]) = self.place(self.on_round(way));
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

    /// A trefoil has no seam: place, slopes and frame go on over it, and the frame turns by as much everywhere.
    #[test]
    fn a_closed_curve_has_no_seam() {
        let count = 900;
        let at = |i: usize| {
            let (angle, far) = (std::f64::consts::TAU * i as f64 / count as f64, 0.6);
            let across = 2.0 + far * libm::cos(3.0 * angle);
            DVec3::new(across * libm::cos(2.0 * angle), across * libm::sin(2.0 * angle), far * libm::sin(3.0 * angle))
        };
        let points: Vec<DVec3> = (0..count).map(at).collect();
        for turn in [0.0, std::f64::consts::TAU, -2.5] {
            let spine = Spine::closed(&points, DVec3::Z, turn);
            let (length, step) = (spine.length(), 1e-5);
            for i in 0..100 {
                let way = length * f64::from(i) / 100.0;
                let [before, after] = [way - step, way + step].map(|way| spine.at(way));
                let speed = (after.at - before.at) / (2.0 * step);
                assert!((speed.length() - 1.0).abs() < 1e-4 && speed.dot(before.axes[2]) > 0.999, "{speed} at {way}");
                assert!((after.slope - before.slope).length() < 1e-4, "at {way}");
                assert!((after.curvature - before.curvature).length() < 1e-2, "at {way}");
                let turning = (after.axes[0] - before.axes[0]).dot(before.axes[1]) / (2.0 * step);
                assert!((turning - spine.twist()).abs() < 1e-4, "{turning} at {way}, {}", spine.twist());
            }
            let [begin, end] = [1e-9, length - 1e-9].map(|way| spine.at(way).axes[0]);
            assert!((begin.dot(end) - libm::cos(turn)).abs() < 1e-6, "{begin}, {end}");
        }
        // A ring in a plane needs no twist.
        let ring: Vec<DVec3> = (0..100)
            .map(|i| {
                DVec3::new(
                    libm::cos(0.0628318530717959 * f64::from(i)),
                    libm::sin(0.0628318530717959 * f64::from(i)),
                    0.0,
                )
            })
            .collect();
        let ring = Spine::closed(&ring, DVec3::Z, 0.0);
        assert!(ring.twist().abs() < 1e-9 && (ring.length() - std::f64::consts::TAU).abs() < 1e-5, "{ring:?}");
    }
}

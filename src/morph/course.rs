//! Every section of a morph at once: what a place shows that has a progress of its own.
//!
//! A section hardly changes in its first and last moments, but F_b becomes flat inside the surface there, and cannot be
//! measured: F_b there goes over into the object's distance, which its zero set ends in.

use super::curves::Curves;
use super::pace::cubic;
use super::real::Real;
use super::section::{Kernel, Slopes};
use crate::field::Interval;

/// How many units of D a unit of t is worth: with the slab and the reach of settings it keeps the first and last frames
/// alive and whole.
pub(super) const FLOW_TIME_SCALE: f64 = 0.25;
/// Sections that are solved, but for the first. Fewer: surfaces go in waves from one to the next, and volumes are off in
/// between; each costs a solve of a₀.
const SOLVED: usize = 48;
/// The parts that progress between two of them is divided into. What needs no solving is taken at each.
const FINER: usize = 8;
/// The share of progress at both ends in which F_b goes over into a distance.
const END: f64 = 0.01;
/// The least t, and the least left to 1, that sections are taken at.
pub(super) const LEAST_TIME: f64 = 1e-3;

/// What varies of a section as the morph goes on, over its progress: STB's t; a₀ over t(1 − t), which neither vanishes nor
/// grows at the ends; and 1/(a₁²q), which is also 1/(a₂²q).
pub(super) type Course = Curves<3>;

/// A section but for its a₀.
pub(super) struct Timed {
    pub time: f64,
    /// 1/(a₁²q).
    pub reach: f64,
}

/// The blend at one place.
pub(super) struct Place<T> {
    kernel: Kernel<T>,
    /// How much of the first and of the second object's distance counts in place of F_b.
    ends: [T; 2],
}

impl<T: Real> Place<T> {
    /// That of a progress and of the course there.
    #[inline(always)]
    pub(super) fn new(progress: T, [time, amount, reach]: [T; 3]) -> Self {
        let (scale, left) = (T::of(FLOW_TIME_SCALE), T::ONE - time);
        let kernel = Kernel::of_parts([-(scale * time), -(scale * left)], amount * time * left, reach);
        Self { kernel, ends: ends(progress) }
    }

    /// The blend, of distances in units of D.
    #[inline(always)]
    pub(super) fn value(&self, first: T, second: T) -> T {
        let [one, two] = self.ends;
        self.kernel.value(first, second) * (T::ONE - one - two) + first * one + second * two
    }

    /// The blend with its derivatives by both distances.
    #[inline(always)]
    pub(super) fn slopes(&self, first: T, second: T) -> Slopes<T> {
        let [one, two] = self.ends;
        let (blend, rest) = (self.kernel.slopes(first, second), T::ONE - one - two);
        Slopes {
            value: blend.value * rest + first * one + second * two,
            by_first: blend.by_first * rest + one,
            by_second: blend.by_second * rest + two,
        }
    }

    /// The blend's derivative by the progress it is at, with the course there and how fast that changes.
    #[inline(always)]
    pub(super) fn rate(&self, progress: T, course: [T; 3], rates: [T; 3], [first, second]: [T; 2]) -> T {
        let ([time, amount, _], [time_rate, amount_rate, reach_rate]) = (course, rates);
        let (cut_rate, left) = (T::of(FLOW_TIME_SCALE) * time_rate, T::ONE - time);
        let a0_rate = amount_rate * time * left + amount * time_rate * (left - time);
        let blend_rate = self.kernel.rate([-cut_rate, cut_rate], a0_rate, reach_rate, first, second);
        let blend = self.kernel.value(first, second);
        let [one, two] = self.ends;
        blend_rate * (T::ONE - one - two)
            + (first - blend) * end_rate(progress)
            + (blend - second) * end_rate(T::ONE - progress)
    }
}

/// The blends of a range of progress: the least and the most of what they are made of.
pub(super) struct Sections<T> {
    cuts: [[T; 2]; 2],
    amount: [T; 2],
    reach: [T; 2],
    ends: [[T; 2]; 2],
}

impl<T: Real> Sections<T> {
    /// Those from a progress to another, between which the course has no more and no less than these.
    #[inline(always)]
    pub(super) fn between(progress: [T; 2], [time, amount, reach]: [[T; 2]; 3]) -> Self {
        let scale = T::of(FLOW_TIME_SCALE);
        // t(1 − t) is least at an end, and at most a quarter.
        let left = time.map(|time| time * (T::ONE - time));
        let middle = time[0] < T::of(0.5) && T::of(0.5) < time[1];
        let most = if middle { T::of(0.25) } else { left[0].most(left[1]) };
        let [from, to] = progress.map(ends);
        Self {
            cuts: [[-(scale * time[1]), -(scale * time[0])], time.map(|time| -(scale * (T::ONE - time)))],
            amount: [amount[0] * left[0].least(left[1]), amount[1] * most],
            reach,
            ends: [[to[0], from[0]], [from[1], to[1]]],
        }
    }

    /// The least and the most of the blends for distances between their least and most, all in units of D: also of what a
    /// batch in `f32` makes of them. No number where a distance is infinite.
    #[inline(always)]
    pub(super) fn bounds(&self, first: [T; 2], second: [T; 2]) -> [T; 2] {
        let [mut least, mut most] = [self.blend(0, first, second), self.blend(1, first, second)];
        for (shares, distance) in self.ends.iter().zip([first, second]) {
            let mix = |share: T, blend: T, own: T| blend + share * (own - blend);
            let [few, many] = *shares;
            least = mix(few, least, distance[0]).least(mix(many, least, distance[0]));
            most = mix(few, most, distance[1]).most(mix(many, most, distance[1]));
        }
        [least, most]
    }

    /// The least or the most of F_b. It rises with all but the reach: both cylinders are ≤ 0, and ρ is least at their upper
    /// ends.
    #[inline(always)]
    fn blend(&self, side: usize, first: [T; 2], second: [T; 2]) -> T {
        let cuts = self.cuts.map(|cut| cut[side]);
        let kernel = Kernel::of_parts(cuts, self.amount[side], self.reach[1 - side]);
        let value = kernel.value(first[side], second[side]);
        // Once for this value and once for those of the batches to come.
        let rounding = T::TWO * kernel.rounding(value);
        if side == 0 { value - rounding } else { value + rounding }
    }
}

impl Course {
    /// The progresses at which sections are to be solved for a range of progress, and one beyond either end of it, which
    /// curves within bend by: closer together towards 0 and 1, where a₀ bends most.
    pub(super) fn nodes(progress: Interval) -> Vec<f64> {
        let node = |i: usize| 0.5 - 0.5 * libm::cos(std::f64::consts::PI * i as f64 / SOLVED as f64);
        let nodes: Vec<f64> = (0..=SOLVED).map(node).collect();
        let first = nodes.partition_point(|node| *node <= progress.lo).saturating_sub(2);
        let end = nodes.partition_point(|node| *node < progress.hi) + 2;
        nodes[first..end.min(nodes.len())].to_vec()
    }

    /// From what sections are at any progress, and the a₀ of those at such nodes. `None` where a number is not finite.
    pub(super) fn new(nodes: &[f64], a0: &[f64], timed: impl Fn(f64) -> Timed) -> Option<Self> {
        let amount = |(node, a0): (&f64, &f64)| {
            let Timed { time, .. } = timed(*node);
            [*node, a0 / (time * (1.0 - time))]
        };
        let amounts: Vec<[f64; 2]> = nodes.iter().zip(a0).map(amount).collect();
        let finer = |i: usize| {
            let [from, to] = [nodes[i], nodes[i + 1]];
            (0..FINER).map(move |part| (i, from + (to - from) * part as f64 / FINER as f64))
        };
        let last = nodes.len() - 2;
        let places = (0..=last).flat_map(finer).chain([(last, nodes[last + 1])]);
        let point = |(piece, progress): (usize, f64)| {
            let Timed { time, reach } = timed(progress);
            (progress, [time, by_parabolas(&amounts, piece, progress), reach])
        };
        Self::through(places.map(point).collect())
    }

    /// a₀ at a progress.
    pub(super) fn a0(&self, progress: f64) -> f64 {
        let [time, amount, _] = self.at(progress);
        amount * time * (1.0 - time)
    }

    /// The blend at a progress.
    pub(super) fn place(&self, progress: f64) -> Place<f64> {
        Place::new(progress, self.at(progress))
    }

    /// The blends of a range of progress.
    pub(super) fn sections(&self, progress: Interval) -> Sections<f64> {
        let ends = [progress.lo, progress.hi];
        let [from, to] = ends.map(|progress| self.at(progress));
        let mut course = self.turns(progress).map(|turns| [turns.lo, turns.hi]);
        for (course, (from, to)) in course.iter_mut().zip(from.into_iter().zip(to)) {
            *course = [course[0].min(from).min(to), course[1].max(from).max(to)];
        }
        Sections::between(ends, course)
    }

    /// How far outside both objects' boxes the blend may still be positive, in units of D; `None` where it never falls.
    pub(super) fn outside(&self) -> Option<f64> {
        let nodes: Vec<f64> = self.xs().collect();
        let piece = |piece: &[f64]| self.sections(Interval::new(piece[0], piece[1]));
        let pieces: Vec<_> = nodes.windows(2).map(piece).collect();
        let inside = |reach: f64| pieces.iter().any(|piece| piece.bounds([-reach; 2], [-reach; 2])[1] >= 0.0);
        let reach = std::iter::successors(Some(1.0 / 64.0), |reach| Some(reach * 1.25));
        reach.take_while(|reach| *reach < 1e6).find(|reach| !inside(*reach))
    }
}

/// The y at an x between a point and the next: a cubic with the slope that the parabola through a point and both beside it
/// has there. Unlike [`Curve`](super::pace::Curve) it goes beyond the points where it turns: as what they are of does.
fn by_parabolas(points: &[[f64; 2]], piece: usize, x: f64) -> f64 {
    let secant = |i: usize| {
        let [[x0, y0], [x1, y1]] = [points[i], points[i + 1]];
        (x1 - x0, (y1 - y0) / (x1 - x0))
    };
    let slope = |i: usize| {
        let sides = [i.checked_sub(1).map(secant), (i + 1 < points.len()).then(|| secant(i))];
        match sides {
            [Some((before, down)), Some((after, up))] => (down * after + up * before) / (before + after),
            [Some((_, only)), None] | [None, Some((_, only))] => only,
            [None, None] => 0.0,
        }
    };
    let ([x0, y0], [_, y1], (width, _)) = (points[piece], points[piece + 1], secant(piece));
    let [a, b, c, d] = cubic([y0, y1], [slope(piece) * width, slope(piece + 1) * width]);
    let s = (x - x0) / width;
    a + s * (b + s * (c + s * d))
}

/// How much of each object's distance counts.
#[inline(always)]
fn ends<T: Real>(progress: T) -> [T; 2] {
    [end(progress), end(T::ONE - progress)]
}

/// 1 at the end, falling to 0 over [`END`].
#[inline(always)]
fn end<T: Real>(progress: T) -> T {
    let u = share_of_end(progress);
    T::ONE - u * u * (T::of(3.0) - T::TWO * u)
}

#[inline(always)]
fn end_rate<T: Real>(progress: T) -> T {
    let u = share_of_end(progress);
    T::of(-6.0 / END) * u * (T::ONE - u)
}

#[inline(always)]
fn share_of_end<T: Real>(progress: T) -> T {
    (progress * T::of(1.0 / END)).most(T::ZERO).least(T::ONE)
}

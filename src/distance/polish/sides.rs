//! Which side of the surface a position is on where F is zero there, and whether F changes sign across a zero.
//!
//! Where operands of an intersection share a face, F is zero on it and negative on both sides: a skin of no thickness,
//! which is no surface of the solid (the closure of F > 0). Where those of a union do, F is positive on both sides: a
//! wall, which is none either. Rounding gives such zeros any sign. What counts is what F reaches beside them: a sheet or a
//! gap that is thicker than the [resolution](Resolution) is kept, a thinner one is not there.

use glam::Vec3;

use crate::field::{BATCH, Evaluator, Gradients, Points};

use super::lanes::Lane;

/// How far on both sides of a zero F is looked at, in units. More than the error of a closest point; two surfaces nearer
/// to one another than this are told apart by a search.
pub(super) const ACROSS: f32 = 0.01;

/// The golden section.
const SECTION: f32 = 0.618_034;

/// Narrowings of a search: it starts with the 2·[`ACROSS`] units across a zero, and 14 leave 2e-5.
const NARROWINGS: usize = 14;

/// F farther from zero than this many times its resolution, by its slope beside the zero, is no rounding. A sheet between
/// parallel faces reaches half of its thickness by min and max, and a fifth by R₀.
const BEYOND_ROUNDING: f32 = 0.25;

/// Which side of the surface a value is on, by that of a value as far from it: `None` where it is zero but for rounding.
/// So the zeros along a skin or a wall do not stand for a side.
#[inline(always)]
pub(super) fn is_inside(value: f32, other: f32, resolution: Resolution) -> Option<bool> {
    let rounding = resolution.share() * other.abs();
    (value.abs() > rounding).then_some(value >= 0.0)
}

/// Whether F is nearer to zero a step before a zero than behind, or farther. On a wall or skin it is as far; a sheet lies
/// on one side of its zeros.
pub(super) fn is_uneven(before: f32, behind: f32, resolution: Resolution) -> bool {
    let (before, behind) = (before.abs(), behind.abs());
    (before - behind).abs() > 2.0 * resolution.share() * before.max(behind)
}

/// What F resolves.
#[derive(Clone, Copy, Debug)]
pub struct Resolution {
    /// The unit of a [`Request`](super::Request), world units.
    pub unit: f32,
    /// The least thickness of sheets and gaps that are told from none, world units.
    pub least: f32,
}

impl Resolution {
    /// The usual one: a ten-thousandth of a unit, or what is left of single precision over an object of that size.
    pub fn new(unit: f64, size: f64) -> Self {
        /// Single precision has steps of 6e-8, and an expression adds up a few of them.
        const ROUNDING: f64 = 4e-7;
        Self { unit: unit as f32, least: (1e-4 * unit).max(ROUNDING * size) as f32 }
    }

    /// What F may be by rounding, as a share of what it is [`ACROSS`] units away.
    pub(super) fn share(self) -> f32 {
        BEYOND_ROUNDING * self.least / (ACROSS * self.unit)
    }
}

/// Zeros of F, and a step of [`ACROSS`] units across each.
#[derive(Clone)]
pub(super) struct Zeros {
    pub points: Points,
    pub steps: [Lane; 3],
    /// The caller's number for each.
    pub of: [u16; BATCH],
}

impl Zeros {
    pub fn new() -> Self {
        Self { points: Points::new(glam::DVec3::ZERO), steps: [[0.0; BATCH]; 3], of: [0; BATCH] }
    }

    pub fn clear(&mut self, origin: glam::DVec3) {
        (self.points.origin, self.points.len) = (origin, 0);
    }

    pub fn push(&mut self, of: usize, point: Vec3, step: Vec3) {
        let lane = self.points.len;
        self.of[lane] = of as u16;
        self.set_step(lane, step);
        self.points.push(point);
    }

    pub fn step(&self, lane: usize) -> Vec3 {
        Vec3::new(self.steps[0][lane], self.steps[1][lane], self.steps[2][lane])
    }

    fn set_step(&mut self, lane: usize, step: Vec3) {
        (self.steps[0][lane], self.steps[1][lane], self.steps[2][lane]) = step.into();
    }

    /// Puts the points moved by a share of their steps, within the bounds, into `out`.
    fn stepped(&self, shares: impl Fn(usize) -> f32, bounds: [Vec3; 2], out: &mut Points) {
        (out.origin, out.len) = (self.points.origin, 0);
        for lane in 0..self.points.len {
            out.push((self.points.offset(lane) + self.step(lane) * shares(lane)).clamp(bounds[0], bounds[1]));
        }
    }

    /// Moves the points across the zero set of what was evaluated at them, by one Newton step, and lets their steps lead
    /// across it, on the sides where they did.
    pub fn project(&mut self, at: &Gradients, bounds: [Vec3; 2]) {
        for lane in 0..self.points.len {
            let (slope, step) = (at.gradient(lane), self.step(lane));
            let square = slope.length_squared();
            if square > 0.0 && square.is_finite() {
                let point = self.points.offset(lane) - slope * (at.value[lane] / square);
                let point = point.clamp(bounds[0], bounds[1]);
                (self.points.x[lane], self.points.y[lane], self.points.z[lane]) = point.into();
                let onward = if slope.dot(step) < 0.0 { -slope } else { slope };
                self.set_step(lane, onward * (step.length() / square.sqrt()));
            }
        }
    }

    pub fn keep(&mut self, mut passes: impl FnMut(usize) -> bool) {
        let mut kept = 0;
        for lane in 0..self.points.len {
            if passes(lane) {
                let (point, step) = (self.points.offset(lane), self.step(lane));
                (self.points.x[kept], self.points.y[kept], self.points.z[kept]) = point.into();
                self.set_step(kept, step);
                self.of[kept] = self.of[lane];
                kept += 1;
            }
        }
        self.points.len = kept;
    }
}

/// Scratch memory of one thread.
pub struct Sides {
    pub(super) zeros: Zeros,
    probes: Points,
    ends: [Box<Lane>; 2],
    values: [Box<Lane>; 2],
    ranges: Box<[[f32; 2]; BATCH]>,
}

impl Sides {
    /// Allocates it.
    pub fn new() -> Self {
        let lane = || Box::new([0.0; BATCH]);
        Self {
            zeros: Zeros::new(),
            probes: Points::new(glam::DVec3::ZERO),
            ends: [lane(), lane()],
            values: [lane(), lane()],
            ranges: Box::new([[0.0; 2]; BATCH]),
        }
    }

    /// Gives values that are zero but for rounding the sign of what is around them: negative on a skin, positive on a wall.
    /// Others stay as they are.
    pub fn settle(
        &mut self,
        evaluator: &mut dyn Evaluator,
        resolution: Resolution,
        points: &Points,
        at: &mut Gradients,
    ) {
        if !any_zero(at, points.len, resolution.least) {
            return;
        }
        self.zeros.clear(points.origin);
        for i in (0..points.len).filter(|&i| is_zero(at, i, resolution.least)) {
            // Where F has no gradient, a direction along which hardly any faces lie.
            let across = at.gradient(i).try_normalize().unwrap_or(Vec3::new(0.36, 0.48, 0.8));
            self.zeros.push(i, points.offset(i), across * (ACROSS * resolution.unit));
        }
        let nowhere = [Vec3::splat(f32::NEG_INFINITY), Vec3::splat(f32::INFINITY)];
        self.find_ends(evaluator, nowhere);
        let Self { zeros, ends: [before, behind], .. } = self;
        let (mut one_sided, mut inside_of) = ([false; BATCH], [false; BATCH]);
        for lane in 0..zeros.points.len {
            let sides =
                [is_inside(before[lane], behind[lane], resolution), is_inside(behind[lane], before[lane], resolution)];
            one_sided[lane] = sides[0].is_none() || sides[1].is_none() || sides[0] == sides[1];
            inside_of[usize::from(zeros.of[lane])] = sides[0].or(sides[1]).unwrap_or(true);
        }
        zeros.keep(|lane| one_sided[lane]);
        let crossed = self.crossed(evaluator, resolution, nowhere, |place| inside_of[place]);
        for lane in 0..self.zeros.points.len {
            let place = usize::from(self.zeros.of[lane]);
            if !crossed[lane] {
                let size = at.value[place].abs().max(f32::MIN_POSITIVE);
                at.value[place] = if inside_of[place] { size } else { -size };
            }
        }
    }

    /// F a step before and behind each zero.
    fn find_ends(&mut self, evaluator: &mut dyn Evaluator, bounds: [Vec3; 2]) {
        for (ends, share) in self.ends.iter_mut().zip([-1.0, 1.0]) {
            self.zeros.stepped(|_| share, bounds, &mut self.probes);
            evaluator.values(&self.probes, ends);
        }
    }

    /// Whether F is uneven beside any of the zeros.
    pub(super) fn any_uneven(
        &mut self,
        evaluator: &mut dyn Evaluator,
        resolution: Resolution,
        bounds: [Vec3; 2],
    ) -> bool {
        self.find_ends(evaluator, bounds);
        let [before, behind] = &self.ends;
        (0..self.zeros.points.len).any(|lane| is_uneven(before[lane], behind[lane], resolution))
    }

    /// The zeros at which the surface is crossed, coming from the inside where `inside` says so of a zero's number: F is of
    /// the other sign a step behind, or, on a sheet or beside a gap, at least somewhere between there and a step before.
    pub(super) fn crossed(
        &mut self,
        evaluator: &mut dyn Evaluator,
        resolution: Resolution,
        bounds: [Vec3; 2],
        inside: impl Fn(usize) -> bool,
    ) -> [bool; BATCH] {
        let mut crossed = [false; BATCH];
        if self.zeros.points.len == 0 {
            return crossed;
        }
        self.find_ends(evaluator, bounds);
        let Self { zeros, probes, ends, values: [low, high], ranges } = self;
        let len = zeros.points.len;
        let sign = |lane: usize| if inside(usize::from(zeros.of[lane])) { 1.0 } else { -1.0 };
        let inner = |range: &[f32; 2], share: f32| range[0] + share * (range[1] - range[0]);
        ranges[..len].fill([-1.0, 1.0]);
        zeros.stepped(|lane| inner(&ranges[lane], 1.0 - SECTION), bounds, probes);
        evaluator.values(probes, low);
        zeros.stepped(|lane| inner(&ranges[lane], SECTION), bounds, probes);
        evaluator.values(probes, high);
        // Of walls and skins F is two lines that meet at zero: hardly ever is there more to find.
        let share = resolution.share();
        let any = (0..len).any(|lane| {
            let [before, behind, low, high] =
                [ends[0][lane], ends[1][lane], low[lane], high[lane]].map(|value| value * sign(lane));
            low.min(high).min(meeting([before, low, high, behind])) < -0.5 * share * before.abs().max(behind.abs())
        });
        for _ in 0..if any { NARROWINGS } else { 0 } {
            // The least of F by the sign of the sides is on that side of one of the two places where it is less.
            let mut lower = [false; BATCH];
            for lane in 0..len {
                let range = &mut ranges[lane];
                lower[lane] = low[lane] * sign(lane) < high[lane] * sign(lane);
                if lower[lane] {
                    (range[1], high[lane]) = (inner(range, SECTION), low[lane]);
                } else {
                    (range[0], low[lane]) = (inner(range, 1.0 - SECTION), high[lane]);
                }
            }
            let share = |lane: usize| if lower[lane] { 1.0 - SECTION } else { SECTION };
            zeros.stepped(|lane| inner(&ranges[lane], share(lane)), bounds, probes);
            let mut new = [0.0; BATCH];
            evaluator.values(probes, &mut new);
            for lane in 0..len {
                *(if lower[lane] { &mut low[lane] } else { &mut high[lane] }) = new[lane];
            }
        }
        for lane in 0..len {
            let least = (low[lane] * sign(lane)).min(high[lane] * sign(lane));
            let (before, behind, side) = (ends[0][lane], ends[1][lane], Some(sign(lane) > 0.0));
            let leaves = is_inside(behind, before, resolution).is_some_and(|inside| Some(inside) != side);
            let comes = is_inside(before, behind, resolution).is_none_or(|inside| Some(inside) == side);
            crossed[lane] = comes && (leaves || least < -resolution.share() * before.abs().max(behind.abs()));
        }
        crossed
    }
}

impl Default for Sides {
    fn default() -> Self {
        Self::new()
    }
}

/// Where two lines meet: one through the first two of four values along a search, one through the last two; the lesser of
/// the inner ones where they do not meet between these.
fn meeting([before, low, high, behind]: [f32; 4]) -> f32 {
    // The ends are at ∓1, the inner places at ∓INNER.
    const INNER: f32 = 2.0 * SECTION - 1.0;
    let (falls, rises) = ((low - before) / (1.0 - INNER), (behind - high) / (1.0 - INNER));
    // low + falls·(t + INNER) = high + rises·(t − INNER)
    let at = (high - low - INNER * (falls + rises)) / (falls - rises);
    if at.abs() <= INNER { low + falls * (at + INNER) } else { low.min(high) }
}

/// Whether F is zero at a point but for rounding, by its slope there.
#[inline(always)]
fn is_zero(at: &Gradients, i: usize, least: f32) -> bool {
    let square = at.dx[i] * at.dx[i] + at.dy[i] * at.dy[i] + at.dz[i] * at.dz[i];
    at.value[i] * at.value[i] <= least * least * square
}

/// Whether F is zero at any of the first points. The usual answer is no, and a plain loop finds that out fast.
#[multiversion::multiversion(targets = "simd")]
fn any_zero(at: &Gradients, len: usize, least: f32) -> bool {
    let mut any = 0;
    for i in 0..super::kernel::whole_passes(len) {
        any |= u32::from(is_zero(at, i, least)) & u32::from(i < len);
    }
    any != 0
}

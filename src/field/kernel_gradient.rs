//! The batch loops for values and gradients together: forward mode over the same tapes.

use multiversion::multiversion;

use super::kernel::{Run, pass};
use super::lane_math as math;
use super::op::{Binary, Unary};
use super::tape::{Code, LaneQuadric, QuadricShape};
use super::width::VectorWidth;
use super::{BATCH, Gradients};

/// Points in one pass over a tape. Fewer: more time goes to fetching instructions; more: the registers, four times as
/// large as those of values, leave the nearest cache.
const LANES: usize = 64;

/// Up to this many points take one short pass: the few left in a search for feet.
const FEW: usize = WIDE;

/// Lanes that an instruction works on together: its derivatives by its arguments stay in vector registers meanwhile.
const WIDE: usize = 16;

/// One number for each lane.
type Lanes = [[f32; WIDE]; LANES / WIDE];

/// One register: value and three derivatives for each lane.
#[derive(Clone)]
#[repr(align(64))]
pub(super) struct Dual {
    pub value: Lanes,
    pub slope: [Lanes; 3],
}

impl Dual {
    const NONE: Lanes = [[0.0; WIDE]; LANES / WIDE];
    pub const ZERO: Self = Self { value: Self::NONE, slope: [Self::NONE; 3] };
}

/// Writes value and gradient of each output of the tape at the points.
pub(super) fn run(width: VectorWidth, run: &Run, registers: &mut Vec<Dual>, outs: &mut [&mut Gradients]) {
    if registers.len() < run.tape.registers {
        registers.resize(run.tape.registers, Dual::ZERO);
    }
    match width {
        VectorWidth::Sse2 => either(run, registers, outs),
        VectorWidth::Avx2 => run_avx2(run, registers, outs),
        VectorWidth::Avx512 => run_avx512(run, registers, outs),
    }
}

/// In passes of all lanes, or of few where there are few points.
#[inline(always)]
fn either(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    if run.points.len <= FEW { body::<FEW>(run, registers, outs) } else { body::<LANES>(run, registers, outs) }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn run_avx2(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    either(run, registers, outs);
}

#[multiversion(targets("x86_64+avx+avx2+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx+avx2"))]
fn run_avx512(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    either(run, registers, outs);
}

/// `out = f(a)` with `(value, derivative by a)` on every lane.
///
/// Lanes are taken in wholes of fixed length into arrays of their own: loops over all arrays at once have more pairs
/// that might overlap than compilers check, and stay scalar. Plain indices, because what is not inlined into a function
/// as large as this is compiled for the narrowest vectors.
macro_rules! each {
    ($registers:ident, $at:ident, $a:ident => $pair:expr) => {{
        let [out, a] = $registers
            .get_disjoint_mut([$at.out as usize, $at.a as usize])
            .expect("an output never shares its argument's register");
        for whole in 0..N / WIDE {
            let (mut value, mut along_a) = ([0.0; WIDE], [0.0; WIDE]);
            for i in 0..WIDE {
                let $a = a.value[whole][i];
                (value[i], along_a[i]) = $pair;
            }
            out.value[whole] = value;
            for axis in 0..3 {
                let mut slope = [0.0; WIDE];
                for i in 0..WIDE {
                    slope[i] = along_a[i] * a.slope[axis][whole][i];
                }
                out.slope[axis][whole] = slope;
            }
        }
    }};
}

/// `out = f(a, b)` with `(value, derivative by a, by b)` on every lane; the arguments may be one register.
macro_rules! both {
    ($registers:ident, $at:ident, $a:ident, $b:ident => $triple:expr) => {{
        if $at.a == $at.b {
            each!($registers, $at, $a => {
                let $b = $a;
                let (value, by_a, by_b) = $triple;
                (value, by_a + by_b)
            })
        } else {
            let [out, a, b] = $registers
                .get_disjoint_mut([$at.out as usize, $at.a as usize, $at.b as usize])
                .expect("an output never shares its argument's register");
            for whole in 0..N / WIDE {
                let (mut value, mut along_a, mut along_b) = ([0.0; WIDE], [0.0; WIDE], [0.0; WIDE]);
                for i in 0..WIDE {
                    let ($a, $b) = (a.value[whole][i], b.value[whole][i]);
                    (value[i], along_a[i], along_b[i]) = $triple;
                }
                out.value[whole] = value;
                for axis in 0..3 {
                    let mut slope = [0.0; WIDE];
                    for i in 0..WIDE {
                        slope[i] = flushed(along_a[i] * a.slope[axis][whole][i] + along_b[i] * b.slope[axis][whole][i]);
                    }
                    out.slope[axis][whole] = slope;
                }
            }
        }
    }};
}

#[inline(always)]
fn body<const N: usize>(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    for first in (0..run.points.len).step_by(N) {
        let position = [pass(&run.points.x, first), pass(&run.points.y, first), pass(&run.points.z, first)];
        for at in &run.tape.code {
            match at.code {
                Code::Affine(row) => {
                    affine::<N>(run.tape.rows[row as usize], position, &mut registers[at.out as usize])
                }
                Code::Quadric(index) => {
                    quadric::<N>(&run.tape.quadrics[index as usize], position, &mut registers[at.out as usize]);
                }
                Code::Input(leaf) => {
                    let (from, to) = (&run.inputs[leaf as usize], &mut registers[at.out as usize]);
                    to.value.as_flattened_mut()[..N].copy_from_slice(pass::<N>(&from.value, first));
                    for (to, from) in to.slope.iter_mut().zip([&from.dx, &from.dy, &from.dz]) {
                        to.as_flattened_mut()[..N].copy_from_slice(pass::<N>(from, first));
                    }
                }
                Code::Linear(scale, offset) => each!(registers, at, a => (a * scale + offset, scale)),
                Code::Unary(operation) => match operation {
                    // Compiled to `Code::Linear`.
                    Unary::Linear { .. } => {}
                    Unary::Abs => each!(registers, at, a => (a.abs(), if a < 0.0 { -1.0 } else { 1.0 })),
                    Unary::Square => each!(registers, at, a => (a * a, 2.0 * a)),
                    Unary::Sqrt => each!(registers, at, a => {
                        let root = a.sqrt();
                        let slope = 0.5 / root;
                        (root, if root > 0.0 { slope } else { 0.0 })
                    }),
                    Unary::Cbrt => each!(registers, at, a => {
                        let root = math::cbrt(a);
                        let slope = 1.0 / (3.0 * root * root);
                        (root, if root != 0.0 { slope } else { 0.0 })
                    }),
                    Unary::Recip => each!(registers, at, a => {
                        let inverse = 1.0 / a;
                        (inverse, -(inverse * inverse))
                    }),
                    Unary::Powi(exponent) => each!(registers, at, a => {
                        let below = math::powi(a, exponent - 1);
                        (math::powi(a, exponent), exponent as f32 * below)
                    }),
                    Unary::Sin => each!(registers, at, a => (math::sin(a), math::cos(a))),
                    Unary::Cos => each!(registers, at, a => (math::cos(a), -math::sin(a))),
                    Unary::Exp => each!(registers, at, a => {
                        let value = math::exp(a);
                        (value, value)
                    }),
                    Unary::Log => each!(registers, at, a => (math::log(a), 1.0 / a)),
                    Unary::Floor => each!(registers, at, a => (a.floor(), 0.0)),
                    Unary::Sign => each!(registers, at, a => (math::sign(a), 0.0)),
                    Unary::Smooth => each!(registers, at, a => {
                        let clamped = math::clamp01(a);
                        (math::smooth(a), 6.0 * clamped * (1.0 - clamped))
                    }),
                },
                Code::Binary(operation) => match operation {
                    Binary::Add => both!(registers, at, a, b => (a + b, 1.0, 1.0)),
                    Binary::Sub => both!(registers, at, a, b => (a - b, 1.0, -1.0)),
                    Binary::Mul => both!(registers, at, a, b => (a * b, b, a)),
                    Binary::Div => both!(registers, at, a, b => {
                        let inverse = 1.0 / b;
                        let value = a / b;
                        (value, inverse, -(value * inverse))
                    }),
                    Binary::Min => both!(registers, at, a, b => {
                        let first = if a < b { 1.0 } else { 0.0 };
                        (if a < b { a } else { b }, first, 1.0 - first)
                    }),
                    Binary::Max => both!(registers, at, a, b => {
                        let first = if a > b { 1.0 } else { 0.0 };
                        (if a > b { a } else { b }, first, 1.0 - first)
                    }),
                    Binary::Union => both!(registers, at, a, b => math::r0_union_with_slopes(a, b)),
                    Binary::Intersection => both!(registers, at, a, b => {
                        let (value, by_a, by_b) = math::r0_union_with_slopes(-a, -b);
                        (-value, by_a, by_b)
                    }),
                    Binary::Corner => both!(registers, at, a, b => {
                        let (by_a, by_b) = corner_slopes(a, b);
                        (math::corner(a, b), by_a, by_b)
                    }),
                    Binary::Displacement => both!(registers, at, a, b => {
                        let (by_a, by_b) = displacement_slopes(a, b);
                        (math::displacement(a, b), by_a, by_b)
                    }),
                    Binary::Pow => both!(registers, at, a, b => {
                        let value = math::pow(a, b);
                        let (by_a, by_b) = (value * b / a, value * math::log(a));
                        (value, if a > 0.0 { by_a } else { 0.0 }, if a > 0.0 { by_b } else { 0.0 })
                    }),
                    Binary::Atan2 => both!(registers, at, a, b => {
                        let square = a * a + b * b;
                        (math::atan2(a, b), b / square, -a / square)
                    }),
                },
            }
        }
        for (out, &register) in outs.iter_mut().zip(&run.tape.outputs) {
            let (from, lanes) = (&registers[register as usize], first..first + N);
            copy(&mut out.value[lanes.clone()], &from.value);
            copy(&mut out.dx[lanes.clone()], &from.slope[0]);
            copy(&mut out.dy[lanes.clone()], &from.slope[1]);
            copy(&mut out.dz[lanes], &from.slope[2]);
        }
    }
}

/// A derivative, or zero where it is too small to matter: the weights of R₀ operands far from the surface multiply
/// to numbers below the normal range, which many processors compute slowly.
#[inline(always)]
fn flushed(derivative: f32) -> f32 {
    if derivative.abs() < 1e-18 { 0.0 } else { derivative }
}

#[inline(always)]
fn copy(to: &mut [f32], from: &Lanes) {
    to.copy_from_slice(&from.as_flattened()[..to.len()]);
}

#[inline(always)]
fn corner_slopes(a: f32, b: f32) -> (f32, f32) {
    let (first, second) = (if a < 0.0 { -a } else { 0.0 }, if b < 0.0 { -b } else { 0.0 });
    let inverse = 1.0 / (first * first + second * second).sqrt();
    let lesser = if a < b { 1.0 } else { 0.0 };
    let outside = (first > 0.0 || second > 0.0) && inverse < f32::INFINITY;
    (if outside { first * inverse } else { lesser }, if outside { second * inverse } else { 1.0 - lesser })
}

/// disp = u³/(2 − u) with u = r₂²/(r₁² + r₂²).
#[inline(always)]
fn displacement_slopes(first: f32, second: f32) -> (f32, f32) {
    let sum = first + second;
    let share = second / sum;
    let rest = 2.0 - share;
    let by_share = share * share * (6.0 - 2.0 * share) / (rest * rest);
    let (by_first, by_second) = (-by_share * share / sum, by_share * (1.0 - share) / sum);
    let within = second > 0.0;
    (if within { by_first } else { 0.0 }, if within { by_second } else { 0.0 })
}

#[inline(always)]
fn affine<const N: usize>([a, b, c, d]: [f32; 4], [x, y, z]: [&[f32; N]; 3], out: &mut Dual) {
    let value = out.value.as_flattened_mut();
    for i in 0..N {
        value[i] = a * x[i] + b * y[i] + c * z[i] + d;
    }
    for (slope, along) in out.slope.iter_mut().zip([a, b, c]) {
        slope.as_flattened_mut()[..N].fill(along);
    }
}

#[inline(always)]
fn quadric<const N: usize>(quadric: &LaneQuadric, position: [&[f32; N]; 3], out: &mut Dual) {
    match quadric.shape {
        QuadricShape::Ball | QuadricShape::Aligned => aligned_quadric(quadric, position, out),
        QuadricShape::General => general_quadric(quadric, position, out),
    }
}

/// Bit for bit the general one with zeros left out.
#[inline(always)]
fn aligned_quadric<const N: usize>(quadric: &LaneQuadric, [x, y, z]: [&[f32; N]; 3], out: &mut Dual) {
    let ([p, q, r], constant, sign) = (quadric.rows, quadric.constant, quadric.signs[0]);
    let steep = [2.0 * sign * p[0], 2.0 * sign * q[1], 2.0 * sign * r[2]];
    for at in 0..N / WIDE {
        let (mut value, mut slope) = ([0.0; WIDE], [[0.0; WIDE]; 3]);
        for i in 0..WIDE {
            let (x, y, z) = (x[WIDE * at + i], y[WIDE * at + i], z[WIDE * at + i]);
            let (u, v, w) = (p[0] * x + p[3], q[1] * y + q[3], r[2] * z + r[3]);
            value[i] = constant + sign * (u * u + v * v + w * w);
            (slope[0][i], slope[1][i], slope[2][i]) = (steep[0] * u, steep[1] * v, steep[2] * w);
        }
        out.value[at] = value;
        for axis in 0..3 {
            out.slope[axis][at] = slope[axis];
        }
    }
}

#[inline(always)]
fn general_quadric<const N: usize>(quadric: &LaneQuadric, [x, y, z]: [&[f32; N]; 3], out: &mut Dual) {
    let ([p, q, r], constant, [s, t, m]) = (quadric.rows, quadric.constant, quadric.signs);
    for at in 0..N / WIDE {
        let (mut value, mut slope) = ([0.0; WIDE], [[0.0; WIDE]; 3]);
        for i in 0..WIDE {
            let (x, y, z) = (x[WIDE * at + i], y[WIDE * at + i], z[WIDE * at + i]);
            let u = p[0] * x + p[1] * y + p[2] * z + p[3];
            let v = q[0] * x + q[1] * y + q[2] * z + q[3];
            let w = r[0] * x + r[1] * y + r[2] * z + r[3];
            value[i] = constant + (s * (u * u) + t * (v * v) + m * (w * w));
            let (u, v, w) = (2.0 * s * u, 2.0 * t * v, 2.0 * m * w);
            for axis in 0..3 {
                slope[axis][i] = u * p[axis] + v * q[axis] + w * r[axis];
            }
        }
        out.value[at] = value;
        for axis in 0..3 {
            out.slope[axis][at] = slope[axis];
        }
    }
}

/// Lanes of a batch past the last whole pass do not exist.
const _: () = assert!(BATCH.is_multiple_of(LANES) && LANES.is_multiple_of(WIDE));

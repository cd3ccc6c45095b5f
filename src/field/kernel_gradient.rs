//! The batch loops for values and gradients together: forward mode over the same tapes.

use multiversion::multiversion;
use multiversion::target::match_target;

use super::kernel::{Run, pass};
use super::op::{Operation, Visitor, choose};
use super::tape::{Code, Instruction, LaneQuadric, QuadricShape};
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
        VectorWidth::Sse2 => run_sse2(run, registers, outs),
        VectorWidth::Avx2 => run_avx2(run, registers, outs),
        VectorWidth::Avx512 => run_avx512(run, registers, outs),
    }
}

/// In passes of all lanes, or of few where there are few points.
#[inline(always)]
fn either(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    if run.points.len <= FEW { body::<FEW>(run, registers, outs) } else { body::<LANES>(run, registers, outs) }
}

/// Short of what it is compiled for each of these hands on to the next narrower one, so that none is compiled twice.
#[multiversion(targets("x86_64+avx+avx2+avx512f+avx512bw+avx512dq+avx512vl"))]
fn run_avx512(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    match_target! {
        "x86_64+avx+avx2+avx512f+avx512bw+avx512dq+avx512vl" => either(run, registers, outs),
        _ => run_avx2(run, registers, outs),
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn run_avx2(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    match_target! {
        "x86_64+avx+avx2" => either(run, registers, outs),
        _ => run_sse2(run, registers, outs),
    }
}

#[inline(never)]
fn run_sse2(run: &Run, registers: &mut [Dual], outs: &mut [&mut Gradients]) {
    either(run, registers, outs);
}

/// An instruction on every lane of the registers.
///
/// Lanes are taken in wholes of fixed length into arrays of their own: loops over all arrays at once have more pairs
/// that might overlap than compilers check, and stay scalar. Plain indices, because what is not inlined into a function
/// as large as this is compiled for the narrowest vectors.
struct OnLanes<'a, const N: usize> {
    registers: &'a mut [Dual],
    at: &'a Instruction,
}

impl<const N: usize> OnLanes<'_, N> {
    /// Of one argument, by its lanes' value and derivative.
    #[inline(always)]
    fn each(self, slopes: impl LaneSlopes) {
        let Self { registers, at } = self;
        let [out, a] = registers
            .get_disjoint_mut([at.out as usize, at.a as usize])
            .expect("an output never shares its argument's register");
        for whole in 0..N / WIDE {
            let (mut value, mut along_a) = ([0.0; WIDE], [0.0; WIDE]);
            for i in 0..WIDE {
                (value[i], along_a[i]) = slopes.of(a.value[whole][i]);
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
    }
}

/// Value and derivative by one argument.
trait LaneSlopes {
    fn of(&self, a: f32) -> (f32, f32);
}

struct OfOne<O>(O);

impl<O: Operation<1>> LaneSlopes for OfOne<O> {
    #[inline(always)]
    fn of(&self, a: f32) -> (f32, f32) {
        let (value, [by_a]) = self.0.slopes([a]);
        (value, by_a)
    }
}

/// An operation on one value twice.
struct OfTwice<O>(O);

impl<O: Operation<2>> LaneSlopes for OfTwice<O> {
    #[inline(always)]
    fn of(&self, a: f32) -> (f32, f32) {
        let (value, [by_a, by_b]) = self.0.slopes([a, a]);
        (value, by_a + by_b)
    }
}

impl<const N: usize> Visitor<1> for OnLanes<'_, N> {
    #[inline(always)]
    fn visit(self, operation: impl Operation<1>) {
        self.each(OfOne(operation));
    }
}

/// The arguments may be one register.
impl<const N: usize> Visitor<2> for OnLanes<'_, N> {
    #[inline(always)]
    fn visit(self, operation: impl Operation<2>) {
        if self.at.a == self.at.b {
            return self.each(OfTwice(operation));
        }
        let Self { registers, at } = self;
        let [out, a, b] = registers
            .get_disjoint_mut([at.out as usize, at.a as usize, at.b as usize])
            .expect("an output never shares its argument's register");
        for whole in 0..N / WIDE {
            let (mut value, mut along_a, mut along_b) = ([0.0; WIDE], [0.0; WIDE], [0.0; WIDE]);
            for i in 0..WIDE {
                (value[i], [along_a[i], along_b[i]]) = operation.slopes([a.value[whole][i], b.value[whole][i]]);
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
                Code::Unary(operation) => operation.visit(OnLanes::<N> { registers, at }),
                Code::Binary(operation) => operation.visit(OnLanes::<N> { registers, at }),
                Code::Choose => chosen::<N>(registers, at),
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

/// Arguments may share a register: their lanes are taken out first. The derivatives are those of the chosen value, not
/// mixed by weights of 0: the other one's may be infinite.
#[inline(always)]
fn chosen<const N: usize>(registers: &mut [Dual], at: &Instruction) {
    let [first, second, third] = [at.a, at.b, at.c].map(|place| place as usize);
    for whole in 0..N / WIDE {
        let condition = registers[first].value[whole];
        let (then, other) = (registers[second].value[whole], registers[third].value[whole]);
        for i in 0..WIDE {
            registers[at.out as usize].value[whole][i] = choose::lane([condition[i], then[i], other[i]]);
        }
        for axis in 0..3 {
            let (then, other) = (registers[second].slope[axis][whole], registers[third].slope[axis][whole]);
            for i in 0..WIDE {
                registers[at.out as usize].slope[axis][whole][i] = choose::lane([condition[i], then[i], other[i]]);
            }
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

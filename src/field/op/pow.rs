//! A power of a base that is not negative; not a number otherwise.

use super::*;

impl Operation<2> for Pow {
    const FUNCTIONS: &'static [Function] = &[function(
        "pow",
        2,
        "pow(x, y)",
        "x to the power of y, the same as `x^y`; of a negative x not a number, unless y is written as a whole number",
        |graph, a| graph.binary(Binary::Pow, a[0], a[1]),
    )];

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        libm::pow(a, b)
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let value = math::pow(a, b);
        let (by_a, by_b) = (value * b / a, value * math::log(a));
        (value, [if a > 0.0 { by_a } else { 0.0 }, if a > 0.0 { by_b } else { 0.0 }])
    }

    /// Everything where it may be undefined.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        let positive = a.lo > 0.0 || (a.lo == 0.0 && b.lo > 0.0);
        if positive { Unary::Exp.bounds([Unary::Log.bounds([a]) * b]) } else { Interval::ALL }
    }

    fn simplified(self, graph: &mut Graph, [a, b]: [Node; 2]) -> Option<Node> {
        match (graph.as_constant(a), graph.as_constant(b)) {
            (_, Some(exponent)) => constant_power(graph, a, exponent),
            (Some(base), _) if base > 0.0 => {
                let power = graph.linear(b, libm::log(base), 0.0);
                Some(graph.unary(Unary::Exp, power))
            }
            _ => None,
        }
    }
}

/// A power whose exponent is whole, or one half, by multiplication and roots.
fn constant_power(graph: &mut Graph, base: Node, exponent: f64) -> Option<Node> {
    if exponent == 0.5 {
        return Some(graph.sqrt(base));
    }
    if exponent.fract() != 0.0 || exponent.abs() > 64.0 {
        return None;
    }
    let power = match exponent.abs() as u32 {
        0 => return Some(graph.constant(1.0)),
        1 => base,
        2 => graph.square(base),
        exponent => graph.unary(Unary::Powi { exponent }, base),
    };
    Some(if exponent < 0.0 { graph.unary(Unary::Recip, power) } else { power })
}

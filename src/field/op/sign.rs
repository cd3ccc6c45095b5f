//! 1, −1, or 0 at zero.

use super::*;

impl Operation<1> for Sign {
    const NATURE: Nature = Nature { jumps: true, shortens: true, ..Nature::PLAIN };
    const FUNCTIONS: &'static [Function] =
        &[function("sign", 1, "sign(x)", "−1, 0 or 1; jumps", |graph, a| graph.unary(Unary::Sign, a[0]))];

    fn value(self, [a]: [f64; 1]) -> f64 {
        if a > 0.0 {
            1.0
        } else if a < 0.0 {
            -1.0
        } else {
            0.0
        }
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        let magnitude = if a == 0.0 { 0.0 } else { 1.0 };
        (if a < 0.0 { -magnitude } else { magnitude }, [0.0])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        Interval::new(self.value([a.lo]), self.value([a.hi]))
    }
}

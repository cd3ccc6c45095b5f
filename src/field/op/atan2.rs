//! The angle of (x, y) from (y, x), in −π..π.

use super::*;

impl Operation<2> for Atan2 {
    const NATURE: Nature = Nature { jumps: true, shortens: true, ..Nature::PLAIN };
    const FUNCTIONS: &'static [Function] = &[
        function("atan", 1, "atan(x)", "the angle whose tangent is x, radians, from −π/2 to π/2", |graph, a| {
            let one = graph.constant(1.0);
            graph.binary(Binary::Atan2, a[0], one)
        }),
        function(
            "atan2",
            2,
            "atan2(y, x)",
            "the angle of the direction (x, y) from the x axis, radians, from −π to π; 0 where both are 0",
            |graph, a| graph.binary(Binary::Atan2, a[0], a[1]),
        ),
    ];

    fn value(self, [y, x]: [f64; 2]) -> f64 {
        libm::atan2(y, x)
    }

    #[inline(always)]
    fn slopes(self, [y, x]: [f32; 2]) -> (f32, [f32; 2]) {
        let square = y * y + x * x;
        (math::atan2(y, x), [x / square, -y / square])
    }

    fn bounds(self, [y, x]: [Interval; 2]) -> Interval {
        use std::f64::consts::PI;
        if x.lo <= 0.0 && y.contains(0.0) {
            return Interval::widened(-PI, PI);
        }
        // Away from the cut the angle over a box is extreme at corners.
        let ends = [(y.lo, x.lo), (y.lo, x.hi), (y.hi, x.lo), (y.hi, x.hi)].map(|(y, x)| libm::atan2(y, x));
        Interval::widened(ends.into_iter().fold(PI, f64::min), ends.into_iter().fold(-PI, f64::max))
    }
}

//! Unions of equal balls among expressions: many copies of one ball are better searched than pruned.

use glam::DVec3;

use super::leaf::Quadric;
use super::op::{Binary, Op, Unary};
use super::program::Program;

/// Equal balls: the union's distance is the radius less the distance from the nearest middle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EqualBalls {
    /// The middles, world units.
    pub middles: Vec<DVec3>,
    /// The radius that all have, world units.
    pub radius: f64,
}

impl EqualBalls {
    /// What a program whose choices are taken first (see `rising`) is made of, where that is `r − √(least square)`.
    pub(super) fn of(program: &Program) -> Option<Self> {
        // All that comes before the root and the difference is what the root is taken of.
        let [chosen @ .., Op::Unary(Unary::Sqrt, _), Op::Unary(Unary::Linear { scale: -1.0, offset: radius }, _)] =
            &program.ops[..]
        else {
            return None;
        };
        let mut middles = Vec::new();
        for op in chosen {
            match *op {
                Op::Binary(Binary::Min, ..) => {}
                Op::Quadric(leaf) => middles.push(middle(&program.quadrics[leaf as usize])?),
                _ => return None,
            }
        }
        Some(Self { middles, radius: *radius })
    }
}

/// Where a quadric is the square of the distance from.
fn middle(quadric: &Quadric) -> Option<DVec3> {
    let mut middle = DVec3::NAN;
    for (weight, form) in &quadric.terms {
        let axis = DVec3::AXES.iter().position(|axis| form.slope == *axis)?;
        if *weight != 1.0 {
            return None;
        }
        middle[axis] = -form.constant;
    }
    (quadric.constant == 0.0 && !middle.is_nan()).then_some(middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Expression, Formula, Graph, Names};

    fn found(text: &str) -> Option<EqualBalls> {
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let root = Formula::parse(text).compile(&mut graph, &names).expect(text);
        Expression::new(&graph, root).for_values_alone().equal_balls()
    }

    #[test]
    fn unions_of_equal_balls_are_told_from_all_else() {
        let ball = |x: &str, radius: f64| format!("({radius} - sqrt((x - {x})^2 + (y + 2)^2 + z^2))");
        let union = |a: String, b: String| format!("max({a}, {b})");
        let three = union(union(ball("1", 0.5), ball("-3", 0.5)), ball("0.25", 0.5));
        let mut balls = found(&three).expect("balls");
        balls.middles.sort_by(|a, b| a.x.total_cmp(&b.x));
        let middles = [-3.0, 0.25, 1.0].map(|x| DVec3::new(x, -2.0, 0.0));
        assert_eq!(balls, EqualBalls { middles: middles.into(), radius: 0.5 });
        for other in [
            union(ball("1", 0.5), ball("2", 0.25)),
            format!("min({}, {})", ball("1", 0.5), ball("2", 0.5)),
            union(ball("1", 0.5), "x".into()),
            "max(1 - sqrt(x^2 + y^2), 1 - sqrt(x^2 + z^2))".into(),
            "max(1 - sqrt(x^2 + y^2 + 2*z^2), 1 - sqrt(x^2 + y^2 + z^2))".into(),
            "max(1 - 2*sqrt(x^2 + y^2 + z^2), 1 - 2*sqrt((x - 3)^2 + y^2 + z^2))".into(),
        ] {
            assert_eq!(found(&other), None, "{other}");
        }
    }
}

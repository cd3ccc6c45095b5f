//! Whether operations of a scene's own do what they declare: by samples, at the numbers of each shape that uses one.

use crate::field::Graph;
use crate::node::applied::{Applied, Promises};
use crate::node::argument::Arguments;
use crate::node::model::Model;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::moment::Moment;

/// Pairs of places that are compared for each shape.
const PAIRS: u32 = 400;
/// Sizes of fields that are looked at: of fine details to that of the largest scenes.
const SIZES: [f64; 6] = [0.01, 0.1, 0.5, 2.0, 10.0, 100.0];
/// What rounding makes of equal values, as a share of them.
const ROUNDING: f64 = 1e-9;

/// An error for each operation that does not do what it declares, with the values of its fields where that was found.
pub(crate) fn broken(model: &Model) -> Vec<Diagnostic> {
    let first = model.shot.range.first as f64;
    let middle = (first + model.shot.range.last as f64) / 2.0;
    let mut found: Vec<Diagnostic> = Vec::new();
    for applied in model.shapes.iter().filter_map(|shape| Arguments::applied(&shape.arguments)) {
        for frame in [first, middle] {
            let problems = [Declared::RisesIn, Declared::Lipschitz]
                .map(|what| counterexample(applied, what, &model.moment(frame)));
            for problem in problems.into_iter().flatten() {
                if found.iter().all(|known| known.span != problem.span) {
                    found.push(problem);
                }
            }
        }
    }
    found
}

#[derive(Clone, Copy, PartialEq)]
enum Declared {
    RisesIn,
    Lipschitz,
}

fn counterexample(applied: &Applied, what: Declared, moment: &Moment) -> Option<Diagnostic> {
    let operation = &applied.operation;
    let Promises { rises_in, lipschitz } = &operation.promises;
    let value = |fields: &[f64]| {
        let mut graph = Graph::new();
        let nodes: Vec<_> = fields.iter().map(|field| graph.constant(*field)).collect();
        let node = applied.node(&mut graph, &nodes, moment).ok()?;
        graph.as_constant(node).filter(|value| value.is_finite())
    };
    let shown = |fields: &[f64]| {
        let each = operation.fields.iter().zip(fields).map(|(name, field)| format!("{name} = {field:.4}"));
        each.collect::<Vec<_>>().join(", ")
    };
    let mut random = Random(1);
    for pair in 0..PAIRS {
        let size = SIZES[pair as usize % SIZES.len()];
        let here: Vec<f64> = operation.fields.iter().map(|_| size * random.next()).collect();
        match (what, rises_in, lipschitz) {
            (Declared::RisesIn, Some((rising, span)), _) => {
                for &field in rising {
                    let mut there = here.clone();
                    there[field] += size * random.next().abs();
                    let (Some(lower), Some(upper)) = (value(&here), value(&there)) else { continue };
                    if upper < lower - ROUNDING * (lower.abs() + upper.abs()) {
                        let name = clip(&operation.fields[field]).into_owned();
                        let problem = format!("F of `{}` falls while `{name}` rises", clip(&operation.name));
                        let help = format!(
                            "it is {lower:.4} at {}, and {upper:.4} at {name} = {:.4}: leave `{name}` out of `rises_in`",
                            shown(&here),
                            there[field]
                        );
                        return Some(Diagnostic::error(*span, problem).help(help));
                    }
                }
            }
            (Declared::Lipschitz, _, Some((bound, span))) => {
                let step = size * if pair % 2 == 0 { 0.01 } else { 1.0 };
                let there: Vec<f64> = here.iter().map(|field| field + step * random.next()).collect();
                let (Some(first), Some(second)) = (value(&here), value(&there)) else { continue };
                let apart = here.iter().zip(&there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                if (first - second).abs() > bound * apart * (1.0 + 1e-6) + ROUNDING * (first.abs() + second.abs()) {
                    let problem = format!("F of `{}` is steeper than its `lipschitz`", clip(&operation.name));
                    let help = format!(
                        "from {} to {} it changes by {:.4} times the greatest change of a field",
                        shown(&here),
                        shown(&there),
                        (first - second).abs() / apart
                    );
                    return Some(Diagnostic::error(*span, problem).help(help));
                }
            }
            _ => return None,
        }
    }
    None
}

/// Numbers from −1 to 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

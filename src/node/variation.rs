//! What of a scene changes over the shot, and what does not.

use crate::node::argument::{Arguments, ScalarName};
use crate::node::model::{Model, Placement, ShapeId};
use crate::text::number::formula::Formula;
use crate::text::number::{Number, NumberValue};
use crate::text::sequence::FileSequence;

/// Which shapes change over time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variation {
    /// Of each shape as it is made, then after each of its modifiers.
    steps: Vec<Vec<bool>>,
    /// Of each of its modifiers by itself.
    modifiers: Vec<Vec<bool>>,
    placed: Vec<bool>,
    painted: Vec<bool>,
}

impl Variation {
    /// Looks through all shapes.
    pub fn of(model: &Model) -> Self {
        let count = model.shapes.len();
        let mut variation = Self {
            steps: vec![Vec::new(); count],
            modifiers: vec![Vec::new(); count],
            placed: vec![false; count],
            painted: vec![false; count],
        };
        let all: Vec<ShapeId> = (0..count).map(ShapeId).collect();
        for id in model.parts_first(&all) {
            let shape = model.shape(id);
            let mut varies = variation.arguments_vary(model, id, &shape.arguments);
            let mut steps = vec![varies];
            for modifier in &shape.modifiers {
                let alone = variation.arguments_vary(model, id, &modifier.arguments);
                varies |= alone;
                steps.push(varies);
                variation.modifiers[id.0].push(alone);
            }
            variation.steps[id.0] = steps;
            variation.placed[id.0] = varies || model.placement_varies(&model.shape(id).placement);
            variation.painted[id.0] = variation.paint_varies(model, id);
        }
        variation
    }

    /// Whether a shape changes in its own space, before all but so many of its modifiers.
    pub fn step(&self, id: ShapeId, step: usize) -> bool {
        self.steps[id.0][step]
    }

    /// Whether what a step after the first does changes.
    pub fn modifier(&self, id: ShapeId, step: usize) -> bool {
        self.modifiers[id.0][step - 1]
    }

    /// Whether a shape changes in its own space, before scale, rotate and move.
    pub fn own(&self, id: ShapeId) -> bool {
        self.steps[id.0].last().copied().unwrap_or(false)
    }

    /// Whether it changes or moves.
    pub fn placed(&self, id: ShapeId) -> bool {
        self.placed[id.0]
    }

    /// Whether a shape that it is made from changes or moves.
    pub fn parts(&self, model: &Model, id: ShapeId) -> bool {
        model.needs(id).into_iter().any(|part| self.placed(part))
    }

    /// Whether its colour or a scalar of it changes in its own space.
    pub fn painted(&self, id: ShapeId) -> bool {
        self.painted[id.0]
    }

    fn paint_varies(&self, model: &Model, id: ShapeId) -> bool {
        let shape = model.shape(id);
        // Parts that move change the shape itself.
        model.needs(id).into_iter().any(|part| self.painted[part.0])
            || (shape.is_conformal() && self.own(id))
            || shape.given_arguments().any(|arguments| self.source_varies(model, id, arguments))
    }

    fn source_varies(&self, model: &Model, id: ShapeId, arguments: &Arguments) -> bool {
        arguments.numbers().any(|number| model.varies(number))
            || arguments.sequence().is_some_and(FileSequence::varies)
            || arguments.formulas().any(|formula| model.formula_varies(formula))
            || arguments.all_shapes().any(|part| self.placed[part.0] || self.painted[part.0])
            || model.read_by(id, arguments).any(|part| self.placed[part.0])
            || arguments.formulas().flat_map(Formula::given).any(|name| self.given_varies(model, id, name))
    }

    /// Whether an attribute that a formula names changes, the shape aside.
    fn given_varies(&self, model: &Model, id: ShapeId, name: &str) -> bool {
        let given = model.shape(id).scalars.get(name);
        given.is_some_and(|given| self.source_varies(model, id, &given.arguments))
    }

    /// Whether what a shape's node is made from changes.
    fn arguments_vary(&self, model: &Model, id: ShapeId, arguments: &Arguments) -> bool {
        let scalar_varies = |by: &ScalarName| match model.shape(id).scalars.get(&by.name) {
            Some(given) => self.source_varies(model, id, &given.arguments),
            None => model.needs(id).into_iter().any(|part| self.painted[part.0]),
        };
        arguments.numbers().any(|number| model.varies(number))
            || arguments.sequence().is_some_and(FileSequence::varies)
            || arguments.formulas().any(|formula| model.formula_varies(formula))
            || model.shapes_of(arguments).any(|part| self.placed[part.0])
            || model.read_by(id, arguments).any(|part| self.placed[part.0])
            || arguments.scalars().any(scalar_varies)
    }
}

impl Model {
    /// Whether what a placement is of moves over the shot.
    pub fn placement_varies(&self, placement: &Placement) -> bool {
        let Placement { scale, rotate, translate } = placement;
        [scale, rotate, translate].into_iter().flatten().any(|number| self.varies(number))
    }

    /// The shapes that a shape is made from, directly.
    pub fn needs(&self, id: ShapeId) -> Vec<ShapeId> {
        let shape = self.shape(id);
        let named = shape.all_arguments().flat_map(|arguments| self.shapes_of(arguments));
        named.chain(shape.reads.values().copied()).collect()
    }

    /// The shapes whose distances formulas among some arguments of a shape read.
    fn read_by<'m>(&'m self, id: ShapeId, arguments: &'m Arguments) -> impl Iterator<Item = ShapeId> + 'm {
        let names = arguments.formulas().flat_map(Formula::distances);
        names.filter_map(move |(_, name)| self.shape(id).reads.get(name).copied())
    }

    /// The shapes that arguments name, and those that their cells stand around.
    fn shapes_of<'m>(&'m self, arguments: &'m Arguments) -> impl Iterator<Item = ShapeId> + 'm {
        arguments.all_shapes().chain(arguments.all_cells().map(|cells| self.cells[cells.0].around))
    }

    /// The shapes whose colours and scalars a shape takes without being made from them.
    fn painted_by(&self, id: ShapeId) -> Vec<ShapeId> {
        self.shape(id).given_arguments().flat_map(Arguments::all_shapes).collect()
    }

    /// Some shapes and all that they are made from or painted by, each once, in the order of the scene.
    pub fn with_parts(&self, shapes: &[ShapeId]) -> Vec<ShapeId> {
        let mut found = self.parts_first(shapes);
        found.sort();
        found
    }

    /// The same, each after all that it is made from or painted by. Without recursion and each once, however many share it.
    fn parts_first(&self, shapes: &[ShapeId]) -> Vec<ShapeId> {
        let mut order = Vec::new();
        let mut seen = vec![false; self.shapes.len()];
        // A shape is entered with its parts above it, and left when it is met again below them.
        let mut open: Vec<(ShapeId, bool)> = shapes.iter().rev().map(|id| (*id, false)).collect();
        while let Some((id, entered)) = open.pop() {
            if entered {
                order.push(id);
            } else if !std::mem::replace(&mut seen[id.0], true) {
                open.push((id, true));
                let parts = self.needs(id).into_iter().chain(self.painted_by(id));
                open.extend(parts.filter(|part| !seen[part.0]).map(|part| (part, false)));
            }
        }
        order
    }

    /// Whether a number changes over the shot.
    pub fn varies(&self, number: &Number) -> bool {
        match &number.value {
            NumberValue::Constant(_) => false,
            NumberValue::Keys(keys) => keys.vary(),
            NumberValue::Formula(formula) => self.formula_varies(formula),
        }
    }

    /// Whether a formula hangs on time, or on a parameter that does.
    pub(crate) fn formula_varies(&self, formula: &Formula) -> bool {
        let is_time = |name: &str| matches!(name, "t" | "frame" | "time");
        formula.names().any(is_time)
            || formula.parameters().any(|place| self.varies(&self.parameters[place].value))
            || formula.numbers().any(|number| self.varies(number))
    }
}

//! What of a scene changes over the shot, and what does not.

use crate::node::model::{AttributeSource, Component, Maker, Model, Modifiers, ShapeId};
use crate::text::formula::Formula;
use crate::text::number::{Number, NumberValue};

/// Which shapes change over time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variation {
    whole: Vec<bool>,
    grown: Vec<bool>,
    bare: Vec<bool>,
    own: Vec<bool>,
    placed: Vec<bool>,
    painted: Vec<bool>,
}

impl Variation {
    /// Looks through all shapes.
    pub fn of(model: &Model) -> Self {
        let count = model.shapes.len();
        let mut variation = Self {
            whole: vec![false; count],
            grown: vec![false; count],
            bare: vec![false; count],
            own: vec![false; count],
            placed: vec![false; count],
            painted: vec![false; count],
        };
        let all: Vec<ShapeId> = (0..count).map(ShapeId).collect();
        for id in model.parts_first(&all) {
            let i = id.0;
            let Modifiers { offset, shell, .. } = &model.shape(id).modifiers;
            variation.whole[i] = variation.whole_varies(model, id);
            variation.grown[i] = variation.whole[i] || model.varies(offset);
            variation.bare[i] = variation.grown[i] || shell.as_ref().is_some_and(|shell| model.varies(shell));
            variation.own[i] = variation.bare[i] || variation.displacement_varies(model, id);
            variation.placed[i] = variation.own[i] || placement_varies(model, id);
            variation.painted[i] = variation.paint_varies(model, id);
        }
        variation
    }

    /// Whether a shape changes in its own space, before `offset`.
    pub fn whole(&self, id: ShapeId) -> bool {
        self.whole[id.0]
    }

    /// Whether a shape changes in its own space, before `shell`.
    pub fn grown(&self, id: ShapeId) -> bool {
        self.grown[id.0]
    }

    /// Whether a shape changes in its own space, before `displace`.
    pub fn bare(&self, id: ShapeId) -> bool {
        self.bare[id.0]
    }

    /// Whether a shape changes in its own space, before scale, rotate and move.
    pub fn own(&self, id: ShapeId) -> bool {
        self.own[id.0]
    }

    /// Whether it changes or moves.
    pub fn placed(&self, id: ShapeId) -> bool {
        self.placed[id.0]
    }

    /// Whether its colour or a scalar of it changes in its own space.
    pub fn painted(&self, id: ShapeId) -> bool {
        self.painted[id.0]
    }

    fn paint_varies(&self, model: &Model, id: ShapeId) -> bool {
        let shape = model.shape(id);
        // Parts that move change the shape itself.
        model.needs(id).into_iter().any(|part| self.painted[part.0])
            || shape.colour.as_ref().is_some_and(|source| self.source_varies(model, source))
            || shape.scalars.values().any(|source| self.source_varies(model, source))
    }

    fn source_varies<const N: usize, K, M>(&self, model: &Model, source: &AttributeSource<N, K, M>) -> bool {
        match source {
            AttributeSource::Formula { components, .. } => components.iter().any(|component| match component {
                Component::Number(number) => model.varies(number),
                Component::Formula(formula) => model.formula_varies(formula),
            }),
            AttributeSource::Parts { shapes, .. } => {
                shapes.iter().any(|part| self.placed[part.0] || self.painted[part.0])
            }
            AttributeSource::Solid(_)
            | AttributeSource::Random { .. }
            | AttributeSource::Bands(_)
            | AttributeSource::Voxels(_) => false,
        }
    }

    fn displacement_varies(&self, model: &Model, id: ShapeId) -> bool {
        let shape = model.shape(id);
        let Some(by) = &shape.modifiers.displace else { return false };
        match shape.scalars.get(&by.name) {
            Some(source) => self.source_varies(model, source),
            None => model.needs(id).into_iter().any(|part| self.painted[part.0]),
        }
    }

    fn whole_varies(&self, model: &Model, id: ShapeId) -> bool {
        let shape = model.shape(id);
        let by_number = numbers(&shape.maker).into_iter().any(|number| model.varies(number));
        let by_formula = matches!(&shape.maker, Maker::Formula { formula, .. } if model.formula_varies(formula));
        by_number || by_formula || model.needs(id).into_iter().any(|other| self.placed[other.0])
    }
}

fn placement_varies(model: &Model, id: ShapeId) -> bool {
    let modifiers = &model.shape(id).modifiers;
    [&modifiers.scale, &modifiers.rotate, &modifiers.translate].into_iter().flatten().any(|number| model.varies(number))
}

/// The numbers of a maker.
fn numbers(maker: &Maker) -> Vec<&Number> {
    match maker {
        Maker::Sphere { radius } => vec![radius],
        Maker::Box { edges } => edges.iter().collect(),
        Maker::Ellipsoid { half_axes } => half_axes.iter().collect(),
        Maker::Cylinder { radius, height: other }
        | Maker::Torus { radius, tube: other }
        | Maker::Capsule { radius, length: other } => [radius].into_iter().chain(other).collect(),
        Maker::HalfSpace { normal, offset } => normal.iter().chain([offset]).collect(),
        Maker::Slab { thickness, normal } => normal.iter().chain([thickness]).collect(),
        Maker::Heart { width } => vec![width],
        Maker::Blend { radius, .. } => vec![radius],
        Maker::Formula { .. }
        | Maker::Mesh { .. }
        | Maker::Union { .. }
        | Maker::Intersection(_)
        | Maker::Difference(_)
        | Maker::Facet { .. } => Vec::new(),
    }
}

impl Model {
    /// The shapes that a shape is made from, directly.
    pub fn needs(&self, id: ShapeId) -> Vec<ShapeId> {
        let shape = self.shape(id);
        let mut needs = match &shape.maker {
            Maker::Union { operands, .. } | Maker::Intersection(operands) | Maker::Difference(operands) => {
                operands.clone()
            }
            Maker::Blend { operands, within, .. } => operands.iter().chain(within).copied().collect(),
            Maker::Facet { of, cells, .. } => vec![*of, self.cells[cells.0].around],
            _ => Vec::new(),
        };
        needs.extend(shape.modifiers.at.iter().map(|copies| self.cells[copies.cells.0].around));
        needs
    }

    /// The shapes whose colours and scalars a shape takes without being made from them.
    fn painted_by(&self, id: ShapeId) -> Vec<ShapeId> {
        let shape = self.shape(id);
        let colour = shape.colour.iter().flat_map(AttributeSource::parts);
        colour.chain(shape.scalars.values().flat_map(AttributeSource::parts)).copied().collect()
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
        let varying = |name: &str| {
            matches!(name, "t" | "frame" | "time")
                || self.parameters.iter().any(|parameter| parameter.name == name && self.varies(&parameter.value))
        };
        formula.names().any(varying)
    }
}

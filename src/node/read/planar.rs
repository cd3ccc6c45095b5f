//! Shapes of the plane among solids: where they may stand, and what becomes of one that is baked by itself.

use super::Building;
use super::links::Node;
use crate::node::argument::{Argument, Arguments};
use crate::node::model::{Content, Shape, ShapeId};
use crate::node::profile;
use crate::node::spec::{Plane, Spec};
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::key::{Absent, Kind};
use crate::text::number::Number;
use crate::text::source::Span;

/// What becomes of a morph between shapes of the plane.
const FLAT_MORPH: &str = "a morph of shapes of the plane is extruded by an eighth of their longest side";

impl Building<'_, '_> {
    /// Which shapes are of the plane: those that are by themselves, and set operations and blends of such.
    fn flat_shapes(&self) -> Vec<bool> {
        let is = |spec: &Spec, plane: Plane| spec.plane == plane;
        let mut flat: Vec<bool> =
            self.shapes.iter().map(|shape| shape.as_ref().is_some_and(|shape| is(shape.spec, Plane::Flat))).collect();
        let joins = |shape: &Shape| {
            matches!(shape.spec.key.kind, Kind::Shapes(_) | Kind::TwoShapes) && is(shape.spec, Plane::Solid)
        };
        // A shape is told after its operands; each round tells one level more.
        loop {
            let mut changed = false;
            for (i, shape) in self.shapes.iter().enumerate() {
                let Some(shape) = shape.as_ref().filter(|shape| joins(shape) && !flat[i]) else { continue };
                let mut operands = shape.arguments.all_shapes().peekable();
                if operands.peek().is_some() && operands.all(|operand| flat[operand.0]) {
                    (flat[i], changed) = (true, true);
                }
            }
            if !changed {
                return flat;
            }
        }
    }

    /// Marks the shapes of the plane, and says which stand where a solid is needed, or the other way round.
    pub(super) fn check_planes(&mut self) {
        let flat = self.flat_shapes();
        for (shape, is_flat) in self.shapes.iter_mut().zip(&flat) {
            shape.iter_mut().for_each(|shape| shape.is_flat = *is_flat);
        }
        for shape in self.shapes.iter().flatten().filter(|shape| shape.is_flat) {
            for (key, span) in idle_along_z(shape) {
                let problem = format!("`{key}` along z does nothing to `{}`, a shape of the plane", clip(&shape.name));
                let help = "leave z out, and do it to the solid that the shape becomes";
                self.reader.say(Diagnostic::warning(span, problem).help(help));
            }
        }
        for link in &self.links {
            let Node::Shape(to) = link.to else { continue };
            let (from, lifts) = match link.from {
                // What reads a shape of the plane says so itself where it cannot.
                Node::Shape(from) if flat[from.0] && !self.is_scattered_on(from, to) => continue,
                Node::Shape(from) => match &self.shapes[from.0] {
                    Some(shape) => (shape.spec.key.name, shape.spec.plane == Plane::Lifts),
                    None => continue,
                },
                Node::Cells(_) => ("octree", false),
                Node::Output => continue,
            };
            let Some(name) = self.shapes[to.0].as_ref().map(|shape| clip(&shape.name).into_owned()) else { continue };
            match (flat[to.0], lifts) {
                (true, false) => {
                    // A shape that it takes colours or distances from says nothing of what makes it.
                    let needs = if self.is_made_of(link.from, to) {
                        format!("`{from}` needs solids")
                    } else {
                        "a solid is needed here".into()
                    };
                    let problem = format!("{needs}, and `{name}` is a shape of the plane");
                    self.reader.say(Diagnostic::error(link.span, problem).help(profile::lift_it()));
                }
                (false, true) if self.is_made_of(link.from, to) => self.reader.say(
                    Diagnostic::error(
                        link.span,
                        format!("`{from}` needs a shape of the plane, and `{name}` is a solid"),
                    )
                    .help("such as `circle`, `rectangle`, `polygon`, or a `union` of them"),
                ),
                _ => {}
            }
        }
    }

    /// Whether copies of a shape are scattered on another one.
    fn is_scattered_on(&self, shape: ShapeId, host: ShapeId) -> bool {
        let modifiers = self.shapes[shape.0].iter().flat_map(|shape| &shape.modifiers);
        modifiers.map(|modifier| modifier.arguments.shape("host")).any(|named| named == Some(&host))
    }

    /// Whether a shape is made of another one. One whose colours it takes, or whose distance it reads, may be a solid.
    fn is_made_of(&self, from: Node, to: ShapeId) -> bool {
        let Node::Shape(from) = from else { return true };
        self.shapes[from.0].as_ref().is_none_or(|shape| shape.arguments.all_shapes().any(|operand| operand == to))
    }

    /// What is baked, with shapes of the plane extruded by themselves.
    pub(super) fn lifted(&mut self, content: Content) -> Content {
        let flat = self.flat_shapes();
        match content {
            Content::Shape(id) => Content::Shape(self.lift(id, &flat)),
            Content::Morph(mut morphs) => {
                let mut shapes = morphs.iter().flat_map(|morph| [morph.from, morph.to]);
                // OpenVDB's morph is one of level sets.
                let in_plane = shapes.all(|id| flat.get(id.0) == Some(&true)) && !morphs[0].mode.spec.by_level_sets;
                let span = morphs[0].span;
                match (in_plane, morphs[0].height) {
                    (true, None) => self.reader.say(
                        Diagnostic::warning(span, FLAT_MORPH)
                            .help(format!("`height` beside says how far; {} make solids to morph", profile::LIFTING)),
                    ),
                    (false, Some(_)) => self.reader.say(
                        Diagnostic::error(
                            span,
                            "`morph.height` is of morphs of shapes of the plane, in all modes but `openvdb`",
                        )
                        .help(format!("leave it out: {} have heights of their own", profile::LIFTING)),
                    ),
                    _ => {}
                }
                for morph in &mut morphs {
                    morph.in_plane = in_plane;
                    if !in_plane {
                        (morph.from, morph.to) = (self.lift(morph.from, &flat), self.lift(morph.to, &flat));
                    }
                }
                Content::Morph(morphs)
            }
        }
    }

    fn lift(&mut self, id: ShapeId, flat: &[bool]) -> ShapeId {
        if !flat.get(id.0).is_some_and(|flat| *flat) {
            return id;
        }
        let spec = profile::extrude();
        let is_made =
            |shape: &Option<Shape>| shape.as_ref().is_some_and(|shape| shape.arguments.shape_of(spec) == Some(id));
        if let Some(made) = (flat.len()..self.shapes.len()).find(|i| is_made(&self.shapes[*i])) {
            return ShapeId(made);
        }
        let Some(shape) = self.shapes[id.0].clone() else { return id };
        let problem =
            format!("`{}` is a shape of the plane: it is extruded by an eighth of its longer side", clip(&shape.name));
        self.reader
            .say(Diagnostic::warning(shape.span, problem).help(format!("{} say what it is to be", profile::LIFTING)));
        let number = |name: &str, value: f64| Number::constant(value, name, shape.span);
        let mut arguments = Arguments(vec![(spec.key.name, Argument::Shape(id))]);
        for key in spec.parameters {
            if let Absent::Number(value) = key.default {
                arguments.0.push((key.name, Argument::Number(number(key.name, value))));
            }
        }
        let placement = crate::node::model::Placement {
            scale: [(); 3].map(|()| number("scale", 1.0)),
            rotate: [(); 3].map(|()| number("rotate", 0.0)),
            translate: [(); 3].map(|()| number("move", 0.0)),
        };
        let lifted = Shape {
            name: shape.name,
            span: shape.span,
            spec,
            arguments,
            modifiers: Vec::new(),
            placement,
            colour: None,
            scalars: Default::default(),
            distance: shape.distance,
            distance_span: shape.distance_span,
            step: shape.step,
            reads: Default::default(),
            is_flat: false,
            lifts: Some(id),
        };
        self.shapes.push(Some(lifted));
        ShapeId(self.shapes.len() - 1)
    }
}

/// What is done to a shape along z alone or as well, of which nothing shows in the plane.
fn idle_along_z(shape: &Shape) -> Vec<(&'static str, Span)> {
    let differs = |number: &Number, from: f64| number.as_constant() != Some(from);
    // One number for all three axes means those of the plane.
    let is_one = |vector: &[Number; 3]| vector[0].span == vector[2].span;
    let placement = &shape.placement;
    let up = Some(&placement.translate[2]).filter(|up| differs(up, 0.0)).map(|up| ("move", up.span));
    let tall = Some(&placement.scale[2]).filter(|tall| differs(tall, 1.0) && !is_one(&placement.scale));
    let modifiers = shape.modifiers.iter().filter_map(|modifier| {
        let key = modifier.spec.key.name;
        let is_idle = match modifier.arguments.get(key)? {
            Argument::Vector(normal) if key == "mirror" => !normal[..2].iter().any(|along| differs(along, 0.0)),
            Argument::Vector(vector) if is_one(vector) => false,
            Argument::Vector(vector) if key == "scale" => differs(&vector[2], 1.0),
            Argument::Vector(vector) => matches!(key, "move" | "elongate") && differs(&vector[2], 0.0),
            Argument::Counts([x, y, z]) => *z > 1 && !(x == z && y == z),
            Argument::Places(places) => places.rows.iter().any(|place| place.at.z != 0.0),
            _ => false,
        };
        is_idle.then(|| (key, modifier.arguments.span(key).unwrap_or(shape.span)))
    });
    up.into_iter().chain(tall.map(|tall| ("scale", tall.span))).chain(modifiers).collect()
}

impl Arguments {
    /// The shape that a row's own key names.
    fn shape_of(&self, spec: &Spec) -> Option<ShapeId> {
        match self.get(spec.key.name)? {
            Argument::Shape(id) => Some(*id),
            _ => None,
        }
    }
}

//! Shapes: one maker each, its parameters, the modifiers.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use crate::distance::method::Choice;
use crate::field::Aabb;

use super::links::{Link, Node};
use super::{Building, Host, any_shape_keys, family, shape_keys};
use crate::node::argument::{Argument, Arguments, Bounds, Component, Copies, Rows};
use crate::node::keys;
use crate::node::list;
use crate::node::model::{Modifier, Placement, Shape, ShapeId};
use crate::node::operation::OPERATION;
use crate::node::spec::Spec;
use crate::node::table;
use crate::text::diagnostic::{Diagnostic, clip, some_of};
use crate::text::key::GREATEST;
use crate::text::key::{Absent, Key, Kind, Limit};
use crate::text::number::formula::Formula;
use crate::text::reader::{Fields, NO_OWNER};
use crate::text::source::Span;
use crate::text::value::{Data, Entry, Origin, Table, Value};

/// What makes a shape.
#[derive(Clone, Copy)]
enum Maker<'r> {
    /// A node.
    Node(&'static Spec),
    /// An operation of the scene's own, by the entry that names it.
    Own(&'r Entry),
}

impl Maker<'_> {
    fn spec(self) -> &'static Spec {
        match self {
            Self::Node(spec) => spec,
            Self::Own(_) => &OPERATION,
        }
    }
}

impl<'r, 'a> Building<'r, 'a> {
    pub(super) fn all_shapes(&mut self) {
        self.must_be_table("shape");
        for (i, entry) in family(self.root, "shape").enumerate() {
            let path = format!("shape.{}", entry.key);
            self.enter(&entry.key);
            match entry.value.table() {
                Some(table) => self.shapes[i] = self.read_shape(&path, entry.key_span, table, ShapeId(i)),
                None => self.reader.wrong_kind(&path, "a table", &entry.value),
            }
        }
    }

    /// What an entry makes of its shape, if it is one that makes.
    fn maker(&self, entry: &'r Entry) -> Option<Maker<'r>> {
        let node = table::maker(&entry.key).map(Maker::Node);
        node.or_else(|| self.operation_of(entry).map(|_| Maker::Own(entry)))
    }

    /// The one maker of a table. Says so where there are two of them, or none and no unknown key that stands for one.
    fn maker_of(&self, path: &str, span: Span, table: &'r Table) -> Option<Maker<'r>> {
        let mut found = table.0.iter().filter_map(|entry| Some((entry, self.maker(entry)?)));
        match (found.next(), found.next()) {
            (Some((_, maker)), None) => Some(maker),
            (Some((first, _)), Some((second, _))) => {
                let problem = format!("`{}` and `{}` both say what `{}` is", first.key, second.key, clip(path));
                self.reader.say(
                    Diagnostic::error(second.key_span, problem)
                        .help("a shape has one maker; `union` and its kin join several shapes"),
                );
                None
            }
            _ => {
                let known = any_shape_keys();
                let unknown = table.0.iter().any(|entry| !known.iter().any(|key| key.is_called(&entry.key)));
                if !unknown {
                    let makers: Vec<&str> = list::MAKERS.iter().map(|spec| spec.key.name).collect();
                    let problem = format!("nothing says what `{}` is", clip(path));
                    self.reader
                        .say(Diagnostic::error(span, problem).help(format!("give it one of {}", some_of(&makers))));
                }
                None
            }
        }
    }

    /// One shape, whose formulas may name what it gives them.
    fn read_shape(&mut self, path: &str, span: Span, table: &'r Table, id: ShapeId) -> Option<Shape> {
        let around = self.reader.enter_scope(self.scope_of(path, table));
        let shape = self.read_shape_within(path, span, table, id);
        self.reader.enter_scope(around);
        shape
    }

    fn read_shape_within(&mut self, path: &str, span: Span, table: &'r Table, id: ShapeId) -> Option<Shape> {
        let maker = self.maker_of(path, span, table);
        let spec = maker.map(Maker::spec);
        let done: Vec<&'static Spec> =
            list::MODIFIERS.iter().filter(|spec| table.0.iter().any(|entry| spec.key.is_called(&entry.key))).collect();
        let (keys, beside) = match maker {
            None => (any_shape_keys(), self.operations.keys().copied().collect()),
            Some(Maker::Node(spec)) => (shape_keys(spec.keys(), &done), Vec::new()),
            Some(Maker::Own(entry)) => (shape_keys([].iter(), &done), self.own_keys(entry, table)),
        };
        self.say_shared(path, table, spec.into_iter().chain(done), &beside);
        let fields = Fields::beside(self.reader, path, table::shape_owner, span, table, keys, beside);
        let arguments = match maker {
            None => None,
            Some(Maker::Node(spec)) => self.arguments(spec.keys(), &fields, id),
            Some(Maker::Own(entry)) => self.applied(path, entry, table, id),
        };
        // Without a maker all else is read, so that all errors come together.
        let mut modifiers = Vec::new();
        let steps = fields.value("do");
        for spec in list::MODIFIERS {
            if fields.entry(spec.key.name).is_none() {
                // Its default is said.
                fields.value(spec.key.name);
            } else if let Some(arguments) = self.arguments(spec.keys(), &fields, id) {
                modifiers.push(Modifier { spec, arguments });
            }
        }
        let mut placement = Placement {
            scale: fields.required_vector("scale"),
            rotate: fields.required_vector("rotate"),
            translate: fields.required_vector("move"),
        };
        if let Some(steps) = steps {
            self.say_beside_steps(&fields, table);
            modifiers = self.steps(&fields.full("do"), steps, id).unwrap_or_default();
            placed_last(&mut modifiers, &mut placement);
        }
        let takes_cells = |spec: &Spec| spec.cells.is_some();
        let has_cells = spec.is_none_or(takes_cells) || modifiers.iter().any(|modifier| takes_cells(modifier.spec));
        let host = Host { id, has_cells };
        let colour = fields.value("color").and_then(|value| self.shape_colour(&fields.full("color"), value, host));
        let scalars = fields
            .value("attribute")
            .map(|value| self.scalars(&fields.full("attribute"), value, host))
            .unwrap_or_default();
        let name = path.trim_start_matches("shape.").into();
        let (distance, distance_span) = self.measured_by(&fields).unwrap_or((Choice::USUAL, span));
        let step = self.step(&fields);
        let mut shape = Shape {
            name,
            span,
            spec: spec?,
            arguments: arguments?,
            modifiers,
            placement,
            colour,
            scalars,
            distance,
            distance_span,
            step,
            reads: BTreeMap::new(),
            is_flat: false,
            lifts: None,
        };
        shape.reads = self.reads(&shape, id);
        self.say_made_by_given(&shape);
        Some(shape)
    }

    /// Says which formulas that make a shape name attributes that are known once it is there.
    fn say_made_by_given(&self, shape: &Shape) {
        for formula in shape.all_arguments().flat_map(Arguments::formulas) {
            if let Some(name) = formula.given().next() {
                let problem = format!("`{}` is an attribute of the shape that this formula makes", clip(name));
                let help = "name it in colours and attributes; `displace` moves the surface by one";
                self.reader.say(Diagnostic::error(formula.span(), problem).help(help));
            }
        }
    }

    /// The shapes whose distances the formulas of a shape read.
    fn reads(&mut self, shape: &Shape, id: ShapeId) -> BTreeMap<String, ShapeId> {
        let mut found = BTreeMap::new();
        let formulas = shape.all_arguments().chain(shape.given_arguments()).flat_map(Arguments::formulas);
        for (formula, name) in formulas.flat_map(|formula| formula.distances().map(move |(_, name)| (formula, name))) {
            let name = Value { data: Data::Text(name.to_owned()), span: formula.span(), origin: Origin::Scene };
            if let Some(other) = self.resolve("shape", &self.shape_ids, &name, "dist") {
                self.links.push(Link { from: Node::Shape(id), to: Node::Shape(other), span: formula.span() });
                found.insert(name.text().unwrap_or_default().to_owned(), other);
            }
        }
        found
    }

    /// Says which keys could be parameters of two nodes of one shape. `own`: the operation of the scene's own that makes
    /// it, and its parameters.
    fn say_shared(
        &self,
        path: &str,
        table: &'r Table,
        specs: impl Iterator<Item = &'static Spec> + Clone,
        own: &[&'r str],
    ) {
        for entry in &table.0 {
            let owns = |spec: &&'static Spec| spec.parameters.iter().any(|key| key.is_called(&entry.key));
            let own = own.first().copied().filter(|_| own.contains(&entry.key.as_str()));
            let mut owners = own.into_iter().chain(specs.clone().filter(owns).map(|spec| spec.key.name));
            if let (Some(first), Some(second)) = (owners.next(), owners.next()) {
                let problem = format!("`{}` of `{}` could go with `{first}` or with `{second}`", entry.key, clip(path));
                let help = format!("write do = [{{ {second} = …, {} = … }}]", entry.key);
                self.reader.say(Diagnostic::error(entry.key_span, problem).help(help));
            }
        }
    }

    /// Says which keys stand beside `do` that belong into it.
    fn say_beside_steps(&self, fields: &Fields<'r, 'a>, table: &'r Table) {
        for entry in &table.0 {
            let is_maker = table::maker(&entry.key).is_some();
            if let Some(spec) = table::step(&entry.key).filter(|_| !is_maker) {
                let problem = format!("`{}` stands beside `do` of `{}`", entry.key, clip(&fields.path));
                let help = format!("its place in the order is one in the list: {{ {} = … }}", spec.key.name);
                self.reader.say(Diagnostic::error(entry.key_span, problem).help(help));
            }
        }
    }

    /// What is done to a shape, in the order of a list.
    fn steps(&mut self, path: &str, value: &'r Value, id: ShapeId) -> Option<Vec<Modifier>> {
        let Some(list) = value.list() else {
            self.reader.wrong_kind(path, "a list of tables such as { twist = 30 }", value);
            return None;
        };
        let mut steps = Vec::with_capacity(list.len());
        let mut sound = true;
        for (i, value) in list.iter().enumerate() {
            let step = self.step_of(&format!("{path}[{i}]"), value, id);
            sound &= step.is_some();
            steps.extend(step);
        }
        sound.then_some(steps)
    }

    /// One thing that is done to a shape.
    fn step_of(&mut self, path: &str, value: &'r Value, id: ShapeId) -> Option<Modifier> {
        let Some(table) = value.table() else {
            self.reader.wrong_kind(path, "a table such as { twist = 30 }", value);
            return None;
        };
        let mut found = table.0.iter().filter_map(|entry| Some((entry, table::step(&entry.key)?)));
        let spec = match (found.next(), found.next()) {
            (Some((_, spec)), None) => spec,
            (Some((first, _)), Some((second, _))) => {
                let problem = format!("`{}` and `{}` are two steps of `{}`", first.key, second.key, clip(path));
                self.reader.say(Diagnostic::error(second.key_span, problem).help("give each a table of its own"));
                return None;
            }
            _ => {
                let names: Vec<&str> = table::steps().map(|spec| spec.key.name).collect();
                let problem = Diagnostic::error(value.span, format!("nothing says what `{}` does", clip(path)));
                self.reader.say(match table.0.first() {
                    Some(entry) => problem.suggest(&entry.key, names.iter().copied()),
                    None => problem.help(format!("give it one of {}", some_of(&names))),
                });
                return None;
            }
        };
        let fields = Fields::new(self.reader, path, table::shape_owner, value.span, table, spec.keys().collect());
        let arguments = self.arguments(spec.keys(), &fields, id)?;
        Some(Modifier { spec, arguments })
    }

    /// The values of a node's keys. Reads them all even where one is wrong, so that all errors come together.
    pub(super) fn arguments(
        &mut self,
        keys: impl Iterator<Item = &'static Key>,
        fields: &Fields<'r, 'a>,
        id: ShapeId,
    ) -> Option<Arguments> {
        let mut arguments = Arguments::default();
        let mut sound = true;
        for key in keys {
            match self.argument(key, fields, id) {
                Some(argument) => arguments.0.push((key.name, argument)),
                None => sound &= fields.entry(key.name).is_none() && key.default != Absent::Required,
            }
        }
        sound &= self.in_time(&mut arguments, fields);
        sound.then_some(arguments)
    }

    /// The value of one key, or its default; `None` where it has neither, and where an error was said.
    fn argument(&mut self, key: &'static Key, fields: &Fields<'r, 'a>, id: ShapeId) -> Option<Argument> {
        let (name, path) = (key.name, fields.full(key.name));
        Some(match key.kind {
            Kind::Number => Argument::Number(fields.number(name)?),
            Kind::Vector | Kind::Lengths => Argument::Vector(Box::new(fields.vector(name)?)),
            Kind::Pair => Argument::Pair(Box::new(fields.two(name)?)),
            Kind::Rows(..) => {
                let (all, span) = fields.rows(name)?;
                Argument::Rows(Rows { all, span })
            }
            Kind::Constant => Argument::Constant(fields.constant(name)?),
            Kind::Seed => Argument::Seed(self.seed_of(fields.whole(name), &fields.path)),
            Kind::Choice(_) => Argument::Choice(fields.choice(name)?),
            Kind::Formula => Argument::Formula(self.formula(&path, fields.value(name)?)?),
            Kind::Path => Argument::File(self.file(name, fields)?),
            Kind::Paths => match self.sequence(name, fields)? {
                Some(files) => Argument::Files(Arc::new(files)),
                None => Argument::File(self.file(name, fields)?),
            },
            Kind::Shape => Argument::Shape(self.operand(&path, Node::Shape(id), fields.value(name)?)?),
            Kind::Shapes(least) => Argument::Shapes(self.operands(name, least, fields, id)?),
            Kind::TwoShapes => Argument::Shapes(self.two_operands(name, fields, id)?),
            Kind::Goals => Argument::Goals(self.goals(&path, fields.value(name)?, id)?),
            // The word is a list of none.
            Kind::ShapesOr(word) if fields.value(name)?.text() == Some(word) => Argument::Shapes(Vec::new()),
            Kind::ShapesOr(_) => Argument::Shapes(self.operands(name, 1, fields, id)?),
            Kind::OfSpace => Argument::Components(vec![match fields.value(name)?.text() {
                Some(text) => Component::Formula(self.reader.formula_of_space(text, fields.value(name)?.span)?),
                None => Component::Number(fields.number(name)?),
            }]),
            Kind::Cells => Argument::Cells(self.cells_reference(&path, id, fields.value(name)?)?),
            Kind::Copies => Argument::Copies(self.copies(&path, id, fields.value(name)?)?),
            Kind::Counts => Argument::Counts(self.counts(&path, fields.value(name)?)?),
            Kind::Places => Argument::Places(self.places(name, fields)?),
            Kind::Direction => Argument::Vector(Box::new(self.direction(name, fields)?)),
            Kind::Box => Argument::Box(self.bounds(&path, fields.value(name)?)?),
            Kind::Scalar => Argument::Scalar(self.scalar_name(fields, name)?),
            Kind::Whole => Argument::Whole(fields.whole(name)?),
            Kind::Text => {
                let span = fields.entry(name).map_or_else(|| fields.main_span(), |entry| entry.value.span);
                Argument::Text(fields.text(name)?, span)
            }
            Kind::Components(meaning) => self.components(&path, fields.value(name)?, meaning)?,
            Kind::Formulas => Argument::Components(self.formulas(&path, fields.value(name)?)?),
            Kind::Palette => Argument::Colours(self.named_palette(&path, fields.value(name)?)?),
            Kind::Colour => Argument::Colour(self.solid(&path, fields.value(name)?)?),
            Kind::TwoColours => Argument::Colours(self.two_colours(&path, fields.value(name)?)?),
            Kind::Numbers => Argument::Numbers(self.several(&path, fields.value(name)?)?),
            Kind::TwoNumbers => Argument::Numbers(self.two_numbers(&path, fields.value(name)?)?),
            Kind::Bands => {
                let colour = |path: &str, value: &'r Value| self.solid(path, value);
                Argument::Bands(self.bands(&path, fields.value(name)?, "[depth, colour]", colour)?)
            }
            Kind::Stops => {
                let colour = |path: &str, value: &'r Value| self.solid(path, value);
                Argument::Bands(self.bands(&path, fields.value(name)?, "[at, colour]", colour)?)
            }
            Kind::NumberStops => {
                let one = |path: &str, value: &'r Value| Some(self.one(path, value));
                Argument::NumberBands(self.bands(&path, fields.value(name)?, "[at, number]", one)?)
            }
            Kind::NumberBands => {
                let one = |path: &str, value: &'r Value| Some(self.one(path, value));
                Argument::NumberBands(self.bands(&path, fields.value(name)?, "[depth, number]", one)?)
            }
            kind => unreachable!("`{name}` of a node is {kind:?}"),
        })
    }

    fn formula(&self, path: &str, value: &'r Value) -> Option<Formula> {
        let Some(text) = value.text() else {
            self.reader.wrong_kind(path, "a formula in quotes", value);
            return None;
        };
        self.reader.formula_of_space(text, value.span)
    }

    /// The key of the operation that makes a shape, and those of its parameters that the shape gives.
    fn own_keys(&self, entry: &'r Entry, table: &'r Table) -> Vec<&'r str> {
        let operation = self.operation_of(entry).and_then(Option::as_ref);
        let is_own = |other: &&Entry| match operation {
            Some(operation) => operation.parameters.iter().any(|parameter| parameter.name == other.key),
            // Nothing is known of an operation that is wrong.
            None => true,
        };
        let others = table.0.iter().filter(|other| other.key != entry.key).filter(is_own);
        std::iter::once(entry).chain(others).map(|entry| entry.key.as_str()).collect()
    }

    /// The shapes of a list.
    pub(super) fn operands(
        &mut self,
        key: &str,
        least: usize,
        fields: &Fields<'r, 'a>,
        id: ShapeId,
    ) -> Option<Vec<ShapeId>> {
        let value = fields.value(key)?;
        self.operand_list(&fields.full(key), value, least, id)
    }

    /// The two shapes of a key.
    fn two_operands(&mut self, key: &str, fields: &Fields<'r, 'a>, id: ShapeId) -> Option<Vec<ShapeId>> {
        let value = fields.value(key)?;
        if let Some(third) = value.list().and_then(|list| list.get(2)) {
            let problem = Diagnostic::error(third.span, format!("`{}` takes two shapes", clip(&fields.full(key))));
            self.reader.say(problem.help("join some of them first: { union = [\"a\", \"b\"] } is a shape too"));
            return None;
        }
        self.operands(key, 2, fields, id)
    }

    /// The shapes of a list, at least so many.
    pub(super) fn operand_list(
        &mut self,
        path: &str,
        value: &'r Value,
        least: usize,
        id: ShapeId,
    ) -> Option<Vec<ShapeId>> {
        let Some(list) = value.list() else {
            let problem = Diagnostic::error(value.span, format!("`{}` must be a list of shapes", clip(path)));
            let help = value.text().map_or_else(String::new, |name| format!("[\"{}\"]", clip(name)));
            self.reader.say(problem.label(format!("this is {}", value.kind())).help(help));
            return None;
        };
        if list.len() < least {
            let wanted = if least == 1 { "one shape" } else { "two shapes" };
            self.reader.say(Diagnostic::error(value.span, format!("`{}` needs at least {wanted}", clip(path))));
            return None;
        }
        let ids: Vec<Option<ShapeId>> = list
            .iter()
            .enumerate()
            .map(|(i, value)| self.operand(&format!("{path}[{i}]"), Node::Shape(id), value))
            .collect();
        ids.into_iter().collect()
    }

    /// The shapes of a list, at least one; what is called as the surface is where no shape has that name.
    fn goals(&mut self, path: &str, value: &'r Value, id: ShapeId) -> Option<Vec<Option<ShapeId>>> {
        const SURFACE: &str = "surface";
        let is_surface = |value: &Value| value.text() == Some(SURFACE) && !self.shape_ids.contains_key(SURFACE);
        let Some(list) = value.list().filter(|list| list.iter().any(is_surface)) else {
            return Some(self.operand_list(path, value, 1, id)?.into_iter().map(Some).collect());
        };
        let surfaces: Vec<bool> = list.iter().map(is_surface).collect();
        let mut goals = Vec::with_capacity(list.len());
        for (i, (value, surface)) in list.iter().zip(surfaces).enumerate() {
            goals.push(match surface {
                true => Some(None),
                false => self.operand(&format!("{path}[{i}]"), Node::Shape(id), value).map(Some),
            });
        }
        goals.into_iter().collect()
    }

    /// A shape by name, or written in place.
    pub(super) fn operand(&mut self, path: &str, from: Node, value: &'r Value) -> Option<ShapeId> {
        let id = match value.table() {
            None => self.resolve("shape", &self.shape_ids, value, path)?,
            Some(table) => {
                let id = ShapeId(self.shapes.len());
                self.shapes.push(None);
                let shape = self.within(value.span, |building| building.read_shape(path, value.span, table, id));
                self.shapes[id.0] = shape;
                id
            }
        };
        self.links.push(Link { from, to: Node::Shape(id), span: value.span });
        Some(id)
    }

    /// A shape that `[morph]` or `[output]` names.
    pub(super) fn shape_reference(&mut self, path: &str, value: &'r Value) -> Option<ShapeId> {
        self.operand(path, Node::Output, value)
    }

    fn copies(&mut self, path: &str, id: ShapeId, value: &'r Value) -> Option<Copies> {
        let keys = keys::COPIES.iter().collect();
        let fields = Fields::of_value(self.reader, path, NO_OWNER, value.span, value, keys)?;
        let cells = fields.value("cells").and_then(|value| self.cells_reference(&fields.full("cells"), id, value));
        let pick = fields.constant("pick").unwrap_or(1.0);
        let seed = self.seed_of(fields.whole("seed"), path);
        Some(Copies { cells: cells?, pick, seed })
    }

    /// A box, or a table with one that says whether it is meant to cut.
    fn bounds(&self, path: &str, value: &'r Value) -> Option<Bounds> {
        if value.table().is_none() {
            return self.box_of(path, value).map(|aabb| Bounds { aabb, cut: false, span: value.span });
        }
        let fields = Fields::of_value(self.reader, path, NO_OWNER, value.span, value, keys::BOUNDS.iter().collect())?;
        let aabb = fields.value("box").and_then(|value| self.box_of(&fields.full("box"), value));
        let cut = fields.flag("cut");
        Some(Bounds { aabb: aabb?, cut, span: value.span })
    }

    /// An edge length, three edge lengths, or two corners.
    fn box_of(&self, path: &str, value: &Value) -> Option<Aabb> {
        let vector = |value: &Value| {
            let numbers: Vec<f64> = value.list()?.iter().filter_map(Value::number).collect();
            let three: [f64; 3] = numbers.try_into().ok()?;
            Some(DVec3::from(three)).filter(|vector| vector.is_finite())
        };
        let corners = match value.list() {
            None => value.number().map(DVec3::splat).map(|edges| (-edges / 2.0, edges / 2.0)),
            Some([min, max]) => vector(min).zip(vector(max)),
            Some(_) => vector(value).map(|edges| (-edges / 2.0, edges / 2.0)),
        };
        let in_range = |corner: &DVec3| Limit::Any.allows(corner.abs().max_element());
        match corners.filter(|(min, max)| min.cmplt(*max).all() && in_range(min) && in_range(max)) {
            Some((min, max)) => Some(Aabb::new(min, max)),
            None => {
                let problem = format!("`{}` must be a box", clip(path));
                self.reader.say(
                    Diagnostic::error(value.span, problem)
                        .help(format!("an edge length, three edge lengths, or [[least x, y, z], [greatest x, y, z]], of at most {GREATEST:e}")),
                );
                None
            }
        }
    }
}

/// Where a list ends with scaling, turning and moving, in this order, that is where the shape stands: a morph carries it.
fn placed_last(modifiers: &mut Vec<Modifier>, placement: &mut Placement) {
    let targets =
        [("move", &mut placement.translate), ("rotate", &mut placement.rotate), ("scale", &mut placement.scale)];
    for (name, target) in targets {
        let last = modifiers.last().filter(|modifier| modifier.spec.key.name == name);
        if let Some(vector) = last.and_then(|modifier| modifier.arguments.vector(name)) {
            *target = vector.clone();
            modifiers.pop();
        }
    }
}

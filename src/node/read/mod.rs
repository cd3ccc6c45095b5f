//! From the tree of values to the model: every table by its keys, names resolved, what is output found.

mod chain;
mod colours;
mod displace;
mod links;
mod morph;
mod pairs;
mod places;
mod planar;
mod scalars;
mod shapes;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::node::keys::{self};
use crate::node::list;
use crate::node::model::{Cells, CellsId, Model, Parameter, Shape, ShapeId};
use crate::node::spec::Spec;
use crate::node::table;
use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity, clip};
use crate::text::files::{Base, Variables};
use crate::text::formula::{Names, RESERVED};
use crate::text::frames::{FrameRange, Shot};
use crate::text::key::{Key, Limit};
use crate::text::number::{NumberValue, plain_number};
use crate::text::reader::{Fields, NO_OWNER, Reader};
use crate::text::source::{Sources, Span};
use crate::text::value::{Data, Entry, Table, Value};

use links::{Link, Node};

/// Where files and variables come from.
pub struct Surroundings {
    /// Where relative paths begin.
    pub base: Base,
    /// The values of variables in paths.
    pub variables: Variables,
}

/// What is known while a scene is read.
struct Building<'r, 'a> {
    reader: &'r Reader<'a>,
    surroundings: &'r Surroundings,
    root: &'r Table,
    shape_ids: BTreeMap<&'r str, ShapeId>,
    cells_ids: BTreeMap<&'r str, CellsId>,
    shapes: Vec<Option<Shape>>,
    cells: Vec<Option<Cells>>,
    links: Vec<Link>,
    seed: u64,
}

/// The shape that an attribute belongs to.
#[derive(Clone, Copy)]
struct Host {
    id: ShapeId,
    /// Whether it has cells, which can take a value each.
    has_cells: bool,
    /// Whether shapes may be written in place in the attribute.
    may_nest: bool,
}

/// Reads a tree. The model where there is no error, and everything there is to say.
pub fn read(
    name: &str,
    root: &Table,
    sources: Arc<Sources>,
    surroundings: &Surroundings,
    earlier: Vec<Diagnostic>,
) -> Result<Model, Diagnostics> {
    let names: Names = family(root, "param").map(|entry| entry.key.clone()).collect();
    let reader = Reader::new(&sources, names);
    earlier.into_iter().for_each(|diagnostic| reader.say(diagnostic));
    let parts = Parts::read(root, surroundings, &reader);
    let (said, settings) = reader.into_parts();
    let mut diagnostics = Diagnostics::new(said, Arc::clone(&sources));
    let Some(parts) = parts.filter(|_| !diagnostics.has_errors()) else {
        diagnostics.drop_notes();
        return Err(diagnostics);
    };
    Ok(Model {
        name: name.into(),
        shot: parts.shot,
        unit: parts.unit,
        up: parts.up,
        seed: parts.seed,
        parameters: parts.parameters,
        shapes: parts.shapes,
        cells: parts.cells,
        content: parts.content,
        output: parts.output,
        settings,
        warnings: diagnostics,
        document: root.clone(),
        sources,
    })
}

/// The parts of a model.
struct Parts {
    shot: Shot,
    unit: &'static str,
    up: &'static str,
    seed: u64,
    parameters: Vec<Parameter>,
    shapes: Vec<Shape>,
    cells: Vec<Cells>,
    content: crate::node::model::Content,
    output: crate::node::model::Output,
}

impl Parts {
    /// `None` only where an error was said.
    fn read(root: &Table, surroundings: &Surroundings, reader: &Reader<'_>) -> Option<Self> {
        let top = Fields::new(reader, "", NO_OWNER, Span::default(), root, keys::SCENE.iter().collect());
        if top.whole("hfvdb").is_some() && top.entry("hfvdb").is_none() {
            let note = Diagnostic::without_place("the scene does not say `hfvdb = 1`: it is read as format 1");
            reader.say(Diagnostic { severity: Severity::Note, ..note });
        }
        let shot = shot(&top);
        let unit = top.choice("unit").unwrap_or("m");
        let up = top.choice("up").unwrap_or("z");
        let seed = top.whole("seed").unwrap_or(0).max(0) as u64;
        let parameters = parameters(reader, root);
        let mut building = Building::new(reader, surroundings, root, seed);
        building.palettes();
        building.all_cells();
        building.all_shapes();
        let morph = building.morph(&shot);
        let (output, chosen) = building.output();
        building.check_velocity(morph.as_deref(), &output);
        building.check_displacements();
        building.report_cycles();
        building.check_planes();
        let content = building.content(morph, chosen)?;
        let content = building.lifted(content);
        Some(Self {
            shot,
            unit,
            up,
            seed,
            parameters,
            shapes: building.shapes.into_iter().collect::<Option<_>>()?,
            cells: building.cells.into_iter().collect::<Option<_>>()?,
            content,
            output,
        })
    }
}

/// The entries of a family such as `shape`.
fn family<'r>(root: &'r Table, name: &str) -> impl Iterator<Item = &'r Entry> + use<'r> {
    root.get(name).and_then(|entry| entry.value.table()).into_iter().flat_map(|table| &table.0)
}

fn shot(top: &Fields<'_, '_>) -> Shot {
    let fps = top.constant("fps").unwrap_or(24.0);
    let range = top.frames("frames");
    Shot { range: range.unwrap_or(FrameRange { first: 1, last: 1 }), fps, still: range.is_none() }
}

fn parameters(reader: &Reader<'_>, root: &Table) -> Vec<Parameter> {
    if let Some(entry) = root.get("param").filter(|entry| entry.value.table().is_none()) {
        reader.wrong_kind("param", "a table", &entry.value);
    }
    // Formulas of parameters know time only.
    let time_only = Reader::new(reader.sources, Names::default());
    let read = |entry: &Entry| {
        let path = format!("param.{}", entry.key);
        if RESERVED.contains(&entry.key.as_str()) {
            let problem = format!("`{}` already means something in formulas", entry.key);
            reader.say(Diagnostic::error(entry.key_span, problem));
        }
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !entry.key.chars().all(is_name) || entry.key.starts_with(|c: char| c.is_ascii_digit()) {
            let problem = format!("`{}` cannot be a name in formulas", clip(&entry.key));
            reader.say(Diagnostic::error(entry.key_span, problem).help("letters, digits and _"));
        }
        let described = entry.value.table().filter(|table| table.get("value").is_some());
        let Some(table) = described else {
            return Parameter {
                name: entry.key.clone(),
                value: noted(&time_only, reader, &path, &entry.value),
                text: None,
            };
        };
        let fields = Fields::new(reader, &path, NO_OWNER, entry.key_span, table, keys::PARAMETER.iter().collect());
        let mut value = match fields.value("value") {
            Some(value) => time_only.number(&path, Limit::Any, value),
            None => fields.required_number("value"),
        };
        if let Some([least, greatest]) = fields.value("range").and_then(|range| pair(reader, &path, range)) {
            value.limit = Limit::Within(least, greatest);
            if let NumberValue::Constant(constant) = value.value
                && let Some(wanted) = value.limit.out_of_range(constant)
            {
                let problem = format!("`{path}` must be {wanted}, and is {}", plain_number(constant));
                reader.say(Diagnostic::error(value.span, problem));
            }
        }
        Parameter { name: entry.key.clone(), value, text: fields.text("text") }
    };
    let all = family(root, "param").map(read).collect();
    time_only.into_parts().0.into_iter().for_each(|diagnostic| reader.say(diagnostic));
    all
}

fn noted(time_only: &Reader<'_>, reader: &Reader<'_>, path: &str, value: &Value) -> crate::text::number::Number {
    reader.note(path, reader.sources.text(value.span), value.origin);
    time_only.number(path, Limit::Any, value)
}

/// `[least, greatest]`.
fn pair(reader: &Reader<'_>, name: &str, value: &Value) -> Option<[f64; 2]> {
    let numbers: Option<Vec<f64>> = value.list().map(|list| list.iter().filter_map(Value::number).collect());
    match numbers.as_deref() {
        Some(&[least, greatest]) if least < greatest => Some([least, greatest]),
        _ => {
            let problem = format!("`{}` takes two numbers, [least, greatest]", clip(name));
            reader.say(Diagnostic::error(value.span, problem));
            None
        }
    }
}

impl<'r, 'a> Building<'r, 'a> {
    fn new(reader: &'r Reader<'a>, surroundings: &'r Surroundings, root: &'r Table, seed: u64) -> Self {
        let shape_ids: BTreeMap<_, _> =
            family(root, "shape").enumerate().map(|(i, entry)| (entry.key.as_str(), ShapeId(i))).collect();
        let cells_ids: BTreeMap<_, _> =
            family(root, "cells").enumerate().map(|(i, entry)| (entry.key.as_str(), CellsId(i))).collect();
        let (shapes, cells) = (vec![None; shape_ids.len()], vec![None; cells_ids.len()]);
        Self { reader, surroundings, root, shape_ids, cells_ids, shapes, cells, links: Vec::new(), seed }
    }

    /// A name of a family, or the error that says that there is none such.
    fn resolve<T: Copy>(&self, family: &str, ids: &BTreeMap<&'r str, T>, value: &Value, path: &str) -> Option<T> {
        let Some(name) = value.text() else {
            self.reader.wrong_kind(path, &format!("the name of {}", noun(family)), value);
            return None;
        };
        let found = ids.get(name).copied();
        if found.is_none() {
            let problem = Diagnostic::error(value.span, format!("there is no `{family}.{}`", clip(name)));
            let elsewhere = ["shape", "cells", "palette", "color"]
                .into_iter()
                .filter(|_| !self.reader.has_said_enough())
                .find(|other| *other != family && self::family(self.root, other).any(|entry| entry.key == name));
            self.reader.say(match elsewhere {
                _ if self.reader.has_said_enough() => problem,
                Some(other) => problem.help(format!("`{name}` is the name of {}", noun(other))),
                None => problem.suggest(name, ids.keys().copied()),
            });
        }
        found
    }

    /// The seed beside a name: the scene's own with the name mixed in, or the one given.
    fn seed_of(&self, given: Option<i64>, name: &str) -> u64 {
        given.map_or_else(|| mixed(self.seed, name), |given| given.max(0) as u64)
    }

    fn all_cells(&mut self) {
        self.must_be_table("cells");
        for (i, entry) in family(self.root, "cells").enumerate() {
            let cells = self.read_cells(&format!("cells.{}", entry.key), entry.key_span, &entry.value, i, true);
            self.cells[i] = cells;
        }
    }

    fn must_be_table(&self, family: &str) {
        if let Some(entry) = self.root.get(family).filter(|entry| entry.value.table().is_none()) {
            self.reader.wrong_kind(family, "a table", &entry.value);
        }
    }

    /// `may_nest`: whether the shape that they stand around may be written in place.
    fn read_cells(&mut self, path: &str, span: Span, value: &'r Value, i: usize, may_nest: bool) -> Option<Cells> {
        let keys = keys::CELLS.iter().collect();
        let fields = Fields::of_value(self.reader, path, NO_OWNER, span, value, keys)?;
        let around = fields
            .value("octree")
            .and_then(|value| self.operand(&fields.full("octree"), Node::Cells(CellsId(i)), value, may_nest));
        let (least_depth, most_depth) = self.depth(&fields);
        Some(Cells {
            name: path.trim_start_matches("cells.").into(),
            span,
            least_depth,
            most_depth,
            chance: fields.constant("chance").unwrap_or(0.5),
            seed: self.seed_of(fields.whole("seed"), path),
            around: around?,
        })
    }

    /// `depth = 2` or `[1, 3]`.
    fn depth(&self, fields: &Fields<'r, 'a>) -> (u32, u32) {
        const MOST: i64 = crate::field::cells::MOST_DEPTH as i64;
        let default = (1, 3);
        let Some(value) = fields.value("depth") else { return default };
        let whole = |value: &Value| match value.data {
            Data::Integer(depth) if (0..=MOST).contains(&depth) => Some(depth as u32),
            _ => None,
        };
        let depths = match &value.data {
            Data::List(list) => match list.as_slice() {
                [least, most] => whole(least).zip(whole(most)).filter(|(least, most)| least <= most),
                _ => None,
            },
            _ => whole(value).map(|depth| (depth, depth)),
        };
        if depths.is_none() {
            let wanted =
                format!("`{}` must be a whole number from 0 to {MOST}, or [least, greatest]", fields.full("depth"));
            self.reader.say(Diagnostic::error(value.span, wanted));
        }
        depths.unwrap_or(default)
    }

    /// Cells by name, or written in place.
    fn cells_reference(&mut self, path: &str, from: ShapeId, value: &'r Value, may_nest: bool) -> Option<CellsId> {
        let id = if value.table().is_some() {
            let id = CellsId(self.cells.len());
            self.cells.push(None);
            self.cells[id.0] = self.read_cells(path, value.span, value, id.0, may_nest);
            id
        } else {
            self.resolve("cells", &self.cells_ids, value, path)?
        };
        self.links.push(Link { from: Node::Shape(from), to: Node::Cells(id), span: value.span });
        Some(id)
    }
}

/// With an article, for messages.
fn noun(family: &str) -> &'static str {
    match family {
        "shape" => "a shape",
        "cells" => "cells",
        "palette" => "a palette",
        _ => "a colour",
    }
}

/// A seed for one purpose, from the scene's seed and the purpose's name: FNV-1a over both.
fn mixed(seed: u64, name: &str) -> u64 {
    let bytes = seed.to_le_bytes().into_iter().chain(name.bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The keys of a shape that is this, and to which this is done.
fn shape_keys(spec: &'static Spec, done: &[&'static Spec]) -> Vec<&'static Key> {
    let parameters = done.iter().flat_map(|spec| spec.parameters);
    let modifiers = list::MODIFIERS.iter().map(|spec| &spec.key);
    spec.keys().chain(parameters).chain(keys::SHAPE).chain(modifiers).collect()
}

/// All keys that a shape may have, whatever it is.
fn any_shape_keys() -> Vec<&'static Key> {
    let makers = list::MAKERS.iter().map(|spec| &spec.key);
    let parameters = list::MAKERS.iter().flat_map(|spec| spec.parameters);
    makers.chain(table::modifier_keys()).chain(keys::SHAPE).chain(parameters).collect()
}

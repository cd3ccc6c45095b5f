//! From the tree of values to the model: every table by its keys, names resolved, what is output found.

mod carry;
mod chain;
mod colours;
mod displace;
mod distance;
mod links;
mod morph;
mod names;
mod operations;
mod pairs;
mod parameters;
mod places;
mod planar;
mod scalars;
mod sequence;
mod shapes;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::node::applied::Operation;
use crate::node::imports::Namespaces;
use crate::node::keys::{self};
use crate::node::list;
use crate::node::model::{Cells, CellsId, Model, Shape, ShapeId};
use crate::node::parameter::Parameter;
use crate::node::promises;
use crate::node::spec::Spec;
use crate::node::table;
use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity, clip, nearest};
use crate::text::files::{Base, Variables};
use crate::text::frames::{FrameRange, Shot};
use crate::text::key::Key;
use crate::text::number::formula::Scope;
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
    /// Which names imported files brought, and where paths of theirs begin.
    pub namespaces: Namespaces,
}

/// What is known while a scene is read.
struct Building<'r, 'a> {
    reader: &'r Reader<'a>,
    surroundings: &'r Surroundings,
    root: &'r Table,
    shape_ids: BTreeMap<&'r str, ShapeId>,
    cells_ids: BTreeMap<&'r str, CellsId>,
    /// By name; `None` for those that are wrong.
    operations: BTreeMap<&'r str, Option<Arc<Operation>>>,
    shapes: Vec<Option<Shape>>,
    cells: Vec<Option<Cells>>,
    links: Vec<Link>,
    seed: u64,
    shot: Shot,
    /// What stands before the names of the file whose text is read: nothing before the scene's own.
    space: String,
    /// How many shapes and cells in place stand around what is read.
    depth: usize,
}

/// The shape that an attribute belongs to.
#[derive(Clone, Copy)]
struct Host {
    id: ShapeId,
    /// Whether it has cells, which can take a value each.
    has_cells: bool,
}

/// Reads a tree. The model where there is no error, and everything there is to say.
pub fn read(
    name: &str,
    root: &Table,
    sources: Arc<Sources>,
    surroundings: &Surroundings,
    earlier: Vec<Diagnostic>,
) -> Result<Model, Diagnostics> {
    let reader = Reader::new(&sources, Scope::default());
    earlier.into_iter().for_each(|diagnostic| reader.say(diagnostic));
    let parts = Parts::read(root, surroundings, &reader);
    let (said, settings) = reader.into_parts();
    let mut diagnostics = Diagnostics::new(said, Arc::clone(&sources));
    let Some(parts) = parts.filter(|_| !diagnostics.has_errors()) else {
        diagnostics.drop_notes();
        return Err(diagnostics);
    };
    let model = Model {
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
        imports: surroundings.namespaces.files.clone(),
        document: root.clone(),
        sources: Arc::clone(&sources),
    };
    let found: Vec<Diagnostic> = parameters::out_of_range(&model).into_iter().chain(promises::broken(&model)).collect();
    if found.is_empty() { Ok(model) } else { Err(Diagnostics::new(found, sources)) }
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
        let misplaced: Vec<&str> =
            root.0.iter().filter(|entry| say_misplaced(reader, entry)).map(|entry| entry.key.as_str()).collect();
        let keys = keys::SCENE.iter().collect();
        let top = Fields::beside(reader, "", NO_OWNER, Span::default(), root, keys, misplaced);
        if top.whole("hfvdb").is_some() && top.entry("hfvdb").is_none() {
            let note = Diagnostic::without_place("the scene does not say `hfvdb = 1`: it is read as format 1");
            reader.say(Diagnostic { severity: Severity::Note, ..note });
        }
        let shot = shot(&top);
        let unit = top.choice("unit").unwrap_or("m");
        let up = top.choice("up").unwrap_or("z");
        let seed = top.whole("seed").unwrap_or(0).max(0) as u64;
        if let Some(entry) = root.get("param").filter(|entry| entry.value.table().is_none()) {
            reader.wrong_kind("param", "a table", &entry.value);
        }
        for entry in family(root, "param") {
            let own = &entry.key[surroundings.namespaces.of(&entry.key).len()..];
            parameters::check_name(reader, own, entry.key_span);
        }
        let parameters = parameters::parameters(reader, "param", family(root, "param"));
        let mut building = Building::new(reader, surroundings, root, seed, shot);
        building.enter("");
        building.palettes();
        building.all_operations();
        building.all_cells();
        building.all_shapes();
        building.enter("");
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

/// Says of what stands at the top without its family where it belongs, if that is plain to see.
fn say_misplaced(reader: &Reader<'_>, Entry { key, key_span, value }: &Entry) -> bool {
    let names: Vec<&str> = keys::SCENE.iter().map(|key| key.name).collect();
    if names.contains(&key.as_str())
        || keys::SCENE.iter().any(|known| known.is_called(key))
        || nearest(key, names).is_some()
    {
        return false;
    }
    let family = match &value.data {
        Data::Table(inner) if inner.0.iter().any(|entry| table::maker(&entry.key).is_some()) => {
            "a shape stands in its family: [shape."
        }
        Data::Integer(_) | Data::Float(_) => "a number with a name is a parameter: [param] with ",
        _ => return false,
    };
    let end =
        if value.table().is_some() { "]".to_owned() } else { format!(" = {}", clip(reader.sources.text(value.span))) };
    let problem = format!("unknown key `{}` at the top of a scene", clip(key));
    reader.say(Diagnostic::error(*key_span, problem).help(format!("{family}{}{end}", clip(key))));
    true
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

impl<'r, 'a> Building<'r, 'a> {
    fn new(reader: &'r Reader<'a>, surroundings: &'r Surroundings, root: &'r Table, seed: u64, shot: Shot) -> Self {
        let shape_ids: BTreeMap<_, _> =
            family(root, "shape").enumerate().map(|(i, entry)| (entry.key.as_str(), ShapeId(i))).collect();
        let cells_ids: BTreeMap<_, _> =
            family(root, "cells").enumerate().map(|(i, entry)| (entry.key.as_str(), CellsId(i))).collect();
        let (shapes, cells) = (vec![None; shape_ids.len()], vec![None; cells_ids.len()]);
        let operations = BTreeMap::new();
        let links = Vec::new();
        Self {
            reader,
            surroundings,
            root,
            shape_ids,
            cells_ids,
            operations,
            shapes,
            cells,
            links,
            seed,
            shot,
            space: String::new(),
            depth: 0,
        }
    }

    /// From here on names are those of the file that brought this one.
    fn enter(&mut self, name: &str) {
        self.space = self.surroundings.namespaces.of(name).to_owned();
        let known = |entry: &Entry| {
            let name =
                entry.key.strip_prefix(&self.space).filter(|name| self.surroundings.namespaces.of(name).is_empty());
            // No formula can name what has a / in it.
            name.map_or_else(|| format!("/{}", entry.key), str::to_owned)
        };
        let parameters = family(self.root, "param").map(known).collect();
        self.reader.enter_scope(Scope { parameters, named: Arc::default() });
    }

    /// A name as the scene knows it, from one in the text that is read.
    fn global(&self, name: &str) -> String {
        format!("{}{name}", self.space)
    }

    /// A name of a family, or the error that says that there is none such.
    fn resolve<T: Copy>(&self, family: &str, ids: &BTreeMap<&'r str, T>, value: &Value, path: &str) -> Option<T> {
        let Some(name) = value.text() else {
            self.reader.wrong_kind(path, &format!("the name of {}", noun(family)), value);
            return None;
        };
        let found = ids.get(self.global(name).as_str()).copied();
        if found.is_none() {
            let problem = Diagnostic::error(value.span, format!("there is no `{family}.{}`", clip(name)));
            let elsewhere = ["shape", "cells", "palette", "color"]
                .into_iter()
                .filter(|_| !self.reader.has_said_enough())
                .find(|other| {
                    *other != family && self::family(self.root, other).any(|entry| entry.key == self.global(name))
                });
            self.reader.say(match elsewhere {
                _ if self.reader.has_said_enough() => problem,
                Some(other) => problem.help(format!("`{name}` is the name of {}", noun(other))),
                None => problem.suggest(name, ids.keys().filter_map(|known| known.strip_prefix(self.space.as_str()))),
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
            self.enter(&entry.key);
            let cells = self.read_cells(&format!("cells.{}", entry.key), entry.key_span, &entry.value, i);
            self.cells[i] = cells;
        }
    }

    fn must_be_table(&self, family: &str) {
        if let Some(entry) = self.root.get(family).filter(|entry| entry.value.table().is_none()) {
            self.reader.wrong_kind(family, "a table", &entry.value);
        }
    }

    fn read_cells(&mut self, path: &str, span: Span, value: &'r Value, i: usize) -> Option<Cells> {
        let keys = keys::CELLS.iter().collect();
        let fields = Fields::of_value(self.reader, path, NO_OWNER, span, value, keys)?;
        let around = fields
            .value("octree")
            .and_then(|value| self.operand(&fields.full("octree"), Node::Cells(CellsId(i)), value));
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

    /// Reads what is written in place, unless it stands too deep in others of its kind.
    fn within<T>(&mut self, span: Span, read: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        /// Each level takes a piece of the stack.
        const DEEPEST: usize = 64;
        if self.depth == DEEPEST {
            let problem = format!("shapes in place stand more than {DEEPEST} deep in one another");
            self.reader.say(Diagnostic::error(span, problem).help("give one on the way a name: [shape.NAME]"));
            return None;
        }
        self.depth += 1;
        let read = read(self);
        self.depth -= 1;
        read
    }

    /// Cells by name, or written in place.
    fn cells_reference(&mut self, path: &str, from: ShapeId, value: &'r Value) -> Option<CellsId> {
        let id = if value.table().is_some() {
            let id = CellsId(self.cells.len());
            self.cells.push(None);
            self.cells[id.0] = self.within(value.span, |building| building.read_cells(path, value.span, value, id.0));
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

/// The keys of a shape with these of its own, and to which this is done.
fn shape_keys(own: impl Iterator<Item = &'static Key>, done: &[&'static Spec]) -> Vec<&'static Key> {
    let parameters = done.iter().flat_map(|spec| spec.parameters);
    let modifiers = list::MODIFIERS.iter().map(|spec| &spec.key);
    own.chain(parameters).chain(keys::SHAPE).chain(modifiers).collect()
}

/// All keys that a shape may have, whatever it is.
fn any_shape_keys() -> Vec<&'static Key> {
    let makers = list::MAKERS.iter().map(|spec| &spec.key);
    let parameters = list::MAKERS.iter().flat_map(|spec| spec.parameters);
    makers.chain(table::modifier_keys()).chain(keys::SHAPE).chain(parameters).collect()
}

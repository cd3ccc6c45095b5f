//! Scenes made by a program, in place of text.

use std::fmt;
use std::path::Path;

use crate::node::load::load;
use crate::node::model::Model;
use crate::node::origin::Source;
use crate::text::diagnostic::Diagnostics;
use crate::text::frames::FrameRange;
use crate::text::overrides::Overrides;

/// A scene made by a program. Keys and values are those of the scene format; [`Scene::model`] checks them as it checks a
/// file, and its text, which [`Display`](fmt::Display) writes, is a file that gives the same scene.
///
/// ```
/// use hfvdb::node::{Part, Scene};
///
/// let scene = Scene::new()
///     .with("frames", "1-24")
///     .shape("cube", Part::new("box", 1.6).with("color", "#d7263d"))
///     .shape("ring", Part::new("torus", 0.8).with("tube", 0.2).with("move", [0.0, 0.0, 0.5]))
///     .with("morph", Part::new("from", "cube").with("to", "ring"));
/// let model = scene.model("ring.toml", ".").expect("a sound scene");
/// assert_eq!(model.shapes.len(), 2);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    keys: Vec<(String, Value)>,
    shapes: Vec<(String, Part)>,
}

impl Scene {
    /// No shape yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// With a key at its top: `frames`, `unit`, or a table such as `morph` and `output`.
    pub fn with(mut self, key: &str, value: impl Into<Value>) -> Self {
        self.keys.push((key.to_owned(), value.into()));
        self
    }

    /// With a shape that others can name.
    pub fn shape(mut self, name: &str, shape: Part) -> Self {
        self.shapes.push((name.to_owned(), shape));
        self
    }

    /// The checked scene. `name` is what messages call it; paths in it begin at `folder`.
    ///
    /// # Errors
    /// All that is wrong with it, with places in its text.
    pub fn model(&self, name: &str, folder: impl AsRef<Path>) -> Result<Model, Diagnostics> {
        self.model_with(name, folder.as_ref(), &Overrides::default())
    }

    pub(super) fn model_with(&self, name: &str, folder: &Path, overrides: &Overrides) -> Result<Model, Diagnostics> {
        load(&Source::Text { name: name.to_owned(), text: self.to_string(), folder: folder.to_owned() }, overrides)
    }
}

/// The scene of `hfvdb morph A B`: two meshes, the one becoming the other over a shot, with the colours of their
/// vertices where they have them. Overrides reach it as any scene: `morph.bridge=1`.
///
/// # Errors
/// Those of [`load`].
pub fn morph_of_meshes(from: &Path, to: &Path, shot: FrameRange, overrides: &Overrides) -> Result<Model, Diagnostics> {
    Scene::new()
        .with("frames", format!("{}-{}", shot.first, shot.last))
        .shape("from", Part::new("mesh", path(from)))
        .shape("to", Part::new("mesh", path(to)))
        .with("morph", Part::new("from", "from").with("to", "to"))
        .model_with("hfvdb morph", Path::new(""), overrides)
}

/// A path as a scene has it. A `$` in a name on the command line is the name's own.
pub(super) fn path(path: &Path) -> String {
    path.display().to_string().replace('$', "$$")
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.keys.iter().any(|(key, _)| key == "hfvdb") {
            writeln!(f, "hfvdb = 1")?;
        }
        // Keys of the whole stand before the first table.
        let is_table = |value: &Value| matches!(value, Value::Part(_));
        for (key, value) in self.keys.iter().filter(|(_, value)| !is_table(value)) {
            writeln!(f, "{} = {value}", Key(key))?;
        }
        let shapes = self.shapes.iter().map(|(name, shape)| (format!("shape.{}", Key(name)), shape));
        let tables = self.keys.iter().filter_map(|(key, value)| match value {
            Value::Part(part) => Some((Key(key).to_string(), part)),
            _ => None,
        });
        for (name, part) in shapes.chain(tables) {
            writeln!(f, "\n[{name}]")?;
            for (key, value) in &part.0 {
                writeln!(f, "{} = {value}", Key(key))?;
            }
        }
        Ok(())
    }
}

/// A table of a scene: a shape, a colour, `[morph]`. As a value it is one written in place.
#[derive(Clone, Debug, PartialEq)]
pub struct Part(Vec<(String, Value)>);

impl Part {
    /// With its first key: what a shape is, where a colour comes from.
    pub fn new(key: &str, value: impl Into<Value>) -> Self {
        Self(Vec::new()).with(key, value)
    }

    /// With another key.
    pub fn with(mut self, key: &str, value: impl Into<Value>) -> Self {
        self.0.push((key.to_owned(), value.into()));
        self
    }
}

/// The value of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// True or false.
    Flag(bool),
    /// A name, a colour, a formula, a path.
    Text(String),
    /// A list.
    List(Vec<Value>),
    /// A table.
    Part(Part),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // The shortest form that is read back as the same number; never a whole one.
            Self::Number(number) if number.is_nan() => write!(f, "nan"),
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Text(text) => write!(f, "{}", Quoted(text)),
            Self::List(values) => {
                write!(f, "[")?;
                for (place, value) in values.iter().enumerate() {
                    write!(f, "{}{value}", if place == 0 { "" } else { ", " })?;
                }
                write!(f, "]")
            }
            Self::Part(Part(entries)) => {
                write!(f, "{{ ")?;
                for (place, (key, value)) in entries.iter().enumerate() {
                    write!(f, "{}{} = {value}", if place == 0 { "" } else { ", " }, Key(key))?;
                }
                write!(f, " }}")
            }
        }
    }
}

/// A key as TOML writes it.
struct Key<'k>(&'k str);

impl fmt::Display for Key<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if !self.0.is_empty() && self.0.chars().all(is_bare) {
            return write!(f, "{}", self.0);
        }
        write!(f, "{}", Quoted(self.0))
    }
}

/// A string as TOML writes it.
struct Quoted<'t>(&'t str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"")?;
        for c in self.0.chars() {
            match c {
                '"' | '\\' => write!(f, "\\{c}")?,
                c if c.is_control() => write!(f, "\\u{:04X}", u32::from(c))?,
                c => write!(f, "{c}")?,
            }
        }
        write!(f, "\"")
    }
}

macro_rules! from {
    ($($from:ty => $make:expr;)*) => {
        $(impl From<$from> for Value {
            fn from(value: $from) -> Self {
                $make(value)
            }
        })*
    };
}

from! {
    f64 => Self::Number;
    i64 => Self::Whole;
    i32 => |value| Self::Whole(i64::from(value));
    bool => Self::Flag;
    String => Self::Text;
    &str => |text: &str| Self::Text(text.to_owned());
    Part => Self::Part;
    glam::DVec3 => |vector: glam::DVec3| vector.to_array().into();
}

impl<V: Into<Self>> From<Vec<V>> for Value {
    fn from(values: Vec<V>) -> Self {
        Self::List(values.into_iter().map(Into::into).collect())
    }
}

impl<V: Into<Self>, const N: usize> From<[V; N]> for Value {
    fn from(values: [V; N]) -> Self {
        Self::List(values.into_iter().map(Into::into).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_gives_the_same_scene() {
        let scene = Scene::new()
            .with("frames", "1-9")
            .with("seed", 7)
            .with("output", Part::new("shape", "all of it").with("resolution", 32))
            .shape("all of it", Part::new("union", vec![Value::from("ball"), Part::new("box", [1.0, 2.0, 0.1]).into()]))
            .shape("ball", Part::new("sphere", 1e-3).with("color", [Value::from("0.5 + x"), 0.2.into(), 1.0.into()]));
        let text = scene.to_string();
        let read = load(
            &Source::Text { name: "s.toml".into(), text: text.clone(), folder: ".".into() },
            &Overrides::default(),
        )
        .expect("its text is sound");
        let model = scene.model("s.toml", ".").expect("it is sound");
        assert_eq!(model.hash().unwrap(), read.hash().unwrap());
        assert_eq!((model.shapes.len(), model.shot.range.last), (3, 9), "{text}");
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place_and_a_way_out() {
        let said = Scene::new().shape("ball", Part::new("spere", 1.0)).model("s.toml", ".").unwrap_err().to_string();
        assert!(said.contains("s.toml:4:1") && said.contains("sphere"), "{said}");
        let odd = Scene::new().shape("a \"b\"\n", Part::new("sphere", f64::NAN)).model("s.toml", ".").unwrap_err();
        assert!(odd.to_string().contains("s.toml:"), "{odd}");
    }
}

//! Reading tables by their known keys: types, limits, defaults, and everything that can be wrong with them.

use std::cell::RefCell;

use crate::text::diagnostic::{Diagnostic, Severity, clip, first_of, listed, nearest};
use crate::text::frames::FrameRange;
use crate::text::key::{Absent, Key, Kind, Limit};
use crate::text::number::formula::{Formula, FormulaProblem, Scope};
use crate::text::number::{Number, NumberValue};
use crate::text::source::{Sources, Span};
use crate::text::value::{Data, Entry, Origin, Table, Value};

/// A value of the scene and who gave it, for `hfvdb check -v`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Its whole name, such as `morph.bridge`.
    pub name: String,
    /// The value as text.
    pub value: String,
    /// Who gave it.
    pub origin: Origin,
}

/// What is shared while one scene is read.
pub struct Reader<'a> {
    /// The texts.
    pub sources: &'a Sources,
    /// What formulas may name where it reads.
    scope: RefCell<Scope>,
    diagnostics: RefCell<Vec<Diagnostic>>,
    settings: RefCell<Vec<Setting>>,
}

impl<'a> Reader<'a> {
    /// Nothing read yet.
    pub fn new(sources: &'a Sources, scope: Scope) -> Self {
        Self { sources, scope: scope.into(), diagnostics: RefCell::default(), settings: RefCell::default() }
    }

    /// What formulas may name where it reads.
    pub fn scope(&self) -> Scope {
        self.scope.borrow().clone()
    }

    /// From here on formulas may name this; gives what they could before.
    pub fn enter_scope(&self, scope: Scope) -> Scope {
        self.scope.replace(scope)
    }

    /// Notes something to say.
    pub fn say(&self, diagnostic: Diagnostic) {
        self.diagnostics.borrow_mut().push(diagnostic);
    }

    /// Notes what is wrong with a formula that stands in a string.
    pub fn say_all(&self, problems: Vec<FormulaProblem>, string: Span, text: &str) {
        problems.into_iter().for_each(|problem| self.say(problem.into_diagnostic(self.sources, string, text)));
    }

    /// A formula of space in a string; `None` where what is wrong with it was said.
    pub fn formula_of_space(&self, text: &str, string: Span) -> Option<Formula> {
        Formula::of_space(text, string, self.scope()).map_err(|problems| self.say_all(problems, string, text)).ok()
    }

    /// Whether an error was noted.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.borrow().iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Whether so much was noted that what comes is only counted: then nobody looks for the nearest names.
    pub fn has_said_enough(&self) -> bool {
        /// Many times what a report shows, whose errors stand in the order of the text, not in this one.
        const ENOUGH: usize = 100;
        self.diagnostics.borrow().len() >= ENOUGH
    }

    /// Everything that was noted.
    pub fn into_parts(self) -> (Vec<Diagnostic>, Vec<Setting>) {
        (self.diagnostics.into_inner(), self.settings.into_inner())
    }

    /// Notes a value for `check -v`.
    pub fn note(&self, name: &str, value: impl Into<String>, origin: Origin) {
        self.settings.borrow_mut().push(Setting { name: name.into(), value: value.into(), origin });
    }

    /// Notes a value as it is written.
    pub fn note_value(&self, name: &str, value: &Value) {
        let text = self.sources.text(value.span);
        let text =
            if text.contains('\n') { text.split_whitespace().collect::<Vec<_>>().join(" ") } else { text.into() };
        self.note(name, text, value.origin);
    }

    /// "this must be so, and is that".
    pub fn wrong_kind(&self, name: &str, wanted: &str, value: &Value) {
        self.say(
            Diagnostic::error(value.span, format!("`{}` must be {wanted}", clip(name)))
                .label(format!("this is {}", value.kind())),
        );
    }

    /// A number, a formula, or keys.
    pub fn number(&self, name: &str, limit: Limit, value: &Value) -> Number {
        let number = |of| Number { value: of, limit, name: name.into(), span: value.span };
        let fallback = || number(NumberValue::Constant(1.0));
        match &value.data {
            Data::Integer(_) | Data::Float(_) => {
                let constant = value.number().unwrap_or_default();
                self.check_limit(name, limit, constant, value.span);
                number(NumberValue::Constant(constant))
            }
            Data::Text(text) => match Formula::of_time(text, value.span, self.scope()) {
                Ok(formula) => number(NumberValue::Formula(formula)),
                Err(problems) => {
                    self.say_all(problems, value.span, text);
                    fallback()
                }
            },
            Data::Table(table) => match self.keys(name, limit, table, value.span) {
                Some(keys) => number(NumberValue::Keys(keys)),
                None => fallback(),
            },
            _ => {
                self.wrong_kind(name, "a number, a formula or keys", value);
                fallback()
            }
        }
    }

    pub(crate) fn check_limit(&self, name: &str, limit: Limit, value: f64, span: Span) {
        if let Some(wanted) = limit.out_of_range(value) {
            self.say(Diagnostic::error(span, format!("`{}` must be {wanted}", clip(name))));
        }
    }

    /// "one of these names", with the nearest.
    pub fn choice_problem(&self, name: &str, choices: &[&str], value: &Value) {
        match value.text() {
            Some(text) => {
                let diagnostic = Diagnostic::error(value.span, format!("`{}` cannot be `{}`", clip(name), clip(text)));
                self.say(diagnostic.suggest(text, choices.iter().copied()));
            }
            None => self.wrong_kind(name, &format!("one of {}", listed(choices)), value),
        }
    }

    /// A list of exactly three.
    pub fn three<'v>(&self, name: &str, value: &'v Value) -> Option<&'v [Value; 3]> {
        let three = value.list().and_then(|list| list.try_into().ok());
        if three.is_none() {
            match value.list() {
                Some(list) => self.say(
                    Diagnostic::error(value.span, format!("`{}` must be three numbers", clip(name)))
                        .label(format!("these are {}", list.len())),
                ),
                None => match value.number() {
                    Some(_) => {
                        let text = self.sources.text(value.span);
                        let problem = Diagnostic::error(value.span, format!("`{}` must be three numbers", clip(name)));
                        self.say(
                            problem
                                .label("this is one")
                                .help(format!("such as [0, 0, {}], for x, y and z", clip(text))),
                        );
                    }
                    None => self.wrong_kind(name, "three numbers", value),
                },
            }
        }
        three
    }

    /// A number that cannot change over time.
    pub fn constant(&self, name: &str, limit: Limit, value: &Value) -> f64 {
        match value.number() {
            Some(constant) => {
                self.check_limit(name, limit, constant, value.span);
                constant
            }
            None => {
                self.wrong_kind(name, "a number that stands still", value);
                1.0
            }
        }
    }

    /// Frames.
    pub fn frames(&self, name: &str, value: &Value) -> Option<FrameRange> {
        let text = match &value.data {
            Data::Integer(frame) => frame.to_string(),
            Data::Text(text) => text.clone(),
            _ => {
                self.wrong_kind(name, "frames such as \"1-48\"", value);
                return None;
            }
        };
        let range = text.parse::<FrameRange>();
        if let Err(wrong) = &range {
            let problem = format!("`{}` must be frames such as \"1-48\": this {wrong}", clip(name));
            self.say(Diagnostic::error(value.span, problem));
        }
        range.ok()
    }
}

/// What a key goes with that a table does not know: another key of the same kind of table.
pub type Owner = fn(&str) -> Option<&'static str>;

/// The owner of keys that are the same in every table of their kind.
pub const NO_OWNER: Owner = |_| None;

/// One table, read by its known keys.
pub struct Fields<'r, 'a> {
    /// What is shared.
    pub reader: &'r Reader<'a>,
    /// Its whole name, such as `shape.ball`.
    pub path: String,
    /// Where it stands: its name in its header, or the inline table.
    pub span: Span,
    table: &'r Table,
    keys: Vec<&'static Key>,
    /// Names of its keys that others read.
    beside: Vec<&'r str>,
}

/// Keys that a message lists where none is near: a shape may have a hundred.
const MOST_KEYS: usize = 12;

impl<'r, 'a> Fields<'r, 'a> {
    /// A table with its known keys; says which of its keys are unknown. `owner` tells what a key of the same kind of table
    /// goes with that is not known here.
    pub fn new(
        reader: &'r Reader<'a>,
        path: &str,
        owner: Owner,
        span: Span,
        table: &'r Table,
        keys: Vec<&'static Key>,
    ) -> Self {
        Self::beside(reader, path, owner, span, table, keys, Vec::new())
    }

    /// The same of a table with keys that others read, of these names.
    pub fn beside(
        reader: &'r Reader<'a>,
        path: &str,
        owner: Owner,
        span: Span,
        table: &'r Table,
        keys: Vec<&'static Key>,
        beside: Vec<&'r str>,
    ) -> Self {
        let fields = Self { reader, path: path.into(), span, table, keys, beside };
        for entry in &table.0 {
            match fields.keys.iter().find(|key| key.is_called(&entry.key)) {
                None if fields.beside.contains(&entry.key.as_str()) => {}
                None => fields.unknown(owner, entry),
                Some(key) => {
                    let earlier = table.0.iter().take_while(|other| other.key_span != entry.key_span);
                    if let Some(other) = earlier.into_iter().find(|other| key.is_called(&other.key)) {
                        let problem = format!("`{}` and `{}` are the same key", other.key, entry.key);
                        reader.say(Diagnostic::error(entry.key_span, problem));
                    }
                }
            }
        }
        fields
    }

    /// A value that must be a table.
    pub fn of_value(
        reader: &'r Reader<'a>,
        path: &str,
        owner: Owner,
        span: Span,
        value: &'r Value,
        keys: Vec<&'static Key>,
    ) -> Option<Self> {
        match value.table() {
            Some(table) => Some(Self::new(reader, path, owner, span, table, keys)),
            None => {
                reader.wrong_kind(path, "a table", value);
                None
            }
        }
    }

    fn unknown(&self, owner: Owner, entry: &Entry) {
        let name = entry.key.as_str();
        let here =
            if self.path.is_empty() { "at the top of a scene".into() } else { format!("in `{}`", clip(&self.path)) };
        let diagnostic = Diagnostic::error(entry.key_span, format!("unknown key `{}` {here}", clip(name)));
        if self.reader.has_said_enough() {
            return self.reader.say(diagnostic);
        }
        let names = self.beside.iter().copied().chain(self.keys.iter().map(|key| key.name));
        self.reader.say(match owner(name) {
            _ if nearest(name, names.clone()).is_some() => diagnostic.suggest(name, names),
            Some(owner) => diagnostic.help(format!("`{name}` goes with `{owner}`")),
            _ => {
                let names: Vec<&str> = names.collect();
                diagnostic.help(format!("there is {}", first_of(&names, MOST_KEYS)))
            }
        });
    }

    /// Where the value of the first of the keys stands, or else the table.
    pub fn main_span(&self) -> Span {
        self.entry(self.keys[0].name).map_or(self.span, |entry| entry.value.span)
    }

    /// The key as it is known. Every caller names a key of the table it was made with.
    fn key(&self, name: &str) -> &'static Key {
        self.keys.iter().find(|key| key.name == name).expect("readers ask for keys of their own table")
    }

    /// A key's entry, under any of its names.
    pub fn entry(&self, name: &str) -> Option<&'r Entry> {
        let key = self.key(name);
        self.table.0.iter().find(|entry| key.is_called(&entry.key))
    }

    /// A key's value; says so where the key must be there and is not. Notes defaults.
    pub fn value(&self, name: &str) -> Option<&'r Value> {
        let entry = self.entry(name);
        if entry.is_none() && self.key(name).default == Required {
            let problem = format!("`{}` has no `{name}`", clip(&self.path));
            self.reader.say(Diagnostic::error(self.span, problem).help(self.key(name).text));
        }
        match entry {
            Some(entry) => self.reader.note_value(&self.full(name), &entry.value),
            None => {
                let default = match self.key(name).default {
                    Absent::Number(value) => format!("{value}"),
                    Absent::Vector([x, y, z]) => format!("[{x}, {y}, {z}]"),
                    Absent::Text(text) => text.into(),
                    Absent::Of(other, share) => format!("({share} · `{other}`)"),
                    Absent::Words(words) => format!("({words})"),
                    Required | Absent::Nothing => return None,
                };
                self.reader.note(&self.full(name), default, Origin::Default);
            }
        }
        entry.map(|entry| &entry.value)
    }

    /// A key's whole name.
    pub fn full(&self, name: &str) -> String {
        if self.path.is_empty() { name.into() } else { format!("{}.{name}", self.path) }
    }

    /// A number; its default where it is left out and has one.
    pub fn number(&self, name: &str) -> Option<Number> {
        let key = self.key(name);
        match (self.value(name), key.default) {
            (Some(value), _) => Some(self.reader.number(&self.full(name), key.limit, value)),
            (None, Absent::Number(value)) => Some(Number::constant(value, &self.full(name), self.span)),
            _ => None,
        }
    }

    /// A number that must be there; some number where it is not, as the scene is refused anyway.
    pub fn required_number(&self, name: &str) -> Number {
        self.number(name).unwrap_or_else(|| Number::constant(1.0, name, self.span))
    }

    /// Three numbers; [`Kind::Lengths`] takes one for all three.
    pub fn vector(&self, name: &str) -> Option<[Number; 3]> {
        let key = self.key(name);
        let full = self.full(name);
        let Some(value) = self.value(name) else {
            let default = match key.default {
                Absent::Number(value) => [value; 3],
                Absent::Vector(vector) => vector,
                Required => [1.0; 3],
                _ => return None,
            };
            return Some(default.map(|value| Number::constant(value, &full, self.span)));
        };
        if key.kind == Kind::Lengths && value.list().is_none() {
            let number = self.reader.number(&full, key.limit, value);
            return Some([number.clone(), number.clone(), number]);
        }
        let three = self.reader.three(&full, value)?;
        Some(["x", "y", "z"].map(|axis| {
            let part = &three[axis.as_bytes()[0] as usize - usize::from(b'x')];
            self.reader.number(&format!("{full}.{axis}"), key.limit, part)
        }))
    }

    /// Two numbers, or one that stands for both.
    pub fn two(&self, name: &str) -> Option<[Number; 2]> {
        let key = self.key(name);
        let full = self.full(name);
        let Some(value) = self.value(name) else {
            let Absent::Number(value) = key.default else { return None };
            return Some([(); 2].map(|()| Number::constant(value, &full, self.span)));
        };
        let Some(list) = value.list() else {
            let number = self.reader.number(&full, key.limit, value);
            return Some([number.clone(), number]);
        };
        let Ok(two) = <&[Value; 2]>::try_from(list) else {
            let problem = format!("`{}` must be one number or two", clip(&full));
            self.reader.say(Diagnostic::error(value.span, problem).label(format!("these are {}", list.len())));
            return None;
        };
        let part = |axis: usize| self.reader.number(&format!("{full}.{}", ["x", "y"][axis]), key.limit, &two[axis]);
        Some([part(0), part(1)])
    }

    /// Lists of numbers that stand still.
    pub fn rows(&self, name: &str) -> Option<(Vec<Vec<f64>>, Span)> {
        let key = self.key(name);
        let full = self.full(name);
        let Kind::Rows(least, widths) = key.kind else { return None };
        let value = self.value(name)?;
        let Some(list) = value.list() else {
            self.reader.wrong_kind(&full, &format!("a {}", key.kind.words()), value);
            return None;
        };
        if list.len() < least {
            let problem = format!("`{}` needs at least {least}", clip(&full));
            self.reader.say(Diagnostic::error(value.span, problem).label(format!("these are {}", list.len())));
            return None;
        }
        let row = |row: &Value| -> Option<Vec<f64>> {
            let parts = row.list()?;
            let numbers: Vec<f64> = parts.iter().filter_map(Value::number).collect();
            let fits = numbers.len() == parts.len() && widths.contains(&numbers.len());
            (fits && numbers.iter().all(|number| Limit::Any.allows(*number))).then_some(numbers)
        };
        let mut rows = Vec::with_capacity(list.len());
        for value in list {
            let Some(numbers) = row(value) else {
                let problem = format!("`{}` is a {}", clip(&full), key.kind.words());
                self.reader.say(Diagnostic::error(value.span, problem).label("this is none of them"));
                return None;
            };
            rows.push(numbers);
        }
        Some((rows, value.span))
    }

    /// Three numbers that must be there.
    pub fn required_vector(&self, name: &str) -> [Number; 3] {
        self.vector(name).unwrap_or_else(|| [(); 3].map(|()| Number::constant(1.0, name, self.span)))
    }

    /// A number that stands still; its default where it is left out and has one.
    pub fn constant(&self, name: &str) -> Option<f64> {
        let key = self.key(name);
        match (self.value(name), key.default) {
            (Some(value), _) => Some(self.reader.constant(&self.full(name), key.limit, value)),
            (None, Absent::Number(value)) => Some(value),
            _ => None,
        }
    }

    /// A whole number; its default where it is left out and has one.
    pub fn whole(&self, name: &str) -> Option<i64> {
        let key = self.key(name);
        match (self.value(name), key.default) {
            (Some(Value { data: Data::Integer(value), span, .. }), _) => {
                if !key.limit.holds(*value as f64) {
                    let problem = format!("`{}` must be {}", clip(&self.full(name)), key.limit.words());
                    self.reader.say(Diagnostic::error(*span, problem));
                }
                Some(*value)
            }
            (Some(value), _) => {
                self.reader.wrong_kind(&self.full(name), "a whole number", value);
                None
            }
            (None, Absent::Number(value)) => Some(value as i64),
            _ => None,
        }
    }

    /// True or false; its default where it is left out.
    pub fn flag(&self, name: &str) -> bool {
        match self.value(name) {
            Some(Value { data: Data::Flag(flag), .. }) => *flag,
            Some(value) => {
                self.reader.wrong_kind(&self.full(name), "true or false", value);
                false
            }
            None => self.key(name).default == Absent::Text("true"),
        }
    }

    /// Text; its default where it is left out and has one.
    pub fn text(&self, name: &str) -> Option<String> {
        match (self.value(name), self.key(name).default) {
            (Some(value), _) => {
                if value.text().is_none() {
                    self.reader.wrong_kind(&self.full(name), "text", value);
                }
                value.text().map(str::to_owned)
            }
            (None, Absent::Text(text)) => Some(text.into()),
            _ => None,
        }
    }

    /// One of the key's names; its default where it is left out and has one.
    pub fn choice(&self, name: &str) -> Option<&'static str> {
        let key = self.key(name);
        let Kind::Choice(choices) = key.kind else { return None };
        match (self.value(name), key.default) {
            (Some(value), _) => {
                let found = choices.iter().copied().find(|choice| value.text() == Some(*choice));
                if found.is_none() {
                    self.reader.choice_problem(&self.full(name), choices, value);
                }
                found
            }
            (None, Absent::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// Frames; `None` where they are left out.
    pub fn frames(&self, name: &str) -> Option<FrameRange> {
        self.value(name).and_then(|value| self.reader.frames(&self.full(name), value))
    }
}

use Absent::Required;

//! Names that a shape gives its formulas: `let.NAME`, and its attributes. Those that are tables are known where the shape
//! is there already: in colours and attributes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::Building;
use super::parameters::check_name;
use crate::field;
use crate::node::list;
use crate::node::source::Source;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::key::{Kind, Limit};
use crate::text::number::formula::{Named, NamedValue, RESERVED, Scope};
use crate::text::source::Span;
use crate::text::value::{Data, Entry, Table, Value};

/// The most names of one shape.
const MOST: usize = 256;

/// A name before it is known what it needs.
struct Candidate<'r> {
    /// With the family: `let.r`, for messages.
    path: String,
    span: Span,
    value: &'r Value,
    named: NamedValue,
    /// The names that what it stands for needs.
    needs: BTreeSet<String>,
}

impl<'r, 'a> Building<'r, 'a> {
    /// What the formulas of a shape may name beside what all may: its `let`s and its attributes.
    pub(super) fn scope_of(&self, path: &str, table: &'r Table) -> Scope {
        let parameters = self.reader.scope().parameters;
        let mut candidates: BTreeMap<&'r str, Candidate<'r>> = BTreeMap::new();
        let attributes = table.get("attribute").and_then(|entry| entry.value.table());
        for entry in attributes.into_iter().flat_map(|table| &table.0) {
            // What has a meaning of its own in formulas keeps it.
            if !RESERVED.contains(&entry.key.as_str()) && !parameters.contains(&entry.key) {
                self.candidate(path, "attribute", entry, &mut candidates);
            }
        }
        if let Some(entry) = table.get("let") {
            match entry.value.table() {
                Some(table) => {
                    table.0.iter().for_each(|entry| self.own_name(path, entry, &parameters, &mut candidates))
                }
                None => self.reader.wrong_kind(
                    &format!("{path}.let"),
                    "a table, such as { r = \"length(x, y)\" }",
                    &entry.value,
                ),
            }
        }
        if let Some(candidate) = candidates.values().nth(MOST) {
            let problem = format!("`{}` gives its formulas more than {MOST} names", clip(path));
            self.reader.say(Diagnostic::error(candidate.span, problem));
            return Scope { parameters, named: Arc::default() };
        }
        let scope = Scope { parameters, named: self.in_order(&candidates) };
        // Those of attributes are checked where they are read.
        let lets = candidates.values().filter(|candidate| candidate.path.contains(".let."));
        for (value, text) in lets.filter_map(|candidate| Some((candidate.value, candidate.value.text()?))) {
            let before = self.reader.enter_scope(scope.clone());
            self.reader.formula_of_space(text, value.span);
            self.reader.enter_scope(before);
        }
        scope
    }

    fn own_name(
        &self,
        path: &str,
        entry: &'r Entry,
        parameters: &[String],
        candidates: &mut BTreeMap<&'r str, Candidate<'r>>,
    ) {
        check_name(self.reader, &entry.key, entry.key_span);
        let taken = if parameters.contains(&entry.key) {
            Some("a parameter of the scene")
        } else if candidates.contains_key(entry.key.as_str()) {
            Some("an attribute of the shape")
        } else {
            None
        };
        match taken {
            Some(taken) => {
                let problem = format!("`{}` is the name of {taken} already", clip(&entry.key));
                self.reader.say(Diagnostic::error(entry.key_span, problem).help("choose another name"));
            }
            None => {
                self.reader.note_value(&format!("{path}.let.{}", entry.key), &entry.value);
                if !self.candidate(path, "let", entry, candidates) {
                    let name = format!("{path}.let.{}", entry.key);
                    self.reader.wrong_kind(&name, "a number, a formula or keys", &entry.value);
                }
            }
        }
    }

    /// Takes a name that stands for a number or a formula; whether it does.
    fn candidate(
        &self,
        path: &str,
        family: &str,
        entry: &'r Entry,
        candidates: &mut BTreeMap<&'r str, Candidate<'r>>,
    ) -> bool {
        let path = format!("{path}.{family}.{}", entry.key);
        let is_frame = |entry: &Entry| entry.key == "ease" || entry.key.parse::<f64>().is_ok();
        let mut needs = BTreeSet::new();
        let named = match &entry.value.data {
            Data::Text(text) => {
                let formula = field::Formula::parse(text);
                needs.extend(formula.names().into_iter().map(str::to_owned));
                NamedValue::Formula(Arc::new(formula))
            }
            Data::Integer(_) | Data::Float(_) => {
                NamedValue::Number(self.reader.number(&path, Limit::Any, &entry.value))
            }
            Data::Table(table) if !table.0.is_empty() && table.0.iter().all(is_frame) => {
                NamedValue::Number(self.reader.number(&path, Limit::Any, &entry.value))
            }
            Data::Table(table) if family == "attribute" => {
                needs.extend(names_in(table));
                NamedValue::Given
            }
            _ => return false,
        };
        let (span, value) = (entry.key_span, &entry.value);
        candidates.insert(&entry.key, Candidate { path, span, value, named, needs });
        true
    }

    /// Each after those that it names; says which are made from themselves.
    fn in_order(&self, candidates: &BTreeMap<&'r str, Candidate<'r>>) -> Arc<[Named]> {
        let needs = |name: &str| -> Vec<&'r str> {
            candidates.keys().copied().filter(|known| candidates[name].needs.contains(*known)).collect()
        };
        let mut open: BTreeMap<&str, Vec<&str>> = candidates.keys().map(|name| (*name, needs(name))).collect();
        let (mut named, mut done) = (Vec::with_capacity(open.len()), BTreeSet::new());
        loop {
            let ready: Vec<&str> = open
                .iter()
                .filter(|(_, needs)| needs.iter().all(|name| done.contains(name)))
                .map(|(name, _)| *name)
                .collect();
            if ready.is_empty() {
                break;
            }
            for name in ready {
                open.remove(name);
                done.insert(name);
                named.push(Named { name: name.to_owned(), value: candidates[name].named.clone() });
            }
        }
        if let Some(first) = open.keys().next() {
            // Of what is left, each needs another one that is left: a way along them comes back.
            let mut way = vec![*first];
            while let Some(next) = open[way[way.len() - 1]].iter().find(|name| !done.contains(*name)) {
                let met = way.iter().position(|name| name == next);
                way.push(next);
                if let Some(begin) = met {
                    self.say_own_cycle(&way[begin..], candidates);
                    break;
                }
            }
        }
        named.into()
    }

    fn say_own_cycle(&self, way: &[&'r str], candidates: &BTreeMap<&'r str, Candidate<'r>>) {
        let candidate = &candidates[way[0]];
        let problem = format!("`{}` is made from itself", clip(&candidate.path));
        let help = format!("the way is {}", way.join(" → "));
        self.reader.say(Diagnostic::error(candidate.value.span, problem).help(help));
    }
}

/// The names in the formulas of an attribute that is a table.
fn names_in(table: &Table) -> BTreeSet<String> {
    let source = list::SCALARS.iter().find(|source| table.0.iter().any(|entry| source.key.is_called(&entry.key)));
    let keys = source.into_iter().flat_map(Source::keys).filter(|key| key.kind == Kind::Formula);
    let entries = keys.flat_map(|key| table.0.iter().filter(|entry| key.is_called(&entry.key)));
    let texts = entries.filter_map(|entry| entry.value.text());
    texts
        .flat_map(|text| field::Formula::parse(text).names().into_iter().map(str::to_owned).collect::<Vec<_>>())
        .collect()
}

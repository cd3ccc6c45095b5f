//! Operations of the scene's own, and shapes that are made by one.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::parameters::{check_name, parameters};
use super::{Building, family};
use crate::node::applied::{Applied, Operation, Promises};
use crate::node::argument::{Argument, Arguments};
use crate::node::keys;
use crate::node::model::ShapeId;
use crate::node::parameter::Parameter;
use crate::node::table;
use crate::text::diagnostic::{Diagnostic, clip, listed};
use crate::text::number::formula::Formula;
use crate::text::reader::{Fields, NO_OWNER};
use crate::text::source::Span;
use crate::text::value::{Entry, Table, Value};

impl<'r, 'a> Building<'r, 'a> {
    pub(super) fn all_operations(&mut self) {
        self.must_be_table("operation");
        for entry in family(self.root, "operation") {
            self.enter(&entry.key);
            let operation = self.operation(entry).map(Arc::new);
            self.operations.insert(entry.key.as_str(), operation);
        }
    }

    /// An operation; `None` where an error was said.
    fn operation(&self, entry: &'r Entry) -> Option<Operation> {
        let path = format!("operation.{}", entry.key);
        if let Some(taken) = taken(&entry.key) {
            let problem = format!("`{}` is the name of {taken}", clip(&entry.key));
            self.reader.say(Diagnostic::error(entry.key_span, problem).help("give the operation another name"));
        }
        let keys = keys::OPERATION.iter().collect();
        let fields = Fields::of_value(self.reader, &path, NO_OWNER, entry.key_span, &entry.value, keys)?;
        let names = self.names(&fields, "fields");
        let own = match fields.value("param").map(|value| (value, value.table())) {
            None => Vec::new(),
            Some((_, Some(table))) => {
                self.check_own_parameters(&path, table);
                parameters(self.reader, &format!("{path}.param"), table.0.iter())
            }
            Some((value, None)) => {
                self.reader.wrong_kind(&fields.full("param"), "a table, such as { k = 0.25 }", value);
                Vec::new()
            }
        };
        let (reach, lipschitz) = (fields.constant("reach"), fields.constant("lipschitz"));
        let rises_in = self.names(&fields, "rises_in");
        let names = names?;
        self.check_names(&names, &own);
        let own_names = own.iter().map(|parameter| &parameter.name);
        let all: Vec<String> = names.iter().map(|(name, _)| name).chain(own_names).cloned().collect();
        let value = fields.value("formula")?;
        let Some(text) = value.text() else {
            self.reader.wrong_kind(&fields.full("formula"), "a formula in quotes", value);
            return None;
        };
        let formula = Formula::of_values(text, value.span, self.reader.scope(), &all)
            .map_err(|problems| self.reader.say_all(problems, value.span, text))
            .ok()?;
        let place = |name: &str| fields.entry(name).map_or(entry.key_span, |entry| entry.value.span);
        let promises = Promises {
            rises_in: rises_in.and_then(|rising| Some((self.rising(rising, &names)?, place("rises_in")))),
            lipschitz: lipschitz.map(|bound| (bound, place("lipschitz"))),
        };
        if let Some(axis) = formula.names().find(|name| matches!(*name, "x" | "y" | "z")) {
            for entry in ["rises_in", "lipschitz"].into_iter().filter_map(|name| fields.entry(name)) {
                let problem = format!("`{}` is about the fields alone, and the formula names `{axis}`", entry.key);
                self.reader.say(Diagnostic::error(entry.key_span, problem).help("leave it out"));
            }
        }
        let name = entry.key.clone();
        let names = names.into_iter().map(|(name, _)| name).collect();
        Some(Operation { name, fields: names, formula, parameters: own, promises, reach })
    }

    /// Names of a list, with their places.
    fn names(&self, fields: &Fields<'r, 'a>, key: &str) -> Option<Vec<(String, Span)>> {
        let value = fields.value(key)?;
        let texts = |list: &[Value]| list.iter().map(|value| Some((value.text()?.to_owned(), value.span))).collect();
        let names: Option<Vec<_>> = value.list().filter(|list| !list.is_empty()).and_then(texts);
        if names.is_none() {
            self.reader.wrong_kind(&fields.full(key), "a list of names, such as [\"a\", \"b\"]", value);
        }
        names
    }

    /// Says which fields cannot be names in the formula, or are the names of something else there.
    fn check_names(&self, fields: &[(String, Span)], own: &[Parameter]) {
        let scope = self.reader.scope();
        let own = own.iter().map(|parameter| &parameter.name);
        let mut known: BTreeSet<&String> = own.chain(scope.parameters.iter()).collect();
        for (name, span) in fields {
            check_name(self.reader, name, *span);
            if !known.insert(name) {
                let problem = format!("`{}` is the name of something else in this formula already", clip(name));
                self.reader.say(Diagnostic::error(*span, problem));
            }
        }
    }

    /// Parameters stand among the keys of shapes.
    fn check_own_parameters(&self, path: &str, table: &Table) {
        let scope = self.reader.scope();
        for Entry { key, key_span, .. } in &table.0 {
            check_name(self.reader, key, *key_span);
            let taken = taken(key).or(scope.parameters.contains(key).then_some("a parameter of the scene"));
            if let Some(taken) = taken {
                let problem = format!("`{}` of `{}` is the name of {taken}", clip(key), clip(path));
                self.reader.say(Diagnostic::error(*key_span, problem).help("give the parameter another name"));
            }
        }
    }

    /// The places of some fields among all.
    fn rising(&self, rising: Vec<(String, Span)>, fields: &[(String, Span)]) -> Option<Vec<usize>> {
        let place = |(name, span): (String, Span)| {
            let found = fields.iter().position(|(field, _)| *field == name);
            if found.is_none() {
                let problem = Diagnostic::error(span, format!("`{}` is none of `fields`", clip(&name)));
                self.reader.say(problem.suggest(&name, fields.iter().map(|(name, _)| name.as_str())));
            }
            found
        };
        let places: Vec<Option<usize>> = rising.into_iter().map(place).collect();
        places.into_iter().collect()
    }

    /// The operation that an entry of a shape names.
    pub(super) fn operation_of(&self, entry: &Entry) -> Option<&Option<Arc<Operation>>> {
        self.operations.get(self.global(&entry.key).as_str())
    }

    /// The values of a shape that is made by an operation.
    pub(super) fn applied(&mut self, path: &str, entry: &'r Entry, table: &'r Table, id: ShapeId) -> Option<Arguments> {
        let full = |name: &str| format!("{path}.{name}");
        self.reader.note_value(&full(&entry.key), &entry.value);
        let shapes = self.operand_list(&full(&entry.key), &entry.value, 1, id);
        // What is wrong with it was said.
        let operation = self.operation_of(entry)?.clone()?;
        let mut numbers = Vec::with_capacity(operation.parameters.len());
        for parameter in &operation.parameters {
            let path = full(&parameter.name);
            let given = table.get(&parameter.name);
            let default = (self.reader.sources.text(parameter.value.span), crate::text::value::Origin::Default);
            match given {
                Some(given) => self.reader.note_value(&path, &given.value),
                None => self.reader.note(&path, default.0, default.1),
            }
            let value = given.map(|given| self.reader.number(&path, parameter.value.limit, &given.value));
            numbers.push(value.unwrap_or_else(|| parameter.value.clone()));
        }
        let shapes = shapes?;
        if shapes.len() != operation.fields.len() {
            let names: Vec<&str> = operation.fields.iter().map(String::as_str).collect();
            let (wanted, given) = (operation.fields.len(), shapes.len());
            let problem = format!("`{}` takes {wanted} shapes, and these are {given}", clip(&full(&entry.key)));
            let help = format!("one for each of its fields, {}", listed(&names));
            self.reader.say(Diagnostic::error(entry.value.span, problem).help(help));
            return None;
        }
        let applied = Applied { operation, numbers };
        Some(Arguments(vec![("operation", Argument::Shapes(shapes)), ("numbers", Argument::Applied(applied))]))
    }
}

/// What a name among the keys of shapes means already.
fn taken(name: &str) -> Option<&'static str> {
    if table::maker(name).is_some() || table::step(name).is_some() {
        Some("a node")
    } else if keys::SHAPE.iter().any(|key| key.is_called(name)) {
        Some("a key of every shape")
    } else {
        None
    }
}

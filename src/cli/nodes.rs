//! `hfvdb nodes`: what scenes are made of, searched and shown.

use std::fmt::Write;

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::options::Global;
use crate::node::{Entry, catalogue};
use crate::text::diagnostic::nearest;

/// Arguments of `hfvdb nodes`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb nodes                    all of them, by their kin
  hfvdb nodes lattice            those whose name, text or source has the word
  hfvdb nodes gyroid             one: its keys with units and defaults, formula, source, example, picture
  hfvdb scenes gyroid            its example as a scene")]
pub struct Arguments {
    /// A node's name, or a word to search for
    #[arg(value_name = "WORD")]
    word: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let all = catalogue();
    let Some(word) = &arguments.word else { return list(&all.iter().collect::<Vec<_>>(), global) };
    let is_called = |entry: &&Entry| entry.name == word || entry.also.contains(&word.as_str());
    let named: Vec<&Entry> = all.iter().filter(is_called).collect();
    if !named.is_empty() {
        return show(&named, global);
    }
    // Words that begin so: `hose` is not in `whose`, and `stripe` finds stripes. All that are given, in any order.
    let wanted: Vec<String> = words(word).collect();
    let has = |entry: &&Entry| {
        let texts = [entry.name, entry.text, entry.source, entry.group];
        let known: Vec<String> = texts.iter().chain(entry.also).flat_map(|text| words(text)).collect();
        wanted.iter().all(|wanted| known.iter().any(|word| word.starts_with(wanted.as_str())))
    };
    let found: Vec<&Entry> = all.iter().filter(has).collect();
    if found.is_empty() {
        let near = nearest(word, all.iter().map(|entry| entry.name));
        let help = near.map_or_else(
            || "`hfvdb nodes` lists them all".to_owned(),
            |near| format!("did you mean `{near}`? `hfvdb nodes` lists them all"),
        );
        return Err(Failure::work(format!("no node is called, or speaks of, \"{word}\"; {help}")));
    }
    list(&found, global)
}

/// The words of a text, small.
fn words(text: &str) -> impl Iterator<Item = String> {
    text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_lowercase)
}

/// One line each, by their kin.
fn list(entries: &[&Entry], global: &Global) -> Result<(), Failure> {
    if global.json {
        return super::print_json(&json!({ "nodes": entries }));
    }
    let mut out = String::new();
    let mut group = "";
    for entry in entries {
        if entry.group != group {
            let blank = if out.is_empty() { "" } else { "\n" };
            let _ = writeln!(out, "{blank}{}", entry.group);
            group = entry.group;
        }
        let _ = writeln!(out, "  {:22} {}", entry.name, first_sentence(entry.text));
    }
    super::print(&out)
}

/// A text up to its first full stop or colon, which begins details.
fn first_sentence(text: &str) -> &str {
    let end = [". ", ": "].iter().filter_map(|stop| text.find(stop)).min();
    end.map_or(text, |end| &text[..end]).trim_end_matches('.')
}

/// All that there is to say of nodes of one name.
fn show(entries: &[&Entry], global: &Global) -> Result<(), Failure> {
    if global.json {
        return super::print_json(&json!({ "nodes": entries }));
    }
    let texts: Vec<String> = entries.iter().map(|entry| of(entry)).collect();
    super::print(&texts.join("\n"))
}

fn of(entry: &Entry) -> String {
    let mut out = String::new();
    let also = if entry.also.is_empty() { String::new() } else { format!(", also {}", entry.also.join(", ")) };
    let _ = writeln!(out, "{}{also}  ({})\n\n{}\n", entry.name, entry.group, entry.text);
    let default = if entry.default.is_empty() { String::new() } else { format!("; when left out {}", entry.default) };
    let _ = writeln!(out, "Takes    {}{default}", entry.takes);
    if !entry.formula.is_empty() {
        let _ = writeln!(out, "Formula  {}", entry.formula);
    }
    if !entry.source.is_empty() {
        let _ = writeln!(out, "Source   {}", entry.source);
    }
    if let Some(picture) = &entry.picture {
        let _ = writeln!(out, "Picture  {picture}");
    }
    if !entry.parameters.is_empty() {
        out.push_str("\nKeys beside it\n");
        for parameter in &entry.parameters {
            let also =
                if parameter.also.is_empty() { String::new() } else { format!(", {}", parameter.also.join(", ")) };
            let _ = writeln!(
                out,
                "  {}{also}: {}; when left out {}\n      {}",
                parameter.name, parameter.takes, parameter.default, parameter.text
            );
        }
    }
    if !entry.example.is_empty() {
        let example: Vec<String> = entry.example.lines().map(|line| format!("  {line}\n")).collect();
        let _ = write!(out, "\nExample\n{}", example.concat());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_is_the_first() {
        assert_eq!(first_sentence("A ball. It is round."), "A ball");
        assert_eq!(first_sentence("A box around the origin: its edges."), "A box around the origin");
        assert_eq!(first_sentence("All."), "All");
    }

    #[test]
    fn a_node_is_told_in_full() {
        let all = catalogue();
        let text = of(all.iter().find(|entry| entry.name == "gear").unwrap());
        for part in ["Takes    number", "pressure_angle: ", "degrees", "docs/images/nodes/gear.png", "  hole = 0.3"] {
            assert!(text.contains(part), "{part}\n{text}");
        }
    }
}

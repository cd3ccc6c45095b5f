//! One frame of a scene with several values of its parameters, as a grid.

use std::sync::Arc;

use super::source::{Shown, Source};
use super::target::Target;
use super::{Arguments, show, source};
use crate::bake::Interrupt;
use crate::cli::failure::Failure;
use crate::cli::job;
use crate::cli::options::{Global, SceneArguments, SceneChanges};
use crate::cli::progress::Progress;
use crate::field::Aabb;
use crate::shot::Prepared;

/// Pictures of a grid: each keeps its scene until the last is made.
const MOST: usize = 256;

/// One `--vary`: a name and its values, as they are typed.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Varied {
    name: String,
    values: Vec<String>,
}

impl Varied {
    fn read(text: &str) -> Result<Self, Failure> {
        let wrong = || Failure::usage(format!("--vary {text}: it is NAME=VALUE,VALUE,…, such as --vary size=0.5,1,2"));
        let (name, values) = text.split_once('=').ok_or_else(wrong)?;
        let values = split(values);
        if name.trim().is_empty() || values.iter().any(|value| value.trim().is_empty()) {
            return Err(wrong());
        }
        Ok(Self { name: name.trim().into(), values: values.into_iter().map(|value| value.trim().to_owned()).collect() })
    }
}

/// The parts between commas that stand in no bracket and no quotes.
fn split(text: &str) -> Vec<&str> {
    let (mut depth, mut quote, mut begin) = (0_i32, None, 0);
    let mut parts = Vec::new();
    for (i, letter) in text.char_indices() {
        match (quote, letter) {
            (Some(open), _) if open == letter => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(letter),
            (None, '[' | '{' | '(') => depth += 1,
            (None, ']' | '}' | ')') => depth -= 1,
            (None, ',') if depth == 0 => {
                parts.push(&text[begin..i]);
                begin = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[begin..]);
    parts
}

/// All combinations, the last name changing fastest: a row of the grid goes through its values.
fn combinations(varied: &[Varied]) -> Vec<Vec<String>> {
    varied.iter().fold(vec![Vec::new()], |before, Varied { name, values }| {
        let with = |set: &Vec<String>| {
            let set = set.clone();
            values.iter().map(move |value| set.iter().cloned().chain([format!("{name}={value}")]).collect())
        };
        before.iter().flat_map(with).collect()
    })
}

/// Makes the pictures, and writes what is made of them.
pub fn run(arguments: &Arguments, target: &Target, interrupt: &Interrupt, global: &Global) -> Result<(), Failure> {
    let varied = arguments.vary.iter().map(|text| Varied::read(text)).collect::<Result<Vec<_>, _>>()?;
    let count: usize = varied.iter().map(|one| one.values.len()).fold(1, usize::saturating_mul);
    if count > MOST {
        return Err(Failure::usage(format!("--vary makes {count} pictures, and {MOST} are the most: fewer values")));
    }
    let all = combinations(&varied);
    let progress = Progress::new(all.len(), global);
    let sampling = source::sampling(arguments, target);
    let default = source::default_resolution(arguments, target, all.len());
    let limit = job::limit(&sampling);
    let mut prepared: Vec<(Arc<Prepared>, i64)> = Vec::new();
    let mut bounds: Option<Aabb> = None;
    for set in &all {
        let changes = SceneChanges {
            set: arguments.changes.set.iter().chain(set).cloned().collect(),
            variant: arguments.changes.variant.clone(),
        };
        let about = |failure: Failure| failure.about(&set.join(", "));
        let scene = SceneArguments { scene: arguments.inputs[0].clone(), changes };
        let model = job::load(&scene, global).map_err(about)?;
        let frames = job::frames(arguments.frames.as_ref(), &model, global)?;
        if arguments.frames.is_some() && frames.numbers().len() > 1 {
            return Err(Failure::usage("--vary shows one frame of each: name it with --frames"));
        }
        let mut ready = job::prepare(&model, &sampling, default, interrupt, &progress, global).map_err(about)?;
        ready.feet = source::feet(arguments, target);
        bounds = Some(bounds.map_or(ready.extent, |bounds| bounds.union(ready.extent)));
        prepared.push((Arc::new(ready), frames.numbers()[0]));
    }
    let compute = |place: usize| -> Result<Shown, Failure> {
        let (ready, frame) = &prepared[place];
        let shown =
            source::frame_of(arguments, target, ready, *frame, limit, interrupt, &|share| progress.at(place, share));
        shown.map_err(|failure| failure.about(&all[place].join(", ")))
    };
    let frame = arguments.frames.as_ref().map_or_else(String::new, |frames| format!(", frame {frames}"));
    let source = Source {
        name: format!("{}{frame}", arguments.inputs[0]),
        numbers: (1..=all.len() as i64).collect(),
        labels: Some(all.iter().map(|set| set.join(" ")).collect()),
        columns: varied.last().map(|one| one.values.len()),
        bounds: bounds.expect("there is at least one"),
        compute: &compute,
        change_of_shape: &|_| None,
    };
    show(arguments, target, &source, interrupt, &progress, global)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_told_apart() {
        let read = |text: &str| {
            Varied::read(text).map(|one| (one.name, one.values)).map_err(|failure| failure.message().to_owned())
        };
        assert_eq!(read("a=0.1, 1,10"), Ok(("a".into(), ["0.1", "1", "10"].map(String::from).to_vec())));
        assert_eq!(read("c=[1, 2],'x,y'").unwrap().1, ["[1, 2]", "'x,y'"]);
        for wrong in ["a", "=1", "a=", "a=1,,2"] {
            assert!(read(wrong).unwrap_err().contains("--vary size=0.5,1,2"), "{wrong}");
        }
    }

    #[test]
    fn the_last_name_changes_fastest() {
        let varied = ["a=1,2", "b=3,4"].map(|text| Varied::read(text).unwrap());
        let all: Vec<String> = combinations(&varied).iter().map(|set| set.join(" ")).collect();
        assert_eq!(all, ["a=1 b=3", "a=1 b=4", "a=2 b=3", "a=2 b=4"]);
    }
}

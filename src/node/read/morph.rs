//! The morph and the output.

use std::collections::BTreeSet;

use crate::attribute::Primaries;
use crate::distance::without::Keep;

use super::Building;
use super::chain::Link;
use super::links::Node;
use crate::node::argument::{Argument, Arguments};
use crate::node::keys;
use crate::node::list::MODES;
use crate::node::model::{
    Component, Content, DelaySource, Morph, MorphCarry, MorphDelay, MorphEase, MorphMode, Output, Placement, ShapeId,
};
use crate::node::morph_mode::{ModeSpec, SHARED};
use crate::text::diagnostic::{Diagnostic, clip, listed};
use crate::text::frames::{FrameRange, Shot};
use crate::text::key::{Kind, Limit};
use crate::text::number::{Number, NumberValue};
use crate::text::reader::{Fields, NO_OWNER};
use crate::text::source::Span;
use crate::text::value::{Table, Value};
use crate::vdb::{Client, Three};

impl<'r, 'a> Building<'r, 'a> {
    /// `None` where there is none, or where an error was said.
    pub(super) fn morph(&mut self, shot: &Shot) -> Option<Vec<Morph>> {
        let entry = self.root.get("morph")?;
        let keys = keys::morph_keys().collect();
        let fields = Fields::of_value(self.reader, "morph", NO_OWNER, entry.key_span, &entry.value, keys)?;
        let cut = fields.value("cut").and_then(|value| self.shape_reference("morph.cut", value));
        let mode = self.morph_mode(&fields);
        let ease = self.ease(&fields, "ease");
        let carry_ease = self.ease(&fields, "carry_ease");
        let eases = [("ease", ease.as_ref()), ("carry_ease", carry_ease.as_ref())];
        let chain = self.chain(&fields, &eases, shot);
        let fill = fields.value("fill").and_then(|value| self.fill(value));
        let correspondences = self.correspondence(&fields, chain.as_deref());
        let carries = self.carry(&fields, chain.as_deref());
        if shot.still {
            let problem = Diagnostic::error(entry.key_span, "a morph needs the scene's `frames`");
            self.reader.say(problem.help("such as frames = \"1-48\""));
        }
        let (chain, carries) = (chain?, carries?);
        let morph = Morph {
            cut,
            keep: Keep {
                largest_only: fields.choice("keep") == Some("largest"),
                least_volume: fields.constant("min_piece").unwrap_or(0.0),
            },
            even_pace: fields.choice("pace") == Some("even"),
            mode,
            in_plane: false,
            height: fields.constant("height"),
            carry: MorphCarry::Left,
            carry_ease,
            arc: fields.value("arc").and_then(|value| self.fixed_vector("morph.arc", value)).unwrap_or_default(),
            placement: Placement {
                scale: [(); 3].map(|()| fields.required_number("scale")),
                rotate: fields.required_vector("rotate"),
                translate: fields.required_vector("move"),
            },
            ease: ease.unwrap_or(MorphEase::Linear),
            octopus: fields.flag("octopus"),
            colour_space: fields.choice("color_space").unwrap_or("auto"),
            alpha: fields.required_number("alpha"),
            beta: fields.required_number("beta"),
            over: chain[0].over,
            colour_over: chain[0].colour_over,
            correspondence: None,
            displace: self.scalar_name(&fields, "displace"),
            fill,
            span: entry.key_span,
            from: chain[0].from,
            to: chain[0].to,
        };
        let link = |(place, link): (usize, Link)| Morph {
            correspondence: correspondences.as_ref().map(|all| all[place].clone()),
            carry: carries[place].clone(),
            from: link.from,
            to: link.to,
            over: link.over,
            colour_over: link.colour_over,
            ..morph.clone()
        };
        let morphs: Vec<Morph> = chain.into_iter().enumerate().map(link).collect();
        self.check_morph_scalars(&morphs);
        Some(morphs)
    }

    fn morph_mode(&mut self, fields: &Fields<'r, 'a>) -> MorphMode {
        let name = fields.choice("mode");
        let spec = MODES.iter().find(|mode| Some(mode.key.name) == name).unwrap_or(&MODES[0]);
        self.keys_of_mode(fields, spec);
        let mut arguments = Arguments::default();
        for key in spec.parameters {
            let argument = match key.kind {
                Kind::Number => fields.number(key.name).map(Argument::Number),
                Kind::Span => self.two_rising(fields, key.name).map(|ends| Argument::Pair(Box::new(ends))),
                Kind::Delay => {
                    fields.value(key.name).and_then(|value| self.delay(value)).map(Box::new).map(Argument::Delay)
                }
                Kind::Round => {
                    fields.value(key.name).and_then(|value| self.round(value)).map(Box::new).map(Argument::Round)
                }
                kind => unreachable!("`{}` of a mode is {kind:?}", key.name),
            };
            arguments.0.extend(argument.map(|argument| (key.name, argument)));
        }
        MorphMode { spec, arguments }
    }

    /// Says which keys the mode does not use.
    fn keys_of_mode(&self, fields: &Fields<'r, 'a>, mode: &ModeSpec) {
        let takes = |mode: &ModeSpec, name: &str| {
            mode.shared.contains(&name) || mode.parameters.iter().any(|key| key.name == name)
        };
        let own = MODES.iter().flat_map(|mode| mode.parameters).map(|key| key.name);
        for name in own.chain(SHARED).filter(|name| !takes(mode, name)) {
            let Some(entry) = fields.entry(name) else { continue };
            let modes: Vec<&str> = MODES.iter().filter(|mode| takes(mode, name)).map(|mode| mode.key.name).collect();
            self.reader.say(match modes[..] {
                [only] => {
                    let problem = format!("`{}` is for `mode = \"{only}\"` only", entry.key);
                    Diagnostic::error(entry.key_span, problem)
                }
                _ => {
                    let problem = format!("`{}` is not for `mode = \"{}\"`", entry.key, mode.key.name);
                    Diagnostic::error(entry.key_span, problem).help(format!("it goes with {}", all_of(&modes)))
                }
            });
        }
    }

    /// `"linear"`, `"smooth"`, or the progress itself; `None` where the key is left out.
    fn ease(&self, fields: &Fields<'r, 'a>, name: &str) -> Option<MorphEase> {
        const NAMES: [&str; 2] = ["linear", "smooth"];
        let (path, value) = (fields.full(name), fields.value(name)?);
        Some(match value.text() {
            Some("linear") => MorphEase::Linear,
            Some("smooth") => MorphEase::Smooth,
            // A single word is meant as a name, unless it is one that formulas know.
            Some(text) if text.chars().all(char::is_alphabetic) && !matches!(text, "t" | "frame" | "time") => {
                self.reader.choice_problem(&path, &NAMES, value);
                MorphEase::Linear
            }
            _ => MorphEase::Progress(self.reader.number(&path, Limit::Within(0.0, 1.0), value)),
        })
    }

    /// Two numbers, the second greater where both stand still.
    fn two_rising(&self, fields: &Fields<'r, 'a>, name: &str) -> Option<[Number; 2]> {
        let (path, value) = (fields.full(name), fields.value(name)?);
        let Some([lo, hi]) = value.list() else {
            self.reader.wrong_kind(&path, "two numbers, [least, greatest]", value);
            return None;
        };
        let ends = [lo, hi].map(|end| self.reader.number(&path, Limit::Any, end));
        if let [NumberValue::Constant(lo), NumberValue::Constant(hi)] = [&ends[0].value, &ends[1].value]
            && lo >= hi
        {
            let problem = format!("`{path}` takes two numbers, [least, greatest]");
            self.reader.say(Diagnostic::error(value.span, problem));
        }
        Some(ends)
    }

    /// A number, a formula of space, or what a shape has.
    fn delay(&mut self, value: &'r Value) -> Option<MorphDelay> {
        const PATH: &str = "morph.delay";
        let span = value.span;
        if let Some(table) = value.table() {
            let fields = Fields::new(self.reader, PATH, NO_OWNER, span, table, keys::DELAY.iter().collect());
            let shape = self.shape_reference("morph.delay.shape", fields.value("shape")?)?;
            let attribute = fields.text("attribute");
            if let (Some(name), Some(entry)) = (&attribute, fields.entry("attribute"))
                && !self.is_scalar(name)
            {
                let known: Vec<&str> =
                    self.shapes.iter().flatten().flat_map(|shape| shape.scalars.keys().map(String::as_str)).collect();
                self.reader.choice_problem("morph.delay.attribute", &known, &entry.value);
                return None;
            }
            let most = fields.constant("most").unwrap_or(0.5);
            return Some(MorphDelay { source: DelaySource::Shape { shape, attribute, most }, span });
        }
        let component = match value.text() {
            None => {
                let number = self.reader.constant(PATH, Limit::Within(0.0, 0.95), value);
                Component::Number(Number::constant(number, PATH, span))
            }
            Some(text) => {
                let formula = self.reader.formula_of_space(text, span)?;
                if formula.distances().next().is_some() {
                    let problem = Diagnostic::error(span, "`dist` is for formulas of shapes");
                    self.reader.say(problem.help("delay = { shape = …, attribute = … } goes by what a shape has"));
                    return None;
                }
                Component::Formula(formula)
            }
        };
        Some(MorphDelay { source: DelaySource::Space(component), span })
    }

    fn round(&self, value: &'r Value) -> Option<[Number; 4]> {
        let keys = keys::ROUND.iter().collect();
        let fields = Fields::of_value(self.reader, "morph.round", NO_OWNER, value.span, value, keys)?;
        Some(["a0", "reach", "a3", "depth"].map(|name| fields.required_number(name)))
    }

    pub(super) fn within_shot(&self, fields: &Fields<'r, 'a>, name: &str, shot: &Shot) -> Option<FrameRange> {
        let range = fields.frames(name)?;
        let span = fields.entry(name).map_or(fields.span, |entry| entry.value.span);
        if range.count() < 2 {
            let problem = format!("`{}` needs at least two frames", fields.full(name));
            self.reader.say(Diagnostic::error(span, problem));
        } else if range.first < shot.range.first || range.last > shot.range.last {
            let FrameRange { first, last } = shot.range;
            let problem = format!("`{}` reaches beyond the scene's frames, {first}-{last}", fields.full(name));
            self.reader.say(Diagnostic::warning(span, problem).help("the morph is not whole within the shot"));
        }
        Some(range)
    }

    /// The output, and the shape that it names.
    pub(super) fn output(&mut self) -> (Output, Option<(ShapeId, Span)>) {
        let keys = keys::OUTPUT.iter().collect();
        let entry = self.root.get("output");
        let span = entry.map_or_else(Span::default, |entry| entry.key_span);
        let fields = match entry {
            Some(entry) => Fields::of_value(self.reader, "output", NO_OWNER, span, &entry.value, keys),
            None => Some(Fields::new(self.reader, "output", NO_OWNER, span, &NOTHING, keys)),
        };
        let Some(fields) = fields else { return (default_output(), None) };
        let chosen =
            fields.value("shape").and_then(|value| Some((self.shape_reference("output.shape", value)?, value.span)));
        if let (Some(size), Some(_)) = (fields.entry("voxel_size"), fields.entry("resolution")) {
            let problem = "`voxel_size` and `resolution` say the same thing twice";
            self.reader.say(Diagnostic::error(size.key_span, problem));
        }
        let program = fields.choice("for").and_then(|name| name.parse::<Client>().ok()).map(Client::program);
        let name = fields.text("color_name").unwrap_or_else(|| match program.map(|program| program.colour) {
            Some(Three::Vectors(name)) => name.into(),
            _ => "Cd".into(),
        });
        let taken = ["surface", "density", "vel"].contains(&name.as_str()) || self.is_scalar(&name);
        if name.is_empty() || taken || name.contains(char::is_whitespace) {
            let problem = format!("a grid cannot be called `{}`", clip(&name));
            self.reader
                .say(Diagnostic::error(fields.entry("color_name").map_or(span, |entry| entry.value.span), problem));
        }
        let mut grids = self.grids(&fields, "grids", &name);
        let fog = program.is_some_and(|program| program.shows_fog);
        if let Some(grids) = grids.as_mut().filter(|grids| fog && !grids.iter().any(|name| name == "density")) {
            grids.push("density".into());
        }
        let output = Output {
            inside: fields.flag("inside"),
            density: grids
                .as_ref()
                .map_or_else(|| fog || self.is_scalar("density"), |all| all.iter().any(|name| name == "density")),
            voxel_size: fields.constant("voxel_size"),
            resolution: fields.whole("resolution").unwrap_or(256).clamp(1, i64::from(u32::MAX)) as u32,
            half_width: fields.constant("half_width").unwrap_or(3.0),
            grids,
            half: self.grids(&fields, "half", &name).unwrap_or_default(),
            compression: fields.choice("compression").unwrap_or("blosc"),
            colour_name: name,
            program,
            primaries: fields.choice("color_space").and_then(Primaries::named),
            max_speed: fields.constant("max_speed"),
            distance: self.measured_by(&fields),
            step: self.step(&fields),
        };
        (output, chosen)
    }

    /// What OpenVDB makes has no motion to tell between its frames.
    pub(super) fn check_velocity(&self, morph: Option<&[Morph]>, output: &Output) {
        if let Some([Morph { mode, span, .. }, ..]) = morph
            && mode.spec.by_level_sets
            && output.writes("vel")
        {
            let problem = "`output.grids` has `vel`, which `mode = \"openvdb\"` does not give";
            self.reader.say(Diagnostic::error(*span, problem).help("leave it out, or use another `mode`"));
        }
    }

    /// Whether a shape has a scalar of this name.
    fn is_scalar(&self, name: &str) -> bool {
        self.shapes.iter().flatten().any(|shape| shape.scalars.contains_key(name))
    }

    /// Names of grids that this scene's frames may have; `None` where they are left out.
    fn grids(&self, fields: &Fields<'r, 'a>, key: &str, colour: &str) -> Option<Vec<String>> {
        let value = fields.value(key)?;
        let path = fields.full(key);
        let scalars = self.shapes.iter().flatten().flat_map(|shape| shape.scalars.keys().map(String::as_str));
        let mut known: Vec<&str> = ["surface", "density", colour, "vel"].into_iter().chain(scalars).collect();
        known.sort_unstable();
        known.dedup();
        // What a program calls the colour is no reason to write its name anew.
        let is_colour = |name: &str| name == "Cd" && fields.entry("for").is_some() && !known.contains(&"Cd");
        let Some(list) = value.list().filter(|list| key != "grids" || !list.is_empty()) else {
            self.reader.wrong_kind(&path, &format!("a list of {}", listed(&known)), value);
            return None;
        };
        let mut names = Vec::new();
        for value in list {
            match value.text() {
                Some(name) if is_colour(name) => names.push(colour.to_owned()),
                Some(name) if known.contains(&name) => names.push(name.to_owned()),
                _ => self.reader.choice_problem(&path, &known, value),
            }
        }
        if key == "grids" && !names.iter().any(|name| name == "surface") {
            let problem =
                Diagnostic::error(value.span, "`output.grids` has no `surface`, on whose voxels all others stand");
            self.reader.say(problem.help("add it to the list"));
        }
        Some(names)
    }

    /// What is baked: the morph, else the shape that is named, else the one that nobody uses.
    pub(super) fn content(&self, morph: Option<Vec<Morph>>, chosen: Option<(ShapeId, Span)>) -> Option<Content> {
        if let Some(morph) = morph {
            if let Some((_, span)) = chosen {
                self.reader.say(Diagnostic::warning(span, "`output.shape` is not used: the morph is what is baked"));
            }
            return Some(Content::Morph(morph));
        }
        if self.root.get("morph").is_some() {
            return None;
        }
        if let Some((id, _)) = chosen {
            return Some(Content::Shape(id));
        }
        let used: BTreeSet<Node> = self.links.iter().map(|link| link.to).collect();
        // What a file brings is there to be used.
        let is_own = |name: &str| self.surroundings.namespaces.of(name).is_empty();
        let mut free = self.shape_ids.iter().filter(|(name, id)| is_own(name) && !used.contains(&Node::Shape(**id)));
        match (free.next(), free.next()) {
            (Some((_, id)), None) => Some(Content::Shape(*id)),
            // What is asked of a scene that is otherwise wrong may be answered once it is right.
            _ if self.reader.has_errors() => None,
            (None, _) if self.shape_ids.is_empty() => {
                if self.root.get("shape").is_some_and(|entry| entry.value.table().is_none()) {
                    return None;
                }
                self.reader
                    .say(Diagnostic::without_place("the scene has no shape").help("[shape.ball] with sphere = 1"));
                None
            }
            // A cycle, which is said elsewhere.
            (None, _) => None,
            (Some((first, _)), Some((second, id))) => {
                let span = family_span(self, *id);
                let problem = format!("what is to be baked, `{}` or `{}`?", clip(first), clip(second));
                self.reader
                    .say(Diagnostic::error(span, problem).help("join them, or name one: [output] with shape = \"…\""));
                None
            }
        }
    }
}

/// `a`, `b` and `c`.
fn all_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

/// The output table of a scene without one.
static NOTHING: Table = Table(Vec::new());

fn family_span(building: &Building<'_, '_>, id: ShapeId) -> Span {
    super::family(building.root, "shape").nth(id.0).map_or_else(Span::default, |entry| entry.key_span)
}

fn default_output() -> Output {
    Output {
        voxel_size: None,
        resolution: 256,
        half_width: 3.0,
        grids: None,
        half: Vec::new(),
        compression: "blosc",
        colour_name: "Cd".into(),
        program: None,
        primaries: None,
        max_speed: None,
        distance: None,
        step: None,
        inside: false,
        density: false,
    }
}

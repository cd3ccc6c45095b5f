//! What is wrong with a scene, and how it is told: the place marked, the nearest name, at most ten within 2 KB.

use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

use crate::terminal;
use crate::text::source::{Place, Sources, Span};

/// The most messages that are shown of one scene.
const MOST_SHOWN: usize = 10;
/// The most bytes of one report. Past it, messages lose their marked text, then are only counted.
const MOST_BYTES: usize = 2048;
/// Of them for the line that counts what is not shown.
const ROOM_FOR_COUNT: usize = 32;
/// The most bytes of a message, of its label and of its help where the whole does not fit: several still do.
const MOST_OF_A_PART: usize = 320;

/// The most names that are listed where none is near.
const MOST_LISTED: usize = 40;

/// Whether the scene can be used all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The scene cannot be used.
    Error,
    /// The scene is used as the message says.
    Warning,
    /// Good to know.
    Note,
}

/// One thing to say about a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Whether the scene can be used all the same.
    pub severity: Severity,
    /// What is wrong, in one line.
    pub message: String,
    /// The text it is about; `None` where it is about no text at all, such as a scene that is not there.
    pub span: Option<Span>,
    /// A few words at the marked text.
    pub label: String,
    /// What to do next: the nearest valid name, the choices.
    pub help: String,
}

impl Diagnostic {
    /// An error about a piece of text.
    pub fn error(span: Span, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            message: message.into(),
            span: Some(span),
            label: String::new(),
            help: String::new(),
        }
    }

    /// A warning about a piece of text.
    pub fn warning(span: Span, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(span, message) }
    }

    /// An error about no place in particular.
    pub fn without_place(message: impl Into<String>) -> Self {
        Self { span: None, ..Self::error(Span::default(), message) }
    }

    /// With a few words at the marked text.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// With what to do next.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }

    /// The same in less room.
    fn shortened(&self) -> Self {
        // What is escaped is longer.
        let part = |text: &str| without_middle(&terminal::message(text), MOST_OF_A_PART).into_owned();
        Self { message: part(&self.message), label: part(&self.label), help: part(&self.help), ..*self }
    }

    /// With the nearest of the names, or else all of them, of very many the first.
    pub fn suggest<'n>(self, wrong: &str, names: impl IntoIterator<Item = &'n str>) -> Self {
        let names: Vec<&str> = names.into_iter().collect();
        let help = match nearest(wrong, names.iter().copied()) {
            Some(name) => format!("did you mean `{name}`?"),
            None if names.is_empty() => return self,
            None => format!("there is {}", some_of(&names)),
        };
        self.help(help)
    }
}

/// The name nearest to a wrong one, where one is near enough to be meant.
pub fn nearest<'n>(wrong: &str, names: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    /// More names than people give, and than are compared in a moment.
    const MOST_LOOKED_AT: usize = 10_000;
    let wrong = clip(wrong);
    let limit = (wrong.chars().count() / 3).max(1);
    names
        .into_iter()
        .take(MOST_LOOKED_AT)
        .map(|name| (strsim::damerau_levenshtein(&wrong.to_lowercase(), &name.to_lowercase()), name))
        .filter(|&(distance, name)| distance <= limit || (wrong.len() > 2 && name.starts_with(wrong.as_ref())))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}

/// Names in a row: `a`, `b` and `c`.
pub fn listed(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", clip(name))).collect();
    match quoted.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
    }
}

/// The same of the first of many.
pub fn some_of(names: &[&str]) -> String {
    first_of(names, MOST_LISTED)
}

/// The first so many, and how many more there are.
pub fn first_of(names: &[&str], most: usize) -> String {
    if names.len() <= most {
        return listed(names);
    }
    let quoted: Vec<String> = names[..most].iter().map(|name| format!("`{}`", clip(name))).collect();
    format!("{} and {} more", quoted.join(", "), names.len() - most)
}

/// A user's text, cut so that one hostile name cannot fill the report.
pub fn clip(text: &str) -> std::borrow::Cow<'_, str> {
    const MOST_CHARACTERS: usize = 48;
    terminal::clipped(text, MOST_CHARACTERS)
}

/// A text of at most so many bytes: its middle goes, for its beginning says what it is about and its end what to do.
fn without_middle(text: &str, most: usize) -> std::borrow::Cow<'_, str> {
    const MARK: &str = " … ";
    if text.len() <= most {
        return text.into();
    }
    let room = most.saturating_sub(MARK.len());
    let (mut first, mut last) = (room * 2 / 3, text.len() - room / 3);
    while !text.is_char_boundary(first) {
        first -= 1;
    }
    while !text.is_char_boundary(last) {
        last += 1;
    }
    format!("{}{MARK}{}", &text[..first], &text[last..]).into()
}

/// Everything that is to be said about one scene, in the order of the text.
#[derive(Clone, Debug)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    sources: Arc<Sources>,
}

impl Diagnostics {
    /// Messages about these texts; sorted by place, the same message about the same place once.
    pub fn new(mut list: Vec<Diagnostic>, sources: Arc<Sources>) -> Self {
        list.sort_by_key(|diagnostic| diagnostic.span.map(|span| (span.source, span.start)));
        list.dedup();
        Self { list, sources }
    }

    /// Leaves out what is only good to know: it is not, beside errors.
    pub fn drop_notes(&mut self) {
        self.list.retain(|diagnostic| diagnostic.severity != Severity::Note);
    }

    /// All messages.
    pub fn list(&self) -> &[Diagnostic] {
        &self.list
    }

    /// Whether there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Where a message points to.
    pub fn place(&self, diagnostic: &Diagnostic) -> Option<Place> {
        diagnostic.span.map(|span| self.sources.place(span))
    }

    /// The report: errors first, ten messages at most, within 2 KB without the colours; the first always, as much of it as
    /// there is room for. `styled` adds the terminal's colours.
    pub fn render(&self, styled: bool) -> String {
        let mut order: Vec<&Diagnostic> = self.list.iter().collect();
        order.sort_by_key(|diagnostic| diagnostic.severity);
        let shortened: Vec<Diagnostic> =
            order.iter().take(MOST_SHOWN).map(|diagnostic| diagnostic.shortened()).collect();
        let briefs: Vec<String> = shortened.iter().map(|diagnostic| self.brief(diagnostic)).collect();
        let (mut report, mut bytes, mut shown) = (String::new(), 0, 0);
        for (i, brief) in briefs.iter().enumerate() {
            // Those that follow keep room for a line each.
            let rest: usize = briefs[i + 1..].iter().map(String::len).sum();
            let fits = |text: &str, rest: usize| bytes + text.len() + rest + ROOM_FOR_COUNT <= MOST_BYTES;
            let whole = [order[i], &shortened[i]]
                .into_iter()
                .find(|diagnostic| fits(&self.marked(diagnostic, &Renderer::plain()), rest));
            let plain = match whole {
                Some(diagnostic) => self.marked(diagnostic, &Renderer::plain()),
                None => brief.clone(),
            };
            if !fits(&plain, 0) {
                break;
            }
            bytes += plain.len();
            shown += 1;
            match whole.filter(|_| styled) {
                Some(diagnostic) => report += &self.marked(diagnostic, &Renderer::styled()),
                None => report += &plain,
            }
        }
        if shown < order.len() {
            report.push_str(&format!("and {} more\n", order.len() - shown));
        }
        report
    }

    /// The scene's own text, where a message is about none: it names the file all the same.
    fn scene(&self) -> Option<&str> {
        self.sources.first().map(|source| source.name.as_str())
    }

    /// A message in one line.
    fn brief(&self, diagnostic: &Diagnostic) -> String {
        let kind = match diagnostic.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        let help = if diagnostic.help.is_empty() { String::new() } else { format!("; {}", diagnostic.help) };
        let place = match self.place(diagnostic) {
            Some(Place { file, line, column }) => format!("{}:{line}:{column}: ", short_path(&file)),
            None => self.scene().map_or_else(String::new, |name| format!("{}: ", short_path(name))),
        };
        terminal::message(&format!("{place}{kind}: {}{help}\n", diagnostic.message)).into_owned()
    }

    /// A message with the text it is about.
    fn marked(&self, diagnostic: &Diagnostic, renderer: &Renderer) -> String {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
            Severity::Note => Level::NOTE,
        };
        let mut group = Group::with_title(level.primary_title(diagnostic.message.as_str()));
        if let Some(name) = self.scene().filter(|_| diagnostic.span.is_none()) {
            group = group.element(Origin::path(short_path(name)));
        }
        if let Some(span) = diagnostic.span {
            let source = self.sources.get(span.source);
            let range = within_one_line(&source.text, span);
            let annotation = AnnotationKind::Primary.span(range).label(diagnostic.label.as_str());
            group = group
                .element(Snippet::source(source.text.as_str()).path(short_path(&source.name)).annotation(annotation));
        }
        if !diagnostic.help.is_empty() {
            group = group.element(Level::HELP.message(diagnostic.help.as_str()));
        }
        format!("{}\n", renderer.clone().term_width(100).render(&[group]))
    }
}

impl Display for Diagnostics {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.render(false).trim_end())
    }
}

impl std::error::Error for Diagnostics {}

/// The end of a long path, which tells more than its beginning.
fn short_path(path: &str) -> String {
    const MOST_CHARACTERS: usize = 80;
    let path = terminal::one_line(path);
    let count = path.chars().count();
    if count <= MOST_CHARACTERS {
        return path.into_owned();
    }
    let end: String = path.chars().skip(count - MOST_CHARACTERS + 1).collect();
    format!("…{end}")
}

/// A mark over many lines would fill the report: it ends with its first line.
fn within_one_line(text: &str, span: Span) -> std::ops::Range<usize> {
    let boundary = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let (start, end) = (boundary(span.start), boundary(span.end.max(span.start)));
    let line_end = text[start..].find(['\n', '\r']).map_or(text.len(), |i| start + i);
    start..end.min(line_end).max(start)
}

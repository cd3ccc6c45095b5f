//! The texts that a scene is made of, and places in them.

use std::ops::Range;

/// A piece of one of a scene's texts, as bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Span {
    /// Which text: 0 is the scene's own, the others are those of imported files and of command line overrides.
    pub source: usize,
    /// The first byte.
    pub start: usize,
    /// The byte after the last.
    pub end: usize,
}

impl Span {
    /// A piece of one text.
    pub fn new(source: usize, range: Range<usize>) -> Self {
        Self { source, start: range.start, end: range.end }
    }
}

/// A line and column as people count them, from 1; columns are characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file's path as it was given, or the command line option.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
}

/// One text with the name that messages call it by.
#[derive(Clone, Debug)]
pub struct SourceText {
    /// The file's path as it was given, or the command line option.
    pub name: String,
    /// All of it.
    pub text: String,
}

/// Every text that a scene was read from.
#[derive(Clone, Debug, Default)]
pub struct Sources(Vec<SourceText>);

impl Sources {
    /// Adds a text; its number goes into the spans.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> usize {
        self.0.push(SourceText { name: name.into(), text: text.into() });
        self.0.len() - 1
    }

    /// The number of the text that was added last.
    pub fn last(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    /// The scene's own text; none where it could not be read.
    pub fn first(&self) -> Option<&SourceText> {
        self.0.first()
    }

    /// The text that a span points into.
    pub fn get(&self, source: usize) -> &SourceText {
        &self.0[source]
    }

    /// What a span marks.
    pub fn text(&self, span: Span) -> &str {
        self.0[span.source].text.get(span.start..span.end).unwrap_or("")
    }

    /// Where a span begins.
    pub fn place(&self, span: Span) -> Place {
        let source = &self.0[span.source];
        let mut start = span.start.min(source.text.len());
        while !source.text.is_char_boundary(start) {
            start -= 1;
        }
        let before = &source.text[..start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Place {
            file: source.name.clone(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_characters_and_lines_from_one() {
        let mut sources = Sources::default();
        let source = sources.add("a.toml", "é = 1\nöü = 2\n");
        let place = sources.place(Span::new(source, 12..13));
        assert_eq!((place.line, place.column), (2, 4));
        assert_eq!(sources.place(Span::new(source, 0..1)).column, 1);
        assert_eq!(sources.place(Span::new(source, 999..999)).line, 3);
    }
}

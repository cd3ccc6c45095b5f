//! Formats a scene's TOML. Spaces, line breaks, blank lines and trailing commas change; the order of keys, comments, and the
//! spelling of keys, numbers and strings (formulas among them) do not.
//!
//! * One space around `=` and after commas, none inside `[…]`, one inside `{ … }`; four spaces for each level of a list.
//! * A list that begins with a line break keeps its rows. Any other stands on one line if it fits in [`WIDTH`], otherwise it
//!   is broken into rows. An inline table is broken only where the author broke it, because TOML 1.0 knows no line breaks in it.
//! * One blank line before a table's header, at most one elsewhere.
//! * A comment behind a value keeps its column; comments that shared a column in a paragraph still do.
//!
//! Formatting a formatted text changes nothing. The tokens are those of `toml_parser`, the parser under `toml_edit`. taplo's
//! formatter was tried and left: it puts each coordinate of a long list of points on a line of its own.

use std::iter::Peekable;
use std::vec::IntoIter;

use toml_parser::lexer::{Token, TokenKind};

use crate::text::diagnostic::Diagnostic;
use crate::text::source::Span;
use crate::text::value::{Origin, parse_toml};

/// Characters of a line, without a comment behind it.
const WIDTH: usize = 120;
/// Spaces for each level.
const STEP: usize = 4;

/// Formats a TOML text; line ends become `\n`. `source` is the text's number in messages.
///
/// # Errors
/// Where the text is not TOML, with its place.
pub fn format_toml(text: &str, source: usize) -> Result<String, Diagnostic> {
    let mut before = String::new();
    parse_toml(text, source, Origin::Scene)?.canonical(&mut before);
    let mut parser = Parser { text, tokens: toml_parser::Source::new(text).lex().into_vec().into_iter().peekable() };
    let mut page = Page::default();
    parser.document(&mut page);
    let formatted = page.finish();
    let mut after = String::new();
    let same = parse_toml(&formatted, source, Origin::Scene).map(|table| table.canonical(&mut after));
    if same.is_err() || before != after {
        let problem = "formatting would change what the scene says, which is an error of this program";
        return Err(Diagnostic::error(Span::new(source, 0..0), problem).help("please report it with the file"));
    }
    Ok(formatted)
}

/// A comment behind something, with the column where it stood in the text.
struct Comment<'t> {
    text: &'t str,
    column: usize,
}

/// A value, or what stands in its place in a group.
enum Value<'t> {
    /// A number, a string, a flag.
    Plain(&'t str),
    Group(Group<'t>),
}

/// A list or an inline table.
struct Group<'t> {
    open: char,
    close: char,
    /// Whether it begins with a line break, or has comments, which need them.
    is_broken: bool,
    /// Behind the opening bracket.
    comment: Option<Comment<'t>>,
    entries: Vec<Entry<'t>>,
    /// On lines of their own before the closing bracket.
    last_comments: Vec<&'t str>,
}

/// An element of a list, or a key with its value.
struct Entry<'t> {
    starts_row: bool,
    blank_before: bool,
    /// On lines of their own before it.
    comments: Vec<&'t str>,
    /// In a table: as written, without spaces around its points.
    key: Option<String>,
    value: Value<'t>,
    comment: Option<Comment<'t>>,
}

impl Value<'_> {
    /// Whether it has line breaks of the author's, or needs them.
    fn is_broken(&self) -> bool {
        match self {
            Self::Plain(_) => false,
            Self::Group(group) => group.is_broken || group.entries.iter().any(|entry| entry.value.is_broken()),
        }
    }

    fn flat(&self, out: &mut String) {
        match self {
            Self::Plain(text) => out.push_str(text),
            Self::Group(group) => {
                out.push_str(group.opening());
                for (i, entry) in group.entries.iter().enumerate() {
                    if i > 0 {
                        out.push_str(", ");
                    }
                    entry.flat(out);
                }
                out.push_str(group.closing());
            }
        }
    }
}

impl Entry<'_> {
    fn flat(&self, out: &mut String) {
        if let Some(key) = &self.key {
            out.push_str(key);
            out.push_str(" = ");
        }
        self.value.flat(out);
    }

    fn width(&self) -> usize {
        let mut flat = String::new();
        self.flat(&mut flat);
        flat.chars().count()
    }
}

impl Group<'_> {
    fn is_spaced(&self) -> bool {
        self.open == '{' && !self.entries.is_empty()
    }

    fn opening(&self) -> &'static str {
        match (self.open, self.is_spaced()) {
            ('{', true) => "{ ",
            ('{', false) => "{",
            _ => "[",
        }
    }

    fn closing(&self) -> &'static str {
        match (self.open, self.is_spaced()) {
            ('{', true) => " }",
            ('{', false) => "}",
            _ => "]",
        }
    }
}

/// The lines of a formatted text.
#[derive(Default)]
struct Page<'t> {
    lines: Vec<Line<'t>>,
}

/// A line; a string of several lines in it counts as one.
#[derive(Default)]
struct Line<'t> {
    code: String,
    comment: Option<Comment<'t>>,
}

impl Line<'_> {
    /// The column after its last character.
    fn end(&self) -> usize {
        self.code.rsplit('\n').next().unwrap_or_default().chars().count()
    }

    fn is_blank(&self) -> bool {
        self.code.is_empty() && self.comment.is_none()
    }
}

impl<'t> Page<'t> {
    fn line(&mut self, code: String) {
        self.lines.push(Line { code, comment: None });
    }

    /// The line that is being written.
    fn last(&mut self) -> &mut String {
        if self.lines.is_empty() {
            self.lines.push(Line::default());
        }
        &mut self.lines.last_mut().expect("there is one by now").code
    }

    /// A blank line, unless one is there or the page begins.
    fn blank(&mut self) {
        if self.lines.last().is_some_and(|line| !line.is_blank()) {
            self.lines.push(Line::default());
        }
    }

    fn comment(&mut self, comment: Option<Comment<'t>>) {
        if let (Some(comment), Some(line)) = (comment, self.lines.last_mut()) {
            line.comment = Some(comment);
        }
    }

    /// Continues the last line with a value. `may_break`: whether a list that is too long is broken into rows.
    fn value(&mut self, value: Value<'t>, indent: usize, may_break: bool) {
        let group = match value {
            Value::Plain(text) => return self.last().push_str(text),
            Value::Group(group) => group,
        };
        let is_broken = group.is_broken;
        let value = Value::Group(group);
        // Its comma, or the bracket that closes what it stands in.
        let follows = usize::from(indent > 0);
        let fits = value.is_broken() || self.fits(&value, follows);
        let Value::Group(group) = value else { return };
        if is_broken || (group.open == '[' && may_break && !fits) {
            return self.rows(group, indent, is_broken);
        }
        let (opening, closing, may_break) = (group.opening(), group.closing(), may_break && group.open == '[');
        self.last().push_str(opening);
        for (i, entry) in group.entries.into_iter().enumerate() {
            if i > 0 {
                self.last().push_str(", ");
            }
            self.entry(entry.key, entry.value, indent, may_break);
        }
        self.last().push_str(closing);
    }

    fn fits(&mut self, value: &Value<'_>, follows: usize) -> bool {
        let mut flat = String::new();
        value.flat(&mut flat);
        let column = self.lines.last().map_or(0, Line::end);
        flat.contains('\n') || column + flat.chars().count() + follows <= WIDTH
    }

    fn entry(&mut self, key: Option<String>, value: Value<'t>, indent: usize, may_break: bool) {
        if let Some(key) = key {
            let last = self.last();
            last.push_str(&key);
            last.push_str(" = ");
        }
        self.value(value, indent, may_break);
    }

    /// A group in rows: the author's where `keep`, otherwise and where one is too long as many elements as fit, tables each
    /// in a row of its own.
    fn rows(&mut self, group: Group<'t>, indent: usize, keep: bool) {
        let inner = indent + STEP;
        let starts = row_starts(&group.entries, inner, keep);
        self.last().push(group.open);
        self.comment(group.comment);
        let is_list = group.open == '[';
        for (entry, starts_row) in group.entries.into_iter().zip(starts) {
            if entry.blank_before {
                self.blank_inside();
            }
            for comment in entry.comments {
                self.line(format!("{:inner$}{comment}", ""));
            }
            if starts_row {
                self.line(" ".repeat(inner));
            } else {
                self.last().push(' ');
            }
            self.entry(entry.key, entry.value, inner, is_list);
            self.last().push(',');
            self.comment(entry.comment);
        }
        for comment in group.last_comments {
            self.line(format!("{:inner$}{comment}", ""));
        }
        self.line(format!("{:indent$}{}", "", group.close));
    }

    /// A blank line in a group, not as its first.
    fn blank_inside(&mut self) {
        if !self.last().ends_with(['[', '{']) {
            self.blank();
        }
    }

    /// The text, with the comments behind values in their columns.
    fn finish(mut self) -> String {
        while self.lines.last().is_some_and(Line::is_blank) {
            self.lines.pop();
        }
        let mut columns: Vec<usize> = Vec::with_capacity(self.lines.len());
        for paragraph in self.lines.split(Line::is_blank) {
            let column_of = |line: &Line<'_>| {
                let own = line.comment.as_ref()?.column;
                let beside = paragraph.iter().filter(|other| other.comment.as_ref().is_some_and(|c| c.column == own));
                beside.map(|other| other.end() + 1).max().map(|end| end.max(own))
            };
            columns.extend(paragraph.iter().map(|line| column_of(line).unwrap_or_default()));
            columns.push(0);
        }
        let mut text = String::new();
        for (line, column) in self.lines.iter().zip(columns) {
            text.push_str(&line.code);
            if let Some(comment) = &line.comment {
                text.extend(std::iter::repeat_n(' ', column.saturating_sub(line.end())));
                text.push_str(comment.text);
            }
            text.push('\n');
        }
        text
    }
}

/// Which entries of a broken group start a row.
fn row_starts(entries: &[Entry<'_>], indent: usize, keep: bool) -> Vec<bool> {
    // What is behind a comment, or below one, must.
    let must = |i: usize| {
        i == 0 || !entries[i].comments.is_empty() || entries[i].blank_before || entries[i - 1].comment.is_some()
    };
    let mut starts: Vec<bool> = (0..entries.len()).map(|i| must(i) || (keep && entries[i].starts_row)).collect();
    let mut first = 0;
    while first < entries.len() {
        let next = (first + 1..entries.len()).find(|&i| starts[i]).unwrap_or(entries.len());
        let row = &entries[first..next];
        let width: usize = row.iter().map(|entry| entry.width() + 2).sum();
        let is_short = indent + width - 1 <= WIDTH || row.iter().any(|entry| entry.value.is_broken());
        if !is_short {
            let is_table = |entry: &Entry<'_>| matches!(&entry.value, Value::Group(group) if group.open == '{');
            let each_alone = row.iter().any(is_table);
            let mut column = indent;
            for (i, entry) in row.iter().enumerate() {
                let width = entry.width() + 1;
                let starts_row = i == 0 || each_alone || column + 1 + width > WIDTH;
                starts[first + i] = starts_row;
                column = if starts_row { indent + width } else { column + 1 + width };
            }
        }
        first = next;
    }
    starts
}

/// Reads the tokens of a text that is known to be TOML.
struct Parser<'t> {
    text: &'t str,
    tokens: Peekable<IntoIter<Token>>,
}

impl<'t> Parser<'t> {
    fn text_of(&self, token: Token) -> &'t str {
        &self.text[token.span().start()..token.span().end()]
    }

    fn peek(&mut self) -> TokenKind {
        self.tokens.peek().map_or(TokenKind::Eof, Token::kind)
    }

    fn skip_spaces(&mut self) {
        while self.tokens.next_if(|token| token.kind() == TokenKind::Whitespace).is_some() {}
    }

    /// The comment at the end of this line.
    fn comment(&mut self) -> Option<Comment<'t>> {
        self.skip_spaces();
        let token = self.tokens.next_if(|token| token.kind() == TokenKind::Comment)?;
        let before = &self.text[..token.span().start()];
        let line = before.rfind('\n').map_or(before, |at| &before[at + 1..]);
        Some(Comment { text: self.text_of(token).trim_end(), column: line.chars().count() })
    }

    fn document(&mut self, page: &mut Page<'t>) {
        // Comments right above a header belong to it; the blank line goes before them.
        let mut above: Vec<&'t str> = Vec::new();
        let (mut newlines, mut after_header) = (0, false);
        loop {
            self.skip_spaces();
            let kind = self.peek();
            if kind == TokenKind::Newline {
                self.tokens.next();
                newlines += 1;
                if newlines > 1 {
                    flush(page, &mut above);
                }
                continue;
            }
            let blank_before = newlines > 1 && !(after_header && above.is_empty());
            if blank_before && above.is_empty() {
                page.blank();
            }
            newlines = 0;
            match kind {
                TokenKind::Comment => {
                    above.extend(self.comment().map(|comment| comment.text));
                    after_header = false;
                    continue;
                }
                TokenKind::LeftSquareBracket => {
                    // A comment that opens the file right above its first header stands as it is.
                    page.blank();
                    flush(page, &mut above);
                    let header = self.until(&[TokenKind::Newline, TokenKind::Comment, TokenKind::Eof]);
                    page.line(header);
                    after_header = true;
                }
                TokenKind::Eof => return flush(page, &mut above),
                _ => {
                    flush(page, &mut above);
                    let key = self.until(&[TokenKind::Equals]);
                    self.tokens.next();
                    let value = self.value();
                    page.line(String::new());
                    page.entry(Some(key), value, 0, true);
                    after_header = false;
                }
            }
            let comment = self.comment();
            page.comment(comment);
        }
    }

    /// The tokens up to one of these, without spaces: a key or a header.
    fn until(&mut self, ends: &[TokenKind]) -> String {
        let mut text = String::new();
        while let Some(token) =
            self.tokens.next_if(|token| !ends.contains(&token.kind()) && token.kind() != TokenKind::Eof)
        {
            if token.kind() != TokenKind::Whitespace {
                text.push_str(self.text_of(token));
            }
        }
        text
    }

    fn value(&mut self) -> Value<'t> {
        self.skip_spaces();
        match self.peek() {
            TokenKind::LeftSquareBracket => Value::Group(self.group('[', ']', TokenKind::RightSquareBracket)),
            TokenKind::LeftCurlyBracket => Value::Group(self.group('{', '}', TokenKind::RightCurlyBracket)),
            _ => {
                // A number is several tokens: digits, a point, digits.
                let is_part = |kind| {
                    use TokenKind::{Atom, BasicString, Dot, LiteralString, MlBasicString, MlLiteralString};
                    matches!(kind, Atom | Dot | BasicString | LiteralString | MlBasicString | MlLiteralString)
                };
                let (mut start, mut end) = (usize::MAX, 0);
                while let Some(token) = self.tokens.next_if(|token| is_part(token.kind())) {
                    start = start.min(token.span().start());
                    end = token.span().end();
                }
                Value::Plain(self.text.get(start..end).unwrap_or_default())
            }
        }
    }

    fn group(&mut self, open: char, close: char, end: TokenKind) -> Group<'t> {
        self.tokens.next();
        let comment = self.comment();
        let mut group = Group {
            open,
            close,
            is_broken: comment.is_some(),
            comment,
            entries: Vec::new(),
            last_comments: Vec::new(),
        };
        let mut comments: Vec<&'t str> = Vec::new();
        let mut newlines = 0;
        let mut blank_before = false;
        loop {
            self.skip_spaces();
            match self.peek() {
                TokenKind::Newline => {
                    self.tokens.next();
                    newlines += 1;
                    blank_before |= newlines > 1 && comments.is_empty();
                    group.is_broken |= group.entries.is_empty();
                }
                TokenKind::Comment => {
                    let comment = self.comment();
                    group.is_broken = true;
                    match group.entries.last_mut() {
                        Some(entry) if newlines == 0 => entry.comment = comment,
                        _ => comments.extend(comment.map(|comment| comment.text)),
                    }
                    // The line break after it is counted anew: it separates no rows by a blank line.
                    newlines = newlines.min(1);
                }
                TokenKind::Comma => {
                    self.tokens.next();
                }
                kind if kind == end || kind == TokenKind::Eof => {
                    self.tokens.next();
                    // Nothing to break.
                    group.is_broken &= !(group.entries.is_empty() && comments.is_empty() && group.comment.is_none());
                    group.last_comments = comments;
                    return group;
                }
                _ => {
                    let key = (open == '{').then(|| self.until(&[TokenKind::Equals]));
                    if key.is_some() {
                        self.tokens.next();
                    }
                    let (starts_row, comments) = (newlines > 0, std::mem::take(&mut comments));
                    let value = self.value();
                    group.entries.push(Entry { starts_row, blank_before, comments, key, value, comment: None });
                    (newlines, blank_before) = (0, false);
                }
            }
        }
    }
}

fn flush<'t>(page: &mut Page<'t>, above: &mut Vec<&'t str>) {
    for comment in above.drain(..) {
        page.line(comment.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::builtin::{builtin_names, builtin_text};

    fn format(text: &str) -> String {
        format_toml(text, 0).unwrap_or_else(|problem| panic!("{problem:?}\n{text}"))
    }

    fn meaning(text: &str) -> String {
        let mut meaning = String::new();
        parse_toml(text, 0, Origin::Scene).expect("it is TOML").canonical(&mut meaning);
        meaning
    }

    fn comments(text: &str) -> Vec<&str> {
        let tokens = toml_parser::Source::new(text).lex();
        tokens.filter(|t| t.kind() == TokenKind::Comment).map(|t| &text[t.span().start()..t.span().end()]).collect()
    }

    /// As they are, and with all spaces between tokens gone.
    #[test]
    fn the_built_in_scenes_are_formatted_and_come_back_from_without_spaces() {
        for text in builtin_names().filter_map(builtin_text) {
            assert_eq!(format(text), text);
            let tokens = toml_parser::Source::new(text).lex().filter(|token| token.kind() != TokenKind::Whitespace);
            let dense: String = tokens.map(|token| &text[token.span().start()..token.span().end()]).collect();
            let once = format(&dense);
            assert_eq!(meaning(&once), meaning(text));
            assert_eq!(comments(&once), comments(text));
            assert_eq!(format(&once), once);
        }
    }

    #[test]
    fn what_people_write() {
        let text = r##"

# top
hfvdb=1   # first
frames   =   "1-24"       # second
a = 1     # one
bcdefghijk = 1# one


[ shape . "a b" ]   # mine

# own
sphere=1.50e-3
  move=[1,2,3,]
color = {range=["red","blue",],by="x"}
formula='a  +   b'
# of b
[shape.b]
union=[ {sphere=1},{box=2}, # odd
# own line
 'a b']
points=[[1,2],
[4,5]]
rows=[
  [1,2], [3,4],

  [5,6]
  # last
  ]
e=[ ]
t={
  a=1,  # aa
  b . c=2}
doc="""
a
  b"""   # after


"##;
        let wanted = r##"# top
hfvdb = 1 # first
frames = "1-24"           # second
a = 1     # one
bcdefghijk = 1 # one

[shape."a b"]       # mine
# own
sphere = 1.50e-3
move = [1, 2, 3]
color = { range = ["red", "blue"], by = "x" }
formula = 'a  +   b'

# of b
[shape.b]
union = [
    { sphere = 1 }, { box = 2 }, # odd
    # own line
    'a b',
]
points = [[1, 2], [4, 5]]
rows = [
    [1, 2], [3, 4],

    [5, 6],
    # last
]
e = []
t = {
    a = 1, # aa
    b.c = 2,
}
doc = """
a
  b"""   # after
"##;
        assert_eq!(format(text), wanted);
        assert_eq!(format(wanted), wanted);
        assert_eq!(format(&text.replace('\n', "\r\n").replace("\"\"\"\r\na\r\n", "\"\"\"\na\n")), wanted);
        assert_eq!(format(""), "");
    }

    #[test]
    fn long_lists_are_broken_into_rows() {
        let points = format!("points = [{}]\n", ["[0.125, -0.25, 1]"; 9].join(", "));
        let six = ["[0.125, -0.25, 1]"; 6].join(", ");
        let three = ["[0.125, -0.25, 1]"; 3].join(", ");
        assert_eq!(format(&points), format!("points = [\n    {six},\n    {three},\n]\n"));
        let tables = format!("union = [{}]\n", ["{ sphere = 0.125, color = \"red\" }"; 4].join(", "));
        let rows = "    { sphere = 0.125, color = \"red\" },\n".repeat(4);
        assert_eq!(format(&tables), format!("union = [\n{rows}]\n"));
        assert_eq!(format(&format(&points)), format(&points));
        // An inline table stays on its line: older readers of TOML know no line breaks in it.
        let table = format!("color = {{ colors = [{}] }}\n", ["\"#d7263d\""; 20].join(", "));
        assert_eq!(format(&table), table);
    }

    #[test]
    fn what_is_not_toml_has_a_place() {
        let problem = format_toml("a = 1\nb = \n", 3).unwrap_err();
        assert_eq!(problem.span.map(|span| (span.source, span.start)), Some((3, 10)));
    }
}

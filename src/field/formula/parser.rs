//! The Pratt parser of formulas: a term, then operators as long as they bind tighter than what waits.

use std::ops::Range;

use super::functions::{Function, functions};
use super::{FormulaError, Term, What, nearest, quoted};
use crate::field::op::Binary;

/// Deeper nesting is refused, so that no text overflows the stack.
const DEEPEST: usize = 200;

/// How tightly the sign before a term binds: tighter than `*`, looser than `^`.
const SIGN: u8 = 7;

/// What a name in quotes is known as.
type Called = fn(&str) -> String;

/// Functions of a name in quotes: an attribute's is a name as any other, that of a shape one that no other name can be.
const QUOTED: [(&str, Called); 2] = [("attr", str::to_owned), ("dist", |shape| format!("dist('{shape}')"))];

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    terms: Vec<Term>,
    /// What is wrong so far, where the rest can be read all the same.
    errors: Vec<FormulaError>,
}

/// The terms as far as they can be read, and what is wrong with them.
pub(super) fn parse(text: &str) -> (Vec<Term>, Vec<FormulaError>) {
    let mut parser = Parser { text, at: 0, depth: 0, terms: Vec::new(), errors: Vec::new() };
    if let Err(error) = parser.whole() {
        parser.errors.push(error);
    }
    (parser.terms, parser.errors)
}

/// An operator: how it is written, what it means, and how tightly it binds on its left and right.
struct Operator {
    symbol: &'static str,
    what: fn(usize, usize) -> What,
    before: u8,
    after: u8,
}

/// How tightly comparisons bind: looser than all else.
const COMPARISON: u8 = 1;

/// Longer symbols before those that they begin with.
const OPERATORS: [Operator; 11] = [
    Operator::comparison("<=", |a, b| What::Not(Binary::Less, b, a)),
    Operator::comparison(">=", |a, b| What::Not(Binary::Less, a, b)),
    Operator::comparison("==", |a, b| What::Binary(Binary::Equal, a, b)),
    Operator::comparison("!=", |a, b| What::Not(Binary::Equal, a, b)),
    Operator::comparison("<", |a, b| What::Binary(Binary::Less, a, b)),
    Operator::comparison(">", |a, b| What::Binary(Binary::Less, b, a)),
    Operator { symbol: "+", what: |a, b| What::Binary(Binary::Add, a, b), before: 3, after: 4 },
    Operator { symbol: "-", what: |a, b| What::Binary(Binary::Sub, a, b), before: 3, after: 4 },
    Operator { symbol: "*", what: |a, b| What::Binary(Binary::Mul, a, b), before: 5, after: 6 },
    Operator { symbol: "/", what: |a, b| What::Binary(Binary::Div, a, b), before: 5, after: 6 },
    Operator { symbol: "^", what: |a, b| What::Binary(Binary::Pow, a, b), before: 10, after: 9 },
];

impl Operator {
    const fn comparison(symbol: &'static str, what: fn(usize, usize) -> What) -> Self {
        Self { symbol, what, before: COMPARISON, after: COMPARISON + 1 }
    }
}

impl Parser<'_> {
    fn whole(&mut self) -> Result<(), FormulaError> {
        self.expression(0)?;
        match self.peek() {
            None => Ok(()),
            Some(')') => Err(self.error_here("this `)` closes nothing")),
            Some('=') => Err(self.error_here("one `=` sets nothing here: `==` compares")),
            Some('?' | ':') => Err(self.error_here("a choice is written `if(condition, a, b)`")),
            Some('&' | '|' | '!') => {
                Err(self.error_here("`(a)*(b)` is both of two conditions, `max(a, b)` either, `1 - a` not"))
            }
            Some(_) => Err(self.error_here("an operator is missing before this")),
        }
    }

    /// The next character that is not space.
    fn peek(&mut self) -> Option<char> {
        let rest = self.text[self.at..].trim_start();
        self.at = self.text.len() - rest.len();
        rest.chars().next()
    }

    /// The operator that comes next, if one does.
    fn operator(&mut self) -> Option<&'static Operator> {
        self.peek();
        OPERATORS.iter().find(|operator| self.text[self.at..].starts_with(operator.symbol))
    }

    fn push(&mut self, what: What, span: Range<usize>) -> usize {
        self.terms.push(Term { what, span });
        self.terms.len() - 1
    }

    fn start_of(&self, term: usize) -> usize {
        self.terms[term].span.start
    }

    fn error(&self, span: Range<usize>, message: impl Into<String>) -> FormulaError {
        FormulaError { span, message: message.into(), suggestion: None }
    }

    /// An error at the word or character that comes next.
    fn error_here(&mut self, message: &str) -> FormulaError {
        let next = self.peek();
        let word = self.word_length();
        let length = if word > 0 { word } else { next.map_or(0, char::len_utf8) };
        self.error(self.at..self.at + length, message)
    }

    /// The length of the name or number that comes next.
    fn word_length(&self) -> usize {
        let rest = &self.text[self.at..];
        rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.')).unwrap_or(rest.len())
    }

    /// An expression of operators that bind at least as tightly as given; its place among the terms.
    fn expression(&mut self, loosest: u8) -> Result<usize, FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.error_here("the formula is nested too deeply: split it up"));
        }
        let mut left = self.term()?;
        let mut is_compared = false;
        while let Some(operator) = self.operator() {
            if operator.before < loosest {
                break;
            }
            if operator.before == COMPARISON && std::mem::replace(&mut is_compared, true) {
                let message = "comparisons do not follow one another: write `(a < b)*(b < c)`";
                return Err(self.error(self.at..self.at + operator.symbol.len(), message));
            }
            self.at += operator.symbol.len();
            let right = self.expression(operator.after)?;
            left = self.push((operator.what)(left, right), self.start_of(left)..self.at);
        }
        self.depth -= 1;
        Ok(left)
    }

    fn term(&mut self) -> Result<usize, FormulaError> {
        match self.peek() {
            None if self.at == 0 || self.text.trim().is_empty() => Err(self.error_here("the formula is empty")),
            None => Err(self.error_here("the formula ends where a number, name or `(` is expected")),
            Some('-' | '+') => {
                let (start, negative) = (self.at, self.text.as_bytes()[self.at] == b'-');
                self.at += 1;
                let value = self.expression(SIGN)?;
                Ok(if negative { self.push(What::Negated(value), start..self.at) } else { value })
            }
            Some('(') => {
                let open = self.at;
                self.at += 1;
                let value = self.expression(0)?;
                self.close(open)?;
                Ok(value)
            }
            Some(first) if first.is_ascii_digit() || first == '.' => self.number(),
            Some(first) if first.is_alphabetic() || first == '_' => self.name(),
            Some('*') if self.text[..self.at].ends_with('*') => Err(self.error_here("a power is written `x^2`")),
            Some(_) => Err(self.error_here("a number, name or `(` is expected here")),
        }
    }

    fn close(&mut self, open: usize) -> Result<(), FormulaError> {
        match self.peek() {
            Some(')') => {
                self.at += 1;
                Ok(())
            }
            None => Err(self.error(open..open + 1, "this `(` is never closed")),
            Some(_) => Err(self.error_here("an operator, `,` or `)` is expected here")),
        }
    }

    /// `attr('name')`: the name in quotes. `called`: how names of its kind are known.
    fn quoted(&mut self, start: usize, function: &str, called: &Called) -> Result<usize, FormulaError> {
        let open = self.at;
        self.at += 1;
        let quote = self.peek().filter(|quote| matches!(quote, '\'' | '"'));
        let rest = &self.text[(self.at + 1).min(self.text.len())..];
        let Some(length) = quote.and_then(|quote| rest.find(quote)) else {
            return Err(self.error_here(&format!("the name stands in quotes: `{function}('name')`")));
        };
        let name = rest[..length].to_owned();
        self.at += length + 2;
        self.close(open)?;
        Ok(self.push(What::Name(called(&name)), start..self.at))
    }

    fn number(&mut self) -> Result<usize, FormulaError> {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let mut end = start + self.word_length();
        // The sign of an exponent ends the word, but not the number.
        let exponent = matches!(bytes[end - 1], b'e' | b'E') && matches!(bytes.get(end), Some(b'+' | b'-'));
        if exponent {
            self.at = end + 1;
            end = self.at + self.word_length();
        }
        self.at = end;
        match self.text[start..end].parse::<f64>() {
            Ok(value) if value > f64::from(f32::MAX) => {
                let message =
                    format!("`{}` is too large: frames are computed in 32 bits, up to 3.4e38", &self.text[start..end]);
                Err(self.error(start..end, message))
            }
            Ok(value) => Ok(self.push(What::Number(value), start..end)),
            Err(_) => {
                let message = format!("`{}` is not a number; write `2 * x` for a product", &self.text[start..end]);
                Err(self.error(start..end, message))
            }
        }
    }

    /// A name, or a call.
    fn name(&mut self) -> Result<usize, FormulaError> {
        let start = self.at;
        self.at += self.word_length();
        let span = start..self.at;
        let name = &self.text[span.clone()];
        if let Some((_, called)) = QUOTED.iter().find(|(function, _)| *function == name)
            && self.peek() == Some('(')
        {
            return self.quoted(start, name, called);
        }
        if self.peek() != Some('(') {
            return Ok(self.push(What::Name(name.to_owned()), span));
        }
        let function = Function::named(name);
        if function.is_none() {
            let suggestion = nearest(name, functions().map(|(name, ..)| name));
            let mut message = format!("there is no function `{name}`");
            if suggestion.is_none() {
                message += &format!("; there are {}", quoted(functions().map(|(name, ..)| name)));
            }
            self.errors.push(FormulaError { span: span.clone(), message, suggestion });
        }
        let open = self.at;
        self.at += 1;
        let mut arguments = Vec::new();
        if self.peek() != Some(')') {
            arguments.push(self.expression(0)?);
            while self.peek() == Some(',') {
                self.at += 1;
                arguments.push(self.expression(0)?);
            }
        }
        self.close(open)?;
        let whole = start..self.at;
        match function {
            Some(function) if (function.least..=function.most).contains(&arguments.len()) => {
                Ok(self.push(What::Call(function, arguments), whole))
            }
            Some(function) => {
                let message =
                    format!("`{name}` takes {}, `{}`, not {}", function.arity(), function.usage, arguments.len());
                let error = self.error(whole.clone(), message);
                self.errors.push(error);
                Ok(self.push(What::Number(1.0), whole))
            }
            // Some number stands for it: the formula is refused anyway.
            None => Ok(self.push(What::Number(1.0), whole)),
        }
    }
}

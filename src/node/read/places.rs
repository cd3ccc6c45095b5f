//! Places in lists and files, counts along axes, directions.

use glam::{DMat3, DVec3};

use super::Building;
use crate::field::{CopyPlace, rotation};
use crate::node::argument::Places;
use crate::node::copied::MOST_COPIES;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::key::GREATEST;
use crate::text::number::Number;
use crate::text::reader::Fields;
use crate::text::value::{Data, Value};

const WANTED: &str = "[x, y, z], [x, y, z, scale], [x, y, z, rx, ry, rz] or [x, y, z, rx, ry, rz, scale]";

impl<'r, 'a> Building<'r, 'a> {
    /// One whole number from 1 on, or three.
    pub(super) fn counts(&self, path: &str, value: &'r Value) -> Option<[u32; 3]> {
        let whole = |value: &Value| match value.data {
            Data::Integer(count) => u32::try_from(count).ok().filter(|count| *count > 0),
            _ => None,
        };
        let counts = match value.list() {
            None => whole(value).map(|count| [count; 3]),
            Some([x, y, z]) => whole(x).zip(whole(y)).zip(whole(z)).map(|((x, y), z)| [x, y, z]),
            Some(_) => None,
        };
        let Some(counts) = counts else {
            let problem = format!("`{}` must be whole numbers from 1 on: one, or three for x, y and z", clip(path));
            self.reader.say(Diagnostic::error(value.span, problem));
            return None;
        };
        let all = counts.iter().map(|count| u64::from(*count)).product::<u64>();
        if all > MOST_COPIES as u64 {
            let problem = format!("`{}` makes {all} copies, and {MOST_COPIES} are the most", clip(path));
            self.reader.say(Diagnostic::error(value.span, problem));
            return None;
        }
        Some(counts)
    }

    /// `"x"`, `"y"` or `"z"`, or three numbers.
    pub(super) fn direction(&self, name: &str, fields: &Fields<'r, 'a>) -> Option<[Number; 3]> {
        let value = fields.entry(name).map(|entry| &entry.value);
        let Some((value, text)) = value.and_then(|value| Some((value, value.text()?))) else {
            return fields.vector(name);
        };
        fields.value(name);
        let full = fields.full(name);
        let Some(axis) = ["x", "y", "z"].iter().position(|known| *known == text) else {
            let problem = format!("`{}` cannot be `{}`", clip(&full), clip(text));
            let help = "one of `x`, `y`, `z`, or three numbers, such as [1, 1, 0]";
            self.reader.say(Diagnostic::error(value.span, problem).help(help));
            return None;
        };
        Some(DVec3::AXES[axis].to_array().map(|part| Number::constant(part, &full, value.span)))
    }

    /// Places of a list, or of a file.
    pub(super) fn places(&mut self, name: &str, fields: &Fields<'r, 'a>) -> Option<Places> {
        let value = &fields.entry(name)?.value;
        let path = fields.full(name);
        if value.text().is_some() {
            let file = self.file(name, fields)?;
            let bytes = match file.read() {
                Ok(bytes) => bytes,
                Err(error) => {
                    let problem = format!("`{}` cannot be read: {error}", clip(value.text().unwrap_or_default()));
                    self.reader.say(Diagnostic::error(value.span, problem));
                    return None;
                }
            };
            let Ok(text) = std::str::from_utf8(&bytes) else {
                self.reader
                    .say(Diagnostic::error(value.span, "the file is not text").help("one place a line: x, y, z"));
                return None;
            };
            return match of_lines(text) {
                Ok(rows) => Some(Places { rows, file: Some(file), span: value.span }),
                Err((line, problem)) => {
                    let problem = format!("{}:{line}: {problem}", clip(value.text().unwrap_or_default()));
                    self.reader.say(Diagnostic::error(value.span, problem).help(format!("each line is {WANTED}")));
                    None
                }
            };
        }
        fields.value(name);
        let Some(list) = value.list() else {
            self.reader.wrong_kind(&path, "a list of places or a file of them", value);
            return None;
        };
        let mut rows = Vec::with_capacity(list.len());
        for (i, row) in list.iter().enumerate() {
            let numbers: Option<Vec<f64>> = row.list().and_then(|list| list.iter().map(Value::number).collect());
            match numbers.as_deref().map(of_numbers) {
                Some(Ok(place)) => rows.push(place),
                Some(Err(problem)) => {
                    let problem = format!("`{}[{i}]`: {problem}", clip(&path));
                    self.reader.say(Diagnostic::error(row.span, problem).help(format!("each is {WANTED}")));
                    return None;
                }
                None => {
                    self.reader.wrong_kind(&format!("{path}[{i}]"), WANTED, row);
                    return None;
                }
            }
        }
        Some(Places { rows, file: None, span: value.span })
    }
}

/// A place from its numbers.
fn of_numbers(numbers: &[f64]) -> Result<CopyPlace, String> {
    if let Some(wrong) = numbers.iter().find(|number| !number.is_finite() || number.abs() > GREATEST) {
        return Err(format!("{wrong} is out of range"));
    }
    let (at, degrees, scale) = match *numbers {
        [x, y, z] => ([x, y, z], None, 1.0),
        [x, y, z, scale] => ([x, y, z], None, scale),
        [x, y, z, rx, ry, rz] => ([x, y, z], Some([rx, ry, rz]), 1.0),
        [x, y, z, rx, ry, rz, scale] => ([x, y, z], Some([rx, ry, rz]), scale),
        _ => return Err(format!("a place has 3, 4, 6 or 7 numbers, not {}", numbers.len())),
    };
    if scale.is_nan() || scale < 1e-9 {
        return Err(format!("its scale must be greater than 0, and is {scale}"));
    }
    let turn = degrees.map_or(DMat3::IDENTITY, |degrees| rotation(DVec3::from_array(degrees)));
    Ok(CopyPlace { scale, turn, at: DVec3::from_array(at) })
}

/// Places of a CSV file: commas, semicolons, tabs or blanks between numbers, `#` before remarks, a first line of names is
/// skipped. The number of the line that is wrong, and what is.
fn of_lines(text: &str) -> Result<Vec<CopyPlace>, (usize, String)> {
    let mut rows = Vec::new();
    let mut is_first = true;
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let words = line.split([',', ';', '\t', ' ']).map(str::trim).filter(|word| !word.is_empty());
        let numbers: Result<Vec<f64>, &str> = words.map(|word| word.parse().map_err(|_| word)).collect();
        let is_heading = std::mem::replace(&mut is_first, false);
        match numbers {
            Ok(numbers) => rows.push(of_numbers(&numbers).map_err(|problem| (number, problem))?),
            Err(_) if is_heading => {}
            Err(word) => return Err((number, format!("`{}` is not a number", clip(word)))),
        }
        if rows.len() > MOST_COPIES {
            return Err((number, format!("{MOST_COPIES} places are the most")));
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_places() {
        let rows = of_lines("x,y,z,scale\n1,2,3,0.5\n# a remark\n\n4; 5; 6\n7 8 9 0 0 90 2\n").unwrap();
        assert_eq!(
            rows.iter().map(|row| (row.at.x, row.scale)).collect::<Vec<_>>(),
            [(1.0, 0.5), (4.0, 1.0), (7.0, 2.0)]
        );
        assert_eq!(rows[2].turn * DVec3::X, DVec3::Y);
        assert_eq!(of_lines("1,2,3\n1,2,x\n").unwrap_err(), (2, "`x` is not a number".to_owned()));
        assert_eq!(of_lines("1,2\n").unwrap_err(), (1, "a place has 3, 4, 6 or 7 numbers, not 2".to_owned()));
        assert_eq!(of_lines("1,2,3,0\n").unwrap_err(), (1, "its scale must be greater than 0, and is 0".to_owned()));
        assert!(of_lines("1,2,inf\n").is_err() && of_lines("1,2,NaN,1\n").is_err());
        let many = "0 0 0\n".repeat(1000) + "0 0 zero\n";
        assert_eq!(of_lines(&many).unwrap_err().0, 1001);
    }
}

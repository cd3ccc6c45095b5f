//! Wavefront OBJ: vertices with or without colours (`v x y z r g b`), polygons of any number of corners.
//!
//! Our own reader rather than `tobj`: that one gives no line numbers, silently assigns colours to the wrong vertices
//! when only some have one, panics on far-off indices in builds with overflow checks, and fans concave polygons.

use glam::DVec3;

use super::read::{Located, linear};
use super::{Problem, TriangleMesh, polygon};

#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    colours: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    // Scratch of one polygon.
    corners: Vec<u32>,
    corner_positions: Vec<DVec3>,
    cut: Vec<[usize; 3]>,
}

/// Reads an OBJ file's content. What is neither a vertex nor a polygon is skipped.
pub(super) fn parse(content: &[u8]) -> Result<TriangleMesh, Located> {
    let mut reader = Reader::default();
    let mut joined = Vec::new();
    for (number, line) in content.split(|&byte| byte == b'\n').enumerate() {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if let Some(start) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(start);
            joined.push(b' ');
            continue;
        }
        let located = |problem| Located { line: Some(number + 1), problem };
        if joined.is_empty() {
            reader.line(line).map_err(located)?;
        } else {
            joined.extend_from_slice(line);
            reader.line(&std::mem::take(&mut joined)).map_err(located)?;
        }
    }
    if !joined.is_empty() {
        return Err(Problem::CutShort("the last line goes on with '\\' but nothing follows".into()).into());
    }
    let colours = (!reader.colours.is_empty()).then_some(reader.colours);
    TriangleMesh::new(reader.positions, reader.triangles, colours).map_err(Located::from)
}

impl Reader {
    fn line(&mut self, line: &[u8]) -> Result<(), Problem> {
        let line = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        match line.trim_ascii_start() {
            [b'v', b' ' | b'\t', rest @ ..] => self.vertex(text(rest)?),
            [b'f', b' ' | b'\t', rest @ ..] => self.polygon(text(rest)?),
            _ => Ok(()),
        }
    }

    fn vertex(&mut self, rest: &str) -> Result<(), Problem> {
        let mut values = [0.0; 8];
        let mut count = 0;
        for word in rest.split_ascii_whitespace().take(values.len()) {
            values[count] = number(word)?;
            count += 1;
        }
        let vertex = self.positions.len();
        let [x, y, z, ..] = values;
        let mut position = DVec3::new(x, y, z);
        let colour = match count {
            3 => None,
            4 => {
                position /= values[3];
                None
            }
            // Seven numbers are x y z w r g b or x y z r g b a: files with alpha are the ones met.
            6 | 7 => Some([values[3], values[4], values[5]]),
            _ => {
                return Err(Problem::malformed(format!(
                    "a vertex of {count} numbers: 'v x y z' or 'v x y z r g b' is expected; is the file cut short?"
                )));
            }
        };
        if !position.is_finite() {
            return Err(Problem::BadCoordinate { vertex, value: [x, y, z] });
        }
        self.positions.push(position);
        self.colour(vertex, colour)
    }

    fn colour(&mut self, vertex: usize, colour: Option<[f64; 3]>) -> Result<(), Problem> {
        if vertex > 0 && colour.is_some() == self.colours.is_empty() {
            return Err(Problem::malformed(
                "some vertices have a colour and others have none; give every 'v' line six numbers, or every one three",
            ));
        }
        if let Some(encoded) = colour {
            if encoded.iter().any(|c| !(0.0..=1.0).contains(c)) {
                return Err(Problem::BadColour { vertex, value: encoded });
            }
            self.colours.push(encoded.map(linear));
        }
        Ok(())
    }

    fn polygon(&mut self, rest: &str) -> Result<(), Problem> {
        self.corners.clear();
        for word in rest.split_ascii_whitespace() {
            let index = word.split('/').next().unwrap_or_default();
            self.corners.push(self.index(index)?);
        }
        if self.corners.len() < 3 {
            return Err(Problem::malformed(format!(
                "a polygon of {} corners; is the file cut short?",
                self.corners.len()
            )));
        }
        self.corner_positions.clear();
        self.corner_positions.extend(self.corners.iter().map(|&v| self.positions[v as usize]));
        self.cut.clear();
        polygon::triangulate(&self.corner_positions, &mut self.cut);
        self.triangles.extend(self.cut.iter().map(|corner| corner.map(|i| self.corners[i])));
        Ok(())
    }

    /// A vertex by its number from 1, or counted back from the last one by a negative number.
    fn index(&self, word: &str) -> Result<u32, Problem> {
        let index: i64 = word.parse().map_err(|_| Problem::malformed(format!("'{word}' is not a vertex number")))?;
        let vertices = self.positions.len();
        let found = if index > 0 { index - 1 } else { index.saturating_add(vertices as i64) };
        match u32::try_from(found) {
            Ok(vertex) if index != 0 && (vertex as usize) < vertices => Ok(vertex),
            _ => Err(Problem::IndexOutOfRange { index, vertices }),
        }
    }
}

fn text(line: &[u8]) -> Result<&str, Problem> {
    std::str::from_utf8(line).map_err(|_| Problem::malformed("bytes that are no text; is this an OBJ file?"))
}

fn number(word: &str) -> Result<f64, Problem> {
    word.parse().map_err(|_| Problem::malformed(format!("'{word}' is not a number")))
}

//! Wavefront OBJ: vertices with or without colours (`v x y z r g b`), polygons of any number of corners, materials.
//!
//! Our own reader rather than `tobj`: that one gives no line numbers, silently assigns colours to the wrong vertices
//! when only some have one, panics on far-off indices in builds with overflow checks, and fans concave polygons.

use std::path::Path;

use glam::DVec3;

use super::Problem;
use super::error::Element;
use super::faces::{Faces, VertexPaint};
use super::material::Material;
use super::mtl;
use super::read::{About, Conventions, Encoding, Imported, Located, Place, Remark, shown, without_mark};
use super::triangles::LARGEST_COORDINATE;

struct Reader {
    encoding: Encoding,
    positions: Vec<DVec3>,
    colours: Vec<[f32; 3]>,
    faces: Faces,
    corners: Vec<u32>,
    /// Places in pictures, to the right and down.
    places: Vec<[f32; 2]>,
    /// The number of the place at each corner of each face; `u32::MAX` where it has none.
    uv: Vec<u32>,
    /// The number of each face's material.
    materials: Vec<u32>,
    /// The names of materials as they come up, and the one that holds now.
    names: Vec<String>,
    material: u32,
    /// The line that names the first.
    first_named: Option<usize>,
    by_blender: bool,
    /// The first line of each kind of content that is not read.
    unread: [Option<(usize, String)>; Unread::COUNT],
}

/// What is known of, and not read.
#[derive(Clone, Copy)]
enum Unread {
    /// Colours of vertices in comments, as ZBrush writes them.
    Polypaint,
    FreeForm,
}

impl Unread {
    const COUNT: usize = 2;
}

/// The libraries of materials that a file's content names.
pub(super) fn libraries(content: &[u8]) -> Vec<String> {
    let lines = content.split(|&byte| byte == b'\n' || byte == b'\r');
    let named = lines.filter_map(|line| line.trim_ascii().strip_prefix(b"mtllib"));
    let named = named.filter(|rest| rest.first().is_some_and(u8::is_ascii_whitespace));
    named.map(|rest| String::from_utf8_lossy(rest.trim_ascii()).into_owned()).collect()
}

/// Reads an OBJ file's content; its materials are sought from `folder`. What is neither a vertex nor a polygon is skipped.
pub(super) fn parse(content: &[u8], conventions: &Conventions, folder: Option<&Path>) -> Result<Imported, Located> {
    let whole = content;
    let content = without_mark(content)?;
    let mut reader = Reader {
        encoding: conventions.colours,
        positions: Vec::new(),
        colours: Vec::new(),
        faces: Faces::new(1),
        corners: Vec::new(),
        places: Vec::new(),
        uv: Vec::new(),
        materials: Vec::new(),
        // Of faces before any `usemtl`.
        names: vec![String::new()],
        material: 0,
        first_named: None,
        by_blender: false,
        unread: Default::default(),
    };
    // A statement over several lines, and its first.
    let (mut joined, mut first) = (Vec::new(), 0);
    let lines = content.split(|&byte| byte == b'\n').flat_map(|line| {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        // Lines of old Macs end in CR alone.
        line.split(|&byte| byte == b'\r')
    });
    for (line, number) in lines.zip(1..) {
        let located = |number, problem| Located { place: Some(Place::Line(number)), problem };
        let statement = reader.without_comment(line, number);
        let goes_on = statement.strip_suffix(b"\\");
        if !joined.is_empty() && statement.is_empty() && !line.is_empty() {
            // A comment between: what goes on goes on after it.
            continue;
        }
        if joined.is_empty() {
            first = number;
            if goes_on.is_none() {
                reader.statement(statement, number).map_err(|problem| located(number, problem))?;
                continue;
            }
        }
        joined.extend_from_slice(goes_on.unwrap_or(statement));
        joined.push(b' ');
        if goes_on.is_none() {
            reader.statement(&std::mem::take(&mut joined), first).map_err(|problem| located(first, problem))?;
        }
    }
    if !joined.is_empty() {
        let problem = Problem::CutShort("goes on with '\\' but nothing follows".into());
        return Err(Located { place: Some(Place::Line(first)), problem });
    }
    let mut of_materials = Vec::new();
    let materials = match folder {
        Some(folder) if reader.names.len() > 1 => reader.load(&libraries(whole), folder, &mut of_materials),
        _ => None,
    };
    // A picture counts for more than the colours of vertices, and these for more than one colour of a whole material.
    let pictured = materials.iter().flatten().any(|material| material.picture.is_some());
    let mut remarks = reader.remarks(materials.is_some());
    if pictured && !reader.colours.is_empty() {
        let text = "the colours of its vertices are not used: its materials have pictures".into();
        let help = "take the pictures out of its materials to have them".into();
        remarks.push(Remark { about: About::Colours, place: None, text, help });
    }
    let Reader { positions, colours, faces, uv, places, materials: of_faces, .. } = reader;
    let colours = (!colours.is_empty()).then_some(colours);
    match materials.filter(|_| pictured || colours.is_none()) {
        Some(materials) => {
            let (faces, positions, places) = faces.with_places(&positions, &uv, &places, &of_faces)?;
            let paint = VertexPaint { colours: None, places: Some(places) };
            let mesh = faces.mesh(positions, paint, conventions, &mut remarks)?;
            remarks.extend(of_materials);
            Ok(Imported { mesh, materials, remarks })
        }
        None => {
            if colours.is_none() {
                remarks.extend(of_materials);
            }
            let mesh = faces.mesh(positions, VertexPaint { colours, places: None }, conventions, &mut remarks)?;
            Ok(Imported { mesh, materials: Vec::new(), remarks })
        }
    }
}

impl Reader {
    /// A line without its comment and the blanks at its end.
    fn without_comment<'l>(&mut self, line: &'l [u8], number: usize) -> &'l [u8] {
        let Some(start) = line.iter().position(|&byte| byte == b'#') else { return line.trim_ascii_end() };
        let comment = &line[start..];
        if self.positions.is_empty() && comment.windows(7).any(|word| word.eq_ignore_ascii_case(b"blender")) {
            self.by_blender = true;
        }
        if comment.starts_with(b"#MRGB ") {
            self.not_read(Unread::Polypaint, number, "");
        }
        line[..start].trim_ascii_end()
    }

    fn not_read(&mut self, what: Unread, number: usize, name: &str) {
        self.unread[what as usize].get_or_insert_with(|| (number, shown(name)));
    }

    fn statement(&mut self, statement: &[u8], number: usize) -> Result<(), Problem> {
        let statement = statement.trim_ascii_start();
        let end = statement.iter().position(u8::is_ascii_whitespace).unwrap_or(statement.len());
        let (keyword, rest) = statement.split_at(end);
        match keyword {
            b"v" => self.vertex(text(rest)?)?,
            // `fo` is what old files call a face.
            b"f" | b"fo" => self.face(text(rest)?, number)?,
            b"vt" => self.place(text(rest)?)?,
            b"usemtl" => {
                self.first_named.get_or_insert(number);
                self.material(String::from_utf8_lossy(rest).trim());
            }
            b"surf" => self.not_read(Unread::FreeForm, number, ""),
            [b'0'..=b'9' | b'-' | b'+' | b'.', ..] => {
                return Err(Problem::malformed(
                    "begins with a number; is a '\\' missing at the end of the line before?",
                ));
            }
            _ => {}
        }
        Ok(())
    }

    fn vertex(&mut self, rest: &str) -> Result<(), Problem> {
        let mut values = [0.0; 8];
        let mut count = 0;
        for word in rest.split_ascii_whitespace().take(values.len()) {
            values[count] = number(word)?;
            count += 1;
        }
        let vertex = Element::Vertex { number: self.positions.len() + 1, first: 1 };
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
        if !(position.abs().max_element() <= LARGEST_COORDINATE && position.is_finite()) {
            return Err(Problem::BadCoordinate { vertex, value: [x, y, z] });
        }
        if !self.positions.is_empty() && colour.is_some() == self.colours.is_empty() {
            return Err(Problem::malformed(
                "some vertices have a colour and others have none; give every 'v' line six numbers, or every one three",
            ));
        }
        self.positions.push(position);
        if let Some(value) = colour {
            self.colours.push(self.encoding.decode(value).ok_or(Problem::BadColour { of: vertex, value })?);
        }
        Ok(())
    }

    fn face(&mut self, rest: &str, number: usize) -> Result<(), Problem> {
        self.corners.clear();
        for word in rest.split_ascii_whitespace() {
            let mut parts = word.split('/');
            self.corners.push(self.index(parts.next().unwrap_or_default(), self.positions.len())?);
            // What is no number, or none of a place, is none: a mesh without pictures does without.
            let place = parts.next().and_then(|index| self.index(index, self.places.len()).ok());
            self.uv.push(place.unwrap_or(u32::MAX));
        }
        self.materials.push(self.material);
        self.faces.push(self.corners.iter().copied(), Place::Line(number));
        Ok(())
    }

    /// A vertex by its number from 1, or counted back from the last one by a negative number.
    fn index(&self, word: &str, vertices: usize) -> Result<u32, Problem> {
        let bad = |_| Problem::malformed(format!("'{}' is not a vertex number", shown(word)));
        let index: i64 = word.parse().map_err(bad)?;
        let found = if index > 0 { index - 1 } else { index.saturating_add(vertices as i64) };
        // Whether there are as many is known at the end: faces may stand before their vertices.
        match u32::try_from(found) {
            Ok(vertex) if index != 0 => Ok(vertex),
            _ => Err(Problem::IndexOutOfRange { index, vertices, first: 1 }),
        }
    }

    fn place(&mut self, rest: &str) -> Result<(), Problem> {
        let mut along = [0.0; 2];
        for (along, word) in along.iter_mut().zip(rest.split_ascii_whitespace()) {
            *along = number(word)? as f32;
        }
        let [u, v] = along.map(|along| if along.is_finite() { along } else { 0.0 });
        self.places.push([u, 1.0 - v]);
        Ok(())
    }

    fn material(&mut self, name: &str) {
        let known = self.names.iter().position(|known| known == name);
        let number = known.unwrap_or_else(|| {
            self.names.push(name.into());
            self.names.len() - 1
        });
        self.material = number as u32;
    }

    /// The materials of the names, if a library has any of them.
    fn load(&self, libraries: &[String], folder: &Path, remarks: &mut Vec<Remark>) -> Option<Vec<Material>> {
        let mut known = mtl::load(libraries, folder, remarks);
        if !self.names.iter().any(|name| known.contains_key(name)) {
            return None;
        }
        let white = Material { factor: [1.0; 3], ..Material::default() };
        Some(self.names.iter().map(|name| known.remove(name).unwrap_or_else(|| white.clone())).collect())
    }

    fn remarks(&self, has_materials: bool) -> Vec<Remark> {
        let mut remarks = Vec::new();
        let mut remark = |about, place: Option<usize>, text: String, help: &str| {
            remarks.push(Remark { about, place: place.map(Place::Line), text, help: help.into() });
        };
        let [polypaint, free_form] = &self.unread;
        if let Some((line, _)) = free_form {
            let text = "free-form surfaces ('surf') are not read, only faces".into();
            remark(About::Faces, Some(*line), text, "turn them into polygons and export it again");
        }
        if self.colours.is_empty() {
            const HELP: &str = "give the shape a `color`, or export the mesh with colours of its vertices";
            if let Some(name) = self.names.get(1).filter(|_| !has_materials) {
                let text = format!("no material of the mesh is known (`usemtl {}`): it has no colour", shown(name));
                remark(
                    About::Colours,
                    self.first_named,
                    text,
                    "put its .mtl file beside it, which its `mtllib` names, or give the shape a `color`",
                );
            }
            if let Some((line, _)) = polypaint {
                let text = "the mesh's colours are not read: ZBrush's polypaint (`#MRGB`) is not".into();
                remark(About::Colours, Some(*line), text, HELP);
            }
        }
        if self.by_blender {
            let text = "the file is by Blender, whose OBJ export has y up where nothing else is chosen; \
                        it is read with z up"
                .into();
            let help = "if the mesh lies on its face, say `up = \"y\"` beside `mesh`, or `--up y` to `hfvdb morph`; \
                        else `up = \"z\"`";
            remark(About::Up, None, text, help);
        }
        remarks
    }
}

fn text(line: &[u8]) -> Result<&str, Problem> {
    std::str::from_utf8(line).map_err(|_| Problem::malformed("bytes that are no text; is this an OBJ file?"))
}

fn number(word: &str) -> Result<f64, Problem> {
    word.parse().map_err(|_| Problem::malformed(format!("'{}' is not a number", shown(word))))
}

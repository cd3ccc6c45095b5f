//! PLY, text and binary, through `ply-rs-bw`; colours of vertices or faces, of any number type.

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    Addable, ElementDef, Encoding as Form, Header, Property, PropertyAccess, PropertyAccessResult, PropertyDef,
    PropertyType, ScalarType,
};

use super::Problem;
use super::cloud::Cloud;
use super::error::Element;
use super::faces::{Faces, VertexPaint};
use super::read::{About, Conventions, Encoding, Imported, Located, Place, Remark, shown, without_mark};
use super::triangles::LARGEST_COORDINATE;

/// Reads a PLY file's content.
pub(super) fn parse(content: &[u8], conventions: &Conventions) -> Result<Imported, Located> {
    let content = without_mark(content)?;
    let (mut reader, header) = begun(content)?;
    let is_text = header.encoding == Form::Ascii;
    let mut positions = Vec::new();
    let mut colours = None;
    let mut faces = Faces::new(0);
    for (name, element) in &header.elements {
        // The line of its first, in a text file.
        let first = reader.line();
        let line = |i: usize| is_text.then_some(Place::Line(first + i));
        let broken = |error: ParseError| payload_problem(content, &header, element, &error);
        let (named, types) = with_usual_colours(element);
        match name.as_str() {
            "vertex" => {
                check_positions(element)?;
                let vertices = Parser::<Vertex>::new().read_payload_for_element(&mut reader, &named, &header);
                let vertices = vertices.map_err(broken)?;
                positions = usable_positions(&vertices, line)?;
                let of = |number| Element::Vertex { number, first: 0 };
                let values = vertices.iter().map(|vertex| vertex.colour);
                colours = decoded(types, conventions.colours, values, line, of)?;
            }
            "face" => {
                check_corners(element)?;
                let polygons = Parser::<Polygon>::new().read_payload_for_element(&mut reader, &named, &header);
                let polygons = polygons.map_err(broken)?;
                let of = |number| Element::Face { number, first: 0 };
                let values = polygons.iter().map(|polygon| polygon.colour);
                faces.colours = decoded(types, conventions.colours, values, line, of)?.unwrap_or_default();
                let vertices = header.elements.get("vertex").map_or(0, |element| element.count);
                for (i, polygon) in polygons.iter().enumerate() {
                    let vertex = |&index: &i64| {
                        let problem = |_| Problem::IndexOutOfRange { index, vertices, first: 0 };
                        u32::try_from(index).map_err(problem)
                    };
                    let corners: Result<Vec<u32>, Problem> = polygon.corners.iter().map(vertex).collect();
                    let place = line(i).unwrap_or(Place::Face(i));
                    faces.push(corners.map_err(|problem| Located { place: Some(place), problem })?, place);
                }
            }
            "tristrips" if element.count > 0 => {
                let problem = "holds triangle strips ('tristrips'), which are not read; export it with faces";
                return Err(Problem::malformed(problem).into());
            }
            _ => {
                Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header).map_err(broken)?;
            }
        }
    }
    let mut remarks = unread_colours(&header, colours.is_some(), !faces.colours.is_empty());
    let paint = VertexPaint { colours, places: None };
    let mesh = faces.mesh(positions, paint, conventions, &mut remarks)?;
    Ok(Imported { mesh, materials: Vec::new(), remarks })
}

/// Reads the points of a PLY file: its vertices, whatever faces there are.
pub(super) fn cloud(content: &[u8], encoding: Encoding) -> Result<Cloud, Located> {
    let content = without_mark(content)?;
    let (mut reader, header) = begun(content)?;
    let is_text = header.encoding == Form::Ascii;
    for (name, element) in &header.elements {
        let first = reader.line();
        let line = |i: usize| is_text.then_some(Place::Line(first + i));
        let broken = |error: ParseError| payload_problem(content, &header, element, &error);
        if name != "vertex" {
            Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header).map_err(broken)?;
            continue;
        }
        check_positions(element)?;
        let (named, types) = with_usual_colours(element);
        let vertices =
            Parser::<Vertex>::new().read_payload_for_element(&mut reader, &named, &header).map_err(broken)?;
        let of = |number| Element::Vertex { number, first: 0 };
        let positions = usable_positions(&vertices, line)?;
        let colours = decoded(types, encoding, vertices.iter().map(|vertex| vertex.colour), line, of)?;
        let has_radius = scalar(element, "radius").is_some();
        let unusable = |vertex: &Vertex| !(vertex.radius > 0.0 && vertex.radius <= LARGEST_COORDINATE);
        if let Some(i) = vertices.iter().position(unusable).filter(|_| has_radius) {
            let problem = format!("a radius must be greater than 0, and is {}", vertices[i].radius);
            return Err(Located { place: line(i), problem: Problem::malformed(problem) });
        }
        let radii = has_radius.then(|| vertices.iter().map(|vertex| vertex.radius).collect());
        return Ok(Cloud { positions, radii, colours });
    }
    Ok(Cloud::default())
}

/// The header, checked, and the reader behind it.
fn begun(content: &[u8]) -> Result<(Reader<&[u8]>, Header), Located> {
    if content.starts_with(b"ply\r") && !content.starts_with(b"ply\r\n") {
        return Err(Problem::malformed("its header's lines end in CR alone, as on old Macs; save it with LF").into());
    }
    let mut reader = Reader::new(content);
    let header = Parser::<Skipped>::new().read_header(&mut reader);
    let header = header.map_err(|error| header_problem(content, &error))?;
    check_names(content)?;
    check_sizes(&header, content.len())?;
    Ok((reader, header))
}

/// A line of a file for messages, counted from 1.
fn line(content: &[u8], number: usize) -> String {
    let line = content.split(|&byte| byte == b'\n').nth(number.saturating_sub(1)).unwrap_or_default();
    shown(String::from_utf8_lossy(line).trim_end())
}

/// What is wrong with a header. The parser's own words take several lines.
fn header_problem(content: &[u8], error: &ParseError) -> Located {
    let place = error.line().map(Place::Line);
    let problem = match (error.kind(), error.line()) {
        _ if !content.starts_with(b"ply") => {
            if content.is_empty() {
                return Problem::CutShort("is empty".into()).into();
            }
            return Problem::malformed("does not begin with the line 'ply'; is this a PLY file?").into();
        }
        (std::io::ErrorKind::UnexpectedEof, _) => Problem::CutShort("ends before the header's 'end_header'".into()),
        (_, Some(number)) => Problem::malformed(format!(
            "'{}' is no line of a header that is known; export it again",
            line(content, number)
        )),
        _ => Problem::malformed("its header has no line 'format ascii 1.0' or its like; export it again"),
    };
    Located { place, problem }
}

/// What is wrong with the content of an element.
fn payload_problem(content: &[u8], header: &Header, element: &ElementDef, error: &ParseError) -> Located {
    let place = error.line().filter(|_| header.encoding == Form::Ascii).map(Place::Line);
    let problem = match (error.kind(), place) {
        (std::io::ErrorKind::UnexpectedEof, _) => {
            Problem::CutShort(format!("ends within the {} of '{}'", element.count, shown(&element.name)))
        }
        (_, Some(Place::Line(number))) => Problem::malformed(format!(
            "'{}' are not the numbers that the header announces of '{}': {}; export it again",
            line(content, number),
            shown(&element.name),
            announced(element)
        )),
        _ => Problem::malformed(format!(
            "what stands under '{}' is not what the header announces: {}; export it again",
            shown(&element.name),
            announced(element)
        )),
    };
    Located { place, problem }
}

/// The properties of an element, as its header has them.
fn announced(element: &ElementDef) -> String {
    const MOST_SHOWN: usize = 6;
    let names: Vec<String> = element
        .properties
        .values()
        .take(MOST_SHOWN)
        .map(|property| match property.data_type {
            PropertyType::Scalar(_) => shown(&property.name),
            PropertyType::List(..) => format!("{} (a count and as many numbers)", shown(&property.name)),
        })
        .collect();
    let more = if element.properties.len() > MOST_SHOWN { " …" } else { "" };
    format!("{}{more}", names.join(" "))
}

/// Refuses a header that names an element twice, or a property of one: what follows could not be told apart.
fn check_names(content: &[u8]) -> Result<(), Located> {
    let mut elements: Vec<&[u8]> = Vec::new();
    let mut properties: Vec<&[u8]> = Vec::new();
    for (text, number) in content.split(|&byte| byte == b'\n').zip(1..) {
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let (known, name) = match words.next() {
            Some(b"element") => {
                properties.clear();
                (&mut elements, words.next())
            }
            Some(b"property") => (&mut properties, words.next_back()),
            Some(b"end_header") => break,
            _ => continue,
        };
        let name = name.unwrap_or_default();
        if known.contains(&name) {
            let name = shown(&String::from_utf8_lossy(name));
            let problem = Problem::malformed(format!("'{name}' is there twice in the header; export it again"));
            return Err(Located { place: Some(Place::Line(number)), problem });
        }
        known.push(name);
    }
    Ok(())
}

/// Refuses headers that announce more than the file can hold, before anything is read or set aside for it.
fn check_sizes(header: &Header, file_size: usize) -> Result<(), Problem> {
    for (name, element) in &header.elements {
        let least: usize = match header.encoding {
            Form::Ascii => 1,
            _ => element.properties.values().map(|property| least_size(&property.data_type)).sum(),
        };
        if element.count > 0 && (least == 0 || element.count > file_size / least) {
            return Err(Problem::CutShort(format!(
                "announces {} of '{}', more than its size can hold",
                element.count,
                shown(name)
            )));
        }
    }
    Ok(())
}

fn least_size(data_type: &PropertyType) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = data_type;
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Vertices need numbers x, y and z.
fn check_positions(element: &ElementDef) -> Result<(), Problem> {
    let is_number = |name: &&str| scalar(element, name).is_some();
    match ["x", "y", "z"].iter().find(|name| element.count > 0 && !is_number(name)) {
        Some(name) => Err(Problem::malformed(format!("its vertices have no number '{name}'; export it again"))),
        None => Ok(()),
    }
}

/// The lists that name a face's vertices.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Faces need a list of whole numbers.
fn check_corners(element: &ElementDef) -> Result<(), Problem> {
    let found = CORNERS.iter().find_map(|name| element.properties.get(*name));
    match found.map(|property| &property.data_type) {
        _ if element.count == 0 => Ok(()),
        Some(PropertyType::List(count, index)) if is_whole(count) && is_whole(index) => Ok(()),
        Some(_) => Err(Problem::malformed("its faces' 'vertex_indices' are no list of whole numbers; export it again")),
        None => Err(Problem::malformed("its faces have no list 'vertex_indices'; export it again")),
    }
}

fn is_whole(scalar: &ScalarType) -> bool {
    !matches!(scalar, ScalarType::Float | ScalarType::Double)
}

fn scalar(element: &ElementDef, name: &str) -> Option<ScalarType> {
    match &element.properties.get(name)?.data_type {
        PropertyType::Scalar(scalar) => Some(scalar.clone()),
        PropertyType::List(..) => None,
    }
}

/// What red, green and blue are called, the usual names first.
const COLOURS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];

/// An element with its colour under the usual names, and the types of that; `None` where it has no colour.
fn with_usual_colours(element: &ElementDef) -> (ElementDef, Option<[ScalarType; 3]>) {
    let types = |names: &[&str; 3]| {
        let [r, g, b] = names.map(|name| scalar(element, name));
        Some([r?, g?, b?])
    };
    let chosen = COLOURS.iter().find_map(|names| Some((names, types(names)?)));
    let mut renamed = ElementDef::new(element.name.clone());
    renamed.count = element.count;
    for (i, property) in element.properties.values().enumerate() {
        let channel = chosen.as_ref().and_then(|(names, _)| names.iter().position(|name| *name == property.name));
        let name = match channel {
            Some(channel) => COLOURS[0][channel].into(),
            None if COLOURS[0].contains(&property.name.as_str()) => format!("unused {i}"),
            None => property.name.clone(),
        };
        renamed.properties.add(PropertyDef::new(name, property.data_type.clone()));
    }
    (renamed, chosen.map(|(_, types)| types))
}

struct Vertex {
    position: [f64; 3],
    colour: [f64; 3],
    radius: f64,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [f64::NAN; 3], colour: [0.0; 3], radius: f64::NAN }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let entry = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "radius" => &mut self.radius,
            _ => match channel(&mut self.colour, name) {
                Some(channel) => channel,
                None => return PropertyAccessResult::Ignored,
            },
        };
        let Some(value) = number(&property) else { return PropertyAccessResult::UnsupportedType };
        *entry = value;
        PropertyAccessResult::Set
    }
}

fn channel<'c>(colour: &'c mut [f64; 3], name: &str) -> Option<&'c mut f64> {
    COLOURS[0].iter().position(|channel| *channel == name).map(|channel| &mut colour[channel])
}

struct Polygon {
    corners: Vec<i64>,
    colour: [f64; 3],
}

impl PropertyAccess for Polygon {
    fn new() -> Self {
        Self { corners: Vec::new(), colour: [0.0; 3] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(channel) = channel(&mut self.colour, name) {
            let Some(value) = number(&property) else { return PropertyAccessResult::UnsupportedType };
            *channel = value;
            return PropertyAccessResult::Set;
        }
        if !CORNERS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element nobody asked for: read, since a text file's and a list's length is known only then, and dropped.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

fn number(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(v) => f64::from(v),
        Property::UChar(v) => f64::from(v),
        Property::Short(v) => f64::from(v),
        Property::UShort(v) => f64::from(v),
        Property::Int(v) => f64::from(v),
        Property::UInt(v) => f64::from(v),
        Property::Float(v) => f64::from(v),
        Property::Double(v) => v,
        _ => return None,
    })
}

fn usable_positions(vertices: &[Vertex], place: impl Fn(usize) -> Option<Place>) -> Result<Vec<DVec3>, Located> {
    let usable = |vertex: &Vertex| vertex.position.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
    if let Some(i) = vertices.iter().position(|vertex| !usable(vertex)) {
        let vertex = Element::Vertex { number: i, first: 0 };
        let problem = Problem::BadCoordinate { vertex, value: vertices[i].position };
        return Err(Located { place: place(i), problem });
    }
    Ok(vertices.iter().map(|vertex| DVec3::from(vertex.position)).collect())
}

/// Scene-linear colours of numbers of some types; `None` where there are none.
fn decoded(
    types: Option<[ScalarType; 3]>,
    encoding: Encoding,
    values: impl Iterator<Item = [f64; 3]>,
    place: impl Fn(usize) -> Option<Place>,
    element: impl Fn(usize) -> Element,
) -> Result<Option<Vec<[f32; 3]>>, Located> {
    let Some(types) = types else { return Ok(None) };
    let whole = types.map(|scalar| match scalar {
        ScalarType::Char | ScalarType::UChar => 255.0,
        ScalarType::Short | ScalarType::UShort => 65535.0,
        _ => 1.0,
    });
    let decode = |(i, value): (usize, [f64; 3])| {
        let encoded = std::array::from_fn(|c| value[c] / whole[c]);
        let problem = || Problem::BadColour { of: element(i), value };
        encoding.decode(encoded).ok_or_else(|| Located { place: place(i), problem: problem() })
    };
    values.enumerate().map(decode).collect::<Result<_, _>>().map(Some)
}

/// What the file holds of colours and is not read.
fn unread_colours(header: &Header, of_vertices: bool, of_faces: bool) -> Vec<Remark> {
    let remark = |text: String, help: &str| Remark { about: About::Colours, place: None, text, help: help.into() };
    if of_vertices && of_faces {
        let text = "the colours of its faces are not read, since its vertices have some too".into();
        return vec![remark(text, "export it without the colours of vertices where those of faces are meant")];
    }
    if of_vertices || of_faces {
        return Vec::new();
    }
    let is_colour = |name: &str| {
        let name = name.to_ascii_lowercase();
        name.split('_').any(|word| matches!(word, "red" | "green" | "blue" | "color" | "colour" | "rgb" | "rgba"))
    };
    let mut found: Vec<String> = Vec::new();
    for (element, definition) in header.elements.iter().filter(|(_, definition)| definition.count > 0) {
        let names = definition.properties.keys().filter(|name| is_colour(name));
        found.extend(names.map(|name| format!("'{}' of '{}'", shown(name), shown(element))));
    }
    let texture = header.comments.iter().find_map(|comment| comment.strip_prefix("TextureFile"));
    const HELP: &str = "export colours of vertices or faces as red, green and blue, or give the shape a `color`";
    if let Some(name) = texture {
        return vec![remark(format!("the mesh's texture '{}' is not read", shown(name.trim())), HELP)];
    }
    if found.is_empty() {
        return Vec::new();
    }
    found.truncate(6);
    vec![remark(format!("what looks like colours is not read: {}", found.join(", ")), HELP)]
}

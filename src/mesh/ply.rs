//! PLY, text and binary, through `ply-rs-bw`; vertex colours of any number type.

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::read::{Located, linear};
use super::{Problem, TriangleMesh, polygon};

/// Reads a PLY file's content.
pub(super) fn parse(content: &[u8]) -> Result<TriangleMesh, Located> {
    let mut reader = Reader::new(content);
    let header = Parser::<Skipped>::new().read_header(&mut reader)?;
    check_sizes(&header, content.len())?;
    let mut positions = Vec::new();
    let mut colours = None;
    let mut polygons = Vec::new();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let vertices = Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header)?;
                colours = linear_colours(element, &vertices)?;
                positions = vertices.iter().map(|vertex| DVec3::from(vertex.position)).collect();
            }
            "face" => polygons = Parser::<Polygon>::new().read_payload_for_element(&mut reader, element, &header)?,
            _ => {
                Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header)?;
            }
        }
    }
    if polygons.is_empty() && header.elements.contains_key("tristrips") {
        return Err(Problem::malformed("holds triangle strips, which are not read; export it with faces").into());
    }
    let triangles = triangles(&positions, &polygons)?;
    TriangleMesh::new(positions, triangles, colours).map_err(Located::from)
}

impl From<ParseError> for Located {
    fn from(error: ParseError) -> Self {
        let problem = match error.kind() {
            std::io::ErrorKind::UnexpectedEof => Problem::CutShort(error.to_string()),
            _ => Problem::malformed(format!("is no PLY file that can be read: {error}")),
        };
        // The parser's text names the line already.
        Self { line: None, problem }
    }
}

/// Refuses headers that announce more than the file can hold, before anything is read or set aside for it.
fn check_sizes(header: &Header, file_size: usize) -> Result<(), Problem> {
    for (name, element) in &header.elements {
        let least: usize = match header.encoding {
            Encoding::Ascii => 1,
            _ => element.properties.values().map(|property| least_size(&property.data_type)).sum(),
        };
        if element.count > 0 && (least == 0 || element.count > file_size / least) {
            return Err(Problem::CutShort(format!(
                "announces {} of '{name}', more than its size can hold",
                element.count
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

struct Vertex {
    position: [f64; 3],
    colour: [f64; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [f64::NAN; 3], colour: [0.0; 3] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let entry = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "red" => &mut self.colour[0],
            "green" => &mut self.colour[1],
            "blue" => &mut self.colour[2],
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(value) = number(&property) else { return PropertyAccessResult::UnsupportedType };
        *entry = value;
        PropertyAccessResult::Set
    }
}

struct Polygon(Vec<i64>);

impl PropertyAccess for Polygon {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
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

/// The colours decoded from sRGB, when red, green and blue are all there.
fn linear_colours(element: &ElementDef, vertices: &[Vertex]) -> Result<Option<Vec<[f32; 3]>>, Problem> {
    let mut whole = [0.0; 3];
    for (whole, name) in whole.iter_mut().zip(["red", "green", "blue"]) {
        let Some(property) = element.properties.get(name) else { return Ok(None) };
        *whole = match property.data_type {
            PropertyType::Scalar(ScalarType::Char | ScalarType::UChar) => 255.0,
            PropertyType::Scalar(ScalarType::Short | ScalarType::UShort) => 65535.0,
            _ => 1.0,
        };
    }
    let decode = |(i, vertex): (usize, &Vertex)| {
        let encoded: [f64; 3] = std::array::from_fn(|c| vertex.colour[c] / whole[c]);
        let fits = encoded.iter().all(|c| (0.0..=1.0).contains(c));
        fits.then(|| encoded.map(linear)).ok_or(Problem::BadColour { vertex: i, value: vertex.colour })
    };
    vertices.iter().enumerate().map(decode).collect::<Result<_, _>>().map(Some)
}

fn triangles(positions: &[DVec3], polygons: &[Polygon]) -> Result<Vec<[u32; 3]>, Problem> {
    let mut triangles = Vec::with_capacity(polygons.len());
    let (mut corners, mut cut) = (Vec::new(), Vec::new());
    for Polygon(indices) in polygons {
        if indices.len() < 3 {
            return Err(Problem::malformed(format!(
                "a face of {} corners under 'vertex_indices'; a list of at least 3 is needed",
                indices.len()
            )));
        }
        corners.clear();
        for &index in indices {
            let position = usize::try_from(index).ok().and_then(|i| positions.get(i));
            corners.push(*position.ok_or(Problem::IndexOutOfRange { index, vertices: positions.len() })?);
        }
        cut.clear();
        polygon::triangulate(&corners, &mut cut);
        // An index that found its position among at most 2³² is one of 32 bits.
        triangles.extend(cut.iter().map(|corner| corner.map(|i| indices[i] as u32)));
    }
    Ok(triangles)
}

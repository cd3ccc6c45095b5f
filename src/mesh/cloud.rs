//! Clouds of points: PLY, and text with a point a line (XYZ, CSV). Colours and radii come along where the file has them.

use std::path::Path;

use glam::DVec3;

use super::error::Element;
use super::read::{Conventions, Encoding, Located, Place, shown, without_mark};
use super::triangles::LARGEST_COORDINATE;
use super::{MeshError, Problem, ply};

/// Points as a file gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cloud {
    /// Where they are.
    pub positions: Vec<DVec3>,
    /// Their radii, of each where the file has any.
    pub radii: Option<Vec<f64>>,
    /// Their colours, scene-linear, of each where the file has any.
    pub colours: Option<Vec<[f32; 3]>>,
}

/// Reads a file of points, by the ending of its name.
///
/// # Errors
/// What is wrong with it, and where.
pub fn read_cloud(file: &Path, content: &[u8], conventions: &Conventions) -> Result<Cloud, MeshError> {
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let read = match ending.as_str() {
        "ply" => ply::cloud(content, conventions.colours),
        _ => of_text(content, conventions.colours),
    };
    let checked = read.and_then(|mut cloud| {
        for position in &mut cloud.positions {
            *position = conventions.turn.apply(*position * conventions.scale);
        }
        cloud.radii.iter_mut().flatten().for_each(|radius| *radius *= conventions.scale);
        let none = || Problem::malformed("holds no points; is it the right file?").into();
        if cloud.positions.is_empty() { Err(none()) } else { Ok(cloud) }
    });
    checked.map_err(|Located { place, problem }| MeshError { file: file.into(), place, problem })
}

/// What columns hold; `None` where there is none.
#[derive(Clone, Copy, Debug)]
struct Columns {
    position: [usize; 3],
    radius: Option<usize>,
    colour: Option<[usize; 3]>,
}

impl Columns {
    /// Of lines without names.
    fn of_count(count: usize) -> Option<Self> {
        let position = [0, 1, 2];
        Some(match count {
            3 => Self { position, radius: None, colour: None },
            4 => Self { position, radius: Some(3), colour: None },
            6 => Self { position, radius: None, colour: Some([3, 4, 5]) },
            7 => Self { position, radius: Some(3), colour: Some([4, 5, 6]) },
            _ => return None,
        })
    }

    /// Of a line of names.
    fn of_names(names: &[&str]) -> Option<Self> {
        let names: Vec<String> = names.iter().map(|name| name.trim_matches('"').to_ascii_lowercase()).collect();
        let at = |wanted: &str| names.iter().position(|name| name == wanted);
        let three = |wanted: [&str; 3]| Some([at(wanted[0])?, at(wanted[1])?, at(wanted[2])?]);
        Some(Self {
            position: three(["x", "y", "z"])?,
            radius: at("radius"),
            colour: three(["red", "green", "blue"]).or_else(|| three(["r", "g", "b"])),
        })
    }
}

/// The words of a line: between commas, semicolons or blanks.
fn words(line: &str) -> Vec<&str> {
    line.split([',', ';', ' ', '\t']).map(str::trim).filter(|word| !word.is_empty()).collect()
}

fn of_text(content: &[u8], encoding: Encoding) -> Result<Cloud, Located> {
    let content = without_mark(content)?;
    let text = std::str::from_utf8(content).map_err(|_| {
        Problem::malformed("is no text; points are read from .ply, and from text with x, y, z on each line")
    })?;
    let mut columns: Option<Columns> = None;
    let mut width = 0;
    let mut cloud = Cloud::default();
    let (mut radii, mut colours) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let at =
            |problem: String| Located { place: Some(Place::Line(number + 1)), problem: Problem::malformed(problem) };
        let bare = line.trim();
        let remark = bare.strip_prefix('#').or_else(|| bare.strip_prefix("//"));
        let words = words(remark.unwrap_or(bare));
        if columns.is_none()
            && let Some(named) = Columns::of_names(&words)
        {
            (columns, width) = (Some(named), words.len());
            continue;
        }
        // A first line with nothing but the number of points is usual too.
        if words.is_empty() || remark.is_some() || words.len() == 1 && columns.is_none() {
            continue;
        }
        let columns = match columns {
            Some(columns) => columns,
            None => {
                let found = Columns::of_count(words.len()).ok_or_else(|| {
                    at(format!(
                        "has {} columns: name them in the first line, such as 'x y z radius red green blue'",
                        words.len()
                    ))
                })?;
                width = words.len();
                *columns.insert(found)
            }
        };
        if words.len() != width {
            return Err(at(format!("has {} columns, and the lines before it {width}", words.len())));
        }
        let read = |column: usize| {
            let word = words[column];
            word.parse::<f64>()
                .ok()
                .filter(|number| number.is_finite())
                .ok_or_else(|| at(format!("'{}' is no number", shown(word))))
        };
        let [x, y, z] = columns.position.map(read);
        let position = [x?, y?, z?];
        if position.iter().any(|part| part.abs() > LARGEST_COORDINATE) {
            let vertex = Element::Vertex { number: cloud.positions.len(), first: 0 };
            let problem = Problem::BadCoordinate { vertex, value: position };
            return Err(Located { place: Some(Place::Line(number + 1)), problem });
        }
        cloud.positions.push(position.into());
        if let Some(column) = columns.radius {
            let radius = read(column)?;
            if radius <= 0.0 || radius > LARGEST_COORDINATE {
                return Err(at(format!("a radius must be greater than 0, and is {radius}")));
            }
            radii.push(radius);
        }
        if let Some(three) = columns.colour {
            let [r, g, b] = three.map(read);
            let colour = [r?, g?, b?];
            if colour.iter().any(|channel| *channel < 0.0) {
                return Err(at(format!(
                    "{colour:?} is no colour: where these columns are something else, such as normals, name them in the \
                     first line"
                )));
            }
            colours.push(colour);
        }
    }
    cloud.radii = (!radii.is_empty()).then_some(radii);
    if !colours.is_empty() {
        // Whole numbers to 255, unless none is greater than 1.
        let greatest = colours.iter().flatten().copied().fold(0.0, f64::max);
        let whole = if greatest > 1.0 && encoding == Encoding::Srgb { 255.0 } else { 1.0 };
        let decode = |colour: &[f64; 3]| encoding.decode(colour.map(|channel| channel / whole));
        let decoded: Option<Vec<[f32; 3]>> = colours.iter().map(decode).collect();
        let problem = || Problem::malformed(format!("holds a colour of {greatest}; they go to 1 or to 255"));
        cloud.colours = Some(decoded.ok_or_else(problem)?);
    }
    Ok(cloud)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, content: &str) -> Result<Cloud, String> {
        read_cloud(Path::new(name), content.as_bytes(), &Conventions::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn points_of_all_forms_of_text() {
        let plain = read("a.xyz", "3\n0 0 0\n1,2;3\n\n# a remark\n 4\t5 6 \n").unwrap();
        assert_eq!(plain.positions[1..], [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)]);
        assert_eq!((plain.radii, plain.colours), (None, None));
        assert_eq!(read("a.csv", "0,0,0,2\n").unwrap().radii, Some(vec![2.0]));
        let coloured = read("a.txt", "0 0 0 255 0 0\n1 1 1 0 0 255\n").unwrap();
        assert_eq!(coloured.colours, Some(vec![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]));
        let named = read("a.csv", "//Z,Y,X,nx,R,G,B,radius\n1,2,3,-1,1,0,0,0.5\n").unwrap();
        assert_eq!(named.positions, [DVec3::new(3.0, 2.0, 1.0)]);
        assert_eq!((named.radii, named.colours), (Some(vec![0.5]), Some(vec![[1.0, 0.0, 0.0]])));
    }

    #[test]
    fn points_of_ply() {
        let header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
        let plain = format!("{header}end_header\n0 0 0\n1 2 3\n");
        assert_eq!(read("a.ply", &plain).unwrap().positions, [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)]);
        let more = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float radius\nend_header\n";
        let full = read("a.ply", &format!("{header}{more}0 0 0 255 0 0 0.5\n1 2 3 0 0 255 0.25\n")).unwrap();
        assert_eq!(full.colours, Some(vec![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]));
        assert_eq!(full.radii, Some(vec![0.5, 0.25]));
    }

    #[test]
    fn wrong_lines_are_told_with_their_place() {
        for (content, words) in [
            ("", "holds no points"),
            ("1 2\n", "line 1: has 2 columns: name them"),
            ("1 2 3\n1 2\n", "line 2: has 2 columns, and the lines before it 3"),
            ("1 2 3\n1 2 x\n", "line 2: 'x' is no number"),
            ("1 2 inf\n", "'inf' is no number"),
            ("1 2 1e300\n", "line 1"),
            ("1 2 3 -1\n", "a radius must be greater than 0, and is -1"),
            ("1 2 3 0 -1 0\n", "such as normals"),
            ("1 2 3 400 1 0\n", "a colour of 400"),
        ] {
            let said = read("a.xyz", content).unwrap_err();
            assert!(said.contains(words) && said.contains("a.xyz"), "{content:?}: {said}");
        }
        assert!(read_cloud(Path::new("a.xyz"), &[0xff, 0xd8, 0x41], &Conventions::default()).is_err());
        assert!(read("a.ply", "ply\nformat ascii 1.0\nelement vertex 9999999\nend_header\n").is_err());
        let radius = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                      property float radius\nend_header\n0 0 0 -1\n";
        assert!(read("a.ply", radius).unwrap_err().contains("a radius must be greater than 0"));
    }
}

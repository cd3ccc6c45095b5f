//! STL, text and binary: triangles and nothing else.
//!
//! Our own reader rather than `stl_io`: that one takes a binary file whose first line begins with "solid" for text, and
//! gives no line numbers.

use glam::DVec3;

use super::Problem;
use super::error::Element;
use super::faces::{Faces, VertexPaint};
use super::read::{Conventions, Imported, Located, Place, shown};
use super::triangles::LARGEST_COORDINATE;

/// What stands before the triangles of a binary file: 80 bytes of anything, and their number.
const HEAD: usize = 84;
/// A triangle of a binary file: normal, corners, and two bytes more.
const TRIANGLE: usize = 50;

/// Reads an STL file's content.
pub(super) fn parse(content: &[u8], conventions: &Conventions) -> Result<Imported, Located> {
    let mut faces = Faces::new(0);
    let mut positions: Vec<DVec3> = Vec::new();
    // A binary file is as long as its number of triangles says, whatever its first bytes are.
    let announced = content.get(80..HEAD).map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
    let is_binary = announced.is_some_and(|count| content.len() == HEAD + TRIANGLE * count as usize);
    let looks_like_text = content.trim_ascii_start().starts_with(b"solid");
    if is_binary || !looks_like_text {
        let Some(count) = announced else { return Err(Problem::CutShort("has no number of triangles".into()).into()) };
        let (triangles, rest) = content[HEAD..].as_chunks::<TRIANGLE>();
        if triangles.len() < count as usize {
            let problem = format!("announces {count} triangles and holds {}", triangles.len());
            return Err(Problem::CutShort(problem).into());
        }
        if triangles.len() > count as usize || !rest.is_empty() {
            let problem = format!("announces {count} triangles and goes on after them; is it an STL file?");
            return Err(Problem::malformed(problem).into());
        }
        for (face, triangle) in triangles.iter().enumerate() {
            let number =
                |at: usize| f32::from_le_bytes([triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]]);
            for corner in 0..3 {
                let at = 12 + 12 * corner;
                let place = Some(Place::Face(face));
                let position = usable([number(at), number(at + 4), number(at + 8)].map(f64::from), positions.len());
                positions.push(position.map_err(|problem| Located { place, problem })?);
            }
            push(&mut faces, face, Place::Face(face));
        }
    } else {
        read_text(content, &mut positions, &mut faces)?;
    }
    let mut remarks = Vec::new();
    let mesh = faces.mesh(positions, VertexPaint::default(), conventions, &mut remarks)?;
    Ok(Imported { mesh, materials: Vec::new(), remarks })
}

fn read_text(content: &[u8], positions: &mut Vec<DVec3>, faces: &mut Faces) -> Result<(), Located> {
    let text = std::str::from_utf8(content).map_err(|_| {
        Problem::malformed("begins as text and holds bytes that are none; a binary file would be as long as it says")
    })?;
    let mut corners = 0;
    for (line, number) in text.lines().zip(1..) {
        let located = |problem| Located { place: Some(Place::Line(number)), problem };
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("vertex") => {
                let mut place = [0.0; 3];
                for along in &mut place {
                    let word = words.next().ok_or_else(|| located(Problem::malformed("a vertex has three numbers")))?;
                    let bad = |_| located(Problem::malformed(format!("'{}' is not a number", shown(word))));
                    *along = word.parse().map_err(bad)?;
                }
                positions.push(usable(place, positions.len()).map_err(located)?);
                corners += 1;
            }
            Some("endloop") => {
                if corners != 3 {
                    return Err(located(Problem::malformed(format!(
                        "a facet has three corners, and this has {corners}"
                    ))));
                }
                push(faces, positions.len() / 3 - 1, Place::Line(number));
                corners = 0;
            }
            _ => {}
        }
    }
    if corners > 0 {
        return Err(Problem::CutShort("ends in the middle of a facet".into()).into());
    }
    Ok(())
}

fn push(faces: &mut Faces, face: usize, place: Place) {
    // More than 2³² vertices are refused with the mesh.
    let first = u32::try_from(3 * face).unwrap_or(u32::MAX - 2);
    faces.push([first, first + 1, first + 2], place);
}

fn usable(value: [f64; 3], number: usize) -> Result<DVec3, Problem> {
    let position = DVec3::from(value);
    if position.is_finite() && position.abs().max_element() <= LARGEST_COORDINATE {
        return Ok(position);
    }
    Err(Problem::BadCoordinate { vertex: Element::Vertex { number, first: 0 }, value })
}

#[cfg(test)]
mod tests {
    use super::super::shapes::cube;
    use super::*;

    fn mesh(content: &[u8]) -> Result<super::super::TriangleMesh, String> {
        parse(content, &Conventions::default()).map(|found| found.mesh).map_err(|found| {
            let place = found.place.map_or_else(String::new, |place| format!("{place}: "));
            format!("{place}{}", found.problem)
        })
    }

    fn binary(head: &str) -> Vec<u8> {
        let cube = cube(0.5, 1);
        let mut out = head.as_bytes().to_vec();
        out.resize(80, b' ');
        out.extend((cube.triangles().len() as u32).to_le_bytes());
        for t in 0..cube.triangles().len() {
            out.extend([0; 12]);
            cube.corners(t).iter().flat_map(|p| p.to_array()).for_each(|x| out.extend((x as f32).to_le_bytes()));
            out.extend([0; 2]);
        }
        out
    }

    fn text() -> String {
        let cube = cube(0.5, 1);
        let facet = |t: usize| {
            let corners = cube.corners(t).map(|p| format!("vertex {} {} {:e}\n", p.x, p.y, p.z)).concat();
            format!("facet normal 0 0 0\n outer loop\n{corners} endloop\nendfacet\n")
        };
        format!("solid a cube\n{}endsolid\n", (0..cube.triangles().len()).map(facet).collect::<String>())
    }

    #[test]
    fn both_kinds_give_the_cube() {
        for content in [binary(""), binary("solid by some program\n"), text().into_bytes()] {
            let mesh = mesh(&content).unwrap();
            assert!(mesh.topology().is_closed() && (mesh.volume() - 1.0).abs() < 1e-12, "{}", mesh.volume());
        }
    }

    #[test]
    fn what_is_broken_is_told_with_its_place() {
        let whole = binary("x");
        for (content, part) in [
            (whole[..whole.len() - 1].to_vec(), "announces 12 triangles and holds 11"),
            (whole[..80].to_vec(), "no number of triangles"),
            ([&whole[..], &[0]].concat(), "goes on after them"),
            (text().replace("vertex", "vertex x").into_bytes(), "line 4: 'x' is not a number"),
            (
                text().replacen(" endloop", "vertex 0 0 0\n endloop", 1).into_bytes(),
                "line 8: a facet has three corners",
            ),
            (text().as_bytes()[..text().find("endloop").unwrap()].to_vec(), "cut short"),
        ] {
            let error = mesh(&content).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}

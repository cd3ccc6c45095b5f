//! OBJ: the surface as triangles, as text, with colours as sRGB beside the vertices.

use std::fmt::Write;
use std::path::Path;

use super::{Encoded, Format, Frame, polygons};
use crate::attribute::to_srgb;
use crate::bake::{Error, Output};
use crate::node::Model;

/// The format of `.obj` files.
#[derive(Debug)]
pub struct Obj;

/// What the last line is.
const END: &str = "# end\n";

impl Format for Obj {
    fn extension(&self) -> &'static str {
        "obj"
    }

    fn check(&self, model: &Model, output: &Output) -> Result<(), String> {
        polygons::check(model, output)?;
        polygons::check_still(model)?;
        match model.scalar_names().into_iter().find(|name| model.output.writes(name)) {
            Some(name) => Err(format!(
                "output.grids: an .obj holds no attributes such as `{name}`; leave it out, or write .ply or .glb"
            )),
            None => Ok(()),
        }
    }

    fn encode(&self, frame: &Frame<'_>) -> Result<Encoded, Error> {
        let surface = polygons::of_frame(frame)?;
        let model = frame.prepared.model();
        let mut text = format!(
            "# {}, frame {}, unit {}, {} up\no surface\n",
            frame.output.identity.program, frame.number, model.unit, model.up
        );
        for (i, position) in surface.positions.iter().enumerate() {
            let [x, y, z] = position.as_vec3().to_array();
            // Writing to a string cannot fail.
            let _ = match &surface.colours {
                Some(colours) => {
                    let [r, g, b] = to_srgb(colours[i]).map(|part| part.clamp(0.0, 1.0));
                    writeln!(text, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}")
                }
                None => writeln!(text, "v {x} {y} {z}"),
            };
        }
        for [a, b, c] in &surface.triangles {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        text.push_str(END);
        Ok(Encoded { pieces: vec![text.into_bytes()], polygons: surface.merged })
    }

    fn read_back(&self, pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
        match pieces.last() {
            Some(piece) if piece.ends_with(END.as_bytes()) => Ok(()),
            _ => Err(Error::Encode(format!("{}: its last line is missing", path.display()))),
        }
    }
}

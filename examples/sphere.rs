//! A coloured ball from a scene's text to an OpenVDB file, and what it is at a point.
//!
//!     cargo run --release --example sphere

use std::sync::Arc;

use glam::DVec3;
use hfvdb::bake::{Bytes, Interrupt, compute_frame};
use hfvdb::node::{Source, load};
use hfvdb::shot::PrepareOptions;
use hfvdb::text::Overrides;
use hfvdb::vdb::{self, Frame, Grid, WriteOptions};

const SCENE: &str = r##"
hfvdb = 1

[shape.ball]
sphere = 1
color = ["0.5 + 0.5*x", 0.2, "0.5 + 0.5*z"]
"##;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let source = Source::Text { name: "ball.toml".into(), text: SCENE.into(), folder: ".".into() };
    let model = Arc::new(load(&source, &Overrides::default()).map_err(|problems| problems.to_string())?);
    let prepared = model.prepare(&PrepareOptions { resolution: Some(64), ..PrepareOptions::default() })?;
    let field = prepared.frame(1)?.field;
    println!("at the middle F is {}", field.reference(DVec3::ZERO));

    let computed = compute_frame(&prepared, 1, 1, Bytes(1 << 30), &Interrupt::default(), &|_| {})?;
    let mut grids = vec![Grid::level_set("surface", &computed.band)];
    grids.extend(computed.colour.iter().map(|colour| Grid::colour(&computed.band, colour)));
    let path = std::env::temp_dir().join("hfvdb-example-sphere.vdb");
    let options = WriteOptions { overwrite: true, ..WriteOptions::default() };
    vdb::write(&path, &Frame { grids, ..Frame::default() }, &options)?;
    println!("{}", path.display());
    Ok(())
}

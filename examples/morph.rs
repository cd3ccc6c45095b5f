//! A cube becomes a torus: the volume, and how far the surface is from a point, over ten frames.
//!
//!     cargo run --release --example morph

use std::sync::Arc;

use glam::DVec3;
use hfvdb::node::{Source, load};
use hfvdb::shot::PrepareOptions;
use hfvdb::text::Overrides;

const SCENE: &str = r##"
hfvdb = 1
frames = "1-10"

[shape.cube]
box = 1.6
color = "#d7263d"

[shape.ring]
torus = 0.8
color = "#1b998b"

[morph]
from = "cube"
to = "ring"
"##;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let source = Source::Text { name: "morph.toml".into(), text: SCENE.into(), folder: ".".into() };
    let model = Arc::new(load(&source, &Overrides::default()).map_err(|problems| problems.to_string())?);
    let prepared = model.prepare(&PrepareOptions { resolution: Some(48), ..PrepareOptions::default() })?;
    for frame in 1..=10 {
        let field = prepared.frame(frame)?.field;
        let volume = prepared.report(frame)?.map_or(0.0, |report| report.numbers.volume);
        println!("frame {frame:2}: volume {volume:.3}, F at the middle {:+.3}", field.reference(DVec3::ZERO));
    }
    Ok(())
}

//! What decides the voxels of a sequence: two bakes with the same identity write the same frames.

use serde::{Deserialize, Serialize};

use crate::vdb::Compression;

/// The program, the scene, and the options that change voxels or how a file keeps them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// The program and its version, such as `hfvdb 0.1.0`.
    pub program: String,
    /// The scene's hash in hexadecimal: its text with overrides, and the files it names.
    pub scene: String,
    /// How finely it is sampled.
    #[serde(flatten)]
    pub sampling: Sampling,
    /// Half the band's width in voxels.
    pub half_width: f64,
    /// Grids kept in 16-bit floats, sorted.
    pub half: Vec<String>,
    /// How voxels are compressed: `blosc`, `zip` or `none`.
    pub compression: String,
    /// How far polygons may be from the surface so that there are fewer, in voxels; 0 where none are merged.
    #[serde(default, skip_serializing_if = "is_none")]
    pub adaptivity: f64,
}

fn is_none(adaptivity: &f64) -> bool {
    *adaptivity == 0.0
}

/// How finely a scene is sampled, as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Voxels along the longest side.
    Resolution(u32),
    /// A voxel's edge, world units.
    VoxelSize(f64),
}

impl Identity {
    /// This program's, without adaptivity.
    pub fn new(
        scene: String,
        sampling: Sampling,
        half_width: f64,
        mut half: Vec<String>,
        compression: Compression,
    ) -> Self {
        half.sort();
        half.dedup();
        let compression = match compression {
            Compression::Blosc => "blosc",
            Compression::Zip => "zip",
            Compression::None => "none",
        };
        let program = concat!("hfvdb ", env!("CARGO_PKG_VERSION")).into();
        Self { program, scene, sampling, half_width, half, compression: compression.into(), adaptivity: 0.0 }
    }

    /// Where two of one scene differ, in words: theirs, and ours. Empty where they are alike.
    pub fn differences(&self, ours: &Self) -> String {
        let mut parts = Vec::new();
        let mut compare = |name: &str, theirs: String, ours: String| {
            if theirs != ours {
                parts.push(format!("{name} {theirs} there, {ours} here"));
            }
        };
        compare("scene", self.scene.clone(), ours.scene.clone());
        compare("program", self.program.clone(), ours.program.clone());
        compare("sampling", self.sampling.to_string(), ours.sampling.to_string());
        compare("half width", self.half_width.to_string(), ours.half_width.to_string());
        let list = |names: &[String]| if names.is_empty() { "none".to_owned() } else { names.join("+") };
        compare("16-bit grids", list(&self.half), list(&ours.half));
        compare("compression", self.compression.clone(), ours.compression.clone());
        compare("adaptivity", self.adaptivity.to_string(), ours.adaptivity.to_string());
        parts.join("; ")
    }
}

impl std::fmt::Display for Sampling {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Resolution(voxels) => write!(f, "resolution {voxels}"),
            Self::VoxelSize(edge) => write!(f, "voxel size {edge}"),
        }
    }
}

//! Which grids which program looks for, one table for what is written and for what is checked.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

/// A program that takes files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Client {
    /// Blender, tried in 5.0.1, 4.5 and 4.2.
    Blender,
    /// Houdini 20.0 to 21.0, by its documentation and the published code of its reader.
    Houdini,
    /// Karma, by Houdini's row.
    Karma,
    /// Arnold, by its published code.
    Arnold,
    /// RenderMan: hdPrman and RenderMan for Blender, by their code.
    RenderMan,
    /// V-Ray, by published code and in part by its documentation.
    VRay,
    /// Redshift, by its documentation.
    Redshift,
    /// MoonRay, by its code.
    MoonRay,
    /// Unreal Engine 5.4, by its documentation, and unreal-vdb, by its code.
    Unreal,
    /// `UsdVol` of USD 25.8 and 26.11, tried; Storm, by its code.
    Usd,
}

/// Three numbers a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Three {
    /// One grid of vectors.
    Vectors(&'static str),
    /// Three grids of numbers.
    Numbers([&'static str; 3]),
}

/// What a program looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// The program.
    pub client: Client,
    /// Its name in options.
    pub name: &'static str,
    /// The fog volume.
    pub density: &'static str,
    /// Whether it shows a density, and a level set only where that is turned into polygons, if at all.
    pub shows_fog: bool,
    /// The level set; `None` where it is of no use, or is taken for fog.
    pub level_set: Option<&'static str>,
    /// The colour.
    pub colour: Three,
    /// Whether a colour of another name is not found by it.
    pub needs_colour_name: bool,
    /// The velocity; `None` where it has no use for one.
    pub velocity: Option<Three>,
    /// Further names by which it finds a velocity; none where it takes any.
    pub velocities: &'static [&'static str],
    /// What was never tried, nor read in code, of this row.
    pub not_verified: Option<&'static str>,
}

/// All programs.
pub static PROGRAMS: [Program; 10] = [
    Program {
        client: Client::Blender,
        name: "blender",
        density: "density",
        shows_fog: false,
        level_set: Some("surface"),
        colour: Three::Vectors("color"),
        needs_colour_name: false,
        velocity: Some(Three::Vectors("velocity")),
        velocities: &["velocity", "vel", "v"],
        not_verified: None,
    },
    HOUDINI,
    Program {
        client: Client::Karma,
        name: "karma",
        not_verified: Some("Houdini's names are taken for Karma's, which binds them in shaders"),
        ..HOUDINI
    },
    Program { client: Client::Arnold, name: "arnold", level_set: Some("surface"), ..RENDERER },
    Program {
        client: Client::RenderMan,
        name: "renderman",
        // Of a volume's fields, sorted by name, hdPrman takes the first for the density.
        colour: Three::Vectors("diffuseColor"),
        velocity: Some(Three::Vectors("velocity")),
        ..RENDERER
    },
    Program {
        client: Client::VRay,
        name: "vray",
        density: "Smoke",
        level_set: Some("Surface"),
        colour: Three::Numbers(["Red", "Green", "Blue"]),
        needs_colour_name: true,
        velocity: Some(Three::Numbers(["Velocity.x", "Velocity.y", "Velocity.z"])),
        velocities: &["Velocity"],
        not_verified: Some("its names are in part known from its documentation alone"),
        ..RENDERER
    },
    Program {
        client: Client::Redshift,
        name: "redshift",
        not_verified: Some("its names are known from its documentation alone"),
        ..RENDERER
    },
    Program { client: Client::MoonRay, name: "moonray", ..RENDERER },
    Program {
        client: Client::Unreal,
        name: "unreal",
        level_set: Some("surface"),
        velocity: None,
        not_verified: Some("Sparse Volume Textures are known from their documentation alone"),
        ..RENDERER
    },
    Program {
        client: Client::Usd,
        name: "usd",
        level_set: Some("surface"),
        colour: Three::Vectors("color"),
        velocity: Some(Three::Vectors("velocity")),
        ..RENDERER
    },
];

const HOUDINI: Program = Program {
    client: Client::Houdini,
    name: "houdini",
    density: "density",
    shows_fog: false,
    level_set: Some("surface"),
    colour: Three::Vectors("Cd"),
    needs_colour_name: true,
    velocity: Some(Three::Vectors("vel")),
    velocities: &["vel", "v"],
    not_verified: None,
};

/// A renderer of densities whose shaders name the rest.
const RENDERER: Program = Program {
    client: Client::Arnold,
    name: "",
    density: "density",
    shows_fog: true,
    level_set: None,
    colour: Three::Vectors("Cd"),
    needs_colour_name: false,
    velocity: Some(Three::Vectors("vel")),
    velocities: &[],
    not_verified: None,
};

/// The names of all programs, as options take them.
pub const NAMES: &[&str] =
    &["blender", "houdini", "karma", "arnold", "renderman", "vray", "redshift", "moonray", "unreal", "usd"];

impl Client {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        PROGRAMS.iter().map(|program| program.client)
    }

    /// What it looks for.
    pub fn program(self) -> &'static Program {
        PROGRAMS.iter().find(|program| program.client == self).expect("a test looks for each")
    }
}

impl fmt::Display for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.program().name)
    }
}

impl FromStr for Client {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = PROGRAMS.iter().find(|program| program.name == name);
        found
            .map(|program| program.client)
            .ok_or_else(|| format!("nothing is known of \"{name}\"; take one or more of {}", NAMES.join(", ")))
    }
}

impl Three {
    /// In words, for messages.
    pub fn words(self) -> String {
        match self {
            Self::Vectors(name) => format!("`{name}`"),
            Self::Numbers([a, b, c]) => format!("`{a}`, `{b}` and `{c}`, a number each"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_by_name() {
        for (program, name) in PROGRAMS.iter().zip(NAMES) {
            assert_eq!(program.name, *name);
            assert_eq!(name.parse(), Ok(program.client));
            assert_eq!(program.client.to_string(), *name);
            assert_eq!(serde_json::to_value(program.client).unwrap(), *name);
        }
        assert!("maya".parse::<Client>().unwrap_err().contains("blender, houdini, karma"));
    }

    /// The page says what the table says.
    #[test]
    fn the_page_has_the_table() {
        let page = include_str!("../../docs/output.md");
        let name = |three: Three| three.words().replace(", a number each", "");
        for Program { name: program, density, level_set, colour, velocity, not_verified, .. } in &PROGRAMS {
            let surface = level_set.map_or_else(|| "–".into(), |name| format!("`{name}`"));
            let row = format!(
                "| `{program}` | `{density}` | {} | {} | {surface} | {} |",
                name(*colour),
                velocity.map_or_else(|| "–".into(), name),
                if not_verified.is_some() { "not verified" } else { "" }
            );
            assert!(page.contains(&row), "docs/output.md has no row\n{row}");
        }
    }
}

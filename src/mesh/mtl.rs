//! Materials of OBJ files, through `tobj`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::material::{self, Material};
use super::read::{About, Encoding, Remark};
use crate::disk;

/// What a picture's options in a material's file take for words.
const OPTIONS: [(&str, usize); 12] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
    ("-bm", 1),
    ("-boost", 1),
];

/// The materials of some libraries by their names; what cannot be read is remarked on.
pub(super) fn load(libraries: &[String], folder: &Path, remarks: &mut Vec<Remark>) -> BTreeMap<String, Material> {
    let mut found = BTreeMap::new();
    for library in libraries {
        let mut remark = |text: String, help: &str| {
            remarks.push(Remark { about: About::Colours, place: None, text, help: help.into() });
        };
        let materials = match read(library, folder) {
            Ok(materials) => materials,
            Err(problem) => {
                let text = format!("the materials of '{}' are not read: {problem}", super::read::shown(library));
                remark(text, "put the file beside the mesh, or give the shape a `color`");
                continue;
            }
        };
        for material in materials {
            // Scene-linear, as Blender writes and reads them.
            let diffuse = material.diffuse.map(|colour| colour.map(f64::from));
            let factor = diffuse.and_then(|colour| Encoding::Linear.decode(colour)).unwrap_or([1.0; 3]);
            let mut made = Material { factor, ..Material::default() };
            if let Some(name) = material.diffuse_texture.as_deref().map(without_options) {
                match material::picture(name, folder) {
                    // Programs write any number beside a picture, which stands for the colour.
                    Ok(picture) => made = Material { factor: [1.0; 3], picture: Some(picture), ..made },
                    Err(problem) => {
                        let text = format!("the picture '{}' is not read: {problem}", super::read::shown(name));
                        remark(
                            text,
                            "put it beside the mesh as PNG or JPEG; its material's plain colour stands for it",
                        );
                    }
                }
            }
            found.insert(material.name, made);
        }
    }
    found
}

fn read(library: &str, folder: &Path) -> Result<Vec<tobj::Material>, String> {
    let path = material::find(library, folder).ok_or("it is not there")?;
    let bytes = disk::read(&path).map_err(|error| error.to_string())?;
    let (materials, _) = tobj::load_mtl_buf(&mut bytes.as_slice()).map_err(|error| error.to_string())?;
    Ok(materials)
}

/// The files that libraries name, and they themselves.
pub(super) fn files(libraries: &[String], folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for library in libraries {
        files.extend(material::find(library, folder));
        let pictures = read(library, folder).unwrap_or_default().into_iter().filter_map(|found| found.diffuse_texture);
        files.extend(pictures.flat_map(|name| material::files(without_options(&name), folder)));
    }
    files
}

/// A picture's name without the options before it.
fn without_options(value: &str) -> &str {
    let mut rest = value.trim();
    while let Some((word, count)) = OPTIONS
        .iter()
        .find(|(word, _)| rest.strip_prefix(word).is_some_and(|after| after.starts_with(char::is_whitespace)))
    {
        rest = rest[word.len()..].trim_start();
        for _ in 0..*count {
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            // Of `-o u v w` the last two may be left out.
            if *count == 3 && rest[..end].parse::<f64>().is_err() {
                break;
            }
            rest = rest[end..].trim_start();
        }
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_before_names() {
        for (value, name) in [
            ("a b.png", "a b.png"),
            ("-s 1 1 1 -clamp on tex/a.png", "tex/a.png"),
            ("-o 0.5 a.png", "a.png"),
            ("-bm 0.3 C:\\x\\a.png", "C:\\x\\a.png"),
            ("-mm 0 1 -texres 512 a.png", "a.png"),
        ] {
            assert_eq!(without_options(value), name);
        }
    }
}

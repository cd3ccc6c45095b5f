//! Materials of OBJ files: their base colours and pictures.
//!
//! Our own reader rather than `tobj`: that one panics on a colour of fewer than three numbers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::material::{self, Material, MaterialNumber};
use super::read::{About, Encoding, Remark};
use super::texture::Meaning;
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
            let mut made = Material { factor: material.colour, ..Material::default() };
            let mut unread = |name: &str, problem: String| {
                let text = format!("the picture '{}' is not read: {problem}", super::read::shown(name));
                remark(text, "put it beside the mesh as PNG or JPEG; its material's plain value stands for it");
            };
            if let Some(name) = material.picture.as_deref() {
                match material::picture(name, folder, Meaning::Colours) {
                    // Programs write any number beside a picture, which stands for the colour.
                    Ok(picture) => made = Material { factor: [1.0; 3], picture: Some(picture), ..made },
                    Err(problem) => unread(name, problem),
                }
            }
            for (to, (plain, name)) in made.numbers.iter_mut().zip(&material.numbers) {
                let picture =
                    name.as_deref().and_then(|name| match material::picture(name, folder, Meaning::Numbers) {
                        Ok(picture) => Some((picture, 0)),
                        Err(problem) => {
                            unread(name, problem);
                            None
                        }
                    });
                let factor = if picture.is_some() { Some(1.0) } else { *plain };
                *to = factor.map(|factor| MaterialNumber { factor, picture, wrap: Default::default() });
            }
            found.insert(material.name, made);
        }
    }
    found
}

/// A material as a library has it.
struct Entry {
    name: String,
    /// Scene-linear, as Blender writes and reads it.
    colour: [f32; 3],
    picture: Option<String>,
    /// Roughness and metalness, plain and as a picture.
    numbers: [(Option<f32>, Option<String>); 2],
}

fn read(library: &str, folder: &Path) -> Result<Vec<Entry>, String> {
    let path = material::find(library, folder).ok_or("it is not there")?;
    let bytes = disk::read(&path).map_err(|error| error.to_string())?;
    Ok(entries(&String::from_utf8_lossy(&bytes)))
}

fn entries(text: &str) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for line in text.lines() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if keyword == "newmtl" {
            entries.push(Entry {
                name: rest.trim().into(),
                colour: [1.0; 3],
                picture: None,
                numbers: Default::default(),
            });
        }
        let Some(entry) = entries.last_mut() else { continue };
        match keyword {
            "Kd" => {
                let numbers: Vec<f64> = rest.split_whitespace().filter_map(|word| word.parse().ok()).collect();
                // One number is a grey.
                let colour = match numbers.as_slice() {
                    [grey] => [*grey; 3],
                    [r, g, b, ..] => [*r, *g, *b],
                    _ => continue,
                };
                entry.colour = Encoding::Linear.decode(colour).unwrap_or(entry.colour);
            }
            "Pr" | "Pm" => {
                let number = rest.split_whitespace().next().and_then(|word| word.parse::<f32>().ok());
                entry.numbers[usize::from(keyword == "Pm")].0 = number.filter(|number| number.is_finite());
            }
            "map_Pr" | "map_Pm" => {
                entry.numbers[usize::from(keyword == "map_Pm")].1 = Some(without_options(rest).to_owned());
            }
            "map_Kd" => entry.picture = Some(without_options(rest).to_owned()),
            _ => {}
        }
    }
    entries
}

/// The files that libraries name, and they themselves.
pub(super) fn files(libraries: &[String], folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for library in libraries {
        files.extend(material::find(library, folder));
        let entries = read(library, folder).unwrap_or_default().into_iter();
        let pictures = entries
            .flat_map(|found| found.picture.into_iter().chain(found.numbers.into_iter().filter_map(|number| number.1)));
        files.extend(pictures.flat_map(|name| material::files(&name, folder)));
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
    fn what_a_library_says() {
        let text = "# made by hand\nKd 1 1 1\nnewmtl a b\n  Kd 0.5 0.25 0\nKd 0.1 0.2\nmap_Kd -clamp on my skin.png\r\nPr 0.25\nmap_Pm steel.png\nnewmtl c\nKd 0.5";
        let found = entries(text);
        let [a, c] = found.as_slice() else { panic!("{} materials", found.len()) };
        assert_eq!((a.name.as_str(), a.colour, a.picture.as_deref()), ("a b", [0.5, 0.25, 0.0], Some("my skin.png")));
        assert_eq!(a.numbers, [(Some(0.25), None), (None, Some("steel.png".into()))]);
        assert_eq!((c.name.as_str(), c.colour, c.picture.as_deref()), ("c", [0.5; 3], None));
    }

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

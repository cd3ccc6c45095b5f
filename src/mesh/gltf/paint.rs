//! Base colours of a file's materials, and their pictures.

use std::sync::Arc;

use glam::{DAffine2, DMat2, DVec2};
use serde::Deserialize;

use super::super::Problem;
use super::super::material::{Material, MaterialNumber, Picture};
use super::super::read::{About, Remark, shown};
use super::super::texture::{Meaning, Texture, Wrap};
use super::document::{Glossy, Rough, TextureTransform, TextureUse};
use super::{File, fetched, missing};

/// The materials that faces name, and last the one of those that name none.
pub struct Painted {
    pub materials: Vec<Material>,
    /// Of each, the set of places in its picture, and how these are moved.
    pub uses: Vec<(usize, DAffine2)>,
}

impl Painted {
    pub fn new(file: &File<'_>, remarks: &mut Vec<Remark>) -> Self {
        let mut painted = Self { materials: Vec::new(), uses: Vec::new() };
        // One picture may have colours for one material and numbers for another.
        let mut decoded: Vec<Decoded> = vec![None; file.root.images.len()];
        let mut decoded_numbers = decoded.clone();
        for entry in &file.root.materials {
            let glossy = entry.extensions.get("KHR_materials_pbrSpecularGlossiness");
            let glossy = glossy.map(|value| Glossy::deserialize(value).unwrap_or_default());
            let none = Rough::default();
            let rough = entry.pbr_metallic_roughness.as_ref().unwrap_or(&none);
            let (factor, texture) = match &glossy {
                Some(glossy) => (glossy.diffuse_factor, glossy.diffuse_texture.as_ref()),
                None => (rough.base_color_factor, rough.base_color_texture.as_ref()),
            };
            let [r, g, b, _] =
                factor.unwrap_or([1.0; 4]).map(|part| if part.is_finite() { part.max(0.0) } else { 1.0 });
            let mut made = Material { factor: [r as f32, g as f32, b as f32], ..Material::default() };
            let mut unread = |problem: String| {
                let text = format!("a picture is not read: {problem}");
                let help = "export its pictures as PNG or JPEG; its material's plain value stands for it".into();
                remarks.push(Remark { about: About::Colours, place: None, text, help });
            };
            let mut of_use = texture.map(TextureUse::places);
            if let Some(texture) = texture {
                match file.picture(texture.index, &mut decoded, Meaning::Colours) {
                    Ok((picture, wrap)) => (made.picture, made.wrap) = (Some(Picture::Single(picture)), wrap),
                    Err(problem) => unread(problem),
                }
            }
            if entry.pbr_metallic_roughness.is_some() && glossy.is_none() {
                let picture = rough.metallic_roughness_texture.as_ref().and_then(|texture| {
                    let places = texture.places();
                    if *of_use.get_or_insert(places) != places {
                        unread("that of roughness and metalness lies otherwise on the mesh than that of colour".into());
                        return None;
                    }
                    match file.picture(texture.index, &mut decoded_numbers, Meaning::Numbers) {
                        Ok(found) => Some(found),
                        Err(problem) => {
                            unread(problem);
                            None
                        }
                    }
                });
                // Green has the roughness, blue the metalness.
                for (at, factor) in [rough.roughness_factor, rough.metallic_factor].into_iter().enumerate() {
                    let factor = factor.filter(|factor| factor.is_finite()).unwrap_or(1.0) as f32;
                    let wrap = picture.as_ref().map(|(_, wrap)| *wrap).unwrap_or_default();
                    let picture = picture.as_ref().map(|(picture, _)| (Picture::Single(Arc::clone(picture)), at + 1));
                    made.numbers[at] = Some(MaterialNumber { factor, picture, wrap });
                }
            }
            let of_use = of_use.unwrap_or((0, DAffine2::IDENTITY));
            painted.materials.push(made);
            painted.uses.push(of_use);
        }
        painted.materials.push(Material { factor: [1.0; 3], ..Material::default() });
        painted.uses.push((0, DAffine2::IDENTITY));
        painted
    }

    /// The number of a face's material.
    pub fn number_of(&self, material: Option<usize>) -> Result<usize, Problem> {
        let none = self.materials.len() - 1;
        match material {
            None => Ok(none),
            Some(number) if number < none => Ok(number),
            Some(number) => Err(missing("material", number)),
        }
    }
}

impl TextureUse {
    /// The set of places, and how they are moved (KHR_texture_transform).
    fn places(&self) -> (usize, DAffine2) {
        let Some(value) = self.extensions.get("KHR_texture_transform") else {
            return (self.tex_coord, DAffine2::IDENTITY);
        };
        let transform = TextureTransform::deserialize(value).unwrap_or_default();
        let (sin, cos) = transform.rotation.sin_cos();
        // Counter-clockwise in places that go down.
        let turn = DMat2::from_cols(DVec2::new(cos, -sin), DVec2::new(sin, cos));
        let matrix = turn * DMat2::from_diagonal(transform.scale.unwrap_or([1.0; 2]).into());
        let map = DAffine2::from_mat2_translation(matrix, transform.offset.into());
        (transform.tex_coord.unwrap_or(self.tex_coord), map)
    }
}

type Decoded = Option<Result<Arc<Texture>, String>>;

impl File<'_> {
    fn picture(
        &self,
        texture: usize,
        decoded: &mut [Decoded],
        meaning: Meaning,
    ) -> Result<(Arc<Texture>, [Wrap; 2]), String> {
        let entry = self.root.textures.get(texture).ok_or("it is not in the file")?;
        let Some(source) = entry.source else {
            let extension = entry.extensions.as_object().and_then(|all| all.keys().next());
            return Err(
                extension.map_or_else(|| "it has no source".into(), |name| format!("it needs `{}`", shown(name)))
            );
        };
        let known = decoded.get_mut(source).ok_or("its image is not in the file")?;
        let picture = known.get_or_insert_with(|| {
            let image = &self.root.images[source];
            let texture = match (&image.uri, image.buffer_view) {
                (Some(uri), _) => Texture::decode(&fetched(uri, self.folder)?, meaning)?,
                (None, Some(view)) => {
                    Texture::decode(self.view(view).map_err(|problem| problem.to_string())?, meaning)?
                }
                (None, None) => return Err("it is empty".into()),
            };
            Ok(Arc::new(texture))
        });
        let wrap = |kind: u32| match kind {
            33071 => Wrap::Clamp,
            33648 => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let sampler = entry.sampler.and_then(|sampler| self.root.samplers.get(sampler));
        let wraps = sampler.map_or([Wrap::Repeat; 2], |sampler| [wrap(sampler.wrap_s), wrap(sampler.wrap_t)]);
        Ok((picture.clone()?, wraps))
    }
}

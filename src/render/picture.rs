//! The picture: samples of every pixel, visibility smoothed over neighbours, pixels.

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::{
    camera::Camera,
    image::{Image, decode_srgb, encode_srgb},
    layers::{FAR, Layers},
    screen::Screen,
    studio::{Shade, Studio, combine, expose},
    trace::{Ray, first_hit},
    volume::Volume,
};
use crate::grid::{Band, Channel};

/// Samples of a pixel each way.
const SAMPLES: usize = 3;
/// The places of a pixel's samples, in the order they are taken: the outermost first.
const SAMPLE_PLACES: [(usize, usize); SAMPLES * SAMPLES] =
    [(0, 0), (2, 2), (2, 0), (0, 2), (1, 1), (1, 0), (1, 2), (0, 1), (2, 1)];
/// Directions that each sample looks into for the sky.
const DRAWS: usize = 2;
/// Directions that a pixel's ground looks into for the sky.
const GROUND_DRAWS: usize = 4;
/// Directions chosen for one pixel.
const PIXEL_DRAWS: usize = SAMPLES * SAMPLES * DRAWS;
/// Pixels each way over which visibility is smoothed. Directions differ from pixel to pixel with this period, so
/// that a window of this edge holds each of them once, and no grain is left.
const WINDOW: usize = 4;
/// The part of a picture's width and height, at each border, over which the ground's shadow fades.
const FADE: f32 = 0.16;
/// The albedo where nothing gives a colour: that of sRGB `#cccccc`.
const CLAY: [f32; 3] = [0.604; 3];

/// How a surface is lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// A key light, a sky and soft shadows.
    #[default]
    Studio,
    /// Colours as they are, without light or shadow: for reading values off a picture.
    Flat,
}

/// How a picture looks apart from its object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// How the object is lit.
    pub lighting: Lighting,
    /// The plain background, sRGB.
    pub background: [u8; 3],
    /// The height z, world units, of a ground that takes the object's shadow; seen from above only, and only under
    /// [`Lighting::Studio`].
    pub ground: Option<f64>,
}

impl Default for Look {
    fn default() -> Self {
        Self { lighting: Lighting::Studio, background: [206, 209, 214], ground: None }
    }
}

/// What a picture is taken of.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The surface.
    pub band: &'a Band,
    /// Its colour, scene-linear Rec.709; a light grey where there is none.
    pub colour: Option<&'a Channel<[f32; 3]>>,
    /// Where it is seen from.
    pub camera: Camera,
    /// Light, background and ground.
    pub look: Look,
}

/// Takes the picture, `width` by `height` pixels, opaque. Runs on the current rayon pool; the same pixels for any
/// number of threads. An empty band gives the plain background.
pub fn render(scene: &Scene<'_>, width: usize, height: usize) -> Image {
    let volume = Volume::new(scene.band);
    let painter = Painter::new(scene, &volume, width, height);
    let pixels = painter.pixels();
    let [red, green, blue] = scene.look.background;
    let mut image = Image::new(width, height, [red, green, blue, 255]);
    image.pixels_mut().par_chunks_mut(width.max(1)).enumerate().for_each(|(row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            if let Some(light) = painter.light(&pixels, column, row) {
                let [red, green, blue] = light.map(encode_srgb);
                *out = [red, green, blue, 255];
            }
        }
    });
    image
}

/// Takes the picture in layers, for compositing: the object alone, without background and ground. The same sampling as
/// [`render`].
pub fn render_layers(scene: &Scene<'_>, width: usize, height: usize) -> Layers {
    let look = Look { ground: None, ..scene.look };
    let scene = &Scene { look, ..*scene };
    let volume = Volume::new(scene.band);
    let painter = Painter::new(scene, &volume, width, height);
    let pixels = painter.pixels();
    let mut layers = Layers::new(width, height);
    for (index, pixel) in pixels.iter().enumerate() {
        if pixel.object == 0.0 {
            continue;
        }
        let light = painter.object_light(&pixels, index % width, index / width, |light| light);
        layers.mask[index] = pixel.object / pixel.samples;
        for channel in 0..3 {
            layers.beauty[channel][index] = light[channel] / pixel.samples;
            layers.colour[channel][index] = pixel.colour[channel] / pixel.samples;
            layers.normal[channel][index] = pixel.normal.normalize_or_zero()[channel];
        }
        layers.depth[index] = pixel.nearest.min(FAR);
    }
    layers
}

/// Sums over a pixel's samples on the object, and what was found of the ground.
#[derive(Clone, Copy, Default)]
struct Pixel {
    /// How many samples were taken.
    samples: f32,
    /// How many samples lie on the object.
    object: f32,
    shade: Shade,
    /// Its own colour.
    colour: [f32; 3],
    normal: Vec3,
    /// Along the rays, in voxels.
    depth: f32,
    /// The least depth along the camera's axis, world units.
    nearest: f32,
    /// How many samples lie on the ground.
    ground: f32,
    ground_light: f32,
}

impl Pixel {
    /// Whether the first four samples, with these colours, all lie on one smooth patch of one colour: the others
    /// would tell nothing new. Beside the object they might: a crumb is small.
    fn is_plain(&self, colours: &[[f32; 3]; 4]) -> bool {
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02);
        // The sum of four unit normals that differ by 5° or less is longer than this.
        self.object == 4.0 && self.normal.length() > 3.99 && colours.iter().all(|&colour| near(colour, colours[0]))
    }
}

struct Painter<'a> {
    scene: &'a Scene<'a>,
    volume: &'a Volume<'a>,
    studio: Studio<'a>,
    screen: Screen,
    width: usize,
    height: usize,
    draws: Vec<DVec2>,
    ground: Option<f64>,
    background: [f32; 3],
}

impl<'a> Painter<'a> {
    fn new(scene: &'a Scene<'a>, volume: &'a Volume<'a>, width: usize, height: usize) -> Self {
        Self {
            scene,
            studio: Studio::new(volume, &scene.camera),
            screen: Screen::new(volume, &scene.camera, width, height),
            volume,
            width,
            height,
            draws: draws(),
            ground: scene.look.ground.filter(|height| height.is_finite() && scene.look.lighting == Lighting::Studio),
            background: scene.look.background.map(decode_srgb),
        }
    }

    /// All pixels, sampled.
    fn pixels(&self) -> Vec<Pixel> {
        let mut pixels = vec![Pixel::default(); self.width * self.height];
        pixels.par_chunks_mut(self.width.max(1)).enumerate().for_each(|(row, pixels)| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                *pixel = self.pixel(column, row);
            }
        });
        pixels
    }

    fn pixel(&self, column: usize, row: usize) -> Pixel {
        let phase = row % WINDOW * WINDOW + column % WINDOW;
        let draws = &self.draws[phase * PIXEL_DRAWS..][..PIXEL_DRAWS];
        let may_show = self.screen.may_show(column, row);
        let mut pixel = Pixel::default();
        let mut colours = [[0.0; 3]; 4];
        for (order, (across, down)) in SAMPLE_PLACES.into_iter().enumerate() {
            if order == 4 && (!may_show || pixel.is_plain(&colours)) {
                break;
            }
            let within = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
            let place = DVec2::new(
                (column as f64 + within(across)) / self.width as f64 * 2.0 - 1.0,
                1.0 - (row as f64 + within(down)) / self.height as f64 * 2.0,
            );
            let colour = self.add_sample(&mut pixel, place, order, draws, may_show);
            if let Some(place) = colours.get_mut(order) {
                *place = colour;
            }
        }
        pixel
    }

    /// Adds a sample to the sums; returns the object's own colour there.
    fn add_sample(&self, pixel: &mut Pixel, place: DVec2, order: usize, draws: &[DVec2], may_show: bool) -> [f32; 3] {
        let camera = &self.scene.camera;
        let ray = Ray::new(camera.eye / self.volume.voxel_size(), camera.direction(place));
        let ground = self.ground_distance(&ray);
        pixel.samples += 1.0;
        let end = if may_show { ground.unwrap_or(f64::INFINITY) } else { 0.0 };
        let Some(t) = first_hit(self.volume, &ray, 0.0, end) else {
            if let Some(t) = ground {
                // The ground's light is smooth: one sample of a pixel tells enough.
                if pixel.ground == 0.0 {
                    pixel.ground_light = self.studio.ground(ray.at(t), &draws[..GROUND_DRAWS]);
                }
                pixel.ground += 1.0;
            }
            return [0.0; 3];
        };
        let position = ray.at(t);
        let normal = (-self.volume.gradient(position)).try_normalize().unwrap_or(-ray.direction);
        let albedo = self.scene.colour.map_or(CLAY, |channel| self.volume.colour(channel, position));
        // What is not a number, or negative, is black; values above 1 are kept until the picture is exposed.
        let albedo = albedo.map(|value| if value > 0.0 { value.min(16.0) } else { 0.0 });
        let shade = match self.scene.look.lighting {
            Lighting::Studio => self.studio.object(position, normal, albedo, &draws[order * DRAWS..][..DRAWS]),
            Lighting::Flat => Shade { ambient: albedo, ..Shade::default() },
        };
        let depth = (t * self.volume.voxel_size() * ray.direction.dot(camera.forward)) as f32;
        pixel.nearest = if pixel.object == 0.0 { depth } else { pixel.nearest.min(depth) };
        pixel.object += 1.0;
        for (sum, value) in pixel.colour.iter_mut().zip(albedo) {
            *sum += value;
        }
        pixel.normal += normal.as_vec3();
        pixel.depth += t as f32;
        pixel.shade.add(&shade);
        albedo
    }

    /// How far along the ray the ground is, in voxels, if the ray comes down on it from above.
    fn ground_distance(&self, ray: &Ray) -> Option<f64> {
        let height = self.ground? / self.volume.voxel_size();
        let t = (height - ray.origin.z) / ray.direction.z;
        (ray.direction.z < 0.0 && t > 0.0).then_some(t)
    }

    /// A pixel's linear light, or `None` for plain background.
    fn light(&self, pixels: &[Pixel], column: usize, row: usize) -> Option<[f32; 3]> {
        let pixel = &pixels[row * self.width + column];
        if pixel.object + pixel.ground == 0.0 {
            return None;
        }
        let count = pixel.samples;
        let object = self.object_light(pixels, column, row, expose);
        let ground = match pixel.ground {
            0.0 => 0.0,
            _ => 1.0 - (1.0 - self.smoothed(pixels, column, row).ground) * self.fade(column, row),
        };
        let plain = count - pixel.object - pixel.ground + pixel.ground * ground;
        Some(std::array::from_fn(|channel| (object[channel] + self.background[channel] * plain) / count))
    }

    /// The object's linear light, summed over a pixel's samples on it.
    fn object_light(&self, pixels: &[Pixel], column: usize, row: usize, expose: impl Fn(f32) -> f32) -> [f32; 3] {
        let pixel = &pixels[row * self.width + column];
        match self.scene.look.lighting {
            _ if pixel.object == 0.0 => [0.0; 3],
            Lighting::Flat => pixel.shade.ambient,
            Lighting::Studio => {
                let seen = self.smoothed(pixels, column, row);
                let per_sample = |sum: [f32; 3]| sum.map(|value| value / pixel.object.max(1.0));
                combine(per_sample(pixel.shade.ambient), per_sample(pixel.shade.key), seen.sky, seen.key)
                    .map(|value| expose(value) * pixel.object)
            }
        }
    }

    /// How much of the ground's shadow shows: none at the border, so that pictures side by side are one paper.
    fn fade(&self, column: usize, row: usize) -> f32 {
        let from_border = |place: usize, end: usize| (place.min(end - 1 - place) as f32 + 0.5) / (FADE * end as f32);
        let ramp = |part: f32| part.min(1.0) * part.min(1.0) * (3.0 - 2.0 * part.min(1.0));
        ramp(from_border(column, self.width)) * ramp(from_border(row, self.height))
    }

    /// What a pixel sees of sky, key and ground light: means over the pixels around it that lie on the same piece
    /// of surface.
    fn smoothed(&self, pixels: &[Pixel], column: usize, row: usize) -> Seen {
        let pixel = &pixels[row * self.width + column];
        let normal = pixel.normal.normalize_or_zero();
        let depth = pixel.depth / pixel.object.max(1.0);
        // Across a window, a surface seen at a slant recedes by some pixels' width; more is another surface.
        let pixel_width = 2.0 * self.scene.camera.half_extent.y as f32 * depth / self.height as f32;
        let (mut sums, mut weights, mut ground_weight) = (Seen::default(), 0.0_f32, 0.0_f32);
        let window = |centre: usize, end: usize| centre.saturating_sub(WINDOW / 2)..(centre + WINDOW / 2).min(end);
        for line in window(row, self.height) {
            for other in &pixels[line * self.width..][window(column, self.width)] {
                if other.ground > 0.0 {
                    sums.ground += other.ground_light;
                    ground_weight += 1.0;
                }
                if other.object > 0.0 {
                    let apart = (other.depth / other.object - depth).abs();
                    let alike = other.normal.dot(normal) / other.object;
                    if apart < 8.0 * pixel_width && alike > 0.8 {
                        sums.sky += other.shade.sky_seen;
                        sums.key += other.shade.key_seen;
                        weights += other.object;
                    }
                }
            }
        }
        if weights == 0.0 {
            (sums.sky, sums.key, weights) = (pixel.shade.sky_seen, pixel.shade.key_seen, pixel.object.max(1.0));
        }
        Seen { sky: sums.sky / weights, key: sums.key / weights, ground: sums.ground / ground_weight.max(1.0) }
    }
}

#[derive(Clone, Copy, Default)]
struct Seen {
    sky: f32,
    key: f32,
    ground: f32,
}

/// Places in the unit square for every phase of the window, sample and draw: the additive sequence of the plastic
/// number (its powers −1 and −2), even over the square and over each phase alone.
fn draws() -> Vec<DVec2> {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let step = DVec2::new(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC));
    let phases = WINDOW * WINDOW;
    let count = phases * PIXEL_DRAWS;
    (0..count)
        .map(|index| {
            let (phase, draw) = (index / PIXEL_DRAWS, index % PIXEL_DRAWS);
            (DVec2::splat(0.5) + step * (draw * phases + phase) as f64).fract()
        })
        .collect()
}

#[cfg(test)]
mod tests;

//! The picture: samples of every pixel, what they see of the lights, pixels.

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::{
    camera::Camera,
    ground::Ground,
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
/// The places of a pixel's samples, in the order they are taken: the middle, the corners, the rest.
const SAMPLE_PLACES: [(usize, usize); SAMPLES * SAMPLES] =
    [(1, 1), (0, 0), (2, 2), (2, 0), (0, 2), (1, 0), (1, 2), (0, 1), (2, 1)];
/// Lit pixels each way over which visibility is smoothed. Directions differ from one to the next with this period, so
/// that a window of this edge holds each of them once, and no grain is left.
const WINDOW: usize = 4;
/// A pixel of at most so many voxels shows all there is by one sample, where its neighbours show the same.
const FINE_PIXEL: f64 = 0.75;
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

/// How much work goes into a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// The same light by a twentieth of the rays: every other pixel each way is looked at, those between them and at
    /// edges where neighbours differ.
    Draft,
    /// At least five samples a pixel, and shadows at each of them.
    #[default]
    Final,
}

impl Quality {
    /// Pixels from one that looks for the lights to the next.
    fn lit_step(self) -> usize {
        match self {
            Self::Draft => 2,
            Self::Final => 1,
        }
    }

    /// Directions that a lit pixel looks into for the sky; the key has half as many.
    fn draws(self) -> usize {
        match self {
            Self::Draft => 1,
            Self::Final => 2,
        }
    }

    /// A pixel's mean unit normal is longer than this where its samples lie on one patch: they differ by some 5° (draft: 12°)
    /// at most.
    fn smoothness(self) -> f32 {
        match self {
            Self::Draft => 0.985,
            Self::Final => 0.9975,
        }
    }

    /// Pixels between points of the ground that look for the lights: a shadow is soft by a share of the picture.
    fn ground_step(self, picture: usize) -> usize {
        let across = match self {
            Self::Draft => 100,
            Self::Final => 300,
        };
        picture.div_ceil(across).max(2)
    }
}

/// How a picture looks apart from its object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// How the object is lit.
    pub lighting: Lighting,
    /// How much work goes into it.
    pub quality: Quality,
    /// The plain background, sRGB.
    pub background: [u8; 3],
    /// The height, world units along the axis that points up, of a ground that takes the object's shadow; seen from above only, and only under
    /// [`Lighting::Studio`].
    pub ground: Option<f64>,
}

impl Default for Look {
    fn default() -> Self {
        Self { lighting: Lighting::Studio, quality: Quality::default(), background: [206, 209, 214], ground: None }
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
    let ground = painter.ground.map(|plane| {
        Ground::new(
            &painter.studio,
            &scene.camera,
            plane,
            [width, height],
            scene.look.quality.ground_step(width.max(height)),
        )
    });
    let [red, green, blue] = scene.look.background;
    let mut image = Image::new(width, height, [red, green, blue, 255]);
    image.pixels_mut().par_chunks_mut(width.max(1)).enumerate().for_each(|(row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            if let Some(light) = painter.light(&pixels, ground.as_ref(), column, row) {
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
    for (row, line) in pixels.iter().enumerate() {
        for (column, pixel) in line.pixels.iter().enumerate() {
            let Some(object) = line.object(column) else { continue };
            let (index, samples) = (row * width + column, f32::from(pixel.samples));
            let light = painter.object_light(&pixels, object, column, row, |light| light);
            layers.mask[index] = object.samples / samples;
            for channel in 0..3 {
                layers.beauty[channel][index] = light[channel] / samples;
                layers.colour[channel][index] = object.colour[channel] / samples;
                layers.normal[channel][index] = object.normal.normalize_or_zero()[channel];
            }
            layers.depth[index] = object.nearest.min(FAR);
        }
    }
    layers
}

/// A row of a picture. Most of many pictures is background: only what shows the object takes room.
#[derive(Default)]
struct Row {
    pixels: Vec<Pixel>,
    objects: Vec<Object>,
}

impl Row {
    /// Adds a sample to a pixel.
    fn add(&mut self, column: usize, sample: &Met) {
        let pixel = &mut self.pixels[column];
        pixel.samples += 1;
        match sample {
            Met::Nothing => {}
            Met::Ground => pixel.on_ground += 1,
            Met::Object(sample) => match self.objects.get_mut(pixel.object as usize) {
                Some(object) => object.add(sample),
                None => {
                    pixel.object = self.objects.len() as u32;
                    self.objects.push(*sample);
                }
            },
        }
    }

    /// What a pixel of one sample shows.
    fn view(&self, column: usize) -> View<'_> {
        let pixel = self.pixels.get(column)?;
        Some(match self.objects.get(pixel.object as usize) {
            Some(object) => Met::Object(object),
            None if pixel.on_ground > 0 => Met::Ground,
            None => Met::Nothing,
        })
    }

    /// What a pixel shows of the object.
    fn object(&self, column: usize) -> Option<&Object> {
        self.objects.get(self.pixels[column].object as usize)
    }
}

/// How many samples were taken of a pixel, and where they lie.
#[derive(Clone, Copy)]
struct Pixel {
    samples: u8,
    on_ground: u8,
    /// Its place among the row's objects.
    object: u32,
}

impl Default for Pixel {
    fn default() -> Self {
        Self { samples: 0, on_ground: 0, object: u32::MAX }
    }
}

/// Sums over a pixel's samples on the object.
#[derive(Clone, Copy)]
struct Object {
    /// How many there are.
    samples: f32,
    shade: Shade,
    /// Its own colour.
    colour: [f32; 3],
    normal: Vec3,
    /// The least depth along the camera's axis, world units.
    nearest: f32,
    /// Where the first of the samples lies (index position).
    first: DVec3,
    /// The unit normal there. At an edge the mean of several belongs to no surface.
    first_normal: Vec3,
    /// The way there along its ray, in voxels.
    first_depth: f32,
    /// What that one sees of the lights, where it was looked for.
    seen: Option<Seen>,
}

impl Object {
    /// Whether all samples of a pixel, so many with these colours, lie on one patch of one colour, as smooth as told: more
    /// would tell nothing new. Beside the object they might: a crumb is small.
    fn is_all_of(&self, samples: u8, colours: &[[f32; 3]], smoothness: f32) -> bool {
        let smooth = self.normal.length() > smoothness * self.samples;
        self.samples == f32::from(samples) && smooth && colours.iter().all(|colour| alike(*colour, colours[0]))
    }

    /// Whether another of one sample shows the same patch of the object: colour, direction, and no step between.
    fn continues(&self, other: &Self) -> bool {
        let step = (other.first - self.first).dot(self.normal.as_dvec3()).abs();
        self.normal.dot(other.normal) > 0.995 && alike(self.colour, other.colour) && step < 0.5
    }

    /// Halfway between two of one sample.
    fn halfway(&self, other: &Self) -> Self {
        let mut both = *self;
        both.add(other);
        Self {
            samples: 1.0,
            shade: both.shade.scaled(0.5),
            colour: both.colour.map(|sum| 0.5 * sum),
            normal: both.normal.normalize_or_zero(),
            nearest: 0.5 * (self.nearest + other.nearest),
            first: 0.5 * (self.first + other.first),
            first_normal: (self.first_normal + other.first_normal).normalize_or_zero(),
            first_depth: 0.5 * (self.first_depth + other.first_depth),
            seen: None,
        }
    }

    fn add(&mut self, sample: &Self) {
        self.samples += sample.samples;
        self.shade.add(&sample.shade);
        for (sum, value) in self.colour.iter_mut().zip(sample.colour) {
            *sum += value;
        }
        self.normal += sample.normal;
        self.nearest = self.nearest.min(sample.nearest);
    }
}

/// What a pixel of one sample shows; nothing where there is no such pixel.
type View<'a> = Option<Met<&'a Object>>;

/// Whether both show one patch of the object, or neither shows it.
fn is_like(a: View<'_>, b: View<'_>) -> bool {
    match (a, b) {
        (Some(Met::Object(a)), Some(Met::Object(b))) => a.continues(b),
        (Some(Met::Ground), Some(Met::Ground)) | (Some(Met::Nothing), Some(Met::Nothing)) => true,
        _ => false,
    }
}

/// What is seen halfway between two that show the same.
fn between(a: View<'_>, b: View<'_>) -> Option<Met> {
    match (a?, b?) {
        (Met::Object(a), Met::Object(b)) if a.continues(b) => Some(Met::Object(a.halfway(b))),
        (Met::Ground, Met::Ground) => Some(Met::Ground),
        (Met::Nothing, Met::Nothing) => Some(Met::Nothing),
        _ => None,
    }
}

fn alike(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02)
}

/// What a ray meets first.
#[derive(Clone, Copy)]
enum Met<T = Object> {
    Object(T),
    Ground,
    Nothing,
}

/// The parts of sky and key that are seen.
#[derive(Clone, Copy, Default)]
struct Seen {
    sky: f32,
    key: f32,
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
        let ground = scene.look.ground.filter(|height| height.is_finite() && scene.look.lighting == Lighting::Studio);
        Self {
            scene,
            studio: Studio::new(volume, &scene.camera),
            screen: Screen::new(volume, &scene.camera, width, height),
            volume,
            width,
            height,
            draws: draws(WINDOW * WINDOW, scene.look.quality.draws()),
            ground: ground.map(|height| height / volume.voxel_size()),
            background: scene.look.background.map(decode_srgb),
        }
    }

    /// All pixels, sampled.
    fn pixels(&self) -> Vec<Row> {
        let is_draft = self.scene.look.quality == Quality::Draft && self.pixel_width() <= FINE_PIXEL;
        let mut rows = if is_draft { self.drafted() } else { self.sampled() };
        if self.scene.look.lighting == Lighting::Studio {
            let step = self.scene.look.quality.lit_step();
            rows.par_iter_mut().enumerate().step_by(step).for_each(|(row, line)| {
                for column in (0..self.width).step_by(step) {
                    if let Some(object) = line.objects.get_mut(line.pixels[column].object as usize) {
                        object.seen = Some(self.seen(object, self.draws_of(column / step, row / step)));
                    }
                }
            });
        }
        rows
    }

    fn new_row(&self) -> Row {
        Row { pixels: vec![Pixel::default(); self.width], objects: Vec::new() }
    }

    /// All pixels with as many samples as each needs by itself.
    fn sampled(&self) -> Vec<Row> {
        let of_row = |row: usize| {
            let mut line = self.new_row();
            for column in 0..self.width {
                self.sample(&mut line, column, row, 0..SAMPLES * SAMPLES);
            }
            line
        };
        (0..self.height).into_par_iter().map(of_row).collect()
    }

    /// One sample of every other pixel each way; of those between them where they differ; and more where neighbours do.
    fn drafted(&self) -> Vec<Row> {
        let even = |row: usize| {
            let mut line = self.new_row();
            for column in (0..self.width).step_by(2) {
                self.sample(&mut line, column, row, 0..1);
            }
            for column in (1..self.width).step_by(2) {
                let between = between(line.view(column - 1), line.view(column + 1));
                self.fill(&mut line, column, row, between);
            }
            line
        };
        let even: Vec<Row> = (0..self.height).into_par_iter().step_by(2).map(even).collect();
        let odd = |place: usize| {
            let mut line = self.new_row();
            for column in 0..self.width {
                let below = even.get(place + 1).and_then(|below| below.view(column));
                let between = between(even[place].view(column), below);
                self.fill(&mut line, column, 2 * place + 1, between);
            }
            line
        };
        let odd: Vec<Row> = (0..self.height / 2).into_par_iter().map(odd).collect();
        let mut rows = Vec::with_capacity(self.height);
        let mut odd = odd.into_iter();
        for line in even {
            rows.push(line);
            rows.extend(odd.next());
        }
        let borders = self.borders(&rows);
        rows.par_iter_mut().zip(&borders).enumerate().for_each(|(row, (line, borders))| {
            for &column in borders {
                self.sample(line, column, row, 1..SAMPLES * SAMPLES);
            }
        });
        rows
    }

    /// Sets a pixel to what its neighbours show alike, or looks for itself.
    fn fill(&self, line: &mut Row, column: usize, row: usize, between: Option<Met>) {
        match between {
            Some(met) => line.add(column, &met),
            None => self.sample(line, column, row, 0..1),
        }
    }

    /// A pixel's width in the middle of the object, in voxels.
    fn pixel_width(&self) -> f64 {
        let (least, greatest) = self.volume.extent();
        let camera = &self.scene.camera;
        let middle = 0.5 * (least + greatest) - camera.eye / self.volume.voxel_size();
        2.0 * camera.half_extent.y * middle.dot(camera.forward).abs() / self.height as f64
    }

    /// Which pixels of each row, of one sample each, differ from one of those around them.
    fn borders(&self, rows: &[Row]) -> Vec<Vec<usize>> {
        let around = |centre: usize, end: usize| centre.saturating_sub(1)..(centre + 2).min(end);
        let of_row = |row: usize| {
            let differs = |column: &usize| {
                let view = rows[row].view(*column);
                let mut others = around(row, self.height)
                    .flat_map(|line| around(*column, self.width).map(move |place| rows[line].view(place)));
                others.any(|other| !is_like(view, other))
            };
            (0..self.width).filter(differs).collect()
        };
        (0..self.height).into_par_iter().map(of_row).collect()
    }

    /// Takes samples of a pixel, as many of these as tell something new.
    fn sample(&self, line: &mut Row, column: usize, row: usize, order: Range<usize>) {
        const ENOUGH: usize = 5;
        let may_show = self.screen.may_show(column, row);
        let mut colours = [line.object(column).map_or([0.0; 3], |object| object.colour); ENOUGH];
        for place in order {
            if place == ENOUGH {
                let (samples, smoothness) = (line.pixels[column].samples, self.scene.look.quality.smoothness());
                let is_all_of = |object: &Object| object.is_all_of(samples, &colours, smoothness);
                if !may_show || line.object(column).is_some_and(is_all_of) {
                    break;
                }
            }
            let (across, down) = SAMPLE_PLACES[place];
            let within = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
            let on_screen = DVec2::new(
                (column as f64 + within(across)) / self.width as f64 * 2.0 - 1.0,
                1.0 - (row as f64 + within(down)) / self.height as f64 * 2.0,
            );
            let met = self.look_at(on_screen, may_show);
            line.add(column, &met);
            if let (Some(kept), Met::Object(object)) = (colours.get_mut(place), &met) {
                *kept = object.colour;
            }
        }
    }

    /// What there is to see at a place of the picture.
    fn look_at(&self, place: DVec2, may_show: bool) -> Met {
        let camera = &self.scene.camera;
        let ray = Ray::new(camera.eye / self.volume.voxel_size(), camera.direction(place));
        let ground = self.ground.and_then(|plane| ray.meets_level(camera.upright, plane));
        let end = if may_show { ground.unwrap_or(f64::INFINITY) } else { 0.0 };
        let Some(t) = first_hit(self.volume, &ray, 0.0, end) else {
            return if ground.is_some() { Met::Ground } else { Met::Nothing };
        };
        let position = ray.at(t);
        let normal = (-self.volume.gradient(position)).try_normalize().unwrap_or(-ray.direction);
        let albedo = self.scene.colour.map_or(CLAY, |channel| self.volume.colour(channel, position));
        // What is not a number, or negative, is black; values above 1 are kept until the picture is exposed.
        let albedo = albedo.map(|value| if value > 0.0 { value.min(16.0) } else { 0.0 });
        let shade = match self.scene.look.lighting {
            Lighting::Studio => self.studio.object(normal, albedo),
            Lighting::Flat => Shade { ambient: albedo, ..Shade::default() },
        };
        Met::Object(Object {
            samples: 1.0,
            shade,
            colour: albedo,
            normal: normal.as_vec3(),
            nearest: (t * self.volume.voxel_size() * ray.direction.dot(camera.forward)) as f32,
            first: position,
            first_normal: normal.as_vec3(),
            first_depth: t as f32,
            seen: None,
        })
    }

    /// The draws of a place in the window.
    fn draws_of(&self, column: usize, row: usize) -> &[DVec2] {
        let count = self.scene.look.quality.draws();
        let phase = row % WINDOW * WINDOW + column % WINDOW;
        &self.draws[phase * count..][..count]
    }

    /// What a pixel's first sample sees, in the directions of these draws.
    fn seen(&self, object: &Object, draws: &[DVec2]) -> Seen {
        let [sky, key] = self.studio.seen_from(object.first, object.first_normal.as_dvec3(), draws);
        Seen { sky, key }
    }

    /// A pixel's linear light, or `None` for plain background.
    fn light(&self, rows: &[Row], ground: Option<&Ground>, column: usize, row: usize) -> Option<[f32; 3]> {
        let Pixel { samples, on_ground, .. } = rows[row].pixels[column];
        let object = rows[row].object(column);
        if object.is_none() && on_ground == 0 {
            return None;
        }
        let light = object.map_or([0.0; 3], |object| self.object_light(rows, object, column, row, expose));
        let [samples, on_ground] = [samples, on_ground].map(f32::from);
        let ground = ground.map_or(1.0, |ground| 1.0 - (1.0 - ground.light(column, row)) * self.fade(column, row));
        let plain = samples - object.map_or(0.0, |object| object.samples) - on_ground + on_ground * ground;
        Some(std::array::from_fn(|channel| (light[channel] + self.background[channel] * plain) / samples))
    }

    /// The object's linear light, summed over a pixel's samples on it.
    fn object_light(
        &self,
        rows: &[Row],
        object: &Object,
        column: usize,
        row: usize,
        expose: impl Fn(f32) -> f32,
    ) -> [f32; 3] {
        match self.scene.look.lighting {
            Lighting::Flat => object.shade.ambient,
            Lighting::Studio => {
                let seen = self.smoothed(rows, object, column, row);
                let per_sample = |sum: [f32; 3]| sum.map(|value| value / object.samples);
                combine(per_sample(object.shade.ambient), per_sample(object.shade.key), seen.sky, seen.key)
                    .map(|value| expose(value) * object.samples)
            }
        }
    }

    /// How much of the ground's shadow shows: none at the border, so that pictures side by side are one paper.
    fn fade(&self, column: usize, row: usize) -> f32 {
        let from_border = |place: usize, end: usize| (place.min(end - 1 - place) as f32 + 0.5) / (FADE * end as f32);
        let ramp = |part: f32| part.min(1.0) * part.min(1.0) * (3.0 - 2.0 * part.min(1.0));
        ramp(from_border(column, self.width)) * ramp(from_border(row, self.height))
    }

    /// What a pixel sees of sky and key: means over the lit pixels around it that lie on the same piece of surface.
    fn smoothed(&self, rows: &[Row], object: &Object, column: usize, row: usize) -> Seen {
        let step = self.scene.look.quality.lit_step();
        let (normal, depth) = (object.first_normal, object.first_depth);
        // Across a window, a surface seen at a slant recedes by some pixels' width; more is another surface.
        let pixel_width = 2.0 * self.scene.camera.half_extent.y as f32 * depth / self.height as f32;
        let near = 8.0 * pixel_width * step as f32;
        let (mut sum, mut weight) = (Seen::default(), 0.0_f32);
        let half = WINDOW * step / 2;
        let window = |centre: usize, end: usize| {
            (centre.saturating_sub(half).next_multiple_of(step)..(centre + half).min(end)).step_by(step)
        };
        for line in window(row, self.height) {
            for place in window(column, self.width) {
                let Some(other) = rows[line].object(place) else { continue };
                let Some(seen) = other.seen else { continue };
                if (other.first_depth - depth).abs() < near && other.first_normal.dot(normal) > 0.8 {
                    sum.sky += seen.sky;
                    sum.key += seen.key;
                    weight += 1.0;
                }
            }
        }
        match weight {
            // Alone with its surface, it looks in all directions.
            0.0 => self.seen(object, &self.draws),
            _ => Seen { sky: sum.sky / weight, key: sum.key / weight },
        }
    }
}

/// Places in the unit square for every phase of a window: the additive sequence of the plastic number (its powers −1
/// and −2), even over the square and over each phase alone.
pub(super) fn draws(phases: usize, of_phase: usize) -> Vec<DVec2> {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let step = DVec2::new(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC));
    (0..phases * of_phase)
        .map(|index| {
            let (phase, draw) = (index / of_phase, index % of_phase);
            (DVec2::splat(0.5) + step * (draw * phases + phase) as f64).fract()
        })
        .collect()
}

#[cfg(test)]
mod tests;

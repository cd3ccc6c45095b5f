//! The light on the object: a large warm key from the upper left of the camera, a cool sky all around, a soft
//! shadow on the ground. Chosen so that form reads at a thumbnail's size and colours stay what they are.

use glam::{DVec2, DVec3};

use super::{
    camera::Camera,
    trace::{Ray, first_hit},
    volume::Volume,
};

/// What the key adds to a white surface that faces it.
const KEY: [f32; 3] = [0.80, 0.77, 0.72];
/// What an open sky adds to a white surface that faces up, and what the ground throws back to one that faces down.
const SKY: [f32; 3] = [0.42, 0.44, 0.47];
const GROUND: [f32; 3] = [0.24, 0.23, 0.22];
/// A weak light from the camera, so that what looks at us is never without form.
const FILL: f32 = 0.10;
/// The sine of the angle that the key spans to each side; a smaller one gives harder shadows.
const KEY_SPREAD: f64 = 0.22;
/// The highlight's strength and width: enough to tell round from flat, too little to bleach a colour.
const SHINE: f32 = 0.10;
const SHINE_POWER: i32 = 36;
/// Light that finds its way into a place that sees no sky, by way of its surroundings.
const BOUNCE: f32 = 0.12;
/// How dark the ground gets where it sees no key, and where it sees no sky.
const GROUND_SHADOW: [f32; 2] = [0.34, 0.42];
/// Rays start this far from the surface, in voxels: less, and the interpolated surface shades itself in spots;
/// more, and light leaks into narrow folds.
const LIFT: f64 = 1.0;

/// Light on one point of the object, kept in parts, because visibility is smoothed over pixels before they meet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shade {
    /// What sky and fill give where all of the sky is seen.
    pub ambient: [f32; 3],
    /// What the key gives where all of it is seen.
    pub key: [f32; 3],
}

impl Shade {
    /// The light by a factor.
    pub(super) fn scaled(&self, by: f32) -> Self {
        Self { ambient: self.ambient.map(|value| by * value), key: self.key.map(|value| by * value) }
    }

    /// Adds another point's light, part by part.
    pub(super) fn add(&mut self, other: &Self) {
        for channel in 0..3 {
            self.ambient[channel] += other.ambient[channel];
            self.key[channel] += other.key[channel];
        }
    }
}

/// The lights, set for one camera.
pub(super) struct Studio<'a> {
    volume: &'a Volume<'a>,
    key: DVec3,
    forward: DVec3,
    /// The axis that points up.
    upright: usize,
}

impl<'a> Studio<'a> {
    pub(super) fn new(volume: &'a Volume<'a>, camera: &Camera) -> Self {
        let key = camera.right * -0.55 + camera.up * 0.75 - camera.forward * 0.62;
        Self { volume, key: key.normalize(), forward: camera.forward, upright: camera.upright.axis() }
    }

    /// A voxel's edge in world units.
    pub(super) fn voxel_size(&self) -> f64 {
        self.volume.voxel_size()
    }

    /// Light on a point of the object with an outward unit normal.
    pub(super) fn object(&self, normal: DVec3, albedo: [f32; 3]) -> Shade {
        let upward = (0.5 + 0.5 * normal[self.upright]) as f32;
        let facing = (-normal.dot(self.forward)).max(0.0) as f32;
        let towards_key = normal.dot(self.key).max(0.0) as f32;
        let half = (self.key - self.forward).normalize();
        let shine = SHINE * (normal.dot(half).max(0.0) as f32).powi(SHINE_POWER) * towards_key.sqrt();
        let mut shade = Shade::default();
        for channel in 0..3 {
            let sky = GROUND[channel] + (SKY[channel] - GROUND[channel]) * upward;
            shade.ambient[channel] = albedo[channel] * (sky + FILL * facing);
            shade.key[channel] = KEY[channel] * (albedo[channel] * towards_key + shine);
        }
        shade
    }

    /// The parts of sky and key that a point of the object (index position) sees. `draws` are places in the unit square
    /// that choose the directions looked into, the first half of them for the key; more of them give less noise.
    pub(super) fn seen_from(&self, position: DVec3, normal: DVec3, draws: &[DVec2]) -> [f32; 2] {
        let from = position + normal * LIFT;
        let key = if normal.dot(self.key) > 0.0 { self.key_seen(from, &draws[..draws.len().div_ceil(2)]) } else { 0.0 };
        [self.sky_seen(from, normal, draws), key]
    }

    /// How bright the ground is at a point of it, as a share of the open ground.
    pub(super) fn ground(&self, position: DVec3, draws: &[DVec2]) -> f32 {
        let key = self.key_seen(position, draws);
        let sky = self.sky_seen(position, DVec3::AXES[self.upright], draws);
        (1.0 - GROUND_SHADOW[0] * (1.0 - key)) * (1.0 - GROUND_SHADOW[1] * (1.0 - sky))
    }

    /// The share of directions, weighted by their cosine, in which nothing stands before the sky.
    fn sky_seen(&self, from: DVec3, normal: DVec3, draws: &[DVec2]) -> f32 {
        let (across, along) = normal.any_orthonormal_pair();
        self.seen(from, draws, |disc| {
            normal * (1.0 - disc.length_squared()).max(0.0).sqrt() + across * disc.x + along * disc.y
        })
    }

    fn key_seen(&self, from: DVec3, draws: &[DVec2]) -> f32 {
        let (across, along) = self.key.any_orthonormal_pair();
        self.seen(from, draws, |disc| (self.key + (across * disc.x + along * disc.y) * KEY_SPREAD).normalize())
    }

    fn seen(&self, from: DVec3, draws: &[DVec2], direction: impl Fn(DVec2) -> DVec3) -> f32 {
        let free = |draw: &&DVec2| {
            let ray = Ray::new(from, direction(on_disc(**draw)));
            first_hit(self.volume, &ray, 0.0, f64::INFINITY).is_none()
        };
        draws.iter().filter(free).count() as f32 / draws.len().max(1) as f32
    }
}

/// A place in the unit square, carried to the unit disc: equal areas stay equal.
fn on_disc(draw: DVec2) -> DVec2 {
    let (sin, cos) = libm::sincos(draw.x * std::f64::consts::TAU);
    DVec2::new(cos, sin) * draw.y.sqrt()
}

/// Ambient and key light with what is seen of them.
pub(super) fn combine(ambient: [f32; 3], key: [f32; 3], sky_seen: f32, key_seen: f32) -> [f32; 3] {
    let open = BOUNCE + (1.0 - BOUNCE) * sky_seen;
    std::array::from_fn(|channel| ambient[channel] * open + key[channel] * key_seen)
}

/// Light as the picture shows it: as it is up to a point, then bent so that nothing clips.
pub(super) fn expose(light: f32) -> f32 {
    const BEND: f32 = 0.7;
    let over = (light - BEND) / (1.0 - BEND);
    if over <= 0.0 { light } else { BEND + (1.0 - BEND) * (over / (1.0 + over)) }
}

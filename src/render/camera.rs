//! Where a picture is taken from. Where z is up the front faces −y, as in Blender; where y is, +z, as in Houdini.

use std::str::FromStr;

use glam::{DVec2, DVec3};

use crate::field::Aabb;

/// The tangent of half the angle of view across the picture's shorter side: that of an 85 mm lens on 24 mm of
/// film. A wider lens bends shapes near the border; a longer one flattens depth.
const LENS: f64 = 12.0 / 85.0;
/// Room between the box and the picture's border, as a share of the box's extent in the picture.
const MARGIN: f64 = 0.06;

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// y: the front faces +z.
    Y,
    /// z: the front faces −y.
    #[default]
    Z,
}

impl Up {
    /// The axis of this name, `y` or `z`.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "y" => Some(Self::Y),
            "z" => Some(Self::Z),
            _ => None,
        }
    }

    /// Its number: 0 is x.
    pub fn axis(self) -> usize {
        match self {
            Self::Y => 1,
            Self::Z => 2,
        }
    }

    /// A direction where z is up, as it is where this axis is.
    fn turned(self, v: DVec3) -> DVec3 {
        match self {
            Self::Y => DVec3::new(v.x, v.z, -v.y),
            Self::Z => v,
        }
    }
}

/// A direction to look from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// From the front, level.
    Front,
    /// From behind, level.
    Back,
    /// From −x, level.
    Left,
    /// From +x, level.
    Right,
    /// From the front, 35° to the right and 27° above: three sides of a box are seen.
    #[default]
    ThreeQuarter,
    /// From above, with the back upward in the picture.
    Top,
    /// From below, with the front upward in the picture.
    Bottom,
}

impl View {
    /// All of them, by their names.
    pub const NAMES: [(&'static str, Self); 7] = [
        ("front", Self::Front),
        ("back", Self::Back),
        ("left", Self::Left),
        ("right", Self::Right),
        ("top", Self::Top),
        ("bottom", Self::Bottom),
        ("three-quarter", Self::ThreeQuarter),
    ];

    /// Degrees to the right of the front, and above level.
    fn angles(self) -> (f64, f64) {
        match self {
            Self::Front => (0.0, 0.0),
            Self::Back => (180.0, 0.0),
            Self::Left => (-90.0, 0.0),
            Self::Right => (90.0, 0.0),
            Self::ThreeQuarter => (35.0, 27.0),
            Self::Top => (0.0, 90.0),
            Self::Bottom => (0.0, -90.0),
        }
    }
}

impl FromStr for View {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, view)| *view);
        found.ok_or_else(|| {
            let names = Self::NAMES.map(|(name, _)| name);
            format!("there is no view `{name}`: take one of {}", names.join(", "))
        })
    }
}

/// A perspective camera in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: DVec3,
    /// Unit vector to the picture's right.
    pub right: DVec3,
    /// Unit vector to the picture's top.
    pub up: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// Half the picture's width and height at distance 1 from the eye.
    pub half_extent: DVec2,
    /// The axis of the world that points up: where light comes from, and what ground lies across.
    pub upright: Up,
}

impl Camera {
    /// The camera that shows a whole world box from a view, turned by `turn` degrees (counter-clockwise from
    /// above), in a picture of the given aspect (width ÷ height). Frame one box around a whole sequence, and
    /// nothing but the object moves. A box without extent, or not finite, is given one.
    pub fn framing(bounds: &Aabb, upright: Up, view: View, turn: f64, aspect: f64) -> Self {
        let (azimuth, elevation) = view.angles();
        let turn = if turn.is_finite() { turn % 360.0 } else { 0.0 };
        let (sin_azimuth, cos_azimuth) = libm::sincos((azimuth + turn).to_radians());
        let (sin_elevation, cos_elevation) = libm::sincos(elevation.to_radians());
        let right = DVec3::new(cos_azimuth, sin_azimuth, 0.0);
        let level = DVec3::new(-sin_azimuth, cos_azimuth, 0.0);
        let forward = level * cos_elevation - DVec3::Z * sin_elevation;
        let up = level * sin_elevation + DVec3::Z * cos_elevation;
        let [right, forward, up] = [right, forward, up].map(|direction| upright.turned(direction));

        let aspect = if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
        let half_extent = if aspect > 1.0 { DVec2::new(LENS * aspect, LENS) } else { DVec2::new(LENS, LENS / aspect) };
        let bounds = with_extent(bounds);
        let centre = (bounds.min + bounds.max) * 0.5;
        let corners = bounds_corners(&bounds).map(|corner| corner - centre);
        let fit = half_extent / (1.0 + MARGIN);
        let (across, distance_across) = fit_axis(&corners, right, forward, fit.x);
        let (along, distance_along) = fit_axis(&corners, up, forward, fit.y);
        let distance = distance_across.max(distance_along);
        Self {
            eye: centre + right * across + up * along - forward * distance,
            right,
            up,
            forward,
            half_extent,
            upright,
        }
    }

    /// The camera that shows a whole world box from a view however it is [`Camera::turned`] about the box's middle: of the
    /// same distance at every turn.
    pub fn framing_all_around(bounds: &Aabb, upright: Up, view: View, turn: f64, aspect: f64) -> Self {
        let bounds = with_extent(bounds);
        let (centre, mut half) = ((bounds.min + bounds.max) * 0.5, bounds.size() * 0.5);
        let height = half[upright.axis()];
        half = DVec3::splat((half.length_squared() - height * height).sqrt());
        half[upright.axis()] = height;
        Self::framing(&Aabb::new(centre - half, centre + half), upright, view, turn, aspect)
    }

    /// The camera turned by some degrees (counter-clockwise from above) about the upright axis through a place.
    pub fn turned(self, about: DVec3, degrees: f64) -> Self {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let turn = |v: DVec3| match self.upright {
            Up::Y => DVec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x),
            Up::Z => DVec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z),
        };
        let [right, up, forward] = [self.right, self.up, self.forward].map(turn);
        Self { eye: about + turn(self.eye - about), right, up, forward, ..self }
    }

    /// The unit direction through a place in the picture: −1 to 1 from left to right, and from bottom to top.
    pub(super) fn direction(&self, place: DVec2) -> DVec3 {
        let slope = place * self.half_extent;
        (self.forward + self.right * slope.x + self.up * slope.y).normalize()
    }
}

/// A finite box with room in it.
fn with_extent(bounds: &Aabb) -> Aabb {
    let finite = bounds.min.is_finite() && bounds.max.is_finite() && bounds.min.cmple(bounds.max).all();
    if !finite {
        return Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    }
    if bounds.min == bounds.max { bounds.grown(1.0) } else { *bounds }
}

fn bounds_corners(bounds: &Aabb) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let pick = |bit: usize, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
        DVec3::new(
            pick(0, bounds.min.x, bounds.max.x),
            pick(1, bounds.min.y, bounds.max.y),
            pick(2, bounds.min.z, bounds.max.z),
        )
    })
}

/// Where along `axis` the eye stands, and the least distance at which both border planes of slope `slope` clear
/// all corners: with c the place and D the distance, ±(x − c) ≤ slope·(D + z) for every corner (x, z).
fn fit_axis(corners: &[DVec3; 8], axis: DVec3, forward: DVec3, slope: f64) -> (f64, f64) {
    let mut reach = [f64::NEG_INFINITY; 2];
    for corner in corners {
        let (across, depth) = (corner.dot(axis), corner.dot(forward));
        reach[0] = reach[0].max(across - slope * depth);
        reach[1] = reach[1].max(-across - slope * depth);
    }
    ((reach[0] - reach[1]) * 0.5, (reach[0] + reach[1]) * 0.5 / slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a world position appears: −1 to 1 both ways.
    fn place(camera: &Camera, position: DVec3) -> DVec2 {
        let offset = position - camera.eye;
        let depth = offset.dot(camera.forward);
        assert!(depth > 0.0);
        DVec2::new(offset.dot(camera.right), offset.dot(camera.up)) / depth / camera.half_extent
    }

    #[test]
    fn a_framed_box_fills_the_picture_and_stays_inside() {
        let bounds = Aabb::new(DVec3::new(-3.0, 1.0, 100.0), DVec3::new(2.0, 1.5, 104.0));
        for (name, view) in View::NAMES {
            for aspect in [0.5, 1.0, 2.5] {
                for turn in [0.0, 77.0] {
                    let camera = Camera::framing(&bounds, Up::Y, view, turn, aspect);
                    let places = bounds_corners(&bounds).map(|corner| place(&camera, corner).abs());
                    let reach = places.into_iter().fold(DVec2::ZERO, DVec2::max).max_element();
                    assert!((reach * (1.0 + MARGIN) - 1.0).abs() < 1e-9, "{name} {aspect} {turn}: {reach}");
                }
            }
        }
    }

    #[test]
    fn views_look_from_where_they_say() {
        let bounds = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        let eye = |view| Camera::framing(&bounds, Up::Z, view, 0.0, 1.0).eye;
        assert!(eye(View::Front).y < -1.0 && eye(View::Front).x.abs() < 1e-9);
        assert!(eye(View::Top).z > 1.0);
        let three_quarter = eye(View::ThreeQuarter);
        assert!(three_quarter.x > 1.0 && three_quarter.y < -1.0 && three_quarter.z > 1.0);
        assert!(eye(View::Left).x < -1.0 && eye(View::Right).x > 1.0 && eye(View::Back).y > 1.0);
        assert!(eye(View::Bottom).z < -1.0);
        // Where y is up: the front is +z, and the right stays the right.
        let camera = |view| Camera::framing(&bounds, Up::Y, view, 0.0, 1.0);
        assert!(camera(View::Front).eye.z > 1.0 && camera(View::Top).eye.y > 1.0 && camera(View::Right).eye.x > 1.0);
        assert_eq!((camera(View::Front).up, camera(View::Front).right), (DVec3::Y, DVec3::X));
        assert!("side".parse::<View>().unwrap_err().contains("three-quarter"));
    }

    #[test]
    fn all_around_a_box_stays_inside_at_one_distance() {
        let bounds = Aabb::new(DVec3::new(-3.0, 1.0, 100.0), DVec3::new(2.0, 1.5, 104.0));
        let centre = (bounds.min + bounds.max) * 0.5;
        for upright in [Up::Y, Up::Z] {
            let first = Camera::framing_all_around(&bounds, upright, View::ThreeQuarter, 0.0, 1.0);
            for degrees in [0.0, 30.0, 90.0, 211.0] {
                let camera = first.turned(centre, degrees);
                assert!((camera.eye.distance(centre) - first.eye.distance(centre)).abs() < 1e-9);
                let places = bounds_corners(&bounds).map(|corner| place(&camera, corner).abs().max_element());
                assert!(places.into_iter().all(|reach| reach < 1.0), "{degrees}: {places:?}");
            }
            let whole = first.turned(centre, 77.0);
            let plain = Camera::framing(&bounds, upright, View::ThreeQuarter, 77.0, 1.0);
            assert!(whole.forward.abs_diff_eq(plain.forward, 1e-9) && whole.up.abs_diff_eq(plain.up, 1e-9));
        }
    }

    #[test]
    fn a_box_without_extent_is_still_a_picture() {
        for bounds in [
            Aabb::new(DVec3::splat(5.0), DVec3::splat(5.0)),
            Aabb::new(DVec3::splat(f64::NAN), DVec3::ONE),
            Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY),
        ] {
            let camera = Camera::framing(&bounds, Up::Z, View::ThreeQuarter, f64::NAN, f64::NAN);
            assert!(camera.eye.is_finite() && camera.forward.is_normalized());
        }
    }
}

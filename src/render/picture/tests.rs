use glam::{DVec3, IVec3};

use super::*;
use crate::{
    field::Aabb,
    grid::{
        BLOCK_VOXELS,
        testing::{band_of, sphere, voxel_of},
    },
    render::{Up, View},
};

const RED: [f32; 3] = [0.6, 0.05, 0.1];
const BLUE: [f32; 3] = [0.05, 0.2, 0.7];

fn painted(band: &Band, colour: impl Fn(DVec3) -> [f32; 3]) -> Channel<[f32; 3]> {
    let block = |&origin: &IVec3| {
        std::array::from_fn::<_, BLOCK_VOXELS, _>(|at| colour(band.lattice.centre(voxel_of(origin, at))))
    };
    Channel::of_blocks("Cd", &band.active, band.origins.iter().map(block), [0.0; 3])
}

fn flat<'a>(band: &'a Band, colour: Option<&'a Channel<[f32; 3]>>, camera: Camera) -> Scene<'a> {
    Scene { band, colour, camera, look: Look { lighting: Lighting::Flat, background: [0; 3], ..Look::default() } }
}

fn cube(edge: f64) -> Aabb {
    Aabb::new(DVec3::splat(-edge / 2.0), DVec3::splat(edge / 2.0))
}

#[test]
fn the_silhouette_of_a_sphere_has_its_area() {
    let (radius, size) = (1.0, 160);
    let band = sphere(DVec3::ZERO, radius, 0.05);
    let white = painted(&band, |_| [1.0; 3]);
    let camera = Camera::framing(&cube(3.0), Up::Z, View::Front, 0.0, 1.0);
    let image = render(&flat(&band, Some(&white), camera), size, size);
    let covered: f64 = image.pixels().iter().map(|pixel| f64::from(decode_srgb(pixel[0]))).sum();
    // A sphere of radius r at distance d fills a disc of tangent r/√(d² − r²).
    let tangent = radius / (camera.eye.length_squared() - radius * radius).sqrt();
    let disc = tangent / camera.half_extent.x * size as f64 / 2.0;
    let exact = std::f64::consts::PI * disc * disc;
    assert!((covered / exact - 1.0).abs() < 4e-3, "{covered} pixels for {exact}");
}

#[test]
fn flat_colours_are_those_of_the_channel() {
    let band = sphere(DVec3::ZERO, 1.0, 0.05);
    let halves = painted(&band, |p| if p.x < 0.0 { RED } else { BLUE });
    let camera = Camera::framing(&cube(2.0), Up::Z, View::Front, 0.0, 1.0);
    let image = render(&flat(&band, Some(&halves), camera), 60, 60);
    let expected = |colour: [f32; 3]| colour.map(encode_srgb);
    assert_eq!(image.pixel(20, 30)[..3], expected(RED));
    assert_eq!(image.pixel(40, 30)[..3], expected(BLUE));
    assert_eq!(image.pixel(0, 0), [0, 0, 0, 255]);
    // From behind, left and right change places.
    let behind = Camera::framing(&cube(2.0), Up::Z, View::Front, 180.0, 1.0);
    assert_eq!(render(&flat(&band, Some(&halves), behind), 60, 60).pixel(20, 30)[..3], expected(BLUE));
}

#[test]
fn a_colour_that_is_no_colour_is_drawn_without_harm() {
    let band = sphere(DVec3::ZERO, 1.0, 0.1);
    let camera = Camera::framing(&cube(2.0), Up::Z, View::ThreeQuarter, 0.0, 1.0);
    for value in [f32::NAN, f32::INFINITY, -3.0] {
        let odd = painted(&band, |_| [value; 3]);
        let bright = render(&flat(&band, Some(&odd), camera), 9, 9).pixel(4, 4)[0];
        assert_eq!(bright, if value > 0.0 { 255 } else { 0 });
    }
    let short = Channel { name: "Cd".into(), values: Vec::new(), background: RED };
    assert_eq!(render(&flat(&band, Some(&short), camera), 9, 9).pixel(4, 4)[..3], RED.map(encode_srgb));
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let band = sphere(DVec3::new(0.2, 0.0, 0.1), 0.8, 0.05);
    let colour = painted(&band, |p| if (p.x * 5.0).floor() as i32 % 2 == 0 { RED } else { BLUE });
    let camera = Camera::framing(&cube(2.0), Up::Z, View::ThreeQuarter, 20.0, 1.5);
    let look = Look { ground: Some(-0.7), ..Look::default() };
    let scene = Scene { band: &band, colour: Some(&colour), camera, look };
    let with = |threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| render(&scene, 90, 60))
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn an_empty_band_is_plain_background() {
    let mut band = sphere(DVec3::ZERO, 1.0, 0.5);
    (band.origins, band.distances, band.active, band.inside_tiles) = Default::default();
    let camera = Camera::framing(&cube(2.0), Up::Z, View::ThreeQuarter, 0.0, 1.0);
    let look = Look { background: [1, 2, 3], ground: Some(-1.0), ..Look::default() };
    let image = render(&Scene { band: &band, colour: None, camera, look }, 20, 10);
    assert!(image.pixels().iter().all(|&pixel| pixel == [1, 2, 3, 255]));
    assert_eq!(render(&Scene { band: &band, colour: None, camera, look }, 0, 10).pixels().len(), 0);
}

/// A sheet one voxel thick and a wire of two, seen edge-on and along: every line of sight that meets them shows.
#[test]
fn thin_geometry_is_not_missed() {
    let size = 0.02;
    let sheet =
        band_of(|p| size * 0.5 - (p.z - 0.37 * size).abs().max(p.x.abs() - 1.0).max(p.y.abs() - 1.0), 1.1, size);
    let camera = Camera::framing(&cube(2.4), Up::Z, View::ThreeQuarter, 0.0, 1.0);
    let white = painted(&sheet, |_| [1.0; 3]);
    let image = render(&flat(&sheet, Some(&white), camera), 120, 120);
    let to_pixel = |p: DVec3| {
        let offset = p - camera.eye;
        let place = DVec2::new(offset.dot(camera.right), offset.dot(camera.up)) / offset.dot(camera.forward);
        let place = place / camera.half_extent * 60.0;
        (60.0 + place.x, 60.0 - place.y)
    };
    for x in -9..=9 {
        for y in -9..=9 {
            let (column, row) = to_pixel(DVec3::new(f64::from(x) * 0.1, f64::from(y) * 0.1, 0.37 * size));
            assert_eq!(image.pixel(column as usize, row as usize)[0], 255, "a hole at {x}, {y}");
        }
    }
    let wire = band_of(|p| size - DVec2::new(p.x - 0.3 * size, p.y).length(), 1.1, size);
    let white = painted(&wire, |_| [1.0; 3]);
    let front = Camera::framing(&cube(2.0), Up::Z, View::Front, 0.0, 1.0);
    let image = render(&flat(&wire, Some(&white), front), 80, 80);
    for row in 4..76 {
        let bright: f32 = (36..44).map(|column| decode_srgb(image.pixel(column, row)[0])).sum();
        // The wire is 0.04 wide, and a pixel 0.025 (a tenth more in the margin and by perspective).
        assert!((1.2..2.0).contains(&bright), "row {row}: {bright} pixels wide");
    }
}

/// The layers of a ball seen from the front, against what geometry says at its middle and over its disc.
#[test]
fn layers_hold_what_they_say() {
    let (radius, size) = (1.0, 90);
    let band = sphere(DVec3::ZERO, radius, 0.05);
    let halves = painted(&band, |p| if p.x < 0.0 { RED } else { BLUE });
    let camera = Camera::framing(&cube(3.0), Up::Z, View::Front, 0.0, 1.0);
    let scene = Scene { band: &band, colour: Some(&halves), camera, look: Look::default() };
    let layers = render_layers(&scene, size, size);
    let at = |column: usize, row: usize| row * size + column;
    let middle = at(45, 45);
    let distance = camera.eye.length() as f32;
    assert!((layers.depth[middle] - (distance - 1.0)).abs() < 2e-3);
    assert!((layers.normal[1][middle] + 1.0).abs() < 2e-3, "it faces the camera, which looks along +y");
    assert_eq!(layers.mask[middle], 1.0);
    assert_eq!(std::array::from_fn(|channel| layers.colour[channel][at(30, 45)]), RED);
    assert_eq!(std::array::from_fn(|channel| layers.colour[channel][at(60, 45)]), BLUE);
    assert_eq!((layers.mask[0], layers.depth[0], layers.beauty[0][0]), (0.0, 1e10, 0.0));
    let tangent = radius / (camera.eye.length_squared() - radius * radius).sqrt();
    let disc = tangent / camera.half_extent.x * size as f64 / 2.0;
    let exact = std::f64::consts::PI * disc * disc;
    let covered: f64 = layers.mask.iter().map(|&mask| f64::from(mask)).sum();
    assert!((covered / exact - 1.0).abs() < 8e-3, "{covered} pixels for {exact}");
    for index in 0..size * size {
        let mask = layers.mask[index];
        let normal = Vec3::from_array(std::array::from_fn(|axis| layers.normal[axis][index]));
        assert!((normal.length() - f32::from(mask > 0.0)).abs() < 1e-5);
        // What is premultiplied is never more than the brightest colour that is covered.
        assert!(layers.colour[2][index] <= 0.7 * mask + 1e-6);
    }
    // The picture of the same view shows the same light where it is not bent.
    let picture = render(&scene, size, size);
    let dark = at(60, 60);
    let light: [f32; 3] = std::array::from_fn(|channel| layers.beauty[channel][dark]);
    assert_eq!(picture.pixels()[dark][..3], light.map(encode_srgb));
}

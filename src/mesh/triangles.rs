//! Triangles with optional colours at the vertices.

use glam::DVec3;

use super::error::Element;
use super::material::PicturePlace;
use super::{Problem, Topology};
use crate::field::Aabb;

/// Coordinates beyond this are refused: fourth powers of lengths must stay finite.
pub const LARGEST_COORDINATE: f64 = 1e30;

/// A triangle mesh whose every index and position is valid. World units, counter-clockwise seen from outside.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    colours: Option<Vec<[f32; 3]>>,
    places: Option<Vec<PicturePlace>>,
}

impl TriangleMesh {
    /// Checks and takes positions, triangles (indices into the positions) and one scene-linear Rec.709 colour for
    /// each position, if any.
    ///
    /// Triangles that name one vertex twice are left out, since they bound nothing.
    pub fn new(
        positions: Vec<DVec3>,
        mut triangles: Vec<[u32; 3]>,
        colours: Option<Vec<[f32; 3]>>,
    ) -> Result<Self, Problem> {
        if positions.is_empty() {
            return Err(Problem::NoVertices);
        }
        if triangles.is_empty() {
            return Err(Problem::NoFaces);
        }
        if u32::try_from(positions.len()).is_err() || u32::try_from(triangles.len()).is_err() {
            return Err(Problem::TooLarge);
        }
        let usable = |p: &DVec3| p.is_finite() && p.abs().max_element() <= LARGEST_COORDINATE;
        if let Some(vertex) = positions.iter().position(|p| !usable(p)) {
            return Err(Problem::BadCoordinate { vertex: vertex_from_0(vertex), value: positions[vertex].to_array() });
        }
        if let Some(&index) = triangles.iter().flatten().find(|&&index| index as usize >= positions.len()) {
            return Err(Problem::IndexOutOfRange { index: i64::from(index), vertices: positions.len(), first: 0 });
        }
        if let Some(colours) = &colours {
            check_colours(colours, positions.len())?;
        }
        triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        let mesh = Self { positions, triangles, colours, places: None };
        if !(0..mesh.triangles.len()).any(|t| mesh.area_normal(t).length_squared() > 0.0) {
            return Err(Problem::Flat);
        }
        Ok(mesh)
    }

    /// The vertices' positions.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The triangles' vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Scene-linear Rec.709 colours, one for each vertex, if the mesh has any.
    pub fn colours(&self) -> Option<&[[f32; 3]]> {
        self.colours.as_deref()
    }

    /// With a place in a material's picture for each vertex; those of a triangle are in one material.
    ///
    /// # Panics
    /// Where they are not as many as the vertices.
    pub(super) fn with_places(mut self, places: Vec<PicturePlace>) -> Self {
        assert_eq!(places.len(), self.positions.len(), "each vertex has a place");
        self.places = Some(places);
        self
    }

    /// The vertices' places in their materials' pictures, if the mesh has any.
    pub fn places(&self) -> Option<&[PicturePlace]> {
        self.places.as_deref()
    }

    /// The three corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// Twice the area of a triangle along its outward normal.
    pub fn area_normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// The least box around all triangles.
    pub fn bounding_box(&self) -> Aabb {
        let empty = Aabb::new(DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY));
        let corners = (0..self.triangles.len()).flat_map(|t| self.corners(t));
        corners.fold(empty, |all, p| Aabb::new(all.min.min(p), all.max.max(p)))
    }

    /// The enclosed volume: positive where triangles face outward, of no meaning for an open mesh.
    pub fn volume(&self) -> f64 {
        let middle = self.bounding_box().centre();
        let six_times = |t| {
            let [a, b, c] = self.corners(t).map(|p| p - middle);
            a.dot(b.cross(c))
        };
        (0..self.triangles.len()).map(six_times).sum::<f64>() / 6.0
    }

    /// How the triangles hang together: holes, orientation.
    pub fn topology(&self) -> Topology {
        Topology::of(self)
    }

    /// The mesh with other triangles on the same vertices.
    pub(super) fn with_triangles(&self, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            positions: self.positions.clone(),
            triangles,
            colours: self.colours.clone(),
            places: self.places.clone(),
        }
    }

    /// Turns some triangles over.
    pub(super) fn flip_those(&mut self, which: &[bool]) {
        for (triangle, _) in self.triangles.iter_mut().zip(which).filter(|(_, flips)| **flips) {
            triangle.swap(1, 2);
        }
    }

    /// Turns every triangle over.
    pub(super) fn flip(&mut self) {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
    }
}

fn check_colours(colours: &[[f32; 3]], vertices: usize) -> Result<(), Problem> {
    if colours.len() != vertices {
        return Err(Problem::malformed(format!("{} colours for {vertices} vertices", colours.len())));
    }
    let bad = colours.iter().position(|colour| colour.iter().any(|c| !c.is_finite() || *c < 0.0));
    bad.map_or(Ok(()), |vertex| {
        Err(Problem::BadColour { of: vertex_from_0(vertex), value: colours[vertex].map(f64::from) })
    })
}

fn vertex_from_0(number: usize) -> Element {
    Element::Vertex { number, first: 0 }
}

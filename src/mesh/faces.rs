//! The faces of a file made into a mesh: cut into triangles, those that bound nothing or are there twice left out.

use std::hash::Hasher;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHasher};

use super::material::PicturePlace;
use super::polygon::{self, Crossing};
use super::read::{About, Conventions, Located, Place, Remark};
use super::{Problem, TriangleMesh};

/// Faces as they stand in a file.
pub(super) struct Faces {
    corners: Vec<u32>,
    /// Where each face's corners end.
    ends: Vec<usize>,
    places: Vec<Place>,
    /// What the file calls its first vertex.
    first_vertex: usize,
    /// A colour of each face, or of none.
    pub colours: Vec<[f32; 3]>,
}

/// What vertices are painted with.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexPaint {
    /// A scene-linear colour of each, or of none.
    pub colours: Option<Vec<[f32; 3]>>,
    /// The place of each in a material's picture, or of none.
    pub places: Option<Vec<PicturePlace>>,
}

impl Faces {
    /// None yet, of a file that calls its first vertex by some number.
    pub fn new(first_vertex: usize) -> Self {
        Self { corners: Vec::new(), ends: Vec::new(), places: Vec::new(), first_vertex, colours: Vec::new() }
    }

    /// Takes a face of some vertices, counted from 0.
    pub fn push(&mut self, corners: impl IntoIterator<Item = u32>, place: Place) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
        self.places.push(place);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    fn corners(&self, face: usize) -> &[u32] {
        let start = if face == 0 { 0 } else { self.ends[face - 1] };
        &self.corners[start..self.ends[face]]
    }

    /// Takes apart the vertices that have several places in pictures, or several materials. `uv` has a place for each
    /// corner of each face, numbers into `places`, and `materials` a number for each face; the vertices that are left have
    /// one of each.
    pub fn with_places(
        mut self,
        positions: &[DVec3],
        uv: &[u32],
        places: &[[f32; 2]],
        materials: &[u32],
    ) -> Result<(Self, Vec<DVec3>, Vec<PicturePlace>), Located> {
        self.check_vertices(positions.len())?;
        let mut known: FxHashMap<[u32; 3], u32> = FxHashMap::default();
        let (mut vertices, mut found) = (Vec::new(), Vec::new());
        let mut face = 0;
        for (at, corner) in self.corners.iter_mut().enumerate() {
            while at >= self.ends[face] {
                face += 1;
            }
            let (vertex, material) = (*corner, materials[face]);
            *corner = *known.entry([vertex, uv[at], material]).or_insert_with(|| {
                vertices.push(positions[vertex as usize]);
                let place = places.get(uv[at] as usize).copied().unwrap_or_default();
                found.push(PicturePlace { place, material });
                // More than 2³² of them are refused with the mesh.
                u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
            });
        }
        Ok((self, vertices, found))
    }

    /// The mesh of these faces. Colours of vertices come before those of faces. Faces that are there twice are taken once,
    /// unless the surface is closed by both alone: where it crosses itself some belong to two of its sheets.
    pub fn mesh(
        self,
        positions: Vec<DVec3>,
        paint: VertexPaint,
        conventions: &Conventions,
        remarks: &mut Vec<Remark>,
    ) -> Result<TriangleMesh, Located> {
        self.check_vertices(positions.len())?;
        let mut of_single = Vec::new();
        let is_copy = self.copies(&positions, &mut of_single);
        if !is_copy.contains(&true) {
            return self.without(&is_copy, positions, paint, conventions, remarks);
        }
        let single = self.without(&is_copy, positions.clone(), paint.clone(), conventions, &mut of_single)?;
        if !single.topology().is_closed() {
            let mut of_all = Vec::new();
            let all = self.without(&vec![false; self.len()], positions, paint, conventions, &mut of_all)?;
            if all.topology().is_closed() {
                remarks.extend(of_all);
                return Ok(all);
            }
        }
        remarks.extend(of_single);
        Ok(single)
    }

    fn without(
        &self,
        is_copy: &[bool],
        mut positions: Vec<DVec3>,
        VertexPaint { mut colours, places: of_vertices }: VertexPaint,
        conventions: &Conventions,
        remarks: &mut Vec<Remark>,
    ) -> Result<TriangleMesh, Located> {
        let mut by_face = (colours.is_none() && !self.colours.is_empty()).then(|| OneColour::new(&positions));
        let (mut triangles, mut ring, mut places, mut cut) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut short, mut crossing) = (Vec::new(), Vec::new());
        for face in (0..self.len()).filter(|face| !is_copy[*face]) {
            if self.corners(face).len() < 3 {
                short.push(face);
            }
            self.ring(face, &positions, &mut ring);
            places.clear();
            places.extend(ring.iter().map(|v| positions[*v as usize]));
            cut.clear();
            match polygon::triangulate(&places, &mut cut) {
                Err(Crossing(place)) if places.len() > 4 => {
                    let problem = Problem::CrossingFace { corners: places.len(), near: place.to_array() };
                    return Err(Located { place: Some(self.places[face]), problem });
                }
                Err(Crossing(_)) => crossing.push(face),
                Ok(()) => {}
            }
            for corners in &cut {
                let triangle = corners.map(|i| ring[i]);
                triangles.push(match &mut by_face {
                    Some(one) => triangle.map(|vertex| one.vertex(vertex, self.colours[face])),
                    None => triangle,
                });
            }
        }
        remarks.extend(self.left_out(&short));
        remarks.extend(self.crossing(&crossing));
        if triangles.is_empty() && self.len() > 0 {
            return Err(Problem::Flat.into());
        }
        if let Some(one) = by_face {
            (positions, colours) = (one.positions, Some(one.colours));
        }
        let Conventions { turn, scale, .. } = conventions;
        positions.iter_mut().for_each(|position| *position = turn.apply(*position * *scale));
        let mesh = TriangleMesh::new(positions, triangles, colours)?;
        Ok(match of_vertices {
            Some(places) => mesh.with_places(places),
            None => mesh,
        })
    }

    fn check_vertices(&self, vertices: usize) -> Result<(), Located> {
        let names_none = |face: &usize| self.corners(*face).iter().any(|vertex| *vertex as usize >= vertices);
        let Some(face) = (0..self.len()).into_par_iter().find_first(names_none) else { return Ok(()) };
        let vertex = self.corners(face).iter().find(|vertex| **vertex as usize >= vertices).copied().unwrap_or(0);
        let index = i64::from(vertex) + self.first_vertex as i64;
        let problem = Problem::IndexOutOfRange { index, vertices, first: self.first_vertex };
        Err(Located { place: Some(self.places[face]), problem })
    }

    /// The corners of a face without those at the same place as the one before.
    fn ring(&self, face: usize, positions: &[DVec3], ring: &mut Vec<u32>) {
        ring.clear();
        let place = |vertex: u32| positions[vertex as usize];
        for &vertex in self.corners(face) {
            if ring.last().is_none_or(|last| place(*last) != place(vertex)) {
                ring.push(vertex);
            }
        }
        while ring.len() > 1 && place(ring[0]) == place(ring[ring.len() - 1]) {
            ring.pop();
        }
    }

    /// Which faces are there already: the same places in the same order, wherever it begins. Turned over is another face.
    fn copies(&self, positions: &[DVec3], remarks: &mut Vec<Remark>) -> Vec<bool> {
        let key = |face: usize| {
            let mut ring = Vec::new();
            self.ring(face, positions, &mut ring);
            let edge = |i: usize| edge_key(positions[ring[i] as usize], positions[ring[(i + 1) % ring.len()] as usize]);
            // Two corners bound nothing, and are told of as that.
            (ring.len() > 2).then(|| ((0..ring.len()).map(edge).fold(0, u64::wrapping_add), face))
        };
        let mut keys: Vec<(u64, usize)> = (0..self.len()).into_par_iter().filter_map(key).collect();
        keys.par_sort_unstable();
        let mut is_copy = vec![false; self.len()];
        // Of the first copy in the file: itself, and what it is a copy of.
        let mut first: Option<(usize, usize)> = None;
        let (mut ring, mut other) = (Vec::new(), Vec::new());
        for run in keys.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
            for (i, &(_, face)) in run.iter().enumerate().skip(1) {
                self.ring(face, positions, &mut ring);
                let original = run[..i].iter().map(|entry| entry.1).find(|earlier| {
                    self.ring(*earlier, positions, &mut other);
                    !is_copy[*earlier] && is_rotation(&ring, &other, positions)
                });
                if let Some(original) = original {
                    is_copy[face] = true;
                    first = Some(first.map_or((face, original), |known| known.min((face, original))));
                }
            }
        }
        if let Some((copy, original)) = first {
            let count = is_copy.iter().filter(|is| **is).count();
            let original = self.places[original];
            let text = match count {
                1 => format!("this face is a copy of that of {original}: it is taken once"),
                _ => format!(
                    "{count} faces are there more than once, this one already as {original}: each is taken once"
                ),
            };
            remarks.push(Remark {
                about: About::Faces,
                place: Some(self.places[copy]),
                text,
                help: "delete doubled faces in the modeller and export it again".into(),
            });
        }
        is_copy
    }

    fn left_out(&self, short: &[usize]) -> Option<Remark> {
        let face = *short.first()?;
        let corners = self.corners(face).len();
        let noun = if corners == 1 { "corner" } else { "corners" };
        let others = match short.len() {
            1 => "it is left out".into(),
            2 => "it and another are left out".into(),
            count => format!("it and {} others are left out", count - 1),
        };
        Some(Remark {
            about: About::Faces,
            place: Some(self.places[face]),
            text: format!("a face of {corners} {noun} bounds nothing: {others}"),
            help: "check that nothing is missing".into(),
        })
    }

    fn crossing(&self, crossing: &[usize]) -> Option<Remark> {
        let face = *crossing.first()?;
        let text = match crossing.len() {
            1 => "this face of four corners crosses itself: it is cut along its diagonal".into(),
            count => {
                format!("{count} faces of four corners cross themselves, this one first: they are cut along a diagonal")
            }
        };
        Some(Remark {
            about: About::Faces,
            place: Some(self.places[face]),
            text,
            help: "put their corners in order, or export it in triangles".into(),
        })
    }
}

/// Vertices that each have the colour of one face, as many at a place as there are colours around it.
struct OneColour<'p> {
    places: &'p [DVec3],
    positions: Vec<DVec3>,
    colours: Vec<[f32; 3]>,
    known: FxHashMap<(u32, [u32; 3]), u32>,
}

impl<'p> OneColour<'p> {
    fn new(places: &'p [DVec3]) -> Self {
        Self { places, positions: Vec::new(), colours: Vec::new(), known: FxHashMap::default() }
    }

    fn vertex(&mut self, vertex: u32, colour: [f32; 3]) -> u32 {
        // More than 2³² of them are refused with the mesh.
        let next = u32::try_from(self.positions.len()).unwrap_or(u32::MAX);
        let found = *self.known.entry((vertex, colour.map(f32::to_bits))).or_insert(next);
        if found == next {
            self.positions.push(self.places[vertex as usize]);
            self.colours.push(colour);
        }
        found
    }
}

/// A number of an edge's two ends in their order, mixed so that sums of them differ.
fn edge_key(from: DVec3, to: DVec3) -> u64 {
    let mut hasher = FxHasher::default();
    // −0 is 0.
    [from + 0.0, to + 0.0].iter().flat_map(DVec3::to_array).for_each(|x| hasher.write_u64(x.to_bits()));
    let mut key = hasher.finish();
    key = (key ^ (key >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    key = (key ^ (key >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    key ^ (key >> 31)
}

/// Whether two rings of corners are at the same places in the same order, wherever it begins.
fn is_rotation(a: &[u32], b: &[u32], positions: &[DVec3]) -> bool {
    let same = |i: usize, k: usize| positions[a[i] as usize] == positions[b[k % b.len()] as usize];
    a.len() == b.len() && (0..b.len()).any(|start| (0..a.len()).all(|i| same(i, start + i)))
}

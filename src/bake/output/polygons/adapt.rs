//! Fewer triangles: large ones where the surface is flat and its attributes are even, small ones elsewhere.
//!
//! meshoptimizer merges triangles by collapsing edges, the cheapest by quadric errors first (Garland and Heckbert 1997;
//! with attributes Hoppe 1999). These errors are means of squares over planes of triangles, and single floats: no bound of
//! a distance. So what it gives is looked at: each triangle against the field ([`Within`]), and each vertex that went
//! against the triangles, with its attributes. Where one is too far away, a vertex that went there stays, and it is done
//! again; what does not come right stays as it was. The surface is cut into cubes for this, which do not change along
//! their borders and are done by themselves, so that the result does not depend on threads; then into others, which
//! hold those borders.

use glam::DVec3;
use meshopt::SimplifyOptions;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::TriMesh;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::within::Within;
use super::{Polygons, notches};
use crate::attribute::to_srgb;
use crate::bake::{Beyond, PolygonRecord};
use crate::field::{BATCH, Field};

/// The edges of cubes, in voxels, and where they begin, of their edge: what is at the border of one is well inside of
/// another. Quadrics of single floats are right to about 3e-4 of the edge. Small ones have what did not come right in large
/// ones.
const PASSES: [(f64, f64); 4] = [(64.0, 0.0), (64.0, 0.5), (16.0, 0.25), (64.0, 0.25)];
/// How often a cube is done; after the first few rounds all vertices in a reach that doubles stay, not one for each fault.
const ROUNDS: usize = 8;
const FEW: usize = 4;
/// The part of the error that is used: between the points that are looked at triangles may be a little further away.
const USED: f64 = 0.95;
/// The target that meshoptimizer is given, of the error. With a larger one more triangles are refused, with a smaller one
/// fewer are merged.
const TARGET: f64 = 0.7;
/// What attributes may differ by: a step of 8 bits, of sRGB or of a number's range.
const STEP: f32 = 1.0 / 255.0;
/// The most attributes that meshoptimizer takes. It does not know of more; they are looked at as all.
const MOST_GUIDES: usize = 32;
/// No triangle.
const NONE: u32 = u32::MAX;

/// Merges triangles of a field's surface, as far as it stays within an error. Error and voxel: in voxels, and world units.
pub fn adapt(dense: Polygons, field: &dyn Field, error: f64, voxel: f64) -> Polygons {
    let work = Work::new(&dense, field, USED * error * voxel, voxel);
    let away = (0..).zip(&work.samples).filter(|(_, sample)| sample.is_none()).map(|(vertex, _)| vertex);
    let triangles =
        notches::without(away.collect(), dense.triangles.clone(), &dense.positions, voxel, &mut work.within());
    let first: FxHashSet<[u32; 3]> = triangles.iter().copied().collect();
    let mut surface = Surface { triangles, homes: vec![NONE; dense.positions.len()] };
    for (edge, shift) in PASSES {
        surface = work.pass(surface, edge * voxel, shift);
    }
    debug_assert!(open(&surface.triangles).is_subset(&open(&dense.triangles)), "the surface is torn");
    let beyond = work.beyond(surface.triangles.iter().filter(|triangle| first.contains(*triangle)));
    let (triangles, unmerged) = (surface.triangles.len() as u64, dense.triangles.len() as u64);
    let merged = Some(PolygonRecord { triangles, unmerged, beyond });
    Polygons { merged, ..compact(&dense, surface.triangles) }
}

/// Triangles between some of the dense surface's vertices.
struct Surface {
    triangles: Vec<[u32; 3]>,
    /// Of each vertex that went the triangle that it is next to.
    homes: Vec<u32>,
}

/// What a cube has become: its triangles, and the vertices that went, each with the place of its triangle among these.
struct Merged {
    triangles: Vec<[u32; 3]>,
    gone: Vec<(u32, u32)>,
}

struct Work<'a> {
    dense: &'a Polygons,
    field: &'a dyn Field,
    error: f64,
    voxel: f64,
    /// For each vertex the point of the field's surface next to it; `None` where that is further away than the error.
    samples: Vec<Option<DVec3>>,
    /// All attributes of each vertex, so that a step is 1.
    guides: Vec<f32>,
    width: usize,
    /// Of each scalar, and of velocities, what is a step.
    steps: Vec<f32>,
}

impl<'a> Work<'a> {
    fn new(dense: &'a Polygons, field: &'a dyn Field, error: f64, voxel: f64) -> Self {
        let mut normals = vec![DVec3::ZERO; dense.positions.len()];
        for triangle in &dense.triangles {
            let [a, b, c] = triangle.map(|vertex| dense.positions[vertex as usize]);
            let area = (b - a).cross(c - a);
            triangle.iter().for_each(|vertex| normals[*vertex as usize] += area);
        }
        let pairs = dense.positions.par_chunks(BATCH / 2).zip(normals.par_chunks(BATCH / 2));
        let samples = pairs.map_init(
            || Within::new(field, error, voxel),
            |within, (positions, normals)| {
                let normals: Vec<DVec3> = normals.iter().map(|normal| normal.normalize_or_zero()).collect();
                within.on_surface(positions, &normals)
            },
        );
        let samples = samples.collect::<Vec<_>>().concat();
        let steps: Vec<f32> = dense.scalars.iter().map(|(_, values)| STEP * range(values.iter().copied())).collect();
        let fastest = dense.velocities.iter().flatten().flatten().fold(0.0, |most: f32, part| most.max(part.abs()));
        let mut work = Self { dense, field, error, voxel, samples, guides: Vec::new(), width: 0, steps };
        work.steps.push(STEP * fastest);
        work.guide();
        work
    }

    fn within(&self) -> Within<'a> {
        Within::new(self.field, self.error, self.voxel)
    }

    /// Collects attributes as meshoptimizer takes them.
    fn guide(&mut self) {
        let Polygons { colours, scalars, velocities, positions, .. } = self.dense;
        let count = 3 * usize::from(colours.is_some()) + scalars.len() + 3 * usize::from(velocities.is_some());
        self.width = count.min(MOST_GUIDES);
        let steps = |value: f32, step: f32| if step > 0.0 { value / step } else { 0.0 };
        for vertex in 0..positions.len() {
            let colour = colours.iter().flat_map(|colours| colours[vertex].map(|part| part / STEP));
            let fastest = self.steps[scalars.len()];
            let velocity = velocities.iter().flat_map(|all| all[vertex].map(|part| steps(part, fastest)));
            let scalar = scalars.iter().zip(&self.steps).map(|((_, values), step)| steps(values[vertex], *step));
            self.guides.extend(colour.chain(velocity).chain(scalar).take(self.width));
        }
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|vertex| self.dense.positions[vertex as usize])
    }

    /// Merges what lies within the cubes of one shift.
    fn pass(&self, surface: Surface, edge: f64, shift: f64) -> Surface {
        let Surface { triangles, homes } = surface;
        let cube = |triangle: &[u32; 3]| {
            let middle = self.corners(*triangle).iter().sum::<DVec3>() / 3.0;
            (middle / edge + shift).floor().as_ivec3().to_array()
        };
        let mut keyed: Vec<([i32; 3], u32)> =
            triangles.par_iter().enumerate().map(|(number, triangle)| (cube(triangle), number as u32)).collect();
        keyed.par_sort_unstable();
        let cubes: Vec<&[([i32; 3], u32)]> = keyed.chunk_by(|a, b| a.0 == b.0).collect();
        let mut cube_of = vec![0_u32; triangles.len()];
        for (number, cube) in cubes.iter().enumerate() {
            cube.iter().for_each(|(_, triangle)| cube_of[*triangle as usize] = number as u32);
        }
        let mut gone: Vec<Vec<u32>> = vec![Vec::new(); cubes.len()];
        for (vertex, home) in homes.iter().enumerate().filter(|(_, home)| **home != NONE) {
            gone[cube_of[*home as usize] as usize].push(vertex as u32);
        }
        let before: Vec<Vec<[u32; 3]>> =
            cubes.iter().map(|cube| cube.iter().map(|(_, at)| triangles[*at as usize]).collect()).collect();
        let mut merged: Vec<Option<Merged>> = before
            .par_iter()
            .zip(&gone)
            .map_init(|| self.within(), |within, (triangles, gone)| Cube::new(self, triangles, gone).merged(within))
            .collect();
        // Two cubes may join the same vertices of their border by an edge each.
        loop {
            let now = |cube: usize| merged[cube].as_ref().map_or(&before[cube], |merged| &merged.triangles);
            let mut edges: Vec<([u32; 2], usize)> = (0..before.len())
                .flat_map(|cube| now(cube).iter().flat_map(sides).map(move |side| (side, cube)))
                .collect();
            edges.par_sort_unstable();
            let twice = edges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1);
            let torn: Vec<usize> =
                twice.flatten().map(|(_, cube)| *cube).filter(|cube| merged[*cube].is_some()).collect();
            if torn.is_empty() {
                break;
            }
            torn.into_iter().for_each(|cube| merged[cube] = None);
        }
        let (mut out, mut new_homes) = (Vec::new(), vec![NONE; homes.len()]);
        let mut moved = vec![NONE; triangles.len()];
        for (cube, (merged, was)) in merged.into_iter().zip(&before).enumerate() {
            let first = out.len() as u32;
            match merged {
                Some(Merged { triangles, gone }) => {
                    gone.into_iter().for_each(|(vertex, at)| new_homes[vertex as usize] = first + at);
                    out.extend(triangles);
                }
                None => {
                    cubes[cube].iter().zip(first..).for_each(|((_, old), new)| moved[*old as usize] = new);
                    gone[cube]
                        .iter()
                        .for_each(|vertex| new_homes[*vertex as usize] = moved[homes[*vertex as usize] as usize]);
                    out.extend(was);
                }
            }
        }
        Surface { triangles: out, homes: new_homes }
    }

    /// How many triangles are too far from the field's surface, and where one is.
    fn beyond<'t>(&self, triangles: impl Iterator<Item = &'t [u32; 3]>) -> Option<Beyond> {
        let corners: Vec<[DVec3; 3]> = triangles.map(|triangle| self.corners(*triangle)).collect();
        let chunks = corners.par_chunks(BATCH).map_init(|| self.within(), |within, corners| within.astray(corners));
        let astray: Vec<DVec3> = chunks.collect::<Vec<_>>().concat().into_iter().flatten().collect();
        astray.first().map(|at| Beyond { triangles: astray.len() as u64, near: at.to_array() })
    }

    /// Whether a vertex's attributes are others than those between the corners of a triangle.
    fn differs(&self, vertex: u32, triangle: [u32; 3], weights: [f32; 3]) -> bool {
        let Polygons { colours, scalars, velocities, .. } = self.dense;
        let [a, b, c] = triangle.map(|corner| corner as usize);
        let vertex = vertex as usize;
        let between = |x: f32, y: f32, z: f32| x * weights[0] + y * weights[1] + z * weights[2];
        let threes = |all: &[[f32; 3]]| std::array::from_fn(|i| between(all[a][i], all[b][i], all[c][i]));
        let far = |found: [f32; 3], wanted: [f32; 3], step: f32| {
            found.iter().zip(wanted).any(|(found, wanted)| (found - wanted).abs() > step)
        };
        colours.as_ref().is_some_and(|all| far(to_srgb(threes(all)), to_srgb(all[vertex]), STEP))
            || velocities.as_ref().is_some_and(|all| far(threes(all), all[vertex], self.steps[scalars.len()]))
            || scalars
                .iter()
                .zip(&self.steps)
                .any(|((_, all), step)| (between(all[a], all[b], all[c]) - all[vertex]).abs() > *step)
    }
}

/// What lies in one cube.
struct Cube<'a> {
    work: &'a Work<'a>,
    triangles: &'a [[u32; 3]],
    /// Vertices that went before, next to these triangles.
    gone: &'a [u32],
    /// Those of the triangles, rising.
    vertices: Vec<u32>,
}

/// What is wrong with triangles: near a place, which a vertex should hold that went.
struct Fault {
    at: DVec3,
    /// How far around vertices are to hold it.
    reach: f64,
}

impl<'a> Cube<'a> {
    fn new(work: &'a Work<'a>, triangles: &'a [[u32; 3]], gone: &'a [u32]) -> Self {
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        Self { work, triangles, gone, vertices }
    }

    fn local(&self, vertex: u32) -> usize {
        self.vertices.partition_point(|other| *other < vertex)
    }

    /// Fewer triangles, or `None`.
    fn merged(&self, within: &mut Within<'_>) -> Option<Merged> {
        let before: FxHashSet<[u32; 3]> = self.triangles.iter().map(|triangle| turned(*triangle)).collect();
        let mut right = before.clone();
        let mut locks = vec![false; self.vertices.len()];
        for round in 0..ROUNDS {
            let triangles = self.simplified(&locks);
            if triangles.is_empty() || triangles.len() == self.triangles.len() {
                return None;
            }
            let mut is_used = vec![false; self.vertices.len()];
            triangles.iter().flatten().for_each(|vertex| is_used[self.local(*vertex)] = true);
            let mut faults = self.torn(&triangles);
            self.astray(&triangles, &mut right, within, &mut faults);
            let gone = self.homes(&triangles, &is_used, &mut faults)?;
            if faults.is_empty() {
                return Some(Merged { triangles, gone });
            }
            let free: Vec<usize> = (0..locks.len()).filter(|at| !is_used[*at]).collect();
            let reach = if round < FEW { 0.0 } else { self.work.voxel * f64::from(1 << (round - FEW)) };
            for Fault { at, reach: own } in faults {
                let place = |local: usize| self.work.dense.positions[self.vertices[local] as usize];
                let away = |local: &usize| place(*local).distance_squared(at);
                let next = free.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
                let near = free.iter().filter(|local| away(local) < own.max(reach).powi(2));
                near.chain(next).for_each(|local| locks[*local] = true);
            }
        }
        None
    }

    /// What meshoptimizer makes of it where some vertices stay.
    fn simplified(&self, locks: &[bool]) -> Vec<[u32; 3]> {
        let Work { dense, error, voxel, guides, width, .. } = self.work;
        let middle = dense.positions[self.vertices[0] as usize];
        let position = |vertex: &u32| ((dense.positions[*vertex as usize] - middle) / voxel).as_vec3().to_array();
        let positions: Vec<[f32; 3]> = self.vertices.iter().map(position).collect();
        let indices: Vec<u32> = self.triangles.iter().flatten().map(|vertex| self.local(*vertex) as u32).collect();
        let of_vertex = |vertex: &u32| &guides[*vertex as usize * width..][..*width];
        let attributes: Vec<f32> = self.vertices.iter().flat_map(of_vertex).copied().collect();
        let target = (TARGET * error / voxel) as f32;
        let found = meshopt::simplify_with_attributes_and_locks_decoder(
            &indices,
            &positions,
            &attributes,
            &vec![target; *width],
            4 * width,
            locks,
            0,
            target,
            SimplifyOptions::LockBorder | SimplifyOptions::ErrorAbsolute,
            None,
        );
        let global = |at: u32| self.vertices[at as usize];
        found.as_chunks().0.iter().map(|triangle: &[u32; 3]| triangle.map(global)).collect()
    }

    /// Where the surface is not closed as before: collapses do not look at what is joined besides.
    fn torn(&self, triangles: &[[u32; 3]]) -> Vec<Fault> {
        let mut faces: Vec<[u32; 3]> = triangles
            .iter()
            .map(|triangle| {
                let mut sorted = *triangle;
                sorted.sort_unstable();
                sorted
            })
            .collect();
        faces.sort_unstable();
        let twice = faces.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| [pair[0][0], pair[0][1]]);
        let before = open(self.triangles);
        let after = open(triangles);
        let torn = after.symmetric_difference(&before).map(|(edge, _)| *edge).chain(twice);
        let mut vertices: Vec<u32> = torn.flatten().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let fault =
            |vertex: u32| Fault { at: self.work.dense.positions[vertex as usize], reach: 2.0 * self.work.voxel };
        vertices.into_iter().map(fault).collect()
    }

    /// Looks at triangles that are not known to be right.
    fn astray(
        &self,
        triangles: &[[u32; 3]],
        right: &mut FxHashSet<[u32; 3]>,
        within: &mut Within<'_>,
        faults: &mut Vec<Fault>,
    ) {
        let new: Vec<[u32; 3]> =
            triangles.iter().map(|triangle| turned(*triangle)).filter(|new| !right.contains(new)).collect();
        let corners: Vec<[DVec3; 3]> = new.iter().map(|triangle| self.work.corners(*triangle)).collect();
        for (triangle, astray) in new.into_iter().zip(within.astray(&corners)) {
            match astray {
                Some(at) => faults.push(Fault { at, reach: 0.0 }),
                None => _ = right.insert(triangle),
            }
        }
    }

    /// The triangles that the vertices which went are next to. Those that are too far away, or have other attributes, are
    /// faults.
    fn homes(&self, triangles: &[[u32; 3]], is_used: &[bool], faults: &mut Vec<Fault>) -> Option<Vec<(u32, u32)>> {
        let Work { dense, samples, error, .. } = self.work;
        let origin = dense.positions[self.vertices[0] as usize];
        let places = self.vertices.iter().map(|vertex| (dense.positions[*vertex as usize] - origin).to_array().into());
        let local = triangles.iter().map(|triangle| triangle.map(|vertex| self.local(vertex) as u32));
        let mesh = TriMesh::new(places.collect(), local.collect()).ok()?;
        let now = self.vertices.iter().enumerate().filter(|(at, _)| !is_used[*at]).map(|(_, vertex)| *vertex);
        let mut homes = Vec::new();
        // Of each triangle the vertex that is furthest away.
        let mut worst: Vec<Option<(f64, u32)>> = vec![None; triangles.len()];
        for vertex in now.chain(self.gone.iter().copied()) {
            let sample = samples[vertex as usize];
            let place = sample.unwrap_or(dense.positions[vertex as usize]) - origin;
            let (found, (triangle, location)) =
                mesh.project_local_point_and_get_location(place.to_array().into(), false);
            let away = DVec3::from(found.point.to_array()).distance(place);
            let weights = location.barycentric_coordinates()?.map(|weight| weight as f32);
            let at = triangle as usize;
            let is_far = sample.is_some() && away > *error;
            let is_wrong = is_far || self.work.differs(vertex, triangles[at], weights);
            if is_wrong && worst[at].is_none_or(|(most, _)| away > most) {
                worst[at] = Some((away, vertex));
            }
            homes.push((vertex, triangle));
        }
        let fault = |(_, vertex): (f64, u32)| Fault { at: dense.positions[vertex as usize], reach: 0.0 };
        faults.extend(worst.into_iter().flatten().map(fault));
        Some(homes)
    }
}

/// The edges that are not those of two triangles which face the same way, and how often they are there.
fn open(triangles: &[[u32; 3]]) -> FxHashSet<([u32; 2], usize)> {
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(sides).collect();
    edges.sort_unstable();
    let is_open = |same: &&[[u32; 2]]| same.len() > 1 || edges.binary_search(&[same[0][1], same[0][0]]).is_err();
    edges.chunk_by(|a, b| a == b).filter(is_open).map(|same| (same[0], same.len())).collect()
}

fn sides([a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[*a, *b], [*b, *c], [*c, *a]]
}

/// The same triangle, its least vertex first.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn range(values: impl Iterator<Item = f32>) -> f32 {
    let (least, most) =
        values.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), value| (value.min(least), value.max(most)));
    (most - least).max(0.0)
}

/// The vertices that triangles use, and these.
fn compact(dense: &Polygons, mut triangles: Vec<[u32; 3]>) -> Polygons {
    let mut kept: Vec<u32> = triangles.iter().flatten().copied().collect();
    kept.par_sort_unstable();
    kept.dedup();
    let mut number = vec![NONE; dense.positions.len()];
    for (new, old) in (0..).zip(&kept) {
        number[*old as usize] = new;
    }
    triangles.iter_mut().flatten().for_each(|vertex| *vertex = number[*vertex as usize]);
    fn of<T: Copy>(kept: &[u32], all: &[T]) -> Vec<T> {
        kept.iter().map(|vertex| all[*vertex as usize]).collect()
    }
    Polygons {
        positions: of(&kept, &dense.positions),
        triangles,
        colours: dense.colours.as_ref().map(|colours| of(&kept, colours)),
        scalars: dense.scalars.iter().map(|(name, values)| (name.clone(), of(&kept, values))).collect(),
        velocities: dense.velocities.as_ref().map(|velocities| of(&kept, velocities)),
        merged: None,
    }
}

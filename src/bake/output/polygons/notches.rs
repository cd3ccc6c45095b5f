//! Takes away vertices that are not on the surface, where others are beside them.
//!
//! Dual contouring keeps a vertex in its cell. Where the sharp edge that it should be on passes the cell by, it stands off
//! the surface, a notch in the edge; or at the very place of a neighbour's vertex. Such a vertex is moved onto a
//! neighbour, if all triangles that this changes are then within the distance of the surface and face outward.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::within::{Within, is_flat};

/// Closer than this share of a voxel two vertices are at one place.
const SAME: f64 = 1e-4;

/// The triangles without the vertices that are away from the surface, and without triangles that are too flat, as far as
/// they can be spared.
pub fn without(
    away: FxHashSet<u32>,
    triangles: Vec<[u32; 3]>,
    positions: &[DVec3],
    voxel: f64,
    within: &mut Within<'_>,
) -> Vec<[u32; 3]> {
    let is_flat = |triangle: &[u32; 3]| is_flat(triangle.map(|corner| positions[corner as usize]), voxel);
    let mut unwanted = away.clone();
    unwanted.extend(triangles.iter().filter(|triangle| is_flat(triangle)).flatten());
    let mut mesh = Mesh::around(&unwanted, triangles);
    // Vertices at one place become one: that moves nothing.
    for vertex in sorted(&unwanted) {
        let place = positions[vertex as usize];
        let at_one_place = |other: &u32| positions[*other as usize].distance(place) < SAME * voxel;
        for target in mesh.neighbours(vertex).into_iter().filter(at_one_place) {
            if let Some(changed) = mesh.collapsed(vertex, target) {
                mesh.collapse(vertex, target, changed);
                break;
            }
        }
    }
    let mut unwanted = away;
    unwanted.extend(mesh.triangles.iter().flatten().filter(|triangle| is_flat(triangle)).flatten());
    let mut work = Work { mesh, unwanted: &unwanted, positions, within, undo: Vec::new() };
    for group in work.groups() {
        work.undo.clear();
        group.iter().for_each(|vertex| work.spare(*vertex, true));
        if !work.is_right(work.changed()) {
            work.take_back();
            group.iter().for_each(|vertex| work.spare(*vertex, false));
        }
    }
    work.mesh.triangles.into_iter().flatten().collect()
}

fn sorted(vertices: &FxHashSet<u32>) -> Vec<u32> {
    let mut all: Vec<u32> = vertices.iter().copied().collect();
    all.sort_unstable();
    all
}

struct Work<'a, 'f> {
    mesh: Mesh,
    unwanted: &'a FxHashSet<u32>,
    positions: &'a [DVec3],
    within: &'a mut Within<'f>,
    /// The collapses of a group.
    undo: Vec<Collapse>,
}

/// A vertex that was moved onto another.
struct Collapse {
    /// The triangles around it, as they were.
    before: Vec<(usize, [u32; 3])>,
    vertex: u32,
    /// All numbers that it had in the mesh's table.
    around: Vec<usize>,
    target: u32,
    /// How many the other had there.
    count: usize,
}

impl Work<'_, '_> {
    /// Unwanted vertices that hang together.
    fn groups(&self) -> Vec<Vec<u32>> {
        let (mut seen, mut groups) = (FxHashSet::default(), Vec::new());
        for first in sorted(self.unwanted) {
            let (mut group, mut next) = (Vec::new(), vec![first]);
            while let Some(vertex) = next.pop() {
                if seen.insert(vertex) {
                    group.push(vertex);
                    next.extend(self.mesh.neighbours(vertex).into_iter().filter(|other| self.unwanted.contains(other)));
                }
            }
            groups.push(group);
        }
        groups
    }

    /// Moves a vertex onto a neighbour, the nearest that will do. `later`: triangles with another unwanted corner are
    /// looked at when all of the group is done.
    fn spare(&mut self, vertex: u32, later: bool) {
        let place = self.positions[vertex as usize];
        let away = |other: &u32| self.positions[*other as usize].distance(place);
        let mut targets = self.mesh.neighbours(vertex);
        targets.retain(|target| !self.unwanted.contains(target));
        targets.sort_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)));
        for target in targets {
            let Some(changed) = self.mesh.collapsed(vertex, target) else { continue };
            let is_judged =
                |corners: &[u32; 3]| !(later && corners.iter().any(|corner| self.unwanted.contains(corner)));
            let judged = changed.iter().map(|(_, corners)| *corners).filter(is_judged).collect();
            if self.is_right(judged) {
                self.undo.push(self.mesh.collapse(vertex, target, changed));
                return;
            }
        }
    }

    fn is_right(&mut self, triangles: Vec<[u32; 3]>) -> bool {
        let corners = triangles.into_iter().map(|corners| corners.map(|corner| self.positions[corner as usize]));
        self.within.astray(&corners.collect::<Vec<_>>()).iter().all(Option::is_none)
    }

    /// The triangles that the group's collapses have changed.
    fn changed(&self) -> Vec<[u32; 3]> {
        let mut numbers: Vec<usize> =
            self.undo.iter().flat_map(|done| &done.before).map(|(number, _)| *number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.into_iter().filter_map(|number| self.mesh.triangles[number]).collect()
    }

    fn take_back(&mut self) {
        while let Some(Collapse { before, vertex, around, target, count }) = self.undo.pop() {
            self.mesh.around.entry(target).or_default().truncate(count);
            self.mesh.around.insert(vertex, around);
            before.into_iter().for_each(|(number, corners)| self.mesh.triangles[number] = Some(corners));
        }
    }
}

/// Triangles, of which those around some vertices and their neighbours are known.
struct Mesh {
    triangles: Vec<Option<[u32; 3]>>,
    around: FxHashMap<u32, Vec<usize>>,
}

impl Mesh {
    fn around(vertices: &FxHashSet<u32>, triangles: Vec<[u32; 3]>) -> Self {
        let touches = |triangle: &&[u32; 3]| triangle.iter().any(|corner| vertices.contains(corner));
        let mut around: FxHashMap<u32, Vec<usize>> =
            triangles.iter().filter(touches).flatten().map(|corner| (*corner, Vec::new())).collect();
        for (number, triangle) in triangles.iter().enumerate() {
            for corner in triangle {
                if let Some(all) = around.get_mut(corner) {
                    all.push(number);
                }
            }
        }
        Self { triangles: triangles.into_iter().map(Some).collect(), around }
    }

    fn triangles_around(&self, vertex: u32) -> impl Iterator<Item = (usize, [u32; 3])> {
        let all = self.around.get(&vertex).into_iter().flatten();
        all.filter_map(|number| Some((*number, self.triangles[*number]?)))
    }

    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let corners = self.triangles_around(vertex).flat_map(|(_, corners)| corners);
        let mut all: Vec<u32> = corners.filter(|corner| *corner != vertex).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The triangles that a vertex has once it is moved onto another; `None` where the surface would then touch itself: the
    /// two have more neighbours in common than the corners of the two triangles between them.
    fn collapsed(&self, vertex: u32, target: u32) -> Option<Vec<(usize, [u32; 3])>> {
        let of_target = self.neighbours(target);
        let shared = self.neighbours(vertex).into_iter().filter(|other| of_target.binary_search(other).is_ok()).count();
        let (between, rest): (Vec<_>, Vec<_>) =
            self.triangles_around(vertex).partition(|(_, corners)| corners.contains(&target));
        let moved = |corner: u32| if corner == vertex { target } else { corner };
        let rest = rest.into_iter().map(|(number, corners)| (number, corners.map(moved)));
        (shared == 2 && between.len() == 2).then(|| rest.collect())
    }

    fn collapse(&mut self, vertex: u32, target: u32, changed: Vec<(usize, [u32; 3])>) -> Collapse {
        let before: Vec<(usize, [u32; 3])> = self.triangles_around(vertex).collect();
        before.iter().for_each(|(number, _)| self.triangles[*number] = None);
        let around = self.around.remove(&vertex).unwrap_or_default();
        let of_target = self.around.entry(target).or_default();
        let count = of_target.len();
        for (number, corners) in changed {
            self.triangles[number] = Some(corners);
            of_target.push(number);
        }
        Collapse { before, vertex, around, target, count }
    }
}

//! Polygons into triangles.
//!
//! Convex polygons are fanned. All others go through a constrained Delaunay triangulation (`spade`, exact predicates) of
//! their corners seen along the area vector. Its triangles are taken as often as the outline winds around them, so the
//! triangles' own outline is the polygon's: neighbours pair up at every edge, and no vertex is added or left out. That
//! covers bridge edges to holes, corners that occur twice, outlines that touch themselves and corners in line.
//!
//! Guaranteed: every edge of the polygon belongs to one triangle more in its own direction than in the other, all other
//! edges cancel. Not guaranteed: which diagonals are chosen.

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;
use spade::handles::{FaceHandle, FixedVertexHandle, PossiblyOuterTag};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// A polygon that crosses itself or covers a part of its plane more than once, and about where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing(pub DVec3);

/// Cuts a polygon (corners in order, not necessarily convex or quite flat) into triangles of indices into `corners`,
/// appended to `out`. A quadrilateral that crosses itself is cut all the same; of larger ones that do, nothing is
/// appended.
pub(super) fn triangulate(corners: &[DVec3], out: &mut Vec<[usize; 3]>) -> Result<(), Crossing> {
    match corners.len() {
        0..=2 => Ok(()),
        3 => {
            out.push([0, 1, 2]);
            Ok(())
        }
        4 => quadrilateral(corners, out),
        _ => {
            let flat = flattened(corners);
            if is_convex(&flat) {
                fan(corners.len(), out);
                return Ok(());
            }
            let exact = Outline::of(&flat, 0.0);
            exact.triangulate(corners, out).or_else(|_| {
                let near = Outline::of(&flat, tolerance(corners));
                near.triangulate(corners, out)
            })
        }
    }
}

fn fan(count: usize, out: &mut Vec<[usize; 3]>) {
    out.extend((2..count).map(|i| [0, i - 1, i]));
}

/// How far a corner may lie on the wrong side of an edge by rounding alone: text files keep about six digits. Less:
/// outlines that touch themselves are called crossing. More: narrow gaps are closed.
fn tolerance(corners: &[DVec3]) -> f64 {
    let (min, max) = corners.iter().fold((corners[0], corners[0]), |(min, max), p| (min.min(*p), max.max(*p)));
    1e-5 * (max - min).max_element() + 1e-6 * max.abs().max(min.abs()).max_element()
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Cut from corner 0 where that can be, as exporters expect.
fn quadrilateral(corners: &[DVec3], out: &mut Vec<[usize; 3]>) -> Result<(), Crossing> {
    let p = flattened(corners);
    let turns: [f64; 4] = std::array::from_fn(|i| turn(p[(i + 3) % 4], p[i], p[(i + 1) % 4]));
    let from_second = !(turns[1] >= 0.0 && turns[3] >= 0.0) && turns[0] >= 0.0 && turns[2] >= 0.0;
    out.extend(if from_second { [[1, 2, 3], [1, 3, 0]] } else { [[0, 1, 2], [0, 2, 3]] });
    let rounding = tolerance(corners);
    let turned_over = |i: usize| turns[i] < -rounding * (p[(i + 1) % 4] - p[(i + 3) % 4]).length();
    let crosses = (0..4).filter(|i| turned_over(*i)).count() > 1;
    if crosses { Err(Crossing(corners.iter().sum::<DVec3>() / 4.0)) } else { Ok(()) }
}

/// The corners seen along the area vector, so that the polygon runs counter-clockwise. Flat polygons are seen along an
/// axis, which leaves their coordinates as they are, so that what is in line stays so.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let normal = normal(corners);
    let is_flat = || {
        let height = |p: &DVec3| (*p - corners[0]).dot(normal).abs();
        let far = corners.iter().map(|p| (*p - corners[0]).abs().max_element()).fold(0.0, f64::max);
        corners.iter().all(|p| height(p) <= 1e-3 * far)
    };
    let steepest = normal.abs();
    let (x, y) = if normal != DVec3::ZERO && !is_flat() {
        let x = normal.any_orthonormal_vector();
        (x, normal.cross(x))
    } else if steepest.x >= steepest.y && steepest.x >= steepest.z {
        if normal.x >= 0.0 { (DVec3::Y, DVec3::Z) } else { (DVec3::Z, DVec3::Y) }
    } else if steepest.y >= steepest.z {
        if normal.y >= 0.0 { (DVec3::Z, DVec3::X) } else { (DVec3::X, DVec3::Z) }
    } else if normal.z >= 0.0 {
        (DVec3::X, DVec3::Y)
    } else {
        (DVec3::Y, DVec3::X)
    };
    corners.iter().map(|p| DVec2::new(p.dot(x), p.dot(y))).collect()
}

/// The direction of the area vector. Where that is next to nothing, as of two loops that run against one another, it is
/// that of the plane through the corners farthest apart.
fn normal(corners: &[DVec3]) -> DVec3 {
    let doubled_area = |i: usize| (corners[i] - corners[0]).cross(corners[(i + 1) % corners.len()] - corners[0]);
    let area: DVec3 = (0..corners.len()).map(doubled_area).sum();
    let ways = || corners.iter().map(|p| *p - corners[0]);
    let farthest = |a: DVec3, b: DVec3| if b.length_squared() > a.length_squared() { b } else { a };
    let far = ways().fold(DVec3::ZERO, farthest);
    if area.length() > 1e-6 * far.length_squared() {
        return area.normalize_or_zero();
    }
    let across = ways().map(|way| far.cross(way)).fold(DVec3::ZERO, farthest).normalize_or_zero();
    if across.dot(area) < 0.0 { -across } else { across }
}

/// Turns left at every corner, and goes around once.
fn is_convex(flat: &[DVec2]) -> bool {
    let count = flat.len();
    let at = |i: usize| flat[i % count];
    let goes_up = |i: usize| {
        let way = at(i + 1) - at(i);
        way.y > 0.0 || (way.y == 0.0 && way.x > 0.0)
    };
    (0..count).all(|i| turn(at(i), at(i + 1), at(i + 2)) > 0.0)
        && (0..count).filter(|&i| !goes_up(i) && goes_up(i + 1)).count() == 1
}

/// A polygon's outline among the points of a triangulation.
struct Outline {
    cdt: Cdt,
    /// The first corner at each of the points, by their handles.
    corner_of: Vec<usize>,
    /// The points that each edge goes through, its ends included.
    ways: Vec<Vec<FixedVertexHandle>>,
    /// What counts as the same place.
    tolerance: f64,
}

impl Outline {
    /// Corners nearer to one another than the tolerance become one point, and edges go through points as near.
    fn of(flat: &[DVec2], tolerance: f64) -> Self {
        let mut cdt = Cdt::new();
        let mut corner_of: Vec<usize> = Vec::new();
        let count = flat.len();
        let points: Vec<FixedVertexHandle> = (0..count)
            .map(|i| {
                let same = |first: &usize| tolerance > 0.0 && flat[*first].distance(flat[i]) <= tolerance;
                let near = corner_of.iter().position(same);
                let point = near.map_or_else(|| insert(&mut cdt, flat[i]), FixedVertexHandle::from_index);
                if point.index() == corner_of.len() {
                    corner_of.push(i);
                }
                point
            })
            .collect();
        let ways = (0..count)
            .map(|i| {
                let (from, to) = (points[i], points[(i + 1) % count]);
                let mut way = vec![from];
                if tolerance > 0.0 && from != to {
                    way.extend(touched(flat, &corner_of, [from, to], tolerance));
                }
                way.push(to);
                way
            })
            .collect();
        Self { cdt, corner_of, ways, tolerance }
    }

    fn triangulate(mut self, corners: &[DVec3], out: &mut Vec<[usize; 3]>) -> Result<(), Crossing> {
        for way in &mut self.ways {
            *way = constrain(&mut self.cdt, way).map_err(|([a, b], share)| {
                let [a, b] = [a, b].map(|point| corners[self.corner_of[point.index()]]);
                Crossing(a.lerp(b, share))
            })?;
        }
        if self.cdt.num_inner_faces() == 0 {
            fan(corners.len(), out);
            return Ok(());
        }
        let windings = self.windings();
        self.check_overlap(&windings, corners)?;
        for face in self.cdt.inner_faces() {
            let winding = windings[face.fix().index()];
            let [a, b, c] = face.vertices().map(|vertex| self.corner_of[vertex.fix().index()]);
            let triangle = if winding > 0 { [a, b, c] } else { [a, c, b] };
            out.extend(std::iter::repeat_n(triangle, winding.unsigned_abs() as usize));
        }
        self.close(corners, out);
        Ok(())
    }

    /// How often the outline goes around each face.
    fn windings(&self) -> Vec<i32> {
        let mut crossed: FxHashMap<(usize, usize), i32> = FxHashMap::default();
        for step in self.ways.iter().flat_map(|way| way.windows(2)) {
            *crossed.entry((step[0].index(), step[1].index())).or_default() += 1;
        }
        let times = |from: usize, to: usize| crossed.get(&(from, to)).copied().unwrap_or(0);
        let mut windings: Vec<Option<i32>> = vec![None; self.cdt.num_all_faces()];
        windings[self.cdt.outer_face().fix().index()] = Some(0);
        let mut edges: Vec<_> = self.cdt.convex_hull().collect();
        edges.iter_mut().filter(|edge| !edge.face().is_outer()).for_each(|edge| *edge = edge.rev());
        while let Some(edge) = edges.pop() {
            let (from, to) = (edge.from().fix().index(), edge.to().fix().index());
            let beyond: FaceHandle<'_, PossiblyOuterTag, _, _, _, _> = edge.rev().face();
            let entry = &mut windings[beyond.fix().index()];
            if entry.is_some() {
                continue;
            }
            // The left of an edge of the outline is inside.
            let here = windings[edge.face().fix().index()].unwrap_or(0);
            windings[beyond.fix().index()] = Some(here - times(from, to) + times(to, from));
            edges.extend(beyond.as_inner().into_iter().flat_map(|face| face.adjacent_edges()));
        }
        windings.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Refuses an outline that goes around a part of its plane twice, or the other way, but for what rounding does.
    fn check_overlap(&self, windings: &[i32], corners: &[DVec3]) -> Result<(), Crossing> {
        let odd = |face: &FaceHandle<'_, _, _, _, _, _>| !(0..=1).contains(&windings[face.fix().index()]);
        let area: f64 = self.cdt.inner_faces().filter(odd).map(|face| face.area()).sum();
        let length: f64 = self.cdt.convex_hull().map(|edge| edge.length_2().sqrt()).sum();
        if area <= self.tolerance.max(1e-12 * length) * length {
            return Ok(());
        }
        let largest = self.cdt.inner_faces().filter(odd).max_by(|a, b| a.area().total_cmp(&b.area()));
        let middle = largest.map(|face| face.vertices().map(|v| corners[self.corner_of[v.fix().index()]]));
        Err(Crossing(middle.map_or(corners[0], |[a, b, c]| (a + b + c) / 3.0)))
    }

    /// Joins each edge of the polygon to the points that it went through: triangles without an area, or as narrow as the
    /// tolerance.
    fn close(&self, corners: &[DVec3], out: &mut Vec<[usize; 3]>) {
        for (i, way) in self.ways.iter().enumerate() {
            let mut around = vec![i, (i + 1) % corners.len()];
            around.extend(way.iter().rev().map(|point| self.corner_of[point.index()]));
            around.dedup_by(|b, a| corners[*a] == corners[*b]);
            while around.len() > 1 && corners[around[0]] == corners[around[around.len() - 1]] {
                around.pop();
            }
            out.extend((2..around.len()).map(|k| [around[0], around[k - 1], around[k]]));
        }
    }
}

/// The point at a place, which may be there already.
fn insert(cdt: &mut Cdt, place: DVec2) -> FixedVertexHandle {
    // Nearer to 0 than the triangulation takes.
    let representable = |x: f64| if x.abs() < 1e-40 { 0.0 } else { x };
    let point = Point2::new(representable(place.x), representable(place.y));
    cdt.insert(point).expect("coordinates of a mesh are finite and below 1e30")
}

/// The points that lie on an edge between its ends, in order.
fn touched(
    flat: &[DVec2],
    corner_of: &[usize],
    [from, to]: [FixedVertexHandle; 2],
    tolerance: f64,
) -> Vec<FixedVertexHandle> {
    let (a, b) = (flat[corner_of[from.index()]], flat[corner_of[to.index()]]);
    let (way, length) = ((b - a).normalize_or_zero(), (b - a).length());
    let mut found: Vec<(f64, usize)> = (0..corner_of.len())
        .filter(|point| *point != from.index() && *point != to.index())
        .filter_map(|point| {
            let beside = flat[corner_of[point]] - a;
            let along = beside.dot(way);
            (along > 0.0 && along < length && way.perp_dot(beside).abs() <= tolerance).then_some((along, point))
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.into_iter().map(|(_, point)| FixedVertexHandle::from_index(point)).collect()
}

/// Makes a way a row of edges of the triangulation: its points with those that lie exactly between. Where the outline
/// would be crossed, fails with the edge that crosses and the share of it before the crossing.
fn constrain(
    cdt: &mut Cdt,
    way: &[FixedVertexHandle],
) -> Result<Vec<FixedVertexHandle>, ([FixedVertexHandle; 2], f64)> {
    let mut whole = vec![way[0]];
    for step in way.windows(2).filter(|step| step[0] != step[1]) {
        let edges = cdt.try_add_constraint(step[0], step[1]);
        if edges.is_empty() {
            let place = |point: FixedVertexHandle| {
                let Point2 { x, y } = cdt.vertex(point).position();
                DVec2::new(x, y)
            };
            let [a, b] = [place(step[0]), place(step[1])];
            let crossed = cdt.get_conflicting_edges_between_vertices(step[0], step[1]).next();
            let share = crossed.map_or(0.5, |edge| {
                let [c, d] = edge.vertices().map(|vertex| place(vertex.fix()));
                (turn(c, d, a) / (turn(c, d, a) - turn(c, d, b))).clamp(0.0, 1.0)
            });
            return Err(([step[0], step[1]], share));
        }
        whole.extend(edges.into_iter().map(|edge| cdt.directed_edge(edge).to().fix()));
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Shoelace: an independent way to the area along z.
    fn shoelace(p: &[DVec3]) -> f64 {
        let next = |i: usize| p[(i + 1) % p.len()];
        (0..p.len()).map(|i| p[i].x * next(i).y - next(i).x * p[i].y).sum::<f64>() / 2.0
    }

    fn on_plane(points: impl IntoIterator<Item = [f64; 2]>) -> Vec<DVec3> {
        points.into_iter().map(|[x, y]| DVec3::new(x, y, 0.0)).collect()
    }

    /// The triangles of a polygon along z: none turned over, all together its area, their outline its own.
    fn whole(corners: &[DVec3]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        triangulate(corners, &mut triangles).unwrap_or_else(|crossing| panic!("{crossing:?}"));
        let doubled = |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).z;
        let area: f64 = triangles.iter().map(|t| doubled(t).abs() / 2.0).sum();
        let wanted = shoelace(corners);
        assert!((area - wanted).abs() <= 1e-9 * wanted.abs(), "{area} {wanted}");
        pairs_up(corners, &triangles);
        triangles
    }

    /// What is left of the triangles' edges, those that run both ways cancelled, is the polygon's outline.
    fn pairs_up(corners: &[DVec3], triangles: &[[usize; 3]]) {
        let mut left: FxHashMap<[[u64; 3]; 2], i32> = FxHashMap::default();
        let key = |i: usize| (corners[i] + 0.0).to_array().map(f64::to_bits);
        let mut count = |a: usize, b: usize, times: i32| {
            let (a, b) = (key(a), key(b));
            if a != b {
                *left.entry([a.min(b), a.max(b)]).or_default() += if a < b { times } else { -times };
            }
        };
        triangles.iter().for_each(|t| (0..3).for_each(|k| count(t[k], t[(k + 1) % 3], 1)));
        (0..corners.len()).for_each(|i| count(i, (i + 1) % corners.len(), -1));
        assert!(left.values().all(|times| *times == 0), "edges do not pair up");
    }

    fn fails(corners: &[DVec3], near: [f64; 2]) {
        let mut triangles = Vec::new();
        let Crossing(place) = triangulate(corners, &mut triangles).expect_err("it crosses itself");
        assert!(place.truncate().distance(DVec2::from(near)) < 0.51, "{place}");
        assert_eq!(triangles.is_empty(), corners.len() > 4);
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        let arrow = on_plane([[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]]);
        let comb = (0..20).map(|i| [f64::from(i), f64::from(i % 2) * 5.0]).chain([[19.0, 9.0], [0.0, 9.0]]);
        for polygon in [arrow, on_plane(comb)] {
            assert_eq!(whole(&polygon).len(), polygon.len() - 2);
        }
    }

    /// The corner of a quadrilateral that exporters cut from.
    #[test]
    fn convex_polygons_are_fanned() {
        let square = on_plane([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(whole(&square), [[0, 1, 2], [0, 2, 3]]);
        let ring = on_plane((0..300).map(|i| {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 300.0);
            [cos, sin]
        }));
        assert_eq!(whole(&ring).len(), 298);
    }

    /// A square with a hole in each of `cells`² cells, joined to the corner below by a bridge that is gone both ways.
    fn sieve(cells: u32) -> Vec<DVec3> {
        let side = f64::from(cells);
        let mut corners = Vec::new();
        // Along the lower edge, up each column of holes and down again.
        for column in 0..cells {
            let x = f64::from(column) + 0.3;
            corners.push([x, 0.0]);
            for row in 0..cells {
                corners.push([x, f64::from(row) + 0.3]);
            }
            for row in (0..cells).rev() {
                let y = f64::from(row) + 0.3;
                if row + 1 < cells {
                    corners.push([x, y]);
                }
                corners.extend([[x, y + 0.4], [x + 0.4, y + 0.4], [x + 0.4, y], [x, y]]);
            }
            corners.push([x, 0.0]);
        }
        corners.extend([[side, 0.0], [side, side], [0.0, side], [0.0, 0.0]]);
        on_plane(corners)
    }

    #[test]
    fn holes_joined_by_bridges() {
        for cells in [1, 2, 7, 30] {
            let corners = sieve(cells);
            let wanted = f64::from(cells * cells) * (1.0 - 0.16);
            assert!((shoelace(&corners) - wanted).abs() < 1e-9);
            whole(&corners);
        }
    }

    /// Stars, combs and spirals of thousands of corners, in less time than a frame takes.
    #[test]
    fn thousands_of_corners() {
        let start = std::time::Instant::now();
        let star = on_plane((0..20_000).map(|i| {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 20_000.0);
            let radius = if i % 2 == 0 { 1.0 } else { 0.3 };
            [radius * cos, radius * sin]
        }));
        assert_eq!(whole(&star).len(), 19_998);
        let spiral = |i: u32, inset: f64| {
            let turns = f64::from(i) / 500.0;
            let (sin, cos) = libm::sincos(turns * std::f64::consts::TAU);
            let radius = 1.0 + turns - inset;
            [radius * cos, radius * sin]
        };
        let spiral = (0..5000).map(|i| spiral(i, 0.0)).chain((0..5000).rev().map(|i| spiral(i, 0.4)));
        whole(&on_plane(spiral));
        let teeth = (0..5000).flat_map(|i| {
            let x = f64::from(i);
            [[x, 0.0], [x + 0.25, 0.0], [x + 0.25, -3.0], [x + 0.75, -3.0], [x + 0.75, 0.0]]
        });
        whole(&on_plane(teeth.chain([[5000.0, 0.0], [5000.0, 1.0], [0.0, 1.0]])));
        assert!(start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
    }

    #[test]
    fn corners_in_line_and_touching() {
        // All sides of a square halved, and one corner twice.
        whole(&on_plane([
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [2.0, 2.0],
            [1.0, 2.0],
            [0.0, 2.0],
            [0.0, 1.0],
        ]));
        // A corner on another edge, from inside; two loops that share a corner; a spike that is gone both ways.
        whole(&on_plane([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]]));
        whole(&on_plane([
            [0.0, 0.0],
            [1.0, -1.0],
            [2.0, 0.0],
            [3.0, -1.0],
            [4.0, 0.0],
            [3.0, 1.0],
            [2.0, 0.0],
            [1.0, 1.0],
        ]));
        whole(&on_plane([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [3.0, 1.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0]]));
        // In line altogether: no area, and the edges pair up all the same.
        whole(&on_plane([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0], [1.5, 0.0]]));
    }

    #[test]
    fn polygons_that_are_not_flat() {
        // Bent by a right angle along its middle: corners lie above one another along an axis.
        let bent = [[0, 0, 0], [1, 0, 0], [1, 0, -1], [1, 1, -1], [1, 1, 0], [0, 1, 0]];
        let corners = bent.map(|p| DVec3::from(p.map(f64::from)));
        let mut triangles = Vec::new();
        triangulate(&corners, &mut triangles).unwrap();
        assert_eq!(triangles.len(), 4);
        pairs_up(&corners, &triangles);
    }

    #[test]
    fn crossings_are_found() {
        fails(&on_plane([[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 3.0]]), [1.2, 1.2]);
        // A pentagram, a loop around the same square twice, a hole that runs the wrong way.
        fails(
            &on_plane((0..5).map(|i| {
                let (sin, cos) = libm::sincos(f64::from(i * 2) * std::f64::consts::TAU / 5.0);
                [cos, sin]
            })),
            [0.0, 0.0],
        );
        // Loops that run against one another have no area together.
        fails(&on_plane([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), [0.5, 0.5]);
        fails(&on_plane([[0.0, 0.0], [2.0, 2.0], [2.0, 1.0], [2.0, 0.0], [0.0, 2.0], [0.0, 1.0]]), [1.0, 1.0]);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        fails(&on_plane(square.into_iter().chain(square)), [0.5, 0.5]);
        let hole = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0]];
        let outer = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0], [0.0, 0.0]];
        fails(&on_plane(outer.into_iter().chain(hole)), [1.5, 1.5]);
    }

    /// What a modeller's text file keeps of a polygon that lies askew: six digits after the point.
    fn askew(corners: &[DVec3], turned: [f64; 3]) -> Vec<DVec3> {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, turned[0], turned[1], turned[2]);
        corners.iter().map(|p| ((turn * *p) * 1e6).round() / 1e6).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Around the origin at random, any radii, with bridges to holes at random, and corners put between.
        #[test]
        fn polygons_at_random(
            radii in prop::collection::vec(0.5..2.0_f64, 5..60),
            hole in prop::option::of(3..9_usize),
            halved in prop::collection::vec(any::<bool>(), 60),
            turned in [0.0..6.3_f64, 0.0..6.3_f64, 0.0..6.3_f64],
        ) {
            let count = radii.len();
            let around = |i: usize, count: usize, radius: f64| {
                let (sin, cos) = libm::sincos(i as f64 * std::f64::consts::TAU / count as f64);
                [radius * cos, radius * sin]
            };
            let mut corners = Vec::new();
            for i in 0..count {
                let (here, next) = (around(i, count, radii[i]), around(i + 1, count, radii[(i + 1) % count]));
                corners.push(here);
                if halved[i] {
                    corners.push([(here[0] + next[0]) / 2.0, (here[1] + next[1]) / 2.0]);
                }
            }
            if let Some(sides) = hole {
                corners.push(corners[0]);
                corners.extend((0..=sides).rev().map(|i| around(i % sides, sides, 0.1)));
            }
            let corners = on_plane(corners);
            let mut triangles = Vec::new();
            prop_assert!(triangulate(&corners, &mut triangles).is_ok());
            pairs_up(&corners, &triangles);
            let doubled = |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).z;
            let area: f64 = triangles.iter().map(|t| doubled(t).abs() / 2.0).sum();
            prop_assert!((area - shoelace(&corners)).abs() < 1e-9 * area, "{} {}", area, shoelace(&corners));

            let corners = askew(&corners, turned);
            triangles.clear();
            prop_assert!(triangulate(&corners, &mut triangles).is_ok());
            pairs_up(&corners, &triangles);
            let of = |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).length();
            let rounded: f64 = triangles.iter().map(|t| of(t) / 2.0).sum();
            prop_assert!((rounded - area).abs() < 1e-4 * area, "{} {}", rounded, area);
        }

        /// Any corners at all, few places, so that all sorts of touching and crossing come: an outline or an error.
        #[test]
        fn any_corners_at_all(places in prop::collection::vec((0..5_i32, 0..5_i32, 0..2_i32), 3..14)) {
            let corners: Vec<DVec3> = places.iter().map(|(x, y, z)| DVec3::from([*x, *y, *z].map(f64::from))).collect();
            let mut triangles = Vec::new();
            if triangulate(&corners, &mut triangles).is_ok() || corners.len() <= 4 {
                pairs_up(&corners, &triangles);
            }
            let again = triangles.clone();
            triangles.clear();
            let _ = triangulate(&corners, &mut triangles);
            prop_assert_eq!(again, triangles);
        }
    }
}

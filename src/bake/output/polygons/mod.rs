//! A frame's surface as triangles with attributes: dual contouring of the band by the field's own gradient (Ju et al.
//! 2002), with a vertex for each piece of the surface in a cell, so that edges and corners are sharp and the surface is
//! closed.

mod adapt;
mod cell;
mod fit;
mod notches;
mod within;

use std::sync::Arc;

use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;

use super::Frame;
use crate::attribute::{Attribute, LinearRgb};
use crate::bake::{Error, Output, PolygonRecord};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points};
use crate::grid::measure::{Lookup, Place, Surroundings, local_of};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, BlockMask, mask};
use crate::morph::Movement;
use crate::node::Model;
use crate::shot::FrameContent;

use cell::{NO_PIECE, least_corner, others, pieces_of};

/// The narrowest band, in voxels, whose blocks hold all cells that the surface passes through.
const LEAST_HALF_WIDTH: f64 = 2.5;
/// Steps of the search for the surface along an edge: the distances are exact where they are short.
const STEPS: usize = 4;

/// What polygons cannot hold of what is asked for.
pub fn check(model: &Model, output: &Output) -> Result<(), String> {
    if output.identity.half_width < LEAST_HALF_WIDTH {
        return Err(format!("--half-width: polygons need a band of {LEAST_HALF_WIDTH} voxels at least"));
    }
    if let Some(grid) = output.identity.half.first() {
        return Err(format!("--half: polygons have no grid `{grid}` of 16 bits"));
    }
    if let Some(program) = model.output.program {
        return Err(format!("--for {}: it names the grids of .vdb; leave it out for polygons", program.name));
    }
    if model.output.fills_inside() {
        return Err(
            "output.grids: polygons hold a surface alone, without `density` and `inside`; leave them out, or write \
                    .vdb"
                .into(),
        );
    }
    if let Some(primaries) = model.output.other_primaries() {
        return Err(format!(
            "output.color_space: polygons have colours of Rec.709, not `{}`; leave it out, or write .vdb",
            primaries.name()
        ));
    }
    Ok(())
}

/// What formats of polygons without motion cannot hold.
pub fn check_still(model: &Model) -> Result<(), String> {
    if model.output.writes("vel") {
        return Err("output.grids: of polygons .usda alone holds `vel`; leave it out, or write .usda or .vdb".into());
    }
    Ok(())
}

/// The surface of a frame.
pub fn of_frame(frame: &Frame<'_>) -> Result<Polygons, Error> {
    let content = frame.prepared.frame(frame.number).map_err(Error::Scene)?;
    let band = &frame.computed.band;
    let dense = polygons(&content, band)
        .map_err(|_| Error::Encode("the surface has more than 4,294,967,295 vertices: take larger voxels".into()))?;
    match frame.output.identity.adaptivity {
        0.0 => Ok(dense),
        error => Ok(adapt::adapt(dense, content.field.as_ref(), error, band.lattice.voxel_size.get())),
    }
}

/// A surface of triangles, world units, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Polygons {
    /// Where the vertices are.
    pub positions: Vec<DVec3>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// Scene-linear, of each vertex.
    pub colours: Option<Vec<LinearRgb>>,
    /// Further numbers of each vertex, by name.
    pub scalars: Vec<(String, Vec<f32>)>,
    /// World units a second, of each vertex.
    pub velocities: Option<Vec<[f32; 3]>>,
    /// How many triangles were merged, where that was asked for.
    pub merged: Option<PolygonRecord>,
}

/// More vertices than indices of 32 bits reach.
struct TooMany;

/// The surface of a frame whose band this is.
fn polygons(content: &FrameContent, band: &Band) -> Result<Polygons, TooMany> {
    let lookup = Lookup::new(band);
    let field = content.field.as_ref();
    let blocks = 0..band.origins.len();
    let crossings: Vec<Crossings> = blocks
        .clone()
        .into_par_iter()
        .map_init(|| field.evaluator(), |evaluator, block| Crossings::of(band, &lookup, block, evaluator.as_mut()))
        .collect();
    let mut cells: Vec<Cells> =
        blocks.clone().into_par_iter().map(|block| Cells::of(band, &lookup, block, &crossings)).collect();
    let mut count = 0_u64;
    for cells in &mut cells {
        cells.first = u32::try_from(count).map_err(|_| TooMany)?;
        count += cells.vertices.len() as u64;
    }
    u32::try_from(count).map_err(|_| TooMany)?;
    let quads = blocks.into_par_iter().flat_map_iter(|block| quads(band, &lookup, block, &crossings, &cells));
    let quads: Vec<[u32; 4]> = quads.collect();
    let positions: Vec<DVec3> = cells.into_iter().flat_map(|cells| cells.vertices).collect();
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| {
        let [p, q, r, s] = [a, b, c, d].map(|vertex| positions[vertex as usize]);
        // The shorter way across.
        if p.distance_squared(r) <= q.distance_squared(s) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    });
    let triangles = triangles.collect();
    let colours = content.colour.as_deref().map(|colour| sampled(colour, &positions));
    let scalar = |(name, scalar): &(String, Arc<crate::attribute::Scalar>)| {
        (name.clone(), sampled(scalar.as_ref(), &positions).into_iter().map(|[value]| value).collect())
    };
    let scalars = content.scalars.iter().map(scalar).collect();
    let velocities = content.movement.as_ref().map(|movement| velocities(field, movement, &positions, band));
    Ok(Polygons { positions, triangles, colours, scalars, velocities, merged: None })
}

/// How fast vertices move.
fn velocities(field: &dyn Field, movement: &Movement, positions: &[DVec3], band: &Band) -> Vec<[f32; 3]> {
    let edge = band.lattice.voxel_size.get();
    let chunks = positions.par_chunks(BATCH).map_init(
        || (field.evaluator(), movement.meter(edge), Box::new(Gradients::new())),
        |(evaluator, meter, gradients), positions| {
            let points = Points::of_positions(positions);
            let Some(region) = points.bounding_box() else { return Vec::new() };
            evaluator.enter(&region.grown(0.01 * edge));
            evaluator.gradients(&points, gradients);
            evaluator.leave();
            let outward: Vec<Vec3> = (0..points.len).map(|i| (-gradients.gradient(i)).normalize_or_zero()).collect();
            let (mut out, mut held) = ([[0.0; 3]; BATCH], [false; BATCH]);
            meter.velocities(&points, &outward, &mut out, &mut held);
            out[..points.len].to_vec()
        },
    );
    chunks.collect::<Vec<_>>().concat()
}

/// An attribute at places.
fn sampled<const N: usize>(attribute: &dyn Attribute<N>, positions: &[DVec3]) -> Vec<[f32; N]> {
    let chunks = positions.par_chunks(BATCH).map_init(
        || (attribute.sampler(), Box::new([[0.0; N]; BATCH])),
        |(sampler, out), positions| {
            let points = Points::of_positions(positions);
            let Some(region) = points.bounding_box() else { return Vec::new() };
            sampler.enter(&region);
            sampler.sample(&points, out);
            sampler.leave();
            out[..positions.len()].to_vec()
        },
    );
    chunks.collect::<Vec<_>>().concat()
}

/// The values of a block's voxels and of those after them on each axis.
struct Values([f32; Values::EDGE * Values::EDGE * Values::EDGE]);

impl Values {
    const EDGE: usize = BLOCK_EDGE as usize + 1;

    fn of(around: &Surroundings<'_>) -> Self {
        let along = |at: usize, stride: usize| (at / stride % Self::EDGE) as i32;
        let local = |at: usize| IVec3::new(along(at, Self::EDGE * Self::EDGE), along(at, Self::EDGE), along(at, 1));
        Self(std::array::from_fn(|at| around.value(local(at))))
    }

    fn at(&self, local: IVec3) -> f32 {
        let [x, y, z] = local.to_array().map(|along| along as usize);
        self.0[(x * Self::EDGE + y) * Self::EDGE + z]
    }

    /// The bits of a cell's corners, 1 inside.
    fn corners(&self, least: IVec3) -> u8 {
        let bit = |corner: i32| {
            let voxel = least + IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1);
            u8::from(self.at(voxel) >= 0.0) << corner
        };
        (0..8).map(bit).sum()
    }
}

/// Where the edges from a block's voxels to their next ones cross the surface.
struct Crossings {
    /// The voxels whose edge along each axis does.
    edges: [BlockMask; 3],
    /// Point and outward normal of each, axis by axis in the order of voxels.
    found: Vec<(DVec3, DVec3)>,
}

impl Crossings {
    fn of(band: &Band, lookup: &Lookup<'_>, block: usize, evaluator: &mut dyn Evaluator) -> Self {
        let values = Values::of(&lookup.around(block));
        let (origin, edge) = (band.origins[block], band.lattice.voxel_size.get());
        let mut edges = [[0; 8]; 3];
        // Both ends of each crossed edge, and the values there.
        let mut ends: Vec<([DVec3; 2], [f64; 2])> = Vec::new();
        for (axis, edges) in edges.iter_mut().enumerate() {
            for at in 0..BLOCK_VOXELS {
                let here = local_of(at);
                let next = here + IVec3::AXES[axis];
                let values = [values.at(here), values.at(next)];
                if (values[0] >= 0.0) != (values[1] >= 0.0) {
                    edges[at >> 6] |= 1 << (at & 63);
                    let places = [here, next].map(|voxel| (origin + voxel).as_dvec3() * edge);
                    ends.push((places, values.map(f64::from)));
                }
            }
        }
        let mut found = Vec::with_capacity(ends.len());
        let region = Aabb::new(origin.as_dvec3() * edge, (origin + BLOCK_EDGE).as_dvec3() * edge).grown(0.01 * edge);
        evaluator.enter(&region);
        for ends in ends.chunks(BATCH) {
            found.extend(on_surface(ends, evaluator));
        }
        evaluator.leave();
        Self { edges, found }
    }

    /// Where the edge from a voxel along an axis crosses.
    fn at(&self, axis: usize, at: usize) -> (DVec3, DVec3) {
        let before: usize = self.edges[..axis].iter().map(mask::count).sum();
        self.found[before + mask::rank(&self.edges[axis], at)]
    }
}

/// Where F vanishes between ends of different sign, and the outward normal there.
fn on_surface(ends: &[([DVec3; 2], [f64; 2])], evaluator: &mut dyn Evaluator) -> Vec<(DVec3, DVec3)> {
    let origin = ends[0].0[0];
    let mut brackets: Vec<([f64; 2], [f64; 2])> = ends.iter().map(|(_, values)| ([0.0, 1.0], *values)).collect();
    let share = |([low, high], [a, b]): &([f64; 2], [f64; 2])| low + (high - low) * (a / (a - b)).clamp(0.0, 1.0);
    let points = |brackets: &[([f64; 2], [f64; 2])]| {
        let mut points = Points::new(origin);
        for (([from, to], _), bracket) in ends.iter().zip(brackets) {
            points.push((from.lerp(*to, share(bracket)) - origin).as_vec3());
        }
        points
    };
    let mut out = Box::new([0.0; BATCH]);
    for _ in 0..STEPS {
        evaluator.values(&points(&brackets), &mut out);
        for (bracket, value) in brackets.iter_mut().zip(out.iter()) {
            let (at, value) = (share(bracket), f64::from(*value));
            let ([low, high], [a, b]) = bracket;
            // Of F only signs are the same as those of distances; by their sizes at both ends the next guess is made.
            if (value >= 0.0) == (*a >= 0.0) {
                (*low, *a) = (at, value);
                *b /= 2.0;
            } else {
                (*high, *b) = (at, value);
                *a /= 2.0;
            }
            if *a == *b {
                (*a, *b) = (1.0, -1.0);
            }
        }
    }
    let points = points(&brackets);
    let mut gradients = Box::new(Gradients::new());
    evaluator.gradients(&points, &mut gradients);
    let normal = |i: usize| {
        let ([from, to], values) = ends[i];
        let along = (to - from).normalize() * if values[0] >= 0.0 { 1.0 } else { -1.0 };
        let found = (-gradients.gradient(i).as_dvec3()).normalize_or_zero();
        // On a crease F may have a slope of either side, and none at all where it is flat.
        if found.is_finite() && found.dot(along) > 0.0 { found } else { along }
    };
    (0..ends.len()).map(|i| (points.position(i), normal(i))).collect()
}

/// The vertices in a block's cells: those between a voxel and the next ones.
struct Cells {
    /// The cells that the surface passes through.
    crossed: BlockMask,
    /// Their corners' signs, and the number of their first vertex in the block.
    of_cell: Vec<(u8, u32)>,
    vertices: Vec<DVec3>,
    /// The number of the block's first vertex.
    first: u32,
}

impl Cells {
    fn of(band: &Band, lookup: &Lookup<'_>, block: usize, crossings: &[Crossings]) -> Self {
        let around = lookup.around(block);
        let values = Values::of(&around);
        let (origin, edge) = (band.origins[block], band.lattice.voxel_size.get());
        let mut cells = Self { crossed: [0; 8], of_cell: Vec::new(), vertices: Vec::new(), first: 0 };
        let mut planes: [Vec<(DVec3, DVec3)>; 4] = Default::default();
        for at in 0..BLOCK_VOXELS {
            let least = local_of(at);
            let corners = values.corners(least);
            if corners == 0 || corners == u8::MAX {
                continue;
            }
            cells.crossed[at >> 6] |= 1 << (at & 63);
            cells.of_cell.push((corners, cells.vertices.len() as u32));
            let pieces = pieces_of(corners);
            planes.iter_mut().for_each(Vec::clear);
            for (number, piece) in pieces.of_edge.iter().enumerate().filter(|(_, piece)| **piece != NO_PIECE) {
                let voxel = least + IVec3::from(least_corner(number).map(|along| along as i32));
                if let Place::Voxel { block, offset } = around.at(voxel) {
                    planes[usize::from(*piece)].push(crossings[block].at(number / 4, offset));
                }
            }
            let low = (origin + least).as_dvec3() * edge;
            for planes in &planes[..usize::from(pieces.count)] {
                // Beyond the cell it would stand among the neighbours' vertices.
                cells.vertices.push(fit::point_on(planes).clamp(low, low + edge));
            }
        }
        cells
    }

    /// The vertex of the piece that crosses an edge of a cell.
    fn vertex(&self, at: usize, edge: usize) -> u32 {
        let (corners, first) = self.of_cell[mask::rank(&self.crossed, at)];
        self.first + first + u32::from(pieces_of(corners).of_edge[edge])
    }
}

/// Around each crossed edge of a block's voxels the vertices of its four cells, counter-clockwise seen from outside.
fn quads(band: &Band, lookup: &Lookup<'_>, block: usize, crossings: &[Crossings], cells: &[Cells]) -> Vec<[u32; 4]> {
    let around = lookup.around(block);
    let mut quads = Vec::new();
    for axis in 0..3 {
        let [b, c] = others(axis);
        for at in mask::places(&crossings[block].edges[axis]) {
            let voxel = local_of(at);
            let vertex = |(i, j): (usize, usize)| {
                // The cell in which the edge's least corner is at these places of the other axes.
                let mut corner = [0; 3];
                (corner[b], corner[c]) = (i, j);
                let least = voxel - IVec3::from(corner.map(|along| along as i32));
                match around.at(least) {
                    Place::Voxel { block, offset } => Some(cells[block].vertex(offset, cell::edge(axis, corner))),
                    _ => None,
                }
            };
            let four = [(1, 1), (0, 1), (0, 0), (1, 0)].map(vertex);
            let [Some(p), Some(q), Some(r), Some(s)] = four else { continue };
            let from_inside = band.distances[block][at] >= 0.0;
            // Seen against the axis these go round to the left for x and z, to the right for y.
            quads.push(if from_inside == (axis != 1) { [p, q, r, s] } else { [s, r, q, p] });
        }
    }
    quads
}

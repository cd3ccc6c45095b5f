//! `vector-dt`: the vector distance transform (Danielsson, 1980). Nodes beside the surface have a point on it; every other
//! takes the nearest of those that its neighbours have, and then of those around that point.
//!
//! Neighbours alone pass on too few: where the surface lies across the axes, the point below a node is that of a node three
//! steps away, which those between have nearer ones than and do not carry. That leaves errors of up to 0.7 voxel.
//!
//! **Guaranteed:** each distance is that to a point on F = 0, so none is too short; the same bits for any number of
//! threads. **Not guaranteed:** that the point is the closest one. It is one of a finite number on the surface, about two
//! for each voxel's face, and creases have none of their own.

mod seeds;

use std::sync::Arc;

use glam::{DVec3, IVec3};

use super::lattice::{self, Nodes};
use super::rounds::settle;
use super::{AsChosen, Measured, Method, Request};
use crate::distance::nearest::Watch;
use crate::distance::octree::{BuildError, DistanceObject};
use crate::field::Field;
use crate::grid::Band;

/// How much nearer a neighbour's point must be to be taken, in voxels. Less costs rounds for nothing.
const NEARER: f64 = 1e-6;

/// Nearer than this to its point, in voxels, a node looks at those around it. Farther away they are nearer by less than a
/// fiftieth of a voxel.
const LOOKS: f64 = 6.0;

/// No point yet.
const NONE: u32 = u32::MAX;

/// Its point, its distance and that of the band, its side and whether it is listed, and a share of the points.
const BYTES_A_NODE: usize = 28;

/// The method.
pub struct VectorDt;

impl Method for VectorDt {
    fn name(&self) -> &'static str {
        "vector-dt"
    }

    fn measure(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<Measured, BuildError> {
        let field = request.field.as_ref();
        lattice::measure(
            request,
            BYTES_A_NODE,
            &|nodes: &Nodes<'_>, watch: &Watch<'_>| distances(field, nodes, watch),
            watch,
        )
    }

    fn bytes_a_node(&self) -> usize {
        BYTES_A_NODE
    }

    fn restored(&self, object: Arc<DistanceObject>, field: &Arc<dyn Field>) -> Measured {
        Measured::signed(object, field)
    }

    fn measure_band(
        &self,
        field: &dyn Field,
        band: &mut Band,
        _as_chosen: AsChosen,
        watch: &Watch<'_>,
    ) -> Result<(), BuildError> {
        lattice::measure_band(band, &|nodes: &Nodes<'_>, watch: &Watch<'_>| distances(field, nodes, watch), watch)
    }
}

/// Distances to the points that nodes end up with.
fn distances(field: &dyn Field, nodes: &Nodes<'_>, watch: &Watch<'_>) -> Result<Vec<f64>, BuildError> {
    let blocks = nodes.blocks;
    let place = |node: usize| nodes.lattice.centre(blocks.voxel(node));
    let mut points: Vec<DVec3> = Vec::new();
    let mut nearest = vec![NONE; blocks.nodes()];
    let mut sources = Vec::new();
    for (node, point) in seeds::points(field, nodes, watch)? {
        let known = nearest[node];
        if known == NONE {
            nearest[node] = points.len() as u32;
            points.push(point);
            sources.push(node);
        } else if place(node).distance_squared(point) < place(node).distance_squared(points[known as usize]) {
            points[known as usize] = point;
        }
    }
    let square = |point: u32, at: DVec3| {
        if point == NONE { f64::INFINITY } else { at.distance_squared(points[point as usize]) }
    };
    let around = |point: DVec3| {
        let least = (point / nodes.step()).floor().as_ivec3();
        (0..8).filter_map(move |corner| blocks.node(least + IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1)))
    };
    let relax = |nearest: &[u32], node: usize| {
        let at = place(node);
        let mut held = (nearest[node], square(nearest[node], at));
        let offer = |held: &mut (u32, f64), other: usize| {
            let distance = square(nearest[other], at);
            if distance < held.1 {
                *held = (nearest[other], distance);
            }
        };
        (0..6).filter_map(|face| blocks.beside(node, face)).for_each(|other| offer(&mut held, other));
        let mut looked = NONE;
        while held.0 != looked && held.1 < (LOOKS * nodes.step()).powi(2) {
            looked = held.0;
            around(points[looked as usize]).for_each(|other| offer(&mut held, other));
        }
        let nearer = held.1.sqrt() < square(nearest[node], at).sqrt() - NEARER * nodes.step();
        nearer.then_some(held.0)
    };
    settle(blocks, &mut nearest, &sources, relax, watch)?;
    Ok(nearest.iter().enumerate().map(|(node, &point)| square(point, place(node)).sqrt()).collect())
}

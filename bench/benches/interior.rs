//! Interior distances in a full box against the simplest rival: a wavefront over a dense array of the same cells, each of
//! which hears from its 26 neighbours (ways along the lattice, up to 10 % too long), and tricubic look-ups in it.
//!
//! `cargo bench -p hfvdb-bench --bench interior [-- CELLS]`; 192 without arguments, the most being 250.
//!
//! `INTERIOR what seconds processor error`: the mean error in cells, against the straight line.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};
use hfvdb::attribute::Attribute;
use hfvdb::attribute::conformal::{Body, Feature, Goal, Interior, Method};
use hfvdb::field::{Aabb, BATCH, Expression, Field, Graph, Points};
use hfvdb_bench::clock::timed;
use rayon::prelude::*;

/// Look-ups that are timed.
const QUERIES: usize = 1 << 24;
/// The source's radius, in edges of the box.
const SOURCE: f64 = 0.025;

/// Lengths of the shortest ways along a dense lattice from its middle, cells.
struct Wavefront {
    along: usize,
    values: Vec<f32>,
}

impl Wavefront {
    fn new(along: usize, radius: f32) -> Self {
        let mut values = vec![f32::INFINITY; along.pow(3)];
        let steps: Vec<([isize; 3], f32)> = (0..27)
            .filter(|k| *k != 13)
            .map(|k| {
                let step = [k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1];
                (step, (step.iter().map(|s| s * s).sum::<isize>() as f32).sqrt())
            })
            .collect();
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); 2 * along + 4];
        let middle = (along as f32 - 1.0) / 2.0;
        for x in 0..along {
            for y in 0..along {
                for z in 0..along {
                    let far = Vec3::new(x as f32, y as f32, z as f32).distance(Vec3::splat(middle)) - radius;
                    if far <= 1.0 {
                        let at = (x * along + y) * along + z;
                        values[at] = far.max(0.0);
                        buckets[values[at] as usize].push(at as u32);
                    }
                }
            }
        }
        // A step is no shorter than a bucket is wide: what a bucket reaches lies in later ones.
        for bucket in 0..buckets.len() {
            for at in std::mem::take(&mut buckets[bucket]) {
                let at = at as usize;
                let here = values[at];
                if here as usize != bucket {
                    continue;
                }
                let place = [at / along / along, at / along % along, at % along];
                for (step, length) in &steps {
                    let to: [usize; 3] = std::array::from_fn(|axis| place[axis].wrapping_add_signed(step[axis]));
                    if to.iter().any(|to| *to >= along) {
                        continue;
                    }
                    let to = (to[0] * along + to[1]) * along + to[2];
                    if here + length < values[to] {
                        values[to] = here + length;
                        buckets[values[to] as usize].push(to as u32);
                    }
                }
            }
        }
        Self { along, values }
    }

    /// By Catmull and Rom's cubics; `place` is in cells, at least two from the border.
    fn at(&self, place: Vec3) -> f32 {
        let floor = place.floor();
        let weights = (place - floor).to_array().map(|t| {
            let (t2, t3) = (t * t, t * t * t);
            [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, 0.5 * (t3 - t2)]
        });
        let first = floor.to_array().map(|at| at as usize - 1);
        let mut sum = 0.0;
        for (i, wx) in weights[0].iter().enumerate() {
            for (j, wy) in weights[1].iter().enumerate() {
                let row = ((first[0] + i) * self.along + first[1] + j) * self.along + first[2];
                let values = &self.values[row..row + 4];
                let along = (0..4).map(|k| weights[2][k] * values[k]).sum::<f32>();
                sum += wx * wy * along;
            }
        }
        sum
    }
}

/// Places of a batch, in edges of the box from its middle: together they fill nine tenths of it evenly.
fn places(batch: usize) -> impl Iterator<Item = Vec3> {
    // Martin Roberts' sequence of low discrepancy (2018).
    const STEPS: [f64; 3] = [0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_4];
    let corner = STEPS.map(|step| (batch as f64 * step).fract() as f32 - 0.5);
    (0..BATCH).map(move |i| {
        let at = [i >> 6, i >> 3 & 7, i & 7];
        // A batch is a block of neighbours, as voxels ask.
        Vec3::from(std::array::from_fn(|axis| (corner[axis] + at[axis] as f32 / 512.0).clamp(-0.5, 0.5) * 0.9))
    })
}

fn main() {
    let along: u32 = std::env::args().filter_map(|argument| argument.parse().ok()).next().unwrap_or(192);
    let mut graph = Graph::new();
    let (solid, source) = (graph.cuboid(DVec3::splat(1.0)), graph.sphere(SOURCE));
    let [solid, source]: [Arc<dyn Field>; 2] = [solid, source].map(|node| Arc::new(Expression::new(&graph, node)) as _);
    let cancel = AtomicBool::new(false);
    let aabb = Aabb::new(DVec3::splat(-0.5), DVec3::splat(0.5));
    let (lattice, body) = timed(|| Body::new(Arc::clone(&solid), solid, aabb, along, &cancel).expect("it has nodes"));
    let body = Arc::new(body);
    let (spread, feature) = timed(|| Feature::new(&body, source, &Method::Sight, &cancel).expect("it spreads"));
    let (front, dense) = timed(|| Wavefront::new(along as usize, SOURCE as f32 * along as f32));
    let interior = Interior::new(body, vec![Goal::Feature(Arc::new(feature))]);
    let batches = QUERIES / BATCH;
    let exact = |place: Vec3| (place.length() - SOURCE as f32).max(0.0) * along as f32;
    let (asked, error) = timed(|| {
        let of_batch = |sampler: &mut Box<dyn hfvdb::attribute::Sampler<1> + '_>, batch: usize| {
            let (mut points, mut out) = (Points::new(DVec3::ZERO), [[0.0]; BATCH]);
            places(batch).for_each(|place| points.push(place));
            sampler.sample(&points, &mut out);
            let errors = places(batch).zip(out).map(|(place, [found])| (found * along as f32 - exact(place)).abs());
            f64::from(errors.sum::<f32>())
        };
        (0..batches).into_par_iter().map_init(|| interior.sampler(), of_batch).sum::<f64>() / QUERIES as f64
    });
    let (looked, dense_error) = timed(|| {
        let of_batch = |batch: usize| {
            let found = places(batch).map(|place| (place, dense.at((place + 0.5) * along as f32 - 0.5)));
            f64::from(found.map(|(place, found)| (found - exact(place)).abs()).sum::<f32>())
        };
        (0..batches).into_par_iter().map(of_batch).sum::<f64>() / QUERIES as f64
    });
    let print = |what: &str, [clock, processor]: [f64; 2], error: Option<f64>| {
        let error = error.map_or_else(|| "-".to_owned(), |error| format!("{error:.3}"));
        println!("INTERIOR {what} {clock:.3} {processor:.3} {error}");
    };
    print("lattice", lattice, None);
    print("sight", spread, None);
    print("wavefront", front, None);
    print("sight-look-ups", asked, Some(error));
    print("tricubic-look-ups", looked, Some(dense_error));
}

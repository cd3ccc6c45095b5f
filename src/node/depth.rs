//! How deep points lie in a solid whose value does not tell: nothing is measured before a point lies off the surface,
//! which of a solid that nothing cuts none does.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::attribute::{Attribute, Sampler};
use crate::distance::Distance;
use crate::distance::method::Choice;
use crate::distance::octree::BuildError;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Interval, Points};

use crate::node::keeping::{Keeping, Solid};
use crate::node::measured::measured;

/// The depth of points in a solid, world units; not a number where it cannot be measured.
pub(crate) struct Depth {
    /// The solid.
    pub solid: Arc<dyn Field>,
    /// Its box.
    pub aabb: Aabb,
    /// The depths that are told apart.
    pub levels: Interval,
    /// A voxel's edge.
    pub voxel: f64,
    /// Points are on the surface that are no further from it, world units.
    pub tolerance: f64,
    /// What measures it.
    pub choice: Choice,
    /// Where it is kept, and what decides it.
    pub kept: Option<(Keeping, Solid)>,
    /// Set to stop measuring.
    pub cancel: Arc<AtomicBool>,
    /// Told why it cannot be measured.
    pub failed: Box<dyn Fn(BuildError) + Send + Sync>,
    /// The distance, once it is asked for; `None` where it cannot be measured.
    pub measured: OnceLock<Option<Arc<dyn Distance>>>,
}

impl Depth {
    /// The distance, which is measured now if it is not yet.
    ///
    /// Threads of a pool that wait for one another go on with other work, which may come here again and wait for itself.
    /// So this thread waits for one of no pool, and that for a pool of its own.
    fn measured(&self) -> Option<&dyn Distance> {
        let measure = || {
            let Self { solid, aabb, levels, voxel, choice, cancel, .. } = self;
            let kept = self.kept.as_ref().map(|(keeping, of)| (keeping, *of, None));
            measured(*choice, solid, *aabb, *levels, *voxel, kept, cancel)
        };
        let threads = rayon::current_num_threads();
        let apart = || match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool.install(measure),
            Err(_) => measure(),
        };
        let first = || {
            let done = std::thread::scope(|scope| scope.spawn(apart).join());
            match done {
                Ok(Ok(distance)) => Some(distance),
                Ok(Err(error)) => {
                    (self.failed)(error);
                    None
                }
                Err(panic) => std::panic::resume_unwind(panic),
            }
        };
        self.measured.get_or_init(first).as_deref()
    }

    /// The depth of a point on the surface, to first order; `None` elsewhere.
    fn on_surface(&self, value: f64, slope: DVec3) -> Option<f64> {
        let depth = value / slope.length();
        (depth.abs() <= self.tolerance).then_some(depth)
    }
}

impl Attribute<1> for Depth {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        Box::new(DepthSampler {
            depth: self,
            solid: self.solid.evaluator(),
            distance: None,
            at: Box::default(),
            open: Vec::new(),
            elsewhere: Points::new(DVec3::ZERO),
            values: [0.0; BATCH],
        })
    }
}

struct DepthSampler<'a> {
    depth: &'a Depth,
    solid: Box<dyn Evaluator + 'a>,
    /// Of the measured distance, once it is asked for.
    distance: Option<Box<dyn Evaluator + 'a>>,
    at: Box<Gradients>,
    /// The points off the surface.
    open: Vec<usize>,
    elsewhere: Points,
    values: [f32; BATCH],
}

impl Sampler<1> for DepthSampler<'_> {
    // No region is entered: pruning keeps a field's zero set, but here its values count.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        self.solid.gradients(points, &mut self.at);
        self.open.clear();
        for i in 0..points.len {
            match self.depth.on_surface(f64::from(self.at.value[i]), self.at.gradient(i).as_dvec3()) {
                Some(depth) => out[i] = [depth as f32],
                None => self.open.push(i),
            }
        }
        if self.open.is_empty() {
            return;
        }
        if self.distance.is_none() {
            self.distance = self.depth.measured().map(Field::evaluator);
        }
        let Some(distance) = &mut self.distance else {
            self.open.iter().for_each(|&i| out[i] = [f32::NAN]);
            return;
        };
        self.elsewhere.origin = points.origin;
        self.elsewhere.len = 0;
        self.open.iter().for_each(|&i| self.elsewhere.push(points.offset(i)));
        distance.values(&self.elsewhere, &mut self.values);
        self.open.iter().zip(&self.values).for_each(|(&i, value)| out[i] = [*value]);
    }
}

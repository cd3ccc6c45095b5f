//! Numbers of a surface's form, everywhere in space by the levels of F: how it is bent, and where it faces.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::{Attribute, Sampler};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points};

/// Half of the divergence of the outward normal, times a length: the mean curvature. 1 on a ball of that radius, 0 where
/// it is flat, −1 in a hollow of that radius. By differences of normals over a tenth of the length.
pub struct Curvature {
    /// F, positive inside.
    pub solid: Arc<dyn Field>,
    /// The length.
    pub length: f64,
}

/// The outward normal along a direction: 1 where the surface faces it, −1 where it faces away.
pub struct Facing {
    /// F, positive inside.
    pub solid: Arc<dyn Field>,
    /// The direction, of length 1.
    pub direction: DVec3,
}

impl Attribute<1> for Curvature {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        Box::new(CurvatureSampler { normals: Normals::new(&*self.solid), curvature: self })
    }
}

impl Attribute<1> for Facing {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        Box::new(FacingSampler { normals: Normals::new(&*self.solid), direction: self.direction.as_vec3() })
    }
}

/// The outward normals of a batch.
struct Normals<'f> {
    evaluator: Box<dyn Evaluator + 'f>,
    gradients: Gradients,
    there: Points,
}

impl<'f> Normals<'f> {
    fn new(solid: &'f dyn Field) -> Self {
        Self { evaluator: solid.evaluator(), gradients: Gradients::new(), there: Points::new(DVec3::ZERO) }
    }

    /// Those at points that are moved by a way.
    fn moved(&mut self, points: &Points, way: DVec3) {
        self.there.clone_from(points);
        self.there.origin += way;
        self.evaluator.gradients(&self.there, &mut self.gradients);
    }

    /// That of a point; 0 where F is level.
    fn of(&self, i: usize) -> Vec3 {
        -self.gradients.gradient(i).normalize_or_zero()
    }
}

struct CurvatureSampler<'a> {
    normals: Normals<'a>,
    curvature: &'a Curvature,
}

impl CurvatureSampler<'_> {
    fn step(&self) -> f64 {
        0.1 * self.curvature.length
    }
}

impl Sampler<1> for CurvatureSampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        let step = self.step();
        self.normals.evaluator.enter(&region.grown(step));
    }

    fn leave(&mut self) {
        self.normals.evaluator.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        let step = self.step();
        let share = (self.curvature.length / (4.0 * step)) as f32;
        out[..points.len].fill([0.0]);
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                self.normals.moved(points, DVec3::AXES[axis] * (sign * step));
                for (i, sum) in out.iter_mut().enumerate().take(points.len) {
                    sum[0] += self.normals.of(i)[axis] * (sign as f32 * share);
                }
            }
        }
    }
}

struct FacingSampler<'a> {
    normals: Normals<'a>,
    direction: Vec3,
}

impl Sampler<1> for FacingSampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.normals.evaluator.enter(region);
    }

    fn leave(&mut self) {
        self.normals.evaluator.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        self.normals.moved(points, DVec3::ZERO);
        for (i, value) in out.iter_mut().enumerate().take(points.len) {
            value[0] = self.normals.of(i).dot(self.direction);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Expression, Graph, Node};

    fn value(attribute: &dyn Attribute<1>, at: DVec3) -> f32 {
        let (mut points, mut out) = (Points::new(at), [[0.0]; BATCH]);
        points.push(Vec3::ZERO);
        attribute.sampler().sample(&points, &mut out);
        out[0][0]
    }

    fn solid(make: impl FnOnce(&mut Graph) -> Node) -> Arc<dyn Field> {
        let mut graph = Graph::new();
        let node = make(&mut graph);
        Arc::new(Expression::new(&graph, node))
    }

    #[test]
    fn balls_hollows_and_planes() {
        let at = DVec3::new(0.3, -0.4, 0.5).normalize() * 0.5;
        let ball = solid(|graph| graph.sphere(0.5));
        let curvature = |solid, length| value(&Curvature { solid, length }, at);
        assert!((curvature(ball.clone(), 0.5) - 1.0).abs() < 0.01, "{}", curvature(ball.clone(), 0.5));
        assert!((curvature(ball.clone(), 0.25) - 0.5).abs() < 0.01);
        let hollow = solid(|graph| {
            let ball = graph.sphere(0.5);
            graph.neg(ball)
        });
        assert!((curvature(hollow, 0.5) + 1.0).abs() < 0.01);
        let plane = solid(|graph| graph.half_space(DVec3::Z, 0.1));
        assert!(curvature(plane.clone(), 0.5).abs() < 1e-6);
        assert_eq!(value(&Facing { solid: plane, direction: DVec3::Z }, at), 1.0);
        let along = at.normalize().as_vec3().y;
        assert!((value(&Facing { solid: ball, direction: DVec3::Y }, at) - along).abs() < 1e-6);
    }
}

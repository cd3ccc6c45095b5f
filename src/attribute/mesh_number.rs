//! A number of a mesh's materials, such as roughness, everywhere in space: that of the closest point of the mesh.

use std::sync::Arc;

use super::Attribute;
use super::mesh_colour::material_at;
use crate::field::{Aabb, BATCH, Evaluator, Points};
use crate::mesh::{Lookup, Material, MeshDistance, MeshEvaluator, NumberOf};

/// A number of the closest point of a mesh.
#[derive(Clone, Debug)]
pub struct MeshNumbers {
    mesh: Arc<MeshDistance>,
    materials: Arc<[Material]>,
    which: NumberOf,
    lookup: Lookup,
    voxel: f32,
}

impl MeshNumbers {
    /// A number of a mesh's materials, 1 where a material says none; `None` where none says it. Pictures are averaged over
    /// a voxel's edge, world units.
    pub fn new(
        mesh: Arc<MeshDistance>,
        materials: Arc<[Material]>,
        which: NumberOf,
        lookup: Lookup,
        voxel: f64,
    ) -> Option<Self> {
        let says = |material: &Material| material.numbers[which as usize].is_some();
        let has_any = mesh.mesh().places().is_some() && materials.iter().any(says);
        has_any.then_some(Self { mesh, materials, which, lookup, voxel: voxel as f32 })
    }
}

impl Attribute<1> for MeshNumbers {
    fn sampler(&self) -> Box<dyn super::Sampler<1> + '_> {
        Box::new(Sampler { numbers: self, evaluator: self.mesh.mesh_evaluator() })
    }
}

struct Sampler<'a> {
    numbers: &'a MeshNumbers,
    evaluator: MeshEvaluator<'a>,
}

impl super::Sampler<1> for Sampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.evaluator.enter(region);
    }

    fn leave(&mut self) {
        self.evaluator.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        let MeshNumbers { mesh, materials, which, lookup, voxel } = self.numbers;
        for (number, nearest) in out.iter_mut().zip(self.evaluator.nearest(points)) {
            let found = material_at(mesh, materials, nearest, *voxel)
                .and_then(|(material, place, across)| material.number(*which, place, *lookup, across));
            *number = [found.unwrap_or(1.0)];
        }
    }
}

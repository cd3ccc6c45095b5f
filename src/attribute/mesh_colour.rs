//! The colours of a mesh, everywhere in space: at the closest point of the mesh, those of its vertices blended over the
//! triangle, times those of its material's picture there.

use std::sync::Arc;

use super::{Attribute, LinearRgb};
use crate::field::{Aabb, BATCH, Evaluator, Points};
use crate::mesh::{Lookup, Material, MeshDistance, MeshEvaluator, Nearest};

/// Colour of the closest point of a mesh.
#[derive(Clone, Debug)]
pub struct MeshColours {
    mesh: Arc<MeshDistance>,
    materials: Arc<[Material]>,
    lookup: Lookup,
    voxel: f32,
    below: Option<Below>,
}

/// What lies deep inside.
#[derive(Clone, Copy, Debug)]
pub struct Below {
    /// How far inward from the surface the mesh's colours reach, world units.
    pub depth: f64,
    /// What lies deeper.
    pub colour: LinearRgb,
}

impl MeshColours {
    /// The colours of a mesh with some materials, or `None` where it has none. Pictures are averaged over a voxel's edge,
    /// world units.
    pub fn new(mesh: Arc<MeshDistance>, materials: Arc<[Material]>, lookup: Lookup, voxel: f64) -> Option<Self> {
        let has_any = mesh.mesh().colours().is_some() || mesh.mesh().places().is_some();
        has_any.then_some(Self { mesh, materials, lookup, voxel: voxel as f32, below: None })
    }

    /// The same with another colour deep inside.
    pub fn with_below(self, below: Option<Below>) -> Self {
        Self { below, ..self }
    }
}

impl Attribute<3> for MeshColours {
    fn sampler(&self) -> Box<dyn super::Sampler<3> + '_> {
        Box::new(Sampler { colours: self, evaluator: self.mesh.mesh_evaluator() })
    }
}

/// The material at a closest point, the place in its pictures, and how many times as wide as these a voxel is.
pub(super) fn material_at<'m>(
    mesh: &MeshDistance,
    materials: &'m [Material],
    nearest: &Nearest,
    voxel: f32,
) -> Option<(&'m Material, [f32; 2], f32)> {
    let place = mesh.place(nearest)?;
    let material = materials.get(place.material as usize)?;
    Some((material, place.place, voxel * mesh.places_a_unit(nearest.triangle)))
}

struct Sampler<'a> {
    colours: &'a MeshColours,
    evaluator: MeshEvaluator<'a>,
}

impl super::Sampler<3> for Sampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.evaluator.enter(region);
    }

    fn leave(&mut self) {
        self.evaluator.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        let MeshColours { mesh, materials, lookup, voxel, below } = self.colours;
        for ((i, colour), nearest) in out.iter_mut().enumerate().zip(self.evaluator.nearest(points)) {
            if let Some(Below { depth, colour: below }) = below
                && nearest.distance_squared > depth * depth
                && mesh.is_inside(points.position(i), nearest)
            {
                *colour = *below;
                continue;
            }
            // A mesh with neither has no colours: `new` saw to it.
            *colour = mesh.colour(nearest).unwrap_or([1.0; 3]);
            if let Some((material, place, across)) = material_at(mesh, materials, nearest, *voxel) {
                let painted = material.colour(place, *lookup, across);
                colour.iter_mut().zip(painted).for_each(|(colour, painted)| *colour *= painted);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::mesh::{Holes, TriangleMesh};

    /// Rounding carries no colour beyond those of the corners, however bright they are.
    #[test]
    fn colours_stay_between_those_of_the_corners() {
        for bright in [1.0, 3.7_f32] {
            let corners = [[0.3, 0.1, -0.2], [1.1, 0.2, 0.4], [-0.3, 0.9, 0.1], [0.2, 0.3, 1.7]].map(DVec3::from);
            let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
            let mesh = TriangleMesh::new(corners.to_vec(), triangles, Some(vec![[bright; 3]; 4])).unwrap();
            let mesh = Arc::new(MeshDistance::new(mesh, Holes::Refuse).unwrap());
            for i in 0..4096 {
                let place = [i % 16, i / 16 % 16, i / 256].map(|k| f64::from(k) * 0.13 - 0.4);
                assert_eq!(mesh.colour(&mesh.nearest(DVec3::from(place))), Some([bright; 3]));
            }
        }
    }

    /// Inside and deeper than the colours reach there is another one; outside there is none.
    #[test]
    fn what_lies_below() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = TriangleMesh::new(corners.to_vec(), triangles, Some(vec![[0.5; 3]; 4])).unwrap();
        let mesh = Arc::new(MeshDistance::new(mesh, Holes::Refuse).unwrap());
        let below = Below { depth: 0.1, colour: [1.0, 0.0, 0.0] };
        let source = MeshColours::new(mesh, Arc::default(), Lookup::Filtered, 0.1).unwrap().with_below(Some(below));
        let mut points = Points::new(DVec3::ZERO);
        [[0.2; 3], [0.05, 0.2, 0.2], [-0.5; 3]].iter().for_each(|at| points.push(Vec3::from(*at)));
        let mut out = [[0.0; 3]; BATCH];
        source.sampler().sample(&points, &mut out);
        assert_eq!(out[..3], [[1.0, 0.0, 0.0], [0.5; 3], [0.5; 3]]);
    }

    /// A tetrahedron with the corner positions as colours: the colour at a foot is the foot.
    #[test]
    fn colour_of_the_foot() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let colours = corners.map(|p| p.as_vec3().to_array()).to_vec();
        let mesh = TriangleMesh::new(corners.to_vec(), triangles, Some(colours)).unwrap();
        let mesh = Arc::new(MeshDistance::new(mesh, Holes::Refuse).unwrap());
        let source = MeshColours::new(mesh.clone(), Arc::default(), Lookup::Filtered, 0.1).unwrap();
        let mut sampler = source.sampler();
        let mut points = Points::new(DVec3::ZERO);
        for i in 0..512 {
            points.push(Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) * 0.2 - 0.5);
        }
        let mut out = [[0.0; 3]; BATCH];
        sampler.enter(&Aabb::new(DVec3::splat(-0.5), DVec3::splat(1.0)));
        sampler.sample(&points, &mut out);
        sampler.leave();
        for (i, colour) in out.into_iter().enumerate() {
            let foot = mesh.nearest(points.position(i)).point.as_vec3();
            assert!(Vec3::from(colour).distance(foot) < 1e-6, "{colour:?} {foot}");
        }
    }
}

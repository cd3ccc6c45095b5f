//! Primitive solids, each in its own space with its middle at the origin, positive inside.
//!
//! Lengths are world units and are taken as given: a negative or zero length makes a solid without inside.

use glam::DVec3;

use super::facts::Facts;
use super::graph::{Graph, Node};
use super::op::{Binary, Unary};
use super::{Aabb, Slope};

fn centred(half: DVec3) -> Option<Aabb> {
    let half = half.max(DVec3::ZERO);
    Some(Aabb::new(-half, half))
}

impl Graph {
    /// `√(x² + y²)`.
    pub fn radius_about_z(&mut self) -> Node {
        let (x, y) = (self.x(), self.y());
        self.length(&[x, y])
    }

    /// The length of a vector given by its components.
    pub fn length(&mut self, components: &[Node]) -> Node {
        let mut sum = self.constant(0.0);
        for &component in components {
            let square = self.square(component);
            sum = self.add(sum, square);
        }
        self.sqrt(sum)
    }

    /// `offset − value`.
    fn less(&mut self, offset: f64, value: Node) -> Node {
        self.unary(Unary::Linear { scale: -1.0, offset }, value)
    }

    /// A ball: the exact distance.
    pub fn sphere(&mut self, radius: f64) -> Node {
        let position = [self.x(), self.y(), self.z()];
        let distance = self.length(&position);
        let node = self.less(radius, distance);
        self.declare(node, Facts::distance(centred(DVec3::splat(radius))))
    }

    /// The half-space opposite to `normal`: `normal · p ≤ offset`. The normal need not have unit length; one of
    /// no length gives all or nothing.
    pub fn half_space(&mut self, normal: DVec3, offset: f64) -> Node {
        let unit = normal.normalize_or_zero();
        self.affine(-unit, offset)
    }

    /// `|normal · p| ≤ thickness / 2`.
    pub fn slab(&mut self, normal: DVec3, thickness: f64) -> Node {
        let unit = normal.normalize_or_zero();
        let (above, below) = (self.affine(-unit, thickness / 2.0), self.affine(unit, thickness / 2.0));
        let node = self.binary(Binary::Min, above, below);
        self.declare(node, Facts::distance(None))
    }

    /// A box by its edge lengths: the exact distance.
    pub fn cuboid(&mut self, edges: DVec3) -> Node {
        let [x, y, z] = [(DVec3::X, edges.x), (DVec3::Y, edges.y), (DVec3::Z, edges.z)]
            .map(|(normal, edge)| self.slab(normal, edge));
        let xy = self.binary(Binary::Corner, x, y);
        let node = self.binary(Binary::Corner, xy, z);
        self.declare(node, Facts::distance(centred(edges / 2.0)))
    }

    /// An ellipsoid by its half axes. Not a distance: `(1 − |p/r|)` times the least half axis, never steeper
    /// than 1.
    pub fn ellipsoid(&mut self, radii: DVec3) -> Node {
        if radii.min_element() <= 0.0 {
            return self.constant(-1.0);
        }
        let scaled = [(DVec3::X, radii.x), (DVec3::Y, radii.y), (DVec3::Z, radii.z)]
            .map(|(axis, radius)| self.affine(axis / radius, 0.0));
        let length = self.length(&scaled);
        let least = radii.min_element();
        let node = self.unary(Unary::Linear { scale: -least, offset: least }, length);
        self.declare(node, Facts::new(centred(radii), Slope::Lipschitz(1.0 + 1e-9)))
    }

    /// A cylinder about z: the exact distance.
    pub fn cylinder(&mut self, radius: f64, height: f64) -> Node {
        let across = self.radius_about_z();
        let side = self.less(radius, across);
        let caps = self.slab(DVec3::Z, height);
        let node = self.binary(Binary::Corner, side, caps);
        self.declare(node, Facts::distance(centred(DVec3::new(radius, radius, height / 2.0))))
    }

    /// A torus about z: `major` from the middle to the middle of the tube, `minor` the tube's radius. The exact
    /// distance where the tube does not meet itself.
    pub fn torus(&mut self, major: f64, minor: f64) -> Node {
        let across = self.radius_about_z();
        let from_ring = self.unary(Unary::Linear { scale: 1.0, offset: -major }, across);
        let z = self.z();
        let distance = self.length(&[from_ring, z]);
        let node = self.less(minor, distance);
        let slope = Slope::Exact { outside: true, inside: minor <= major };
        let reach = major + minor;
        self.declare(node, Facts::new(centred(DVec3::new(reach, reach, minor)), slope))
    }

    /// A capsule along z: all within `radius` of a segment of the given length. The exact distance.
    pub fn capsule(&mut self, radius: f64, length: f64) -> Node {
        let [x, y, z] = [self.x(), self.y(), self.z()];
        let from_middle = self.abs(z);
        let past_end = self.unary(Unary::Linear { scale: 1.0, offset: -length / 2.0 }, from_middle);
        let zero = self.constant(0.0);
        let along = self.binary(Binary::Max, past_end, zero);
        let distance = self.length(&[x, y, along]);
        let node = self.less(radius, distance);
        self.declare(node, Facts::distance(centred(DVec3::new(radius, radius, radius + length / 2.0))))
    }

    /// A heart, its width along x, upright along z. Not a distance: the slope is 0.6 to 1.3 on the surface.
    ///
    /// The sextic (x² + 9/4·y² + z² − 1)³ = x²z³ + 9/80·y²z³ is, by its cube roots, F = z·∛(x² + 9/80·y²) −
    /// (x² + 9/4·y² + z² − 1). That has a gradient on its surface where the sextic has none, but for the dent and
    /// the tip, where the root is infinitely steep; [`SOFTNESS`] under the root rounds them.
    pub fn heart(&mut self, width: f64) -> Node {
        /// Added under the cube root. Less: sharper dent and tip, thinner than a voxel of a usual grid; more: the
        /// two lobes melt into one.
        const SOFTNESS: f64 = 1e-3;
        /// Half the extents of the surface along x and y, and its ends along z.
        const REACH: [f64; 2] = [1.112232079605079, 0.672852760108552];
        const ENDS: [f64; 2] = [-1.0, 1.171216502998138];
        /// The mean slope of F on the surface.
        const STEEPNESS: f64 = 2.5;

        if width <= 0.0 {
            return self.constant(-1.0);
        }
        let scale = width / 2.0 / REACH[0];
        let x = self.affine(DVec3::X / scale, 0.0);
        let y = self.affine(DVec3::Y / scale, 0.0);
        let z = self.affine(DVec3::Z / scale, (ENDS[0] + ENDS[1]) / 2.0);
        let [x2, y2, z2] = [x, y, z].map(|coordinate| self.square(coordinate));

        let flat = self.unary(Unary::Linear { scale: 9.0 / 80.0, offset: SOFTNESS }, y2);
        let radicand = self.add(x2, flat);
        let root = self.unary(Unary::Cbrt, radicand);
        let root = self.unary(Unary::Linear { scale: 1.0, offset: -SOFTNESS.cbrt() }, root);
        let lobes = self.mul(z, root);

        let depth = self.unary(Unary::Linear { scale: 9.0 / 4.0, offset: -1.0 }, y2);
        let round = self.add(x2, z2);
        let ball = self.add(round, depth);
        let heart = self.sub(lobes, ball);
        let node = self.unary(Unary::Linear { scale: scale / STEEPNESS, offset: 0.0 }, heart);
        let half = DVec3::new(REACH[0], REACH[1], (ENDS[1] - ENDS[0]) / 2.0) * scale;
        self.declare(node, Facts::new(centred(half * (1.0 + 1e-12)), Slope::Unknown))
    }
}

//! Arithmetic, set operations, blends, offset and shell.

use std::collections::BTreeMap;

use super::facts::Facts;
use super::graph::{Graph, Node};
use super::leaf::{Affine, Quadric};
use super::op::{Binary, Op, Unary};
use super::{Aabb, Side, Slope};

/// Which functions stand for union and intersection. All have the same zero set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SetSystem {
    /// System R₀, `a + b ± √(a² + b²)`: smooth but where both operands are zero.
    #[default]
    R0,
    /// Maximum and minimum: keep exact distances exact on one side.
    MinMax,
    /// System R_m, R₀ times `(a² + b²)^(m/2)`: m times differentiable also where both operands are zero.
    Rm {
        /// m, at least 1.
        order: u32,
    },
    /// Rvachev's normalised system of class Cⁿ⁻¹: as steep on the surface as its operands.
    Cn {
        /// n, at least 2.
        order: u32,
    },
}

impl SetSystem {
    fn union(self) -> Binary {
        match self {
            Self::R0 => Binary::Union,
            Self::MinMax => Binary::Max,
            Self::Rm { order } => Binary::RmUnion { order },
            Self::Cn { order } => Binary::CnUnion { order },
        }
    }

    fn intersection(self) -> Binary {
        match self {
            Self::R0 => Binary::Intersection,
            Self::MinMax => Binary::Min,
            Self::Rm { order } => Binary::RmIntersection { order },
            Self::Cn { order } => Binary::CnIntersection { order },
        }
    }
}

/// How the greater of two values is rounded where they are near one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// A polynomial of second degree.
    Quadratic,
    /// A polynomial of third degree.
    Cubic,
    /// A piece of a circle.
    Circular,
    /// Exponentials: felt everywhere, if faintly, and the same for any order of several.
    Exponential,
}

/// What holds a blend within bounds: it vanishes where this field is not positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlendBounds {
    /// The bounding solid f₃.
    pub solid: Node,
    /// Its weight a₃, not zero.
    pub weight: f64,
}

/// Material added (or, where `amount` is negative, taken away) where two operands meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// a₀: the value added where both operands are zero.
    pub amount: f64,
    /// a₁ and a₂, not zero: how far from each operand's surface the blend reaches.
    pub reach: [f64; 2],
    /// Bounds of the blend; without them it reaches everywhere, if faintly.
    pub bounds: Option<BlendBounds>,
}

impl Graph {
    /// The sum.
    pub fn add(&mut self, a: Node, b: Node) -> Node {
        self.binary(Binary::Add, a, b)
    }

    /// The difference of values (of solids: [`Graph::difference`]).
    pub fn sub(&mut self, a: Node, b: Node) -> Node {
        self.binary(Binary::Sub, a, b)
    }

    /// The product.
    pub fn mul(&mut self, a: Node, b: Node) -> Node {
        self.binary(Binary::Mul, a, b)
    }

    /// The quotient.
    pub fn div(&mut self, a: Node, b: Node) -> Node {
        self.binary(Binary::Div, a, b)
    }

    /// The negated value: the complement of a solid.
    pub fn neg(&mut self, a: Node) -> Node {
        self.linear(a, -1.0, 0.0)
    }

    /// `scale · a + offset`.
    pub fn linear(&mut self, a: Node, scale: f64, offset: f64) -> Node {
        self.unary(Unary::Linear { scale, offset }, a)
    }

    /// The absolute value.
    pub fn abs(&mut self, a: Node) -> Node {
        self.unary(Unary::Abs, a)
    }

    /// The square.
    pub fn square(&mut self, a: Node) -> Node {
        self.unary(Unary::Square, a)
    }

    /// The square root.
    pub fn sqrt(&mut self, a: Node) -> Node {
        self.unary(Unary::Sqrt, a)
    }

    /// The lesser value.
    pub fn min(&mut self, a: Node, b: Node) -> Node {
        self.binary(Binary::Min, a, b)
    }

    /// The greater value.
    pub fn max(&mut self, a: Node, b: Node) -> Node {
        self.binary(Binary::Max, a, b)
    }

    /// `3a² − 2a³` of a value held to 0..1.
    pub fn smooth(&mut self, a: Node) -> Node {
        self.unary(Unary::Smooth, a)
    }

    /// The greatest whole number that is not above a value; jumps.
    pub fn floor(&mut self, a: Node) -> Node {
        self.unary(Unary::Floor, a)
    }

    /// The angle of the direction (x, y) from the x axis, −π to π.
    pub fn atan2(&mut self, y: Node, x: Node) -> Node {
        self.binary(Binary::Atan2, y, x)
    }

    /// The sine of an angle in radians.
    pub fn sin(&mut self, a: Node) -> Node {
        self.unary(Unary::Sin, a)
    }

    /// The cosine of an angle in radians.
    pub fn cos(&mut self, a: Node) -> Node {
        self.unary(Unary::Cos, a)
    }

    /// The exponential.
    pub fn exp(&mut self, a: Node) -> Node {
        self.unary(Unary::Exp, a)
    }

    /// A power; not a number where the base is negative and the exponent not whole.
    pub fn pow(&mut self, base: Node, exponent: f64) -> Node {
        let exponent = self.constant(exponent);
        self.binary(Binary::Pow, base, exponent)
    }

    /// The intersection of two solids whose surfaces meet at right angles: the exact distance where both are.
    pub fn corner(&mut self, a: Node, b: Node) -> Node {
        self.binary(Binary::Corner, a, b)
    }

    /// The union of solids; of none, nothing (−1 everywhere).
    pub fn union(&mut self, system: SetSystem, solids: &[Node]) -> Node {
        self.balanced(system.union(), solids).unwrap_or_else(|| self.constant(-1.0))
    }

    /// The intersection of solids; of none, everything (1 everywhere).
    pub fn intersection(&mut self, system: SetSystem, solids: &[Node]) -> Node {
        self.balanced(system.intersection(), solids).unwrap_or_else(|| self.constant(1.0))
    }

    /// The first solid without the others.
    pub fn difference(&mut self, system: SetSystem, from: Node, others: &[Node]) -> Node {
        if others.is_empty() {
            return from;
        }
        let taken = self.union(system, others);
        let rest = self.neg(taken);
        self.intersection(system, &[from, rest])
    }

    /// An operation over many operands as a balanced tree: pruning and R₀'s attenuation of values both want it
    /// shallow.
    fn balanced(&mut self, operation: Binary, operands: &[Node]) -> Option<Node> {
        match operands {
            [] => None,
            [one] => Some(*one),
            _ => {
                let (first, second) = operands.split_at(operands.len().div_ceil(2));
                let (first, second) = (self.balanced(operation, first)?, self.balanced(operation, second)?);
                Some(self.binary(operation, first, second))
            }
        }
    }

    /// The R₀ union of two solids with a blend where they meet.
    pub fn blend_union(&mut self, a: Node, b: Node, blend: &Blend) -> Node {
        self.blended(Binary::Union, a, b, blend)
    }

    /// The R₀ intersection of two solids with a blend where they meet.
    pub fn blend_intersection(&mut self, a: Node, b: Node, blend: &Blend) -> Node {
        self.blended(Binary::Intersection, a, b, blend)
    }

    /// Set operation plus a₀·disp: the bounded blend with r₁² = (f₁/a₁)² + (f₂/a₂)² and r₂² = (f₃/a₃)² inside the
    /// bounds, or the classic unbounded a₀ / (1 + r₁²).
    fn blended(&mut self, operation: Binary, a: Node, b: Node, blend: &Blend) -> Node {
        let base = self.binary(operation, a, b);
        let near = self.sum_of_scaled_squares(a, b, blend.reach);
        let known = self.facts(base);
        let (displacement, facts) = match blend.bounds {
            None => {
                let grown = self.linear(near, 1.0, 1.0);
                // No more is added than the amount.
                let most = Unary::Linear { scale: 1.0, offset: blend.amount };
                (self.unary(Unary::Recip, grown), most.facts([known]))
            }
            Some(BlendBounds { solid, weight }) => {
                let zero = self.constant(0.0);
                let inside = self.max(solid, zero);
                let inside = self.linear(inside, 1.0 / weight, 0.0);
                let depth = self.square(inside);
                // Nothing is added outside of the bounds.
                let bounds = known.bounds.zip(self.facts(solid).bounds).map(|(a, b)| a.union(b));
                (self.binary(Binary::Displacement, near, depth), Facts { bounds, ..known })
            }
        };
        let added = self.linear(displacement, blend.amount, 0.0);
        let node = self.add(base, added);
        self.declare(node, Facts { slope: Slope::Unknown, ..facts })
    }

    fn sum_of_scaled_squares(&mut self, a: Node, b: Node, reach: [f64; 2]) -> Node {
        let [first, second] = [(a, reach[0]), (b, reach[1])].map(|(node, reach)| {
            let scaled = self.linear(node, 1.0 / reach, 0.0);
            self.square(scaled)
        });
        self.add(first, second)
    }

    /// The solid grown by a distance (shrunk where that is negative), as exactly as its value is the distance.
    pub fn offset(&mut self, solid: Node, distance: f64) -> Node {
        let known = self.facts(solid);
        let mut facts = Unary::Linear { scale: 1.0, offset: distance }.facts([known]);
        if self.stays_convex(solid, distance) {
            facts = Facts::distance(known.bounds.map(|bounds| bounds.grown(distance)));
        }
        let node = self.shifted(solid, 1.0, distance);
        self.declare(node, facts)
    }

    /// Whether a solid is an exact corner of slabs, balls and cylinders, of which growing by a distance leaves something:
    /// its offsets are exact on both sides.
    fn stays_convex(&self, solid: Node, distance: f64) -> bool {
        if !matches!(self.slope(solid), Slope::Exact { outside: true, inside: true }) {
            return false;
        }
        let form = |node: u32| match self.ops[node as usize] {
            Op::Affine(index) => Some(self.affines[index as usize]),
            _ => None,
        };
        let is_unit = |form: &Affine| (form.slope.length_squared() - 1.0).abs() < 1e-12;
        let mut open = vec![solid];
        while let Some(part) = open.pop() {
            let is_left = match self.op(part) {
                Op::Binary(Binary::Corner, a, b) => {
                    open.extend([Node(a), Node(b)]);
                    true
                }
                Op::Binary(Binary::Min, a, b) => form(a).zip(form(b)).is_some_and(|(above, below)| {
                    let is_slab = above.slope == -below.slope && is_unit(&above);
                    is_slab && above.constant + below.constant + 2.0 * distance > 0.0
                }),
                Op::Unary(Unary::Linear { scale: -1.0, offset }, root) => {
                    offset + distance > 0.0 && self.is_length(Node(root))
                }
                _ => false,
            };
            if !is_left {
                return false;
            }
        }
        true
    }

    /// Whether a node is the distance from a point, or from a straight line.
    fn is_length(&self, node: Node) -> bool {
        let Op::Unary(Unary::Sqrt, square) = self.op(node) else { return false };
        let Op::Quadric(index) = self.ops[square as usize] else { return false };
        let Quadric { constant, terms } = &self.quadrics[index as usize];
        let forms = || terms.iter().filter(|(weight, _)| *weight != 0.0);
        let are_right = |(i, (weight, one)): (usize, &(f64, Affine))| {
            *weight == 1.0
                && forms().enumerate().all(|(j, (_, two))| {
                    let wanted = if i == j { 1.0 } else { 0.0 };
                    (one.slope.dot(two.slope) - wanted).abs() < 1e-12
                })
        };
        *constant == 0.0 && forms().count() >= 2 && forms().enumerate().all(are_right)
    }

    /// The solid grown by another node's value, which may differ from place to place and is ≤ 0 throughout where the
    /// solid only shrinks (`inward`). `bounds` is believed, as in [`Self::bounded`].
    pub fn displaced(&mut self, solid: Node, by: Node, inward: bool, bounds: Aabb) -> Node {
        let node = self.distributed(solid, false, inward, |graph, operand| graph.add(operand, by));
        self.bounded(node, bounds)
    }

    /// The skin of a solid: all within half the thickness of its surface, as exactly as its value is the distance.
    pub fn shell(&mut self, solid: Node, thickness: f64) -> Node {
        self.wall(solid, solid, thickness)
    }

    /// The same by two values of one sign: one is the distance outside of the solid, one inside.
    pub fn wall(&mut self, outside: Node, inside: Node, thickness: f64) -> Node {
        let half = thickness / 2.0;
        let (inner, outer) = (self.shifted(inside, -1.0, half), self.offset(outside, half));
        let exact = self.slope(outside).is_exact(Side::Outside) && self.slope(inside).is_exact(Side::Inside);
        let slope = if exact { Slope::Exact { outside: true, inside: false } } else { Slope::Unknown };
        let node = self.min(outer, inner);
        self.declare(node, Facts::new(None, slope))
    }

    /// The greater of two values, rounded where they differ by less than `width`: the union of two distances, blended.
    pub fn smooth_max(&mut self, kernel: Kernel, width: f64, a: Node, b: Node) -> Node {
        let operation = match kernel {
            Kernel::Quadratic => Binary::SmoothQuadratic { width },
            Kernel::Cubic => Binary::SmoothCubic { width },
            Kernel::Circular => Binary::SmoothCircular { width },
            // As much is added in the middle as by the polynomial of second degree.
            Kernel::Exponential => Binary::SmoothExponential { width: width / 4.0 },
        };
        self.binary(operation, a, b)
    }

    /// `scale · node + offset`, scale ±1.
    fn shifted(&mut self, node: Node, scale: f64, offset: f64) -> Node {
        let inward = scale > 0.0 && offset < 0.0;
        self.distributed(node, scale < 0.0, inward, |graph, operand| graph.linear(operand, scale, offset))
    }

    /// What `shift` makes of a node, taken below minima and maxima: values are the same, and the smooth branches stay
    /// the operands of a set operation. Shrinking takes corners along too: the inset of an exact corner is the exact
    /// corner of the insets. `turned`: whether greater values become lesser ones.
    fn distributed(
        &mut self,
        node: Node,
        turned: bool,
        inward: bool,
        mut shift: impl FnMut(&mut Self, Node) -> Node,
    ) -> Node {
        let opens = |op: Op| match op {
            Op::Binary(operation @ (Binary::Min | Binary::Max), a, b) => Some((operation, a, b)),
            Op::Binary(Binary::Corner, a, b) if inward => Some((Binary::Corner, a, b)),
            _ => None,
        };
        // Arguments come before their operation, so going up in order needs no recursion.
        let mut reached = vec![node.0];
        let mut moved = BTreeMap::new();
        while let Some(next) = reached.pop() {
            if moved.insert(next, Node(next)).is_none()
                && let Some((_, a, b)) = opens(self.ops[next as usize])
            {
                reached.extend([a, b]);
            }
        }
        let order: Vec<u32> = moved.keys().copied().collect();
        for index in order {
            let made = match opens(self.ops[index as usize]) {
                Some((operation, a, b)) => {
                    let operation = if turned { operation.turned() } else { operation };
                    self.binary(operation, moved[&a], moved[&b])
                }
                None => shift(self, Node(index)),
            };
            moved.insert(index, made);
        }
        moved[&node.0]
    }

    /// States a box that the solid keeps within, where construction cannot tell (a formula). It is believed, and
    /// clips nothing.
    pub fn bounded(&mut self, solid: Node, bounds: Aabb) -> Node {
        self.declare(solid, Facts::new(Some(bounds), Slope::Unknown))
    }

    /// States that a node is the signed distance to the surface of a solid in a box. It is believed.
    pub fn exact(&mut self, solid: Node, bounds: Aabb) -> Node {
        self.declare(solid, Facts::distance(Some(bounds)))
    }

    /// States that a node is nowhere steeper. It is believed.
    pub fn no_steeper(&mut self, node: Node, bound: f64) -> Node {
        self.declare(node, Facts::new(None, Slope::Lipschitz(bound)))
    }

    /// Whether a node is the same for every z.
    pub fn is_flat(&self, node: Node) -> bool {
        let mut seen = std::collections::BTreeSet::new();
        let mut open = vec![node.0];
        while let Some(next) = open.pop() {
            if !seen.insert(next) {
                continue;
            }
            match self.ops[next as usize] {
                Op::Affine(index) if self.affines[index as usize].slope.z != 0.0 => return false,
                Op::Quadric(index)
                    if self.quadrics[index as usize].terms.iter().any(|(_, form)| form.slope.z != 0.0) =>
                {
                    return false;
                }
                // Other fields of the plane are read at some z, whatever it is.
                Op::External { at: [x, y, _], .. } => open.extend([x, y]),
                op => op.arguments(|argument| open.push(argument)),
            }
        }
        true
    }

    /// States what a node's value says about distance, of a solid in a box where there is one. It is believed.
    pub fn sloped(&mut self, solid: Node, slope: Slope, bounds: Option<Aabb>) -> Node {
        self.declare(solid, Facts::new(bounds, slope))
    }

    /// States how a solid falls outside of its known box: it is no more than −`fall` times the distance to that. It is
    /// believed.
    pub fn falling(&mut self, solid: Node, fall: f64) -> Node {
        let facts = Facts { fall, ..self.facts(solid) };
        self.declare(solid, facts)
    }
}

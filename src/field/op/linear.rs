//! `scale · value + offset`: negation, scaling and offset in one.

use super::super::facts::exact;
use super::*;

impl Operation<1> for Linear {
    fn value(self, [a]: [f64; 1]) -> f64 {
        a * self.scale + self.offset
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        (a * self.scale as f32 + self.offset as f32, [self.scale as f32])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        let Self { scale, offset } = self;
        if scale == 0.0 || a == Interval::ZERO {
            return Interval::checked(offset, offset);
        }
        let scaled = match scale {
            1.0 => a,
            -1.0 => -a,
            _ if scale > 0.0 => Interval::outward(a.lo * scale, a.hi * scale),
            _ => Interval::outward(a.hi * scale, a.lo * scale),
        };
        scaled + Interval::new(offset, offset)
    }

    fn facts(self, [a]: [Facts; 1]) -> Facts {
        let Self { scale, offset } = self;
        let slope = match a.slope {
            Slope::Exact { outside, inside } if scale.abs() == 1.0 => {
                let (outside, inside) = if scale > 0.0 { (outside, inside) } else { (inside, outside) };
                // Growing an exact distance leaves it exact outside only, shrinking inside only: creases of the
                // other side turn round.
                exact(outside && offset >= 0.0, inside && offset <= 0.0)
            }
            _ => Facts::steep(a.steepness().map(|bound| bound * scale.abs())).slope,
        };
        if scale <= 0.0 {
            return Facts::new(None, slope);
        }
        let fall = scale * a.fall;
        let bounds = match a.bounds {
            _ if offset <= 0.0 => a.bounds,
            // F ≥ −offset/scale lies within that over the fall.
            Some(bounds) if fall > 0.0 => Some(bounds.grown(offset / fall)),
            _ => None,
        };
        Facts { bounds, slope, fall }
    }

    fn simplified(self, graph: &mut Graph, [a]: [Node; 1]) -> Option<Node> {
        let Self { scale, offset } = self;
        if scale == 0.0 {
            return Some(graph.constant(offset));
        }
        match graph.op(a) {
            _ if scale == 1.0 && offset == 0.0 => Some(a),
            Op::Affine(index) => {
                let form = graph.affines[index as usize].linear(scale, offset);
                Some(graph.affine_leaf(form))
            }
            Op::Quadric(index) => {
                let quadric = graph.quadrics[index as usize].linear(scale, offset);
                Some(graph.quadric_leaf(quadric))
            }
            Op::Unary(Unary::Linear { scale: first, offset: shift }, value) => {
                Some(graph.linear(Node(value), scale * first, scale * shift + offset))
            }
            // An offset polyhedron is a polyhedron: its faces stay branches of their own.
            Op::Binary(side @ (Binary::Min | Binary::Max), first, second) if is_polyhedral(graph, a) => {
                let [first, second] = [first, second].map(|operand| graph.linear(Node(operand), scale, offset));
                Some(graph.binary(if scale > 0.0 { side } else { side.turned() }, first, second))
            }
            _ => None,
        }
    }
}

/// Whether a node is made of a few planes by min and max alone.
fn is_polyhedral(graph: &Graph, node: Node) -> bool {
    /// Operations looked at: more planes than half of this are rewritten at a cost that nobody wants.
    const MOST: usize = 128;
    let mut stack = vec![node];
    for _ in 0..MOST {
        match stack.pop().map(|node| graph.op(node)) {
            None => return true,
            Some(Op::Affine(_)) => {}
            Some(Op::Binary(Binary::Min | Binary::Max, a, b)) => stack.extend([Node(a), Node(b)]),
            Some(_) => return false,
        }
    }
    false
}

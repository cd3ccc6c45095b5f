//! The operations that an expression is made of.

/// An operation on one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unary {
    /// `scale · value + offset`: negation, scaling and offset in one.
    Linear {
        scale: f64,
        offset: f64,
    },
    Abs,
    Square,
    Sqrt,
    Cbrt,
    Recip,
    /// An exponent of at least 3.
    Powi(u32),
    Sin,
    Cos,
    Exp,
    Log,
    Floor,
    Sign,
    /// `3v² − 2v³` of the value clamped to 0..1.
    Smooth,
}

/// An operation on two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Min,
    Max,
    /// R₀ union.
    Union,
    /// R₀ intersection.
    Intersection,
    /// The exact intersection of two exact distances whose surfaces meet at right angles.
    Corner,
    /// The bounded blend's disp of (r₁², r₂²).
    Displacement,
    Pow,
    /// The angle of (x, y) from (y, x).
    Atan2,
}

impl Binary {
    /// Whether the zero set lies in those of the two operands, as for any union or intersection.
    pub fn is_set_operation(self) -> bool {
        matches!(self, Self::Min | Self::Max | Self::Union | Self::Intersection | Self::Corner)
    }

    pub fn is_union(self) -> bool {
        matches!(self, Self::Max | Self::Union)
    }

    /// The other of min and max where greater values become lesser ones; any other operation as it is.
    pub fn turned(self) -> Self {
        match self {
            Self::Min => Self::Max,
            Self::Max => Self::Min,
            other => other,
        }
    }
}

/// One operation; arguments are indices of earlier operations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
    /// An affine form of the position, by its index in the table.
    Affine(u32),
    /// A sum of squares of affine forms, by its index in the table.
    Quadric(u32),
    /// Another field read at a position given by three values.
    External {
        leaf: u32,
        at: [u32; 3],
    },
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
}

impl Op {
    /// The operation with its arguments renamed.
    pub fn renamed(self, mut name: impl FnMut(u32) -> u32) -> Self {
        match self {
            Self::Affine(_) | Self::Quadric(_) => self,
            Self::External { leaf, at } => Self::External { leaf, at: at.map(name) },
            Self::Unary(operation, a) => Self::Unary(operation, name(a)),
            Self::Binary(operation, a, b) => {
                let a = name(a);
                Self::Binary(operation, a, name(b))
            }
        }
    }

    /// Calls `visit` with each argument.
    pub fn arguments(self, mut visit: impl FnMut(u32)) {
        match self {
            Self::Affine(_) | Self::Quadric(_) => {}
            Self::External { at, .. } => at.into_iter().for_each(visit),
            Self::Unary(_, a) => visit(a),
            Self::Binary(_, a, b) => {
                visit(a);
                visit(b);
            }
        }
    }

    /// The operation as words: equal for equal operations only.
    pub fn key(self) -> [u64; 4] {
        match self {
            Self::Affine(index) => [0, u64::from(index), 0, 0],
            Self::Quadric(index) => [1, u64::from(index), 0, 0],
            Self::External { leaf, at } => {
                [2 | u64::from(leaf) << 32, u64::from(at[0]), u64::from(at[1]), u64::from(at[2])]
            }
            Self::Unary(operation, a) => {
                let a = u64::from(a);
                match operation {
                    Unary::Linear { scale, offset } => [3, a, (scale + 0.0).to_bits(), (offset + 0.0).to_bits()],
                    Unary::Powi(exponent) => [4, a, u64::from(exponent), 0],
                    Unary::Abs => [5, a, 0, 0],
                    Unary::Square => [5, a, 1, 0],
                    Unary::Sqrt => [5, a, 2, 0],
                    Unary::Recip => [5, a, 3, 0],
                    Unary::Sin => [5, a, 4, 0],
                    Unary::Cos => [5, a, 5, 0],
                    Unary::Exp => [5, a, 6, 0],
                    Unary::Log => [5, a, 7, 0],
                    Unary::Floor => [5, a, 8, 0],
                    Unary::Sign => [5, a, 9, 0],
                    Unary::Smooth => [5, a, 10, 0],
                    Unary::Cbrt => [5, a, 11, 0],
                }
            }
            Self::Binary(operation, a, b) => [6, operation as u64, u64::from(a), u64::from(b)],
        }
    }
}

/// Marks the operations that one depends on, and itself.
pub(super) fn mark_needed(ops: &[Op], root: u32, needed: &mut Vec<bool>) {
    needed.clear();
    needed.resize(ops.len(), false);
    needed[root as usize] = true;
    for index in (0..=root as usize).rev() {
        if needed[index] {
            ops[index].arguments(|argument| needed[argument as usize] = true);
        }
    }
}

//! The operations that an expression is made of: one file for each, and one line in the lists below.
//!
//! A file holds all that is known of its operation, as an [`Operation`]; nothing else needs to name it. Lists make an
//! enum, as small as programs want it, that calls the operation it stands for.

use super::facts::Facts;
use super::formula::{any_number, fold, function};
use super::graph::{Graph, Node};
use super::lane_math as math;
use super::{Interval, Slope};

pub(super) use super::formula::Function;

/// One operation on `N` values, by all that evaluators ask.
pub(super) trait Operation<const N: usize>: Copy {
    const NATURE: Nature = Nature::PLAIN;

    /// The functions of formulas that are this operation.
    const FUNCTIONS: &'static [Function] = &[];

    /// The judge of every faster way, and the end points of bounds.
    fn value(self, arguments: [f64; N]) -> f64;

    /// The value in one lane of a batch, and its derivatives by the arguments; compilers leave out what batches of values
    /// do not ask for. Inlined always: see [`Visitor`].
    fn slopes(self, arguments: [f32; N]) -> (f32, [f32; N]);

    /// Bounds of the value, rounded outward.
    fn bounds(self, arguments: [Interval; N]) -> Interval;

    /// What is known of the value from what is known of the arguments.
    fn facts(self, _arguments: [Facts; N]) -> Facts {
        Facts::NONE
    }

    /// A node of the same value that says more, where there is one. Arguments that are constants are none of its concern:
    /// not all of them are.
    fn simplified(self, _graph: &mut Graph, _arguments: [Node; N]) -> Option<Node> {
        None
    }

    /// What the operation is to the last bit, throughout such arguments.
    fn same(self, _arguments: [Interval; N]) -> Same {
        Same::Itself
    }

    /// Visits the operation; in several cases, where loops are the faster for what is known in each.
    #[inline(always)]
    fn visit(self, visitor: impl Visitor<N>) {
        visitor.visit(self);
    }
}

/// What is done with an operation whose type is known: each has code of its own. Inlined always, as lanes are: what is not
/// inlined into a function as large as a batch loop is compiled for the narrowest vectors.
pub(super) trait Visitor<const N: usize> {
    fn visit(self, operation: impl Operation<N>);
}

/// What there is to know of an operation at a glance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Nature {
    /// Whether the value may jump.
    pub jumps: bool,
    /// Whether programs may get shorter in some region: the value may be that of an argument throughout, or zero.
    pub shortens: bool,
    /// Whether it is one of its arguments on either side of a crease; of a single one, that or its negation.
    pub creases: bool,
    /// Whether it stands for a union or an intersection: its zero set lies in those of its arguments.
    pub set: Option<Set>,
}

impl Nature {
    pub const PLAIN: Self = Self { jumps: false, shortens: false, creases: false, set: None };
    pub const UNION: Self = Self { shortens: true, set: Some(Set::Union), ..Self::PLAIN };
    pub const INTERSECTION: Self = Self { shortens: true, set: Some(Set::Intersection), ..Self::PLAIN };
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Set {
    Union,
    Intersection,
}

/// What an operation equals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Same {
    Itself,
    Argument(usize),
    Negated(usize),
}

/// Makes an enum of operations: by the file, the name and, where there are parameters, an example of them for tests. (The
/// first token stands for itself in the macro within.)
macro_rules! operations {
    (
        $dollar:tt $(#[$doc:meta])* $Enum:ident on $arity:literal:
        $($module:ident: $Name:ident $({ $($field:ident: $type:ty = $example:expr),+ })?,)+
    ) => {
        $(
            mod $module;

            #[derive(Clone, Copy)]
            struct $Name {
                $($($field: $type),+)?
            }
        )+

        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(super) enum $Enum {
            $($Name $({ $($field: $type),+ })?),+
        }

        macro_rules! each {
            ($dollar given:expr, $dollar operation:ident => $dollar body:expr) => {
                match $dollar given {
                    $($Enum::$Name $({ $($field),+ })? => {
                        let $dollar operation = $Name { $($($field),+)? };
                        $dollar body
                    })+
                }
            };
        }

        impl $Enum {
            /// One of each.
            #[cfg(test)]
            pub const ALL: &[Self] = &[$(Self::$Name $({ $($field: $example),+ })?),+];

            const FUNCTIONS: &[&[Function]] = &[$($Name::FUNCTIONS),+];

            pub fn nature(self) -> Nature {
                match self {
                    $(Self::$Name { .. } => $Name::NATURE),+
                }
            }

            pub fn value(self, arguments: [f64; $arity]) -> f64 {
                each!(self, operation => operation.value(arguments))
            }

            pub fn bounds(self, arguments: [Interval; $arity]) -> Interval {
                each!(self, operation => operation.bounds(arguments))
            }

            pub fn facts(self, arguments: [Facts; $arity]) -> Facts {
                each!(self, operation => operation.facts(arguments))
            }

            pub fn simplified(self, graph: &mut Graph, arguments: [Node; $arity]) -> Option<Node> {
                each!(self, operation => operation.simplified(graph, arguments))
            }

            pub fn same(self, arguments: [Interval; $arity]) -> Same {
                each!(self, operation => operation.same(arguments))
            }

            #[inline(always)]
            pub fn visit(self, visitor: impl Visitor<$arity>) {
                each!(self, operation => operation.visit(visitor))
            }

            /// The number of the operation, and its parameters.
            fn key(self) -> (u64, [u64; 2]) {
                enum Number {
                    $($Name),+
                }
                match self {
                    $(Self::$Name $({ $($field),+ })? => {
                        let parameters: &[f64] = &[$($(f64::from($field)),+)?];
                        let bits = |at: usize| parameters.get(at).map_or(0, |number| (number + 0.0).to_bits());
                        (Number::$Name as u64, [bits(0), bits(1)])
                    }),+
                }
            }
        }
    };
}

pub(super) mod choose;

operations! {
    $
    /// An operation on one value.
    Unary on 1:
    abs: Abs,
    cbrt: Cbrt,
    cos: Cos,
    exp: Exp,
    floor: Floor,
    linear: Linear { scale: f64 = -1.5, offset: f64 = 0.25 },
    log: Log,
    powi: Powi { exponent: u32 = 5 },
    recip: Recip,
    sign: Sign,
    sin: Sin,
    smooth: Smooth,
    sqrt: Sqrt,
    square: Square,
}

operations! {
    $
    /// An operation on two values.
    Binary on 2:
    add: Add,
    atan2: Atan2,
    cn_intersection: CnIntersection { order: u32 = 3 },
    cn_union: CnUnion { order: u32 = 2 },
    corner: Corner,
    displacement: Displacement,
    div: Div,
    equal: Equal,
    less: Less,
    max: Max,
    min: Min,
    mul: Mul,
    pow: Pow,
    r0_intersection: Intersection,
    r0_union: Union,
    rm_intersection: RmIntersection { order: u32 = 3 },
    rm_union: RmUnion { order: u32 = 2 },
    smooth_circular: SmoothCircular { width: f64 = 1.5 },
    smooth_cubic: SmoothCubic { width: f64 = 1.5 },
    smooth_exponential: SmoothExponential { width: f64 = 0.5 },
    smooth_quadratic: SmoothQuadratic { width: f64 = 1.5 },
    sub: Sub,
}

/// The facts of the greater of two values with something added where they are near one another, no more than `most`, and a
/// slope that is a mean of both.
fn rounded(a: Facts, b: Facts, most: f64) -> Facts {
    let steep = Facts::steep(a.steepness().zip(b.steepness()).map(|(a, b)| a.max(b)));
    let greater = Facts::union(a, b, Slope::Unknown, 1.0);
    let grown = Unary::Linear { scale: 1.0, offset: most }.facts([greater]);
    Facts { bounds: grown.bounds, slope: steep.slope, fall: grown.fall }
}

/// What that is where two values differ by more than the width in which anything is added.
fn far_apart([a, b]: [Interval; 2], width: f64) -> Same {
    match (a, b) {
        _ if b.hi + width <= a.lo => Same::Argument(0),
        _ if a.hi + width <= b.lo => Same::Argument(1),
        _ => Same::Itself,
    }
}

/// The functions of formulas that are one operation each.
pub(super) fn functions() -> impl Iterator<Item = &'static Function> {
    Unary::FUNCTIONS.iter().chain(Binary::FUNCTIONS).copied().flatten()
}

impl Binary {
    /// The other of min and max where greater values become lesser ones; any other operation as it is.
    pub fn turned(self) -> Self {
        match self {
            Self::Min => Self::Max,
            Self::Max => Self::Min,
            other => other,
        }
    }

    /// The operation with the same sign that is nowhere level where its arguments are not, of one that is.
    pub fn sided(self) -> Option<Self> {
        match self {
            Self::RmUnion { .. } => Some(Self::Max),
            Self::RmIntersection { .. } => Some(Self::Min),
            _ => None,
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
    /// A condition, the value where it is not 0, and the value where it is.
    Choose([u32; 3]),
}

impl Op {
    /// What an operation on values is like; leaves are plain.
    pub fn nature(self) -> Nature {
        match self {
            Self::Affine(_) | Self::Quadric(_) | Self::External { .. } => Nature::PLAIN,
            Self::Unary(operation, _) => operation.nature(),
            Self::Binary(operation, ..) => operation.nature(),
            Self::Choose(_) => Nature { jumps: true, shortens: true, ..Nature::PLAIN },
        }
    }

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
            Self::Choose(arguments) => Self::Choose(arguments.map(name)),
        }
    }

    /// Another operation on the same two arguments.
    pub fn with(self, operation: Binary) -> Self {
        match self {
            Self::Binary(_, a, b) => Self::Binary(operation, a, b),
            other => other,
        }
    }

    /// Calls `visit` with each argument.
    pub fn arguments(self, mut visit: impl FnMut(u32)) {
        match self {
            Self::Affine(_) | Self::Quadric(_) => {}
            Self::External { at, .. } => at.into_iter().for_each(visit),
            Self::Choose(arguments) => arguments.into_iter().for_each(visit),
            Self::Unary(_, a) => visit(a),
            Self::Binary(_, a, b) => {
                visit(a);
                visit(b);
            }
        }
    }

    /// The operation as words: equal for equal operations only.
    pub fn key(self) -> [u64; 4] {
        let pair = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
        match self {
            Self::Affine(index) => [0, u64::from(index), 0, 0],
            Self::Quadric(index) => [1, u64::from(index), 0, 0],
            Self::External { leaf, at: [x, y, z] } => [2, pair(leaf, x), pair(y, z), 0],
            Self::Unary(operation, a) => {
                let (number, [first, second]) = operation.key();
                [3 | number << 8, u64::from(a), first, second]
            }
            Self::Binary(operation, a, b) => {
                let (number, [first, second]) = operation.key();
                [4 | number << 8, pair(a, b), first, second]
            }
            Self::Choose([condition, then, other]) => [5, u64::from(condition), pair(then, other), 0],
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

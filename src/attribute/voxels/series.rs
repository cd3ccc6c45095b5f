//! Taylor series of |y|⁻ᵖ in three dimensions: their monomials, moments of voxels, and sums over many of them at once.
//!
//! A monomial's exponents α = (α₁, α₂, α₃) are written as one index; yᵅ = y₁^α₁ y₂^α₂ y₃^α₃, α! = α₁! α₂! α₃!,
//! |α| = α₁ + α₂ + α₃.

use glam::{DVec3, Vec3};

/// The greatest |α|. More: each node costs more; less: many more nodes are needed.
pub(super) const DEGREE: usize = 5;

/// How many monomials there are up to [`DEGREE`].
const MONOMIALS: usize = (DEGREE + 1) * (DEGREE + 2) * (DEGREE + 3) / 6;

/// How many numbers are summed: weights, then red, green and blue.
const SUMS: usize = 4;

/// Nodes, or points, that are computed side by side.
pub(super) const LANES: usize = 16;

/// A sum for each monomial, 1 first, by rising |α|.
pub(super) type Coefficients = [[f32; SUMS]; MONOMIALS];

/// Sums of nothing.
pub(super) const ZERO: Coefficients = [[0.0; SUMS]; MONOMIALS];

/// The exponents of each monomial.
const EXPONENTS: [[usize; 3]; MONOMIALS] = exponents();

const fn exponents() -> [[usize; 3]; MONOMIALS] {
    let (mut all, mut next, mut degree) = ([[0; 3]; MONOMIALS], 0, 0);
    while degree <= DEGREE {
        let mut x = degree + 1;
        while x > 0 {
            x -= 1;
            let mut y = degree - x + 1;
            while y > 0 {
                y -= 1;
                all[next] = [x, y, degree - x - y];
                next += 1;
            }
        }
        degree += 1;
    }
    all
}

/// The monomial that has exponents.
const fn monomial(exponents: [usize; 3]) -> usize {
    let [x, y, z] = exponents;
    let (degree, rest) = (x + y + z, y + z);
    degree * (degree + 1) * (degree + 2) / 6 + rest * (rest + 1) / 2 + z
}

/// |α|.
const fn degree(monomial: usize) -> usize {
    let [x, y, z] = EXPONENTS[monomial];
    x + y + z
}

/// How many monomials have a product with each that is no higher than [`DEGREE`]: the first ones.
const FACTORS: [usize; MONOMIALS] = {
    let (mut all, mut i) = ([0; MONOMIALS], 0);
    while i < MONOMIALS {
        let rest = DEGREE - degree(i);
        all[i] = (rest + 1) * (rest + 2) * (rest + 3) / 6;
        i += 1;
    }
    all
};

/// The monomial of each such product.
static PRODUCTS: [[u8; MONOMIALS]; MONOMIALS] = {
    let (mut all, mut i) = ([[0; MONOMIALS]; MONOMIALS], 0);
    while i < MONOMIALS {
        let mut k = 0;
        while k < FACTORS[i] {
            let ([ax, ay, az], [bx, by, bz]) = (EXPONENTS[i], EXPONENTS[k]);
            all[i][k] = monomial([ax + bx, ay + by, az + bz]) as u8;
            k += 1;
        }
        i += 1;
    }
    all
};

/// The monomial with one less of an axis of which each has some.
const LOWER: [[usize; 3]; MONOMIALS] = {
    let (mut all, mut i) = ([[0; 3]; MONOMIALS], 0);
    while i < MONOMIALS {
        let mut axis = 0;
        while axis < 3 {
            let mut exponents = EXPONENTS[i];
            if exponents[axis] > 0 {
                exponents[axis] -= 1;
                all[i][axis] = monomial(exponents);
            }
            axis += 1;
        }
        i += 1;
    }
    all
};

/// The first axis of which each has some.
const AXIS: [usize; MONOMIALS] = {
    let (mut all, mut i) = ([0; MONOMIALS], 1);
    while i < MONOMIALS {
        while EXPONENTS[i][all[i]] == 0 {
            all[i] += 1;
        }
        i += 1;
    }
    all
};

/// yᵅ/α! of all monomials.
#[inline]
pub(super) fn monomials(at: Vec3) -> [f32; MONOMIALS] {
    let mut all = [1.0; MONOMIALS];
    for i in 1..MONOMIALS {
        let axis = AXIS[i];
        all[i] = all[LOWER[i][axis]] * at[axis] / EXPONENTS[i][axis] as f32;
    }
    all
}

/// Adds the moments Σ hᵅ/α! (1, c) of voxels whose moments around another centre are known: h there, and h + `step` here.
pub(super) fn shift(moments: &mut Coefficients, from: &Coefficients, step: DVec3) {
    let powers = monomials(step.as_vec3());
    for a in 0..MONOMIALS {
        for b in 0..FACTORS[a] {
            (0..SUMS).for_each(|sum| moments[usize::from(PRODUCTS[a][b])][sum] += powers[a] * from[b][sum]);
        }
    }
}

/// Σ h² of voxels with these moments.
pub(super) fn square_sum(moments: &Coefficients) -> f64 {
    [[2, 0, 0], [0, 2, 0], [0, 0, 2]].iter().map(|square| 2.0 * f64::from(moments[monomial(*square)][0])).sum()
}

/// Σ |h + s|⁴ of `count` voxels of Σ |h|⁴ = `fourth` and Σ h = 0, with their moments.
pub(super) fn shifted_fourth(fourth: f64, count: f64, moments: &Coefficients, step: DVec3) -> f64 {
    let sum = |exponents: [usize; 3], factor: f64| f64::from(moments[monomial(exponents)][0]) * factor;
    let axis = |i: usize| std::array::from_fn::<usize, 3, _>(|k| usize::from(k == i));
    let add = |a: [usize; 3], b: [usize; 3]| std::array::from_fn(|k| a[k] + b[k]);
    let (mut square, mut along, mut cubic) = (0.0, 0.0, 0.0);
    for i in 0..3 {
        for j in 0..3 {
            let pair = add(axis(i), axis(j));
            let second = sum(pair, if i == j { 2.0 } else { 1.0 });
            along += second * step[i] * step[j];
            square += if i == j { second } else { 0.0 };
            let triple = add(pair, axis(j));
            cubic += sum(triple, if i == j { 6.0 } else { 2.0 }) * step[i];
        }
    }
    let length = step.length_squared();
    fourth + 4.0 * along + count * length * length + 4.0 * cubic + 2.0 * length * square
}

/// How many nodes are multiplied side by side, all sums of each.
const ABREAST: usize = LANES / SUMS;

/// The sums of each of them, node after node.
type Abreast = [[f32; LANES]; MONOMIALS];

/// A series around a point: Σ u^α/α! times its coefficients, u the way from the point.
#[derive(Clone)]
pub(super) struct Series {
    pub around: DVec3,
    coefficients: Coefficients,
}

impl Series {
    /// The sum of (s r²)^(−p/2) (1, c) over nodes, each with its centroid and its moments.
    pub fn new<'m>(
        around: DVec3,
        power: u32,
        scale: f32,
        nodes: impl Iterator<Item = (DVec3, &'m Coefficients)>,
    ) -> Self {
        let mut abreast = [[0.0; LANES]; MONOMIALS];
        let (mut ways, mut moments) = ([[0.0; LANES]; 3], [&ZERO; LANES]);
        let mut len = 0;
        for (centroid, sums) in nodes {
            let way = (around - centroid).as_vec3();
            (0..3).for_each(|axis| ways[axis][len] = way[axis]);
            moments[len] = sums;
            len += 1;
            if len == LANES {
                add(&mut abreast, power, scale, &ways, &moments);
                len = 0;
            }
        }
        if len > 0 {
            add(&mut abreast, power, scale, &ways, &moments[..len]);
        }
        let total = |sums: &[f32; LANES], sum: usize| (0..ABREAST).map(|node| sums[node * SUMS + sum]).sum();
        let coefficients = std::array::from_fn(|a| std::array::from_fn(|sum| total(&abreast[a], sum)));
        Self { around, coefficients }
    }
}

/// Adds to the coefficients of u^α/α! Σ over β of ∂^(α+β) (s y²)^(−p/2) · Σ hᵝ/β! (1, c), y the way from a node, of as many
/// nodes as there are moments. The derivatives are by Duan and Krasny's recurrence (An adaptive treecode for computing
/// nonbonded potential energy in classical molecular systems, 2001), which follows from y·∇|y|⁻ᵖ = −p |y|⁻ᵖ:
/// n y² ∂ᵅ + (2n + p − 2) Σ αᵢ yᵢ ∂^(α−eᵢ) + (n + p − 2) Σ αᵢ(αᵢ − 1) ∂^(α−2eᵢ) = 0, n = |α|.
#[multiversion::multiversion(targets = "simd")]
fn add(sums: &mut Abreast, power: u32, scale: f32, way: &[[f32; LANES]; 3], moments: &[&Coefficients]) {
    let mut inverse = [0.0; LANES];
    let mut slopes = [[0.0; LANES]; MONOMIALS];
    for i in 0..LANES {
        inverse[i] = 1.0 / (way[0][i] * way[0][i] + way[1][i] * way[1][i] + way[2][i] * way[2][i]);
        slopes[0][i] = if power % 2 == 1 { (scale * inverse[i]).sqrt() } else { 1.0 };
    }
    for _ in 0..power / 2 {
        for i in 0..LANES {
            slopes[0][i] *= scale * inverse[i];
        }
    }
    for a in 1..MONOMIALS {
        let n = degree(a) as f32;
        let first = -(2.0 * n + power as f32 - 2.0) / n;
        let second = -(n + power as f32 - 2.0) / n;
        let mut sum = [0.0; LANES];
        for axis in 0..3 {
            let (count, lower) = (EXPONENTS[a][axis], LOWER[a][axis]);
            if count > 0 {
                let factor = first * count as f32;
                for i in 0..LANES {
                    sum[i] += factor * way[axis][i] * slopes[lower][i];
                }
            }
            if count > 1 {
                let (factor, lowest) = (second * (count * (count - 1)) as f32, LOWER[lower][axis]);
                for i in 0..LANES {
                    sum[i] += factor * slopes[lowest][i];
                }
            }
        }
        for i in 0..LANES {
            slopes[a][i] = sum[i] * inverse[i];
        }
    }
    // Where there are fewer nodes than before, what is left of those is multiplied by 0.
    let (mut slope, mut moment) = ([[0.0; LANES]; MONOMIALS], [[0.0; LANES]; MONOMIALS]);
    for (first, moments) in moments.chunks(ABREAST).enumerate() {
        for a in 0..MONOMIALS {
            let four: [f32; ABREAST] =
                std::array::from_fn(|node| if node < moments.len() { slopes[a][first * ABREAST + node] } else { 0.0 });
            slope[a] = std::array::from_fn(|i| four[i / SUMS]);
        }
        for (node, moments) in moments.iter().enumerate() {
            for a in 0..MONOMIALS {
                moment[a][node * SUMS..][..SUMS].copy_from_slice(&moments[a]);
            }
        }
        add_degree::<0, 1>(sums, &slope, &moment);
        add_degree::<1, 3>(sums, &slope, &moment);
        add_degree::<4, 6>(sums, &slope, &moment);
        add_degree::<10, 10>(sums, &slope, &moment);
        add_degree::<20, 15>(sums, &slope, &moment);
        add_degree::<35, 21>(sums, &slope, &moment);
    }
}

/// Adds to the coefficients of one degree, the `COUNT` monomials from the `FIRST` on: so few that they stay in registers
/// meanwhile, and sums next to one another do not wait for each other.
#[inline(always)]
fn add_degree<const FIRST: usize, const COUNT: usize>(sums: &mut Abreast, slope: &Abreast, moment: &Abreast) {
    let mut here = [[0.0; LANES]; COUNT];
    here.copy_from_slice(&sums[FIRST..FIRST + COUNT]);
    for b in 0..FACTORS[FIRST] {
        for k in 0..COUNT {
            let slope = &slope[usize::from(PRODUCTS[b][FIRST + k])];
            for i in 0..LANES {
                here[k][i] += slope[i] * moment[b][i];
            }
        }
    }
    sums[FIRST..FIRST + COUNT].copy_from_slice(&here);
}

/// The last degree's monomials are the last ones.
const _: () = assert!(DEGREE == 5 && MONOMIALS == 35 + 21);

/// Adds a series at points, each given by its way from the series' middle.
pub(super) fn evaluate(series: &Series, at: &[[f32; LANES]; 3], sums: &mut [[f32; LANES]; SUMS]) {
    evaluate_all(&series.coefficients, at, sums);
}

#[multiversion::multiversion(targets = "simd")]
fn evaluate_all(coefficients: &Coefficients, at: &[[f32; LANES]; 3], sums: &mut [[f32; LANES]; SUMS]) {
    let mut powers = [[1.0; LANES]; MONOMIALS];
    for a in 0..MONOMIALS {
        if a > 0 {
            let (axis, lower) = (AXIS[a], LOWER[a][AXIS[a]]);
            let factor = 1.0 / EXPONENTS[a][axis] as f32;
            for i in 0..LANES {
                powers[a][i] = powers[lower][i] * (at[axis][i] * factor);
            }
        }
        for sum in 0..SUMS {
            for i in 0..LANES {
                sums[sum][i] += coefficients[a][sum] * powers[a][i];
            }
        }
    }
}

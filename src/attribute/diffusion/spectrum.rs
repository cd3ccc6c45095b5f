//! The lowest eigenfunctions of a surface's Laplacian: cotangents and lumped masses, found by filtered iteration on a
//! subspace (Zhou, Saad, Tiago and Chelikowsky, Self-consistent-field calculations using Chebyshev-filtered subspace
//! iteration, 2006). It takes products with the matrix alone; each vector's are its own, so threads change no bit.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::surface::Surface;

/// Modes that heat has left to this share count no more.
pub(super) const LEAST: f64 = 1e-3;
/// Vectors that are iterated at first, and at most: beyond it the highest modes are left out.
const VECTORS: [usize; 2] = [24, 160];
/// Vectors beyond those wanted: the last ones settle slowly.
const SPARE: usize = 6;
/// The degree of the filter.
const DEGREE: usize = 24;
/// An eigenpair is found where A·x is this near to λ·x, against the lowest eigenvalue that is not 0.
const NEAR: f64 = 1e-3;
/// Rounds at most: where eigenvalues lie close beyond the last one, what is found by then is as good.
const ROUNDS: usize = 60;
/// Eigenvalues this near to one another, as a share, belong together: a part of such a group would depend on chance.
const SAME: f64 = 0.01;

/// The numbers of each vertex.
pub struct Spectrum {
    modes: usize,
    /// By vertex, then by mode.
    numbers: Vec<f64>,
}

impl Spectrum {
    /// φₖ·exp(−λₖt) of every vertex for all modes but the constant one, t = `time`/λ₁; `None` where it was stopped.
    pub fn new(surface: &Surface, time: f64, cancel: &AtomicBool) -> Option<Self> {
        let matrix = Matrix::new(surface);
        let vertices = surface.positions.len();
        let mut block = Block::random(vertices, VECTORS[0].min(vertices));
        loop {
            block.iterate(&matrix, cancel)?;
            let wanted = block.wanted(time);
            let most = VECTORS[1].min(vertices);
            if wanted.is_some() || block.vectors.len() >= most {
                let known = block.vectors.len().saturating_sub(SPARE).max(2);
                let modes = wanted
                    .unwrap_or_else(|| (2..known).rev().find(|count| !block.parts_a_group(*count)).unwrap_or(known));
                return Some(block.spectrum(&matrix, modes, time));
            }
            block.widen((2 * block.vectors.len()).min(most));
        }
    }

    /// How many numbers a vertex has.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// The numbers of a vertex.
    pub fn of_vertex(&self, vertex: usize) -> &[f64] {
        &self.numbers[vertex * self.modes..][..self.modes]
    }
}

/// M^(−1/2)·L·M^(−1/2), by rows.
struct Matrix {
    starts: Vec<usize>,
    columns: Vec<u32>,
    entries: Vec<f64>,
    /// The square root of each vertex' mass: a third of the area around it.
    roots: Vec<f64>,
    /// No eigenvalue is greater (Gershgorin).
    greatest: f64,
}

impl Matrix {
    fn new(surface: &Surface) -> Self {
        let vertices = surface.positions.len();
        let mut masses = vec![0.0; vertices];
        let mut edges: Vec<(u32, u32, f64)> = Vec::new();
        for triangle in &surface.triangles {
            let corners = triangle.map(|vertex| surface.positions[vertex as usize]);
            let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                masses[triangle[i] as usize] += area / 3.0;
                // Of a needle the cotangent is endless: it joins as much as a good triangle would not, but finitely.
                let cotangent = (corners[j] - corners[i]).dot(corners[k] - corners[i]) / (2.0 * area).max(1e-30);
                let weight = 0.5 * cotangent.clamp(-STIFFEST, STIFFEST);
                edges.push((triangle[j], triangle[k], weight));
                edges.push((triangle[k], triangle[j], weight));
            }
        }
        // A vertex of needles alone has next to no mass.
        let least = masses.iter().sum::<f64>() / vertices as f64 * 1e-4;
        let roots: Vec<f64> = masses.iter().map(|mass| mass.max(least).sqrt()).collect();
        edges.sort_by_key(|(row, column, _)| (*row, *column));
        let (mut starts, mut columns, mut entries) = (vec![0], Vec::new(), Vec::new());
        let mut greatest: f64 = 0.0;
        let mut at = 0;
        for row in 0..vertices as u32 {
            let own = columns.len();
            columns.push(row);
            entries.push(0.0);
            while at < edges.len() && edges[at].0 == row {
                let (_, column, _) = edges[at];
                let mut weight = 0.0;
                while at < edges.len() && (edges[at].0, edges[at].1) == (row, column) {
                    weight += edges[at].2;
                    at += 1;
                }
                entries[own] += weight;
                columns.push(column);
                entries.push(-weight);
            }
            for place in own..entries.len() {
                entries[place] /= roots[row as usize] * roots[columns[place] as usize];
            }
            greatest = greatest.max(entries[own..].iter().map(|entry| entry.abs()).sum());
            starts.push(columns.len());
        }
        Self { starts, columns, entries, roots, greatest }
    }

    fn times(&self, vector: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(self.starts.windows(2).map(|ends| {
            let row = ends[0]..ends[1];
            let columns = &self.columns[row.clone()];
            self.entries[row].iter().zip(columns).map(|(entry, column)| entry * vector[*column as usize]).sum::<f64>()
        }));
    }

    /// A vector with what lies in \[from, greatest\] of it damped, and all below raised.
    fn filtered(&self, vector: &[f64], from: f64) -> Vec<f64> {
        let (half, middle) = ((self.greatest - from) / 2.0, (self.greatest + from) / 2.0);
        let mut sigma = -half / middle;
        let first = sigma;
        let mut before = vector.to_vec();
        let mut now = Vec::new();
        self.times(&before, &mut now);
        now.iter_mut().zip(&before).for_each(|(now, before)| *now = (*now - middle * before) * first / half);
        let mut product = Vec::new();
        for _ in 1..DEGREE {
            let next = 1.0 / (2.0 / first - sigma);
            self.times(&now, &mut product);
            for i in 0..now.len() {
                let value = (product[i] - middle * now[i]) * (2.0 * next / half) - sigma * next * before[i];
                (before[i], now[i]) = (now[i], value);
            }
            sigma = next;
        }
        now
    }
}

/// Cotangents are held to this: those of angles of a twentieth of a degree.
const STIFFEST: f64 = 1000.0;

/// Vectors that come to span the lowest eigenspace, with their eigenvalues, least first.
struct Block {
    vectors: Vec<Vec<f64>>,
    values: Vec<f64>,
    /// Of the numbers at random, the next.
    random: u64,
}

impl Block {
    fn random(length: usize, count: usize) -> Self {
        let mut block = Self { vectors: vec![vec![1.0; length]], values: Vec::new(), random: 1 };
        block.widen(count);
        block
    }

    /// More vectors, at random.
    fn widen(&mut self, count: usize) {
        let length = self.vectors[0].len();
        while self.vectors.len() < count {
            let next = (0..length).map(|_| {
                self.random =
                    self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (self.random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            });
            let next = next.collect();
            self.vectors.push(next);
        }
    }

    /// Until all but the spare ones are eigenvectors; `None` where it was stopped.
    fn iterate(&mut self, matrix: &Matrix, cancel: &AtomicBool) -> Option<()> {
        self.rotate(matrix);
        for _ in 0..ROUNDS {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let from = self.values[self.values.len() - 1].clamp(1e-6 * matrix.greatest, 0.9 * matrix.greatest);
            self.vectors = self.vectors.par_iter().map(|vector| matrix.filtered(vector, from)).collect();
            self.rotate(matrix);
            if self.is_settled(matrix) {
                break;
            }
        }
        Some(())
    }

    fn is_settled(&self, matrix: &Matrix) -> bool {
        let last = self.vectors.len().saturating_sub(SPARE).max(1);
        let enough = NEAR * self.values.get(1).copied().unwrap_or(0.0).max(1e-9 * matrix.greatest);
        let is_near = |i: usize| {
            let mut product = Vec::new();
            matrix.times(&self.vectors[i], &mut product);
            let off: f64 = product.iter().zip(&self.vectors[i]).map(|(a, x)| (a - self.values[i] * x).powi(2)).sum();
            off.sqrt() <= enough
        };
        (0..last).into_par_iter().all(is_near)
    }

    /// Makes the vectors orthonormal, and eigenvectors of the matrix as far as their span goes (Rayleigh and Ritz).
    fn rotate(&mut self, matrix: &Matrix) {
        orthonormalise(&mut self.vectors);
        let products: Vec<Vec<f64>> = self
            .vectors
            .par_iter()
            .map(|vector| {
                let mut product = Vec::new();
                matrix.times(vector, &mut product);
                product
            })
            .collect();
        let count = self.vectors.len();
        let mut small: Vec<Vec<f64>> = (0..count)
            .into_par_iter()
            .map(|i| (0..count).map(|j| dot(&self.vectors[i], &products[j])).collect())
            .collect();
        let turns = eigen(&mut small);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|a, b| small[*a][*a].total_cmp(&small[*b][*b]).then(a.cmp(b)));
        self.values = order.iter().map(|i| small[*i][*i].max(0.0)).collect();
        let length = self.vectors[0].len();
        let turned = |column: &usize| {
            let mut out = vec![0.0; length];
            for (vector, turn) in self.vectors.iter().zip(&turns) {
                out.iter_mut().zip(vector).for_each(|(sum, x)| *sum += turn[*column] * x);
            }
            out
        };
        self.vectors = order.par_iter().map(turned).collect();
    }

    /// The modes that heat has not left by then, and those that belong to the last of them; `None` where more have to be
    /// found to tell.
    fn wanted(&self, time: f64) -> Option<usize> {
        let most = -libm::log(LEAST) / time * self.values[1];
        let known = self.vectors.len() - SPARE;
        let count = self.values.iter().position(|value| *value > most * (1.0 + SAME))?;
        // The lowest group is there however long heat spreads.
        (count.max(2)..known).find(|count| !self.parts_a_group(*count))
    }

    /// Whether the first so many modes hold a part of the modes of one eigenvalue.
    fn parts_a_group(&self, count: usize) -> bool {
        self.values[count] - self.values[count - 1] < SAME * self.values[count]
    }

    fn spectrum(&self, matrix: &Matrix, modes: usize, time: f64) -> Spectrum {
        let count = modes - 1;
        let decays: Vec<f64> =
            self.values[1..modes].iter().map(|value| libm::exp(-value * time / self.values[1])).collect();
        let vertices = matrix.roots.len();
        let mut numbers = Vec::with_capacity(vertices * count);
        for vertex in 0..vertices {
            let of_mode = |(vector, decay): (&Vec<f64>, &f64)| vector[vertex] / matrix.roots[vertex] * decay;
            numbers.extend(self.vectors[1..modes].iter().zip(&decays).map(of_mode));
        }
        Spectrum { modes: count, numbers }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Each vector freed of those before it, twice, and of length 1 (Gram and Schmidt).
fn orthonormalise(vectors: &mut [Vec<f64>]) {
    for i in 0..vectors.len() {
        let (before, rest) = vectors.split_at_mut(i);
        let own = &mut rest[0];
        for _ in 0..2 {
            for other in &*before {
                let along = dot(other, own);
                own.iter_mut().zip(other).for_each(|(x, other)| *x -= along * other);
            }
            let length = dot(own, own).sqrt().max(f64::MIN_POSITIVE);
            own.iter_mut().for_each(|x| *x /= length);
        }
    }
}

/// Makes a symmetric matrix diagonal by Jacobi's rotations, and gives its eigenvectors as columns.
fn eigen(matrix: &mut [Vec<f64>]) -> Vec<Vec<f64>> {
    const SWEEPS: usize = 12;
    let count = matrix.len();
    let mut vectors: Vec<Vec<f64>> =
        (0..count).map(|i| (0..count).map(|j| if i == j { 1.0 } else { 0.0 }).collect()).collect();
    let scale = (0..count).map(|i| matrix[i][i].abs()).fold(f64::MIN_POSITIVE, f64::max);
    for _ in 0..SWEEPS {
        let mut largest: f64 = 0.0;
        for p in 0..count {
            for q in p + 1..count {
                let off = matrix[p][q];
                largest = largest.max(off.abs());
                if off.abs() <= 1e-17 * scale {
                    continue;
                }
                let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
                let tan = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let cos = 1.0 / (tan * tan + 1.0).sqrt();
                let sin = tan * cos;
                let turned = |a: f64, b: f64| (cos * a - sin * b, sin * a + cos * b);
                for row in matrix.iter_mut().chain(&mut vectors) {
                    (row[p], row[q]) = turned(row[p], row[q]);
                }
                for column in 0..count {
                    let (a, b) = turned(matrix[p][column], matrix[q][column]);
                    (matrix[p][column], matrix[q][column]) = (a, b);
                }
            }
        }
        if largest <= 1e-14 * scale {
            break;
        }
    }
    vectors
}

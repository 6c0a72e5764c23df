//! Eigenvalues of a small Hessenberg matrix, by the QR algorithm with shifts, in complex numbers.
//!
//! In: columns, each with one number more than the one before. Out: real and imaginary parts. Never: vectors.
//!
//! Source: Golub, Van Loan, Matrix Computations, 4th ed., 7.5: Wilkinson's shift, deflation from below.

use core::ops::{Add, Mul, Sub};

/// A complex number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    const fn real(re: f64) -> Self {
        Complex { re, im: 0.0 }
    }
    fn size(self) -> f64 {
        self.re.hypot(self.im)
    }
    fn conjugate(self) -> Self {
        Complex { im: -self.im, ..self }
    }
    fn times(self, by: f64) -> Self {
        Complex { re: self.re * by, im: self.im * by }
    }
    /// The root with a real part of 0 or more.
    fn root(self) -> Self {
        let size = self.size();
        let re = (0.5 * (size + self.re)).max(0.0).sqrt();
        let im = (0.5 * (size - self.re)).max(0.0).sqrt();
        Complex { re, im: im.copysign(self.im) }
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Complex { re: self.re + other.re, im: self.im + other.im }
    }
}
impl Sub for Complex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Complex { re: self.re - other.re, im: self.im - other.im }
    }
}
impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Complex { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

/// Rounds for one eigenvalue, after which it is taken as it is.
const ROUNDS: usize = 60;

/// The eigenvalues of the matrix whose column `k` has `k + 2` numbers, of which the last one of the last column, below the
/// matrix, does not count.
pub(super) fn eigenvalues(columns: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let count = columns.len();
    let at = |row: usize, column: usize| columns[column].get(row).copied().unwrap_or(0.0);
    let mut matrix: Vec<Vec<Complex>> =
        (0..count).map(|row| (0..count).map(|column| Complex::real(at(row, column))).collect()).collect();
    let mut found = Vec::new();
    let (mut size, mut round) = (count, 0);
    while size > 0 {
        let last = size - 1;
        // Where the matrix falls into two.
        let small = |row: usize| {
            let beside = matrix[row][row].size() + matrix[row - 1][row - 1].size();
            matrix[row][row - 1].size() <= f64::EPSILON * if beside > 0.0 { beside } else { f64::MIN_POSITIVE }
        };
        let first = (1..size).rev().find(|&row| small(row)).unwrap_or(0);
        if first == last || round >= ROUNDS {
            let Complex { re, im } = matrix[last][last];
            found.push([re, im]);
            (size, round) = (last, 0);
            continue;
        }
        round += 1;
        let shift = shift(&matrix, last, round);
        step(&mut matrix, first..size, shift);
    }
    found
}

/// The eigenvalue of the last two rows and columns that is nearer to the last number; now and then another one, so that none
/// is turned in a circle.
fn shift(matrix: &[Vec<Complex>], last: usize, round: usize) -> Complex {
    let [a, b] = [matrix[last - 1][last - 1], matrix[last - 1][last]];
    let [c, d] = [matrix[last][last - 1], matrix[last][last]];
    if round.is_multiple_of(11) {
        return d + Complex::real(c.size());
    }
    let (mean, half) = ((a + d).times(0.5), (a - d).times(0.5));
    let root = (half * half + b * c).root();
    let [one, other] = [mean + root, mean - root];
    if (one - d).size() < (other - d).size() { one } else { other }
}

/// `Q R = H - shift` by rotations, then `R Q + shift`, of some rows and the same columns.
fn step(matrix: &mut [Vec<Complex>], rows: core::ops::Range<usize>, shift: Complex) {
    for row in rows.clone() {
        matrix[row][row] = matrix[row][row] - shift;
    }
    let mut rotations = Vec::new();
    for k in rows.start..rows.end - 1 {
        let (a, b) = (matrix[k][k], matrix[k + 1][k]);
        let size = a.size().hypot(b.size());
        let (c, s) = if size > 0.0 { (a.times(1.0 / size), b.times(1.0 / size)) } else { (Complex::real(1.0), b) };
        rotations.push((c, s));
        let [above, below] = &mut matrix[k..k + 2] else { continue };
        for (above, below) in above[k..rows.end].iter_mut().zip(&mut below[k..rows.end]) {
            (*above, *below) = (c.conjugate() * *above + s.conjugate() * *below, c * *below - s * *above);
        }
    }
    for (k, (c, s)) in (rows.start..).zip(rotations) {
        for line in &mut matrix[rows.start..(k + 2).min(rows.end)] {
            let (left, right) = (line[k], line[k + 1]);
            line[k] = left * c + right * s;
            line[k + 1] = right * c.conjugate() - left * s.conjugate();
        }
    }
    for row in rows {
        matrix[row][row] = matrix[row][row] + shift;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The eigenvalues, largest imaginary part first, then largest real part.
    fn sorted(columns: &[Vec<f64>]) -> Vec<[f64; 2]> {
        let mut found = eigenvalues(columns);
        found.sort_by(|a, b| (b[1], b[0]).partial_cmp(&(a[1], a[0])).unwrap());
        found
    }

    fn near(found: &[[f64; 2]], expected: &[[f64; 2]], tolerance: f64) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < tolerance, "{found:?}, {expected:?}");
        }
    }

    #[test]
    fn of_known_matrices() {
        near(&eigenvalues(&[vec![-3.0, 0.0]]), &[[-3.0, 0.0]], 1e-15);
        // x'' = -4 x - 2 z 2 x' for z = 0, 0.5.
        near(&sorted(&[vec![0.0, -4.0], vec![1.0, 0.0, 0.0]]), &[[0.0, 2.0], [0.0, -2.0]], 1e-14);
        let root = 3.0_f64.sqrt();
        near(&sorted(&[vec![0.0, -4.0], vec![1.0, -2.0, 0.0]]), &[[-1.0, root], [-1.0, -root]], 1e-14);
        // A turn by a third of a circle: the third roots of 1.
        let turn = [vec![0.0, 1.0], vec![0.0, 0.0, 1.0], vec![1.0, 0.0, 0.0, 0.0]];
        let half = 0.75_f64.sqrt();
        near(&sorted(&turn), &[[-0.5, half], [1.0, 0.0], [-0.5, -half]], 1e-13);
        // A chain of ten: -2 on the diagonal, 1 beside it.
        let chain: Vec<Vec<f64>> = (0..10)
            .map(|column: usize| {
                let number =
                    |row: usize| f64::from(u8::from(row.abs_diff(column) == 1)) - 2.0 * f64::from(row == column);
                (0..column + 2).map(number).collect()
            })
            .collect();
        let wave = |k: usize| -2.0 + 2.0 * (core::f64::consts::PI * (k + 1) as f64 / 11.0).cos();
        let expected: Vec<[f64; 2]> = (0..10).map(|k| [wave(k), 0.0]).collect();
        let mut found = eigenvalues(&chain);
        found.sort_by(|a, b| b[0].total_cmp(&a[0]));
        near(&found, &expected, 1e-13);
    }
}

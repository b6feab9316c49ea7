//! Symmetric positive definite matrices of some dozen rows.

use std::ops::Range;

/// A symmetric matrix; only its lower triangle is used.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetric {
    size: usize,
    values: Vec<f64>,
}

impl Symmetric {
    /// A matrix of zeros.
    pub fn zero(size: usize) -> Self {
        Self { size, values: vec![0.0; size * size] }
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The value in a row and a column.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        let (row, column) = (row.max(column), row.min(column));
        self.values[row * self.size + column]
    }

    /// Adds to the value in a row and a column, and to its mirror image.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let (row, column) = (row.max(column), row.min(column));
        self.values[row * self.size + column] += value;
    }

    /// Submatrix of a range of rows and columns.
    pub fn part(&self, range: Range<usize>) -> Self {
        let mut part = Self::zero(range.len());
        for row in 0..range.len() {
            (0..=row).for_each(|column| part.add(row, column, self.at(range.start + row, range.start + column)));
        }
        part
    }

    /// The quadratic form of a vector.
    pub fn form(&self, vector: &[f64]) -> f64 {
        let row = |i: usize| (0..self.size).map(|j| self.at(i, j) * vector[j]).sum::<f64>();
        (0..self.size).map(|i| vector[i] * row(i)).sum()
    }

    /// The lower triangle L of L·Lᵀ (Cholesky); `None` unless the matrix is positive definite
    /// beyond rounding.
    fn factor(&self) -> Option<Vec<f64>> {
        let n = self.size;
        let mut lower = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum();
                let rest = self.at(i, j) - known;
                if i != j {
                    lower[i * n + j] = rest / lower[j * n + j];
                } else if rest > 1e-14 * self.at(i, i) {
                    lower[i * n + i] = rest.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(lower)
    }

    /// Solves A·x = `right`; `None` for a matrix that is not positive definite.
    pub fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        Some(substituted(&self.factor()?, right))
    }

    /// The inverse.
    pub fn inverse(&self) -> Option<Self> {
        let (n, lower) = (self.size, self.factor()?);
        let mut inverse = Self::zero(n);
        for column in 0..n {
            let unit: Vec<f64> = (0..n).map(|row| f64::from(u8::from(row == column))).collect();
            let solved = substituted(&lower, &unit);
            (column..n).for_each(|row| inverse.add(row, column, solved[row]));
        }
        Some(inverse)
    }
}

/// Solves L·Lᵀ·x = `right`.
fn substituted(lower: &[f64], right: &[f64]) -> Vec<f64> {
    let n = right.len();
    let mut x = right.to_vec();
    for i in 0..n {
        let known: f64 = (0..i).map(|k| lower[i * n + k] * x[k]).sum();
        x[i] = (x[i] - known) / lower[i * n + i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| lower[k * n + i] * x[k]).sum();
        x[i] = (x[i] - known) / lower[i * n + i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    #[test]
    fn solutions_and_inverses_are_right() {
        let mut random = Random::new(71);
        for n in 1..12 {
            let factors: Vec<f64> = (0..n * n).map(|_| random.range(-1.0, 1.0)).collect();
            let mut matrix = Symmetric::zero(n);
            for i in 0..n {
                for j in 0..=i {
                    let dot: f64 = (0..n).map(|k| factors[i * n + k] * factors[j * n + k]).sum();
                    matrix.add(i, j, dot + f64::from(u8::from(i == j)));
                }
            }
            let right: Vec<f64> = (0..n).map(|_| random.range(-1.0, 1.0)).collect();
            let x = matrix.solve(&right).expect("positive definite");
            let inverse = matrix.inverse().expect("positive definite");
            for i in 0..n {
                let found: f64 = (0..n).map(|j| matrix.at(i, j) * x[j]).sum();
                assert!((found - right[i]).abs() < 1e-12);
                let by_inverse: f64 = (0..n).map(|j| inverse.at(i, j) * right[j]).sum();
                assert!((by_inverse - x[i]).abs() < 1e-12);
            }
        }
        let mut flat = Symmetric::zero(2);
        [(0, 0), (0, 1), (1, 1)].iter().for_each(|(row, column)| flat.add(*row, *column, 1.0));
        assert_eq!(flat.solve(&[1.0, 1.0]), None, "singular");
    }
}

//! Singular values of three by three matrices: which rotations are determined depends on them.

use super::prelude::*;

const VALUES: Quantity = Quantity::new("singular values", 6.0, "1", "the largest singular value");

const FACTORS: Quantity = Quantity::new(
    "U Λ Vᵀ, and what U and V lack to be orthogonal",
    20.0,
    "1",
    "the largest singular value, and 1",
);

pub(super) fn family(_: Extent) -> Family {
    let shapes: [(&str, [f64; 3]); 10] = [
        ("1, 1, 1", [1.0; 3]),
        ("3, 2, 1", [3.0, 2.0, 1.0]),
        ("1, 1, 1e-8", [1.0, 1.0, 1e-8]),
        ("1, 1e-4, 1e-8", [1.0, 1e-4, 1e-8]),
        ("1, 1e-10, 1e-10", [1.0, 1e-10, 1e-10]),
        ("1, 1e-12, 1e-24", [1.0, 1e-12, 1e-24]),
        ("1, 1e-15, 0", [1.0, 1e-15, 0.0]),
        ("1, 1, 0", [1.0, 1.0, 0.0]),
        ("1, 0, 0", [1.0, 0.0, 0.0]),
        ("0, 0, 0", [0.0; 3]),
    ];
    let sizes = [("", 1.0), (" times 1e-140", 1e-140), (" times 1e140", 1e140)];
    let shapes = shapes.into_iter().flat_map(|(name, values)| {
        sizes.map(|(size_name, size)| (format!("{name}{size_name}"), turned(values, size)))
    });
    let graded = [
        ("rows from 1 to 1e-20", graded(1e-10, 1.0)),
        ("columns from 1 to 1e-20", graded(1.0, 1e-10)),
        ("rows and columns from 1 to 1e-20", graded(1e-5, 1e-5)),
    ];
    Family::new(
        "singular values",
        "The SVD of three by three matrices of any rank, grade and size, reflections \
            included, against one-sided Jacobi in 192 bits.",
        &[VALUES, FACTORS],
    )
    .with(shapes, rows)
    .with(graded, rows)
}

/// Of these singular values: some without any structure, some aligned with the axes, some
/// reflections.
fn turned(values: [f64; 3], size: f64) -> [Matrix3<f64>; 6] {
    let mut sequence = Sequence::new(7);
    std::array::from_fn(|i| {
        let mut turn = || sequence.rotation().to_rotation_matrix().into_inner();
        let left = if i == 0 { Matrix3::identity() } else { turn() };
        let right = if i == 1 { Matrix3::identity() } else { turn() };
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        let diagonal = Matrix3::from_diagonal(&Vector3::from(values));
        left * diagonal * right * (sign * size)
    })
}

fn graded(rows_by: f64, columns_by: f64) -> [Matrix3<f64>; 6] {
    let mut sequence = Sequence::new(23);
    std::array::from_fn(|_| {
        Matrix3::from_fn(|i, j| {
            let grade = rows_by.powi(i as i32) * columns_by.powi(j as i32);
            sequence.signed() * grade
        })
    })
}

fn rows(methods: &Methods, matrices: &[Matrix3<f64>; 6]) -> Found {
    Ok(matrices.iter().flat_map(|matrix| rows_of(methods, matrix)).collect())
}

fn rows_of(methods: &Methods, matrix: &Matrix3<f64>) -> [Row; 2] {
    let found = (methods.svd3)(matrix);
    let exact = svd(&HighMatrix::from_fn(3, 3, |i, j| High::from(matrix[(i, j)])));
    let largest = exact.singular_values[0].to_f64();
    let error = (0..3)
        .map(|k| {
            let error = High::from(found.singular_values[k]) - &exact.singular_values[k];
            error.abs().to_f64()
        })
        .fold(0.0, f64::max);
    let product = found.u * Matrix3::from_diagonal(&found.singular_values) * found.v.transpose();
    // Divided first, because squares of what is left would leave the range of f64.
    let part = |m: Matrix3<f64>| {
        if largest > 0.0 { (m / largest).norm() } else { m.norm() }
    };
    let orthogonal = |q: &Matrix3<f64>| ((q * q.transpose() - Matrix3::identity()).norm(), 1.0);
    let factors = [(part(product - matrix), 1.0), orthogonal(&found.u), orthogonal(&found.v)];
    [VALUES.row(1.0, error, largest), FACTORS.worst(1.0, &factors)]
}

//! Textbook methods that lose digits: the battery has to find each of them out.

use super::case::Methods;
use crate::precision::fixed_point;
use nalgebra::{Complex, DMatrix, Matrix3, Point3, Unit, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_field::bernstein::products;
use trackwright_field::evaluation::Matrix6x3;
use trackwright_field::fit::{Fit, fit};
use trackwright_field::inverse::InverseState;
use trackwright_field::least_squares::Solution;
use trackwright_field::samples::{PoseError, Sample};
use trackwright_geometry::directions::{DirectionSet, DirectionWeights, Weighting};
use trackwright_geometry::pose::{pose_from_parts, quaternion_from_matrix};
use trackwright_geometry::rotation::AxisRotation;
use trackwright_geometry::svd3::{Svd3, svd3};
use trackwright_simulation::frame_fit::{FrameFit, FrameFitter};
use trackwright_simulation::linear_fit::RotationNotDetermined;
use trackwright_simulation::tool_in_crf::RelativeError;
use trackwright_simulation::{SensorOrientation, Statistics, Summary};

/// `AᵀA x = Aᵀb`.
pub const NORMAL_EQUATIONS: Methods = Methods {
    solve: |rows, values, rcond, ridge| Ok(by_normal_equations(rows, values, rcond, ridge)),
    fit: |set, settings, bounds| {
        let own = fit(set, settings, bounds)?;
        if settings.directions != DirectionSet::One {
            return Ok(own);
        }
        let row =
            |s: &Sample| products(settings.order, &own.model.bounds().to_unit(&s.position_mm));
        let rows: Vec<_> = set.samples.iter().map(row).collect();
        let values: Vec<_> = set.samples.iter().map(|s| s.error.values()).collect();
        let found = by_normal_equations(&rows, &values, settings.rcond, settings.ridge);
        let room = &own.model;
        let model = room.with_coefficients(room.order(), *room.bounds(), found.unknowns)?;
        Ok(Fit { model, ..own })
    },
    ..Methods::OWN
};

fn by_normal_equations(rows: &[Vec<f64>], values: &[[f64; 6]], rcond: f64, ridge: f64) -> Solution {
    let a = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let b = DMatrix::from_fn(rows.len(), 6, |i, k| values[i][k]);
    let normal = a.transpose() * &a;
    let eigen = normal.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let is_kept = |l: &f64| *l > rcond * rcond * largest;
    let kept: Vec<f64> = eigen.eigenvalues.iter().copied().filter(is_kept).collect();
    let inverse = eigen.eigenvalues.map(|l| match is_kept(&l) {
        true => 1.0 / (l + ridge * ridge * largest),
        false => 0.0,
    });
    let v = &eigen.eigenvectors;
    let x = v * DMatrix::from_diagonal(&inverse) * v.transpose() * (a.transpose() * b);
    Solution {
        unknowns: (0..a.ncols()).map(|i| std::array::from_fn(|k| x[(i, k)])).collect(),
        rank: kept.len(),
        condition: (largest / kept.into_iter().fold(f64::INFINITY, f64::min)).sqrt(),
    }
}

/// The angle from the trace or the scalar part, by arccosine.
pub const ARCCOSINE_LOGARITHM: Methods = Methods {
    log_matrix: |m| {
        let angle = (0.5 * (m.trace() - 1.0)).clamp(-1.0, 1.0).acos();
        let v = Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
        if angle == 0.0 { Vector3::zeros() } else { v * (0.5 * angle / angle.sin()) }
    },
    log_quaternion: |q| {
        let half = q.w.clamp(-1.0, 1.0).acos();
        if half == 0.0 { Vector3::zeros() } else { q.imag() * (2.0 * half / half.sin()) }
    },
    angle: |q| 2.0 * q.w.abs().min(1.0).acos(),
    axis_rotation: |from, to| {
        let angle = from.dot(to).clamp(-1.0, 1.0).acos();
        let cross = from.cross(to);
        AxisRotation {
            vector_rad: cross.try_normalize(0.0).map_or_else(Vector3::zeros, |c| c * angle),
            is_ambiguous: false,
        }
    },
    ..Methods::OWN
};

/// `V Uᵀ` without a check that it is a rotation.
pub const NO_DETERMINANT_SIGN: Methods = Methods {
    frame: |body, weight_mm, readings, truth| {
        let own = FrameFitter::new(body, weight_mm).fit(readings, truth);
        let n = readings.len() as f64;
        let own_mean =
            body.sensors.iter().map(|s| s.position_in_body.coords).sum::<Vector3<f64>>() / n;
        let mean = readings.iter().map(|r| r.position_mm.coords).sum::<Vector3<f64>>() / n;
        let mut h = Matrix3::zeros();
        for (s, r) in body.sensors.iter().zip(readings) {
            h += (s.position_in_body.coords - own_mean) * (r.position_mm.coords - mean).transpose();
            if let SensorOrientation::FiveDof(axis) = s.orientation {
                let read = r.rotation * Vector3::z();
                h += axis.into_inner() * read.transpose() * (weight_mm * weight_mm);
            }
        }
        let svd = svd3(&h);
        let rotation = quaternion_from_matrix(&(svd.v * svd.u.transpose()));
        FrameFit { tracker_from_body: pose_from_parts(mean - rotation * own_mean, rotation), ..own }
    },
    ..Methods::OWN
};

/// Powers of the normalised coordinates instead of Bernstein polynomials.
pub const MONOMIALS: Methods = Methods {
    evaluate: |model, position_mm, axis, outside| {
        let at = match outside {
            OutsidePolicy::Extrapolate => *position_mm,
            OutsidePolicy::Clamp | OutsidePolicy::Reject => model.bounds().clamp(position_mm),
        };
        let n = model.order() + 1;
        let u = model.bounds().to_unit(&at);
        let binomial =
            |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
        // B_i = Σ_p C(n, i) C(n − i, p − i) (−1)^(p − i) x^p
        let factor = |i: usize, p: usize| {
            let sign = if (p - i).is_multiple_of(2) { 1.0 } else { -1.0 };
            binomial(n - 1, i) * binomial(n - 1 - i, p - i) * sign
        };
        let basis =
            |k: usize, i: usize| (i..n).map(|p| factor(i, p) * u[k].powi(p as i32)).sum::<f64>();
        let [x, y, z] = [0, 1, 2].map(|k| (0..n).map(|i| basis(k, i)).collect::<Vec<_>>());
        let mut values = [0.0; 6];
        let w = model.directions().weights(axis, model.weighting());
        for (&direction, weight) in w.directions.iter().zip(&w.weights) {
            let own = &model.coefficients()[direction * n * n * n..][..n * n * n];
            for (i, coefficient) in own.iter().enumerate() {
                let product = weight * x[i / (n * n)] * y[i / n % n] * z[i % n];
                for (value, c) in values.iter_mut().zip(coefficient) {
                    *value += product * c;
                }
            }
        }
        PoseError::of_values(values)
    },
    ..Methods::OWN
};

/// Derivatives by differences of values.
pub const DIFFERENCES: Methods = Methods {
    derivatives: |model, position_mm, axis, outside| {
        let at = |p: Point3<f64>, n: Unit<Vector3<f64>>| {
            nalgebra::Vector6::from(model.evaluate(&p, &n, outside).error.values())
        };
        let columns = |change: &dyn Fn(Vector3<f64>) -> nalgebra::Vector6<f64>, step: f64| {
            let slopes = [Vector3::x(), Vector3::y(), Vector3::z()]
                .map(|e| (change(e * step) - change(e * -step)) / (2.0 * step));
            Matrix6x3::from_columns(&slopes)
        };
        let n = axis.into_inner();
        [
            columns(&|d| at(position_mm + d, *axis), 1e-6 * model.bounds().diagonal_mm()),
            columns(&|d| at(*position_mm, Unit::new_normalize(n + d)), 1e-6),
        ]
    },
    ..Methods::OWN
};

/// `p ← p_m − e(p)` a few times, whatever the map is like.
pub const FIXED_POINT: Methods = Methods {
    undistort: |model, measured, _| {
        let poses = fixed_point(model, measured, 4).into_iter();
        poses.map(|pose| (Some(pose), InverseState::Converged)).collect()
    },
    ..Methods::OWN
};

/// Areas as angles' sum less π, angles by arccosine.
pub const ANGLES_SUM: Methods = Methods {
    weights: |set, axis, weighting| {
        let own = set.weights(axis, weighting);
        if weighting == Weighting::Gnomonic {
            return own;
        }
        let [a, b, c] = own.directions.map(|d| set.directions()[d].into_inner());
        let n = axis.into_inner();
        let area = |a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>| {
            let angle = |at: Vector3<f64>, p: Vector3<f64>, q: Vector3<f64>| {
                let (x, y) = (at.cross(&p), at.cross(&q));
                let both = x.norm() * y.norm();
                if both == 0.0 { 0.0 } else { (x.dot(&y) / both).clamp(-1.0, 1.0).acos() }
            };
            angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - std::f64::consts::PI
        };
        let areas = [area(n, b, c), area(a, n, c), area(a, b, n)];
        let sum: f64 = areas.iter().sum();
        DirectionWeights { directions: own.directions, weights: areas.map(|w| w / sum) }
    },
    ..Methods::OWN
};

/// Singular values by the eigenvalues of `MᵀM`.
pub const SQUARED_SINGULAR_VALUES: Methods = Methods {
    svd3: |matrix| {
        let eigen = (matrix.transpose() * matrix).symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let s = Vector3::from(order.map(|k| eigen.eigenvalues[k].max(0.0).sqrt()));
        let v = Matrix3::from_columns(&order.map(|k| eigen.eigenvectors.column(k).into_owned()));
        let u =
            matrix * v * Matrix3::from_diagonal(&s.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 }));
        Svd3 { u, singular_values: s, v }
    },
    ..Methods::OWN
};

/// Mean of squares less square of mean; plain sums.
pub const TEXTBOOK_VARIANCE: Methods = Methods {
    statistics: |values| {
        let own = Statistics::of(values)?;
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| v * v).sum::<f64>() / n;
        let std = (square - mean * mean).max(0.0).sqrt();
        Some(own.with(Summary::Std, std).with(Summary::Mean, mean))
    },
    ..Methods::OWN
};

/// `A` from moments about the body's origin, the mean taken off afterwards.
pub const MOMENTS_ABOUT_ORIGIN: Methods = Methods {
    covariance: |body, weight_mm, sensors, tip| {
        let n = body.sensors.len() as f64;
        let square = |x: Vector3<f64>| Matrix3::identity() * x.norm_squared() - x * x.transpose();
        let mean = body.sensors.iter().map(|s| s.position_in_body.coords).sum::<Vector3<f64>>() / n;
        let seen = |o: &SensorOrientation| match o {
            SensorOrientation::Marker => Matrix3::zeros(),
            SensorOrientation::FiveDof(a) => Matrix3::identity() - a.into_inner() * a.transpose(),
            SensorOrientation::SixDof(_) => Matrix3::identity() * 2.0,
        };
        let parts = body.sensors.iter();
        let a = parts
            .map(|s| square(s.position_in_body.coords) + seen(&s.orientation) * weight_mm.powi(2))
            .sum::<Matrix3<f64>>()
            - square(mean) * n;
        let inverse =
            a.try_inverse().ok_or(RotationNotDetermined { smallest: 0.0, largest: a.norm() })?;
        let lever = (tip.coords - mean).cross_matrix();
        let parts = body.sensors.iter().zip(sensors);
        Ok(parts
            .map(|(s, c)| {
                let x = s.position_in_body.coords - mean;
                let j = Matrix3::identity() / n - lever * inverse * x.cross_matrix();
                let k = -lever * inverse * seen(&s.orientation) * weight_mm.powi(2);
                j * c.position_mm2 * j.transpose() + k * c.rotation_rad2 * k.transpose()
            })
            .sum())
    },
    relative_error: |truth, simulated, tip| {
        let turn = (simulated.rotation * truth.rotation.inverse()).to_rotation_matrix();
        RelativeError {
            tip_error_in_crf_mm: simulated * tip - truth * tip,
            angle_rad: (0.5 * (turn.matrix().trace() - 1.0)).clamp(-1.0, 1.0).acos(),
        }
    },
    ..Methods::OWN
};

/// Everything right but for the last six digits.
pub const SINGLE_PRECISION: Methods = Methods {
    evaluate: |model, position_mm, axis, outside| {
        let values = model.evaluate(position_mm, axis, outside).error.values();
        PoseError::of_values(values.map(|v| f64::from(v as f32)))
    },
    ..Methods::OWN
};

/// Leaves values that are not numbers out of the smallest and largest, as `f64::min` does.
pub const NAN_IGNORED: Methods = Methods {
    statistics: |values| {
        let (min, max) = (
            values.iter().copied().fold(f64::INFINITY, f64::min),
            values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        );
        Statistics::of(values).map(|own| own.with(Summary::Min, min).with(Summary::Max, max))
    },
    ..Methods::OWN
};

/// `(2μ − u) / (2 (μ + u))`, `u = x² / (1 − x cot x) − 1`, as it is written.
pub const COTANGENT: Methods = Methods {
    sphere_factor: |radius_mm, material, frequency_hz| {
        let part = radius_mm * material.inverse_squared_skin_depth_per_mm2(frequency_hz).sqrt();
        let mu = material.relative_permeability();
        let x = Complex::new(part, part);
        let u = x * x / (-(x / x.tan()) + 1.0) - 1.0;
        Ok((-u + 2.0 * mu) / ((u + mu) * 2.0))
    },
    ..Methods::OWN
};

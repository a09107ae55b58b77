//! The fit: one least-squares system solved in several ways, against its solution refined with
//! residuals in 192 bits.

use super::sampling::poses;
use super::{Bench, Row, Settings, Stop, What};
use crate::high::{High, Zero};
use crate::high_linear::gradient;
use faer::linalg::solvers::{Solve, SolveLstsq};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, Par, Side};
use nalgebra::Vector3;
use trackwright_field::OutsidePolicy;
use trackwright_field::bernstein::{coefficient_count, products, push_products};
use trackwright_field::fit::DEFAULT_RCOND;
use trackwright_field::least_squares::{LeastSquares, Solution, Triangle};
use trackwright_simulation::Scenario;

/// Orders whose systems are solved, where not above the highest requested.
const ORDERS: [usize; 4] = [1, 2, 4, 6];

/// The order whose front is drawn: the largest that measured rooms bear.
const CHARTED_ORDER: usize = 4;

/// Largest wobble in millimetres that no polynomial fits, so that residuals are not zero.
const WOBBLE_MM: f64 = 0.1;

/// Steps of refinement; each gains what the condition's square leaves of 16 digits, here eight and more.
const REFINEMENTS: usize = 3;

/// Positions at which a solution's field is compared with the reference.
const PROBES: usize = 500;

const VALUES: usize = 6;

/// Of these the position's, which alone are compared.
const COMPARED: usize = 3;

/// Every way of solving a fit.
pub fn measure(bench: &mut Bench) -> Result<(), Stop> {
    let (scenario, settings) = (bench.scenario, bench.settings);
    bench.family.charted = problem(CHARTED_ORDER.min(settings.max_order));
    bench.family.about = format!(
        "Least squares (4) for one orientation on {} samples of the design's room, with a \
         wobble of {WOBBLE_MM} mm that no polynomial fits; rows are made in the time, one \
         thread. In the picture a line joins the orders of one method. The error is the \
         largest difference in position of the solution's field from that of the reference: \
         the solution refined with residuals in 192 bits. The default \
         knows rank and condition from the extreme singular values of R, and takes the SVD \
         where the rank is not certainly full.",
        settings.samples
    );
    let orders = ORDERS
        .into_iter()
        .filter(|&o| o <= settings.max_order && coefficient_count(o) <= settings.samples);
    let methods: [(&str, bool, Method); 5] = [
        ("QR by blocks, back substitution", true, blocks),
        ("QR by blocks, then SVD of R", false, blocks_then_svd),
        ("QR, back substitution", false, qr),
        ("SVD of the design matrix", false, svd),
        ("normal equations", false, normal_equations),
    ];
    bench.steps = orders.clone().count() * (methods.len() + 1);
    for order in orders {
        let system = System::new(scenario, settings, order);
        let Some(reference) = system.reference() else {
            continue;
        };
        bench.next()?;
        for (method, is_default, solve) in methods {
            let (seconds, solution) = settings.timing.measure(|| solve(&system));
            bench.next()?;
            let Some(solution) = solution else { continue };
            let error = system.field_difference_mm(&solution, &reference);
            let row = Row::new(What::Fit, bench.room(), &problem(order), method);
            let row = row.measured(settings.samples, seconds, error).default_if(is_default);
            bench.family.rows.push(Row { order, directions: 1, ..row.step_of(method) });
        }
    }
    Ok(())
}

fn problem(order: usize) -> String {
    format!("one orientation at order {order}")
}

/// A way to solve a system: six values a unknown; `None` where it fails.
type Method = fn(&System) -> Option<Mat<f64>>;

/// Rows to fit, and where to compare what comes of it.
struct System {
    order: usize,
    unit_positions: Vec<Vector3<f64>>,
    values: Vec<[f64; VALUES]>,
    probes: Vec<Vec<f64>>,
}

impl System {
    fn new(scenario: &Scenario, settings: &Settings, order: usize) -> Self {
        let model = &scenario.environment.model;
        let bounds = model.bounds();
        let (unit_positions, values) = poses(bounds, settings.samples, settings.seed)
            .into_iter()
            .enumerate()
            .map(|(i, (position, axis))| {
                let mut values =
                    model.evaluate(&position, &axis, OutsidePolicy::Clamp).error.values();
                for (value, k) in values.iter_mut().zip([0.0, 0.1, 0.2]) {
                    *value += WOBBLE_MM * (i as f64 * (1.0 + k)).sin();
                }
                (bounds.to_unit(&position), values)
            })
            .unzip();
        let probes = poses(bounds, PROBES, settings.seed + 1)
            .iter()
            .map(|(position, _)| products(order, &bounds.to_unit(position)))
            .collect();
        Self { order, unit_positions, values, probes }
    }

    fn unknowns(&self) -> usize {
        coefficient_count(self.order)
    }

    fn rows(&self) -> Vec<Vec<f64>> {
        self.unit_positions.iter().map(|at| products(self.order, at)).collect()
    }

    fn matrix(&self) -> Mat<f64> {
        let rows = self.rows();
        Mat::from_fn(rows.len(), self.unknowns(), |i, j| rows[i][j])
    }

    fn right_side(&self) -> Mat<f64> {
        Mat::from_fn(self.values.len(), VALUES, |i, k| self.values[i][k])
    }

    /// The exact positions' solution of the system as its `f64` numbers stand: what residuals in 192
    /// bits leave of the gradient is taken off by the triangle of a QR, `dx = R⁻¹ R⁻ᵀ Aᵀ (b − A x)`.
    fn reference(&self) -> Option<Vec<[High; COMPARED]>> {
        let rows = self.rows();
        let qr = self.matrix().qr();
        let r = qr.thin_R();
        let mut x = vec![vec![High::zero(); self.unknowns()]; COMPARED];
        for (k, x) in x.iter_mut().enumerate() {
            for _ in 0..=REFINEMENTS {
                let (gradient, _) = gradient(&rows, |i| self.values[i][k], x);
                let mut step = Mat::from_fn(x.len(), 1, |j, _| gradient[j]);
                solve_lower_triangular_in_place(r.transpose(), step.as_mut(), Par::Seq);
                solve_upper_triangular_in_place(r, step.as_mut(), Par::Seq);
                x.iter_mut().enumerate().for_each(|(j, x)| *x += step[(j, 0)]);
            }
        }
        let is_finite = x.iter().flatten().all(|v| v.to_f64().is_finite());
        let solution = (0..self.unknowns()).map(|j| std::array::from_fn(|k| x[k][j].clone()));
        is_finite.then(|| solution.collect())
    }

    /// Largest difference of two solutions' fields over the probes.
    fn field_difference_mm(&self, found: &Mat<f64>, exact: &[[High; COMPARED]]) -> f64 {
        let off: Vec<[f64; COMPARED]> = (exact.iter().enumerate())
            .map(|(j, exact)| {
                std::array::from_fn(|k| (High::from(found[(j, k)]) - &exact[k]).to_f64())
            })
            .collect();
        let length = |row: &Vec<f64>| {
            let sum = |k: usize| row.iter().zip(&off).map(|(p, off)| p * off[k]).sum::<f64>();
            Vector3::from_fn(|k, _| sum(k)).norm()
        };
        self.probes.iter().map(length).fold(0.0, f64::max)
    }
}

/// What a fit does: the rank is certain from the extreme singular values of R, or its SVD decides.
fn blocks(system: &System) -> Option<Mat<f64>> {
    Some(matrix_of(&triangle(system).solve(DEFAULT_RCOND, 0.0).ok()?))
}

fn blocks_then_svd(system: &System) -> Option<Mat<f64>> {
    Some(matrix_of(&triangle(system).decompose().ok()?.solve(DEFAULT_RCOND, 0.0)))
}

fn matrix_of(found: &Solution) -> Mat<f64> {
    Mat::from_fn(found.unknowns.len(), VALUES, |i, k| found.unknowns[i][k])
}

fn triangle(system: &System) -> Triangle {
    let mut least_squares = LeastSquares::new(system.unknowns());
    for (at, values) in system.unit_positions.iter().zip(&system.values) {
        least_squares.push(|out| push_products(system.order, at, out), *values);
    }
    least_squares.into_triangle()
}

fn qr(system: &System) -> Option<Mat<f64>> {
    Some(system.matrix().qr().solve_lstsq(system.right_side()))
}

fn svd(system: &System) -> Option<Mat<f64>> {
    let svd = system.matrix().thin_svd().ok()?;
    let mut rotated = svd.U().transpose() * system.right_side();
    for (i, s) in svd.S().column_vector().iter().enumerate() {
        for k in 0..VALUES {
            rotated[(i, k)] /= s;
        }
    }
    Some(svd.V() * rotated)
}

/// The condition of the design matrix squared: here to be seen, used nowhere else.
fn normal_equations(system: &System) -> Option<Mat<f64>> {
    let a = system.matrix();
    let squared = a.transpose() * &a;
    let right = a.transpose() * system.right_side();
    Some(squared.llt(Side::Lower).ok()?.solve(right))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Timing, testing};
    use trackwright_geometry::directions::{DirectionSet, Weighting};

    fn system(order: usize) -> System {
        let settings = Settings { timing: Timing::ONCE, samples: 1500, ..Settings::default() };
        let model = testing::model(2, DirectionSet::Six, Weighting::Area);
        System::new(&testing::scenario(model), &settings, order)
    }

    #[test]
    fn the_reference_residual_is_perpendicular() {
        let system = system(4);
        let x = system.reference().unwrap();
        for k in 0..COMPARED {
            let x: Vec<High> = x.iter().map(|x| x[k].clone()).collect();
            let (gradient, _) = gradient(&system.rows(), |i| system.values[i][k], &x);
            // f64 alone would leave 1e-13 of it.
            assert!(gradient.iter().all(|g| g.abs() < 1e-22), "{gradient:?}");
        }
    }

    #[test]
    fn normal_equations_lose_the_squared_condition() {
        let system = system(5);
        let exact = system.reference().unwrap();
        let error = |method: Method| system.field_difference_mm(&method(&system).unwrap(), &exact);
        let orthogonal = [blocks, blocks_then_svd, qr, svd].map(|m| error(m));
        assert!(orthogonal.iter().all(|&e| e < 1e-11), "{orthogonal:?}");
        let squared = error(normal_equations);
        assert!(orthogonal.iter().all(|&e| squared > 3.0 * e), "{squared:e} {orthogonal:?}");
    }
}

//! Several bodies in each other's fields: each answers the coils and the others until all stay.
//!
//! Each body answers the field normal to its surface at its own samples: panels of a surface, directions
//! of a sphere. What another body's unknowns make there is a matrix of the two bodies and their relative
//! pose. Answers are exchanged one body after the other (Schwarz's alternating method), where what is left
//! falls by about (size/distance)⁶ a round, and mixed, so that bodies which nearly touch converge too.

use crate::body::Solver;
use crate::boundary::BoundaryBody;
use crate::mixing::Mixing;
use crate::panel::Panel;
use crate::phase::with_no_lag;
use crate::sphere::multipoles::SphereBody;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{DVector, Point3, Unit, Vector3};
use rayon::prelude::*;
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_geometry::pose::Pose;
use trackwright_task::{Cancelled, Task};

/// Unknowns that change by less than this part of themselves in a round stay. Positions that a tracker
/// reports change by less than 10⁻⁵ mm then.
const STAYS: f64 = 1e-8;

/// Rounds after which bodies count as too near to each other. Cubes apart by their side take 5, by a
/// fortieth of it 15, and up to 31 by next to nothing.
const MAX_ROUNDS: usize = 100;

/// Why the bodies' fields are not known.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ExchangeError {
    #[error(
        "the fields of the bodies did not converge: they still change by {change:.1e} of themselves after {rounds} rounds"
    )]
    NoConvergence { rounds: usize, change: f64 },
    #[error("the field of the coils at the metal is not finite")]
    NotFinite,
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// How an exchange ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExchangeReport {
    /// 0 where no body is in another's field.
    pub rounds: usize,
    /// Largest relative change of a coil's answer in the last round.
    pub change: f64,
}

/// A body that answers, about its own frame.
#[derive(Clone, Debug)]
pub(crate) enum Answer {
    None,
    Sphere(SphereBody),
    Surface(Arc<BoundaryBody>),
}

impl Answer {
    /// Of a body whose sources are no nearer to its middle than so far.
    pub fn new(solver: &Solver, nearest_mm: f64) -> Self {
        match solver {
            Solver::None => Self::None,
            Solver::Sphere(response) => {
                let degree =
                    crate::sphere::multipoles::degree_for(response.radius_mm(), nearest_mm);
                Self::Sphere(SphereBody::new(response, degree))
            }
            Solver::Surface(body) => Self::Surface(Arc::clone(body)),
        }
    }

    /// Whether this answers as the other: their bodies and degrees are the same.
    pub fn is_alike(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::None, Self::None) => true,
            (Self::Sphere(one), Self::Sphere(other)) => one == other,
            (Self::Surface(one), Self::Surface(other)) => Arc::ptr_eq(one, other),
            _ => false,
        }
    }

    fn samples(&self) -> usize {
        match self {
            Self::None => 0,
            Self::Sphere(sphere) => sphere.directions().len(),
            Self::Surface(body) => body.surface().panels().len() + body.shape().spans().len(),
        }
    }

    fn unknowns(&self) -> usize {
        match self {
            Self::None => 0,
            Self::Sphere(sphere) => sphere.terms(),
            Self::Surface(body) => body.unknowns(),
        }
    }

    /// Unknowns in phase that answer a normal field at the samples.
    fn in_phase(&self, normal_field: &Mat<f64>) -> Mat<f64> {
        match self {
            Self::None => Mat::zeros(0, normal_field.ncols()),
            Self::Sphere(sphere) => sphere.answer().in_phase_of(normal_field),
            Self::Surface(body) => body.answer().in_phase_of(&body.without_mean(normal_field)),
        }
    }

    /// Likewise of fields in phase and fields that lag, one half of the columns each.
    fn both(&self, normal_field: &Mat<f64>) -> Mat<f64> {
        match self {
            Self::None => Mat::zeros(0, normal_field.ncols()),
            Self::Sphere(sphere) => sphere.answer().of_both(normal_field),
            Self::Surface(body) => body.answer().of_both(&body.without_mean(normal_field)),
        }
    }

    /// Normal field of all coils at the samples; a column a coil.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn normal_field(
        &self,
        tracker_from_body: &Pose,
        coils: &CoilField<'_>,
        task: &Task,
    ) -> Result<Mat<f64>, Cancelled> {
        let count = coils.generator.coils.len();
        let row = |points: &[Point3<f64>], normal: &Unit<Vector3<f64>>| {
            let normal = tracker_from_body.rotation * normal.into_inner();
            let mut fields = vec![Vector3::zeros(); count];
            let mut sums = vec![0.0; count];
            for p in points {
                coils.generator.field(&(tracker_from_body * p), &mut fields);
                for (sum, field) in sums.iter_mut().zip(&fields) {
                    *sum += field.dot(&normal) / points.len() as f64;
                }
            }
            sums
        };
        let smooth_mm = |center: &Point3<f64>| coils.distance_mm(&(tracker_from_body * center));
        self.sampled(count, smooth_mm, row, task)
    }

    /// What the field of unknowns is of, which all points have in common.
    pub fn sources(&self, unknowns: Mat<f64>) -> Mat<f64> {
        match self {
            Self::Surface(body) => body.sources(&unknowns),
            Self::None | Self::Sphere(_) => unknowns,
        }
    }

    /// Adds the fields of sources, a column a coil, at a point outside, in the body's frame.
    pub fn add_fields(&self, sources: &Mat<f64>, p: &Point3<f64>, fields: &mut [Vector3<f64>]) {
        match self {
            Self::None => {}
            Self::Sphere(sphere) => sphere.add_fields(sources, p, fields),
            Self::Surface(body) => body.add_fields(sources, p, fields),
        }
    }

    /// Normal field at this body's samples of each unknown of another one; rows are samples.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn coupling(
        &self,
        source: &Self,
        body_from_source: &Pose,
        task: &Task,
    ) -> Result<Mat<f64>, Cancelled> {
        let columns = source.unknowns();
        let source_from_body = body_from_source.inverse();
        let row = |points: &[Point3<f64>], normal: &Unit<Vector3<f64>>| {
            let normal = source_from_body.rotation * normal.into_inner();
            let share = 1.0 / points.len() as f64;
            let mut row = vec![0.0; columns];
            for p in points {
                source.for_unit_fields(&(source_from_body * p), |unknown, field| {
                    row[unknown] += field.dot(&normal) * share;
                });
            }
            row
        };
        let smooth_mm = |center: &Point3<f64>| {
            let from_middle_mm = (source_from_body * center).coords.norm();
            // A sphere's field varies over the distance from it.
            match source {
                Self::Sphere(sphere) => from_middle_mm - sphere.radius_mm(),
                Self::None | Self::Surface(_) => from_middle_mm,
            }
        };
        self.sampled(columns, smooth_mm, row, task)
    }

    /// A row of numbers for each sample, of the points of its rule and its normal. `smooth_mm` is the
    /// distance over which what is sampled varies, at the middle of a panel.
    fn sampled(
        &self,
        columns: usize,
        smooth_mm: impl Fn(&Point3<f64>) -> f64 + Sync,
        row: impl Fn(&[Point3<f64>], &Unit<Vector3<f64>>) -> Vec<f64> + Sync,
        task: &Task,
    ) -> Result<Mat<f64>, Cancelled> {
        let row = |points: &[Point3<f64>], normal: &Unit<Vector3<f64>>| match task
            .cancel
            .is_cancelled()
        {
            true => Err(Cancelled),
            false => Ok(row(points, normal)),
        };
        let rows: Vec<Vec<f64>> = match self {
            Self::None => Vec::new(),
            Self::Sphere(sphere) => sphere
                .directions()
                .par_iter()
                .map(|d| row(&[Point3::from(d.into_inner() * sphere.radius_mm())], d))
                .collect::<Result<_, _>>()?,
            Self::Surface(body) => {
                let mean = |panel: &Panel| {
                    row(&panel.rule_mm(smooth_mm(panel.center_mm())), panel.normal())
                };
                // The flux through a hole.
                let through = |span: &Vec<(f64, Panel)>| {
                    let mut sums = vec![0.0; columns];
                    for (share, panel) in span {
                        let by = share * panel.area_mm2();
                        sums.iter_mut()
                            .zip(mean(panel)?)
                            .for_each(|(sum, field)| *sum += by * field);
                    }
                    Ok(sums)
                };
                let spans = body.shape().spans().par_iter().map(through);
                let all = body.surface().panels().par_iter().map(mean).chain(spans);
                all.collect::<Result<_, _>>()?
            }
        };
        Ok(Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]))
    }

    /// Calls `each` with every unknown and the field that a unit of it has at a point outside.
    fn for_unit_fields(&self, p: &Point3<f64>, each: impl FnMut(usize, Vector3<f64>)) {
        match self {
            Self::None => {}
            Self::Sphere(sphere) => sphere.for_fields(p, each),
            Self::Surface(body) => body.for_unit_fields(p, each),
        }
    }
}

/// A generator, and where its wires are.
#[derive(Clone, Debug)]
pub(crate) struct CoilField<'a> {
    pub generator: &'a Generator,
    /// Points of all coils' wires.
    pub wires_mm: &'a [Vec<Point3<f64>>],
}

impl CoilField<'_> {
    /// Distance of a point from the nearest wire.
    pub fn distance_mm(&self, p: &Point3<f64>) -> f64 {
        let squares = self.wires_mm.iter().flatten().map(|wire| (p - wire).norm_squared());
        squares.fold(f64::INFINITY, f64::min).sqrt()
    }
}

/// Unknowns of all bodies that answer the coils' normal fields and each other.
///
/// `couplings[i][j]` is that of body `i` with the unknowns of body `j`; `None` where there is none.
///
/// # Errors
/// Fields that are not finite or do not converge, and [`Cancelled`].
pub(crate) fn exchange(
    answers: &[Arc<Answer>],
    normal_fields: &[Arc<Mat<f64>>],
    couplings: &[Vec<Option<Arc<Mat<f64>>>>],
    task: &Task,
) -> Result<(Vec<Mat<f64>>, ExchangeReport), ExchangeError> {
    let is_finite = |field: &Mat<f64>| field.norm_l1().is_finite();
    if !normal_fields.iter().all(|field| is_finite(field)) {
        return Err(ExchangeError::NotFinite);
    }
    let mut report = ExchangeReport::default();
    let each = answers.iter().zip(normal_fields);
    if couplings.iter().flatten().all(Option::is_none) {
        return Ok((each.map(|(answer, field)| answer.in_phase(field)).collect(), report));
    }
    let mut unknowns: Vec<Mat<f64>> =
        each.map(|(answer, field)| answer.both(&with_no_lag(field))).collect();
    let coils = normal_fields.first().map_or(0, |field| field.ncols());
    let mut mixing: Vec<Mixing> = (0..coils).map(|_| Mixing::default()).collect();
    for rounds in 1..=MAX_ROUNDS {
        let before: Vec<DVector<f64>> = (0..coils).map(|coil| stacked(&unknowns, coil)).collect();
        for (i, answer) in answers.iter().enumerate() {
            if task.cancel.is_cancelled() {
                return Err(Cancelled.into());
            }
            let mut field = with_no_lag(&normal_fields[i]);
            for (other, coupling) in unknowns.iter().zip(&couplings[i]) {
                if let Some(coupling) = coupling {
                    let (one, par) = (1.0, Par::Seq);
                    matmul(field.as_mut(), Accum::Add, coupling.as_ref(), other.as_ref(), one, par);
                }
            }
            unknowns[i] = answer.both(&field);
        }
        let after: Vec<DVector<f64>> = (0..coils).map(|coil| stacked(&unknowns, coil)).collect();
        let changes = before.iter().zip(&after).map(|(before, after)| change(before, after));
        report = ExchangeReport { rounds, change: changes.fold(0.0, f64::max) };
        if report.change <= STAYS {
            let in_phase = |of: Mat<f64>| of.as_ref().subcols(0, coils).to_owned();
            return Ok((unknowns.into_iter().map(in_phase).collect(), report));
        }
        if !report.change.is_finite() {
            break;
        }
        for (coil, mixing) in mixing.iter_mut().enumerate() {
            unstack(&mixing.next(&before[coil], &after[coil]), coil, &mut unknowns);
        }
    }
    let ExchangeReport { rounds, change } = report;
    Err(ExchangeError::NoConvergence { rounds, change })
}

/// Unknowns of all bodies for one coil, in phase and what lags.
fn stacked(unknowns: &[Mat<f64>], coil: usize) -> DVector<f64> {
    let count: usize = unknowns.iter().map(Mat::nrows).sum();
    let parts = |of: &Mat<f64>| [coil, coil + of.ncols() / 2];
    let all = unknowns.iter().flat_map(|of_body| {
        parts(of_body).into_iter().flat_map(|column| of_body.col(column).iter().copied())
    });
    DVector::from_iterator(2 * count, all)
}

fn unstack(stacked: &DVector<f64>, coil: usize, unknowns: &mut [Mat<f64>]) {
    let mut values = stacked.iter();
    for of_body in unknowns {
        for column in [coil, coil + of_body.ncols() / 2] {
            for (unknown, value) in of_body.col_mut(column).iter_mut().zip(&mut values) {
                *unknown = *value;
            }
        }
    }
}

/// Change of one coil's unknowns relative to them; infinite where that is no number, which `f64::max`
/// would pass over.
fn change(before: &DVector<f64>, after: &DVector<f64>) -> f64 {
    let change = (after - before).norm();
    if change == 0.0 {
        return 0.0;
    }
    let relative = change / after.norm();
    if relative.is_finite() { relative } else { f64::INFINITY }
}

/// Samples times unknowns of one body by another: what a coupling's numbers take.
pub(crate) fn coupling_size(target: &Answer, source: &Answer) -> usize {
    target.samples() * source.unknowns()
}

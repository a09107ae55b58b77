//! The bodies of a solution: their places with intervals, their kind and their form, and what makes each doubtful.

use super::extended::OF_EXTENDED;
use super::extended::nearly_spheres;
use super::multipoles::{OF_TENSOR, tensor};
use super::rows::Rows;
use super::solve::Solution;
use super::sources::{OF_BODY, Source, SourceModel, radius_mm};
use crate::setup::WITHIN_95;
use nalgebra::{Matrix3, Point3, SMatrix, SVector, SymmetricEigen, Unit, Vector3};
use trackwright_field::generator::Coil;
use trackwright_geometry::bounds::Bounds;

/// Of two independent normal numbers 95 % are within a circle of so many standard deviations.
const CIRCLE_95: f64 = 2.447_747;

/// A strength that is not so many standard deviations from zero may be noise. The search takes the best
/// of some hundred independent places, whose largest by chance is 3 to 4.
pub const CLEAR_STRENGTH: f64 = 5.0;

/// A position is determined where its interval's half length, along its worst axis, is no more than this
/// part of the distance from the middle of the measurements, or of half the diagonal of their box where the
/// body is nearer than that.
pub const POSITION_LIMIT: f64 = 0.2;

/// Other bodies that explain the rows by less than this worse, in squares of noise, may be the true ones:
/// what 95 % of a χ² of four degrees of freedom are within.
const AS_GOOD: f64 = 9.49;

/// Extent of a body over the distance of the nearest sample, above which multipoles don't converge.
pub const EXTENT_LIMIT: f64 = 0.8;

/// Standard deviations that two strengths along axes are apart in bodies whose form is stated, and how many times the
/// smaller one the larger one is.
const CLEAR_FORM: f64 = 4.0;
const LEAST_RATIO: f64 = 1.4;

/// A strength of the other sign up to this part of the largest one, or so many standard deviations, is none.
const OTHER_SIGN: f64 = 0.1;
const CLEAR_SIGN: f64 = 3.0;

/// 95 % of repeated measurements give an interval with the true value in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    pub fn half_length(&self) -> f64 {
        0.5 * (self.high - self.low)
    }
}

/// What a body does to a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetalKind {
    /// Eddy currents keep the field out: the strength is below zero.
    Conductor,
    /// Magnetisation draws the field in: the strength is above zero.
    Ferromagnetic,
}

/// Why a body is not determined.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BodyDoubt {
    #[error(
        "its strength is {deviations:.1} standard deviations from zero, expected {CLEAR_STRENGTH}"
    )]
    Strength { deviations: f64 },
    #[error("its position is not known to {limit_mm:.0} mm")]
    Position { half_length_mm: f64, limit_mm: f64 },
    #[error(
        "it may as well be at ({:.0}, {:.0}, {:.0}) mm", other_mm.x, other_mm.y, other_mm.z
    )]
    Elsewhere { other_mm: Point3<f64> },
    #[error("it is too large beside its distance of {nearest_mm:.0} mm from the nearest sample")]
    Large { nearest_mm: f64 },
    #[error("the bodies leave more than noise")]
    Misfit,
    #[error("the measurements do not determine it")]
    NotDetermined,
    /// No such body can be: it stands for something else.
    #[error("it is behind the generator's coils")]
    BehindGenerator,
    /// As above.
    #[error("it strengthens the field along one axis and weakens it along another")]
    BothSigns,
}

impl BodyDoubt {
    /// Whether there is no such body, whatever else disturbs.
    pub fn is_phantom(&self) -> bool {
        matches!(self, Self::BehindGenerator | Self::BothSigns)
    }
}

/// A form that the strengths along a body's axes state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Flat: the axis is its normal.
    Plate,
    /// Long: the axis is its own.
    Rod,
}

/// How a flat or long body is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyForm {
    pub form: Form,
    /// In the tracker frame; its sign has no meaning.
    pub axis: Unit<Vector3<f64>>,
    /// 95 % of repeated measurements have the true axis within this angle.
    pub axis_within95_rad: f64,
}

/// What is known of a body that is determined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownBody {
    /// Covariance of the middle in the tracker frame.
    pub center_cov_mm2: Matrix3<f64>,
    /// 95 % intervals of x, y and z.
    pub center_mm: [Interval; 3],
    /// Half length of the 95 % interval along the axis of which least is known.
    pub half_length_mm: f64,
    pub strength_mm3: Interval,
    /// Of the equivalent sphere, see [`Source::radius_mm`].
    pub radius_mm: Interval,
    /// Along its axes, the largest first; all the same of a sphere.
    pub strengths_mm3: [f64; 3],
    /// `None` where it is compact, or not known to be anything else.
    pub form: Option<BodyForm>,
}

/// A body that explains a part of the disturbance.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundBody {
    /// Of a body that is not a sphere, of the mean strength along its axes.
    pub source: Source,
    pub kind: MetalKind,
    /// From the middle to the nearest true position measured.
    pub nearest_mm: f64,
    /// Or why it is not determined; then no number of it means anything.
    pub known: Result<KnownBody, BodyDoubt>,
}

impl FoundBody {
    pub fn doubt(&self) -> Option<&BodyDoubt> {
        self.known.as_ref().err()
    }
}

/// The bodies of a solution, the strongest first.
pub(super) fn found_bodies(
    rows: &Rows,
    best: &Solution,
    others: &[Solution],
    is_misfit: bool,
) -> Vec<FoundBody> {
    let covariance = match best.model {
        SourceModel::Multipoles => best.covariance(rows.dof),
        // What is compact is seldom a sphere.
        SourceModel::Dipoles | SourceModel::Spheres => nearly_spheres(rows, best),
    };
    let bounds = Bounds::around(rows.positions_mm.iter().copied());
    let variance = best.variance(rows.dof).max(1.0);
    let rival = others.iter().find(|other| other.loss - best.loss < AS_GOOD * variance);
    let is_extended = best.model == SourceModel::Multipoles;
    let of_body = if is_extended { OF_EXTENDED } else { OF_BODY };
    let body = |(k, source): (usize, &Source)| {
        let (half_mm, middle_mm) =
            bounds.map_or((0.0, source.center_mm), |b| (0.5 * b.diagonal_mm(), b.center_mm()));
        let limit_mm = POSITION_LIMIT * (source.center_mm - middle_mm).norm().max(half_mm);
        let nearest = rows.positions_mm.iter().map(|p| (p - source.center_mm).norm());
        let nearest_mm = nearest.fold(f64::INFINITY, f64::min);
        let strengths = match &covariance {
            None => Err(BodyDoubt::NotDetermined),
            Some(all) if is_extended => {
                let block =
                    all.fixed_view::<OF_TENSOR, OF_TENSOR>(k * of_body + 3, k * of_body + 3);
                Strengths::of_tensor(&best.extended[k].entries, &block.into_owned())
            }
            Some(all) => {
                let at = k * of_body + 3;
                Ok(Strengths::of_sphere(source.strength_mm3, all[(at, at)].sqrt()))
            }
        };
        let mean_mm3 = strengths.as_ref().map_or(source.strength_mm3, |s| s.kind_mm3);
        let known = || -> Result<KnownBody, BodyDoubt> {
            if is_behind(rows, &source.center_mm) {
                return Err(BodyDoubt::BehindGenerator);
            }
            let strengths = strengths?;
            let all = covariance.as_ref().ok_or(BodyDoubt::NotDetermined)?;
            let cov = all.fixed_view::<3, 3>(k * of_body, k * of_body).into_owned();
            let half_length_mm = WITHIN_95 * cov.symmetric_eigenvalues().max().sqrt();
            if half_length_mm.is_nan() || half_length_mm > limit_mm {
                return Err(BodyDoubt::Position { half_length_mm, limit_mm });
            }
            if strengths.deviations < CLEAR_STRENGTH {
                return Err(BodyDoubt::Strength { deviations: strengths.deviations });
            }
            if let Some(other_mm) = rival.and_then(|r| elsewhere(source, half_length_mm, r)) {
                return Err(BodyDoubt::Elsewhere { other_mm });
            }
            if is_extended && best.extended[k].extent_mm > EXTENT_LIMIT * nearest_mm {
                return Err(BodyDoubt::Large { nearest_mm });
            }
            if is_misfit {
                return Err(BodyDoubt::Misfit);
            }
            let axis = |axis: usize| {
                let half = WITHIN_95 * cov[(axis, axis)].sqrt();
                let middle = source.center_mm[axis];
                Interval { low: middle - half, high: middle + half }
            };
            let Interval { low, high } = strengths.mean_mm3;
            let [small, large] = if low < 0.0 { [high, low] } else { [low, high] };
            Ok(KnownBody {
                center_cov_mm2: cov,
                center_mm: [0, 1, 2].map(axis),
                half_length_mm,
                strength_mm3: strengths.mean_mm3,
                radius_mm: Interval { low: radius_mm(small), high: radius_mm(large) },
                strengths_mm3: strengths.along_axes_mm3,
                form: strengths.form,
            })
        };
        FoundBody {
            source: *source,
            kind: match mean_mm3 < 0.0 {
                true => MetalKind::Conductor,
                false => MetalKind::Ferromagnetic,
            },
            nearest_mm,
            known: known(),
        }
    };
    let mut bodies: Vec<FoundBody> = best.sources.iter().enumerate().map(body).collect();
    bodies.sort_by(|a, b| b.source.strength_mm3.abs().total_cmp(&a.source.strength_mm3.abs()));
    bodies
}

/// Whether a body is on the other side of all coils than the measurements.
fn is_behind(rows: &Rows, center_mm: &Point3<f64>) -> bool {
    let mean = |points: &mut dyn Iterator<Item = Point3<f64>>| {
        let (sum, count) =
            points.fold((Vector3::zeros(), 0.0), |(sum, n), p| (sum + p.coords, n + 1.0));
        Point3::from(sum / f64::max(count, 1.0))
    };
    let coil_at = |coil: &Coil| {
        let (Coil::Dipole { at_mm, .. } | Coil::SquareLoop { center_mm: at_mm, .. }) = coil;
        *at_mm
    };
    let coils = || rows.generator.coils.iter().map(coil_at);
    let toward = mean(&mut rows.positions_mm.iter().copied()) - mean(&mut coils());
    let nearest = coils().map(|p| p.coords.dot(&toward)).fold(f64::INFINITY, f64::min);
    center_mm.coords.dot(&toward) < nearest
}

/// What is known of a body's strength along each axis.
struct Strengths {
    mean_mm3: Interval,
    /// The largest one, with its sign.
    kind_mm3: f64,
    /// Of the largest one from zero.
    deviations: f64,
    along_axes_mm3: [f64; 3],
    form: Option<BodyForm>,
}

impl Strengths {
    fn of_sphere(strength_mm3: f64, log_std_dev: f64) -> Self {
        let factor = (WITHIN_95 * log_std_dev).exp();
        let ends = [strength_mm3 / factor, strength_mm3 * factor];
        Self {
            mean_mm3: Interval { low: ends[0].min(ends[1]), high: ends[0].max(ends[1]) },
            kind_mm3: strength_mm3,
            deviations: 1.0 / log_std_dev,
            along_axes_mm3: [strength_mm3; 3],
            form: None,
        }
    }

    fn of_tensor(
        entries: &[f64],
        cov: &SMatrix<f64, OF_TENSOR, OF_TENSOR>,
    ) -> Result<Self, BodyDoubt> {
        let eigen = SymmetricEigen::new(tensor(entries));
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[b].abs().total_cmp(&eigen.eigenvalues[a].abs()));
        let values = order.map(|k| eigen.eigenvalues[k]);
        let axes = order.map(|k| eigen.eigenvectors.column(k).into_owned());
        // Slope of `uᵀ G v` by the entries, and the standard deviation of sums of such.
        let slope = |u: &Vector3<f64>, v: &Vector3<f64>| {
            let both = |i: usize, j: usize| u[i] * v[j] + u[j] * v[i];
            SVector::<f64, OF_TENSOR>::new(
                u.x * v.x,
                u.y * v.y,
                u.z * v.z,
                both(0, 1),
                both(0, 2),
                both(1, 2),
            )
        };
        let std_dev = |slope: SVector<f64, OF_TENSOR>| slope.dot(&(cov * slope)).max(0.0).sqrt();
        let of_value = |k: usize| slope(&axes[k], &axes[k]);
        let sign = values[0].signum();
        for k in [1, 2] {
            let other = -sign * values[k];
            if other > OTHER_SIGN * values[0].abs() && other > CLEAR_SIGN * std_dev(of_value(k)) {
                return Err(BodyDoubt::BothSigns);
            }
        }
        let apart = |a: usize, b: usize| {
            let gap = (values[a] - values[b]).abs();
            gap > CLEAR_FORM * std_dev(of_value(a) - of_value(b))
                && values[a].abs() > LEAST_RATIO * values[b].abs()
        };
        // The axis that differs from the two others.
        let is_first = (values[0] - values[1]).abs() > (values[1] - values[2]).abs();
        let (own, others) = if is_first { (0, [1, 2]) } else { (2, [0, 1]) };
        let form = others.iter().all(|&k| apart(own.min(k), own.max(k))).then(|| {
            let turn =
                |k: usize| std_dev(slope(&axes[own], &axes[k])) / (values[own] - values[k]).abs();
            BodyForm {
                form: if is_first == (sign < 0.0) { Form::Plate } else { Form::Rod },
                axis: Unit::new_normalize(axes[own]),
                axis_within95_rad: CIRCLE_95 * turn(others[0]).max(turn(others[1])),
            }
        });
        let mean = (values[0] + values[1] + values[2]) / 3.0;
        let third = SVector::<f64, OF_TENSOR>::new(1.0, 1.0, 1.0, 0.0, 0.0, 0.0) / 3.0;
        let half = WITHIN_95 * std_dev(third);
        Ok(Self {
            mean_mm3: Interval { low: mean - half, high: mean + half },
            kind_mm3: values[0],
            deviations: values[0].abs() / std_dev(of_value(0)),
            along_axes_mm3: values,
            form,
        })
    }
}

/// Where another solution has a body instead, farther than a body's interval.
fn elsewhere(source: &Source, half_length_mm: f64, rival: &Solution) -> Option<Point3<f64>> {
    let distance = |other: &&Source| (other.center_mm - source.center_mm).norm();
    let nearest = rival.sources.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    (distance(&nearest) > 2.0 * half_length_mm).then_some(nearest.center_mm)
}

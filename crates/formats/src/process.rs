//! The part of an environment that states what its measurements leave open of the field.

use super::computed_model::{self, HarmonicEntry};
use super::error::FormatError;
use super::ron_text::{self, RonWriter};
use nalgebra::{Unit, Vector3};
use serde::Deserialize;
use std::f64::consts::PI;
use std::sync::Arc;
use trackwright_field::FieldPoint;
use trackwright_field::gaussian::{
    Amplitude, ErrorValues, GaussianField, Kernel, KernelScale, Registration, Row, Trend,
};
use trackwright_geometry::limits::{length_above_zero_problem, length_problem, position_problem};
use trackwright_geometry::number::shortest;

/// Comments that are written with a process.
pub(super) const ROWS_COMMENT: &str =
    "// Position in mm, axis, error in mm and rad, noise of an outlier.";
pub(super) const REFITS_COMMENT: &str = "// The model without one group of the measurements each.";

/// Squared length of an axis whose components are rounded to 1e-9 may be off 1 by this.
const AXIS_TOLERANCE: f64 = 1e-6;

#[derive(Deserialize)]
#[serde(rename = "Process", deny_unknown_fields)]
pub(super) struct ProcessEntry {
    trend: Trend,
    kernel: Kernel,
    amplitude: Amplitude,
    covariance: [ErrorValues; 6],
    has_rotations: bool,
    measured_rows: usize,
    left_out_rms_mm: f64,
    #[serde(default)]
    sensor_variance: Option<ErrorValues>,
    rows: Vec<RowEntry>,
    #[serde(default)]
    refits: Vec<HarmonicEntry>,
    #[serde(default)]
    registration: Option<Registration>,
}

/// Position, axis, error, the noise of an outlier (1 of others), and the second axis of a 6-DOF sensor.
#[derive(Deserialize)]
struct RowEntry(
    [f64; 3],
    [f64; 3],
    ErrorValues,
    #[serde(default = "usual_noise")] f64,
    #[serde(default)] Option<[f64; 3]>,
);

fn usual_noise() -> f64 {
    1.0
}

impl ProcessEntry {
    pub(super) fn check(self) -> Result<Arc<GaussianField>, FormatError> {
        let check = |name: &str, value: f64, problem: Option<&'static str>| match problem {
            None => Ok(()),
            Some(expected) => Err(FormatError::number(format!("process.{name}"), value, expected)),
        };
        // Kernels of larger and smaller numbers are none any more after they are squared.
        let positive = |value: f64| (!(1e-12..=1e12).contains(&value)).then_some("1e-12 to 1e12");
        let is_sine = |value: f64| value == f64::INFINITY || (1e-6..=1e12).contains(&value);
        let sine = |value: f64| (!is_sine(value)).then_some("1e-6 to 1e12, or inf");
        check("kernel.nugget", self.kernel.nugget, positive(self.kernel.nugget))?;
        for KernelScale { length_mm, axis_sine, x_axis_sine, variance } in self.kernel.scales {
            check("kernel.scales.length_mm", length_mm, length_above_zero_problem(length_mm))?;
            check("kernel.scales.variance", variance, positive(variance))?;
            // Infinite where axes were not measured.
            check("kernel.scales.axis_sine", axis_sine, sine(axis_sine))?;
            check("kernel.scales.x_axis_sine", x_axis_sine, sine(x_axis_sine))?;
        }
        check("left_out_rms_mm", self.left_out_rms_mm, length_problem(self.left_out_rms_mm))?;
        if let Some((name, found)) = self.amplitude.problem() {
            check(name, found, Some("a number within its limits"))?;
        }
        let is_variance = |c: usize| self.covariance[c][c] >= 0.0;
        let is_finite = self.covariance.as_flattened().iter().all(|v| v.is_finite());
        if !(is_finite && (0..6).all(is_variance)) {
            let found = "no covariance";
            let expected = "finite numbers, variances zero or more";
            return Err(FormatError::field("process.covariance", found, expected));
        }
        let is_variance = |v: &f64| v.is_finite() && *v >= 0.0;
        if !self.sensor_variance.iter().flatten().all(is_variance) {
            let (name, expected) = ("process.sensor_variance", "finite numbers of zero or more");
            return Err(FormatError::field(name, "not that", expected));
        }
        let rows: Result<Vec<Row>, FormatError> =
            self.rows.into_iter().enumerate().map(|(index, row)| row.check(index)).collect();
        let rows = rows?;
        if rows.is_empty() {
            return Err(FormatError::field("process.rows", "none", "at least one"));
        }
        if let Some(Registration { position_std_mm, angle_std_rad, center_mm }) = &self.registration
        {
            let name = "registration.position_std_mm";
            check(name, *position_std_mm, length_problem(*position_std_mm))?;
            let of_angle = (!(0.0..=PI).contains(angle_std_rad)).then_some("0 to π");
            check("registration.angle_std_rad", *angle_std_rad, of_angle)?;
            if let Some(expected) = position_problem(center_mm) {
                let found = ron_text::list(center_mm);
                let name = "process.registration.center_mm";
                return Err(FormatError::field(name, found, expected));
            }
        }
        let refits = self.refits.into_iter().enumerate();
        let refits = refits.map(|(index, refit)| refit.model(&format!("process.refits[{index}]")));
        let refits: Vec<_> = refits.collect::<Result<_, FormatError>>()?;
        Ok(Arc::new(GaussianField {
            trend: self.trend,
            kernel: self.kernel,
            amplitude: self.amplitude,
            component_covariance: self.covariance,
            rows,
            has_rotations: self.has_rotations,
            measured_rows: self.measured_rows,
            left_out_rms_mm: self.left_out_rms_mm,
            sensor_variance: self.sensor_variance,
            refits,
            registration: self.registration,
        }))
    }
}

impl RowEntry {
    fn check(self, index: usize) -> Result<Row, FormatError> {
        let Self(position, axis, error, noise_factor, x_axis) = self;
        let name = || format!("process.rows[{index}]");
        let axis = Vector3::from(axis);
        if let Some(expected) = position_problem(&position) {
            let found = ron_text::list(&position);
            return Err(FormatError::field(name(), found, expected));
        }
        let numbers = error.iter().chain([&noise_factor]);
        let is_finite = numbers.into_iter().all(|v| v.is_finite());
        if !is_finite || noise_factor <= 0.0 {
            let expected = "finite numbers, noise above zero";
            return Err(FormatError::field(name(), "not that", expected));
        }
        let unit = |axis: Vector3<f64>| {
            let off = (axis.norm_squared() - 1.0).abs();
            if off.is_nan() || off > AXIS_TOLERANCE {
                let found = format!("an axis of length {}", axis.norm());
                return Err(FormatError::field(name(), found, "length 1"));
            }
            Ok(Unit::new_unchecked(axis))
        };
        let x_axis = x_axis.map(|axis| unit(axis.into())).transpose()?;
        Ok(Row {
            point: FieldPoint { x_axis, ..FieldPoint::new(position.into(), unit(axis)?) },
            error,
            noise_factor,
        })
    }
}

fn row_line(row: &Row) -> String {
    let position = ron_text::tuple(row.point.position_mm.coords.as_slice());
    let axis = ron_text::tuple(row.point.axis.as_slice());
    let (error, noise) = (ron_text::tuple(&row.error), shortest(row.noise_factor));
    let x_axis = row.point.x_axis.map(|axis| ron_text::tuple(axis.as_slice()));
    let x_axis = x_axis.map_or_else(String::new, |axis| format!(", Some({axis})"));
    format!("({position}, {axis}, {error}, {noise}{x_axis})")
}

/// Writes a process as a field of an environment, a row a line.
pub(super) fn write(out: &mut RonWriter, process: &GaussianField) {
    let scales = process.kernel.scales.each_ref().map(|scale| {
        let sine = match scale.axis_sine.is_finite() {
            true => shortest(scale.axis_sine),
            false => "inf".to_owned(),
        };
        let of_x_axis = match scale.x_axis_sine.is_finite() {
            true => format!("x_axis_sine: {}, ", shortest(scale.x_axis_sine)),
            false => String::new(),
        };
        let [length, variance] = [scale.length_mm, scale.variance].map(shortest);
        format!("(length_mm: {length}, axis_sine: {sine}, {of_x_axis}variance: {variance})")
    });
    let nugget = shortest(process.kernel.nugget);
    let amplitude = &process.amplitude;
    out.fields("process", |out| {
        out.plain("trend", process.trend);
        out.field("kernel", format_args!("(scales: ({}), nugget: {nugget})", scales.join(", ")));
        let [center, half] = [&amplitude.center_mm, &amplitude.half_mm].map(|v| ron_text::tuple(v));
        let log_variance = ron_text::tuple(&amplitude.log_variance);
        out.field(
            "amplitude",
            format_args!("(center_mm: {center}, half_mm: {half}, log_variance: {log_variance})"),
        );
        out.fields("covariance", |out| {
            let lines = process.component_covariance.iter().map(|line| ron_text::tuple(line));
            lines.for_each(|line| out.line(line + ","));
        });
        out.field("has_rotations", process.has_rotations);
        out.field("measured_rows", process.measured_rows);
        out.field("left_out_rms_mm", shortest(process.left_out_rms_mm));
        if let Some(variance) = &process.sensor_variance {
            out.field("sensor_variance", format_args!("Some({})", ron_text::tuple(variance)));
        }
        if let Some(Registration { position_std_mm, angle_std_rad, center_mm }) = &process.registration {
            let [position, angle] = [position_std_mm, angle_std_rad].map(|std| shortest(*std));
            let center = ron_text::tuple(center_mm);
            out.field(
                "registration",
                format_args!("Some((position_std_mm: {position}, angle_std_rad: {angle}, center_mm: {center}))"),
            );
        }
        out.line(ROWS_COMMENT);
        out.lines("rows", process.rows.iter().map(row_line));
        if !process.refits.is_empty() {
            out.line(REFITS_COMMENT);
            out.list("refits", |out| {
                for refit in &process.refits {
                    out.item(|out| computed_model::write_harmonic(out, refit));
                }
            });
        }
    });
}

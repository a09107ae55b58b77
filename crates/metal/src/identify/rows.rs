//! Measurements as rows that the fields of the metal have to explain, in units of their noise.
//!
//! A measurement gives 5 rows, 6 of a sensor with three axes: `W (s(measured) − s(true)) = W (n·δB)`
//! with `W = R⁻¹ Qᵀ` of the signals' Jacobian at the measured pose. Noise of the measured pose is noise of
//! the rows: the first three have that of the position, the others that of the rotation at a lever.

use super::noise::Noise;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::rows::{Maps, SolveError};
use trackwright_field::samples::{MeasurementContent, MeasurementSet};
use trackwright_task::Task;

/// Rows that are positions; the others are rotations.
pub(super) const POSITION_ROWS: usize = 3;

/// Measurements that one thread computes at a time.
const CHUNK: usize = 128;

#[derive(Clone)]
pub(super) struct Rows {
    pub generator: Generator,
    pub positions_mm: Vec<Point3<f64>>,
    /// Axes of a sensor.
    pub axes_each: usize,
    /// Rows of a measurement.
    pub dof: usize,
    axes: Vec<Vector3<f64>>,
    /// `W`, measurement after measurement, row by row; columns axis by axis, coil by coil.
    maps: Vec<f64>,
    pub right: Vec<f64>,
}

impl Rows {
    /// Rows in mm.
    pub fn new(
        task: &Task,
        generator: &Generator,
        set: &MeasurementSet,
    ) -> Result<Self, SolveError> {
        let maps = Maps::new(task, generator, &set.measurements, set.content)?;
        let axes_each = if set.content == MeasurementContent::SixDof { 3 } else { 1 };
        let ideal = || set.measurements.iter().map(|m| &m.tracker_from_ideal);
        let of_pose = |pose: &trackwright_geometry::pose::Pose| {
            let rotation = pose.rotation;
            // A sensor with one axis has it along its z.
            let first = if axes_each == 1 { 2 } else { 0 };
            (first..3).map(move |axis| rotation * Vector3::ith(axis, 1.0))
        };
        let count = set.measurements.len();
        Ok(Self {
            generator: generator.clone(),
            positions_mm: ideal().map(|pose| pose.translation.vector.into()).collect(),
            axes_each,
            dof: maps.dof(),
            axes: ideal().flat_map(of_pose).collect(),
            maps: (0..count).flat_map(|m| maps.map(m)).copied().collect(),
            right: (0..count).flat_map(|m| maps.right(m)).copied().collect(),
        })
    }

    pub fn len(&self) -> usize {
        self.positions_mm.len()
    }

    /// The same rows over their noise.
    pub fn over_noise(&self, noise: &Noise) -> Self {
        let mut scaled = self.clone();
        let signals = self.signals();
        for (row, right) in scaled.right.iter_mut().enumerate() {
            let scale = 1.0 / noise.of_row_mm(row % self.dof);
            *right *= scale;
            scaled.maps[row * signals..][..signals].iter_mut().for_each(|w| *w *= scale);
        }
        scaled
    }

    /// The same measurements with another right side.
    pub fn with_right(&self, right: Vec<f64>) -> Self {
        Self { right, ..self.clone() }
    }

    /// Some of the measurements.
    pub fn some(&self, measurements: &[usize]) -> Self {
        fn picked<T: Copy>(all: &[T], each: usize, measurements: &[usize]) -> Vec<T> {
            measurements.iter().flat_map(|m| &all[m * each..][..each]).copied().collect()
        }
        Self {
            generator: self.generator.clone(),
            positions_mm: picked(&self.positions_mm, 1, measurements),
            axes_each: self.axes_each,
            dof: self.dof,
            axes: picked(&self.axes, self.axes_each, measurements),
            maps: picked(&self.maps, self.dof * self.signals(), measurements),
            right: picked(&self.right, self.dof, measurements),
        }
    }

    /// Signals of a measurement.
    pub fn signals(&self) -> usize {
        self.axes_each * self.generator.coils.len()
    }

    /// Axes of a measurement's sensor.
    pub fn axes(&self, measurement: usize) -> &[Vector3<f64>] {
        &self.axes[measurement * self.axes_each..][..self.axes_each]
    }

    /// `W s` of a measurement.
    pub fn map(&self, measurement: usize, signals: &[f64], out: &mut [f64]) {
        let len = self.dof * signals.len();
        let rows = self.maps[measurement * len..][..len].chunks_exact(signals.len());
        for (out, row) in out.iter_mut().zip(rows) {
            *out = row.iter().zip(signals).map(|(w, s)| w * s).sum();
        }
    }

    /// What fields add to the rows; `None` where there is no field at a measurement.
    pub fn explained(
        &self,
        field: impl Fn(&Point3<f64>, &mut [Vector3<f64>]) -> bool + Sync,
    ) -> Option<Vec<f64>> {
        let coils = self.generator.coils.len();
        let mut out = vec![0.0; self.right.len()];
        let all_are_known = out
            .par_chunks_mut(self.dof * CHUNK)
            .enumerate()
            .map(|(chunk, out)| {
                let mut fields = vec![Vector3::zeros(); coils];
                let mut signals = vec![0.0; self.signals()];
                for (k, out) in out.chunks_exact_mut(self.dof).enumerate() {
                    let m = chunk * CHUNK + k;
                    if !field(&self.positions_mm[m], &mut fields) {
                        return false;
                    }
                    for (axis, n) in self.axes(m).iter().enumerate() {
                        for (coil, field) in fields.iter().enumerate() {
                            signals[axis * coils + coil] = n.dot(field);
                        }
                    }
                    self.map(m, &signals, out);
                }
                true
            })
            .reduce(|| true, |a, b| a && b);
        all_are_known.then_some(out)
    }

    /// What is left of the rows.
    pub fn left(&self, explained: &[f64]) -> Vec<f64> {
        self.right.iter().zip(explained).map(|(right, explained)| right - explained).collect()
    }
}

//! A process conditioned part by part of the room, so that many poses of a room of many rows are soon done.
//!
//! What rows far away add to the rows near a pose is next to nothing (the screening effect; Stein,
//! *Interpolation of Spatial Data*, 1999, chapter 3). A room of few rows is one part.

use super::field::GaussianField;
use super::fit::GaussianError;
use super::posterior::Conditioned;
use super::row::Row;
use crate::field_point::FieldPoint;
use crate::made_once::made_once;
use nalgebra::{Point3, Vector3};
use std::sync::OnceLock;
use trackwright_geometry::bounds::Bounds;

/// Rows of a part. Of a room of 3,000 rows the stated errors of readings are then 1.00 to 1.01 times those by
/// all rows (`parts_state_the_errors_that_all_rows_state`).
const ROWS: usize = 700;

/// Parts along each side of a room of more rows.
const PER_SIDE: usize = 4;

/// The parts of a room, each conditioned on its rows when it is first wanted.
pub(super) struct Neighborhoods<'a> {
    field: &'a GaussianField,
    /// Of the rows.
    bounds: Bounds,
    per_side: usize,
    parts: Vec<OnceLock<Result<Conditioned, GaussianError>>>,
}

impl<'a> Neighborhoods<'a> {
    pub fn new(field: &'a GaussianField) -> Self {
        let around = Bounds::around(field.rows.iter().map(|row| row.point.position_mm));
        let nowhere = Bounds { min_mm: Point3::origin(), max_mm: Point3::origin() };
        let bounds = around.unwrap_or(nowhere);
        let per_side = if field.rows.len() > ROWS { PER_SIDE } else { 1 };
        let parts = (0..per_side.pow(3)).map(|_| OnceLock::new()).collect();
        Self { field, bounds, per_side, parts }
    }

    /// Indices of points by the part that they are in, or nearest to; parts without points are left out.
    pub fn grouped(&self, at: &[FieldPoint]) -> Vec<(usize, Vec<usize>)> {
        let mut groups = vec![Vec::new(); self.parts.len()];
        for (i, point) in at.iter().enumerate() {
            groups[self.part_of(&point.position_mm)].push(i);
        }
        let groups = groups.into_iter().enumerate();
        groups.filter(|(_, points)| !points.is_empty()).collect()
    }

    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn part(&self, part: usize) -> Result<&Conditioned, GaussianError> {
        let conditioned = made_once(&self.parts[part], || {
            let GaussianField { kernel, amplitude, .. } = self.field;
            Conditioned::new(*kernel, &self.rows_near(part), amplitude)
        });
        conditioned.as_ref().map_err(Clone::clone)
    }

    fn part_of(&self, position_mm: &Point3<f64>) -> usize {
        let unit = self.bounds.to_unit(&self.bounds.clamp(position_mm));
        let place = |k: usize| ((unit[k] * self.per_side as f64) as usize).min(self.per_side - 1);
        (place(2) * self.per_side + place(1)) * self.per_side + place(0)
    }

    /// The rows nearest to a part's box, in the table's order.
    fn rows_near(&self, part: usize) -> Vec<Row> {
        let rows = &self.field.rows;
        if rows.len() <= ROWS {
            return rows.clone();
        }
        let n = self.per_side;
        let place = Vector3::new(part % n, part / n % n, part / (n * n)).cast::<f64>();
        let size_mm = self.bounds.size_mm() / n as f64;
        let min_mm = self.bounds.min_mm + size_mm.component_mul(&place);
        let own = Bounds { min_mm, max_mm: min_mm + size_mm };
        let distance =
            |row: &Row| (row.point.position_mm - own.clamp(&row.point.position_mm)).norm_squared();
        let distances: Vec<f64> = rows.iter().map(distance).collect();
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.select_nth_unstable_by(ROWS, |a, b| {
            distances[*a].total_cmp(&distances[*b]).then(a.cmp(b))
        });
        order.truncate(ROWS);
        order.sort_unstable();
        order.into_iter().map(|i| rows[i]).collect()
    }
}

//! A round-tipped tube with an oval side window: the working end of a tissue shaver.

use std::f64::consts::{PI, TAU};

use crate::shape::{Shape, ShapeBuilder};
use crate::vector::{Vec3, vec3};

/// Columns of faces around the tube outside the window, and across the window's floor.
const OUTSIDE_COLUMNS: usize = 36;
const FLOOR_COLUMNS: usize = 8;

/// Rows of the round tip, and along the window: four a tooth where there are seven teeth, so that
/// every tooth has its point and its root on a row.
const TIP_ROWS: usize = 9;
const WINDOW_ROWS: usize = 28;

/// A tube whose tip is at the origin, closed at both ends, its window looking along +x.
///
/// The window is cut down to a round floor rather than through: what lies inside hides the floor.
#[derive(Clone, Copy, Debug)]
pub struct WindowedTube {
    pub tip_z_mm: f64,
    pub end_z_mm: f64,
    pub radius_mm: f64,
    pub window_start_z_mm: f64,
    pub window_end_z_mm: f64,
    /// Half the window's opening, seen from the axis.
    pub window_half_angle_rad: f64,
    pub floor_radius_mm: f64,
    /// Teeth along each edge; 0 for a plain edge.
    pub teeth: usize,
}

/// One cross-section: the tube's radius there and how far the window reaches to either side.
struct Row {
    z_mm: f64,
    radius_mm: f64,
    half_angle_rad: f64,
}

impl WindowedTube {
    pub fn shape(&self) -> Shape {
        let rows = self.rows();
        let mut builder = ShapeBuilder::default();
        for pair in rows.windows(2) {
            let (row, next) = (&pair[0], &pair[1]);
            // Around the back, from the window's left edge to its right one.
            add_strip(&mut builder, OUTSIDE_COLUMNS, |t, ahead| {
                let row = if ahead { next } else { row };
                let angle = row.half_angle_rad + t * (TAU - 2.0 * row.half_angle_rad);
                on_row(row, row.radius_mm, angle)
            });
            if row.half_angle_rad == 0.0 && next.half_angle_rad == 0.0 {
                continue;
            }
            add_strip(&mut builder, FLOOR_COLUMNS, |t, ahead| {
                let row = if ahead { next } else { row };
                on_row(row, self.floor_radius_mm, (2.0 * t - 1.0) * row.half_angle_rad)
            });
            for side in [-1.0, 1.0] {
                add_strip(&mut builder, 1, |t, ahead| {
                    let row = if ahead { next } else { row };
                    let (outer, inner) = (row.radius_mm, self.floor_radius_mm);
                    let depth = if side > 0.0 { t } else { 1.0 - t };
                    on_row(row, inner + (outer - inner) * depth, side * row.half_angle_rad)
                });
            }
        }
        self.close_end(&mut builder);
        builder.finish()
    }

    fn rows(&self) -> Vec<Row> {
        let plain = |z_mm: f64, radius_mm: f64| Row { z_mm, radius_mm, half_angle_rad: 0.0 };
        let mut rows = Vec::new();
        for i in 0..=TIP_ROWS {
            let (sin, cos) = (i as f64 / TIP_ROWS as f64 * PI / 2.0).sin_cos();
            rows.push(plain(self.tip_z_mm + self.radius_mm * (1.0 - cos), self.radius_mm * sin));
        }
        let (start, end) = (self.window_start_z_mm, self.window_end_z_mm);
        for i in 0..=WINDOW_ROWS {
            // Close rows at the ends, where the oval turns.
            let along = (1.0 - (i as f64 / WINDOW_ROWS as f64 * PI).cos()) / 2.0;
            let mut row = plain(start + (end - start) * along, self.radius_mm);
            if i > 0 && i < WINDOW_ROWS {
                row.half_angle_rad = self.half_angle_rad(i, along);
            }
            rows.push(row);
        }
        rows.push(plain(self.end_z_mm, self.radius_mm));
        rows
    }

    fn half_angle_rad(&self, row: usize, along: f64) -> f64 {
        /// How much of the opening a tooth's point takes.
        const TOOTH_DEPTH: f64 = 0.34;
        let oval = (1.0 - (2.0 * along - 1.0).powi(4)).max(0.0).sqrt();
        let tooth = if self.teeth == 0 {
            0.0
        } else {
            let phase = row as f64 * self.teeth as f64 / WINDOW_ROWS as f64;
            1.0 - (2.0 * phase.fract() - 1.0).abs()
        };
        self.window_half_angle_rad * oval * (1.0 - TOOTH_DEPTH * tooth)
    }

    fn close_end(&self, builder: &mut ShapeBuilder) {
        let end = Row { z_mm: self.end_z_mm, radius_mm: self.radius_mm, half_angle_rad: 0.0 };
        let middle = vec3(0.0, 0.0, self.end_z_mm);
        for column in 0..OUTSIDE_COLUMNS {
            let angle = |i: usize| i as f64 / OUTSIDE_COLUMNS as f64 * TAU;
            let (a, b) = (angle(column), angle(column + 1));
            builder.triangle([
                on_row(&end, self.radius_mm, a),
                on_row(&end, self.radius_mm, b),
                middle,
            ]);
        }
    }
}

/// Faces between two rows; `point(t, ahead)` is on the near or far row, `t` from 0 to 1 across it.
fn add_strip(builder: &mut ShapeBuilder, columns: usize, point: impl Fn(f64, bool) -> Vec3) {
    for column in 0..columns {
        let [a, b] = [column, column + 1].map(|i| i as f64 / columns as f64);
        builder.quad([point(a, false), point(b, false), point(b, true), point(a, true)]);
    }
}

fn on_row(row: &Row, radius_mm: f64, angle: f64) -> Vec3 {
    vec3(radius_mm * angle.cos(), radius_mm * angle.sin(), row.z_mm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{open_edge_count, volume_mm3};

    #[test]
    fn the_window_takes_away_what_it_should() {
        let plain = WindowedTube {
            tip_z_mm: 0.0,
            end_z_mm: 20.0,
            radius_mm: 2.0,
            window_start_z_mm: 2.5,
            window_end_z_mm: 9.0,
            window_half_angle_rad: 0.0,
            floor_radius_mm: 1.0,
            teeth: 0,
        };
        let cut = WindowedTube { window_half_angle_rad: 1.0, ..plain };
        assert_eq!(open_edge_count(&cut.shape()), 0);
        let cut_mm3 = volume_mm3(&plain.shape()) - volume_mm3(&cut.shape());
        // Half-angle 1 rad between radii 1 and 2 over 6.5 mm, times the oval's mean width 0.874.
        let expected_mm3 = (4.0 - 1.0) * 6.5 * 0.874;
        assert!((cut_mm3 / expected_mm3 - 1.0).abs() < 0.03, "{cut_mm3}");
    }
}

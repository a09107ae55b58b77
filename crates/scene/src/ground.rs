//! The ground under the tracker's generator: a grid that fades with distance, and the tracker's axes.

use nalgebra::Point3;

/// How long the tracker's axes are drawn.
pub const AXIS_LENGTH_MM: f64 = 120.0;

/// Where the ground is: under the generator, which is 70 mm deep.
const GROUND_Z_MM: f64 = 72.0;
const SPACING_MM: f64 = 50.0;
const LINES_EACH_WAY: i32 = 18;
const GRID_ALPHA: f64 = 0.5;

/// Lines in pieces, tracker frame; each end with its opacity, as faint as it is far from the middle.
pub fn grid() -> Vec<[(Point3<f64>, f64); 2]> {
    let reach = SPACING_MM * f64::from(LINES_EACH_WAY);
    let end = |x: f64, y: f64| {
        let nearness = (1.0 - x.hypot(y) / reach).max(0.0);
        let at = Point3::new(x, y, GROUND_Z_MM);
        (at, GRID_ALPHA * nearness * nearness)
    };
    let mut lines = Vec::new();
    for i in -LINES_EACH_WAY..=LINES_EACH_WAY {
        for j in -LINES_EACH_WAY..LINES_EACH_WAY {
            let across = f64::from(i) * SPACING_MM;
            let (from, to) = (f64::from(j) * SPACING_MM, f64::from(j + 1) * SPACING_MM);
            for line in [[end(across, from), end(across, to)], [end(from, across), end(to, across)]]
            {
                if line.iter().any(|(_, alpha)| *alpha > 0.0) {
                    lines.push(line);
                }
            }
        }
    }
    lines
}

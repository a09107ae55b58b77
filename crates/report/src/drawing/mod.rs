//! Drawings as SVG within a page: a body from three sides with dimensions, and the set-up of tool,
//! CRF and field generator in the room. Their colours are those of the page (classes of its style).

mod body;
mod dimension;
mod marks;
mod outline;
mod paper;
mod setup;
mod silhouette;

pub use body::body_drawings;
pub use outline::BodyOutline;
pub use setup::{SetUp, setup_drawing};

/// Beyond this nothing is drawn: a kilometre is no tool and no room, and what is farther would leave
/// everything else a dot.
const FARTHEST_MM: f64 = 1e6;

/// Whether a point can be part of a drawing.
fn is_drawable(point: &nalgebra::Point3<f64>) -> bool {
    point.iter().all(|v| v.abs() <= FARTHEST_MM)
}

/// A length on a drawing: hundredths, and no more digits than it has.
///
/// ```
/// use trackwright_report::drawing::dimension_text;
/// assert_eq!([12.5, -0.004, -3.0].map(dimension_text), ["12.5", "0", "−3"]);
/// ```
pub fn dimension_text(length_mm: f64) -> String {
    let text = format!("{length_mm:.2}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    match text {
        "-0" => "0".to_owned(),
        _ => text.replace('-', "−"),
    }
}

#[cfg(test)]
mod tests;

//! `∬ 1/R` of two triangles of layers, each evenly filled over its layer's thickness.

use super::layer::{Layer, Triangle};
use nalgebra::Point2;

/// Gauss and Legendre's rule of six points from 0 to 1: places and weights.
const RULE: [(f64, f64); 6] = [
    (0.033765242898424, 0.085662246189585),
    (0.169395306766868, 0.180380786524069),
    (0.380690406958402, 0.233956967286346),
    (0.619309593041598, 0.233956967286346),
    (0.830604693233132, 0.180380786524069),
    (0.966234757101576, 0.085662246189585),
];

/// Triangles so many times their radii apart are points, or three points each. What is left out is below
/// 10⁻³ of a pair.
const FAR: f64 = 4.0;
const NEAR: f64 = 1.5;

/// Layers whose heights differ by less than this part of a distance are in one plane.
const FLAT: f64 = 0.1;

/// How far two layers' currents are apart in height, by their weights.
pub(super) struct HeightDifferences {
    each: [(f64, f64); 6],
    rms_mm: f64,
    least_mm: f64,
}

impl HeightDifferences {
    /// Of layers that are the same or do not overlap.
    pub fn new(one: &Layer, other: &Layer) -> Self {
        let (a, b) = (one.thickness_mm(), other.thickness_mm());
        let is_same = one.heights_mm == other.heights_mm;
        let apart_mm = (one.middle_mm() - other.middle_mm()).abs();
        let (least_mm, span_mm) = match is_same {
            true => (0.0, a),
            false => ((apart_mm - 0.5 * (a + b)).max(0.0), a + b),
        };
        // Nearer to each other where the distance is least: there 1/R changes fastest.
        let mut each = RULE.map(|(place, weight)| {
            let beyond_mm = span_mm * place.powi(3);
            let density = match is_same {
                true => a - beyond_mm,
                false => beyond_mm.min(a).min(b).min(span_mm - beyond_mm),
            };
            (least_mm + beyond_mm, weight * place * place * density)
        });
        let sum: f64 = each.iter().map(|(_, weight)| weight).sum();
        each.iter_mut().for_each(|(_, weight)| *weight /= sum);
        let square: f64 = each.iter().map(|(mm, weight)| weight * mm * mm).sum();
        Self { each, rms_mm: square.sqrt(), least_mm }
    }

    /// Mean of a function of the difference.
    fn mean(&self, of: impl Fn(f64) -> f64) -> f64 {
        self.each.iter().map(|(mm, weight)| weight * of(*mm)).sum()
    }

    /// Mean of `1/R` of two points.
    fn of_points(&self, a: &Point2<f64>, b: &Point2<f64>) -> f64 {
        let square = (a - b).norm_squared();
        if self.rms_mm * self.rms_mm < FLAT * FLAT * square {
            return 1.0 / (square + self.rms_mm * self.rms_mm).sqrt();
        }
        self.mean(|mm| 1.0 / (square + mm * mm).sqrt())
    }

    /// `∬ 1/R` in mm³.
    pub fn of_triangles(&self, target: &Triangle, source: &Triangle) -> f64 {
        let apart_mm = (target.center_mm - source.center_mm).norm().hypot(self.least_mm);
        let reach_mm = target.radius_mm + source.radius_mm;
        let areas = target.area_mm2 * source.area_mm2;
        if apart_mm > FAR * reach_mm {
            return areas * self.of_points(&target.center_mm, &source.center_mm);
        }
        if apart_mm > NEAR * reach_mm {
            let points = source.rule_mm();
            let pairs = target.rule_mm().into_iter().flat_map(|a| points.map(|b| (a, b)));
            return areas * pairs.map(|(a, b)| self.of_points(&a, &b)).sum::<f64>() / 9.0;
        }
        let at = |p: &Point2<f64>| self.mean(|mm| source.potential_mm(p, mm));
        target.area_mm2 * target.rule_mm().iter().map(at).sum::<f64>() / 3.0
    }
}

//! What jitter does to the tip, as a result.

use super::{
    DeterminedPart, Estimate, FirstOrderCheck, MonteCarlo, MotionUncertainty, TipUncertainty,
    UncertaintyReport,
};
use crate::figures::RoomFieldFigures;
use crate::metric::Metric;
use nalgebra::Matrix3;
use trackwright_result::{Section, Table, data, number};

/// Degrees a radian.
const DEG: f64 = 180.0 / std::f64::consts::PI;

/// A figure's label, the figure by the formula, and sampled with its standard error.
type Compared = (String, Option<f64>, Option<[f64; 2]>);

impl UncertaintyReport {
    /// All that was found; `figures` are those without jitter.
    pub fn section(&self, figures: &RoomFieldFigures) -> Section {
        let jitter = &self.jitter;
        let (position_mm, angle_deg) = (jitter.position_mm, jitter.angle_rad * DEG);
        let (weight_mm, weight_source) = (self.weight.value_mm, self.weight.source.label());
        let growth = jitter.growth.map_or_else(String::new, |g| {
            format!(
                ", growing beyond {} mm with the distance to the powers {} and {}",
                g.distance_mm, g.position_exponent, g.angle_exponent
            )
        });
        let (tip, sampled) = (self.tip(), self.monte_carlo.as_ref());
        let agreement = tip.zip(sampled).map(|(tip, sampled)| {
            let difference = tip.rms_mm - sampled.rms_mm.value;
            Section::of([
                data("relative_difference", difference / sampled.rms_mm.value),
                data("standard_errors", difference / sampled.rms_mm.std_error),
            ])
            .named("agreement")
        });
        let parts = [
            self.first_order.as_ref().map(|(tip, check)| tip.section(check.as_ref())),
            sampled.map(MonteCarlo::section),
            agreement,
        ];
        Section::of([
            data("jitter.position_mm", position_mm),
            data("jitter.angle_deg", angle_deg),
            data("jitter.growth", jitter.growth),
            data("jitter.source", self.jitter_source),
            data("orientation_weight_mm", weight_mm),
            data("orientation_weight_source", weight_source),
        ])
        .with(format!(
            "jitter {position_mm:.4} mm and {angle_deg:.4} ° an axis{growth}, from the {}",
            self.jitter_source
        ))
        .with(format!("orientation weight {weight_mm:.4} mm, {weight_source}"))
        .with_all(parts.into_iter().flatten())
        .with(self.comparison())
        .with_all(self.first_order.iter().flat_map(|(tip, check)| tip.verdicts(check.as_ref())))
        .with_all(self.motion.iter().flat_map(|over| over.section(figures).items))
    }

    fn tip(&self) -> Option<&TipUncertainty> {
        self.first_order.as_ref().map(|(tip, _)| tip)
    }

    /// First order and Monte Carlo side by side, whichever there is.
    fn comparison(&self) -> Table {
        let (tip, sampled) = (self.tip(), self.monte_carlo.as_ref());
        let estimate = |of: fn(&MonteCarlo) -> Estimate| {
            sampled.map(of).map(|found| [found.value, found.std_error])
        };
        // Of normal values; the distribution of the tip is close enough to one for this.
        let spread = |of: &dyn Fn(&MonteCarlo) -> f64| {
            sampled.map(|m| [of(m), of(m) / (2.0 * m.samples as f64).sqrt()])
        };
        let std = |covariance: &Matrix3<f64>, k| f64::max(covariance[(k, k)], 0.0).sqrt();
        let axes = || (0..3).zip(["x", "y", "z"]);
        let mut rows: Vec<Compared> =
            vec![("tip scatter RMS, mm".to_owned(), tip.map(|t| t.rms_mm), estimate(|m| m.rms_mm))];
        rows.extend(axes().map(|(k, axis)| {
            let found = spread(&|m| std(&m.covariance_mm2, k));
            (format!("tip scatter {axis}, mm"), tip.map(|t| std(&t.covariance_mm2, k)), found)
        }));
        rows.extend(axes().map(|(k, axis)| {
            let found = sampled.map(|m| [m.mean_error_mm[k], m.mean_std_error_mm[k]]);
            (format!("tip shift {axis}, mm"), tip.map(|t| t.bias_mm[k]), found)
        }));
        let total = estimate(|m| m.total_rms_mm);
        rows.push((format!("{}, mm", total_label()), tip.map(|t| t.total_rms_mm), total));
        if sampled.is_some() {
            let median = estimate(|m| m.median_mm);
            rows.push((format!("{}, mm", Metric::TIP_MEDIAN.label()), None, median));
            rows.push((format!("{}, mm", Metric::TIP_P95.label()), None, estimate(|m| m.p95_mm)));
        }
        let rotation = spread(&|m| m.rotation_rms_rad * DEG);
        let formula = tip.map(|t| t.rotation_rms_rad * DEG);
        rows.push(("rotation scatter RMS, °".to_owned(), formula, rotation));
        rows.retain(|(_, formula, sampled)| formula.is_some() || sampled.is_some());
        let head = |is_there, head| if is_there { head } else { "" };
        Table::of("", &rows)
            .text("", "figure", |(label, ..)| label.clone())
            .number("", head(tip.is_some(), "first order"), 4, |(_, formula, _)| *formula)
            .number("", head(sampled.is_some(), "Monte Carlo"), 4, |(.., sampled)| {
                sampled.map(|[value, std_error]| format!("{value:.4} ± {std_error:.4}"))
            })
            .done()
    }
}

/// Of distortion and jitter together.
fn total_label() -> String {
    format!("{}, shift and scatter", Metric::TIP_RMS.label())
}

fn matrix(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    m.transpose().into()
}

impl TipUncertainty {
    fn section(&self, check: Option<&FirstOrderCheck>) -> Section {
        let (ellipsoid, bias) = (&self.ellipsoid, &self.bias_check);
        Section::of([
            data("tip_mm", self.tip_in_crf.coords.as_slice()),
            data("covariance_mm2", matrix(&self.covariance_mm2)),
            data("rms_mm", self.rms_mm),
            data("bias_mm", self.bias_mm.as_slice()),
            data("total_rms_mm", self.total_rms_mm),
            data("rotation_covariance_deg2", matrix(&(self.rotation_covariance_rad2 * DEG * DEG))),
            data("rotation_rms_deg", self.rotation_rms_rad * DEG),
            data("rotation_bias_deg", (self.rotation_bias_rad * DEG).as_slice()),
            data("cross_covariance_mm_deg", matrix(&(self.cross_covariance_mm_rad * DEG))),
            data("ellipsoid_95.center_mm", ellipsoid.center_in_crf.coords.as_slice()),
            data("ellipsoid_95.semi_axes_mm", ellipsoid.semi_axes_in_crf_mm.map(<[f64; 3]>::from)),
            data("ellipsoid_95.lengths_mm", ellipsoid.lengths_mm()),
            data("check", check),
            data("bias_check.simulated_mm", bias.simulated_mm.as_slice()),
            data("bias_check.difference_mm", bias.difference_mm),
            data("bias_check.holds", bias.holds),
            data("determined", self.determined.as_ref().map(DeterminedPart::section)),
            data("poorly_determined", self.is_poorly_determined),
        ])
        .named("first_order")
    }

    /// Whether the first order holds, the ellipsoid, and what is not determined.
    fn verdicts(&self, check: Option<&FirstOrderCheck>) -> Vec<String> {
        let [a, b, c] = self.ellipsoid.lengths_mm();
        let bias = &self.bias_check;
        let mut lines = vec![
            format!(
                "95 % of the scatter lies in an ellipsoid with semi-axes {a:.4}, {b:.4} and {c:.4} mm"
            ),
            match check {
                None => {
                    "first order: not checked, there are too many sensors; request monte-carlo too"
                        .to_owned()
                }
                Some(check) if check.holds => format!(
                    "first order holds for the scatter: the next order differs by {:.3} %",
                    100.0 * check.relative_difference
                ),
                Some(check) => format!(
                    "first order does not hold for the scatter: the next order gives {:.4} mm, {:.1} % \
                     away; trust monte-carlo",
                    check.next_order_rms_mm,
                    100.0 * check.relative_difference
                ),
            },
            format!(
                "first order {} for the shift: {:.4} mm from the simulated one of {:.4} mm",
                if bias.holds { "holds" } else { "does not hold" },
                bias.difference_mm,
                bias.simulated_mm.norm()
            ),
        ];
        lines.extend(self.determined.as_ref().map(|part| {
            format!(
                "the {}'s rotation is not determined; what it cannot change of the tip scatters by \
                 {:.4} mm RMS and is shifted by {:.4} mm",
                part.free_axis.body,
                part.rms_mm,
                part.bias_mm.norm()
            )
        }));
        lines
    }
}

impl DeterminedPart {
    fn section(&self) -> Section {
        Section::of([
            data("free_axis", self.free_axis),
            data("covariance_mm2", matrix(&self.covariance_mm2)),
            data("rms_mm", self.rms_mm),
            data("bias_mm", self.bias_mm.as_slice()),
            data("total_rms_mm", self.total_rms_mm),
        ])
    }
}

impl MonteCarlo {
    fn section(&self) -> Section {
        Section::of([
            data("samples", self.samples),
            data("seed", self.seed),
            data("mean_error_mm", self.mean_error_mm.as_slice()),
            data("mean_std_error_mm", self.mean_std_error_mm.as_slice()),
            data("covariance_mm2", matrix(&self.covariance_mm2)),
            data("rms_mm", self.rms_mm.value),
            data("rms_std_error_mm", self.rms_mm.std_error),
            data("total_rms_mm", self.total_rms_mm.value),
            data("total_rms_std_error_mm", self.total_rms_mm.std_error),
            data("position_mm", self.tip_error_mm),
            data("median_std_error_mm", self.median_mm.std_error),
            data("p95_std_error_mm", self.p95_mm.std_error),
            data("angle_deg", self.angle_deg),
            data("mean_rotation_deg", (self.mean_rotation_rad * DEG).as_slice()),
            data("rotation_covariance_deg2", matrix(&(self.rotation_covariance_rad2 * DEG * DEG))),
            data("rotation_rms_deg", self.rotation_rms_rad * DEG),
            data("position_mm_determined", self.determined_mm),
        ])
        .named("monte_carlo")
    }
}

impl MotionUncertainty {
    fn section(&self, figures: &RoomFieldFigures) -> Section {
        let (tip, rotation) = (&self.rms_mm, &self.rotation_rms_deg);
        let total_rms_mm = self.total_rms_mm(figures.position_mm.rms());
        let free = "a rotation is not determined; the scatter is that with the true one";
        Section::of([
            data("first_order", self),
            number("", "tip scatter RMS, first order", tip.rms(), 4, "mm"),
            number("", "tip scatter mean", tip.mean(), 4, "mm"),
            number("", "tip scatter max", tip.max(), 4, "mm"),
            number("", "rotation scatter RMS, first order", rotation.rms(), 4, "°"),
            number("first_order.total_rms_mm", total_label(), total_rms_mm, 4, "mm"),
        ])
        .with_all(self.free_axis.map(|_| free.to_owned()))
    }
}

//! An agreement as a result.

use super::{Agreement, Bias, Compared, Interval, PivotedTool, Summary};
use nalgebra::Point3;
use trackwright_result::{Row, Section, Table, count, data, mm, number, text};

impl Agreement {
    /// All that is known of it; `recorded` is what else is known of the recording.
    pub fn section(&self, recorded: impl IntoIterator<Item = Row>) -> Section {
        let summary = &self.summary;
        let angle = summary.angle_deg.as_ref().map(|angle| side_by_side("angle error, °", angle));
        let errors = Section::default()
            .with(side_by_side("tip error, mm", &summary.position_mm))
            .with_all(angle);
        let predicted = self.figures.rows().into_iter().map(|row| {
            let is_shown = !row.label.is_empty();
            Row { label: format!("predicted {}", row.label).into(), ..row }.shown_if(is_shown)
        });
        let statements = [summary.statement.clone()].into_iter();
        Section::of(summary.counts())
            .with_all(recorded)
            .with(errors)
            .with(Section::of(summary.figures()).with_all(predicted))
            .with(
                Section::default().with_all(statements.chain(self.figures.no_interval_statement())),
            )
    }
}

impl Summary {
    /// All of it, as programs read it.
    pub fn section(&self) -> Section {
        Section::of(self.counts()).with_all(self.figures())
    }

    fn counts(&self) -> [Row; 10] {
        let outside = "with a sensor outside the room's box";
        let unsupported = match self.unsupported {
            Some(found) => count("unsupported", "on poorly supported field", found).part(),
            None => data("unsupported", ()),
        };
        [
            count("poses", "recorded poses", self.poses),
            count("used", "compared", self.used).part(),
            count("outside", outside, self.outside).part(),
            unsupported,
            number("effective", "effective number of poses", self.effective, 1, "").part(),
            data("unknowns", self.unknowns),
            data("position_mm", &self.position_mm),
            data("angle_deg", &self.angle_deg),
            data("block", self.block),
            data("noise", self.noise),
        ]
    }

    fn figures(&self) -> Vec<Row> {
        let found = &self.position_mm;
        let of_angle = self.angle_deg.as_ref().and_then(|angle| angle.explained);
        let percent = |label, found| interval(label, found, (100.0, 1), "%");
        let mut rows = vec![
            percent("explained of the squared tip error", found.explained),
            percent("of its change from pose to pose", found.explained_of_variation).part(),
            percent("of the squared angle error", of_angle).part(),
            interval("predictions fit best times", found.slope, (1.0, 2), ""),
        ];
        rows.extend(found.bias.iter().flat_map(Bias::rows));
        let [bias, lower, upper] = match &found.lengths {
            Some(limits) => [limits.bias, limits.lower, limits.upper].map(Some),
            None => [None; 3],
        };
        let length = |label, found| interval(label, found, (1.0, 3), "mm");
        rows.extend([
            length("measured minus predicted length, mean", bias),
            length("lower limit of agreement", lower).part(),
            length("upper limit of agreement", upper).part(),
        ]);
        if let Some(noise) = &self.noise {
            let accepted = noise.accepted.map_or_else(String::new, |[low, high]| {
                format!("(nothing else: {low:.2} to {high:.2})")
            });
            let squared = number("", "squared difference in its units", noise.normalised, 2, "");
            rows.push(mm("", "uncertainty that the room states, RMS", noise.rms_mm));
            rows.push(squared.part().remarked(accepted));
        }
        let misfit_mm = self.room_misfit_rms_mm;
        let misfit =
            mm("room_misfit_rms_mm", "misfit of the room's model at the tip, RMS", misfit_mm);
        rows.extend([
            misfit.shown_if(misfit_mm.is_some()),
            data("verdict", self.verdict),
            data("statement", &self.statement),
        ]);
        rows
    }
}

impl Bias {
    fn rows(&self) -> Vec<Row> {
        let axis = |(k, axis): (usize, &str)| {
            let half =
                self.half_width.map_or_else(String::new, |h| format!("(95 %: ± {:.3})", h[k]));
            mm("", format!("mean difference {axis}"), self.mean[k]).remarked(half)
        };
        let chance =
            self.p.map(|p| if p < 1e-4 { "< 0.0001".to_owned() } else { format!("{p:.4}") });
        let chance = chance.map(|p| text("", "chance of so much without a bias", p).part());
        ["x", "y", "z"].into_iter().enumerate().map(axis).chain(chance).collect()
    }
}

impl PivotedTool {
    /// The tip as the recording has it, beside that of the design.
    pub fn tip_rows(&self, designed: &Point3<f64>) -> [Row; 4] {
        let point = |at: &Point3<f64>| <[f64; 3]>::from(at.coords);
        let recorded = &self.pivot.tip_in_tool;
        let off_mm = (recorded - designed).norm();
        [
            data("tip.recorded", point(recorded)),
            data("tip.designed", point(designed)),
            mm("tip.distance_mm", "recorded tip from that of the design", off_mm),
            data("tip.std_error_mm", self.pivot.tip_std_error_mm),
        ]
    }
}

/// A figure with its interval, for people alone: times a unit, with so many decimals.
fn interval(
    label: &'static str,
    found: Option<Interval>,
    (times, decimals): (f64, usize),
    unit: &'static str,
) -> Row {
    let ends = found.and_then(|found| found.low.zip(found.high));
    let ends = ends.map_or_else(String::new, |(low, high)| {
        format!("(95 %: {:.decimals$} to {:.decimals$})", times * low, times * high)
    });
    let value = found.map(|found| times * found.value);
    number("", label, value, decimals, unit).remarked(ends).shown_if(found.is_some())
}

/// The three distributions below each other.
fn side_by_side(what: &'static str, found: &Compared) -> Table {
    let each = [
        ("  measured", &found.measured),
        ("  predicted", &found.predicted),
        ("  measured − predicted", &found.residual),
    ];
    Table::of("", &each)
        .text("", what, |(name, _)| *name)
        .number("", "RMS", 3, |(_, errors)| errors.rms())
        .number("", "mean", 3, |(_, errors)| errors.mean())
        .number("", "median", 3, |(_, errors)| errors.median())
        .number("", "p95", 3, |(_, errors)| errors.p95())
        .number("", "max", 3, |(_, errors)| errors.max())
        .done()
}

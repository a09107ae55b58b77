//! A study as a result.

use super::figure::{Figure, Figures, NoInterval};
use super::figures::{DECIMALS, IN_METAL, RoomFieldFigures, figure_rows, trial_number};
use super::judgement::JudgedBound;
use super::study::Study;
use super::trial::Trial;
use trackwright_geometry::pose::pose_to_array;
use trackwright_result::{Row, Section, count, data, number, text};

impl Figure {
    /// The figure with its interval, for people alone.
    pub fn row(&self) -> Row {
        let interval = self.interval_text(DECIMALS);
        let interval = interval.map_or_else(String::new, |words| format!("(95 %: {words})"));
        let (label, unit) = (self.metric.label(), self.metric.unit());
        number("", label, self.value, DECIMALS, unit).remarked(interval)
    }

    /// The same in a line: `tip error RMS 0.4400 mm (95 %: 0.4000 to 0.6100)`.
    pub fn statement(&self) -> String {
        let row = self.row();
        let words = format!("{} {} {} {}", row.label, row.value_text(), row.unit, row.remark);
        words.trim_end().to_owned()
    }

    /// The figure and its interval; people read those that a requirement can be about.
    fn rows(&self) -> [Row; 3] {
        let metric = self.metric;
        let key = |end| format!("figures.{}.{}.{end}", metric.of.json_key(), metric.summary.key());
        let value = Row { key: key("value").into(), ..self.row() };
        [
            value.shown_if(metric.first_bound().is_some()),
            data(key("low"), self.low),
            data(key("high"), self.high),
        ]
    }
}

impl Figures {
    /// Each figure, and what all rest on.
    pub fn rows(&self) -> Vec<Row> {
        let mut rows = vec![
            data("basis", self.basis),
            data("no_interval", self.no_interval.as_ref().map(ToString::to_string)),
            data("figures", ()),
        ];
        rows.extend(self.all.iter().flat_map(Figure::rows));
        if let Some(within) = &self.within {
            rows.extend([
                data("within.figure", within.metric),
                data("within.limit_mm", within.limit_mm),
                data("within.part", within.part),
                data("within.low", within.interval.map(|[low, _]| low)),
                data("within.high", within.interval.map(|[_, high]| high)),
            ]);
        }
        rows
    }

    /// Why there is no interval.
    pub fn no_interval_statement(&self) -> Option<String> {
        let why = self.no_interval.as_ref()?;
        let has_figures = !self.all.is_empty() || *why == NoInterval::Assumed;
        Some(format!("{}: {why}", if has_figures { "no interval" } else { "no figures" }))
    }

    /// The requirement, a sentence a bound.
    fn requirement_statements(&self) -> impl Iterator<Item = String> {
        let statement = |bound: &JudgedBound| {
            format!("requirement {}: {}", bound.metric.name(), bound.words(DECIMALS, " "))
        };
        self.requirement.iter().flat_map(|requirement| &requirement.bounds).map(statement)
    }
}

impl RoomFieldFigures {
    /// What needs no drawn fields; `single` is the trial of a study of one pose.
    pub fn section(&self, single: Option<&Trial>) -> Section {
        Section::of(self.rows(single)).with_all(self.statements())
    }

    fn rows(&self, single: Option<&Trial>) -> Vec<Row> {
        let if_any = |key: &'static str, label: &'static str, found: usize| {
            count(key, label, found).shown_if(found > 0)
        };
        let mut rows = vec![
            count("trials", "trials", self.trials),
            text("", "worst trial", trial_number(self.worst.trial)).shown_if(self.trials > 1),
            data("worst", self.worst),
            if_any("outside", self.outside_label(), self.outside),
            if_any("in_metal", IN_METAL, self.in_metal),
            if_any("out_of_volume", "trials with a sensor out of the volume", self.out_of_volume),
            data("without_field", self.without_field),
            if_any("rejected", "trials left out", self.rejected),
            data("poorly_determined", self.poorly_determined),
            data("room_field.position_mm", self.position_mm),
            data("room_field.angle_deg", self.angle_deg),
        ];
        if let Some(free) = &self.free_axis {
            rows.push(data("free_axis", free));
            rows.push(data("room_field.position_mm_determined", self.position_mm_determined));
        }
        rows.extend(self.barely_determined.as_ref().map(|weak| data("barely_determined", weak)));
        if let Some(trial) = single {
            let error_mm: [f64; 3] = trial.tip_error_in_crf_mm.into();
            rows.extend([
                data("error_mm", error_mm),
                data("true", pose_to_array(&trial.crf_from_tool)),
                data("simulated", pose_to_array(&trial.crf_from_tool_simulated)),
            ]);
        }
        rows
    }

    /// What of a rotation is not determined.
    fn statements(&self) -> impl Iterator<Item = String> {
        let weak = match &self.barely_determined {
            Some(weak) => Some(weak.statement()),
            None => self.poorly_determined.then(|| {
                "a rotation is poorly determined: noise in the readings decides it".to_owned()
            }),
        };
        self.free_axis.map(|free| free.statement()).into_iter().chain(weak)
    }

    /// The paper's simulation for people; programs have it in [`RoomFieldFigures::section`].
    pub fn paper_section(&self, single: Option<&Trial>) -> Section {
        let for_people = |row: Row| Row { key: "".into(), ..row };
        let mut rows: Vec<Row> = figure_rows(self).into_iter().map(for_people).collect();
        let mut poses = Vec::new();
        if let Some(trial) = single {
            let error_mm = trial.tip_error_in_crf_mm;
            rows.extend(["x", "y", "z"].into_iter().enumerate().map(|(k, axis)| {
                number("", format!("tip error {axis}"), error_mm[k], DECIMALS, "mm")
            }));
            for (name, pose) in [
                ("true pose", &trial.crf_from_tool),
                ("simulated pose", &trial.crf_from_tool_simulated),
            ] {
                let [x, y, z, qw, qx, qy, qz] = pose_to_array(pose);
                poses.push(format!(
                    "{name:<15} ({x:.4}, {y:.4}, {z:.4}) mm, ({qw:.6}, {qx:.6}, {qy:.6}, {qz:.6})"
                ));
            }
        }
        let head = "by the room's model alone, taken for the truth:".to_owned();
        Section::of(rows).with_all(poses).headed(head)
    }
}

impl Study {
    /// All that is known of it; `single` is the trial of a study of one pose.
    pub fn section(&self, single: Option<&Trial>) -> Section {
        Section::of(self.figures.rows())
            .with_all(self.room_field.rows(single))
            .with(data("requirement", &self.figures.requirement))
            .with_all(self.figures.no_interval_statement())
            .with_all(self.figures.requirement_statements())
            .with_all(self.room_field.statements())
    }
}

//! The procedure within a design file: further rooms, and what was decided at each step.

use super::write_requirement;
use crate::error::FormatError;
use crate::ron_text::{self, RonWriter};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::sync::LazyLock;
use trackwright_calibration::agreement::{BuiltRecording, RecordedFrame};
use trackwright_design::{Day, Decision, Procedure};
use trackwright_procedure::{
    DecidedFigures, DecidedRecording, DecidedRow, DecidedStudies, DecisionBasis, RoomName, Step,
};
use trackwright_simulation::judgement::Verdict;
use trackwright_simulation::metric::MetricFields;
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::{ErrorOf, Metric, MetricMap};

#[derive(Deserialize)]
#[serde(rename = "Procedure", deny_unknown_fields)]
pub(super) struct ProcedureEntry {
    rooms: Option<Vec<String>>,
    crf: Option<StudiesEntry>,
    tool: Option<StudiesEntry>,
    built: Option<RecordingEntry>,
}

#[derive(Deserialize)]
#[serde(rename = "Decision", deny_unknown_fields)]
struct StudiesEntry {
    date: String,
    note: Option<String>,
    requirement: Option<Requirement>,
    rows: Vec<RowEntry>,
}

#[derive(Deserialize)]
#[serde(rename = "Row", deny_unknown_fields)]
struct RowEntry {
    room: String,
    file: String,
    target: Option<String>,
    no_figures: Option<String>,
    trials: Option<usize>,
    without_field: Option<usize>,
    position: Option<PositionEntry>,
    angle: Option<AngleEntry>,
    /// Whether the figures are those that were to be expected; older files have those of the room's own
    /// field.
    expected: Option<bool>,
    verdict: Option<VerdictEntry>,
    /// In older files.
    met: Option<bool>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename = "Verdict")]
enum VerdictEntry {
    Met,
    Missed,
    CannotTell,
}

impl VerdictEntry {
    fn verdict(self) -> Verdict {
        match self {
            Self::Met => Verdict::Met,
            Self::Missed => Verdict::Missed,
            Self::CannotTell => Verdict::CannotTell,
        }
    }
}

/// Figures of the tip's error, by their names in a file.
struct PositionEntry(MetricMap);

/// Figures of the rotation's error.
struct AngleEntry(MetricMap);

impl<'de> Deserialize<'de> for PositionEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        static FIELDS: LazyLock<MetricFields> = LazyLock::new(|| fields(ErrorOf::Position));
        decided_figures(deserializer, "Position", &FIELDS).map(Self)
    }
}

impl<'de> Deserialize<'de> for AngleEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        static FIELDS: LazyLock<MetricFields> = LazyLock::new(|| fields(ErrorOf::Angle));
        decided_figures(deserializer, "Angle", &FIELDS).map(Self)
    }
}

fn fields(of: ErrorOf) -> MetricFields {
    let decided = Metric::decided().filter(|metric| metric.of == of);
    MetricFields::new(decided.map(|metric| (metric, metric.summary.key())))
}

fn decided_figures<'de, D: Deserializer<'de>>(
    deserializer: D,
    name: &'static str,
    fields: &'static MetricFields,
) -> Result<MetricMap, D::Error> {
    let found = MetricMap::deserialize(deserializer, name, fields)?;
    let is_missing = |metric: &Metric| found.get(*metric).is_none();
    match fields.metrics().iter().find(|metric| is_missing(metric)) {
        Some(metric) => Err(D::Error::missing_field(metric.summary.key())),
        None => Ok(found),
    }
}

#[derive(Deserialize)]
#[serde(rename = "Built", deny_unknown_fields)]
struct RecordingEntry {
    date: String,
    note: Option<String>,
    room: String,
    file: String,
    table: String,
    crf_table: Option<String>,
    frame: Option<RecordedFrame>,
    registered: Option<bool>,
    averaged: Option<u32>,
    truth_mm: Option<f64>,
    tool: Option<String>,
    poses: usize,
    used: usize,
    measured_rms: f64,
    predicted_rms: f64,
    residual_rms: f64,
    explained: Option<f64>,
    slope: Option<f64>,
    statement: String,
}

impl ProcedureEntry {
    pub(super) fn check(self) -> Result<Procedure, FormatError> {
        let rooms = self.rooms.unwrap_or_default().into_iter().enumerate();
        let rooms = rooms
            .map(|(index, room)| ron_text::file_name(format!("procedure.rooms[{index}]"), room));
        let studies = |step: Step, entry: Option<StudiesEntry>| {
            entry.map(|entry| entry.check(step)).transpose()
        };
        Ok(Procedure {
            further_rooms: rooms.collect::<Result<_, _>>()?,
            crf: studies(Step::Crf, self.crf)?,
            tool: studies(Step::Tool, self.tool)?,
            built: self.built.map(RecordingEntry::check).transpose()?,
        })
    }
}

impl StudiesEntry {
    fn check(self, step: Step) -> Result<Decision, FormatError> {
        let rows = self.rows.into_iter().enumerate();
        let rows =
            rows.map(|(index, row)| row.check(&format!("procedure.{}.rows[{index}]", step.key())));
        let studies =
            DecidedStudies { requirement: self.requirement, rows: rows.collect::<Result<_, _>>()? };
        decision(step, &self.date, self.note, DecisionBasis::Studies(studies))
    }
}

impl RowEntry {
    fn check(self, place: &str) -> Result<DecidedRow, FormatError> {
        let missing = |field: &str| {
            let expected = "the figure, or no_figures";
            FormatError::field(format!("{place}.{field}"), "absent", expected)
        };
        let figures = match self.no_figures {
            Some(why) => Err(why),
            None => {
                let position = self.position.ok_or_else(|| missing("position"))?;
                let angle = self.angle.ok_or_else(|| missing("angle"))?;
                Ok(DecidedFigures {
                    trials: self.trials.ok_or_else(|| missing("trials"))?,
                    without_field: self.without_field.unwrap_or(0),
                    values: position.0.iter().chain(angle.0.iter()).collect(),
                    are_expected: self.expected.unwrap_or(false),
                    verdict: self.verdict.map(VerdictEntry::verdict).or(self.met.map(of_met)),
                })
            }
        };
        Ok(DecidedRow {
            room: RoomName { name: self.room, file: self.file },
            target: self.target,
            figures,
        })
    }
}

fn of_met(met: bool) -> Verdict {
    if met { Verdict::Met } else { Verdict::Missed }
}

impl RecordingEntry {
    fn check(self) -> Result<Decision, FormatError> {
        let decided = DecidedRecording {
            room: RoomName { name: self.room, file: self.file },
            recording: BuiltRecording {
                table: self.table,
                crf_table: self.crf_table,
                frame: self.frame.unwrap_or_default(),
                is_registered: self.registered.unwrap_or(false),
                averaged: self.averaged.unwrap_or(1),
                truth_std_mm: self.truth_mm.unwrap_or(0.0),
                whole: self.tool,
            },
            poses: self.poses,
            used: self.used,
            measured_rms_mm: self.measured_rms,
            predicted_rms_mm: self.predicted_rms,
            residual_rms_mm: self.residual_rms,
            explained: self.explained,
            slope: self.slope,
            statement: self.statement,
        };
        let basis = DecisionBasis::Recording(Box::new(decided));
        decision(Step::Built, &self.date, self.note, basis)
    }
}

fn decision(
    step: Step,
    date: &str,
    note: Option<String>,
    basis: DecisionBasis,
) -> Result<Decision, FormatError> {
    let day: Result<Day, _> = date.parse();
    let expected = "a day such as 2005-10-26";
    let field = || format!("procedure.{}.date", step.key());
    let decision = Decision {
        date: day.map_err(|_| FormatError::field(field(), format!("{date:?}"), expected))?,
        note: note.unwrap_or_default(),
        basis,
    };
    match decision.check(step) {
        Ok(()) => Ok(decision),
        Err(cause) => Err(FormatError::Decision { step, cause }),
    }
}

/// Writes it where there is anything of it.
pub(super) fn write(out: &mut RonWriter, procedure: &Procedure) {
    if procedure.is_empty() {
        return;
    }
    out.fields("procedure", |out| {
        if !procedure.further_rooms.is_empty() {
            let rooms = procedure.further_rooms.iter();
            let rooms: Vec<_> = rooms.map(|room| ron_text::string(room)).collect();
            out.field("rooms", format_args!("[{}]", rooms.join(", ")));
        }
        for (step, decision) in procedure.decisions() {
            out.fields(step.key(), |out| {
                out.string("date", &decision.date.to_string());
                out.optional_string("note", Some(&*decision.note).filter(|note| !note.is_empty()));
                match &decision.basis {
                    DecisionBasis::Studies(studies) => write_studies(out, studies),
                    DecisionBasis::Recording(recording) => write_recording(out, recording),
                }
            });
        }
    });
}

fn write_studies(out: &mut RonWriter, studies: &DecidedStudies) {
    write_requirement(out, studies.requirement.as_ref());
    out.list("rows", |out| {
        for row in &studies.rows {
            out.item(|out| {
                write_room(out, &row.room);
                out.optional_string("target", row.target.as_deref());
                match &row.figures {
                    Err(why) => out.string("no_figures", why),
                    Ok(figures) => write_figures(out, figures),
                }
            });
        }
    });
}

fn write_room(out: &mut RonWriter, room: &RoomName) {
    out.string("room", &room.name);
    out.string("file", &room.file);
}

fn write_figures(out: &mut RonWriter, figures: &DecidedFigures) {
    out.field("trials", figures.trials);
    if figures.without_field > 0 {
        out.field("without_field", figures.without_field);
    }
    for of in ErrorOf::ALL {
        let values = figures.values.iter().filter(|(metric, _)| metric.of == of);
        let values = values.map(|(m, value)| format!("{}: {value:?}", m.summary.key()));
        out.field(of.key(), format_args!("({})", values.collect::<Vec<_>>().join(", ")));
    }
    if figures.are_expected {
        out.field("expected", true);
    }
    out.optional("verdict", figures.verdict);
}

fn write_recording(out: &mut RonWriter, decided: &DecidedRecording) {
    let recording = &decided.recording;
    write_room(out, &decided.room);
    out.string("table", &recording.table);
    out.optional_string("crf_table", recording.crf_table.as_deref());
    if recording.frame != RecordedFrame::default() {
        out.plain("frame", recording.frame);
    }
    if recording.is_registered {
        out.field("registered", true);
    }
    if recording.averaged != 1 {
        out.field("averaged", recording.averaged);
    }
    if recording.truth_std_mm.to_bits() != 0 {
        out.plain("truth_mm", recording.truth_std_mm);
    }
    out.optional_string("tool", recording.whole.as_deref());
    out.field("poses", decided.poses);
    out.field("used", decided.used);
    out.plain("measured_rms", decided.measured_rms_mm);
    out.plain("predicted_rms", decided.predicted_rms_mm);
    out.plain("residual_rms", decided.residual_rms_mm);
    out.optional("explained", decided.explained);
    out.optional("slope", decided.slope);
    out.string("statement", &decided.statement);
}

#[cfg(test)]
mod tests;

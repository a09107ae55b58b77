//! The procedure within a design file: further rooms, and what was decided at each step.

use super::{FormatError, Lines, file_name, ron_text};
use serde::Deserialize;
use trackwright_calibration::agreement::{BuiltRecording, RecordedFrame};
use trackwright_design::{Day, Decision, Procedure};
use trackwright_procedure::{
    AngleFigures, DecidedFigures, DecidedRecording, DecidedRow, DecidedStudies, DecisionBasis,
    PositionFigures, RoomName, Step,
};
use trackwright_simulation::requirement::Requirement;

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
    met: Option<bool>,
}

#[derive(Deserialize)]
#[serde(rename = "Position", deny_unknown_fields)]
struct PositionEntry {
    rms: f64,
    mean: f64,
    p95: f64,
    max: f64,
}

#[derive(Deserialize)]
#[serde(rename = "Angle", deny_unknown_fields)]
struct AngleEntry {
    rms: f64,
    p95: f64,
    max: f64,
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
        let rooms =
            rooms.map(|(index, room)| file_name(&format!("procedure.rooms[{index}]"), room));
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
                    position_mm: PositionFigures {
                        rms: position.rms,
                        mean: position.mean,
                        p95: position.p95,
                        max: position.max,
                    },
                    angle_deg: AngleFigures { rms: angle.rms, p95: angle.p95, max: angle.max },
                    met: self.met,
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
pub(super) fn write(out: &mut Lines, procedure: &Procedure) {
    if procedure.is_empty() {
        return;
    }
    out.line(1, "procedure: (");
    if !procedure.further_rooms.is_empty() {
        let rooms = procedure.further_rooms.iter();
        let rooms: Vec<_> = rooms.map(|room| ron_text::string(room)).collect();
        out.field(2, "rooms", &format!("[{}]", rooms.join(", ")));
    }
    for (step, decision) in procedure.decisions() {
        out.line(2, &format!("{}: (", step.key()));
        out.field(3, "date", &ron_text::string(&decision.date.to_string()));
        if !decision.note.is_empty() {
            out.field(3, "note", &ron_text::string(&decision.note));
        }
        match &decision.basis {
            DecisionBasis::Studies(studies) => write_studies(out, studies),
            DecisionBasis::Recording(recording) => write_recording(out, recording),
        }
        out.line(2, "),");
    }
    out.line(1, "),");
}

fn write_studies(out: &mut Lines, studies: &DecidedStudies) {
    out.requirement(3, studies.requirement.as_ref());
    out.line(3, "rows: [");
    for row in &studies.rows {
        out.line(4, "(");
        write_room(out, 5, &row.room);
        if let Some(target) = &row.target {
            out.field(5, "target", &ron_text::string(target));
        }
        match &row.figures {
            Err(why) => out.field(5, "no_figures", &ron_text::string(why)),
            Ok(figures) => write_figures(out, figures),
        }
        out.line(4, "),");
    }
    out.line(3, "],");
}

fn write_room(out: &mut Lines, depth: usize, room: &RoomName) {
    out.field(depth, "room", &ron_text::string(&room.name));
    out.field(depth, "file", &ron_text::string(&room.file));
}

fn write_figures(out: &mut Lines, figures: &DecidedFigures) {
    let (p, a) = (&figures.position_mm, &figures.angle_deg);
    out.field(5, "trials", &figures.trials.to_string());
    if figures.without_field > 0 {
        out.field(5, "without_field", &figures.without_field.to_string());
    }
    let position =
        format!("(rms: {:?}, mean: {:?}, p95: {:?}, max: {:?})", p.rms, p.mean, p.p95, p.max);
    out.field(5, "position", &position);
    let angle = format!("(rms: {:?}, p95: {:?}, max: {:?})", a.rms, a.p95, a.max);
    out.field(5, "angle", &angle);
    if let Some(met) = figures.met {
        out.field(5, "met", &met.to_string());
    }
}

fn write_recording(out: &mut Lines, decided: &DecidedRecording) {
    let recording = &decided.recording;
    write_room(out, 3, &decided.room);
    out.field(3, "table", &ron_text::string(&recording.table));
    if let Some(table) = &recording.crf_table {
        out.field(3, "crf_table", &ron_text::string(table));
    }
    if recording.frame != RecordedFrame::default() {
        out.field(3, "frame", &format!("{:?}", recording.frame));
    }
    if recording.is_registered {
        out.field(3, "registered", "true");
    }
    if recording.averaged != 1 {
        out.field(3, "averaged", &recording.averaged.to_string());
    }
    if recording.truth_std_mm.to_bits() != 0 {
        out.field(3, "truth_mm", &format!("{:?}", recording.truth_std_mm));
    }
    if let Some(whole) = &recording.whole {
        out.field(3, "tool", &ron_text::string(whole));
    }
    out.field(3, "poses", &decided.poses.to_string());
    out.field(3, "used", &decided.used.to_string());
    let numbers = [
        ("measured_rms", Some(decided.measured_rms_mm)),
        ("predicted_rms", Some(decided.predicted_rms_mm)),
        ("residual_rms", Some(decided.residual_rms_mm)),
        ("explained", decided.explained),
        ("slope", decided.slope),
    ];
    for (name, value) in numbers {
        if let Some(value) = value {
            out.field(3, name, &format!("{value:?}"));
        }
    }
    out.field(3, "statement", &ron_text::string(&decided.statement));
}

#[cfg(test)]
mod tests;

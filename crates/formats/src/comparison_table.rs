//! A comparison as a table, one row a design in a room: the same columns in every row, cells of what
//! is not there empty, names quoted as RFC 4180 has it.

use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::pose_to_array;
use trackwright_simulation::comparison::{Comparison, DifferenceVerdict, Row};
use trackwright_simulation::{METRICS, Metric, Verdict};

/// What designs and rooms are called, by their numbers in the comparison.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    pub designs: Vec<String>,
    pub design_files: Vec<String>,
    pub rooms: Vec<String>,
    pub room_files: Vec<String>,
}

impl Names {
    /// From files and names: a name that is not one's own, or none, has its file behind it.
    pub fn new<'a>(
        designs: impl Iterator<Item = (String, &'a str)>,
        rooms: impl Iterator<Item = (String, &'a str)>,
    ) -> Self {
        let (design_files, designs) = distinct(designs);
        let (room_files, rooms) = distinct(rooms);
        Self { designs, design_files, rooms, room_files }
    }

    /// The name of this number in one of the lists.
    pub fn of(list: &[String], number: usize) -> &str {
        list.get(number).map_or("", String::as_str)
    }
}

/// Files, and what stands for each.
fn distinct<'a>(named: impl Iterator<Item = (String, &'a str)>) -> (Vec<String>, Vec<String>) {
    let (files, names): (Vec<String>, Vec<&str>) = named.unzip();
    let is_shared = |name: &str| names.iter().filter(|other| **other == name).count() > 1;
    let all = files.iter().zip(&names);
    let labels = all.map(|(file, name)| match is_shared(name) || name.is_empty() {
        false => (*name).to_owned(),
        true => format!("{name} ({file})"),
    });
    let labels = labels.collect();
    (files, labels)
}

/// Columns before the figures.
const FIRST: &str = "design,design_file,environment,environment_file,no_figures,trials,outside,\
    out_of_volume,without_field,rejected";

/// Columns between the figures and their differences: the worst pose is the tool's in the CRF (or the
/// tracker).
const MIDDLE: &str = "basis,verdict,worst_trial,worst_position_mm,worst_angle_deg,worst_x,worst_y,\
    worst_z,worst_qw,worst_qx,worst_qy,worst_qz,baseline,motion_differs,requirement_differs,\
    environment_differs";

/// Writes the table.
pub fn write(out: &mut dyn Write, comparison: &Comparison, names: &Names) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    let figures = METRICS.iter().flat_map(|f| ["", "_low", "_high"].map(|what| column(*f, what)));
    let differences = METRICS.iter().flat_map(|f| {
        let ends = ["_difference", "_difference_low", "_difference_high"];
        let ends = ends.map(|what| column(*f, what));
        ends.into_iter().chain([format!("{}_verdict", f.name())])
    });
    let [first, middle] = [FIRST, MIDDLE].map(|names| names.split(',').map(str::to_owned));
    let columns: Vec<String> = first.chain(figures).chain(middle).chain(differences).collect();
    table.write_record(&columns)?;
    for row in &comparison.rows {
        table.write_record(cells(row, comparison, names, &columns))?;
    }
    table.flush()
}

/// `position_rms_mm`, `angle_max_difference_deg`.
fn column(metric: Metric, what: &str) -> String {
    format!("{}{what}_{}", metric.name(), metric.of.unit_key())
}

/// Cells of what is not there are empty.
fn cells(row: &Row, comparison: &Comparison, names: &Names, columns: &[String]) -> Vec<String> {
    let mut cells = vec![
        Names::of(&names.designs, row.design).to_owned(),
        Names::of(&names.design_files, row.design).to_owned(),
        Names::of(&names.rooms, row.room).to_owned(),
        Names::of(&names.room_files, row.room).to_owned(),
        row.measured.as_ref().err().map_or_else(String::new, ToString::to_string),
    ];
    if let Ok(measured) = &row.measured {
        let (known, field) = (&measured.study.figures, &measured.study.room_field);
        let left_out = [field.outside, field.out_of_volume, field.without_field, field.rejected];
        cells.push(field.trials.to_string());
        cells.extend(left_out.map(|count| count.to_string()));
        cells.extend(known.all.iter().flat_map(|figure| {
            let ends = [Some(figure.value), figure.low, figure.high];
            ends.map(|end| end.map_or_else(String::new, shortest))
        }));
        cells.push(known.basis.key().to_owned());
        let verdict = known.requirement.as_ref().map(|requirement| requirement.verdict);
        cells.push(verdict.map_or("", Verdict::key).to_owned());
        cells.push(field.worst.trial.to_string());
        cells.extend([field.worst.position_mm, field.worst.angle_deg].map(shortest));
        cells.extend(pose_to_array(&measured.worst_pose.crf_from_tool).map(shortest));
    }
    let of_baseline = columns.iter().position(|name| name == "baseline");
    cells.resize(of_baseline.unwrap_or(columns.len()), String::new());
    if let Some(against) = &row.against_baseline {
        cells.push(Names::of(&names.designs, comparison.baseline).to_owned());
        let differs = [against.motion_differs, against.requirement_differs, against.room_differs];
        cells.extend(differs.map(|is| u8::from(is).to_string()));
        for d in &against.differences {
            cells.extend([d.difference, d.low, d.high].map(shortest));
            cells.push(verdict(d.verdict).to_owned());
        }
    }
    cells.resize(columns.len(), String::new());
    cells
}

/// As JSON has it.
fn verdict(verdict: DifferenceVerdict) -> &'static str {
    match verdict {
        DifferenceVerdict::Better => "better",
        DifferenceVerdict::Worse => "worse",
        DifferenceVerdict::NotTold => "not_told",
        DifferenceVerdict::Negligible => "negligible",
        DifferenceVerdict::RoomUnknown => "room_unknown",
        DifferenceVerdict::OtherRoom => "other_room",
        DifferenceVerdict::Unsettled => "unsettled",
    }
}

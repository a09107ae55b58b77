//! `compare`: designs beside each other in one room or several, and what of their differences is one.

use super::figures;
use super::named_design::note_sizes;
use super::numbers::zero_or_more;
use super::prelude::*;
use trackwright_design::Design;
use trackwright_field::samples::MapKind;
use trackwright_formats::comparison_table::{self, Names};
use trackwright_project::{ComparedDesign, ComparedRoom, ComparedRooms};
use trackwright_report::comparison_json::comparison_json;
use trackwright_report::text_table::columns;
use trackwright_simulation::comparison::{
    Comparison, LEAST_DEG, LEAST_MM, Least, Row, Settings, compare, difference_words, met_words,
    notes, worst_words,
};
use trackwright_simulation::{ErrorOf, Metric, Summary};

/// Longest name that a table shows whole.
const MAX_NAME: usize = 36;

/// Hold designs against each other in one room or several, and report which differences are more
/// than the room's uncertainty and the sampling of the motion
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Designs (*.design.ron); each is simulated over its range of motion, or where it has none at its
    /// own pose
    #[arg(required = true, value_name = "DESIGN")]
    designs: Vec<PathBuf>,

    /// Rooms (*.env.ron) that every design is simulated in; without any, each design is in its own
    #[arg(long, value_name = "ENV", num_args = 1..)]
    environment: Vec<PathBuf>,

    /// The design that the others are held against, by its file or its name; the first where none is
    /// named
    #[arg(long, value_name = "DESIGN")]
    baseline: Option<PathBuf>,

    /// What happens to sensors outside the model's box; rejected trials are left out and counted
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    /// Difference of tip errors below which there is none that matters
    #[arg(long, value_name = "MM", default_value_t = LEAST_MM, value_parser = zero_or_more)]
    least_mm: f64,

    /// Likewise of angles
    #[arg(long, value_name = "DEG", default_value_t = LEAST_DEG, value_parser = zero_or_more)]
    least_deg: f64,

    /// Seed of the fields that a room might as well have, and of the poses between those of the grid
    #[arg(long, default_value_t = 0)]
    seed: u64,

    /// Table to write, one row a design and room
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,

    /// How to print the comparison
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Reads, simulates, and prints a row for every design in every room.
///
/// # Errors
/// Files that can't be used, a design named twice, a baseline that is none of the designs.
pub fn run(args: &CompareArgs, files: &Files) -> anyhow::Result<()> {
    let csv = files.optional_output(args.csv.as_deref())?;
    named_once(&args.designs, "design")?;
    named_once(&args.environment, "environment")?;
    let designs = trackwright_project::read_compared_designs(files, &args.designs)?;
    for compared in &designs {
        note_sizes(&compared.design);
    }
    let baseline = match &args.baseline {
        None => 0,
        Some(named) => baseline(named, &designs)?,
    };
    let own_rooms: Vec<PathBuf> = designs.iter().map(|d| d.own_room.clone()).collect();
    let is_own = args.environment.is_empty();
    let rooms = match is_own {
        true => &own_rooms,
        false => &args.environment,
    };
    let ComparedRooms { rooms, of_file } = trackwright_project::read_compared_rooms(files, rooms)?;
    let of_design = |design: usize| match is_own {
        true => vec![of_file[design]],
        false => (0..rooms.len()).collect(),
    };
    let all: Vec<&Design> = designs.iter().map(|d| &d.design).collect();
    let plan = trackwright_project::comparison_plan(
        &all,
        rooms.iter().map(|r| r.environment.clone()).collect(),
        of_design,
        baseline,
        args.outside,
    );
    for ComparedRoom { file, environment } in &rooms {
        if environment.model.map() == MapKind::Correction {
            output::note(&format!(
                "note: {} is a correction map, a function of the measured pose; it is used as a distortion map",
                file.display()
            ));
        }
    }
    let settings = Settings {
        least: Least { mm: args.least_mm, deg: args.least_deg },
        seed: args.seed,
        ..Settings::default()
    };
    let shown = Shown::new("comparing");
    let found = compare(&plan, &settings, &shown.task)?;
    drop(shown);
    let names = Names::new(
        (designs.iter()).map(|d| (d.file.display().to_string(), d.design.name.as_str())),
        (rooms.iter()).map(|r| (r.file.display().to_string(), r.environment.name.as_str())),
    );
    if let Some(csv) = &csv {
        csv.write(|out| comparison_table::write(out, &found, &names))?;
    }
    args.format.print(|| comparison_json(&found, &names), || as_text(&found, &names))
}

/// # Errors
/// The second of two names of one file.
pub(super) fn named_once(files: &[PathBuf], what: &str) -> anyhow::Result<()> {
    for (number, file) in files.iter().enumerate() {
        if let Some(first) =
            files[..number].iter().find(|first| trackwright_project::is_same_file(first, file))
        {
            bail!(
                "{}: found the same {what} named twice (as {} before), expected each once",
                file.display(),
                first.display()
            );
        }
    }
    Ok(())
}

/// The number of the design that is meant.
fn baseline(named: &Path, designs: &[ComparedDesign]) -> anyhow::Result<usize> {
    let by_file = designs.iter().position(|d| trackwright_project::is_same_file(&d.file, named));
    if let Some(number) = by_file {
        return Ok(number);
    }
    let mut by_name = (0..designs.len()).filter(|&d| Path::new(&designs[d].design.name) == named);
    match (by_name.next(), by_name.next()) {
        (Some(number), None) => return Ok(number),
        (Some(_), Some(_)) => bail!(
            "--baseline {}: found several designs of this name, expected the file of one",
            named.display()
        ),
        (None, _) => {}
    }
    let files: Vec<String> = designs.iter().map(|d| d.file.display().to_string()).collect();
    let found = match named.exists() {
        true => "a design that is not compared",
        false => "no such file, and no design of this name",
    };
    bail!("--baseline {}: found {found}, expected one of {}", named.display(), files.join(", "))
}

fn as_text(found: &Comparison, names: &Names) -> String {
    let labels = short(&names.designs);
    let mut rooms: Vec<usize> = found.rows.iter().map(|row| row.room).collect();
    rooms.sort_unstable();
    rooms.dedup();
    let mut parts = Vec::new();
    for room in rooms {
        let rows: Vec<&Row> = found.rows.iter().filter(|row| row.room == room).collect();
        parts.push(one_line(Names::of(&names.rooms, room)));
        parts.push(table(&rows, &labels, found.baseline));
        for row in rows {
            parts.extend(about(row, &labels, found.baseline));
        }
        if let Some(why) = found.rooms_unknown[room] {
            parts.push(format!("  the uncertainty of the room's field is unknown: {why}"));
        }
        parts.push(String::new());
    }
    parts.pop();
    parts.join("\n")
}

/// The figures, a line a design.
fn table(rows: &[&Row], labels: &[String], baseline: usize) -> String {
    let figures = Metric::bounded().map(|m| format!("{} {}", m.summary.short(), m.unit()));
    let last = ["required", "ΔRMS mm", "ΔRMS °"].map(str::to_owned);
    let header: Vec<String> = std::iter::once(String::new()).chain(figures).chain(last).collect();
    let width = header.len();
    let mut lines = vec![header];
    for row in rows {
        let mut cells = vec![Names::of(labels, row.design).to_owned()];
        match &row.measured {
            Err(_) => cells.extend((1..width).map(|_| "–".to_owned())),
            Ok(measured) => {
                cells.extend(measured.study.figures.bounded().map(|figure| figure.value_text(4)));
                cells.push(met_words(measured).to_owned());
                cells.extend(changes(row, baseline));
            }
        }
        lines.push(cells);
    }
    let aligned = columns(&lines, 1).into_iter().map(|line| format!("  {line}"));
    aligned.collect::<Vec<_>>().join("\n")
}

/// The differences of the RMS of tip and angle.
fn changes(row: &Row, baseline: usize) -> [String; 2] {
    if row.design == baseline {
        return ["baseline".to_owned(), String::new()];
    }
    let Some(against) = &row.against_baseline else {
        return ["–", "–"].map(str::to_owned);
    };
    [ErrorOf::Position, ErrorOf::Angle].map(|of| {
        let found = against
            .differences
            .iter()
            .find(|d| d.metric.of == of && d.metric.summary == Summary::Rms);
        found.map_or_else(String::new, |d| format!("{:+.4}", d.difference))
    })
}

/// What a line of the table leaves out.
fn about(row: &Row, labels: &[String], baseline: usize) -> Vec<String> {
    let name = Names::of(labels, row.design);
    let mut lines = vec![format!("  {name}")];
    match &row.measured {
        Err(why) => lines.push(format!("    no figures: {why}")),
        Ok(measured) => {
            if let Some(against) = &row.against_baseline {
                let shown = Metric::bounded();
                let width = shown.clone().map(|m| m.label().chars().count()).max().unwrap_or(0);
                lines.extend(shown.map(|metric| {
                    let difference = &against.differences[metric.index()];
                    let words = difference_words(difference, Names::of(labels, baseline));
                    format!("    {:<width$}  {words}", metric.label())
                }));
            }
            let rows = figures::rows(&measured.study.figures).into_iter();
            lines.extend(rows.map(|(label, value, unit)| format!("    {label}  {value} {unit}")));
            let line = figures::no_interval_line(&measured.study.figures);
            lines.extend(line.map(|line| format!("    {line}")));
            lines.push(format!("    {}", worst_words(measured)));
            let notes = notes(measured, row.against_baseline.as_ref());
            lines.extend(notes.into_iter().map(|note| format!("    note: {note}")));
        }
    }
    lines
}

/// Names for a table: on one line, and cut where that leaves them different.
fn short(names: &[String]) -> Vec<String> {
    let whole: Vec<String> = names.iter().map(|name| one_line(name)).collect();
    let cut: Vec<String> = whole
        .iter()
        .map(|name| match name.chars().count() > MAX_NAME {
            false => name.clone(),
            true => {
                let kept: String = name.chars().take(MAX_NAME - 1).collect();
                format!("{}…", kept.trim_end())
            }
        })
        .collect();
    let is_own = |name: &String| cut.iter().filter(|other| *other == name).count() == 1;
    whole
        .into_iter()
        .zip(&cut)
        .map(|(whole, cut)| if is_own(cut) { cut.clone() } else { whole })
        .collect()
}

/// A name as a terminal can show it.
fn one_line(name: &str) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    name.chars().map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_where_they_stay_different() {
        let name = |end: &str| format!("A shaver with three sensors along its shaft, {end}");
        let one = short(&[name("a"), "b".to_owned()]);
        assert_eq!(one[0], "A shaver with three sensors along i…");
        assert_eq!(one[0].chars().count(), MAX_NAME);
        assert_eq!(short(&[name("a"), name("b")]), [name("a"), name("b")]);
        assert_eq!(short(&["a\tb\n\u{1b}[31m".to_owned()]), ["a b  [31m"]);
    }
}

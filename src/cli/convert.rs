//! `convert`: tool definitions of trackers' makers, bodies, and back; whether several are
//! distinguishable.

use super::numbers::above_zero;
use super::prelude::*;
use nalgebra::Point3;
use trackwright_design::definition::DefinitionKind;
use trackwright_formats::tool_definition::{
    BodyFormat, Conversion, Lost, OnMismatch, ToolDefinition, from_body,
};
use trackwright_project::{ReadTool, StoreError};
use trackwright_result::{Section, Table, data};
use trackwright_simulation::SensorOrientation;
use trackwright_simulation::distinct::{
    Comparison, Distinction, LEAST_MM, compare_tools, compare_with_itself,
};

/// Convert a tool definition of a tracker's maker to a body file, back, or to another maker's
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The tool, known by what is in the file: an NDI ROM (*.rom, optical or Aurora) or one in a
    /// *.tool file, an Atracsys geometry (*.ini), a SAW geometry (*.json), or a body (*.body.ron)
    #[arg(value_name = "IN", required_unless_present = "check")]
    input: Option<PathBuf>,

    /// What to write, known by the file's name: *.body.ron, *.rom (optical for a body of markers,
    /// Aurora for one of 5-DOF sensors), *.tool, *.ini or *.json. Writing an Aurora ROM is
    /// experimental: its format is known from one real file. What a body does not use of a
    /// definition travels in its file, and is written back
    #[arg(value_name = "OUT", required_unless_present = "check")]
    output: Option<PathBuf>,

    /// Report whether an optical tracker can distinguish these tools, by the distances and angles
    /// of their markers, and whether one of them looks the same from two sides; exit status 1 where
    /// it cannot
    #[arg(long, value_name = "TOOL", num_args = 1.., conflicts_with_all = ["input", "output"])]
    check: Vec<PathBuf>,

    /// Distances between markers that differ by less may be taken for each other
    #[arg(long, value_name = "MM", default_value_t = LEAST_MM, requires = "check", value_parser = above_zero)]
    least_mm: f64,

    /// Read a ROM whose checksum does not match; one that is written from it does
    #[arg(long)]
    force: bool,

    /// How to print what was read and written
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Reads, writes, and reports what was lost.
///
/// # Errors
/// Files that can't be used, and bodies that cannot be such a definition.
pub fn run(args: &ConvertArgs, files: &Files) -> anyhow::Result<Ending> {
    match (&args.input, &args.output) {
        (Some(input), Some(output)) => {
            convert(args, input, output, files)?;
            Ok(Ending::Done)
        }
        _ => check(args, files),
    }
}

fn read(args: &ConvertArgs, files: &Files, file: &Path) -> anyhow::Result<ReadTool> {
    let on_mismatch = match args.force {
        true => OnMismatch::Accept,
        false => OnMismatch::Refuse,
    };
    files.read_tool(file, on_mismatch).map_err(with_way_out)
}

fn convert(args: &ConvertArgs, input: &Path, file: &Path, files: &Files) -> anyhow::Result<()> {
    let output = files.output(file)?;
    let target = trackwright_project::body_format_of(file)?;
    let tool = read(args, files, input)?;
    let written = match target {
        BodyFormat::Body => {
            output.write_body(&tool.body, input)?;
            None
        }
        BodyFormat::Definition(format) => {
            let conversion = from_body(&tool.body, format)
                .with_context(|| format!("{}: no {}", input.display(), format.name()))?;
            output.write_definition(&conversion.definition)?;
            Some(conversion)
        }
    };
    for note in notes(&tool, written.as_ref()) {
        output::note(&format!("{}: {note}", file.display()));
    }
    let read = Section::default()
        .with(format!("{}: {}", input.display(), read_kind(&tool)))
        .with_all(tool.section().items);
    let code = written.as_ref().map_or("body", |written| written.definition.kind().code());
    let lost = written.as_ref().map_or(&[][..], |written| &written.lost);
    let lost = Table::of("lost", lost).data("what", Lost::code).data("note", Lost::to_string);
    let found = Section::of([
        data("written.kind", code),
        data("written.new_image", written.as_ref().is_some_and(|written| written.is_new_image)),
        data("written.experimental", code == DefinitionKind::NdiEm.code()),
    ])
    .with(read.named("read"))
    .with(lost.done())
    .with(format!("{}: {}, written", file.display(), written_kind(written.as_ref())));
    output::print_section(args.format, &found)
}

/// The error and, where there is one, the way past it.
fn with_way_out(error: StoreError) -> anyhow::Error {
    match error.is_checksum() {
        true => anyhow::anyhow!("{error} (--force reads it all the same)"),
        false => error.into(),
    }
}

/// What the file was, with its article.
fn read_kind(tool: &ReadTool) -> String {
    let carried = tool.body.definition.as_ref().map(|d| d.kind.name());
    match (tool.kind, carried) {
        (Some(kind), _) => kind.name().to_owned(),
        (None, Some(carried)) => format!("a body from {carried}"),
        (None, None) => "a body".to_owned(),
    }
}

fn written_kind(written: Option<&Conversion>) -> &'static str {
    written.map_or("a body", |written| written.definition.kind().name())
}

/// Notes beside the result, a line each.
fn notes(tool: &ReadTool, written: Option<&Conversion>) -> Vec<String> {
    let read = ToolDefinition::carried(tool.body.definition.as_deref());
    let doubt = read.as_ref().and_then(ToolDefinition::doubt);
    let size = tool.body.rigid.size_doubt();
    let size = size.map(|doubt| format!("warning: tip and sensors: {doubt}"));
    let notes = written.map(Conversion::notes).unwrap_or_default();
    doubt.into_iter().chain(size).chain(notes).collect()
}

/// A tool that has been read.
struct CheckedTool<'a> {
    file: &'a Path,
    sensors: Vec<String>,
    markers: Vec<Point3<f64>>,
}

/// Two tools, or one twice.
struct Pair {
    tools: [usize; 2],
    found: Comparison,
}

/// Compares every tool with itself and with every other, and prints what is found.
///
/// # Errors
/// Files that can't be used.
fn check(args: &ConvertArgs, files: &Files) -> anyhow::Result<Ending> {
    let mut tools = Vec::with_capacity(args.check.len());
    for file in &args.check {
        tools.push(checked_tool(args, files, file)?);
    }
    for tool in tools.iter().filter(|tool| tool.markers.len() < 3) {
        output::note(&format!(
            "note: {}: {} markers, expected three at least; a tool of coils is known by its port and serial number, \
             not by where they are",
            tool.file.display(),
            tool.markers.len()
        ));
    }
    let pairs = compared(&tools, args.least_mm);
    output::print_section(args.format, &check_section(&tools, &pairs, args.least_mm))?;
    let is_apart = |pair: &Pair| pair.found.distinction == Distinction::Apart;
    Ok(match pairs.iter().all(is_apart) {
        true => Ending::Done,
        false => Ending::DoesNotHold,
    })
}

fn checked_tool<'a>(
    args: &ConvertArgs,
    files: &Files,
    file: &'a Path,
) -> anyhow::Result<CheckedTool<'a>> {
    let body = read(args, files, file)?.body.rigid;
    let markers = body.sensors.into_iter();
    let markers = markers.filter(|sensor| sensor.orientation == SensorOrientation::Marker);
    let (sensors, markers) = markers.map(|sensor| (sensor.name, sensor.position_in_body)).unzip();
    Ok(CheckedTool { file, sensors, markers })
}

fn compared(tools: &[CheckedTool], least_mm: f64) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (i, first) in tools.iter().enumerate() {
        for (j, second) in tools.iter().enumerate().skip(i) {
            let found = match i == j {
                true => compare_with_itself(&first.markers, least_mm),
                false => compare_tools(&first.markers, &second.markers, least_mm),
            };
            pairs.extend(found.map(|found| Pair { tools: [i, j], found }));
        }
    }
    pairs
}

fn check_section(tools: &[CheckedTool], pairs: &[Pair], least_mm: f64) -> Section {
    let of = |pair: &Pair| pair.tools.map(|tool| &tools[tool]);
    let table = Table::of("pairs", pairs)
        .data("tools", |pair| of(pair).map(|tool| tool.file.display().to_string()))
        .data("found", |pair| json!(pair.found));
    Section::of([data("least_mm", least_mm)])
        .with(table.done())
        .with_all(pairs.iter().map(|pair| check_line(of(pair), pair)))
}

fn check_line([a, b]: [&CheckedTool; 2], pair: &Pair) -> String {
    let Comparison { distinction, markers: [own, other], distance_mm, angle_deg } = &pair.found;
    let names =
        |tool: &CheckedTool, of: &[usize; 3]| of.map(|k| tool.sensors[k].clone()).join(", ");
    let is_one = pair.tools[0] == pair.tools[1];
    let who = match is_one {
        true => format!("{} with itself", a.file.display()),
        false => format!("{} and {}", a.file.display(), b.file.display()),
    };
    let verdict = match (distinction, is_one) {
        (Distinction::Apart, true) => "looks different from every side",
        (Distinction::Apart, false) => "distinguishable",
        (Distinction::ThreeMarkersAlike, _) => "may be confused where only three markers are seen",
        (Distinction::Alike, true) => "looks the same from two sides",
        (Distinction::Alike, false) => "indistinguishable",
    };
    format!(
        "{who}: {verdict}; markers {} and {} differ by {distance_mm:.2} mm and {angle_deg:.1}° at most",
        names(a, own),
        names(b, other)
    )
}

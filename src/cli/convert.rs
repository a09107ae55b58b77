//! `convert`: tool definitions of trackers' makers, bodies, and back.

use super::output::{self, Format};
use super::tool_report;
use crate::formats::FormatError;
use crate::formats::tool_definition::{
    Conversion, DefinitionFormat, DefinitionKind, Lost, NdiRom, OnMismatch, from_body,
};
use crate::store::{self, ReadTool, StoreError};
use anyhow::{Context, bail};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The tool, known by what is in the file: an NDI ROM (*.rom, optical or Aurora) or one in a
    /// *.tool file, an Atracsys geometry (*.ini), a SAW geometry (*.json), or a body (*.body.ron)
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// What to write, known by the file's name: *.body.ron, *.rom (optical for a body of markers,
    /// Aurora for one of 5-DOF sensors), *.tool, *.ini or *.json. Writing an Aurora ROM is
    /// experimental: its format is known from one real file. What a body does not use of a
    /// definition travels in its file, and is written back
    #[arg(value_name = "OUT")]
    output: PathBuf,

    /// Read a ROM whose checksum does not match; one that is written from it does
    #[arg(long)]
    force: bool,

    /// How to print what was read and written
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// What OUT is to be.
enum Target {
    Body,
    Definition(DefinitionFormat),
}

/// Reads, writes, and says what was lost.
///
/// # Errors
/// Files that can't be used, and bodies that cannot be such a definition.
pub fn run(args: &ConvertArgs) -> anyhow::Result<()> {
    let target = target_of(&args.output)?;
    if store::is_same_file(&args.input, &args.output) {
        bail!(
            "{}: IN and OUT are one file, expected another one to write",
            args.output.display()
        );
    }
    let on_mismatch = match args.force {
        true => OnMismatch::Accept,
        false => OnMismatch::Refuse,
    };
    let tool = store::read_tool(&args.input, on_mismatch).map_err(with_way_out)?;
    let written = match target {
        Target::Body => {
            store::write_body(&args.output, &tool.body, &args.input)?;
            None
        }
        Target::Definition(format) => {
            let conversion = from_body(&tool.body, format)
                .with_context(|| format!("{}: no {}", args.input.display(), name_of(format)))?;
            store::write_definition(&args.output, &conversion.definition)?;
            Some(conversion)
        }
    };
    for note in notes(&tool, written.as_ref()) {
        output::note(&format!("{}: {note}", args.output.display()));
    }
    match args.format {
        Format::Json => output::print_json(&as_json(&tool, written.as_ref())),
        Format::Text => {
            let read = tool_report::as_text(&tool);
            let kind = written_kind(written.as_ref());
            output::print(&format!(
                "{}: {}\n{read}\n{}: {kind}, written",
                args.input.display(),
                tool_report::kind_name(&tool),
                args.output.display(),
            ))
        }
    }
}

fn target_of(file: &Path) -> anyhow::Result<Target> {
    let extension = file.extension().unwrap_or_default().to_string_lossy();
    if extension.eq_ignore_ascii_case("ron") {
        return Ok(Target::Body);
    }
    match DefinitionFormat::of_extension(&extension) {
        Some(format) => Ok(Target::Definition(format)),
        None => bail!(
            "{}: found a name that says no format, expected one in .body.ron, .rom, .tool, .ini or .json",
            file.display()
        ),
    }
}

/// The error and, where there is one, the way past it.
fn with_way_out(error: StoreError) -> anyhow::Error {
    match &error {
        StoreError::Format {
            cause: FormatError::Checksum { .. },
            ..
        } => anyhow::anyhow!("{error} (--force reads it all the same)"),
        _ => error.into(),
    }
}

fn name_of(format: DefinitionFormat) -> &'static str {
    match format {
        DefinitionFormat::Rom => "ROM",
        DefinitionFormat::ToolPlist => ".tool file",
        DefinitionFormat::AtracsysIni => "Atracsys geometry",
        DefinitionFormat::SawJson => "SAW geometry",
    }
}

fn written_kind(written: Option<&Conversion>) -> &'static str {
    written.map_or("a body", |written| written.definition.kind().name())
}

/// What there is to say beside the result, a line each.
fn notes(tool: &ReadTool, written: Option<&Conversion>) -> Vec<String> {
    let mut notes = Vec::new();
    let read = tool.body.definition.as_ref().and_then(|d| d.rom());
    if let Some(sum) = read.map(NdiRom::checksum).filter(|sum| !sum.matches()) {
        notes.push(format!(
            "read from an image whose checksum is {}, expected {}",
            sum.stored, sum.computed
        ));
    }
    let Some(written) = written else {
        return notes;
    };
    notes.extend(written.lost.iter().map(|lost| format!("without {lost}")));
    if written.is_new_image {
        notes.push(
            "a new image: serial number, date and manufacturer are empty, what a body does not say is as in most real ones"
                .to_owned(),
        );
    }
    let rom = written.definition.rom();
    if let (Some(was), Some(rom)) = (written.mended_checksum, rom) {
        notes.push(format!(
            "checksum was {}, is {} now",
            was.stored,
            rom.checksum().stored
        ));
    }
    if matches!(rom, Some(NdiRom::Em(_))) {
        notes.push(
            "writing Aurora ROMs is experimental: look at it in NDI's own software before a tool is programmed with it"
                .to_owned(),
        );
    }
    notes
}

fn as_json(tool: &ReadTool, written: Option<&Conversion>) -> Value {
    let code = written.map_or("body", |written| written.definition.kind().code());
    let lost = written.map_or(&[][..], |written| &written.lost);
    let line = |lost: &Lost| json!({"what": lost.code(), "note": lost.to_string()});
    let kind = tool.kind.map_or("body", DefinitionKind::code);
    json!({
        "read": tool_report::as_json(tool, kind),
        "written": {
            "kind": code,
            "new_image": written.is_some_and(|written| written.is_new_image),
            "experimental": code == DefinitionKind::NdiEm.code(),
        },
        "lost": lost.iter().map(line).collect::<Vec<_>>(),
    })
}

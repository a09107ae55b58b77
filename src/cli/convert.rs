//! `convert`: tool definitions of trackers' makers, bodies, and back.

use super::output::{self, Format};
use super::tool_report;
use crate::formats::tool_definition::{
    BodyFormat, Conversion, DefinitionKind, Lost, OnMismatch, ToolDefinition, from_body,
};
use crate::store::{self, ReadTool, StoreError};
use anyhow::{Context, bail};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

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

/// Reads, writes, and says what was lost.
///
/// # Errors
/// Files that can't be used, and bodies that cannot be such a definition.
pub fn run(args: &ConvertArgs) -> anyhow::Result<()> {
    let target = store::body_format_of(&args.output)?;
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
        BodyFormat::Body => {
            store::write_body(&args.output, &tool.body, &args.input)?;
            None
        }
        BodyFormat::Definition(format) => {
            let conversion = from_body(&tool.body, format)
                .with_context(|| format!("{}: no {}", args.input.display(), format.name()))?;
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

/// The error and, where there is one, the way past it.
fn with_way_out(error: StoreError) -> anyhow::Error {
    match error.is_checksum() {
        true => anyhow::anyhow!("{error} (--force reads it all the same)"),
        false => error.into(),
    }
}

fn written_kind(written: Option<&Conversion>) -> &'static str {
    written.map_or("a body", |written| written.definition.kind().name())
}

/// What there is to say beside the result, a line each.
fn notes(tool: &ReadTool, written: Option<&Conversion>) -> Vec<String> {
    let read = tool.body.definition.as_deref();
    let doubt = read.and_then(ToolDefinition::doubt);
    let size = tool.body.rigid.size_doubt();
    let size = size.map(|doubt| format!("warning: tip and sensors: {doubt}"));
    let notes = written.map(Conversion::notes).unwrap_or_default();
    doubt.into_iter().chain(size).chain(notes).collect()
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

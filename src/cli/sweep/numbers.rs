//! `sweep numbers`: what a plan may vary of a design.

use super::super::prelude::*;
use trackwright_report::section_text::section_text;
use trackwright_result::{Row, Section, text};

#[derive(Debug, Args)]
pub(super) struct NumbersArgs {
    /// Design (*.design.ron), or the name of a built-in one
    design: PathBuf,

    /// How to print them
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Prints the paths of all numbers of a design, with what they are.
///
/// # Errors
/// A design that can't be read.
pub(super) fn run(args: &NumbersArgs, files: &Files) -> anyhow::Result<()> {
    let world = files.open_design_without_meshes(&args.design)?;
    let all = trackwright_sweep::number_paths(world.document.design());
    let rows = all.iter().map(|(path, value, unit)| Row {
        unit,
        ..text(path.clone(), path.clone(), value.to_string())
    });
    let rows = Section::of(rows);
    let each = |(path, value, unit): &(String, f64, &str)| json!({"path": path, "value": value, "unit": unit});
    args.format.print(|| all.iter().map(each).collect::<Vec<_>>(), || section_text(&rows))
}

//! `sweep numbers`: what a plan may vary of a design.

use super::super::prelude::*;

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
    args.format.print(
        || {
            let each = all
                .iter()
                .map(|(path, value, unit)| json!({"path": path, "value": value, "unit": unit}));
            each.collect::<Vec<_>>()
        },
        || {
            let rows = all.iter().map(|(path, value, unit)| row(path, value.to_string(), unit));
            output::aligned(&rows.collect::<Vec<_>>())
        },
    )
}

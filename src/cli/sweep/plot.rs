//! `sweep plot`: the rows of a sweep as pictures.

use super::super::prelude::*;
use trackwright_report::sweep::{
    NumberColumn, SweepColumns, effect_chart, front_chart, page, parallel_coordinates,
};
use trackwright_simulation::Metric;
use trackwright_sweep::{ROW, SweepTable};

const WIDE: (u32, u32) = (1200, 560);
const CHART: (u32, u32) = (900, 520);

#[derive(Debug, Args)]
pub(super) struct PlotArgs {
    /// Folder that `sweep` wrote, or a table that `sweep merge` wrote
    sweep: PathBuf,

    /// Folder to write sweep.html and its pictures to
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    /// Columns of figures, the first of which colours the rows and is held against each number; by
    /// default those of the plan
    #[arg(long, value_name = "COLUMN", num_args = 1..)]
    figure: Vec<String>,
}

/// Draws the rows.
///
/// # Errors
/// A column that is not there, files that can't be used.
pub(super) fn run(args: &PlotArgs, files: &Files) -> anyhow::Result<()> {
    let table = SweepTable::open(&args.sweep)?;
    table.files().try_for_each(|file| files.input(file))?;
    let sweep = columns(&table, args)?;
    output::make_folder(Some(&args.output))?;
    let put = |name: &str, text: &str| -> anyhow::Result<()> {
        Ok(files.output(&args.output.join(name))?.write_bytes(text.as_bytes())?)
    };
    put("parallel.svg", &parallel_coordinates(&sweep, WIDE))?;
    let first = &sweep.figures[0];
    for (k, number) in sweep.parameters.iter().enumerate() {
        put(&format!("effect-{}.svg", k + 1), &effect_chart(&sweep, number, first).to_svg(CHART))?;
    }
    if let [first, second, ..] = sweep.figures.as_slice() {
        put("front.svg", &front_chart(&sweep, first, second).to_svg(CHART))?;
    }
    put("sweep.html", &page(&sweep))?;
    output::print(&args.output.join("sweep.html").display().to_string())
}

fn columns(table: &SweepTable, args: &PlotArgs) -> anyhow::Result<SweepColumns> {
    let all = table.columns();
    let read = |name: &str| -> anyhow::Result<NumberColumn> {
        let values = table.numbers(name)?;
        let unit = all.iter().find(|c| c.name == name).map(|c| c.unit.clone()).unwrap_or_default();
        Ok(NumberColumn { name: name.to_owned(), unit, values })
    };
    let figures: Vec<String> = match args.figure.is_empty() {
        false => args.figure.clone(),
        true => {
            let is_figure = |name: &str| Metric::named(name).is_some();
            all.iter().map(|c| c.name.clone()).filter(|name| is_figure(name)).collect()
        }
    };
    let parameters = table.parameters();
    Ok(SweepColumns {
        title: file_name(&args.sweep),
        rows: table.numbers(ROW)?.into_iter().map(|row| row as u64).collect(),
        parameters: parameters.iter().map(|name| read(name)).collect::<anyhow::Result<_>>()?,
        figures: figures.iter().map(|name| read(name)).collect::<anyhow::Result<_>>()?,
    })
}

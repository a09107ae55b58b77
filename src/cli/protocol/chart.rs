//! `protocol chart`: control charts of the tables of repeated runs.

use super::super::prelude::*;
use clap::ValueEnum;
use trackwright_calibration::protocol::control_chart::{MIN_FOR_LIMITS, Rules, control_chart};
use trackwright_calibration::protocol::table::{ALL, Measure, ProtocolRow, ProtocolTable};
use trackwright_report::control_charts::{self, FigureChart};

#[derive(Debug, Args)]
pub struct ChartArgs {
    /// Tables of `protocol hummel`; ordered by their dates where all have one, else as they are named
    #[arg(required = true, num_args = 2.., value_name = "TABLE")]
    tables: Vec<PathBuf>,

    /// Chart to write (SVG): individuals and moving ranges of each figure
    #[arg(short, long, value_name = "CHART.svg")]
    output: PathBuf,

    /// Take the limits from the first N tables, 8 at least; from all where left out
    #[arg(long, value_name = "N")]
    baseline: Option<usize>,

    /// Which points count as out of control
    #[arg(long, value_enum, default_value_t)]
    rules: RulesArg,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum RulesArg {
    /// One point beyond 3 σ, two of three beyond 2 σ, four of five beyond σ, eight in a row on a side
    #[default]
    WesternElectric,
    /// One point beyond 3 σ
    Nelson1,
}

/// A figure that tables have: a row, and which of its numbers.
struct Figure {
    measure: Measure,
    condition: String,
}

impl Figure {
    /// Of a rod the largest shift, of all else the RMS.
    fn value(&self, table: &ProtocolTable) -> Option<f64> {
        let found = table.row(&self.measure, &self.condition)?.statistics;
        Some(if self.is_largest() { found.max } else { found.rms })
    }

    fn is_largest(&self) -> bool {
        matches!(self.measure, Measure::Rod(_))
    }

    fn label(&self) -> String {
        let (label, condition) = (self.measure.label(), &self.condition);
        match self.is_largest() {
            true => format!("{label} at {condition}, max"),
            false => format!("{label}, RMS"),
        }
    }
}

/// Reads the tables, draws the charts, and lists what is out of control.
///
/// # Errors
/// Tables of another kind, tables without a common figure, limits from too few.
pub fn run(args: &ChartArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let mut runs = Vec::new();
    for file in &args.tables {
        runs.push((file, files.read_protocol_table(file)?));
    }
    let is_dated = runs.iter().all(|(_, table)| table.date.is_some());
    if is_dated {
        runs.sort_by(|(_, a), (_, b)| a.date.cmp(&b.date));
    }
    let names: Vec<String> = runs
        .iter()
        .map(|(file, table)| match &table.date {
            Some(date) if is_dated => date.clone(),
            _ => file_name(file).trim_end_matches(".csv").to_owned(),
        })
        .collect();
    let tables: Vec<&ProtocolTable> = runs.iter().map(|(_, table)| table).collect();
    let rules = match args.rules {
        RulesArg::WesternElectric => Rules::WesternElectric,
        RulesArg::Nelson1 => Rules::NelsonFirst,
    };
    let mut charts = Vec::new();
    for figure in figures(&tables) {
        let values: Vec<f64> = tables.iter().filter_map(|table| figure.value(table)).collect();
        if values.len() < tables.len() {
            output::note(&format!(
                "note: {} is in {} of {} tables, and not charted",
                figure.label(),
                values.len(),
                tables.len()
            ));
            continue;
        }
        let chart = control_chart(&values, args.baseline, rules)
            .map_err(|error| anyhow!("no control chart: {error}; a table is a run"))?;
        let (key, unit) = (figure.measure.key(), figure.measure.unit());
        charts.push(FigureChart { key, label: figure.label(), unit, chart });
    }
    if charts.is_empty() {
        bail!("no control chart: found no figure that all {} tables have", tables.len());
    }
    if charts.iter().all(|figure| figure.chart.limits.is_none()) {
        output::note(&format!(
            "note: no limits: found {} tables, expected at least {MIN_FOR_LIMITS}",
            tables.len()
        ));
    }
    output.write_bytes(control_charts::svg(&charts, &names).as_bytes())?;
    let written = format!("written to {}", args.output.display());
    output::print_section(args.format, &control_charts::section(&charts, &names).with(written))
}

/// Figures of any table: of each measure its row over everything, of each rod its nearest distance.
fn figures(tables: &[&ProtocolTable]) -> Vec<Figure> {
    let mut found: Vec<Figure> = Vec::new();
    for row in tables.iter().flat_map(|table| &table.rows) {
        let ProtocolRow { measure, condition, .. } = row;
        let is_charted = matches!(measure, Measure::Rod(_)) || condition == ALL;
        if is_charted && found.iter().all(|figure| figure.measure != *measure) {
            found.push(Figure { measure: measure.clone(), condition: condition.clone() });
        }
    }
    found
}

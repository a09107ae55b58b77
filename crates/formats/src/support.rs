//! The part of an environment that keeps model validity.

use super::error::FormatError;
use super::ron_text;
use serde::Deserialize;
use std::fmt::Write;
use trackwright_field::DistortionModel;
use trackwright_field::validity::{Cell, Cells, FitValidity, FitValidityParts};
use trackwright_geometry::number::shortest;

#[derive(Deserialize)]
#[serde(rename = "Support", deny_unknown_fields)]
pub(super) struct SupportEntry {
    position_std_mm: Vec<Option<f64>>,
    angle_std_rad: Option<Vec<Option<f64>>>,
    greatest_leverage: Vec<f64>,
    greatest_undetermined: Vec<f64>,
    variance: Vec<Vec<f64>>,
    #[serde(default)]
    leverage: Vec<Vec<f64>>,
    #[serde(default)]
    undetermined: Vec<Vec<f64>>,
    samples: CellsEntry,
}

/// Origin, edge in mm, and `(i, j, k, bits of directions)` of each cell with a sample in it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CellsEntry {
    origin: [f64; 3],
    edge: f64,
    cells: Vec<(u32, u32, u32, u64)>,
}

impl SupportEntry {
    pub(super) fn check(self, model: &DistortionModel) -> Result<FitValidity, FormatError> {
        let origin = ron_text::point("support.samples.origin", self.samples.origin)?;
        let cells = self.samples.cells.into_iter();
        let cells =
            cells.map(|(i, j, k, directions)| Cell { index: [i, j, k], directions }).collect();
        let parts = FitValidityParts {
            position_std_mm: self.position_std_mm,
            angle_std_rad: self.angle_std_rad,
            greatest_leverage: self.greatest_leverage,
            greatest_undetermined: self.greatest_undetermined,
            variance: self.variance,
            leverage: self.leverage,
            undetermined: self.undetermined,
            cells: Cells::new(origin, self.samples.edge, cells),
        };
        FitValidity::from_parts(parts, model).map_err(FormatError::from)
    }
}

/// Writes a support as the last field of an environment.
pub(super) fn push(out: &mut String, parts: &FitValidityParts) {
    out.push_str("    support: (\n");
    push_list(out, "position_std_mm", &stds(&parts.position_std_mm));
    if let Some(std) = &parts.angle_std_rad {
        push_list(out, "angle_std_rad", &stds(std));
    }
    push_list(out, "greatest_leverage", &numbers(&parts.greatest_leverage));
    push_list(out, "greatest_undetermined", &numbers(&parts.greatest_undetermined));
    push_forms(out, "variance", &parts.variance);
    push_forms(out, "leverage", &parts.leverage);
    push_forms(out, "undetermined", &parts.undetermined);
    push_cells(out, &parts.cells);
    out.push_str("    ),\n");
}

fn stds(std: &[Option<f64>]) -> Vec<String> {
    std.iter().map(|s| s.map_or_else(|| "None".to_owned(), shortest)).collect()
}

fn numbers(values: &[f64]) -> Vec<String> {
    values.iter().copied().map(shortest).collect()
}

// Writing to a string cannot fail.

fn push_list(out: &mut String, name: &str, values: &[String]) {
    let _ = writeln!(out, "        {name}: [{}],", values.join(","));
}

/// A line each; left out without any.
fn push_forms(out: &mut String, name: &str, forms: &[Vec<f64>]) {
    if forms.is_empty() {
        return;
    }
    let _ = writeln!(out, "        {name}: [");
    for form in forms {
        let _ = writeln!(out, "            [{}],", numbers(form).join(","));
    }
    out.push_str("        ],\n");
}

fn push_cells(out: &mut String, cells: &Cells) {
    let origin = ron_text::tuple(cells.origin_mm().coords.as_slice());
    let _ = writeln!(
        out,
        "        samples: (\n            origin: {origin},\n            edge: {:?},\n            cells: [",
        cells.edge_mm()
    );
    for line in cells.cells().chunks(CELLS_A_LINE) {
        let line: Vec<_> = line
            .iter()
            .map(|c| {
                let [i, j, k] = c.index;
                format!("({i},{j},{k},{})", c.directions)
            })
            .collect();
        let _ = writeln!(out, "                {},", line.join(","));
    }
    out.push_str("            ],\n        ),\n");
}

const CELLS_A_LINE: usize = 8;

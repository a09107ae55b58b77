//! The part of an environment that keeps model validity.

use super::error::FormatError;
use super::ron_text::{self, RonWriter};
use serde::Deserialize;
use trackwright_field::DistortionModel;
use trackwright_field::validity::{Cell, Cells, FitValidity, FitValidityParts};
use trackwright_geometry::number::shortest;

#[derive(Deserialize)]
#[serde(rename = "Support", deny_unknown_fields)]
pub(super) struct ValidityEntry {
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

impl ValidityEntry {
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

/// Writes the validity of a fit as a field of an environment.
pub(super) fn write(out: &mut RonWriter, parts: &FitValidityParts) {
    let stds = |std: &[Option<f64>]| {
        list(std.iter().map(|s| s.map_or_else(|| "None".to_owned(), shortest)))
    };
    let numbers = |values: &[f64]| list(values.iter().copied().map(shortest));
    out.fields("support", |out| {
        out.field("position_std_mm", stds(&parts.position_std_mm));
        if let Some(std) = &parts.angle_std_rad {
            out.field("angle_std_rad", stds(std));
        }
        out.field("greatest_leverage", numbers(&parts.greatest_leverage));
        out.field("greatest_undetermined", numbers(&parts.greatest_undetermined));
        let forms = [
            ("variance", &parts.variance),
            ("leverage", &parts.leverage),
            ("undetermined", &parts.undetermined),
        ];
        for (name, forms) in forms.into_iter().filter(|(_, forms)| !forms.is_empty()) {
            out.lines(name, forms.iter().map(|form| numbers(form)));
        }
        out.fields("samples", |out| write_cells(out, &parts.cells));
    });
}

fn list(values: impl Iterator<Item = String>) -> String {
    format!("[{}]", values.collect::<Vec<_>>().join(","))
}

fn write_cells(out: &mut RonWriter, cells: &Cells) {
    out.field("origin", ron_text::tuple(cells.origin_mm().coords.as_slice()));
    out.plain("edge", cells.edge_mm());
    let cell = |cell: &Cell| {
        let [i, j, k] = cell.index;
        format!("({i},{j},{k},{})", cell.directions)
    };
    let line = |cells: &[Cell]| cells.iter().map(cell).collect::<Vec<_>>().join(",");
    out.lines("cells", cells.cells().chunks(CELLS_A_LINE).map(line));
}

const CELLS_A_LINE: usize = 8;

//! Rows as columns: names, types and units of what a sweep's Parquet files hold.

use super::points::columns;
use super::sweep::{Row, RowFigures, Sweep};
use arrow_array::builder::{BooleanBuilder, Float64Builder, StringBuilder, UInt64Builder};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use std::collections::HashMap;
use std::sync::Arc;
use trackwright_formats::sweep_plan::{SweepMotion, SweepPlan};
use trackwright_simulation::Metric;

/// Key of a column's unit in its metadata.
pub const UNIT: &str = "unit";

/// The number of a row.
pub const ROW: &str = "row";
/// Why a row has no figures.
pub const PROBLEM: &str = "problem";
pub(crate) const DESIGN: &str = "design";
pub(crate) const ROOM: &str = "room";
pub(crate) const MOTION: &str = "motion";
const TRIALS: &str = "trials";
const OUTSIDE: &str = "outside";
const OUT_OF_VOLUME: &str = "out_of_volume";
pub(crate) const COUNTS: [&str; 3] = [TRIALS, OUTSIDE, OUT_OF_VOLUME];
const REQUIREMENT_MET: &str = "requirement_met";
const REQUIREMENT_MET_EXPECTED: &str = "requirement_met_expected";

/// How a figure's columns end where it is expected over drawn fields, and what they hold.
const EXPECTED: [(&str, &str); 3] = [
    ("_expected", "Expected over drawn fields"),
    ("_low", "Lower end of the 95 % interval of the expected value"),
    ("_high", "Upper end of the 95 % interval of the expected value"),
];

/// What a column of that name holds; nothing where the name is enough.
pub(crate) fn about(name: &str) -> &'static str {
    let is_figure = |name: &str| Metric::named(name).is_some();
    match name {
        REQUIREMENT_MET => "Whether the design's requirement holds in the room's own field",
        REQUIREMENT_MET_EXPECTED => "Whether it holds for the expected figures with 95 %",
        TRIALS => "Poses of the study",
        OUTSIDE => "Poses with a sensor outside the model's box",
        OUT_OF_VOLUME => "Poses with a sensor outside the tracker's volume",
        _ if is_figure(name) => "In the room's own field",
        _ => EXPECTED
            .into_iter()
            .find(|(ending, _)| name.strip_suffix(ending).is_some_and(is_figure))
            .map_or("", |(_, about)| about),
    }
}

/// The columns of a plan.
pub fn schema(plan: &SweepPlan) -> SchemaRef {
    let text = |name: &str, is_nullable| Field::new(name, DataType::Utf8, is_nullable);
    let mut fields = vec![
        Field::new(ROW, DataType::UInt64, false),
        text(DESIGN, false),
        text(ROOM, true),
        text(MOTION, false),
    ];
    let number = |name: String, unit: &str, is_nullable| {
        let field = Field::new(name, DataType::Float64, is_nullable);
        let units = (!unit.is_empty()).then(|| (UNIT.to_owned(), unit.to_owned()));
        field.with_metadata(HashMap::from_iter(units))
    };
    fields.extend(columns(plan.paths()).into_iter().map(|(name, unit)| number(name, unit, false)));
    fields.extend(COUNTS.map(|name| Field::new(name, DataType::UInt64, true)));
    for metric in &plan.figures {
        let unit = metric.of.unit_key();
        fields.push(number(metric.name().to_owned(), unit, true));
        if plan.expected {
            let name = |ending: &str| format!("{}{ending}", metric.name());
            fields.extend(EXPECTED.map(|(ending, _)| number(name(ending), unit, true)));
        }
    }
    fields.push(Field::new(REQUIREMENT_MET, DataType::Boolean, true));
    if plan.expected {
        fields.push(Field::new(REQUIREMENT_MET_EXPECTED, DataType::Boolean, true));
    }
    fields.push(text(PROBLEM, true));
    Arc::new(Schema::new(fields))
}

/// Rows as a batch of [`schema`].
///
/// # Errors
/// None, for rows of the sweep.
pub(crate) fn batch(
    sweep: &Sweep,
    schema: &SchemaRef,
    first: u64,
    rows: &[Row],
) -> Result<RecordBatch, ArrowError> {
    let plan = sweep.plan();
    let of_texts = |text: &dyn Fn(&Row) -> Option<String>| -> ArrayRef {
        let mut builder = StringBuilder::new();
        rows.iter().for_each(|row| builder.append_option(text(row)));
        Arc::new(builder.finish())
    };
    let of_numbers = |number: &dyn Fn(&Row) -> Option<f64>| -> ArrayRef {
        let mut builder = Float64Builder::with_capacity(rows.len());
        // What is no number is none.
        rows.iter()
            .for_each(|row| builder.append_option(number(row).filter(|value| value.is_finite())));
        Arc::new(builder.finish())
    };
    let of_counts = |count: &dyn Fn(usize, &Row) -> Option<u64>| -> ArrayRef {
        let mut builder = UInt64Builder::with_capacity(rows.len());
        rows.iter().enumerate().for_each(|(k, row)| builder.append_option(count(k, row)));
        Arc::new(builder.finish())
    };
    let of_flags = |flag: &dyn Fn(&Row) -> Option<bool>| -> ArrayRef {
        let mut builder = BooleanBuilder::with_capacity(rows.len());
        rows.iter().for_each(|row| builder.append_option(flag(row)));
        Arc::new(builder.finish())
    };
    let mut arrays = vec![
        of_counts(&|k, _| Some(first + k as u64)),
        of_texts(&|row| Some(plan.designs[row.key.design].clone())),
        of_texts(&|row| row.key.room.map(|room| plan.rooms[room].clone())),
        of_texts(&|row| Some(motion_text(&plan.motions, row.key.motion))),
    ];
    let numbers = plan.paths().count();
    arrays.extend((0..numbers).map(|k| of_numbers(&|row| Some(row.numbers[k]))));
    arrays.push(of_counts(&|_, row| Some(study(row)?.trials)));
    arrays.push(of_counts(&|_, row| Some(study(row)?.outside)));
    arrays.push(of_counts(&|_, row| Some(study(row)?.out_of_volume)));
    for metric in &plan.figures {
        let k = metric.index();
        arrays.push(of_numbers(&|row| Some(study(row)?.own[k])));
        if plan.expected {
            arrays.push(of_numbers(&|row| Some(study(row)?.expected.as_ref()?.0[k])));
            arrays.push(of_numbers(&|row| Some(study(row)?.expected.as_ref()?.1[k][0])));
            arrays.push(of_numbers(&|row| Some(study(row)?.expected.as_ref()?.1[k][1])));
        }
    }
    arrays.push(of_flags(&|row| study(row)?.requirement_met));
    if plan.expected {
        arrays.push(of_flags(&|row| study(row)?.requirement_met_expected));
    }
    arrays.push(of_texts(&|row| row.study.as_ref().err().cloned()));
    RecordBatch::try_new(Arc::clone(schema), arrays)
}

fn study(row: &Row) -> Option<&RowFigures> {
    row.study.as_ref().ok()
}

/// Short, and each its own.
fn motion_text(motions: &[SweepMotion], index: usize) -> String {
    let kind = match &motions[index] {
        SweepMotion::Single => return "single".to_owned(),
        SweepMotion::Motion => return "motion".to_owned(),
        SweepMotion::Range(_) => "range",
        SweepMotion::Input(_) => "input",
    };
    format!("{kind} {}", index + 1)
}

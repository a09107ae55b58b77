//! Rows as columns: names, types and units of what a sweep's Parquet files hold.

use super::points::columns;
use super::sweep::{Row, RowFigures, Sweep};
use arrow_array::builder::{Float64Builder, StringBuilder, UInt64Builder};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use std::collections::HashMap;
use std::sync::Arc;
use trackwright_formats::sweep_plan::{SweepMotion, SweepPlan};
use trackwright_simulation::{Figures, Metric};

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
const BASIS: &str = "basis";
const VERDICT: &str = "verdict";

/// How a figure's columns end, and what they hold.
const ENDS: [(&str, &str); 2] =
    [("_low", "Lower end of the 95 % interval"), ("_high", "Upper end of the 95 % interval")];
const ROOM_FIELD: &str = "_room_field";

/// What a column of that name holds; nothing where the name is enough.
pub(crate) fn about(name: &str) -> &'static str {
    let is_figure = |name: &str| Metric::named(name).is_some();
    let is_figures = |ending: &str| name.strip_suffix(ending).is_some_and(is_figure);
    match name {
        BASIS => "What the figures rest on",
        VERDICT => "Whether the design's requirement is met, missed, or not decided",
        TRIALS => "Poses of the study",
        OUTSIDE => "Poses with a sensor outside the model's box",
        OUT_OF_VOLUME => "Poses with a sensor outside the tracker's volume",
        _ if is_figures(ROOM_FIELD) => "With the room's model taken for its field",
        _ => ENDS.into_iter().find(|(ending, _)| is_figures(ending)).map_or("", |end| end.1),
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
        let name = |ending: &str| format!("{}{ending}", metric.name());
        if plan.expected {
            fields.push(number(name(""), unit, true));
            fields.extend(ENDS.map(|(ending, _)| number(name(ending), unit, true)));
        }
        if plan.room_field {
            fields.push(number(name(ROOM_FIELD), unit, true));
        }
    }
    if plan.expected {
        fields.extend([BASIS, VERDICT].map(|name| text(name, true)));
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
        let figure = |row: &Row| known(row)?.get(*metric).copied();
        if plan.expected {
            arrays.push(of_numbers(&|row| Some(figure(row)?.value)));
            arrays.push(of_numbers(&|row| figure(row)?.low));
            arrays.push(of_numbers(&|row| figure(row)?.high));
        }
        if plan.room_field {
            arrays.push(of_numbers(&|row| Some(study(row)?.room_field?[k])));
        }
    }
    if plan.expected {
        arrays.push(of_texts(&|row| Some(known(row)?.basis.key().to_owned())));
        arrays.push(of_texts(&|row| {
            Some(known(row)?.requirement.as_ref()?.verdict.key().to_owned())
        }));
    }
    arrays.push(of_texts(&|row| row.study.as_ref().err().cloned()));
    RecordBatch::try_new(Arc::clone(schema), arrays)
}

fn study(row: &Row) -> Option<&RowFigures> {
    row.study.as_ref().ok()
}

fn known(row: &Row) -> Option<&Figures> {
    study(row)?.known.as_ref()
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

//! What the command line leaves open about a model, chosen by cross-validation with a progress bar.

use super::prelude::*;
use trackwright_calibration::room_choice::{
    self, Chosen, Grouping, ModelChoice, ModelRequest, RowLabels, numbered_labels, row_groups,
};
use trackwright_field::fit::FitSettings;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::places::Places;
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_field::selection::{HoldOutBy, Scores, SelectSettings};
use trackwright_formats::groups::SENSOR_COLUMN;
use trackwright_report::selection::{
    SENSOR_INTERVAL, grouped_line, hold_out_lines, hold_out_name, reason, sensors_line,
};

/// What is to be held out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum HoldOutArg {
    Rows,
    Groups,
    Sensors,
    /// Rows with equal text in this column.
    Column(String),
}

impl From<&str> for HoldOutArg {
    fn from(text: &str) -> Self {
        match text {
            "rows" => Self::Rows,
            "groups" => Self::Groups,
            "sensors" | SENSOR_COLUMN => Self::Sensors,
            column => Self::Column(column.to_owned()),
        }
    }
}

/// The settings of a fit; what is left open is chosen by cross-validation on the measurements.
/// Where a hold-out is named, a model with nothing open is cross-validated as well.
///
/// # Errors
/// Measurements that nothing can be chosen by.
pub(super) fn settings(
    files: &Files,
    file: &Path,
    samples: &SampleSet,
    request: &ModelRequest,
    hold_out: Option<&HoldOutArg>,
) -> anyhow::Result<(FitSettings, Option<Chosen>)> {
    let tried = match (request.wanted(samples), hold_out) {
        (ModelChoice::Fixed(settings), None) => return Ok((settings, None)),
        (ModelChoice::Fixed(settings), Some(_)) => SelectSettings {
            orders: vec![settings.order],
            direction_sets: vec![settings.directions],
            ridges: vec![settings.ridge],
            method: settings.method,
            map: settings.map,
            weighting: settings.weighting,
            rcond: settings.rcond,
            ..SelectSettings::for_samples(samples)
        },
        (ModelChoice::Open(tried), _) => tried,
    };
    let labels = row_labels(files, file, samples, None, hold_out)?;
    let chosen = cross_validate(file, samples, labels, tried)?;
    Ok((chosen.settings(), Some(chosen)))
}

/// Which rows belong together, which sensor each is of, and what is to be held out.
///
/// # Errors
/// A column that is not there or has empty cells, nothing to hold out.
pub(super) fn row_labels(
    files: &Files,
    file: &Path,
    samples: &SampleSet,
    group: Option<&str>,
    hold_out: Option<&HoldOutArg>,
) -> anyhow::Result<RowLabels> {
    let column = match (group, hold_out) {
        (Some(group), Some(HoldOutArg::Column(column))) if group != column => {
            bail!("--group {group} and --hold-out {column}: expected one column")
        }
        (None, Some(HoldOutArg::Column(column))) => Some(column.as_str()),
        (group, _) => group,
    };
    let deciding = hold_out.map(|by| match by {
        HoldOutArg::Rows => HoldOutBy::Rows,
        HoldOutArg::Groups | HoldOutArg::Column(_) => HoldOutBy::Groups,
        HoldOutArg::Sensors => HoldOutBy::Sensors,
    });
    let grouping = grouping(files, file, samples, column)?;
    if deciding == Some(HoldOutBy::Groups) && grouping.is_none() {
        bail!(
            "{}: found no groups of rows to hold out, expected a column cluster, frame or pose, places that were measured several times, or --hold-out COLUMN",
            file.display()
        );
    }
    let sensors = match files.read_sensors(file) {
        Ok(Some(column)) => numbered_labels(&column.name, &column.labels, samples.samples.len())
            .map(Some)
            .with_context(|| file.display().to_string())?,
        Ok(None) => None,
        Err(error) if deciding == Some(HoldOutBy::Sensors) => return Err(error.into()),
        Err(error) => {
            output::note(&format!("note: {error}; sensors are not held out"));
            None
        }
    };
    if deciding == Some(HoldOutBy::Sensors) && sensors.is_none() {
        bail!(
            "{}: found no column {SENSOR_COLUMN:?}, expected one that names the sensor of each row",
            file.display()
        );
    }
    Ok(RowLabels { grouping, sensors, deciding })
}

/// The groups of a table's rows: by the named column, by one that is known to mean so, or by the
/// clusters or places that the data show.
fn grouping(
    files: &Files,
    file: &Path,
    samples: &SampleSet,
    column: Option<&str>,
) -> anyhow::Result<Option<Grouping>> {
    let column = files.read_groups(file, column)?;
    let column = column.as_ref().map(|c| (c.name.as_str(), c.labels.as_slice()));
    row_groups(samples, column).with_context(|| file.display().to_string())
}

/// [`room_choice::choose_by`], with a progress bar.
///
/// # Errors
/// Those of it, with the file's name.
pub(super) fn cross_validate(
    file: &Path,
    samples: &SampleSet,
    labels: RowLabels,
    tried: SelectSettings,
) -> anyhow::Result<Chosen> {
    let shown = Shown::new("cross-validating");
    room_choice::choose_by(samples, labels, tried, &shown.task)
        .with_context(|| file.display().to_string())
}

/// Why the choice is what it is.
pub(super) fn reason_of(chosen: &Chosen) -> String {
    reason(&chosen.selection, chosen.by.as_deref(), chosen.tried.folds)
}

/// What was found of the rows, the chosen model in each hold-out, and why it was chosen.
pub(super) fn lines(chosen: &Chosen) -> Vec<String> {
    let (found, by) = (&chosen.selection, chosen.by.as_deref());
    let grouped = chosen.places.as_ref().map(grouped_line);
    let sensors = found.sensors.as_ref().map(sensors_line);
    grouped
        .into_iter()
        .chain(hold_out_lines(found, by))
        .chain(sensors)
        .chain([reason_of(chosen)])
        .collect()
}

pub(super) fn as_json(chosen: &Chosen) -> Value {
    let best = chosen.selection.best();
    let mut value = json!({
        "order": best.candidate.order,
        "directions": best.candidate.directions.len(),
        "ridge": best.candidate.ridge,
        "cv": scores_json(best.deciding()),
        "folds": chosen.tried.folds,
        "reason": reason_of(chosen),
    });
    add_hold_outs(&mut value, chosen);
    value
}

/// Adds what was held out, how the chosen model did in each hold-out, and what was found of rows
/// and sensors.
pub(super) fn add_hold_outs(value: &mut Value, chosen: &Chosen) {
    let found = &chosen.selection;
    let hold_outs: Vec<Value> = found
        .hold_outs
        .iter()
        .map(|hold_out| {
            json!({
                "by": hold_out_name(hold_out.by),
                "folds": hold_out.folds,
                "count": hold_out.count,
                "decides": hold_out.by == found.decided_by,
                "cv": found.best().held_out_by(hold_out.by).map(scores_json),
            })
        })
        .collect();
    value["groups"] = json!(chosen.by.as_ref().map(|by| json!({"by": by, "count": found.groups})));
    value["hold_out"] = json!(hold_out_name(found.decided_by));
    value["hold_outs"] = json!(hold_outs);
    value["sensors"] = json!(found.sensors.as_ref().map(sensors_json));
    value["grouped"] = json!(chosen.places.as_ref().map(places_json));
}

/// What is left of rows held out.
pub(super) fn scores_json(scores: &Scores) -> Value {
    json!({
        "position_rms_mm": scores.position_rms_mm,
        "position_max_mm": scores.position_max_mm,
        "angle_rms_deg": scores.angle_rms_rad.map(f64::to_degrees),
    })
}

fn sensors_json(spread: &SensorSpread) -> Value {
    let degrees = |angles: [f64; 2]| angles.map(f64::to_degrees);
    json!({
        "count": spread.sensors,
        "degrees_of_freedom": spread.degrees_of_freedom,
        "position_mm": spread.position_std_dev_mm(),
        "position_rms_mm": spread.position_rms_mm(),
        "angle_rms_deg": spread.angle_rms_rad().map(f64::to_degrees),
        "intervals": {
            "position_rms_mm": spread.position_interval_mm(SENSOR_INTERVAL),
            "angle_rms_deg": spread.angle_interval_rad(SENSOR_INTERVAL).map(degrees),
        },
    })
}

fn places_json(places: &Places) -> Value {
    let variogram: Vec<Value> = places
        .variogram
        .iter()
        .map(|point| {
            json!({
                "distance_mm": point.distance_mm,
                "semivariance_mm2": point.semivariance_mm2,
                "pairs": point.pairs,
            })
        })
        .collect();
    json!({
        "places": places.count,
        "width_mm": places.width_mm,
        "dependence": places.dependence,
        "correlation_length_mm": places.correlation_length_mm,
        "nugget_mm2": places.nugget_mm2,
        "sill_mm2": places.sill_mm2,
        "variogram": variogram,
    })
}

//! Points of 3D Slicer: its markups (`*.mrk.json`) and the older `*.fcsv`.
//!
//! Files are in LPS or in RAS and state which; points are given in RAS, as Slicer's scene shows
//! them and as live poses of a tracker come there. So what `export` writes (`export/markups.rs`)
//! comes back.

use super::error::{FormatError, quoted, text};
use super::table_dialect::quoted_cells;
use nalgebra::Point3;
use serde::Deserialize;

/// Whether the first character shows that this is no table.
pub fn is_json(text: &str) -> bool {
    text.trim_start().starts_with('{')
}

/// Whether the lines in front are those of an `fcsv` file.
pub fn is_fcsv(text: &str) -> bool {
    comments(text).any(|(_, line)| {
        line.starts_with("Markups fiducial file") || option(line, "CoordinateSystem").is_some()
    })
}

/// What a file's x and y are multiplied by.
#[derive(Clone, Copy)]
enum Axes {
    Lps,
    Ras,
}

impl Axes {
    fn point(self, [x, y, z]: [f64; 3]) -> Point3<f64> {
        match self {
            Self::Ras => Point3::new(x, y, z),
            // Zero stays without a sign.
            Self::Lps => Point3::new(0.0 - x, 0.0 - y, z),
        }
    }
}

#[derive(Deserialize)]
struct File {
    markups: Vec<Markup>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Markup {
    coordinate_system: Option<String>,
    coordinate_units: Option<serde_json::Value>,
    #[serde(default)]
    control_points: Vec<ControlPoint>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct ControlPoint {
    #[serde(default)]
    label: String,
    position: Option<Vec<f64>>,
    /// `undefined`, `preview` or `missing` where it is no point; older files have none.
    position_status: Option<String>,
}

/// Reads the control points of all lists that are defined, mm, RAS.
///
/// # Errors
/// Text that is no JSON of markups, a coordinate system or unit that is not known, positions that are
/// none, no defined point.
pub fn parse_json(bytes: &[u8]) -> Result<Vec<Point3<f64>>, FormatError> {
    let file: File = serde_json::from_str(text(bytes)?).map_err(|error| FormatError::Syntax {
        line: error.line(),
        column: error.column(),
        problem: format!("found no markups of 3D Slicer ({error}), expected its *.mrk.json"),
    })?;
    let mut points = Vec::new();
    for (list, markup) in file.markups.iter().enumerate() {
        let of_list = |name: &str| format!("markups[{list}].{name}");
        let axes = match markup.coordinate_system.as_deref() {
            Some("LPS") => Axes::Lps,
            Some("RAS") => Axes::Ras,
            other => {
                return Err(FormatError::field(
                    of_list("coordinateSystem"),
                    other.map_or("not there".to_owned(), |other| format!("{other:?}")),
                    "LPS or RAS",
                ));
            }
        };
        let unit = markup.coordinate_units.as_ref();
        if let Some(unit) = unit.filter(|unit| unit.as_str() != Some("mm")) {
            return Err(FormatError::field(of_list("coordinateUnits"), unit, "mm"));
        }
        for (index, point) in markup.control_points.iter().enumerate() {
            let status = point.position_status.as_deref();
            if status.is_some_and(|status| status != "defined") {
                continue;
            }
            match point.position.as_deref() {
                Some(&[x, y, z]) => points.push(axes.point([x, y, z])),
                None if status.is_none() => {}
                position => {
                    let found = position.map_or(0, <[f64]>::len);
                    return Err(FormatError::field(
                        of_list(&format!("controlPoints[{index}] {:?} position", point.label)),
                        format!("{found} numbers"),
                        "x, y, z",
                    ));
                }
            }
        }
    }
    some(points)
}

/// Reads the points of an `fcsv` file that are defined, mm, RAS.
///
/// # Errors
/// No coordinate system or one that is not known, rows without a point, no defined point.
pub fn parse_fcsv(bytes: &[u8]) -> Result<Vec<Point3<f64>>, FormatError> {
    let text = text(bytes)?;
    let stated = comments(text)
        .find_map(|(line, comment)| Some((line, option(comment, "CoordinateSystem")?)));
    let axes = match stated {
        // Versions before 4.11 have numbers.
        Some((_, "LPS" | "1")) => Axes::Lps,
        Some((_, "RAS" | "0")) => Axes::Ras,
        other => {
            let (line, found) = other.unwrap_or((1, "nothing"));
            let found = format!("{found:?} as coordinate system");
            let expected = "# CoordinateSystem = LPS or RAS (1 or 0 in older files)";
            return Err(FormatError::line(line, found, expected));
        }
    };
    let columns = comments(text).find_map(|(_, comment)| option(comment, "columns"));
    let names: Vec<&str> = columns.unwrap_or("id,x,y,z").split(',').map(str::trim).collect();
    let mut points = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        if content.starts_with('#') || content.trim().is_empty() {
            continue;
        }
        let mut record = quoted_cells(line, content)?;
        record.trim();
        if !is_defined(line, &record, names.len())? {
            continue;
        }
        let mut at = [0.0; 3];
        for (value, name) in at.iter_mut().zip(["x", "y", "z"]) {
            let place = names.iter().position(|column| *column == name);
            let cell = place.and_then(|place| record.get(place)).unwrap_or("");
            let number = cell.parse().ok().filter(|value: &f64| value.is_finite());
            *value = number.ok_or_else(|| {
                FormatError::cell(line, name, format!("{cell:?}"), "a number in mm")
            })?;
        }
        points.push(axes.point(at));
    }
    some(points)
}

/// Since Slicer 5 a row ends in two cells that no column names: whether the place is defined (2), and
/// one that is of no interest here.
fn is_defined(line: u64, record: &csv::StringRecord, named: usize) -> Result<bool, FormatError> {
    match record.get(named).filter(|_| record.len() == named + 2) {
        None | Some("2") => Ok(true),
        Some("0" | "1" | "3") => Ok(false),
        Some(other) => {
            Err(FormatError::cell(line, "state of the point", quoted(other), "0, 1, 2 or 3"))
        }
    }
}

fn some(points: Vec<Point3<f64>>) -> Result<Vec<Point3<f64>>, FormatError> {
    match points.is_empty() {
        true => Err(FormatError::field("the number of points that are defined", 0, "one at least")),
        false => Ok(points),
    }
}

/// The content of lines that are no rows.
fn comments(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let lines = (1..).zip(text.lines());
    lines.filter_map(|(line, content)| Some((line, content.strip_prefix('#')?.trim())))
}

fn option<'a>(comment: &'a str, name: &str) -> Option<&'a str> {
    Some(comment.strip_prefix(name)?.trim_start().strip_prefix('=')?.trim())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::export::PatientAxes;
    use crate::export::markups::{self, MarkupPoint};
    use crate::points;
    use crate::test_cases::assert_refused;
    use proptest::prelude::*;
    use trackwright_geometry::pose::Pose;

    /// As Slicer 5 writes it, shortened.
    pub(crate) const JSON: &str = r#"{"@schema": "markups-schema-v1.0.3.json#", "markups": [{"type": "Fiducial",
        "coordinateSystem": "LPS", "coordinateUnits": "mm", "controlPoints": [
        {"id": "1", "label": "nasion", "position": [-1.5, 2.0, 3.0], "positionStatus": "defined"},
        {"id": "2", "label": "left", "position": [0.0, 0.0, 0.0], "positionStatus": "undefined"},
        {"id": "3", "label": "right", "positionStatus": "missing"},
        {"id": "4", "label": "old", "position": [4.0, 0.0, 6.0]}]}]}"#;

    pub(crate) const FCSV: &str = "# Markups fiducial file version = 5.2\n# CoordinateSystem = LPS\n\
        # columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n\
        1,-1.5,2,3,0,0,0,1,1,1,0,\"nasion, mid\",,node,2,0\n\
        2,9,9,9,0,0,0,1,1,1,0,left,,,0,0\n\
        4,4,0,6,0,0,0,1,1,1,0,old,,\n";

    fn expected() -> Vec<Point3<f64>> {
        vec![Point3::new(1.5, -2.0, 3.0), Point3::new(-4.0, 0.0, 6.0)]
    }

    #[test]
    fn defined_points_are_read_in_ras() {
        for text in [JSON, FCSV] {
            assert_eq!(points::parse(text.as_bytes()), Ok(expected()));
            let marked = format!("\u{feff}{text}");
            assert_eq!(points::parse(marked.as_bytes()), Ok(expected()));
            let ras = text.replace("LPS", "RAS");
            let found = points::parse(ras.as_bytes()).unwrap();
            assert_eq!(found[0], Point3::new(-1.5, 2.0, 3.0));
        }
        for (older, same) in [("1", "LPS"), ("0", "RAS")] {
            let [older, same] =
                [older, same].map(|name| FCSV.replace("= LPS", &format!("= {name}")));
            assert_eq!(points::parse(older.as_bytes()), points::parse(same.as_bytes()));
        }
        // Columns have no fixed places.
        let turned = "# CoordinateSystem = RAS\n# columns = label,z,y,x\nF-1,3,2,1\n";
        assert_eq!(points::parse(turned.as_bytes()), Ok(vec![Point3::new(1.0, 2.0, 3.0)]));
    }

    #[test]
    fn what_is_no_point_is_named() {
        let message = |text: &str| points::parse(text.as_bytes()).unwrap_err().to_string();
        let cases = r#"
            "LPS" => "IJK" | markups[0].coordinateSystem is "IJK", expected LPS or RAS
            "coordinateSystem": "LPS", => | markups[0].coordinateSystem is not there…
            "mm" => "m" | markups[0].coordinateUnits is "m", expected mm
            2.0, 3.0] => 2.0] | markups[0].controlPoints[0] "nasion" position is 2 numbers…
            "markups": => "other": | line 6…
            -1.5 => NaN | line 3…
            -1.5 => 1e999 | line 3…
        "#;
        assert_refused(JSON, cases, message);
        let cases = r##"
            = LPS => = IJK | line 2: found "IJK" as coordinate system…
            # CoordinateSystem = LPS\n => | line 1: found "nothing" as coordinate system…
            -1.5 => left | line 4: x is "left", expected a number…
            -1.5 => inf | line 4: x is "inf"…
            ,x,y,z, => ,r,a,s, | line 4: x is ""…
        "##;
        assert_refused(FCSV, cases, message);
        assert!(
            message("{\"markups\": []}").starts_with("the number of points that are defined is 0")
        );
    }

    #[test]
    fn cut_markups_are_refused_or_keep_whole_points() {
        for end in 0..JSON.len() {
            assert!(points::parse(&JSON.as_bytes()[..end]).is_err(), "{end}");
        }
        // A row of text has no end that could be missed; those before it are whole.
        let first = FCSV.find("2,9,9").unwrap();
        for end in first..FCSV.len() {
            let found = parse_fcsv(&FCSV.as_bytes()[..end]).unwrap_or(expected());
            assert_eq!(found[0], expected()[0], "{end}");
        }
    }

    proptest! {
        #[test]
        fn own_exports_come_back_to_the_bit(
            places in prop::collection::vec(prop::array::uniform3(-1e3..1e3_f64), 1..8),
        ) {
            let given: Vec<MarkupPoint> = places
                .iter()
                .map(|[x, y, z]| MarkupPoint {
                    label: "p".to_owned(),
                    tracker_from_point: Pose::translation(*x, *y, *z),
                })
                .collect();
            let mut bytes = Vec::new();
            markups::write(&mut bytes, &given, PatientAxes::Ras).unwrap();
            let found = points::parse(&bytes).unwrap();
            let expected: Vec<_> = places.iter().map(|p| Point3::from(*p)).collect();
            prop_assert_eq!(found, expected);
        }
    }
}

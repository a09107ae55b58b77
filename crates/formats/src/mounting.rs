//! Mounting regions in a body file: where its sensors may be put.

use super::error::FormatError;
use super::ron_text::{self, RonWriter};
use nalgebra::Point3;
use serde::Deserialize;
use trackwright_geometry::bounds::Bounds;
use trackwright_simulation::mounting::{Mounting, MountingAxis, MountingRegion};

/// A region as files hold it.
#[derive(Deserialize)]
#[serde(rename = "Region", deny_unknown_fields)]
pub(super) enum RegionEntry {
    Surface { axis: Option<MountingAxis>, boxes: Option<Vec<BoxEntry>> },
    Channel { points: Vec<[f64; 3]>, radius: Option<f64>, axis: Option<MountingAxis> },
    Seat { position: [f64; 3], axis: Option<[f64; 3]> },
}

/// A box as files hold it.
#[derive(Deserialize)]
#[serde(rename = "Box", deny_unknown_fields)]
pub(crate) struct BoxEntry {
    min: [f64; 3],
    max: [f64; 3],
}

/// The mounting that the fields of a body file state, lengths in mm.
pub(super) fn check(
    regions: Option<Vec<RegionEntry>>,
    keep_out: Option<Vec<BoxEntry>>,
    least_gap_mm: Option<f64>,
    tip_clearance_mm: Option<f64>,
) -> Result<Mounting, FormatError> {
    let regions = regions.unwrap_or_default().into_iter().enumerate();
    let mounting = Mounting {
        regions: regions.map(|(i, region)| region.check(i)).collect::<Result<_, _>>()?,
        keep_out: bounds_of(keep_out),
        least_gap_mm,
        tip_clearance_mm: tip_clearance_mm.unwrap_or(0.0),
    };
    mounting.check()?;
    Ok(mounting)
}

impl RegionEntry {
    fn check(self, index: usize) -> Result<MountingRegion, FormatError> {
        Ok(match self {
            Self::Surface { axis, boxes } => MountingRegion::Surface {
                axis: axis.unwrap_or(MountingAxis::AsItIs),
                boxes: bounds_of(boxes),
            },
            Self::Channel { points, radius, axis } => MountingRegion::Channel {
                points_mm: points.into_iter().map(Point3::from).collect(),
                radius_mm: radius,
                axis: axis.unwrap_or(MountingAxis::Along),
            },
            Self::Seat { position, axis } => MountingRegion::Seat {
                position_mm: position.into(),
                axis: axis
                    .map(|axis| ron_text::axis(&format!("mounting[{index}].axis"), axis))
                    .transpose()?,
            },
        })
    }
}

pub(crate) fn bounds_of(boxes: Option<Vec<BoxEntry>>) -> Vec<Bounds> {
    let boxes = boxes.unwrap_or_default().into_iter();
    boxes.map(|BoxEntry { min, max }| Bounds::from((min, max))).collect()
}

/// Writes what a body states, one region or box a line; nothing where it states nothing.
pub(super) fn write(out: &mut RonWriter, mounting: &Mounting) {
    let Mounting { regions, keep_out, least_gap_mm, tip_clearance_mm } = mounting;
    out.lines_if_any("mounting", regions.iter().map(region_text));
    out.lines_if_any("keep_out", keep_out.iter().map(box_text));
    out.optional("least_gap", *least_gap_mm);
    if *tip_clearance_mm != 0.0 {
        out.plain("tip_clearance", tip_clearance_mm);
    }
}

fn region_text(region: &MountingRegion) -> String {
    match region {
        MountingRegion::Surface { axis, boxes } => match &boxes[..] {
            [] => format!("Surface(axis: {axis:?})"),
            boxes => {
                let boxes: Vec<_> = boxes.iter().map(box_text).collect();
                format!("Surface(axis: {axis:?}, boxes: [{}])", boxes.join(", "))
            }
        },
        MountingRegion::Channel { points_mm, radius_mm, axis } => {
            let points: Vec<_> = points_mm.iter().map(point_text).collect();
            let radius = radius_mm.map_or_else(String::new, |r| format!(", radius: {r:?}"));
            format!("Channel(points: [{}]{radius}, axis: {axis:?})", points.join(", "))
        }
        MountingRegion::Seat { position_mm, axis } => {
            let axis = axis.map_or_else(String::new, |axis| {
                format!(", axis: {}", ron_text::tuple(axis.as_slice()))
            });
            format!("Seat(position: {}{axis})", point_text(position_mm))
        }
    }
}

pub(crate) fn box_text(own: &Bounds) -> String {
    format!("(min: {}, max: {})", point_text(&own.min_mm), point_text(&own.max_mm))
}

fn point_text(point: &Point3<f64>) -> String {
    ron_text::tuple(point.coords.as_slice())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::body::{parse, write};
    use crate::test_cases::assert_refused;
    use nalgebra::{Unit, Vector3};
    use proptest::prelude::*;
    use trackwright_geometry::limits::MAX_LENGTH_MM;

    const PLAIN: &str = r#"(
    version: 1,
    name: "needle",
    sensors: [
        (name: "a", kind: Marker, position: (0.0, 0.0, 9.0)),
    ],
)
"#;

    const FIELDS: &str = "
    mounting: [
        Surface(axis: Normal, boxes: [(min: (0, -1, 2), max: (1, 1, 3))]),
        Channel(points: [(0, 0, 10), (0, 0, 130)], radius: 0.5, axis: Along),
        Seat(position: (1, 2, 3), axis: (0, 0, 2)),
    ],
    keep_out: [(min: (-5, -5, 0), max: (5, 5, 20))],
    least_gap: 9, tip_clearance: 5,
)
";

    fn stated() -> String {
        PLAIN.replace("\n)\n", FIELDS)
    }

    fn mounting(text: &str) -> Mounting {
        parse(text.as_bytes()).unwrap().mounting
    }

    #[test]
    fn regions_are_read_as_stated() {
        let boxed = |min: [f64; 3], max: [f64; 3]| Bounds::from((min, max));
        let expected = Mounting {
            regions: vec![
                MountingRegion::Surface {
                    axis: MountingAxis::Normal,
                    boxes: vec![boxed([0.0, -1.0, 2.0], [1.0, 1.0, 3.0])],
                },
                MountingRegion::Channel {
                    points_mm: vec![Point3::new(0.0, 0.0, 10.0), Point3::new(0.0, 0.0, 130.0)],
                    radius_mm: Some(0.5),
                    axis: MountingAxis::Along,
                },
                MountingRegion::Seat {
                    position_mm: Point3::new(1.0, 2.0, 3.0),
                    axis: Some(Vector3::z_axis()),
                },
            ],
            keep_out: vec![boxed([-5.0, -5.0, 0.0], [5.0, 5.0, 20.0])],
            least_gap_mm: Some(9.0),
            tip_clearance_mm: 5.0,
        };
        assert_eq!(mounting(&stated()), expected);
    }

    #[test]
    fn what_is_left_out_has_its_default() {
        let text = stated()
            .replace("(axis: Normal, boxes: [(min: (0, -1, 2), max: (1, 1, 3))])", "()")
            .replace(", radius: 0.5, axis: Along", "")
            .replace(", axis: (0, 0, 2)", ", axis: None")
            .replace("least_gap: 9, tip_clearance: 5,", "");
        let found = mounting(&text);
        let surface = MountingRegion::Surface { axis: MountingAxis::AsItIs, boxes: Vec::new() };
        assert_eq!(found.regions[0], surface);
        let MountingRegion::Channel { radius_mm, axis, .. } = &found.regions[1] else {
            panic!("{found:?}")
        };
        assert_eq!((radius_mm, axis), (&None, &MountingAxis::Along));
        assert!(matches!(found.regions[2], MountingRegion::Seat { axis: None, .. }));
        assert_eq!((found.least_gap_mm, found.tip_clearance_mm), (None, 0.0));
    }

    #[test]
    fn a_body_without_regions_stays_as_written() {
        for empty in ["", "    mounting: [], keep_out: [], tip_clearance: 0,\n"] {
            let text = PLAIN.replace("\n)\n", &format!("\n{empty})\n"));
            let body = parse(text.as_bytes()).unwrap();
            assert!(body.mounting.is_empty());
            assert_eq!(write(&body), PLAIN);
        }
    }

    #[test]
    fn every_wrong_region_is_named() {
        let cases = r#"
            axis: Along => axis: Normal
                | mounting[1].axis is Normal, expected Free or Along or AsItIs for a channel
            axis: Normal => axis: Along
                | mounting[0].axis is Along, expected Free or Normal or Tangent or AsItIs for a surface
            (0, 0, 10), => | mounting[1].points has 1, expected at least two
            (0, 0, 10), (0, 0, 130) => | mounting[1].points has 0, expected at least two
            (0, 0, 10) => (0, 0, 130)
                | mounting[1].points[1] is (0, 0, 130), expected another place than the point before
            (0, 0, 10) => (0, NaN, 10)
                | mounting[1].points[0] is (0, NaN, 10), expected finite numbers
            (0, 0, 10) => (0, 0, -2e6)
                | mounting[1].points[0] is (0, 0, -2000000), expected coordinates of at most 1e6 mm
            (0, 0, 10) => (0, 10) | line 9, column …
            points: [(0, 0, 10), (0, 0, 130)], => | line 9, column …
            radius: 0.5 => radius: 0 | mounting[1].radius is 0, expected a length above zero
            radius: 0.5 => radius: -1 | mounting[1].radius is -1, expected a length above zero
            radius: 0.5 => radius: inf | mounting[1].radius is inf, expected a length above zero
            radius: 0.5 => radius: 2e6 | mounting[1].radius is 2000000, expected a length of at most 1e6 mm
            axis: (0, 0, 2) => axis: (0, 0, 0) | mounting[2].axis is (0, 0, 0), expected a direction
            axis: (0, 0, 2) => axis: Along | line 10, column …
            position: (1, 2, 3) => position: (1, inf, 3)
                | mounting[2].position is (1, inf, 3), expected finite numbers
            position: (1, 2, 3), => | line 10, column …
            min: (0, -1, 2) => min: (0, -1, 3)
                | mounting[0].boxes[0]: min z and max z are 3, expected min below max
            max: (1, 1, 3) => max: (1, NaN, 3)
                | mounting[0].boxes[0]: max is (1, NaN, 3), expected finite numbers
            max: (5, 5, 20) => max: (5, 5, 1e9)
                | keep_out[0]: max is (5, 5, 1000000000), expected coordinates of at most 1e6 mm
            max: (5, 5, 20) => size: (5, 5, 20) | line 12, column …
            least_gap: 9 => least_gap: -9 | least_gap is -9, expected zero or more
            least_gap: 9 => least_gap: "9" | line 13, column …
            tip_clearance: 5 => tip_clearance: NaN | tip_clearance is NaN, expected zero or more
        "#;
        assert_refused(&stated(), cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }

    fn place() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-MAX_LENGTH_MM..=MAX_LENGTH_MM)
    }

    fn bounds() -> impl Strategy<Value = Bounds> {
        let edges = prop::array::uniform3(1e-6..1e5_f64);
        (prop::array::uniform3(-9e5..9e5_f64), edges).prop_map(|(min, edges)| {
            let max = std::array::from_fn(|k| min[k] + edges[k]);
            Bounds::from((min, max))
        })
    }

    fn region() -> impl Strategy<Value = MountingRegion> {
        use MountingAxis::{Along, AsItIs, Free, Normal, Tangent};
        let boxes = prop::collection::vec(bounds(), 0..3);
        let of_surface = prop::sample::select(vec![AsItIs, Free, Normal, Tangent]);
        let of_channel = prop::sample::select(vec![AsItIs, Free, Along]);
        let points = prop::collection::vec(place(), 2..5);
        let radius = prop::option::of(1e-300..=MAX_LENGTH_MM);
        let axis = prop::option::of(prop::array::uniform3(-1.0..1.0_f64));
        prop_oneof![
            (of_surface, boxes).prop_map(|(axis, boxes)| MountingRegion::Surface { axis, boxes }),
            (points, radius, of_channel).prop_map(|(points, radius_mm, axis)| {
                let points_mm = points.into_iter().map(Point3::from).collect();
                MountingRegion::Channel { points_mm, radius_mm, axis }
            }),
            (place(), axis).prop_map(|(position, axis)| MountingRegion::Seat {
                position_mm: position.into(),
                axis: axis.map(|[x, y, z]| Unit::new_normalize(Vector3::new(x, y, z + 2.0))),
            }),
        ]
    }

    /// Anything that a body may state.
    pub(in super::super) fn any_mounting() -> impl Strategy<Value = Mounting> {
        (
            prop::collection::vec(region(), 0..4),
            prop::collection::vec(bounds(), 0..3),
            prop::option::of(0.0..=MAX_LENGTH_MM),
            0.0..=MAX_LENGTH_MM,
        )
            .prop_map(|(regions, keep_out, least_gap_mm, tip_clearance_mm)| Mounting {
                regions,
                keep_out,
                least_gap_mm,
                tip_clearance_mm,
            })
    }
}

//! Pose tables: `x, y, z, qw, qx, qy, qz`, and what `distort` adds to them.

use super::error::FormatError;
use super::table::Table;
use std::io::{self, Write};
use trackwright_field::Validity;
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::{Pose, pose_to_array};

const EXPECTED: &str = "the columns of a poses table (x, y, z, qw, qx, qy, qz)";

/// Reads a table of poses.
///
/// # Errors
/// Missing columns, cells that are no numbers, quaternions off unit length, no rows.
pub fn parse(bytes: &[u8]) -> Result<Vec<Pose>, FormatError> {
    let table = Table::parse(bytes)?;
    let columns = table.header().pose("", EXPECTED)?;
    table.read(|row| row.pose(&columns))
}

/// Whose poses of a table that has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhosePoses {
    /// Of a simulation log.
    True,
    Simulated,
    /// Of a measurement table, which may have positions alone.
    Ideal,
    Measured,
    /// Of input data.
    Tool,
    Crf,
}

impl WhosePoses {
    /// What the names of their columns begin with.
    fn begin(self) -> &'static str {
        match self {
            Self::True => "true_",
            Self::Simulated => "sim_",
            Self::Ideal => "ideal_",
            Self::Measured => "measured_",
            Self::Tool => "tool_",
            Self::Crf => "crf_",
        }
    }
}

/// Reads some poses of a table; they are not turned where it has positions alone.
///
/// # Errors
/// As [`parse`].
pub fn parse_of(bytes: &[u8], whose: WhosePoses) -> Result<Vec<Pose>, FormatError> {
    const EXPECTED: &str = "the columns of these poses (…_x, …_y, …_z, and …_qw, …_qx, …_qy, …_qz)";
    let table = Table::parse(bytes)?;
    let [columns] = table.header().poses([whose.begin()], EXPECTED, EXPECTED)?;
    table.read(|row| row.pose(&columns))
}

/// Writes poses.
pub fn write<'a>(out: &mut dyn Write, poses: impl IntoIterator<Item = &'a Pose>) -> io::Result<()> {
    writeln!(out, "x,y,z,qw,qx,qy,qz")?;
    for pose in poses {
        write_pose(out, pose)?;
        writeln!(out)?;
    }
    Ok(())
}

/// Where a sensor is, as a row states it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowPlace {
    /// Outside the model's box.
    pub is_outside: bool,
    /// Where the room states no field: out of the tracker's volume as well.
    pub is_without_field: bool,
}

/// Writes poses, each with where it is, and the model validity where it is given; a pose that was left
/// out has empty cells.
pub fn write_with_outside(
    out: &mut dyn Write,
    rows: impl IntoIterator<Item = (Option<Pose>, RowPlace)>,
    validity: Option<&[Validity]>,
) -> io::Result<()> {
    writeln!(out, "{WITH_OUTSIDE}{}", validity_header(validity))?;
    for (index, (pose, place)) in rows.into_iter().enumerate() {
        write_row(out, pose, place)?;
        if let Some(at) = validity.and_then(|validity| validity.get(index)) {
            write_validity(out, at)?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A compensated pose as a row: no pose where there is no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatedRow {
    pub pose: Option<Pose>,
    pub place: RowPlace,
    /// Other poses may read the same.
    pub is_ambiguous: bool,
}

/// Writes compensated poses with their flags, and the model validity where it is given; one without an answer
/// has empty cells for both and did not converge.
pub fn write_compensated(
    out: &mut dyn Write,
    rows: impl IntoIterator<Item = CompensatedRow>,
    validity: Option<&[Validity]>,
) -> io::Result<()> {
    writeln!(out, "{WITH_OUTSIDE},converged,ambiguous{}", validity_header(validity))?;
    for (index, row) in rows.into_iter().enumerate() {
        write_row(out, row.pose, row.place)?;
        let [converged, ambiguous] = [row.pose.is_some(), row.is_ambiguous].map(u8::from);
        write!(out, ",{converged},{ambiguous}")?;
        match (validity.and_then(|validity| validity.get(index)), row.pose) {
            (Some(at), Some(_)) => write_validity(out, at)?,
            // There is nothing that it would be the validity of.
            (Some(_), None) => write!(out, "{}", ",".repeat(VALIDITY.split(',').count()))?,
            (None, _) => {}
        }
        writeln!(out)?;
    }
    Ok(())
}

const VALIDITY: &str =
    "std_error_mm,std_error_deg,leverage,supported,distance_mm,within95_mm,within95_deg";

fn validity_header(validity: Option<&[Validity]>) -> String {
    validity.map_or_else(String::new, |_| format!(",{VALIDITY}"))
}

/// The cells of a pose's validity, each after a comma; what is not known, or not finite, is an empty one.
fn write_validity(out: &mut dyn Write, at: &Validity) -> io::Result<()> {
    let cell = |value: Option<f64>| match value {
        Some(value) if value.is_finite() => shortest(value),
        _ => String::new(),
    };
    let degrees = |angle_rad: Option<f64>| cell(angle_rad.map(f64::to_degrees));
    write!(
        out,
        ",{},{},{},{},{},{},{}",
        cell(Some(at.position_error_mm)),
        degrees(at.angle_error_rad),
        cell(at.fit.as_ref().map(|fit| fit.leverage)),
        u8::from(at.is_supported),
        cell(Some(at.distance_mm)),
        cell(at.position_95_mm),
        degrees(at.angle_95_rad),
    )
}

const WITH_OUTSIDE: &str = "x,y,z,qw,qx,qy,qz,outside,without_field";

/// A pose or empty cells, and the flags, without a line end.
fn write_row(out: &mut dyn Write, pose: Option<Pose>, place: RowPlace) -> io::Result<()> {
    match pose {
        Some(pose) => write_pose(out, &pose)?,
        None => out.write_all(b",,,,,,")?,
    }
    let [outside, without] = [place.is_outside, place.is_without_field].map(u8::from);
    write!(out, ",{outside},{without}")
}

/// Writes a pose's seven cells, without a line end.
pub(super) fn write_pose(out: &mut dyn Write, pose: &Pose) -> io::Result<()> {
    let cells = pose_to_array(pose).map(shortest);
    out.write_all(cells.join(",").as_bytes())
}

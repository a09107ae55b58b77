//! The shaft of a tool beside its tip: recordings of turns about it, and the frame of the tip.

use super::super::file_kinds::{file_kind, own_name};
use super::super::numbers::{above_zero, three};
use super::super::prelude::*;
use super::super::tool_reader::ToolReader;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trackwright_calibration::pivot::PivotLimits;
use trackwright_calibration::spin::{ShaftDirection, Spin, SpinLimits, spin, tool_from_tip};
use trackwright_formats::body::{self, BodyFile};
use trackwright_formats::export::{PatientAxes, itk_transform};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_project::Output;
use trackwright_simulation::body::{RigidBody, Sensor};
use trackwright_simulation::mounting::Mounting;

#[derive(Debug, Args)]
pub(super) struct SpinArgs {
    /// Recordings of the same tool turned about its shaft, which points one way meanwhile, best by
    /// whole turns: give the direction of the shaft, towards the tip. With other recordings they are
    /// of the same sensor or markers
    #[arg(long, value_name = "FILE", num_args = 1..)]
    spin: Vec<PathBuf>,

    /// Where the tip is, mm, tool's frame, where no recording around one point determines it
    #[arg(long, value_name = "X,Y,Z", requires = "spin", conflicts_with = "recordings", allow_hyphen_values = true, value_parser = three)]
    tip: Option<[f64; 3]>,

    /// Largest RMS angle between the shaft and its mean direction while it was turned
    #[arg(long, value_name = "DEG", default_value_t = SpinLimits::MAX_RMS_DEG, value_parser = above_zero, requires = "spin")]
    max_shaft_deg: f64,

    /// File to write the frame of the tip to, its kind given by its name: *.tfm (tip to tool, as
    /// SlicerIGT has it: z along the shaft and out of the tip) or *.body.ron (a body of a design with
    /// its tip in the origin, z up the shaft, and a 6-DOF sensor where the tool's frame is)
    #[arg(long, value_name = "OUT", requires = "spin")]
    tip_frame: Option<PathBuf>,
}

impl SpinArgs {
    /// The tip that was stated, tool frame.
    pub(super) fn tip(&self) -> Option<Point3<f64>> {
        self.tip.map(Point3::from)
    }

    /// Reads and calibrates; the tip with its standard error, mm.
    ///
    /// # Errors
    /// Files that can't be used, and recordings that cannot answer, with the reason.
    pub(super) fn shaft(
        &self,
        reader: &mut ToolReader,
        limits: &PivotLimits,
        tip: Option<(Point3<f64>, f64)>,
    ) -> anyhow::Result<Option<Spin>> {
        if self.spin.is_empty() {
            return Ok(None);
        }
        // Before anything is computed.
        if let Some(file) = &self.tip_frame {
            kind_of(file)?;
            if tip.is_none() {
                bail!(
                    "--tip-frame: found no tip, expected recordings around one point, or --tip X,Y,Z"
                );
            }
        }
        let limits = SpinLimits {
            min_poses: limits.min_poses,
            min_range_rad: limits.min_range_rad,
            min_turn_rad: limits.min_turn_rad,
            max_rms_rad: self.max_shaft_deg.to_radians(),
        };
        let poses = reader.read_all(self.spin.iter().map(PathBuf::as_path))?;
        let found = spin(&poses, &limits).map_err(|error| output::refused("no shaft", &error))?;
        let found = match &tip {
            Some((tip, std_error_mm)) => found.towards(tip, *std_error_mm),
            None => found,
        };
        match (&self.tip_frame, found.direction) {
            (Some(file), ShaftDirection::Open) => bail!(
                "{}: which of the two directions along the shaft leads to the tip is open, expected a tip that \
                 lies along the shaft from the tool's origin",
                file.display()
            ),
            _ => Ok(Some(found)),
        }
    }

    /// Where the frame of the tip goes.
    pub(super) fn tip_frame(&self) -> Option<&Path> {
        self.tip_frame.as_deref()
    }

    /// Writes the frame of the tip, where that was requested.
    ///
    /// # Errors
    /// Errors of the disk.
    pub(super) fn write_tip_frame(
        output: Option<&Output>,
        shaft: Option<&Spin>,
        tip: Option<Point3<f64>>,
    ) -> anyhow::Result<()> {
        let (Some(output), Some(shaft), Some(tip)) = (output, shaft, tip) else {
            return Ok(());
        };
        let tool_from_tip = tool_from_tip(&tip, &shaft.shaft_in_tool);
        let file = output.file();
        match kind_of(file)? {
            ".tfm" => {
                output.write(|out| itk_transform::write(out, &tool_from_tip, PatientAxes::Ras))?;
            }
            _ => {
                let text = body::write(&body_of(file, &tool_from_tip));
                output.write_bytes(text.as_bytes())?;
            }
        }
        Ok(())
    }
}

/// The ending of a file for the tip's frame.
fn kind_of(file: &Path) -> anyhow::Result<&'static str> {
    file_kind(file, "the tip's frame", &[".tfm", ".body.ron"])
}

/// A body like the built-in ones, whose z runs from the tip up the shaft.
fn body_of(file: &Path, tool_from_tip: &Pose) -> BodyFile {
    let half_turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let tool_from_body = tool_from_tip * pose_from_parts(Vector3::zeros(), half_turn);
    let body_from_tool = tool_from_body.inverse();
    BodyFile {
        rigid: RigidBody {
            name: own_name(file, ".body.ron"),
            tip_in_body: Some(Point3::origin()),
            sensors: vec![Sensor::six_dof(
                "tool",
                body_from_tool.translation.vector,
                body_from_tool.rotation,
            )],
        },
        mesh: None,
        definition: None,
        mounting: Mounting::default(),
    }
}

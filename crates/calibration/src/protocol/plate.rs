//! The plate: a grid of holes 50 mm apart on several levels, and a disc in its middle that turns a
//! sensor by equal steps.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use trackwright_field::Environment;
use trackwright_geometry::limits::{length_above_zero_problem, position_problem, short};
use trackwright_geometry::pose::{Pose, is_finite, pose_from_parts, pose_to_array};
use trackwright_result::{Section, data};

/// Distance of neighbouring holes.
pub const GRID_MM: f64 = 50.0;

/// Rows and columns of the paper's plate, as MITK's evaluation of the protocol has it.
pub const PAPER_ROWS: usize = 9;
pub const PAPER_COLUMNS: usize = 10;

/// Holes on the circle of the paper's disc: 11.25° each.
pub const PAPER_STEPS: usize = 32;

/// Levels of the paper's plate.
pub const PAPER_LEVELS: usize = 3;

/// Distance of levels that a plate gets where a room is high enough; the paper's is not known.
pub const LEVEL_MM: f64 = 100.0;

/// More holes a side, levels or steps are an error of whoever counts them.
const MOST: usize = 200;

/// The plate and where it is. Its frame: origin in the middle of the grid on level 0, x from column to
/// column, y from row to row, z from level to level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    pub rows: usize,
    pub columns: usize,
    pub levels: usize,
    pub level_mm: f64,
    /// Positions of the disc.
    pub steps: usize,
    pub tracker_from_plate: Pose,
}

impl Plate {
    /// The plate and where it is, as a result.
    pub fn section(&self) -> Section {
        Section::of([
            data("rows", self.rows),
            data("columns", self.columns),
            data("grid_mm", GRID_MM),
            data("levels", self.levels),
            data("level_mm", self.level_mm),
            data("steps", self.steps),
            data("tracker_from_plate", pose_to_array(&self.tracker_from_plate)),
        ])
    }

    /// The same in words.
    pub fn statement(&self) -> String {
        let Self { rows, columns, steps, .. } = self;
        let at = self.tracker_from_plate.translation.vector;
        let levels = match self.levels {
            1 => "one level".to_owned(),
            levels => format!("{levels} levels {} mm apart", self.level_mm),
        };
        format!(
            "{rows} by {columns} holes {GRID_MM} mm apart on {levels}, disc of {steps} steps; middle of level 0 at \
             ({:.1}, {:.1}, {:.1}) mm",
            at.x, at.y, at.z
        )
    }
}

/// Where a sensor is on the plate. Everything is counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    pub level: usize,
    pub at: SiteAt,
    /// A rod of metal beside the sensor.
    pub rod: Option<RodSite>,
}

/// A hole of the grid, or the disc at an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SiteAt {
    Hole { row: usize, column: usize },
    Disc { angle_deg: f64 },
}

/// What a sensor's reading determines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorKind {
    /// One coil along z: a turn is that of its axis, as the rotation about it is not measured.
    #[default]
    FiveDof,
    SixDof,
}

/// One reading of the sensor at a site.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateReading {
    pub site: Site,
    pub tracker_from_sensor: Pose,
}

/// A rod and where it is beside the sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct RodSite {
    /// Name of the material.
    pub rod: String,
    pub distance_mm: f64,
    /// Distinguishes rods at one distance.
    pub placement: String,
}

/// Why there is no such plate in a room.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlateError {
    #[error("{name} are {found}, expected {least} to {MOST}")]
    Count { name: &'static str, found: usize, least: usize },
    #[error("distance of levels is {} mm, expected {expected}", short(*found))]
    LevelDistance { found: f64, expected: &'static str },
    #[error("the pose of the plate is not finite or farther than 1e6 mm")]
    Pose,
    #[error(
        "{site} is at ({:.1}, {:.1}, {:.1}) mm, outside the room's {what}",
        position_mm[0], position_mm[1], position_mm[2]
    )]
    Outside { site: String, position_mm: [f64; 3], what: &'static str },
    #[error(
        "the room is {:.0} by {:.0} by {:.0} mm: not even four holes 50 mm apart fit into its middle",
        size_mm[0], size_mm[1], size_mm[2]
    )]
    NoneFits { size_mm: [f64; 3] },
}

impl Site {
    /// A site without a rod.
    pub fn plain(level: usize, at: SiteAt) -> Self {
        Self { level, at, rod: None }
    }

    /// For a person.
    pub fn label(&self) -> String {
        let at = match self.at {
            SiteAt::Hole { row, column } => format!("row {row}, column {column}"),
            SiteAt::Disc { angle_deg } => format!("disc at {}°", short(angle_deg)),
        };
        format!("level {}, {at}", self.level)
    }
}

impl Plate {
    /// The plate in the middle of a room, parallel to the tracker's x and y: as the paper's, with fewer
    /// holes and nearer levels where the room is smaller.
    ///
    /// # Errors
    /// [`PlateError::NoneFits`].
    pub fn fitted(environment: &Environment) -> Result<Self, PlateError> {
        let bounds = environment.model.bounds();
        let whole = match &environment.volume {
            Some(volume) => volume.bounds().intersection(bounds).unwrap_or(*bounds),
            None => *bounds,
        };
        let (middle, size) = (whole.center_mm(), whole.size_mm());
        let between = (PAPER_LEVELS - 1) as f64;
        for part in [1.0, 0.75, 0.5] {
            let height_mm = (between * LEVEL_MM).min(size.z * part);
            let level_mm = ((height_mm / between) / 10.0).floor().max(1.0) * 10.0;
            let bottom = middle.coords - Vector3::z() * (0.5 * between * level_mm);
            for fewer in 0..PAPER_ROWS - 1 {
                let plate = Self {
                    rows: PAPER_ROWS - fewer,
                    columns: PAPER_COLUMNS - fewer,
                    levels: PAPER_LEVELS,
                    level_mm,
                    steps: PAPER_STEPS,
                    tracker_from_plate: pose_from_parts(bottom, UnitQuaternion::identity()),
                };
                if plate.check_inside(environment).is_ok() {
                    return Ok(plate);
                }
            }
        }
        Err(PlateError::NoneFits { size_mm: size.into() })
    }

    /// Checks numbers and pose.
    ///
    /// # Errors
    /// Fewer than two rows or columns, or no level; a pose or a distance that cannot be. A disc of 0
    /// steps is none, one of fewer than 3 turns by no angle that could be measured.
    pub fn check(&self) -> Result<(), PlateError> {
        let counts = [
            ("rows", self.rows, 2),
            ("columns", self.columns, 2),
            ("levels", self.levels, 1),
            ("steps of the disc", self.steps, if self.steps == 0 { 0 } else { 3 }),
        ];
        for (name, found, least) in counts {
            if !(least..=MOST).contains(&found) {
                return Err(PlateError::Count { name, found, least });
            }
        }
        if let Some(expected) = length_above_zero_problem(self.level_mm) {
            return Err(PlateError::LevelDistance { found: self.level_mm, expected });
        }
        let position = &self.tracker_from_plate.translation.vector;
        match is_finite(&self.tracker_from_plate) && position_problem(position).is_none() {
            true => Ok(()),
            false => Err(PlateError::Pose),
        }
    }

    /// Checks that all of it is where the room was measured.
    ///
    /// # Errors
    /// Those of [`Plate::check`], and the first site outside the model's box or the tracker's volume.
    pub fn check_inside(&self, environment: &Environment) -> Result<(), PlateError> {
        self.check()?;
        for site in self.sites() {
            let p = Point3::from(self.tracker_from_sensor(&site).translation.vector);
            let is_in_volume = environment.volume.as_ref().is_none_or(|volume| volume.contains(&p));
            let what = match (environment.model.bounds().contains(&p), is_in_volume) {
                (true, true) => continue,
                (false, _) => "box",
                (true, false) => "measurement volume",
            };
            let site = site.label();
            return Err(PlateError::Outside { site, position_mm: p.coords.into(), what });
        }
        Ok(())
    }

    /// Holes level by level and row by row, and on each level the disc's positions after them.
    pub fn sites(&self) -> impl Iterator<Item = Site> + use<> {
        let Self { rows, columns, levels, steps, .. } = *self;
        (0..levels).flat_map(move |level| {
            let holes = (0..rows)
                .flat_map(move |row| (0..columns).map(move |column| SiteAt::Hole { row, column }));
            let step_deg = 360.0 / steps as f64;
            let disc =
                (0..steps).map(move |step| SiteAt::Disc { angle_deg: step as f64 * step_deg });
            holes.chain(disc).map(move |at| Site::plain(level, at))
        })
    }

    /// True pose of the sensor at a site: its axis, z, along the plate's x, turned by the disc about the
    /// plate's z. On the disc it is in the middle of the grid.
    pub fn tracker_from_sensor(&self, site: &Site) -> Pose {
        let middle = |count: usize| 0.5 * (count as f64 - 1.0);
        let (x, y, angle_deg) = match site.at {
            SiteAt::Hole { row, column } => {
                (column as f64 - middle(self.columns), row as f64 - middle(self.rows), 0.0)
            }
            SiteAt::Disc { angle_deg } => (0.0, 0.0, angle_deg),
        };
        let position = Vector3::new(x * GRID_MM, y * GRID_MM, site.level as f64 * self.level_mm);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_deg.to_radians());
        let along_x =
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
        self.tracker_from_plate * pose_from_parts(position, turn * along_x)
    }
}

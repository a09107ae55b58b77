//! Simulates a tracked tool in a room: a `Scenario` gives an `Outcome` of figures, over a pose, a
//! range of motion or given poses; slices, placement, tolerances and comparisons rest on the same
//! trials.
//!
//! Lengths are in mm, angles in radians unless a name states degrees.
//!
//! ```
//! use nalgebra::{Point3, UnitQuaternion};
//! use std::sync::Arc;
//! use trackwright_field::samples::MapKind;
//! use trackwright_field::random_models::room;
//! use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
//! use trackwright_geometry::pose::Pose;
//! use trackwright_simulation::*;
//!
//! // A room without any error, and a probe whose tip is 100 mm from its sensor.
//! let ideal = DistortionModel::zero(room(), MapKind::Distortion);
//! let environment = Environment::of_model("ideal", ideal);
//! let sensor = Sensor::six_dof("only", Point3::origin(), UnitQuaternion::identity());
//! let tip_in_body = Some(Point3::new(0.0, 0.0, 100.0));
//! let scenario = Scenario {
//!     environment: Arc::new(environment),
//!     tool: RigidBody { name: "probe".into(), tip_in_body, sensors: vec![sensor] },
//!     crf: None,
//!     crf_from_tool: Pose::translation(0.0, 0.0, -300.0),
//!     motion: None,
//!     orientation_weight_mm: 100.0,
//!     requirement: Some(Requirement::at_most([(Metric::TIP_MAX, 1.0)])),
//!     outside: OutsidePolicy::Clamp,
//! };
//! let study = study(&scenario, &Mode::Single, &CancelToken::default(), None)?;
//! assert!(study.room_field.value(Metric::TIP_RMS) < 1e-9);
//! let requirement = study.figures.requirement.expect("a requirement");
//! assert_eq!(requirement.verdict, Verdict::Met);
//! # Ok::<(), StudyError>(())
//! ```

pub mod along_shaft;
pub mod arrows;
pub mod axis_words;
pub mod body;
pub mod body_compensation;
pub mod body_prediction;
pub mod coil_fit;
pub mod comparison;
pub mod distinct;
pub mod error_sources;
pub mod expected;
mod explain;
pub mod field_lattice;
pub mod figure;
pub mod figures;
pub mod frame_fit;
pub mod judgement;
pub mod linear_fit;
pub mod metal_distance;
pub mod metric;
pub mod motion;
pub mod motion_outline;
pub mod mounting;
mod mounting_channel;
mod mounting_edits;
pub mod pairs;
pub mod pivot;
pub mod placement;
pub mod plan;
pub mod pose_rule;
pub mod preview;
pub mod profile;
pub mod recording;
pub mod refit;
pub mod requirement;
pub mod run;
pub mod scenario;
mod section;
pub mod shaft;
pub mod slice;
pub mod slice_plan;
pub mod slice_probe;
pub mod slice_quantity;
pub mod slice_support;
pub mod spread;
pub mod statistics;
pub mod study;
mod study_error;
pub mod support;
pub mod supported_region;
pub mod tolerance;
pub mod tool_in_crf;
pub mod tracker;
pub mod trial;
pub mod uncertainty;
pub mod usable_region;
pub mod weak_rotation;
pub mod work;

pub use along_shaft::AlongShaft;
pub use arrows::{ArrowOutcome, ArrowPlan, ArrowSensor, sample_arrows};
pub use body::{Coil, RigidBody, Sensor, SensorOrientation};
pub use coil_fit::{
    CoilFinding, CoilMisfit, Nearby, coil_findings, coil_fits, coil_gap_mm, coil_line_near,
    coil_points, coil_section, coil_statements, sticks_out_near,
};
pub use error_sources::{ErrorSources, TrialSource, error_sources, source_words, trial_sources};
pub use expected::{Expected, ExpectedError, expected};
pub use explain::{Deed, Explained, explain};
pub use figure::{Basis, Figure, Figures, NoInterval};
pub use figures::{RoomFieldFigures, figure_rows};
pub use frame_fit::Determination;
pub use judgement::{JudgedBound, Judgement, Undecided, Verdict};
pub use metric::{ErrorOf, METRICS, Metric, MetricMap, MetricValues, Statistics, Summary};
pub use motion::{AxisRange, Motion};
pub use mounting::{Mounting, MountingAxis, MountingError, MountingRegion};
pub use mounting_channel::channel_of;
pub use mounting_edits::{channel_point, new_forbidden_box};
pub use pivot::Pivot;
pub use placement::{
    AxisRule, BestPlace, CoilDepth, PlacedBody, Placement, PlacementError, PlacementOutcome,
    PlacementPlan, place,
};
pub use profile::{
    ChartedProfile, Profile, study_profiled, trial_count, trial_offsets, trial_pose,
};
pub use requirement::{Requirement, Within};
pub use run::{Outcome, StudyError, is_rejected, run};
pub use scenario::{InputTrial, Mode, Scenario, ScenarioCrf};
pub use shaft::shaft_in_body;
pub use slice::{SliceOutcome, sample_slice};
pub use slice_plan::{SlicePlan, SlicePlane};
pub use slice_probe::{Reading, SliceHit};
pub use slice_quantity::Quantity;
pub use slice_support::slice_support;
pub use study::{Study, study};
pub use support::{SupportSurvey, survey};
pub use supported_region::{SupportedRegion, SupportedRegionError, supported_region};
pub use tracker::SensorDetail;
pub use trackwright_task::CancelToken;
pub use trial::{BodyDetail, PoseDetail, Trial, simulate_pose};
pub use usable_region::{RegionBasis, RegionError, UsableRegion, usable_region};
pub use weak_rotation::WeakRotation;
pub use work::Work;

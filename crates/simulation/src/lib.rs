//! Scenario in, outcome out: the three modes, statistics, requirements, slices, work counted.

pub mod arrows;
pub mod body;
pub mod body_compensation;
pub mod body_prediction;
pub mod comparison;
pub mod distinct;
pub mod expected;
mod explain;
pub mod field_lattice;
pub mod figures;
pub mod frame_fit;
pub mod linear_fit;
pub mod metric;
pub mod motion;
pub mod motion_outline;
pub mod own_study;
pub mod pairs;
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
pub mod slice;
pub mod slice_plan;
pub mod slice_probe;
pub mod slice_quantity;
pub mod slice_support;
pub mod statistics;
pub mod support;
pub mod supported_region;
pub mod tolerance;
pub mod tool_in_crf;
pub mod tracker;
pub mod trial;
pub mod uncertainty;
pub mod usable_region;
pub mod work;

pub use arrows::{ArrowOutcome, ArrowPlan, ArrowSensor, sample_arrows};
pub use body::{Coil, RigidBody, Sensor, SensorOrientation};
pub use expected::{
    BoundVerdict, Expected, ExpectedError, ExpectedRow, Headline, expected, expected_rows, headline,
};
pub use explain::{Deed, Explained, explain};
pub use figures::{FigureRow, Figures, RowOf, figure_rows};
pub use frame_fit::Determination;
pub use metric::{ErrorOf, METRICS, Metric, MetricMap, MetricValues, Statistics, Summary};
pub use motion::{AxisRange, Motion};
pub use placement::{
    AxisRule, Basis, PlacedBody, Placement, PlacementError, PlacementOutcome, PlacementPlan, place,
};
pub use profile::{ChartedProfile, Profile, run_profiled, trial_count, trial_offsets, trial_pose};
pub use requirement::{Requirement, Within};
pub use run::{Outcome, StudyError, is_rejected, run};
pub use scenario::{InputTrial, Mode, Scenario, ScenarioCrf};
pub use slice::{SliceOutcome, sample_slice};
pub use slice_plan::{SlicePlan, SlicePlane};
pub use slice_probe::{Reading, SliceHit};
pub use slice_quantity::Quantity;
pub use slice_support::slice_support;
pub use support::{SupportSurvey, survey};
pub use supported_region::{SupportedRegion, SupportedRegionError, supported_region};
pub use trackwright_task::CancelToken;
pub use tracker::SensorDetail;
pub use trial::{BodyDetail, PoseDetail, Trial, look};
pub use usable_region::{RegionBasis, RegionError, UsableRegion, usable_region};
pub use work::Work;

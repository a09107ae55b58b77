//! Settings that lift the refusals which calibrations have in common.

use trackwright_result::Remedy;

pub const FEWER_POSES: Remedy =
    Remedy::new("min_poses", "each sample counts as one, and {} accepts fewer, 3 at least");
pub const LESS_RANGE: Remedy = Remedy::new("min_range_deg", "{} accepts less");
pub const LESS_TURN: Remedy = Remedy::new("min_turn_deg", "{} accepts less");

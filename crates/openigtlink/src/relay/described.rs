//! What a pose that is sent on states about itself: keys and values of version 2 metadata.

use super::tool::ToolClock;
use crate::codec::Extension;
use trackwright_simulation::body_prediction::BodyPrediction;

/// Whether the room's samples support the model at every sensor: `valid`, `invalid`, or [`UNKNOWN`].
pub const VALIDITY: &str = "trackwright.validity";

/// RMS distance of the tool's tip, as it is sent, from the true one, in mm.
pub const TIP_RMS_MM: &str = "trackwright.predicted_tip_rms_mm";

/// Standard error of the correction's position, RMS over the tool's sensors, in mm.
pub const STD_MM: &str = "trackwright.correction_std_mm";

/// Standard error of the correction's rotation, RMS over the tool's sensors, in degrees.
pub const STD_DEG: &str = "trackwright.correction_std_deg";

/// How much longer the sample took to arrive than the fastest of its tool, in ms.
pub const LATENCY_MS: &str = "trackwright.latency_ms";

/// By how much the clocks have moved against each other, in ms: as much delay may be hidden.
pub const CLOCK_SHIFT_MS: &str = "trackwright.clock_shift_ms";

/// All of them.
pub const KEYS: [&str; 6] = [VALIDITY, TIP_RMS_MM, STD_MM, STD_DEG, LATENCY_MS, CLOCK_SHIFT_MS];

/// What stands for a number, or a validity, that is not known.
pub const UNKNOWN: &str = "unknown";

/// Sets every key; other keys stay.
pub fn describe(extension: &mut Extension, known: Option<&BodyPrediction>, clock: &ToolClock) {
    let number = |value: Option<f64>, digits: usize| match value {
        Some(value) if value.is_finite() => format!("{value:.digits$}"),
        _ => UNKNOWN.to_owned(),
    };
    let validity = match known.map(|known| known.is_valid) {
        Some(true) => "valid",
        Some(false) => "invalid",
        None => UNKNOWN,
    };
    extension.set(VALIDITY, validity);
    let tip_rms_mm = known.and_then(|known| known.tip_rms_mm);
    extension.set(TIP_RMS_MM, &number(tip_rms_mm, 4));
    let std_mm = known.and_then(|known| known.position_std_error_mm);
    extension.set(STD_MM, &number(std_mm, 4));
    let std_rad = known.and_then(|known| known.angle_std_error_rad);
    extension.set(STD_DEG, &number(std_rad.map(f64::to_degrees), 4));
    let ms = |s: f64| 1e3 * s;
    extension.set(LATENCY_MS, &number(clock.latency_s.map(ms), 3));
    extension.set(CLOCK_SHIFT_MS, &number(clock.latency_s.map(|_| ms(clock.shift_s)), 3));
}

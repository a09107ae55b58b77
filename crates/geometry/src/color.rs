//! Colours as numbers: sRGB as files and screens have it, linear as light adds up.

/// Linear light of an sRGB channel, both from 0 to 1 (IEC 61966-2-1).
pub fn linear_from_srgb(channel: f64) -> f64 {
    match channel <= 0.04045 {
        true => channel / 12.92,
        false => ((channel + 0.055) / 1.055).powf(2.4),
    }
}

/// The sRGB channel of linear light, both from 0 to 1.
pub fn srgb_from_linear(light: f64) -> f64 {
    match light <= 0.003_130_8 {
        true => light * 12.92,
        false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }
}

/// Eight bits a channel as fractions.
pub fn fractions(srgb: [u8; 3]) -> [f64; 3] {
    srgb.map(|part| f64::from(part) / 255.0)
}

/// Linear light of an sRGB colour of eight bits a channel.
pub fn linear(srgb: [u8; 3]) -> [f64; 3] {
    fractions(srgb).map(linear_from_srgb)
}

/// Lightness as in HSL: the middle of the largest and the smallest channel.
pub fn lightness(srgb: [f64; 3]) -> f64 {
    let [low, high] = range(srgb);
    (low + high) / 2.0
}

/// A colour with another lightness; hue and saturation, as HSL has them, stay.
pub fn with_lightness(srgb: [f64; 3], wanted: f64) -> [f64; 3] {
    let [low, high] = range(srgb);
    let room = |lightness: f64| 1.0 - (2.0 * lightness - 1.0).abs();
    let (chroma, full) = (high - low, room((low + high) / 2.0));
    if chroma <= 0.0 || full <= 0.0 {
        return [wanted; 3];
    }
    let new_chroma = chroma / full * room(wanted);
    srgb.map(|part| wanted + ((part - low) / chroma - 0.5) * new_chroma)
}

fn range(srgb: [f64; 3]) -> [f64; 2] {
    [
        srgb.iter().copied().fold(f64::INFINITY, f64::min),
        srgb.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_light_round_trips_eight_bits() {
        for part in 0..=255u8 {
            let back = srgb_from_linear(linear([part; 3])[0]) * 255.0;
            // The standard's two constants round: at the joint the pieces differ by 1e-8.
            assert!((back - f64::from(part)).abs() < 1e-4, "{part}: {back}");
        }
        // The standard's own middle grey.
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
    }

    #[test]
    fn another_lightness_keeps_hue_and_saturation() {
        // hsl(30, 50 %, 40 %) is rgb(0.6, 0.4, 0.2); at 70 % it is rgb(0.85, 0.7, 0.55).
        let found = with_lightness([0.6, 0.4, 0.2], 0.7);
        for (found, expected) in found.iter().zip([0.85, 0.7, 0.55]) {
            assert!((found - expected).abs() < 1e-12, "{found}");
        }
        assert_eq!(with_lightness([0.3; 3], 0.8), [0.8; 3]);
        assert!((lightness([0.6, 0.4, 0.2]) - 0.4).abs() < 1e-15);
    }
}

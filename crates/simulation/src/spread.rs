//! Some of many places, evenly.

/// `some` of `count` places, spread by the golden ratio: in a grid no axis is missed, as it would be
/// by steps that are a multiple of the axis's own.
pub fn spread(count: usize, some: usize) -> impl Iterator<Item = usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..some.max(1)).map(move |k| {
        let part = ((k as f64 + 0.5) * GOLDEN).fract();
        ((part * count as f64) as usize).min(count - 1)
    })
}

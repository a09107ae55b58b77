//! Where labels go: beside what they name, never over each other.

use bevy_egui::egui::{Pos2, Rect, Vec2, pos2, vec2};

/// A label to place; earlier ones get the better places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    pub anchor: Pos2,
    pub size: Vec2,
    /// Room is looked for in all of the view.
    pub is_needed: bool,
}

/// Distances from the anchor that are tried, in pixels; the first touches no glyph.
const DISTANCES: [f32; 5] = [14.0, 30.0, 50.0, 78.0, 112.0];

/// Directions that are tried at each distance: right, left, and then around.
const DIRECTIONS: [(f32, f32); 8] = [
    (1.0, 0.0),
    (-1.0, 0.0),
    (0.8, -0.7),
    (0.8, 0.7),
    (-0.8, -0.7),
    (-0.8, 0.7),
    (0.0, -1.0),
    (0.0, 1.0),
];

/// Between the places in the view that are tried for a label that is needed.
const STEP: f32 = 12.0;

/// Half the side of the square around an anchor that other labels leave free.
const GLYPH_HALF: f32 = 7.0;

/// A place for each label, in order: none over another, none over an obstacle. `None` where there is no
/// room or the anchor is out of view.
pub fn place(wanted: &[Wanted], obstacles: &[Rect], view: Rect) -> Vec<Option<Rect>> {
    let glyphs: Vec<Rect> = wanted
        .iter()
        .map(|w| Rect::from_center_size(w.anchor, Vec2::splat(2.0 * GLYPH_HALF)))
        .collect();
    let mut taken: Vec<Rect> = obstacles.to_vec();
    let mut places = Vec::with_capacity(wanted.len());
    for (index, label) in wanted.iter().enumerate() {
        let place = place_one(label, index, &glyphs, &taken, view);
        taken.extend(place.map(|rect| rect.expand(2.0)));
        places.push(place);
    }
    places
}

fn place_one(
    label: &Wanted,
    index: usize,
    glyphs: &[Rect],
    taken: &[Rect],
    view: Rect,
) -> Option<Rect> {
    if !view.contains(label.anchor) {
        return None;
    }
    let candidates = || {
        DISTANCES.into_iter().flat_map(|distance| {
            DIRECTIONS.into_iter().map(move |direction| candidate(label, direction, distance))
        })
    };
    let is_free = |rect: &Rect| {
        view.contains_rect(*rect)
            && !taken.iter().any(|t| t.intersects(*rect))
            && !glyphs
                .iter()
                .enumerate()
                .any(|(other, glyph)| other != index && glyph.intersects(*rect))
    };
    candidates().find(is_free).or_else(|| {
        let anywhere = grid(view, label.size).filter(is_free);
        let away = |rect: &Rect| rect.distance_sq_to_pos(label.anchor);
        let nearest = || anywhere.min_by(|a, b| away(a).total_cmp(&away(b)));
        label.is_needed.then(nearest).flatten()
    })
}

/// Places all over the view.
fn grid(view: Rect, size: Vec2) -> impl Iterator<Item = Rect> {
    let steps = |space: f32| (0..=(space.max(0.0) / STEP) as usize).map(|k| k as f32 * STEP);
    let free = view.size() - size;
    steps(free.y).flat_map(move |y| {
        steps(free.x).map(move |x| Rect::from_min_size(view.min + vec2(x, y), size))
    })
}

/// The label's rectangle at a direction and distance from its anchor.
fn candidate(label: &Wanted, (x, y): (f32, f32), distance: f32) -> Rect {
    let half = label.size / 2.0;
    let shift = |d: f32, half: f32| d * distance + d.signum() * half * f32::from(d != 0.0);
    let center = label.anchor + vec2(shift(x, half.x), shift(y, half.y));
    Rect::from_center_size(center, label.size)
}

/// Where a line from the anchor meets the label; `None` where the label is near enough without.
pub fn leader(anchor: Pos2, label: Rect) -> Option<[Pos2; 2]> {
    let end = pos2(
        anchor.x.clamp(label.left(), label.right()),
        anchor.y.clamp(label.top(), label.bottom()),
    );
    let toward = end - anchor;
    let length = toward.length();
    (length > DISTANCES[0] + 2.0).then(|| [anchor + toward / length * GLYPH_HALF, end])
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: Rect = Rect { min: Pos2::ZERO, max: pos2(400.0, 300.0) };

    fn wanted(x: f32, y: f32) -> Wanted {
        Wanted { anchor: pos2(x, y), size: vec2(60.0, 16.0), is_needed: false }
    }

    #[test]
    fn ten_labels_at_nearly_one_place_do_not_overlap() {
        let all: Vec<Wanted> = (0..10).map(|k| wanted(200.0 + k as f32, 150.0)).collect();
        let places: Vec<Rect> = place(&all, &[], VIEW).into_iter().flatten().collect();
        assert!(places.len() >= 8, "{} of 10 placed", places.len());
        for (i, a) in places.iter().enumerate() {
            for b in &places[i + 1..] {
                assert!(!a.intersects(*b), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_label_at_the_right_edge_goes_left_of_its_anchor() {
        let place = place(&[wanted(390.0, 150.0)], &[], VIEW)[0].unwrap();
        assert!(place.right() < 390.0);
    }

    #[test]
    fn a_label_without_room_is_left_out() {
        for is_needed in [false, true] {
            let label = Wanted { is_needed, ..wanted(200.0, 150.0) };
            assert_eq!(place(&[label], &[VIEW], VIEW), [None]);
        }
    }

    #[test]
    fn a_needed_label_finds_the_room_that_is_left() {
        // A legend over all but a strip at the left.
        let legend = Rect::from_min_max(pos2(80.0, 0.0), VIEW.max);
        let mut label = wanted(300.0, 150.0);
        assert_eq!(place(&[label], &[legend], VIEW), [None]);
        label.is_needed = true;
        let several = [label; 3];
        let places: Vec<Rect> = place(&several, &[legend], VIEW).into_iter().flatten().collect();
        assert_eq!(places.len(), 3);
        for (i, a) in places.iter().enumerate() {
            assert!(VIEW.contains_rect(*a) && !a.intersects(legend), "{a:?}");
            assert!(places[i + 1..].iter().all(|b| !a.intersects(*b)), "{places:?}");
        }
    }

    #[test]
    fn what_is_out_of_view_has_no_label() {
        assert_eq!(place(&[wanted(500.0, 150.0)], &[], VIEW), [None]);
    }
}

//! Text in a chart: how wide it will be, how it is wrapped, and where it covers least.

/// Mean width of a letter of a sans face as a part of its size; wide faces (DejaVu) are 0.6.
const LETTER_WIDTH: f64 = 0.6;

/// Distance between lines of text, as a part of its size.
const LINE_HEIGHT: f64 = 1.3;

/// Costs of a place for a label: what leaves the plot, what covers another label, a point.
const OUT_OF_PLOT: usize = 1000;
const ON_A_LABEL: usize = 100;

/// Corners of an upright rectangle in pixels, y down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    pub left: i32,
    pub top: i32,
    pub right: i32,
    pub bottom: i32,
}

impl Rect {
    /// From left to right.
    pub fn width(&self) -> i32 {
        self.right - self.left
    }

    /// From top to bottom.
    pub fn height(&self) -> i32 {
        self.bottom - self.top
    }

    fn holds(&self, (x, y): (i32, i32)) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }

    fn contains(&self, other: &Self) -> bool {
        self.holds((other.left, other.top)) && self.holds((other.right, other.bottom))
    }

    fn meets(&self, other: &Self) -> bool {
        self.left <= other.right
            && other.left <= self.right
            && self.top <= other.bottom
            && other.top <= self.bottom
    }

    fn grown(&self, by: i32) -> Self {
        Self {
            left: self.left - by,
            top: self.top - by,
            right: self.right + by,
            bottom: self.bottom + by,
        }
    }
}

/// Width of a line of text, on the safe side.
pub fn width_px(text: &str, size_px: f64) -> i32 {
    (text.chars().count() as f64 * LETTER_WIDTH * size_px).ceil() as i32
}

/// Height of one line.
pub fn line_px(size_px: f64) -> i32 {
    (LINE_HEIGHT * size_px).round() as i32
}

/// Lines no wider than `max_px`, broken at spaces, and within words longer than a line.
pub fn wrapped(text: &str, size_px: f64, max_px: i32) -> Vec<String> {
    let max = ((f64::from(max_px) / (LETTER_WIDTH * size_px)) as usize).max(1);
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let letters: Vec<char> = word.chars().collect();
        for piece in letters.chunks(max) {
            let line = lines.last_mut().map(|l| l.chars().count()).unwrap_or(0);
            let gap = usize::from(line > 0);
            if line + gap + piece.len() > max && line > 0 {
                lines.push(String::new());
            }
            if let Some(last) = lines.last_mut() {
                if !last.is_empty() {
                    last.push(' ');
                }
                last.extend(piece);
            }
        }
    }
    lines
}

/// The place beside `at` where a label of a size covers the fewest points and no other label.
pub fn place(
    at: (i32, i32),
    (width, height): (i32, i32),
    gap: i32,
    plot: &Rect,
    points: &[(i32, i32)],
    taken: &[Rect],
) -> Rect {
    let (x, y) = at;
    let (w, h) = (width, height);
    let corners = [
        (x + gap, y - gap - h),
        (x + gap, y + gap),
        (x - gap - w, y - gap - h),
        (x - gap - w, y + gap),
        (x + gap + 6, y - h / 2),
        (x - gap - w - 6, y - h / 2),
        (x - w / 2, y - gap - h - 6),
        (x - w / 2, y + gap + 6),
        (x + 3 * gap, y - 3 * gap - h),
        (x - 3 * gap - w, y + 3 * gap),
        (x + 3 * gap, y + 3 * gap),
        (x - 3 * gap - w, y - 3 * gap - h),
    ];
    let rects = corners.map(|(left, top)| Rect { left, top, right: left + w, bottom: top + h });
    let cost = |r: &Rect| {
        let covered = points.iter().filter(|&&p| r.grown(5).holds(p)).count();
        let labels = taken.iter().filter(|t| t.meets(r)).count();
        OUT_OF_PLOT * usize::from(!plot.contains(r)) + ON_A_LABEL * labels + covered
    };
    // The first of equals.
    rects.into_iter().min_by_key(cost).unwrap_or(rects[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: Rect = Rect { left: 0, top: 0, right: 400, bottom: 300 };

    #[test]
    fn text_wraps_at_spaces_and_within_long_words() {
        assert_eq!(wrapped("one two three", 10.0, 48), ["one two", "three"]);
        assert_eq!(wrapped("abcdefghij", 10.0, 30), ["abcde", "fghij"]);
        assert_eq!(wrapped("", 10.0, 30), [""]);
    }

    #[test]
    fn a_label_avoids_points_and_the_edge() {
        let at = (200, 150);
        let above_right: Vec<_> = (0..9).map(|i| (210 + 5 * i, 140)).collect();
        let r = place(at, (40, 12), 8, &PLOT, &above_right, &[]);
        assert!(above_right.iter().all(|&p| !r.holds(p)), "{r:?}");
        let r = place((398, 2), (40, 12), 8, &PLOT, &[], &[]);
        assert!(PLOT.contains(&r), "{r:?}");
    }

    #[test]
    fn labels_of_neighbours_do_not_cover_each_other() {
        let first = place((200, 150), (60, 12), 8, &PLOT, &[], &[]);
        let second = place((204, 150), (60, 12), 8, &PLOT, &[], &[first]);
        assert!(!first.meets(&second));
    }
}

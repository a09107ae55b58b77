//! The shapes that tell series apart where colour does not.

use plotters::coord::Shift;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

/// Half the size of a marker, in pixels.
const RADIUS: i32 = 5;

/// Shapes before they come round again: filled ones first, then strokes.
const SHAPES: usize = 7;

/// The shape of a series by its number: another one each time the colours come round.
pub fn shape(number: usize, colors: usize) -> usize {
    (number + number / colors) % SHAPES
}

/// A shape by its number, in a colour, with a thin edge of paper so that neighbours stay apart.
pub fn draw<'a>(area: &Area<'a>, at: (i32, i32), shape: usize, color: RGBColor) -> Drawn<'a> {
    let r = RADIUS;
    match shape {
        0 => {
            area.draw(&Circle::new(at, r + 1, super::super::palette::PAPER.filled()))?;
            area.draw(&Circle::new(at, r, color.filled()))
        }
        1 => polygon(area, at, &[(-r, -r), (r, -r), (r, r), (-r, r)], color),
        2 => polygon(area, at, &[(0, -r - 1), (r + 1, r), (-r - 1, r)], color),
        3 => polygon(area, at, &[(0, -r - 2), (r + 2, 0), (0, r + 2), (-r - 2, 0)], color),
        4 => polygon(area, at, &[(0, r + 1), (r + 1, -r), (-r - 1, -r)], color),
        5 => strokes(area, at, &[[(-r, -r), (r, r)], [(-r, r), (r, -r)]], color),
        _ => strokes(area, at, &[[(-r - 1, 0), (r + 1, 0)], [(0, -r - 1), (0, r + 1)]], color),
    }
}

fn polygon<'a>(
    area: &Area<'a>,
    at: (i32, i32),
    corners: &[(i32, i32)],
    color: RGBColor,
) -> Drawn<'a> {
    let placed = |scale: &dyn Fn(i32) -> i32| -> Vec<(i32, i32)> {
        corners.iter().map(|&(x, y)| (at.0 + scale(x), at.1 + scale(y))).collect()
    };
    area.draw(&Polygon::new(placed(&|v| v + v.signum()), super::super::palette::PAPER.filled()))?;
    area.draw(&Polygon::new(placed(&|v| v), color.filled()))
}

fn strokes<'a>(
    area: &Area<'a>,
    at: (i32, i32),
    lines: &[[(i32, i32); 2]],
    color: RGBColor,
) -> Drawn<'a> {
    for line in lines {
        let placed = line.map(|(x, y)| (at.0 + x, at.1 + y));
        area.draw(&PathElement::new(placed, color.stroke_width(3)))?;
    }
    Ok(())
}

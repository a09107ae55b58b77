//! Calibration, pivot and fiducial files of the Johns Hopkins computer-integrated-surgery data sets.
//!
//! The first line holds counts and the file's name, every other one `x, y, z` in millimetres.

use super::error::{FormatError, quoted, text};
use nalgebra::Point3;
use trackwright_calibration::calibration_object::{CalibrationBody, CalibrationFrame};
use trackwright_calibration::marker_body::BaseAndTool;

/// Most points of a file: far above any real one, far below what would fill the memory.
const MAX_POINTS: usize = 100_000_000;

/// Up to three lists of points that a file has for each frame.
type Frame = [Vec<Point3<f64>>; 3];

/// Reads a `calbody` file: counts `N_D, N_A, N_C, name`, then the points.
///
/// # Errors
/// Counts that are none, lines that are no points, too few or too many of them.
pub fn parse_calbody(bytes: &[u8]) -> Result<CalibrationBody, FormatError> {
    let expected = "three counts and a name (N_D, N_A, N_C, name)";
    let mut frames = read_frames(bytes, expected, |each: [usize; 3]| (each, 1))?;
    let [optical_on_base, optical_on_object, em_on_object] = frames.pop().unwrap_or_default();
    Ok(CalibrationBody { optical_on_base, optical_on_object, em_on_object })
}

/// Reads a `calreadings` file: counts `N_D, N_A, N_C, N_frames, name`, then the points of each
/// frame.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_calreadings(bytes: &[u8]) -> Result<Vec<CalibrationFrame>, FormatError> {
    let expected = "four counts and a name (N_D, N_A, N_C, N_frames, name)";
    let frames = read_frames(bytes, expected, |[d, a, c, frames]| ([d, a, c], frames))?;
    let frame = |[optical_on_base, optical_on_object, em_on_object]: Frame| CalibrationFrame {
        optical_on_base,
        optical_on_object,
        em_on_object,
    };
    Ok(frames.into_iter().map(frame).collect())
}

/// Reads an `empivot`, `em-fiducialss` or `EM-nav` file: counts `N_G, N_frames, name`, then where the
/// markers of the probe are in each frame.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_empivot(bytes: &[u8]) -> Result<Vec<Vec<Point3<f64>>>, FormatError> {
    let expected = "two counts and a name (N_G, N_frames, name)";
    let frames = read_frames(bytes, expected, |[markers, frames]| ([markers, 0, 0], frames))?;
    Ok(frames.into_iter().map(|[markers, ..]| markers).collect())
}

/// Reads an `optpivot` file: counts `N_D, N_H, N_frames, name`, then in each frame where the markers of
/// the EM tracker's base are, and those of the probe.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_optpivot(bytes: &[u8]) -> Result<Vec<BaseAndTool>, FormatError> {
    let expected = "three counts and a name (N_D, N_H, N_frames, name)";
    let frames = read_frames(bytes, expected, |[base, probe, frames]| ([base, probe, 0], frames))?;
    let frame = |[on_base, on_tool, _]: Frame| BaseAndTool { on_base, on_tool };
    Ok(frames.into_iter().map(frame).collect())
}

/// Reads a `ct-fiducials` file: a count and a name, `N_B, name`, then the points.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_ct_fiducials(bytes: &[u8]) -> Result<Vec<Point3<f64>>, FormatError> {
    let expected = "a count and a name (N_B, name)";
    let mut frames = read_frames(bytes, expected, |[count]| ([count, 0, 0], 1))?;
    let [points, ..] = frames.pop().unwrap_or_default();
    Ok(points)
}

/// Reads a file's points; `layout` gives from its counts how many each frame has, and how many frames
/// there are.
fn read_frames<const N: usize>(
    bytes: &[u8],
    expected: &str,
    layout: impl Fn([usize; N]) -> ([usize; 3], usize),
) -> Result<Vec<Frame>, FormatError> {
    let text = text(bytes)?;
    let mut lines = (1..).zip(text.lines().map(str::trim));
    let header = lines.next().map_or("", |(_, line)| line);
    let wrong = |expected: String| FormatError::line(1, quoted(header), expected);
    let counts = counts(header).ok_or_else(|| wrong(expected.to_owned()))?;
    let ([a, b, c], frames) = layout(counts);
    // Counts that no file could hold are refused before anything is set aside for them.
    let each = a.checked_add(b).and_then(|n| n.checked_add(c));
    if each.and_then(|n| n.checked_mul(frames)).is_none_or(|n| n > MAX_POINTS) {
        return Err(wrong(format!("counts of at most {MAX_POINTS} points")));
    }
    let mut lines = lines.filter(|(_, line)| !line.is_empty());
    let mut next = || match lines.next() {
        Some((line, content)) => {
            point(content).ok_or_else(|| FormatError::line(line, quoted(content), "x, y, z in mm"))
        }
        None => {
            let expected = format!("more points: line 1 states {}", quoted(header));
            let line = text.lines().count() as u64;
            Err(FormatError::line(line, "the end of the file", expected))
        }
    };
    let mut take = |count: usize| (0..count).map(|_| next()).collect::<Result<Vec<_>, _>>();
    let frames = (0..frames).map(|_| Ok([take(a)?, take(b)?, take(c)?]));
    let frames = frames.collect::<Result<Vec<Frame>, FormatError>>()?;
    match lines.next() {
        None => Ok(frames),
        Some((line, content)) => {
            let expected = format!("the end of the file: line 1 states {}", quoted(header));
            Err(FormatError::line(line, quoted(content), expected))
        }
    }
}

/// The counts of a first line, each above zero. Its last cell is the file's name; without one these
/// are another file's counts.
fn counts<const N: usize>(header: &str) -> Option<[usize; N]> {
    let mut cells = header.split(',').map(str::trim);
    let mut counts = [0; N];
    for count in &mut counts {
        *count = cells.next()?.parse().ok().filter(|&count| count > 0)?;
    }
    let is_named = cells.next()?.parse::<f64>().is_err();
    (is_named && cells.next().is_none()).then_some(counts)
}

fn point(line: &str) -> Option<Point3<f64>> {
    let cells: Option<Vec<f64>> = line.split(',').map(|cell| cell.trim().parse().ok()).collect();
    match cells?.as_slice() {
        &[x, y, z] if [x, y, z].iter().all(|v| v.is_finite()) => Some(Point3::new(x, y, z)),
        _ => None,
    }
}

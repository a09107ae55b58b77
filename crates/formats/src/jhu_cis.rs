//! Calibration, pivot and fiducial files of the Johns Hopkins computer-integrated-surgery data sets.
//!
//! The first line holds counts and the file's name, every other one `x, y, z` in millimetres.

use super::error::{FormatError, text};
use nalgebra::Point3;
use trackwright_calibration::calibration_object::{CalibrationBody, CalibrationFrame};
use trackwright_calibration::marker_body::BaseAndTool;

/// Most points of a file: far above any real one, far below what would fill the memory.
const MAX_POINTS: usize = 100_000_000;

/// Reads a `calbody` file: counts `N_D, N_A, N_C, name`, then the points.
///
/// # Errors
/// Counts that are none, lines that are no points, too few or too many of them.
pub fn parse_calbody(bytes: &[u8]) -> Result<CalibrationBody, FormatError> {
    let mut file = Points::open(bytes)?;
    let [base, object, em] = file.counts("three counts and a name (N_D, N_A, N_C, name)")?;
    file.expect_total([base, object, em, 1])?;
    let body = CalibrationBody {
        optical_on_base: file.take(base)?,
        optical_on_object: file.take(object)?,
        em_on_object: file.take(em)?,
    };
    file.finish()?;
    Ok(body)
}

/// Reads a `calreadings` file: counts `N_D, N_A, N_C, N_frames, name`, then the points of each
/// frame.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_calreadings(bytes: &[u8]) -> Result<Vec<CalibrationFrame>, FormatError> {
    let mut file = Points::open(bytes)?;
    let [base, object, em, frames] =
        file.counts("four counts and a name (N_D, N_A, N_C, N_frames, name)")?;
    file.expect_total([base, object, em, frames])?;
    let frames = (0..frames)
        .map(|_| {
            Ok(CalibrationFrame {
                optical_on_base: file.take(base)?,
                optical_on_object: file.take(object)?,
                em_on_object: file.take(em)?,
            })
        })
        .collect::<Result<_, FormatError>>()?;
    file.finish()?;
    Ok(frames)
}

/// Reads an `empivot`, `em-fiducialss` or `EM-nav` file: counts `N_G, N_frames, name`, then where the
/// markers of the probe are in each frame.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_empivot(bytes: &[u8]) -> Result<Vec<Vec<Point3<f64>>>, FormatError> {
    let mut file = Points::open(bytes)?;
    let [markers, frames] = file.counts("two counts and a name (N_G, N_frames, name)")?;
    file.expect_total([markers, 0, 0, frames])?;
    let frames = (0..frames).map(|_| file.take(markers)).collect::<Result<_, FormatError>>()?;
    file.finish()?;
    Ok(frames)
}

/// Reads an `optpivot` file: counts `N_D, N_H, N_frames, name`, then in each frame where the markers of
/// the EM tracker's base are, and those of the probe.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_optpivot(bytes: &[u8]) -> Result<Vec<BaseAndTool>, FormatError> {
    let mut file = Points::open(bytes)?;
    let [base, probe, frames] =
        file.counts("three counts and a name (N_D, N_H, N_frames, name)")?;
    file.expect_total([base, probe, 0, frames])?;
    let frames = (0..frames)
        .map(|_| Ok(BaseAndTool { on_base: file.take(base)?, on_tool: file.take(probe)? }))
        .collect::<Result<_, FormatError>>()?;
    file.finish()?;
    Ok(frames)
}

/// Reads a `ct-fiducials` file: a count and a name, `N_B, name`, then the points.
///
/// # Errors
/// As [`parse_calbody`].
pub fn parse_ct_fiducials(bytes: &[u8]) -> Result<Vec<Point3<f64>>, FormatError> {
    let mut file = Points::open(bytes)?;
    let [count] = file.counts("a count and a name (N_B, name)")?;
    file.expect_total([count, 0, 0, 1])?;
    let points = file.take(count)?;
    file.finish()?;
    Ok(points)
}

/// The lines of a file that still have to be read; empty ones are skipped.
struct Points<'a> {
    header: &'a str,
    lines: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    last_line: usize,
}

impl<'a> Points<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let text = text(bytes)?;
        let mut lines = text.lines().map(str::trim).enumerate();
        let header = lines.next().map_or("", |(_, line)| line);
        Ok(Self {
            header,
            lines: Box::new(lines.filter(|(_, line)| !line.is_empty())),
            last_line: text.lines().count(),
        })
    }

    fn counts<const N: usize>(&self, expected: &str) -> Result<[usize; N], FormatError> {
        let error = || FormatError::Line {
            line: 1,
            found: format!("{:?}", shortened(self.header)),
            expected: expected.to_owned(),
        };
        let mut cells = self.header.split(',').map(str::trim);
        let mut counts = [0; N];
        for count in &mut counts {
            *count = cells
                .next()
                .and_then(|cell| cell.parse().ok())
                .filter(|&count| count > 0)
                .ok_or_else(error)?;
        }
        // The last cell is the file's name; without one these are another file's counts.
        match (cells.next(), cells.next()) {
            (Some(name), None) if name.parse::<f64>().is_err() => Ok(counts),
            _ => Err(error()),
        }
    }

    /// Refuses counts that no file could hold before anything is set aside for them.
    fn expect_total(&self, [base, object, em, frames]: [usize; 4]) -> Result<(), FormatError> {
        let total = base
            .checked_add(object)
            .and_then(|n| n.checked_add(em))
            .and_then(|n| n.checked_mul(frames))
            .filter(|&n| n <= MAX_POINTS);
        match total {
            Some(_) => Ok(()),
            None => Err(FormatError::Line {
                line: 1,
                found: format!("{:?}", shortened(self.header)),
                expected: format!("counts of at most {MAX_POINTS} points"),
            }),
        }
    }

    fn take(&mut self, count: usize) -> Result<Vec<Point3<f64>>, FormatError> {
        (0..count).map(|_| self.point()).collect()
    }

    fn point(&mut self) -> Result<Point3<f64>, FormatError> {
        let expected = "x, y, z in mm";
        let Some((index, line)) = self.lines.next() else {
            return Err(FormatError::Line {
                line: self.last_line as u64,
                found: "the end of the file".to_owned(),
                expected: format!("more points: line 1 says {:?}", shortened(self.header)),
            });
        };
        let mut cells = line.split(',').map(|cell| cell.trim().parse::<f64>());
        match (cells.next(), cells.next(), cells.next(), cells.next()) {
            (Some(Ok(x)), Some(Ok(y)), Some(Ok(z)), None)
                if x.is_finite() && y.is_finite() && z.is_finite() =>
            {
                Ok(Point3::new(x, y, z))
            }
            _ => Err(FormatError::Line {
                line: index as u64 + 1,
                found: format!("{:?}", shortened(line)),
                expected: expected.to_owned(),
            }),
        }
    }

    fn finish(mut self) -> Result<(), FormatError> {
        match self.lines.next() {
            None => Ok(()),
            Some((index, line)) => Err(FormatError::Line {
                line: index as u64 + 1,
                found: format!("{:?}", shortened(line)),
                expected: format!("the end of the file: line 1 says {:?}", shortened(self.header)),
            }),
        }
    }
}

/// A line short enough to be quoted.
fn shortened(line: &str) -> String {
    line.chars().take(60).collect()
}

//! What two sides of a table show beside each other, row by row.

use super::alone::{Extent, PoseFrame, SMALL_REACH, Signs, is_too_far};
use super::mistake::Mistake;
use super::parts::{self, FAR_MM, FAR_RATIO};
use super::whole::{self, CERTAIN_PART, LEAST_MM, positions};
use super::{Explained, MIN_ROWS, Part, Suspicion, in_order, piece, sensor};
use crate::robust::median;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use trackwright_field::samples::{Measurement, MeasurementContent};
use trackwright_geometry::bounds::Bounds;

/// Rows that are kept, evenly from the table: 30 MB.
const MAX_KEPT: usize = 1 << 18;

/// Rows that whole sides are compared by.
const MAX_COMPARED: usize = 4096;

/// Rows by which a side may be late.
const MAX_SHIFT: usize = 3;

/// Steps from row to row that are used, the longest of the table, and the fewest: on a path,
/// whose rows are nearly where their neighbours are, those at its gaps and ends alone.
const MAX_STEPS: usize = 256;
const MIN_STEPS: usize = 6;

/// Those down to half as far are outliers as well where so many times as far as the next nearer row: they
/// are the tracker's other solution too.
const OUTLIER_GAP: f64 = 1.5;

/// A row is repeated where its numbers stand so many times as often in the table as those of the median row.
const LEAST_REPEATS: f64 = 5.0;

/// Units in which rows are close to the origin, and the part of these that has to be in the room with one of them.
const SMALL_UNITS: [(f64, &str); 3] = [(10.0, "centimetres"), (25.4, "inches"), (1000.0, "metres")];
const MOST_OF_SMALL: f64 = 0.8;

/// Part of the table's spread that rows in another frame have at least.
const SPREAD_PART: f64 = 0.5;

/// Rooms distort by less, RMS.
const LARGE_MM: f64 = 20.0;
const LARGE_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Measurements as they come, of which a bounded number is kept.
#[derive(Clone, Debug)]
pub struct PairedDoubts {
    content: MeasurementContent,
    frame: PoseFrame,
    rows: usize,
    kept: Vec<Measurement>,
    /// Every so many-th row is kept.
    stride: usize,
    ideal: Extent,
    measured: Extent,
    signs: [Signs; 2],
}

impl PairedDoubts {
    /// Of a table without rows.
    pub fn new(content: MeasurementContent, frame: PoseFrame) -> Self {
        Self {
            content,
            frame,
            rows: 0,
            kept: Vec::new(),
            stride: 1,
            ideal: Extent::default(),
            measured: Extent::default(),
            signs: [Signs::default(); 2],
        }
    }

    /// The suspicions of a whole table.
    pub fn of(
        measurements: &[Measurement],
        content: MeasurementContent,
        frame: PoseFrame,
    ) -> Vec<Suspicion> {
        let mut doubts = Self::new(content, frame);
        measurements.iter().for_each(|m| doubts.push(m));
        doubts.suspicions()
    }

    /// Takes the next row.
    pub fn push(&mut self, m: &Measurement) {
        let (ideal, measured) = positions(m);
        self.ideal.push(&[ideal]);
        self.measured.push(&[measured]);
        if self.content != MeasurementContent::PositionOnly {
            self.signs[0].push(&m.tracker_from_ideal);
            self.signs[1].push(&m.tracker_from_measured);
        }
        if self.rows.is_multiple_of(self.stride) {
            if self.kept.len() == MAX_KEPT {
                let mut places = 0..;
                self.kept.retain(|_| places.next().is_some_and(|k: usize| k.is_multiple_of(2)));
                self.stride *= 2;
            }
            if self.rows.is_multiple_of(self.stride) {
                self.kept.push(*m);
            }
        }
        self.rows += 1;
    }

    /// What is suspected, the worst first.
    pub fn suspicions(&self) -> Vec<Suspicion> {
        let mut found = self.alone();
        if self.rows < MIN_ROWS {
            return found;
        }
        let is_usable = |m: &Measurement| {
            let (ideal, measured) = positions(m);
            let is_missing = self.frame != PoseFrame::Any && is_missing(m);
            !(is_too_far(&ideal) || is_too_far(&measured) || is_missing)
        };
        let usable: Vec<(usize, Measurement)> = self
            .kept
            .iter()
            .enumerate()
            .filter(|(_, m)| is_usable(m))
            .map(|(k, m)| (k * self.stride, *m))
            .collect();
        found.extend(self.zeros());
        if usable.len() < MIN_ROWS {
            return found;
        }
        found.extend(copied(&usable).into_iter().chain(repeated(&usable)));
        let compared: Vec<Measurement> = every(&usable, MAX_COMPARED).map(|(_, m)| *m).collect();
        let pairs: Vec<_> = compared.iter().map(positions).collect();
        // One of another scale is compared with nothing until that is put right.
        if let Some(scale) = whole::scale(&pairs, ["ideal", "measured"]) {
            found.push(scale);
        } else if let Some(part) = self.unit_of_part(&usable) {
            found.push(part);
        } else {
            found.extend(self.compared(&usable, &compared));
        }
        if found.is_empty() {
            found.extend(large(&compared, self.content));
        }
        found.sort_by_key(|suspicion| !suspicion.is_beyond_doubt());
        found
    }

    /// Of sides in the same unit.
    fn compared(&self, usable: parts::Rows<'_>, compared: &[Measurement]) -> Vec<Suspicion> {
        let has_axes = self.content != MeasurementContent::PositionOnly;
        let mut found = Vec::new();
        let shift = self.shift(usable);
        let place = || {
            let [scaled, placed] = [sensor::scale(compared), whole::placed(compared)];
            match (&scaled, &placed) {
                (
                    Some(Suspicion::Mistake { explained: by_scale, .. }),
                    Some(Suspicion::Mistake { explained: by_place, .. }),
                ) if by_place.after < by_scale.after => placed,
                _ => scaled.or(placed),
            }
        };
        let is_shifted = shift.is_some();
        found.extend(shift.or_else(place));
        if has_axes && !is_shifted {
            let turned = whole::turned(compared, !found.is_empty());
            if turned.is_none() {
                found.extend(self.scalar_last());
            }
            found.extend(turned);
        }
        if !found.is_empty() {
            return found;
        }
        let positions = parts::far_positions(usable);
        if positions.found.is_none() && positions.is_far.contains(&true) {
            let of_all = self
                .shift_of_part(usable, &positions)
                .or_else(|| frame_of_part(usable, &positions.is_far))
                .or_else(|| parts::moved(usable, self.content));
            if let Some(of_all) = of_all {
                return vec![of_all];
            }
        }
        let mut is_far = positions.is_far.clone();
        found.extend(positions.found.or_else(|| outliers(usable)));
        if has_axes {
            let orientations = parts::far_orientations(usable);
            let is_new = |k: &usize| orientations.is_far[*k] && !is_far[*k];
            let far: Vec<usize> = (0..usable.len()).filter(is_new).collect();
            found.extend(orientations.found.or_else(|| {
                let first_row = usable[*far.first()?].0 + 1;
                let part = Some(Part { count: far.len(), of: usable.len(), first_row });
                let mut angles: Vec<f64> =
                    far.iter().map(|&k| parts::angle(&usable[k].1)).collect();
                Some(Suspicion::Orientations { median_rad: median(&mut angles)?, part })
            }));
            is_far.iter_mut().zip(&orientations.is_far).for_each(|(all, is)| *all |= is);
        }
        let near: Vec<(usize, Measurement)> =
            usable.iter().zip(&is_far).filter(|(_, is)| !**is).map(|(row, _)| *row).collect();
        if near.len() < MIN_ROWS {
            return found;
        }
        let compared: Vec<Measurement> = every(&near, MAX_COMPARED).map(|(_, m)| *m).collect();
        let stride = self.stride * near.len().div_ceil(MAX_COMPARED);
        let of_all = in_order::lag(&compared, self.content, stride)
            .or_else(|| parts::moved(&near, self.content))
            .or_else(|| sensor::of_sensor(&compared, self.content))
            .or_else(|| in_order::change(&compared, self.content))
            .or_else(|| piece::in_one_piece(&near, self.content));
        found.extend(of_all);
        found
    }

    /// What a side shows by itself. Sides in one small unit report it once.
    fn alone(&self) -> Vec<Suspicion> {
        let mut found = self.ideal.suspicions(self.frame);
        for other in self.measured.suspicions(self.frame) {
            let is_reported = |earlier: &Suspicion| {
                std::mem::discriminant(earlier) == std::mem::discriminant(&other)
            };
            if !found.iter().any(is_reported) {
                found.push(other);
            }
        }
        found
    }

    fn scalar_last(&self) -> Option<Suspicion> {
        let [ideal, measured] = self.signs.map(|signs| signs.suspicion());
        ideal.or(measured)
    }

    /// Rows beside a tracker's origin, apart from the others, and among them where both sides are in another unit.
    fn unit_of_part(&self, rows: parts::Rows<'_>) -> Option<Suspicion> {
        let is_small = |(_, m): &&(usize, Measurement)| {
            let (ideal, measured) = positions(m);
            ideal.norm().max(measured.norm()) < SMALL_REACH
        };
        if self.frame != PoseFrame::Tracker {
            return None;
        }
        let place = |(_, m): &(usize, Measurement)| Point3::from(positions(m).0);
        let room = Bounds::around(rows.iter().filter(|row| !is_small(row)).map(place))?;
        let small: Vec<&(usize, Measurement)> =
            rows.iter().filter(is_small).filter(|row| !room.contains(&place(row))).collect();
        let inside =
            |factor: f64| small.iter().filter(|row| room.contains(&(place(row) * factor))).count();
        let units = SMALL_UNITS.map(|(factor, units)| (inside(factor), units));
        let (count, units) = units.into_iter().max_by_key(|(count, _)| *count)?;
        let is_it = count >= MIN_ROWS && count as f64 > MOST_OF_SMALL * small.len() as f64;
        let part = Part { count, of: rows.len(), first_row: small.first()?.0 + 1 };
        is_it.then_some(Suspicion::UnitOfPart { part, units })
    }

    /// Positions of a tracker are nowhere in its origin.
    fn zeros(&self) -> Option<Suspicion> {
        if self.frame == PoseFrame::Any {
            return None;
        }
        let of = |is_it: fn(&Measurement) -> bool| -> Vec<usize> {
            (0..self.kept.len()).filter(|&k| is_it(&self.kept[k])).collect()
        };
        // A grid may have a few rows in the origin.
        let both = of(|m| positions(m) == (Vector3::zeros(), Vector3::zeros()));
        let rows = if both.len() < MIN_ROWS { of(is_missing) } else { both };
        let first_row = rows.first()? * self.stride + 1;
        Some(Suspicion::Zeros { count: rows.len(), first_row })
    }

    /// Far rows that are those of some rows before or after.
    fn shift_of_part(&self, rows: parts::Rows<'_>, far: &parts::FarRows) -> Option<Suspicion> {
        let place = |k: usize| positions(&rows[k].1);
        // Along a path a row's neighbours are near it: only readings that are not in their own row count.
        let left = |k: usize, by: isize| {
            let at = k.checked_add_signed(by).filter(|&at| at < rows.len() && far.is_far[at])?;
            Some((place(at).1 - place(k).0).norm())
        };
        let of = |by: isize| -> Vec<usize> {
            let is_it = |&k: &usize| left(k, by).is_some_and(|left| left <= far.near);
            (0..rows.len()).filter(|&k| far.is_far[k]).filter(is_it).collect()
        };
        let shifts = (1..=MAX_SHIFT as isize).flat_map(|by| [by, -by]);
        let (by, members) = shifts.map(|by| (by, of(by))).max_by_key(|(_, of)| of.len())?;
        let count = far.is_far.iter().filter(|is| **is).count();
        if self.stride > 1 || members.len() < MIN_ROWS || 2 * members.len() < count {
            return None;
        }
        let median_of = |by: isize| {
            median(&mut members.iter().filter_map(|&k| left(k, by)).collect::<Vec<_>>())
        };
        let change = Explained::new(median_of(0)?, median_of(by)?, FAR_MM, FAR_MM)?;
        let first_row = rows[members[0]].0 + 1;
        let part = Some(Part { count: members.len(), of: rows.len(), first_row });
        Some(Suspicion::RowShift { rows: by, part, change })
    }

    /// Rows of one side that are late: its steps from row to row are those of other rows.
    fn shift(&self, rows: parts::Rows<'_>) -> Option<Suspicion> {
        if self.stride > 1 {
            return None;
        }
        let pair = |k: usize| positions(&rows[k].1);
        let length = |k: usize| (pair(k + 1).0 - pair(k).0).norm();
        let last = rows.len().checked_sub(MAX_SHIFT + 1)?;
        let mut steps: Vec<usize> = (MAX_SHIFT..last).filter(|&k| length(k) > LEAST_MM).collect();
        steps.sort_by(|a, b| length(*b).total_cmp(&length(*a)));
        steps.truncate(MAX_STEPS);
        if steps.len() < MIN_STEPS {
            return None;
        }
        // Between a step of the ideal side and the measured one so many rows later.
        let late = |by: isize| {
            let each = steps.iter().map(|&k| {
                let at = k.saturating_add_signed(by);
                let ideal = pair(k + 1).0 - pair(k).0;
                (pair(at + 1).1 - pair(at).1 - ideal).norm()
            });
            median(&mut each.collect::<Vec<_>>())
        };
        let shifts = (1..=MAX_SHIFT as isize).flat_map(|by| [by, -by]);
        let tried = shifts.filter_map(|by| Some((by, late(by)?)));
        let (by, after) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let places: Vec<Vector3<f64>> =
            every(rows, MAX_COMPARED).map(|(_, m)| positions(m).0).collect();
        let certain = CERTAIN_PART * whole::spread(places.iter());
        let change = Explained::new(late(0)?, after, LEAST_MM, certain)?;
        Some(Suspicion::RowShift { rows: by, part: None, change })
    }
}

/// Whether one side has zeros and the other another place.
fn is_missing(m: &Measurement) -> bool {
    let (ideal, measured) = positions(m);
    let has_zeros = ideal == Vector3::zeros() || measured == Vector3::zeros();
    has_zeros && (ideal - measured).norm() > FAR_MM
}

/// So many rows, evenly.
fn every<'a>(rows: parts::Rows<'a>, most: usize) -> impl Iterator<Item = &'a (usize, Measurement)> {
    rows.iter().step_by(rows.len().div_ceil(most))
}

/// Rows that are far and in another frame than the others.
fn frame_of_part(rows: parts::Rows<'_>, is_far: &[bool]) -> Option<Suspicion> {
    let far: Vec<&(usize, Measurement)> =
        rows.iter().zip(is_far).filter(|(_, is)| **is).map(|(row, _)| row).collect();
    if far.len() < MIN_ROWS {
        return None;
    }
    let pairs: Vec<_> = far.iter().map(|(_, m)| positions(m)).collect();
    let near = rows.iter().zip(is_far).filter(|(_, is)| !**is);
    let near: Vec<Vector3<f64>> = near.map(|((_, m), _)| positions(m).0).collect();
    // Within a small region a rotation and a translation explain any field.
    if whole::spread(pairs.iter().map(|pair| &pair.0)) < SPREAD_PART * whole::spread(near.iter()) {
        return None;
    }
    let (pose, after) = whole::rigid(&pairs, false)?;
    let before = median(&mut pairs.iter().map(|(a, b)| (a - b).norm()).collect::<Vec<_>>())?;
    let explained = Explained::new(before, after, FAR_MM, FAR_MM)?;
    let at = nalgebra::Point3::from(pairs[0].0);
    let mistake =
        Mistake::Frame { angle_rad: pose.rotation.angle(), shift: (pose * at - at).norm() };
    let part = Some(Part { count: far.len(), of: rows.len(), first_row: far[0].0 + 1 });
    Some(Suspicion::Mistake { mistake, part, explained })
}

fn outliers(rows: parts::Rows<'_>) -> Option<Suspicion> {
    let apart = |m: &Measurement| {
        let (ideal, measured) = positions(m);
        (measured - ideal).norm()
    };
    let mut all: Vec<f64> = rows.iter().map(|(_, m)| apart(m)).collect();
    let median = median(&mut all)?;
    let mut limit = FAR_MM.max(FAR_RATIO * median);
    all.sort_by(f64::total_cmp);
    let first_beyond = all.partition_point(|mm| *mm <= limit);
    let half_as_far = all.partition_point(|mm| *mm <= limit / 2.0);
    let neighbors = all.get(half_as_far.saturating_sub(1)..=first_beyond)?.windows(2);
    let gap = neighbors.max_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
    if let Some(&[nearer, farther]) = gap
        && farther > OUTLIER_GAP * nearer
    {
        limit = (nearer + farther) / 2.0;
    }
    let mut beyond = rows.iter().filter(|(_, m)| apart(m) > limit);
    let first_row = beyond.next()?.0 + 1;
    let largest = all.last().copied()?;
    Some(Suspicion::Outliers { count: 1 + beyond.count(), first_row, limit, largest, median })
}

fn copied(rows: parts::Rows<'_>) -> Option<Suspicion> {
    let mut copied = rows.iter().filter(|(_, m)| {
        let (ideal, measured) = positions(m);
        ideal == measured
    });
    let first_row = copied.next()?.0 + 1;
    Some(Suspicion::Copied { count: 1 + copied.count(), of: rows.len(), first_row })
}

fn repeated(rows: parts::Rows<'_>) -> Option<Suspicion> {
    let mut counts: HashMap<[u64; 6], (usize, usize)> = HashMap::new();
    for (row, m) in rows {
        let (ideal, measured) = positions(m);
        let key = [ideal.x, ideal.y, ideal.z, measured.x, measured.y, measured.z].map(f64::to_bits);
        counts.entry(key).or_insert((*row, 0)).1 += 1;
    }
    let mut each: Vec<f64> = counts.values().map(|(_, count)| *count as f64).collect();
    let usual = LEAST_REPEATS * median(&mut each)?;
    let is_often = |count: usize| count as f64 > usual || counts.len() < MIN_ROWS;
    let often = counts.values().filter(|(_, count)| is_often(*count));
    let (first_row, count) =
        often.fold((usize::MAX, 0), |(first, sum), (row, count)| (first.min(row + 1), sum + count));
    (count > 0).then_some(Suspicion::Repeated { count, first_row })
}

fn large(rows: &[Measurement], content: MeasurementContent) -> Option<Suspicion> {
    let rms = |value: &dyn Fn(&Measurement) -> f64| {
        (rows.iter().map(|m| value(m).powi(2)).sum::<f64>() / rows.len() as f64).sqrt()
    };
    let position_mm = rms(&|m| {
        let (ideal, measured) = positions(m);
        (ideal - measured).norm()
    });
    let angle_rad = match content {
        MeasurementContent::PositionOnly => 0.0,
        _ => rms(&parts::angle),
    };
    (position_mm > LARGE_MM || angle_rad > LARGE_RAD)
        .then_some(Suspicion::Large { position_mm, angle_rad })
}

//! Poses of one tool from recordings of any kind, corrected for a room where one is given.

use super::prelude::*;
use nalgebra::Point3;
use trackwright_calibration::marker_body::{MarkerBody, in_base};
use trackwright_field::compensation::{Compensated, Method, Tally, compensate};
use trackwright_field::computed::ModelKind;
use trackwright_field::environment::Environment;
use trackwright_formats::pivot_recording::PivotRecording;
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::pose::Pose;
use trackwright_task::Task;

/// What files of the same tool share.
pub(super) struct ToolReader<'a> {
    files: &'a Files,
    /// A part of the tool's name.
    pub tool: Option<String>,
    /// A part of the name of the tool in whose frame poses are.
    pub reference: Option<String>,
    /// The room that readings are corrected for, and what happens outside its box.
    pub room: Option<(Environment, OutsidePolicy)>,
    /// What became of the readings that were corrected, of all files so far.
    pub tally: Tally,
    /// Markers of an EM tracker's base, in its frame.
    pub base: Option<Vec<Point3<f64>>>,
    /// Whether any recording needed them.
    pub has_used_base: bool,
    /// A tool that is known by its markers has the frame that they have when they are first seen.
    body: Option<MarkerBody>,
    has_poses: bool,
    as_is: AsIsArgs,
}

impl<'a> ToolReader<'a> {
    pub(super) fn of_tool(files: &'a Files, tool: Option<&str>, as_is: AsIsArgs) -> Self {
        Self {
            files,
            tool: tool.map(str::to_owned),
            room: None,
            tally: Tally::default(),
            base: None,
            has_used_base: false,
            body: None,
            has_poses: false,
            reference: None,
            as_is,
        }
    }

    /// The tool's poses in several files, one after the other.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(super) fn read_all<'p>(
        &mut self,
        recordings: impl IntoIterator<Item = &'p Path>,
    ) -> anyhow::Result<Vec<Pose>> {
        let mut poses = Vec::new();
        for file in recordings {
            poses.extend(self.read(file)?);
        }
        Ok(poses)
    }

    /// The tool's poses in a file.
    ///
    /// # Errors
    /// Files that can't be used, poses beside markers, markers without an answer.
    fn read(&mut self, file: &Path) -> anyhow::Result<Vec<Pose>> {
        let named = || file.display().to_string();
        let markers = match self.as_is.take(self.files.read_pivot_recording(file)?)? {
            found if self.reference.is_some() && !matches!(found, PivotRecording::Tools(_)) => {
                bail!(
                    "{}: found poses of one tool, expected a recording of several, one of which is the reference tool",
                    named()
                )
            }
            PivotRecording::Poses(poses) => return self.poses(file, poses),
            PivotRecording::Tools(recording) => {
                let (tool, reference) = (self.tool.as_deref(), self.reference.as_deref());
                let track = recording.track(tool, reference).with_context(named)?;
                for (reason, count) in track.unusable() {
                    output::note(&format!(
                        "{}: {} of {} samples not used: {reason}",
                        named(),
                        with_separators(count),
                        with_separators(track.samples.len())
                    ));
                }
                return self.poses(file, track.good().copied().collect());
            }
            PivotRecording::Markers(frames) => self.corrected(file, frames)?,
            PivotRecording::MarkersAndBase(_) if self.room.is_some() => bail!(
                "{}: found readings of an optical tracker, which no --environment corrects",
                named()
            ),
            PivotRecording::MarkersAndBase(frames) => {
                let base = self.base.as_ref().with_context(|| {
                    format!(
                        "{}: found markers beside those of the EM tracker's base, expected --calbody, which states where \
                         these are",
                        named()
                    )
                })?;
                let markers = in_base(base, &frames).with_context(named)?;
                self.has_used_base = true;
                markers
            }
        };
        if self.has_poses {
            bail!(MixedKinds(named()));
        }
        let first = markers.first().map_or(&[][..], Vec::as_slice);
        let body = self.body.get_or_insert_with(|| MarkerBody::seen_at(first));
        body.poses(&markers).with_context(named)
    }

    fn poses(&mut self, file: &Path, poses: Vec<Pose>) -> anyhow::Result<Vec<Pose>> {
        if self.body.is_some() {
            bail!(MixedKinds(file.display().to_string()));
        }
        self.has_poses = true;
        let Some(found) = self.compensated(file, &poses, "poses")? else {
            return Ok(poses);
        };
        let corrected: Vec<Pose> = found.iter().filter_map(|at| at.pose).collect();
        note_unused(file, poses.len() - corrected.len(), poses.len(), "poses");
        Ok(corrected)
    }

    /// Readings corrected for the room, counted and reported; `None` where there is no room.
    fn compensated(
        &mut self,
        file: &Path,
        measured: &[Pose],
        what: &str,
    ) -> anyhow::Result<Option<Vec<Compensated>>> {
        let Some((room, outside)) = &self.room else {
            return Ok(None);
        };
        let method = Method::of(room.model.map());
        let found = compensate(&room.model, measured, *outside, method, &Task::default())?;
        let tally = Tally::of(measured, &found);
        let what = format!("{what} of {} are", file.display());
        output::note_outside(&what, tally.outside, tally.rows, *outside);
        self.tally.add(&tally);
        Ok(Some(found))
    }

    /// Markers, which have positions alone, corrected each by itself; frames that are not corrected as a
    /// whole are left out and counted.
    fn corrected(
        &mut self,
        file: &Path,
        frames: Vec<Vec<Point3<f64>>>,
    ) -> anyhow::Result<Vec<Vec<Point3<f64>>>> {
        let Some((room, _)) = &self.room else {
            return Ok(frames);
        };
        let model = &room.model;
        if model.directions() != DirectionSet::One || model.computed().is_some() {
            let found = match model.kind() {
                ModelKind::Bernstein => format!("{}", model.directions().len()),
                kind => format!("a {} model", kind.name()),
            };
            bail!(
                "{}: found markers, which have no axes, expected a room of 1 orientation for them, not {found}",
                file.display()
            );
        }
        let read: Vec<Pose> =
            frames.iter().flatten().map(|at| Pose::translation(at.x, at.y, at.z)).collect();
        let Some(found) = self.compensated(file, &read, "markers")? else {
            return Ok(frames);
        };
        let mut corrected = found.iter().map(|at| at.pose);
        let mut answers = Vec::with_capacity(frames.len());
        for markers in &frames {
            // All of a frame are taken, whichever of them has no answer.
            let positions: Vec<_> = corrected.by_ref().take(markers.len()).collect();
            let positions: Option<Vec<Point3<f64>>> = positions
                .into_iter()
                .map(|pose| pose.map(|pose| pose.translation.vector.into()))
                .collect();
            answers.extend(positions);
        }
        if answers.is_empty() {
            bail!(
                "{}: found no frame of {} whose markers the room corrects, expected some within its box",
                file.display(),
                with_separators(frames.len())
            );
        }
        note_unused(file, frames.len() - answers.len(), frames.len(), "frames");
        Ok(answers)
    }
}

/// Reports how many readings have no answer.
fn note_unused(file: &Path, unused: usize, of: usize, what: &str) {
    if unused > 0 {
        output::note(&format!(
            "note: {}: {} of {} {what} not used: the room has no correction there",
            file.display(),
            with_separators(unused),
            with_separators(of)
        ));
    }
}

/// Recordings that know their tool in different ways.
#[derive(Debug, thiserror::Error)]
#[error(
    "{0}: found poses beside markers, expected recordings of one kind: the tool's frame is not the same"
)]
struct MixedKinds(String);

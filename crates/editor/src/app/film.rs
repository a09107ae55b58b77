//! Moving pictures of the 3D view without a window: one app paints every frame, each of them the
//! picture that `picture` would take there.

use crate::app::picture::{Picture, PictureError, PictureSetup, Studio};
use crate::document::requests::OpenWorld;
use crate::viewport::camera::OrbitRig;
use crate::workspaces::study::{self, state::StudyRequest};
use nalgebra::{Translation3, Vector3};
use trackwright_design::{Edit, MetalEdit};
use trackwright_geometry::pose::Pose;
use trackwright_project::World;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilmMove {
    /// The camera goes round its focus once, about the scene's vertical. The frame after the last one
    /// would be the first, so that it can be played in a loop.
    Turntable,
    /// The tool goes through so many trials of its range of motion, in the order in which the Study
    /// workspace plays them; the last frame shows the last one.
    Motion { trials: usize },
    /// A metal object, by its place in the room's list, goes by a vector of the tracker frame; the last
    /// frame shows it there.
    Metal { object: usize, by_mm: Vector3<f64> },
}

/// Paints so many frames and hands each on as it comes.
///
/// Call [`preflight::adapter`](crate::app::preflight::adapter) first, as for a picture.
///
/// # Errors
/// See [`PictureError`], and those of `take`, which end it.
pub fn film<E: From<PictureError>>(
    world: World,
    size: [u32; 2],
    mut setup: PictureSetup,
    what: FilmMove,
    frames: usize,
    mut take: impl FnMut(usize, Picture) -> Result<(), E>,
) -> Result<(), E> {
    if matches!(what, FilmMove::Motion { .. }) && !setup.workspace.shows_trials {
        setup.workspace = study::WORKSPACE;
    }
    let mut studio = Studio::open(world, size, setup)?;
    let first = studio.app.world().resource::<OrbitRig>().camera;
    let objects = world_metal(&studio);
    for frame in 0..frames {
        match what {
            FilmMove::Turntable => {
                let part = frame as f64 / frames as f64;
                studio.app.world_mut().resource_mut::<OrbitRig>().camera = first.turned(part);
            }
            FilmMove::Motion { trials } => {
                let trial = trial_of(frame, frames, trials);
                studio.show(StudyRequest::Show(Some(trial)))?;
            }
            FilmMove::Metal { object, by_mm } => {
                let Some(start) = objects.get(object) else { continue };
                let moved = Translation3::from(by_mm * part_of(frame, frames));
                let tracker_from_object =
                    Pose::from_parts(moved * start.translation, start.rotation);
                studio
                    .edit(Edit::Metal(MetalEdit::SetPose { index: object, tracker_from_object }))?;
            }
        }
        take(frame, studio.picture()?)?;
    }
    Ok(())
}

/// Where the metal is at first.
fn world_metal(studio: &Studio) -> Vec<Pose> {
    let design = studio.app.world().resource::<OpenWorld>().0.document.design();
    let objects = design.room_metal.iter().flat_map(|metal| &metal.objects);
    objects.map(|object| object.tracker_from_object).collect()
}

/// How far the film is in a frame: 0 in the first one, 1 in the last.
fn part_of(frame: usize, frames: usize) -> f64 {
    frame as f64 / frames.saturating_sub(1).max(1) as f64
}

/// The trial that a frame shows: the first one in the first frame, the last one in the last.
fn trial_of(frame: usize, frames: usize, trials: usize) -> usize {
    (part_of(frame, frames) * trials.saturating_sub(1) as f64).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn film_frames_span_all_trials_at_even_steps() {
        let trials = |frames, trials| -> Vec<usize> {
            (0..frames).map(|k| trial_of(k, frames, trials)).collect()
        };
        assert_eq!(trials(5, 5), [0, 1, 2, 3, 4]);
        assert_eq!(trials(3, 101), [0, 50, 100]);
        assert_eq!(trials(4, 2), [0, 0, 1, 1]);
        assert_eq!(trials(1, 9), [0]);
        assert_eq!(trials(3, 1), [0, 0, 0]);
    }
}

//! `trackwright render --turntable` and `--motion`: the 3D view in motion, as a video where `ffmpeg` is
//! installed, else as numbered pictures with the command that joins them.

use super::metal::object_index;
use super::numbers::{above_zero, three};
use super::prelude::*;
use indicatif::ProgressBar;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use trackwright_editor::app::film::{FilmMove, film};
use trackwright_editor::app::picture::{Picture, PictureError, PictureSetup};
use trackwright_project::{
    self, ENCODER, FrameFolder, Output, StoreError, VideoError, VideoFile, VideoShape, World,
};
use trackwright_simulation::{Mode, trial_count};

/// A turn that is slow enough to follow, and short enough to be watched to its end.
const TURN_S: f64 = 12.0;

/// A metal object that is moved as a hand would.
const METAL_S: f64 = 8.0;

/// Trials a second as the Study workspace plays them.
const TRIALS_PER_S: f64 = 25.0;

/// Longest motion without a stated length.
const LONGEST_MOTION_S: f64 = 30.0;

/// An hour of 60 frames a second is more than anybody watches.
const MOST_FRAMES: f64 = 216_000.0;

#[derive(Args, Clone, Debug)]
pub struct VideoArgs {
    #[command(flatten)]
    moves: MoveArgs,
    /// How far the metal object goes in all, mm of the tracker frame
    #[arg(long, value_name = "X,Y,Z", requires = "move_metal", allow_hyphen_values = true, value_parser = three)]
    by: Option<[f64; 3]>,
    /// How long it lasts; a turn of 12 s, and a motion of 25 poses a second up to 30 s by default
    #[arg(long, value_name = "S", requires = "moves", value_parser = above_zero)]
    seconds: Option<f64>,
    /// Frames a second
    #[arg(long, value_name = "N", requires = "moves", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=120))]
    fps: u32,
}

/// What moves.
#[derive(Args, Clone, Debug)]
#[group(id = "moves", required = false, multiple = false)]
struct MoveArgs {
    /// A video of one turn of the camera about the vertical through what it looks at; OUTPUT is an
    /// .mp4, or a folder for numbered pictures
    #[arg(long)]
    turntable: bool,
    /// A video of the tool going through its range of motion, pose by pose as the Study workspace
    /// plays it
    #[arg(long, conflicts_with = "trial")]
    motion: bool,
    /// A video of a metal object of the room that goes by --by, with the figures at each place
    #[arg(long, value_name = "NAME", requires = "by")]
    move_metal: Option<String>,
}

/// Where frames go.
enum Frames {
    Video(VideoFile),
    Pictures(FrameFolder),
}

/// Why a film ends early.
#[derive(Debug, thiserror::Error)]
enum FilmError {
    #[error("interrupted")]
    Interrupted,
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Video(#[from] VideoError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Begin(#[from] anyhow::Error),
}

impl VideoArgs {
    /// Whether anything is to move.
    pub fn is_wanted(&self) -> bool {
        self.moves.turntable || self.moves.motion || self.moves.move_metal.is_some()
    }

    /// Paints and writes it.
    ///
    /// # Errors
    /// A design without a range of motion, a size that no video has, an encoder that fails, a file or
    /// folder that cannot be written.
    pub fn run(
        &self,
        world: World,
        size: [u32; 2],
        setup: PictureSetup,
        output: &Output,
    ) -> anyhow::Result<()> {
        let to = output.file();
        let what = self.what(&world)?;
        let frames = self.frames(what)?;
        let shape = VideoShape { size, frames_per_s: self.fps };
        shape.check().context("--size")?;
        check_name(to)?;
        if !is_folder(to) {
            output.expect_own()?;
        }
        if let FilmMove::Motion { trials } = what
            && trials > frames
        {
            output::note(&format!(
                "note: {frames} frames show {frames} of {trials} poses; --seconds {:.0} shows all",
                (trials as f64 / f64::from(self.fps)).ceil()
            ));
        }
        let bar = output::progress(frames as u64, "painting");
        let is_interrupted = Arc::new(AtomicBool::new(false));
        // Begun with the first frame: until then nothing is there to be cleared away, and a signal
        // ends the program as it ends any.
        let mut begun: Option<(Frames, PathBuf)> = None;
        let filmed = film(world, size, setup, what, frames, |index, picture| {
            if is_interrupted.load(Ordering::Relaxed) {
                return Err(FilmError::Interrupted);
            }
            let (out, _) = match &mut begun {
                Some(begun) => begun,
                none => none.insert(begin(to, shape, &is_interrupted)?),
            };
            out.take(index, picture)?;
            report_progress(&bar, index, frames);
            Ok(())
        });
        bar.finish_and_clear();
        if let Err(FilmError::Interrupted) = filmed {
            bail!("interrupted; no video was written");
        }
        filmed.with_context(|| format!("cannot write {}", to.display()))?;
        match begun {
            Some((Frames::Video(file), _)) => {
                file.finish().with_context(|| format!("cannot write {}", to.display()))?;
                output.is_written();
                Ok(())
            }
            Some((Frames::Pictures(folder), video)) => {
                output::print(&folder.command(&video, frames, self.fps))
            }
            None => bail!("{}: no frame was painted", to.display()),
        }
    }

    fn what(&self, world: &World) -> anyhow::Result<FilmMove> {
        if self.moves.turntable {
            return Ok(FilmMove::Turntable);
        }
        if let (Some(name), Some(by_mm)) = (&self.moves.move_metal, self.by) {
            let Some(metal) = &world.document.design().room_metal else {
                bail!("--move-metal: found a room without metal, expected an object to move");
            };
            let object = object_index(metal, Some(name)).context("--move-metal")?;
            return Ok(FilmMove::Metal { object, by_mm: by_mm.into() });
        }
        let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
        match trial_count(&scenario, &Mode::Motion) {
            Some(trials) if trials > 0 => Ok(FilmMove::Motion { trials }),
            _ => {
                bail!("the design has no range of motion to go through, expected one for --motion")
            }
        }
    }

    fn frames(&self, what: FilmMove) -> anyhow::Result<usize> {
        let usual_s = match what {
            FilmMove::Turntable => TURN_S,
            FilmMove::Metal { .. } => METAL_S,
            FilmMove::Motion { trials } => (trials as f64 / TRIALS_PER_S).min(LONGEST_MOTION_S),
        };
        let seconds = self.seconds.unwrap_or(usual_s);
        let frames = (seconds * f64::from(self.fps)).round().max(1.0);
        if frames > MOST_FRAMES {
            bail!("--seconds {seconds} is {frames:.0} frames, expected at most {MOST_FRAMES}");
        }
        Ok(frames as usize)
    }
}

impl Frames {
    fn take(&mut self, index: usize, picture: Picture) -> Result<(), FilmError> {
        match self {
            Self::Video(file) => file.frame(&picture.rgba()?)?,
            Self::Pictures(folder) => folder.frame(index, &picture.png()?)?,
        }
        Ok(())
    }
}

fn is_folder(to: &Path) -> bool {
    to.is_dir() || to.as_os_str().to_string_lossy().ends_with('/')
}

/// Refuses a name that is neither a video's nor a folder's.
fn check_name(to: &Path) -> anyhow::Result<()> {
    let is_mp4 = to.extension().is_some_and(|e| e.eq_ignore_ascii_case("mp4"));
    if !is_mp4 && !is_folder(to) {
        bail!(
            "{}: expected a name that ends in .mp4, or a folder that ends in / for numbered pictures",
            to.display()
        );
    }
    Ok(())
}

/// Opens what frames go to, and from then on has a signal end the film at its next frame.
fn begin(
    to: &Path,
    shape: VideoShape,
    is_interrupted: &Arc<AtomicBool>,
) -> anyhow::Result<(Frames, PathBuf)> {
    let is_interrupted = Arc::clone(is_interrupted);
    ctrlc::set_handler(move || is_interrupted.store(true, Ordering::Relaxed))
        .context("Ctrl+C cannot be listened for")?;
    output_at(to, shape)
}

/// An encoder where a video is wanted and there is one, else a folder; and what the video is called.
fn output_at(to: &Path, shape: VideoShape) -> anyhow::Result<(Frames, PathBuf)> {
    if is_folder(to) {
        // Beside the folder, under its name.
        let mut video = to.file_name().unwrap_or("video".as_ref()).to_owned();
        video.push(".mp4");
        return Ok((Frames::Pictures(FrameFolder::new(to)?), to.with_file_name(video)));
    }
    if let Some(file) = VideoFile::start(ENCODER, to, shape)? {
        return Ok((Frames::Video(file), to.to_owned()));
    }
    let folder = FrameFolder::path_for(to);
    output::note(&format!(
        "note: {ENCODER} was not found; the frames go to {}, and the command that joins them is \
         printed at the end",
        folder.display()
    ));
    Ok((Frames::Pictures(FrameFolder::new(&folder)?), to.to_owned()))
}

/// On a terminal by a bar, elsewhere in a line now and then.
fn report_progress(bar: &ProgressBar, index: usize, frames: usize) {
    bar.set_position(index as u64 + 1);
    let tenth = |done: usize| done * 10 / frames;
    if bar.is_hidden() && tenth(index + 1) > tenth(index) {
        output::note(&format!("{} of {frames} frames", index + 1));
    }
}

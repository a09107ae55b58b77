//! Videos: frames into `ffmpeg`, which encodes them into a file that is whole or not there, or one by
//! one into a folder where it is not installed.

use super::error::StoreError;
use super::paths::{extension_of, folder_of};
use super::write::{Draft, Temporary, remove_leftovers, write_error};
use std::collections::VecDeque;
use std::ffi::OsStr;
use std::fs;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::thread::{self, JoinHandle};

/// What encodes, by the name that it is found by.
pub const ENCODER: &str = "ffmpeg";

/// Lines that are reported of a failed encoder's output: the reason is in the last ones.
const REPORTED_LINES: usize = 5;

/// H.264 in 4:2:0, which every player and slide program shows, at a quality at which thin lines stay
/// clean; sRGB's primaries are those of BT.709, whose matrix players expect of what is large.
/// Playing begins before all of it is there.
const ENCODING: &str = "-an -vf scale=out_color_matrix=bt709:out_range=tv -c:v libx264 \
    -preset medium -crf 18 -pix_fmt yuv420p -colorspace bt709 -color_primaries bt709 \
    -color_trc bt709 -movflags +faststart -y";

/// Width and height in pixels, and frames a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VideoShape {
    /// Even numbers: half of the picture's colours are kept in each direction.
    pub size: [u32; 2],
    pub frames_per_s: u32,
}

#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    #[error("{} x {} pixels cannot be a video, expected even numbers", .0[0], .0[1])]
    OddSize([u32; 2]),
    #[error("a frame has {found} bytes, expected {expected}")]
    Frame { found: usize, expected: usize },
    #[error("{encoder} cannot be started: {cause}")]
    Start { encoder: String, cause: io::Error },
    #[error("{encoder} takes no more frames: {cause}")]
    Write { encoder: String, cause: io::Error },
    #[error("{encoder} failed ({status}): {output}")]
    Encoder {
        encoder: String,
        status: ExitStatus,
        /// Its last lines.
        output: String,
    },
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// A video in the making. Dropping it leaves nothing behind.
#[derive(Debug)]
pub struct VideoFile {
    encoder: String,
    frame_bytes: usize,
    file: PathBuf,
    /// Beside the file, whose place it takes in the end.
    temporary: Temporary,
    child: Child,
    frames: Option<ChildStdin>,
    stderr_lines: Option<JoinHandle<String>>,
}

impl VideoFile {
    /// Starts an encoder, usually [`ENCODER`]; `None` where there is no such program.
    pub fn start(
        encoder: impl AsRef<OsStr>,
        file: &Path,
        shape: VideoShape,
    ) -> Result<Option<Self>, VideoError> {
        let [width, height] = shape.size;
        shape.check()?;
        // The encoder determines the container by the name's end.
        remove_leftovers(&folder_of(file));
        let temporary = Temporary::next_to(file, &format!(".{}", extension_of(file)))
            .map_err(|cause| write_error(file, cause))?;
        let encoder = encoder.as_ref();
        let mut command = Command::new(encoder);
        command
            .args(["-hide_banner", "-loglevel", "error", "-nostdin"])
            .args(["-f", "rawvideo", "-pixel_format", "rgba"])
            .arg("-video_size")
            .arg(format!("{width}x{height}"))
            .arg("-framerate")
            .arg(shape.frames_per_s.to_string())
            .args(["-i", "pipe:0"])
            .args(ENCODING.split(' '))
            .arg(&temporary.path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        // Ctrl+C is this program's to answer.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let name = encoder.to_string_lossy().into_owned();
        let mut child = match command.spawn() {
            Ok(child) => child,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(cause) => return Err(VideoError::Start { encoder: name, cause }),
        };
        let mut video = Self {
            encoder: name,
            frame_bytes: shape.frame_bytes(),
            file: file.to_owned(),
            temporary,
            frames: child.stdin.take(),
            child,
            stderr_lines: None,
        };
        if let Some(stderr) = video.child.stderr.take() {
            let reader = thread::Builder::new().spawn(move || last_lines(BufReader::new(stderr)));
            // Dropped, the video ends its encoder.
            video.stderr_lines =
                Some(reader.map_err(|cause| VideoError::Start {
                    encoder: video.encoder.clone(),
                    cause,
                })?);
        }
        Ok(Some(video))
    }

    /// Hands a frame on: red, green, blue and opacity of each pixel, from the upper left.
    pub fn frame(&mut self, rgba: &[u8]) -> Result<(), VideoError> {
        if rgba.len() != self.frame_bytes {
            return Err(VideoError::Frame { found: rgba.len(), expected: self.frame_bytes });
        }
        let written = match &mut self.frames {
            Some(frames) => frames.write_all(rgba),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        };
        written.or_else(|cause| {
            // It reads no more, and its last lines state why.
            self.end()?;
            Err(VideoError::Write { encoder: self.encoder.clone(), cause })
        })
    }

    /// Waits for the encoder and puts the video in its place.
    pub fn finish(mut self) -> Result<(), VideoError> {
        self.end()?;
        let placed = self.temporary.handle.sync_all();
        let placed = placed.and_then(|()| fs::rename(&self.temporary.path, &self.file));
        Ok(placed.map_err(|cause| write_error(&self.file, cause))?)
    }

    /// No more frames come.
    fn end(&mut self) -> Result<(), VideoError> {
        drop(self.frames.take());
        let status = self
            .child
            .wait()
            .map_err(|cause| VideoError::Start { encoder: self.encoder.clone(), cause })?;
        if status.success() {
            return Ok(());
        }
        let output = self.stderr_lines.take().and_then(|reader| reader.join().ok());
        Err(VideoError::Encoder {
            encoder: self.encoder.clone(),
            status,
            output: output
                .filter(|lines| !lines.is_empty())
                .unwrap_or_else(|| "it gave no reason".to_owned()),
        })
    }
}

impl Drop for VideoFile {
    fn drop(&mut self) {
        drop(self.frames.take());
        // One that has ended is not there to be killed.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl VideoShape {
    fn frame_bytes(self) -> usize {
        let [width, height] = self.size.map(|side| side as usize);
        width * height * 4
    }

    /// Refuses odd sizes.
    pub fn check(self) -> Result<(), VideoError> {
        match self.size.iter().all(|side| side % 2 == 0 && *side > 0) {
            true => Ok(()),
            false => Err(VideoError::OddSize(self.size)),
        }
    }
}

/// The last lines of a stream, which is read as a whole: else its writer would wait.
fn last_lines(stream: impl BufRead) -> String {
    let mut lines = VecDeque::new();
    for line in stream.split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line).trim().to_owned();
        if !line.is_empty() {
            lines.push_back(line);
        }
        if lines.len() > REPORTED_LINES {
            lines.pop_front();
        }
    }
    Vec::from(lines).join("; ")
}

/// Frames as pictures in a folder, numbered from 1.
#[derive(Clone, Debug)]
pub struct FrameFolder {
    folder: PathBuf,
}

impl FrameFolder {
    /// Makes the folder if it has to be. Frames that are there are written over.
    pub fn new(folder: &Path) -> Result<Self, StoreError> {
        fs::create_dir_all(folder).map_err(|cause| write_error(folder, cause))?;
        remove_leftovers(folder);
        Ok(Self { folder: folder.to_owned() })
    }

    /// Where frames go that were to become a video.
    ///
    /// ```
    /// use std::path::Path;
    /// let folder = trackwright_project::FrameFolder::path_for(Path::new("a/turn.mp4"));
    /// assert_eq!(folder, Path::new("a/turn-frames"));
    /// ```
    pub fn path_for(video: &Path) -> PathBuf {
        let stem = video.file_stem().unwrap_or_default().to_string_lossy();
        folder_of(video).join(format!("{stem}-frames"))
    }

    /// Writes a frame, counted from 0.
    pub fn frame(&self, index: usize, png: &[u8]) -> Result<(), StoreError> {
        let file = self.folder.join(format!("frame-{:05}.png", index + 1));
        let draft = Draft::write(&file, |out| out.write_all(png));
        draft.and_then(Draft::place).map_err(|cause| write_error(&file, cause))
    }

    /// What makes a video of so many frames where there is an encoder, for a shell.
    pub fn command(&self, video: &Path, frames: usize, frames_per_s: u32) -> String {
        // A percent sign would begin a number.
        let folder = self.folder.to_string_lossy().replace('%', "%%");
        let pattern = Path::new(&folder).join("frame-%05d.png");
        let (pattern, video) = (for_shell(&pattern), for_shell(video));
        // Older frames may be there too.
        format!(
            "{ENCODER} -framerate {frames_per_s} -i {pattern} -frames:v {frames} {ENCODING} {video}"
        )
    }
}

/// A path as a shell reads it.
fn for_shell(path: &Path) -> String {
    let text = path.to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-%+=:@,".contains(c);
    match text.chars().all(is_plain) && !text.starts_with('-') {
        true => text.into_owned(),
        false if text.starts_with('-') => format!("'./{}'", text.replace('\'', r"'\''")),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::tests::files as names;
    use std::os::unix::fs::PermissionsExt;

    const SHAPE: VideoShape = VideoShape { size: [4, 2], frames_per_s: 25 };

    /// A program that a shell runs.
    fn script(folder: &Path, text: &str) -> PathBuf {
        let file = folder.join("encoder");
        fs::write(&file, format!("#!/bin/sh\n{text}\n")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
        file
    }

    fn start(encoder: &Path, video: &Path) -> VideoFile {
        // Another test's new process may hold the script open for writing for a moment.
        for _ in 0..1_000_000 {
            match VideoFile::start(encoder, video, SHAPE) {
                Err(VideoError::Start { cause, .. })
                    if cause.kind() == io::ErrorKind::ExecutableFileBusy =>
                {
                    thread::yield_now();
                }
                started => return started.unwrap().unwrap(),
            }
        }
        panic!("the script stays busy")
    }

    #[test]
    fn every_byte_arrives_in_order() {
        let folder = tempfile::tempdir().unwrap();
        // The last word is the file to write.
        let copy = "for last; do :; done\necho \"$@\" > \"$0.words\"\ncat > \"$last\"";
        let encoder = script(folder.path(), copy);
        let video = folder.path().join("turn.mp4");
        let mut file = start(&encoder, &video);
        let frames: Vec<Vec<u8>> = (0..3_u8).map(|k| vec![k; SHAPE.frame_bytes()]).collect();
        for frame in &frames {
            file.frame(frame).unwrap();
        }
        assert!(!video.exists());
        let short = file.frame(&frames[0][1..]).unwrap_err().to_string();
        assert_eq!(short, "a frame has 31 bytes, expected 32");
        file.finish().unwrap();
        assert_eq!(fs::read(&video).unwrap(), frames.concat());
        assert_eq!(names(folder.path()), ["encoder", "encoder.words", "turn.mp4"]);
        let words = fs::read_to_string(folder.path().join("encoder.words")).unwrap();
        for words_of in ["-pixel_format rgba -video_size 4x2 -framerate 25 -i pipe:0", "libx264"] {
            assert!(words.contains(words_of), "{words}");
        }
    }

    #[test]
    fn a_failed_encoder_is_reported_with_its_last_lines() {
        let folder = tempfile::tempdir().unwrap();
        let fail = "head -c 32 > /dev/null\nfor k in 1 2 3 4 5 6 7; do echo \"reason $k\" >&2; done\nexit 3";
        let encoder = script(folder.path(), fail);
        let video = folder.path().join("turn.mp4");
        fs::write(&video, "an older one").unwrap();
        let mut file = start(&encoder, &video);
        let frame = vec![0; SHAPE.frame_bytes()];
        // The pipe holds some frames before anybody notices.
        let error = (0..100_000).find_map(|_| file.frame(&frame).err());
        let error = error.unwrap_or_else(|| file.finish().unwrap_err());
        let VideoError::Encoder { status, output, .. } = &error else {
            panic!("{error}");
        };
        assert_eq!(status.code(), Some(3));
        assert_eq!(output, "reason 3; reason 4; reason 5; reason 6; reason 7");
        assert_eq!(fs::read_to_string(&video).unwrap(), "an older one");
    }

    #[test]
    fn an_abandoned_video_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        // One process, as an encoder is: nobody is left who could write after it.
        let encoder = script(folder.path(), "for last; do :; done\nexec cat > \"$last\"");
        let mut file = start(&encoder, &folder.path().join("turn.mp4"));
        file.frame(&vec![7; SHAPE.frame_bytes()]).unwrap();
        drop(file);
        assert_eq!(names(folder.path()), ["encoder"]);
    }

    #[test]
    fn odd_sizes_and_missing_encoders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let video = folder.path().join("turn.mp4");
        let missing = folder.path().join("no-such-program");
        assert!(VideoFile::start(&missing, &video, SHAPE).unwrap().is_none());
        assert!(names(folder.path()).is_empty());
        let odd = VideoShape { size: [640, 481], ..SHAPE };
        let error = VideoFile::start(&missing, &video, odd).unwrap_err().to_string();
        assert_eq!(error, "640 x 481 pixels cannot be a video, expected even numbers");
    }

    #[test]
    fn the_command_that_joins_frames_survives_a_shell() {
        let folder = tempfile::tempdir().unwrap();
        let odd = folder.path().join("it's 100% new");
        let frames = FrameFolder::new(&odd).unwrap();
        frames.frame(0, b"first").unwrap();
        frames.frame(11, b"twelfth").unwrap();
        assert_eq!(names(&odd), ["frame-00001.png", "frame-00012.png"]);
        let command = frames.command(Path::new("my turn.mp4"), 12, 30);
        // As a shell takes it apart.
        let words =
            Command::new("sh").args(["-c", &format!("printf '%s\\n' {command}")]).output().unwrap();
        let words = String::from_utf8(words.stdout).unwrap();
        let words: Vec<&str> = words.lines().collect();
        assert_eq!(words[..4], ["ffmpeg", "-framerate", "30", "-i"]);
        let pattern = folder.path().join("it's 100%% new/frame-%05d.png");
        assert_eq!(words[4], pattern.to_string_lossy());
        assert_eq!(words[5..7], ["-frames:v", "12"]);
        assert_eq!(words.last(), Some(&"my turn.mp4"));
    }
}

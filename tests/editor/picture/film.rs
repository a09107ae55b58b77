//! Moving pictures: frames as pictures, and as bytes for an encoder.

use super::render;
use crate::copied::Copied;
use crate::pixels::Picture;
use crate::support::program::{
    Scratch, end_within, fail, processor_seconds, signal, text, trackwright,
};
use crate::support::wire::until;
use std::fs;
use std::path::Path;

const SIZE: &str = "160x120";

/// The frames of a folder, which are numbered from 1 without a gap.
fn numbered(folder: &Path) -> Vec<Picture> {
    let mut files: Vec<_> =
        (fs::read_dir(folder).unwrap()).map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for (index, file) in files.iter().enumerate() {
        let name = format!("frame-{:05}.png", index + 1);
        assert_eq!(file.file_name().unwrap().to_str(), Some(&*name));
    }
    files.iter().map(|file| Picture::read(file)).collect()
}

#[test]
fn a_turntable_starts_at_the_still_picture() {
    let copy = Copied::new("pointer-on-head");
    let folder = text(&copy.path("turn")) + "/";
    let design = text(&copy.design);
    let turn = ["--turntable", "--seconds", "1", "--fps", "4", "--size", SIZE];
    let output =
        trackwright(&[&["render", &design, "-o", &folder], &turn[..]].concat()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let frames = numbered(Path::new(&folder));
    assert_eq!(frames.len(), 4);
    let still = render(&copy, SIZE, &[]);
    assert_eq!(frames[0].differences(&still), 0);
    for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)] {
        let changed = frames[a].differences(&frames[b]);
        assert!(changed > 1000, "{a} and {b}: {changed}");
    }
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert!(
        stdout.starts_with("ffmpeg -framerate 4 -i ") && stdout.contains("-frames:v 4"),
        "{stdout}"
    );
}

#[test]
fn a_motion_ends_at_the_last_trial() {
    let copy = Copied::new("pointer-on-head");
    let folder = text(&copy.path("motion")) + "/";
    let design = text(&copy.design);
    let motion = ["--motion", "--seconds", "1", "--fps", "3", "--size", SIZE];
    let output =
        trackwright(&[&["render", &design, "-o", &folder], &motion[..]].concat()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let frames = numbered(Path::new(&folder));
    assert_eq!(frames.len(), 3);
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        assert!(frames[a].differences(&frames[b]) > 20, "{a} and {b}");
    }
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("poses; --seconds "), "{stderr}");
}

#[cfg(unix)]
#[test]
fn an_encoder_receives_every_byte() {
    use std::os::unix::fs::PermissionsExt;
    let copy = Copied::new("pointer-on-head");
    let scratch = Scratch::new();
    let encoder = scratch.path("ffmpeg");
    let run = |script: &str| {
        fs::write(&encoder, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&encoder, fs::Permissions::from_mode(0o755)).unwrap();
        let (design, video) = (text(&copy.design), scratch.arg("turn.mp4"));
        let arguments = [
            "render",
            &design,
            "-o",
            &video,
            "--turntable",
            "--seconds",
            "1",
            "--fps",
            "3",
            "--size",
            SIZE,
            // The first encoder's file begins as no video does.
            "--overwrite",
        ];
        let path =
            format!("{}:{}", text(encoder.parent().unwrap()), std::env::var("PATH").unwrap());
        trackwright(&arguments).env("PATH", path).output().unwrap()
    };
    let output = run("for last; do :; done\ncat > \"$last\"");
    assert!(output.status.success(), "{output:?}");
    let bytes = fs::read(scratch.path("turn.mp4")).unwrap();
    assert_eq!(bytes.len(), 3 * 160 * 120 * 4);
    let [first, second, _] = [0, 1, 2].map(|k| &bytes[k * 76_800..(k + 1) * 76_800]);
    assert_ne!(first, second);
    let output = run("cat > /dev/null\necho 'no space left' >&2\nexit 1");
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("ffmpeg failed") && stderr.contains("no space left"), "{stderr}");
    // The first video is as it was, and nothing lies beside it.
    assert_eq!(fs::read(scratch.path("turn.mp4")).unwrap(), bytes);
    assert_eq!(fs::read_dir(encoder.parent().unwrap()).unwrap().count(), 2);
}

#[test]
fn impossible_videos_fail_before_painting() {
    let copy = Copied::new("endoscope");
    let design = text(&copy.design);
    for (more, why) in [
        (&["-o", "a.png", "--turntable"][..], "expected a name that ends in .mp4"),
        (&["-o", "a.mp4", "--turntable", "--size", "161x120"], "expected even numbers"),
        (&["-o", "a.mp4"], "expected a name that ends in .png"),
        (&["-o", "a.mp4", "--turntable", "--motion"], "cannot be used with"),
        (&["-o", "a.png", "--seconds", "3"], "--turntable"),
    ] {
        let error = fail(&[&["render", &design], more].concat());
        assert!(error.contains(why), "{more:?}: {error}");
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "long: it paints for a while"]
fn long_report_ends_by_a_signal() {
    use std::os::unix::process::ExitStatusExt;
    use std::time::Duration;
    use trackwright_design::{Edit, MAX_SLIDES, SlideEdit};
    let copy = Copied::new("endoscope");
    let mut world = trackwright_project::open_design(&copy.design).unwrap();
    let slide = world.document.design().slides[0].clone();
    // So many that they take minutes.
    while world.document.design().slides.len() < MAX_SLIDES {
        let slide = Box::new(slide.clone());
        let added = SlideEdit::Add { index: 0, slide };
        world.document.apply(Edit::Slides(added)).unwrap();
    }
    trackwright_project::save(&mut world).unwrap();
    let (design, page) = (text(&copy.design), text(&copy.path("page.html")));
    let mut child = trackwright(&["report", &design, "-o", &page]).spawn().unwrap();
    // The study takes less than a second: pictures are painted.
    until("pictures", || processor_seconds(child.id()) > 15.0);
    signal(&child, "-TERM");
    assert_eq!(end_within(&mut child, Duration::from_secs(60)).signal(), Some(15));
    assert!(!copy.path("page.html").exists());
}

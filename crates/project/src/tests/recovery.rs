//! Sessions that end well, badly, and by being killed.

use super::*;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};
use trackwright_formats::recovery_file::RecoveryOrigin;

/// A folder with a design and all that belongs to it, and a state folder in it.
fn world_and_state() -> (TempDir, PathBuf, World) {
    let folder = tempfile::tempdir().unwrap();
    let mut world = open_builtin("pointer-on-head").unwrap();
    save_as(&mut world, &folder.path().join("a b.design.ron")).unwrap();
    let state = folder.path().join("state/recovery");
    (folder, state, world)
}

/// Changes the design, a body of it, and its view.
fn change(world: &mut World) {
    world.document.apply(Edit::SetName("Other".into())).unwrap();
    let sensor = world.document.design().tool.body.rigid.sensors[0].clone();
    let edit = Edit::AddSensor {
        body: BodyRole::Tool,
        sensor: Sensor {
            name: "third".to_owned(),
            position_in_body: Point3::new(0.1, 1.0 / 3.0, -1e-300),
            ..sensor
        },
    };
    world.document.apply(edit).unwrap();
    let mut view = world.document.view().clone();
    view.layers.ghost = false;
    assert!(world.document.set_view(view));
}

/// Runs only as a process of its own, by the test after it.
#[test]
#[ignore = "started and killed by the test of killed sessions"]
fn a_session_for_killing() {
    let Some(folder) = std::env::var_os("TRACKWRIGHT_TEST_DESIGN") else {
        return;
    };
    let mut world = open_design(Path::new(&folder)).unwrap();
    change(&mut world);
    let mut recovery = Recovery::start(&recovery_folder().unwrap()).unwrap();
    recovery.write(&Snapshot::of(&world)).unwrap();
    writeln!(io::stdout(), "the session is ready").unwrap();
    // Ends with the pipe, should the other test fail before it kills.
    let _ = io::stdin().read(&mut [0]);
}

#[test]
fn a_killed_process_leaves_its_design() {
    let (folder, state, mut expected) = world_and_state();
    let design = folder.path().join("a b.design.ron");
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "tests::recovery::a_session_for_killing"])
        .args(["--ignored", "--nocapture"])
        .env("TRACKWRIGHT_TEST_DESIGN", &design)
        .env(STATE_VARIABLE, folder.path().join("state"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let is_ready = |line: &String| line.contains("the session is ready");
    assert!(lines.map_while(Result::ok).any(|line| is_ready(&line)));
    let before = files(&state);
    assert_eq!(before.len(), 2, "{before:?}");
    assert!(leftovers(&state).unwrap().is_empty(), "it lives");

    child.kill().unwrap();
    child.wait().unwrap();
    let found = leftovers(&state).unwrap();
    let [leftover] = &found[..] else { panic!("{found:?}") };
    assert_eq!(files(&state), before);
    let content = leftover.content().unwrap();
    assert_eq!(content.process, child.id());
    assert_eq!(content.design.name, "Other");
    assert_eq!(content.origin, RecoveryOrigin::File(design.clone()));
    assert!(content.is_dirty && content.written().elapsed().unwrap().as_secs() < 600);

    let mut world = leftover.open().unwrap();
    assert!(world.mesh_problems().is_empty());
    change(&mut expected);
    assert_eq!(world.document.design(), expected.document.design());
    assert_eq!(world.document.view(), expected.document.view());
    assert_eq!(world.environment, expected.environment);
    assert_eq!(world.mesh(BodyRole::Tool), expected.mesh(BodyRole::Tool));
    assert_eq!(world.mesh(BodyRole::Crf), expected.mesh(BodyRole::Crf));
    assert!(world.document.is_dirty());
    let written = save(&mut world).unwrap().written;
    assert_eq!(written, [folder.path().join("pointer.body.ron"), design.clone()]);
    let again = open_design(&design).unwrap();
    assert_eq!(again.document.design(), expected.document.design());
}

#[test]
fn a_leftover_is_offered_once() {
    let (_folder, state, mut world) = world_and_state();
    change(&mut world);
    let mut sessions = [(); 2].map(|()| Recovery::start(&state).unwrap());
    for session in &mut sessions {
        session.write(&Snapshot::of(&world)).unwrap();
    }
    assert!(leftovers(&state).unwrap().is_empty());
    let [first, mut second] = sessions;
    drop(first);
    let held = leftovers(&state).unwrap();
    assert_eq!(held.len(), 1);
    assert!(leftovers(&state).unwrap().is_empty(), "it is held");
    drop(held);
    let mut again = leftovers(&state).unwrap();
    assert_eq!(again.len(), 1, "nobody discarded it");
    again.remove(0).discard().unwrap();
    assert!(leftovers(&state).unwrap().is_empty());
    second.clear().unwrap();
    drop(second);
    assert_eq!(files(&state), [""; 0]);
}

#[test]
fn an_unchanged_snapshot_is_not_written_again() {
    let (folder, state, mut world) = world_and_state();
    let mut recovery = Recovery::start(&state).unwrap();
    assert!(recovery.write(&Snapshot::of(&world)).unwrap());
    assert!(!recovery.write(&Snapshot::of(&world)).unwrap());
    change(&mut world);
    assert!(recovery.write(&Snapshot::of(&world)).unwrap());
    save_as(&mut world, &folder.path().join("new.design.ron")).unwrap();
    assert!(recovery.write(&Snapshot::of(&world)).unwrap());
    let names = files(&state);
    assert_eq!(names.len(), 2, "{names:?}");
    assert!(names.iter().any(|name| name.ends_with(".new.recovery.ron")), "{names:?}");
}

#[test]
fn a_recovered_built_in_design_can_be_saved() {
    let folder = tempfile::tempdir().unwrap();
    let mut world = open_builtin("endoscope").unwrap();
    change(&mut world);
    let leftover = crashed(&folder.path().join("state"), &world);
    let mut recovered = leftover.open().unwrap();
    assert_eq!(recovered.document.design(), world.document.design());
    assert_eq!(recovered.document.origin(), &Origin::BuiltIn("endoscope"));
    assert!(recovered.document.is_dirty() && recovered.mesh(BodyRole::Tool).is_some());
    assert!(matches!(save(&mut recovered), Err(StoreError::ReadOnly("endoscope"))));
    save_as(&mut recovered, &folder.path().join("mine.design.ron")).unwrap();
    assert!(!recovered.document.is_dirty());
}

#[test]
fn a_design_without_its_files_is_recovered() {
    let (folder, state, mut world) = world_and_state();
    change(&mut world);
    let leftover = crashed(&state, &world);
    for name in ["a b.design.ron", "head-crf.body.ron", "pointer.body.ron", "pointer.glb"] {
        fs::remove_file(folder.path().join(name)).unwrap();
    }
    let mut recovered = leftover.open().unwrap();
    assert_eq!(recovered.mesh_problems().len(), 1);
    assert!(recovered.mesh(BodyRole::Tool).is_none() && recovered.mesh(BodyRole::Crf).is_some());
    assert!(recovered.document.is_dirty());
    assert!(recovered.document.history().states.iter().all(|s| !s.is_saved));
    assert_eq!(save(&mut recovered).unwrap().written.len(), 3);
    assert!(!recovered.document.is_dirty());
    // A room that is gone is an error, and the file stays for when it is back.
    fs::remove_file(folder.path().join("operating-table.env.ron")).unwrap();
    let error = leftover.open().unwrap_err().to_string();
    assert!(error.contains("expected an environment"), "{error}");
    assert!(leftover.file().exists());
}

#[test]
fn changes_after_the_crash_are_not_written_over() {
    let (folder, state, mut world) = world_and_state();
    change(&mut world);
    let leftover = crashed(&state, &world);
    let file = folder.path().join("a b.design.ron");
    let theirs = fs::read_to_string(&file).unwrap().replace("order", "ORDER") + "\n";
    fs::write(&file, &theirs).unwrap();
    let mut recovered = leftover.open().unwrap();
    let found = changes(&recovered);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].part, found[0].change), (WatchedPart::Design, FileChange::Content));
    let error = save(&mut recovered).unwrap_err();
    assert!(matches!(error, StoreError::ChangedOnDisk { .. }), "{error}");
    assert_eq!(fs::read_to_string(&file).unwrap(), theirs);
}

#[test]
fn a_broken_recovery_file_stays_until_discarded() {
    let (_folder, state, world) = world_and_state();
    let leftover = crashed(&state, &world);
    let file = leftover.file().to_owned();
    let whole = fs::read(&file).unwrap();
    drop(leftover);
    fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    fs::write(state.join("1-x.old.recovery.ron"), &whole).unwrap();
    let mut found = leftovers(&state).unwrap();
    assert_eq!(found.len(), 2);
    let broken = found.remove(1);
    let message = broken.content().unwrap_err().to_string();
    assert!(message.starts_with(&format!("{}: ", file.display())), "{message}");
    assert!(broken.open().is_err());
    assert!(file.exists());
    broken.discard().unwrap();
    assert!(!file.exists());
    // The one without a lock of its own is as good as any.
    assert!(found[0].open().is_ok());
}

#[test]
fn stale_locks_are_removed() {
    let (_folder, state, world) = world_and_state();
    let leftover = crashed(&state, &world);
    drop(leftover);
    let names = files(&state);
    fs::write(state.join("1-gone.lock"), "").unwrap();
    fs::write(state.join("notes.txt"), "").unwrap();
    let session = Recovery::start(&state).unwrap();
    let other = Recovery::start(&state).unwrap();
    let locks = files(&state).iter().filter(|name| name.ends_with(".lock")).count();
    assert_eq!(locks, 3);
    drop((session, other));
    let mut expected = names;
    expected.push("notes.txt".to_owned());
    expected.sort();
    assert_eq!(files(&state), expected);
    assert!(leftovers(&state.join("nowhere")).unwrap().is_empty());
}

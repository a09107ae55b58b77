//! What a hand waits for in the editor: `cargo bench --bench editor`.
//!
//! Three figures: from an edit to its stamped result with the renderer off; from the start of the
//! program to the first frame that shows tool and figures; frames a second of the built-in scene
//! while it is orbited. The last two run the program in a window of its own (Xvfb, xdotool).

use bevy::prelude::*;
use std::io::{self, BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use trackwright::design::{BodyRole, Edit};
use trackwright::editor::document::DocumentPlugin;
use trackwright::editor::solve::{SolverHandle, SolverPlugin};
use trackwright::editor::state::{EditRequest, OpenWorld, Results, StatePlugin};
use trackwright::store;

/// How long a start or an answer may take before the bench gives up.
const PATIENCE: Duration = Duration::from_secs(60);

/// How long the scene is orbited for the frame rate.
const ORBIT: Duration = Duration::from_secs(5);

fn main() -> io::Result<()> {
    let mut out = io::stdout();
    let mut times = edits_to_results(50);
    writeln!(
        out,
        "{}",
        row("edit to stamped result, renderer off", &mut times)
    )?;
    let mut starts = Vec::new();
    let mut rates = Vec::new();
    for _ in 0..5 {
        let mut window = OpenWindow::start()?;
        starts.push(window.time_to_figures());
        rates.push(window.frames_per_second()?);
    }
    writeln!(
        out,
        "{}",
        row("start to the first frame with figures", &mut starts)
    )?;
    rates.sort_by(f64::total_cmp);
    let of = |k: usize| rates[k];
    writeln!(
        out,
        "frames a second while orbiting: median {:.1}, from {:.1} to {:.1}",
        of(rates.len() / 2),
        of(0),
        of(rates.len() - 1)
    )
}

fn row(what: &str, times: &mut [Duration]) -> String {
    times.sort();
    let ms = |k: usize| times[k].as_secs_f64() * 1e3;
    format!(
        "{what}: median {:.1} ms, from {:.1} to {:.1} ms, {} times",
        ms(times.len() / 2),
        ms(0),
        ms(times.len() - 1),
        times.len()
    )
}

/// Moves a sensor of the built-in design again and again, and waits for each study.
fn edits_to_results(count: usize) -> Vec<Duration> {
    let world = store::open_builtin(store::DEFAULT_BUILTIN).expect("the built-in design");
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, StatePlugin, DocumentPlugin, SolverPlugin))
        .insert_resource(OpenWorld(world));
    let (told, wakes) = channel();
    let solver = &app.world().resource::<SolverHandle>().solver;
    solver.wake_with(Box::new(move || {
        // The last wake finds nobody.
        let _ = told.send(());
    }));
    let wakes = Mutex::new(wakes);
    wait_for_study(&mut app, &wakes);
    (0..count)
        .map(|i| {
            let tool = &app.world().resource::<OpenWorld>().0.document.design().tool;
            let mut sensor = tool.body.rigid.sensors[0].clone();
            sensor.position_in_body.z += if i % 2 == 0 { 1.0 } else { -1.0 };
            let body = BodyRole::Tool;
            let start = Instant::now();
            app.world_mut()
                .write_message(EditRequest::Apply(Edit::SetSensor {
                    body,
                    index: 0,
                    sensor,
                }));
            wait_for_study(&mut app, &wakes);
            start.elapsed()
        })
        .collect()
}

/// Updates until the study that is shown belongs to the document's revision.
fn wait_for_study(app: &mut App, wakes: &Mutex<Receiver<()>>) {
    let start = Instant::now();
    loop {
        app.update();
        let revision = app.world().resource::<OpenWorld>().0.document.revision();
        let study = &app.world().resource::<Results>().study;
        if study.as_ref().is_some_and(|s| s.revision == revision) {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "no result");
        // A wake is only a hint to look again.
        let _ = wakes
            .lock()
            .expect("nobody panics with it")
            .recv_timeout(PATIENCE);
    }
}

/// The program in a window on a display of its own.
struct OpenWindow {
    xvfb: Child,
    program: Child,
    lines: Receiver<(Instant, String)>,
    display: String,
    started: Instant,
}

impl OpenWindow {
    fn start() -> io::Result<Self> {
        let mut xvfb = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1440x900x24",
                "-nolisten",
                "tcp",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let mut number = String::new();
        let stdout = xvfb
            .stdout
            .take()
            .ok_or_else(|| io::Error::other("no display"))?;
        BufReader::new(stdout).read_line(&mut number)?;
        let display = format!(":{}", number.trim());
        let started = Instant::now();
        let mut program = Command::new(env!("CARGO_BIN_EXE_trackwright"))
            .arg("--explain")
            .env("DISPLAY", &display)
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()?;
        let stderr = program
            .stderr
            .take()
            .ok_or_else(|| io::Error::other("no lines"))?;
        let (tell, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                if tell.send((Instant::now(), line)).is_err() {
                    return;
                }
            }
        });
        Ok(Self {
            xvfb,
            program,
            lines,
            display,
            started,
        })
    }

    /// Until the end of the first frame after the first figures: by then they are on the screen.
    fn time_to_figures(&mut self) -> Duration {
        let mut has_figures = false;
        loop {
            let (at, line) = self
                .lines
                .recv_timeout(PATIENCE)
                .expect("the program goes on");
            if line.starts_with("result ") {
                has_figures = true;
            } else if has_figures && line.starts_with("frame ") {
                return at - self.started;
            }
        }
    }

    /// Orbits with the middle button and counts frames.
    fn frames_per_second(&mut self) -> io::Result<f64> {
        let end = Instant::now() + ORBIT;
        self.xdotool(&["mousemove", "700", "450", "mousedown", "2"])?;
        let mut frames = 0;
        while Instant::now() < end {
            self.xdotool(&["mousemove_relative", "--", "3", "1"])?;
            frames += self
                .lines
                .try_iter()
                .filter(|(_, line)| line.starts_with("frame "))
                .count();
        }
        self.xdotool(&["mouseup", "2"])?;
        Ok(frames as f64 / ORBIT.as_secs_f64())
    }

    fn xdotool(&self, arguments: &[&str]) -> io::Result<()> {
        Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.display)
            .status()
            .map(|_| ())
    }
}

impl Drop for OpenWindow {
    fn drop(&mut self) {
        for child in [&mut self.program, &mut self.xvfb] {
            // Gone already is as good.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

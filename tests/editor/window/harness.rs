//! The program in a window on a display of its own, what it prints with `--explain`, and a person's
//! hand and eye.

use super::screen::Screen;
use crate::pixels::Picture;
use crate::support::program::{succeed, text, trackwright};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};
use trackwright_simulation::{Metric, Verdict};

/// Longest that anything is waited for; on a busy machine software Vulkan takes seconds a frame.
const PATIENCE: Duration = Duration::from_secs(120);

/// So long without a line and with nothing left to compute, the window is at rest. Frames follow
/// each other within this on a machine that paints two a second.
const REST: Duration = Duration::from_millis(600);

/// Windows share the processors and a person has one pair of hands: one after the other, or those
/// of one test.
static TURN: Mutex<()> = Mutex::new(());

/// A test's turn to have windows.
pub struct Turn(#[expect(dead_code, reason = "held, not read")] MutexGuard<'static, ()>);

impl Turn {
    pub fn wait() -> Self {
        // A test that failed with a window open decides nothing about the next one.
        Self(TURN.lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }
}

/// A running editor. Ends with its test.
pub struct Window {
    program: Child,
    lines: Receiver<String>,
    printed: Vec<String>,
    pub screen: Screen,
    /// Recovery files and the like are this window's own.
    _state: Option<tempfile::TempDir>,
    id: String,
    /// Clicks since the start, and commands that were found by their names.
    clicks: usize,
    /// `None` where the test keeps its turn itself.
    _turn: Option<Turn>,
}

/// A figure as the result panel shows it, with its unit.
pub type Figure = (String, String);

impl Window {
    /// Opens a design and waits until everything is computed and drawn.
    pub fn open(design: &Path) -> Self {
        let state = tempfile::tempdir().unwrap();
        let mut window = Self::open_with_state(design, state.path());
        window._state = Some(state);
        window
    }

    /// Opens a design in a session that finds what others left in a state folder.
    pub fn open_with_state(design: &Path, state: &Path) -> Self {
        let turn = Turn::wait();
        let mut window = Self::open_beside(&turn, design, state);
        window._turn = Some(turn);
        window
    }

    /// The same, beside other windows of a test whose turn it is.
    pub fn open_beside(_: &Turn, design: &Path, state: &Path) -> Self {
        Self::start(&["--explain"], design, state)
    }

    /// The same, in a window whose controls can be found by their names.
    pub fn open_with_controls(_: &Turn, design: &Path, state: &Path) -> Self {
        Self::start(&["--explain", "--controls"], design, state)
    }

    fn start(options: &[&str], design: &Path, state: &Path) -> Self {
        let screen = Screen::start();
        let mut program = trackwright(&[options, &[&text(design)]].concat())
            .env("DISPLAY", &screen.name)
            .env(trackwright_project::STATE_VARIABLE, state)
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let stderr = BufReader::new(program.stderr.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in stderr.lines().map_while(Result::ok) {
                // The test has ended.
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        let mut window = Self {
            program,
            lines,
            printed: Vec::new(),
            screen,
            _state: None,
            id: String::new(),
            clicks: 0,
            _turn: None,
        };
        window.wait_for("its first figures", |printed| {
            printed.iter().any(|line| line.starts_with("result "))
        });
        let named = ["search", "--sync", "--onlyvisible", "--limit", "1", "--name", "trackwright$"];
        window.id = window.xdotool(&named);
        // There is no window manager that would give it the keys.
        window.xdotool(&["windowfocus", &window.id]);
        window
            .poll("the keyboard", |window| window.screen.xdotool(&["getwindowfocus"]) == window.id);
        window.settle();
        window
    }

    pub fn xdotool(&self, args: &[&str]) -> String {
        self.screen.xdotool(args)
    }

    /// The title as the window system has it.
    pub fn title(&self) -> String {
        self.xdotool(&["getwindowname", &self.id])
    }

    pub fn pid(&self) -> u32 {
        self.program.id()
    }

    /// Moves the pointer to a place in the window and lets the window see it.
    pub fn point_at(&mut self, [x, y]: [f64; 2]) {
        self.xdotool(&["mousemove", &format!("{x:.0}"), &format!("{y:.0}")]);
        self.settle();
    }

    pub fn click(&mut self, at: [f64; 2]) {
        self.point_at(at);
        // A button that is held is no click: no pause between its press and its release.
        self.xdotool(&["click", "1"]);
        self.clicks += 1;
        self.settle();
    }

    pub fn clicks(&self) -> usize {
        self.clicks
    }

    pub fn press_button(&mut self) {
        self.xdotool(&["mousedown", "1"]);
        self.settle();
    }

    pub fn release_button(&mut self) {
        self.xdotool(&["mouseup", "1"]);
        self.settle();
    }

    /// Moves the pointer so many pixels along a direction, a few at a time as a hand does.
    pub fn move_along(&mut self, direction: [f64; 2], pixels: u32) {
        const STEPS: u32 = 10;
        let mut done = [0.0; 2];
        for step in 1..=STEPS {
            let way = f64::from(pixels * step) / f64::from(STEPS);
            let to = direction.map(|d| (d * way).round());
            let [dx, dy] = [0, 1].map(|k| format!("{:.0}", to[k] - done[k]));
            self.xdotool(&["mousemove_relative", "--", &dx, &dy]);
            done = to;
        }
        self.settle();
    }

    /// A key or a combination such as `ctrl+z`. As with a hand, modifiers are down before the
    /// key and until after it.
    pub fn key(&mut self, combination: &str) {
        let mut modifiers: Vec<&str> = combination.split('+').collect();
        let key = modifiers.pop().expect("a key");
        self.hold("keydown", &modifiers);
        self.xdotool(&["key", key]);
        self.settle();
        modifiers.reverse();
        self.hold("keyup", &modifiers);
    }

    /// The middle of a control that is shown with this name; the last of several. Needs
    /// [`Self::open_with_controls`].
    #[track_caller]
    pub fn control(&self, name: &str) -> [f64; 2] {
        let found = controls(&self.printed).rev().find(|control| control.name == name);
        let found = found.unwrap_or_else(|| panic!("no control {name}; {}", self.newest()));
        [0, 1].map(|k| found.corner[k] + found.size[k] / 2.0)
    }

    /// The texts to the right of a label, from left to right.
    #[track_caller]
    pub fn row(&self, label: &str) -> Vec<String> {
        let middle = |control: &Control| control.corner[1] + control.size[1] / 2.0;
        let own = controls(&self.printed).find(|control| control.name == label);
        let own = own.unwrap_or_else(|| panic!("no {label}; {}", self.newest()));
        let is_beside = |control: &Control| {
            control.corner[0] > own.corner[0] && (middle(control) - middle(&own)).abs() < 3.0
        };
        let mut row: Vec<_> = controls(&self.printed).filter(is_beside).collect();
        row.sort_by(|a, b| a.corner[0].total_cmp(&b.corner[0]));
        row.into_iter().map(|control| control.name.to_owned()).collect()
    }

    /// The whole name of what is shown with these words in it, with plain spaces.
    #[track_caller]
    pub fn name_with(&self, words: &str) -> String {
        let found = controls(&self.printed).find(|control| control.name.contains(words));
        let found = found.unwrap_or_else(|| panic!("nothing with {words}; {}", self.newest()));
        found.name.replace('\u{2009}', " ")
    }

    /// Waits until a control of this name is shown.
    #[track_caller]
    pub fn wait_for_control(&mut self, name: &str) {
        self.wait_for(name, |printed| controls(printed).any(|control| control.name == name));
        self.settle();
    }

    /// Clicks a control.
    #[track_caller]
    pub fn click_control(&mut self, name: &str) {
        self.click(self.control(name));
    }

    /// Finds a command by its name, as a person would who does not know its key.
    pub fn run_command(&mut self, name: &str) {
        self.key("ctrl+shift+p");
        self.write(name);
        self.key("Return");
        self.clicks += 1;
    }

    /// Presses modifiers or lets go of them.
    fn hold(&mut self, action: &str, modifiers: &[&str]) {
        if !modifiers.is_empty() {
            self.xdotool(&[&[action], modifiers].concat());
            self.settle();
        }
    }

    pub fn write(&mut self, text: &str) {
        self.xdotool(&["type", "--delay", "30", text]);
        self.settle();
    }

    /// Quits as a person does, and waits until the program has ended well.
    pub fn close(mut self) {
        self.xdotool(&["keydown", "ctrl"]);
        self.settle();
        // Nobody receives the key's release.
        self.xdotool(&["key", "q"]);
        let status = self.program.wait().unwrap();
        assert!(status.success(), "{status:?}; {}", self.newest());
    }

    /// What is on the screen once it has stopped changing.
    pub fn picture(&mut self) -> Picture {
        self.settle();
        let mut last = self.screen.picture();
        let start = Instant::now();
        // Frames are reported when they are made; the driver presents them a little later.
        while start.elapsed() < PATIENCE {
            self.listen(REST);
            let now = self.screen.picture();
            if now == last {
                return now;
            }
            last = now;
        }
        panic!("the picture never stops changing");
    }

    /// The value of the newest line that begins with a word: `last("dialog")`.
    pub fn last(&self, word: &str) -> Option<&str> {
        last_of(&self.printed, word)
    }

    /// A field of the newest line about the document, such as `dirty` or `undo`.
    #[track_caller]
    pub fn document(&self, field: &str) -> &str {
        field_of(self.last("document").expect("a document"), field)
    }

    /// Whether the document becomes another than the one of a revision within so long, with
    /// everything of it shown.
    #[track_caller]
    pub fn is_edited(&mut self, before: &str, within: Duration) -> bool {
        let start = Instant::now();
        while self.document("revision") == before {
            if start.elapsed() > within {
                return false;
            }
            self.listen(Duration::from_millis(50));
        }
        self.settle();
        true
    }

    /// The newest figures, in order.
    pub fn figures(&self) -> Vec<Figure> {
        let newest = revision_of(&self.printed, "result").expect("figures");
        let newest = format!("result revision={newest} ");
        let rows: Vec<Figure> = self
            .printed
            .iter()
            .filter_map(|line| line.strip_prefix(&newest))
            .filter_map(|row| row.rsplit_once('='))
            // The command line states once why there is no interval.
            .map(|(label, value)| (label, value.replace(" (no interval)", "")))
            .map(|(label, value)| (label.to_owned(), value.replace(' ', "")))
            .collect();
        // Another document that was opened counts its revisions anew.
        let first = rows.first().map(|(label, _)| label.clone());
        let begin = rows.iter().rposition(|(label, _)| Some(label) == first.as_ref());
        rows[begin.unwrap_or(0)..].to_vec()
    }

    /// A counter of the work done since the start.
    #[track_caller]
    pub fn counter(&self, name: &str) -> u64 {
        let counters = self.last("counters").expect("counters");
        field_of(counters, name).parse().expect("a count")
    }

    /// Waits until the figures of the document as it is now are shown and nothing is drawn any
    /// more.
    #[track_caller]
    pub fn settle(&mut self) {
        let start = Instant::now();
        loop {
            let is_quiet = self.listen(REST) == 0;
            if is_quiet && is_solved(&self.printed) {
                return;
            }
            assert!(start.elapsed() < PATIENCE, "never at rest; {}", self.newest());
        }
    }

    /// Waits until what was printed so far is as wanted.
    #[track_caller]
    pub fn wait_for(&mut self, what: &str, is_there: impl Fn(&[String]) -> bool) {
        self.poll(what, |window| is_there(&window.printed));
    }

    #[track_caller]
    fn poll(&mut self, what: &str, mut is_there: impl FnMut(&Self) -> bool) {
        let start = Instant::now();
        while !is_there(self) {
            let ended = self.program.try_wait().unwrap();
            assert!(ended.is_none(), "ended before {what}: {ended:?}; {}", self.newest());
            assert!(start.elapsed() < PATIENCE, "never {what}; {}", self.newest());
            self.listen(Duration::from_millis(50));
        }
    }

    /// Receives the lines that come until none came for so long; how many there were.
    pub fn listen(&mut self, pause: Duration) -> usize {
        let before = self.printed.len();
        loop {
            match self.lines.recv_timeout(pause) {
                Ok(line) => self.printed.push(line),
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => {
                    panic!("the program has ended; {}", self.newest())
                }
            }
        }
        self.printed.len() - before
    }

    /// The first line within so long, if there is one.
    pub fn next_line(&mut self, within: Duration) -> Option<String> {
        let line = self.lines.recv_timeout(within).ok()?;
        self.printed.push(line.clone());
        Some(line)
    }

    fn newest(&self) -> String {
        let from = self.printed.len().saturating_sub(12);
        format!("the last lines:\n{}", self.printed[from..].join("\n"))
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        // Gone already is as good.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// What is shown with a name, in pixels of the window.
struct Control<'a> {
    name: &'a str,
    corner: [f64; 2],
    size: [f64; 2],
}

/// What the newest list of controls names.
fn controls(printed: &[String]) -> impl DoubleEndedIterator<Item = Control<'_>> {
    let from = printed.iter().rposition(|line| line == "controls").unwrap_or(0);
    printed[from..].iter().filter_map(|line| control_of(line))
}

/// From `control X Y WIDTH HEIGHT ROLE NAME`.
fn control_of(line: &str) -> Option<Control<'_>> {
    let mut words = line.strip_prefix("control ")?.splitn(6, ' ');
    let mut number = || words.next()?.parse::<f64>().ok();
    let (corner, size) = ([number()?, number()?], [number()?, number()?]);
    Some(Control { name: words.nth(1)?, corner, size })
}

fn last_of<'a>(printed: &'a [String], word: &str) -> Option<&'a str> {
    printed.iter().rev().find_map(|line| line.strip_prefix(word)?.strip_prefix(' '))
}

/// `revision=3 dirty=true undo=Move sensor shaft redo=none`: a value reaches to the next name.
#[track_caller]
fn field_of<'a>(line: &'a str, field: &str) -> &'a str {
    let start = line.find(&format!("{field}=")).expect("the field") + field.len() + 1;
    let rest = &line[start..];
    let Some(equals) = rest.find('=') else {
        return rest;
    };
    rest[..equals].rsplit_once(' ').map_or(rest, |(value, _)| value)
}

/// Whether the newest figures are those of the newest document.
fn is_solved(printed: &[String]) -> bool {
    let figures = revision_of(printed, "result");
    figures.is_some() && figures == revision_of(printed, "document")
}

fn revision_of<'a>(printed: &'a [String], word: &str) -> Option<&'a str> {
    last_of(printed, word)?.strip_prefix("revision=")?.split(' ').next()
}

/// What `simulate --mode motion` prints as text for a design, as rows of the result panel.
pub fn simulated(design: &Path) -> Vec<Figure> {
    let out = succeed(&["simulate", &text(design), "--mode", "motion"]);
    let each = Metric::bounded().filter_map(|metric| {
        let row =
            out.lines().find_map(|line| line.strip_prefix(metric.label())?.strip_prefix("  "));
        Some((metric.label().to_owned(), row?.replace(' ', "")))
    });
    let of_bounds = out.lines().filter_map(|line| line.strip_prefix("requirement "));
    let verdicts = of_bounds.filter_map(|line| {
        let (_, words) = line.split_once(": ")?;
        [Verdict::Met, Verdict::Missed, Verdict::CannotTell]
            .into_iter()
            .find(|verdict| words.starts_with(verdict.label()))
    });
    let verdict = Verdict::of_all(verdicts);
    each.chain(verdict.map(|v| ("requirement".to_owned(), v.label().replace(' ', "")))).collect()
}

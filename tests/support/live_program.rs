//! `trackwright live` as a person runs it, beside a test.

use super::program::{signal, trackwright};
use super::wire::PATIENCE;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

/// The program, running, and its notes.
pub struct Live {
    pub child: Child,
    notes: Receiver<String>,
}

/// A machine that does other things is not taken for a tool that is late.
pub const PATIENT: [&str; 5] = ["live", "--format", "json", "--stale-ms", "20000"];

impl Live {
    pub fn start(args: &[&str]) -> Self {
        Self::run(trackwright(&[&PATIENT[..], args].concat()))
    }

    /// With files of a few kilobytes and no more: the system refuses what comes after them.
    pub fn start_on_a_small_disk(args: &[&str]) -> Self {
        Self::start_after("trap '' XFSZ; ulimit -f 4", args)
    }

    /// Behind commands of a shell that set limits.
    pub fn start_after(limits: &str, args: &[&str]) -> Self {
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("{limits}; exec \"$0\" \"$@\"")]);
        shell.arg(env!("CARGO_BIN_EXE_trackwright"));
        shell.args(PATIENT).args(args);
        Self::run(shell)
    }

    pub fn run(mut program: Command) -> Self {
        let mut child = program.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let notes = lines_of(child.stderr.take().unwrap());
        Self { child, notes }
    }

    /// The first note with a text in it.
    #[track_caller]
    pub fn wait_for_note(&self, text: &str) -> String {
        let end = Instant::now() + PATIENCE;
        let mut others = Vec::new();
        loop {
            let left = end.saturating_duration_since(Instant::now());
            match self.notes.recv_timeout(left) {
                Ok(note) if note.contains(text) => return note,
                Ok(note) => others.push(note),
                Err(_) => panic!("{text:?} is not in {others:?}"),
            }
        }
    }

    /// As Ctrl+C does.
    pub fn interrupt(self) -> Value {
        self.interrupt_printing().1
    }

    /// The same, with the text that is printed.
    pub fn interrupt_printing(mut self) -> (String, Value) {
        signal(&self.child, "-INT");
        let mut out = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        assert!(self.child.wait().unwrap().success());
        let end = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}"));
        (out, end)
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // Gone already is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The lines of a stream, as they come.
pub fn lines_of(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

/// Where the program serves.
pub fn address_in(note: &str) -> SocketAddr {
    let address = note.split([' ', ',']).nth(2).unwrap();
    address.trim_end_matches(':').parse().unwrap()
}

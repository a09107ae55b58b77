//! What a hand waits for in the editor: `cargo bench --bench editor`.
//!
//! Runs `trackwright --measure` on a display of its own (Xvfb) where there is none, several times,
//! since a machine is never quite quiet.

use std::io::{self, BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};

const TIMES: usize = 3;

fn main() -> io::Result<()> {
    let display = Display::start()?;
    for _ in 0..TIMES {
        let out = Command::new(env!("CARGO_BIN_EXE_trackwright"))
            .arg("--measure")
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .output()?;
        io::stdout().write_all(&out.stdout)?;
        io::stderr().write_all(&out.stderr)?;
        if !out.status.success() {
            return Err(io::Error::other("nothing was measured"));
        }
    }
    Ok(())
}

/// A display without a window manager, as large as the window that is measured.
struct Display {
    xvfb: Child,
    name: String,
}

impl Display {
    fn start() -> io::Result<Self> {
        let screen = ["-displayfd", "1", "-screen", "0", "1280x720x24"];
        let mut xvfb = Command::new("Xvfb")
            .args(screen)
            .args(["-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let stdout = xvfb.stdout.take().ok_or_else(|| io::Error::other("no display"))?;
        let mut number = String::new();
        BufReader::new(stdout).read_line(&mut number)?;
        Ok(Self { xvfb, name: format!(":{}", number.trim()) })
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // Gone already is as good.
        let _ = self.xvfb.kill();
        let _ = self.xvfb.wait();
    }
}

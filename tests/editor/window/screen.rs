//! A display of a test's own, and what stands on it.

use crate::pixels::Picture;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConnectionExt, ImageFormat};
use x11rb::rust_connection::RustConnection;

/// Width and height of the display: the window's first size.
pub const SIZE: [u16; 2] = [1440, 900];

/// An X server without a screen; it ends with its test.
pub struct Screen {
    server: Child,
    connection: RustConnection,
    root: u32,
    /// As `DISPLAY` names it.
    pub name: String,
}

impl Screen {
    pub fn start() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-noreset", "-nolisten", "tcp", "-screen", "0"])
            .arg(format!("{}x{}x24", SIZE[0], SIZE[1]))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb runs (Debian package xvfb)");
        // The server chooses a free number and reports it once it listens.
        let mut number = String::new();
        let stdout = server.stdout.take().expect("a pipe");
        BufReader::new(stdout).read_line(&mut number).expect("the display's number from Xvfb");
        let name = format!(":{}", number.trim());
        let (connection, index) = x11rb::connect(Some(&name)).expect("Xvfb answers");
        let root = connection.setup().roots[index].root;
        Self { server, connection, root, name }
    }

    /// What is on the screen now.
    pub fn picture(&self) -> Picture {
        let [width, height] = SIZE;
        let image = self
            .connection
            .get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, !0)
            .expect("the server is there")
            .reply()
            .expect("the screen can be read");
        // 24 bits deep: blue, green, red, and a byte that means nothing.
        let pixels = image.data.chunks_exact(4).map(|p| [p[2], p[1], p[0]]).collect();
        Picture::new(usize::from(width), usize::from(height), pixels)
    }

    /// Moves the pointer, presses buttons and keys: the only input that tests have.
    #[track_caller]
    pub fn xdotool(&self, args: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(args)
            .env("DISPLAY", &self.name)
            .output()
            .expect("xdotool runs (Debian package xdotool)");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "xdotool {args:?}: {error}");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // Gone already is as good.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

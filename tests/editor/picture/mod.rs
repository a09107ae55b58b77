//! Pictures made by `render`, read pixel by pixel.

mod film;
mod layers;
mod panels;
mod slice;

use super::copied::Copied;
use super::pixels::Picture;
use crate::support::program::{succeed, text};

/// Renders a copied design with more arguments.
#[track_caller]
fn render(copy: &Copied, size: &str, more: &[&str]) -> Picture {
    Picture::read(&render_file(copy, size, more))
}

/// The file that `render` writes.
#[track_caller]
fn render_file(copy: &Copied, size: &str, more: &[&str]) -> std::path::PathBuf {
    let picture = copy.path("picture.png");
    let (design, output) = (text(&copy.design), text(&picture));
    succeed(&[&["render", &design, "-o", &output, "--size", size], more].concat());
    picture
}

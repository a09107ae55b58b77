//! An SVG picture in the making: shapes and text at pixels, y down.

use crate::palette::Rgb;
use maud::{Markup, html};

/// Which point of a text is at its place: horizontally, and how far its baseline is below.
#[derive(Clone, Copy)]
pub struct Anchor(&'static str, &'static str);

impl Anchor {
    pub const TOP: Self = Self("middle", "0.76em");
    pub const TOP_LEFT: Self = Self("start", "0.76em");
    pub const LEFT: Self = Self("start", "0.5ex");
    pub const MIDDLE: Self = Self("middle", "0.5ex");
    pub const RIGHT: Self = Self("end", "0.5ex");
}

/// A picture of a size in pixels.
pub struct Svg {
    size: (u32, u32),
    shapes: Vec<Markup>,
}

impl Svg {
    /// An empty picture.
    pub fn new(size: (u32, u32)) -> Self {
        Self { size, shapes: Vec::new() }
    }

    /// The document.
    pub fn finish(self) -> String {
        let (width, height) = self.size;
        let document = html! {
            svg width=(width) height=(height) viewBox=(format!("0 0 {width} {height}"))
                xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" {
                @for shape in &self.shapes { (shape) "\n" }
            }
        };
        document.into_string()
    }

    /// A line through points; through fewer than two there is none.
    pub fn line(&mut self, points: &[(i32, i32)], color: Rgb, width: u32) {
        if points.len() > 1 {
            self.shapes.push(html! {
                polyline fill="none" stroke=(color) stroke-width=(width) points=(listed(points)) {}
            });
        }
    }

    /// A filled polygon.
    pub fn polygon(&mut self, corners: &[(i32, i32)], color: Rgb) {
        self.shapes.push(html! { polygon fill=(color) points=(listed(corners)) {} });
    }

    /// A filled rectangle between two corners.
    pub fn rectangle(
        &mut self,
        (left, top): (i32, i32),
        (right, bottom): (i32, i32),
        color: Rgb,
        opacity: f64,
    ) {
        let (width, height) = ((right - left).max(0), (bottom - top).max(0));
        self.shapes.push(html! {
            rect x=(left) y=(top) width=(width) height=(height) opacity=(opacity) fill=(color) {}
        });
    }

    /// A filled circle.
    pub fn disc(&mut self, (x, y): (i32, i32), radius: i32, color: Rgb) {
        self.shapes.push(html! { circle cx=(x) cy=(y) r=(radius) fill=(color) {} });
    }

    /// A circle.
    pub fn ring(&mut self, (x, y): (i32, i32), radius: i32, color: Rgb, width: u32) {
        self.shapes.push(html! {
            circle cx=(x) cy=(y) r=(radius) fill="none" stroke=(color) stroke-width=(width) {}
        });
    }

    /// Text at a place.
    pub fn text(&mut self, (x, y): (i32, i32), words: &str, size: f64, color: Rgb, at: Anchor) {
        let Anchor(across, below) = at;
        self.shapes.push(html! {
            text x=(x) y=(y) dy=(below) text-anchor=(across) font-size=(size) fill=(color) {
                (words)
            }
        });
    }

    /// A heading: bold, its upper left corner at a place.
    pub fn bold_text(&mut self, (x, y): (i32, i32), words: &str, size: f64, color: Rgb) {
        self.shapes.push(html! {
            text x=(x) y=(y) dy="0.76em" font-size=(size) font-weight="bold" fill=(color) {
                (words)
            }
        });
    }

    /// Text that runs upwards, its middle at a place.
    pub fn upward_text(&mut self, (x, y): (i32, i32), words: &str, size: f64, color: Rgb) {
        self.shapes.push(html! {
            text x=(x) y=(y) dy="0.76em" text-anchor="middle" font-size=(size) fill=(color)
                transform=(format!("rotate(270, {x}, {y})")) { (words) }
        });
    }
}

fn listed(points: &[(i32, i32)]) -> String {
    points.iter().map(|(x, y)| format!("{x},{y}")).collect::<Vec<_>>().join(" ")
}

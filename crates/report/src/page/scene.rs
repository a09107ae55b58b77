//! The set-up in three dimensions: a drawing that stands still, and where there is a scene and a
//! browser that can, the same scene turned by the hand.

use super::{Report, extras};
use crate::drawing::{SetUp, setup_drawing};
use data_encoding::BASE64;
use maud::{Markup, PreEscaped, html};
use sha2::{Digest, Sha256};
use trackwright_design::BodyRole;

/// The library that draws: see `assets/viewer/README.md` for its version and where it is from.
const LIBRARY: &str = include_str!("../../../../assets/viewer/three.min.js");
const LIBRARY_LICENCE: &str = include_str!("../../../../assets/viewer/three-LICENSE.txt");

/// What uses it for this page.
const VIEWER: &str = include_str!("../../../../assets/viewer/viewer.js");

pub struct Scene<'a> {
    report: &'a Report<'a>,
    glb: Option<&'a [u8]>,
}

impl<'a> Scene<'a> {
    /// The scene of a report.
    pub fn new(report: &'a Report<'a>) -> Self {
        Self { report, glb: report.extras.scene_glb.as_deref() }
    }

    /// The view that turns, or its drawing.
    pub fn section(&self) -> Markup {
        let world = self.report.world;
        let generator = trackwright_project::generator_mesh().ok();
        let drawing = setup_drawing(&SetUp {
            design: world.document.design(),
            environment: &world.environment,
            tool_mesh: self.report.mesh(BodyRole::Tool),
            crf_mesh: self.report.mesh(BodyRole::Crf),
            generator_mesh: generator.as_ref(),
        });
        html! {
            section id="setup" {
                h2 { "Where everything is" }
                figure class="wide" id="scene" {
                    div class="still" { (drawing) }
                    @if self.glb.is_some() {
                        // Filled by the viewer: what turns, and for paper how it was last seen.
                        canvas tabindex="0" hidden aria-label="The scene in three dimensions; arrow keys turn it" {}
                        img class="seen" alt="The scene as it was last turned" hidden;
                    }
                    figcaption {
                        @if let Some(legend) = &self.report.extras.scene_legend {
                            div class="scene-legend" hidden { (extras::legend(legend)) }
                        }
                        @if self.glb.is_some() {
                            p class="still-words" { "The scene stands still here: it turns in a browser that runs scripts and draws in three dimensions (WebGL)." }
                            p class="turning-words" hidden { "Drag to turn, scroll to come nearer, drag with the right button to shift; double click for the first view." }
                        }
                        p class="note" {
                            "The field generator is below, its axis z points down; lines are the "
                            @match &world.environment.volume {
                                Some(volume) => { "tracker's volume (" (volume.name()) ")." },
                                None => "box in which the room was measured.",
                            }
                        }
                    }
                }
            }
        }
    }

    /// The scene's bytes and what shows them, at the page's end.
    pub fn scripts(&self) -> Markup {
        html! {
            @if let Some(glb) = self.glb {
                script type="application/octet-stream" id="scene-glb" { (PreEscaped(BASE64.encode(glb))) }
                @for script in [LIBRARY, VIEWER] { script { (PreEscaped(script)) } }
            }
        }
    }

    /// What the page may do: no script but its own, nothing fetched from anywhere.
    pub fn policy(&self) -> String {
        let scripts = match self.glb {
            None => "'none'".to_owned(),
            Some(_) => [LIBRARY, VIEWER].map(hash_source).join(" "),
        };
        format!(
            "default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; img-src data:; \
             base-uri 'none'; form-action 'none'"
        )
    }

    /// The licence of the embedded viewer.
    pub fn licence(&self) -> Markup {
        html! {
            @if self.glb.is_some() {
                details {
                    summary { "The view that turns is drawn by three.js, under the MIT licence" }
                    pre { (LIBRARY_LICENCE) }
                }
            }
        }
    }
}

/// A script by the hash of what stands between its tags.
fn hash_source(script: &str) -> String {
    format!("'sha256-{}'", BASE64.encode(&Sha256::digest(script)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn embedded_scripts_are_whole_and_fetch_nothing() {
        for script in [LIBRARY, VIEWER] {
            let lower = script.to_ascii_lowercase();
            assert!(!lower.contains("</script") && !lower.contains("<!--"));
            let mut places = lower.match_indices("://").map(|(at, _)| &lower[at..]);
            // The name of the XHTML namespace is no place.
            assert!(places.all(|place| place.starts_with("://www.w3.org/1999/xhtml")));
        }
    }
}

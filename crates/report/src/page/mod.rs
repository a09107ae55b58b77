//! The report of a design: one HTML page that holds all it shows, opens in any browser without a
//! network, and prints.
//!
//! All text goes through `maud`, which escapes it. The page's own policy (a `meta` of
//! Content-Security-Policy) lets no script run but the embedded ones, known by their hashes, and
//! lets nothing be fetched.

mod assumptions;
mod decisions;
mod extras;
mod figures;
mod geometry;
mod scene;
mod style;
pub(crate) use style::css;
mod summary;
mod workshop;

use super::words::{PlainWords, plain_words};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use trackwright_design::BodyRole;
use trackwright_formats::printable::printable;
use trackwright_formats::printable::printable_lines;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_project::World;
use trackwright_simulation::figures::capitalised;
use trackwright_simulation::{
    CancelToken, ErrorSources, Mode, Profile, Scenario, Study, StudyError, Verdict,
    coil_statements, error_sources, study_profiled,
};

pub use extras::{SceneLegend, Slide, SlideError, TableSection};
pub use workshop::workshop_section;

/// Everything that a page is made from.
///
/// ```
/// use trackwright_project::{DEFAULT_BUILTIN, open_builtin_without_meshes};
/// use trackwright_report::page::{Extras, Report, ReportedStudy};
/// use trackwright_simulation::{CancelToken, Mode};
/// let world = open_builtin_without_meshes(DEFAULT_BUILTIN)?;
/// let study = ReportedStudy::run(&world, Mode::Single, &CancelToken::default())?;
/// let html = Report { world: &world, study: &study, extras: Extras::default() }.to_html();
/// assert!(html.contains("<h2>Figures</h2>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Report<'a> {
    pub world: &'a World,
    pub study: &'a ReportedStudy,
    pub extras: Extras,
}

/// A study, run for a report.
#[derive(Clone, Debug)]
pub struct ReportedStudy {
    pub scenario: Scenario,
    pub mode: Mode,
    pub study: Study,
    /// `None` of a study of more trials than are kept one by one.
    pub profile: Option<Profile>,
    /// Where the error comes from, where it misses the requirement.
    pub sources: Option<ErrorSources>,
    pub words: PlainWords,
}

/// What a page shows beside the study, each only where it is given.
#[derive(Clone, Debug, Default)]
pub struct Extras {
    /// Name of the design's file, without its folder.
    pub design_file: Option<String>,
    /// Name of the file of poses, for input data.
    pub input_file: Option<String>,
    /// When the report was made, `2026-11-22`.
    pub date: Option<String>,
    /// Saved views, as pictures.
    pub slides: Vec<Slide>,
    /// The scene as binary glTF, with the colours of the editor.
    pub scene_glb: Option<Vec<u8>>,
    /// What is drawn there and how large.
    pub scene_legend: Option<SceneLegend>,
    /// The manufacturing sheet.
    pub manufacturing: Option<TableSection>,
}

impl ReportedStudy {
    /// Runs a mode of a world's design.
    ///
    /// # Errors
    /// Those of the study.
    pub fn run(world: &World, mode: Mode, cancel: &CancelToken) -> Result<Self, StudyError> {
        let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
        let (study, profile) = study_profiled(&scenario, &mode, cancel)?;
        let requirement = study.figures.requirement.as_ref();
        let is_missed = requirement.is_some_and(|r| r.verdict == Verdict::Missed);
        let sources = is_missed.then(|| error_sources(&scenario, &mode, cancel)).transpose()?;
        let mut words = plain_words(&scenario, &mode, &study);
        let misfits = coil_statements(&trackwright_project::coil_findings(world));
        let misfits = misfits.iter().map(|statement| format!("{}.", capitalised(statement)));
        words.cautions.extend(misfits);
        Ok(Self { scenario, mode, study, profile, sources, words })
    }
}

impl Report<'_> {
    /// The reference frame of errors and motions.
    fn reference(&self) -> &'static str {
        match self.study.scenario.crf {
            Some(_) => "CRF",
            None => "tracker",
        }
    }

    /// The page as HTML.
    pub fn to_html(&self) -> String {
        let design = self.world.document.design();
        let scene = scene::Scene::new(self);
        let content = html! {
            main {
                (summary::head(self))
                (summary::section(self))
                (figures::errors(self))
                (figures::table(self))
                (scene.section())
                (extras::slides(&self.extras.slides))
                (geometry::section(self))
                (extras::table(self.extras.manufacturing.as_ref()))
                (decisions::section(self))
                (assumptions::section(self))
            }
            (self.foot(&scene))
        };
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(scene.policy());
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content=(format!("trackwright {}", env!("CARGO_PKG_VERSION")));
                    meta name="robots" content="noindex";
                    title { (printable(&design.name)) " – design report" }
                    style { (PreEscaped(style::css())) }
                }
                body {
                    (PreEscaped(printable_lines(&content.into_string())))
                    (scene.scripts())
                }
            }
        }
        .into_string()
    }

    fn foot(&self, scene: &scene::Scene) -> Markup {
        html! {
            footer {
                p { (self.provenance()) }
                p { "Made by trackwright " (env!("CARGO_PKG_VERSION")) ". This file is whole: it needs no network and no other file." }
                (scene.licence())
            }
        }
    }

    /// Where the conclusions come from, as every picture states it.
    fn provenance(&self) -> String {
        super::room::caption(&self.world.environment)
    }

    fn mesh(&self, role: BodyRole) -> Option<&SurfaceMesh> {
        self.world.mesh(role).map(AsRef::as_ref)
    }
}

/// The name of a file that is referred to, without folders.
fn file_name(reference: &str) -> String {
    let name = reference.rsplit(['/', '\\']).next();
    name.unwrap_or(reference).to_owned()
}

/// A table of which every cell is text.
fn table_of(head: &[String], rows: &[Vec<String>], class: &str) -> Markup {
    html! {
        table class=(class) {
            thead { tr { @for cell in head { th { (cell) } } } }
            tbody {
                @for row in rows {
                    tr { @for cell in row { td { (cell) } } }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;

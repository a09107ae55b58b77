//! Designs, `*.design.ron`: which bodies stand where in which room, and what is asked of them.

mod layer_fields;
mod procedure;
#[cfg(test)]
mod tests;

use super::body::BodyFile;
use super::design_anatomy::{self, AnatomyEntry};
use super::error::FormatError;
use super::ron_text::{self, PoseEntry};
use layer_fields::UnknownLayers;
use procedure::ProcedureEntry;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::Deserialize;
use std::fmt::Write;
use trackwright_design::{
    Anatomy, CrfPlacement, Design, DesignBody, Procedure, Slide, Target, ToolPlacement, View,
};
use trackwright_geometry::limits::length_problem;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::motion::Motion;
use trackwright_simulation::requirement::Requirement;

/// What a design file holds: the design with its bodies by file name only, and its view.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignFile {
    pub name: String,
    pub environment: String,
    pub crf: Option<CrfReference>,
    pub tool_body: String,
    pub crf_from_tool: Pose,
    pub motion: Option<Motion>,
    pub orientation_weight_mm: Option<f64>,
    pub requirement: Option<Requirement>,
    pub procedure: Procedure,
    pub anatomy: Vec<Anatomy>,
    pub slides: Vec<Slide>,
    pub view: View,
}

/// A CRF by its file's name.
#[derive(Clone, Debug, PartialEq)]
pub struct CrfReference {
    pub body: String,
    pub tracker_from_crf: Pose,
    pub targets: Vec<Target>,
    pub motion: Option<Motion>,
    pub requirement: Option<Requirement>,
}

impl DesignFile {
    /// What a design's own file holds of it.
    pub fn of(design: &Design, view: &View) -> Self {
        Self {
            name: design.name.clone(),
            environment: design.environment.clone(),
            crf: design.crf.as_ref().map(|crf| CrfReference {
                body: crf.body.reference.clone(),
                tracker_from_crf: crf.tracker_from_crf,
                targets: crf.targets.clone(),
                motion: crf.motion,
                requirement: crf.requirement,
            }),
            tool_body: design.tool.body.reference.clone(),
            crf_from_tool: design.tool.crf_from_tool,
            motion: design.motion,
            orientation_weight_mm: design.orientation_weight_mm,
            requirement: design.requirement,
            procedure: design.procedure.clone(),
            anatomy: design.anatomy.clone(),
            slides: design.slides.clone(),
            view: view.clone(),
        }
    }

    /// The design with the bodies that `body` has for their references, the tool's first.
    ///
    /// # Errors
    /// Those of `body`.
    pub fn into_design<E>(
        self,
        mut body: impl FnMut(&str) -> Result<BodyFile, E>,
    ) -> Result<(Design, View), E> {
        let mut inlined = |reference: String| {
            let BodyFile { rigid, mesh, definition } = body(&reference)?;
            Ok(DesignBody { reference, mesh, rigid, definition })
        };
        let tool =
            ToolPlacement { body: inlined(self.tool_body)?, crf_from_tool: self.crf_from_tool };
        let crf = match self.crf {
            None => None,
            Some(crf) => Some(CrfPlacement {
                body: inlined(crf.body)?,
                tracker_from_crf: crf.tracker_from_crf,
                targets: crf.targets,
                motion: crf.motion,
                requirement: crf.requirement,
            }),
        };
        let design = Design {
            name: self.name,
            environment: self.environment,
            crf,
            tool,
            motion: self.motion,
            orientation_weight_mm: self.orientation_weight_mm,
            requirement: self.requirement,
            procedure: self.procedure,
            anatomy: self.anatomy,
            slides: self.slides,
        };
        Ok((design, self.view))
    }
}

#[derive(Deserialize)]
#[serde(rename = "Design", deny_unknown_fields)]
struct DesignEntry {
    version: u64,
    name: String,
    environment: String,
    crf: Option<CrfEntry>,
    tool: ToolEntry,
    motion: Option<Motion>,
    orientation_weight: Option<f64>,
    requirement: Option<Requirement>,
    procedure: Option<ProcedureEntry>,
    anatomy: Option<Vec<AnatomyEntry>>,
    slides: Option<Vec<Slide>>,
    view: Option<View>,
}

impl ron_text::Versioned for DesignEntry {
    fn version(&self) -> u64 {
        self.version
    }
}

#[derive(Deserialize)]
#[serde(rename = "Crf", deny_unknown_fields)]
struct CrfEntry {
    body: String,
    pose: PoseEntry,
    targets: Option<Vec<TargetEntry>>,
    motion: Option<Motion>,
    requirement: Option<Requirement>,
}

#[derive(Deserialize)]
#[serde(rename = "Tool", deny_unknown_fields)]
struct ToolEntry {
    body: String,
    pose: PoseEntry,
}

#[derive(Deserialize)]
#[serde(rename = "Target", deny_unknown_fields)]
struct TargetEntry {
    name: String,
    position: [f64; 3],
}

/// Reads a design.
///
/// # Errors
/// Anything that leaves a doubt about what the design is; see [`FormatError`].
pub fn parse(bytes: &[u8]) -> Result<DesignFile, FormatError> {
    let entry: DesignEntry = ron_text::parse(bytes)?;
    check_motion("", entry.motion.as_ref())?;
    check_requirement("requirement", entry.requirement.as_ref())?;
    if let Some(weight) = entry.orientation_weight {
        check_number("orientation_weight", weight, length_problem(weight))?;
    }
    let mut view = entry.view.unwrap_or_default();
    view.check()?;
    let mut slides = entry.slides.unwrap_or_default();
    let (of_view, of_slides) = UnknownLayers::of(bytes)?.into_names();
    view.unknown_layers = of_view;
    for (slide, unknown) in slides.iter_mut().zip(of_slides) {
        slide.view.unknown_layers = unknown;
    }
    for (index, slide) in slides.iter().enumerate() {
        (slide.view.check()).map_err(|cause| FormatError::Slide { index, cause })?;
    }
    Ok(DesignFile {
        name: entry.name,
        environment: file_name("environment", entry.environment)?,
        crf: entry.crf.map(read_crf).transpose()?,
        tool_body: file_name("tool.body", entry.tool.body)?,
        crf_from_tool: entry.tool.pose.check("tool.pose")?,
        motion: entry.motion,
        orientation_weight_mm: entry.orientation_weight,
        requirement: entry.requirement,
        procedure: entry.procedure.map(ProcedureEntry::check).transpose()?.unwrap_or_default(),
        anatomy: design_anatomy::read(entry.anatomy.unwrap_or_default())?,
        slides,
        view,
    })
}

fn read_crf(entry: CrfEntry) -> Result<CrfReference, FormatError> {
    check_motion("crf.", entry.motion.as_ref())?;
    check_requirement("crf.requirement", entry.requirement.as_ref())?;
    let read_target = |(index, target): (usize, TargetEntry)| {
        let field = format!("crf.targets[{index}] {:?}: position", target.name);
        Ok(Target { position_in_crf: ron_text::point(&field, target.position)?, name: target.name })
    };
    Ok(CrfReference {
        body: file_name("crf.body", entry.body)?,
        tracker_from_crf: entry.pose.check("crf.pose")?,
        targets: entry
            .targets
            .unwrap_or_default()
            .into_iter()
            .enumerate()
            .map(read_target)
            .collect::<Result<_, FormatError>>()?,
        motion: entry.motion,
        requirement: entry.requirement,
    })
}

fn file_name(field: &str, name: String) -> Result<String, FormatError> {
    if name.trim().is_empty() {
        Err(FormatError::field(field, "empty", "a file"))
    } else {
        Ok(name)
    }
}

fn check_motion(prefix: &'static str, motion: Option<&Motion>) -> Result<(), FormatError> {
    // The grid itself knows which ranges can be visited; where it starts does not matter.
    motion.map_or(Ok(()), |motion| match motion.grid(&Pose::identity()) {
        Ok(_) => Ok(()),
        Err(cause) => Err(FormatError::Motion { prefix, cause }),
    })
}

fn check_requirement(field: &str, requirement: Option<&Requirement>) -> Result<(), FormatError> {
    for (name, limit) in requirement.into_iter().flat_map(Requirement::bounds) {
        if let Some(limit) = limit {
            let problem = Requirement::bound_problem(name, limit);
            check_number(&format!("{field}.{name}"), limit, problem)?;
        }
    }
    Ok(())
}

fn check_number(field: &str, value: f64, problem: Option<&'static str>) -> Result<(), FormatError> {
    problem.map_or(Ok(()), |expected| Err(FormatError::number(field, value, expected)))
}

/// Writes a design; what is absent or has its default is left out.
pub fn write(design: &DesignFile) -> String {
    let mut out = Lines::default();
    out.line(0, "(");
    out.field(1, "version", "1");
    out.field(1, "name", &ron_text::string(&design.name));
    out.field(1, "environment", &ron_text::string(&design.environment));
    if let Some(crf) = &design.crf {
        out.line(1, "crf: (");
        out.field(2, "body", &ron_text::string(&crf.body));
        out.field(2, "pose", &ron_text::pose(&crf.tracker_from_crf));
        if !crf.targets.is_empty() {
            out.line(2, "targets: [");
            for target in &crf.targets {
                let name = ron_text::string(&target.name);
                let position = ron_text::tuple(target.position_in_crf.coords.as_slice());
                out.line(3, &format!("(name: {name}, position: {position}),"));
            }
            out.line(2, "],");
        }
        out.motion(2, crf.motion.as_ref());
        out.requirement(2, crf.requirement.as_ref());
        out.line(1, "),");
    }
    out.line(1, "tool: (");
    out.field(2, "body", &ron_text::string(&design.tool_body));
    out.field(2, "pose", &ron_text::pose(&design.crf_from_tool));
    out.line(1, "),");
    out.motion(1, design.motion.as_ref());
    if let Some(weight_mm) = design.orientation_weight_mm {
        out.field(1, "orientation_weight", &format!("{weight_mm:?}"));
    }
    out.requirement(1, design.requirement.as_ref());
    procedure::write(&mut out, &design.procedure);
    out.anatomy(1, &design.anatomy);
    out.slides(1, &design.slides);
    if design.view.is_worth_writing() {
        out.view(1, "view", &design.view);
    }
    out.line(0, ")");
    out.0
}

/// A file in the making.
#[derive(Default)]
struct Lines(String);

impl Lines {
    fn line(&mut self, depth: usize, text: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{:1$}{text}", "", 4 * depth);
    }

    fn field(&mut self, depth: usize, name: &str, value: &str) {
        self.line(depth, &format!("{name}: {value},"));
    }

    fn motion(&mut self, depth: usize, motion: Option<&Motion>) {
        let Some(motion) = motion else { return };
        self.line(depth, "motion: (");
        for (axis, range) in motion.axes() {
            if let Some(r) = range {
                let range = format!("(min: {:?}, max: {:?}, step: {:?})", r.min, r.max, r.step);
                self.field(depth + 1, axis, &range);
            }
        }
        self.line(depth, "),");
    }

    fn requirement(&mut self, depth: usize, requirement: Option<&Requirement>) {
        let Some(requirement) = requirement else {
            return;
        };
        let bounds: Vec<_> = requirement
            .bounds()
            .into_iter()
            .filter_map(|(name, limit)| limit.map(|limit| format!("{name}: {limit:?}")))
            .collect();
        self.field(depth, "requirement", &format!("({})", bounds.join(", ")));
    }

    fn anatomy(&mut self, depth: usize, anatomy: &[Anatomy]) {
        if anatomy.is_empty() {
            return;
        }
        self.line(depth, "anatomy: [");
        for one in anatomy {
            self.line(depth + 1, &design_anatomy::line(one));
        }
        self.line(depth, "],");
    }

    fn slides(&mut self, depth: usize, slides: &[Slide]) {
        if slides.is_empty() {
            return;
        }
        self.line(depth, "slides: [");
        for slide in slides {
            self.line(depth + 1, "(");
            self.field(depth + 2, "title", &ron_text::string(&slide.title));
            if !slide.caption.is_empty() {
                self.field(depth + 2, "caption", &ron_text::string(&slide.caption));
            }
            if !slide.figures.is_empty() {
                // Names, in a line.
                let figures: Vec<_> = slide.figures.iter().map(|f| format!("{f:?}")).collect();
                self.field(depth + 2, "figures", &format!("[{}]", figures.join(", ")));
            }
            self.view(depth + 2, "view", &slide.view);
            self.line(depth + 1, "),");
        }
        self.line(depth, "],");
    }

    /// A view: numbers, flags and names, all of which RON can hold.
    fn view(&mut self, depth: usize, name: &str, view: &View) {
        let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let config = PrettyConfig::new().new_line("\n").depth_limit(1);
        if let Ok(text) = options.to_string_pretty(view, config) {
            let indented = text.replace('\n', &format!("\n{:1$}", "", 4 * depth));
            self.field(depth, name, &indented);
        }
    }
}

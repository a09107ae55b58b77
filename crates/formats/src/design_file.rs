//! Designs, `*.design.ron`: which bodies stand where in which room, and what is required of them.

mod anatomy;
mod layer_fields;
mod procedure;
#[cfg(test)]
mod tests;

use super::body::BodyFile;
use super::error::FormatError;
use super::ron_text::{self, PoseEntry, RonWriter, Version};
use anatomy::AnatomyEntry;
use layer_fields::UnknownLayers;
use procedure::ProcedureEntry;
use serde::Deserialize;
use trackwright_design::{
    BodyRole, CrfPlacement, Design, DesignBody, Slide, Target, ToolPlacement, View,
};
use trackwright_geometry::limits::length_problem;
use trackwright_simulation::motion::Motion;
use trackwright_simulation::pivot::Pivot;
use trackwright_simulation::requirement::Requirement;

/// What a design file holds: the design, of whose bodies only the files are known, and its view.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignFile {
    pub design: Design,
    pub view: View,
}

impl DesignFile {
    /// What a design's own file holds of it.
    pub fn of(design: &Design, view: &View) -> Self {
        let mut design = design.clone();
        for role in BodyRole::ALL {
            if let Some(body) = design.body_mut(role) {
                *body = DesignBody::of_file(std::mem::take(&mut body.reference));
            }
        }
        design.room_metal = None;
        Self { design, view: view.clone() }
    }

    /// The design with the bodies that `body` has for their references, the tool's first.
    ///
    /// # Errors
    /// Those of `body`.
    pub fn into_design<E>(
        mut self,
        mut body: impl FnMut(&str) -> Result<BodyFile, E>,
    ) -> Result<(Design, View), E> {
        for role in BodyRole::ALL {
            if let Some(own) = self.design.body_mut(role) {
                let BodyFile { rigid, mesh, definition, mounting } = body(&own.reference)?;
                let reference = std::mem::take(&mut own.reference);
                *own = DesignBody { reference, rigid, mesh, definition, mounting };
            }
        }
        Ok((self.design, self.view))
    }
}

#[derive(Deserialize)]
#[serde(rename = "Design", deny_unknown_fields)]
struct DesignEntry {
    #[serde(rename = "version")]
    _version: Version,
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
    let UnknownLayers { of_view, of_slides } = UnknownLayers::of(bytes)?;
    view.unknown_layers = of_view;
    for (slide, unknown) in slides.iter_mut().zip(of_slides) {
        slide.view.unknown_layers = unknown;
    }
    for (index, slide) in slides.iter().enumerate() {
        (slide.view.check()).map_err(|cause| FormatError::Slide { index, cause })?;
    }
    let design = Design {
        name: entry.name,
        environment: ron_text::file_name("environment", entry.environment)?,
        // In the environment's own file.
        room_metal: None,
        crf: entry.crf.map(read_crf).transpose()?,
        tool: ToolPlacement {
            body: DesignBody::of_file(ron_text::file_name("tool.body", entry.tool.body)?),
            crf_from_tool: entry.tool.pose.check("tool.pose")?,
        },
        motion: entry.motion,
        orientation_weight_mm: entry.orientation_weight,
        requirement: entry.requirement,
        procedure: entry.procedure.map(ProcedureEntry::check).transpose()?.unwrap_or_default(),
        anatomy: anatomy::read(entry.anatomy.unwrap_or_default())?,
        slides,
    };
    Ok(DesignFile { design, view })
}

fn read_crf(entry: CrfEntry) -> Result<CrfPlacement, FormatError> {
    check_motion("crf.", entry.motion.as_ref())?;
    check_requirement("crf.requirement", entry.requirement.as_ref())?;
    let targets = entry.targets.unwrap_or_default().into_iter().enumerate();
    let targets = targets.map(|(index, target)| {
        let field = format!("crf.targets[{index}] {:?}: position", target.name);
        Ok(Target { position_in_crf: ron_text::point(&field, target.position)?, name: target.name })
    });
    Ok(CrfPlacement {
        body: DesignBody::of_file(ron_text::file_name("crf.body", entry.body)?),
        tracker_from_crf: entry.pose.check("crf.pose")?,
        targets: targets.collect::<Result<_, FormatError>>()?,
        motion: entry.motion,
        requirement: entry.requirement,
    })
}

fn check_motion(prefix: &'static str, motion: Option<&Motion>) -> Result<(), FormatError> {
    motion.map_or(Ok(()), |motion| match motion.trials() {
        Ok(_) => Ok(()),
        Err(cause) => Err(FormatError::Motion { prefix, cause }),
    })
}

fn check_requirement(field: &str, requirement: Option<&Requirement>) -> Result<(), FormatError> {
    for (metric, limit) in requirement.into_iter().flat_map(Requirement::bounds) {
        let problem = Requirement::bound_problem(metric, limit);
        check_number(&format!("{field}.{}", metric.name()), limit, problem)?;
    }
    Ok(())
}

fn check_number(field: &str, value: f64, problem: Option<&'static str>) -> Result<(), FormatError> {
    problem.map_or(Ok(()), |expected| Err(FormatError::number(field, value, expected)))
}

/// Writes a design; what is absent or has its default is left out.
pub fn write(file: &DesignFile) -> String {
    let DesignFile { design, view } = file;
    RonWriter::file(|out| {
        out.string("name", &design.name);
        out.string("environment", &design.environment);
        if let Some(crf) = &design.crf {
            out.fields("crf", |out| write_crf(out, crf));
        }
        out.fields("tool", |out| {
            out.string("body", &design.tool.body.reference);
            out.field("pose", ron_text::pose(&design.tool.crf_from_tool));
        });
        write_motion(out, design.motion.as_ref());
        out.optional("orientation_weight", design.orientation_weight_mm);
        write_requirement(out, design.requirement.as_ref());
        procedure::write(out, &design.procedure);
        out.lines_if_any("anatomy", design.anatomy.iter().map(anatomy::line));
        if !design.slides.is_empty() {
            out.list("slides", |out| {
                design.slides.iter().for_each(|slide| out.item(|out| write_slide(out, slide)));
            });
        }
        if view.is_to_be_written() {
            out.value("view", view, 1);
        }
    })
}

fn write_crf(out: &mut RonWriter, crf: &CrfPlacement) {
    out.string("body", &crf.body.reference);
    out.field("pose", ron_text::pose(&crf.tracker_from_crf));
    let target = |target: &Target| {
        let name = ron_text::string(&target.name);
        let position = ron_text::tuple(target.position_in_crf.coords.as_slice());
        format!("(name: {name}, position: {position})")
    };
    out.lines_if_any("targets", crf.targets.iter().map(target));
    write_motion(out, crf.motion.as_ref());
    write_requirement(out, crf.requirement.as_ref());
}

fn write_motion(out: &mut RonWriter, motion: Option<&Motion>) {
    let Some(motion) = motion else { return };
    out.fields("motion", |out| {
        let point = |point: &[f64; 3]| ron_text::tuple(point);
        match &motion.pivot {
            Pivot::Origin => {}
            Pivot::Tip => out.field("pivot", "Tip"),
            Pivot::Body(at) => out.field("pivot", format_args!("Body({})", point(at))),
            Pivot::Reference(at) => out.field("pivot", format_args!("Reference({})", point(at))),
        }
        let axes = motion.axes().into_iter();
        for (axis, r) in axes.filter_map(|(axis, range)| Some((axis, range?))) {
            let range = format_args!("(min: {:?}, max: {:?}, step: {:?})", r.min, r.max, r.step);
            out.field(axis, range);
        }
    });
}

fn write_requirement(out: &mut RonWriter, requirement: Option<&Requirement>) {
    let Some(requirement) = requirement else { return };
    let bounds = requirement.bounds();
    let bounds = bounds.map(|(metric, limit)| format!("{}: {limit:?}", metric.name()));
    out.field("requirement", format_args!("({})", bounds.collect::<Vec<_>>().join(", ")));
}

fn write_slide(out: &mut RonWriter, slide: &Slide) {
    out.string("title", &slide.title);
    out.optional_string("caption", Some(&*slide.caption).filter(|text| !text.is_empty()));
    // Names, in a line.
    out.optional("figures", Some(&slide.figures).filter(|figures| !figures.is_empty()));
    out.value("view", &slide.view, 1);
}

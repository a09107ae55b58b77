//! A design of which some numbers vary.

use trackwright_design::{Design, DesignBody, View};
use trackwright_formats::number_path::{FoundNumber, NumberPath, NumberedText, PathError};
use trackwright_formats::{BodyFile, DesignFile, FormatError, body, design_file};
use trackwright_simulation::body::RigidBody;

const WEIGHT: &str = "orientation_weight";

/// Why a row has no figures.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum TemplateError {
    #[error(transparent)]
    Path(#[from] PathError),
    #[error("{part}{cause}")]
    Invalid { part: &'static str, cause: FormatError },
}

/// The texts of a design and its bodies, and where the numbers of a plan are in them.
///
/// A row's design is read from the texts with the row's numbers in their places, so that it is valid where
/// a file with them would be.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    design: Design,
    parts: [Part; 3],
}

/// A text of its own, and the numbers in it that vary, with their places in the plan.
#[derive(Clone, Debug)]
struct Part {
    kind: PartKind,
    text: NumberedText,
    numbers: Vec<(usize, Result<FoundNumber, PathError>)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum PartKind {
    Design,
    Tool,
    Crf,
}

impl PartKind {
    const ALL: [Self; 3] = [Self::Design, Self::Tool, Self::Crf];

    /// What paths to its numbers begin with.
    fn fields(self) -> &'static [&'static str] {
        match self {
            Self::Design => &[],
            Self::Tool => &["tool", "body"],
            Self::Crf => &["crf", "body"],
        }
    }

    fn prefix(self) -> &'static str {
        match self {
            Self::Design => "",
            Self::Tool => "tool.body",
            Self::Crf => "crf.body",
        }
    }
}

impl Template {
    /// A design whose numbers at these paths vary.
    pub fn new<'a>(design: &Design, paths: impl Iterator<Item = &'a NumberPath>) -> Self {
        let mut design = without_pictures(design);
        let paths: Vec<&NumberPath> = paths.collect();
        // A design that leaves it to the room has no number there; where it varies every row has its own.
        if paths.iter().any(|path| path.to_string() == WEIGHT) {
            design.orientation_weight_mm.get_or_insert(1.0);
        }
        let mut parts = PartKind::ALL.map(|kind| Part {
            kind,
            text: NumberedText::new(text_of(&design, kind)),
            numbers: Vec::new(),
        });
        for (index, path) in paths.into_iter().enumerate() {
            let within = parts.iter_mut().rev().find_map(|part| {
                let fields = part.kind.fields();
                if fields.is_empty() {
                    return Some((part, path.clone()));
                }
                path.behind(fields).map(|rest| (part, rest))
            });
            if let Some((part, path)) = within {
                let found = part.text.find(&path, part.kind.prefix());
                part.numbers.push((index, found));
            }
        }
        Self { design, parts }
    }

    /// The design with other numbers, in the order of the paths.
    ///
    /// # Errors
    /// A path that leads to no number; numbers that leave the design invalid.
    pub fn with(&self, values: &[f64]) -> Result<Design, TemplateError> {
        let mut design = self.design.clone();
        for part in &self.parts {
            if part.numbers.is_empty() {
                continue;
            }
            let found = part.numbers.iter().map(|(index, found)| {
                let found = found.as_ref().map_err(Clone::clone)?;
                Ok((found, values[*index]))
            });
            let text = part.text.with(&found.collect::<Result<Vec<_>, PathError>>()?);
            part.kind.read(&text, &mut design)?;
        }
        Ok(design)
    }

    /// The first path that leads to no number.
    pub fn problem(&self) -> Option<&PathError> {
        let numbers = self.parts.iter().flat_map(|part| &part.numbers);
        numbers
            .filter_map(|(index, found)| Some((index, found.as_ref().err()?)))
            .min_by_key(|(index, _)| **index)
            .map(|(_, problem)| problem)
    }

    pub fn has_crf(&self) -> bool {
        self.design.crf.is_some()
    }

    /// What the rows depend on, in texts.
    pub fn texts(&self) -> [String; 3] {
        PartKind::ALL.map(|kind| text_of(&self.design, kind))
    }
}

/// The paths of all numbers of a design that a plan may vary.
pub fn number_paths(design: &Design) -> Vec<(String, f64, &'static str)> {
    let design = without_pictures(design);
    PartKind::ALL
        .into_iter()
        .flat_map(|kind| {
            let text = NumberedText::new(text_of(&design, kind));
            let prefix = kind.prefix();
            let paths = text.paths();
            let listed = paths.iter().filter_map(|path| {
                let value = text.find(path, "").ok()?.value;
                let whole =
                    if prefix.is_empty() { path.to_string() } else { format!("{prefix}.{path}") };
                (path.to_string() != "version").then(|| (whole, value, path.unit()))
            });
            listed.collect::<Vec<_>>()
        })
        .collect()
}

impl PartKind {
    fn read(self, text: &str, design: &mut Design) -> Result<(), TemplateError> {
        let invalid = |cause| TemplateError::Invalid {
            part: match self {
                Self::Design => "",
                Self::Tool => "tool.body: ",
                Self::Crf => "crf.body: ",
            },
            cause,
        };
        let rigid = |text: &str| -> Result<RigidBody, TemplateError> {
            Ok(body::parse(text.as_bytes()).map_err(invalid)?.rigid)
        };
        match self {
            Self::Design => {
                let read = design_file::parse(text.as_bytes()).map_err(invalid)?.design;
                let bodies = [design.tool.body.clone()]
                    .into_iter()
                    .chain(design.crf.take().map(|crf| crf.body));
                let metal = design.room_metal.take();
                *design = with_bodies(read, bodies);
                design.room_metal = metal;
            }
            Self::Tool => design.tool.body.rigid = rigid(text)?,
            Self::Crf => {
                if let Some(crf) = &mut design.crf {
                    crf.body.rigid = rigid(text)?;
                }
            }
        }
        Ok(())
    }
}

fn with_bodies(mut design: Design, mut bodies: impl Iterator<Item = DesignBody>) -> Design {
    if let Some(tool) = bodies.next() {
        design.tool.body = tool;
    }
    if let (Some(crf), Some(body)) = (&mut design.crf, bodies.next()) {
        crf.body = body;
    }
    design
}

/// Without what no figure depends on.
pub(crate) fn without_pictures(design: &Design) -> Design {
    let mut plain = design.clone();
    plain.slides.clear();
    plain.anatomy.clear();
    plain.procedure = Default::default();
    for role in trackwright_design::BodyRole::ALL {
        if let Some(body) = plain.body_mut(role) {
            body.mesh = None;
            body.definition = None;
            body.mounting = Default::default();
        }
    }
    plain
}

fn text_of(design: &Design, kind: PartKind) -> String {
    let body = |body: &DesignBody| body::write(&BodyFile::of(body));
    match kind {
        PartKind::Design => design_file::write(&DesignFile::of(design, &View::default())),
        PartKind::Tool => body(&design.tool.body),
        PartKind::Crf => design.crf.as_ref().map(|crf| body(&crf.body)).unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_project::open_builtin_without_meshes;

    fn design() -> Design {
        open_builtin_without_meshes("pointer-on-head").unwrap().document.design().clone()
    }

    fn template(paths: &[&str]) -> Template {
        let paths: Vec<NumberPath> = paths.iter().map(|path| path.parse().unwrap()).collect();
        Template::new(&design(), paths.iter())
    }

    #[test]
    fn numbers_of_design_and_bodies_are_set() {
        let varied = template(&[
            "tool.body.sensors[0].position.z",
            "motion.x.max",
            "crf.body.sensors[1].position[0]",
            "crf.pose.position.y",
        ]);
        let found = varied.with(&[-33.25, 40.0, 7.5, -2.0]).unwrap();
        let mut expected = without_pictures(&design());
        expected.tool.body.rigid.sensors[0].position_in_body.z = -33.25;
        if let (Some(motion), Some(crf)) = (&mut expected.motion, &mut expected.crf) {
            motion.x.as_mut().unwrap().max = 40.0;
            crf.body.rigid.sensors[1].position_in_body.x = 7.5;
            crf.tracker_from_crf.translation.vector.y = -2.0;
        }
        assert_eq!(found, expected);
    }

    #[test]
    fn numbers_left_as_they_are_change_nothing() {
        let original = without_pictures(&design());
        for (path, value, _) in number_paths(&design()) {
            let template = template(&[&path]);
            assert_eq!(template.problem(), None);
            assert_eq!(template.with(&[value]).unwrap(), original, "{path}");
        }
    }

    #[test]
    fn what_cannot_be_states_why() {
        let error =
            |path: &str, value: f64| template(&[path]).with(&[value]).unwrap_err().to_string();
        assert_eq!(
            error("tool.body.sensors[9].position.x", 0.0),
            "tool.body.sensors has no item 9, expected one of 3, from 0"
        );
        assert!(error("crf.bdy", 0.0).contains("crf has no bdy, expected one of body"));
        assert_eq!(error("motion.x.step", -1.0), "motion.x: step is -1, expected zero or more");
        let far = error("tool.body.sensors[0].position.x", 1e9);
        assert!(far.starts_with("tool.body: sensors[0]"), "{far}");
    }
}

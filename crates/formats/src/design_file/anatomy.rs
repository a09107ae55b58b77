//! The anatomy of a design's file: which meshes are shown beside its bodies, and where.

use crate::error::FormatError;
use crate::mounting::{BoxEntry, bounds_of, box_text};
use crate::ron_text::{self, PoseEntry};
use serde::Deserialize;
use trackwright_design::{Anatomy, AnatomyFrame};
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::mounting::{BoxPlace, check_box};

#[derive(Deserialize)]
#[serde(rename = "Anatomy", deny_unknown_fields)]
pub(super) struct AnatomyEntry {
    name: String,
    mesh: String,
    mesh_unit: Option<MeshUnit>,
    #[serde(default)]
    on: AnatomyFrame,
    pose: Option<PoseEntry>,
    color: Option<[f64; 3]>,
    crf_patch: Option<Vec<BoxEntry>>,
}

/// Without a pose a mesh is where its own frame is.
pub(super) fn read(entries: Vec<AnatomyEntry>) -> Result<Vec<Anatomy>, FormatError> {
    ron_text::check_names("anatomy", entries.iter().map(|entry| entry.name.as_str()))?;
    let entries = entries.into_iter().enumerate();
    entries.map(|(index, entry)| read_one(index, entry)).collect()
}

fn read_one(index: usize, entry: AnatomyEntry) -> Result<Anatomy, FormatError> {
    let field = |of: &str| format!("anatomy[{index}] {:?}: {of}", entry.name);
    let mesh = MeshReference {
        file: ron_text::file_name(field("mesh"), entry.mesh)?,
        unit: ron_text::mesh_unit(field("mesh_unit"), entry.mesh_unit)?,
    };
    let parts = entry.color.iter().flatten();
    if let Some(part) = parts.copied().find(|part| !(0.0..=1.0).contains(part)) {
        let expected = "red, green and blue from 0 to 1";
        return Err(FormatError::number(field("color"), part, expected));
    }
    let frame_from_mesh = match &entry.pose {
        Some(pose) => pose.check(&field("pose"))?,
        None => Pose::identity(),
    };
    let crf_patch = bounds_of(entry.crf_patch);
    for (number, own) in crf_patch.iter().enumerate() {
        let named = |cause| {
            let (name, cause) = (entry.name.clone(), Box::new(cause));
            FormatError::Anatomy { index, name, cause }
        };
        check_box(BoxPlace::CrfPatch { index: number }, own).map_err(named)?;
    }
    Ok(Anatomy {
        frame_from_mesh,
        crf_patch,
        on: entry.on,
        color: entry.color,
        mesh,
        name: entry.name,
    })
}

/// One mesh in a line of its own.
pub(super) fn line(anatomy: &Anatomy) -> String {
    let mut fields = vec![
        format!("name: {}", ron_text::string(&anatomy.name)),
        format!("mesh: {}", ron_text::string(&anatomy.mesh.file)),
    ];
    if let Some(unit) = anatomy.mesh.unit {
        fields.push(format!("mesh_unit: {unit:?}"));
    }
    fields.push(format!("on: {:?}", anatomy.on));
    fields.push(format!("pose: {}", ron_text::pose(&anatomy.frame_from_mesh)));
    if let Some(color) = &anatomy.color {
        fields.push(format!("color: {}", ron_text::tuple(color)));
    }
    if !anatomy.crf_patch.is_empty() {
        let boxes: Vec<_> = anatomy.crf_patch.iter().map(box_text).collect();
        fields.push(format!("crf_patch: [{}]", boxes.join(", ")));
    }
    format!("({})", fields.join(", "))
}

#[cfg(test)]
mod tests {
    use super::super::{DesignFile, parse, write};
    use super::*;
    use crate::test_cases::assert_refused;
    use trackwright_geometry::bounds::Bounds;

    fn design(anatomy: &str) -> String {
        format!(
            "(version: 1, name: \"a\", environment: \"r.env.ron\", \
             tool: (body: \"t.body.ron\", pose: (position: (0, 0, 0), rotation: (1, 0, 0, 0))), \
             anatomy: [{anatomy}])"
        )
    }

    fn read(anatomy: &str) -> Result<DesignFile, String> {
        parse(design(anatomy).as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn anatomy_needs_a_name_and_a_file_only() {
        let least = read(r#"(name: "head", mesh: "head.glb")"#).unwrap();
        let head = Anatomy {
            name: "head".into(),
            mesh: MeshReference::new("head.glb"),
            on: AnatomyFrame::Crf,
            frame_from_mesh: Pose::identity(),
            color: None,
            crf_patch: Vec::new(),
        };
        assert_eq!(least.design.anatomy, std::slice::from_ref(&head));
        let mut all = least;
        all.design.anatomy.push(Anatomy {
            name: "the \"table\"\n".into(),
            mesh: MeshReference {
                file: "../scans/a b.stl".into(),
                unit: Some(MeshUnit::Factor(0.1)),
            },
            on: AnatomyFrame::Tracker,
            frame_from_mesh: Pose::translation(0.1, -2.0, 1e-9),
            color: Some([0.0, 0.3, 1.0]),
            crf_patch: vec![
                Bounds::from(([-0.1, 2.0, 1e-9], [0.3, 2.5, 7.0])),
                Bounds::from(([-5.0; 3], [5.0; 3])),
            ],
        });
        let text = write(&all);
        assert_eq!(parse(text.as_bytes()).unwrap(), all, "{text}");
        // What is not stated is not written: older versions open the file.
        assert_eq!(text.matches("crf_patch").count(), 1, "{text}");
        all.design.anatomy.clear();
        assert!(!write(&all).contains("anatomy"));
    }

    #[test]
    fn errors_of_anatomy_name_it() {
        let cases = r#"
            (name: "", mesh: "a.stl") | anatomy[0]: name is empty, expected a name
            (name: "a", mesh: "a.stl"), (name: "a", mesh: "b.stl")
                | anatomy[1]: name is "a", the name of anatomy[0], expected each name once
            (name: "a", mesh: " ") | anatomy[0] "a": mesh is empty, expected a file
            (name: "a", mesh: "a.stl", mesh_unit: Factor(-1))
                | anatomy[0] "a": mesh_unit is -1 mm, expected a length above zero
            (name: "a", mesh: "a.stl", color: (0, NaN, 0))
                | anatomy[0] "a": color is NaN, expected red, green and blue from 0 to 1
            (name: "a", mesh: "a.stl", pose: (position: (0, inf, 0), rotation: (1, 0, 0, 0)))
                | anatomy[0] "a": pose.position is (0, inf, 0), expected finite numbers
            (name: "a", mesh: "a.stl", crf_patch: [(min: (0, 0, 0), max: (1, 1, 0))])
                | anatomy[0] "a": crf_patch[0]: min z and max z are 0, expected min below max
            (name: "a", mesh: "a.stl", crf_patch: [(min: (0, -inf, 0), max: (1, 1, 1))])
                | anatomy[0] "a": crf_patch[0]: min is (0, -inf, 0), expected finite numbers
            (name: "a", mesh: "a.stl", crf_patch: [(min: (0, 0, 0), max: (1, 1, 2e6))])
                | anatomy[0] "a": crf_patch[0]: max is (1, 1, 2000000), expected coordinates of at most 1e6 mm
            (name: "a", mesh: "a.stl", crf_patch: [(min: (0, 0, 0), size: (1, 1, 1))]) | …`size`…
            (name: "a", mesh: "a.stl", crf_patch: (min: (0, 0, 0), max: (1, 1, 1))) | line 1, column …
            (name: "a", mesh: "a.stl", on: Table) | …found `Table`, expected `Crf` or `Tracker`…
        "#;
        assert_refused("", cases, |anatomy| read(anatomy).unwrap_err());
    }
}

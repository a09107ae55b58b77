//! A row as a design to be opened: what it changes of the design that it is a row of.

use super::sweep::Sweep;
use std::sync::Arc;
use trackwright_design::{CrfPlacement, Design, DesignBody, Edit, EditError, Origin};
use trackwright_metal::setup::RoomMetal;
use trackwright_project::{
    RoomSource, StoreError, World, open_builtin_without_meshes, open_design_without_meshes,
    reference_to_room,
};

/// The numbers, the motion and the room of a row.
#[derive(Clone, Debug)]
pub struct RowDesign {
    pub row: u64,
    /// The design that the numbers are put into.
    pub origin: Origin,
    /// With the row's numbers, without what no figure depends on.
    design: Design,
    /// The plan's room and the metal in it; `None` for the design's own.
    room: Option<(RoomSource, Option<Arc<RoomMetal>>)>,
}

/// Why a row cannot be shown as a design.
#[derive(Debug, thiserror::Error)]
pub enum RowDesignError {
    /// Why the row has no figures.
    #[error("row {row}: {problem}")]
    Problem { row: u64, problem: String },
    #[error("row {row} is beyond the plan's last row, {}", rows - 1)]
    NoRow { row: u64, rows: u64 },
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("row {row}: the open design has other bodies than the design of the sweep")]
    OtherBodies { row: u64 },
    #[error("row {row}: {cause}")]
    Edit { row: u64, cause: EditError },
}

impl Sweep {
    /// A row to be shown as a design.
    ///
    /// # Errors
    /// A row that is not in the plan, or that has no design; a room that cannot be read any more.
    pub fn row_design(&self, row: u64) -> Result<RowDesign, RowDesignError> {
        if row >= self.rows() {
            return Err(RowDesignError::NoRow { row, rows: self.rows() });
        }
        let problem = |problem| RowDesignError::Problem { row, problem };
        let (mut design, _) = self.design(row).map_err(problem)?;
        if let Some(range) = self.range_of(row) {
            design.motion = Some(range);
        }
        let room = match self.room_of(row) {
            None => None,
            Some(source) => Some((source.clone(), source.read()?.metal)),
        };
        Ok(RowDesign { row, origin: self.origin_of(row).clone(), design, room })
    }
}

impl RowDesign {
    /// The edits that give the open design, which is the one that the sweep is of, all that the row's
    /// figures depend on. None where it has that already.
    ///
    /// # Errors
    /// A design whose bodies were replaced, or in which an edit is refused.
    pub fn edits(&self, open: &World) -> Result<Vec<Edit>, RowDesignError> {
        let design = open.document.design();
        let wanted = &self.design;
        let mut edits = Vec::new();
        if design.bodies().count() != wanted.bodies().count() {
            return Err(RowDesignError::OtherBodies { row: self.row });
        }
        for ((role, own), (_, wanted)) in design.bodies().zip(wanted.bodies()) {
            if own.reference != wanted.reference {
                return Err(RowDesignError::OtherBodies { row: self.row });
            }
            if own.rigid != wanted.rigid {
                let rigid = wanted.rigid.clone();
                let content = Box::new(DesignBody { rigid, ..own.clone() });
                edits.push(Edit::SetBody { body: role, content });
            }
        }
        if let (Some(own), Some(wanted)) = (&design.crf, &wanted.crf) {
            edits.extend(crf_edits(own, wanted));
        }
        if design.tool.crf_from_tool != wanted.tool.crf_from_tool {
            edits.push(Edit::SetToolPose(wanted.tool.crf_from_tool));
        }
        if design.motion != wanted.motion {
            edits.push(Edit::SetMotion(wanted.motion));
        }
        if design.requirement != wanted.requirement {
            edits.push(Edit::SetRequirement(wanted.requirement));
        }
        if design.orientation_weight_mm != wanted.orientation_weight_mm {
            edits.push(Edit::SetOrientationWeight(wanted.orientation_weight_mm));
        }
        let (file, metal) = match &self.room {
            None => (wanted.environment.clone(), &wanted.room_metal),
            Some((room, metal)) => (reference_to_room(open, room)?, metal),
        };
        if design.environment != file || design.room_metal != *metal {
            edits.push(Edit::SetEnvironment { file, metal: metal.clone() });
        }
        self.tried(design_with(open, &edits))?;
        Ok(edits)
    }

    /// The whole design, as a file beside that of the sweep's design would hold it, with a name of its
    /// own.
    ///
    /// # Errors
    /// As [`edits`](Self::edits), and a design that cannot be read any more.
    pub fn whole(&self) -> Result<Design, RowDesignError> {
        let open = self.saved()?;
        let mut edits = self.edits(&open)?;
        let name = &open.document.design().name;
        edits.push(Edit::SetName(format!("{name}, row {}", self.row)));
        self.tried(design_with(&open, &edits))
    }

    /// As [`edits`](Self::edits), of the sweep's design as it was saved.
    ///
    /// # Errors
    /// As [`whole`](Self::whole).
    pub fn edits_of_saved(&self) -> Result<Vec<Edit>, RowDesignError> {
        self.edits(&self.saved()?)
    }

    fn saved(&self) -> Result<World, RowDesignError> {
        Ok(match &self.origin {
            Origin::BuiltIn(name) => open_builtin_without_meshes(name)?,
            Origin::File(file) => open_design_without_meshes(file)?,
        })
    }

    fn tried(&self, design: Result<Design, EditError>) -> Result<Design, RowDesignError> {
        design.map_err(|cause| RowDesignError::Edit { row: self.row, cause })
    }
}

/// An open design with some edits more.
fn design_with(open: &World, edits: &[Edit]) -> Result<Design, EditError> {
    let mut document = open.document.clone();
    for edit in edits {
        document.apply(edit.clone())?;
    }
    Ok(document.design().clone())
}

fn crf_edits(own: &CrfPlacement, wanted: &CrfPlacement) -> Vec<Edit> {
    let mut edits = Vec::new();
    if own.tracker_from_crf != wanted.tracker_from_crf {
        edits.push(Edit::SetCrfPose(wanted.tracker_from_crf));
    }
    if own.motion != wanted.motion {
        edits.push(Edit::SetCrfMotion(wanted.motion));
    }
    if own.requirement != wanted.requirement {
        edits.push(Edit::SetCrfRequirement(wanted.requirement));
    }
    let kept = own.targets.len().min(wanted.targets.len());
    edits.extend((kept..own.targets.len()).rev().map(|index| Edit::RemoveTarget { index }));
    for (index, target) in wanted.targets.iter().enumerate() {
        match own.targets.get(index) {
            Some(own) if own == target => {}
            Some(_) => edits.push(Edit::SetTarget { index, target: target.clone() }),
            None => edits.push(Edit::AddTarget(target.clone())),
        }
    }
    edits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::template::without_pictures;
    use std::fs;
    use std::path::Path;
    use trackwright_design::BodyRole;
    use trackwright_formats::sweep_plan;
    use trackwright_project::{open_builtin, open_design, open_variant, own_room, save, save_as};
    use trackwright_project::{refresh_environment, save_with_copies};

    /// Numbers in all parts of a design, and a motion of the plan's own.
    const PLAN: &str = r#"(
        version: 1,
        designs: ["pointer-on-head"],
        vary: [Grid([
            (path: "tool.body.sensors[0].position.z", values: List([60, 72])),
            (path: "crf.body.sensors[1].position.x", values: List([7])),
            (path: "crf.pose.position.y", values: List([-3])),
            (path: "crf.targets[0].position.x", values: List([1.5])),
            (path: "orientation_weight", values: List([80])),
        ])],
        motions: [Motion, Range((x: (min: 0, max: 10, step: 5)))],
    )"#;

    fn sweep(text: &str, folder: &Path) -> Sweep {
        Sweep::of_plan(sweep_plan::parse(text.as_bytes()).unwrap(), folder).unwrap()
    }

    fn apply(world: &mut World, edits: Vec<Edit>) {
        world.document.begin("row");
        edits.into_iter().for_each(|edit| assert!(world.document.apply(edit).unwrap()));
        assert!(world.document.commit());
        refresh_environment(world).unwrap();
    }

    #[test]
    fn a_row_is_one_step_of_the_open_design() {
        let sweep = sweep(PLAN, Path::new("/nowhere"));
        let mut world = open_builtin("pointer-on-head").unwrap();
        let before = world.document.design().clone();
        for row in 0..sweep.rows() {
            let (mut expected, _) = sweep.design(row).unwrap();
            expected.motion = sweep.range_of(row).or(expected.motion);
            let shown = sweep.row_design(row).unwrap();
            let edits = shown.edits(&world).unwrap();
            apply(&mut world, edits);
            assert_eq!(without_pictures(world.document.design()), expected, "{row}");
            assert_eq!(shown.edits(&world).unwrap(), []);
            assert!(world.document.design().tool.body.mesh.is_some());
            world.document.undo();
            assert_eq!(*world.document.design(), before);
        }
        // Whatever was changed meanwhile.
        let mut sensor = before.tool.body.rigid.sensors[1].clone();
        sensor.position_in_body.x += 1.0;
        for edit in [
            Edit::SetSensor { body: BodyRole::Tool, index: 1, sensor },
            Edit::SetRequirement(None),
            Edit::RemoveTarget { index: 0 },
        ] {
            world.document.apply(edit).unwrap();
        }
        let edits = sweep.row_design(0).unwrap().edits(&world).unwrap();
        apply(&mut world, edits);
        assert_eq!(without_pictures(world.document.design()), sweep.design(0).unwrap().0);
    }

    #[test]
    fn a_row_is_in_the_room_of_the_plan() {
        let text = PLAN.replace(
            "vary",
            r#"rooms: ["operating-table.env.ron", "operating-theatre.env.ron"], vary"#,
        );
        let of_built_in = sweep(&text, Path::new("/nowhere"));
        let mut world = open_builtin("pointer-on-head").unwrap();
        let follow = |sweep: &Sweep, world: &mut World| {
            for row in 0..sweep.rows() {
                let edits = sweep.row_design(row).unwrap().edits(world).unwrap();
                apply(world, edits);
                assert_eq!(own_room(world).unwrap(), *sweep.room_of(row).unwrap(), "{row}");
            }
        };
        follow(&of_built_in, &mut world);
        let folder = tempfile::tempdir().unwrap();
        let mut world = open_builtin("pointer-on-head").unwrap();
        save_as(&mut world, &folder.path().join("own.design.ron")).unwrap();
        let of_file = sweep(&text.replace("pointer-on-head", "own.design.ron"), folder.path());
        follow(&of_file, &mut world);
    }

    #[test]
    fn a_row_becomes_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.design.ron");
        save_as(&mut open_builtin("pointer-on-head").unwrap(), &file).unwrap();
        let sweep = sweep(&PLAN.replace("pointer-on-head", "own.design.ron"), folder.path());
        let before = open_design(&file).unwrap().document.design().clone();
        let row = sweep.row_design(2).unwrap();
        assert_eq!(row.origin, Origin::File(sweep_file(&sweep, "own.design.ron")));
        let design = row.whole().unwrap();
        let mut world = open_variant(&row.origin, design.clone(), "row-2").unwrap();
        assert!(world.document.is_dirty());
        assert_eq!(design.name, format!("{}, row 2", before.name));
        assert!(world.mesh(BodyRole::Tool).is_some());
        save_with_copies(&mut world).unwrap();
        let saved = open_design(&folder.path().join("own-row-2.design.ron")).unwrap();
        let body = |design: &Design| design.tool.body.rigid.clone();
        assert_eq!(body(saved.document.design()), body(&design));
        assert_eq!(saved.document.design().motion, design.motion);
        assert_eq!(*open_design(&file).unwrap().document.design(), before);
        // What is there is not written over.
        let again = open_variant(&row.origin, design, "row-2").unwrap();
        let free = sweep_file(&sweep, "own-row-2-2.design.ron");
        assert_eq!(*again.document.origin(), Origin::File(free));
    }

    fn sweep_file(sweep: &Sweep, name: &str) -> std::path::PathBuf {
        Path::new(sweep.plan().folder.as_deref().unwrap()).join(name)
    }

    #[test]
    fn what_cannot_be_shown_states_why() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.design.ron");
        let mut world = open_builtin("pointer-on-head").unwrap();
        save_as(&mut world, &file).unwrap();
        let text =
            PLAN.replace("[60, 72]", "[60, 1e12]").replace("pointer-on-head", "own.design.ron");
        let sweep = sweep(&text, folder.path());
        let error = |row: u64| sweep.row_design(row).unwrap_err().to_string();
        assert!(error(2).starts_with("row 2: tool.body: sensors[0]"), "{}", error(2));
        assert_eq!(error(4), "row 4 is beyond the plan's last row, 3");
        let row = sweep.row_design(0).unwrap();
        let mut content = Box::new(world.document.design().tool.body.clone());
        content.reference = "other.body.ron".to_owned();
        world.document.apply(Edit::SetBody { body: BodyRole::Tool, content }).unwrap();
        let error = row.edits(&world).unwrap_err();
        assert!(matches!(error, RowDesignError::OtherBodies { row: 0 }), "{error}");
        save(&mut world).unwrap();
        fs::remove_file(&file).unwrap();
        assert!(matches!(row.whole(), Err(RowDesignError::Store(_))));
    }
}

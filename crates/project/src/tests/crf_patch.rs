//! The CRF on a patch of the anatomy: stated in the file, searched over, applied as edits.

use super::*;
use nalgebra::Point3;
use trackwright_design::{Anatomy, AnatomyEdit, AnatomyFrame};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::solid::Solid;
use trackwright_optimization::{
    Goal, Moves, OptimizeError, Optimized, OverRooms, PoseBounds, Settings, optimize,
};
use trackwright_simulation::{CancelToken, Metric};
use trackwright_task::Task;

const RADIUS_MM: f64 = 90.0;

/// From the CRF into the head.
const INWARD: Vector3<f64> = Vector3::new(0.0, -0.77, 0.638);

/// A head as a text of an OBJ file.
fn head() -> String {
    let Solid { positions_mm, triangles, .. } = Solid::sphere(RADIUS_MM);
    let vertices = positions_mm.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = triangles.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    vertices.chain(faces).collect()
}

/// The middle of the CRF's body.
fn middle_in_crf(world: &World) -> Point3<f64> {
    world.mesh(BodyRole::Crf).unwrap().body_bounds().unwrap().center_mm()
}

/// A design with a head 4 mm below the middle of its CRF, and a patch of 50 mm to all sides.
fn world_with_patch(on: AnatomyFrame) -> (TempDir, World) {
    let (folder, mut world) = saved_world();
    fs::write(folder.path().join("head.obj"), head()).unwrap();
    let inward = INWARD.normalize();
    let center = middle_in_crf(&world) + inward * (RADIUS_MM + 4.0);
    let foot_in_mesh = Point3::from(inward * -RADIUS_MM);
    let reach = Vector3::repeat(50.0);
    let patch = Bounds { min_mm: foot_in_mesh - reach, max_mm: foot_in_mesh + reach };
    let anatomy = Anatomy {
        name: "head".to_owned(),
        mesh: MeshReference::new("head.obj"),
        on: AnatomyFrame::Crf,
        frame_from_mesh: Pose::translation(center.x, center.y, center.z),
        color: None,
        crf_patch: Vec::new(),
    };
    let anatomy = anatomy.put_on(on, world.document.design());
    for edit in [
        AnatomyEdit::Add(Box::new(anatomy)),
        AnatomyEdit::SetCrfPatch { index: 0, boxes: vec![patch] },
    ] {
        world.document.apply(Edit::Anatomy(edit)).unwrap();
    }
    refresh_meshes(&mut world).unwrap();
    (folder, world)
}

fn search(world: &World) -> Result<Optimized, OptimizeError> {
    let rooms = [std::sync::Arc::clone(&world.environment)];
    let bounds = PoseBounds { shift_mm: Vector3::repeat(1e6), turn_deg: 10.0 };
    let moves = Moves { crf_pose: Some(bounds), ..Moves::default() };
    let goal = Goal::Figure(Metric::TIP_RMS);
    let problem = placement_problem(world, &rooms, moves, goal, OverRooms::Worst);
    let settings = Settings { most_fits: 600_000, ..Settings::default() };
    optimize(&problem, &settings, &CancelToken::default(), &Task::default(), &mut |_| ())
}

#[test]
fn a_patch_stays_in_the_file() {
    let (folder, mut world) = world_with_patch(AnatomyFrame::Crf);
    save(&mut world).unwrap();
    let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
    assert_eq!(opened.document.design(), world.document.design());
    assert_eq!(opened.document.design().anatomy[0].crf_patch.len(), 1);
    assert_eq!(world.document.undo().as_deref(), Some("Change CRF patch of anatomy head"));
    assert!(world.document.design().anatomy[0].crf_patch.is_empty());
}

#[test]
fn the_head_crf_finds_its_spot_on_the_head() {
    for on in AnatomyFrame::ALL {
        let (_folder, mut world) = world_with_patch(on);
        let before = world.document.design().clone();
        let found = search(&world).unwrap();
        assert!(found.best.objective < found.start.objective);
        let change = found.best.crf_change(&found.start).unwrap();
        assert!(change.way_mm > 5.0, "{change:?}");
        world.document.begin("Place sensors");
        for edit in layout_edits(world.document.design(), &found.best) {
            world.document.apply(edit).unwrap();
        }
        world.document.commit();
        let now = world.document.design().clone();
        // In the room the head, the targets and the tool are where they were; the patch is on the head.
        let in_room = |design: &trackwright_design::Design| {
            let crf = design.crf.as_ref().unwrap();
            let head = design.anatomy[0].tracker_from_mesh(design);
            let mut points = vec![head * Point3::origin(), head * Point3::new(90.0, 0.0, 0.0)];
            points.extend(crf.targets.iter().map(|own| crf.tracker_from_crf * own.position_in_crf));
            let tool = crf.tracker_from_crf * design.tool.crf_from_tool;
            points.extend([tool * Point3::origin(), tool * Point3::new(0.0, 50.0, 50.0)]);
            points
        };
        for (was, is) in in_room(&before).iter().zip(in_room(&now)) {
            assert!((was - is).norm() < 1e-9, "{on:?}: {was} {is}");
        }
        assert_eq!(now.anatomy[0].crf_patch, before.anatomy[0].crf_patch);
        assert_eq!(now.anatomy[0].on, on);
        // The CRF is as far from the head as it was, but for the head's facets.
        let off_mm = |design: &trackwright_design::Design| {
            let crf = design.crf.as_ref().unwrap();
            let middle = crf.tracker_from_crf * middle_in_crf(&world);
            (design.anatomy[0].tracker_from_mesh(design).inverse() * middle).coords.norm()
        };
        let [was_mm, is_mm] = [&before, &now].map(off_mm);
        assert!((was_mm - is_mm).abs() < 1.0, "{was_mm} {is_mm}");
        // It stands on the patch still: a search goes on from there.
        let again = search(&world).unwrap();
        let less = (again.start.objective - found.best.objective).abs();
        assert!(less < 1e-9 * found.best.objective, "{less}");
        assert_eq!(world.document.undo().as_deref(), Some("Place sensors"));
        assert_eq!(*world.document.design(), before);
    }
}

#[test]
fn anatomy_without_its_mesh_has_no_patch() {
    let (folder, mut world) = world_with_patch(AnatomyFrame::Crf);
    fs::remove_file(folder.path().join("head.obj")).unwrap();
    save(&mut world).unwrap();
    let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
    let error = search(&opened).unwrap_err().to_string();
    let expected = "the anatomy \"head\" has a crf_patch and no surface that it could be of: expected a \
                    mesh that can be read";
    assert_eq!(error, expected);
    // A box that is nowhere near.
    let (_folder, mut world) = world_with_patch(AnatomyFrame::Crf);
    let far = vec![Bounds::from(([200.0, 0.0, 0.0], [210.0, 9.0, 9.0]))];
    let edit = AnatomyEdit::SetCrfPatch { index: 0, boxes: far };
    world.document.apply(Edit::Anatomy(edit)).unwrap();
    let error = search(&world).unwrap_err().to_string();
    let expected = "no point of the surface of the anatomy \"head\" is in its crf_patch: the nearest corner \
                    is 110.0 mm away";
    assert_eq!(error, expected);
}

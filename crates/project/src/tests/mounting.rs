//! Mounting regions on the disk, and those of the built-in bodies: what they allow is possible.

use super::*;
use nalgebra::Unit;
use std::collections::BTreeMap;
use std::iter;
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::rotation::perpendicular;
use trackwright_geometry::surface::Surface;
use trackwright_simulation::body::Coil;
use trackwright_simulation::{MountingAxis, MountingRegion, channel_of, coil_fits};

/// The coil that all but one of the built-in sensors have.
const COIL: Coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };

struct Own {
    mounting: Mounting,
    sensors: Vec<Sensor>,
    tip_mm: Point3<f64>,
    mesh: SurfaceMesh,
    surface: Surface,
}

fn built_in() -> BTreeMap<String, Own> {
    let mut found = BTreeMap::new();
    for name in builtin_names() {
        let world = open_builtin(name).unwrap();
        for (role, body) in world.document.design().bodies() {
            let mesh = SurfaceMesh::clone(world.mesh(role).unwrap());
            let own = Own {
                mounting: body.mounting.clone(),
                sensors: body.rigid.sensors.clone(),
                tip_mm: body.rigid.judged_tip_in_body(),
                surface: Surface::new(&mesh).unwrap(),
                mesh,
            };
            found.insert(body.rigid.name.clone(), own);
        }
    }
    assert_eq!(found.len(), 4);
    found
}

#[test]
fn coils_fit_all_along_built_in_channels() {
    let mut channels = 0;
    for (name, own) in built_in() {
        assert!(own.surface.is_closed(), "{name}");
        for region in &own.mounting.regions {
            let MountingRegion::Channel { points_mm, radius_mm, axis } = region else { continue };
            channels += 1;
            assert!(radius_mm.is_some_and(|radius_mm| radius_mm >= COIL.diameter_mm / 2.0));
            let along = Unit::new_normalize(points_mm[1] - points_mm[0]);
            let across = perpendicular(&along);
            let directions = match axis {
                MountingAxis::Free => {
                    vec![along, across, Unit::new_normalize(along.cross(&across))]
                }
                _ => vec![along],
            };
            let half_mm = *along * (COIL.length_mm / 2.0);
            let [first, last] = [points_mm[0] + half_mm, points_mm[1] - half_mm];
            for place in (0..=40).map(|k| first + (last - first) * (f64::from(k) / 40.0)) {
                assert!(own.surface.contains(&place), "{name}: {place}");
                for direction in &directions {
                    let mut sensor = Sensor::five_dof("a", place, *direction);
                    sensor.coil = Some(COIL);
                    let fits = coil_fits(&sensor, iter::empty(), Some(&own.surface));
                    assert!(fits, "{name}: {place} {direction:?}");
                }
            }
        }
    }
    assert_eq!(channels, 4);
}

#[test]
fn built_in_sensors_keep_off_forbidden_boxes() {
    for (name, own) in built_in() {
        for sensor in &own.sensors {
            let coil = sensor.coil.unwrap();
            let half_mm = *sensor.axis_in_body().unwrap() * (coil.length_mm / 2.0);
            let radius_mm = Vector3::repeat(coil.diameter_mm / 2.0);
            for k in -10..=10 {
                let place = sensor.position_in_body + half_mm * (f64::from(k) / 10.0);
                let what = format!("{name}: {}", sensor.name);
                for keep_out in &own.mounting.keep_out {
                    let grown = Bounds {
                        min_mm: keep_out.min_mm - radius_mm,
                        max_mm: keep_out.max_mm + radius_mm,
                    };
                    assert!(!grown.contains(&place), "{what}: {keep_out:?}");
                }
                assert!((place - own.tip_mm).norm() > own.mounting.tip_clearance_mm, "{what}");
            }
        }
    }
}

#[test]
fn built_in_patches_have_free_surface() {
    for (name, own) in built_in() {
        for region in &own.mounting.regions {
            let MountingRegion::Surface { boxes, .. } = region else { continue };
            for patch in boxes {
                let positions = own.mesh.body_parts().flat_map(|part| &part.positions_mm);
                let inside: Vec<_> = positions.filter(|place| patch.contains(place)).collect();
                let is_free = |place: &&&Point3<f64>| {
                    !own.mounting.keep_out.iter().any(|keep_out| keep_out.contains(place))
                };
                let free = inside.iter().filter(is_free).count();
                assert!(free > 50 && 2 * free > inside.len(), "{name}: {patch:?}: {free}");
            }
        }
    }
}

#[test]
fn the_pointers_shaft_is_its_channel() {
    let own = &built_in()["Pointer"];
    let found = channel_of(&own.surface, &own.mesh.long_axis());
    let Some(MountingRegion::Channel { points_mm, radius_mm, axis }) = found else {
        panic!("{found:?}")
    };
    assert_eq!(axis, MountingAxis::Along);
    // From the end of its cone, a long round to 1.1 mm, to the far end.
    let [start, end] = points_mm[..] else { panic!("{points_mm:?}") };
    assert!(start.coords.xy().norm() < 1e-3 && (12.0..15.0).contains(&start.z), "{start}");
    assert!((end.z - 185.0).abs() < 0.1, "{end}");
    assert!(radius_mm.is_some_and(|r| (1.05..=1.1).contains(&r)), "{radius_mm:?}");
}

#[test]
fn changed_regions_are_saved_exported_and_imported() {
    let (folder, mut world) = saved_world();
    let at = |name: &str| folder.path().join(name);
    let before = world.document.design().tool.body.mounting.clone();
    let changed = Mounting { least_gap_mm: Some(0.1 + 0.2), ..before };
    let mounting = Box::new(changed.clone());
    world.document.apply(Edit::SetMounting { body: BodyRole::Tool, mounting }).unwrap();
    assert_eq!(names(&save(&mut world).unwrap()), ["pointer.body.ron"]);
    let mut again = open_design(&at("a.design.ron")).unwrap();
    assert_eq!(again.document.design(), world.document.design());

    fs::create_dir(at("other")).unwrap();
    let copy = at("other/copy.body.ron");
    BodyExport::of(&world, BodyRole::Tool, &copy).unwrap().unwrap().write().unwrap();
    let none = Box::default();
    again.document.apply(Edit::SetMounting { body: BodyRole::Tool, mounting: none }).unwrap();
    let import = BodyImport::of_file(&again, BodyRole::Tool, &copy, OnMismatch::Refuse);
    let taken = import.unwrap().read().unwrap();
    assert_eq!(taken.body.mounting, changed);

    let rom = BodyExport::of(&world, BodyRole::Tool, &at("other/copy.rom")).unwrap().unwrap();
    assert!(rom.notes().contains(&"without where sensors may be put".to_owned()));
}

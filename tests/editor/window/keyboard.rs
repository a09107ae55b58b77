//! The keyboard alone: a sensor is added, placed, nudged and saved, and the design is presented.

use super::harness::Window;
use super::screen::SIZE;
use crate::copied::Copied;
use nalgebra::Vector3;
use trackwright_design::sensor_beside_last;

#[test]
fn a_design_is_made_without_a_pointer() {
    let copy = Copied::new("pointer-on-head");
    let tool = |copy: &Copied| {
        let world = trackwright_project::open_design(&copy.design).unwrap();
        world.document.design().tool.body.rigid.clone()
    };
    let before = tool(&copy);
    let wanted = sensor_beside_last(&before);
    let mut window = Window::open(&copy.design);
    let of_designer = window.picture();
    let mut type_at_once = |keys: &str| {
        // As fast as the display takes them: several come within one frame.
        let keys: Vec<&str> = keys.split(' ').collect();
        window.xdotool(&[&["key", "--delay", "0"], &keys[..]].concat());
        window.settle();
        window.document("undo").to_owned()
    };
    assert_eq!(type_at_once("ctrl+k b e s i d e Return"), format!("Add sensor {}", wanted.name));
    assert_eq!(type_at_once("g x 5 Return"), format!("Move sensor {}", wanted.name));
    assert_eq!(type_at_once("Right"), "Move 1 sensor");
    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    window.key("F5");
    let most = usize::from(SIZE[0]) * usize::from(SIZE[1]);
    assert!(window.picture().differences(&of_designer) > most / 10, "it is presented");
    window.key("Escape");

    let after = tool(&copy);
    let [added] = &after.sensors[before.sensors.len()..] else { panic!("{after:?}") };
    let placed = wanted.position_in_body + Vector3::new(5.0, 0.0, 0.0);
    let nudged_mm = added.position_in_body - placed;
    assert!((nudged_mm.amax() - 1.0).abs() < 1e-9 && (nudged_mm.norm() - 1.0).abs() < 1e-9);
    window.close();
}

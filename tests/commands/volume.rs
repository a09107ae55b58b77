//! The tracker's measurement volume, named when a room is fitted.

use crate::support::program::Scratch;

#[test]
fn a_named_volume_decides_who_is_outside() {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-on-head", "d");
    let design = scratch.arg("d/pointer-on-head.design.ron");
    let out_of = |volume: &str| {
        let size = "--order 1 --directions 1";
        let table = "own:room-a/room-a-fit.csv";
        scratch.succeed(format!("fit {table} -o d/room.env.ron {size} --volume {volume}"));
        scratch.json(format!("simulate {design} --mode motion --log log.csv"));
        let log = scratch.read("log.csv");
        let mut rows = log.lines().map(|row| row.split(','));
        let column = rows.next().unwrap().position(|name| name == "out_of_volume");
        let counts = rows.map(|mut row| row.nth(column.unwrap()).unwrap().parse::<usize>());
        let written = scratch.read("d/room.env.ron");
        let volume = written.lines().find(|line| line.contains("volume: "));
        let volume = volume.map(|line| line.trim().to_owned());
        (volume, counts.map(Result::unwrap).sum::<usize>())
    };
    let expected = |name: &str| Some(format!("volume: {name},"));
    let (cube, of_cube) = out_of("cube");
    assert_eq!(cube, expected("AuroraCube"));
    let (dome, of_dome) = out_of("dome");
    assert_eq!(dome, expected("AuroraDome"));
    let (tabletop, of_tabletop) = out_of("tabletop");
    assert_eq!(tabletop, expected("AuroraTabletop"));
    let (compact, of_compact) = out_of("compact");
    assert_eq!(compact, expected("AuroraCompact"));
    assert_eq!(out_of("none"), (None, 0));
    // The cube lies within the dome, and most of this design beyond the compact volume.
    assert!(of_dome <= of_cube && of_cube < of_compact && of_tabletop < of_compact);
    let unknown = scratch.fail("fit own:room-a/room-a-fit.csv -o d/room.env.ron --volume ball");
    assert!(unknown.contains("cube, dome, tabletop, compact, none"), "{unknown}");
}

//! The tracker's measurement volume, named when a room is fitted.

use crate::support::program::Scratch;

#[test]
fn a_named_volume_decides_who_is_outside() {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-on-head", "d");
    let [cube, dome, tabletop, compact, none] = [
        ("cube", "volume: AuroraCube,"),
        ("dome", "volume: AuroraDome,"),
        ("tabletop", "volume: AuroraTabletop,"),
        ("compact", "volume: AuroraCompact,"),
        ("none", ""),
    ]
    .map(|(name, written)| {
        scratch.fit("d/room.env.ron", &format!("--order 1 --directions 1 --volume {name}"));
        let room = scratch.read("d/room.env.ron");
        let line = room.lines().find(|line| line.contains("volume: ")).unwrap_or("");
        assert_eq!(line.trim(), written);
        scratch.json("simulate d/pointer-on-head.design.ron --mode motion --log log.csv");
        scratch.table("log.csv").numbers("out_of_volume").iter().sum::<f64>()
    });
    assert_eq!(none, 0.0);
    // The cube lies within the dome, and most of this design beyond the compact volume.
    assert!(dome <= cube && cube < compact && tabletop < compact);
    let unknown = "fit own:room-a/room-a-fit.csv -o d/room.env.ron --volume ball";
    scratch.refused(unknown, &["cube, dome, tabletop, compact, none"]);
}

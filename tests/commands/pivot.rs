//! Where the tip of a pivoted tool is: published answers, and the three refusals.

use crate::support::data::third_party;
use crate::support::golden::{number, numbers};
use crate::support::program::{Scratch, text};
use crate::support::table::POSE;

#[test]
fn the_published_recording_gives_its_tip() {
    let Some(file) = third_party("pivot/poses-57.txt") else { return };
    let (scratch, line) = (Scratch::new(), format!("pivot {}", text(&file)));
    let found = scratch.json(&line);
    assert_eq!(found["poses"], 57);
    // Published to three decimals; the last digit of the offset may round either way.
    let tip = numbers::<3>(&found["tip"]);
    let pivot = numbers::<3>(&found["pivot"]);
    for (found, expected) in tip.iter().zip([-14.473, 394.634, -7.407]) {
        assert!((found - expected).abs() < 1.5e-3, "{tip:?}");
    }
    for (found, expected) in pivot.iter().zip([-804.742, -85.474, -2112.131]) {
        assert!((found - expected).abs() < 0.5e-3, "{pivot:?}");
    }
    let [all, one] = ["rms_mm", "rms_component_mm"].map(|key| number(&found[key]));
    assert!((one - 1.761).abs() < 0.5e-3, "{one}");
    assert!((all - 3.0_f64.sqrt() * one).abs() < 1e-12 && (all - 3.050).abs() < 0.5e-3);
    // Neighbouring readings depend on each other: 95 % intervals are wider than those of 57.
    let effective = number(&found["effective"]);
    assert!((12.0..=57.0).contains(&effective), "{effective}");
    for (key, at, error) in
        [("tip", &tip, "tip_std_error_mm"), ("pivot", &pivot, "pivot_std_error_mm")]
    {
        let worst = number(&found[error]);
        assert!((1.0..20.0).contains(&worst), "{worst}");
        for (k, at) in at.iter().enumerate() {
            let [low, high] = numbers::<2>(&found["intervals"][key][k]);
            assert!(low < *at && *at < high && high - low < 2.0 * 3.0 * worst);
        }
    }
    scratch.succeed_with(line, &["95 % interval", "-804.742 -85.474 -2112.131 mm"]);
}

#[test]
fn a_marker_probe_finds_the_jhu_posts() {
    let Some(folder) = third_party("jhu-cis") else { return };
    for case in ["a", "b", "c", "d", "e", "f", "g"] {
        let file = |kind: &str| folder.join(format!("pa1-debug-{case}-{kind}.txt"));
        let found = Scratch::new().json(format!("pivot {}", text(&file("empivot"))));
        // The second line of the course's own answers is the post of the EM probe.
        let answers = std::fs::read_to_string(file("output1")).unwrap();
        let post = answers.lines().nth(1).unwrap().split(',');
        for (found, expected) in numbers::<3>(&found["pivot"]).iter().zip(post) {
            let expected: f64 = expected.trim().parse().unwrap();
            assert!((found - expected).abs() < 0.05, "{case}: {found} {expected}");
        }
    }
}

/// Twelve poses with the tip in (0, 0, 0), turned about x by as many degrees as are given; in every
/// second one about y instead, if requested, and shifted along x by so much, one way and the other.
fn recording(scratch: &Scratch, turns_deg: f64, has_two_axes: bool, slide_mm: f64) -> String {
    let mut table = format!("{POSE}\n");
    for i in 0..12 {
        let half = (turns_deg * (f64::from(i / 2) - 2.5) / 5.0).to_radians() / 2.0;
        let (sine, cosine) = half.sin_cos();
        let (x, y) = match has_two_axes && i % 2 == 1 {
            true => (0.0, sine),
            false => (sine, 0.0),
        };
        let shift = if i % 2 == 0 { slide_mm } else { -slide_mm };
        table += &format!("{shift},0,0,{cosine},{x},{y},0\n");
    }
    let name = format!("{turns_deg}-{has_two_axes}-{slide_mm}.csv");
    scratch.write(&name, table);
    name
}

#[test]
fn each_refusal_has_its_reason_and_its_limit() {
    let scratch = Scratch::new();
    let good = recording(&scratch, 60.0, true, 0.0);
    let found = scratch.json(format!("pivot {good}"));
    assert!(numbers::<3>(&found["tip"]).iter().all(|v: &f64| v.abs() < 1e-9));
    let range = number(&found["orientation_range_deg"]);
    assert!((range - 60.0).abs() < 1e-9, "{range}");
    let still = recording(&scratch, 10.0, true, 0.0);
    let one_axis = recording(&scratch, 60.0, false, 0.0);
    let sliding = recording(&scratch, 60.0, true, 8.0);
    for (args, expected) in [
        (
            format!("{good} --min-poses 13"),
            &["too few poses: 12, expected at least 13", "--min-poses"][..],
        ),
        (still, &["too little variation: no two poses differ by more than 10.0°"]),
        (one_axis, &["too little variation: the tool turned about one axis only"]),
        (sliding, &["too large an error: the tip is"]),
    ] {
        scratch.refused(format!("pivot {args}"), expected);
    }
    // All recordings of one tool together.
    let both = scratch.json(format!("pivot {good} {good} --min-poses 24"));
    assert_eq!(both["poses"], 24);
}

#[test]
fn only_good_samples_of_the_named_tool_count() {
    let scratch = Scratch::new();
    let poses = scratch.read(&recording(&scratch, 60.0, true, 0.0));
    let columns = "Frame\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz";
    let mut table = format!("Tools\tPort 1: still\t{columns}\tPort 2: probe\t{columns}\n");
    for (i, row) in poses.lines().skip(1).enumerate() {
        let cells: Vec<&str> = row.split(',').collect();
        let (at, turn) = cells.split_at(3);
        let still = "8\tOK\t1\t0\t0\t0\t0\t0\t0";
        let probe = [turn, at].concat().join("\t");
        table += &format!("2\tPort 1: still\t{still}\tPort 2: probe\t{i}\tOK\t{probe}\n");
        // Numbers that the tracker does not stand by.
        let off = probe.replacen("\t0\t0\t0", "\t90\t0\t0", 1);
        table += &format!(
            "2\tPort 1: still\t{still}\tPort 2: probe\t{i}\tPartially Out of Volume\t{off}\n"
        );
    }
    scratch.write("ndi.tsv", table);
    scratch.refused("pivot ndi.tsv", &["Port 1: still; Port 2: probe"]);
    let (found, notes) = scratch.json_and_notes("pivot ndi.tsv --tool probe");
    assert_eq!(found["poses"], 12);
    assert!(number(&found["rms_mm"]) < 1e-9);
    assert!(notes.contains("12 of 24 samples not used: Partially Out of Volume"), "{notes}");
    scratch.refused("pivot ndi.tsv --tool still", &["too little variation"]);
}

#[test]
fn real_recordings_are_read_whole() {
    use trackwright_formats::recording::parse;
    // Tools, samples of each, and how many of them the tracker calls good.
    let expected: [(&str, usize, usize, &[usize]); 6] = [
        ("aurora-polaris/static/EM_31_08_2013_001.tsv", 3, 100, &[100, 100, 100]),
        ("aurora-polaris/static/OT_31_08_2013_001.tsv", 1, 100, &[100]),
        // Its last row is cut.
        ("aurora-csv/NDIdata_snakeravenTest_2_2_21.csv", 4, 159, &[]),
        ("igs-mha/SlidingProbeTrackingData.igs.mha", 3, 85, &[85, 85, 85]),
        ("igs-mha/EightLandmarkPointsTrackedForPhantomRegistration.igs.mha", 2, 1000, &[]),
        ("igs-mha/TransformInterpolationTest.igs.mha", 3, 500, &[]),
    ];
    for (file, tools, samples, good) in expected {
        let Some(path) = third_party(file) else { return };
        let found = parse(&std::fs::read(path).unwrap()).unwrap();
        assert_eq!(found.tools.len(), tools, "{file}");
        for (tool, good) in found.tools.iter().zip(good) {
            assert_eq!(tool.good().count(), *good, "{file} {}", tool.name);
        }
        for tool in &found.tools {
            assert_eq!(tool.samples.len(), samples, "{file} {}", tool.name);
            let unusable: usize = tool.unusable().values().sum();
            assert_eq!(tool.good().count() + unusable, samples);
        }
    }
}

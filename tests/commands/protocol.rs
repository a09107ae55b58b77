//! The protocol of Hummel et al. in a room, from a recording, and over time.

use crate::support::golden::number;
use crate::support::program::Scratch;
use serde_json::Value;
use std::fmt::Write;

const SMALL: &str = "--rows 3 --columns 3 --levels 2 --steps 8 --samples 20";
const JITTER: &str = "--jitter-position-mm 0.08 --jitter-angle-deg 0.1";

/// The row of a measure.
#[track_caller]
fn row<'a>(found: &'a Value, measure: &str, condition: &str) -> &'a Value {
    let rows = found["rows"].as_array().unwrap();
    let row = rows.iter().find(|row| row["measure"] == measure && row["condition"] == condition);
    row.unwrap_or_else(|| panic!("no {measure} {condition} in {found}"))
}

#[test]
fn a_recording_gives_its_rooms_figures_back() {
    let scratch = Scratch::new();
    let rods = "--rods steel-416,bronze --rod-distances 20,50 --rod-direction across";
    let run = format!("protocol hummel operating-table {SMALL} {JITTER} {rods} --readings r.csv");
    let simulated = scratch.json(format!("{run} -o simulated.csv --date 2026-05-31"));
    let recorded = scratch.json("protocol hummel --recording r.csv -o recorded.csv");
    assert_eq!(simulated["rows"], recorded["rows"]);
    assert_eq!((&recorded["source"], &recorded["plate"]), (&"r.csv".into(), &Value::Null));
    assert_eq!(simulated["date"], "2026-05-31");
    // 18 holes: 6 along each axis on each level.
    let distance = row(&simulated, "distance_50", "all");
    assert_eq!(distance["count"], 24);
    // In the middle of the room it is a quarter of that of a whole plate.
    assert!((0.03..0.2).contains(&number(&distance["rms"])), "{distance}");
    let jitter = number(&row(&simulated, "jitter", "all")["rms"]);
    // √3 · 0.08 mm, from 34 · 19 · 3 degrees of freedom: a standard error of 1.6 %.
    assert!((jitter / (3.0_f64.sqrt() * 0.08) - 1.0).abs() < 0.064, "{jitter}");
    let [steel, bronze] =
        ["rod_steel-416", "rod_bronze"].map(|rod| number(&row(&simulated, rod, "20 mm")["max"]));
    assert!(steel > bronze && bronze > 1.0, "{steel} {bronze}");
    assert_eq!(row(&simulated, "rod_steel-416", "20 mm")["paper"]["aurora"], "max 4.2");
    let table = scratch.read("simulated.csv");
    assert!(table.starts_with("source,date,measure,condition,unit,count,mean,std,rms,min,max"));
    // The same seed, the same table; another seed, another one.
    let again = scratch.json(format!("{run} -o again.csv --overwrite"));
    assert_eq!(again["rows"], simulated["rows"]);
    let other = scratch.json(format!("{run} -o other.csv --seed 2 --overwrite"));
    assert_ne!(other["rows"], simulated["rows"]);
}

#[test]
fn the_table_stands_beside_the_papers() {
    let scratch = Scratch::new();
    let (text, notes) =
        scratch.both("protocol hummel operating-table -o t.csv --rod-distances 20 --samples 2");
    for words in ["9 by 10 holes", "error of 200 mm", "0.96 ± 0.68", "max 4.2", "planar-nine"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(notes.contains("the room has no jitter"), "{notes}");
    assert!(!text.contains("jitter"), "{text}");
}

/// A plate of four holes, each of a tracker's own file.
#[test]
fn holes_may_have_a_trackers_file_each() {
    let scratch = Scratch::new();
    let mut list = "row,column,recording\n".to_owned();
    for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let (x, y) = (50.0 * f64::from(column), 51.0 * f64::from(row));
        let mut readings = "x,y,z,qw,qx,qy,qz\n".to_owned();
        for z in [-200.0, -200.1, -199.9] {
            writeln!(readings, "{x},{y},{z},1,0,0,0").unwrap();
        }
        scratch.write(&format!("{row}{column}.csv"), readings);
        writeln!(list, "{row},{column},{row}{column}.csv").unwrap();
    }
    scratch.write("list.csv", list);
    let found = scratch.json("protocol hummel --recording list.csv -o t.csv");
    let along = |axis: &str| number(&row(&found, "distance_50", axis)["mean"]);
    assert!(along("along x").abs() < 1e-9 && (along("along y") - 1.0).abs() < 1e-9, "{found}");
    // 0.02 mm² from three readings: a variance of 0.01 mm² over all axes.
    let jitter = number(&row(&found, "jitter", "all")["rms"]);
    assert!((jitter - 0.1).abs() < 1e-9, "{jitter}");
}

#[test]
fn runs_that_cannot_be_have_one_error() {
    let scratch = Scratch::new();
    let pose = "x,y,z,qw,qx,qy,qz";
    scratch.write("poses.csv", format!("{pose}\n0,0,-200,1,0,0,0\n"));
    scratch.write("few.csv", format!("row,column,{pose}\n0,0,0,0,-200,1,0,0,0\n"));
    let room = "protocol hummel operating-table -o t.csv";
    for (line, words) in [
        (format!("{room} --plate 0,0,-200,0,40,0"), "outside the room's box"),
        (format!("{room} --samples 0"), "0 samples at each site, expected 1 to 10000"),
        (format!("{room} --rods cheese"), "--rods: found \"cheese\", expected one of aluminium"),
        (format!("{room} --rods bronze,bronze"), "--rods: found bronze twice"),
        (format!("{room} --rod-diameter-mm nan"), "expected a length above zero"),
        (format!("{room} --rod-length-mm 2000"), "a rod of 10 by 2000 mm, expected at most 1000"),
        (format!("{room} --rod-distances 2000"), "distance of a rod is 2000 mm"),
        (format!("{room} --permeability 0.5"), "relative permeability is 0.5"),
        (format!("{room} --date 2026-02-30"), "no day of the calendar"),
        (format!("{room} --no-rods --frequency 1000"), "--no-rods"),
        (format!("{room} --recording few.csv"), "--recording"),
        ("protocol hummel nowhere -o t.csv".to_owned(), "nowhere"),
        ("protocol chart few.csv poses.csv -o c.svg".to_owned(), "no column source"),
        ("protocol hummel --recording few.csv -o t.csv".to_owned(), "too few holes: 0"),
        ("protocol hummel --recording poses.csv -o t.csv".to_owned(), "no column row, column"),
        (
            format!("protocol hummel --recording few.csv -o t.csv {JITTER}"),
            "belongs to a simulated room",
        ),
        ("protocol hummel --recording few.csv -o few.csv".to_owned(), "few.csv"),
        ("protocol chart few.csv -o c.svg".to_owned(), "2 values required"),
    ] {
        scratch.refused(line, &[words]);
    }
    assert!(!scratch.has("t.csv") && !scratch.has("c.svg"));
}

/// A table of a run whose 50 mm are off by so much.
fn table(error_mm: f64, date: &str) -> String {
    let row = |measure: &str, rms: f64| {
        format!("room,{date},{measure},all,mm,9,{rms},0,{rms},{rms},{rms},,,\n")
    };
    let columns = "source,date,measure,condition,unit,count,mean,std,rms,min,max,worst,\
        paper_aurora,paper_microbird";
    format!("{columns}\n{}{}", row("jitter", 0.1), row("distance_50", error_mm))
}

#[test]
fn a_run_out_of_control_is_marked_and_listed() {
    let scratch = Scratch::new();
    let mut files = String::new();
    // Named against their dates, so that these have to order them.
    for day in (1..=12).rev() {
        let error_mm = match day {
            11 => 1.6,
            _ => 1.0 + 0.05 * f64::from(day % 2),
        };
        scratch.write(&format!("run-{day}.csv"), table(error_mm, &format!("2026-05-{day:02}")));
        write!(files, " run-{day}.csv").unwrap();
    }
    let chart = format!("protocol chart{files} -o chart.svg --baseline 8");
    let found = scratch.json(&chart);
    let figure = &found["figures"][1];
    assert_eq!(
        (&figure["figure"], &found["runs"][0]),
        (&"distance_50".into(), &"2026-05-01".into())
    );
    // Of the first eight; the limits are those of the chart's own tests.
    assert!((number(&figure["limits"]["mean"]) - 1.025).abs() < 1e-9, "{figure}");
    let marked = figure["out_of_control"].as_array().unwrap();
    let is_beyond = |point: &Value| point["run"] == "2026-05-11" && point["why"] == "beyond 3 σ";
    assert!(marked.iter().any(is_beyond), "{figure}");
    let is_late =
        |point: &Value| ["2026-05-11", "2026-05-12"].contains(&point["run"].as_str().unwrap());
    assert!(marked.iter().all(is_late), "{figure}");
    // A jitter that never changes has limits at its mean, and none beyond.
    assert_eq!(found["figures"][0]["out_of_control"].as_array().unwrap().len(), 0);
    assert!(scratch.read("chart.svg").contains(">2026-05-11</text>"));
    let text = scratch.succeed(&chart);
    assert!(text.contains("error of 50 mm, RMS: 2026-05-11 is 1.6000 mm: beyond 3 σ"), "{text}");
}

#[test]
fn few_runs_have_no_limits() {
    let scratch = Scratch::new();
    for run in 0..7 {
        scratch.write(&format!("{run}.csv"), table(1.0 + 0.01 * f64::from(run), ""));
    }
    scratch.write("jitter.csv", table(1.0, "").replace("distance_50", "rotation"));
    let files = "0.csv 1.csv 2.csv 3.csv 4.csv 5.csv 6.csv";
    let (found, notes) = scratch.json_and_notes(format!("protocol chart {files} -o c.svg"));
    assert!(notes.contains("no limits: found 7 tables, expected at least 8"), "{notes}");
    assert_eq!(found["figures"][0]["limits"], Value::Null);
    let line = format!("protocol chart {files} -o d.svg --baseline 8");
    scratch.refused(line, &["limits from the first 8 runs, found 7"]);
    let notes = scratch.notes("protocol chart 0.csv jitter.csv -o e.svg");
    assert!(notes.contains("error of 50 mm, RMS is in 1 of 2 tables, and not charted"), "{notes}");
}

//! The report as a file: where it goes, what it holds, and how a browser shows it.

use crate::support::golden::number;
use crate::support::peers::python;
use crate::support::program::{Scratch, json_of};
use serde_json::Value;
use std::path::Path;
use trackwright_report::page::{Extras, Report, ReportedStudy};
use trackwright_simulation::{CancelToken, Mode};

/// Rows of the table of figures: label, value, unit.
fn figures(html: &str) -> Vec<[String; 3]> {
    let (_, section) = html.split_once("id=\"figures\"").unwrap();
    let (_, table) = section.split_once("<table class=\"data figures\"").unwrap();
    let (table, _) = table.split_once("</table>").unwrap();
    let rows = table.split("<tr").skip(1);
    rows.map(|row| {
        let cells = row.split("<t").skip(1).map(text_of);
        cells.collect::<Vec<_>>().try_into().unwrap()
    })
    .collect()
}

/// What of a cell is read, from within its first tag on.
fn text_of(cell: &str) -> String {
    let texts = cell.split('>').skip(1).map(|text| text.split('<').next().unwrap());
    let text: String = texts.collect();
    [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&amp;", "&")]
        .iter()
        .fold(text, |text, (escaped, letter)| text.replace(escaped, letter))
}

#[test]
fn a_folder_or_a_file_name_is_accepted() {
    let scratch = Scratch::new();
    let printed = scratch.succeed("report designs/pointer-on-head.design.ron -o deep/reports");
    let file = "deep/reports/pointer-on-head.html";
    assert!(printed.starts_with(file), "{printed}");
    let html = scratch.read(file);
    let simulate = "simulate designs/pointer-on-head.design.ron --mode motion --room-field";
    let simulated = scratch.succeed(simulate);
    let rows = figures(&html);
    assert!(rows.len() > 15);
    for [label, value, unit] in rows {
        let is_there = |line: &str| {
            let words = line.strip_prefix(label.as_str()).map(str::split_whitespace);
            words.is_some_and(|words| {
                words.eq([value.as_str(), unit.as_str()].into_iter().filter(|w| !w.is_empty()))
            })
        };
        assert!(simulated.lines().any(is_there), "{label} {value} {unit}");
    }
    // Written over without a question, as by every command.
    scratch.succeed("report endoscope -o one.html");
    scratch.succeed("report pointer-on-head -o one.html");
    assert!(scratch.read("one.html").contains("Pointer on a head-mounted CRF"));
}

#[test]
fn one_date_and_one_input_give_one_page() {
    let scratch = Scratch::new();
    let write = |name: &str, epoch: &str| {
        let mut command = scratch.command(&format!("report endoscope -o {name}"));
        let output = command.env("SOURCE_DATE_EPOCH", epoch).output().unwrap();
        (output.status.success(), String::from_utf8(output.stderr).unwrap())
    };
    assert!(write("a.html", "951782400").0 && write("b.html", "951782400").0);
    let read = |name: &str| scratch.read(name);
    assert_eq!(read("a.html"), read("b.html"));
    // The last day of February of a leap year that a hundred divides.
    assert!(read("a.html").contains("2000-02-29"));
    let (is_fine, stderr) = write("c.html", "yesterday");
    assert!(!is_fine && stderr.contains("expected seconds since 1970"), "{stderr}");
}

#[test]
fn given_poses_and_a_single_one_have_their_pages() {
    let scratch = Scratch::new();
    let turn = "0,0,0.9762960071199334,-0.2164396139381029";
    let columns = "tool_x,tool_y,tool_z,tool_qw,tool_qx,tool_qy,tool_qz";
    scratch.write("poses.csv", format!("{columns}\n15,-55,25,{turn}\n5,-55,25,{turn}\n"));
    scratch.succeed("report pointer-on-head -o page.html --input poses.csv");
    let html = scratch.read("page.html");
    let found = figures(&html);
    let design = "designs/pointer-on-head.design.ron";
    let simulated = scratch.json(format!("simulate {design} --mode input --input poses.csv"));
    let rms = number(&simulated["room_field"]["position_mm"]["rms"]);
    assert_eq!(found[0], ["tip error RMS".to_owned(), format!("{rms:.4}"), "mm".to_owned()]);
    assert!(html.contains("Tip error pose by pose") && html.contains("poses.csv"));
    scratch.succeed("report pointer-on-head -o page.html --mode single");
    assert!(scratch.read("page.html").contains("One position was looked at"));
    let both = "report pointer-on-head -o page.html --mode single --input poses.csv";
    scratch.refused(both, &["expected --mode input or none"]);
}

#[test]
fn impossible_outputs_leave_nothing() {
    let scratch = Scratch::new();
    scratch.write("notes.txt", "mine");
    for (line, words) in [
        ("report endoscope -o notes.txt", &["notes.txt", "a file where a folder should be"][..]),
        ("report endoscope -o notes.txt/reports", &["cannot be written"]),
        ("report endoscope -o nowhere/page.html", &["no such file or folder"]),
        // A design that cannot be used makes no folder.
        ("report no.design.ron -o reports", &["no.design.ron"]),
    ] {
        scratch.refused(line, words);
    }
    assert_eq!(scratch.read("notes.txt"), "mine");
    assert!(!scratch.has("reports"));
}

#[test]
fn a_missing_mesh_shows_no_local_folder() {
    let scratch = Scratch::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = |from: &str, to: &str, change: &dyn Fn(String) -> String| {
        let content = std::fs::read_to_string(folder.join(from)).unwrap();
        scratch.write(to, change(content));
    };
    copy("designs/endoscope.design.ron", "a.design.ron", &|text| {
        text.replace("../assets/bodies/", "").replace("../assets/environments/", "")
    });
    copy("assets/bodies/endoscope.body.ron", "endoscope.body.ron", &|text| text);
    let room = "assets/environments/operating-table.env.ron";
    copy(room, "operating-table.env.ron", &|text| text);
    scratch.notes_with("report a.design.ron -o a.html", &["mesh is missing"]);
    let html = scratch.read("a.html");
    assert!(html.contains("endoscope.glb could not be read"));
    assert!(!html.contains(&scratch.arg("")), "the page has a folder of this machine");
}

#[test]
fn a_slide_with_a_lost_layer_is_reported() {
    let scratch = Scratch::new();
    let slides = r#"slides: [(title: "a"), (title: "b", view: (layers: (halo: true)))],"#;
    let with_slides = format!("    {slides}\n    tool: (");
    scratch.copy_built_in("new-tool", "a.design.ron", "    tool: (", &with_slides);
    let notes = scratch.notes("report a.design.ron -o a.html");
    let expected = "slide 2 is shown without the layer \"halo\", which this version";
    assert!(notes.contains(expected), "{notes}");
    assert!(!notes.contains("slide 1"), "{notes}");
    assert!(scratch.has("a.html"));
}

/// Writes the page of a built-in design with a mesh for a scene; the figures that it should show.
fn page_with_scene(name: &str, file: &Path) -> Vec<[String; 3]> {
    let world = trackwright_project::open_builtin(name).unwrap();
    let study = ReportedStudy::run(&world, Mode::Motion, &CancelToken::default()).unwrap();
    let glb = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/meshes/pointer.glb");
    let report = Report {
        world: &world,
        study: &study,
        extras: Extras { scene_glb: Some(std::fs::read(glb).unwrap()), ..Extras::default() },
    };
    let html = report.to_html();
    std::fs::write(file, &html).unwrap();
    figures(&html)
}

fn browse(page: &Path, out: &Path, flags: &[&str]) -> Value {
    json_of(python("browser.py").args([page, out]).args(flags))
}

#[test]
fn the_page_works_offline_in_a_browser() {
    let scratch = Scratch::new();
    let page = scratch.path("page.html");
    let expected = page_with_scene(trackwright_project::DEFAULT_BUILTIN, &page);
    let out = scratch.path("seen");
    let found = browse(&page, &out, &[]);
    assert_eq!(found["console"], Value::Array(vec![]));
    assert_eq!(found["requests"], Value::Array(vec![]));
    assert_eq!(found["turns"], true);
    assert_eq!(found["still_words"], false);
    let shown: Vec<[String; 3]> = serde_json::from_value(found["figures"].clone()).unwrap();
    assert_eq!(shown, expected);
    let read = |name: &str| std::fs::read(out.join(name)).unwrap();
    assert_ne!(read("before.png"), read("after.png"), "a drag turned nothing");
    assert!(read("page.pdf").starts_with(b"%PDF"));
}

#[test]
fn a_browser_without_webgl_shows_the_drawing() {
    let scratch = Scratch::new();
    let page = scratch.path("page.html");
    page_with_scene("endoscope", &page);
    let found = browse(&page, &scratch.path("seen"), &["--no-webgl"]);
    assert_eq!(found["turns"], false);
    assert_eq!(found["still_words"], true);
    assert_eq!(found["console"], Value::Array(vec![]));
}

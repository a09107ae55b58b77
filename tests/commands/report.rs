//! The report as a file: where it goes, what it holds, and how a browser shows it.

use crate::support::peers::python;
use crate::support::program::{Scratch, fail, json, succeed, text, trackwright};
use serde_json::Value;
use std::path::Path;
use trackwright_report::page::{Extras, Report, ReportedStudy};
use trackwright_simulation::{CancelToken, Mode};

/// Rows of the table of figures: label, value, unit.
fn figures(html: &str) -> Vec<[String; 3]> {
    let (_, section) = html.split_once("id=\"figures\"").unwrap();
    let (_, table) = section.split_once("<table class=\"figures\"").unwrap();
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

/// The same rows as `simulate` prints them.
fn printed(args: &[&str]) -> String {
    succeed(&[&["simulate"], args].concat())
}

#[test]
fn a_folder_or_a_file_name_is_accepted() {
    let scratch = Scratch::new();
    let folder = scratch.arg("deep/reports");
    let said = succeed(&["report", "designs/pointer-on-head.design.ron", "-o", &folder]);
    let file = scratch.path("deep/reports/pointer-on-head.html");
    assert!(said.starts_with(&text(&file)), "{said}");
    let html = std::fs::read_to_string(&file).unwrap();
    let simulated = printed(&["designs/pointer-on-head.design.ron", "--mode", "motion"]);
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
    let page = scratch.arg("one.html");
    succeed(&["report", "endoscope", "-o", &page]);
    succeed(&["report", "pointer-on-head", "-o", &page]);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("Pointer on a head-mounted CRF"));
}

#[test]
fn one_date_and_one_input_give_one_page() {
    let scratch = Scratch::new();
    let write = |name: &str, epoch: &str| {
        let args = ["report", "endoscope", "-o", &scratch.arg(name)];
        let output = trackwright(&args).env("SOURCE_DATE_EPOCH", epoch).output().unwrap();
        (output.status.success(), String::from_utf8(output.stderr).unwrap())
    };
    assert!(write("a.html", "951782400").0 && write("b.html", "951782400").0);
    let read = |name: &str| std::fs::read_to_string(scratch.path(name)).unwrap();
    assert_eq!(read("a.html"), read("b.html"));
    // The last day of February of a leap year that a hundred divides.
    assert!(read("a.html").contains("2000-02-29"));
    let (is_fine, said) = write("c.html", "yesterday");
    assert!(!is_fine && said.contains("expected seconds since 1970"), "{said}");
}

#[test]
fn given_poses_and_a_single_one_have_their_pages() {
    let scratch = Scratch::new();
    let table = "tool_x,tool_y,tool_z,tool_qw,tool_qx,tool_qy,tool_qz\n\
                 15,-55,25,0,0,0.9762960071199334,-0.2164396139381029\n\
                 5,-55,25,0,0,0.9762960071199334,-0.2164396139381029\n";
    std::fs::write(scratch.path("poses.csv"), table).unwrap();
    let (poses, page) = (scratch.arg("poses.csv"), scratch.arg("page.html"));
    succeed(&["report", "pointer-on-head", "-o", &page, "--input", &poses]);
    let html = std::fs::read_to_string(&page).unwrap();
    let found = figures(&html);
    let simulated = json(&[
        "simulate",
        "designs/pointer-on-head.design.ron",
        "--mode",
        "input",
        "--input",
        &poses,
    ]);
    let rms = simulated["position_mm"]["rms"].as_f64().unwrap();
    assert_eq!(found[0], ["tip error RMS".to_owned(), format!("{rms:.4}"), "mm".to_owned()]);
    assert!(html.contains("Tip error pose by pose") && html.contains("poses.csv"));
    succeed(&["report", "pointer-on-head", "-o", &page, "--mode", "single"]);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("One position was looked at"));
    let said =
        fail(&["report", "pointer-on-head", "-o", &page, "--mode", "single", "--input", &poses]);
    assert!(said.contains("expected --mode input or none"), "{said}");
}

#[test]
fn impossible_outputs_leave_nothing() {
    let scratch = Scratch::new();
    std::fs::write(scratch.path("notes.txt"), "mine").unwrap();
    let said = fail(&["report", "endoscope", "-o", &scratch.arg("notes.txt")]);
    assert!(
        said.contains("notes.txt") && said.contains("a file where a folder should be"),
        "{said}"
    );
    let said = fail(&["report", "endoscope", "-o", &scratch.arg("notes.txt/reports")]);
    assert!(said.contains("cannot be written"), "{said}");
    let said = fail(&["report", "endoscope", "-o", &scratch.arg("nowhere/page.html")]);
    assert!(said.contains("no such file or folder"), "{said}");
    assert_eq!(std::fs::read_to_string(scratch.path("notes.txt")).unwrap(), "mine");
    // A design that cannot be used makes no folder.
    let said = fail(&["report", &scratch.arg("no.design.ron"), "-o", &scratch.arg("reports")]);
    assert!(said.contains("no.design.ron"), "{said}");
    assert!(!scratch.path("reports").exists());
}

#[test]
fn a_missing_mesh_shows_no_local_folder() {
    let scratch = Scratch::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = |from: &str, to: &str, change: &dyn Fn(String) -> String| {
        let content = std::fs::read_to_string(folder.join(from)).unwrap();
        std::fs::write(scratch.path(to), change(content)).unwrap();
    };
    copy("designs/endoscope.design.ron", "a.design.ron", &|text| {
        text.replace("../assets/bodies/", "").replace("../assets/environments/", "")
    });
    copy("assets/bodies/endoscope.body.ron", "endoscope.body.ron", &|text| text);
    let room = "assets/environments/operating-table.env.ron";
    copy(room, "operating-table.env.ron", &|text| text);
    let args = ["report", &scratch.arg("a.design.ron"), "-o", &scratch.arg("a.html")];
    let output = trackwright(&args).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("mesh is missing"), "{said}");
    let html = std::fs::read_to_string(scratch.path("a.html")).unwrap();
    assert!(html.contains("endoscope.glb could not be read"));
    assert!(!html.contains(&scratch.arg("")), "the page has a folder of this machine");
}

#[test]
fn a_slide_with_a_lost_layer_is_reported() {
    let scratch = Scratch::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let design = std::fs::read_to_string(folder.join("designs/new-tool.design.ron")).unwrap();
    let assets = format!("{}/assets/", folder.display());
    let design = design.replace("../assets/", &assets);
    let slides = r#"slides: [(title: "a"), (title: "b", view: (layers: (halo: true)))],"#;
    let tool = "    tool: (";
    assert!(design.contains(tool) && !design.contains("slides"));
    let file = scratch.path("a.design.ron");
    std::fs::write(&file, design.replace(tool, &format!("    {slides}\n{tool}"))).unwrap();
    let args = ["report", &text(&file), "-o", &scratch.arg("a.html")];
    let output = trackwright(&args).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    let expected = "slide 2 is shown without the layer \"halo\", which this version";
    assert!(said.contains(expected), "{said}");
    assert!(!said.contains("slide 1"), "{said}");
    assert!(scratch.path("a.html").exists());
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
    let output = python("browser.py").args([page, out]).args(flags).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {said}"))
}

#[test]
fn the_page_works_offline_in_a_browser() {
    let scratch = Scratch::new();
    let page = scratch.path("page.html");
    let expected = page_with_scene(trackwright_project::DEFAULT_BUILTIN, &page);
    let out = scratch.path("seen");
    let found = browse(&page, &out, &[]);
    assert_eq!(found["said"], Value::Array(vec![]));
    assert_eq!(found["asked"], Value::Array(vec![]));
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
    assert_eq!(found["said"], Value::Array(vec![]));
}

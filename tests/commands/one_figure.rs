//! One figure, one interval, one verdict: whoever is readers gives the same.

use crate::support::golden::{list, number};
use crate::support::program::Scratch;
use serde_json::Value;
use std::path::Path;
use trackwright_design::SlideFigure;
use trackwright_project::builtin_names;
use trackwright_report::words::plain_figure;
use trackwright_simulation::{CancelToken, Metric, Mode, study};
use trackwright_sweep::SweepTable;

/// A study of a design, by the file's name of a design in a folder of its own.
struct AllReaders {
    scratch: Scratch,
    design: String,
    /// As `simulate --format json` prints it.
    study: Value,
}

/// Value and ends of a figure, as JSON has them.
fn triple(figure: &Value) -> [&Value; 3] {
    ["value", "low", "high"].map(|end| &figure[end])
}

impl AllReaders {
    fn of(scratch: Scratch, design: &str) -> Self {
        let study = scratch.json(format!("simulate {design} --mode motion"));
        Self { scratch, design: design.to_owned(), study }
    }

    fn figure(&self, metric: Metric) -> &Value {
        &self.study["figures"][metric.of.json_key()][metric.summary.key()]
    }

    fn verdict(&self) -> &str {
        self.study["requirement"]["verdict"].as_str().unwrap()
    }

    /// Another command's study is the same.
    fn assert_same(&self, other: &Value, who: &str) {
        for key in ["figures", "basis", "requirement", "room_field", "trials", "outside"] {
            assert_eq!(other[key], self.study[key], "{key} of {who}, {}", self.design);
        }
    }

    /// Everyone who shows figures shows these.
    fn everyone_agrees(&self) {
        let Self { scratch, design, .. } = self;
        self.the_terminal_agrees();
        self.the_page_agrees();
        self.the_sweep_agrees();
        self.the_slide_agrees();
        let has_figures = !self.study["figures"].is_null();
        let compared = scratch.json(format!("compare {design}"));
        let row = &list(&compared, "rows")[0];
        let steps = scratch.json(format!("procedure {design}"));
        let tool = &list(&steps, "steps")[1];
        let of_step = &list(tool, "rows")[0];
        for (row, who) in [(row, "compare"), (of_step, "procedure")] {
            match has_figures {
                true => self.assert_same(row, who),
                false => assert!(row["no_figures"].is_string(), "{who}: {row}"),
            }
        }
        let state = if has_figures { self.verdict() } else { "no_figures" };
        assert_eq!(tool["state"], state, "{design}");
    }

    fn the_terminal_agrees(&self) {
        let text = self.scratch.succeed(format!("simulate {} --mode motion", self.design));
        for metric in Metric::bounded().filter(|_| !self.study["figures"].is_null()) {
            let [value, low, high] = triple(self.figure(metric));
            let shown = |end: &Value| format!("{:.4}", number(end));
            let interval = match (low.is_null(), high.is_null()) {
                (true, _) => String::new(),
                (false, true) => format!(" (95 %: at least {})", shown(low)),
                (false, false) => format!(" (95 %: {} to {})", shown(low), shown(high)),
            };
            let line = text.lines().find(|line| line.starts_with(metric.label()));
            let line = line.unwrap_or_else(|| panic!("{}: {text}", metric.label()));
            let expected = format!("{} {}{interval}", shown(value), metric.unit());
            assert!(line.ends_with(&expected), "{line}, expected {expected}");
        }
        for check in list(&self.study["requirement"], "checks") {
            let line = format!("requirement {}: ", check["figure"].as_str().unwrap());
            let mut lines = text.lines().filter_map(|own| own.strip_prefix(&line));
            let verdict = check["verdict"].as_str().unwrap().replace('_', " ");
            let found = lines.next().unwrap_or_else(|| panic!("{line}: {text}"));
            assert!(found.starts_with(&verdict), "{found}, expected {verdict}");
        }
    }

    fn the_page_agrees(&self) {
        self.scratch.succeed(format!("report {} -o page.html --overwrite", self.design));
        let page = self.scratch.read("page.html");
        let sentence = match self.verdict() {
            "met" => "The requirement is met.",
            "missed" => "The requirement is missed: ",
            _ => "whether the requirement is met",
        };
        assert!(page.contains(sentence), "{}: {sentence}", self.design);
        for metric in Metric::bounded().filter(|_| !self.study["figures"].is_null()) {
            let [value, low, high] = triple(self.figure(metric));
            let value = format!("<td class=\"number\">{:.4}</td>", number(value));
            let interval = match (low.is_null(), high.is_null()) {
                (true, _) => "–".to_owned(),
                (false, true) => format!("at least {:.4}", number(low)),
                (false, false) => format!("{:.4} to {:.4}", number(low), number(high)),
            };
            let (label, unit) = (metric.label(), metric.unit());
            let row = format!(
                "<th scope=\"row\">{label}</th>{value}<td class=\"unit\">{unit}</td>\
                 <td class=\"number\">{interval}</td>"
            );
            assert!(page.contains(&row), "{}: {row}", self.design);
        }
    }

    fn the_sweep_agrees(&self) {
        let Self { scratch, design, .. } = self;
        let plan = format!("(version: 1, designs: [{design:?}], motions: [Motion])");
        scratch.write("plan.sweep.ron", plan);
        scratch.succeed("sweep plan.sweep.ron -o rows");
        let table = SweepTable::open(&scratch.path("rows")).unwrap();
        let text = |column: &str| table.texts(&[column], 0..1).unwrap()[0][0].clone();
        assert_eq!(text("verdict"), self.verdict());
        assert_eq!(text("basis"), self.study["basis"].as_str().unwrap());
        for metric in Metric::bounded().filter(|_| !self.study["figures"].is_null()) {
            for (ending, end) in ["", "_low", "_high"].into_iter().zip(triple(self.figure(metric)))
            {
                let cell = table.numbers(&format!("{}{ending}", metric.name())).unwrap()[0];
                let expected = end.as_f64().unwrap_or(f64::NAN);
                assert_eq!(cell.to_bits(), expected.to_bits(), "{}{ending}", metric.name());
            }
        }
    }

    fn the_slide_agrees(&self) {
        let world = trackwright_project::open_design(&self.scratch.path(&self.design)).unwrap();
        let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
        let found = study(&scenario, &Mode::Motion, &CancelToken::default(), None).unwrap();
        let slide = plain_figure(SlideFigure::LargestTipError, &found.figures);
        let Some(slide) = slide else {
            assert!(self.study["figures"].is_null());
            return;
        };
        let [value, low, high] = triple(self.figure(Metric::TIP_MAX));
        assert_eq!(slide.value, format!("{:.2}\u{2009}mm", number(value)));
        if let (Some(low), Some(high)) = (low.as_f64(), high.as_f64()) {
            let interval = format!("{low:.2} to {high:.2}\u{2009}mm");
            assert!(slide.words.ends_with(&interval), "{}", slide.words);
        }
    }
}

/// A built-in design in a folder of its own. Metal is solved for by every reader, so it has few triangles.
fn built_in(name: &str) -> AllReaders {
    let scratch = Scratch::new();
    let design = trackwright_project::open_builtin_without_meshes(name).unwrap().document;
    let reference = &design.design().environment;
    scratch.copy_built_in(name, "a.design.ron", reference, "room.env.ron");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let room = std::fs::read_to_string(root.join("designs").join(reference)).unwrap();
    let room = room
        .replace("../meshes", root.join("assets/meshes").to_str().unwrap())
        .replace("triangles: 1000", "triangles: 200")
        .replace("triangles: 400", "triangles: 150");
    scratch.write("room.env.ron", room);
    AllReaders::of(scratch, "a.design.ron")
}

#[test]
fn built_in_designs_have_one_figure() {
    for name in builtin_names() {
        let readers = built_in(name);
        readers.everyone_agrees();
        assert!(["met", "missed"].contains(&readers.verdict()), "{name}: {}", readers.verdict());
        assert!(readers.study.get("free_axis").is_none(), "{name}");
        // No interval of a room is without width.
        for metric in Metric::bounded() {
            let [value, low, high] = triple(readers.figure(metric)).map(number);
            assert!(low < value && value < high, "{name}: {low} {value} {high}");
        }
    }
}

#[test]
fn the_search_starts_with_the_figures_of_simulate() {
    let readers = built_in("pointer-on-head");
    let found = readers.scratch.json("optimize a.design.ron -o b.design.ron --seconds 1");
    readers.assert_same(&found["start"]["figures"], "optimize");
    let own = readers.scratch.json("simulate b.design.ron --mode motion");
    let written = if found["is_better"] == true { &found["best"] } else { &found["start"] };
    assert_eq!(own["figures"], written["figures"]["figures"]);
}

const PLATE: &str = "(name: \"plate\", shape: Cuboid(size: (200, 200, 10)), triangles: 120, \
                     material: Named(\"aluminium\"), \
                     pose: (position: (320, 0, -300), rotation: (0.7, 0, 0.7, 0)))";

/// The built-in room with metal in it.
fn with_metal(object: &str) -> AllReaders {
    let scratch = Scratch::new();
    scratch.copy_to_own_room("pointer-on-head");
    let rooms = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments");
    let read = |name: &str| std::fs::read_to_string(rooms.join(name)).unwrap();
    let theatre = read("operating-theatre.env.ron");
    let (_, metal) = theatre.split_once("    metal: (").unwrap();
    let (generator, _) = metal.split_once("        objects:").unwrap();
    let text = read("operating-table.env.ron");
    let end = text.rfind(')').unwrap();
    let text = format!("{}    metal: ({generator}objects: [{object}]),\n)", &text[..end]);
    scratch.write("room.env.ron", text);
    AllReaders::of(scratch, "a.design.ron")
}

#[test]
fn metal_adds_to_the_figure_and_to_its_interval() {
    let (bare, plate) = (built_in("pointer-on-head"), with_metal(PLATE));
    assert_eq!(
        (&bare.study["basis"], &plate.study["basis"]),
        (&"measured".into(), &"metal".into())
    );
    plate.everyone_agrees();
    let [own, with] =
        [&bare, &plate].map(|readers| number(&readers.figure(Metric::TIP_RMS)["value"]));
    assert!(with > own, "{own} {with}");
}

#[test]
fn a_sensor_in_metal_is_named_by_everyone() {
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let tracker_from_tool = scenario.tracker_from_crf() * scenario.crf_from_tool;
    let at = tracker_from_tool * scenario.tool.sensors[0].position_in_body;
    let at = format!("({:?}, {:?}, {:?})", at.x, at.y, at.z);
    let readers = with_metal(&format!(
        "(name: \"ball\", shape: Sphere(radius: 20), material: Named(\"aluminium\"), \
         pose: (position: {at}, rotation: (1, 0, 0, 0)))"
    ));
    readers.everyone_agrees();
    let study = &readers.study;
    let [in_metal, trials] = ["in_metal", "trials"].map(|key| study[key].as_u64().unwrap());
    assert!(in_metal > 0 && in_metal < trials, "{study}");
    assert_eq!(study["basis"], "outside");
    // Beside the ball the errors may exceed a bound.
    assert_ne!(readers.verdict(), "met");
    let scratch = &readers.scratch;
    let words = ["trials with a sensor in metal"];
    scratch.succeed_with("simulate a.design.ron --mode motion", &words);
    assert!(scratch.read("page.html").contains("a sensor is in metal, where it has no reading"));
    let words = ["1 of 1 trials a sensor is in metal, where it has no reading"];
    scratch.succeed_with("simulate a.design.ron --mode single", &words);
}

/// What states figures of a design; `@` is it.
const ABOUT_A_DESIGN: [&str; 12] = [
    "@",
    "simulate @ --mode motion",
    "simulate @ --mode single",
    "simulate @ --mode motion --format json",
    "compare @",
    "procedure @",
    "tolerances @",
    "tolerances @ --format json",
    "optimize @ -o better.design.ron --seconds 1",
    "metal distance @",
    "verify @ built.csv --frame crf",
    "verify @ built.csv --frame crf --same-frame",
];

/// Commands about no design, those whose output has no figure of one, and what [`AllReaders::everyone_agrees`] reads.
const OTHERS: &str = "fit generator select distort compensate precision import convert characterize pivot protocol \
                      register export live stability help render report sweep";

#[test]
fn a_design_outside_its_room_meets_nothing() {
    let AllReaders { scratch, .. } = with_metal(PLATE);
    let text = scratch.read("a.design.ron");
    let (before, after) = text.split_once("crf: (").unwrap();
    let (_, from) = after.split_once("position: (").unwrap();
    let (place, _) = from.split_once(')').unwrap();
    let moved = after.replacen(place, "0.0, 0.0, 400.0", 1);
    scratch.write("a.design.ron", format!("{before}crf: ({moved}"));
    let readers = AllReaders::of(scratch, "a.design.ron");
    assert_eq!(readers.study["basis"], "outside");
    assert!(readers.study["figures"].is_null(), "{}", readers.study);
    assert_eq!(readers.verdict(), "cannot_tell");
    readers.everyone_agrees();
    let scratch = &readers.scratch;
    scratch.succeed("simulate a.design.ron --mode motion --log log.csv");
    let log = scratch.read("log.csv").replace("true_", "ideal_").replace("sim_", "measured_");
    scratch.write("built.csv", log);
    for line in ABOUT_A_DESIGN {
        let output = scratch.command(&line.replace('@', "a.design.ron")).output().unwrap();
        let [out, notes] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        let text = format!("{out}\n{notes}")
            .replace("whether the requirement is met", "")
            .replace("whether the requirement holds", "");
        let is_judged = |word: &str| matches!(word, "met" | "missed" | "fails" | "holds");
        let judged = text.split(|c: char| !c.is_alphanumeric()).find(|word| is_judged(word));
        assert_eq!(judged, None, "{line}: {text}");
        let reasons = [
            "cannot_tell",
            "no figures",
            "cannot tell",
            "not decided",
            "does not reach",
            "outside the room's box",
        ];
        assert!(reasons.iter().any(|reason| text.contains(reason)), "{line}: {text}");
    }
    let help = scratch.succeed("--help");
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    let (commands, _) = commands.split_once("\n\n").unwrap();
    let names = commands.lines().filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    for name in names.filter(|name| !name.is_empty()) {
        let is_known = |line: &&str| line.split(' ').next() == Some(name);
        let is_other = OTHERS.split_whitespace().any(|other| other == name);
        assert!(is_other || ABOUT_A_DESIGN.iter().any(is_known), "{name}");
    }
}

#[test]
fn partly_outside_a_bound_is_missed_or_open() {
    let scratch = Scratch::new();
    scratch.fit("room.env.ron", "--order 2");
    let body = format!("{}/assets/bodies/pointer.body.ron", env!("CARGO_MANIFEST_DIR"));
    let write = |limit_mm: f64| {
        let motion = "motion: (x: (min: 0.0, max: 400.0, step: 20.0))";
        let more = format!("{motion}, requirement: (position_max: {limit_mm:?})");
        scratch.write_design("a", &body, [0.0, 0.0, -350.0], &more);
        let study = scratch.json("simulate a.design.ron --mode motion");
        assert_eq!(study["basis"], "outside", "{study}");
        (study["requirement"]["verdict"].clone(), study["requirement"]["checks"][0].clone())
    };
    // What is inside may miss a bound by itself, but never meets it for what is outside.
    let (verdict, check) = write(1e4);
    assert_eq!(verdict, "cannot_tell");
    assert!(check["high"].is_null() && check["reason"].as_str().unwrap().contains("outside"));
    assert!(check["low"].is_number(), "{check}");
    let least_mm = number(&check["low"]);
    assert_eq!(write(0.9 * least_mm).0, "missed");
}

#[test]
fn order_zero_has_the_figure_of_its_measurements() {
    let scratch = Scratch::new();
    scratch.copy_to_own_room("endoscope");
    scratch.fit("room.env.ron", "--order 0");
    let readers = AllReaders::of(scratch, "a.design.ron");
    readers.everyone_agrees();
    let [value, low, high] = triple(readers.figure(Metric::TIP_RMS));
    assert!(number(&readers.study["room_field"]["position_mm"]["rms"]) < 1e-9);
    assert!(number(value) > 0.0 && number(low) > 0.0 && (high.is_null() || number(high) > 0.0));
}

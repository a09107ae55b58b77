//! The page holds what it promises, and nothing that somebody wrote becomes markup in it.

use super::*;
use scraper::{ElementRef, Html, Selector};
use std::sync::Arc;
use trackwright_design::{Decision, Document, Origin};
use trackwright_field::DistortionModel;
use trackwright_procedure::{DecidedRow, DecidedStudies, DecisionBasis, RoomName};
use trackwright_simulation::{Metric, Requirement, figure_rows};

const EVIL: &str =
    "</script></title><script>alert('x')</script><img src=x onerror=alert(1)>&amp;\"'";

fn world(name: &str) -> World {
    trackwright_project::open_builtin(name).unwrap()
}

fn page(world: &World, mode: Mode, extras: Extras) -> String {
    let study = ReportedStudy::run(world, mode, &CancelToken::default()).unwrap();
    let report = Report { world, study: &study, extras };
    report.to_html()
}

fn all<'a>(page: &'a Html, what: &str) -> Vec<ElementRef<'a>> {
    let selector = Selector::parse(what).unwrap();
    page.select(&selector).collect()
}

fn words(element: &ElementRef) -> String {
    element.text().collect()
}

/// The smallest PNG's beginning: enough to be embedded.
fn png() -> Vec<u8> {
    b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec()
}

#[test]
fn figures_are_those_of_the_command_line() {
    for name in trackwright_project::builtin_names() {
        let world = world(name);
        let html = page(&world, Mode::Motion, Extras::default());
        let parsed = Html::parse_document(&html);
        let found: Vec<Vec<String>> = all(&parsed, "#figures table.figures tr")
            .iter()
            .map(|row| row.child_elements().map(|cell| words(&cell)).collect())
            .collect();
        let study = ReportedStudy::run(&world, Mode::Motion, &CancelToken::default()).unwrap();
        let expected: Vec<Vec<String>> = figure_rows(&study.study.room_field)
            .into_iter()
            .map(|row| vec![row.label.to_string(), row.value_text(), row.unit.to_owned()])
            .collect();
        assert_eq!(found, expected, "{name}");
        assert!(html.len() < 15_000_000, "{name}: {}", html.len());
        // Four over position and orientation, the spread, and the shaft.
        assert_eq!(all(&parsed, "#error svg").len(), 6, "{name}");
        let worst =
            trackwright_simulation::figures::trial_number(study.study.room_field.worst.trial);
        let texts: Vec<String> = all(&parsed, "#figures p").iter().map(words).collect();
        let sentence = format!("The worst trial is number {worst} of ");
        assert!(texts.iter().any(|text| text.starts_with(&sentence)), "{texts:?}");
    }
}

fn evil_decision() -> Decision {
    let row = DecidedRow {
        room: RoomName { name: EVIL.to_owned(), file: EVIL.to_owned() },
        target: Some(EVIL.to_owned()),
        figures: Err(EVIL.to_owned()),
    };
    Decision {
        date: "2005-10-26".parse().unwrap(),
        note: EVIL.to_owned(),
        basis: DecisionBasis::Studies(DecidedStudies { requirement: None, rows: vec![row] }),
    }
}

#[test]
fn what_nobody_gives_has_no_section() {
    let world = world(trackwright_project::DEFAULT_BUILTIN);
    let bare = page(&world, Mode::Motion, Extras::default());
    let parsed = Html::parse_document(&bare);
    for absent in ["#decisions", "#slides", "#manufacturing", "canvas", "script", "details"] {
        assert!(all(&parsed, absent).is_empty(), "{absent}");
    }
    assert!(bare.contains("script-src 'none'"));
    let full = page(
        &world,
        Mode::Motion,
        Extras {
            slides: vec![Slide::new("Front".into(), "From ahead".into(), png()).unwrap()],
            scene_glb: Some(b"glTF".to_vec()),
            manufacturing: Some(TableSection {
                title: "To be built".into(),
                head: vec!["sensor".into()],
                rows: vec![vec!["shaft".into()]],
                ..TableSection::default()
            }),
            ..Extras::default()
        },
    );
    let parsed = Html::parse_document(&full);
    for present in ["#slides img", "#manufacturing td", "canvas", "details pre"] {
        assert_eq!(all(&parsed, present).len(), 1, "{present}");
    }
    let error = Slide::new("Front".into(), String::new(), b"GIF89a".to_vec()).unwrap_err();
    assert!(error.to_string().contains("expected a PNG"));
}

#[test]
fn markup_in_any_name_is_text_everywhere() {
    let opened = world(trackwright_project::DEFAULT_BUILTIN);
    let mut design = opened.document.design().clone();
    design.name = EVIL.to_owned();
    design.environment = EVIL.to_owned();
    let crf = design.crf.as_mut().unwrap();
    for body in [&mut design.tool.body, &mut crf.body] {
        body.reference = EVIL.to_owned();
        body.rigid.name = EVIL.to_owned();
        for sensor in &mut body.rigid.sensors {
            sensor.name = EVIL.to_owned();
        }
    }
    design.procedure.tool = Some(evil_decision());
    let mut environment = (*opened.environment).clone();
    environment.name = EVIL.to_owned();
    let provenance = environment.provenance.as_mut().unwrap();
    provenance.data = EVIL.to_owned();
    provenance.holdout.as_mut().unwrap().data = EVIL.to_owned();
    let mesh = |role| opened.mesh(role).cloned();
    let world = World::new(
        Document::new(design, opened.document.view().clone(), Origin::File("x".into())),
        Arc::new(environment),
        mesh(BodyRole::Tool),
        mesh(BodyRole::Crf),
    );
    let evil = || EVIL.to_owned();
    let html = page(
        &world,
        Mode::Motion,
        Extras {
            design_file: Some(evil()),
            input_file: Some(evil()),
            date: Some(evil()),
            slides: vec![Slide::new(evil(), evil(), png()).unwrap()],
            // What a scene is called goes in as bytes that no parser of HTML takes for its own.
            scene_glb: Some(EVIL.as_bytes().to_vec()),
            scene_legend: Some(SceneLegend {
                magnification: 200.0,
                keys: vec![([1, 2, 3], evil())],
                maps: vec![evil()],
            }),
            manufacturing: Some(TableSection {
                title: evil(),
                lead: vec![evil()],
                head: vec![evil()],
                rows: vec![vec![evil()]],
                notes: vec![evil()],
            }),
        },
    );
    let parsed = Html::parse_document(&html);
    // The scene's data, the library, the viewer: no other script, and no picture but the slide and
    // the one that the viewer fills.
    assert_eq!(all(&parsed, "script").len(), 3);
    assert_eq!(all(&parsed, "img").len(), 2);
    assert!(all(&parsed, "[onerror]").is_empty());
    assert_eq!(words(&all(&parsed, "h1")[0]), EVIL);
    assert!(words(&all(&parsed, "head title")[0]).starts_with(EVIL));
    for place in [
        "#decisions p:not(:first-of-type)",
        "#decisions td",
        "#slides strong",
        "#slides span",
        "#manufacturing td",
        "#geometry h3",
        "#setup .legend .key",
    ] {
        assert!(words(&all(&parsed, place)[0]).contains(EVIL), "{place}");
    }
    // Within SVG as well: sensors' tooltips, names in the set-up.
    let tooltips = all(&parsed, "#geometry svg g.sensor title");
    assert!(!tooltips.is_empty() && tooltips.iter().all(|title| words(title).contains(EVIL)));
    assert!(all(&parsed, "#setup svg text").iter().any(|text| words(text) == EVIL));
    // What follows the last thing that was written is still where it belongs.
    assert_eq!(all(&parsed, "body > footer").len(), 1);
}

#[test]
fn nothing_in_the_page_leads_out_of_it() {
    let world = world(trackwright_project::DEFAULT_BUILTIN);
    let extras = Extras { scene_glb: Some(b"glTF".to_vec()), ..Extras::default() };
    let html = page(&world, Mode::Motion, extras);
    let parsed = Html::parse_document(&html);
    for outward in ["link", "iframe", "a[href]", "script[src]", "base", "object"] {
        assert!(all(&parsed, outward).is_empty(), "{outward}");
    }
    for picture in all(&parsed, "img[src]") {
        assert!(picture.attr("src").unwrap().starts_with("data:"));
    }
    assert!(!html.contains("url(") && !html.contains("@import"));
    let policy = all(&parsed, "meta[http-equiv]")[0].attr("content").unwrap();
    assert!(policy.starts_with("default-src 'none'; script-src 'sha256-"), "{policy}");
}

#[test]
fn the_scene_states_how_large_errors_are_drawn() {
    let world = world(trackwright_project::DEFAULT_BUILTIN);
    let legend = SceneLegend {
        magnification: 200.0,
        keys: vec![([0xC4, 0x10, 0x8F], "errors of tip".to_owned())],
        maps: Vec::new(),
    };
    let extras = Extras {
        scene_glb: Some(b"glTF".to_vec()),
        scene_legend: Some(legend),
        ..Extras::default()
    };
    let html = page(&world, Mode::Motion, extras);
    let parsed = Html::parse_document(&html);
    let text = words(&all(&parsed, "#setup .legend")[0]);
    assert!(text.contains("Errors drawn 200× larger") && text.contains("errors of tip"), "{text}");
    assert!(html.contains("#c4108f"));
    let without = page(&world, Mode::Motion, Extras::default());
    assert!(all(&Html::parse_document(&without), "#setup .legend").is_empty());
}

#[test]
fn a_missed_requirement_has_its_reasons() {
    let opened = world(trackwright_project::DEFAULT_BUILTIN);
    let reasons = |limit_mm: f64| {
        let mut design = opened.document.design().clone();
        design.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, limit_mm)]));
        let origin = Origin::File("x".into());
        let document = Document::new(design, opened.document.view().clone(), origin);
        let world = World::new(document, opened.environment.clone(), None, None);
        let html = page(&world, Mode::Motion, Extras::default());
        let parsed = Html::parse_document(&html);
        all(&parsed, "#summary .reasons li").iter().map(words).collect::<Vec<_>>()
    };
    let missed = reasons(1e-3);
    assert_eq!(missed.len(), 2, "{missed:?}");
    assert!(missed[0].starts_with("Sensor ") && missed[0].contains(" of the tip error"));
    assert!(missed[1].contains("of the trials"), "{missed:?}");
    assert!(reasons(1e3).is_empty());
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let world = world(trackwright_project::DEFAULT_BUILTIN);
    let once = page(&world, Mode::Motion, Extras::default());
    assert_eq!(once, page(&world, Mode::Motion, Extras::default()));
}

#[test]
fn a_bare_design_has_its_page() {
    let opened = world("endoscope");
    let mut design = opened.document.design().clone();
    design.crf = None;
    design.requirement = None;
    design.motion = None;
    let mut environment = (*opened.environment).clone();
    environment.model = DistortionModel::zero(*environment.model.bounds(), environment.model.map());
    environment.provenance = None;
    environment.fit_validity = None;
    environment.process = None;
    environment.volume = None;
    environment.jitter = None;
    let document = Document::new(design, opened.document.view().clone(), Origin::File("x".into()));
    let world = World::new(document, Arc::new(environment), None, None);
    let html = page(&world, Mode::Single, Extras::default());
    let parsed = Html::parse_document(&html);
    let text = words(&all(&parsed, "main")[0]);
    for sentence in [
        "The tip is ",
        "No requirement is set.",
        "tracked without a reference on the patient",
        "One position was looked at",
        "the body has no mesh",
        "an ideal room",
        "the volume is not stated",
    ] {
        assert!(text.contains(sentence), "{sentence}: {text}");
    }
    assert!(all(&parsed, "#error svg").is_empty());
    assert!(!html.contains("NaN"));
}

#[test]
fn motions_are_relative_to_the_reference() {
    for (name, is, is_not) in
        [("pointer-on-head", "CRF", "tracker"), ("endoscope", "tracker", "CRF")]
    {
        let page = page(&world(name), Mode::Motion, Extras::default());
        let page = Html::parse_document(&page);
        let axes = all(&page, "#assumptions table.motion td:first-child");
        let axes: Vec<String> = axes.iter().map(words).collect();
        assert_eq!(axes.len(), 6, "{axes:?}");
        let ends_so = |axis: &&String| axis.ends_with(&format!("of the {is}"));
        assert_eq!(axes.iter().filter(ends_so).count(), 6, "{axes:?}");
        let paragraphs: Vec<String> = all(&page, "#figures p").iter().map(words).collect();
        let is_worst = |p: &&String| p.ends_with(&format!("in the {is}'s frame."));
        let worst = paragraphs.iter().find(is_worst);
        let worst = worst.unwrap_or_else(|| panic!("{paragraphs:?}"));
        assert!(!worst.contains(is_not) && !worst.contains("+0"), "{worst}");
    }
}

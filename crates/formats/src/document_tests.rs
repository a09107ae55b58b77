//! Every field, number and range of every document, one by one: what is mistyped, absurd or reversed
//! is refused, and the message states what it should have been.

use super::ron_tokens::{Token, Tokens, place};
use super::{
    FormatError, baseline_file, body, computed_model, design_file, environment, generator,
    preferences_file, recent_file, recovery_file, room_metal, sweep_plan,
};
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;
use trackwright_design::view::Layer;
use trackwright_field::generator::Generator;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::volume::Volume;

type Parse = fn(&[u8]) -> Result<(), FormatError>;

/// A document. All of one kind together have every field that one of it may have.
struct Document {
    kind: &'static str,
    text: String,
    parse: Parse,
}

const DESIGN: &str = r#"(
    version: 1,
    name: "Pointer",
    environment: "or.env.ron",
    crf: (
        body: "head.body.ron",
        pose: (position: (-50.0, 0.0, -300.0), rotation: (1.0, 0.0, 0.0, 0.0)),
        targets: [(name: "sinus", position: (20.0, -40.0, -60.0))],
        motion: (x: (min: -1.0, max: 1.0, step: 1.0)),
        requirement: (position_rms: 1.0),
    ),
    tool: (
        body: "pointer.body.ron",
        pose: (position: (0.0, 0.0, 30.0), rotation: (1.0, 0.0, 0.0, 0.0)),
    ),
    motion: (
        pivot: Tip,
        x: (min: -50.0, max: 50.0, step: 50.0),
        y: (min: -50.0, max: 50.0, step: 50.0),
        z: (min: -50.0, max: 50.0, step: 50.0),
        rx: (min: -90.0, max: 90.0, step: 45.0),
        ry: (min: -90.0, max: 90.0, step: 45.0),
        rz: (min: -90.0, max: 90.0, step: 45.0),
    ),
    orientation_weight: 100.0,
    requirement: (position_rms: 1.0, position_p95: 1.5, position_max: 2.0, angle_rms: 0.5, angle_max: 1.0),
    procedure: (
        rooms: ["ward.env.ron"],
        crf: (
            date: "2005-10-25",
            note: "so be it",
            requirement: (position_rms: 1.0),
            rows: [(
                room: "OR",
                file: "or.env.ron",
                target: "sinus",
                trials: 3375,
                without_field: 12,
                position: (rms: 0.4, mean: 0.3, p95: 0.7, max: 0.9),
                angle: (rms: 0.131, p95: 0.2, max: 0.3),
                expected: true,
                verdict: Met,
                met: true,
            ), (
                room: "ward",
                file: "ward.env.ron",
                no_figures: "no such file",
            )],
        ),
        tool: (
            date: "2005-10-26",
            rows: [(
                room: "OR",
                file: "or.env.ron",
                trials: 8,
                position: (rms: 0.4, mean: 0.3, p95: 0.7, max: 0.9),
                angle: (rms: 0.131, p95: 0.2, max: 0.3),
            )],
        ),
        built: (
            date: "2005-10-27",
            note: "",
            room: "OR",
            file: "or.env.ron",
            table: "built.csv",
            crf_table: "crf.csv",
            frame: Crf,
            registered: true,
            averaged: 4,
            truth_mm: 0.05,
            tool: "probe",
            poses: 91,
            used: 45,
            measured_rms: 4.0,
            predicted_rms: 3.22,
            residual_rms: 1.67,
            explained: 0.83,
            slope: 1.1,
            statement: "83 % are explained.",
        ),
    ),
    anatomy: [(
        name: "skull",
        mesh: "skull.stl",
        mesh_unit: Factor(0.1),
        on: Tracker,
        pose: (position: (0.0, 0.0, 0.0), rotation: (1.0, 0.0, 0.0, 0.0)),
        color: (0.9, 0.9, 0.8),
        crf_patch: [(min: (-9.0, -9.0, 40.0), max: (9.0, 9.0, 60.0))],
    )],
    slides: [(
        title: "One",
        caption: "first: and only",
        figures: [WithinLimit],
        view: (layers: (ghost: false)),
    )],
    view: (
        camera: (focus_mm: (0.0, 0.0, -300.0), distance_mm: 900.0, azimuth_rad: 0.7, elevation_rad: 0.3, is_orthographic: true),
        layers: (LAYERS),
        hidden: [ToolSensor("shaft")],
        locked: [Crf],
        magnification: Times(50.0),
        slice: (
            quantity: TipErrorMm,
            axis: X,
            position_mm: -250.0,
            free: (normal: (0.0, 1.0, 1.0), offset_mm: -200.0),
            sensor_axis: (0.0, 0.0, 1.0),
            range_mm: 2.0,
            color_map: Inferno,
        ),
        arrows: (per_side: 7, of_tool: true, range_mm: 3.0),
        placement_rule: Normal,
        placement_depth: Own,
        placement_range_mm: 4.0,
    ),
)
"#;

const BODY: &str = r#"(
    version: 1,
    name: "Pointer",
    mesh: "pointer.stl",
    mesh_unit: Factor(25.4),
    tip: (0.0, 0.0, 1.0),
    sensors: [
        (name: "shaft", kind: FiveDof, position: (0.0, 0.0, 120.0), axis: (0.0, 0.0, 1.0), coil: (diameter: 0.8, length: 9.0)),
        (name: "handle", kind: SixDof, position: (12.0, 0.0, 150.0), rotation: (1.0, 0.0, 0.0, 0.0)),
    ],
    tool_definition: (kind: SawJson, file: "DEFINITION"),
    mounting: [
        Surface(axis: Normal, boxes: [(min: (0.0, -1.0, 2.0), max: (1.0, 1.0, 3.0))]),
        Channel(points: [(0.0, 0.0, 10.0), (0.0, 0.0, 130.0)], radius: 0.5, axis: Along),
        Seat(position: (1.0, 2.0, 3.0), axis: (0.0, 0.0, 1.0)),
    ],
    keep_out: [(min: (-5.0, -5.0, 0.0), max: (5.0, 5.0, 20.0))],
    least_gap: 9.0,
    tip_clearance: 5.0,
)
"#;

const DEFINITION: &str = r#"{"count": 3, "id": 7, "fiducials": [{"x": 0.0, "y": 26.87, "z": 3},
{"x": -23.69, "y": -22.77, "z": 3.0}, {"x": 26.12, "y": -27.14, "z": 3}], "pivot": {"x": 0, "y": -9, "z": 3}}"#;

const PREFERENCES: &str = r#"(
    version: 1,
    window: (1280, 720),
    is_maximised: false,
    is_light: true,
    scale: 1.25,
    panels: (left: true, right: true, history: false),
    workspace: "Design",
    widths: {"Design left": 312.0},
    is_legend_folded: true,
)
"#;

fn documents() -> Vec<Document> {
    let document = |kind, text: String, parse| Document { kind, text, parse };
    let layers: Vec<_> = Layer::ALL.iter().map(|layer| format!("{}: true", layer.field)).collect();
    let environment: Parse = |bytes| environment::parse(bytes).map(drop);
    let mut room = environment::tests::room();
    room.fit_validity = Some(environment::tests::support(&room));
    room.process = Some(Arc::new(environment::tests::process(true)));
    room.volume = Some(Volume::Box(Bounds::from(([-1.0, -2.0, -300.5], [1.0, 2.0, -0.1]))));
    let [kriging, mut harmonic] = computed_model::tests::environments();
    harmonic.name = "harmonic".to_owned();
    let mut generator = Generator::planar_nine();
    generator.coils.extend(Generator::anser().coils);
    let definition = data_encoding::BASE64.encode(DEFINITION.as_bytes());
    vec![
        document("design", DESIGN.replace("LAYERS", &layers.join(", ")), |bytes| {
            design_file::parse(bytes).map(drop)
        }),
        document("body", BODY.replace("DEFINITION", &definition), |bytes| {
            body::parse(bytes).map(drop)
        }),
        document(
            "environment",
            environment::write(&room, Some(&room_metal::tests::metal())),
            environment,
        ),
        document("environment", environment::write(&kriging, None), environment),
        document("environment", environment::write(&harmonic, None), environment),
        document("generator", generator::write(&generator), |bytes| {
            generator::parse(bytes).map(drop)
        }),
        document("preferences", PREFERENCES.to_owned(), |bytes| {
            preferences_file::parse(bytes).map(drop)
        }),
        document("recent designs", recent_file::write(&["/a".into()]), |bytes| {
            recent_file::parse(bytes).map(drop)
        }),
        document("recovery", String::from_utf8(recovery_file::tests::good()).unwrap(), |bytes| {
            recovery_file::parse(bytes).map(drop)
        }),
        document("baseline", baseline_file::tests::good(), |bytes| {
            baseline_file::parse(bytes).map(drop)
        }),
        document("sweep", sweep_plan::tests::PLAN.to_owned(), |bytes| {
            sweep_plan::parse(bytes).map(drop)
        }),
    ]
}

impl Document {
    /// The message with another text in a place; none where it is accepted.
    fn refusal(&self, range: &Range<usize>, with: &str) -> Option<String> {
        let text = [&self.text[..range.start], with, &self.text[range.end..]].concat();
        (self.parse)(text.as_bytes()).err().map(|e| e.to_string())
    }

    /// Where the names of fields stand.
    fn fields(&self) -> Vec<Range<usize>> {
        let tokens: Vec<_> = Tokens::of(&self.text).collect();
        let pairs = tokens.iter().zip(tokens.iter().skip(1));
        let fields =
            pairs.filter(|(name, sign)| name.0 == Token::Word && sign.0 == Token::Sign(':'));
        fields.map(|(name, _)| name.1.clone()).collect()
    }

    /// Where the names of variants stand.
    fn variants(&self) -> Vec<Range<usize>> {
        let fields = self.fields();
        let words = Tokens::of(&self.text).filter(|(token, _)| *token == Token::Word);
        let words = words.map(|(_, range)| range);
        let is_value = |word: &str| matches!(word, "true" | "false" | "inf" | "Some" | "None");
        words
            .filter(|range| !fields.contains(range) && !is_value(&self.text[range.clone()]))
            .collect()
    }

    fn numbers(&self) -> Vec<Range<usize>> {
        let numbers = Tokens::of(&self.text).filter(|(token, _)| *token == Token::Number);
        numbers.map(|(_, range)| range).collect()
    }

    /// The value of the field whose name ends there.
    fn value_after(&self, end: usize) -> &str {
        let mut depth = 0;
        let mut last = end;
        let tokens = Tokens::of(&self.text).filter(|(_, range)| range.start >= end);
        for (token, range) in tokens.skip(1) {
            match token {
                Token::Sign('(' | '[') => depth += 1,
                Token::Sign(')' | ']') => depth -= 1,
                _ => {}
            }
            if depth < 0 || (depth == 0 && token == Token::Sign(',')) {
                break;
            }
            last = range.end;
        }
        self.text[end..last].trim_start_matches(':').trim_start()
    }

    /// The field whose value something is in.
    fn field_of(&self, at: usize) -> &str {
        let fields = self.fields();
        let field = fields.iter().rfind(|field| field.end <= at).unwrap();
        &self.text[field.clone()]
    }

    /// A place for a message of a test.
    fn at(&self, range: &Range<usize>) -> String {
        let (line, column) = place(&self.text, range.start);
        format!("{} line {line}, column {column}", self.kind)
    }
}

/// A letter exchanged with the next, a letter less, a letter twice: each another name.
fn misspelt(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let is_name = |letters: &[char]| letters.first().is_some_and(|c| !c.is_ascii_digit());
    let mut all = BTreeSet::new();
    // The last that is a name, so that it is not always the first letter that is wrong.
    let exchanged = (1..letters.len()).rev().find_map(|at| {
        let mut other = letters.clone();
        other.swap(at - 1, at);
        (other != letters && is_name(&other)).then_some(other)
    });
    let dropped = (0..letters.len()).rev().find_map(|at| {
        let mut other = letters.clone();
        other.remove(at);
        is_name(&other).then_some(other)
    });
    let middle = letters.len() / 2;
    let mut doubled = letters.clone();
    doubled.insert(middle, letters[middle]);
    all.extend(exchanged.into_iter().chain(dropped).chain([doubled]));
    all.into_iter().map(String::from_iter).collect()
}

#[test]
fn the_documents_have_every_field() {
    let documents = documents();
    for document in &documents {
        (document.parse)(document.text.as_bytes())
            .unwrap_or_else(|error| panic!("{}: {error}", document.kind));
        let of_kind = documents.iter().filter(|other| other.kind == document.kind);
        let has: BTreeSet<&str> = of_kind
            .flat_map(|other| {
                let fields = other.fields().into_iter();
                fields.map(|field| &other.text[field])
            })
            .collect();
        // The program itself lists which fields a struct may have.
        for field in document.fields() {
            let stranger = document.refusal(&(field.start..field.start), "qqqqqqqqqq: 0, ");
            let Some(message) = stranger else {
                // A layer that is like none is one that this program was built without.
                let name = document.text[field].to_owned();
                assert!(
                    Layer::ALL.iter().any(|layer| layer.field == name),
                    "{}: {name}",
                    document.kind
                );
                continue;
            };
            let (_, known) = match message.split_once("field `qqqqqqqqqq`, expected ") {
                Some(parts) => parts,
                None => panic!("{}: {message}", document.at(&field)),
            };
            for name in known.split(" or ").map(|name| name.trim_matches('`')) {
                assert!(has.contains(name), "{} has no {name}", document.kind);
            }
        }
        if document.kind == "design" {
            assert!(Layer::ALL.iter().all(|layer| has.contains(layer.field)));
        }
    }
}

#[test]
fn every_misspelt_field_is_corrected() {
    let (mut tried, mut accepted) = (0, 0);
    for document in documents() {
        for field in document.fields() {
            let right = &document.text[field.clone()];
            for wrong in misspelt(right) {
                tried += 1;
                let Some(message) = document.refusal(&field, &wrong) else {
                    accepted += 1;
                    continue;
                };
                let (line, column) = place(&document.text, field.start);
                let begins = format!("line {line}, column {column}: found ");
                // Where a name less a letter is another field, there is that field twice.
                let is_named = match message.strip_prefix(&begins) {
                    Some(rest) if rest.starts_with("the unknown field") => {
                        rest.contains(&format!("`{wrong}`, "))
                            && rest.contains(&format!("`{right}`"))
                    }
                    Some(rest) => rest.starts_with(&format!("field `{wrong}` twice")),
                    // The other one comes later, and is the second then.
                    None => message.contains(&format!("found field `{wrong}` twice")),
                };
                assert!(is_named, "{}: {wrong}: {message}", document.at(&field));
            }
        }
    }
    assert_eq!(accepted, 0, "of {tried} misspelt fields");
    assert!(tried >= MISSPELT, "{tried} misspelt fields");
}

/// As many as there were when this was written.
const MISSPELT: usize = 1195;

#[test]
fn every_misspelt_variant_is_corrected() {
    let mut tried = 0;
    for document in documents() {
        for variant in document.variants() {
            let right = &document.text[variant.clone()];
            for wrong in misspelt(right) {
                tried += 1;
                let message = document.refusal(&variant, &wrong).unwrap_or_default();
                let (line, column) = place(&document.text, variant.start);
                let begins = format!("line {line}, column {column}: found `{wrong}`, expected ");
                let named = message.strip_prefix(&begins);
                assert!(
                    named.is_some_and(|known| known.contains(&format!("`{right}`"))),
                    "{}: {wrong}: {message}",
                    document.at(&variant)
                );
            }
        }
    }
    assert!(tried >= VARIANTS, "{tried} misspelt variants");
}

/// As many as there were when this was written.
const VARIANTS: usize = 157;

#[test]
fn a_field_twice_is_refused() {
    for document in documents() {
        for field in document.fields() {
            let name = &document.text[field.clone()];
            let value = document.value_after(field.end);
            let twice = format!("{name}: {value}, ");
            let message = document.refusal(&(field.start..field.start), &twice);
            let (line, column) = place(&document.text, field.start);
            let column = match value.rsplit_once('\n') {
                None => column + twice.chars().count(),
                Some((_, last)) => last.chars().count() + 3,
            };
            let line = line + value.matches('\n').count();
            let expected = format!(
                "line {line}, column {column}: found field `{name}` twice, expected it once"
            );
            assert_eq!(message, Some(expected), "{}", document.at(&field));
        }
    }
}

#[test]
fn newer_versions_are_reported_before_their_fields() {
    for document in documents() {
        let newer = document.text.replacen("version: 1", "qqq: (7), version: 9", 1);
        let error = (document.parse)(newer.as_bytes()).unwrap_err().to_string();
        let expected = "version is 9, expected 1; a newer trackwright wrote it";
        assert_eq!(error, expected, "{}", document.kind);
    }
}

/// Fields whose numbers are no lengths: directions, which are normalised, and what a fit found.
const NO_LENGTHS: [&str; 20] = [
    "axis",
    "coefficients",
    "covariance",
    "from",
    "to",
    "values",
    "greatest_leverage",
    "greatest_undetermined",
    "leverage",
    "moment",
    "normal",
    "nugget",
    "position_std_mm",
    "angle_std_rad",
    "position_rms_mm",
    "ridge",
    "rotation",
    "undetermined",
    "variance",
    "weights",
];

/// Likewise, of which only some numbers are lengths.
const NOT_ALL_LENGTHS: [&str; 6] =
    ["rows", "angle_rms_rad", "axis_sine", "x_axis_sine", "sensor_variance", "sensor_axis"];

#[test]
fn absurd_numbers_are_refused_one_by_one() {
    let mut tried = 0;
    for document in documents() {
        for number in document.numbers() {
            let field = document.field_of(number.start);
            for absurd in ["1e308", "-1e308", "1e999"] {
                tried += 1;
                let message = document.refusal(&number, absurd);
                let message =
                    message.unwrap_or_else(|| panic!("{}: {absurd}", document.at(&number)));
                // Of an integer the digits before the exponent are read alone.
                let is_named = message.contains(absurd)
                    || message.contains("found ")
                    || message.contains(" is ");
                assert!(is_named, "{}: {message}", document.at(&number));
            }
            // Below what no number may be, and more than any length.
            let message = document.refusal(&number, "1e29");
            let may_be = NO_LENGTHS.contains(&field) || NOT_ALL_LENGTHS.contains(&field);
            assert!(message.is_some() || may_be, "{} {field}: 1e29 mm", document.at(&number));
        }
    }
    assert!(tried > 1000, "{tried}");
}

/// Where two numbers or lists of them stand that are the ends of a range.
fn ranges(document: &Document) -> Vec<(Range<usize>, Range<usize>)> {
    let tokens: Vec<_> = Tokens::of(&document.text).collect();
    let text = |at: usize| &document.text[tokens[at].1.clone()];
    let numbers_from = |at: usize, count: usize| -> Vec<Range<usize>> {
        let numbers = tokens[at..].iter().filter(|(token, _)| *token == Token::Number);
        numbers.take(count).map(|(_, range)| range.clone()).collect()
    };
    let mut found = Vec::new();
    for at in 0..tokens.len().saturating_sub(1) {
        match (text(at), text(at + 1)) {
            ("min", ":") if tokens[at + 2].0 != Token::Sign('(') => {
                let ends = numbers_from(at, 2);
                found.push((ends[0].clone(), ends[1].clone()));
            }
            // Two corners, in which each axis has its own range.
            ("min" | "box", ":") | ("Box", "(") => {
                let corners = numbers_from(at, 6);
                let pairs = (0..3).map(|k| (corners[k].clone(), corners[k + 3].clone()));
                found.extend(pairs);
            }
            _ => {}
        }
    }
    found
}

#[test]
fn every_reversed_range_is_named() {
    let mut tried = 0;
    for document in documents() {
        for (min, max) in ranges(&document) {
            tried += 1;
            let text = [
                &document.text[..min.start],
                "6.25",
                &document.text[min.end..max.start],
                "-7.5",
                &document.text[max.end..],
            ]
            .concat();
            let error = (document.parse)(text.as_bytes()).unwrap_err().to_string();
            let is_named =
                error.contains("6.25") && error.contains("-7.5") && error.contains("min");
            assert!(is_named, "{}: {error}", document.at(&min));
        }
    }
    // Seven ranges of motion; three boxes of a model, one of a volume, two of a body, one of anatomy;
    // six axes of a sweep's motion.
    assert_eq!(tried, 7 + 3 * 7 + 6);
}

//! Metal that was found in a measurement table, as a result, and in words that the editor has too.

use trackwright_field::generator::Generator;
use trackwright_metal::identify::compare::{Compared, ComparedModel};
use trackwright_metal::identify::{
    BodyForm, Form, FoundBody, Identification, IdentifySettings, Interval, KnownBody, MetalKind,
    Verdict,
};
use trackwright_result::{Section, Table, data, with_separators};

/// What a body does to fields, in a word.
pub fn kind_name(kind: MetalKind) -> &'static str {
    match kind {
        MetalKind::Conductor => "conductor",
        MetalKind::Ferromagnetic => "ferromagnetic",
    }
}

/// How a flat or long body is turned, with the 95 % interval of its axis.
pub fn form_line(form: &BodyForm) -> String {
    let [x, y, z] =
        <[f64; 3]>::from(form.axis.into_inner()).map(|v| (100.0 * v).round() / 100.0 + 0.0);
    let what = match form.form {
        Form::Plate => "flat, its normal",
        Form::Rod => "long, its axis",
    };
    let within_deg = form.axis_within95_rad.to_degrees();
    format!("{what} along ({x:.2}, {y:.2}, {z:.2}) ± {within_deg:.0}°")
}

/// How many bodies were found, or why there is no answer.
pub fn verdict_line(found: &Identification) -> String {
    let count = found.bodies.len();
    let bodies = if count == 1 { "1 body".to_owned() } else { format!("{count} bodies") };
    match found.verdict {
        Verdict::Found => match found.determined().count() {
            all if all == count => format!("found {bodies}"),
            some => format!("found {some} of {bodies}; cannot tell where the rest is"),
        },
        Verdict::NothingFound => {
            "nothing found: bodies explain samples held out no better than noise does".to_owned()
        }
        Verdict::NotCompact if count == 0 => format!(
            "cannot tell: a disturbance of {:.2} mm that compact bodies do not explain",
            found.disturbance.position_mm
        ),
        Verdict::CannotTell => {
            format!("cannot tell: {bodies} explain a disturbance, but none is determined")
        }
        Verdict::NotCompact => format!(
            "cannot tell: {bodies} leave {:.0} % of the disturbance",
            100.0 * found.unexplained
        ),
    }
}

/// What the bodies leave, where that is more than noise.
pub fn misfit_line(found: &Identification) -> Option<String> {
    (found.is_misfit() && !found.bodies.is_empty()).then(|| {
        let left_mm = found.unexplained * found.disturbance.position_mm;
        format!("a disturbance of {left_mm:.2} mm is left that compact bodies do not explain")
    })
}

/// A model that the bodies are compared with.
pub fn compared_name(model: ComparedModel) -> String {
    match model {
        ComparedModel::None => "not corrected".to_owned(),
        ComparedModel::Bodies => "the bodies found".to_owned(),
        ComparedModel::Harmonic { degree } => format!("harmonic, degree {degree}"),
        ComparedModel::PerDirection(candidate) => format!(
            "Bernstein, order {}, orientations {}",
            candidate.order,
            candidate.directions.len()
        ),
    }
}

/// All that was found in a table of measurements; `of` is what these are, in words.
pub fn metal_section(
    of: &str,
    (generator, settings): (&Generator, &IdentifySettings),
    found: &Identification,
    compared: &[Compared],
) -> Section {
    let (noise, disturbance) = (&found.noise, &found.disturbance);
    let [noise_deg, disturbance_deg] =
        [noise, disturbance].map(|errors| errors.rotation_rad.to_degrees());
    let (noise_mm, disturbance_mm) = (noise.position_mm, disturbance.position_mm);
    let contradict = (found.down_weighted > 0).then(|| {
        let count = with_separators(found.down_weighted);
        format!("{count} samples contradict the others and count for less")
    });
    let bodies = Section::default()
        .with(verdict_line(found))
        .with_all((1..).zip(&found.bodies).flat_map(|(number, body)| body_lines(number, body)))
        .with(bodies_table(&found.bodies))
        .with_all(misfit_line(found));
    let folds = settings.folds;
    let table = Table::of("", &compared_rows(compared))
        .text("", "model", |[model, ..]| model.clone())
        .number("", "position RMS, mm", 0, |[_, position, _]| position.clone())
        .number("", "angle RMS, °", 0, |[.., angle]| angle.clone())
        .done();
    let held_out = (!compared.is_empty()).then(|| format!("held out by row, {folds} folds:"));
    Section::of([
        data("verdict", found.verdict),
        data("generator", &generator.name),
        data("samples", found.measurements),
        data("down_weighted", found.down_weighted),
        data("noise_mm", noise_mm),
        data("noise_deg", noise_deg),
        data("disturbance_rms_mm", disturbance_mm),
        data("disturbance_rms_deg", disturbance_deg),
        data("unexplained", found.unexplained),
        data("model", found.model),
        data("tried", &found.tried),
        data("folds", folds),
        data("held_out", compared.iter().map(compared_section).collect::<Vec<_>>()),
    ])
    .with(format!("{of}, generator {}", generator.name))
    .with(format!(
        "noise {noise_mm:.3} mm and {noise_deg:.3}° a component; disturbance {disturbance_mm:.3} mm and \
         {disturbance_deg:.3}° RMS"
    ))
    .with_all(contradict)
    .with(bodies)
    .with(Section::default().with_all(held_out).with(table))
}

fn bodies_table(bodies: &[FoundBody]) -> Table {
    fn known<T>(value: impl Fn(&FoundBody, &KnownBody) -> T) -> impl Fn(&FoundBody) -> Option<T> {
        move |body| body.known.as_ref().ok().map(|known| value(body, known))
    }
    let ends = |interval: &Interval| [interval.low, interval.high];
    let form = |known: &KnownBody| known.form;
    Table::of("bodies", bodies)
        .data("kind", known(|body, _| kind_name(body.kind)))
        .data("is_determined", |body| body.known.is_ok())
        .data("doubt", |body| body.doubt().map(ToString::to_string))
        .data("center_mm", known(|body, _| <[f64; 3]>::from(body.source.center_mm.coords)))
        .data("center_within95_mm", known(move |_, of| of.center_mm.map(|i| ends(&i))))
        .data("center_cov_mm2", known(|_, of| <[[f64; 3]; 3]>::from(of.center_cov_mm2.transpose())))
        .data("half_length_mm", known(|_, of| of.half_length_mm))
        .data("strength_mm3", known(|body, _| body.source.strength_mm3))
        .data("strength_within95_mm3", known(move |_, of| ends(&of.strength_mm3)))
        .data("radius_mm", known(|body, _| body.source.radius_mm()))
        .data("radius_within95_mm", known(move |_, of| ends(&of.radius_mm)))
        .data("strengths_mm3", known(|_, of| of.strengths_mm3))
        .data("form", known(move |_, of| form(of).map(|form| form_name(form.form))))
        .data("axis", known(move |_, of| form(of).map(|f| <[f64; 3]>::from(f.axis.into_inner()))))
        .data(
            "axis_within95_deg",
            known(move |_, of| form(of).map(|form| form.axis_within95_rad.to_degrees())),
        )
        .data("nearest_sample_mm", known(|body, _| body.nearest_mm))
        .done()
}

fn form_name(form: Form) -> &'static str {
    match form {
        Form::Plate => "plate",
        Form::Rod => "rod",
    }
}

fn body_lines(number: usize, body: &FoundBody) -> Vec<String> {
    let known = match &body.known {
        Ok(known) => known,
        Err(doubt) => return vec![format!("{number}  cannot tell: {doubt}")],
    };
    let (kind, center) = (kind_name(body.kind), body.source.center_mm);
    // Plus zero makes of a rounded -0 a 0.
    let tenths = |value_mm: f64| (10.0 * value_mm).round() / 10.0 + 0.0;
    let axis =
        |k: usize| format!("{:.1} ± {:.1}", tenths(center[k]), known.center_mm[k].half_length());
    let mut lines = vec![
        format!(
            "{number}  {kind}, like a sphere of {:.1} mm radius ({:.1} to {:.1})",
            body.source.radius_mm(),
            known.radius_mm.low,
            known.radius_mm.high
        ),
        format!("   at x {}, y {}, z {} mm (95 %)", axis(0), axis(1), axis(2)),
        format!(
            "   strength {:.0} mm³ ({:.0} to {:.0}), nearest sample {:.0} mm away",
            body.source.strength_mm3,
            known.strength_mm3.low,
            known.strength_mm3.high,
            body.nearest_mm
        ),
    ];
    lines.extend(known.form.as_ref().map(|form| format!("   {}", form_line(form))));
    lines
}

/// What models leave of samples held out: position RMS in mm, and angle RMS in degrees where it is
/// known.
pub fn compared_rows(compared: &[Compared]) -> Vec<[String; 3]> {
    let row = |compared: &Compared| {
        let overall = &compared.scores.overall;
        let angle = overall.angle_rms_rad;
        [
            compared_name(compared.model),
            format!("{:.4}", overall.position_rms_mm),
            angle.map_or_else(|| "–".to_owned(), |angle| format!("{:.4}", angle.to_degrees())),
        ]
    };
    compared.iter().map(row).collect()
}

/// What a model leaves, for programs.
fn compared_section(compared: &Compared) -> Section {
    let (name, more) = match compared.model {
        ComparedModel::None => ("none", Vec::new()),
        ComparedModel::Bodies => ("bodies", Vec::new()),
        ComparedModel::Harmonic { degree } => ("harmonic", vec![data("degree", degree)]),
        ComparedModel::PerDirection(candidate) => {
            let directions = candidate.directions.len();
            let [order, ridge] = [data("order", candidate.order), data("ridge", candidate.ridge)];
            ("bernstein", vec![order, data("directions", directions), ridge])
        }
    };
    let overall = &compared.scores.overall;
    Section::of([
        data("model", name),
        data("position_rms_mm", overall.position_rms_mm),
        data("angle_rms_deg", overall.angle_rms_rad.map(f64::to_degrees)),
    ])
    .with_all(more)
}

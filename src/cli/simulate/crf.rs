//! `simulate --body crf`: step 2 of the paper's design procedure, the CRF alone against the tracker.

use super::{ModeArg, SimulateArgs, as_json, note_world, simulate, study_text};
use crate::cli::output::{self, Format};
use anyhow::{Context, bail};
use serde_json::{Value, json};
use trackwright_project::Files;
use trackwright_simulation::Mode;

/// Simulates the CRF at each of its targets, and prints the figures.
pub(super) fn run(args: &SimulateArgs, asked: ModeArg, files: &Files) -> anyhow::Result<()> {
    let file = args.design.display();
    let world = files.open_design_without_meshes(&args.design)?;
    let design = world.document.design();
    let Some(crf) = &design.crf else {
        bail!("{file}: the design has no CRF to simulate");
    };
    let mode = match asked {
        ModeArg::Single => Mode::Single,
        ModeArg::Motion if crf.motion.is_none() => {
            bail!("{file}: crf.motion is absent, expected the CRF's own range of motion");
        }
        ModeArg::Motion => Mode::Motion,
        ModeArg::Input => bail!("--body crf takes --mode single or motion, not input"),
    };
    for (is_given, flag) in [
        (args.log.is_some(), "--log"),
        (args.support, "--support"),
        (args.explain, "--explain"),
        (args.uncertainty.is_asked(), "--uncertainty"),
    ] {
        if is_given {
            bail!("{flag} is of the tool's study, not of the CRF's");
        }
    }
    note_world(&world);
    let mut texts = Vec::new();
    let mut values: Vec<Value> = Vec::new();
    for judged in trackwright_project::resolve_crf(design, &world.environment) {
        let mut scenario = judged.scenario;
        scenario.outside = args.outside.into();
        let (outcome, last) =
            simulate(&scenario, &mode, None).with_context(|| args.design.display().to_string())?;
        let single = last.filter(|_| asked == ModeArg::Single);
        let at = match &judged.target {
            Some(target) => format!(" at {target}"),
            None => String::new(),
        };
        let name = &crf.body.rigid.name;
        let title = output::head(&format!("{name}{at}, alone"), &world.environment.name);
        let expected = crate::cli::expected::of(&scenario, &mode)?;
        texts.push(study_text(&title, &outcome, single.as_ref(), expected.as_ref()));
        let mut value = as_json(&outcome.figures, single.as_ref());
        if let Some(expected) = &expected {
            let bounds = trackwright_simulation::expected::judged(&outcome.figures, Some(expected));
            crate::cli::expected::add_json(&mut value, expected, &bounds);
        }
        value["target"] = json!(judged.target);
        values.push(value);
    }
    match args.format {
        Format::Json => output::print_json(&json!({
            "crf": crf.body.rigid.name,
            "targets": values,
        })),
        Format::Text => output::print(&texts.join("\n\n")),
    }
}

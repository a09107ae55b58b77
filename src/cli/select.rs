//! `select`: cross-validates model sizes and regularisation, names the best, and fits it.

use super::choose;
use super::fit::{FittingArgs, Target, VolumeArg, fit_and_write, read};
use super::jitter::JitterArgs;
use super::model_kind::{LOSS, tried_kinds};
use super::prelude::*;
use super::registration::RegistrationArgs;
use trackwright_calibration::kind_choice::{KindChoice, TriedKind, best_kind};
use trackwright_calibration::learning_curve::{LEAST_ROWS, LearningPoint, doubled, learning_curve};
use trackwright_calibration::room_model::RoomModel;
use trackwright_calibration::row_labels::{HeldOut, RowLabels};
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::{DEFAULT_FOLDS, DEFAULT_RIDGES, DEFAULT_SEED, SelectSettings};
use trackwright_geometry::directions::DirectionSet;
use trackwright_report::room_section::fit_section;
use trackwright_report::selection_section::{curve_items, selection_section};
use trackwright_report::{learning_chart, selection_chart};
use trackwright_result::data;

/// Orders that are tried where none are named.
const DEFAULT_ORDERS: &str = "1-6";

/// Size of the chart in pixels.
const CHART_SIZE: (u32, u32) = (960, 640);

/// Cross-validate model sizes and regularisation on measurements, and name the best
#[derive(Debug, Args)]
pub struct SelectArgs {
    /// Measurement table (CSV): ideal_x … ideal_qz, measured_x … measured_qz; mm, unit quaternions
    data: PathBuf,

    /// Kinds of models to try on the same rows held out, of none (no correction), bernstein (the paper's),
    /// symmetric (Bernstein with an axis turned round having the same error), kriging and harmonic. Where
    /// left out, bernstein where an option of polynomials is given, else all. A kind that leaves twice as much as another in the first rows is tried no further
    #[arg(long, value_name = "LIST")]
    models: Option<String>,

    /// Field generators of harmonic models, each of them tried: planar-nine, anser, a file
    /// (*.generator.ron), or learn; the built-in ones and learn where left out
    #[arg(long, value_name = "NAME|FILE|learn,…")]
    generator: Option<String>,

    /// Degree of harmonic models, 1 to 10; 2 to 8 are tried where left out
    #[arg(long, value_name = "L")]
    degree: Option<usize>,

    /// How the measurements of harmonic models count
    #[arg(long, value_parser = LOSS, default_value = "huber")]
    loss: Loss,

    /// Orders to try, as 1-6 or 1,2,4; 0, no correction, is tried always
    #[arg(long, value_name = "LIST", default_value = DEFAULT_ORDERS)]
    orders: String,

    /// Numbers of basis orientations to try, of 1, 6, 12, 14, 26 and 42; all that the table has
    /// orientations for where left out
    #[arg(long, value_name = "LIST")]
    directions: Option<String>,

    /// Ridges to try, each a part of the largest singular value; 0 and half decades from 1e-6 to
    /// 1 where left out
    #[arg(long, value_name = "LIST")]
    ridges: Option<String>,

    /// Parts that the rows are split into, each held out once
    #[arg(long, value_name = "K", default_value_t = DEFAULT_FOLDS)]
    folds: usize,

    /// Column that states which rows belong together; cluster, frame or pose where the table has
    /// one, else the clusters or places that the data show, if any
    #[arg(long, value_name = "COLUMN")]
    group: Option<String>,

    /// What is held out to choose by: rows, groups (as given by --group), sensors (by the column
    /// sensor), or a column whose rows with equal text belong together; groups where there are any,
    /// else rows, where left out. The others are reported
    #[arg(long, value_name = "rows|groups|sensors|COLUMN")]
    hold_out: Option<HeldOut>,

    /// Seed of the random folds
    #[arg(long, value_name = "N", default_value_t = DEFAULT_SEED)]
    seed: u64,

    /// Environment to write (*.env.ron): the chosen model, fitted to all rows
    #[arg(short, long, value_name = "ENV")]
    output: Option<PathBuf>,

    /// Chart to write: what is left of held-out rows against order, one line a set of orientations
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,

    /// Chart to write: what each kind of model leaves of held-out rows against how many there are. The
    /// kinds are tried once for each number, on rows taken by chance
    #[arg(long, value_name = "FILE.svg")]
    learning_curve: Option<PathBuf>,

    /// Numbers of rows of the learning curve, as 250,500,1000; all, a half, a quarter and so on where
    /// left out
    #[arg(long, value_name = "LIST", requires = "learning_curve")]
    rows: Option<String>,

    #[command(flatten)]
    fitting: FittingArgs,

    /// The tracker's measurement volume, where it is known, for the environment
    #[arg(long, value_enum, default_value_t, requires = "output")]
    volume: VolumeArg,

    #[command(flatten)]
    jitter: JitterArgs,

    #[command(flatten)]
    registration: RegistrationArgs,

    #[command(flatten)]
    common: TableArgs,
}

/// Cross-validates, prints the table, and writes what was requested.
///
/// # Errors
/// Files that can't be used, lists that name nothing to try, rows that can't be folded.
pub fn run(args: &SelectArgs, files: &Files) -> anyhow::Result<()> {
    let environment = files.optional_output(args.output.as_deref())?;
    if let Some(environment) = &environment {
        environment.expect_own()?;
    }
    let plot = files.optional_output(args.plot.as_deref())?;
    let curve_output = files.optional_output(args.learning_curve.as_deref())?;
    let mut settings = settings(args)?;
    let samples = read(files, &args.data, args.fitting.reading()?, args.common.as_is)?;
    if args.directions.is_none() && !samples.has_rotations {
        settings.direction_sets = vec![DirectionSet::One];
    }
    let labels = choose::row_labels(
        files,
        &args.data,
        &samples,
        args.group.as_deref(),
        args.hold_out.as_ref(),
    )?;
    // An option of polynomials names them.
    let models = args.models.as_deref();
    let models = models.or_else(|| has_polynomial_options(args).then_some("bernstein"));
    let kinds = tried_kinds(
        files,
        models,
        args.generator.as_deref(),
        args.degree,
        args.loss,
        (&samples, settings.map),
    )?;
    refuse_unused(args, &kinds)?;
    let curve = learning_points(args, &samples, &labels, &settings, &kinds)?;
    let (chosen, choice) = if kinds == [TriedKind::Bernstein] {
        let chosen = choose::cross_validate(&args.data, &samples, labels, settings)?;
        (chosen, None)
    } else {
        // What cannot be chosen is listed where the kinds are named.
        settings.only_contenders = models.is_none();
        let shown = Shown::new("cross-validating");
        let (chosen, choice) = best_kind(&samples, labels, &settings, &kinds, &shown.task)
            .with_context(|| args.data.display().to_string())?;
        (chosen, Some(choice))
    };
    let name = file_name(&args.data);
    let mut found = selection_section(&name, samples.samples.len(), &chosen, choice.as_ref());
    if let Some(output) = &environment {
        let target = Target {
            data: &args.data,
            output,
            volume: args.volume,
            jitter: args.jitter.jitter(),
            registration: args.registration.error(),
            with_support: true,
            sensors: chosen.selection.sensors,
        };
        let best = choice.as_ref().map(KindChoice::best);
        let fit_settings = match best {
            Some(kind) => kind.settings(&chosen.tried),
            None => chosen.settings(),
        };
        let model = best.map_or(RoomModel::PAPER, |kind| kind.model.clone());
        let room = fit_and_write(&target, &model, &fit_settings, &samples, None)?;
        found = found
            .with(data("fit", fit_section(&name, &fit_settings, &room)))
            .with(format!("written to {}", output.file().display()));
    }
    if let Some(plot) = &plot {
        let chart = selection_chart::chart(&name, &chosen.selection);
        plot.write_bytes(chart.to_svg(CHART_SIZE).as_bytes())?;
        found = found.with(format!("drawn to {}", plot.file().display()));
    }
    if let (Some(output), Some(points)) = (&curve_output, &curve) {
        let chart = learning_chart::chart(&name, points);
        output.write_bytes(chart.to_svg(CHART_SIZE).as_bytes())?;
        found = found
            .with_all(curve_items(points))
            .with(format!("drawn to {}", output.file().display()));
    }
    output::print_section(args.common.format, &found)
}

/// Options that only polynomials have, and whether each is given.
fn polynomial_options(args: &SelectArgs) -> impl Iterator<Item = (&'static str, bool)> {
    let of_lists = [
        ("--orders", args.orders != DEFAULT_ORDERS),
        ("--directions", args.directions.is_some()),
        ("--ridges", args.ridges.is_some()),
    ];
    of_lists.into_iter().chain(args.fitting.of_polynomials())
}

fn has_polynomial_options(args: &SelectArgs) -> bool {
    polynomial_options(args).any(|(_, is_given)| is_given)
}

/// Refuses what none of the kinds that are tried would look at.
fn refuse_unused(args: &SelectArgs, kinds: &[TriedKind]) -> anyhow::Result<()> {
    let is_bernstein =
        |kind: &TriedKind| matches!(kind, TriedKind::Bernstein | TriedKind::Symmetric);
    let given = polynomial_options(args).find(|(_, is_given)| *is_given);
    if let (Some((name, _)), false) = (given, kinds.iter().any(is_bernstein)) {
        bail!("{name} belongs to Bernstein polynomials, which --models does not name");
    }
    if args.registration.error().is_some() && args.output.is_none() {
        bail!("--registration-mm is for the environment, expected --output with it");
    }
    if args.jitter.jitter().is_some() && args.output.is_none() {
        bail!("--jitter-position-mm is for the environment, expected --output with it");
    }
    Ok(())
}

/// The kinds on some of the rows, where a learning curve is requested.
fn learning_points(
    args: &SelectArgs,
    samples: &SampleSet,
    labels: &RowLabels,
    settings: &SelectSettings,
    kinds: &[TriedKind],
) -> anyhow::Result<Option<Vec<LearningPoint>>> {
    if args.learning_curve.is_none() {
        return Ok(None);
    }
    let all = samples.samples.len();
    let expected = "numbers of rows, 50 and more, no more than the table has";
    let sizes = match &args.rows {
        None => doubled(all),
        Some(list) => numbers::<usize>("--rows", list, expected)?,
    };
    if let Some(size) = sizes.iter().find(|s| !(LEAST_ROWS..=all).contains(s)) {
        bail!("--rows: found {size}, expected {expected} ({all})");
    }
    if sizes.is_empty() {
        bail!("--learning-curve: found {all} rows, expected {LEAST_ROWS} at least");
    }
    let shown = Shown::new("cross-validating some of the rows");
    let points = learning_curve(samples, labels, settings, kinds, &sizes, &shown.task)
        .with_context(|| args.data.display().to_string())?;
    Ok(Some(points))
}

fn settings(args: &SelectArgs) -> anyhow::Result<SelectSettings> {
    let mut orders = orders(&args.orders)?;
    orders.push(0);
    let direction_sets = match &args.directions {
        None => DirectionSet::ALL.to_vec(),
        Some(list) => numbers::<usize>("--directions", list, "1, 6, 12, 14, 26 or 42")?
            .into_iter()
            .map(|m| DirectionSet::try_from(m).context("--directions"))
            .collect::<Result<_, _>>()?,
    };
    let ridges = match &args.ridges {
        None => DEFAULT_RIDGES.to_vec(),
        Some(list) => numbers("--ridges", list, "numbers of zero or more")?,
    };
    Ok(SelectSettings {
        orders,
        direction_sets,
        ridges,
        folds: args.folds,
        seed: args.seed,
        method: args.fitting.method,
        map: args.fitting.map,
        weighting: args.fitting.weights,
        rcond: args.fitting.rcond,
        only_contenders: false,
    })
}

/// `1-3,6` as 1, 2, 3, 6.
fn orders(list: &str) -> anyhow::Result<Vec<usize>> {
    let mut orders = Vec::new();
    for item in list.split(',').map(str::trim) {
        let (first, last) = item.split_once('-').unwrap_or((item, item));
        match (first.trim().parse::<usize>(), last.trim().parse::<usize>()) {
            // A range up to a number beyond any order is refused by its ends, not by its length.
            (Ok(first), Ok(last)) if first <= last => {
                orders.extend([first, last]);
                orders.extend(first..=last.min(trackwright_field::bernstein::MAX_ORDER));
            }
            _ => bail!("--orders: found {list:?}, expected orders as in 1-6 or 1,2,4"),
        }
    }
    Ok(orders)
}

fn numbers<T: std::str::FromStr>(
    option: &str,
    list: &str,
    expected: &str,
) -> anyhow::Result<Vec<T>> {
    list.split(',')
        .map(|item| item.trim().parse().ok())
        .collect::<Option<Vec<T>>>()
        .with_context(|| format!("{option}: found {list:?}, expected a list of {expected}"))
}

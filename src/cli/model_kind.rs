//! What kind of model a room gets, as the command line names it.

use super::prelude::*;
use clap::ArgAction;
use trackwright_calibration::kind_choice::{TriedKind, TriedOptions};
use trackwright_calibration::room_model::{GeneratorChoice, HarmonicOrder, RoomModel};
use trackwright_field::computed::ModelKind;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::Loss;
use trackwright_field::harmonic::solid_harmonics::MAX_DEGREE;
use trackwright_field::samples::{MapKind, SampleSet};

const KIND: Choice<ModelKind> = Choice(&[
    ("bernstein", "Bernstein polynomials per basis orientation, the paper's", ModelKind::Bernstein),
    (
        "kriging",
        "The mean of a Gaussian process, of any shape the measurements show",
        ModelKind::Kriging,
    ),
    (
        "harmonic",
        "The fields of a generator's coils, disturbed by harmonic functions",
        ModelKind::Harmonic,
    ),
]);
pub(super) const LOSS: Choice<Loss> =
    Choice(&[("huber", "", Loss::Huber), ("squares", "", Loss::Squares)]);
const YES_OR_NO: Choice<bool> = Choice(&[("yes", "", true), ("no", "", false)]);

/// A model's kind, and what only that kind has.
#[derive(Debug, Args)]
pub(super) struct ModelArgs {
    /// Kind of model. harmonic needs --generator. Where left out, the best of all kinds on rows held out,
    /// as `select` finds it; bernstein where an option of polynomials is given
    #[arg(long, value_parser = KIND, value_name = "KIND")]
    model: Option<ModelKind>,

    /// Field generator of a harmonic model: planar-nine, anser, a file (*.generator.ron), or learn
    #[arg(long, value_name = "NAME|FILE|learn")]
    generator: Option<String>,

    /// Degree of a harmonic model, 1 to 10; from the number of measurements where left out
    #[arg(long, value_name = "L")]
    degree: Option<usize>,

    /// How the measurements of a harmonic model count: huber weighs down those that contradict the
    /// others, squares is plain least squares
    #[arg(long, value_parser = LOSS, default_value = "huber")]
    loss: Loss,

    /// Whether an axis turned round has the same error, as that of a 5-DOF coil has; of Bernstein
    /// polynomials, the other kinds always have it
    #[arg(long, value_parser = YES_OR_NO, default_value = "no", value_name = "yes|no",
        action = ArgAction::Set)]
    symmetric: bool,
}

impl ModelArgs {
    /// The kind as it was stated, or by options that only one kind has.
    ///
    /// # Errors
    /// How measurements count, where nothing names a kind that weighs them.
    pub fn kind(&self, has_polynomial_options: bool) -> anyhow::Result<Option<ModelKind>> {
        let of_options = match () {
            () if self.generator.is_some() || self.degree.is_some() => Some(ModelKind::Harmonic),
            () if self.symmetric || has_polynomial_options => Some(ModelKind::Bernstein),
            () if self.loss != Loss::default() => bail!("--loss belongs to --model harmonic"),
            () => None,
        };
        Ok(self.model.or(of_options))
    }

    /// A model of a kind, with its generator read; the ridge is of a harmonic one.
    ///
    /// # Errors
    /// Options of another kind, a degree beyond 1 to 10, a generator that can't be read.
    pub fn model(
        &self,
        kind: ModelKind,
        ridge: Option<f64>,
        files: &Files,
    ) -> anyhow::Result<RoomModel> {
        let is_harmonic = kind == ModelKind::Harmonic;
        if !is_harmonic && (self.generator.is_some() || self.degree.is_some()) {
            bail!("--generator and --degree belong to --model harmonic");
        }
        if !is_harmonic && self.loss != Loss::default() {
            bail!("--loss belongs to --model harmonic");
        }
        if kind != ModelKind::Bernstein && self.symmetric {
            bail!("--symmetric belongs to --model bernstein; the other kinds always are");
        }
        Ok(match kind {
            ModelKind::Bernstein => RoomModel::Bernstein { is_symmetric: self.symmetric },
            ModelKind::Kriging => RoomModel::Kriging,
            // No other is among the options.
            ModelKind::Harmonic | ModelKind::Simulated => {
                let Some(generator) = &self.generator else {
                    bail!(
                        "--model harmonic: found no --generator, expected planar-nine, anser, a file (*.generator.ron), or learn"
                    );
                };
                RoomModel::Harmonic(HarmonicOrder {
                    generator: generator_choice(files, generator)?,
                    degree: checked_degree(self.degree)?,
                    ridge,
                    loss: self.loss,
                })
            }
        })
    }
}

/// A degree that harmonics have.
pub(super) fn checked_degree(degree: Option<usize>) -> anyhow::Result<Option<usize>> {
    match degree {
        Some(degree) if !(1..=MAX_DEGREE).contains(&degree) => {
            bail!("--degree: found {degree}, expected 1 to {MAX_DEGREE}")
        }
        degree => Ok(degree),
    }
}

/// `learn`, a generator by its name, or one from a file.
///
/// # Errors
/// A file that can't be read as a generator.
pub(super) fn generator_choice(files: &Files, text: &str) -> anyhow::Result<GeneratorChoice> {
    if text == "learn" {
        return Ok(GeneratorChoice::Learned(None));
    }
    Ok(GeneratorChoice::Known(match Generator::built_in(text) {
        Some(generator) => generator,
        None => files.read_generator(Path::new(text))?,
    }))
}

/// The kinds of a list as in `bernstein,symmetric,kriging,harmonic`, or all that the samples can be fitted
/// with where there is none.
///
/// # Errors
/// A kind that is not one, options of kinds that are not named.
pub(super) fn tried_kinds(
    files: &Files,
    list: Option<&str>,
    generators: Option<&str>,
    degree: Option<usize>,
    loss: Loss,
    (samples, map): (&SampleSet, MapKind),
) -> anyhow::Result<Vec<TriedKind>> {
    let items = |list: &str| list.split(',').map(|name| name.trim().to_owned()).collect();
    let names: Option<Vec<String>> = list.map(items);
    let generators = generators.map(|list| {
        list.split(',')
            .map(|name| generator_choice(files, name.trim()))
            .collect::<Result<Vec<_>, _>>()
    });
    let generators = generators.transpose()?;
    let options = TriedOptions {
        names: names.as_deref(),
        generators: generators.as_deref(),
        degree: checked_degree(degree)?,
        loss,
    };
    options.kinds(samples, map).context("--models")
}

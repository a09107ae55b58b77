//! Metal that was found in a measurement table, in words: the same for the command line and the editor.

use trackwright_metal::identify::compare::{Compared, ComparedModel};
use trackwright_metal::identify::{Identification, MetalKind, Verdict};

/// What a body does to fields, in a word.
pub fn kind_name(kind: MetalKind) -> &'static str {
    match kind {
        MetalKind::Conductor => "conductor",
        MetalKind::Ferromagnetic => "ferromagnetic",
    }
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
        Verdict::CannotTell => {
            format!("cannot tell: {bodies} explain a disturbance, but none is determined")
        }
        Verdict::NotCompact => format!(
            "cannot tell: {bodies} leave {:.0} % of the disturbance",
            100.0 * found.unexplained
        ),
    }
}

/// What makes the intervals too short, where anything does.
pub fn misfit_line(found: &Identification) -> Option<String> {
    found.is_misfit().then(|| {
        format!(
            "The bodies leave {:.0} % of the disturbance: intervals do not contain what such a model lacks",
            100.0 * found.unexplained
        )
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

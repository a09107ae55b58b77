//! How a room's metal is simulated, in plain words.

use trackwright_metal::body::ResponseModel;
use trackwright_metal::furnished::{FurnishReport, MetalEvaluation, ObjectReport, TOLERANCE_MM};
use trackwright_result::with_separators;

/// One line an object, then how the objects see each other, and how poses were evaluated until now.
pub fn metal_lines(report: &FurnishReport) -> Vec<String> {
    let mut lines: Vec<_> = report.objects.iter().map(object_line).collect();
    if report.exchange.rounds > 0 {
        let (count, rounds) = (report.objects.len(), report.exchange.rounds);
        lines.push(format!("fields exchanged between {count} objects in {rounds} rounds"));
    }
    if report.objects.iter().any(|object| object.triangles > 0) {
        let percent = 100.0 * report.solution_error;
        lines.push(format!(
            "half as many triangles change the field in the volume by {percent:.1} %"
        ));
    }
    if report.is_added_to_errors {
        lines.push(
            "added to the errors of the measured room; what it does to other metal is left out"
                .to_owned(),
        );
    }
    lines.extend(evaluation_line(&report.evaluation));
    lines
}

fn object_line(object: &ObjectReport) -> String {
    let triangles = match (object.triangles, object.coarsened_from) {
        (0, _) => String::new(),
        (count, None) => format!("{} triangles, ", with_separators(count)),
        (count, Some(from)) => {
            format!("{} of {} triangles, ", with_separators(count), with_separators(from))
        }
    };
    format!("{}: {triangles}{}", object.name, model_words(&object.model))
}

/// What answers an object, within a sentence.
pub fn model_words(model: &ResponseModel) -> String {
    match model {
        ResponseModel::None => "neither magnetic nor conducting, no response".to_owned(),
        ResponseModel::SphereSeries => "a sphere, in closed form".to_owned(),
        ResponseModel::Permeable { relative_permeability } => {
            format!("permeable, no currents, µ {relative_permeability}")
        }
        ResponseModel::Conductor { skin_depth_mm } => {
            format!("its currents, at a skin depth of {skin_depth_mm:.2} mm")
        }
    }
}

fn evaluation_line(evaluation: &MetalEvaluation) -> Option<String> {
    match evaluation {
        MetalEvaluation::None => None,
        MetalEvaluation::Harmonic { degree } => Some(format!(
            "all poses by harmonic functions of degree {degree}, within {TOLERANCE_MM} mm"
        )),
        MetalEvaluation::Cells(cells) => {
            let counts = cells.counts();
            let poses = |count: u64| with_separators(count.try_into().unwrap_or(usize::MAX));
            Some(format!(
                "{} poses by harmonic functions in {} cells, within {TOLERANCE_MM} mm; {} in {} cells \
                 with the field of what is near itself",
                poses(counts.harmonic_poses),
                counts.harmonic_cells,
                poses(counts.direct_poses),
                counts.direct_cells
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_has_its_triangles_and_its_skin_depth() {
        let object = ObjectReport {
            name: "table".to_owned(),
            triangles: 1000,
            coarsened_from: Some(23_456),
            model: ResponseModel::Conductor { skin_depth_mm: 4.25 },
        };
        let solved = "table: 1,000 of 23,456 triangles, its currents, at a skin depth of 4.25 mm";
        assert_eq!(object_line(&object), solved);
    }
}

//! How a room's metal is simulated, in plain words.

use trackwright_metal::body::ResponseModel;
use trackwright_metal::furnished::{FurnishReport, MetalEvaluation, ObjectReport, TOLERANCE_MM};
use trackwright_metal::surface::Wall;
use trackwright_result::with_separators;

/// One line an object, then how the objects see each other, and how poses were evaluated until now.
pub fn metal_lines(report: &FurnishReport) -> Vec<String> {
    let mut lines: Vec<_> = report.objects.iter().map(object_line).collect();
    lines.extend(report.objects.iter().filter_map(|object| {
        Some(format!("{}: {}", object.name, thin_wall_words(object.thin_wall.as_ref()?)))
    }));
    if report.exchange.rounds > 0 {
        let (count, rounds) = (report.objects.len(), report.exchange.rounds);
        lines.push(format!("fields exchanged between {count} objects in {rounds} rounds"));
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

/// What has to be known of objects whose response is an estimate.
pub fn estimated_metal(report: &FurnishReport) -> Vec<String> {
    let estimated = report.objects.iter().filter(|object| object.model.is_estimate());
    let words = |object: &ObjectReport| {
        format!(
            "{}: {}; what it does may be up to that limit, which no interval includes",
            object.name,
            model_words(&object.model)
        )
    };
    estimated.map(words).collect()
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

/// A wall that is thinner than its triangles, within a sentence.
pub fn thin_wall_words(wall: &Wall) -> String {
    format!(
        "a wall of {:.1} mm is thinner than its triangles of {:.1} mm, with which the response is \
         some per cent low; more triangles answer better",
        wall.thickness_mm, wall.triangle_mm
    )
}

/// What answers an object, within a sentence.
pub fn model_words(model: &ResponseModel) -> String {
    match model {
        ResponseModel::None => "neither magnetic nor conducting, no response".to_owned(),
        ResponseModel::SphereSeries => "a sphere, in closed form".to_owned(),
        ResponseModel::NoFlux { skin_depth_mm } => {
            format!("no flux enters, skin depth {skin_depth_mm:.2} mm")
        }
        ResponseModel::Currents { skin_depth_mm } => {
            format!("its currents, at a skin depth of {skin_depth_mm:.2} mm")
        }
        ResponseModel::Permeable { relative_permeability } => {
            format!("permeable, no currents, µ {relative_permeability}")
        }
        ResponseModel::ScaledBySphere { factor, mean_radius_mm, skin_depth_mm, .. } => format!(
            "an estimate: {:.0} % of its limit, as a sphere of {mean_radius_mm:.1} mm, skin depth \
             {skin_depth_mm:.2} mm",
            100.0 * factor
        ),
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
                "{} poses by harmonic functions in {} cells, within {TOLERANCE_MM} mm; {} by the \
                 metal's own field in {} cells near it",
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
    use trackwright_metal::boundary::SurfaceLimit;

    #[test]
    fn an_estimate_is_called_one() {
        let object = ObjectReport {
            name: "table".to_owned(),
            triangles: 1000,
            coarsened_from: Some(23_456),
            thin_wall: None,
            model: ResponseModel::ScaledBySphere {
                limit: SurfaceLimit::NoFlux,
                factor: 0.8123,
                mean_radius_mm: 40.0,
                skin_depth_mm: 4.25,
            },
        };
        assert_eq!(
            object_line(&object),
            "table: 1,000 of 23,456 triangles, an estimate: 81 % of its limit, as a \
             sphere of 40.0 mm, skin depth 4.25 mm"
        );
    }
}

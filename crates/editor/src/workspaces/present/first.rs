//! The slide of a design that has none: what it is, and how well it does.

use trackwright_design::view::View;
use trackwright_design::{Document, Slide, SlideFigure};
use trackwright_report::words::for_audience;

/// A slide that shows the design as it is looked at, with what an engineer has to explain left out.
pub fn slide_of(document: &Document) -> Slide {
    let design = document.design();
    let mut figures = Vec::new();
    if design.requirement.is_some() {
        figures.push(SlideFigure::WithinLimit);
    }
    figures.extend([SlideFigure::TypicalTipError, SlideFigure::LargestTipError]);
    let own = document.own_view();
    Slide {
        title: for_audience(&design.name),
        caption: String::new(),
        figures,
        view: View { layers: own.layers.for_audience(), ..own.clone() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_audience_reads_patient_reference() {
        let world =
            trackwright_project::open_builtin_without_meshes(trackwright_project::DEFAULT_BUILTIN)
                .unwrap();
        assert!(world.document.design().name.contains("CRF"));
        let title = slide_of(&world.document).title;
        assert!(title.contains("patient reference") && !title.contains("CRF"), "{title}");
    }
}

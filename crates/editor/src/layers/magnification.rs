//! The one magnification of errors, decided once and shown in the legend. It stays as it is until a
//! person changes it or has it fitted.

use crate::document::requests::{OpenWorld, ViewRequest};
use crate::document::shown::ShownDesign;
use crate::document::state::WorldGeneration;
use crate::layers::settings::{INDENT, row_ui, set_from};
use crate::runner::results::Results;
use crate::schedule::EditorSystems;
use crate::shell::commands::{Command, VIEW};
use crate::viewport::camera::OrbitRig;
use crate::widgets::basic::{NumberField, number_ui};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{Button, Slider, SliderClamping, Ui};
use nalgebra::Point3;
use trackwright_design::view::{Layers, Magnification, View};
use trackwright_geometry::gizmo::Eye;
use trackwright_geometry::magnification::automatic_magnification;
use trackwright_geometry::orbit::OrbitCamera;
use trackwright_scene::opening_view::first_camera;
use trackwright_scene::tool_errors::ToolErrors;
use trackwright_simulation::PoseDetail;

pub const FIT: Command = Command::new(
    VIEW,
    12,
    "Fit magnification",
    "Magnifies errors so that the tip's is easy to see from here, and keeps it so",
);

/// The magnification of errors, ghost and vectors as drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ShownMagnification {
    pub times: f64,
    /// The ghost's turn would be too large and is drawn smaller.
    pub is_capped: bool,
}

/// What fitting would make of it now; `None` while there is no error to be seen.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct MagnificationFit(pub Option<f64>);

/// What the open design was fitted by when it was opened.
#[derive(Resource, Clone, Copy, Debug, Default)]
struct FirstFit {
    generation: Option<WorldGeneration>,
    times: Option<f64>,
}

/// Keeps [`ShownMagnification`], and fits it on request.
pub struct MagnifyPlugin;

impl Plugin for MagnifyPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(ShownMagnification { times: 1.0, is_capped: false })
            .init_resource::<MagnificationFit>()
            .init_resource::<FirstFit>()
            .add_systems(
                Update,
                decide
                    .run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<ShownDesign>))
                    .in_set(EditorSystems::Sample),
            );
    }
}

/// What magnified errors are drawn from.
#[derive(SystemParam)]
pub struct ShownErrors<'w> {
    pub world: Res<'w, OpenWorld>,
    pub shown: Res<'w, ShownDesign>,
    pub results: Res<'w, Results>,
    pub magnification: Res<'w, ShownMagnification>,
    pub rig: Res<'w, OrbitRig>,
}

impl ShownErrors<'_> {
    pub fn layers(&self) -> Layers {
        self.world.0.document.view().layers
    }

    pub fn times(&self) -> f64 {
        self.magnification.times
    }

    /// At the pose that is shown; `None` while nothing is known.
    pub fn pose(&self) -> Option<&PoseDetail> {
        self.results.pose.as_ref().map(|pose| &pose.value)
    }

    pub fn tool(&self) -> Option<ToolErrors> {
        Some(ToolErrors::of(&self.shown.design, self.pose()?))
    }
}

/// Whether errors, or what they are of, may differ from before.
pub fn errors_changed(
    world: Option<Res<OpenWorld>>,
    design: Option<Res<ShownDesign>>,
    results: Res<Results>,
    magnification: Res<ShownMagnification>,
) -> bool {
    world.is_some_and(|world| world.is_changed())
        || design.is_some_and(|design| design.is_changed())
        || results.is_changed()
        || magnification.is_changed()
}

/// Whether what is drawn of them may: they also look different from elsewhere.
pub fn anything_moved(
    world: Option<Res<OpenWorld>>,
    design: Option<Res<ShownDesign>>,
    results: Res<Results>,
    magnification: Res<ShownMagnification>,
    rig: Res<OrbitRig>,
) -> bool {
    rig.is_changed() || errors_changed(world, design, results, magnification)
}

/// What an error is fitted by: below it there is nothing to see, only round-off.
const LEAST_ERROR_MM: f64 = 1e-6;

/// The magnification at which an error is easy to see in a view of such a height at its place; `None`
/// where there is no error.
fn fitted(error_mm: f64, height_mm: f64) -> Option<f64> {
    (error_mm > LEAST_ERROR_MM).then(|| automatic_magnification(error_mm, height_mm))
}

/// How much of the tracker's frame the view shows from top to bottom where a point is, mm.
fn height_mm(camera: OrbitCamera, view_px: [f64; 2], at_mm: &Point3<f64>) -> f64 {
    Eye { camera, view_px }.mm_per_px(at_mm) * view_px[1]
}

/// A design that has not been fitted since it was opened is, once, as its own view frames it. Nothing
/// else moves an automatic magnification: an arrow that grows is an error that grew.
fn decide(
    world: Res<OpenWorld>,
    generation: Option<Res<WorldGeneration>>,
    design: Res<ShownDesign>,
    results: Res<Results>,
    rig: Res<OrbitRig>,
    (mut first, mut fit): (ResMut<FirstFit>, ResMut<MagnificationFit>),
    mut shown: ResMut<ShownMagnification>,
) {
    let is_moved = world.is_changed() || design.is_changed() || results.is_changed();
    if !(is_moved || rig.is_changed()) {
        return;
    }
    let errors = (results.pose.as_ref())
        .map(|pose| ToolErrors::of(&design.design, &pose.value))
        .filter(|_| rig.view_px[1] > 1.0);
    let Some(errors) = errors else { return };
    fit.set_if_neq(MagnificationFit(fit_now(&errors, &design, &results, &rig)));
    let generation = generation.map(|generation| *generation);
    if first.generation != generation {
        *first = FirstFit { generation, times: None };
    }
    if first.times.is_none() {
        let own = world.0.document.own_view().camera;
        let camera = own.map_or_else(|| first_camera(&world.0, rig.view_px), Into::into);
        let height_mm = height_mm(camera, rig.view_px, &errors.tip_mm());
        first.times = fitted(errors.error_mm().norm(), height_mm);
    }
    let times = match world.0.document.view().magnification {
        Magnification::Times(times) => times,
        Magnification::Auto => first.times.unwrap_or(1.0),
    };
    shown.set_if_neq(ShownMagnification { times, is_capped: errors.ghost(times).is_capped });
}

/// By what is seen now. Trials and live poses by the worst one, as if it were where the camera looks.
fn fit_now(
    errors: &ToolErrors,
    design: &ShownDesign,
    results: &Results,
    rig: &OrbitRig,
) -> Option<f64> {
    let own_mm = errors.error_mm().norm();
    let is_one_of_many = design.trial.is_some() || design.live.is_some();
    match results.study.as_ref().filter(|_| is_one_of_many) {
        Some(study) => {
            let worst_mm = study.value.room_field.worst.position_mm.max(own_mm);
            fitted(worst_mm, height_mm(rig.camera, rig.view_px, &rig.camera.focus_mm))
        }
        None => fitted(own_mm, height_mm(rig.camera, rig.view_px, &errors.tip_mm())),
    }
}

/// What the slider reaches from.
const SLIDER: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;

/// How much larger errors are drawn: a number, a button that fits it, and a slider.
pub fn magnification_ui(
    ui: &mut Ui,
    view: &mut View,
    shown: ShownMagnification,
    MagnificationFit(fit): MagnificationFit,
) {
    let decimals = if shown.times.fract() == 0.0 { 0 } else { 2 };
    let field = NumberField {
        unit: "×",
        decimals,
        speed: (shown.times / 100.0).max(0.01),
        min: 0.01,
        max: 1e9,
        width: 62.0,
        ..NumberField::plain("how much larger errors are drawn")
    };
    let mut set = |times: f64| view.magnification = Magnification::Times(times);
    row_ui(ui, "magnified", |ui| {
        set_from(number_ui(ui, &field, shown.times), &mut set);
        let button = ui.add_enabled(fit.is_some(), Button::new("Fit")).on_hover_text(FIT.about);
        if let Some(times) = fit.filter(|_| button.clicked()) {
            set(times);
        }
    });
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        let mut times = shown.times;
        ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(40.0);
        let slider = Slider::new(&mut times, SLIDER)
            .logarithmic(true)
            .show_value(false)
            .clamping(SliderClamping::Never);
        if ui.add(slider).changed() {
            set(two_digits(times));
        }
    });
}

/// A factor with two digits: what a person sets with a slider is no more exact.
fn two_digits(times: f64) -> f64 {
    let unit = 10f64.powf(times.log10().floor() - 1.0);
    match unit >= 1.0 {
        true => (times / unit).round() * unit,
        false => (times * 10.0).round() / 10.0,
    }
}

/// Sets the magnification to what fits, and keeps it there.
pub(crate) fn fit_on_request(
    fit: Res<MagnificationFit>,
    world: Option<Res<OpenWorld>>,
    mut requests: MessageWriter<ViewRequest>,
) {
    if let (Some(times), Some(world)) = (fit.0, world) {
        let magnification = Magnification::Times(times);
        requests.write(ViewRequest::Set(View { magnification, ..world.0.document.view().clone() }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slider_sets_two_digits() {
        for (from, to) in [(1.234, 1.2), (12.34, 12.0), (199.9, 200.0), (5432.1, 5400.0)] {
            assert!((two_digits(from) - to).abs() < 1e-9, "{from}: {}", two_digits(from));
        }
    }

    #[test]
    fn round_off_is_not_magnified() {
        assert_eq!(fitted(1e-12, 400.0), None);
        assert_eq!(fitted(f64::NAN, 400.0), None);
        assert_eq!(fitted(0.5, 400.0), Some(50.0));
    }
}

//! How far the selected metal object must be: from where on the requirement holds, and the error along the
//! line. Computed while the section is shown and the hand rests.

use super::metal_distance_mark;
use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::document::state::WorldGeneration;
use crate::runner::jobs::Newest;
use crate::runner::wake::Waker;
use crate::schedule::request_then_receive;
use crate::shell::requests::Requests;
use crate::widgets::basic::{length, quiet_ui, section_ui, warning_ui};
use crate::widgets::chart::chart_ui;
use crate::widgets::tooltip::Explain;
use bevy::prelude::*;
use bevy_egui::egui::{ComboBox, Ui};
use nalgebra::{Unit, Vector3};
use trackwright_design::Design;
use trackwright_geometry::number;
use trackwright_geometry::pose::Pose;
use trackwright_metal::furnished::Furnisher;
use trackwright_report::metal_chart;
use trackwright_report::plot::Chart;
use trackwright_simulation::Mode;
use trackwright_simulation::figures::capitalised;
use trackwright_simulation::metal_distance::{
    MetalDistanceSearch, MetalDistances, metal_distances,
};

/// How far the object is moved at most.
const FARTHEST_MM: f64 = 500.0;

const CHART_HEIGHT: f32 = 150.0;

/// Finds how far the selected object must be.
pub struct MetalDistancePlugin;

/// The direction that is chosen, and what was found last.
#[derive(Resource)]
pub struct MetalDistance {
    direction: MoveDirection,
    found: Newest<DistanceKey, Result<DistanceAnswer, String>>,
}

/// Where the object is moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MoveDirection {
    #[default]
    AwayFromTip,
    /// Along an axis of the tracker's frame.
    Axis { axis: usize, is_back: bool },
}

/// Chooses a direction.
#[derive(Message, Clone, Copy, Debug)]
pub struct ChooseDirection(pub MoveDirection);

/// What the distances depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DistanceKey {
    generation: u64,
    revision: u64,
    object: usize,
    direction: MoveDirection,
}

struct DistanceAnswer {
    found: MetalDistances,
    chart: Chart,
}

impl MetalDistance {
    /// The object that was found a least distance for, and where it is then, `tracker_from_object`;
    /// nothing where it is there already, and of another design than the present one.
    pub fn least(&self, design: &Design, generation: u64, revision: u64) -> Option<(usize, Pose)> {
        let (key, answer) = self.found.found()?;
        if (key.generation, key.revision) != (generation, revision) {
            return None;
        }
        let own = design.metal_object(key.object)?.tracker_from_object;
        Some((key.object, answer.as_ref().ok()?.found.least(&own)?))
    }
}

impl MoveDirection {
    const ALL: [Self; 7] = {
        let mut all = [Self::AwayFromTip; 7];
        let mut k = 0;
        while k < 6 {
            all[k + 1] = Self::Axis { axis: k / 2, is_back: k % 2 == 1 };
            k += 1;
        }
        all
    };

    fn label(self) -> String {
        match self {
            Self::AwayFromTip => "away from the tip".to_owned(),
            Self::Axis { axis, is_back } => {
                let sign = if is_back { '−' } else { '+' };
                format!("{sign}{} of the tracker", ['x', 'y', 'z'][axis])
            }
        }
    }

    fn unit(self) -> Option<Unit<Vector3<f64>>> {
        match self {
            Self::AwayFromTip => None,
            Self::Axis { axis, is_back } => {
                let mut parts = [0.0; 3];
                parts[axis] = if is_back { -1.0 } else { 1.0 };
                number::direction(parts)
            }
        }
    }
}

impl FromWorld for MetalDistance {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self { direction: MoveDirection::default(), found: Newest::new("distance of metal", waker) }
    }
}

impl Plugin for MetalDistancePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(metal_distance_mark::plugin);
        app.init_resource::<MetalDistance>().add_message::<ChooseDirection>().add_systems(
            Update,
            request_then_receive((choose, request).chain(), receive)
                .run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<Selection>)),
        );
    }
}

/// Whether a metal object is selected, which the section is about.
pub(crate) fn is_metal_selected(world: &World) -> bool {
    let selection = world.get_resource::<Selection>();
    selection.and_then(Selection::primary).is_some_and(|what| matches!(what, Selected::Metal(_)))
}

fn choose(mut choices: MessageReader<ChooseDirection>, mut state: ResMut<MetalDistance>) {
    if let Some(ChooseDirection(direction)) = choices.read().last() {
        state.direction = *direction;
    }
}

fn request(
    mut state: ResMut<MetalDistance>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    selection: Res<Selection>,
    drag: Option<Res<ActiveDrag>>,
) {
    let Some(Selected::Metal(object)) = selection.primary() else {
        if state.found.requested().is_some() {
            state.found.give_up();
        }
        return;
    };
    let store = &world.0;
    let is_settled = store.awaited_metal().is_none() && store.metal_problem().is_none();
    if drag.is_some_and(|drag| drag.0) || !is_settled {
        return;
    }
    let key = DistanceKey {
        generation: generation.0,
        revision: store.document.revision(),
        object,
        direction: state.direction,
    };
    if state.found.requested() == Some(&key) {
        return;
    }
    let design = store.document.shared_design();
    let Some(metal) = design.room_metal.clone() else {
        return;
    };
    let bare = store.bare_environment().clone();
    let scenario = trackwright_project::resolve(&design, &store.environment);
    state.found.request(key, move |task, _| {
        let search = MetalDistanceSearch {
            mode: if scenario.motion.is_some() { &Mode::Motion } else { &Mode::Single },
            scenario: &scenario,
            bare: &bare,
            metal: &metal,
            object,
            direction: key.direction.unit(),
            farthest_mm: FARTHEST_MM,
        };
        let found = metal_distances(&search, &mut Furnisher::default(), task);
        if task.cancel.is_cancelled() {
            return None;
        }
        let name = metal.objects.get(object).map_or("", |object| object.name.as_str());
        Some(found.map_err(|error| error.to_string()).map(|found| DistanceAnswer {
            chart: metal_chart::chart(&design.name, name, &scenario, &found),
            found,
        }))
    });
}

fn receive(mut state: ResMut<MetalDistance>) {
    if state.bypass_change_detection().found.receive(|_| ()) {
        state.set_changed();
    }
}

pub(crate) fn metal_distance_panel(
    mut ui: InMut<Ui>,
    world: Res<OpenWorld>,
    selection: Res<Selection>,
    state: Option<Res<MetalDistance>>,
    mut requests: Requests<ChooseDirection>,
) {
    let (Some(state), Some(Selected::Metal(object))) = (state, selection.primary()) else {
        return;
    };
    let design = world.0.document.design();
    let metal = design.room_metal.as_ref();
    let Some(name) = metal.and_then(|metal| Some(&metal.objects.get(object)?.name)) else {
        return;
    };
    section_ui(&mut ui, "How far must it be?");
    let mut direction = state.direction;
    let choice = ComboBox::from_id_salt("direction of the metal")
        .selected_text(direction.label())
        .show_ui(&mut ui, |ui| {
            for each in MoveDirection::ALL {
                ui.selectable_value(&mut direction, each, each.label());
            }
        });
    choice.response.explained("The direction in which the object is moved for this");
    if direction != state.direction {
        requests.write(ChooseDirection(direction));
    }
    let now_mm = world.0.distance_to_tip_mm(object);
    if let Some(now_mm) = now_mm {
        quiet_ui(&mut ui, format!("Now {} from its surface to the tip", length(now_mm)));
    }
    match state.found.found().filter(|(key, _)| key.object == object) {
        None => drop(quiet_ui(&mut ui, "Being computed")),
        Some((_, Err(why))) => drop(warning_ui(&mut ui, &capitalised(why))),
        Some((_, Ok(answer))) => {
            let has_requirement = design.requirement.is_some();
            quiet_ui(&mut ui, capitalised(&answer.found.statement(name, has_requirement)));
            chart_ui(&mut ui, &answer.chart, CHART_HEIGHT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_away_and_six_axes() {
        let labels: Vec<_> = MoveDirection::ALL.iter().map(|each| each.label()).collect();
        assert_eq!(labels[0], "away from the tip");
        assert_eq!(labels[6], "−z of the tracker");
        assert_eq!(MoveDirection::ALL[6].unit().unwrap().into_inner(), -Vector3::z());
    }
}

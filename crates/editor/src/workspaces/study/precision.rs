//! Error against run time of the open design, measured in the background on request.

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::runner::jobs::{JobInfo, Runner};
use crate::runner::wake::Waker;
use crate::schedule::{UiSystems, request_then_receive};
use crate::shell::commands::{AddCommand, Command, VIEW, write};
use crate::shell::requests::Requests;
use crate::workspaces::study::precision_ui::precision_window;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use trackwright_accuracy::precision::{Family, Machine, Report, Settings, What, run_each};
use trackwright_task::{Cancelled, Task};

/// Measures on [`PrecisionRequest::Measure`]; nothing runs and nothing is kept before.
pub struct PrecisionPlugin;

/// A request to the page.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrecisionRequest {
    Open,
    Close,
    Measure,
    Cancel,
    Show(What),
}

/// The page: what is measured so far, and of which state of which design.
#[derive(Resource)]
pub struct PrecisionPage {
    pub is_open: bool,
    pub shown: What,
    pub families: Vec<Family>,
    pub machine: Option<Machine>,
    /// Name of the measured design, and the generation and revision of it.
    pub of: Option<(String, u64, u64)>,
    /// Why there is nothing.
    pub problem: Option<String>,
    /// What is measured, and how patiently.
    pub settings: Settings,
    measuring: Option<Runner<(), Found>>,
}

/// What measuring finds.
enum Found {
    Family(Box<Family>),
    End(Result<Box<Report>, Cancelled>),
}

impl Default for PrecisionPage {
    fn default() -> Self {
        Self {
            is_open: false,
            shown: What::Field,
            families: Vec::new(),
            machine: None,
            of: None,
            problem: None,
            settings: Settings::default(),
            measuring: None,
        }
    }
}

impl PrecisionPage {
    /// How far the measuring is, from 0 to 1; `None` where none is under way.
    pub fn part(&self) -> Option<f64> {
        self.measuring.as_ref().map(Runner::progress)
    }
}

impl Plugin for PrecisionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PrecisionPage>()
            .add_message::<PrecisionRequest>()
            .add_command(SHOW_PRECISION, write(PrecisionRequest::Open))
            .add_systems(EguiPrimaryContextPass, window.run_if(is_open).in_set(UiSystems::Dialogs))
            .add_systems(
                Update,
                request_then_receive(
                    answer.run_if(on_message::<PrecisionRequest>),
                    receive.run_if(is_measuring),
                ),
            );
    }
}

const SHOW_PRECISION: Command = Command::new(
    VIEW,
    20,
    "Error against run time…",
    "Measures what each way of computing costs in time and error, for this design",
);

fn is_open(page: Res<PrecisionPage>) -> bool {
    page.is_open
}

fn window(
    mut contexts: EguiContexts,
    page: Res<PrecisionPage>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    mut requests: Requests<PrecisionRequest>,
) -> Result {
    let revision = world.map(|world| world.0.document.revision());
    let is_current =
        page.of.as_ref().is_some_and(|(_, g, r)| *g == generation.0 && Some(*r) == revision);
    requests.write_all(precision_window(contexts.ctx_mut()?, &page, is_current));
    Ok(())
}

fn is_measuring(page: Res<PrecisionPage>) -> bool {
    page.measuring.is_some()
}

fn answer(
    mut requests: MessageReader<PrecisionRequest>,
    mut page: ResMut<PrecisionPage>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    waker: Res<Waker>,
) {
    for request in requests.read() {
        match *request {
            PrecisionRequest::Open => page.is_open = true,
            PrecisionRequest::Close => {
                page.is_open = false;
                cancel(&page);
            }
            PrecisionRequest::Cancel => cancel(&page),
            PrecisionRequest::Show(what) => page.shown = what,
            PrecisionRequest::Measure => {
                if let Some(world) = &world {
                    measure(&mut page, world, generation.0, &waker);
                }
            }
        }
    }
}

fn cancel(page: &PrecisionPage) {
    if let Some(measuring) = &page.measuring {
        measuring.cancel();
    }
}

fn measure(page: &mut PrecisionPage, world: &OpenWorld, generation: u64, waker: &Waker) {
    if page.measuring.is_some() {
        return;
    }
    let document = &world.0.document;
    let scenario = trackwright_project::resolve(document.design(), &world.0.environment);
    let settings = page.settings;
    let mut measuring = Runner::new("precision", waker.clone());
    let work = move |task: &Task, found: &mut dyn FnMut(Found)| {
        let show = |family: &Family| found(Found::Family(Box::new(family.clone())));
        let report = run_each(&scenario, &settings, task, show);
        Some(Found::End(report.map(Box::new)))
    };
    let info = JobInfo { shows_progress: true, ..JobInfo::default() };
    measuring.submit(info, (), Box::new(work));
    page.families.clear();
    page.machine = None;
    page.of = Some((document.design().name.clone(), generation, document.revision()));
    page.problem = None;
    page.measuring = Some(measuring);
}

fn receive(mut page: ResMut<PrecisionPage>) {
    let measuring = page.bypass_change_detection().measuring.as_ref();
    let answers = measuring.map(Runner::answers).unwrap_or_default();
    for answer in answers {
        match answer.value {
            Ok(Found::Family(family)) => {
                page.families.push(*family);
                continue;
            }
            Ok(Found::End(Ok(report))) => page.machine = Some(report.machine),
            Ok(Found::End(Err(_))) => page.problem = Some("cancelled".to_owned()),
            Err(lost) => page.problem = Some(lost.to_string()),
        }
        page.measuring = None;
    }
}

//! Error against run time of the open design, measured in the background when asked for.

use crate::document::apply::WorldGeneration;
use crate::document::requests::OpenWorld;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};
use trackwright_accuracy::precision::{Family, Machine, Report, Settings, What, run_each};
use trackwright_task::{CancelToken, Task};

/// Measures when [`PrecisionRequest::Measure`] asks; nothing runs and nothing is kept before.
pub struct PrecisionPlugin;

/// Asks for something of the page.
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
    measuring: Option<Measuring>,
}

struct Measuring {
    cancel: CancelToken,
    told: Mutex<Receiver<Told>>,
    part: f64,
}

/// What the measuring thread tells.
enum Told {
    Part(f64),
    Family(Box<Family>),
    Done(Box<Report>),
    Cancelled,
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
        self.measuring.as_ref().map(|m| m.part)
    }
}

impl Plugin for PrecisionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PrecisionPage>()
            .init_resource::<WorldGeneration>()
            .init_resource::<Waker>()
            .add_message::<PrecisionRequest>()
            .add_systems(
                Update,
                (answer.run_if(on_message::<PrecisionRequest>), hear.run_if(is_measuring))
                    .chain()
                    .in_set(EditorSystems::Solve),
            );
    }
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
                cancel(&mut page);
            }
            PrecisionRequest::Cancel => cancel(&mut page),
            PrecisionRequest::Show(what) => page.shown = what,
            PrecisionRequest::Measure => {
                if let Some(world) = &world {
                    measure(&mut page, world, generation.0, &waker);
                }
            }
        }
    }
}

fn cancel(page: &mut PrecisionPage) {
    if let Some(measuring) = &page.measuring {
        measuring.cancel.cancel();
    }
}

fn measure(page: &mut PrecisionPage, world: &OpenWorld, generation: u64, waker: &Waker) {
    if page.measuring.is_some() {
        return;
    }
    let document = &world.0.document;
    let scenario = trackwright_project::resolve(document.design(), &world.0.environment);
    let (sender, told) = channel();
    let task = Task::told_to({
        let (sender, waker) = (sender.clone(), waker.clone());
        // A bar of some hundred steps is smooth enough; each costs a frame.
        let last = Mutex::new(0.0);
        move |part| {
            if let Ok(mut last) = last.lock()
                && part - *last >= 0.01
            {
                *last = part;
                tell(&sender, Told::Part(part), &waker);
            }
        }
    });
    let cancel = task.cancel.clone();
    let (settings, waker) = (page.settings, waker.clone());
    let started = std::thread::Builder::new().name("precision".into()).spawn(move || {
        let show = |family: &Family| {
            tell(&sender, Told::Family(Box::new(family.clone())), &waker);
        };
        let end = match run_each(&scenario, &settings, &task, show) {
            Ok(report) => Told::Done(Box::new(report)),
            Err(_) => Told::Cancelled,
        };
        tell(&sender, end, &waker);
    });
    page.families.clear();
    page.machine = None;
    page.of = Some((document.design().name.clone(), generation, document.revision()));
    match started {
        Ok(_) => {
            page.problem = None;
            page.measuring = Some(Measuring { cancel, told: Mutex::new(told), part: 0.0 });
        }
        Err(error) => page.problem = Some(format!("cannot start a thread: {error}")),
    }
}

fn tell(sender: &Sender<Told>, what: Told, waker: &Waker) {
    // The page may have been dropped with the window.
    if sender.send(what).is_ok() {
        waker.wake();
    }
}

fn hear(mut page: ResMut<PrecisionPage>) {
    let told: Vec<Told> = match &page.bypass_change_detection().measuring {
        Some(measuring) => match measuring.told.lock() {
            Ok(told) => told.try_iter().collect(),
            Err(_) => vec![Told::Cancelled],
        },
        None => return,
    };
    for told in told {
        match told {
            Told::Part(part) => {
                if let Some(measuring) = &mut page.measuring {
                    measuring.part = part;
                }
            }
            Told::Family(family) => page.families.push(*family),
            Told::Done(report) => {
                page.machine = Some(report.machine);
                page.measuring = None;
            }
            Told::Cancelled => {
                page.problem = Some("cancelled".to_owned());
                page.measuring = None;
            }
        }
    }
}

//! The search for better places: what it is of, how far it is, and what it found.

use crate::document::requests::OpenWorld;
use crate::runner::jobs::Runner;
use crate::runner::wake::Waker;
use crate::workspaces::design::placement_search::wish::Wish;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::{BodyRole, Design};
use trackwright_field::Environment;
use trackwright_optimization::{Goal, Layout, OptimizeError, Optimized, Settings};
use trackwright_project::StoreError;
use trackwright_report::drawing::BodyOutline;
use trackwright_task::{CancelToken, Hold};

/// A request to the panel.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum PlacementSearchRequest {
    Open,
    Close,
    Set(Wish),
    /// Unfolds the settings, or folds them into a line.
    ShowSettings(bool),
    Start,
    /// Ends the search with the best so far.
    Stop,
    /// Selects an answer.
    Show(AnswerId),
    /// An answer under the pointer, or none any more.
    Hover(Option<AnswerId>),
    /// Gives the design the sensors and poses of an answer.
    Take(AnswerId),
}

/// One of the layouts that were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerId {
    /// Of the distinct good ones, the best first.
    Candidate(usize),
    /// Of the best ones of each number of sensors.
    Pareto(usize),
}

/// What a search is of.
#[derive(Clone, Debug)]
pub struct Searched {
    pub generation: u64,
    pub revision: u64,
    pub design: Arc<Design>,
    pub room: Arc<Environment>,
    pub wish: Wish,
    pub goal: Goal,
}

impl Searched {
    /// Whether the open design is still the one, be it that it was undone to it.
    pub fn is_of(&self, world: &OpenWorld, generation: u64) -> bool {
        let document = &world.0.document;
        self.generation == generation
            && Arc::ptr_eq(&self.room, &world.0.environment)
            && (self.revision == document.revision() || *self.design == *document.design())
    }
}

/// What a search delivers: ever better layouts, then its result.
pub enum Found {
    Better { best: Box<Layout>, evaluations: u64, after_secs: f64 },
    End(Box<Result<SearchResult, SearchError>>),
}

/// Why a search has no result.
#[derive(Debug, thiserror::Error)]
pub enum SearchError {
    #[error(transparent)]
    Room(#[from] StoreError),
    #[error("cannot start threads: {0}")]
    NoThreads(#[from] rayon::ThreadPoolBuildError),
    #[error("stopped before a layout was found")]
    StoppedEarly,
    #[error(transparent)]
    Search(OptimizeError),
}

/// The result of a search, and what is needed to show it.
#[derive(Clone, Debug)]
pub struct SearchResult {
    pub optimized: Optimized,
    /// The rooms' names, as figures have them.
    pub rooms: Vec<String>,
    /// Of the bodies whose sensors may move.
    pub outlines: Vec<(BodyRole, BodyOutline)>,
    pub took_secs: f64,
}

impl SearchResult {
    pub fn layout(&self, answer: AnswerId) -> Option<&Layout> {
        match answer {
            AnswerId::Candidate(index) => self.optimized.candidates.get(index),
            AnswerId::Pareto(index) => self.optimized.pareto.get(index),
        }
    }
}

/// A search that is under way.
pub struct Running {
    pub of: Arc<Searched>,
    /// Ends it with the best so far.
    pub enough: CancelToken,
    pub best: Option<Box<Layout>>,
    /// Layouts that were judged when the best was found.
    pub evaluations: u64,
}

/// The panel's state.
#[derive(Resource)]
pub struct PlacementSearch {
    pub is_open: bool,
    /// Of the design that was opened last; `None` before the panel was opened for it.
    pub wish: Option<Wish>,
    /// Whether all settings are shown while there is a search or a result; else they always are.
    pub shows_settings: bool,
    /// How long and how is searched.
    pub settings: Settings,
    /// Lets the search wait while frames are drawn.
    pub(super) hold: Hold,
    pub(super) runner: Runner<Arc<Searched>, Found>,
    pub running: Option<Running>,
    /// The result of the last search, and what it is of.
    pub result: Option<(Arc<Searched>, SearchResult)>,
    /// Whether the open design is the one that the search, or else the result, is of.
    pub is_current: bool,
    /// Why there is no result.
    pub problem: Option<String>,
    /// The best value so far over seconds.
    pub curve: Vec<[f64; 2]>,
    pub selected: AnswerId,
    pub hovered: Option<AnswerId>,
}

impl FromWorld for PlacementSearch {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self {
            is_open: false,
            wish: None,
            shows_settings: false,
            settings: Settings::default(),
            hold: Hold::default(),
            runner: Runner::new("placement search", waker),
            running: None,
            result: None,
            is_current: false,
            problem: None,
            curve: Vec::new(),
            selected: AnswerId::Candidate(0),
            hovered: None,
        }
    }
}

impl PlacementSearch {
    /// The layout whose places are shown in the scene, and what it is called there.
    pub fn shown(&self) -> Option<(&Layout, &Searched, String)> {
        if !(self.is_open && self.is_current) {
            return None;
        }
        if let Some(running) = &self.running {
            let best = running.best.as_ref()?;
            return Some((best, &running.of, "best places so far".to_owned()));
        }
        let (searched, result) = self.result.as_ref()?;
        let answer = self.hovered.unwrap_or(self.selected);
        let words = match answer {
            AnswerId::Candidate(index) => format!("places of answer {}", index + 1),
            AnswerId::Pareto(_) => "places of the chosen design".to_owned(),
        };
        Some((result.layout(answer)?, searched, words))
    }

    /// Whether the settings stand as a line above what is found with them.
    pub fn is_folded(&self) -> bool {
        self.has_outcome() && !self.shows_settings
    }

    /// Whether there is something to be shown below the settings.
    pub fn has_outcome(&self) -> bool {
        self.running.is_some() || self.result.is_some()
    }

    /// What the search that runs is of, or else the result.
    pub(super) fn searched(&self) -> Option<&Searched> {
        let running = self.running.as_ref().map(|running| &*running.of);
        running.or_else(|| self.result.as_ref().map(|(searched, _)| &**searched))
    }

    /// Gives up what runs and forgets what was found.
    pub(super) fn forget(&mut self) {
        self.give_up();
        self.result = None;
        self.problem = None;
        self.curve.clear();
    }

    /// Gives up what runs.
    pub(super) fn give_up(&mut self) {
        if let Some(running) = self.running.take() {
            running.enough.cancel();
            self.runner.give_up(0);
        }
    }
}

//! A study with all that is reported of it, the same wherever it is reported.

use crate::missed::{Missed, sources_section};
use trackwright_design::BodyRole;
use trackwright_result::{Item, Section, data};
use trackwright_simulation::expected::{ExpectedError, MoreMeasuring, more_measuring};
use trackwright_simulation::{
    CancelToken, Mode, Scenario, Study, StudyError, Trial, Undecided, study,
};

/// A study, and what a reader needs beside it.
#[derive(Clone, Debug)]
pub struct StudyReport {
    pub study: Study,
    /// The trial of a study of one pose.
    pub single: Option<Trial>,
    /// Measurements that would decide bounds that the room does not.
    pub needed: Vec<MoreMeasuring>,
    pub missed: Option<Missed>,
    role: BodyRole,
}

impl StudyReport {
    /// Runs the study of a body. The measurements that would decide a bound are counted for the tool's.
    ///
    /// # Errors
    /// A study that cannot run.
    pub fn run(
        role: BodyRole,
        (scenario, mode): (&Scenario, &Mode),
        cancel: &CancelToken,
    ) -> Result<Self, StudyError> {
        let mut last = None;
        let study = study(scenario, mode, cancel, Some(&mut |trial: &Trial| last = Some(*trial)))?;
        Self::of(role, (scenario, mode), study, last, cancel)
    }

    /// The same of a study that was run; `last` is its last trial.
    ///
    /// # Errors
    /// [`StudyError::Cancelled`].
    pub fn of(
        role: BodyRole,
        (scenario, mode): (&Scenario, &Mode),
        study: Study,
        last: Option<Trial>,
        cancel: &CancelToken,
    ) -> Result<Self, StudyError> {
        let requirement = study.figures.requirement.as_ref();
        let open = requirement.map_or(&[][..], |requirement| &requirement.bounds);
        let is_open = open.iter().any(|bound| bound.reason == Some(Undecided::Interval));
        let needed = match role {
            BodyRole::Tool if is_open => match more_measuring(scenario, mode, open, cancel) {
                Ok(needed) => needed,
                Err(ExpectedError::Study(error)) => return Err(error),
                Err(_) => Vec::new(),
            },
            _ => Vec::new(),
        };
        let missed = Missed::of(role, (scenario, mode), &study, cancel)?;
        let single = last.filter(|_| matches!(mode, Mode::Single));
        Ok(Self { study, single, needed, missed, role })
    }

    /// The study as `simulate` prints it; people read the paper's simulation where it is requested.
    pub fn section(&self, of: (&Scenario, &Mode), has_room_field: bool) -> Section {
        let (single, room_field) = (self.single.as_ref(), &self.study.room_field);
        let needed = self.needed.iter().flat_map(|more| {
            let key = format!("measurements_needed.{}", more.metric.name());
            [data(key, more.measurements).into(), Item::Line(more.statement())]
        });
        let paper = has_room_field.then(|| room_field.paper_section(single).below(0));
        self.study
            .section(single)
            .with(sources_section(self.role, of, room_field, self.missed.as_ref()))
            .with_all(needed)
            .with_all(paper)
    }
}

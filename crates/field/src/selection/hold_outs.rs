//! What is held out together, and by which of it a model is chosen: rows, groups of rows, sensors.

use super::folds::{Folds, numbered};
use super::settings::{SelectError, SelectSettings};

/// What is held out in the folds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldOutBy {
    /// Each row by itself: how the model does beside its samples.
    Rows,
    /// Rows that belong together: how it does at other places, poses or times.
    Groups,
    /// All rows of a sensor: how it does with a sensor that it has not seen.
    Sensors,
}

/// Which rows belong together, and what decides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HoldOuts<'a> {
    /// Names the group of each row by any number.
    pub groups: Option<&'a [usize]>,
    /// Names the sensor of each row by any number.
    pub sensors: Option<&'a [usize]>,
    /// Whether fewer groups than folds are held out in as many folds as groups, at least two; else
    /// they are an error.
    pub has_few_groups: bool,
    /// `None`: groups where there are any, else rows.
    pub deciding: Option<HoldOutBy>,
    /// Whether nothing else is held out than what decides.
    pub only_deciding: bool,
}

/// One way in which rows were held out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HoldOut {
    pub by: HoldOutBy,
    pub folds: usize,
    /// Number of rows, groups or sensors.
    pub count: usize,
}

/// The folds of each hold-out, where it is made.
pub(super) struct AllFolds {
    pub rows: Option<Folds>,
    pub groups: Option<(Folds, usize)>,
    pub sensors: Option<(Folds, usize)>,
    pub deciding: HoldOutBy,
}

impl AllFolds {
    /// Sensors are few: there are at most as many folds of them.
    pub fn new(
        hold_outs: &HoldOuts,
        rows: usize,
        settings: &SelectSettings,
    ) -> Result<Self, SelectError> {
        let deciding = hold_outs.deciding.unwrap_or(match hold_outs.groups {
            Some(_) => HoldOutBy::Groups,
            None => HoldOutBy::Rows,
        });
        let labelled = |labels: &[usize], are_few_fine: bool| {
            if labels.len() != rows {
                return Err(SelectError::GroupCount { found: labels.len(), expected: rows });
            }
            let (groups, count) = numbered(labels);
            let folds = match are_few_fine {
                true => settings.folds.min(count.max(2)),
                false => settings.folds,
            };
            if count < folds {
                return Err(SelectError::FewerGroupsThanFolds { groups: count, folds });
            }
            Ok((Folds::of_groups(&groups, count, folds, settings.seed), count))
        };
        let groups = hold_outs
            .groups
            .map(|labels| labelled(labels, hold_outs.has_few_groups))
            .transpose()?;
        let sensors = match hold_outs.sensors.map(|labels| labelled(labels, true)) {
            // One sensor cannot be held out; that matters only to whoever wants it to be.
            Some(Err(SelectError::FewerGroupsThanFolds { groups, .. })) => match deciding {
                HoldOutBy::Sensors => return Err(SelectError::FewSensors(groups)),
                _ => None,
            },
            other => other.transpose()?,
        };
        match (deciding, &groups, &sensors) {
            (HoldOutBy::Groups, None, _) => Err(SelectError::NothingToHoldOut("groups")),
            (HoldOutBy::Sensors, _, None) => Err(SelectError::NothingToHoldOut("sensors")),
            _ => {
                let is_made = |by| !hold_outs.only_deciding || deciding == by;
                let by_row = || Folds::of_rows(rows, settings.folds, settings.seed);
                Ok(Self {
                    rows: is_made(HoldOutBy::Rows).then(by_row),
                    groups: groups.filter(|_| is_made(HoldOutBy::Groups)),
                    sensors: sensors.filter(|_| is_made(HoldOutBy::Sensors)),
                    deciding,
                })
            }
        }
    }

    /// All hold-outs, rows first.
    pub fn list(&self) -> Vec<HoldOut> {
        let rows = self.rows.iter().map(|folds| HoldOut {
            by: HoldOutBy::Rows,
            folds: folds.rows.len(),
            count: folds.rows.iter().map(Vec::len).sum(),
        });
        let labelled = [(HoldOutBy::Groups, &self.groups), (HoldOutBy::Sensors, &self.sensors)];
        let labelled = labelled.into_iter().filter_map(|(by, folds)| {
            let (folds, count) = folds.as_ref()?;
            Some(HoldOut { by, folds: folds.rows.len(), count: *count })
        });
        rows.chain(labelled).collect()
    }
}

//! Suspicions in words, with their numbers and units.

use super::{Explained, Part, Suspicion, named_axes, short};
use std::fmt;

/// A sentence without a full stop, for a line of its own or behind a file's name.
impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |c: &Explained| {
            format!("{} mm apart in the median, {} mm", short(c.before), short(c.after))
        };
        let deg = |e: &Explained| {
            let [before, after] = [e.before, e.after].map(f64::to_degrees);
            format!("{before:.1}° apart in the median, {after:.1}°")
        };
        match self {
            Self::Metres { span, reach, .. } => write!(
                f,
                "positions span {} and reach {} from the origin, a tracker's volume some 100 to 1,000 mm: are they metres?",
                short(*span),
                short(*reach)
            ),
            Self::InchesOrCentimetres { span, reach } => write!(
                f,
                "positions span {} and reach {} from the origin, a tracker's volume some 100 to 1,000 mm: are they inches \
                 or centimetres?",
                short(*span),
                short(*reach)
            ),
            Self::TooFar { count, first_row, largest } => write!(
                f,
                "{count} {} a coordinate beyond 1 km (row {first_row}; the largest is {largest:.3e} mm): are they missing \
                 readings?",
                if *count == 1 { "row has" } else { "rows have" }
            ),
            Self::Outliers { count, first_row, limit, largest, median } => write!(
                f,
                "{count} {} more than {} mm, up to {} mm, between ideal and measured position (row {first_row} first), \
                 the median is {} mm: are they outliers?",
                if *count == 1 { "row has" } else { "rows have" },
                short(*limit),
                short(*largest),
                short(*median)
            ),
            Self::Scale { sides: [first, second], ratio, first_mm, second_mm, units } => {
                write!(
                    f,
                    "distances among {second} positions are {} times those among {first} ones ({} and {} mm in the median): ",
                    short(*ratio),
                    short(*second_mm),
                    short(*first_mm)
                )?;
                match units {
                    Some(units) => write!(f, "are they in {units}?"),
                    None => f.write_str("are they of the same places, in one unit?"),
                }
            }
            Self::NotInRoom { rows, inside, axes, inside_with_axes } => write!(
                f,
                "{inside} of {rows} positions are in the room's box, {inside_with_axes} where {}: are axes taken for others?",
                named_axes(axes, "", "")
            ),
            Self::Input {
                rows,
                inside: [inside, without],
                from_own_mm: [mm, without_mm],
                mistake,
            } => {
                let [mm, without_mm] = [*mm, *without_mm].map(short);
                write!(
                    f,
                    "{inside} of {rows} trials have their sensors in the room's box, {mm} mm from the design's own \
                     poses in the mean; {without} and {without_mm} mm where {mistake}"
                )
            }
            Self::RowShift { rows, part, change } => {
                write_part(f, part)?;
                write!(
                    f,
                    "from row to row, the sides' steps are {} where the ideal side's row k belongs to the measured side's \
                     row k {} {}: are rows shifted?",
                    mm(change),
                    if *rows < 0 { "−" } else { "+" },
                    rows.abs()
                )
            }
            Self::UnitOfPart { part, units } => {
                write_part(f, &Some(*part))?;
                write!(
                    f,
                    "both sides are within 70 mm of the origin, apart from the other rows, and among them where they are \
                     in {units}: are they?"
                )
            }
            Self::Lag { rows, standard_error, moved_mm, left_mm } => write!(
                f,
                "along the path the measured side is {} rows {} the ideal one (standard error {}): readings move by {} mm \
                 RMS, where {} mm is left beside that: are the clocks of the two sides apart? (lag {} takes it out)",
                short(rows.abs()),
                if *rows < 0.0 { "before" } else { "behind" },
                short(*standard_error),
                short(*moved_mm),
                short(*left_mm),
                short(*rows)
            ),
            Self::Drift { of_field, changed_mm, left_mm } => write!(
                f,
                "from the first row to the last {} by {} mm RMS, where {} mm is left beside that: {}?",
                if *of_field { "the field changes" } else { "one side moves" },
                short(*changed_mm),
                short(*left_mm),
                if *of_field { "was metal moved" } else { "did the reference move" }
            ),
            Self::ScalarLast { rows, negative_first } => write!(
                f,
                "qz is negative in none of the {negative_first} rows in which qw is, of {rows}, as if qw were the last: are the \
                 quaternions in the order x, y, z, w?"
            ),
            Self::Mistake { mistake, part, explained } => {
                write_part(f, part)?;
                let apart = match mistake.is_of_angles() {
                    true => deg(explained),
                    false => mm(explained),
                };
                let subject = match mistake.is_of_angles() {
                    true => "the orientations",
                    false => "the sides",
                };
                write!(f, "{subject} are {apart} {mistake}")
            }
            Self::Zeros { count, first_row } => write!(
                f,
                "{count} {} at (0, 0, 0) on one side or both (row {first_row} first), which are zero in no tracker: are they \
                 missing readings?",
                if *count == 1 { "position is" } else { "positions are" }
            ),
            Self::Repeated { count, first_row } => write!(
                f,
                "{count} rows have the same numbers as another row (row {first_row} first): was it copied?"
            ),
            Self::Copied { count, of, first_row } => write!(
                f,
                "{count} of {of} rows have the same numbers on both sides (row {first_row} first): was one side copied \
                 from the other?"
            ),
            Self::Large { position_mm, angle_rad } => write!(
                f,
                "the sides are {} mm and {:.1}° apart RMS, more than rooms distort by: do they belong together?",
                short(*position_mm),
                angle_rad.to_degrees()
            ),
            Self::TooLarge { span, reach, .. } => write!(
                f,
                "positions span {} m and reach {} m from the origin, a tracker's volume less than 5 m: are they \
                 micrometres, or millimetres taken for metres?",
                short(*span * 1e-3),
                short(*reach * 1e-3)
            ),
            Self::Orientations { median_rad, part } => {
                write_part(f, part)?;
                write!(
                    f,
                    "the orientations are {:.1}° apart in the median, and no order, sign or frame of theirs explains it: are \
                 angles in degrees taken for radians, or quaternions made of other angles?",
                    median_rad.to_degrees()
                )
            }
        }
    }
}

fn write_part(f: &mut fmt::Formatter<'_>, part: &Option<Part>) -> fmt::Result {
    match part {
        Some(Part { count: 1, first_row, .. }) => write!(f, "in row {first_row} "),
        Some(Part { count, of, first_row }) => {
            let percent = 100.0 * *count as f64 / *of as f64;
            write!(f, "in {count} of {of} rows ({percent:.1} %, row {first_row} first) ")
        }
        None => Ok(()),
    }
}

//! Readings of a sensor on a plate with a grid of holes and a disc, one row a reading or a recording.
//!
//! Columns `row` and `column` of a hole, or `angle_deg` of the disc; `level`, 0 where there is none; beside
//! a rod of metal its material `rod` and `distance_mm`, and `placement` where several are at one distance;
//! then a pose, or `recording`, the name of a file with the readings of that site.

use super::error::FormatError;
use super::table::{Header, POSE, Row, Table};
use std::io::{self, Write};
use trackwright_calibration::protocol::plate::{PlateReading, RodSite, Site, SiteAt};
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::{Pose, pose_to_array};

/// Highest number of a level, row or column.
const MOST: f64 = 999.0;

const EXPECTED: &str = "the columns of a plate recording (row, column, or angle_deg of the disc; x, y, z, qw, \
    qx, qy, qz, or recording)";

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateRow {
    pub site: Site,
    pub content: PlateContent,
}

/// What a row has of its site.
#[derive(Clone, Debug, PartialEq)]
pub enum PlateContent {
    /// One reading or a mean, `tracker_from_sensor`.
    Pose(Pose),
    /// Name of a file.
    Recording(String),
}

/// Places of the optional columns.
struct Columns {
    level: Option<usize>,
    hole: Option<[usize; 2]>,
    angle: Option<usize>,
    rod: Option<[usize; 2]>,
    placement: Option<usize>,
}

/// Reads the table.
///
/// # Errors
/// Missing columns, cells that are no numbers, rows that are neither of a hole nor of the disc.
pub fn parse(bytes: &[u8]) -> Result<Vec<PlateRow>, FormatError> {
    let table = Table::parse(bytes)?;
    let header = table.header();
    let columns = Columns::of(header)?;
    if header.has("recording") && !header.has_pose("") {
        let file = header.columns(&["recording"], EXPECTED)?[0];
        return table.read(|row| {
            let site = columns.site(row)?;
            match row.cell(file) {
                "" => Err(FormatError::cell(row.line(), "recording", "empty", "a file's name")),
                name => Ok(PlateRow { site, content: PlateContent::Recording(name.to_owned()) }),
            }
        });
    }
    let pose = header.pose("", EXPECTED)?;
    table.read(|row| {
        Ok(PlateRow { site: columns.site(row)?, content: PlateContent::Pose(row.pose(&pose)?) })
    })
}

impl Columns {
    fn of(header: &Header) -> Result<Self, FormatError> {
        let optional = |name: &str| -> Result<Option<usize>, FormatError> {
            let found = header.has(name).then(|| header.columns(&[name], EXPECTED)).transpose()?;
            Ok(found.map(|columns| columns[0]))
        };
        let pair = |names: [&str; 2]| -> Result<Option<[usize; 2]>, FormatError> {
            let is_there = names.iter().any(|name| header.has(name));
            let found = is_there.then(|| header.columns(&names, EXPECTED)).transpose()?;
            Ok(found.map(|columns| [columns[0], columns[1]]))
        };
        let hole = pair(["row", "column"])?;
        let angle = optional("angle_deg")?;
        if hole.is_none() && angle.is_none() {
            header.columns(&["row", "column"], EXPECTED)?;
        }
        let rod = pair(["rod", "distance_mm"])?;
        Ok(Self { level: optional("level")?, hole, angle, rod, placement: optional("placement")? })
    }

    fn site(&self, row: &Row) -> Result<Site, FormatError> {
        let filled = |column: Option<usize>| column.filter(|column| !row.cell(*column).is_empty());
        let count = |column: usize, name: &str| -> Result<usize, FormatError> {
            let value = row.number(column)?;
            match value.fract() == 0.0 && (0.0..=MOST).contains(&value) {
                true => Ok(value as usize),
                false => {
                    let expected = "a whole number from 0 to 999";
                    Err(FormatError::cell(row.line(), name, shortest(value), expected))
                }
            }
        };
        let level = filled(self.level).map_or(Ok(0), |column| count(column, "level"))?;
        let hole = self.hole.filter(|hole| hole.iter().any(|c| !row.cell(*c).is_empty()));
        let at = match (hole, filled(self.angle)) {
            (Some([r, c]), None) => {
                SiteAt::Hole { row: count(r, "row")?, column: count(c, "column")? }
            }
            (None, Some(column)) => {
                let angle_deg = row.number(column)?;
                if !(0.0..360.0).contains(&angle_deg) {
                    let found = shortest(angle_deg);
                    let expected = "0 to less than 360";
                    return Err(FormatError::cell(row.line(), "angle_deg", found, expected));
                }
                SiteAt::Disc { angle_deg }
            }
            (both, _) => {
                let found = match both {
                    Some(_) => "a hole and an angle of the disc",
                    None => "neither a hole nor an angle of the disc",
                };
                return Err(FormatError::line(row.line(), found, "one of them"));
            }
        };
        let rod = match self.rod.filter(|[rod, _]| !row.cell(*rod).is_empty()) {
            None => None,
            Some([rod, distance]) => {
                let distance_mm = row.number(distance)?;
                if distance_mm < 0.0 {
                    let (found, expected) = (shortest(distance_mm), "zero or more");
                    return Err(FormatError::cell(row.line(), "distance_mm", found, expected));
                }
                let placement = filled(self.placement).map_or("", |column| row.cell(column));
                Some(RodSite {
                    rod: row.cell(rod).to_owned(),
                    distance_mm,
                    placement: placement.to_owned(),
                })
            }
        };
        Ok(Site { level, at, rod })
    }
}

/// Writes readings, so that [`parse`] gives them back.
pub fn write(out: &mut dyn Write, readings: &[PlateReading]) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    let names = ["level", "row", "column", "angle_deg", "rod", "distance_mm", "placement"];
    table.write_record(names.into_iter().chain(POSE))?;
    for PlateReading { site, tracker_from_sensor } in readings {
        let at = match site.at {
            SiteAt::Hole { row, column } => [row.to_string(), column.to_string(), String::new()],
            SiteAt::Disc { angle_deg } => [String::new(), String::new(), shortest(angle_deg)],
        };
        let rod = site
            .rod
            .as_ref()
            .map(|rod| [rod.rod.clone(), shortest(rod.distance_mm), rod.placement.clone()]);
        let place = [site.level.to_string()].into_iter().chain(at).chain(rod.unwrap_or_default());
        table.write_record(place.chain(pose_to_array(tracker_from_sensor).map(shortest)))?;
    }
    table.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::assert_refused;

    #[test]
    fn readings_are_read_back() {
        let site = |at: SiteAt, rod: Option<RodSite>| Site { level: 2, at, rod };
        let beside = RodSite {
            rod: "steel-416".to_owned(),
            distance_mm: 20.5,
            placement: "+x side, along z".to_owned(),
        };
        let disc = SiteAt::Disc { angle_deg: 11.25 };
        let readings = [
            site(SiteAt::Hole { row: 0, column: 7 }, None),
            site(disc, None),
            site(disc, Some(beside)),
        ]
        .map(|site| PlateReading {
            site,
            tracker_from_sensor: Pose::translation(1.25, -3.0, -200.0),
        });
        let mut written = Vec::new();
        write(&mut written, &readings).unwrap();
        let found = parse(&written).unwrap();
        for (found, reading) in found.iter().zip(&readings) {
            assert_eq!(found.site, reading.site);
            assert_eq!(found.content, PlateContent::Pose(reading.tracker_from_sensor));
        }
        assert_eq!(found.len(), 3);
    }

    #[test]
    fn recordings_are_named() {
        let found = parse(b"row,column,recording\n3,4,a.tsv\n").unwrap();
        let site = Site::plain(0, SiteAt::Hole { row: 3, column: 4 });
        let content = PlateContent::Recording("a.tsv".to_owned());
        assert_eq!(found, [PlateRow { site, content }]);
    }

    #[test]
    fn wrong_tables_are_refused() {
        let cases = r#"
            x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n
                | line 1: found no column row, column, expected the columns of a plate…
            row,column,x,y,z\n1,2,3,4,5\n | line 1: found no column qw, qx, qy, qz…
            row,column => row,line | line 1: found no column column…
            ,1,7, => ,1,NaN, | line 2: column is "NaN", expected a finite number
            ,1,7, => ,1,1.5, | line 2: column is 1.5, expected a whole number…
            ,1,7, => ,-1,7, | line 2: row is -1, expected a whole number…
            ,25, => ,NaN, | line 2: x is "NaN", expected a finite number
            ,1,7,, => ,1,7,5, | line 2: found a hole and an angle of the disc, expected one…
            ,1,7,, => ,,,, | line 2: found neither a hole nor…
            ,1,7,, => ,,,360, | line 2: angle_deg is 360, expected 0 to less than 360
            distance_mm => depth_mm | line 1: found no column distance_mm…
            row,column,recording\n1,1,\n
                | line 2: recording is empty, expected a file's name
        "#;
        let good = "level,row,column,angle_deg,rod,distance_mm,x,y,z,qw,qx,qy,qz\n\
                    0,1,7,,bronze,20,25,2,3,1,0,0,0\n";
        assert!(parse(good.as_bytes()).is_ok());
        assert_refused(good, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }
}

//! Every parser on every kind of rubbish: an error, never a panic; and tables in detail.

use super::*;
use crate::preferences_file::Preferences;
use crate::test_cases::assert_refused;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::sync::LazyLock;
use trackwright_field::samples::{Measurement, MeasurementContent, MeasurementSet};
use trackwright_geometry::pose::{Pose, pose_from_array, pose_to_array};
use trackwright_simulation::Trial;

const MEASUREMENTS: &str = "ideal_x,ideal_y,ideal_z,ideal_qw,ideal_qx,ideal_qy,ideal_qz,\
measured_x,measured_y,measured_z,measured_qw,measured_qx,measured_qy,measured_qz\n\
1,2,3,1,0,0,0,1.5,2,3,0.6,0.8,0,0\n4,5,6,1,0,0,0,4,5,6,1,0,0,0\n";
const POSES: &str = "note,x,y,z,qw,qx,qy,qz\nfirst,1,2,3,0,-1,0,0\n";
const CALBODY: &str = "1, 1, 2, pa1-calbody.txt\n 1.00, 2.00, 3.00\n4,5,6\n7,8,9\n10,11,12\n";
const CALREADINGS: &str =
    "1, 1, 1, 2, x-calreadings.txt\n1,2,3\n4,5,6\n7,8,9\n1,2,3\n4,5,6\n7,8,9\n";

const OPTPIVOT: &str = "1, 2, 2, x-optpivot.txt\n1,2,3\n4,5,6\n7,8,9\n1,2,3\n4,5,6\n7,8,0\n";

/// First lines of tables and recordings.
const BEGINNINGS: [&str; 7] = [
    "# CoordinateSystem = LPS\n",
    "ObjectType = Image\nSeq_Frame",
    "Tools\tPort 1\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\n",
    "received_s,time_s,tool,state,x,y,z,qw,qx,qy,qz\n",
    "ideal_x,ideal_y,ideal_z,ideal_qw,ideal_qx,ideal_qy,ideal_qz,measured_x,measured_y,measured_z,\
     measured_qw,measured_qx,measured_qy,measured_qz,sensor,pose\n",
    "Frame#,ToolHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error,#Markers\n",
    "#Tools,ToolInfo,Frame#,PortHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error,Markers\n",
];

/// Letters of numbers and labels, of which nearly any text is a table or a recording in the making.
const LETTERS: [&str; 2] = ["0129xyz,; .\n#e-", "Position: Orientation: 12.-e(),\n"];

type Accepts = fn(&[u8]) -> bool;

/// Every parser, and good files of its kind.
static KINDS: LazyLock<Vec<(Accepts, Vec<Vec<u8>>)>> = LazyLock::new(|| {
    let texts = |texts: &[&str]| texts.iter().map(|text| text.as_bytes().to_vec()).collect();
    let input = POSES.replace(",x,y,z,q", ",tool_x,tool_y,tool_z,q").replace(",q", ",tool_q");
    let room = "(version: 1, name: \"r\", model: (order: 0, directions: 1, weighting: Area, \
                map: Distortion, box: ((0, 0, 0), (1, 1, 1)), coefficients: []))";
    let body = include_str!("../../../assets/bodies/pointer.body.ron");
    let design = include_str!("../../../designs/pointer-on-head.design.ron");
    vec![
        (|bytes| body::parse(bytes).is_ok(), texts(&[body])),
        (|bytes| design_file::parse(bytes).is_ok(), texts(&[design])),
        (|bytes| environment::parse(bytes).is_ok(), texts(&[room])),
        (|bytes| measurements::parse(bytes).is_ok(), texts(&[MEASUREMENTS])),
        (|bytes| poses::parse(bytes).is_ok(), texts(&[POSES])),
        (|bytes| input::parse(bytes, true).is_ok(), texts(&[&input])),
        (|bytes| jhu_cis::parse_calbody(bytes).is_ok(), texts(&[CALBODY])),
        (|bytes| jhu_cis::parse_calreadings(bytes).is_ok(), texts(&[CALREADINGS])),
        (|bytes| jhu_cis::parse_optpivot(bytes).is_ok(), texts(&[OPTPIVOT])),
        (|bytes| jhu_cis::parse_empivot(bytes).is_ok(), vec![]),
        (|bytes| points::parse(bytes).is_ok(), vec![]),
        (|bytes| markups::parse_json(bytes).is_ok(), texts(&[markups::tests::JSON])),
        (|bytes| markups::parse_fcsv(bytes).is_ok(), texts(&[markups::tests::FCSV])),
        (|bytes| matrices::parse(bytes).is_ok(), vec![]),
        (|bytes| recorded_tool::parse(bytes).is_ok(), texts(&[MEASUREMENTS])),
        (|bytes| recording::parse(bytes).is_ok(), texts(&[recording::igs_mha::tests::HEADING])),
        (|bytes| pivot_recording::parse(bytes).is_ok(), vec![]),
        (|bytes| recovery_file::parse(bytes).is_ok(), vec![recovery_file::tests::good()]),
        (|bytes| baseline_file::parse(bytes).is_ok(), texts(&[&baseline_file::tests::good()])),
        (|bytes| recent_file::parse(bytes).is_ok(), texts(&[&recent_file::write(&["/a".into()])])),
        (
            |bytes| preferences_file::parse(bytes).is_ok(),
            texts(&[&preferences_file::write(&Preferences::default())]),
        ),
        (|bytes| mesh::read(bytes, "glb", None).is_ok(), vec![gltf::tests::triangle()]),
        (|bytes| mesh::read(bytes, "stl", None).is_ok(), vec![]),
        (|bytes| mesh::read(bytes, "obj", None).is_ok(), vec![]),
        (|bytes| mesh::read(bytes, "", None).is_ok(), mesh::tests::good_files().into()),
    ]
});

/// All parsers, one after the other.
fn parse_all(bytes: &[u8]) {
    for (accepts, _) in KINDS.iter() {
        let _ = accepts(bytes);
    }
}

fn good_files() -> Vec<Vec<u8>> {
    KINDS.iter().flat_map(|(_, files)| files.clone()).collect()
}

#[test]
fn the_good_files_are_good() {
    for (number, (accepts, files)) in KINDS.iter().enumerate() {
        assert!(files.iter().all(|file| accepts(file)), "kind {number}");
    }
}

#[test]
fn an_optical_pivot_is_whole_or_refused() {
    let frames = jhu_cis::parse_optpivot(OPTPIVOT.as_bytes()).unwrap();
    let lengths = frames.iter().map(|f| (f.on_base.len(), f.on_tool.len()));
    assert!(lengths.eq([(1, 2), (1, 2)]));
    assert_eq!((frames[1].on_base[0].x, frames[1].on_tool[1].z), (1.0, 0.0));
    // Up to its last number, whatever is cut off.
    for end in 0..OPTPIVOT.len() - "0\n".len() {
        assert!(jhu_cis::parse_optpivot(&OPTPIVOT.as_bytes()[..end]).is_err(), "{end}");
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        parse_all(&bytes);
    }

    #[test]
    fn bytes_behind_any_beginning_never_panic(
        beginning in prop::sample::select(&BEGINNINGS[..]),
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        parse_all(&[beginning.as_bytes(), &bytes].concat());
    }

    #[test]
    fn letters_in_any_order_never_panic(
        choices in prop::collection::vec(any::<prop::sample::Index>(), 0..200),
    ) {
        for letters in LETTERS.map(str::as_bytes) {
            let bytes: Vec<u8> = choices.iter().map(|choice| *choice.get(letters)).collect();
            parse_all(&bytes);
        }
    }

    #[test]
    fn damaged_files_never_panic(
        file in prop::sample::select(good_files()),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = file;
        for (index, byte) in edits {
            let index = index.index(bytes.len());
            bytes[index] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        parse_all(&bytes);
    }

    /// Digits are what the interesting numbers are made of.
    #[test]
    fn other_numbers_never_panic(
        file in prop::sample::select(good_files()),
        index in any::<prop::sample::Index>(),
        is_negative in any::<bool>(),
        digits in prop::collection::vec(b'0'..=b'9', 1..20),
    ) {
        let places: Vec<_> = (0..file.len()).filter(|&i| file[i].is_ascii_digit()).collect();
        let place = places[index.index(places.len())];
        let mut bytes = file;
        let sign = is_negative.then_some(b'-');
        bytes.splice(place..=place, sign.into_iter().chain(digits));
        parse_all(&bytes);
    }
}

/// Rows, or samples of recordings.
type Count = fn(&[u8]) -> Result<usize, FormatError>;

/// Texts that are read row by row, and what counts their rows.
fn row_texts() -> Vec<(String, Count)> {
    let samples: Count = |bytes| {
        let found = recording::parse(bytes)?;
        Ok(found.tools.iter().map(|tool| tool.samples.len()).sum())
    };
    let rows = |header: &str, row: &str| format!("{header}\n{}", format!("{row}\n").repeat(9));
    let pose = "x,y,z,qw,qx,qy,qz";
    let tool = "tool_x,tool_y,tool_z,tool_qw,tool_qx,tool_qy,tool_qz";
    let measured = MEASUREMENTS.lines().next().unwrap_or_default();
    let labelled = rows(
        &format!("{measured},sensor,pose"),
        "1,2,3,1,0,0,0,1.5,2,3,0.6,0.8,0,0,\"a, \"\"b\"\"\",7",
    );
    let live = "100.5,,a,OK,4,5,6,1,0,0,0";
    let printed = "Frame#,ToolHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error,#Markers";
    let ndi = "Tools\tPort 1\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz";
    let aurora = "Sample:,Hour,Minutes,Seconds,ms,Xa,Ya,Za,qoa,qxa,qya,qza";
    let rod = "level,row,column,rod,distance_mm";
    let sensor = "Sensor: a Position: 1 2 3 Orientation: 1 0 0 0 1 0 0 0 1";
    vec![
        (labelled.clone(), |bytes| Ok(measurements::parse(bytes)?.measurements.len())),
        (labelled.clone(), |bytes| Ok(recorded_tool::parse(bytes)?.rows.len())),
        (labelled.clone(), |bytes| {
            Ok(groups::parse(bytes, Some("pose"))?.map_or(0, |g| g.labels.len()))
        }),
        (labelled.replace(',', ";"), |bytes| Ok(measurements::parse(bytes)?.measurements.len())),
        (labelled.replace('\n', "\r"), |bytes| Ok(measurements::parse(bytes)?.measurements.len())),
        (rows(&format!("note,{pose}"), ",1,2,3,1,0,0,0"), |bytes| Ok(poses::parse(bytes)?.len())),
        (rows(tool, "1,2,3,1,0,0,0"), |bytes| Ok(input::parse(bytes, false)?.len())),
        (rows("name,x,y,z", "\"a, b\",1,2,3"), |bytes| Ok(points::parse(bytes)?.len())),
        (rows("# CoordinateSystem = LPS", "1,1,2,3,\"a, b\""), |bytes| {
            Ok(points::parse(bytes)?.len())
        }),
        (rows(&format!("{rod},{pose}"), "0,1,2,a,20,1,2,3,1,0,0,0"), |bytes| {
            Ok(plate_recording::parse(bytes)?.len())
        }),
        (protocol_table::tests::good(), |bytes| Ok(protocol_table::parse(bytes)?.rows.len())),
        (rows("1 2 3", "4;5;6"), |bytes| Ok(points::parse(bytes)?.len())),
        (rows(recording::live_table::HEADER, live), samples),
        (rows(printed, "100,Port:1,0,Enabled,1,0,0,0,1.5,2,3,0.1,0"), samples),
        (rows(ndi, "1\tPort 1\tOK\t1\t0\t0\t0\t4\t5\t6"), samples),
        (rows(aurora, "1,2,3,4,5,1,2,3,1,0,0,0"), samples),
        (rows(sensor, sensor), samples),
    ]
}

/// At each byte, and so in each cell: before, within and behind its text.
#[test]
fn a_stray_quote_never_drops_rows() {
    let (mut accepted, mut refused) = (0, 0);
    for (text, count) in row_texts() {
        let all = count(text.as_bytes()).unwrap();
        assert!(all >= 4, "{text}");
        let header = text.find(['\n', '\r']).unwrap() + 1;
        for stray in ["\"", "\"\"\"", "\n\""] {
            for at in 0..=text.len() {
                let mut bytes = text.clone().into_bytes();
                bytes.splice(at..at, stray.bytes());
                let line = 1 + bytes[..at].iter().filter(|b| **b == b'\n').count();
                match count(&bytes) {
                    Ok(found) => {
                        assert!(found >= all, "{found} rows: {stray:?} at {at} of {text}");
                        accepted += 1;
                    }
                    Err(error) => {
                        let message = error.to_string();
                        let is_named = message.starts_with(&format!("line {line}"));
                        let is_shifted = stray.starts_with('\n') || at < header;
                        assert!(is_named || is_shifted, "{line}: {message}: {at} of {text}");
                        refused += 1;
                    }
                }
            }
        }
    }
    assert!(refused > 4 * accepted, "{accepted} accepted, {refused} refused");
}

fn message<T>(result: Result<T, FormatError>) -> String {
    match result {
        Ok(_) => "no error".to_owned(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_table_with_quaternions_is_of_5_dof_sensors() {
    let set = measurements::parse(MEASUREMENTS.as_bytes()).unwrap();
    assert_eq!(set.content, MeasurementContent::FiveDof);
    assert_eq!(set.measurements.len(), 2);
    let measured = &set.measurements[0].tracker_from_measured;
    assert_eq!(pose_to_array(measured), [1.5, 2.0, 3.0, 0.6, 0.8, 0.0, 0.0]);
}

#[test]
fn quaternions_are_all_there_or_none() {
    let text = "measured_x,measured_y,measured_z,ideal_x,ideal_y,ideal_z\r\n1,2,3,4,5,6\r\n";
    let set = measurements::parse(text.as_bytes()).unwrap();
    assert_eq!(set.content, MeasurementContent::PositionOnly);
    assert_eq!(set.measurements[0].tracker_from_ideal, Pose::translation(4.0, 5.0, 6.0));
    let text = MEASUREMENTS.replace("ideal_qy", "ideal_q2").replace("measured_qw", "w");
    assert_eq!(
        message(measurements::parse(text.as_bytes())),
        "line 1: found no column ideal_qy, measured_qw, expected all of ideal_qw … ideal_qz and \
         measured_qw … measured_qz, or none of them"
    );
}

#[test]
fn wrong_tables_name_line_and_column() {
    let cases = r#"
        first,1, => first,one, | line 2: x is "one", expected a finite number
        first,1, => first,, | line 2: x is empty, expected a finite number
        first,1, => first,NaN, | line 2: x is "NaN", expected a finite number
        first,1, => first,-inf, | line 2: x is "-inf", expected a finite number
        first,1, => first,1e999, | line 2: x is "1e999", expected a finite number
        0,-1,0,0 => 0,-1.0011,0,0
            | line 2: length of the quaternion qw … qz is 1.0011, expected 1 within 0.001
        0,-1,0,0 => 0,0,0,0
            | line 2: length of the quaternion qw … qz is 0, expected 1 within 0.001
        first,1 => 1 | line 2: found 7 cells, expected 8, as in line 1
        first,1,2,3,0,-1,0,0\n => | found no rows, expected at least one
        note => x | line 1: found column x twice, expected it once
        note => x_mm | line 1: found column x twice, expected it once
        qx,qy => qx,q2
            | line 1: found no column qy, expected the columns of a poses table
            | (x, y, z, qw, qx, qy, qz)
    "#;
    assert_refused(POSES, cases, |text| message(poses::parse(text.as_bytes())));
    assert!(message(poses::parse(b"")).starts_with("line 1: found no column x, y, z, qw"));
}

#[test]
fn nearly_unit_quaternions_are_renormalised() {
    let poses = poses::parse(POSES.replace("0,-1,0,0", "0,1.0009,0,0").as_bytes()).unwrap();
    assert_eq!(poses[0].rotation.norm(), 1.0);
}

#[test]
fn crf_columns_count_only_with_a_crf() {
    let tool = "tool_x,tool_y,tool_z,tool_qw,tool_qx,tool_qy,tool_qz";
    let alone = format!("{tool}\n1,2,3,1,0,0,0\n");
    assert_eq!(input::parse(alone.as_bytes(), true).unwrap()[0].tracker_from_crf, None);
    let both = format!("{},{tool}\n4,5,6,1,0,0,0,1,2,3,1,0,0,0\n", tool.replace("tool", "crf"));
    let trial = input::parse(both.as_bytes(), true).unwrap()[0];
    assert_eq!(trial.tracker_from_crf, Some(Pose::translation(4.0, 5.0, 6.0)));
    assert_eq!(trial.crf_from_tool, Pose::translation(1.0, 2.0, 3.0));
    let broken = both.replace("crf_x", "elsewhere");
    assert_eq!(input::parse(broken.as_bytes(), false).unwrap()[0].tracker_from_crf, None);
    assert_eq!(
        message(input::parse(broken.as_bytes(), true)),
        "line 1: found no column crf_x, expected all of crf_x … crf_qz, or none of them"
    );
}

#[test]
fn calibration_files_are_split_into_markers() {
    let body = jhu_cis::parse_calbody(CALBODY.as_bytes()).unwrap();
    assert_eq!(
        (body.optical_on_base.len(), body.optical_on_object.len(), body.em_on_object.len()),
        (1, 1, 2)
    );
    assert_eq!(body.em_on_object[1].coords, Vector3::new(10.0, 11.0, 12.0));
    let frames = jhu_cis::parse_calreadings(CALREADINGS.as_bytes()).unwrap();
    assert_eq!(frames.len(), 2);
    assert_eq!(frames[1].em_on_object[0].coords, Vector3::new(7.0, 8.0, 9.0));
}

#[test]
fn wrong_calibration_files_name_the_line() {
    let calbody = |text: &str| message(jhu_cis::parse_calbody(text.as_bytes()));
    let calreadings = |text: &str| message(jhu_cis::parse_calreadings(text.as_bytes()));
    let cases = r#"
        10,11,12\n => | line 4: found the end of the file, expected more points: line 1 states
            | "1, 1, 2, pa1-calbody.txt"
        7,8,9 => 7,8 | line 4: found "7,8", expected x, y, z in mm
        10,11,12\n => 10,11,12\n1,2,3\n | line 6: found "1,2,3"…
    "#;
    assert_refused(CALBODY, cases, calbody);
    assert!(calbody(CALREADINGS).contains("expected three counts"));
    assert!(calreadings(CALBODY).contains("expected four counts"));
    let huge = CALREADINGS.replace("1, 1, 1, 2", "1, 1, 4000000000, 4000000000");
    assert!(calreadings(&huge).contains("counts of at most"));
}

#[test]
fn written_measurements_read_back_to_the_bit() {
    let pose = |values| pose_from_array(values).unwrap();
    let mut set = MeasurementSet {
        measurements: vec![Measurement {
            tracker_from_ideal: pose([0.1, 1e-9, -1e11, 0.5, -0.5, 0.5, 0.5]),
            tracker_from_measured: pose([1.0 / 3.0, -0.0, 7.0, 0.3, 0.2, -0.1, 0.9]),
        }],
        content: MeasurementContent::FiveDof,
    };
    let mut out = Vec::new();
    measurements::write(&mut out, &set).unwrap();
    assert_eq!(measurements::parse(&out).unwrap(), set);
    set.content = MeasurementContent::PositionOnly;
    let mut out = Vec::new();
    measurements::write(&mut out, &set).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert_eq!(
        text,
        "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z\n\
         0.1,1e-9,-100000000000,0.3333333333333333,-0,7\n"
    );
}

#[test]
fn the_log_has_one_row_a_trial() {
    let trial = Trial {
        crf_from_tool: pose_from_array([1.0, 2.0, 3.0, -1.0, 0.0, 0.0, 0.0]).unwrap(),
        crf_from_tool_simulated: Pose::translation(1.5, 2.0, 3.0),
        tip_error_in_crf_mm: Vector3::new(0.5, 0.0, 0.0),
        tip_error_mm: 0.5,
        angle_error_deg: 0.0,
        outside: 2,
        in_metal: 0,
        out_of_volume: 0,
        determined_mm: None,
        free_reach_mm: 0.0,
    };
    let mut out = Vec::new();
    log::write_header(&mut out).unwrap();
    log::write_trial(&mut out, &trial).unwrap();
    let text = String::from_utf8(out).unwrap();
    let (header, row) = text.split_once('\n').unwrap();
    assert_eq!(row, "1,2,3,1,0,0,0,1.5,2,3,1,0,0,0,0.5,0,0,0.5,0,2,0\n");
    assert_eq!(header.split(',').count(), row.split(',').count());
    assert!(header.starts_with("true_x,true_y,true_z,true_qw"), "{header}");
    assert!(header.ends_with("sim_qz,err_x,err_y,err_z,err_mm,err_deg,outside,out_of_volume"));
}

#[test]
fn distorted_poses_state_whether_they_were_outside() {
    let mut out = Vec::new();
    let place = |is: bool| poses::RowPlace { is_outside: is, is_without_field: is };
    let rows = [(Some(Pose::translation(1.0, 2.0, 3.0)), place(false)), (None, place(true))];
    poses::write_with_outside(&mut out, rows, None).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert_eq!(text, "x,y,z,qw,qx,qy,qz,outside,without_field\n1,2,3,1,0,0,0,0,0\n,,,,,,,1,1\n");
}

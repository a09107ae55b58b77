//! Geometries as text, and images within property lists.

use super::*;
use crate::test_cases::assert_refused;

#[test]
fn text_geometries_stay_until_the_body_changes() {
    let (ini, json) = (read(INI.as_bytes(), "").unwrap(), read(JSON.as_bytes(), "").unwrap());
    assert_eq!(ini.rigid, json.rigid);
    assert_eq!(ini.rigid.name, "geometry 7");
    assert_eq!(ini.rigid.tip_in_body, Some(Point3::new(0.0, -9.0, 3.0)));
    let with_mark = format!("\u{feff}{INI}");
    assert_eq!(read(with_mark.as_bytes(), "").unwrap().rigid, ini.rigid);
    for (text, format) in [
        (INI, DefinitionFormat::AtracsysIni),
        (&with_mark, DefinitionFormat::AtracsysIni),
        (JSON, DefinitionFormat::SawJson),
    ] {
        let body = through_body_file(&read(text.as_bytes(), "").unwrap());
        let conversion = to(&body, format);
        assert_eq!(*conversion.definition.write(), *text.as_bytes());
        assert_eq!(conversion.lost, []);
    }
    // The second marker moves to the front, the first one goes.
    let edit = |body: &BodyFile| {
        let mut body = body.clone();
        body.rigid.sensors.swap(0, 1);
        body.rigid.sensors.remove(1);
        body.rigid.sensors[1].position_in_body.z = 4.5;
        body
    };
    let conversion = to(&edit(&ini), DefinitionFormat::AtracsysIni);
    assert_eq!(codes(&conversion.lost), ["sensor_names"]);
    assert_eq!(
        String::from_utf8_lossy(&conversion.definition.write()),
        "; by hand\r\n[geometry]\r\ncount=2\r\nid=7\r\nversion=1\r\n[fiducial0]\nx=-23.69\r\ny=-22.77\r\nz=3\r\nnormalX=1\r\n[fiducial1]\nx=26.12\r\ny=-27.14\r\nz=4.5\r\n[pivot]\r\nx=0\r\ny=-9\r\nz=3\r\n"
    );
    let conversion = to(&edit(&json), DefinitionFormat::SawJson);
    assert_eq!(codes(&conversion.lost), ["comments", "sensor_names"]);
    let text = conversion.definition.write();
    assert!(String::from_utf8_lossy(&text).contains("disc // flat"));
    let ToolDefinition::SawJson(read_back) =
        ToolDefinition::parse(DefinitionKind::SawJson, &text, OnMismatch::Refuse).unwrap()
    else {
        panic!()
    };
    assert_eq!(Some(read_back.geometry()), conversion.definition.geometry());
}

#[test]
fn errors_of_text_geometries_have_a_place() {
    let cases = r#"
        count=3 => count=4
            | geometry.count is 4, with 3 [fiducial…] sections, expected the number of these, one
            | at least
        count=3 => count=-3 | line 3: geometry.count is "-3", expected a count
        x=-23.69 => x=-23,69 | line 11: fiducial1.x is "-23,69", expected a number of mm
        x=-23.69 => x=NaN | fiducial1.x is NaN, expected a number of mm
        x=-23.69 => w=1 | fiducial1.x is missing, expected a number of mm
        x=-23.69 => y=1 | line 12: found y again, expected each key of a section once
        [fiducial1] => [fiducial0]
            | line 10: found [fiducial0] again, expected each section once
        [fiducial1] => fiducial1
            | line 10: found "fiducial1", expected a [section] or a key=value within one
        [fiducial2] => [fiducial3] | fiducial2.x is missing, expected a number of mm
    "#;
    assert_refused(INI, cases, |text| read(text.as_bytes(), "ini").unwrap_err());
    let cases = r#"
        "count": 3 => "count": 2
            | count is 2, with 3 fiducials, expected the number of fiducials
        -23.69 => "a" | fiducials[1].x is "a", expected a number of mm
        "fiducials" => "tools"
            | fiducials is missing beside `tools`, which is a tracker's configuration, expected the
            | markers of a tool
        "id": 7 => "id": 7.5 | id is 7.5, expected a whole number
        "id": 7, => "id": 7
            | line 4, column 2: found no JSON (expected `,` or `}`), expected an object
    "#;
    assert_refused(JSON, cases, |text| read(text.as_bytes(), "json").unwrap_err());
    let deep = format!("{{\"fiducials\": {}", "[".repeat(MAX_BYTES / 2));
    assert!(read(deep.as_bytes(), "json").unwrap_err().contains("recursion limit"));
    let many = format!(
        "[geometry]\ncount=1001\n{}",
        (0..1001).map(|i| format!("[fiducial{i}]\n")).collect::<String>()
    );
    let message = read(many.as_bytes(), "ini").unwrap_err();
    assert_eq!(message, "count is 1001, expected at most 1000 markers");
    let long = format!("{{\"fiducials\": [{}", "1,".repeat(MAX_BYTES));
    assert!(read(long.as_bytes(), "json").unwrap_err().starts_with("length is "));
}

pub(super) fn plist_of(image: &[u8]) -> String {
    let data = data_encoding::BASE64.encode(image);
    let (start, end) = data.split_at(100);
    format!(
        "<?xml version=\"1.0\"?>\n<!DOCTYPE plist [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;\">]>\n<plist version=\"1.0\"><dict>\n<key>Name</key><string>&b;</string>\n<key>ROMData</key>\n<data>\n  {start}\n  {end}\n</data><key>data</key><data>AA==</data></dict></plist>\n"
    )
}

#[test]
fn a_tool_file_keeps_all_around_its_image() {
    for image in [optical_image(), em_image()] {
        let text = plist_of(&image);
        let mut body = through_body_file(&read(text.as_bytes(), "").unwrap());
        assert_eq!(rom_bytes(&body), image);
        let same = to(&body, DefinitionFormat::ToolPlist);
        assert_eq!(*same.definition.write(), *text.as_bytes());
        // A new one around an image that stood alone.
        let alone = read(&image, "rom").unwrap();
        let wrapped = to(&alone, DefinitionFormat::ToolPlist).definition.write().into_owned();
        assert_eq!(rom_bytes(&read(&wrapped, "tool").unwrap()), image);
        body.rigid.sensors[0].position_in_body.x = 3.0;
        let moved = to(&body, DefinitionFormat::ToolPlist).definition.write().into_owned();
        let moved = String::from_utf8(moved).unwrap();
        assert!(moved.contains("<key>Name</key><string>&b;</string>"), "{moved}");
        assert_eq!(read(moved.as_bytes(), "").unwrap().rigid, body.rigid);
        for cut in 0..text.rfind("</plist>").unwrap() + 8 {
            assert!(read(&text.as_bytes()[..cut], "tool").is_err(), "cut at {cut}");
        }
    }
}

#[test]
fn property_lists_need_a_sound_image() {
    let image = optical_image();
    let text = plist_of(&image);
    let cases = r#"
        ROMData => RomData | ROMData is missing, expected an NDI image in base64…
        TkRJ => T*RJ | ROMData is no base64 from its letter 2 on, expected base64…
        <plist version="1.0"> => <html> | line 3, column 1: found <html>, expected <plist>…
        <key>data</key> => <key>ROMData</key> | …found ROMData twice, expected it once…
        </data> => <b/></data> | …found more than text in it, expected its end tag…
        </dict> => </dixt> | …found no XML…
    "#;
    assert_refused(&text, cases, |text| read(text.as_bytes(), "tool").unwrap_err());
    let deep = format!("<plist>{}", "<array>".repeat(MAX_BYTES / 8));
    assert!(read(deep.as_bytes(), "tool").unwrap_err().contains("cut short"));
    let huge = plist_of(&vec![0; MAX_BYTES]);
    assert!(read(huge.as_bytes(), "tool").unwrap_err().starts_with("length is "));
}

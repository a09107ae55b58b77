//! What is reported of a tool in words.

use super::*;

fn reported(body: &BodyFile) -> Vec<String> {
    let facts = carried(body).facts();
    let line = |fact: &Fact| format!("{}: {} {}", fact.what, fact.value, fact.unit);
    facts.iter().map(|f| line(f).trim_end().to_owned()).collect()
}

#[test]
fn an_images_facts_have_values_and_units() {
    let mut image = optical_image();
    image.extend([0xee, 0xff]);
    let body = read(&image, "rom").unwrap();
    let reported = reported(&body);
    for line in [
        "manufacturer: SINTEF helse",
        "part number: 8700339",
        "serial number: 34801403",
        "date: 2005-01-06",
        "markers: 4",
        "largest angle of a marker: 90 deg",
        "largest error of a marker: 0.75 mm",
        "trailing bytes: 2: EE FF",
    ] {
        assert!(reported.iter().any(|it| it == line), "{line}: {reported:?}");
    }
    assert_eq!(carried(&body).doubt(), None);
}

#[test]
fn a_new_image_was_made_on_no_day_by_nobody() {
    let mut body = read(INI.as_bytes(), "ini").unwrap();
    assert_eq!(reported(&body), ["number: 7", "markers: 3", "pivot: given, as the tip"]);
    body.definition = None;
    let image = rom_bytes(&body);
    let reported = reported(&read(&image, "rom").unwrap());
    for line in ["serial number: none", "date: none", "manufacturer: none"] {
        assert!(reported.iter().any(|it| it == line), "{line}: {reported:?}");
    }
}

#[test]
fn an_accepted_wrong_checksum_is_reported() {
    let mut image = em_image();
    image[60] ^= 1;
    let (body, _) = read_body(&image, "rom", OnMismatch::Accept).unwrap();
    let sum = carried(&body).rom().unwrap().checksum();
    let doubt = carried(&body).doubt().unwrap();
    let numbers = format!("checksum is {}, expected {}", sum.stored, sum.computed);
    assert!(doubt.ends_with(&numbers), "{doubt}");
}

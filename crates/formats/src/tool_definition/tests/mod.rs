//! Images made here byte by byte, so that the offsets are stated twice, and what is wrong with
//! them.

mod facts;
mod images;
mod losses;
mod properties;
mod texts;

use super::geometry::marker;
use super::*;
use crate::body::{self, BodyFile};
use nalgebra::Point3;
use std::f32::consts::PI;
use trackwright_design::definition::DefinitionKind;
use trackwright_simulation::body::RigidBody;
use trackwright_simulation::body::{Sensor, SensorOrientation};
use trackwright_simulation::mounting::Mounting;

const PLACES: [[f32; 3]; 4] =
    [[0.0, -0.0, 0.0], [0.0, 28.59, 41.02], [0.0, 0.0, 88.0], [0.0, -44.32, 40.45]];

fn carried(body: &BodyFile) -> ToolDefinition {
    ToolDefinition::carried(body.definition.as_deref()).unwrap()
}

fn put(image: &mut [u8], at: usize, bytes: &[u8]) {
    image[at..at + bytes.len()].copy_from_slice(bytes);
}

fn put_floats(image: &mut [u8], at: usize, values: &[f32]) {
    for (i, value) in values.iter().enumerate() {
        put(image, at + 4 * i, &value.to_le_bytes());
    }
}

fn with_sum(mut image: Vec<u8>) -> Vec<u8> {
    let sum: u32 = image[6..752].iter().map(|b| u32::from(*b)).sum();
    put(&mut image, 4, &sum.to_le_bytes()[..2]);
    image
}

/// Four markers with normals of their own, and two slots of what was there before.
fn optical_image() -> Vec<u8> {
    let mut image = vec![0; 752];
    put(&mut image, 0, b"NDI\0");
    put(&mut image, 8, &[1, 0, 0, 0, 1, 0, 0, 2]);
    put(&mut image, 20, &[0x03, 0x14, 0x80, 0x34, 90, 0, 0, 0, 4, 0, 0, 0, 3]);
    put_floats(&mut image, 36, &[0.75]);
    for (i, place) in PLACES.iter().enumerate() {
        put_floats(&mut image, 72 + 12 * i, place);
        put_floats(&mut image, 312 + 12 * i, &[1.0, 0.0, i as f32]);
        image[552 + i] = i as u8;
        image[613 + i] = 1 + i as u8 % 2;
        image[633 + i] = 1;
    }
    for stale in 4..6 {
        put_floats(&mut image, 72 + 12 * stale, &[-1613.4, f32::NAN, 0.5]);
        image[552 + stale] = stale as u8;
        image[613 + stale] = 1;
    }
    put(&mut image, 580, b"SINTEF helse8700339");
    put_floats(&mut image, 656, &[0.0, 0.0, -1.0]);
    with_sum(image)
}

fn with_em_sum(mut image: Vec<u8>) -> Vec<u8> {
    let sum: u32 = image[4..325].iter().map(|b| u32::from(*b)).sum();
    put(&mut image, 325, &sum.to_le_bytes());
    image
}

/// Two coils 0.7 mm apart that cross at 25°.
fn em_image() -> Vec<u8> {
    let mut image = vec![0; 329];
    put(&mut image, 0, &[1, 0, 0x41, 1, 0, 0, 0, 4]);
    put(&mut image, 12, &[0, 0x10, 0x91, 0x37, 2, 0, 0, 0, 2]);
    put(&mut image, 30, &[0xab; 5]);
    let polar = 12.5_f32.to_radians();
    put_floats(&mut image, 56, &[0.0, -0.35, -4.5, 0.0, polar]);
    put_floats(&mut image, 76, &[0.0, 0.35, -4.5, PI, polar]);
    put_floats(&mut image, 216, &[18.0, 18.0]);
    put(&mut image, 292, b"NDI");
    put(&mut image, 304, b"610029");
    with_em_sum(image)
}

fn read(bytes: &[u8], extension: &str) -> Result<BodyFile, String> {
    let found = read_body(bytes, extension, OnMismatch::Refuse);
    found.map(|(body, _)| body).map_err(|e| e.to_string())
}

fn to(body: &BodyFile, format: DefinitionFormat) -> Conversion {
    from_body(body, format).unwrap()
}

fn rom_bytes(body: &BodyFile) -> Vec<u8> {
    to(body, DefinitionFormat::Rom).definition.write().into_owned()
}

/// Where two images differ.
fn changes(a: &[u8], b: &[u8]) -> Vec<usize> {
    assert_eq!(a.len(), b.len());
    (0..a.len()).filter(|i| a[*i] != b[*i]).collect()
}

fn codes(lost: &[Lost]) -> Vec<&'static str> {
    lost.iter().map(Lost::code).collect()
}

fn through_body_file(body: &BodyFile) -> BodyFile {
    body::parse(body::write(body).as_bytes()).unwrap()
}

const INI: &str = "; by hand\r\n[geometry]\r\ncount=3\r\nid=7\r\nversion=1\r\n[fiducial0]\r\nx=0.000000 ; first\r\ny=26.87\r\nz=3\r\n[fiducial1]\r\nx=-23.69\r\ny=-22.77\r\nz=3\r\nnormalX=1\r\n[fiducial2]\r\nx=26.12\r\ny=-27.14\r\nz=3\r\n[pivot]\r\nx=0\r\ny=-9\r\nz=3\r\n";

const JSON: &str = "/* a \"tool\" */\n{\n \"count\": 3, \"id\": 7, // seven\n \"fiducials\": [{\"x\": 0.0, \"y\": 26.870000, \"z\": 3}, {\"x\": -23.69, \"y\": -22.77, \"z\": 3.0, \"type\": \"disc // flat\"},\n {\"x\": 26.12, \"y\": -27.14, \"z\": 3}],\n \"pivot\": {\"x\": 0, \"y\": -9, \"z\": 3}\n}\n";

#[test]
fn places_beyond_a_kilometre_are_refused() {
    let far = JSON.replace("26.870000", "-1e7");
    assert_eq!(
        read(far.as_bytes(), "json").unwrap_err(),
        "marker 1: position is (0, -10000000, 3), expected coordinates of at most 1e6 mm"
    );
}

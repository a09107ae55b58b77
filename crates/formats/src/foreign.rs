//! Files of other kinds than the one that is expected, by their first bytes and by their names.

use super::error::FormatError;

/// So many bytes of a file are enough.
pub const HEAD: usize = 4096;

/// A kind of file.
struct Kind {
    /// With its article.
    name: &'static str,
    /// Bytes at a place.
    signatures: &'static [(usize, &'static [u8])],
    /// Ends of names, small letters.
    endings: &'static [&'static str],
    /// Words in what is expected where this program reads such files.
    read_as: &'static [&'static str],
    /// What to do about it.
    advice: &'static str,
}

const AS_CSV: &str = "; save it as CSV";
const UNPACK: &str = "; unpack it first";
const NUMBERS: &str = "; write its numbers as CSV";
const POSES: &str = "; write its poses as CSV";
const OPTITRACK: &[&str] = &[".tra", ".tak", ".ttp", ".motive"];
const TABLES: &[&str] = &["table", "recording", "points", "calbody", "calreadings"];

/// The first that fits is it, so that a workbook is found before the archive that it is.
const KINDS: [Kind; 33] = [
    kind(
        "an Excel workbook",
        &[(0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")],
        &[".xlsx", ".xlsm", ".xls"],
        AS_CSV,
    ),
    kind(
        "an OpenDocument sheet",
        &[(30, b"mimetypeapplication/vnd.oasis.opendocument")],
        &[".ods"],
        AS_CSV,
    ),
    kind("an Apple Numbers sheet", &[], &[".numbers"], AS_CSV),
    kind("a zip archive", &[(0, b"PK\x03\x04")], &[".zip"], UNPACK),
    kind("a gzip archive", &[(0, b"\x1f\x8b")], &[".gz", ".tgz"], UNPACK),
    kind("a 7-Zip archive", &[(0, b"7z\xbc\xaf\x27\x1c")], &[".7z"], UNPACK),
    kind("a PNG image", &[(0, b"\x89PNG\r\n\x1a\n")], &[".png"], ""),
    kind("a JPEG image", &[(0, b"\xff\xd8\xff")], &[".jpg", ".jpeg"], ""),
    kind("a TIFF image", &[(0, b"II*\0"), (0, b"MM\0*")], &[".tif", ".tiff"], ""),
    kind("a DICOM file", &[(128, b"DICM")], &[".dcm", ".ima"], ""),
    kind("a NIfTI image", &[(344, b"n+1\0"), (344, b"ni1\0")], &[".nii"], ""),
    kind("an NRRD image", &[(0, b"NRRD000")], &[".nrrd", ".nhdr"], ""),
    kind("a PDF document", &[(0, b"%PDF-")], &[".pdf"], ""),
    kind("a MATLAB file", &[(0, b"MATLAB ")], &[".mat"], NUMBERS),
    kind("an HDF5 file", &[(0, b"\x89HDF\r\n\x1a\n")], &[".h5", ".hdf5"], NUMBERS),
    kind("a NumPy array", &[(0, b"\x93NUMPY")], &[".npy", ".npz"], NUMBERS),
    kind("a Parquet table", &[(0, b"PAR1")], &[".parquet"], "; write it as CSV"),
    kind("a SQLite database", &[(0, b"SQLite format 3\0")], &[".sqlite", ".db"], ""),
    kind("a ROS bag", &[(0, b"#ROSBAG"), (0, b"\x89MCAP0\r\n")], &[".bag", ".mcap"], POSES),
    kind("a C3D motion-capture file", &[], &[".c3d"], POSES),
    kind("an OptiTrack tool or take, which is not read", &[], OPTITRACK, ""),
    kind("a Vicon file, which is not read", &[], &[".vsk", ".vst", ".x2d"], ""),
    kind("a STEP model", &[(0, b"ISO-10303-21")], &[".step", ".stp"], "; export it as STL"),
    kind("a CAD model", &[], &[".iges", ".igs", ".sldprt", ".ipt", ".f3d"], "; export it as STL"),
    kind("UTF-16 text", &[(0, b"\xff\xfe"), (0, b"\xfe\xff")], &[], "; save it as UTF-8"),
    read("an NDI tool definition", &[(0, b"NDI\0")], &[".rom"], &["body", "tool"]),
    read("a glTF mesh", &[(0, b"glTF")], &[".glb", ".gltf"], &["mesh"]),
    read("a mesh", &[], &[".stl", ".obj", ".ply"], &["mesh"]),
    read("a design", &[], &[".design.ron"], &["design"]),
    read("a body", &[], &[".body.ron"], &["body"]),
    read("an environment", &[], &[".env.ron"], &["environment"]),
    read("a field generator", &[], &[".generator.ron"], &["generator"]),
    read("a table", &[], &[".csv", ".tsv"], TABLES),
];

const fn kind(
    name: &'static str,
    signatures: &'static [(usize, &'static [u8])],
    endings: &'static [&'static str],
    advice: &'static str,
) -> Kind {
    Kind { name, signatures, endings, read_as: &[], advice }
}

const fn read(
    name: &'static str,
    signatures: &'static [(usize, &'static [u8])],
    endings: &'static [&'static str],
    read_as: &'static [&'static str],
) -> Kind {
    Kind { name, signatures, endings, read_as, advice: "" }
}

impl Kind {
    fn has_signature(&self, head: &[u8]) -> bool {
        let is_there = |(place, bytes): &(usize, &[u8])| {
            head.get(*place..).is_some_and(|rest| rest.starts_with(bytes))
        };
        self.signatures.iter().any(is_there)
    }

    fn has_ending(&self, name: &str) -> bool {
        self.endings.iter().any(|ending| name.ends_with(ending))
    }

    fn is_read_as(&self, expected: &str) -> bool {
        self.read_as.iter().any(|word| expected.contains(word))
    }
}

/// What a file that cannot be read as `expected` is instead, by its beginning or else by its name;
/// `None` where it is of no known kind, or of the one that is expected.
///
/// ```
/// use trackwright_formats::foreign::foreign;
///
/// let png = foreign(b"\x89PNG\r\n\x1a\n", "a.csv", "a table").unwrap();
/// assert_eq!(png.to_string(), "found a PNG image, expected a table");
/// ```
pub fn foreign(head: &[u8], file_name: &str, expected: &'static str) -> Option<FormatError> {
    let name = file_name.to_lowercase();
    // A workbook is an archive by its bytes.
    let is_archive = head.starts_with(b"PK\x03\x04");
    let by_bytes = KINDS.iter().find(|kind| {
        kind.has_signature(head)
            && !(is_archive && KINDS.iter().any(|known| known.has_ending(&name)))
    });
    let found = by_bytes.or_else(|| KINDS.iter().find(|kind| kind.has_ending(&name)))?;
    (!found.is_read_as(expected)).then_some(FormatError::Foreign {
        found: found.name,
        expected,
        advice: found.advice,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(head: &[u8], name: &str, expected: &'static str) -> Option<String> {
        foreign(head, name, expected).map(|error| error.to_string())
    }

    #[test]
    fn bytes_decide_before_file_names() {
        let png = message(b"\x89PNG\r\n\x1a\n....", "a.csv", "a measurement table");
        assert_eq!(png.unwrap(), "found a PNG image, expected a measurement table");
        let workbook = message(b"PK\x03\x04....", "A.XLSX", "points");
        assert_eq!(workbook.unwrap(), "found an Excel workbook, expected points; save it as CSV");
        let archive = message(b"PK\x03\x04....", "a", "a mesh").unwrap();
        assert_eq!(archive, "found a zip archive, expected a mesh; unpack it first");
        let mut dicom = vec![0; 140];
        dicom[128..132].copy_from_slice(b"DICM");
        assert!(message(&dicom, "x", "a mesh").unwrap().contains("a DICOM file"));
        let optitrack = message(b"\x01\x02", "tool.tra", "a body or a tool definition").unwrap();
        assert!(optitrack.contains("an OptiTrack tool or take, which is not read"), "{optitrack}");
    }

    #[test]
    fn what_is_expected_is_not_foreign() {
        assert_eq!(message(b"NDI\0", "a.rom", "a body or a tool definition"), None);
        assert!(message(b"NDI\0", "a.rom", "a recording").is_some());
        assert_eq!(message(b"x,y", "a.csv", "a poses table"), None);
        assert!(message(b"x,y", "a.csv", "an environment").is_some());
        assert_eq!(message(b"", "a.txt", "a recording"), None);
        assert_eq!(message(b"(version: 1", "a.env.ron", "an environment"), None);
    }
}

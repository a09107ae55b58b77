//! Pictures as pixels: where a colour is, and what differs.

use std::collections::BTreeSet;

/// A place in a picture, pixels from its upper left corner.
pub type Pixel = [usize; 2];

/// Eight bits a channel, sRGB.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pixels: Vec<[u8; 3]>,
}

/// Pixels of one colour that touch each other.
#[derive(Clone, Debug)]
pub struct Blob {
    pub pixels: Vec<Pixel>,
}

impl Picture {
    pub fn new(width: usize, height: usize, pixels: Vec<[u8; 3]>) -> Self {
        assert_eq!(pixels.len(), width * height);
        Self { width, height, pixels }
    }

    /// Reads a PNG file of three channels.
    #[track_caller]
    pub fn read(path: &std::path::Path) -> Self {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        let pixels = data.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        Self::new(info.width as usize, info.height as usize, pixels)
    }

    pub fn at(&self, [x, y]: Pixel) -> [u8; 3] {
        self.pixels[y * self.width + x]
    }

    /// The pixels of the requested colour.
    pub fn all(&self, is_wanted: impl Fn([u8; 3]) -> bool) -> BTreeSet<Pixel> {
        let places = (0..self.height).flat_map(|y| (0..self.width).map(move |x| [x, y]));
        places.filter(|at| is_wanted(self.at(*at))).collect()
    }

    /// How many pixels differ.
    pub fn differences(&self, other: &Self) -> usize {
        assert_eq!((self.width, self.height), (other.width, other.height));
        self.pixels.iter().zip(&other.pixels).filter(|(a, b)| a != b).count()
    }

    /// Groups of touching pixels (corners count) of the requested colour, the largest first.
    pub fn blobs(&self, is_wanted: impl Fn([u8; 3]) -> bool) -> Vec<Blob> {
        let mut left = self.all(is_wanted);
        let mut blobs = Vec::new();
        while let Some(first) = left.pop_first() {
            let mut pixels = vec![first];
            let mut next = 0;
            while let Some([x, y]) = pixels.get(next).copied() {
                next += 1;
                for nx in x.saturating_sub(1)..=x + 1 {
                    for ny in y.saturating_sub(1)..=y + 1 {
                        if left.remove(&[nx, ny]) {
                            pixels.push([nx, ny]);
                        }
                    }
                }
            }
            blobs.push(Blob { pixels });
        }
        blobs.sort_by_key(|blob| std::cmp::Reverse(blob.pixels.len()));
        blobs
    }
}

impl Blob {
    pub fn center(&self) -> [f64; 2] {
        let n = self.pixels.len() as f64;
        [0, 1].map(|k| self.pixels.iter().map(|p| p[k] as f64).sum::<f64>() / n)
    }

    /// The direction in which it is longest, of length 1: the eigenvector of its second moments.
    pub fn direction(&self) -> [f64; 2] {
        let [cx, cy] = self.center();
        let moments = self.pixels.iter().fold([0.0; 3], |[xx, xy, yy], p| {
            let (x, y) = (p[0] as f64 - cx, p[1] as f64 - cy);
            [xx + x * x, xy + x * y, yy + y * y]
        });
        let angle = 0.5 * (2.0 * moments[1]).atan2(moments[0] - moments[2]);
        [angle.cos(), angle.sin()]
    }
}

/// Whether no channel is further off than this.
pub fn is_near(color: [u8; 3], wanted: [u8; 3], at_most: u8) -> bool {
    color.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= at_most)
}

/// The ghost's hue: blue over green, red at most half of it, whatever shines through. The CRF's
/// own teal has more green than blue and more red.
pub fn is_ghost([r, g, b]: [u8; 3]) -> bool {
    b >= g && g > 60 && u16::from(r) * 2 < u16::from(g)
}

/// The hue of error vectors: red and blue far above green.
pub fn is_error_vector([r, g, b]: [u8; 3]) -> bool {
    r > 120 && u16::from(g) * 2 < u16::from(r) && b > 100 && r > b
}

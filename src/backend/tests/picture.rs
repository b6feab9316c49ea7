//! Pictures to correct, and the corrected pictures.

/// A picture in memory, row 0 at the bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub size: (u32, u32),
    pub pixels: Vec<[u8; 4]>,
}

impl Picture {
    pub fn new(size: (u32, u32), pixel: impl Fn(u32, u32) -> [u8; 4]) -> Self {
        let pixels = (0..size.0 * size.1).map(|i| pixel(i % size.0, i / size.0)).collect();
        Self { size, pixels }
    }

    /// Returns a pixel; row 0 is at the bottom.
    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        self.pixels[(y * self.size.0 + x) as usize]
    }

    /// Returns the bilinear value at a place in texels, encoded, 0…1.
    pub fn bilinear(&self, x: f64, y: f64) -> [f64; 4] {
        let (x, y) = (x - 0.5, y - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let clamp = |v: f64, size: u32| (v.max(0.0) as u32).min(size - 1);
        let corner = |i: f64, j: f64| {
            self.at(clamp(x.floor() + i, self.size.0), clamp(y.floor() + j, self.size.1)).map(|c| f64::from(c) / 255.0)
        };
        let (a, b, c, d) = (corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0));
        std::array::from_fn(|k| (a[k] * (1.0 - fx) + b[k] * fx) * (1.0 - fy) + (c[k] * (1.0 - fx) + d[k] * fx) * fy)
    }
}

//! Pictures to correct, and places to draw.

use crate::backend::gl::api::*;

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

    /// Row 0 at the bottom.
    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        self.pixels[(y * self.size.0 + x) as usize]
    }

    /// Bilinear value at a place in texels, encoded values 0…1.
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

    pub fn texture(&self, gl: &Gl, format: u32) -> u32 {
        let mut texture = 0;
        let data = self.pixels.as_ptr().cast();
        // SAFETY: a context is current; the array holds the whole picture.
        unsafe {
            gl.gen_textures(1, &mut texture);
            gl.bind_texture(GL_TEXTURE_2D, texture);
            let (width, height) = (self.size.0 as i32, self.size.1 as i32);
            gl.tex_image2_d(GL_TEXTURE_2D, 0, format as i32, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, data);
            gl.tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
            gl.bind_texture(GL_TEXTURE_2D, 0);
        }
        texture
    }
}

/// A framebuffer with one RGBA8 texture, filled with a colour that no test expects to stay.
pub struct Canvas {
    pub framebuffer: u32,
    pub size: (u32, u32),
}

impl Canvas {
    pub fn new(gl: &Gl, size: (u32, u32)) -> Self {
        let picture = Picture::new(size, |_, _| [255, 0, 255, 77]);
        let texture = picture.texture(gl, GL_RGBA8);
        let mut framebuffer = 0;
        // SAFETY: a context is current.
        unsafe {
            gl.gen_framebuffers(1, &mut framebuffer);
            gl.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
            gl.framebuffer_texture2_d(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
            assert_eq!(gl.check_framebuffer_status(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
            gl.bind_framebuffer(GL_FRAMEBUFFER, 0);
        }
        Self { framebuffer, size }
    }

    pub fn viewport(&self) -> [i32; 4] {
        [0, 0, self.size.0 as i32, self.size.1 as i32]
    }

    /// What is in it.
    pub fn read(&self, gl: &Gl) -> Picture {
        let mut picture = Picture::new(self.size, |_, _| [0; 4]);
        let data = picture.pixels.as_mut_ptr().cast();
        // SAFETY: a context is current; the array holds the whole picture.
        unsafe {
            gl.bind_framebuffer(GL_READ_FRAMEBUFFER, self.framebuffer);
            gl.read_pixels(0, 0, self.size.0 as i32, self.size.1 as i32, GL_RGBA, GL_UNSIGNED_BYTE, data);
            gl.bind_framebuffer(GL_READ_FRAMEBUFFER, 0);
            assert_eq!(gl.get_error(), GL_NO_ERROR);
        }
        picture
    }
}

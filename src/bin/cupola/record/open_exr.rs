//! OpenEXR files of recorded pictures: half floats of linear light, as programs for compositing
//! expect them.

use cupola::ring::Picture;
use exr::prelude::{Encoding, Image, SpecificChannels, Vec2, WritableImage, f16};
use std::io::Cursor;

/// Encodes a picture of 16 bits as an OpenEXR file. Equal pixels give equal bytes.
pub fn file(picture: &Picture) -> Result<Vec<u8>, exr::error::Error> {
    let (width, height) = (picture.size.0 as usize, picture.size.1 as usize);
    let light = lights();
    let color = |at: usize| {
        let bytes = picture.rgba.get(at..at + 2).map_or([0; 2], |bytes| [bytes[0], bytes[1]]);
        light[usize::from(u16::from_ne_bytes(bytes))]
    };
    let pixel = |Vec2(x, y): Vec2<usize>| {
        let at = (y * width + x) * 8;
        (color(at), color(at + 2), color(at + 4))
    };
    let image = Image::from_encoded_channels((width, height), Encoding::SMALL_LOSSLESS, SpecificChannels::rgb(pixel));
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// Light of each value that is shown.
fn lights() -> &'static [f16] {
    static LIGHTS: std::sync::OnceLock<Vec<f16>> = std::sync::OnceLock::new();
    LIGHTS.get_or_init(|| (0..=u16::MAX).map(|value| f16::from_f64(light(f64::from(value) / 65535.0))).collect())
}

/// Light of a shown value by the curve of sRGB (IEC 61966-2-1).
fn light(shown: f64) -> f64 {
    if shown <= 0.04045 { shown / 12.92 } else { ((shown + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cupola::ring::Format;
    use exr::prelude::{ReadChannels, ReadLayers, read};

    #[test]
    fn a_file_has_the_light_of_each_pixel() {
        let colors: [u16; 8] = [65535, 32768, 257, 65535, 1, 40_000, 0, 65535];
        let rgba: Vec<u8> = colors.iter().flat_map(|color| color.to_ne_bytes()).collect();
        let picture = Picture { name: "a".into(), size: (2, 1), rgba, format: Format::Rgba16 };
        let bytes = file(&picture).expect("a file");
        assert_eq!(bytes, file(&picture).expect("a file"));
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |_, _| Vec::new(),
                |pixels: &mut Vec<(f32, f32, f32)>, _, pixel: (f32, f32, f32)| pixels.push(pixel),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .expect("an OpenEXR file");
        let found: Vec<f64> =
            image.layer_data.channel_data.pixels.iter().flat_map(|(r, g, b)| [*r, *g, *b]).map(f64::from).collect();
        let expected = [1.0, 0.21404, 0.000_303_5, 0.000_001_181, 0.33095, 0.0];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= expected / 1000.0 + 3e-8, "{found} is not {expected}");
        }
        assert!(found[3] > 0.0, "the darkest grey is not black");
    }
}

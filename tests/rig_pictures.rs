//! Keys of a rig file for an output's finished picture: its mask, its black and how it is mirrored.

use cupola::rig::parse;
use std::path::Path;

#[test]
fn masks() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(folder.join("not-a.png"), "text").unwrap();
    let png = b"\x89PNG\r\n\x1a\n and so on";
    std::fs::write(folder.join("a.png"), png).unwrap();
    let read = |mask: &str| {
        let text = format!("[[output]]\nkind = \"domemaster\"\n{mask}");
        parse(&text, "rig.toml", folder).map_err(|error| error.message)
    };
    let rig = read("mask = { image = \"a.png\" }").unwrap();
    assert_eq!(rig.outputs[0].mask.as_deref(), Some(folder.join("a.png").as_path()));
    let cases = [
        ("mask = { image = \"none.png\" }", "rig.toml:3: output[0].mask.image", "cannot be read"),
        ("mask = { image = \"not-a.png\" }", "rig.toml:3: output[0].mask.image", "no PNG file"),
        ("mask = { image = \"\" }", "rig.toml:3: output[0].mask.image", "the name is empty"),
        ("mask = {}", "rig.toml:3: output[0].mask.image", "is missing"),
        ("mask = { file = \"a.png\", image = \"a.png\" }", "rig.toml:3: output[0].mask.file", "unknown key"),
        ("mask = \"a.png\"", "rig.toml:3: output[0].mask", "not a table"),
    ];
    for (mask, start, words) in cases {
        let message = read(mask).unwrap_err();
        assert!(message.starts_with(start) && message.contains(words), "{message}");
    }
}

#[test]
fn blacks() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let pfm = |name: &str, last: f32| {
        let values: Vec<f32> = [0.0; 9].into_iter().chain([0.25, last, 0.5]).collect();
        let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
        std::fs::write(folder.join(name), [&b"PF\n2 2\n-1.0\n"[..], &bytes].concat()).unwrap();
    };
    pfm("black.pfm", 1.0);
    pfm("nan.pfm", f32::NAN);
    pfm("negative.pfm", -0.125);
    pfm("bright.pfm", 1.5);
    std::fs::write(folder.join("no-black.png"), "text").unwrap();
    std::fs::write(folder.join("cut.png"), b"\x89PNG\r\n\x1a\n and so on").unwrap();
    image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([51, 0, 255 * x as u8])).save(folder.join("rgb.png")).unwrap();
    image::GrayImage::from_fn(1, 1, |_, _| image::Luma([51])).save(folder.join("grey.png")).unwrap();
    let read = |black: &str| {
        let text = format!("[[output]]\nkind = \"domemaster\"\n{black}");
        parse(&text, "rig.toml", folder).map_err(|error| error.message)
    };
    let levels = |black: &str| read(black).unwrap().outputs[0].black.as_ref().unwrap().levels.clone();
    // The first row of a float map is the bottom row.
    assert_eq!(levels("size = [2, 2]\nblack = { image = \"black.pfm\" }").values[1], [0.25, 1.0, 0.5]);
    let close = |found: [f32; 3], expected: [f32; 3]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6);
    let colours = levels("black = { image = \"rgb.png\" }");
    assert!(
        colours.size == (2, 1)
            && close(colours.values[0], [0.2, 0.0, 0.0])
            && close(colours.values[1], [0.2, 0.0, 1.0])
    );
    assert!(close(levels("black = { image = \"grey.png\" }").values[0], [0.2; 3]));
    let values = |word: &str| {
        let rig = read(&format!("black = {{ image = \"grey.png\", values = \"{word}\" }}"))?;
        Ok::<_, String>(rig.outputs[0].black.as_ref().unwrap().values)
    };
    assert_eq!(values("displayed"), Ok(cupola::rig::BlackValues::Displayed));
    assert_eq!(values("light"), Ok(cupola::rig::BlackValues::Light));
    let cases = [
        ("black = { image = \"none.png\" }", 3, "black.image", "none.png"),
        ("black = { image = \"no-black.png\" }", 3, "black.image", "no PNG picture"),
        ("black = { image = \"cut.png\" }", 3, "black.image", "no PNG picture"),
        (
            "black = { image = \"nan.pfm\" }",
            3,
            "black.image",
            "(0.25, NaN, 0.5) at column 1, row 0; expected values from 0 to 1",
        ),
        ("black = { image = \"negative.pfm\" }", 3, "black.image", "(0.25, -0.125, 0.5) at column 1, row 0"),
        ("black = { image = \"bright.pfm\" }", 3, "black.image", "(0.25, 1.5, 0.5) at column 1, row 0"),
        (
            "size = [2, 3]\nblack = { image = \"black.pfm\" }",
            4,
            "black.image",
            "2 × 2 pixels; expected those of the output, 2 × 3",
        ),
        ("blend = { black_level = 0.1 }\nblack = { image = \"black.pfm\" }", 4, "black.image", "blend.black_level"),
        ("black = { image = \"black.pfm\", values = \"lihgt\" }", 3, "black.values", "did you mean \"light\"?"),
        ("black = { image = \"\" }", 3, "black.image", "the name is empty"),
        ("black = {}", 3, "black.image", "is missing"),
        ("black = { file = \"a.png\", image = \"grey.png\" }", 3, "black.file", "unknown key"),
        ("black = \"grey.png\"", 3, "black", "not a table"),
    ];
    for (black, line, key, words) in cases {
        let message = read(black).unwrap_err();
        assert!(
            message.starts_with(&format!("rig.toml:{line}: output[0].{key} (output-1): ")) && message.contains(words),
            "{message}"
        );
    }
}

#[test]
fn flips() {
    let with = |flip: &str| {
        parse(&format!("[[output]]\nkind = \"domemaster\"\n{flip}"), "rig.toml", Path::new(""))
            .map(|rig| rig.outputs[0].flip)
            .map_err(|error| error.message)
    };
    let flip = |horizontal, vertical| Ok(cupola::rig::Flip { horizontal, vertical });
    assert_eq!(with(""), flip(false, false));
    assert_eq!(with("flip = \"none\""), flip(false, false));
    assert_eq!(with("flip = \"horizontal\""), flip(true, false));
    assert_eq!(with("flip = \"vertical\""), flip(false, true));
    assert_eq!(with("flip = \"both\""), flip(true, true));
    for (flip, words) in [("flip = \"horizontl\"", "did you mean \"horizontal\"?"), ("flip = true", "\"both\"")] {
        let message = with(flip).unwrap_err();
        assert!(message.contains(":3: output[0].flip (output-1): ") && message.contains(words), "{message}");
    }
}

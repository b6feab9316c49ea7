//! Rigs without a file.

/// A rig that is part of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Name for [`load`](super::load).
    pub name: &'static str,
    /// Description in one line.
    pub summary: &'static str,
    /// TOML text of the rig, to read and to adapt.
    pub text: &'static str,
}

const PRESETS: [Preset; 7] = [
    Preset {
        name: "fisheye",
        summary: "180° fisheye picture, its centre straight ahead (the default)",
        text: include_str!("presets/fisheye.toml"),
    },
    Preset {
        name: "fisheye-210",
        summary: "210° domemaster of a planetarium: zenith in the centre, front at the bottom",
        text: include_str!("presets/fisheye-210.toml"),
    },
    Preset {
        name: "planetarium-6",
        summary: "six overlapping projectors in a tilted dome, blended",
        text: include_str!("presets/planetarium-6.toml"),
    },
    Preset {
        name: "planetarium-2",
        summary: "two overlapping projectors at the rim of a level dome, blended",
        text: include_str!("presets/planetarium-2.toml"),
    },
    Preset {
        name: "idome",
        summary: "a dome before the viewer, lit by one projector by way of a spherical mirror",
        text: include_str!("presets/idome.toml"),
    },
    Preset {
        name: "identity",
        summary: "nothing is corrected: the program's own picture, byte for byte",
        text: include_str!("presets/identity.toml"),
    },
    Preset {
        name: "identity-captured",
        summary: "the program's own picture by way of Cupola's framebuffer and correction, for tests",
        text: include_str!("presets/identity-captured.toml"),
    },
];

/// All presets; the default is the first.
pub fn presets() -> &'static [Preset] {
    &PRESETS
}

/// The preset called `name`.
pub(super) fn find(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

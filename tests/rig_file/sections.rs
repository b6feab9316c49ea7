//! The tables of `docs/rig-file.md`.

/// Names of the tables of `docs/rig-file.md`, each with rigs in which `@` marks the place of a key.
/// A table has the keys of all its rigs.
pub const SECTIONS: [(&str, &[&str]); 28] = [
    ("file", &["@\n[[output]]\nkind = \"domemaster\""]),
    ("dome", &["[dome]\n@"]),
    (
        "screen",
        &[
            "[screen]\nshape = \"sphere\"\n@",
            "[screen]\nshape = \"ellipsoid\"\n@",
            "[screen]\nshape = \"cylinder\"\n@",
            "[screen]\nshape = \"cone\"\n@",
            "[screen]\nshape = \"plane\"\n@",
            "[screen]\nshape = \"mesh\"\n@",
        ],
    ),
    ("viewer", &["[viewer]\n@"]),
    ("camera", &["[camera]\n@"]),
    ("content", &["[content]\nkind = \"cubemap\"\n@\n[[output]]\nkind = \"cubemap\""]),
    ("content domemaster", &["[content]\nkind = \"domemaster\"\n@\n[[output]]\nkind = \"cubemap\""]),
    (
        "content others",
        &[
            "[content]\nkind = \"equirectangular\"\n@\n[[output]]\nkind = \"cubemap\"",
            "[content]\nkind = \"cylindrical\"\n@\n[[output]]\nkind = \"cubemap\"",
            "[content]\nkind = \"flat\"\n@\n[[output]]\nkind = \"cubemap\"",
        ],
    ),
    ("views", &["[views]\n@"]),
    ("overlay", &["[overlay]\n@"]),
    ("window", &["[window]\n@"]),
    ("output", &["[[output]]\nkind = \"cubemap\"\n@"]),
    (
        "output method",
        &[
            "[[output]]\nkind = \"domemaster\"\nmethod = \"table\"\n@",
            "[[output]]\nkind = \"domemaster\"\nmethod = \"mesh\"\n@",
            "[[output]]\nkind = \"domemaster\"\nmethod = \"cube-mesh\"\n@",
        ],
    ),
    (
        "output method primitive",
        &[
            "[[output]]\nkind = \"domemaster\"\nmethod = \"primitive\"\n@",
            "[[output]]\nkind = \"domemaster\"\nmethod = \"primitive-tessellation\"\n@",
        ],
    ),
    ("output domemaster", &["[[output]]\nkind = \"domemaster\"\n@"]),
    (
        "output panorama",
        &[
            "[[output]]\nkind = \"equirectangular\"\n@",
            "[[output]]\nkind = \"cylindrical\"\n@",
            "[[output]]\nkind = \"cubemap\"\n@",
        ],
    ),
    ("output projector", &["[[output]]\nkind = \"projector\"\n@"]),
    ("output angles", &["[[output]]\nkind = \"projector\"\n[output.angles]\n@"]),
    ("output distortion", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.distortion]\n@"]),
    ("output fisheye", &["[[output]]\nkind = \"projector\"\n[output.fisheye]\n@"]),
    ("output mirror", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.mirror]\n@"]),
    (
        "output perspective",
        &["[[output]]\nkind = \"perspective\"\n@", "[[output]]\nkind = \"perspective\"\nlens = \"x\"\n@"],
    ),
    (
        "output mesh",
        &[
            "[[output]]\nkind = \"mesh\"\nfile = \"x\"\n@",
            "[[output]]\nkind = \"mesh\"\nfile = \"x\"\nvalues = \"picture\"\npicture = \"perspective\"\nfov = [60, 40]\n@",
        ],
    ),
    ("output blend", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.blend]\n@"]),
    ("output transfer", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.blend.transfer]\n@"]),
    (
        "output ramps",
        &[
            "[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[[output.blend.ramps]]\nangle = \"polar\"\n@",
            "[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[[output.blend.ramps]]\nangle = \"azimuth\"\n@",
        ],
    ),
    ("output mask", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.mask]\n@"]),
    ("output black", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.black]\n@"]),
];

//! Keys of outputs: kinds, methods, names, sizes, windows.

use super::*;

#[test]
fn keys_of_another_kind_of_output() {
    let expected = ["it belongs to kind = \"domemaster\""];
    let (text, number) = with("fov = [90, 60]", "fov = [90, 60]\naperture = 180");
    refused_text(&text, number + 1, "output[3].aperture (monitor): unknown key", &expected);
    let (text, number) = with("aperture = 180", "aperture = 180\nfov = [60, 40]");
    refused_text(
        &text,
        number + 1,
        "output[2].fov (master): unknown key",
        &["kind = \"projector\" or \"perspective\""],
    );
    refused_text(
        "[[outputs]]\nkind = \"domemaster\"\n[[output]]\nkind = \"domemaster\"",
        1,
        "outputs",
        &["[[output]]"],
    );
}

#[test]
fn methods_of_outputs() {
    let line = "method = \"mesh\"";
    refused(line, "method = \"mash\"", "output[2].method", &["did you mean \"mesh\"?"]);
    refused("max_error = 0.2", "max_error = 0", "output[2].max_error", &["pixels", "at least 0.005"]);
    refused("max_error = 0.2", "density = 8", "output[2].density", &["it belongs to method = \"cube-mesh\""]);
    let (text, number) = with(line, "method = \"fragment\"");
    refused_text(
        &text,
        number + 1,
        "output[2].max_error (master): unknown key",
        &["method = \"table\", \"mesh\" or \"primitive\""],
    );
    let (text, number) = with(line, "method = \"cube-mesh\"");
    refused_text(&text.replace("max_error = 0.2", "density = 7.5"), number + 1, "output[2].density", &["not whole"]);
    assert!(read(&text.replace("max_error = 0.2", "density = 7")).is_ok());
    refused(
        "lens = \"program\"",
        "lens = \"program\"\nmethod = \"table\"",
        "output[4].method",
        &["before the program draws"],
    );
    let special = "kind = \"domemaster\"\nprojection = \"equisolid\"";
    let (text, number) = with(line, "method = \"cube-mesh\"\ndensity = 7");
    let text = text.replace("max_error = 0.2\n", "").replace("kind = \"domemaster\"", special);
    refused_text(&text, number + 1, "output[2].method", &["equidistant"]);
    let blacks = "[[output]]\nkind = \"domemaster\"\n[[output]]\nkind = \"projector\"\nfov = [60, 40]\nmethod = \"mesh\"\n\
                  [output.blend]\ncontrast = 1000\n";
    refused_text(blacks, 6, "output[1].method", &["blend.contrast"]);
}

#[test]
fn windows_of_their_own() {
    let head = "[[output]]\nkind = \"domemaster\"\n[[output]]\nkind = \"domemaster\"\n";
    let own = |keys: &str| format!("{head}{keys}");
    let rig = read(&own("size = [64, 64]\ndisplay = \":0.1\"\nfullscreen = true")).expect("a rig");
    assert_eq!((rig.outputs.len(), rig.beside.len()), (1, 1));
    let window = rig.beside[0].own_window.as_ref().expect("a window");
    assert_eq!((window.display.as_deref(), window.fullscreen), (Some(":0.1"), true));
    assert!(read(&own("size = [64, 64]\nfullscreen = false")).is_ok_and(|rig| rig.outputs.len() == 2));
    refused_text(&own("monitor = \"DP-2\""), 3, "output[1].shown", &["needs a size"]);
    let keys = "size = [64, 64]\nmonitor = \"DP-2\"\n";
    refused_text(&own(&format!("{keys}fullscreen = true")), 7, "output[1].fullscreen", &["leave out one"]);
    refused_text(&own(&format!("{keys}shown = true")), 7, "output[1].shown", &["a window of its own"]);
    let only = "[[output]]\nkind = \"domemaster\"\nsize = [64, 64]\ndisplay = \":1\"";
    refused_text(only, 1, "output", &["none of them has a place in the program's window"]);
}

#[test]
fn names_of_outputs() {
    refused("name = \"right\"", "name = \"left\"", "output[1].name", &["another output", "of its own"]);
    refused("name = \"right\"", "name = \"Left\"", "output[1].name", &["another output"]);
    for name in ["", "a b", "a/b", "..", "-o", "é", &"n".repeat(65)] {
        refused(
            "name = \"right\"",
            &format!("name = {name:?}"),
            "output[1].name",
            &["cannot be used", "letters", "digits"],
        );
    }
    read(&with("name = \"right\"", &format!("name = \"{}\"", "n".repeat(64))).0).unwrap();
}

#[test]
fn sizes() {
    for (size, which) in
        [("[0, 1080]", 0), ("[1920, 0]", 1), ("[16385, 1080]", 0), ("[-1, 1080]", 0), ("[1920.5, 1080]", 0)]
    {
        let key = format!("output[0].size[{which}]");
        refused(
            "size = [1920, 1080]",
            &format!("size = {size}"),
            &key,
            &["[width, height] in pixels", "from 1 to 16384"],
        );
    }
    refused("size = [1920, 1080]", "size = [1920]", "output[0].size", &["expected 2 numbers"]);
    refused("size = [1920, 1080]", "size = \"1920x1080\"", "output[0].size", &["expected 2 numbers"]);
    read(&with("size = [1920, 1080]", "size = [16384, 16384]").0).unwrap();
}

#[test]
fn windows() {
    let line = "window = [1920, 0, 1920, 1080]";
    refused(line, "window = [1919, 0, 1920, 1080]", "output[1].window", &["overlaps the window of \"left\""]);
    refused(line, "window = [1920, 0, 0, 1080]", "output[1].window[2]", &["from 1 to 16384"]);
    refused(line, "window = [-1, 0, 1920, 1080]", "output[1].window[0]", &["from 0 to 32767"]);
    refused(line, "window = [32000, 0, 1920, 1080]", "output[1].window", &["(33920, 1080)", "32767"]);
    refused(line, "window = [1920, 0, 1920]", "output[1].window", &["expected 4 numbers"]);
    let (text, number) = with(line, "");
    refused_text(&text, number - 3, "output[1].window", &["is missing", "for none"]);
}

//! Files of cached results whose content somebody changed: the first byte chooses a file, the rest takes the place of its
//! content, under a header that is right.
#![no_main]

use cupola::cache::Cache;
use cupola::correct::{build_with, cached_unsampled_areas};
use cupola::digest::Digest;
use cupola::rig::{self, Rig};
use cupola::views::Request;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Magic and key, which stay.
const KEPT: usize = 32;
/// Behind them the length and the sum of the content.
const HEADER: usize = KEPT + 8 + 16;

struct Setup {
    rig: Rig,
    request: Request,
    folder: PathBuf,
    /// Path and bytes of each file.
    files: Vec<(PathBuf, Vec<u8>)>,
}

/// Two projectors, one by a table, and everything that is computed for them.
fn setup() -> &'static Setup {
    static SETUP: OnceLock<Setup> = OnceLock::new();
    SETUP.get_or_init(|| {
        let text = "
            [[output]]
            kind = \"projector\"
            position = [0.0, 0.0, 1.0]
            pitch = 20.0
            fov = [60.0, 40.0]
            method = \"table\"
            [[output]]
            kind = \"projector\"
            yaw = 40.0
            fov = [60.0, 40.0]
        ";
        let rig = rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        let request = Request {
            output_sizes: vec![(24, 16); 2],
            window: (48, 16),
            panel: false,
            primary: false,
            max_atlas: 2048,
        };
        let shared = Path::new("/dev/shm");
        let root = if shared.is_dir() { shared.to_owned() } else { std::env::temp_dir() };
        let folder = root.join(format!("cupola-fuzz-{}", std::process::id()));
        let mut setup = Setup { rig, request, folder, files: Vec::new() };
        use_cache(&setup);
        let mut files: Vec<PathBuf> =
            std::fs::read_dir(&setup.folder).expect("a folder").map(|entry| entry.expect("a file").path()).collect();
        files.sort();
        setup.files = files.into_iter().map(|path| (path.clone(), std::fs::read(path).expect("a file"))).collect();
        assert!(setup.files.len() >= 3, "views, blocks, tables: {:?}", setup.files.len());
        // Seeds: the contents as they are.
        if let Some(folder) = std::env::var_os("FUZZ_SEEDS") {
            for (index, (_, bytes)) in setup.files.iter().enumerate() {
                let seed = [&[index as u8], &bytes[HEADER..]].concat();
                std::fs::write(Path::new(&folder).join(format!("{index}")), seed).expect("written");
            }
        }
        setup
    })
}

fn use_cache(setup: &Setup) {
    let cache = Cache::in_folder(setup.folder.clone(), b"build");
    if let Ok(plan) = build_with(&setup.rig, &setup.request, &cache) {
        let _ = cached_unsampled_areas(&plan, &cache);
    }
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let setup = setup();
    let Some((index, content)) = bytes.split_first() else { return };
    let (path, whole) = &setup.files[usize::from(*index) % setup.files.len()];
    let length = (content.len() as u64).to_le_bytes();
    let sum = Digest::of(content).value().to_le_bytes();
    std::fs::write(path, [&whole[..KEPT], &length, &sum, content].concat()).expect("written");
    use_cache(setup);
    // Results that follow from the changed one have other keys.
    for entry in std::fs::read_dir(&setup.folder).expect("a folder").flatten() {
        if !setup.files.iter().any(|(known, _)| *known == entry.path()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
    std::fs::write(path, whole).expect("written");
});

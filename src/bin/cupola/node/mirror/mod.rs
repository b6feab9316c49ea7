//! `cupola node --mirror`: node 0 runs the program and draws the outputs of all nodes. The others
//! run no program, and show the pictures of node 0.
//!
//! ```text
//! program ─► ring of node 0 ─► Source: one thread for each mirror ═► Mirror ─► ring ─► cupola window
//! ```
//!
//! Each thread of the source sends the newest frame, and reads the next one when the mirror has
//! received it. A slow mirror therefore loses frames, and neither the program nor another mirror
//! waits.

mod screen;
mod source;

use super::Arguments;
use super::pictures::{Head, PictureLink, SILENCE};
use super::sidecar::{self, say};
use crate::display;
use crate::failure::Failure;
use crate::launch::loader::Scratch;
use crate::run;
use crate::window::opening::Windows;
use cupola::rig::{Place, Rig};
use cupola::ring::{self, Picture};
use cupola::system::{self, process};
use screen::{End, Screen};
use source::Source;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Interval at which the command checks for signals.
const LOOK: Duration = Duration::from_millis(20);
/// Longest wait for the thread that receives pictures after the connection was closed.
const LAST: Duration = Duration::from_secs(1);

/// Runs a node: the program on node 0, else a mirror.
pub fn show(
    arguments: Arguments,
    place: &Place,
    connect: impl FnOnce() -> Result<Box<dyn PictureLink>, Failure>,
) -> Result<ExitCode, Failure> {
    let whole = arguments.options.rig()?;
    let rig = whole.clone().on_node(place)?;
    sidecar::announce(place, &rig);
    match place.number {
        0 => draw(arguments, place, whole.with_mirrors(place)?, connect),
        _ => mirror(&arguments, place, &rig, connect),
    }
}

/// Runs the program, and sends its pictures to the mirrors.
fn draw(
    arguments: Arguments,
    place: &Place,
    rig: Rig,
    connect: impl FnOnce() -> Result<Box<dyn PictureLink>, Failure>,
) -> Result<ExitCode, Failure> {
    let Arguments { mut options, summary, program, .. } = arguments;
    options.mirrored = Some(format!("{}/{}", place.number, place.count));
    if options.headless {
        options.size = options.size.or(rig.extent());
    }
    let Some(path) = options.published(&rig)? else {
        return Err(Failure::usage("CUPOLA_PUBLISH=0 is set, and the mirrors show published pictures"));
    };
    let source = Source::start(Path::new(&path), place.count as usize, Arc::from(connect()?));
    let code = run::start(options, &program, None);
    sidecar::write_summary(summary.as_deref(), &source.finish());
    code
}

/// Shows the outputs of this node.
fn mirror(
    arguments: &Arguments,
    place: &Place,
    rig: &Rig,
    connect: impl FnOnce() -> Result<Box<dyn PictureLink>, Failure>,
) -> Result<ExitCode, Failure> {
    let options = &arguments.options;
    let own = || rig.outputs.iter().chain(&rig.beside).filter(|output| output.here);
    let names = own().map(|output| &*output.name).collect::<Vec<_>>().join("\n");
    let path = ring_path(options.publish.as_deref(), place);
    let scratch = Scratch::new()?;
    let size = rig.extent().unwrap_or((1920, 1200));
    let server = options.headless.then(|| display::Server::start(size, scratch.path())).transpose()?;
    let display = server.as_ref().map_or_else(Vec::new, display::Server::environment);
    // The windows close and captures are written before this process ends.
    process::note_end_signals();
    let link: Arc<dyn PictureLink> = Arc::from(connect()?);
    let windows = Windows::open_all(rig, &path, &display);
    say(&format!("node {}: its pictures are published in {}", place.number, path.display()));
    link.send(0, &Head::Outputs { bytes: names.len() }, names.as_bytes());
    let shown = shown(&link, &path);
    windows.close();
    ring::remove_if_ended(&path);
    let (end, pictures) = shown?;
    for picture in &pictures {
        options.capture.as_ref().map_or(Ok(()), |file| capture(file, picture))?;
    }
    link.close(end == End::Told);
    if end == End::Lost && !process::end_was_asked_for() {
        return Err(Failure::new(format!("node {}: node 0 cannot be reached any more", place.number)));
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows pictures until node 0 or this process ends. Returns those of the newest frame.
fn shown(link: &Arc<dyn PictureLink>, path: &Path) -> Result<(End, Vec<Picture>), Failure> {
    let heard = Arc::new(AtomicU64::new(system::monotonic()));
    let screen = Screen::new(Arc::clone(link), path.to_owned(), Arc::clone(&heard));
    let thread = std::thread::spawn(|| screen.show());
    let mut closed = None;
    while !thread.is_finished() {
        if process::end_was_asked_for() {
            link.close(false);
            closed = closed.or(Some(Instant::now()));
        }
        // The thread may wait for the rest of a picture, and MPI does not report that node 0 has ended.
        let silence = Duration::from_nanos(system::monotonic().saturating_sub(heard.load(Ordering::SeqCst)));
        if silence > SILENCE + LAST || closed.is_some_and(|closed| closed.elapsed() > LAST) {
            return Ok((End::Lost, Vec::new()));
        }
        std::thread::sleep(LOOK);
    }
    thread.join().unwrap_or_else(|_| Err(Failure::new("the thread that receives pictures has panicked")))
}

/// File of the pictures that a mirror publishes: that of node 0 with the number of the mirror.
fn ring_path(given: Option<&Path>, place: &Place) -> PathBuf {
    let of_node_0 = given.filter(|file| !file.as_os_str().is_empty()).map_or_else(ring::default_path, Path::to_owned);
    let mut path = of_node_0.into_os_string();
    path.push(format!("-mirror-{}", place.number));
    path.into()
}

/// Writes the picture of an output as a PNG file, FILE-NAME.png.
fn capture(file: &Path, picture: &Picture) -> Result<(), Failure> {
    let (width, height) = picture.size;
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let path = file.with_file_name(format!("{stem}-{}.png", picture.name));
    let rgba = image::RgbaImage::from_raw(width, height, picture.rgba.clone());
    let rgb = image::DynamicImage::from(rgba.unwrap_or_default()).into_rgb8();
    rgb.save_with_format(&path, image::ImageFormat::Png)
        .map_err(|error| Failure::new(format!("{}: {error}", path.display())))
}

//! `cupola stream ndi:NAME`, with a library that plays NDI's (`tests/apps/preload/ndi.c`).

use crate::harness::tests;
use crate::programs::{Run, preload, scratch};
use cupola::ring::{Frame, Next, Reader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

tests! {
    an_ndi_source_has_the_published_pictures,
    pictures_of_new_sizes_go_on_to_the_same_ndi_source,
    what_is_wrong_with_the_library_is_said_at_once,
}

/// A frame that was published: the time of its swap, and its size and pixels.
struct Published {
    time: u64,
    size: (u32, u32),
    rgba: Vec<u8>,
}

/// A picture that the library got: the line about it, and its pixels.
struct Got {
    words: Vec<String>,
    rgba: Vec<u8>,
}

impl Got {
    /// Time in units of 100 ns.
    fn time(&self) -> i64 {
        self.words[8].parse().expect("a time")
    }

    /// Place among the published frames.
    fn place(&self, published: &[Published]) -> Option<usize> {
        published.iter().position(|frame| frame.rgba == self.rgba && self.words[2] == name(frame.size))
    }
}

fn name((width, height): (u32, u32)) -> String {
    format!("{width}x{height}")
}

/// A folder with the library under the name `file`.
fn folder_with(library: &str, file: &str) -> PathBuf {
    let folder = scratch("ndi");
    std::os::unix::fs::symlink(preload(library), folder.join(file)).expect("a link can be made");
    folder
}

/// `cupola stream ndi:Dome` without the libraries that this machine may have.
fn stream() -> Command {
    let mut stream = Command::new(env!("CARGO_BIN_EXE_cupola"));
    stream.args(["stream", "ndi:Dome"]);
    stream.env_remove("LD_LIBRARY_PATH").env_remove("NDI_RUNTIME_DIR_V5").env_remove("NDI_RUNTIME_DIR_V6");
    stream
}

/// Reads all frames that a program publishes.
fn read(ring: &Path, has_ended: &AtomicBool) -> Vec<Published> {
    let (mut published, mut frame) = (Vec::new(), Frame::default());
    let mut reader = loop {
        match Reader::open(ring) {
            Ok(reader) => break reader,
            Err(_) if has_ended.load(Relaxed) => return published,
            Err(_) => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    while reader.next(Duration::from_secs(60), &mut frame).expect("frames") == Next::Frame {
        let picture = frame.pictures.remove(0);
        published.push(Published { time: frame.time, size: picture.size, rgba: picture.rgba });
    }
    published
}

/// Runs a program that waits for its readers, and streams its pictures. Returns the library's calls
/// other than those for pictures, the pictures that it got, and the published ones.
fn streamed(run: &Run<'_>, variable: &str, file: &str) -> Option<(Vec<String>, Vec<Got>, Vec<Published>)> {
    let (folder, ring) = (scratch("ndi-stream"), scratch("ndi-ring").join("ring"));
    let (calls, library) = (folder.join("calls"), folder_with("ndi", file));
    let mut stream = stream();
    stream.args(["--fps", "1000", "--published"]).arg(&ring).env("NDI_CALLS", &calls).env(variable, &library);
    let mut stream = stream.stderr(Stdio::null()).spawn().expect("cupola starts");
    let publish = format!("--publish={}", ring.display());
    let run = Run {
        cupola: &[publish.as_str()],
        cupola_frames: 0,
        environment: &[("CUPOLA_PUBLISH_WAIT", "1")],
        ..run.clone()
    };
    let has_ended = AtomicBool::new(false);
    let published = std::thread::scope(|scope| {
        let reading = scope.spawn(|| read(&ring, &has_ended));
        let finished = run.under("identity");
        has_ended.store(true, Relaxed);
        if let Some(finished) = finished {
            finished.expect_success();
        }
        reading.join().expect("a reader")
    });
    if published.is_empty() {
        stream.kill().and_then(|()| stream.wait()).expect("it ends");
        return None;
    }
    assert!(stream.wait().expect("it ends").success());
    let text = std::fs::read_to_string(&calls).expect("calls");
    let pixels = std::fs::read(folder.join("calls.pixels")).expect("pixels");
    let (frames, others) = text.lines().map(str::to_owned).partition::<Vec<_>, _>(|line| line.starts_with("frame "));
    let mut rest = &pixels[..];
    let got = frames.iter().map(|line| {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let (width, height) = words[2].split_once('x').expect("a size");
        let bytes = width.parse::<usize>().expect("a number") * height.parse::<usize>().expect("a number") * 4;
        let (rgba, later) = rest.split_at(bytes);
        rest = later;
        Got { words, rgba: rgba.to_vec() }
    });
    let got = got.collect();
    assert!(rest.is_empty(), "{} bytes too many", rest.len());
    Some((others, got, published))
}

fn an_ndi_source_has_the_published_pictures() {
    let run = Run { size: (97, 53), frames: 60, extra: &["--mode", "100"], ..Run::new("frame_index") };
    let Some((calls, got, published)) = streamed(&run, "LD_LIBRARY_PATH", "libndi.so.6") else { return };
    let (first, last) = (&calls[..2], &calls[calls.len() - 2..]);
    assert_eq!(first, ["initialize", "create Dome - 0 0"]);
    assert_eq!(last, ["send_destroy 1", "destroy"]);
    assert!(calls[2..calls.len() - 2].iter().all(|call| call == "connections 1 0"), "{calls:?}");
    // The first frames may come before the readers, and before the reader of this test alone.
    let early = got.iter().take_while(|picture| picture.place(&published).is_none()).count();
    let got = &got[early..];
    assert!(early < 20 && got.len() > 30, "{early} early ones and {} pictures", got.len());
    let places: Vec<usize> = got.iter().filter_map(|picture| picture.place(&published)).collect();
    assert_eq!(places.len(), got.len(), "the pixels are those that were published");
    assert!(places.windows(2).all(|pair| pair[1] == pair[0] + 1), "{places:?}");
    for (picture, place) in got.iter().zip(&places) {
        let format = ["frame", "1", "97x53", "RGBX", "388", "1000/1", "0", "1"];
        assert_eq!(&picture.words[..8], format);
        assert_eq!(picture.words[9], "0");
        let passed = (published[*place].time - published[places[0]].time) / 100;
        assert_eq!(picture.time() - got[0].time(), passed as i64, "times are those of the swaps");
    }
    let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("a date").as_secs() as i64;
    assert!((now - got[0].time() / 10_000_000).abs() < 600, "the time is a date");
    // Negative control: a byte is wrong.
    let mut wrong = Got { words: got[0].words.clone(), rgba: got[0].rgba.clone() };
    wrong.rgba[1000] ^= 1;
    assert_eq!(wrong.place(&published), None);
}

fn pictures_of_new_sizes_go_on_to_the_same_ndi_source() {
    let run = Run { frames: 160, ..Run::new("resize") };
    let Some((calls, got, published)) = streamed(&run, "NDI_RUNTIME_DIR_V5", "libndi.so.5") else { return };
    assert_eq!(calls.iter().filter(|call| call.starts_with("create")).count(), 1, "{calls:?}");
    let mut sizes: Vec<String> = got.iter().map(|picture| picture.words[2].clone()).collect();
    assert!(got.iter().all(|picture| picture.place(&published).is_some()), "{sizes:?}");
    sizes.dedup();
    let mut expected: Vec<String> = published.iter().map(|frame| name(frame.size)).collect();
    expected.dedup();
    assert!(sizes.len() > 1 && expected.ends_with(&sizes), "{sizes:?}, {expected:?}");
}

/// The command says it before it waits for a program.
fn what_is_wrong_with_the_library_is_said_at_once() {
    let said = |library: Option<(&str, &str)>, fails: &str, words: &[&str]| {
        let mut stream = stream();
        stream.env("NDI_FAILS", fails).args(["--published", "/nonexistent/ring"]);
        if let Some((library, file)) = library {
            stream.env("NDI_RUNTIME_DIR_V6", folder_with(library, file));
        }
        let Output { status, stderr, .. } = stream.output().expect("cupola starts");
        let text = String::from_utf8_lossy(&stderr);
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        assert_eq!(status.code(), Some(1), "{text}");
    };
    let ndi = Some(("ndi", "libndi.so.6"));
    said(ndi, "initialize", &["NDIlib_initialize", "processor"]);
    said(ndi, "create", &["\"Dome\"", "NDIlib_send_create", "another name"]);
    let incomplete = Some(("ndi_incomplete", "libndi.so.6"));
    said(incomplete, "", &["ndi-", "libndi.so.6: ", "NDIlib_send_destroy", "install NDI's SDK"]);
    // A machine that has the library cannot show what is said without it.
    let mut installed = Command::new("sh");
    installed.args(["-c", "ldconfig -p 2>/dev/null || /sbin/ldconfig -p"]);
    if installed.output().is_ok_and(|output| !String::from_utf8_lossy(&output.stdout).contains("libndi.so")) {
        let looked = ["libndi.so.6: cannot open", "libndi.so.5: cannot open", "NDI_RUNTIME_DIR_V6", "ndi.video"];
        said(None, "", &looked);
        // The folder that a variable names is searched, and said.
        said(Some(("ndi", "libndi.so.4")), "", &[&looked[..], &["ndi-"]].concat());
    }
}

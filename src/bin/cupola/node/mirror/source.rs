//! Node 0: sends the newest published frame to each mirror.

use crate::node::pictures::{ALIVE, Head, PictureLink};
use crate::node::sidecar::say;
use cupola::lock::Lock;
use cupola::ring::{Frame, Next, Picture, Reader};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Interval at which threads check for work.
const LOOK: Duration = Duration::from_millis(10);
/// Time that the mirrors have to receive the last frame.
const LAST: Duration = Duration::from_secs(5);

/// The threads that send to the mirrors.
pub struct Source {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<bool>>,
}

/// Frames that a mirror received, and frames that it lost.
#[derive(Clone, Copy, Default)]
struct Counts {
    sent: u64,
    lost: u64,
}

struct Shared {
    /// File of the published frames.
    path: PathBuf,
    link: Arc<dyn PictureLink>,
    newest: Mutex<Newest>,
    /// Counts of each node.
    counts: Vec<Mutex<Counts>>,
    /// True if the program has ended.
    has_ended: AtomicBool,
}

/// The newest frame, which all threads share.
#[derive(Default)]
struct Newest {
    reader: Option<Reader>,
    /// Number of frames that were read.
    number: u64,
    frame: Arc<Frame>,
    /// Memory for the next frame.
    spare: Frame,
}

/// Result of a look for a new frame.
enum Look {
    New(u64, Arc<Frame>),
    Nothing,
    Over,
}

impl Source {
    /// Starts a thread for each of the other nodes.
    pub fn start(path: &Path, count: usize, link: Arc<dyn PictureLink>) -> Self {
        let shared = Arc::new(Shared {
            path: path.to_owned(),
            link,
            newest: Mutex::default(),
            counts: (0..count).map(|_| Mutex::default()).collect(),
            has_ended: AtomicBool::new(false),
        });
        let thread = |to| {
            let shared = Arc::clone(&shared);
            std::thread::spawn(move || {
                let is_clean = shared.serve(to);
                if !is_clean {
                    say(&format!("node {to} has ended unexpectedly: the others go on without it"));
                }
                is_clean
            })
        };
        let threads = (1..count).map(thread).collect();
        Self { shared, threads }
    }

    /// Handles the end of the program: sends its last frame, and ends the mirrors. Prints and
    /// returns the counts.
    pub fn finish(self) -> serde_json::Value {
        self.shared.has_ended.store(true, Ordering::SeqCst);
        let begin = Instant::now();
        let is_over = || self.threads.iter().all(JoinHandle::is_finished);
        while !is_over() && begin.elapsed() < LAST {
            std::thread::sleep(LOOK);
        }
        let mut is_clean = true;
        let mut nodes = Vec::new();
        for (node, thread) in (1..).zip(self.threads) {
            let is_late = !thread.is_finished();
            is_clean &= !is_late && thread.join().unwrap_or(false);
            let Counts { sent, lost } = *self.shared.counts[node].locked();
            let late = if is_late { "; it did not receive the last one in time" } else { "" };
            say(&format!("node {node} has received {sent} frames, and lost {lost}{late}"));
            nodes.push(serde_json::json!({ "node": node, "received": sent, "lost": lost }));
        }
        self.shared.link.close(is_clean);
        serde_json::json!({ "mirrors": nodes })
    }
}

impl Shared {
    /// Sends the newest frames to a mirror until the program ends. Returns false if the connection
    /// is lost before.
    fn serve(&self, to: usize) -> bool {
        let mut names = Vec::new();
        let Some(Head::Outputs { .. }) = self.link.receive(to, &mut names) else { return false };
        let names = String::from_utf8_lossy(&names).into_owned();
        let names: Vec<&str> = names.lines().collect();
        let (mut known, mut first, mut last) = (0, None, Instant::now());
        let mut is_told = false;
        loop {
            match self.look(known) {
                Look::Over => return self.link.send(to, &Head::End, &[]),
                Look::Nothing if last.elapsed() < ALIVE => {}
                Look::Nothing => {
                    if !self.link.send(to, &Head::Alive, &[]) {
                        return false;
                    }
                    last = Instant::now();
                }
                Look::New(number, frame) => {
                    known = number;
                    let is_wanted = |picture: &&Picture| names.contains(&&*picture.name);
                    let pictures: Vec<&Picture> = frame.pictures.iter().filter(is_wanted).collect();
                    if pictures.len() < names.len() && !std::mem::replace(&mut is_told, true) {
                        let has = |name: &&&str| !pictures.iter().any(|picture| picture.name == **name);
                        let missing: Vec<&str> = names.iter().filter(has).copied().collect();
                        say(&format!(
                            "node {to} shows {}, which node 0 does not draw: do the rig files of the nodes differ?",
                            missing.join(", ")
                        ));
                    }
                    if !self.send(to, &frame, &pictures) {
                        return false;
                    }
                    last = Instant::now();
                    // Frames that the program left out of the ring are not lost.
                    let first = *first.get_or_insert(frame.number);
                    let mut counts = self.counts[to].locked();
                    counts.sent += 1;
                    counts.lost = (frame.number + 1).saturating_sub(first + counts.sent);
                }
            }
        }
    }

    /// Sends pictures of a frame.
    fn send(&self, to: usize, frame: &Frame, pictures: &[&Picture]) -> bool {
        (0..pictures.len() as u64).rev().zip(pictures).all(|(left, picture)| {
            let head = Head::Picture { frame: frame.index, left, size: picture.size, name: picture.name.clone() };
            self.link.send(to, &head, &picture.rgba)
        })
    }

    /// Looks for a frame after the one with the number `known`, for a short time.
    fn look(&self, known: u64) -> Look {
        let mut newest = self.newest.locked();
        let newest = &mut *newest;
        if newest.number > known {
            return Look::New(newest.number, Arc::clone(&newest.frame));
        }
        // Frames that were published before the end are still read.
        let has_ended = self.has_ended.load(Ordering::SeqCst);
        if newest.reader.is_none() {
            newest.reader = Reader::open_at_newest(&self.path).ok();
        }
        let next = newest.reader.as_mut().map(|reader| {
            reader.skip_to_newest();
            reader.next(LOOK, &mut newest.spare)
        });
        match next {
            Some(Ok(Next::Frame)) => {
                newest.number += 1;
                let old = std::mem::replace(&mut newest.frame, Arc::new(std::mem::take(&mut newest.spare)));
                newest.spare = Arc::try_unwrap(old).unwrap_or_default();
                Look::New(newest.number, Arc::clone(&newest.frame))
            }
            _ if has_ended => Look::Over,
            Some(Ok(Next::Nothing)) => Look::Nothing,
            // The program may open another window, or another program may follow.
            Some(Ok(Next::Ended) | Err(_)) | None => {
                newest.reader = None;
                std::thread::sleep(LOOK);
                Look::Nothing
            }
        }
    }
}

//! What runs beside the program of a node: it tells node 0 how far the program is, and lets it go.

use super::head::{Action, Head};
use super::link::{Deliver, Link, Message};
use crate::failure::Failure;
use cupola::nodes::Page;
use cupola::rig::Place;
use cupola::system::{self, process};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// So often threads look whether there is something else to do.
const LOOK: Duration = Duration::from_millis(10);
/// Time that the other programs have at least to end by themselves after that of node 0.
const LAST: Duration = Duration::from_secs(1);
/// Time that they have to end when they were asked to.
const GRACE: Duration = Duration::from_secs(10);
/// A node that waits for the end of others, and hears nothing for so long, waits no more.
const SILENCE: Duration = Duration::from_secs(60);

/// What runs beside a program.
pub struct Sidecar(Arc<Shared>);

struct Shared {
    place: Place,
    page: Page,
    path: PathBuf,
    link: OnceLock<Box<dyn Link>>,
    /// On node 0.
    head: Option<Mutex<Head>>,
    /// The head has to be asked again soon.
    changed: Condvar,
    /// The program has ended.
    has_ended: AtomicBool,
    /// A node is not reached any more.
    has_lost: AtomicBool,
    /// Node 0 has said that all is over: 1, and 2 if all nodes have said so.
    over: AtomicU64,
    /// When another node was heard last.
    heard: AtomicU64,
}

/// Tells the user. What started this command may have ended, and with it the way to the terminal.
pub fn say(words: &str) {
    let _ = std::io::stderr().write_all(format!("cupola: {words}\n").as_bytes());
}

fn locked(head: &Mutex<Head>) -> MutexGuard<'_, Head> {
    head.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Sidecar {
    /// Makes the page at `path`, and connects with the other nodes. `limit`: the longest wait;
    /// `length` of a frame; `paced`: that length, if frames are shown in real time.
    pub fn start(
        place: &Place,
        path: &Path,
        limit: Duration,
        length: Duration,
        paced: Option<Duration>,
        connect: impl FnOnce(Arc<Deliver>) -> Result<Box<dyn Link>, Failure>,
    ) -> Result<Self, Failure> {
        let page =
            Page::create(path, limit, length).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
        // The others give up after the limit: by then they have to be told.
        let head = (place.number == 0).then(|| Mutex::new(Head::new(place.count as usize, limit / 2, paced)));
        let shared = Arc::new(Shared {
            place: place.clone(),
            page,
            path: path.to_owned(),
            link: OnceLock::new(),
            head,
            changed: Condvar::new(),
            has_ended: AtomicBool::new(false),
            has_lost: AtomicBool::new(false),
            over: AtomicU64::new(0),
            heard: AtomicU64::new(system::monotonic()),
        });
        let receiver = Arc::clone(&shared);
        let link = connect(Arc::new(move |from, message| receiver.receive(from, message)));
        let link = link.inspect_err(|_| shared.remove_page())?;
        // It is set here alone.
        let _ = shared.link.set(link);
        let watcher = Arc::clone(&shared);
        std::thread::spawn(move || watcher.watch());
        if shared.head.is_some() {
            let ticker = Arc::clone(&shared);
            std::thread::spawn(move || ticker.tick());
        }
        Ok(Self(shared))
    }

    /// The program has ended; `well`: by itself and without an error. Waits for the others.
    pub fn finish(&self, well: bool, summary: Option<&Path>) {
        let shared = &*self.0;
        shared.has_ended.store(true, Ordering::SeqCst);
        let mut is_clean = !shared.has_lost.load(Ordering::SeqCst);
        match &shared.head {
            Some(head) => {
                shared.act(locked(head).gone(0, system::monotonic()));
                let begin = Instant::now();
                let is_over = |limit: Duration| locked(head).left() == 0 || begin.elapsed() > limit;
                let wait = |limit: Duration| {
                    while !is_over(limit) && shared.silence() < SILENCE {
                        std::thread::sleep(LOOK);
                    }
                };
                if well {
                    // The others may end with the same frame by themselves.
                    let by_themselves = shared.page.limit().max(LAST);
                    wait(by_themselves);
                    shared.send_all(&Message::End);
                    wait(by_themselves + GRACE);
                } else {
                    wait(Duration::MAX);
                }
                is_clean &= locked(head).left() == 0 && !shared.has_lost.load(Ordering::SeqCst);
                shared.send_all(&Message::Over { is_clean });
                shared.report(&locked(head), summary);
            }
            None => {
                shared.send(0, &Message::Gone);
                while shared.over.load(Ordering::SeqCst) == 0
                    && !shared.has_lost.load(Ordering::SeqCst)
                    && shared.silence() < SILENCE
                {
                    std::thread::sleep(LOOK);
                }
                is_clean &= shared.over.load(Ordering::SeqCst) == 2;
            }
        }
        if let Some(link) = shared.link.get() {
            link.close(is_clean);
        }
        shared.remove_page();
    }
}

impl Shared {
    fn remove_page(&self) {
        // It may be gone meanwhile.
        let _ = std::fs::remove_file(&self.path);
    }

    fn send(&self, to: usize, message: &Message) {
        if let Some(link) = self.link.get() {
            link.send(to, message);
        }
    }

    fn send_all(&self, message: &Message) {
        (1..self.place.count as usize).for_each(|to| self.send(to, message));
    }

    /// Time since another node was heard.
    fn silence(&self) -> Duration {
        Duration::from_nanos(system::monotonic().saturating_sub(self.heard.load(Ordering::SeqCst)))
    }

    /// Does what the head has decided. To be called while it is locked, so that releases go out in
    /// their order.
    fn act(&self, actions: Vec<Action>) {
        for action in actions {
            match action {
                Action::Release { frame, time } => {
                    self.send_all(&Message::Release { frame, time });
                    self.page.release(frame, time);
                }
                Action::Say(words) => words.lines().for_each(say),
            }
        }
    }

    /// Takes a message of another node.
    fn receive(&self, from: usize, message: Option<Message>) {
        let now = system::monotonic();
        self.heard.store(now, Ordering::SeqCst);
        if message.is_none() && self.over.load(Ordering::SeqCst) == 0 {
            self.has_lost.store(true, Ordering::SeqCst);
        }
        match (message, &self.head) {
            (Some(Message::Arrived(arrival)), Some(head)) => {
                let mut head = locked(head);
                self.act(head.arrived(from, arrival, now));
                self.look_at(&head, now);
            }
            (Some(Message::Gone), Some(head)) => {
                let mut head = locked(head);
                self.act(head.gone(from, now));
            }
            (None, Some(head)) => {
                let mut head = locked(head);
                if head.is_there(from) {
                    say(&format!("node {from} has ended without a word: the others go on without it"));
                }
                self.act(head.gone(from, now));
            }
            (None, None) if self.over.load(Ordering::SeqCst) == 0 => {
                say(&format!("node {}: node 0 is not reached any more", self.place.number));
                self.page.leave();
            }
            (Some(Message::Release { frame, time }), None) => self.page.release(frame, time),
            (Some(Message::End), None) => process::stop_foreground(),
            (Some(Message::Over { is_clean }), None) => {
                self.over.store(1 + u64::from(is_clean), Ordering::SeqCst);
            }
            _ => {}
        }
    }

    /// Wakes the thread that releases frames in time, if it has to look sooner than it would.
    fn look_at(&self, head: &Head, now: u64) {
        if head.due().is_some_and(|due| due < now + LOOK.as_nanos() as u64) {
            self.changed.notify_one();
        }
    }

    /// Watches how far the program is.
    fn watch(&self) {
        let mut known = 0;
        while !self.has_ended.load(Ordering::SeqCst) {
            let Some(arrival) = self.page.arrival(known, LOOK) else { continue };
            known = arrival.frame;
            match &self.head {
                Some(head) => {
                    let now = system::monotonic();
                    let mut head = locked(head);
                    self.act(head.arrived(0, arrival, now));
                    self.look_at(&head, now);
                }
                None => self.send(0, &Message::Arrived(arrival)),
            }
        }
    }

    /// Lets the head decide what time decides.
    fn tick(&self) {
        let Some(mutex) = &self.head else { return };
        let mut head = locked(mutex);
        while head.left() > 0 {
            let now = system::monotonic();
            self.act(head.tick(now));
            let left = head.due().map_or(LOOK, |due| Duration::from_nanos(due.saturating_sub(now)));
            let wait = left.clamp(Duration::from_micros(50), LOOK);
            head = self.changed.wait_timeout(head, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Says and writes what was seen.
    fn report(&self, head: &Head, file: Option<&Path>) {
        let is_one_machine = self.link.get().is_some_and(|link| link.is_one_machine());
        say(&head.summary(is_one_machine));
        let Some(file) = file else { return };
        let text = serde_json::to_string_pretty(&head.json(is_one_machine)).unwrap_or_default();
        if let Err(error) = std::fs::write(file, text) {
            say(&format!("{}: {error}", file.display()));
        }
    }
}

//! The part beside the program of a node: it reports the program's progress to node 0, and releases
//! its frames.

use super::agreed::Agreed;
use super::door::Door;
use super::head::{Action, Head};
use super::input;
use super::link::{Deliver, Link, Message};
use crate::failure::Failure;
use cupola::lock::Lock;
use cupola::nodes::Page;
use cupola::rig::{Place, Rig};
use cupola::system::{self, process};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Interval at which threads check for work.
const LOOK: Duration = Duration::from_millis(10);
/// Shortest time that the other programs have to end by themselves after that of node 0.
const LAST: Duration = Duration::from_secs(1);
/// Time that they have to end after they were asked to.
const GRACE: Duration = Duration::from_secs(10);
/// Time without a message after which a node no longer waits for the end of others.
const SILENCE: Duration = Duration::from_secs(60);

/// State beside a program.
pub struct Sidecar(Arc<Shared>);

struct Shared {
    place: Place,
    door: Arc<Door>,
    path: PathBuf,
    link: OnceLock<Box<dyn Link>>,
    /// Decisions of node 0; only on node 0.
    head: Option<Mutex<Head>>,
    /// Signalled if `tick` has to run earlier than planned.
    changed: Condvar,
    /// True if the program has ended.
    has_ended: AtomicBool,
    /// True if the connection to a node is lost.
    has_lost: AtomicBool,
    /// Message of node 0 that all nodes have ended: 1, and 2 if each of them has said so.
    over: AtomicU64,
    /// Time of the last message of another node.
    heard: AtomicU64,
    /// Settings of node 0.
    settings: OnceLock<Agreed>,
}

/// Prints a message for the user. The terminal may be gone, if the process that started this
/// command has ended.
pub fn say(words: &str) {
    let _ = std::io::stderr().write_all(format!("cupola: {words}\n").as_bytes());
}

/// Prints the outputs that this node shows.
pub fn announce(place: &Place, rig: &Rig) {
    let outputs = rig.outputs.iter().chain(&rig.beside).filter(|output| output.here);
    let outputs: Vec<&str> = outputs.map(|output| &*output.name).collect();
    let shows = if outputs.is_empty() { "no output".to_owned() } else { outputs.join(", ") };
    say(&format!("node {} of {} ({}) shows {shows}", place.number, place.count, place.host));
}

/// Writes the observations of node 0 to a file.
pub fn write_summary(file: Option<&Path>, summary: &serde_json::Value) {
    let Some(file) = file else { return };
    let text = serde_json::to_string_pretty(summary).unwrap_or_default();
    if let Err(error) = std::fs::write(file, text) {
        say(&format!("{}: {error}", file.display()));
    }
}

impl Sidecar {
    /// Creates the page at `path`, and connects with the other nodes. `limit`: longest wait;
    /// `length`: length of a frame; `paced`: that length, if frames are shown in real time.
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
        // The other programs go on by themselves after the limit: they have to get an answer
        // before.
        let head = (place.number == 0).then(|| Mutex::new(Head::new(place.count as usize, limit / 2, paced)));
        let shared = Arc::new(Shared {
            place: place.clone(),
            door: Door::new(page, place.number, say),
            path: path.to_owned(),
            link: OnceLock::new(),
            head,
            changed: Condvar::new(),
            has_ended: AtomicBool::new(false),
            has_lost: AtomicBool::new(false),
            over: AtomicU64::new(0),
            heard: AtomicU64::new(system::monotonic()),
            settings: OnceLock::new(),
        });
        let receiver = Arc::clone(&shared);
        let link = connect(Arc::new(move |from, message| receiver.receive(from, message)));
        let link = link.inspect_err(|_| shared.remove_page())?;
        // Only this thread sets the link.
        let _ = shared.link.set(link);
        let watcher = Arc::clone(&shared);
        std::thread::spawn(move || watcher.watch());
        if shared.head.is_some() {
            let ticker = Arc::clone(&shared);
            std::thread::spawn(move || ticker.tick());
        }
        Ok(Self(shared))
    }

    /// Returns the settings of node 0, which it sends to the others. They wait for them, before they start their
    /// programs. `own`: those of this node.
    pub fn agree(&self, own: Agreed) -> Result<Agreed, Failure> {
        let shared = &*self.0;
        if shared.head.is_some() {
            shared.send_all(&[Message::Settings(own)]);
            return Ok(own);
        }
        loop {
            // The message may have come before the connection was lost.
            let is_lost = shared.has_lost.load(Ordering::SeqCst) || shared.silence() > SILENCE;
            if let Some(settings) = shared.settings.get() {
                return Ok(*settings);
            }
            if is_lost {
                shared.remove_page();
                return Err(Failure::new(format!("node {}: node 0 does not send its settings", shared.place.number)));
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Sets the length of a frame of the program, before it is started.
    pub fn set_length(&self, length: Duration) {
        self.0.door.set_length(length);
    }

    /// Gives the programs of all nodes the input that comes from `source`, which node 0 has.
    pub fn take_input(&self, source: Option<Box<dyn Read + Send>>) {
        self.0.door.expect_events();
        let shared = Arc::clone(&self.0);
        if let (Some(source), true) = (source, shared.head.is_some()) {
            std::thread::spawn(move || {
                let add = |line| {
                    if let Some(head) = &shared.head {
                        while head.locked().is_input_full() {
                            std::thread::sleep(LOOK);
                        }
                        head.locked().add_input(line);
                    }
                };
                input::read(source, add, say);
            });
        }
    }

    /// Handles the end of the program and waits for the others. `well`: it ended by itself and
    /// without an error.
    pub fn finish(&self, well: bool, summary: Option<&Path>) {
        let shared = &*self.0;
        shared.has_ended.store(true, Ordering::SeqCst);
        shared.door.close();
        let mut is_clean = !shared.has_lost.load(Ordering::SeqCst);
        match &shared.head {
            Some(head) => {
                if !well {
                    say_failed(0);
                }
                shared.act(head.locked().gone(0, system::monotonic()));
                let begin = Instant::now();
                let is_over = |limit: Duration| head.locked().left() == 0 || begin.elapsed() > limit;
                let wait = |limit: Duration| {
                    while !is_over(limit) && shared.silence() < SILENCE {
                        std::thread::sleep(LOOK);
                    }
                };
                if well {
                    // The others may end by themselves with the same frame.
                    let by_themselves = shared.door.limit().max(LAST);
                    wait(by_themselves);
                    shared.send_all(&[Message::End]);
                    wait(by_themselves + GRACE);
                } else {
                    wait(Duration::MAX);
                }
                is_clean &= head.locked().left() == 0 && !shared.has_lost.load(Ordering::SeqCst);
                shared.send_all(&[Message::Over { is_clean }]);
                shared.report(&head.locked(), summary);
            }
            None => {
                shared.send(0, &[Message::Gone { well }]);
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

/// Says that a node's program has failed, unless the user ends all of them.
fn say_failed(node: usize) {
    if !process::end_was_asked_for() {
        say(&format!("the program of node {node} has ended with an error: the others go on without it"));
    }
}

impl Shared {
    fn remove_page(&self) {
        // The file may be gone already.
        let _ = std::fs::remove_file(&self.path);
    }

    fn send(&self, to: usize, messages: &[Message]) {
        if let Some(link) = self.link.get() {
            link.send(to, messages);
        }
    }

    fn send_all(&self, messages: &[Message]) {
        (1..self.place.count as usize).for_each(|to| self.send(to, messages));
    }

    /// Time since the last message of another node.
    fn silence(&self) -> Duration {
        Duration::from_nanos(system::monotonic().saturating_sub(self.heard.load(Ordering::SeqCst)))
    }

    /// Executes the actions of the head. The caller holds the head's lock, so that releases are
    /// sent in their order.
    fn act(&self, actions: Vec<Action>) {
        let messages: Vec<Message> = actions.iter().filter_map(Action::message).collect();
        if !messages.is_empty() {
            self.send_all(&messages);
        }
        for action in actions {
            match action {
                Action::Input { frame, event } => self.door.add(frame, event),
                Action::Release { frame, time } => self.door.open(frame, time),
                Action::Say(words) => words.lines().for_each(say),
            }
        }
    }

    /// Handles a message of another node.
    fn receive(&self, from: usize, message: Option<Message>) {
        let now = system::monotonic();
        self.heard.store(now, Ordering::SeqCst);
        if message.is_none() && self.over.load(Ordering::SeqCst) == 0 {
            self.has_lost.store(true, Ordering::SeqCst);
        }
        match (message, &self.head) {
            (Some(Message::Arrived(arrival)), Some(head)) => {
                let mut head = head.locked();
                self.act(head.arrived(from, arrival, now));
                self.look_at(&head, now);
            }
            (Some(Message::Gone { well }), Some(head)) => {
                if !well && !self.has_ended.load(Ordering::SeqCst) {
                    say_failed(from);
                }
                let mut head = head.locked();
                self.act(head.gone(from, now));
            }
            (None, Some(head)) => {
                let mut head = head.locked();
                if head.is_there(from) {
                    say(&format!("node {from} has ended unexpectedly: the others go on without it"));
                }
                self.act(head.gone(from, now));
            }
            (None, None) if self.over.load(Ordering::SeqCst) == 0 => {
                say(&format!("node {}: node 0 cannot be reached any more", self.place.number));
                self.door.leave();
            }
            (Some(Message::Input { frame, event }), None) => self.door.add(frame, event),
            (Some(Message::Release { frame, time }), None) => self.door.open(frame, time),
            // They come once.
            (Some(Message::Settings(settings)), None) => drop(self.settings.set(settings)),
            (Some(Message::End), None) => process::stop_foreground(),
            (Some(Message::Over { is_clean }), None) => {
                self.over.store(1 + u64::from(is_clean), Ordering::SeqCst);
            }
            _ => {}
        }
    }

    /// Wakes the thread that releases frames in time, if it has work earlier than it expects.
    fn look_at(&self, head: &Head, now: u64) {
        if head.due().is_some_and(|due| due < now + LOOK.as_nanos() as u64) {
            self.changed.notify_one();
        }
    }

    /// Watches the program's progress.
    fn watch(&self) {
        let mut known = 0;
        while !self.has_ended.load(Ordering::SeqCst) {
            let Some(arrival) = self.door.arrival(known, LOOK) else { continue };
            known = arrival.frame;
            match &self.head {
                Some(head) => {
                    let now = system::monotonic();
                    let mut head = head.locked();
                    self.act(head.arrived(0, arrival, now));
                    self.look_at(&head, now);
                }
                None => self.send(0, &[Message::Arrived(arrival)]),
            }
        }
    }

    /// Executes the decisions of the head that depend on time.
    fn tick(&self) {
        let Some(mutex) = &self.head else { return };
        let mut head = mutex.locked();
        while head.left() > 0 {
            let now = system::monotonic();
            self.act(head.tick(now));
            let left = head.due().map_or(LOOK, |due| Duration::from_nanos(due.saturating_sub(now)));
            let wait = left.clamp(Duration::from_micros(50), LOOK);
            head = self.changed.wait_timeout(head, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Prints and writes the summary.
    fn report(&self, head: &Head, file: Option<&Path>) {
        let is_one_machine = self.link.get().is_some_and(|link| link.is_one_machine());
        say(&head.summary(is_one_machine));
        write_summary(file, &head.json(is_one_machine));
    }
}

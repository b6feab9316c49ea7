//! Nodes on any number of machines, started by `mpirun`.
//!
//! Calls of MPI have no time-out and may wait for a node that is stopped. So each destination has a
//! thread that waits only for it, and incoming messages are polled.

use super::link::{Deliver, Link, Message, WORDS};
use super::pictures::{self, Head, PictureLink, SILENCE};
use super::sidecar::say;
use crate::failure::Failure;
use cupola::rig::Place;
use cupola::system::process;
use mpi::Threading;
use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, Equivalence, Source};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Interval of polling for messages.
const LOOK: Duration = Duration::from_micros(50);

/// Longest time for the last messages if a node is lost, which does not receive them.
const LAST: Duration = Duration::from_millis(500);

/// Processes that `mpirun` has started.
pub struct Job {
    universe: Universe,
    /// This node among them.
    pub place: Place,
    is_one_machine: bool,
}

/// True if `mpirun` has started this process.
pub fn is_there() -> bool {
    ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"].iter().any(|name| std::env::var_os(name).is_some())
}

impl Job {
    /// Joins the other nodes.
    pub fn join() -> Result<Self, Failure> {
        let (universe, threading) =
            mpi::initialize_with_threading(Threading::Multiple).ok_or_else(|| Failure::new("MPI is in use already"))?;
        if threading != Threading::Multiple {
            return Err(Failure::new("this MPI does not serve several threads (MPI_THREAD_MULTIPLE)"));
        }
        let world = universe.world();
        let number = |number: i32| u32::try_from(number).unwrap_or(0);
        let place =
            Place { number: number(world.rank()), count: number(world.size()), host: cupola::system::host_name() };
        let own = u64::try_from(cupola::digest::Digest::of(place.host.as_bytes()).value() >> 64).unwrap_or(0);
        let mut hosts = vec![0; place.count as usize];
        world.all_gather_into(&own, &mut hosts[..]);
        let is_one_machine = hosts.iter().all(|host| *host == own);
        Ok(Self { universe, place, is_one_machine })
    }

    /// Connects this node with the others.
    pub fn connect(self, deliver: Arc<Deliver>) -> Box<dyn Link> {
        let is_closed = Arc::new(AtomicBool::new(false));
        let peers = if self.place.number == 0 { 1..self.place.count as i32 } else { 0..1 };
        let mut senders = vec![None];
        senders.resize_with(self.place.count as usize, || None);
        let mut threads = Vec::new();
        for peer in peers {
            let (sender, receiver) = channel::<Option<Message>>();
            threads.push(std::thread::spawn(move || {
                let world = SimpleCommunicator::world();
                while let Ok(Some(message)) = receiver.recv() {
                    world.process_at_rank(peer).send(&message.words()[..]);
                }
            }));
            senders[peer as usize] = Some(sender);
        }
        let closed = Arc::clone(&is_closed);
        let reader = std::thread::spawn(move || {
            process::sleep_precisely();
            let world = SimpleCommunicator::world();
            while !closed.load(Ordering::SeqCst) {
                let Some(status) = world.any_process().immediate_probe() else {
                    std::thread::sleep(LOOK);
                    continue;
                };
                let from = status.source_rank();
                let mut words = [0; WORDS];
                world.process_at_rank(from).receive_into(&mut words[..]);
                deliver(usize::try_from(from).unwrap_or(0), Message::of(words));
            }
        });
        let parts = Mutex::new(Some(Parts { universe: self.universe, reader, senders: threads }));
        Box::new(Messages { senders, is_one_machine: self.is_one_machine, is_closed, parts })
    }

    /// Connects node 0 with its mirrors.
    pub fn connect_pictures(self) -> Box<dyn PictureLink> {
        Box::new(Pictures { is_closed: AtomicBool::new(false), universe: Mutex::new(Some(self.universe)) })
    }
}

/// Connections for pictures.
struct Pictures {
    is_closed: AtomicBool,
    universe: Mutex<Option<Universe>>,
}

/// Sends data, and waits until the other node receives them: MPI does not report a node that has
/// ended.
fn send<Data: Equivalence>(to: i32, data: &[Data]) {
    let world = SimpleCommunicator::world();
    let begin = Instant::now();
    let mut is_told = false;
    let node = world.process_at_rank(to);
    mpi::request::scope(|scope| {
        let mut request = node.immediate_synchronous_send(scope, data);
        // MPI's own wait would occupy a processor while the other node is stopped.
        while let Err(waiting) = request.test() {
            request = waiting;
            if begin.elapsed() > SILENCE && !std::mem::replace(&mut is_told, true) {
                say(&format!("node {to} does not receive pictures any more: the others go on without it"));
            }
            std::thread::sleep(LOOK);
        }
    });
}

impl PictureLink for Pictures {
    fn send(&self, to: usize, head: &Head, bytes: &[u8]) -> bool {
        let Ok(to) = i32::try_from(to) else { return false };
        send(to, &head.words()[..]);
        if !bytes.is_empty() {
            send(to, bytes);
        }
        true
    }

    fn receive(&self, from: usize, bytes: &mut Vec<u8>) -> Option<Head> {
        let world = SimpleCommunicator::world();
        let from = world.process_at_rank(i32::try_from(from).ok()?);
        let begin = Instant::now();
        process::sleep_precisely();
        while from.immediate_probe().is_none() {
            if self.is_closed.load(Ordering::SeqCst) || begin.elapsed() > SILENCE {
                return None;
            }
            std::thread::sleep(LOOK);
        }
        let mut words = [0; pictures::WORDS];
        from.receive_into(&mut words[..]);
        let head = Head::of(words)?;
        bytes.resize(head.bytes(), 0);
        if !bytes.is_empty() {
            from.receive_into(&mut bytes[..]);
        }
        Some(head)
    }

    fn close(&self, is_clean: bool) {
        self.is_closed.store(true, Ordering::SeqCst);
        let universe = self.universe.lock().ok().and_then(|mut universe| universe.take());
        if !is_clean {
            // The end of MPI would wait for all nodes, including lost ones.
            std::mem::forget(universe);
        }
    }
}

struct Messages {
    /// To the thread of each destination; `None` in a channel ends the thread.
    senders: Vec<Option<Sender<Option<Message>>>>,
    is_one_machine: bool,
    is_closed: Arc<AtomicBool>,
    parts: Mutex<Option<Parts>>,
}

/// MPI, and the threads that use it.
struct Parts {
    universe: Universe,
    reader: JoinHandle<()>,
    senders: Vec<JoinHandle<()>>,
}

impl Link for Messages {
    fn send(&self, to: usize, messages: &[Message]) {
        if let Some(Some(sender)) = self.senders.get(to) {
            for message in messages {
                // The thread lives as long as this link.
                let _ = sender.send(Some(*message));
            }
        }
    }

    fn is_one_machine(&self) -> bool {
        self.is_one_machine
    }

    fn close(&self, is_clean: bool) {
        self.is_closed.store(true, Ordering::SeqCst);
        let parts = self.parts.lock().ok().and_then(|mut parts| parts.take());
        if let Some(Parts { universe, reader, senders }) = parts {
            let _ = reader.join();
            // The last messages may not be sent yet, and MPI has to be there for them.
            for sender in self.senders.iter().flatten() {
                // A thread that has ended needs no end.
                let _ = sender.send(None);
            }
            let begin = Instant::now();
            while !senders.iter().all(JoinHandle::is_finished) && (is_clean || begin.elapsed() < LAST) {
                std::thread::sleep(LOOK);
            }
            if is_clean {
                drop(universe);
            } else {
                // The end of MPI would wait for all nodes, including lost ones.
                std::mem::forget(universe);
            }
        }
    }
}

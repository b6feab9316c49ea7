//! Nodes on one machine, through a socket, without MPI: to try out a rig, and for tests.

use super::link::{Deliver, Link, Message, WORDS};
use super::pictures::{self, Head, PictureLink, SILENCE};
use crate::failure::Failure;
use cupola::rig::Place;
use std::io::{self, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

/// Longest wait for the other nodes at the start.
const START: Duration = Duration::from_secs(20);
/// Time after which a node that receives nothing, although its buffer is full, counts as lost.
const FULL: Duration = Duration::from_millis(5);

/// Connections to the other nodes by their number.
struct Sockets(Vec<OnceLock<Mutex<UnixStream>>>);

impl Link for Sockets {
    fn send(&self, to: usize, messages: &[Message]) {
        let Some(socket) = self.0.get(to).and_then(OnceLock::get) else { return };
        let Ok(mut socket) = socket.lock() else { return };
        let words = messages.iter().flat_map(Message::words);
        let bytes: Vec<u8> = words.flat_map(u64::to_ne_bytes).collect();
        if socket.write_all(&bytes).is_err() {
            // A message that was sent in part cannot be taken back.
            let _ = socket.shutdown(Shutdown::Both);
        }
    }

    fn is_one_machine(&self) -> bool {
        true
    }

    fn close(&self, _is_clean: bool) {
        for socket in self.0.iter().filter_map(OnceLock::get).filter_map(|socket| socket.lock().ok()) {
            let _ = socket.shutdown(Shutdown::Both);
        }
    }
}

/// Connections for pictures to the other nodes by their number.
struct PictureSockets(Vec<OnceLock<UnixStream>>);

impl PictureLink for PictureSockets {
    fn send(&self, to: usize, head: &Head, bytes: &[u8]) -> bool {
        let Some(mut socket) = self.0.get(to).and_then(OnceLock::get) else { return false };
        let words: Vec<u8> = head.words().into_iter().flat_map(u64::to_ne_bytes).collect();
        socket.write_all(&words).and_then(|()| socket.write_all(bytes)).is_ok()
    }

    fn receive(&self, from: usize, bytes: &mut Vec<u8>) -> Option<Head> {
        let mut socket = self.0.get(from)?.get()?;
        let head = Head::of(read_words::<{ pictures::WORDS }>(&mut socket).ok()?)?;
        bytes.resize(head.bytes(), 0);
        socket.read_exact(bytes).ok()?;
        Some(head)
    }

    fn close(&self, _is_clean: bool) {
        for socket in self.0.iter().filter_map(OnceLock::get) {
            // The other node may have closed it.
            let _ = socket.shutdown(Shutdown::Both);
        }
    }
}

/// Connects this node with the others through the socket `path`, which node 0 creates.
pub fn connect(place: &Place, path: &Path, deliver: Arc<Deliver>) -> Result<Box<dyn Link>, Failure> {
    let sockets = Sockets((0..place.count).map(|_| OnceLock::new()).collect());
    connected(place, path, |number, socket| add(&sockets, number, socket, &deliver))?;
    Ok(Box::new(sockets))
}

/// Connects node 0 with its mirrors through the socket `path`, which node 0 creates.
pub fn connect_pictures(place: &Place, path: &Path) -> Result<Box<dyn PictureLink>, Failure> {
    let sockets = PictureSockets((0..place.count).map(|_| OnceLock::new()).collect());
    connected(place, path, |number, socket| {
        socket.set_read_timeout(Some(SILENCE))?;
        socket.set_write_timeout(Some(SILENCE))?;
        sockets.0.get(number).ok_or_else(too_large)?.set(socket).map_err(|_| twice())
    })?;
    Ok(Box::new(sockets))
}

fn too_large() -> io::Error {
    io::Error::other("a node has a number that is too large")
}

fn twice() -> io::Error {
    io::Error::other("two nodes have the same number")
}

/// Connects this node with the others, and adds each connection with the number of its node.
fn connected(
    place: &Place,
    path: &Path,
    mut add: impl FnMut(usize, UnixStream) -> io::Result<()>,
) -> Result<(), Failure> {
    let failed = |error: io::Error| Failure::new(format!("the other nodes cannot be reached: {error}"));
    if place.number == 0 {
        let listener = UnixListener::bind(path).map_err(failed)?;
        for _ in 1..place.count {
            let mut socket = listener.accept().map_err(failed)?.0;
            socket.set_read_timeout(Some(START)).map_err(failed)?;
            let mut number = [0; 8];
            socket.read_exact(&mut number).map_err(failed)?;
            let number = usize::try_from(u64::from_ne_bytes(number)).unwrap_or(usize::MAX);
            add(number, socket).map_err(failed)?;
        }
        // All nodes are connected.
        let _ = std::fs::remove_file(path);
    } else {
        let begin = Instant::now();
        let mut socket = loop {
            match UnixStream::connect(path) {
                Ok(socket) => break socket,
                Err(error) if begin.elapsed() > START => return Err(failed(error)),
                Err(_) => std::thread::sleep(Duration::from_millis(10)),
            }
        };
        socket.write_all(&u64::from(place.number).to_ne_bytes()).map_err(failed)?;
        add(0, socket).map_err(failed)?;
    }
    Ok(())
}

/// Reads numbers that [`Message::words`] or [`Head::words`] made.
fn read_words<const COUNT: usize>(socket: &mut impl Read) -> io::Result<[u64; COUNT]> {
    let mut words = [[0; 8]; COUNT];
    socket.read_exact(words.as_flattened_mut())?;
    Ok(words.map(u64::from_ne_bytes))
}

/// Stores a connection, and reads from it on a thread.
fn add(sockets: &Sockets, number: usize, socket: UnixStream, deliver: &Arc<Deliver>) -> io::Result<()> {
    socket.set_read_timeout(None)?;
    socket.set_write_timeout(Some(FULL))?;
    let mut reader = socket.try_clone()?;
    sockets.0.get(number).ok_or_else(too_large)?.set(Mutex::new(socket)).map_err(|_| twice())?;
    let deliver = Arc::clone(deliver);
    std::thread::spawn(move || {
        while let Ok(words) = read_words::<WORDS>(&mut reader) {
            deliver(number, Message::of(words));
        }
        deliver(number, None);
    });
    Ok(())
}

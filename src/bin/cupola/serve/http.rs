//! Requests and answers of HTTP/1.1, with a limit on everything that a stranger could make large.

use super::access::{Access, HEADER};
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Greatest number of bytes of a request's head.
const LONGEST_HEAD: usize = 8 << 10;
/// Greatest number of bytes of a request's body.
const LONGEST_BODY: usize = 64 << 10;
/// Greatest number of lines of a request's head.
const MOST_HEADERS: usize = 64;
/// Greatest number of simultaneous connections.
const MOST_CONNECTIONS: usize = 64;
/// Time after which a connection is closed that sends nothing, or receives nothing.
const PATIENCE: Duration = Duration::from_secs(20);
/// Content policy of the page: it may load nothing from elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'nonce-cupola'; style-src 'unsafe-inline'; img-src 'self' data: blob:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A request that passed the checks.
#[derive(Debug, PartialEq)]
pub struct Request {
    /// True for POST, false for GET.
    pub is_post: bool,
    /// Path, without the part after `?`.
    pub path: String,
    /// Part after `?`.
    pub query: String,
    /// Body of a POST.
    pub body: Vec<u8>,
    /// True if it has the secret word.
    pub has_token: bool,
    is_last: bool,
}

impl Request {
    /// Value of `name` in `?name=value&…`.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.query
            .split('&')
            .filter_map(|pair| pair.split_once('='))
            .find(|(key, _)| *key == name)
            .map(|(_, value)| value)
    }
}

/// An answer.
#[derive(Debug)]
pub struct Answer {
    status: u16,
    kind: &'static str,
    headers: Vec<(&'static str, String)>,
    body: Vec<u8>,
}

impl Answer {
    /// Returns an answer with a body of this content type.
    pub fn new(status: u16, kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status, kind, headers: Vec::new(), body: body.into() }
    }

    /// Returns an answer with a text for people.
    pub fn words(status: u16, words: &str) -> Self {
        Self::new(status, "text/plain; charset=utf-8", words)
    }

    /// Returns an answer with JSON.
    pub fn json(status: u16, value: &serde_json::Value) -> Self {
        Self::new(status, "application/json", value.to_string())
    }

    /// Adds a header.
    pub fn with(mut self, name: &'static str, value: String) -> Self {
        self.headers.push((name, value));
        self
    }

    fn write(&self, to: &mut impl Write, is_last: bool) -> std::io::Result<()> {
        let reason = match self.status {
            200 => "OK",
            204 => "No Content",
            400 => "Bad Request",
            403 => "Forbidden",
            404 => "Not Found",
            413 => "Content Too Large",
            _ => "Error",
        };
        let mut head = format!(
            "HTTP/1.1 {} {reason}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: {}\r\nCache-Control: no-store\r\n\
             X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nContent-Security-Policy: {POLICY}\r\n",
            self.status,
            self.kind,
            self.body.len(),
            if is_last { "close" } else { "keep-alive" },
        );
        for (name, value) in &self.headers {
            head += &format!("{name}: {value}\r\n");
        }
        to.write_all(&[head.as_bytes(), b"\r\n", &self.body].concat())
    }
}

/// Answers connections with `answer`, each in a thread of its own, for as long as the process
/// lives.
pub fn serve(listener: TcpListener, access: Arc<Access>, answer: impl Fn(&Request) -> Answer + Send + Sync + 'static) {
    let (answer, open) = (Arc::new(answer), Arc::new(AtomicUsize::new(0)));
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let Ok(stream) = stream else {
                // For example, too many files are open.
                std::thread::sleep(Duration::from_millis(50));
                continue;
            };
            if open.fetch_add(1, Ordering::SeqCst) >= MOST_CONNECTIONS {
                open.fetch_sub(1, Ordering::SeqCst);
                continue;
            }
            let (access, answer, counted) = (access.clone(), answer.clone(), Counted(open.clone()));
            let spawned = std::thread::Builder::new().spawn(move || {
                let _counted = counted;
                // The client is gone.
                let _ = converse(stream, &access, &*answer);
            });
            drop(spawned);
        }
    });
}

/// Counts a connection until it is dropped.
struct Counted(Arc<AtomicUsize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn converse(mut stream: TcpStream, access: &Access, answer: &dyn Fn(&Request) -> Answer) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_nodelay(true)?;
    let mut held = Vec::new();
    loop {
        match read(&mut stream, &mut held, access)? {
            Ok(None) => return Ok(()),
            Ok(Some(request)) => {
                answer(&request).write(&mut stream, request.is_last)?;
                if request.is_last {
                    return Ok(());
                }
            }
            Err(refusal) => return refusal.write(&mut stream, true),
        }
    }
}

/// Reads the next request; `None` at the end of the connection. `held`: bytes that were already
/// read.
pub(super) fn read(
    stream: &mut impl Read,
    held: &mut Vec<u8>,
    access: &Access,
) -> std::io::Result<Result<Option<Request>, Answer>> {
    let (mut request, head, length) = loop {
        match head_of(held, access) {
            Ok(Some(found)) => break found,
            Ok(None) if held.len() > LONGEST_HEAD => return Ok(Err(Answer::words(413, "The request is too long."))),
            Ok(None) => {}
            Err(refusal) => return Ok(Err(refusal)),
        }
        if !more(stream, held)? {
            return Ok(Ok(None));
        }
    };
    while held.len() < head + length {
        if !more(stream, held)? {
            return Ok(Ok(None));
        }
    }
    request.body = held[head..head + length].to_vec();
    held.drain(..head + length);
    Ok(Ok(Some(request)))
}

/// Reads available bytes. Returns whether there were any.
fn more(stream: &mut impl Read, held: &mut Vec<u8>) -> std::io::Result<bool> {
    let mut buffer = [0; 4096];
    let count = loop {
        match stream.read(&mut buffer) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            other => break other?,
        }
    };
    held.extend_from_slice(&buffer[..count]);
    Ok(count > 0)
}

/// Parses the request, and the lengths of its head and of its body; `None` while the head is not
/// complete.
fn head_of(bytes: &[u8], access: &Access) -> Result<Option<(Request, usize, usize)>, Answer> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let head = match parsed.parse(&bytes[..bytes.len().min(LONGEST_HEAD + 1)]) {
        Ok(httparse::Status::Complete(head)) => head,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(_) => return Err(Answer::words(400, "This request is not understood.")),
    };
    let header = |name: &str| {
        let found = parsed.headers.iter().find(|header| header.name.eq_ignore_ascii_case(name))?;
        std::str::from_utf8(found.value).ok().map(str::trim)
    };
    if !access.is_own_name(header("host"), header("origin")) {
        return Err(Answer::words(403, "Open the address that cupola printed, with its number and no other name."));
    }
    let is_post = match parsed.method {
        Some("GET") => false,
        Some("POST") => true,
        _ => return Err(Answer::words(400, "Only GET and POST are understood.")),
    };
    let length = match header("content-length") {
        None => 0,
        Some(length) => length.parse().map_err(|_| Answer::words(400, "The length of the request is not a number."))?,
    };
    if header("transfer-encoding").is_some() || length > LONGEST_BODY {
        return Err(Answer::words(413, "The request is too long."));
    }
    let (path, query) =
        parsed.path.unwrap_or_default().split_once('?').unwrap_or((parsed.path.unwrap_or_default(), ""));
    let request = Request {
        is_post,
        path: path.to_owned(),
        query: query.to_owned(),
        body: Vec::new(),
        has_token: access.knows(header(HEADER)),
        is_last: parsed.version == Some(0)
            || header("connection").is_some_and(|word| word.eq_ignore_ascii_case("close")),
    };
    Ok(Some((request, head, length)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access() -> Access {
        Access::new("127.0.0.1:8640".parse().expect("an address")).expect("random numbers")
    }

    fn all(bytes: &[u8]) -> Vec<Result<Request, u16>> {
        let (access, mut stream, mut held, mut found) = (access(), bytes, Vec::new(), Vec::new());
        loop {
            match read(&mut stream, &mut held, &access).expect("a slice") {
                Ok(None) => return found,
                Ok(Some(request)) => found.push(Ok(request)),
                Err(refusal) => {
                    found.push(Err(refusal.status));
                    return found;
                }
            }
        }
    }

    #[test]
    fn requests_follow_each_other() {
        let text = b"POST /do?a=1&b=2 HTTP/1.1\r\nHost: localhost:8640\r\nContent-Length: 3\r\n\r\nabcGET / HTTP/1.1\r\nHost: localhost:8640\r\n\r\n";
        let found = all(text);
        let [Ok(first), Ok(second)] = &found[..] else { panic!("{found:?}") };
        assert!(first.is_post && first.path == "/do" && first.body == b"abc" && first.value("b") == Some("2"));
        assert!(!second.is_post && second.path == "/" && !second.has_token && first.value("c").is_none());
    }

    #[test]
    fn what_is_too_long_or_foreign_is_refused() {
        let long = format!("GET /{} HTTP/1.1\r\n", "a".repeat(2 * LONGEST_HEAD));
        let body = format!("POST / HTTP/1.1\r\nHost: localhost:8640\r\nContent-Length: {}\r\n\r\n", LONGEST_BODY + 1);
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "A: b\r\n".repeat(MOST_HEADERS + 1));
        for (text, status) in [
            (long.as_str(), 413),
            (&body, 413),
            (&many, 400),
            ("GET / HTTP/1.1\r\nHost: evil.example:8640\r\n\r\n", 403),
            ("GET / HTTP/1.1\r\nHost: localhost:8640\r\nOrigin: http://evil.example\r\n\r\n", 403),
            ("PUT / HTTP/1.1\r\nHost: localhost:8640\r\n\r\n", 400),
            ("POST / HTTP/1.1\r\nHost: localhost:8640\r\nContent-Length: -1\r\n\r\n", 400),
            ("POST / HTTP/1.1\r\nHost: localhost:8640\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 413),
        ] {
            assert_eq!(all(text.as_bytes()).pop().expect("an answer").map(|_| ()), Err(status), "{text:.60}");
        }
    }

    /// Sends random bytes, and good requests with random bytes changed.
    #[test]
    fn random_bytes_do_no_harm() {
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        let good =
            b"POST /do HTTP/1.1\r\nHost: localhost:8640\r\nContent-Length: 5\r\nX-Cupola-Token: abc\r\n\r\nhello";
        let mut understood = 0;
        for _ in 0..20_000 {
            let mut bytes = good.to_vec();
            for _ in 0..random() % 4 {
                let at = random() as usize % bytes.len();
                bytes[at] = random() as u8;
            }
            if random() % 4 == 0 {
                bytes = (0..random() % 300).map(|_| random() as u8).collect();
            }
            understood += all(&bytes).iter().filter(|found| found.is_ok()).count();
        }
        assert!((1000..19_000).contains(&understood), "{understood}");
    }
}

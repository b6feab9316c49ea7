//! Access to the server.
//!
//! The printed address contains a secret word behind `#`, so that browsers neither send nor log it
//! by themselves; the page sends it with each request in a header of its own. Other users of the
//! machine do not know it. Pages of other servers cannot set that header. Requests under a foreign
//! name of this machine (DNS rebinding) are refused before the word is checked.

use std::io::Read;
use std::net::{IpAddr, SocketAddr};

/// Header with the secret word.
pub const HEADER: &str = "x-cupola-token";

/// Number of bytes of the secret.
const BYTES: usize = 16;

/// Secret word, and the names under which the server accepts requests.
pub struct Access {
    token: String,
    port: u16,
}

impl Access {
    /// Makes a new secret word.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn new(address: SocketAddr) -> std::io::Result<Self> {
        let mut bytes = [0; BYTES];
        std::fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { token, port: address.port() })
    }

    /// Address to open in a browser, for the machine's name or number.
    pub fn url(&self, host: &str) -> String {
        format!("http://{host}:{}/#{}", self.port, self.token)
    }

    /// True if `word` is the secret one. The time of the comparison does not depend on the word.
    pub fn knows(&self, word: Option<&str>) -> bool {
        let word = word.unwrap_or_default().as_bytes();
        let own = self.token.as_bytes();
        let differing = own.iter().enumerate().fold(0, |sum, (at, byte)| sum | (byte ^ word.get(at).unwrap_or(&0)));
        std::hint::black_box(differing) == 0 && word.len() == own.len()
    }

    /// True if a request has names that only a page of this server, or a program, sends. A numeric
    /// address is accepted, because no foreign name server can direct it here.
    pub fn is_own_name(&self, host: Option<&str>, origin: Option<&str>) -> bool {
        let Some(host) = host else { return false };
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.contains(']') => (name, port),
            _ => (host, "80"),
        };
        let number = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        let is_named = name == "localhost" || number.parse::<IpAddr>().is_ok();
        let is_own_origin = origin.is_none_or(|origin| origin.strip_prefix("http://") == Some(host));
        is_named && port == self.port.to_string() && is_own_origin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access() -> Access {
        Access::new("127.0.0.1:8640".parse().expect("an address")).expect("random numbers")
    }

    #[test]
    fn only_the_word_opens() {
        let access = access();
        let word = access.url("localhost").split_once('#').expect("a word").1.to_owned();
        assert_eq!(word.len(), 2 * BYTES);
        assert!(access.knows(Some(&word)));
        let longer = format!("{word}0");
        for wrong in [None, Some(""), Some(&word[1..]), Some(&longer), Some("0123456789abcdef0123456789abcdef")] {
            assert!(!access.knows(wrong), "{wrong:?}");
        }
        assert!(!super::tests::access().knows(Some(&word)));
    }

    #[test]
    fn foreign_names_and_pages_are_refused() {
        let access = access();
        for (host, origin) in [
            ("127.0.0.1:8640", None),
            ("localhost:8640", Some("http://localhost:8640")),
            ("[::1]:8640", None),
            ("192.168.1.7:8640", Some("http://192.168.1.7:8640")),
        ] {
            assert!(access.is_own_name(Some(host), origin), "{host}");
        }
        for (host, origin) in [
            (None, None),
            (Some("evil.example:8640"), None),
            (Some("127.0.0.1.evil.example:8640"), None),
            (Some("localhost"), None),
            (Some("localhost:80"), None),
            (Some("[::1]"), None),
            (Some("127.0.0.1:8640"), Some("http://evil.example")),
            (Some("127.0.0.1:8640"), Some("null")),
            (Some("127.0.0.1:8640"), Some("https://127.0.0.1:8640")),
        ] {
            assert!(!access.is_own_name(host, origin), "{host:?} {origin:?}");
        }
    }
}

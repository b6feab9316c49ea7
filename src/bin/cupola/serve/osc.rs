//! Requests through OSC over UDP, for show control: `/cupola/set/KEY VALUE…`, `/cupola/undo` and
//! others.

use super::control::{Command, Server};
use super::pattern::Choice;
use crate::pattern::direction;
use rosc::{OscMessage, OscPacket, OscType};
use serde_json::Value;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::os::unix::fs::MetadataExt;
use std::sync::Arc;

/// Greatest number of messages of a bundle that are executed.
const MOST: usize = 256;
/// Greatest number of bundles and arrays of a packet, which may lie in each other. Each level takes
/// room on the stack.
const MOST_NESTED: usize = 64;

/// Executes messages that arrive at `socket`, for as long as the process lives.
pub fn serve(socket: UdpSocket, server: Arc<Server>) {
    std::thread::spawn(move || {
        let mut bytes = vec![0; 64 << 10];
        loop {
            let Ok((length, from)) = socket.recv_from(&mut bytes) else {
                std::thread::sleep(std::time::Duration::from_millis(50));
                continue;
            };
            if !is_from_this_user(from) {
                continue;
            }
            for message in messages(&bytes[..length]) {
                let command = command(&message);
                let asked = matches!(command, Ok(Command::Get { .. }));
                let answered = command.and_then(|command| server.run(command, false));
                if let Err(why) = &answered {
                    eprintln!("cupola: OSC {}: {why}", message.addr);
                }
                if asked {
                    send(&socket, from, answer(&message.addr, answered));
                }
            }
        }
    });
}

/// Answer to the question for a key: `/cupola/value/KEY` with its value or, if the file does not have it, with its default;
/// `/cupola/refused/KEY` with the reason.
fn answer(address: &str, answered: Result<Value, String>) -> OscMessage {
    let key = address.strip_prefix("/cupola/get").unwrap_or_default();
    match answered {
        // Tables and lists of tables have no other form than their text.
        Ok(found) if found["toml"].is_string() => {
            OscMessage { addr: format!("/cupola/value{key}"), args: vec![argument(&found["toml"])] }
        }
        Ok(found) => {
            let value = if found["value"].is_null() { &found["default"] } else { &found["value"] };
            let args = value.as_array().map_or_else(|| vec![argument(value)], |all| all.iter().map(argument).collect());
            OscMessage { addr: format!("/cupola/value{key}"), args }
        }
        Err(why) => OscMessage { addr: format!("/cupola/refused{key}"), args: vec![OscType::String(why)] },
    }
}

/// A value as an argument. Numbers are floats, which all show controls read.
fn argument(value: &Value) -> OscType {
    match value {
        Value::Number(number) => OscType::Float(number.as_f64().unwrap_or_default() as f32),
        Value::Bool(value) => OscType::Bool(*value),
        Value::String(text) => OscType::String(text.clone()),
        Value::Null => OscType::Nil,
        other => OscType::String(other.to_string()),
    }
}

/// Sends an answer; who does not listen any more does not get it.
fn send(socket: &UdpSocket, to: SocketAddr, message: OscMessage) {
    if let Ok(bytes) = rosc::encoder::encode(&OscPacket::Message(message)) {
        let _ = socket.send_to(&bytes, to);
    }
}

/// Choice of a pattern: its parts, and `step=`, `only=` and `at=AZIMUTH,ELEVATION`.
fn choice(words: Vec<String>) -> Result<Choice, String> {
    let mut choice = Choice::default();
    for word in words {
        match word.split_once('=') {
            None => choice.parts.push(word),
            Some(("step", step)) => choice.step = Some(step.parse().map_err(|_| "step= lacks a number of degrees")?),
            Some(("only", name)) => choice.only = Some(name.to_owned()),
            Some(("at", place)) => choice.at.push(direction(place)?),
            Some((other, _)) => return Err(format!("{other}= is not known; there are step=, only= and at=")),
        }
    }
    Ok(choice)
}

/// Returns the messages of a packet; none if it is not understood, or nested too deeply.
pub(super) fn messages(bytes: &[u8]) -> Vec<OscMessage> {
    let bundles = bytes.windows(8).filter(|part| part == b"#bundle\0").count();
    let arrays = bytes.iter().filter(|byte| **byte == b'[').count();
    let mut messages = Vec::new();
    if bundles + arrays <= MOST_NESTED
        && let Ok((_, packet)) = rosc::decoder::decode_udp(bytes)
    {
        flatten(packet, &mut messages);
    }
    messages
}

/// Collects the messages of a packet, including those in bundles.
fn flatten(packet: OscPacket, messages: &mut Vec<OscMessage>) {
    match packet {
        OscPacket::Message(message) if messages.len() < MOST => messages.push(message),
        OscPacket::Message(_) => {}
        OscPacket::Bundle(bundle) => bundle.content.into_iter().for_each(|packet| flatten(packet, messages)),
    }
}

/// True if a packet of this machine is from this user. Packets of other machines arrive only if the
/// operator requested it.
fn is_from_this_user(from: SocketAddr) -> bool {
    if !from.ip().is_loopback() {
        return true;
    }
    let Ok(user) = std::fs::metadata("/proc/self").map(|process| process.uid()) else { return false };
    let file = if matches!(from.ip(), IpAddr::V4(_)) { "/proc/net/udp" } else { "/proc/net/udp6" };
    let sockets = std::fs::read_to_string(file).unwrap_or_default();
    owners(&sockets, from.port()).all(|owner| owner == user)
}

/// Users of the sockets with this port, in the system's table; another user if none is found.
fn owners(table: &str, port: u16) -> impl Iterator<Item = u32> {
    let users: Vec<u32> = table
        .lines()
        .skip(1)
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            let (_, own) = words.nth(1)?.split_once(':')?;
            let is_it = u16::from_str_radix(own, 16).ok()? == port;
            words.nth(5).filter(|_| is_it)?.parse().ok()
        })
        .collect();
    let nobody = users.is_empty().then_some(u32::MAX);
    users.into_iter().chain(nobody)
}

/// Converts a message to a request.
pub(super) fn command(message: &OscMessage) -> Result<Command, String> {
    let words: Vec<String> =
        message.args.iter().map(word).collect::<Option<_>>().ok_or("an argument is neither number nor text")?;
    let path = message.addr.strip_prefix("/cupola/").ok_or("the address does not begin with /cupola/")?;
    let first = || words.first().cloned();
    Ok(match path.split('/').collect::<Vec<_>>()[..] {
        ["set", ref key @ ..] if !key.is_empty() && !words.is_empty() => {
            let value = if words.len() == 1 { words[0].clone() } else { format!("[{}]", words.join(", ")) };
            let key = key.join(".");
            let gesture = Some(format!("osc {key}"));
            Command::Set { changes: vec![format!("{key}={value}")], remove: Vec::new(), gesture }
        }
        ["unset", ref key @ ..] if !key.is_empty() => {
            Command::Set { changes: Vec::new(), remove: vec![key.join(".")], gesture: None }
        }
        ["undo"] => Command::Undo {},
        ["redo"] => Command::Redo {},
        ["save"] => Command::Save { replace: false },
        ["rig"] => Command::Rig { name: first().ok_or("the name of the rig is missing")?, replace: false },
        ["get", ref key @ ..] if !key.is_empty() => Command::Get { key: key.join(".") },
        ["pattern"] => Command::Pattern(choice(words)?),
        ["start"] => Command::Start { program: first(), command: None },
        ["stop"] => Command::Stop {},
        ["pause"] => Command::Pause {},
        ["resume"] => Command::Resume {},
        ["step"] => {
            let frames = first().map_or(Ok(1.0), |word| word.parse::<f64>());
            let frames = frames.ok().filter(|frames| *frames >= 0.0 && frames.fract() == 0.0);
            Command::Step { frames: frames.ok_or("expected a number of frames")? as u64 }
        }
        _ => return Err("this address is not known, or lacks its value".to_owned()),
    })
}

/// Formats an argument as in the rig file.
fn word(argument: &OscType) -> Option<String> {
    Some(match argument {
        // Formats only the digits of the float.
        OscType::Float(value) => value.to_string(),
        OscType::Double(value) => value.to_string(),
        OscType::Int(value) => value.to_string(),
        OscType::Long(value) => value.to_string(),
        OscType::Bool(value) => value.to_string(),
        OscType::String(value) => value.clone(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn message(addr: &str, args: Vec<OscType>) -> Result<Command, String> {
        command(&OscMessage { addr: addr.to_owned(), args })
    }

    #[test]
    fn addresses_are_keys() {
        let set = |change: &str, key: &str| Command::Set {
            changes: vec![change.to_owned()],
            remove: Vec::new(),
            gesture: Some(format!("osc {key}")),
        };
        let yaw = message("/cupola/set/output/front/yaw", vec![OscType::Float(12.1)]);
        assert_eq!(yaw, Ok(set("output.front.yaw=12.1", "output.front.yaw")));
        let place =
            message("/cupola/set/viewer/position", vec![OscType::Int(0), OscType::Double(0.5), OscType::Int(1)]);
        assert_eq!(place, Ok(set("viewer.position=[0, 0.5, 1]", "viewer.position")));
        let unset = Command::Set { changes: Vec::new(), remove: vec!["viewer.yaw".to_owned()], gesture: None };
        assert_eq!(message("/cupola/unset/viewer/yaw", Vec::new()), Ok(unset));
        assert_eq!(message("/cupola/stop", Vec::new()), Ok(Command::Stop {}));
        for wrong in
            ["/cupola/set", "/cupola/set/dome/radius", "/cupola/unset", "/cupola/quit", "/other", "/cupola/rig", ""]
        {
            assert!(message(wrong, Vec::new()).is_err(), "{wrong}");
        }
        assert!(message("/cupola/set/dome/radius", vec![OscType::Nil]).is_err());
    }

    #[test]
    fn questions_are_answered() {
        let key = || "output.front.yaw".to_owned();
        assert_eq!(message("/cupola/get/output/front/yaw", Vec::new()), Ok(Command::Get { key: key() }));
        assert!(message("/cupola/get", Vec::new()).is_err());
        let answer = |value| answer("/cupola/get/output/front/yaw", value);
        let told = answer(Ok(serde_json::json!({ "value": 12.5, "default": 0 })));
        assert_eq!((told.addr.as_str(), told.args), ("/cupola/value/output/front/yaw", vec![OscType::Float(12.5)]));
        let told = answer(Ok(serde_json::json!({ "value": null, "default": [1, 2] })));
        assert_eq!(told.args, [OscType::Float(1.0), OscType::Float(2.0)]);
        let text = "{ file = \"a.csv\" }";
        let told = answer(Ok(serde_json::json!({ "toml": text, "value": null, "default": "power" })));
        assert_eq!(told.args, [OscType::String(text.to_owned())]);
        let told = answer(Err("no".to_owned()));
        assert_eq!((told.addr.as_str(), told.args.len()), ("/cupola/refused/output/front/yaw", 1));
    }

    #[test]
    fn patterns_have_options() {
        let pattern = |words: &[&str]| {
            message("/cupola/pattern", words.iter().map(|word| OscType::String((*word).to_owned())).collect())
        };
        let chosen = Choice {
            parts: vec!["horizon".to_owned()],
            step: Some(15.0),
            only: Some("front".to_owned()),
            at: vec![[45.0, 30.0]],
            cursor: None,
        };
        assert_eq!(pattern(&["horizon", "step=15", "only=front", "at=45,30"]), Ok(Command::Pattern(chosen)));
        for wrong in ["step=wide", "at=45", "size=3"] {
            assert!(pattern(&[wrong]).is_err(), "{wrong}");
        }
    }

    #[test]
    fn other_users_are_told_apart() {
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n\
            1: 0100007F:21C0 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 1 2 0 0\n\
            2: 00000000:21C1 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0 0\n";
        assert_eq!(owners(table, 0x21C0).collect::<Vec<_>>(), [1000]);
        assert_eq!(owners(table, 0x21C1).collect::<Vec<_>>(), [0]);
        assert_eq!(owners(table, 0x21C2).collect::<Vec<_>>(), [u32::MAX]);
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        assert!(is_from_this_user(socket.local_addr().expect("an address")));
    }

    #[test]
    fn random_packets_do_no_harm() {
        let mut random = Random::new(1);
        for _ in 0..20_000 {
            let mut bytes = b"/cupola/set/dome/radius\0,f\0\0\x40\x80\0\0".to_vec();
            for _ in 0..4 {
                let at = random.below(bytes.len());
                bytes[at] = random.bits() as u8;
            }
            messages(&bytes).iter().for_each(|message| drop(command(message)));
        }
    }

    /// Threads have a stack of 2 MiB.
    #[test]
    fn deeply_nested_packets_are_left_out() {
        let nested = |depth: usize| {
            let mut packet = b"/cupola/undo\0\0\0\0,\0\0\0".to_vec();
            for _ in 0..depth {
                let length = packet.len() as u32;
                packet = [b"#bundle\0\0\0\0\0\0\0\0\x01", &length.to_be_bytes()[..], &packet].concat();
            }
            packet
        };
        let arrays = |depth: usize| {
            let tags = format!(",{}{}", "[".repeat(depth), "]".repeat(depth));
            let padding = vec![0; 4 - tags.len() % 4];
            [b"/cupola/undo\0\0\0\0", tags.as_bytes(), &padding].concat()
        };
        for depth in [0, 1, MOST_NESTED] {
            assert_eq!(messages(&nested(depth)).len(), 1, "{depth} bundles");
            assert_eq!(messages(&arrays(depth)).len(), 1, "{depth} arrays");
        }
        for depth in [MOST_NESTED + 1, 3000] {
            assert_eq!(messages(&nested(depth)).len(), 0, "{depth} bundles");
            assert_eq!(messages(&arrays(10 * depth)).len(), 0, "{depth} arrays");
        }
    }
}

//! A single test, because the receiver belongs to the process.

use super::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

#[test]
fn messages_reach_the_receiver_that_is_set_and_no_other() {
    let own = |text: &str| text.contains("a test of messages");
    let heard = Arc::new(Mutex::new(Vec::new()));
    let receiver = |heard: &Arc<Mutex<Vec<_>>>| -> Receiver {
        let heard = heard.clone();
        Box::new(move |level, text| {
            if own(text) {
                heard.lock().expect("not poisoned").push((level, text.to_owned()));
                // Neither a message nor a change from inside: both would lock for ever.
                log::error!("a test of messages from inside");
                assert_eq!(set_receiver(None).map_err(|error| error.kind), Err(ErrorKind::InvalidState));
            }
        })
    };

    log::error!("a test of messages before there is a receiver");
    set_receiver(Some(receiver(&heard))).expect("no other logger");
    log::warn!("a test of messages, {}", 1);
    log::debug!("a test of messages, 2");
    log::trace!("a test of messages that is too fine");
    log::error!(target: "other::cupola", "a test of messages of another crate");
    let expected = [(Level::Warn, "a test of messages, 1"), (Level::Debug, "a test of messages, 2")];
    assert_eq!(*heard.lock().expect("not poisoned"), expected.map(|(level, text)| (level, text.to_owned())));

    // A panic that the barrier stops is a message with the panic's text.
    heard.lock().expect("not poisoned").clear();
    assert_eq!(crate::fence::guard(|| panic!("a test of messages panics")), None::<()>);
    let messages = std::mem::take(&mut *heard.lock().expect("not poisoned"));
    assert!(
        matches!(&messages[..], [(Level::Error, text)] if text.contains("a test of messages panics")),
        "{messages:?}"
    );

    set_receiver(None).expect("no other logger");
    log::error!("a test of messages after the receiver");
    assert!(heard.lock().expect("not poisoned").is_empty());

    // Removal waits: nothing is received afterwards, even if other threads go on.
    let (stop, count) = (AtomicBool::new(false), Arc::new(AtomicUsize::new(0)));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                while !stop.load(Ordering::Relaxed) {
                    log::error!("a test of messages from many threads");
                }
            });
        }
        for _ in 0..50 {
            let live = Arc::new(AtomicBool::new(true));
            let (seen, count) = (live.clone(), count.clone());
            set_receiver(Some(Box::new(move |_, _| {
                assert!(seen.load(Ordering::SeqCst), "received after the removal");
                count.fetch_add(1, Ordering::Relaxed);
            })))
            .expect("no other logger");
            std::thread::sleep(std::time::Duration::from_millis(1));
            set_receiver(None).expect("no other logger");
            live.store(false, Ordering::SeqCst);
        }
        stop.store(true, Ordering::Relaxed);
    });
    assert!(count.load(Ordering::Relaxed) > 0, "control: the threads were heard");
}

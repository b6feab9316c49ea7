//! Outlets: where pictures leave this command.

use crate::failure::Failure;
use crate::launch::clock::Rate;
use crate::pipe::{Receiver, TimeBase, Writing};
use cupola::ring::Picture;
use cupola::system::ndi;
use std::io::ErrorKind;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Interval at which the receivers of an NDI source are counted.
const COUNTING: Duration = Duration::from_secs(1);

/// Outlet for pictures.
pub enum Outlet {
    Receiver(Receiver),
    Output(Writing, (u32, u32)),
    Ndi(Ndi),
}

impl Outlet {
    /// True if pictures of this size can go on to the same receiver.
    pub fn takes(&self, size: (u32, u32)) -> bool {
        match self {
            Self::Receiver(receiver) => receiver.size() == size,
            Self::Output(_, own) => *own == size,
            Self::Ndi(_) => true,
        }
    }

    /// Sends a picture. `time`: nanoseconds since the first one. Returns false if the reader of the
    /// standard output is gone.
    pub fn add(&mut self, picture: &Picture, time: u64) -> Result<bool, Failure> {
        let units = TimeBase::LIVE.units(time);
        match self {
            Self::Receiver(receiver) => receiver.add(picture, units).map(|()| true),
            Self::Output(writing, _) => match writing.add(&mut std::io::stdout().lock(), &picture.rgba, units) {
                Ok(()) => Ok(true),
                Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
                Err(error) => Err(Failure::new(format!("the standard output: {error}"))),
            },
            Self::Ndi(source) => source.add(picture, time).map(|()| true),
        }
    }

    /// Ends the pictures, and waits until a receiver has received all of them.
    pub fn finish(&mut self) -> Result<(), Failure> {
        match self {
            Self::Receiver(receiver) => receiver.finish(),
            Self::Output(..) | Self::Ndi(_) => Ok(()),
        }
    }
}

/// Source of NDI.
pub struct Ndi {
    source: ndi::Source,
    rate: Rate,
    /// Date of the first picture, in units of 100 ns since 1970.
    begin: Option<i64>,
    counted: Instant,
    receivers: u32,
}

impl Ndi {
    /// Loads NDI's library and makes a source of this name.
    pub fn open(name: &str, rate: Rate) -> Result<Self, Failure> {
        let source = ndi::Source::new(name).map_err(Failure::new)?;
        Ok(Self { source, rate, begin: None, counted: Instant::now(), receivers: 0 })
    }

    fn add(&mut self, picture: &Picture, time: u64) -> Result<(), Failure> {
        let begin = *self.begin.get_or_insert_with(|| {
            let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            i64::try_from(now.as_nanos() / 100).unwrap_or(0)
        });
        let time = begin.saturating_add_unsigned(time / 100);
        let rate = (self.rate.frames, self.rate.seconds);
        let sent = ndi::Sent { size: picture.size, rgba: &picture.rgba, rate, time };
        self.source.send(sent).map_err(Failure::new)?;
        if self.counted.elapsed() >= COUNTING {
            self.counted = Instant::now();
            let receivers = self.source.receivers();
            if std::mem::replace(&mut self.receivers, receivers) != receivers {
                eprintln!("cupola: number of receivers of the NDI source: {receivers}");
            }
        }
        Ok(())
    }
}

//! Outlets: where pictures leave this command.

#[cfg(feature = "pipewire")]
use super::pipewire;
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
    #[cfg(feature = "pipewire")]
    PipeWire(pipewire::Source),
}

/// Result of sending a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Added {
    /// The receiver has got it.
    Sent,
    /// The receiver is too slow for it.
    #[cfg_attr(not(feature = "pipewire"), expect(dead_code, reason = "the other outlets wait for their receivers"))]
    Lost,
    /// There is no receiver yet, or no longer.
    #[cfg_attr(not(feature = "pipewire"), expect(dead_code, reason = "the other outlets do not know it"))]
    Unseen,
    /// The receiver is gone, and pictures have to end.
    Gone,
}

impl Outlet {
    /// Loads NDI's library and makes a source of this name.
    pub fn ndi(name: &str, rate: Rate) -> Result<Self, Failure> {
        let source = ndi::Source::new(name).map_err(Failure::new)?;
        Ok(Self::Ndi(Ndi { source, rate, begin: None, counted: Instant::now(), receivers: 0 }))
    }

    /// Connects to PipeWire for a source of this name.
    #[cfg(feature = "pipewire")]
    pub fn pipewire(name: &str, rate: Rate) -> Result<Self, Failure> {
        pipewire::Source::open(name, rate).map(Self::PipeWire)
    }

    /// PipeWire is not compiled in.
    #[cfg(not(feature = "pipewire"))]
    pub fn pipewire(name: &str, _rate: Rate) -> Result<Self, Failure> {
        Err(Failure::new(format!(
            "pipewire:{name} needs a cupola that was built with PipeWire: cargo build --release --features pipewire (on \
             Debian with the packages libpipewire-0.3-dev and libclang-dev)"
        )))
    }

    /// True if pictures of this size can go on to the same receiver.
    pub fn takes(&self, size: (u32, u32)) -> bool {
        match self {
            Self::Receiver(receiver) => receiver.size() == size,
            Self::Output(_, own) => *own == size,
            Self::Ndi(_) => true,
            #[cfg(feature = "pipewire")]
            Self::PipeWire(_) => true,
        }
    }

    /// Sends a picture. `time`: nanoseconds since the first one.
    pub fn add(&mut self, picture: &Picture, time: u64) -> Result<Added, Failure> {
        let units = TimeBase::LIVE.units(time);
        match self {
            Self::Receiver(receiver) => receiver.add(picture, units).map(|()| Added::Sent),
            Self::Output(writing, _) => match writing.add(&mut std::io::stdout().lock(), &picture.rgba, units) {
                Ok(()) => Ok(Added::Sent),
                Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(Added::Gone),
                Err(error) => Err(Failure::new(format!("the standard output: {error}"))),
            },
            Self::Ndi(source) => source.add(picture, time).map(|()| Added::Sent),
            #[cfg(feature = "pipewire")]
            Self::PipeWire(source) => source.add(picture),
        }
    }

    /// Handles what a receiver wants, while there is no picture.
    pub fn handle_events(&self) -> Result<(), Failure> {
        match self {
            Self::Receiver(_) | Self::Output(..) | Self::Ndi(_) => Ok(()),
            #[cfg(feature = "pipewire")]
            Self::PipeWire(source) => source.handle_events(),
        }
    }

    /// Ends the pictures, and waits until a receiver has received all of them.
    pub fn finish(&mut self) -> Result<(), Failure> {
        match self {
            Self::Receiver(receiver) => receiver.finish(),
            Self::Output(..) | Self::Ndi(_) => Ok(()),
            #[cfg(feature = "pipewire")]
            Self::PipeWire(source) => source.finish(),
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

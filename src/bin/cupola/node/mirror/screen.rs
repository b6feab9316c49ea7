//! A mirror: receives pictures of node 0, and publishes them on this machine for its windows.

use crate::failure::Failure;
use crate::node::pictures::{Head, PictureLink};
use cupola::ring::{Format, Picture, Shape, Stamp, Writer};
use cupola::system;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Slots of the ring, as few as there can be: its readers take the newest frame.
const SLOTS: usize = 3;

/// How a mirror ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The program of node 0 has ended.
    Told,
    /// The connection was closed or lost.
    Lost,
}

/// The pictures of a mirror.
pub struct Screen {
    link: Arc<dyn PictureLink>,
    path: PathBuf,
    /// Time of the last message of node 0.
    heard: Arc<AtomicU64>,
    writer: Option<Writer>,
    /// Pictures of the newest frame, and those of the next one that have come.
    newest: Vec<Picture>,
    next: Vec<Picture>,
    /// Memory for the pixels of more pictures.
    spare: Vec<Vec<u8>>,
}

impl Screen {
    /// `path`: file of the published pictures. `heard` is set to the time of each message of
    /// node 0.
    pub fn new(link: Arc<dyn PictureLink>, path: PathBuf, heard: Arc<AtomicU64>) -> Self {
        Self { link, path, heard, writer: None, newest: Vec::new(), next: Vec::new(), spare: Vec::new() }
    }

    /// Shows the pictures of node 0 until one of the two ends. Returns the pictures of the newest
    /// frame, too.
    ///
    /// # Errors
    /// The pictures cannot be published.
    pub fn show(mut self) -> Result<(End, Vec<Picture>), Failure> {
        let mut pixels = Vec::new();
        let end = loop {
            let head = self.link.receive(0, &mut pixels);
            self.heard.store(system::monotonic(), Ordering::SeqCst);
            match head {
                Some(Head::Picture { frame, left, size, name }) => {
                    let rgba = std::mem::replace(&mut pixels, self.spare.pop().unwrap_or_default());
                    self.next.push(Picture { name, size, rgba, format: Format::Rgba8 });
                    if left == 0 {
                        self.publish(frame)?;
                    }
                }
                Some(Head::Alive) => {}
                Some(Head::End) => break End::Told,
                Some(Head::Outputs { .. }) | None => break End::Lost,
            }
        };
        if let Some(writer) = self.writer {
            writer.end();
        }
        Ok((end, self.newest))
    }

    /// Publishes a complete frame.
    fn publish(&mut self, frame: u64) -> Result<(), Failure> {
        let old = std::mem::replace(&mut self.newest, std::mem::take(&mut self.next));
        self.spare.extend(old.into_iter().map(|picture| picture.rgba));
        let shape = |picture: &Picture| Shape { name: picture.name.clone(), size: picture.size, format: Format::Rgba8 };
        let shapes: Vec<Shape> = self.newest.iter().map(shape).collect();
        match &mut self.writer {
            Some(writer) if writer.shapes() == shapes => {}
            Some(writer) => writer.reshape(&shapes)?,
            None => self.writer = Some(Writer::create(&self.path, &shapes, SLOTS, false)?),
        }
        if let Some(writer) = &mut self.writer {
            writer.publish(Stamp { index: frame, time: system::monotonic(), rig: 0 }, |pictures| {
                for (number, picture) in self.newest.iter().enumerate() {
                    let row = (picture.size.0 as usize * 4).max(1);
                    for (y, row) in (0..).zip(picture.rgba.chunks_exact(row)) {
                        pictures.row(number, y, row);
                    }
                }
            });
        }
        Ok(())
    }
}

//! A video source of PipeWire, which other programs take as a camera.
//!
//! PipeWire's events are handled between two frames, in the thread that sends. PipeWire allocates
//! the buffers, in memory that it shares with the receivers. A receiver that is slow keeps them: a
//! frame that finds no free buffer is lost. Nothing here waits for a receiver.

use super::outlet::Added;
use crate::failure::Failure;
use crate::launch::clock::Rate;
use cupola::ring::Picture;
use pipewire::context::ContextRc;
use pipewire::core::{CoreRc, Listener};
use pipewire::loop_::Timeout;
use pipewire::main_loop::MainLoopRc;
use pipewire::properties::properties;
use pipewire::spa::buffer::DataType;
use pipewire::spa::param::ParamType;
use pipewire::spa::param::format::{FormatProperties, MediaSubtype, MediaType};
use pipewire::spa::param::video::{VideoFormat, VideoInfoRaw};
use pipewire::spa::pod::serialize::PodSerializer;
use pipewire::spa::pod::{ChoiceValue, Object, Pod, Property, Value, object, property};
use pipewire::spa::sys;
use pipewire::spa::utils::{Choice, ChoiceEnum, ChoiceFlags, Direction, Fraction, Rectangle, SpaTypes};
use pipewire::stream::{Stream, StreamFlags, StreamListener, StreamRc, StreamState};
use std::cell::{Cell, RefCell};
use std::io::Cursor;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Number of buffers: usual, least and greatest.
const BUFFERS: (i32, i32, i32) = (4, 2, 16);
/// Time for the receivers to take the last picture.
const LAST: Duration = Duration::from_millis(100);

/// A source with a name.
pub struct Source {
    // Dropped in this order: the stream before the connection on which it is.
    stream: Option<Offered>,
    _errors: Listener,
    core: CoreRc,
    main_loop: MainLoopRc,
    name: String,
    rate: Rate,
    state: Rc<State>,
}

/// The stream that receivers see.
struct Offered {
    _events: StreamListener<()>,
    stream: StreamRc,
    size: (u32, u32),
}

/// What PipeWire has told.
#[derive(Default)]
struct State {
    /// Format and size on which source and receivers agree.
    format: Cell<Option<(VideoFormat, (u32, u32))>>,
    is_streaming: Cell<bool>,
    failure: RefCell<Option<String>>,
}

impl Source {
    /// Connects to PipeWire.
    pub fn open(name: &str, rate: Rate) -> Result<Self, Failure> {
        pipewire::init();
        let unreachable = |error: pipewire::Error| {
            let folder = std::env::var_os("XDG_RUNTIME_DIR");
            let folder = folder.map_or_else(|| "is not set".to_owned(), |folder| format!("is {}", folder.display()));
            Failure::new(format!(
                "PipeWire is not reached: {error}. It has to run for this user (systemctl --user start pipewire); its \
                 socket is in the folder XDG_RUNTIME_DIR, which {folder}"
            ))
        };
        let main_loop = MainLoopRc::new(None).map_err(unreachable)?;
        let context = ContextRc::new(&main_loop, None).map_err(unreachable)?;
        let core = context.connect_rc(None).map_err(unreachable)?;
        let state = Rc::new(State::default());
        let told = Rc::clone(&state);
        let errors = core.add_listener_local().error(move |object, _, _, message| {
            // Errors of other objects, such as a link that was refused, do not end the connection.
            if object == pipewire::core::PW_ID_CORE {
                told.failure.replace(Some(message.to_owned()));
            }
        });
        let errors = errors.register();
        Ok(Self { stream: None, _errors: errors, core, main_loop, name: name.to_owned(), rate, state })
    }

    /// Handles what PipeWire has sent.
    pub fn handle_events(&self) -> Result<(), Failure> {
        while self.main_loop.loop_().iterate(Timeout::None) > 0 {}
        match &*self.state.failure.borrow() {
            Some(words) => Err(Failure::new(format!("PipeWire takes no more pictures: {words}"))),
            None => Ok(()),
        }
    }

    /// Offers a picture to the receivers.
    pub fn add(&mut self, picture: &Picture) -> Result<Added, Failure> {
        let refused = |error: pipewire::Error| Failure::new(format!("PipeWire refuses the pictures: {error}"));
        self.offer(picture.size).map_err(refused)?;
        self.handle_events()?;
        let Some(Offered { stream, .. }) = &self.stream else { return Ok(Added::Unseen) };
        let format = self.state.format.get().filter(|(_, size)| *size == picture.size);
        let (Some((format, _)), true) = (format, self.state.is_streaming.get()) else { return Ok(Added::Unseen) };
        let Some(mut buffer) = stream.dequeue_buffer() else { return Ok(Added::Lost) };
        let Some(data) = buffer.datas_mut().first_mut() else { return Ok(Added::Lost) };
        let is_whole = data.data().is_some_and(|bytes| write(bytes, &picture.rgba, format));
        let chunk = data.chunk_mut();
        *chunk.offset_mut() = 0;
        *chunk.stride_mut() = i32::try_from(picture.size.0 * 4).unwrap_or(0);
        *chunk.size_mut() = if is_whole { u32::try_from(picture.rgba.len()).unwrap_or(0) } else { 0 };
        // Gives the buffer to PipeWire.
        drop(buffer);
        stream.trigger_process().map_err(refused)?;
        self.handle_events()?;
        Ok(if is_whole { Added::Sent } else { Added::Lost })
    }

    /// Waits until the receivers had time to take the last picture.
    pub fn finish(&mut self) -> Result<(), Failure> {
        let end = Instant::now() + LAST;
        while self.state.is_streaming.get() && Instant::now() < end {
            self.main_loop.loop_().iterate(Timeout::Finite(LAST / 10));
        }
        self.handle_events()
    }

    /// Makes the stream for pictures of this size, or changes its format.
    fn offer(&mut self, size: (u32, u32)) -> Result<(), pipewire::Error> {
        let bytes = format(size, self.rate);
        let mut parameters: Vec<&Pod> = Pod::from_bytes(&bytes).into_iter().collect();
        match &mut self.stream {
            Some(offered) if offered.size == size => Ok(()),
            Some(offered) => {
                eprintln!("cupola: the picture has another size now: PipeWire's receivers get another format");
                offered.size = size;
                offered.stream.update_params(&mut parameters)
            }
            None => {
                let properties = properties! {
                    *pipewire::keys::MEDIA_CLASS => "Video/Source",
                    *pipewire::keys::MEDIA_TYPE => "Video",
                    *pipewire::keys::MEDIA_CATEGORY => "Capture",
                    *pipewire::keys::MEDIA_ROLE => "Camera",
                    *pipewire::keys::NODE_NAME => self.name.as_str(),
                    *pipewire::keys::NODE_DESCRIPTION => self.name.as_str(),
                };
                let stream = StreamRc::new(self.core.clone(), &self.name, properties)?;
                let events = listen(&stream, &self.state)?;
                stream.connect(
                    Direction::Output,
                    None,
                    StreamFlags::DRIVER | StreamFlags::MAP_BUFFERS,
                    &mut parameters,
                )?;
                self.stream = Some(Offered { _events: events, stream, size });
                Ok(())
            }
        }
    }
}

/// Notes what PipeWire tells about the stream.
fn listen(stream: &StreamRc, state: &Rc<State>) -> Result<StreamListener<()>, pipewire::Error> {
    let (changed, told) = (Rc::clone(state), Rc::clone(state));
    stream
        .add_local_listener::<()>()
        .state_changed(move |_, (), _, now| {
            changed.is_streaming.set(now == StreamState::Streaming);
            if let StreamState::Error(words) = now {
                changed.failure.replace(Some(words));
            }
        })
        .param_changed(move |stream, (), id, parameter| {
            if id == ParamType::Format.as_raw() {
                told.format.set(parameter.and_then(|parameter| agreed(stream, parameter)));
            }
        })
        .register()
}

/// Format and size on which source and receivers agree. Asks for buffers for them.
fn agreed(stream: &Stream, parameter: &Pod) -> Option<(VideoFormat, (u32, u32))> {
    let mut video = VideoInfoRaw::new();
    video.parse(parameter).ok()?;
    let Rectangle { width, height } = video.size();
    let bytes = buffers((width, height))?;
    stream.update_params(&mut [Pod::from_bytes(&bytes)?]).ok()?;
    Some((video.format(), (width, height)))
}

/// Writes pixels to a buffer in its format. Returns false if the buffer is too small.
fn write(buffer: &mut [u8], rgba: &[u8], format: VideoFormat) -> bool {
    let Some(buffer) = buffer.get_mut(..rgba.len()) else { return false };
    buffer.copy_from_slice(rgba);
    if [VideoFormat::BGRx, VideoFormat::BGRA].contains(&format) {
        buffer.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
    }
    true
}

/// The formats that are offered, as PipeWire's bytes.
fn format((width, height): (u32, u32), rate: Rate) -> Vec<u8> {
    let rate = [rate.frames, rate.seconds].map(|number| u32::try_from(number).unwrap_or(u32::MAX));
    bytes(object!(
        SpaTypes::ObjectParamFormat,
        ParamType::EnumFormat,
        property!(FormatProperties::MediaType, Id, MediaType::Video),
        property!(FormatProperties::MediaSubtype, Id, MediaSubtype::Raw),
        property!(
            FormatProperties::VideoFormat,
            Choice,
            Enum,
            Id,
            VideoFormat::RGBx,
            VideoFormat::RGBx,
            VideoFormat::RGBA,
            VideoFormat::BGRx,
            VideoFormat::BGRA
        ),
        property!(FormatProperties::VideoSize, Rectangle, Rectangle { width, height }),
        property!(FormatProperties::VideoFramerate, Fraction, Fraction { num: rate[0], denom: rate[1] })
    ))
}

/// The buffers that pictures of this size need, as PipeWire's bytes.
fn buffers((width, height): (u32, u32)) -> Option<Vec<u8>> {
    let stride = width.checked_mul(4)?;
    let number = |key, value: u32| Some(Property::new(key, Value::Int(i32::try_from(value).ok()?)));
    let choice =
        |key, choice| Property::new(key, Value::Choice(ChoiceValue::Int(Choice(ChoiceFlags::empty(), choice))));
    let (default, min, max) = BUFFERS;
    let kinds = 1 << DataType::MemPtr.as_raw() | 1 << DataType::MemFd.as_raw();
    let properties = vec![
        choice(sys::SPA_PARAM_BUFFERS_buffers, ChoiceEnum::Range { default, min, max }),
        number(sys::SPA_PARAM_BUFFERS_blocks, 1)?,
        number(sys::SPA_PARAM_BUFFERS_size, stride.checked_mul(height)?)?,
        number(sys::SPA_PARAM_BUFFERS_stride, stride)?,
        choice(sys::SPA_PARAM_BUFFERS_dataType, ChoiceEnum::Flags { default: kinds, flags: Vec::new() }),
    ];
    let (type_, id) = (SpaTypes::ObjectParamBuffers.as_raw(), ParamType::Buffers.as_raw());
    Some(bytes(Object { type_, id, properties }))
}

/// An object as PipeWire's bytes; empty if it has none.
fn bytes(object: Object) -> Vec<u8> {
    let written = PodSerializer::serialize(Cursor::new(Vec::new()), &Value::Object(object));
    written.map_or_else(|_| Vec::new(), |(cursor, _)| cursor.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_written_in_the_receivers_order() {
        let written = |format| {
            let mut buffer = [9; 9];
            assert!(write(&mut buffer, &[1, 2, 3, 255, 4, 5, 6, 255], format));
            buffer
        };
        assert_eq!(written(VideoFormat::RGBx), [1, 2, 3, 255, 4, 5, 6, 255, 9]);
        assert_eq!(written(VideoFormat::BGRA), [3, 2, 1, 255, 6, 5, 4, 255, 9]);
        assert!(!write(&mut [0; 7], &[0; 8], VideoFormat::RGBx));
    }

    #[test]
    fn formats_and_buffers_are_what_pipewire_reads() {
        let bytes = format((640, 480), Rate { frames: 30000, seconds: 1001 });
        let mut video = VideoInfoRaw::new();
        assert!(Pod::from_bytes(&bytes).is_some_and(|pod| video.parse(pod).is_ok()));
        assert_eq!(
            (video.size(), video.framerate()),
            (Rectangle { width: 640, height: 480 }, Fraction { num: 30000, denom: 1001 })
        );
        assert!(buffers((640, 480)).is_some_and(|bytes| Pod::from_bytes(&bytes).is_some()));
        assert!(buffers((1 << 20, 1 << 20)).is_none());
    }
}

//! A video source of NDI, made by NDI's own library.
//!
//! The library is not a part of Cupola. The user installs it, and it is loaded while the command
//! runs. The structures and functions below are those of its versions 5 and 6.

use libloading::Library;
use std::error::Error;
use std::ffi::{CString, OsString, c_char, c_void};
use std::path::Path;

/// Files of the library, the newest version first, each with the variable for its folder.
const FILES: [(&str, &str); 2] = [("NDI_RUNTIME_DIR_V6", "libndi.so.6"), ("NDI_RUNTIME_DIR_V5", "libndi.so.5")];
/// Four characters that name the format of the pixels: red, green, blue, and a byte without meaning.
const RGBX: u32 = u32::from_le_bytes(*b"RGBX");
/// Number of whole pictures, in contrast to those of every other row.
const PROGRESSIVE: i32 = 1;

/// `NDIlib_send_create_t`: description of a new source.
#[repr(C)]
struct Description {
    name: *const c_char,
    groups: *const c_char,
    keeps_rate_of_video: bool,
    keeps_rate_of_audio: bool,
}

/// `NDIlib_video_frame_v2_t`: a picture.
#[repr(C)]
struct Video {
    width: i32,
    height: i32,
    pixels: u32,
    frames: i32,
    seconds: i32,
    /// Width ÷ height of the picture; 0: that of its pixels.
    aspect: f32,
    rows: i32,
    /// Time in units of 100 ns.
    time_code: i64,
    data: *const u8,
    bytes_per_row: i32,
    metadata: *const c_char,
    /// Time of sending, written by the library.
    time_stamp: i64,
}

/// Functions of the library.
struct Functions {
    initialize: unsafe extern "C" fn() -> bool,
    destroy: unsafe extern "C" fn(),
    create_source: unsafe extern "C" fn(*const Description) -> *mut c_void,
    destroy_source: unsafe extern "C" fn(*mut c_void),
    send: unsafe extern "C" fn(*mut c_void, *const Video),
    receivers: unsafe extern "C" fn(*mut c_void, u32) -> i32,
}

/// A source that receivers in the network find by its name.
pub struct Source {
    functions: Functions,
    source: *mut c_void,
}

/// A picture with its rate and its time.
#[derive(Clone, Copy, Debug)]
pub struct Sent<'a> {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Its pixels, red first, rows from the top.
    pub rgba: &'a [u8],
    /// Numbers of frames and of seconds in which they are shown.
    pub rate: (u64, u64),
    /// Time in units of 100 ns.
    pub time: i64,
}

impl Source {
    /// Loads the library and makes a source of this name.
    ///
    /// # Errors
    /// The library is not installed or not complete, or it does not make the source. The message
    /// tells what to do.
    pub fn new(name: &str) -> Result<Self, String> {
        let name = CString::new(name).map_err(|_| "the name of an NDI source has no character 0".to_owned())?;
        let functions = Functions::load()?;
        // SAFETY: the library's own function without arguments. It is called before all others.
        if !unsafe { (functions.initialize)() } {
            return Err("NDI's library does not run on this processor (NDIlib_initialize)".to_owned());
        }
        let description = Description {
            name: name.as_ptr(),
            groups: std::ptr::null(),
            // Frames are sent when the program draws them; the library would delay them.
            keeps_rate_of_video: false,
            keeps_rate_of_audio: false,
        };
        // SAFETY: the structure and the name in it live during the call, and the library copies them.
        let source = unsafe { (functions.create_source)(&raw const description) };
        if source.is_null() {
            // SAFETY: the counterpart of `initialize`; nothing of the library is used afterwards.
            unsafe { (functions.destroy)() };
            return Err(format!(
                "NDI's library makes no source {name:?} (NDIlib_send_create); choose another name, and check the \
                 library's own settings"
            ));
        }
        Ok(Self { functions, source })
    }

    /// Sends a picture, and waits until the library has used its pixels.
    ///
    /// # Errors
    /// The picture has fewer bytes than its size needs, or it is larger than NDI's numbers allow.
    pub fn send(&mut self, sent: Sent<'_>) -> Result<(), String> {
        let (width, height) = sent.size;
        let bytes = u64::from(width) * u64::from(height) * 4;
        let too_large = |_| format!("NDI has no pictures of {width} × {height} pixels at this rate");
        if (sent.rgba.len() as u64) < bytes {
            return Err(format!("a picture of {width} × {height} pixels has only {} bytes", sent.rgba.len()));
        }
        let video = Video {
            width: i32::try_from(width).map_err(too_large)?,
            height: i32::try_from(height).map_err(too_large)?,
            pixels: RGBX,
            frames: i32::try_from(sent.rate.0).map_err(too_large)?,
            seconds: i32::try_from(sent.rate.1).map_err(too_large)?,
            aspect: 0.0,
            rows: PROGRESSIVE,
            time_code: sent.time,
            data: sent.rgba.as_ptr(),
            bytes_per_row: i32::try_from(u64::from(width) * 4).map_err(too_large)?,
            metadata: std::ptr::null(),
            time_stamp: 0,
        };
        // SAFETY: the source exists until this is dropped. The structure and its pixels, of which
        // there are enough for size and row length, live during the call. This function of the
        // library, unlike its asynchronous one, does not use them later.
        unsafe { (self.functions.send)(self.source, &raw const video) };
        Ok(())
    }

    /// Number of receivers that are connected now.
    pub fn receivers(&mut self) -> u32 {
        // SAFETY: the source exists until this is dropped. With a time of 0 the call does not wait.
        u32::try_from(unsafe { (self.functions.receivers)(self.source, 0) }).unwrap_or(0)
    }
}

impl Drop for Source {
    fn drop(&mut self) {
        // SAFETY: the source is destroyed once, here, and nothing of the library is used afterwards.
        unsafe {
            (self.functions.destroy_source)(self.source);
            (self.functions.destroy)();
        }
    }
}

impl Functions {
    fn load() -> Result<Self, String> {
        let mut tried = Vec::new();
        for file in candidates(|name| std::env::var_os(name)) {
            // SAFETY: the library's initialisation is as trustworthy as the user who installed it.
            match unsafe { Library::new(&file) } {
                Ok(library) => return Self::of(library, &file),
                Err(error) => tried.push(format!("  {}", words(&error))),
            }
        }
        Err(format!(
            "NDI's library is not installed on this machine. It is no part of Cupola.\nInstall NDI's SDK or runtime \
             for Linux, version 6 or 5, from ndi.video. Name the folder of libndi.so.6 in NDI_RUNTIME_DIR_V6, or that \
             of libndi.so.5 in NDI_RUNTIME_DIR_V5, unless the system's linker finds it.\nCupola looked for\n{}",
            tried.join("\n")
        ))
    }

    fn of(library: Library, file: &OsString) -> Result<Self, String> {
        // The library may have threads of its own, so it stays loaded until the process ends.
        let library: &'static Library = Box::leak(Box::new(library));
        /// Searches a function.
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the type, that of a field of `Functions`, is the one that versions 5 and
                // 6 of the library declare for this name.
                *unsafe { library.get($name) }.map_err(|error| {
                    format!(
                        "{} lacks the function {} of NDI's versions 5 and 6; install NDI's SDK or runtime again ({})",
                        Path::new(file).display(),
                        $name,
                        words(&error)
                    )
                })?
            };
        }
        Ok(Self {
            initialize: function!("NDIlib_initialize"),
            destroy: function!("NDIlib_destroy"),
            create_source: function!("NDIlib_send_create"),
            destroy_source: function!("NDIlib_send_destroy"),
            send: function!("NDIlib_send_send_video_v2"),
            receivers: function!("NDIlib_send_get_no_connections"),
        })
    }
}

/// The linker's own words, which name the file.
fn words(error: &libloading::Error) -> String {
    error.source().map_or_else(|| error.to_string(), ToString::to_string)
}

/// Files that may be the library: those in the folders of the variables, and names for the linker.
fn candidates(variable: impl Fn(&str) -> Option<OsString>) -> Vec<OsString> {
    let in_folder = |(name, file): (&str, &str)| {
        let folder = variable(name).filter(|folder| !folder.is_empty())?;
        Some(Path::new(&folder).join(file).into_os_string())
    };
    FILES.into_iter().filter_map(in_folder).chain(FILES.map(|(_, file)| file.into())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_users_folders_come_first_and_the_newest_version() {
        let five = |name: &str| (name == "NDI_RUNTIME_DIR_V5").then(|| "/opt/ndi".into());
        assert_eq!(candidates(five), ["/opt/ndi/libndi.so.5", "libndi.so.6", "libndi.so.5"]);
        assert_eq!(candidates(|_| Some(OsString::new())), ["libndi.so.6", "libndi.so.5"]);
    }

    #[test]
    #[cfg(target_pointer_width = "64")]
    fn the_structures_have_the_sizes_of_the_c_ones() {
        assert_eq!((size_of::<Description>(), size_of::<Video>()), (24, 72));
        assert_eq!((std::mem::offset_of!(Video, time_code), std::mem::offset_of!(Video, data)), (32, 40));
    }
}

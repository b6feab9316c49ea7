//! The caller of a function: the program and its libraries, which get virtual time, or a part of
//! the system that waits for real devices.

use super::settings;
use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Prefixes of the names of libraries that get real time: Cupola, graphics drivers and their
/// loaders, connections to the display, sound and the system's services.
const REAL: [&str; 37] = [
    "libcupola",
    "libGL.",
    "libGLX",
    "libGLdispatch",
    "libOpenGL",
    "libGLES",
    "libEGL",
    "libglapi",
    "libgallium",
    "libLLVM",
    "libvulkan",
    "libVkLayer",
    "amdvlk",
    "libnvidia",
    "libcuda",
    "libdrm",
    "libgbm",
    "libX11",
    "libxcb",
    "libXext",
    "libXi.",
    "libXrandr",
    "libXfixes",
    "libXdamage",
    "libxshmfence",
    "libwayland",
    "libdecor",
    "libasound",
    "libpulse",
    "libpipewire",
    "libspa",
    "libjack",
    "libopenal",
    "libdbus",
    "libsystemd",
    "libudev",
    "libusb",
];

/// Prefixes of the names of libraries that get the program's time, but the real number of the
/// process. They tell it to others, who look for the process, or give them credentials: the bus of
/// the session, window managers, assistive technology, the parts of an MPI job.
const REAL_NUMBER: [&str; 28] = [
    "libgio-",
    "libglib-",
    "libgobject-",
    "libgdk",
    "libgtk",
    "libQt5",
    "libQt6",
    "libKF5",
    "libKF6",
    "libwx_",
    "libSDL",
    "libglfw",
    "libglut",
    "libSM.",
    "libICE.",
    "libXt.",
    "libatspi",
    "libatk-bridge",
    "libibus",
    "libpolkit",
    "libavahi",
    "libmpi",
    "libopen-rte",
    "libopen-pal",
    "libprrte",
    "libpmix",
    "libuc",
    "libfabric",
];

/// A caller that gets the program's time.
const TIME: usize = 1;
/// A caller that gets the number of the process that is the same in each run.
const NUMBER: usize = 2;

/// Verdicts so far: four times the address of a call, plus what the caller gets. Two addresses with
/// the same slot replace each other. A library that is loaded where another was unloaded gets the
/// verdict about that one.
static SEEN: [AtomicUsize; 1024] = [const { AtomicUsize::new(0) }; 1024];

/// True if a call that returns to `address` gets virtual time.
pub fn is_served(address: usize) -> bool {
    verdict(address) & TIME != 0
}

/// True if a call that returns to `address` gets the same number of the process in each run.
pub fn gets_number(address: usize) -> bool {
    verdict(address) & NUMBER != 0
}

/// What a call that returns to `address` gets.
fn verdict(address: usize) -> usize {
    if settings::settings().is_none() {
        return 0;
    }
    let slot = &SEEN[(address ^ (address >> 10)) % SEEN.len()];
    let seen = slot.load(Ordering::Relaxed);
    if seen >> 2 == address {
        return seen & (TIME | NUMBER);
    }
    let verdict = judge(address);
    slot.store(address << 2 | verdict, Ordering::Relaxed);
    verdict
}

/// What the library at `address` gets. Code outside of libraries is the program's.
fn judge(address: usize) -> usize {
    // SAFETY: asks the dynamic linker about an address; the answer's text is its own.
    let path = unsafe {
        let mut info: libc::Dl_info = std::mem::zeroed();
        if libc::dladdr(address as *const c_void, &mut info) == 0 || info.dli_fname.is_null() {
            return TIME | NUMBER;
        }
        CStr::from_ptr(info.dli_fname).to_bytes()
    };
    let name = path.rsplit(|byte| *byte == b'/').next().unwrap_or(path);
    let is_library = name.windows(3).any(|part| part == b".so");
    let is_driver = name.ends_with(b"_dri.so") || path.windows(5).any(|part| part == b"/dri/");
    let is_among = |names: &[&str]| is_library && names.iter().any(|begin| name.starts_with(begin.as_bytes()));
    if (is_library && is_driver) || is_among(&REAL) {
        0
    } else if is_among(&REAL_NUMBER) {
        TIME
    } else {
        TIME | NUMBER
    }
}

/// Exports functions of libc. Each passes its call on to a function here with one argument more:
/// the address to which the call returns. The number in front of a name is its number of arguments.
macro_rules! interpose {
    ($($arguments:tt $name:ident => $to:path;)*) => {$(
        /// As in libc.
        ///
        /// # Safety
        /// As in libc.
        #[unsafe(naked)]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name() {
            core::arch::naked_asm!(crate::caller::with_caller!($arguments), sym $to)
        }
    )*};
}

/// Code that adds the caller's address to the arguments.
#[cfg(target_arch = "x86_64")]
macro_rules! with_caller {
    (0) => {
        "mov rdi, qword ptr [rsp]\njmp {}"
    };
    (1) => {
        "mov rsi, qword ptr [rsp]\njmp {}"
    };
    (2) => {
        "mov rdx, qword ptr [rsp]\njmp {}"
    };
    (3) => {
        "mov rcx, qword ptr [rsp]\njmp {}"
    };
    (4) => {
        "mov r8, qword ptr [rsp]\njmp {}"
    };
    (5) => {
        "mov r9, qword ptr [rsp]\njmp {}"
    };
    (6) => {
        ".cfi_startproc\npush qword ptr [rsp]\n.cfi_adjust_cfa_offset 8\ncall {}\nadd rsp, 8\n\
         .cfi_adjust_cfa_offset -8\nret\n.cfi_endproc"
    };
    (7) => {
        ".cfi_startproc\nmov rax, qword ptr [rsp]\nmov r10, qword ptr [rsp + 8]\nsub rsp, 8\npush rax\npush r10\n\
         .cfi_adjust_cfa_offset 24\ncall {}\nadd rsp, 24\n.cfi_adjust_cfa_offset -24\nret\n.cfi_endproc"
    };
}

/// As above. All arguments are in registers; the last of eight is the eighth.
#[cfg(target_arch = "aarch64")]
macro_rules! with_caller {
    (0) => {
        "mov x0, x30\nb {}"
    };
    (1) => {
        "mov x1, x30\nb {}"
    };
    (2) => {
        "mov x2, x30\nb {}"
    };
    (3) => {
        "mov x3, x30\nb {}"
    };
    (4) => {
        "mov x4, x30\nb {}"
    };
    (5) => {
        "mov x5, x30\nb {}"
    };
    (6) => {
        "mov x6, x30\nb {}"
    };
    (7) => {
        "mov x7, x30\nb {}"
    };
}

pub(crate) use {interpose, with_caller};

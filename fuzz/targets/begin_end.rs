//! Begin/End and display lists on the null driver: each byte chooses a command, the next ones are its arguments.
//!
//! Arrays are given with exactly the length that OpenGL reads; the driver's functions read them whole.
#![no_main]

use cupola::backend::gl::driver::api::{self, Gl};
use cupola::backend::null;
use cupola::correct::LowerLeftRect;
use cupola::intercept::gl::context::current::set_driver;
use cupola::intercept::gl::context::registry;
use cupola::intercept::gl::entry::{contexts, table};
use cupola::intercept::gl::state::drawable::window::Window;
use std::collections::HashSet;
use std::ffi::{CStr, CString, c_void};
use std::sync::OnceLock;

/// How a command is called; numbers are bytes of arrays.
#[derive(Clone, Copy)]
enum Form {
    Nothing,
    /// Whole numbers.
    Numbers(usize),
    Floats(usize),
    /// Whole numbers, then an array.
    Array(usize, usize),
    /// `glNewList`.
    New,
    /// `glCallList`.
    Call,
    /// `glCallLists`.
    Lists,
}

struct Command {
    name: CString,
    form: Form,
    /// The hook.
    address: *const (),
}

// SAFETY: addresses of functions never change.
unsafe impl Sync for Command {}
// SAFETY: as above.
unsafe impl Send for Command {}

fn read<const BYTES: usize>(array: *const u8) {
    let mut copy = [0; BYTES];
    // SAFETY: OpenGL's callers give an array of so many bytes, which may be misaligned.
    unsafe { std::ptr::copy_nonoverlapping(array, copy.as_mut_ptr(), BYTES) };
    std::hint::black_box(copy);
}

extern "system" fn read_0<const BYTES: usize>(array: *const u8) {
    read::<BYTES>(array);
}

extern "system" fn read_1<const BYTES: usize>(_: u32, array: *const u8) {
    read::<BYTES>(array);
}

extern "system" fn read_2<const BYTES: usize>(_: u32, _: u32, array: *const u8) {
    read::<BYTES>(array);
}

macro_rules! readers {
    ($before:expr, $bytes:expr; $($size:literal)*) => {
        match ($before, $bytes) {
            $(
                (0, $size) => read_0::<$size> as *const c_void,
                (1, $size) => read_1::<$size> as *const c_void,
                (_, $size) => read_2::<$size> as *const c_void,
            )*
            _ => panic!("no driver's function for arrays of {} bytes", $bytes),
        }
    };
}

fn numbers(command: &[(&'static str, Form)]) -> Vec<(String, Form)> {
    command.iter().map(|(name, form)| ((*name).to_owned(), *form)).collect()
}

/// All commands with their forms, those with arrays by the registry's rules for names.
fn forms() -> Vec<(String, Form)> {
    use Form::{Array, Call, Floats, Lists, New, Nothing, Numbers};
    let mut all = numbers(&[
        ("glBegin", Numbers(1)),
        ("glEnd", Nothing),
        ("glNewList", New),
        ("glEndList", Nothing),
        ("glCallList", Call),
        ("glCallLists", Lists),
        ("glDeleteLists", Numbers(2)),
        ("glListBase", Numbers(1)),
        ("glMatrixMode", Numbers(1)),
        ("glPushMatrix", Nothing),
        ("glPopMatrix", Nothing),
        ("glLoadIdentity", Nothing),
        ("glPushAttrib", Numbers(1)),
        ("glPopAttrib", Nothing),
        ("glViewport", Numbers(4)),
        ("glScissor", Numbers(4)),
        ("glEnable", Numbers(1)),
        ("glDisable", Numbers(1)),
        ("glDrawBuffer", Numbers(1)),
        ("glReadBuffer", Numbers(1)),
        ("glClear", Numbers(1)),
        ("glUseProgram", Numbers(1)),
        ("glArrayElement", Numbers(1)),
        ("glDrawArrays", Numbers(3)),
        ("glRenderMode", Numbers(1)),
        ("glVertex2i", Numbers(2)),
        ("glVertex3f", Floats(3)),
        ("glColor4f", Floats(4)),
        ("glNormal3f", Floats(3)),
        ("glTexCoord2f", Floats(2)),
        ("glRectf", Floats(4)),
        ("glRasterPos3f", Floats(3)),
        ("glWindowPos2f", Floats(2)),
        ("glTranslatef", Floats(3)),
        ("glRotatef", Floats(4)),
        ("glLineWidth", Floats(1)),
        ("glPointSize", Floats(1)),
        ("glLoadMatrixf", Array(0, 64)),
        ("glMultMatrixd", Array(0, 128)),
        ("glMaterialfv", Array(2, 16)),
        ("glMaterialiv", Array(2, 16)),
        ("glEdgeFlagv", Array(0, 1)),
        ("glFogCoordfv", Array(0, 4)),
        ("glIndexdv", Array(0, 8)),
        ("glRasterPos4dv", Array(0, 32)),
        ("glVertexAttrib4Nubv", Array(1, 4)),
        ("glVertexAttribI4usv", Array(1, 8)),
        ("glVertexAttribL2dv", Array(1, 16)),
    ]);
    let sizes = [("b", 1), ("ub", 1), ("s", 2), ("us", 2), ("i", 4), ("ui", 4), ("f", 4), ("d", 8)];
    let families: [(&str, usize, &[usize], &[&str]); 7] = [
        ("glVertex", 0, &[2, 3, 4], &["s", "i", "f", "d"]),
        ("glColor", 0, &[3, 4], &["b", "ub", "s", "us", "i", "ui", "f", "d"]),
        ("glSecondaryColor", 0, &[3], &["b", "ub", "s", "us", "i", "ui", "f", "d"]),
        ("glNormal", 0, &[3], &["b", "s", "i", "f", "d"]),
        ("glTexCoord", 0, &[1, 2, 3, 4], &["s", "i", "f", "d"]),
        ("glMultiTexCoord", 1, &[1, 2, 3, 4], &["s", "i", "f", "d"]),
        ("glVertexAttrib", 1, &[1, 2, 3, 4], &["s", "f", "d"]),
    ];
    for (family, before, counts, types) in families {
        for count in counts {
            for kind in types {
                let size = sizes.iter().find(|(name, _)| name == kind).expect("a type").1;
                all.push((format!("{family}{count}{kind}v"), Array(before, count * size)));
            }
        }
    }
    all
}

/// The driver's functions: those that read arrays, one that says it has the compatibility profile, and the null driver's.
fn find(name: &CStr) -> *const c_void {
    let arrays = forms().into_iter().find(|(known, _)| known.as_bytes() == name.to_bytes());
    match arrays {
        Some((_, Form::Array(before, bytes))) => readers!(before, bytes; 1 2 3 4 6 8 12 16 24 32 64 128),
        _ if name == c"glGetIntegerv" => get_integerv as *const c_void,
        _ if name == c"glGenLists" => gen_lists as *const c_void,
        _ => null::find(name),
    }
}

extern "system" fn gen_lists(_: i32) -> u32 {
    100_000
}

extern "system" fn get_integerv(name: u32, values: *mut i32) {
    let address = null::find(c"glGetIntegerv");
    // SAFETY: the null driver's function has this signature, and OpenGL's callers give room for the values.
    unsafe {
        let real: extern "system" fn(u32, *mut i32) = std::mem::transmute(address);
        real(name, values);
        if name == api::GL_CONTEXT_PROFILE_MASK {
            *values = api::GL_CONTEXT_COMPATIBILITY_PROFILE_BIT as i32;
        }
    }
}

unsafe extern "system" fn query(_: *mut c_void, _: *mut c_void, what: i32, value: *mut i32) -> u32 {
    // SAFETY: room for one number, as EGL's callers give.
    unsafe { *value = if what == 0x3057 { 64 } else { 48 } };
    1
}

struct Setup {
    gl: &'static Gl,
    commands: Vec<Command>,
}

fn setup() -> &'static Setup {
    static SETUP: OnceLock<Setup> = OnceLock::new();
    SETUP.get_or_init(|| {
        // SAFETY: the process has one thread yet.
        unsafe { std::env::set_var("CUPOLA_CACHE", "0") };
        let gl: &'static Gl = Box::leak(Box::new(Gl::load(find)));
        set_driver(gl);
        let commands = forms().into_iter().filter_map(|(name, form)| {
            let address = table::find(&name)?;
            Some(Command { name: CString::new(name).expect("a name"), form, address })
        });
        Setup { gl, commands: commands.collect() }
    })
}

/// Arguments out of the input; zeros behind its end.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.byte().unwrap_or_default()).collect()
    }

    /// Mostly a small number or a constant of OpenGL's, sometimes any.
    fn number(&mut self) -> u32 {
        const NAMES: [u32; 16] = [
            api::GL_COMPILE,
            api::GL_COMPILE_AND_EXECUTE,
            api::GL_UNSIGNED_INT,
            api::GL_FLOAT,
            api::GL_PROJECTION,
            api::GL_MODELVIEW,
            api::GL_TEXTURE,
            api::GL_SCISSOR_TEST,
            api::GL_FRONT,
            api::GL_BACK,
            api::GL_TEXTURE0 + 1,
            api::GL_AMBIENT,
            api::GL_SHININESS,
            api::GL_COLOR_BUFFER_BIT | api::GL_DEPTH_BUFFER_BIT,
            api::GL_ALL_ATTRIB_BITS,
            api::GL_FRONT_AND_BACK,
        ];
        match self.byte().unwrap_or_default() {
            small @ 0..=127 => u32::from(small),
            name @ 128..=191 => NAMES[usize::from(name & 15)],
            _ => u32::from_le_bytes(std::array::from_fn(|_| self.byte().unwrap_or_default())),
        }
    }

    fn float(&mut self) -> f32 {
        match self.byte().unwrap_or_default() {
            small @ 0..=239 => f32::from(small) / 64.0 - 1.0,
            _ => f32::from_le_bytes(std::array::from_fn(|_| self.byte().unwrap_or_default())),
        }
    }
}

macro_rules! calls {
    ($address:expr, $count:expr, $next:expr, $type:ty; $($n:literal ($($t:ty),*);)*) => {
        match $count {
            $( $n => {
                // SAFETY: the hook of a command with so many arguments of this type.
                let call: unsafe extern "system" fn($($t),*) = unsafe { std::mem::transmute($address) };
                // SAFETY: as above.
                unsafe { call($({ let value: $t = $next; value }),*) }
            } )*
            _ => unreachable!(),
        }
    };
}

/// Which lists call which: lists that call each other take time without end, with and without Cupola.
#[derive(Default)]
struct Lists {
    compiled: u32,
    call: HashSet<u32>,
    called: HashSet<u32>,
}

impl Lists {
    /// Whether `list` may be called here: from outside, or by a list that no other calls if it calls none itself.
    fn may_call(&mut self, list: u32) -> bool {
        let own = self.compiled;
        let allowed = own == 0 || (list != own && !self.call.contains(&list) && !self.called.contains(&own));
        if own != 0 && allowed {
            self.call.insert(own);
            self.called.insert(list);
        }
        allowed
    }
}

fn run(command: &Command, input: &mut Input, lists: &mut Lists) {
    let address = command.address;
    if command.name.as_c_str() == c"glEndList" {
        lists.compiled = 0;
    }
    match command.form {
        Form::New => {
            let (list, mode) = (input.number(), input.number());
            if lists.compiled == 0 {
                lists.compiled = list;
            }
            // SAFETY: a command with these arguments.
            unsafe { std::mem::transmute::<_, unsafe extern "system" fn(u32, u32)>(address)(list, mode) };
        }
        Form::Call => {
            let list = input.number();
            if lists.may_call(list) {
                // SAFETY: a command with this argument.
                unsafe { std::mem::transmute::<_, unsafe extern "system" fn(u32)>(address)(list) };
            }
        }
        Form::Lists if lists.compiled != 0 => {}
        Form::Nothing => {
            // SAFETY: a command without arguments.
            let call: unsafe extern "system" fn() = unsafe { std::mem::transmute(address) };
            // SAFETY: as above.
            unsafe { call() };
        }
        Form::Numbers(count) => {
            calls!(address, count, input.number(), u32; 1 (u32); 2 (u32, u32); 3 (u32, u32, u32); 4 (u32, u32, u32, u32);)
        }
        Form::Floats(count) => {
            calls!(address, count, input.float(), f32; 1 (f32); 2 (f32, f32); 3 (f32, f32, f32); 4 (f32, f32, f32, f32);)
        }
        Form::Array(before, length) => {
            let numbers = [(); 2].map(|()| input.number());
            let array = input.bytes(length).into_boxed_slice();
            // SAFETY: commands with so many numbers before an array, which has as many bytes as they read.
            unsafe {
                match before {
                    0 => std::mem::transmute::<_, unsafe extern "system" fn(*const u8)>(address)(array.as_ptr()),
                    1 => {
                        let call: unsafe extern "system" fn(u32, *const u8) = std::mem::transmute(address);
                        call(numbers[0], array.as_ptr());
                    }
                    _ => {
                        let call: unsafe extern "system" fn(u32, u32, *const u8) = std::mem::transmute(address);
                        call(numbers[0], numbers[1], array.as_ptr());
                    }
                }
            }
        }
        Form::Lists => {
            let (count, kind) = (i32::from(input.byte().unwrap_or_default() as i8 / 8), input.number());
            let array = input.bytes(4 * count.max(0) as usize).into_boxed_slice();
            // SAFETY: each of the offsets has four bytes at most.
            unsafe {
                let call: unsafe extern "system" fn(i32, u32, *const u8) = std::mem::transmute(address);
                call(count, kind, array.as_ptr());
            }
        }
    }
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Setup { gl, commands } = setup();
    let mut input = Input(bytes);
    let Some(kind) = input.byte() else { return };
    null::reset(LowerLeftRect::of_size((64, 48)));
    // Planning the views of a window takes a thousand times as long as most commands.
    let window = Window::Egl { display: 1, surface: 1, x11: None, query: query as *const () as usize };
    contexts::make_current(1, gl, (kind & 7 == 0).then_some(window), false);
    let (mut left, mut lists) = (4096, Lists::default());
    while let Some(number) = input.byte() {
        let command = &commands[usize::from(number) % commands.len()];
        if std::env::var_os("FUZZ_TRACE").is_some() {
            eprintln!("{:?}", command.name);
        }
        run(command, &mut input, &mut lists);
        left -= 1;
        if left == 0 {
            break;
        }
    }
    contexts::make_current(0, gl, None, false);
    registry::destroyed(1);
});

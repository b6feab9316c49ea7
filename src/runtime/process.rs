//! Processes that belong together: signals passed on, and helpers that end with their parent.
//!
//! Safe fronts of what the standard library has no safe form of, for the `cupola` command.

use std::io;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus};
use std::sync::atomic::{AtomicI32, Ordering};

/// The process that signals are passed on to; 0 = none.
static PROGRAM: AtomicI32 = AtomicI32::new(0);

/// Signals that would end this process and are the program's to decide about.
const PASSED_ON: [libc::c_int; 4] = [libc::SIGINT, libc::SIGQUIT, libc::SIGTERM, libc::SIGHUP];

/// Makes `command` receive SIGTERM when the thread that spawns it ends, however it ends.
pub fn end_with_parent(command: &mut Command) -> &mut Command {
    let parent = std::process::id();
    let request = move || {
        // SAFETY: prctl and getppid take and return plain integers here and are safe to call between fork and exec.
        let failed = unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGTERM as libc::c_ulong) } != 0;
        if failed {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: as above. The parent may have ended before the request.
        if unsafe { libc::getppid() } as u32 != parent {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        Ok(())
    };
    // SAFETY: the closure only makes system calls and neither allocates nor takes locks.
    unsafe { command.pre_exec(request) }
}

/// Sends SIGTERM to a child that has not been waited for.
///
/// # Errors
/// What the system says, for example that the child belongs to another user by now.
pub fn terminate(child: &Child) -> io::Result<()> {
    // SAFETY: kill takes plain integers; the id is the child's, since it has not been waited for.
    match unsafe { libc::kill(child.id() as libc::pid_t, libc::SIGTERM) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Spawns `command` and waits for it. SIGINT, SIGQUIT, SIGTERM and SIGHUP no longer end this process
/// (for its remaining life) but are passed on, so that it outlives the program and can tidy up. Signals
/// of the terminal reach the program by themselves and are not sent twice.
///
/// # Errors
/// [`io::ErrorKind::NotFound`] and the like if the program cannot be started.
pub fn run_in_foreground(command: &mut Command) -> io::Result<ExitStatus> {
    for signal in PASSED_ON {
        // SAFETY: all zeroes is a valid sigaction: no flags, an empty mask.
        let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
        action.sa_sigaction = pass_on as *const () as libc::sighandler_t;
        action.sa_flags = libc::SA_SIGINFO | libc::SA_RESTART;
        // SAFETY: `action` lives during the call, its handler has the three-argument form that the flags announce.
        if unsafe { libc::sigaction(signal, &action, std::ptr::null_mut()) } != 0 {
            return Err(io::Error::last_os_error());
        }
    }
    let mut child = command.spawn()?;
    PROGRAM.store(child.id() as i32, Ordering::SeqCst);
    let status = child.wait();
    PROGRAM.store(0, Ordering::SeqCst);
    status
}

/// Handler of signals: sends what another process sent on to the program.
extern "C" fn pass_on(signal: libc::c_int, info: *mut libc::siginfo_t, _context: *mut libc::c_void) {
    let program = PROGRAM.load(Ordering::SeqCst);
    // SAFETY: the kernel passes a valid `info` to a handler installed with SA_SIGINFO.
    let from_process = unsafe { (*info).si_code } <= 0;
    if program > 0 && from_process {
        // SAFETY: kill is async-signal-safe and takes plain integers. The signal's sender could have sent it itself.
        unsafe { libc::kill(program, signal) };
    }
}

/// What the linker wrote into this library, or the program that it is a part of, to tell its content from any other; `None` where it
/// wrote nothing.
pub fn build_id() -> Option<Vec<u8>> {
    /// The kind of note, and whose it is.
    const NT_GNU_BUILD_ID: u32 = 3;
    const OWNER: &[u8] = b"GNU\0";

    struct Search {
        inside: usize,
        found: Option<Vec<u8>>,
    }

    /// Of one loaded object: not 0 ends the search.
    ///
    /// # Safety
    /// As `dl_iterate_phdr` calls it, with a [`Search`].
    unsafe extern "C" fn look(info: *mut libc::dl_phdr_info, _size: usize, search: *mut libc::c_void) -> libc::c_int {
        // SAFETY: as promised; nobody else has them meanwhile.
        let (info, search) = unsafe { (&*info, &mut *search.cast::<Search>()) };
        if info.dlpi_phdr.is_null() {
            return 0;
        }
        // SAFETY: the object has so many program headers.
        let headers = unsafe { std::slice::from_raw_parts(info.dlpi_phdr, usize::from(info.dlpi_phnum)) };
        let start = |header: &libc::Elf64_Phdr| (info.dlpi_addr as usize).wrapping_add(header.p_vaddr as usize);
        let holds = |header: &libc::Elf64_Phdr| {
            header.p_type == libc::PT_LOAD && search.inside.wrapping_sub(start(header)) < header.p_memsz as usize
        };
        if !headers.iter().any(holds) {
            return 0;
        }
        for header in headers.iter().filter(|header| header.p_type == libc::PT_NOTE) {
            // SAFETY: notes are loaded, and so many bytes long.
            let notes = unsafe { std::slice::from_raw_parts(start(header) as *const u8, header.p_memsz as usize) };
            search.found = search.found.take().or_else(|| note(notes, NT_GNU_BUILD_ID, OWNER));
        }
        1
    }

    let mut search = Search { inside: look as *const () as usize, found: None };
    // SAFETY: `look` takes what it is given here; `search` outlives the call.
    unsafe { libc::dl_iterate_phdr(Some(look), (&raw mut search).cast()) };
    search.found
}

/// The content of the first note of a kind and an owner: each is three numbers, the owner's name and the content, both filled up to a
/// multiple of four bytes.
fn note(mut notes: &[u8], kind: u32, owner: &[u8]) -> Option<Vec<u8>> {
    loop {
        let (header, rest) = notes.split_at_checked(12)?;
        let (numbers, _) = header.as_chunks::<4>();
        let [name, content, found] = [0, 1, 2].map(|place: usize| u32::from_ne_bytes(numbers[place]) as usize);
        let (whose, rest) = rest.split_at_checked(name.next_multiple_of(4))?;
        let what = rest.get(..content)?;
        if found == kind as usize && whose.get(..name) == Some(owner) {
            return Some(what.to_vec());
        }
        notes = rest.get(content.next_multiple_of(4)..)?;
    }
}

#[cfg(test)]
mod tests {
    use super::note;

    #[test]
    fn notes_are_found_and_damaged_ones_are_not() {
        let made = |name: &[u8], content: &[u8], kind: u32| {
            let mut bytes: Vec<u8> =
                [name.len() as u32, content.len() as u32, kind].iter().flat_map(|n| n.to_ne_bytes()).collect();
            for part in [name, content] {
                bytes.extend_from_slice(part);
                bytes.resize(bytes.len().next_multiple_of(4), 0);
            }
            bytes
        };
        let notes = [made(b"GNU\0", &[1], 5), made(b"X\0", &[2, 3], 3), made(b"GNU\0", &[4, 5, 6, 7, 8], 3)].concat();
        assert_eq!(note(&notes, 3, b"GNU\0"), Some(vec![4, 5, 6, 7, 8]));
        assert_eq!(note(&notes, 4, b"GNU\0"), None);
        for length in 0..notes.len() - 3 {
            assert_eq!(note(&notes[..length], 3, b"GNU\0"), None, "{length}");
        }
        let mut endless = notes;
        endless[..4].copy_from_slice(&u32::MAX.to_ne_bytes());
        assert_eq!(note(&endless, 3, b"GNU\0"), None);
    }
}

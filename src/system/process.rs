//! Processes that belong together: signals passed on, and helpers that end with their parent.
//!
//! Safe functions for the `cupola` command that the standard library lacks.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::io;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::time::{Duration, Instant};

/// Number of the user.
pub fn user() -> u32 {
    // SAFETY: returns a number.
    unsafe { libc::getuid() }
}

/// True if this program has more rights than the user who started it, as set-user-ID programs have.
/// Then the user's environment is ignored.
pub fn is_privileged() -> bool {
    // SAFETY: reads a number that the kernel gave to this process.
    unsafe { libc::getauxval(libc::AT_SECURE) != 0 }
}

/// Environment variable of this name, as text; `None` for a program that [`is_privileged`].
pub fn variable(name: &str) -> Option<OsString> {
    if is_privileged() { None } else { std::env::var_os(name) }
}

/// Folder of the user's profiles; `None` if neither `XDG_CONFIG_HOME` nor `HOME` is set.
pub fn profile_folder() -> Option<PathBuf> {
    let absolute = |name: &str| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let config = absolute("XDG_CONFIG_HOME").or_else(|| Some(absolute("HOME")?.join(".config")))?;
    Some(config.join("cupola/profiles"))
}

/// Host name of this machine; empty if it has none.
pub fn host_name() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname").map_or_else(|_| String::new(), |name| name.trim().to_owned())
}

/// File name of this process' program; empty if the system does not report it.
pub fn program_name() -> String {
    let file = std::env::current_exe().unwrap_or_default();
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// File names of the libraries that this process has loaded by now, each once; empty if the system
/// does not report them.
pub fn loaded_libraries() -> Vec<String> {
    let maps = std::fs::read("/proc/self/maps").unwrap_or_default();
    let text = String::from_utf8_lossy(&maps);
    let names = text.lines().filter_map(|line| line.split_once('/')?.1.rsplit('/').next());
    let libraries: BTreeSet<&str> = names.filter(|name| name.contains(".so")).collect();
    libraries.into_iter().map(str::to_owned).collect()
}

/// Process to which signals are passed on; 0 = none.
static PROGRAM: AtomicI32 = AtomicI32::new(0);

/// Signals that would end this process, and about which the program decides.
const PASSED_ON: [libc::c_int; 4] = [libc::SIGINT, libc::SIGQUIT, libc::SIGTERM, libc::SIGHUP];

/// Makes `command` receive SIGTERM when the thread that spawns it ends, however it ends.
pub fn end_with_parent(command: &mut Command) -> &mut Command {
    let parent = std::process::id();
    let request = move || {
        // SAFETY: prctl and getppid take and return plain integers here and are safe to call
        // between fork and exec.
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

/// Does some work with less right to the processors than other programs, as `nice` gives it, and
/// waits for the result. Processes that this thread starts later are not affected.
pub fn in_background<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    /// Smaller than 19, so that a busy machine still does the work at once.
    const NICE: libc::c_int = 10;
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            // SAFETY: takes numbers; 0 is the calling thread, which only does this work.
            unsafe {
                let now = libc::getpriority(libc::PRIO_PROCESS, 0);
                libc::setpriority(libc::PRIO_PROCESS, 0, now.max(NICE))
            };
            work()
        });
        worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Makes sleeps of this thread end within about a microsecond; the system's usual tolerance is
/// 50 µs.
pub fn sleep_precisely() {
    // SAFETY: prctl takes plain integers here. If it fails, sleeps are as usual.
    unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, 1000 as libc::c_ulong) };
}

/// Keeps `command` from being ended when it writes to a pipe without a reader.
pub fn without_broken_pipes(command: &mut Command) -> &mut Command {
    let request = || {
        // SAFETY: takes plain numbers, and is safe to call between fork and exec. What is ignored
        // stays so in the program.
        unsafe { libc::signal(libc::SIGPIPE, libc::SIG_IGN) };
        Ok(())
    };
    // SAFETY: the closure only makes a system call and neither allocates nor takes locks.
    unsafe { command.pre_exec(request) }
}

/// Makes the system place the program's memory at the same addresses in each run, if it permits
/// that: programs sort by addresses, and use them as random numbers.
pub fn with_fixed_addresses(command: &mut Command) -> &mut Command {
    let request = || {
        // SAFETY: takes and returns plain numbers. What is refused stays as it is.
        unsafe {
            let now = libc::personality(0xffff_ffff);
            if now >= 0 {
                libc::personality((now | libc::ADDR_NO_RANDOMIZE) as libc::c_ulong);
            }
        }
        Ok(())
    };
    // SAFETY: the closure only makes system calls and neither allocates nor takes locks.
    unsafe { command.pre_exec(request) }
}

/// Sends SIGTERM to a child that has not been waited for.
///
/// # Errors
/// Those of the system, for example that the child belongs to another user by now.
pub fn terminate(child: &Child) -> io::Result<()> {
    // SAFETY: kill takes plain integers; the id is the child's, since it has not been waited for.
    match unsafe { libc::kill(child.id() as libc::pid_t, libc::SIGTERM) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Kills the process group of a child that was started with `process_group(0)` and has not been
/// waited for.
///
/// # Errors
/// Those of the system, for example that no process of the group is left.
pub fn kill_group(child: &Child) -> io::Result<()> {
    // SAFETY: killpg takes plain integers; the group has the child's id, which is in use until the
    // child has been waited for.
    match unsafe { libc::killpg(child.id() as libc::pid_t, libc::SIGKILL) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// True if a signal that would end this process has come since [`note_end_signals`] or
/// [`run_in_foreground`].
static END_ASKED_FOR: AtomicBool = AtomicBool::new(false);

/// Keeps SIGINT, SIGTERM and SIGHUP from ending this process: [`end_was_asked_for`] reports that
/// one has come.
pub fn note_end_signals() {
    extern "C" fn note(_signal: libc::c_int) {
        END_ASKED_FOR.store(true, Ordering::SeqCst);
    }
    for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
        // SAFETY: the handler only stores to an atomic, which is async-signal-safe.
        unsafe { libc::signal(signal, note as *const () as libc::sighandler_t) };
    }
}

/// True if a signal has asked this process to end.
pub fn end_was_asked_for() -> bool {
    END_ASKED_FOR.load(Ordering::SeqCst)
}

/// End of a program.
#[derive(Clone, Copy, Debug)]
pub enum Ended {
    /// The program ended by itself, or by a signal of another process.
    ByItself(ExitStatus),
    /// The program was stopped at its limit.
    Stopped,
}

/// Spawns `command` and waits for it, for no longer than `limit`. SIGINT, SIGQUIT, SIGTERM and
/// SIGHUP no longer end this process (for its remaining life) but are passed on, so that it
/// outlives the program and can tidy up. Signals of the terminal reach the program by themselves
/// and are not sent twice.
///
/// # Errors
/// [`io::ErrorKind::NotFound`] and the like if the program cannot be started.
pub fn run_in_foreground(command: &mut Command, limit: Option<Duration>) -> io::Result<Ended> {
    for signal in PASSED_ON {
        // SAFETY: all zeroes is a valid sigaction: no flags, an empty mask.
        let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
        action.sa_sigaction = pass_on as *const () as libc::sighandler_t;
        action.sa_flags = libc::SA_SIGINFO | libc::SA_RESTART;
        // SAFETY: `action` lives during the call, its handler has the three-argument form that the
        // flags announce.
        if unsafe { libc::sigaction(signal, &action, std::ptr::null_mut()) } != 0 {
            return Err(io::Error::last_os_error());
        }
    }
    let mut child = command.spawn()?;
    PROGRAM.store(child.id() as i32, Ordering::SeqCst);
    let ended = match limit {
        None => child.wait().map(Ended::ByItself),
        Some(limit) => wait_or_stop(&mut child, limit),
    };
    PROGRAM.store(0, Ordering::SeqCst);
    if STOPPED.swap(false, Ordering::SeqCst) { ended.map(|_| Ended::Stopped) } else { ended }
}

/// True if the program of [`run_in_foreground`] was asked to end by [`stop_foreground`].
static STOPPED: AtomicBool = AtomicBool::new(false);

/// Ends the program of [`run_in_foreground`] with the processes that it started, if it runs: by
/// SIGTERM, and by SIGKILL if it does not end then. It counts as stopped.
pub fn stop_foreground() {
    let program = PROGRAM.load(Ordering::SeqCst);
    let Ok(id) = u32::try_from(program) else { return };
    if id == 0 || STOPPED.swap(true, Ordering::SeqCst) {
        return;
    }
    let family = family_of(id);
    send_to(&family, libc::SIGTERM);
    std::thread::spawn(move || {
        std::thread::sleep(GRACE);
        // Otherwise it has been waited for, and the numbers may be those of others.
        if PROGRAM.load(Ordering::SeqCst) == program {
            send_to(&family, libc::SIGKILL);
        }
    });
}

/// Time that a program has after SIGTERM.
const GRACE: Duration = Duration::from_secs(5);

/// A process, and those that it has started.
fn family_of(id: u32) -> Vec<u32> {
    let mut family = vec![id];
    add_descendants(id, &mut family);
    family
}

/// Sends a signal to processes; 0 only asks. Returns how many are there.
fn send_to(family: &[u32], signal: libc::c_int) -> usize {
    // SAFETY: kill takes plain integers; a process that ended meanwhile is at worst not there.
    family.iter().filter(|id| unsafe { libc::kill(**id as libc::pid_t, signal) } == 0).count()
}

/// Waits for a child. After `limit` the child and the processes that it started get SIGTERM. Those
/// that do not end then get SIGKILL.
fn wait_or_stop(child: &mut Child, limit: Duration) -> io::Result<Ended> {
    const STEP: Duration = Duration::from_millis(20);
    let started = Instant::now();
    while started.elapsed() < limit {
        if let Some(status) = child.try_wait()? {
            return Ok(Ended::ByItself(status));
        }
        std::thread::sleep(STEP);
    }
    let family = family_of(child.id());
    send_to(&family, libc::SIGTERM);
    let stopped = Instant::now();
    // A child that has ended, and was waited for, no longer exists.
    while child.try_wait()?.is_none() || send_to(&family, 0) > 0 {
        if stopped.elapsed() > GRACE {
            send_to(&family, libc::SIGKILL);
            child.wait()?;
            break;
        }
        std::thread::sleep(STEP);
    }
    Ok(Ended::Stopped)
}

/// Adds the processes that `parent` started, and those that they started.
fn add_descendants(parent: u32, family: &mut Vec<u32>) {
    let threads = std::fs::read_dir(format!("/proc/{parent}/task")).into_iter().flatten().flatten();
    let children = threads.filter_map(|thread| std::fs::read_to_string(thread.path().join("children")).ok());
    let children: Vec<u32> = children
        .flat_map(|text| text.split_whitespace().filter_map(|id| id.parse().ok()).collect::<Vec<_>>())
        .collect();
    for child in children {
        family.push(child);
        add_descendants(child, family);
    }
}

/// Signal handler: passes signals of other processes on to the program.
extern "C" fn pass_on(signal: libc::c_int, info: *mut libc::siginfo_t, _context: *mut libc::c_void) {
    if signal != libc::SIGQUIT {
        END_ASKED_FOR.store(true, Ordering::SeqCst);
    }
    let program = PROGRAM.load(Ordering::SeqCst);
    // SAFETY: the kernel passes a valid `info` to a handler installed with SA_SIGINFO.
    let from_process = unsafe { (*info).si_code } <= 0;
    if program > 0 && from_process {
        // SAFETY: kill is async-signal-safe and takes plain integers. The signal's sender could
        // have sent it itself.
        unsafe { libc::kill(program, signal) };
    }
}

#[cfg(test)]
mod tests {
    use super::{is_privileged, variable};

    /// The kernel's number for this process, as `/proc` has it: pairs of words.
    #[test]
    fn rights_are_those_that_the_kernel_says() {
        const AT_SECURE: u64 = 23;
        let bytes = std::fs::read("/proc/self/auxv").expect("this process");
        let (words, _) = bytes.as_chunks::<8>();
        let words: Vec<u64> = words.iter().map(|word| u64::from_ne_bytes(*word)).collect();
        let (pairs, _) = words.as_chunks::<2>();
        let [_, secure] = pairs.iter().find(|[kind, _]| *kind == AT_SECURE).expect("Linux says it");
        assert_eq!(is_privileged(), *secure != 0);
        assert_eq!(variable("PATH").is_some(), !is_privileged());
    }
}

//! Memory that processes share through a file.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

/// A file in memory. Other processes may change it at any time: its words are atomic.
pub struct SharedMemory {
    words: NonNull<AtomicU64>,
    count: usize,
    file: File,
}

// SAFETY: the memory is reached by atomic words alone, and unmapped when nobody borrows it.
unsafe impl Send for SharedMemory {}
// SAFETY: as above.
unsafe impl Sync for SharedMemory {}

impl SharedMemory {
    /// Creates a file of `bytes` zeroes (rounded up to whole words) that only its user can open.
    /// The space is reserved, so that later writes cannot fail for lack of it.
    ///
    /// # Errors
    /// Errors of the system: a file of this name exists, its folder does not exist or is full.
    pub fn create(path: &Path, bytes: usize) -> io::Result<Self> {
        let count = bytes.div_ceil(size_of::<u64>());
        let length = libc::off_t::try_from(count * size_of::<u64>()).map_err(|_| io::ErrorKind::InvalidInput)?;
        let file = OpenOptions::new().read(true).write(true).create_new(true).mode(0o600).open(path)?;
        // SAFETY: takes plain integers.
        let made = match unsafe { libc::posix_fallocate(file.as_raw_fd(), 0, length) } {
            0 => Self::map(file, count),
            error => Err(io::Error::from_raw_os_error(error)),
        };
        made.inspect_err(|_| drop(std::fs::remove_file(path)))
    }

    /// Opens a file that another process created.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        let count = usize::try_from(file.metadata()?.len()).unwrap_or(0) / size_of::<u64>();
        Self::map(file, count)
    }

    fn map(file: File, count: usize) -> io::Result<Self> {
        if count == 0 {
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the file is empty"));
        }
        let (access, descriptor) = (libc::PROT_READ | libc::PROT_WRITE, file.as_raw_fd());
        // SAFETY: maps new pages of an open file; nothing else lies there.
        let address = unsafe {
            libc::mmap(std::ptr::null_mut(), count * size_of::<u64>(), access, libc::MAP_SHARED, descriptor, 0)
        };
        match NonNull::new(address.cast()) {
            Some(words) if address != libc::MAP_FAILED => Ok(Self { words, count, file }),
            _ => Err(io::Error::last_os_error()),
        }
    }

    /// Words of the memory, each as a process last wrote it.
    pub fn words(&self) -> &[AtomicU64] {
        // SAFETY: so many words are mapped for as long as this lives, and zeroes are atomics.
        unsafe { std::slice::from_raw_parts(self.words.as_ptr(), self.count) }
    }

    /// Copies `bytes` to the word with this index and those after it. An incomplete last word is
    /// filled with zeroes.
    ///
    /// # Panics
    /// If they reach beyond the memory.
    pub fn write(&self, word: usize, bytes: &[u8]) {
        self.write_or(word, bytes, 0);
    }

    /// As [`SharedMemory::write`], with the bits of `set` set in each word.
    ///
    /// # Panics
    /// As for [`SharedMemory::write`].
    pub fn write_or(&self, word: usize, bytes: &[u8], set: u64) {
        let (whole, rest) = bytes.as_chunks::<8>();
        let (to, last) = self.words()[word..].split_at(whole.len());
        for (to, from) in to.iter().zip(whole) {
            to.store(u64::from_ne_bytes(*from) | set, Ordering::Relaxed);
        }
        if !rest.is_empty() {
            let mut padded = [0; 8];
            padded[..rest.len()].copy_from_slice(rest);
            last[0].store(u64::from_ne_bytes(padded) | set, Ordering::Relaxed);
        }
    }

    /// Copies the memory to `bytes`, from the word with this index on.
    ///
    /// # Panics
    /// If they reach beyond the memory.
    pub fn read(&self, word: usize, bytes: &mut [u8]) {
        let (whole, rest) = bytes.as_chunks_mut::<8>();
        let (from, last) = self.words()[word..].split_at(whole.len());
        for (to, from) in whole.iter_mut().zip(from) {
            *to = from.load(Ordering::Relaxed).to_ne_bytes();
        }
        if !rest.is_empty() {
            rest.copy_from_slice(&last[0].load(Ordering::Relaxed).to_ne_bytes()[..rest.len()]);
        }
    }

    /// Takes a lock on the byte at this position of the file, unless another opener has it. The
    /// lock ends with this value, or with the process.
    pub fn lock(&self, byte: usize) -> bool {
        self.ask(libc::F_OFD_SETLK, libc::F_WRLCK, byte).is_some()
    }

    /// Releases the lock.
    pub fn unlock(&self, byte: usize) {
        self.ask(libc::F_OFD_SETLK, libc::F_UNLCK, byte);
    }

    /// True if another opener of the file has the lock on this byte.
    pub fn is_locked(&self, byte: usize) -> bool {
        let found = self.ask(libc::F_OFD_GETLK, libc::F_WRLCK, byte);
        found.is_some_and(|found| i32::from(found.l_type) != libc::F_UNLCK)
    }

    fn ask(&self, command: libc::c_int, kind: libc::c_int, byte: usize) -> Option<libc::flock> {
        // SAFETY: all zeroes is a valid structure of plain integers.
        let mut range: libc::flock = unsafe { std::mem::zeroed() };
        range.l_type = kind as libc::c_short;
        range.l_whence = libc::SEEK_SET as libc::c_short;
        range.l_start = libc::off_t::try_from(byte).ok()?;
        range.l_len = 1;
        // SAFETY: an open file, and a structure that lives during the call.
        (unsafe { libc::fcntl(self.file.as_raw_fd(), command, &raw mut range) } != -1).then_some(range)
    }

    /// Waits while the low half of the word with this index is `value`, for no longer than `limit`.
    /// May also return early.
    pub fn wait(&self, word: usize, value: u32, limit: Duration) {
        let time = libc::timespec {
            tv_sec: libc::time_t::try_from(limit.as_secs()).unwrap_or(libc::time_t::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        let half = self.low_half(word);
        // SAFETY: a word of the memory that lives during the call, and a time.
        unsafe { libc::syscall(libc::SYS_futex, half, libc::FUTEX_WAIT, value, &raw const time) };
    }

    /// Wakes the threads that wait for the word with this index.
    pub fn wake(&self, word: usize) {
        // SAFETY: as above.
        unsafe { libc::syscall(libc::SYS_futex, self.low_half(word), libc::FUTEX_WAKE, libc::c_int::MAX) };
    }

    fn low_half(&self, word: usize) -> *const AtomicU32 {
        let half = (&raw const self.words()[word]).cast::<AtomicU32>();
        if cfg!(target_endian = "little") { half } else { half.wrapping_add(1) }
    }
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        // SAFETY: the mapping of `map`, which nobody borrows any more.
        unsafe { libc::munmap(self.words.as_ptr().cast(), self.count * size_of::<u64>()) };
    }
}

#[cfg(test)]
mod tests {
    use super::SharedMemory;
    use std::path::PathBuf;
    use std::sync::atomic::Ordering;
    use std::time::{Duration, Instant};

    fn path(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("cupola-shared-{name}-{}", std::process::id()))
    }

    #[test]
    fn two_openers_see_the_same_bytes() {
        let path = path("bytes");
        let made = SharedMemory::create(&path, 77).expect("memory");
        let opened = SharedMemory::open(&path).expect("memory");
        assert!(SharedMemory::create(&path, 8).is_err(), "it exists");
        std::fs::remove_file(&path).expect("removed");
        assert_eq!((made.words().len(), opened.words().len()), (10, 10));
        for length in [0, 1, 7, 8, 9, 24, 29] {
            let bytes: Vec<u8> = (1..=length).collect();
            made.write(2, &bytes);
            let mut read = vec![0; bytes.len()];
            opened.read(2, &mut read);
            assert_eq!(read, bytes);
        }
        assert_eq!(opened.words()[1].load(Ordering::Relaxed), 0);
    }

    #[test]
    fn a_lock_belongs_to_one_opener() {
        let path = path("locks");
        let made = SharedMemory::create(&path, 64).expect("memory");
        let opened = SharedMemory::open(&path).expect("memory");
        std::fs::remove_file(&path).expect("removed");
        assert!(opened.lock(3) && made.is_locked(3) && !made.is_locked(4));
        assert!(!made.lock(3) && made.lock(4) && !opened.is_locked(3));
        opened.unlock(3);
        assert!(!made.is_locked(3) && made.lock(3));
        drop(made);
        assert!(opened.lock(3) && opened.lock(4), "locks end with their opener");
    }

    #[test]
    fn waiting_ends_with_a_change_or_with_the_time() {
        let path = path("wait");
        let memory = SharedMemory::create(&path, 64).expect("memory");
        std::fs::remove_file(&path).expect("removed");
        let started = Instant::now();
        memory.wait(2, 1, Duration::from_secs(60));
        assert!(started.elapsed() < Duration::from_secs(30), "the word has another value");
        memory.wait(2, 0, Duration::from_millis(20));
        assert!(started.elapsed() >= Duration::from_millis(15), "nobody changes it");
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(20));
                memory.words()[2].store(1, Ordering::Release);
                memory.wake(2);
            });
            while memory.words()[2].load(Ordering::Acquire) == 0 {
                memory.wait(2, 0, Duration::from_secs(60));
            }
        });
        assert!(started.elapsed() < Duration::from_secs(30));
    }
}

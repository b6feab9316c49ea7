//! Results that are cached, and files that are read but not used.

use super::*;
use std::cell::Cell;
use std::convert::Infallible;
use std::os::unix::fs::PermissionsExt;

/// A folder for one test, which is removed with it.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("cupola-cache-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(&self.0).into_iter().flatten().flatten();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        files.sort();
        files
    }

    fn cache(&self) -> Cache {
        Cache::in_folder(self.0.clone(), b"build")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The square of a number, and whether it was computed.
fn square(cache: &Cache, number: u32) -> (u32, bool) {
    let computed = Cell::new(false);
    let value: Result<u32, Infallible> = cache.cached(
        "square",
        &number,
        |_| true,
        || {
            computed.set(true);
            Ok(number * number)
        },
    );
    (value.expect("cannot fail"), computed.get())
}

#[test]
fn files_serve_the_next_process_and_memory_this_one() {
    let folder = Folder::new("files");
    let first = folder.cache();
    assert_eq!(square(&first, 7), (49, true));
    assert_eq!(square(&first, 7), (49, false));
    assert_eq!(square(&first, 8), (64, true));
    assert_eq!(first.counts(), Counts { read: 0, missing: 2, written: 2 });
    let second = folder.cache();
    assert_eq!(square(&second, 7), (49, false));
    assert_eq!(square(&second, 7), (49, false));
    assert_eq!(second.counts(), Counts { read: 1, missing: 0, written: 0 });
    let other = Cache::in_folder(folder.0.clone(), b"another build");
    assert_eq!(square(&other, 7), (49, true));
    assert_eq!(folder.files().len(), 3, "a file for each, and no parts of any: {:?}", folder.files());

    let memory = Cache::in_memory();
    assert_eq!([square(&memory, 7).1, square(&memory, 7).1], [true, false]);
    let none = Cache::none();
    assert_eq!([square(&none, 7).1, square(&none, 7).1], [true, true]);
}

#[test]
fn only_this_user_reads_what_is_kept() {
    let folder = Folder::new("modes");
    square(&folder.cache(), 7);
    let mode = |path: &Path| fs::metadata(path).expect("is there").permissions().mode() & 0o777;
    assert_eq!(mode(&folder.0), 0o700);
    assert_eq!(mode(&folder.files()[0]), 0o600);
}

#[test]
fn damaged_files_are_computed_again() {
    let folder = Folder::new("damaged");
    square(&folder.cache(), 7);
    let file = folder.files().remove(0);
    let whole = fs::read(&file).expect("a file");
    for at in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << (at % 8);
        fs::write(&file, &damaged).expect("written");
        assert_eq!(square(&folder.cache(), 7), (49, true), "byte {at}");
        assert_eq!(fs::read(&file).expect("a file"), whole, "written again");
    }
    for length in 0..whole.len() {
        fs::write(&file, &whole[..length]).expect("written");
        assert_eq!(square(&folder.cache(), 7), (49, true), "{length} bytes");
    }
    fs::write(&file, [&whole[..], b"more"].concat()).expect("written");
    assert_eq!(square(&folder.cache(), 7), (49, true), "more bytes");
    // A whole file under the name of another.
    square(&folder.cache(), 8);
    let other = folder.files().into_iter().find(|path| *path != file).expect("two files");
    fs::copy(&file, &other).expect("copied");
    assert_eq!(square(&folder.cache(), 8), (64, true));
}

/// A result that `decode` does not use completely is computed again.
#[test]
fn content_that_makes_no_sense_is_computed_again() {
    let cache = Cache::in_memory();
    let keep = |length: u8| {
        let value: Result<&str, Infallible> = cache.cached_as(
            "kind",
            &(),
            |bytes| decode::<[u8; 3]>(bytes).map(|_| "decoded"),
            |_| Some(vec![0; length.into()]),
            || Ok("computed"),
        );
        value.expect("cannot fail")
    };
    assert_eq!(keep(2), "computed", "nothing there");
    assert_eq!(keep(4), "computed", "too short");
    assert_eq!(keep(3), "computed", "too long");
    assert_eq!(keep(3), "decoded");
}

#[test]
fn errors_and_what_is_not_to_be_kept_are_not() {
    let folder = Folder::new("errors");
    let cache = folder.cache();
    let failed: Result<u32, &str> = cache.cached("kind", &(), |_| true, || Err("no"));
    assert_eq!(failed, Err("no"));
    let refused: Result<u32, &str> = cache.cached_as("kind", &(), |bytes| decode(bytes), |_| None, || Ok(1));
    assert_eq!((refused, folder.files().len()), (Ok(1), 0));
}

#[test]
fn where_nothing_can_be_written_nothing_is_kept() {
    let folder = Folder::new("blocked");
    fs::write(&folder.0, "a file where the folder should be").expect("written");
    for _ in 0..2 {
        assert_eq!(square(&folder.cache(), 7), (49, true));
    }
    fs::remove_file(&folder.0).expect("removed");
    let below = Cache::in_folder("/proc/self/nowhere".into(), b"build");
    assert_eq!(square(&below, 7), (49, true));
    assert_eq!(square(&below, 7), (49, false), "from memory");
}

#[test]
fn the_files_longest_not_used_go_first() {
    let folder = Folder::new("sweep");
    fs::create_dir(&folder.0).expect("made");
    let now = SystemTime::now();
    for age in 0..10u64 {
        let path = folder.0.join(format!("{age}"));
        fs::write(&path, vec![0; 100]).expect("written");
        let file = OpenOptions::new().append(true).open(&path).expect("there");
        file.set_modified(now - Duration::from_secs(100 * age)).expect("a time");
    }
    let left = || folder.files().iter().map(|path| path.file_name().expect("a name").to_owned()).collect::<Vec<_>>();
    sweep(&folder.0, 1000, 10);
    assert_eq!(left().len(), 10, "not too many");
    sweep(&folder.0, 999, 100);
    assert_eq!(left(), ["0", "1", "2", "3", "4", "5", "6"], "750 bytes at most");
    sweep(&folder.0, 1000, 4);
    assert_eq!(left(), ["0", "1", "2"], "three quarters of 4 files");
}

#[test]
fn a_file_that_is_used_is_young_again() {
    let folder = Folder::new("young");
    square(&folder.cache(), 7);
    let path = folder.files().remove(0);
    let old = SystemTime::now() - RENEWED_AFTER - Duration::from_secs(60);
    OpenOptions::new().append(true).open(&path).expect("there").set_modified(old).expect("a time");
    assert_eq!(square(&folder.cache(), 7), (49, false));
    let age = fs::metadata(&path).and_then(|about| about.modified()).expect("a time").elapsed().expect("past");
    assert!(age < Duration::from_secs(60), "{age:?}");
}

#[test]
fn a_process_writes_only_so_much() {
    let folder = Folder::new("much");
    let cache = folder.cache();
    for number in 0..MOST_WRITTEN_FILES as u32 + 5 {
        square(&cache, number);
    }
    assert_eq!(folder.files().len() as u64, MOST_WRITTEN_FILES);
    assert_eq!(square(&cache, MOST_WRITTEN_FILES as u32 + 4), (516 * 516, false), "but remembers");
}

/// Processes that start together read and write the same files.
#[test]
fn many_at_once_get_what_they_ask_for() {
    let folder = Folder::new("threads");
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for round in 0..50 {
                    let cache = folder.cache();
                    assert_eq!(square(&cache, round % 5).0, (round % 5) * (round % 5));
                }
            });
        }
    });
    assert_eq!(folder.files().len(), 5, "{:?}", folder.files());
}

/// A result that is decoded but not sound is computed again, and so is every result whose key has
/// no bytes.
#[test]
fn unsound_values_and_keys_without_bytes_are_computed_again() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let cache = Cache::in_memory();
    let ask = |sound: bool| {
        let value: Result<u32, Infallible> = cache.cached("kind", &(), |_| sound, || Ok(1));
        (value.expect("cannot fail"), cache.counts().missing)
    };
    assert_eq!([ask(true), ask(true), ask(false)], [(1, 1), (1, 1), (1, 2)]);
    let no_text = Path::new(OsStr::from_bytes(b"\xFF"));
    let value: Result<u32, Infallible> = cache.cached("kind", &no_text, |_| true, || Ok(2));
    assert_eq!((value, cache.counts().missing), (Ok(2), 2));
}

#[test]
fn bytes_are_copied_and_nothing_may_follow() {
    let value = (7u32, RawBytes(&[1, 2, 3]));
    let bytes = encode(&value).expect("bytes");
    let (number, raw) = decode::<(u32, RawBytes<'_>)>(&bytes).expect("a value");
    assert_eq!((number, raw.0), (7, &[1u8, 2, 3][..]));
    assert!(decode::<(u32, RawBytes<'_>)>(&[&bytes[..], &[0]].concat()).is_none());
    assert!(decode::<(u32, RawBytes<'_>)>(&bytes[..bytes.len() - 1]).is_none());
}

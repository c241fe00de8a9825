//! Ranges of remote files on the local disk, within a byte budget.
//!
//! An entry is a file that says whose bytes it holds and has a checksum, so that nothing
//! that a crash, a full disk or another program leaves there is taken for an answer.
//! Entries appear by a rename. Who adds one holds a lock on the folder meanwhile, so that
//! any number of processes keep one budget; who reads one holds none.

mod entry;

use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use self::entry::Entry;
use crate::error::{Error, Result};

/// The file that is locked, and holds the number of bytes in the folder.
const LOCK: &str = "lock";
/// What an entry's name ends with.
const SUFFIX: &str = ".range";
/// How often the lock is tried, and how long after each: whoever holds it may be stopped.
const ATTEMPTS: u32 = 20;
const PAUSE: Duration = Duration::from_millis(2);

/// A folder of ranges.
#[derive(Debug)]
pub(super) struct DiskCache {
    folder: PathBuf,
    budget: u64,
    /// Whether this process has counted the folder's bytes.
    counted: AtomicBool,
    /// One thread of this process at a time: locks of files are the process's.
    adding: Mutex<()>,
}

impl DiskCache {
    /// A cache in a folder, which is made if it is not there, for this user alone.
    pub(super) fn open(folder: &Path, budget: u64) -> Result<Self> {
        let mut builder = fs::DirBuilder::new();
        builder.recursive(true);
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(folder).map_err(Error::io("make the folder of DEEPSHADOW_REMOTE_CACHE"))?;
        let (counted, adding) = (AtomicBool::new(false), Mutex::new(()));
        let cache = Self { folder: folder.to_owned(), budget, counted, adding };
        // Another process may have had more room; what cannot be let go now is later.
        drop(cache.keep_to_budget());
        Ok(cache)
    }

    fn keep_to_budget(&self) -> std::io::Result<()> {
        let Some(mut lock) = self.lock()? else { return Ok(()) };
        if read_total(&mut lock).is_some_and(|total| total > self.budget) {
            let total = self.make_room(0)?;
            write_total(&mut lock, total)?;
        }
        Ok(())
    }

    /// The bytes of a range of `key`'s file, if they are there and whole.
    pub(super) fn get(&self, key: &str, range: &Range<u64>) -> Option<Vec<u8>> {
        let entry = Entry::new(key, range);
        let path = self.path(&entry);
        let mut file = File::open(&path).ok()?;
        let mut stored = Vec::new();
        // One more, to notice what is too long.
        (&mut file).take(entry.stored_length() + 1).read_to_end(&mut stored).ok()?;
        let bytes = entry.decode(stored);
        match bytes {
            // Used now; what cannot be marked so goes a little early.
            Some(_) => drop(file.set_modified(SystemTime::now())),
            None => drop(fs::remove_file(path)),
        }
        bytes
    }

    /// Keeps the bytes of a range. What cannot be kept is not: the next reader asks the
    /// store.
    pub(super) fn put(&self, key: &str, range: &Range<u64>, bytes: &[u8]) {
        let entry = Entry::new(key, range);
        if entry.stored_length() <= self.budget {
            drop(self.add(&entry, bytes));
        }
    }

    fn path(&self, entry: &Entry) -> PathBuf {
        self.folder.join(format!("{}{SUFFIX}", entry.name()))
    }

    fn add(&self, entry: &Entry, bytes: &[u8]) -> std::io::Result<()> {
        let Ok(_alone) = self.adding.try_lock() else { return Ok(()) };
        let Some(mut lock) = self.lock()? else { return Ok(()) };
        let path = self.path(entry);
        let mut total = match (self.counted.swap(true, Ordering::Relaxed), read_total(&mut lock)) {
            (true, Some(total)) => total,
            _ => self.entries()?.iter().map(|(_, length, _)| length).sum(),
        };
        let added = entry.stored_length();
        if total.saturating_add(added) > self.budget {
            total = self.make_room(added)?;
        }
        let old = path.metadata().map_or(0, |old| old.len());
        // One writer at a time: what a crash left of another is overwritten.
        let partial = self.folder.join("partial");
        let mut file = File::create(&partial)?;
        let written =
            file.write_all(&entry.encode(bytes)).and_then(|()| fs::rename(&partial, &path));
        if written.is_err() {
            drop(fs::remove_file(&partial));
        }
        written?;
        write_total(&mut lock, total.saturating_add(added).saturating_sub(old))
    }

    /// The lock, or none if others hold it for long.
    fn lock(&self) -> std::io::Result<Option<File>> {
        let mut options = File::options();
        let file = options.read(true).write(true).create(true).truncate(false);
        let file = file.open(self.folder.join(LOCK))?;
        for _ in 0..ATTEMPTS {
            match file.try_lock() {
                Ok(()) => return Ok(Some(file)),
                Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
                Err(TryLockError::Error(error)) => return Err(error),
            }
        }
        Ok(None)
    }

    /// All entries: when each was used, its bytes, its path.
    fn entries(&self) -> std::io::Result<Vec<(SystemTime, u64, PathBuf)>> {
        let mut entries = Vec::new();
        for found in self.folder.read_dir()?.flatten() {
            let is_entry = found.file_name().as_encoded_bytes().ends_with(SUFFIX.as_bytes());
            if let (true, Ok(metadata)) = (is_entry, found.metadata()) {
                let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                entries.push((used, metadata.len(), found.path()));
            }
        }
        Ok(entries)
    }

    /// Lets the entries go that were not used for longest, until there is room for so many
    /// bytes and an eighth of the budget more, so that not every addition has to. Returns
    /// the bytes that are left.
    fn make_room(&self, bytes: u64) -> std::io::Result<u64> {
        let mut entries = self.entries()?;
        entries.sort_unstable();
        let mut total: u64 = entries.iter().map(|(_, length, _)| length).sum();
        let goal = (self.budget - self.budget / 8).min(self.budget - bytes);
        for (_, length, path) in entries {
            if total <= goal {
                break;
            }
            match fs::remove_file(path) {
                // A reader that found it damaged was faster.
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
                _ => total -= length,
            }
        }
        Ok(total)
    }
}

fn read_total(lock: &mut File) -> Option<u64> {
    let mut bytes = [0; 8];
    lock.seek(SeekFrom::Start(0)).ok()?;
    lock.read_exact(&mut bytes).ok()?;
    Some(u64::from_le_bytes(bytes))
}

fn write_total(lock: &mut File, total: u64) -> std::io::Result<()> {
    lock.seek(SeekFrom::Start(0))?;
    lock.write_all(&total.to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes_in(folder: &Path) -> u64 {
        let entries = folder.read_dir().unwrap().flatten();
        let entries =
            entries.filter(|entry| entry.path().extension().is_some_and(|e| e == "range"));
        // Others may remove some meanwhile.
        entries.filter_map(|entry| Some(entry.metadata().ok()?.len())).sum()
    }

    fn content(index: u64) -> Vec<u8> {
        (0..1000).map(|byte| (byte * 31 + index * 17) as u8).collect()
    }

    #[test]
    fn what_is_put_is_got_under_its_own_name_alone() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::open(&folder.path().join("new/folder"), 1 << 20).unwrap();
        assert_eq!(cache.get("a", &(0..1000)), None);
        cache.put("a", &(0..1000), &content(1));
        let again = DiskCache::open(&folder.path().join("new/folder"), 1 << 20).unwrap();
        assert_eq!(again.get("a", &(0..1000)), Some(content(1)));
        for (key, range) in [("b", 0..1000), ("a", 0..999), ("a", 1..1001), ("a 0", 0..1000)] {
            assert_eq!(cache.get(key, &range), None, "{key} {range:?}");
        }
    }

    #[test]
    fn the_budget_holds_and_what_was_used_last_stays() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::open(folder.path(), 20_000).unwrap();
        cache.put("f", &(0..1000), &content(0));
        for index in 1..100 {
            cache.put("f", &(index * 1000..(index + 1) * 1000), &content(index));
            assert!(bytes_in(folder.path()) <= 20_000, "{index}");
            assert_eq!(cache.get("f", &(0..1000)), Some(content(0)), "{index}");
        }
        assert!(bytes_in(folder.path()) > 10_000);
        assert_eq!(cache.get("f", &(1000..2000)), None);
        cache.put("f", &(0..30_000), &[0; 30_000]);
        assert_eq!(cache.get("f", &(0..30_000)), None);
        // Another process with another budget finds what is there.
        let smaller = DiskCache::open(folder.path(), 5_000).unwrap();
        assert!(bytes_in(folder.path()) <= 5_000);
        smaller.put("g", &(0..1000), &content(7));
        assert!(bytes_in(folder.path()) <= 5_000);
        assert_eq!(smaller.get("g", &(0..1000)), Some(content(7)));
    }

    #[test]
    fn damage_is_a_miss() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::open(folder.path(), 1 << 20).unwrap();
        let path = cache.path(&Entry::new("f", &(0..1000)));
        cache.put("f", &(0..1000), &content(0));
        let whole = fs::read(&path).unwrap();
        for at in (0..whole.len()).step_by(13).chain([whole.len() - 1]) {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            fs::write(&path, damaged).unwrap();
            assert_eq!(cache.get("f", &(0..1000)), None, "{at}");
            assert!(!path.exists());
        }
        for length in [0, 1, whole.len() - 1] {
            fs::write(&path, &whole[..length]).unwrap();
            assert_eq!(cache.get("f", &(0..1000)), None, "{length}");
        }
        fs::write(&path, [&whole[..], &[0]].concat()).unwrap();
        assert_eq!(cache.get("f", &(0..1000)), None);
        // What the lock says of the bytes is no more than a hint.
        fs::write(folder.path().join(LOCK), "x").unwrap();
        cache.put("f", &(0..1000), &content(0));
        assert_eq!(cache.get("f", &(0..1000)), Some(content(0)));
    }

    #[test]
    fn threads_and_a_held_lock_do_not_stop_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let held = File::create(folder.path().join(LOCK)).unwrap();
        held.lock().unwrap();
        let cache = DiskCache::open(folder.path(), 50_000).unwrap();
        cache.put("f", &(0..1000), &content(0));
        assert_eq!(cache.get("f", &(0..1000)), None);
        held.unlock().unwrap();
        // As several processes: each with a cache of its own.
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let cache = DiskCache::open(folder.path(), 50_000).unwrap();
                    for index in 0..200 {
                        let range = index * 1000..(index + 1) * 1000;
                        cache.put("f", &range, &content(index));
                        if let Some(found) = cache.get("f", &range) {
                            assert_eq!(found, content(index));
                        }
                        if let Ok(Some(_nobody_adds)) = cache.lock() {
                            assert!(bytes_in(folder.path()) <= 50_000);
                        }
                    }
                });
            }
        });
        assert!((25_000..=50_000).contains(&bytes_in(folder.path())));
    }
}

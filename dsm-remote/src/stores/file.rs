//! A file in an object store.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use object_store::path::Path;
use object_store::{ObjectMeta, ObjectStore};

use super::connect::{Address, Connection, Retries};
use super::disk_cache::DiskCache;
use super::read_ahead::ReadAhead;
use super::request::{Counters, Requests};
use super::runtime::wait;
use super::version::Version;
use crate::error::{Error, Result};
use crate::options::RemoteOptions;
use crate::statistics::RemoteStatistics;

/// The first bytes, which come with the first request: those of a small file are all of
/// it, and as many as a connection brings without waiting.
const START_BYTES: u64 = 16 << 10;

/// The share of a file that is asked for at its end while it is opened, and the least and
/// the most: a `.dsm` file has its directories there, 64 bytes a tile.
const END_SHARE: u64 = 32;
const END_BYTES: [u64; 2] = [64 << 10, 4 << 20];

/// How much before what is asked for comes along while a file is opened: metadata stand
/// before the directories.
const BEFORE_BYTES: u64 = 16 << 10;

/// A file in an object store, of one version from the first byte to the last. Any number
/// of threads may read from it.
///
/// It is opened for readers that first want its start and its end: both come with two
/// requests, and are let go when [`Self::opened`] says that they were read. After that a
/// read is a request, or less where reads follow each other.
///
/// ```no_run
/// use dsm_remote::{RemoteFile, RemoteOptions};
///
/// let file = RemoteFile::open("https://host/key.dsm", &RemoteOptions::new())?;
/// let start = file.read(0..64)?;
/// println!("{start:x?}, {:?}", file.statistics());
/// # Ok::<(), dsm_remote::Error>(())
/// ```
#[derive(Debug)]
pub struct RemoteFile {
    connection: Connection,
    path: Path,
    options: RemoteOptions,
    meta: ObjectMeta,
    version: Version,
    /// The cache on the disk, and the version's name in it.
    cache: Option<(DiskCache, String)>,
    /// Pieces that were read while the file is opened.
    opening: Mutex<Option<Vec<Piece>>>,
    ahead: Mutex<ReadAhead>,
    counters: Arc<Counters>,
    disk_hits: AtomicU64,
}

/// Bytes at an offset.
#[derive(Debug)]
struct Piece {
    start: u64,
    bytes: Vec<u8>,
}

impl Piece {
    const fn end(&self) -> u64 {
        self.start + self.bytes.len() as u64
    }

    fn get(&self, range: &Range<u64>) -> Option<&[u8]> {
        let [start, end] = [range.start, range.end].map(|at| at.checked_sub(self.start));
        let (start, end) = (usize::try_from(start?).ok()?, usize::try_from(end?).ok()?);
        self.bytes.get(start..end)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What the locks here guard is whole at any time.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl RemoteFile {
    /// Opens the file at an address, with one request.
    ///
    /// # Errors
    ///
    /// [`Error::Address`] and [`Error::Client`] before any request; what the store says.
    pub fn open(address: &str, options: &RemoteOptions) -> Result<Self> {
        let address = Address::parse(address)?;
        let (path, key) = (address.path.clone(), address.key().to_owned());
        // Attempts have their own limit; the client's is for one that nobody waits for.
        let limit = options.timeout.saturating_mul(1 << 10);
        let connection = Connection::new(move || address.connect(limit, Retries::Caller))?;
        Self::begin(connection, path, &key, options)
    }

    /// Lets go what is at hand.
    #[cfg(test)]
    pub(super) fn forget(&self) {
        *lock(&self.ahead) = ReadAhead::new(self.length(), self.options.read_ahead);
    }

    /// Opens an object of a store that there is already.
    #[cfg(test)]
    pub(super) fn of_store(
        store: &Arc<dyn ObjectStore>,
        path: &str,
        options: &RemoteOptions,
    ) -> Result<Self> {
        let store = Arc::clone(store);
        let connection = Connection::new(move || Ok(Arc::clone(&store)))?;
        Self::begin(connection, path.into(), path, options)
    }

    fn begin(
        connection: Connection,
        path: Path,
        key: &str,
        options: &RemoteOptions,
    ) -> Result<Self> {
        let counters = Arc::new(Counters::default());
        let requests = requests(connection.client()?, &path, options, &counters);
        let (bytes, meta) = wait(async move { requests.begin(START_BYTES).await })?;
        let version = Version::of(&meta);
        let cache = match (&options.disk_cache, version.key()) {
            (Some((folder, budget)), Some(version)) => {
                Some((DiskCache::open(folder, *budget)?, format!("{key} {version}")))
            }
            _ => None,
        };
        let ahead = Mutex::new(ReadAhead::new(version.length(), options.read_ahead));
        let opening = Mutex::new(Some(vec![Piece { start: 0, bytes }]));
        let (options, disk_hits) = (options.clone(), AtomicU64::new(0));
        Ok(Self {
            connection,
            path,
            options,
            meta,
            version,
            cache,
            opening,
            ahead,
            counters,
            disk_hits,
        })
    }

    /// Length in bytes.
    #[must_use]
    pub const fn length(&self) -> u64 {
        self.version.length()
    }

    /// The bytes of a range.
    ///
    /// # Errors
    ///
    /// [`Error::Range`] for one that does not lie in the file, [`Error::Changed`] if the
    /// object is another one by now, or what the store says.
    pub fn read(&self, range: Range<u64>) -> Result<Vec<u8>> {
        let length = self.length();
        if range.start > range.end || range.end > length {
            return Err(Error::Range { start: range.start, end: range.end, length });
        }
        if range.is_empty() {
            return Ok(Vec::new());
        }
        if let Some(pieces) = &mut *lock(&self.opening) {
            return self.read_opening(pieces, &range);
        }
        if let Some((cache, key)) = &self.cache
            && let Some(bytes) = cache.get(key, &range)
        {
            self.disk_hits.fetch_add(1, Ordering::Relaxed);
            return Ok(bytes);
        }
        let bytes = self.read_on(&range)?;
        if let Some((cache, key)) = &self.cache {
            cache.put(key, &range, &bytes);
        }
        Ok(bytes)
    }

    /// Reads while the file is opened: its end at once, or what lies before that.
    fn read_opening(&self, pieces: &mut Vec<Piece>, range: &Range<u64>) -> Result<Vec<u8>> {
        if let Some(bytes) = pieces.iter().find_map(|piece| piece.get(range)) {
            return Ok(bytes.to_vec());
        }
        let length = self.length();
        let begun = pieces.iter().find(|piece| piece.start == 0).map_or(0, Piece::end);
        let share = (length / END_SHARE).clamp(END_BYTES[0], END_BYTES[1]);
        let tail = length.saturating_sub(share).max(begun);
        let from = range.start.max(begun);
        let wanted = if from >= tail {
            tail..length
        } else {
            // Up to what there is, if that is not far: more of the directories.
            let next = pieces.iter().map(|piece| piece.start).filter(|next| *next > from);
            let next = next.min().unwrap_or(range.end);
            let is_near = next.saturating_sub(range.end) <= (range.end - from).max(END_BYTES[0]);
            from.saturating_sub(BEFORE_BYTES).max(begun)..if is_near { next } else { range.end }
        };
        let mut piece = Piece { start: wanted.start, bytes: self.fetch(wanted)? };
        while let Some(index) = pieces.iter().position(|next| next.start == piece.end()) {
            piece.bytes.append(&mut pieces.swap_remove(index).bytes);
        }
        if let Some(index) = pieces.iter().position(|before| before.end() == piece.start) {
            let mut before = pieces.swap_remove(index);
            before.bytes.append(&mut piece.bytes);
            piece = before;
        }
        let bytes = piece.get(range).map(<[u8]>::to_vec);
        pieces.push(piece);
        // A file's parts lie in it and do not overlap: what else is asked for is odd.
        bytes.map_or_else(|| self.fetch(range.clone()), Ok)
    }

    /// Ends the opening: what was read for it is let go. Until then all that is read is
    /// kept, for a reader that looks at parts of the start and the end several times.
    pub fn opened(&self) {
        *lock(&self.opening) = None;
    }

    fn read_on(&self, range: &Range<u64>) -> Result<Vec<u8>> {
        let plan = lock(&self.ahead).plan(range);
        if let Some(block) = &plan.fetch {
            block.fill(|range| self.fetch(range));
        }
        let mut bytes = Vec::new();
        for block in &plan.blocks {
            if let Err(error) = block.copy(range, &mut bytes) {
                lock(&self.ahead).forget(block);
                return Err(error);
            }
        }
        Ok(bytes)
    }

    fn fetch(&self, range: Range<u64>) -> Result<Vec<u8>> {
        let client = self.connection.client()?;
        let requests = requests(client, &self.path, &self.options, &self.counters);
        let meta = self.meta.clone();
        wait(async move { requests.range(range, meta).await })
    }

    /// What cannot be told of a file that is replaced while it is read; `None` where
    /// every replacement is told.
    #[must_use]
    pub const fn remark(&self) -> Option<&'static str> {
        self.version.remark()
    }

    /// Counts of requests and bytes so far.
    #[must_use]
    pub fn statistics(&self) -> RemoteStatistics {
        RemoteStatistics {
            requests: self.counters.requests.load(Ordering::Relaxed),
            bytes: self.counters.bytes.load(Ordering::Relaxed),
            disk_hits: self.disk_hits.load(Ordering::Relaxed),
        }
    }
}

fn requests(
    client: Arc<dyn ObjectStore>,
    path: &Path,
    options: &RemoteOptions,
    counters: &Arc<Counters>,
) -> Requests {
    Requests {
        client,
        path: path.clone(),
        timeout: options.timeout,
        retries: options.retries,
        counters: Arc::clone(counters),
    }
}

//! A file that appears whole or not at all.

use std::ffi::{OsStr, OsString};
use std::fs::{File, Metadata, TryLockError};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use dsm_remote::RemoteOptions;
use tempfile::{NamedTempFile, TempPath};

use crate::error::{Error, Result};
use crate::source::remote::text;

/// What a file system's file can do, so that tests can have one that fails.
pub(super) trait OutputFile: Write + Seek + Send {
    /// Waits until everything written is on the disk.
    fn sync(&mut self) -> io::Result<()>;
}

impl OutputFile for File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

/// Collects bytes in a temporary file beside `path`; only [`Self::commit`]
/// puts it there. Dropped before, it leaves no trace. Of an address of an object
/// store the file is a temporary one of the system, and `commit` sends it.
///
/// A process that is killed leaves its temporary file. Whoever writes holds a
/// lock on theirs, which ends with the process: what nobody holds is removed
/// when a file of the same name is written next.
pub struct AtomicFile {
    file: BufWriter<NamedTempFile<Box<dyn OutputFile>>>,
    path: PathBuf,
    /// Where `path` leads, through symbolic links.
    target: PathBuf,
    length: u64,
}

const BUFFER_BYTES: usize = 1 << 18;

impl AtomicFile {
    /// Starts a file that will replace `path`, which may not exist yet.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if none can be made there.
    pub fn create(path: &Path) -> Result<Self> {
        Self::create_with(path, |file| Box::new(file))
    }

    /// The same, with something around the temporary file.
    pub(super) fn create_with(
        path: &Path,
        wrap: impl FnOnce(File) -> Box<dyn OutputFile>,
    ) -> Result<Self> {
        let created = target_of(path).map(|(target, temporary)| {
            let (file, temporary_path) = temporary.into_parts();
            let temporary = NamedTempFile::from_parts(wrap(file), temporary_path);
            let file = BufWriter::with_capacity(BUFFER_BYTES, temporary);
            Self { file, path: path.to_owned(), target, length: 0 }
        });
        created.map_err(|error| error.in_file(Some(path)))
    }

    /// The path that was asked for.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Number of bytes written.
    pub(crate) const fn length(&self) -> u64 {
        self.length
    }

    /// Appends bytes.
    pub(crate) fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).map_err(Error::io("write"))?;
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Overwrites the file's first bytes with `start` and puts the file in
    /// its place, safe on the disk.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be written or moved; what had its name stays then.
    pub fn commit(mut self, start: &[u8]) -> Result<()> {
        self.file.seek(SeekFrom::Start(0)).map_err(Error::io("write"))?;
        self.file.write_all(start).map_err(Error::io("write"))?;
        let mut temporary =
            self.file.into_inner().map_err(|error| Error::io("write")(error.into_error()))?;
        if dsm_remote::is_url(&self.target) {
            return send(temporary.into_temp_path(), &self.target);
        }
        keep_permissions(&self.target, temporary.path())?;
        temporary.as_file_mut().sync().map_err(Error::io("write to the disk"))?;
        temporary
            .persist(&self.target)
            .map_err(|refused| Error::io("move the finished file into place")(refused.error))?;
        sync_folder(folder(&self.target))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Replaces `path`, or makes it, by a file of these bytes: there is the old file
/// or the whole new one, whatever happens meanwhile.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be written; then nothing has changed.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = AtomicFile::create(path)?;
    let written = file.append(bytes).and_then(|()| file.commit(&[]));
    written.map_err(|error| error.in_file(Some(path)))
}

/// Checks that a file can be written at `path`, before the work that it is to
/// hold begins. Nothing is left there.
///
/// # Errors
///
/// [`Error::File`] if its folder does not exist or takes no files, or if there
/// is something that is no regular file.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// assert!(dsm_io::detail::check_output(&folder.join("map.dsm")).is_ok());
/// assert!(dsm_io::detail::check_output(&folder.join("missing/map.dsm")).is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn check_output(path: &Path) -> Result<()> {
    AtomicFile::create(path).map(drop)
}

/// Where a path leads, and a temporary file for what is to stand there.
fn target_of(path: &Path) -> Result<(PathBuf, NamedTempFile)> {
    if dsm_remote::is_url(path) {
        dsm_remote::check_address(text(path)?, &RemoteOptions::from_env()?)?;
        let mut builder = tempfile::Builder::new();
        let temporary = builder.prefix("deepshadow.").suffix(UNSENT).tempfile();
        let temporary = temporary.map_err(Error::io("create a temporary file"))?;
        return Ok((path.to_owned(), temporary));
    }
    let target = follow_links(path)?;
    let temporary = create_beside(&target)?;
    Ok((target, temporary))
}

/// What follows the name of a file that is to be sent.
const UNSENT: &str = ".unsent";

/// Sends a finished file to an address. One that does not arrive is kept: what made it
/// may have taken hours.
fn send(temporary: TempPath, address: &Path) -> Result<()> {
    let options = RemoteOptions::from_env()?;
    let mut file = File::open(&temporary).map_err(Error::io("read the finished file"))?;
    match dsm_remote::upload(&mut file, text(address)?, &options) {
        Ok(()) => Ok(()),
        Err(error) => match temporary.keep() {
            Ok(kept) => Err(Error::NotSent { kept, error }),
            Err(_) => Err(error.into()),
        },
    }
}

/// How many symbolic links may lead to each other; as many as Linux follows.
const MAX_LINKS: usize = 40;

/// Where a path leads whose last part may be a symbolic link: to a file that
/// exists or not.
fn follow_links(path: &Path) -> Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        if !target.symlink_metadata().is_ok_and(|metadata| metadata.is_symlink()) {
            return Ok(target);
        }
        let link = target.read_link().map_err(Error::io("follow the symbolic link"))?;
        target = folder(&target).join(link);
    }
    Err(Error::Path("too many symbolic links lead to each other"))
}

/// What follows the name of a temporary file's target.
const SUFFIX: &str = ".partial";
/// How many letters and digits make its name its own.
const OWN_LETTERS: usize = 6;
/// How often another process may take a new temporary file for a leftover.
const MAX_ATTEMPTS: usize = 64;

/// Creates a temporary file in the folder of `target`, locked while it is open.
fn create_beside(target: &Path) -> Result<NamedTempFile> {
    let name = target.file_name().ok_or_else(|| Error::Path("the path does not name a file"))?;
    let replaced = target.metadata().ok();
    // A rename would replace a device such as /dev/null.
    if replaced.as_ref().is_some_and(|metadata: &Metadata| !metadata.is_file()) {
        return Err(Error::Path("it exists and is not a regular file"));
    }
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    remove_leftovers(folder(target), &prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).rand_bytes(OWN_LETTERS).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: the process's mask takes off the rest. Where a file
        // is replaced that others may not read, they may not read this either.
        let mode = replaced.map_or(0o666, |replaced| replaced.permissions().mode() & 0o666);
        builder.permissions(std::fs::Permissions::from_mode(mode));
    }
    for _ in 0..MAX_ATTEMPTS {
        let temporary =
            builder.tempfile_in(folder(target)).map_err(Error::io("create a file beside it"))?;
        // Not every file system has locks; without one nobody removes it.
        let is_taken = matches!(temporary.as_file().try_lock(), Err(TryLockError::WouldBlock));
        // Between its creation and the lock another process may have found it
        // and taken it for a leftover.
        if !is_taken && temporary.path().symlink_metadata().is_ok() {
            return Ok(temporary);
        }
    }
    Err(Error::Path("other processes take every temporary file beside it"))
}

/// Removes temporary files that begin with `prefix` and that no process has
/// open. What fails is left for the next time.
fn remove_leftovers(folder: &Path, prefix: &OsStr) {
    let Ok(entries) = folder.read_dir() else { return };
    for entry in entries.flatten() {
        let is_file = || entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_temporary_name(&entry.file_name(), prefix) && is_file() {
            // Without a lock that was got, someone may be writing.
            if let Ok(file) = File::open(entry.path())
                && file.try_lock().is_ok()
            {
                drop(std::fs::remove_file(entry.path()));
            }
        }
    }
}

/// Whether a name is that of a temporary file with this prefix.
fn is_temporary_name(name: &OsStr, prefix: &OsStr) -> bool {
    let own = name.as_encoded_bytes().strip_prefix(prefix.as_encoded_bytes());
    own.and_then(|own| own.strip_suffix(SUFFIX.as_bytes()))
        .is_some_and(|own| own.len() == OWN_LETTERS && own.iter().all(u8::is_ascii_alphanumeric))
}

/// Gives the new file the permissions of the one that it replaces.
#[cfg(unix)]
fn keep_permissions(replaced: &Path, new: &Path) -> Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let Ok(metadata) = replaced.metadata() else { return Ok(()) };
    let mode = std::fs::Permissions::from_mode(metadata.permissions().mode() & 0o777);
    std::fs::set_permissions(new, mode).map_err(Error::io("set the permissions of the new file"))
}

#[cfg(not(unix))]
fn keep_permissions(_replaced: &Path, _new: &Path) -> Result<()> {
    Ok(())
}

/// The folder that holds `path`.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// Makes the rename itself last through a crash.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> Result<()> {
    let sync = File::open(folder).and_then(|folder| folder.sync_all());
    sync.map_err(Error::io("write the folder to the disk"))
}

#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = folder.read_dir().unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn only_what_dead_processes_left_of_this_file_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.dsm");
        let others = [
            ".map.dsm.0000000.partial",
            ".map.dsm.00000.partial",
            ".map.dsm.000-00.partial",
            ".map.dsm.000000.part",
            ".other.dsm.000000.partial",
            "map.dsm.000000.partial",
        ];
        for name in others.iter().chain(&[".map.dsm.a0B1c2.partial", ".map.dsm.000000.partial"]) {
            std::fs::write(folder.path().join(name), "left").unwrap();
        }
        std::fs::create_dir(folder.path().join(".map.dsm.folder.partial")).unwrap();
        let mut expected: Vec<_> = others.map(str::to_owned).into();
        expected.push(".map.dsm.folder.partial".to_owned());

        let first = AtomicFile::create(&path).unwrap();
        // Another that is being written meanwhile is nobody's leftover.
        let mut second = AtomicFile::create(&path).unwrap();
        assert_eq!(names(folder.path()).len(), expected.len() + 2);
        drop(first);
        second.append(b"whole").unwrap();
        second.commit(b"W").unwrap();
        expected.push("map.dsm".to_owned());
        expected.sort();
        assert_eq!(names(folder.path()), expected);
        assert_eq!(std::fs::read(path).unwrap(), b"Whole");
    }
}

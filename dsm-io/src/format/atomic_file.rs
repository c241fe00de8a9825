//! A file that appears whole or not at all.

use std::fs::{File, Metadata};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::{Error, Result};

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
/// puts it there. Dropped before, it leaves no trace.
pub(crate) struct AtomicFile {
    file: BufWriter<NamedTempFile<Box<dyn OutputFile>>>,
    path: PathBuf,
    length: u64,
}

const BUFFER_BYTES: usize = 1 << 18;

impl AtomicFile {
    /// Starts a file that will replace `path`, which may not exist yet.
    pub(crate) fn create(path: &Path) -> Result<Self> {
        Self::create_with(path, |file| Box::new(file))
    }

    /// The same, with something around the temporary file.
    pub(super) fn create_with(
        path: &Path,
        wrap: impl FnOnce(File) -> Box<dyn OutputFile>,
    ) -> Result<Self> {
        let in_file = |error: Error| error.in_file(Some(path));
        let name = path
            .file_name()
            .ok_or_else(|| in_file(Error::caller("the path does not name a file")))?;
        // A rename would replace a device such as /dev/null.
        if path.metadata().is_ok_and(|metadata: Metadata| !metadata.is_file()) {
            return Err(in_file(Error::caller("it exists and is not a regular file")));
        }
        let mut prefix = std::ffi::OsString::from(".");
        prefix.push(name);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(".partial");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As any new file: the process's mask takes off the rest.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let temporary = builder
            .tempfile_in(folder(path))
            .map_err(Error::io("create a file beside it"))
            .map_err(in_file)?;
        let (file, temporary_path) = temporary.into_parts();
        let temporary = NamedTempFile::from_parts(wrap(file), temporary_path);
        let file = BufWriter::with_capacity(BUFFER_BYTES, temporary);
        Ok(Self { file, path: path.to_owned(), length: 0 })
    }

    /// The path that the file will have.
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
    pub(crate) fn commit(mut self, start: &[u8]) -> Result<()> {
        self.file.seek(SeekFrom::Start(0)).map_err(Error::io("write"))?;
        self.file.write_all(start).map_err(Error::io("write"))?;
        let mut temporary =
            self.file.into_inner().map_err(|error| Error::io("write")(error.into_error()))?;
        temporary.as_file_mut().sync().map_err(Error::io("write to the disk"))?;
        temporary
            .persist(&self.path)
            .map_err(|refused| Error::io("move the finished file into place")(refused.error))?;
        sync_folder(folder(&self.path))
    }
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

//! Writes sections and tiles, whatever they mean.

use std::path::Path;

use super::atomic_file::AtomicFile;
use super::directory::{TileDirectory, TileEntry};
use super::encoded_tile::EncodedTile;
use super::extent::{Extent, checksum, padding};
use super::level::{Level, broken_order};
use super::prologue::{PROLOGUE_BYTES, Prologue};
use super::section::Section;
use super::version::MINOR;
use crate::achieved_error::AchievedError;
use crate::error::{Error, Result, check_limit, check_tile_bytes};
use crate::limits::Limits;
use crate::section_kind::SectionKind;
use crate::tile_id::TileId;

/// Writes a `.dsm` file of any kind of map.
///
/// The file appears under its name when [`Self::finish`] has written all of
/// it to the disk; until then, and if that never happens, whatever had the
/// name stays as it was. Memory: 64 bytes a tile.
pub struct ContainerWriter {
    file: AtomicFile,
    levels: Vec<Level>,
    directories: Vec<TileDirectory>,
    written: Vec<Vec<bool>>,
    sections: Vec<Section>,
    failed: bool,
}

impl std::fmt::Debug for ContainerWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ContainerWriter")
            .field("path", &self.file.path())
            .field("length", &self.file.length())
            .field("levels", &self.levels)
            .finish_non_exhaustive()
    }
}

impl ContainerWriter {
    /// Starts a file that will replace `path`, which may not exist yet. The
    /// temporary file stands in the same folder.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if no file can be created there.
    pub fn create(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        AtomicFile::create(path).and_then(Self::start).map_err(|error| error.in_file(Some(path)))
    }

    pub(super) fn start(mut file: AtomicFile) -> Result<Self> {
        // The prologue's place: written last, when all it says is known.
        file.append(&[0; PROLOGUE_BYTES])?;
        let (levels, directories) = (Vec::new(), Vec::new());
        let (written, sections) = (Vec::new(), Vec::new());
        Ok(Self { file, levels, directories, written, sections, failed: false })
    }

    /// Adds a level, whose tiles are empty until they are written, and
    /// returns its index. Views count from 0, and so do each view's levels,
    /// in the order in which they are added.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if the level's sizes or number break a rule;
    /// [`Error::Limit`] if the file would have more tiles than a reader
    /// accepts by default.
    pub fn add_level(&mut self, level: Level) -> Result<u32> {
        // A level has 2³² records at most.
        let index = self.levels.len() as u32;
        self.levels.push(level);
        let rule = level.broken_rule().or(broken_order(&self.levels).map(|(_, rule)| rule));
        let rule = rule.or_else(|| {
            usize::try_from(level.tile_count()).is_err().then_some("a level has too many tiles")
        });
        if let Some(rule) = rule {
            self.levels.pop();
            return Err(Error::setting(rule));
        }
        let tiles = self.levels.iter().map(Level::tile_count).fold(0, u64::saturating_add);
        if let Err(error) = check_limit("tiles", tiles, Limits::default().max_tiles) {
            self.levels.pop();
            return Err(error);
        }
        self.written.push(vec![false; level.tile_count() as usize]);
        self.directories.push(TileDirectory::clear(index, level.tiles()));
        Ok(index)
    }

    /// Sets the tolerance of a level, which tiles that follow have to keep.
    pub(crate) fn set_tolerance(&mut self, level: u32, tolerance: f32) {
        if let Some(level) = self.levels.get_mut(level as usize) {
            level.tolerance = tolerance;
        }
    }

    /// The levels added so far.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Writes a tile. Tiles come in any order, each at most once; one that
    /// never comes is empty. The same tiles in the same order give the same
    /// bytes.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`], [`Error::WrittenTwice`]; [`Error::Tile`] if
    /// the error breaks a rule or the level's tolerance, or what the tile
    /// says of itself does; [`Error::TileTooLarge`] if readers would refuse it;
    /// [`Error::File`] if
    /// the file cannot be written, and then it cannot be finished.
    pub fn write_tile(
        &mut self,
        id: TileId,
        tile: &EncodedTile,
        error: AchievedError,
    ) -> Result<()> {
        let level = self.levels.get(id.level as usize).ok_or(Error::NoSuchTile(id))?;
        level.tile_rect(id.x, id.y).ok_or(Error::NoSuchTile(id))?;
        if let Some(rule) = error.broken_rule() {
            return Err(Error::Tile { id, rule: rule.into() });
        }
        if !error.is_within(level.tolerance) {
            return Err(Error::Tile {
                id,
                rule: format!(
                    "its error {} is more than the level's tolerance {}",
                    error.max, level.tolerance
                )
                .into(),
            });
        }
        check_tile_bytes(tile.raw_length.max(tile.bytes.len() as u64))?;
        let entry = TileEntry { stored_length: tile.bytes.len() as u64, error, ..tile.entry() };
        // Where it will stand is not known yet: anywhere but at 0.
        let offset = u64::from(!tile.bytes.is_empty());
        if let Some(rule) = (TileEntry { offset, ..entry }).broken_rule() {
            return Err(Error::Tile { id, rule: rule.into() });
        }
        let index = id.y as usize * level.tiles()[0] as usize + id.x as usize;
        if std::mem::replace(&mut self.written[id.level as usize][index], true) {
            return Err(Error::WrittenTwice(id));
        }
        let contents = if tile.bytes.is_empty() {
            entry
        } else {
            let Extent { offset, crc, .. } = self.append(&tile.bytes)?;
            TileEntry { offset, crc, ..entry }
        };
        if let Some(entry) = self.directories[id.level as usize].get_mut(id.x, id.y) {
            *entry = contents;
        }
        Ok(())
    }

    /// Adds an optional section: readers that don't know its kind skip it.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if the file cannot be written; [`Error::Setting`] for a
    /// kind that this program writes itself.
    pub fn write_section(&mut self, kind: SectionKind, bytes: &[u8]) -> Result<()> {
        if kind.is_known() {
            return Err(Error::setting(format!("section \"{kind}\" is written by the writer")));
        }
        self.append_section(kind, false, bytes)
    }

    fn append_section(&mut self, kind: SectionKind, required: bool, bytes: &[u8]) -> Result<()> {
        let extent = self.append(bytes)?;
        self.sections.push(Section { kind, required, extent });
        Ok(())
    }

    fn append(&mut self, bytes: &[u8]) -> Result<Extent> {
        if self.failed {
            let error = Error::Path("an earlier part of the file could not be written");
            return Err(error.in_file(Some(self.file.path())));
        }
        let (offset, length) = (self.file.length(), bytes.len() as u64);
        let padding = padding(length);
        let written = self.file.append(bytes).and_then(|()| self.file.append(padding));
        self.failed = written.is_err();
        written.map_err(|error| error.in_file(Some(self.file.path())))?;
        Ok(Extent { offset, length, crc: checksum(&[bytes, padding]) })
    }

    /// Writes the metadata, one JSON object with a `kind`, and all else that
    /// is missing; puts the file in its place. Returns its length in bytes.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if the file cannot be written or moved into place;
    /// what had its name stays then. [`Error::Setting`] without any level.
    pub fn finish(mut self, metadata: &[u8]) -> Result<u64> {
        let path = self.file.path().to_owned();
        let finished = self.write_end(metadata).and_then(|prologue| {
            self.file.commit(&prologue.encode())?;
            Ok(prologue.file_length)
        });
        finished.map_err(|error| error.in_file(path.as_path()))
    }

    fn write_end(&mut self, metadata: &[u8]) -> Result<Prologue> {
        if self.levels.is_empty() {
            return Err(Error::setting("a map has at least one level"));
        }
        self.append_section(SectionKind::METADATA, true, metadata)?;
        let mut records = Vec::new();
        for (mut level, directory) in
            std::mem::take(&mut self.levels).into_iter().zip(std::mem::take(&mut self.directories))
        {
            level.error = directory.error_of(&level);
            // A file has 2³² sections at most.
            records.extend(level.encode(self.sections.len() as u32));
            let entries: Vec<u8> = directory.iter().flat_map(|(_, entry)| entry.encode()).collect();
            self.append_section(SectionKind::DIRECTORY, true, &entries)?;
        }
        self.append_section(SectionKind::LEVELS, true, &records)?;
        let section_count = u32::try_from(self.sections.len())
            .map_err(|_| Error::setting("a file holds at most 2³² − 1 sections"))?;
        let table: Vec<u8> = self.sections.iter().flat_map(Section::encode).collect();
        let table = self.append(&table)?;
        Ok(Prologue { minor: MINOR, file_length: self.file.length(), table, section_count })
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::{self, Seek, SeekFrom, Write};

    use super::*;
    use crate::format::atomic_file::OutputFile;

    /// A file on a disk with room for so many bytes, that may fail to sync.
    struct FullDisk {
        file: File,
        room: usize,
        syncs: bool,
    }

    impl Write for FullDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.room == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let written = self.file.write(&bytes[..bytes.len().min(self.room)])?;
            self.room -= written;
            Ok(written)
        }

        fn flush(&mut self) -> io::Result<()> {
            self.file.flush()
        }
    }

    impl Seek for FullDisk {
        fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
            self.file.seek(position)
        }
    }

    impl OutputFile for FullDisk {
        fn sync(&mut self) -> io::Result<()> {
            if self.syncs { Ok(()) } else { Err(io::Error::other("the disk went away")) }
        }
    }

    /// Writes a map with a tile of `bytes`; which calls failed.
    fn write(path: &Path, room: usize, syncs: bool, bytes: usize) -> [Result<()>; 2] {
        let file = AtomicFile::create_with(path, |file| Box::new(FullDisk { file, room, syncs }));
        let mut writer = ContainerWriter::start(file.unwrap()).unwrap();
        writer.add_level(Level::new(1, 1, 1, 0.0)).unwrap();
        let tile = EncodedTile { bytes: vec![1; bytes], raw_length: 1, ..EncodedTile::default() };
        let written = writer.write_tile(TileId::default(), &tile, AchievedError::NONE);
        [written, writer.finish(b"{}").map(drop)]
    }

    /// What the operating system said: the source, below the file's name.
    fn cause(error: &Error) -> &io::Error {
        std::error::Error::source(error).unwrap().downcast_ref().unwrap()
    }

    #[test]
    fn a_full_disk_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.dsm");
        let check_old = || {
            assert_eq!(std::fs::read(&path).unwrap(), b"old");
            assert_eq!(folder.path().read_dir().unwrap().count(), 1);
        };
        std::fs::write(&path, b"old").unwrap();
        // Prologue, tile, metadata, directory, level, table, prologue again.
        let needed = 64 * 6 + 128;
        for room in 0..needed {
            let [tile, finish] = write(&path, room, true, 10);
            assert!(tile.is_ok());
            let error = finish.unwrap_err();
            assert!(error.to_string().ends_with("map.dsm: cannot write"), "{error}");
            assert_eq!(cause(&error).kind(), io::ErrorKind::StorageFull);
            check_old();
        }
        let [_, finish] = write(&path, needed, false, 10);
        assert!(cause(&finish.unwrap_err()).to_string().contains("the disk went away"));
        check_old();
        let [_, finish] = write(&path, needed, true, 10);
        finish.unwrap();
        assert_ne!(std::fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn what_failed_once_cannot_be_finished() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.dsm");
        // More than the buffer, so that the tile itself fails.
        let [tile, finish] = write(&path, 1000, true, 1 << 20);
        assert!(tile.unwrap_err().to_string().contains("cannot write"));
        assert!(finish.unwrap_err().to_string().contains("an earlier part"));
        assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    }
}

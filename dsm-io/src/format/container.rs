//! A file's sections, levels and tiles, whatever they mean.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::directory::{ENTRY_BYTES, TileDirectory, TileEntry};
use super::extent::check_cover;
use super::level::{LEVEL_BYTES, Level, broken_order};
use super::prologue::{PROLOGUE_BYTES, Prologue};
use super::section::{SECTION_ENTRY_BYTES, Section};
use crate::achieved_error::AchievedError;
use crate::error::{Error, Result};
use crate::error::{Place, check_limit};
use crate::limits::Limits;
use crate::section_kind::SectionKind;
use crate::source::Source;
use crate::source::mapped::MappedFile;
use crate::source::memory::Memory;
use crate::source::ranges::FileRanges;
use crate::source::remote::RemoteSource;
use crate::tile_id::{TileId, TileRect};

/// An open `.dsm` file of any kind of map.
///
/// Opening checks every length against the file and the [`Limits`] before
/// memory is taken for it, that the parts of the file cover it exactly, and
/// the checksums of all it reads: everything but the tiles and unknown
/// sections. O(t log t) for t tiles.
///
/// ```
/// use dsm_core::detail::PixelLists;
/// use dsm_core::{DeepMap, MapInfo};
/// use dsm_io::detail::Container;
/// use dsm_io::{Limits, Metadata, WriteOptions, write_map};
/// # use dsm_io::AchievedError;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("clear.dsm");
/// let clear = DeepMap::new(MapInfo::default(), PixelLists::<f32>::clear(100, 50));
/// let metadata = Metadata::new(100, 50, 1, MapInfo::default());
/// write_map(&path, metadata, &clear, AchievedError::NONE, WriteOptions::default())?;
///
/// let container = Container::open(&path, &Limits::default())?;
/// assert_eq!(container.kind()?, "deep");
/// assert_eq!(container.levels()[0].tiles(), [2, 1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Container {
    source: Box<dyn Source>,
    path: Option<PathBuf>,
    minor: u16,
    sections: Vec<Section>,
    metadata: Vec<u8>,
    levels: Vec<Level>,
    directories: Vec<TileDirectory>,
}

impl Container {
    /// Opens a file, or the one at an address such as `s3://maps/key.dsm`
    /// ([`dsm_remote`]). Its tiles are read as they are asked for, each into memory of
    /// its own: somebody who writes to the file or cuts it meanwhile causes errors, and
    /// nothing worse.
    ///
    /// # Errors
    ///
    /// [`Error::File`], naming the file, with what is wrong with it.
    pub fn open(path: impl AsRef<Path>, limits: &Limits) -> Result<Self> {
        let path = path.as_ref();
        if dsm_remote::is_url(path) {
            return Self::open_as(path, RemoteSource::open, limits);
        }
        Self::open_as(path, FileRanges::open, limits)
    }

    /// Maps a file into memory: plain tiles are used where they lie, without a copy. An
    /// address is opened as by [`Self::open`].
    ///
    /// Only for files that nobody changes while they are mapped. Who cuts one makes
    /// the operating system end this process (SIGBUS); of one that is written to, what
    /// was checked may no longer be what is used. Files written by this crate are
    /// replaced whole.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_mapped(path: impl AsRef<Path>, limits: &Limits) -> Result<Self> {
        let path = path.as_ref();
        if dsm_remote::is_url(path) {
            return Self::open(path, limits);
        }
        Self::open_as(path, MappedFile::open, limits)
    }

    fn open_as<S: Source + 'static>(
        path: &Path,
        open: impl FnOnce(&Path) -> Result<S>,
        limits: &Limits,
    ) -> Result<Self> {
        open(path)
            .and_then(|source| Self::read(Box::new(source), Some(path), limits))
            .map_err(|error| error.in_file(Some(path)))
    }

    /// Opens the file at an address of an object store, with these options.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_remote(
        address: impl AsRef<Path>,
        options: &dsm_remote::RemoteOptions,
        limits: &Limits,
    ) -> Result<Self> {
        let address = address.as_ref();
        RemoteSource::open_with(address, options)
            .and_then(|source| Self::read(Box::new(source), Some(address), limits))
            .map_err(|error| error.in_file(Some(address)))
    }

    /// Reads a whole file into memory.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_in_memory(path: impl AsRef<Path>, limits: &Limits) -> Result<Self> {
        let path = path.as_ref();
        if dsm_remote::is_url(path) {
            // Nothing shortens what is opened there: a replaced one is an error.
            return Self::open(path, limits);
        }
        let read = |path: &Path| Memory::read(path, limits.max_in_memory_bytes);
        Self::open_as(path, read, limits)
    }

    /// Opens a file that `source` holds.
    ///
    /// # Errors
    ///
    /// What is wrong with it.
    pub fn from_source(source: impl Source + 'static, limits: &Limits) -> Result<Self> {
        Self::read(Box::new(source), None, limits)
    }

    fn read(source: Box<dyn Source>, path: Option<&Path>, limits: &Limits) -> Result<Self> {
        let file = &*source;
        let length = file.length();
        let start = file.read(0..length.min(PROLOGUE_BYTES as u64))?;
        let prologue = Prologue::decode(&start, length)?;
        drop(start);
        let sections = read_sections(file, &prologue, limits)?;
        let (levels, directories) = read_levels(file, &sections, prologue.minor, limits)?;
        let (index, section) = find(&sections, SectionKind::METADATA)?;
        check_limit("bytes of metadata", section.extent.length, limits.max_header_bytes)?;
        let metadata = section.extent.bytes(file, section.place(index))?.into_owned();
        let mut extents =
            vec![(Prologue::extent(), Place::Prologue), (prologue.table, Place::SectionTable)];
        extents.extend(
            (0..).zip(&sections).map(|(index, section)| (section.extent, section.place(index))),
        );
        extents.extend(
            directories
                .iter()
                .flat_map(TileDirectory::iter)
                .filter(|(_, entry)| !entry.is_empty())
                .map(|(id, entry)| (entry.extent(), Place::Entry(id))),
        );
        check_cover(extents, prologue.file_length)?;
        source.opened();
        let path = path.map(Path::to_owned);
        let minor = prologue.minor;
        Ok(Self { path, minor, sections, metadata, levels, directories, source })
    }

    /// An answer whose error names the file, if it has a name and the error does
    /// not say it already.
    ///
    /// # Errors
    ///
    /// That of the answer, as an [`Error::File`].
    pub fn in_file<V>(&self, answer: Result<V>) -> Result<V> {
        answer.map_err(|error| error.in_file(self.path()))
    }

    /// The file's path, if it has one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// What a user should know of how far the file's bytes can be relied on, if
    /// anything: one sentence without a full stop.
    #[must_use]
    pub fn remark(&self) -> Option<&str> {
        self.source.remark()
    }

    /// The file's major and minor version.
    #[must_use]
    pub const fn version(&self) -> [u16; 2] {
        [super::version::MAJOR, self.minor]
    }

    /// Length of the file, in bytes.
    #[must_use]
    pub fn file_length(&self) -> u64 {
        self.source.length()
    }

    /// The levels, finest first, view by view.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The level with this index.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`].
    pub fn level(&self, level: u32) -> Result<&Level> {
        self.levels.get(level as usize).ok_or(Error::NoSuchLevel(level))
    }

    /// Number of views: at least 1.
    #[must_use]
    pub fn view_count(&self) -> u32 {
        // Views count from 0, without gaps.
        self.levels.last().map_or(0, |level| level.view + 1)
    }

    /// The levels of a view and their indices, finest first; none of a view that
    /// there is not.
    pub fn view(&self, view: u32) -> impl ExactSizeIterator<Item = (u32, &Level)> {
        let first = self.levels.partition_point(|level| level.view < view);
        let count = self.levels[first..].partition_point(|level| level.view == view);
        // A file has 2³² levels at most.
        let indexed = self.levels[first..first + count].iter().enumerate();
        indexed.map(move |(number, level)| ((first + number) as u32, level))
    }

    /// The index of the level with this number in a view, 0 for the finest.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`] with the number.
    pub fn level_of_view(&self, view: u32, number: u32) -> Result<u32> {
        let found = self.view(view).nth(number as usize);
        found.map(|(index, _)| index).ok_or(Error::NoSuchLevel(number))
    }

    /// The tile directory of the level with this index.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchLevel`].
    pub fn directory(&self, level: u32) -> Result<&TileDirectory> {
        self.directories.get(level as usize).ok_or(Error::NoSuchLevel(level))
    }

    /// The directory entry of a tile, and the pixels that it covers.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`].
    pub fn entry(&self, id: TileId) -> Result<(&TileEntry, TileRect)> {
        let rect = self.levels.get(id.level as usize).and_then(|level| level.tile_rect(id.x, id.y));
        let directory = self.directories.get(id.level as usize);
        let entry = directory.and_then(|directory| directory.get(id.x, id.y));
        entry.zip(rect).ok_or(Error::NoSuchTile(id))
    }

    /// The stored bytes of a tile, their checksum checked; none if the tile
    /// is empty. O(bytes).
    ///
    /// # Errors
    ///
    /// [`Error::Checksum`] or [`Error::NoSuchTile`].
    pub fn payload(&self, id: TileId) -> Result<Cow<'_, [u8]>> {
        let (entry, _) = self.entry(id)?;
        if entry.is_empty() {
            return Ok(Cow::Borrowed(&[]));
        }
        entry.extent().bytes(&*self.source, entry.place(id))
    }

    /// The metadata, one JSON object.
    #[must_use]
    pub fn metadata(&self) -> &[u8] {
        &self.metadata
    }

    /// The kind of map that the metadata names.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`] if it names none.
    pub fn kind(&self) -> Result<String> {
        #[derive(serde::Deserialize)]
        struct Kind {
            kind: String,
        }
        let kind = serde_json::from_slice::<Kind>(&self.metadata);
        kind.map(|kind| kind.kind).map_err(Error::Json)
    }

    /// The kinds of all sections.
    pub fn sections(&self) -> impl ExactSizeIterator<Item = SectionKind> {
        self.sections.iter().map(|section| section.kind)
    }

    /// The bytes of section `index`, their checksum checked.
    ///
    /// # Errors
    ///
    /// [`Error::Checksum`], or [`Error::NoSuchSection`] if there is no such section.
    pub fn section(&self, index: u32) -> Result<Cow<'_, [u8]>> {
        let section = self.sections.get(index as usize);
        let section = section.ok_or(Error::NoSuchSection(index))?;
        section.extent.bytes(&*self.source, section.place(index))
    }
}

impl Container {
    /// Looks for everything that can be wrong with a file of any kind: every
    /// checksum, whether what the directories and levels state of the tiles is
    /// true, and `check_tile` of every tile that is not empty. `tolerance` is
    /// what the metadata state. Empty if nothing is wrong.
    #[must_use]
    pub fn verify(
        &self,
        tolerance: f32,
        mut check_tile: impl FnMut(TileId) -> Result<()>,
    ) -> Vec<Error> {
        let mut errors = Vec::new();
        for (index, _) in (0..).zip(self.sections()) {
            errors.extend(self.section(index).err());
        }
        let mut wrong_tiles = self.check_tiles(&mut check_tile).into_iter().peekable();
        for ((index, level), directory) in (0..).zip(&self.levels).zip(&self.directories) {
            for (id, entry) in directory.iter() {
                errors.extend(wrong_tiles.next_if(|(of, _)| *of == id).map(|(_, error)| error));
                if !entry.error.is_within(level.tolerance) {
                    let reason = "its error is more than the level's tolerance";
                    errors.push(Error::invalid(Place::Entry(id), reason));
                }
            }
            let AchievedError { max, mean } = directory.error_of(level);
            let is_mean = (level.error.mean - mean).abs() <= 1e-6 * mean;
            if level.error.max != max || !is_mean {
                let reason = "its error is not that of its tiles";
                errors.push(Error::invalid(Place::Level(index), reason));
            }
        }
        if self.levels.first().is_some_and(|level| level.tolerance != tolerance) {
            let reason = "the metadata state another tolerance";
            errors.push(Error::invalid(Place::Level(0), reason));
        }
        errors.into_iter().map(|error| error.in_file(self.path())).collect()
    }

    /// Checks every tile in the order of the file, which sources that read ahead are
    /// quickest in. What is wrong comes in the order of levels and rows.
    fn check_tiles(
        &self,
        check_tile: &mut impl FnMut(TileId) -> Result<()>,
    ) -> Vec<(TileId, Error)> {
        let tiles = self.directories.iter().flat_map(TileDirectory::iter);
        // Of an empty tile the directory says all, and was checked.
        let stored = tiles.filter(|(_, entry)| !entry.is_empty());
        let mut stored: Vec<_> = stored.map(|(id, entry)| (entry.offset, id)).collect();
        stored.sort_unstable_by_key(|&(offset, _)| offset);
        let wrong = stored.into_iter().filter_map(|(_, id)| Some((id, check_tile(id).err()?)));
        let mut wrong: Vec<_> = wrong.collect();
        wrong.sort_by_key(|(id, _)| (id.level, id.y, id.x));
        wrong
    }
}

fn read_sections(file: &dyn Source, prologue: &Prologue, limits: &Limits) -> Result<Vec<Section>> {
    let place = Place::SectionTable;
    check_limit("sections", prologue.section_count.into(), limits.max_sections.into())?;
    let table = prologue.table.bytes(file, place)?;
    let records = (0..).zip(table.chunks_exact(SECTION_ENTRY_BYTES));
    records
        .map(|(index, bytes)| Section::decode(bytes, index, prologue.minor, prologue.file_length))
        .collect()
}

/// The only section of a kind, and its index.
fn find(sections: &[Section], kind: SectionKind) -> Result<(u32, &Section)> {
    let mut found = (0..).zip(sections).filter(|(_, section)| section.kind == kind);
    match (found.next(), found.next()) {
        (Some(section), None) => Ok(section),
        (None, _) => {
            Err(Error::invalid(Place::SectionTable, format!("there is no section \"{kind}\"")))
        }
        (Some(_), Some((index, section))) => {
            Err(Error::invalid(section.place(index), "there is another section of this kind"))
        }
    }
}

fn read_levels(
    file: &dyn Source,
    sections: &[Section],
    minor: u16,
    limits: &Limits,
) -> Result<(Vec<Level>, Vec<TileDirectory>)> {
    let (index, section) = find(sections, SectionKind::LEVELS)?;
    let place = section.place(index);
    let count = section.extent.length / LEVEL_BYTES as u64;
    if count == 0 || !section.extent.length.is_multiple_of(LEVEL_BYTES as u64) {
        return Err(Error::invalid(place, "it must hold one or more records of 64 bytes"));
    }
    check_limit("levels", count, limits.max_levels.into())?;
    let records = section.extent.bytes(file, place)?;
    let (mut levels, mut directories) = (Vec::new(), Vec::new());
    let mut claimed = vec![false; sections.len()];
    let mut tiles = 0_u64;
    for (index, record) in (0..).zip(records.chunks_exact(LEVEL_BYTES)) {
        let (level, directory) = Level::decode(record, index, minor)?;
        let refuse = |reason| Err(Error::invalid(Place::Level(index), reason));
        let section = match sections.get(directory as usize) {
            Some(section) if section.kind == SectionKind::DIRECTORY => section,
            _ => return refuse("its tile directory is no such section"),
        };
        if std::mem::replace(&mut claimed[directory as usize], true) {
            return refuse("its tile directory belongs to another level");
        }
        tiles = tiles.saturating_add(level.tile_count());
        check_limit("tiles", tiles, limits.max_tiles)?;
        if section.extent.length != level.tile_count() * ENTRY_BYTES as u64 {
            return refuse("its tile directory does not hold one entry a tile");
        }
        let bytes = section.extent.bytes(file, section.place(directory))?;
        let [columns, _] = level.tiles();
        let file_length = file.length();
        directories.push(TileDirectory::decode(&bytes, (index, columns), minor, file_length)?);
        levels.push(level);
    }
    if let Some((index, reason)) = broken_order(&levels) {
        return Err(Error::invalid(Place::Level(index), reason));
    }
    let unclaimed = |(index, section): &(u32, &Section)| {
        section.kind == SectionKind::DIRECTORY && !claimed[*index as usize]
    };
    match (0..).zip(sections).find(unclaimed) {
        None => Ok((levels, directories)),
        Some((index, section)) => {
            Err(Error::invalid(section.place(index), "it belongs to no level"))
        }
    }
}

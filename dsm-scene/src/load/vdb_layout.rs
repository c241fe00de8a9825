//! Layout of an OpenVDB file.
//!
//! The library that decodes the values takes the file at its word: it panics at
//! what it doesn't know, takes memory for whatever length is stated, and hands
//! blocks to a decompressor that trusts theirs. So the whole layout is walked
//! here first, and only files pass whose every length is covered by bytes.

use std::collections::HashSet;

use crate::error::{Error, Place, Result};

/// "BDV " and four zeros, little endian.
const MAGIC: u64 = 0x5644_4220;
/// Versions whose nodes carry masks and a compression of their own.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
const ZIP: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;
/// Voxels farther out would not be told apart in `f32`.
const MAX_DISTANCE: i32 = 1 << 24;
/// Size of the header of a Blosc block, in bytes.
const BLOSC_HEADER: usize = 16;

/// The header of a grid.
#[derive(Clone, Debug)]
pub(super) struct GridLayout {
    pub(super) name: String,
    kind: String,
    parent: String,
    grid: usize,
    blocks: usize,
}

/// The grids of a file, once its header has been found sound.
pub(super) fn grids(bytes: &[u8]) -> Result<Vec<GridLayout>> {
    let mut file = Cursor { bytes, at: 0 };
    let refuse = |reason: String| Err(Error::malformed(Place::Header, reason));
    if bytes.len() < 8 || file.u64()? != MAGIC {
        return refuse("not an OpenVDB file".into());
    }
    let version = file.u32()?;
    if !VERSIONS.contains(&version) {
        let (first, last) = (VERSIONS.start(), VERSIONS.end());
        return refuse(format!("unsupported version {version}: only {first} to {last}"));
    }
    file.take(8)?;
    if file.u8()? != 1 {
        return refuse("unsupported: file without grid offsets".into());
    }
    file.take(36)?;
    file.metadata()?;
    let count = file.u32()?;
    let mut grids = Vec::new();
    let mut names = HashSet::new();
    for _ in 0..count {
        let (name, kind, parent) = (file.name()?, file.name()?, file.name()?);
        let [grid, blocks, end] = [file.u64()?, file.u64()?, file.u64()?];
        if !names.insert(name.clone()) {
            return refuse(format!("duplicate grid `{name}`"));
        }
        let [grid, blocks, end] =
            [grid, blocks, end].map(|at| usize::try_from(at).unwrap_or(usize::MAX));
        let mut inner = file.at(grid)?;
        inner.compression()?;
        inner.metadata()?;
        grids.push(GridLayout { name, kind, parent, grid, blocks });
        file = file.at(end)?;
    }
    Ok(grids)
}

/// Checks all of a grid of floats.
pub(super) fn check_grid(bytes: &[u8], grid: &GridLayout) -> Result<()> {
    let named = |reason: String| {
        Err(Error::malformed(Place::Named(format!("grid `{}`", grid.name)), reason))
    };
    if !grid.kind.starts_with("Tree_float_5_4_3") || !grid.parent.is_empty() {
        return named(format!(
            "unsupported grid {}: only Tree_float_5_4_3, and no instances",
            grid.kind
        ));
    }
    let mut file = Cursor { bytes, at: 0 }.at(grid.grid)?;
    let compression = file.compression()?;
    let half = file.metadata()?;
    let map = file.name()?;
    let numbers = match map.as_str() {
        "UniformScaleMap" => 15,
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => 18,
        _ => return named(format!("unsupported transform {map}")),
    };
    file.take(numbers * 8)?;
    if file.u32()? != 1 {
        return named("unsupported: tree of several buffers".into());
    }
    file.u32()?;
    let (tiles, roots) = (file.u32()?, file.u32()?);
    for _ in 0..tiles {
        file.take(16)?;
        if file.u8()? != 0 {
            return named("unsupported: active tiles of 4096 voxels per side".into());
        }
    }
    let values = Values { compression, size: if half { 2 } else { 4 } };
    let mut leaves = 0_u64;
    for _ in 0..roots {
        for _ in 0..3 {
            let at = file.at;
            if !(-MAX_DISTANCE..=MAX_DISTANCE).contains(&(file.u32()? as i32)) {
                let place = Place::Byte(at as u64);
                return Err(Error::malformed(place, "a node lies beyond ±2^24 voxels"));
            }
        }
        let children = values.node(&mut file, 32_768)?;
        for _ in 0..children {
            let own = values.node(&mut file, 4096)?;
            file.take(u64::from(own) as usize * 64)?;
            leaves += u64::from(own);
        }
    }
    let mut file = file.at(grid.blocks)?;
    for _ in 0..leaves {
        let mask = file.take(64)?;
        values.skip(&mut file, 512, ones(mask))?;
    }
    Ok(())
}

fn ones(mask: &[u8]) -> u32 {
    mask.iter().map(|byte| byte.count_ones()).sum()
}

/// The storage of a grid's values.
struct Values {
    compression: u32,
    size: usize,
}

impl Values {
    /// Walks over an inner node of `count` places; how many children it has.
    fn node(&self, file: &mut Cursor<'_>, count: usize) -> Result<u32> {
        let children = ones(file.take(count / 8)?);
        let active = ones(file.take(count / 8)?);
        self.skip(file, count, active)?;
        Ok(children)
    }

    /// Walks over the values of a node of `count` places, `active` of them
    /// active.
    fn skip(&self, file: &mut Cursor<'_>, count: usize, active: u32) -> Result<()> {
        let start = file.at;
        let refuse =
            |reason: &'static str| Err(Error::malformed(Place::Byte(start as u64), reason));
        let kind = file.u8()?;
        match kind {
            0 | 1 | 6 => {}
            2 => _ = file.take(4)?,
            3 => _ = file.take(count / 8)?,
            4 => _ = file.take(4 + count / 8)?,
            5 => _ = file.take(8 + count / 8)?,
            _ => return refuse("unknown storage of a node's values"),
        }
        let masked = self.compression & ACTIVE_MASK != 0 && kind != 6;
        let stored = if masked { active as usize } else { count };
        let length = stored * self.size;
        if self.compression & (BLOSC | ZIP) == 0 {
            file.take(length)?;
            return Ok(());
        }
        let packed = file.u64()? as i64;
        if packed <= 0 {
            // Stored as it is, with the length negated.
            if packed.unsigned_abs() != length as u64 {
                return refuse("wrong length of a node's values");
            }
            file.take(length)?;
            return Ok(());
        }
        let block = file.take(usize::try_from(packed).unwrap_or(usize::MAX))?;
        if self.compression & BLOSC != 0 && stored > 0 {
            let word = |at: usize| {
                let bytes = block.get(at..at + 4)?.try_into().ok()?;
                usize::try_from(u32::from_le_bytes(bytes)).ok()
            };
            let sound = block.len() >= BLOSC_HEADER
                && word(4) == Some(length)
                && word(12) == Some(block.len());
            if !sound {
                return refuse("wrong length of a compressed block");
            }
        }
        Ok(())
    }
}

/// A place in the file that nothing is read beyond the end of.
#[derive(Clone, Copy)]
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let left = &self.bytes[self.at..];
        let Some(taken) = left.get(..count) else {
            let reason = format!("truncated: {count} bytes expected, {} left", left.len());
            return Err(Error::malformed(Place::Byte(self.at as u64), reason));
        };
        self.at += count;
        Ok(taken)
    }

    /// The file at another offset.
    fn at(self, at: usize) -> Result<Self> {
        if at <= self.bytes.len() {
            Ok(Self { at, ..self })
        } else {
            let reason = format!("offset {at} is outside the file of {} bytes", self.bytes.len());
            Err(Error::malformed(Place::Byte(self.at as u64), reason))
        }
    }

    fn u8(&mut self) -> Result<u8> {
        Ok(self.take(1)?[0])
    }

    fn u32(&mut self) -> Result<u32> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn u64(&mut self) -> Result<u64> {
        let low = self.u32()?;
        Ok(u64::from(low) | u64::from(self.u32()?) << 32)
    }

    /// A text, one character a byte as the decoder reads it.
    fn name(&mut self) -> Result<String> {
        let length = self.u32()?;
        Ok(self.take(length as usize)?.iter().map(|&byte| char::from(byte)).collect())
    }

    fn compression(&mut self) -> Result<u32> {
        let at = self.at;
        match self.u32()? {
            flags if flags <= ZIP | ACTIVE_MASK | BLOSC => Ok(flags),
            flags => Err(Error::malformed(
                Place::Byte(at as u64),
                format!("unknown compression {flags}"),
            )),
        }
    }

    /// Walks over metadata; whether it says that floats are stored as halves.
    fn metadata(&mut self) -> Result<bool> {
        let count = self.u32()?;
        let mut half = false;
        for _ in 0..count {
            let (name, kind) = (self.name()?, self.name()?);
            let length = self.u32()? as usize;
            let value = match kind.as_str() {
                "bool" => self.take(1)?,
                "int32" | "float" => self.take(4)?,
                "int64" => self.take(8)?,
                "vec3i" => self.take(12)?,
                _ => self.take(length)?,
            };
            if name == "is_saved_as_half_float" {
                half = kind == "bool" && value != [0];
            }
        }
        Ok(half)
    }
}

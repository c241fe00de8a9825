//! The tables of a binary file.

use super::compressed::{integers, unpack};
use super::cursor::Cursor;
use super::{CrateFile, MAGIC, PathNode};
use crate::error::{Error, Place, Result};
use crate::load::usd::layer::MAX_DEPTH;

/// Ends a set of fields.
const END: i64 = 0xffff_ffff;

/// Prims and properties with their fields, as tables.
pub(super) struct Sections {
    /// Token and value of each field.
    fields: Vec<(u32, u64)>,
    /// Indices of fields, set after set, each with an end.
    sets: Vec<i64>,
    /// Path, first field in `sets` and kind of each spec.
    pub(super) specs: Vec<(u32, i64, i64)>,
}

impl Sections {
    pub(super) fn read(bytes: Vec<u8>) -> Result<(CrateFile, Self)> {
        let mut header = Cursor::new(&bytes, 0)?;
        if header.take(8).ok() != Some(MAGIC) {
            return Err(Error::malformed(Place::Header, "not a binary USD file"));
        }
        let [major, minor, patch, ..] = header.array::<8>()?;
        let version = [major, minor, patch];
        if major != 0 || minor < 4 {
            let reason =
                format!("version {major}.{minor}.{patch} of the binary format is not read");
            return Err(Error::malformed(Place::Header, reason));
        }
        let mut places = Vec::new();
        let mut table = Cursor::new(&bytes, header.u64()?)?;
        for _ in 0..table.count(32)? {
            let name = table.take(16)?;
            let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
            places.push((name.to_vec(), table.u64()?));
            table.u64()?;
        }
        let section = |name: &str| {
            let missing =
                || Error::malformed(Place::Header, format!("the file has no section {name}"));
            let found = places.iter().find(|place| place.0 == name.as_bytes());
            Cursor::new(&bytes, found.ok_or_else(missing)?.1)
        };
        let (text, tokens) = read_tokens(section("TOKENS")?)?;
        let mut strings = section("STRINGS")?;
        let count = strings.count(4)?;
        let strings = (0..count).map(|_| strings.u32()).collect::<Result<Vec<_>>>()?;
        let fields = read_fields(section("FIELDS")?)?;
        let mut sets = section("FIELDSETS")?;
        let count = sets.u64()?;
        let sets = integers(&mut sets, count, 4)?.into_iter().map(|at| at & END).collect();
        let paths = read_paths(section("PATHS")?)?;
        let specs = read_specs(section("SPECS")?)?;
        let file = CrateFile { version, text, tokens, strings, paths, bytes: Vec::new() };
        Ok((CrateFile { bytes, ..file }, Self { fields, sets, specs }))
    }

    /// Names and values of the fields in the set that begins at `start`.
    pub(super) fn fields<'a>(
        &'a self,
        file: &'a CrateFile,
        start: i64,
    ) -> Result<Vec<(&'a str, u64)>> {
        let broken = || Error::malformed(Place::Whole, "a set of fields is out of range");
        let set = self.sets.get(start as usize..).ok_or_else(broken)?;
        let mut found = Vec::new();
        for &index in set.iter().take_while(|&&index| index != END) {
            // No spec has as many fields as this, and many may have the same set.
            if found.len() > 256 {
                return Err(broken());
            }
            let &(token, value) = self.fields.get(index as usize).ok_or_else(broken)?;
            found.push((file.token(token)?, value));
        }
        Ok(found)
    }
}

type Tokens = (Vec<u8>, Vec<(u32, u32)>);

fn read_tokens(mut cursor: Cursor<'_>) -> Result<Tokens> {
    let (count, size, packed) = (cursor.u64()?, cursor.u64()?, cursor.u64()?);
    let text = unpack(&mut cursor, packed, size)?;
    let mut tokens = Vec::new();
    let mut start = 0;
    // A token is short enough to stand in many places.
    for (end, _) in text.iter().enumerate().filter(|&(_, &byte)| byte == 0) {
        if tokens.len() as u64 == count {
            break;
        }
        if u32::try_from(end).is_err() {
            return Err(cursor.error("more than 4 GiB of tokens"));
        }
        tokens.push((start as u32, end as u32));
        start = end + 1;
    }
    if tokens.len() as u64 != count {
        return Err(cursor.error("there are fewer tokens than stated"));
    }
    Ok((text, tokens))
}

fn read_fields(mut cursor: Cursor<'_>) -> Result<Vec<(u32, u64)>> {
    let count = cursor.u64()?;
    let tokens = integers(&mut cursor, count, 4)?;
    let packed = cursor.u64()?;
    let values = unpack(&mut cursor, packed, count.saturating_mul(8))?;
    let values = values.as_chunks::<8>().0;
    if values.len() != tokens.len() {
        return Err(cursor.error("there are fewer values than fields"));
    }
    let values = values.iter().map(|&value| u64::from_le_bytes(value));
    Ok(tokens.into_iter().map(|token| token as u32).zip(values).collect())
}

fn read_specs(mut cursor: Cursor<'_>) -> Result<Vec<(u32, i64, i64)>> {
    let count = cursor.u64()?;
    let paths = integers(&mut cursor, count, 4)?;
    let sets = integers(&mut cursor, count, 4)?;
    let kinds = integers(&mut cursor, count, 4)?;
    let sets = sets.into_iter().map(|set| set & END);
    Ok(paths
        .into_iter()
        .zip(sets)
        .zip(kinds)
        .map(|((path, set), kind)| (path as u32, set, kind))
        .collect())
}

/// The tree of paths, written depth first: of each its place in the table, its last
/// element, and the distance to its next sibling; −1 has only a child, 0 only a
/// sibling, −2 neither.
fn read_paths(mut cursor: Cursor<'_>) -> Result<Vec<PathNode>> {
    let start = cursor;
    let broken = || start.error("the tree of paths is broken");
    let all = cursor.u64()?;
    let count = cursor.u64()?;
    let places = integers(&mut cursor, count, 4)?;
    let tokens = integers(&mut cursor, count, 4)?;
    let jumps = integers(&mut cursor, count, 4)?;
    if all > count.saturating_mul(2).saturating_add(16) {
        return Err(broken());
    }
    let mut paths = vec![PathNode::default(); all as usize];
    let mut done = vec![false; count as usize];
    // Else the parents of a path could lead back to it.
    let mut is_placed = vec![false; all as usize];
    // Elements that are read next, each with its parent.
    let mut open: Vec<(usize, Option<u32>)> = Vec::new();
    if count > 0 {
        open.push((0, None));
    }
    while let Some((mut at, mut parent)) = open.pop() {
        loop {
            if std::mem::replace(done.get_mut(at).ok_or_else(broken)?, true) {
                return Err(broken());
            }
            let (place, token, jump) = (places[at] as u32, tokens[at], jumps[at]);
            let depth = match parent {
                Some(parent) => paths[parent as usize].depth + 1,
                None => 0,
            };
            if usize::from(depth) > 2 * MAX_DEPTH {
                return Err(start.error("prims are nested too deep"));
            }
            if std::mem::replace(is_placed.get_mut(place as usize).ok_or_else(broken)?, true) {
                return Err(broken());
            }
            paths[place as usize] = PathNode {
                parent: parent.unwrap_or(place),
                token: token.unsigned_abs() as u32,
                is_property: token < 0,
                depth,
            };
            let (has_child, has_sibling) = (jump > 0 || jump == -1, jump >= 0);
            if has_child && has_sibling {
                open.push((at + jump as usize, parent));
            }
            if has_child {
                parent = Some(place);
            } else if !has_sibling {
                break;
            }
            at += 1;
        }
    }
    Ok(paths)
}

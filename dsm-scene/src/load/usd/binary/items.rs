//! Lists in binary files: of names, paths, references and times.

use super::CrateFile;
use super::cursor::Cursor;
use crate::error::{Error, Place, Result};
use crate::load::usd::value::{ListOp, Numbers, Reference, Stored, TimeOffset, Value};

type Item<T> = fn(&CrateFile, &mut Cursor<'_>) -> Result<T>;

impl CrateFile {
    /// A counted list.
    pub(super) fn items<T>(&self, cursor: &mut Cursor<'_>, item: Item<T>) -> Result<Vec<T>> {
        let count = cursor.count(4)?;
        let mut items = Vec::new();
        for _ in 0..count {
            items.push(item(self, cursor)?);
        }
        Ok(items)
    }

    /// An edit of a list.
    pub(super) fn list<T>(&self, cursor: &mut Cursor<'_>, item: Item<T>) -> Result<ListOp<T>> {
        let bits = cursor.u8()?;
        let mut list = ListOp::default();
        if bits & 1 != 0 {
            list.explicit = Some(Vec::new());
        }
        let mut next = |bit: u8| match bits & bit {
            0 => Ok(Vec::new()),
            _ => self.items(cursor, item),
        };
        let explicit = next(2)?;
        if !explicit.is_empty() {
            list.explicit = Some(explicit);
        }
        let added = next(4)?;
        list.prepended = next(32)?;
        list.appended = next(64)?;
        list.appended.extend(added);
        list.deleted = next(8)?;
        Ok(list)
    }

    pub(super) fn integer_list(&self, kind: u8, cursor: &mut Cursor<'_>) -> Result<ListOp<i64>> {
        self.list(
            cursor,
            match kind {
                36 => |_, cursor| Ok(i64::from(cursor.u32()? as i32)),
                38 => |_, cursor| Ok(i64::from(cursor.u32()?)),
                _ => |_, cursor| Ok(cursor.u64()? as i64),
            },
        )
    }

    pub(super) fn token_item(&self, cursor: &mut Cursor<'_>) -> Result<String> {
        self.token(cursor.u32()?).map(str::to_owned)
    }

    pub(super) fn string_item(&self, cursor: &mut Cursor<'_>) -> Result<String> {
        self.string(cursor.u32()?).map(str::to_owned)
    }

    pub(super) fn path_item(&self, cursor: &mut Cursor<'_>) -> Result<String> {
        self.path(cursor.u32()?)
    }

    pub(super) fn selection_item(&self, cursor: &mut Cursor<'_>) -> Result<(String, String)> {
        Ok((self.string_item(cursor)?, self.string_item(cursor)?))
    }

    pub(super) fn offset_item(&self, cursor: &mut Cursor<'_>) -> Result<TimeOffset> {
        Ok(TimeOffset { offset: cursor.f64()?, scale: cursor.f64()? })
    }

    pub(super) fn reference_item(&self, cursor: &mut Cursor<'_>) -> Result<Reference> {
        let (asset, path) = (self.string_item(cursor)?, self.path_or_none(cursor)?);
        let offset = self.offset_item(cursor)?;
        // Custom data: names, each with the distance to its value.
        for _ in 0..cursor.count(12)? {
            cursor.u32()?;
            *cursor = cursor.jump()?;
            cursor.u64()?;
        }
        Ok(Reference { asset, path, offset })
    }

    pub(super) fn payload_item(&self, cursor: &mut Cursor<'_>) -> Result<Reference> {
        let (asset, path) = (self.string_item(cursor)?, self.path_or_none(cursor)?);
        let has_offset = self.version >= [0, 8, 0];
        let offset = if has_offset { self.offset_item(cursor)? } else { TimeOffset::NONE };
        Ok(Reference { asset, path, offset })
    }

    /// A path, which may be the empty one.
    fn path_or_none(&self, cursor: &mut Cursor<'_>) -> Result<String> {
        let index = cursor.u32()?;
        match self.path(index) {
            Ok(path) if path != "/" => Ok(path),
            _ => Ok(String::new()),
        }
    }

    /// An array of numbers of words.
    pub(super) fn words<'a>(
        &'a self,
        at: u64,
        word: fn(&'a Self, u32) -> Result<&'a str>,
    ) -> Result<Value> {
        if at == 0 {
            return Ok(Value::Words(Vec::new()));
        }
        let mut cursor = self.cursor(at)?;
        let count = self.array_length(&mut cursor)?;
        if count > cursor.left() as u64 / 4 {
            return Err(cursor.error("an array is longer than the file"));
        }
        let mut words = Vec::new();
        let mut length = 0;
        for _ in 0..count {
            let word = word(self, cursor.u32()?)?;
            length += word.len();
            // One long word may stand in many places.
            if length > self.bytes.len().saturating_mul(16) {
                return Err(cursor.error("an array of words is too long"));
            }
            words.push(word.to_owned());
        }
        Ok(Value::Words(words))
    }

    pub(super) fn doubles(&self, cursor: &mut Cursor<'_>) -> Result<Value> {
        let count = cursor.count(8)?;
        let data = (0..count).map(|_| cursor.f64()).collect::<Result<_>>()?;
        Ok(Value::Numbers(Numbers { size: 1, is_array: true, data, ..Numbers::default() }))
    }

    /// Times, and where their values are.
    pub(super) fn samples(&self, start: Cursor<'_>) -> Result<Vec<(f64, Stored)>> {
        let mut cursor = { start }.jump()?;
        let times = cursor.u64()?;
        let mut cursor = cursor.jump()?;
        let Value::Numbers(times) = self.value_of_times(times)? else {
            return Err(start.error("times are no numbers"));
        };
        let count = cursor.count(8)?;
        if count != times.data.len() as u64 {
            return Err(start.error("not as many values as times"));
        }
        let mut samples: Vec<(f64, Stored)> = Vec::new();
        for time in times.data {
            if !time.is_finite() || samples.last().is_some_and(|last| last.0 >= time) {
                return Err(start.error("times are not in order"));
            }
            samples.push((time, Stored::Packed(cursor.u64()?)));
        }
        Ok(samples)
    }

    /// The list of times: never one that leads to times again.
    fn value_of_times(&self, packed: u64) -> Result<Value> {
        match (packed >> 48) as u8 {
            9 | 48 => self.value(packed),
            _ => Err(Error::malformed(Place::Whole, "times are no numbers")),
        }
    }
}

//! The stored numbers of a level's pixels, as a page holds them.
//!
//! Everything is a column of 32-bit words: the lists of each pixel, the rows of each list where
//! a pixel has several, and each number of a row. A word of a row stands as its XOR with one of
//! the row before, so that what stays the same is 0. A column's lowest bytes come first, then the
//! next ones; all columns are one zlib stream.

use deepshadow::files::PixelContents;
use deepshadow::files::detail::PixelValue;
use miniz_oxide::deflate::compress_to_vec_zlib;
use serde::Serialize;

/// Numbers a page is made with at best: the time of level 6 is less than what is read takes.
const EFFORT: u8 = 6;

/// What the words of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Type {
    /// The bits of a float.
    Number,
    /// The bits of a float a channel.
    Light,
    Count,
    /// The lower half, then the upper one.
    Mask,
}

/// A column, as the page is told of it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ColumnHead {
    name: &'static str,
    r#type: Type,
    /// Words a row.
    words: usize,
    /// The column whose words of the row before are taken off.
    before: usize,
}

/// The columns of a level, pixel after pixel.
#[derive(Debug, Default)]
pub(super) struct LevelColumns {
    /// Lists of each pixel, or its rows where there are no lists.
    lists: Vec<u32>,
    rows: Vec<u32>,
    has_lists: bool,
    heads: Vec<ColumnHead>,
    words: Vec<Vec<u32>>,
}

impl LevelColumns {
    /// No pixels yet. `names`: columns that must be there, whatever the first pixel has.
    pub(super) fn new(names: &[&'static str]) -> Self {
        let mut columns = Self::default();
        columns.add_heads(names);
        columns
    }

    fn add_heads(&mut self, names: &[&'static str]) {
        for &name in names {
            let head = ColumnHead { name, r#type: Type::Number, words: 1, before: 0 };
            self.heads.push(head);
        }
        let behind = self.heads.iter().position(|head| head.name == "V at and behind");
        for (index, head) in self.heads.iter_mut().enumerate() {
            head.before = behind.filter(|_| head.name == "V before").unwrap_or(index);
        }
    }

    /// Adds a pixel. Its columns are those of the first one; a number that it has not is that of
    /// its first column.
    pub(super) fn push(&mut self, contents: &PixelContents) {
        if self.heads.is_empty() {
            self.add_heads(contents.columns());
        }
        self.has_lists |= contents.has_lists();
        if contents.has_lists() {
            self.lists.push(contents.lists().count() as u32);
            self.rows.extend(contents.lists().map(|list| list.len() as u32));
        } else {
            self.lists.push(contents.rows().len() as u32);
        }
        let places: Vec<usize> = self
            .heads
            .iter()
            .map(|head| contents.columns().iter().position(|name| *name == head.name).unwrap_or(0))
            .collect();
        for row in contents.rows() {
            if self.words.is_empty() {
                self.set_types(&places, row);
            }
            let mut columns = self.words.iter_mut();
            for (head, &place) in self.heads.iter().zip(&places) {
                let words = words(row[place]);
                columns
                    .by_ref()
                    .take(head.words)
                    .zip(words)
                    .for_each(|(column, word)| column.push(word));
            }
        }
    }

    fn set_types(&mut self, places: &[usize], row: &[PixelValue]) {
        for (head, &place) in self.heads.iter_mut().zip(places) {
            (head.r#type, head.words) = match row[place] {
                PixelValue::Rgb(_) => (Type::Light, 3),
                PixelValue::Count(_) => (Type::Count, 1),
                PixelValue::Mask(_) => (Type::Mask, 2),
                _ => (Type::Number, 1),
            };
        }
        self.words.resize(self.heads.iter().map(|head| head.words).sum(), Vec::new());
    }

    /// Bytes before they are packed.
    pub(super) fn raw_bytes(&self) -> u64 {
        let columns = self.words.iter().map(Vec::len).sum::<usize>();
        4 * (columns + self.lists.len() + self.rows.len()) as u64
    }

    /// What the page is told, and the packed bytes.
    pub(super) fn finish(self) -> (Vec<ColumnHead>, bool, Vec<u8>) {
        let mut planes = Vec::with_capacity(self.raw_bytes() as usize);
        let mut append = |words: &[u32]| {
            for plane in 0..4 {
                planes.extend(words.iter().map(|word| (word >> (8 * plane)) as u8));
            }
        };
        append(&self.lists);
        if self.has_lists {
            append(&self.rows);
        }
        let firsts: Vec<usize> = self
            .heads
            .iter()
            .scan(0, |next, head| Some(std::mem::replace(next, *next + head.words)))
            .collect();
        for (head, &first) in self.heads.iter().zip(&firsts) {
            for word in 0..head.words {
                let none = Vec::new();
                let own = self.words.get(first + word).unwrap_or(&none);
                let previous = self.words.get(firsts[head.before] + word).unwrap_or(&none);
                let before = std::iter::once(&0).chain(previous);
                let differences: Vec<u32> = own.iter().zip(before).map(|(a, b)| a ^ b).collect();
                append(&differences);
            }
        }
        (self.heads, self.has_lists, compress_to_vec_zlib(&planes, EFFORT))
    }
}

/// The words of a value; those beyond its column's are not taken.
fn words(value: PixelValue) -> [u32; 3] {
    match value {
        PixelValue::Number(number) => [number.to_bits(), 0, 0],
        PixelValue::Rgb(values) => values.map(f32::to_bits),
        PixelValue::Count(count) => [count, 0, 0],
        PixelValue::Mask(mask) => [mask as u32, (mask >> 32) as u32, 0],
        _ => [0; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use miniz_oxide::inflate::decompress_to_vec_zlib;

    fn words_of(planes: &[u8], at: &mut usize, count: usize) -> Vec<u32> {
        let bytes = &planes[*at..*at + 4 * count];
        *at += 4 * count;
        (0..count)
            .map(|index| {
                (0..4).map(|plane| u32::from(bytes[plane * count + index]) << (8 * plane)).sum()
            })
            .collect()
    }

    #[test]
    fn words_come_back_from_planes_and_differences() {
        let rows = [[1.0_f32, 1.0, 0.75], [2.5, 0.75, 0.5], [3.0, 0.25, 0.0]];
        let mut columns = LevelColumns::new(&[]);
        for pixel in [&rows[..2], &[], &rows[2..]] {
            let mut contents =
                PixelContents::new("vertices", &["depth", "V before", "V at and behind"]);
            pixel.iter().for_each(|row| contents.push(row.map(PixelValue::Number)));
            columns.push(&contents);
        }
        let (heads, has_lists, packed) = columns.finish();
        assert!(!has_lists && heads.iter().map(|head| head.before).eq([0, 2, 2]));
        let planes = decompress_to_vec_zlib(&packed).unwrap();
        let mut at = 0;
        assert_eq!(words_of(&planes, &mut at, 3), [2, 0, 1]);
        let differences = [0; 3].map(|_: u8| words_of(&planes, &mut at, 3));
        assert_eq!(at, planes.len());
        // A step's light before it is mostly what was left behind the one before.
        assert_eq!(differences[1][1], 0);
        let mut before = [0; 3];
        for (row, expected) in rows.iter().enumerate() {
            let own: Vec<u32> = heads
                .iter()
                .zip(&differences)
                .map(|(head, column)| column[row] ^ before[head.before])
                .collect();
            before.copy_from_slice(&own);
            assert_eq!(before.map(f32::from_bits), *expected);
        }
    }
}

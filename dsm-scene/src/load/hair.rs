//! Cem Yuksel's HAIR files.

use std::path::Path;

use glam::Vec3;

use super::read_file;
use crate::curves::Curves;
use crate::error::{Error, Place, Result};

const HEADER: usize = 128;
const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;

/// The file's columns, one after the other.
struct Columns<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Columns<'a> {
    /// The next `count` values of `size` bytes.
    fn take(&mut self, what: &str, count: u64, size: u64) -> Result<&'a [u8]> {
        let left = &self.bytes[self.at..];
        let taken = count.checked_mul(size).and_then(|bytes| usize::try_from(bytes).ok());
        let Some(column) = taken.and_then(|taken| left.get(..taken)) else {
            let reason = format!(
                "truncated: {what} of {count} × {size} bytes expected, {} left",
                left.len()
            );
            return Err(Error::malformed(Place::Byte(self.at as u64), reason));
        };
        self.at += column.len();
        Ok(column)
    }
}

fn floats(bytes: &[u8]) -> impl Iterator<Item = f32> {
    bytes.as_chunks::<4>().0.iter().map(|&bytes| f32::from_le_bytes(bytes))
}

pub(super) fn load(path: &Path) -> Result<Curves> {
    parse(&read_file(path)?)
}

fn parse(bytes: &[u8]) -> Result<Curves> {
    let refuse = |reason| Err(Error::malformed(Place::Header, reason));
    let Some(header) = bytes.get(..HEADER).filter(|header| header.starts_with(b"HAIR")) else {
        return refuse("not a HAIR file: must begin with HAIR and 124 bytes of header");
    };
    let word = |at: usize| {
        let bytes = [header[at], header[at + 1], header[at + 2], header[at + 3]];
        (u32::from_le_bytes(bytes), f32::from_le_bytes(bytes))
    };
    let (strands, points, flags) = (word(4).0, word(8).0, word(12).0);
    let (default_segments, default_thickness) = (word(16).0, word(20).1);
    let default_transparency = word(24).1;
    if flags & POINTS == 0 {
        return refuse("the file has no points");
    }
    let mut columns = Columns { bytes, at: HEADER };
    let mut segments = None;
    if flags & SEGMENTS != 0 {
        segments = Some(columns.take("segment counts", strands.into(), 2)?);
    } else if u64::from(strands) * (u64::from(default_segments) + 1) != u64::from(points) {
        return refuse("the strands' segments do not add up to the number of points");
    }
    let positions = columns.take("points", points.into(), 12)?;
    let mut per_point = |flag, what| match flags & flag {
        0 => Ok(None),
        _ => columns.take(what, points.into(), 4).map(Some),
    };
    let thicknesses = per_point(THICKNESS, "thicknesses")?;
    let transparencies = per_point(TRANSPARENCY, "transparencies")?;

    let mut coordinates = floats(positions);
    let mut coordinate = || coordinates.next().unwrap_or(0.0);
    let positions = (0..points).map(|_| Vec3::new(coordinate(), coordinate(), coordinate()));
    let positions = positions.collect();
    let radii = match thicknesses {
        Some(column) => floats(column).map(|thickness| thickness / 2.0).collect(),
        None => vec![default_thickness / 2.0; points as usize],
    };
    let curves = match segments {
        Some(counts) => {
            let counts = counts.as_chunks::<2>().0.iter();
            let lengths = counts.map(|&count| u32::from(u16::from_le_bytes(count)) + 1);
            Curves::new(positions, radii, lengths)?
        }
        // Strands are as many as points at most: the product was checked.
        None => {
            let lengths = (0..strands).map(|_| default_segments.saturating_add(1));
            Curves::new(positions, radii, lengths)?
        }
    };
    match transparencies {
        Some(column) => curves.with_opacities(floats(column).map(|part| 1.0 - part).collect()),
        None if default_transparency == 0.0 => Ok(curves),
        None => curves.with_opacities(vec![1.0 - default_transparency; points as usize]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of `strands` strands and these flags and columns.
    fn file(strands: u32, points: u32, flags: u32, segments: u32, columns: &[u8]) -> Vec<u8> {
        let mut bytes = b"HAIR".to_vec();
        for word in [strands, points, flags, segments] {
            bytes.extend(word.to_le_bytes());
        }
        for value in [0.5_f32, 0.25, 1.0, 1.0, 1.0] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.resize(HEADER, 0);
        bytes.extend(columns);
        bytes
    }

    fn column(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    #[test]
    fn strands_have_counts_of_their_own_or_one_for_all() {
        let points = column(&[0.0; 15]);
        let curves = parse(&file(1, 5, POINTS, 4, &points)).unwrap();
        assert_eq!((curves.strand_count(), curves.segments().len()), (1, 4));
        assert_eq!(curves.radii(), [0.25; 5]);
        assert_eq!(curves.opacity(0, 0.5), 0.75);
        let counts = [2_u16, 1].into_iter().flat_map(u16::to_le_bytes);
        let thick = column(&[2.0, 4.0, 6.0, 8.0, 10.0]);
        let clear = column(&[0.0, 1.0, 0.0, 0.0, 0.5]);
        let all: Vec<u8> = counts.chain(points).chain(thick).chain(clear).collect();
        let flags = SEGMENTS | POINTS | THICKNESS | TRANSPARENCY;
        let curves = parse(&file(2, 5, flags, 0, &all)).unwrap();
        assert_eq!(curves.segments(), [0, 1, 3]);
        assert_eq!(curves.radii(), [1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(curves.opacity(0, 0.25), 0.75);
    }

    #[test]
    fn files_that_state_more_than_they_hold_are_refused() {
        let points = column(&[0.0; 15]);
        for (strands, count, segments) in
            [(1 << 31, 5, 4), (1, u32::MAX, u32::MAX - 1), (u32::MAX, 5, u32::MAX), (2, 5, 4)]
        {
            assert!(parse(&file(strands, count, POINTS, segments, &points)).is_err());
            assert!(parse(&file(strands, count, POINTS | SEGMENTS, 0, &points)).is_err());
        }
        let whole = file(1, 5, POINTS | THICKNESS, 4, &points);
        let error = parse(&whole).unwrap_err();
        assert!(
            error.to_string().starts_with("byte 188: truncated: thicknesses of 5 × 4"),
            "{error}"
        );
        for length in 0..whole.len() {
            assert!(parse(&whole[..length]).is_err(), "{length} bytes");
        }
    }

    #[test]
    fn odd_numbers_are_refused_where_they_stand() {
        let mut values = [0.0; 15];
        values[7] = f32::NAN;
        let error = parse(&file(1, 5, POINTS, 4, &column(&values))).unwrap_err();
        assert!(error.to_string().starts_with("point 2: "), "{error}");
        let mut columns = column(&[0.0; 15]);
        columns.extend(column(&[1.0, 1.0, 1.0, -1.0, 1.0]));
        let error = parse(&file(1, 5, POINTS | THICKNESS, 4, &columns)).unwrap_err();
        assert!(error.to_string().starts_with("point 3: "), "{error}");
        assert!(parse(&file(1, 5, POINTS | TRANSPARENCY, 4, &columns)).is_err());
    }

    #[test]
    fn no_strands_are_none() {
        let curves = parse(&file(0, 0, POINTS, 0, &[])).unwrap();
        assert_eq!(curves.strand_count(), 0);
    }
}

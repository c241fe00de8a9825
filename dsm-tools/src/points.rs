//! Points to look up, from a CSV file with columns x, y and z.

use std::io::{self, Chain, Read};

use anyhow::{Context, Result, anyhow, bail};
use csv::{ByteRecord, Reader, ReaderBuilder, Terminator};

const NAMES: [&str; 3] = ["x", "y", "z"];

/// The longest line, in bytes. A record is held in memory.
const LONGEST_LINE: usize = 1 << 20;

/// Passes a source on, but for lines that are too long.
struct ShortLines<R> {
    source: R,
    /// Bytes since the last line feed.
    length: usize,
}

impl<R: Read> Read for ShortLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.source.read(buffer)?;
        for part in buffer[..count].split_inclusive(|&byte| byte == b'\n') {
            self.length += part.len();
            if self.length > LONGEST_LINE {
                let reason = format!("a line is longer than {LONGEST_LINE} bytes");
                return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
            }
            if part.ends_with(b"\n") {
                self.length = 0;
            }
        }
        Ok(count)
    }
}

/// Reads points from a CSV file, in order.
///
/// The first record names the columns; those called x, y and z may stand in
/// any order among others. Fields may be quoted, lines may end in CR LF, and
/// blank lines don't count.
pub(crate) struct PointReader<R> {
    reader: Reader<Chain<ShortLines<R>, &'static [u8]>>,
    columns: [usize; 3],
    record: ByteRecord,
}

impl<R: Read> PointReader<R> {
    /// Reads the header.
    pub(crate) fn new(source: R) -> Result<Self> {
        // Line numbers come out right only if LF alone ends a record, and
        // ends the last one too. A CR is trimmed with the blanks.
        let mut reader = ReaderBuilder::new()
            .flexible(true)
            .terminator(Terminator::Any(b'\n'))
            .from_reader(ShortLines { source, length: 0 }.chain(&b"\n"[..]));
        let header = reader.byte_headers().context("reading the header")?;
        if let Some(reason) = no_header(header) {
            bail!(reason);
        }
        let mut columns = [0; 3];
        for (column, name) in columns.iter_mut().zip(NAMES) {
            let mut places =
                (0..header.len()).filter(|&index| header[index].trim_ascii() == name.as_bytes());
            *column = match (places.next(), places.next()) {
                (Some(place), None) => place,
                (None, _) => bail!("the header has no column {name}; it has {}", names(header)),
                (Some(_), Some(_)) => bail!("the header has two columns {name}"),
            };
        }
        Ok(Self { reader, columns, record: ByteRecord::new() })
    }

    /// Reads up to `limit` points into `points`, which is cleared first.
    /// Leaves it empty at the end of the file.
    pub(crate) fn read(&mut self, points: &mut Vec<[f64; 3]>, limit: usize) -> Result<()> {
        points.clear();
        while points.len() < limit && self.reader.read_byte_record(&mut self.record)? {
            if self.record.len() == 1 && self.record[0].trim_ascii().is_empty() {
                continue;
            }
            let mut point = [0.0; 3];
            for (axis, coordinate) in point.iter_mut().enumerate() {
                *coordinate = self.coordinate(axis)?;
            }
            points.push(point);
        }
        Ok(())
    }

    fn coordinate(&self, axis: usize) -> Result<f64> {
        let name = NAMES[axis];
        let Some(field) = self.record.get(self.columns[axis]).map(<[u8]>::trim_ascii) else {
            return Err(anyhow!("line {}: there is no {name}", self.line()));
        };
        let number = str::from_utf8(field).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| {
            let text: String = String::from_utf8_lossy(field).chars().take(40).collect();
            anyhow!("line {}: {name} is not a number: \"{text}\"", self.line())
        })
    }

    /// The line on which the current record starts, from 1.
    fn line(&self) -> u64 {
        let inside: usize = self
            .record
            .iter()
            .map(|field| field.iter().filter(|&&byte| byte == b'\n').count())
            .sum();
        self.reader.position().line() - 1 - inside as u64
    }
}

/// Why a first line is not a header at all.
fn no_header(line: &ByteRecord) -> Option<String> {
    let text = |field: &[u8]| String::from_utf8_lossy(field.trim_ascii()).into_owned();
    let fields: Vec<_> = line.iter().map(text).collect();
    if fields.iter().all(String::is_empty) {
        return Some("there is no header: the first line names the columns, x,y,z".to_owned());
    }
    if fields.iter().all(|field| field.parse::<f64>().is_ok()) {
        let reason = "there is no header: the first line is numbers, and has to name the columns";
        return Some(format!("{reason}, x,y,z"));
    }
    let is_split = |separator| fields.len() == 1 && fields[0].split(separator).count() >= 3;
    let separators = [(';', "semicolons"), ('\t', "tabs"), ('|', "bars"), (' ', "blanks")];
    let (_, other) = separators.into_iter().find(|&(separator, _)| is_split(separator))?;
    Some(format!("the columns are separated by {other}, and have to be by commas"))
}

/// The names of a header's columns, or the first of many.
fn names(header: &ByteRecord) -> String {
    const SHOWN: usize = 12;
    let name = |field: &[u8]| -> String {
        String::from_utf8_lossy(field.trim_ascii()).chars().take(40).collect()
    };
    let mut names: Vec<_> = header.iter().take(SHOWN).map(name).collect();
    if header.len() > SHOWN {
        names.push(format!("and {} more", header.len() - SHOWN));
    }
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<[f64; 3]>> {
        let mut reader = PointReader::new(text.as_bytes())?;
        let (mut all, mut points) = (Vec::new(), Vec::new());
        loop {
            reader.read(&mut points, 2)?;
            if points.is_empty() {
                return Ok(all);
            }
            all.append(&mut points);
        }
    }

    fn refusal(text: &str) -> String {
        format!("{:#}", read(text).unwrap_err())
    }

    #[test]
    fn columns_stand_in_any_order_among_others() {
        let points = [[1.0, 2.0, 3.0], [-4.5, 5e-3, 6.0], [7.0, 8.0, 9.0]];
        for text in [
            "x,y,z\n1,2,3\n-4.5,5e-3,6\n7,8,9\n",
            "name, z ,x,y\na,3,1,2\n\"b,\"\"c\"\"\nd\",6,-4.5,5e-3\n,9,7,8,extra",
            "\u{feff}x,y,z\r\n\r\n1,2,3\r\n\n-4.5, 5e-3,\"6\"\r\n  \r\n7,8,9\r\n\r\n",
        ] {
            assert_eq!(read(text).unwrap(), points, "{text:?}");
        }
        assert!(read("x,y,z\n").unwrap().is_empty());
    }

    #[test]
    fn what_is_not_finite_is_read() {
        let points = read("x,y,z\nnan,inf,-Infinity\n").unwrap();
        assert!(points[0][0].is_nan());
        assert_eq!(points[0][1..], [f64::INFINITY, f64::NEG_INFINITY]);
    }

    #[test]
    fn refusals_name_the_line() {
        for (text, line) in [
            ("x,y,z\n1,2,a", 2),
            ("x,y,z\r\n1,2,3\r\n\r\n1,,3\r\n", 4),
            ("x,y,z\n\n\n1,2\n", 4),
            ("t,x,y,z\n\"\n\n\",1,2,3\n\n\"\n\",1,2,1_0\n", 6),
        ] {
            assert!(refusal(text).starts_with(&format!("line {line}: ")), "{}", refusal(text));
        }
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let endless = PointReader::new(io::repeat(b'0')).err();
        let shown = endless.map(|error| format!("{error:#}"));
        assert!(shown.is_some_and(|shown| shown.contains("longer than 1048576 bytes")));
        let mut long = PointReader::new((&b"x,y,z\n1,2,3\n"[..]).chain(io::repeat(b'0'))).unwrap();
        assert!(long.read(&mut Vec::new(), 9).is_err());
    }

    #[test]
    fn headers_have_each_column_once() {
        assert_eq!(refusal("x,y\n1,2\n"), "the header has no column z; it has x, y");
        assert_eq!(refusal("x,y,z,y\n"), "the header has two columns y");
        assert_eq!(refusal("X, Y ,Z\n1,2,3\n"), "the header has no column x; it has X, Y, Z");
        let many = format!("x,y{}\n", ",column".repeat(1000));
        assert!(refusal(&many).ends_with(", column, and 990 more"), "{}", refusal(&many));
    }

    #[test]
    fn first_lines_that_are_no_headers_are_told() {
        for text in ["", "\n\n", "1,2,3\n4,5,6\n", " 0.5, -1e3,nan\n"] {
            assert!(refusal(text).starts_with("there is no header: "), "{text:?}");
        }
        for (text, other) in [
            ("x;y;z\n1;2;3\n", "semicolons"),
            ("1;2;3\n", "semicolons"),
            ("x\ty\tz\n", "tabs"),
            ("x y z\n", "blanks"),
            ("x|y|z\n", "bars"),
        ] {
            let reason = format!("the columns are separated by {other}, and have to be by commas");
            assert_eq!(refusal(text), reason, "{text:?}");
        }
        // Blanks and semicolons within names are no separators.
        assert_eq!(read("x,y,z,the name; or none\n1,2,3,a\n").unwrap(), [[1.0, 2.0, 3.0]]);
    }
}

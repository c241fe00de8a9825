//! Lines and words of OBJ and MTL files.

use std::borrow::Cow;

/// The lines of a text with their numbers, from 1: ended by LF, CR LF or CR, those that
/// end with `\` joined to the next, and comments left out.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), number: 0 }
    }

    /// The next line as it stands.
    fn raw(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (line, rest) = match end {
            None => (self.rest, &[][..]),
            Some(end) => {
                let both = self.rest[end..].starts_with(b"\r\n");
                (&self.rest[..end], &self.rest[end + 1 + usize::from(both)..])
            }
        };
        self.rest = rest;
        Some(line.trim_ascii())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let line = self.raw()?;
            let number = self.number;
            if line.is_empty() || line.starts_with(b"#") {
                continue;
            }
            let Some(mut begun) = line.strip_suffix(b"\\") else {
                return Some((number, Cow::Borrowed(line)));
            };
            let mut joined = Vec::new();
            loop {
                joined.extend(begun);
                joined.push(b' ');
                let Some(next) = self.raw() else { break };
                match next.strip_suffix(b"\\") {
                    Some(more) => begun = more,
                    None => {
                        joined.extend(next);
                        break;
                    }
                }
            }
            return Some((number, Cow::Owned(joined)));
        }
    }
}

/// The first word of a line and the rest, without the space around it.
pub(super) fn split_word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii())
}

/// The words of a line of numbers, up to a comment.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.take_while(|word| !word.starts_with(b"#"))
}

/// A number; what programs write for none is one that is not a number.
pub(super) fn number(word: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(word).ok()?;
    let unsigned = text.trim_start_matches(['-', '+']);
    if unsigned.get(..3).is_some_and(|start| start.eq_ignore_ascii_case("nan")) {
        return Some(f32::NAN);
    }
    text.parse().ok()
}

/// A name in UTF-8 or, where it is none, in Latin-1; without quotes around it.
pub(super) fn name(bytes: &[u8]) -> String {
    let bytes = bytes.trim_ascii();
    let quoted = bytes.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\""));
    let bytes = quoted.unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8]) -> Vec<(u64, String)> {
        Lines::new(text).map(|(at, line)| (at, String::from_utf8(line.into()).unwrap())).collect()
    }

    #[test]
    fn lines_end_in_every_way() {
        let want = [(1, "v 1".to_owned()), (3, "f 2".to_owned())];
        for text in
            ["v 1\n\nf 2", "v 1\r\n\r\nf 2\r\n", "v 1\r\rf 2\r", "\u{feff}v 1\n# c\\\n f 2 "]
        {
            assert_eq!(lines(text.as_bytes()), want, "{text:?}");
        }
        let joined = lines(b"f 1 2 \\\r\n 3\\\n4\nv \\");
        assert_eq!(joined, [(1, "f 1 2  3 4".to_owned()), (4, "v  ".to_owned())]);
        assert!(lines(b"").is_empty() && lines(b"\n\r\n\r").is_empty());
    }

    #[test]
    fn names_are_utf_8_or_latin_1() {
        assert_eq!(name("grün".as_bytes()), "grün");
        assert_eq!(name(b"gr\xfcn"), "grün");
        assert_eq!(name(b" \"leaf 1.png\" "), "leaf 1.png");
        assert!(number(b"-nan(ind)").is_some_and(f32::is_nan));
        assert_eq!((number(b"1e-3"), number(b"x"), number(b"\xff")), (Some(1e-3), None, None));
        let found: Vec<_> = words(b" 1/2 \t3 # 4").collect();
        assert_eq!(found, [b"1/2".as_slice(), b"3"]);
        assert_eq!(split_word(b"  usemtl  a b "), (b"usemtl".as_slice(), b"a b".as_slice()));
        assert_eq!(split_word(b"usemtl"), (b"usemtl".as_slice(), b"".as_slice()));
    }
}

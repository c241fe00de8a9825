//! Words, numbers and marks of the text encoding.

use crate::error::{Error, Place, Result};

/// A piece of text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// A name, with namespaces and dots.
    Word(&'a str),
    Number(f64),
    Text(String),
    /// `@file@`.
    Asset(&'a str),
    /// `<path>`.
    Path(&'a str),
    Mark(u8),
    End,
}

/// Reads tokens one by one. Lines don't matter, but for messages.
#[derive(Clone)]
pub(super) struct Lexer<'a> {
    text: &'a str,
    at: usize,
}

const fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':' | b'.' | b'|') || byte >= 0x80
}

impl<'a> Lexer<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }

    pub(super) fn error(&self, reason: impl Into<String>) -> Error {
        let before = &self.text.as_bytes()[..self.at.min(self.text.len())];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        Error::malformed(Place::Line(line as u64), reason.into())
    }

    fn byte(&self, ahead: usize) -> u8 {
        self.text.as_bytes().get(self.at + ahead).copied().unwrap_or(0)
    }

    fn skip_space(&mut self) {
        loop {
            match self.byte(0) {
                b' ' | b'\t' | b'\r' | b'\n' => self.at += 1,
                b'#' => self.at = self.until("\n").unwrap_or(self.text.len()),
                b'/' if self.byte(1) == b'/' => {
                    self.at = self.until("\n").unwrap_or(self.text.len());
                }
                b'/' if self.byte(1) == b'*' => {
                    self.at = self.until("*/").map_or(self.text.len(), |end| end + 2);
                }
                _ => break,
            }
        }
    }

    /// Where `end` is next.
    fn until(&self, end: &str) -> Option<usize> {
        self.text[self.at..].find(end).map(|length| self.at + length)
    }

    /// The text up to `end`, which is stepped over.
    fn enclosed(&mut self, start: usize, end: &str) -> Result<&'a str> {
        self.at += start;
        let Some(stop) = self.until(end) else {
            return Err(self.error(format!("no {end} ends it")));
        };
        let inside = &self.text[self.at..stop];
        self.at = stop + end.len();
        Ok(inside)
    }

    /// The next token, without a step.
    pub(super) fn peek(&self) -> Result<Token<'a>> {
        self.clone().next()
    }

    /// Steps over `mark`, if it is next.
    pub(super) fn skip(&mut self, mark: u8) -> bool {
        self.skip_space();
        let is_next = self.byte(0) == mark && self.at < self.text.len();
        self.at += usize::from(is_next);
        is_next
    }

    pub(super) fn expect(&mut self, mark: u8) -> Result<()> {
        if self.skip(mark) {
            return Ok(());
        }
        Err(self.error(format!("{} is missing", char::from(mark))))
    }

    /// The next token as a word.
    pub(super) fn word(&mut self) -> Result<&'a str> {
        match self.next()? {
            Token::Word(word) => Ok(word),
            _ => Err(self.error("a name is missing")),
        }
    }

    pub(super) fn text(&mut self) -> Result<String> {
        match self.next()? {
            Token::Text(text) => Ok(text),
            _ => Err(self.error("a text in quotes is missing")),
        }
    }

    pub(super) fn next(&mut self) -> Result<Token<'a>> {
        self.skip_space();
        if self.at >= self.text.len() {
            return Ok(Token::End);
        }
        Ok(match self.byte(0) {
            b'"' | b'\'' => Token::Text(self.quoted()?),
            b'@' if self.text[self.at..].starts_with("@@@") => {
                Token::Asset(self.enclosed(3, "@@@")?)
            }
            b'@' => Token::Asset(self.enclosed(1, "@")?),
            b'<' => Token::Path(self.enclosed(1, ">")?.trim()),
            byte if byte.is_ascii_digit() || matches!(byte, b'-' | b'+') => self.number()?,
            b'.' if self.byte(1).is_ascii_digit() => self.number()?,
            byte if is_word(byte) => {
                let start = self.at;
                while is_word(self.byte(0)) {
                    self.at += 1;
                }
                match &self.text[start..self.at] {
                    "inf" => Token::Number(f64::INFINITY),
                    "nan" => Token::Number(f64::NAN),
                    word => Token::Word(word),
                }
            }
            mark => {
                self.at += 1;
                Token::Mark(mark)
            }
        })
    }

    fn number(&mut self) -> Result<Token<'a>> {
        let start = self.at;
        let is_part = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'+' | b'.');
        while is_part(self.byte(0)) {
            self.at += 1;
        }
        match self.text[start..self.at].parse() {
            Ok(number) => Ok(Token::Number(number)),
            Err(_) => Err(self.error("a number is not one")),
        }
    }

    fn quoted(&mut self) -> Result<String> {
        let quote = self.byte(0);
        let is_long = self.byte(1) == quote && self.byte(2) == quote;
        let length = if is_long { 3 } else { 1 };
        self.at += length;
        let mut text = String::new();
        loop {
            let rest = &self.text[self.at..];
            let stop = |letter: char| letter == '\\' || letter == char::from(quote);
            let Some(plain) = rest.find(stop) else { return Err(self.error("a text has no end")) };
            text.push_str(&rest[..plain]);
            self.at += plain;
            if self.byte(0) == b'\\' {
                let escaped = self.text[self.at + 1..].chars().next();
                let escaped = escaped.ok_or_else(|| self.error("a text has no end"))?;
                text.push(match escaped {
                    'n' => '\n',
                    't' => '\t',
                    other => other,
                });
                self.at += 1 + escaped.len_utf8();
            } else if !is_long || self.byte(1) == quote && self.byte(2) == quote {
                self.at += length;
                return Ok(text);
            } else {
                text.push(char::from(quote));
                self.at += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_of_every_kind() {
        let text = "a:b.c # no\n -1.5e3 inf \"q\\\"\" '''it's\n''' @f@ @@@g@h@@@ </A/b.c>;/* */{";
        let mut lexer = Lexer::new(text);
        let mut found = Vec::new();
        loop {
            match lexer.next().unwrap() {
                Token::End => break,
                token => found.push(token),
            }
        }
        assert_eq!(
            found,
            [
                Token::Word("a:b.c"),
                Token::Number(-1500.0),
                Token::Number(f64::INFINITY),
                Token::Text("q\"".into()),
                Token::Text("it's\n".into()),
                Token::Asset("f"),
                Token::Asset("g@h"),
                Token::Path("/A/b.c"),
                Token::Mark(b';'),
                Token::Mark(b'{'),
            ]
        );
        for odd in ["\"a", "'''a''", "@a", "<a", "1x", "\"\\"] {
            assert!(Lexer::new(odd).next().is_err(), "{odd}");
        }
    }
}

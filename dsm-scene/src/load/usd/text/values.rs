//! Values in the text encoding.

use half::f16;

use super::lexer::{Lexer, Token};
use crate::error::Result;
use crate::load::usd::value::{Between, ListOp, Numbers, Reference, Stored, TimeOffset, Value};

/// No value nests deeper.
const MAX_NESTING: usize = 64;

/// How many digits numbers of a type keep.
#[derive(Clone, Copy, PartialEq)]
enum Precision {
    Half,
    Float,
    All,
}

impl Precision {
    fn of(type_name: &str) -> Self {
        let name = type_name.trim_end_matches("[]");
        if is_whole(name)
            || name.starts_with("timecode")
            || name.starts_with("double")
            || name.ends_with('d')
        {
            Self::All
        } else if name.starts_with("half") || name.ends_with('h') {
            Self::Half
        } else {
            Self::Float
        }
    }

    fn round(self, value: f64) -> f64 {
        match self {
            Self::Half => f16::from_f64(value).into(),
            Self::Float => f64::from(value as f32),
            Self::All => value,
        }
    }
}

fn is_whole(type_name: &str) -> bool {
    ["int", "uint", "bool", "uchar"].iter().any(|word| type_name.starts_with(word))
}

/// The value of an attribute of this type.
pub(super) fn typed(lexer: &mut Lexer<'_>, type_name: &str) -> Result<Value> {
    let precision = Precision::of(type_name);
    match lexer.peek()? {
        Token::Word("None" | "AnimationBlock") => {
            lexer.next()?;
            Ok(Value::Block)
        }
        Token::Mark(b'{') => {
            skip(lexer, 0)?;
            Ok(Value::Other)
        }
        Token::Path(path) => {
            lexer.next()?;
            Ok(Value::Paths(ListOp::of(vec![path.to_owned()])))
        }
        Token::Mark(b'[' | b'(') | Token::Number(_) | Token::Word(_) => {
            let mut flat = Flat::default();
            flat.read(lexer, 0)?;
            if !flat.words.is_empty() {
                return Ok(Value::Words(flat.words));
            }
            let size = match flat.size {
                Some(size) => size,
                None if flat.data.is_empty() => size_of(type_name),
                None => 1,
            };
            if size == 0 || !flat.data.len().is_multiple_of(size) {
                return Err(lexer.error("its elements are not alike"));
            }
            let mut data: Vec<f64> =
                flat.data.into_iter().map(|value| precision.round(value)).collect();
            if type_name.starts_with("quat") && size == 4 {
                // The real part is written first.
                data.as_chunks_mut::<4>().0.iter_mut().for_each(|quat| quat.rotate_left(1));
            }
            let between = if type_name.starts_with("quat") {
                Between::Arc
            } else if is_whole(type_name) {
                Between::Step
            } else {
                Between::Line
            };
            Ok(Value::Numbers(Numbers { size, is_array: flat.is_array, between, data }))
        }
        Token::Text(_) | Token::Asset(_) => Ok(Value::Words(words(lexer)?)),
        _ => Err(lexer.error("a value is missing")),
    }
}

/// Numbers an element of an empty array.
fn size_of(type_name: &str) -> usize {
    let name = type_name.trim_end_matches("[]");
    let is_three = ["point", "vector", "normal", "color"].iter().any(|w| name.starts_with(w));
    if is_whole(name) && name.ends_with("64") {
        1
    } else if is_three || name.contains('3') {
        3
    } else if name.starts_with("quat") || name.contains('4') {
        4
    } else if name.contains('2') {
        2
    } else {
        1
    }
}

/// Numbers and words without the brackets around them.
#[derive(Default)]
struct Flat {
    data: Vec<f64>,
    words: Vec<String>,
    is_array: bool,
    /// Numbers in the outermost round brackets.
    size: Option<usize>,
}

impl Flat {
    fn read(&mut self, lexer: &mut Lexer<'_>, nesting: usize) -> Result<()> {
        if nesting > MAX_NESTING {
            return Err(lexer.error("brackets are nested too deep"));
        }
        match lexer.next()? {
            Token::Number(number) => self.data.push(number),
            Token::Word("true" | "True") => self.data.push(1.0),
            Token::Word("false" | "False") => self.data.push(0.0),
            Token::Text(text) => self.words.push(text),
            Token::Asset(name) => self.words.push(name.to_owned()),
            Token::Mark(b'[') => {
                self.is_array = true;
                while !lexer.skip(b']') {
                    self.read(lexer, nesting + 1)?;
                    lexer.skip(b',');
                }
            }
            Token::Mark(b'(') => {
                let start = self.data.len();
                let outer = self.size.take();
                while !lexer.skip(b')') {
                    self.read(lexer, nesting + 1)?;
                    lexer.skip(b',');
                }
                let size = self.data.len() - start;
                if outer.is_some_and(|outer| outer != size) {
                    return Err(lexer.error("its elements are not alike"));
                }
                self.size = Some(size);
            }
            _ => return Err(lexer.error("a number is missing")),
        }
        Ok(())
    }
}

/// A text or asset, or a list of them.
pub(super) fn words(lexer: &mut Lexer<'_>) -> Result<Vec<String>> {
    let mut words = Vec::new();
    for_each(lexer, |lexer| match lexer.next()? {
        Token::Text(text) => {
            words.push(text);
            Ok(())
        }
        Token::Asset(name) => {
            words.push(name.to_owned());
            Ok(())
        }
        _ => Err(lexer.error("a text is missing")),
    })?;
    Ok(words)
}

/// A path, or a list of them, or none.
pub(super) fn paths(lexer: &mut Lexer<'_>) -> Result<Vec<String>> {
    let mut paths = Vec::new();
    for_each(lexer, |lexer| match lexer.next()? {
        Token::Path(path) => {
            paths.push(path.to_owned());
            Ok(())
        }
        _ => Err(lexer.error("a path is missing")),
    })?;
    Ok(paths)
}

/// References or payloads, or none.
pub(super) fn references(lexer: &mut Lexer<'_>) -> Result<Vec<Reference>> {
    let mut references = Vec::new();
    for_each(lexer, |lexer| {
        let mut reference =
            Reference { asset: String::new(), path: String::new(), offset: TimeOffset::NONE };
        match lexer.next()? {
            Token::Asset(asset) => {
                reference.asset = asset.to_owned();
                if let Token::Path(path) = lexer.peek()? {
                    reference.path = path.to_owned();
                    lexer.next()?;
                }
            }
            Token::Path(path) => reference.path = path.to_owned(),
            _ => return Err(lexer.error("a file or a path is missing")),
        }
        if lexer.skip(b'(') {
            reference.offset = offset(lexer)?;
        }
        references.push(reference);
        Ok(())
    })?;
    Ok(references)
}

/// `offset = 1; scale = 2)`, after its bracket.
pub(super) fn offset(lexer: &mut Lexer<'_>) -> Result<TimeOffset> {
    let mut found = TimeOffset::NONE;
    while !lexer.skip(b')') {
        let name = lexer.word()?;
        if name == "dictionary" {
            lexer.word()?;
        }
        lexer.expect(b'=')?;
        match (name, lexer.peek()?) {
            ("offset", Token::Number(number)) => found.offset = number,
            ("scale", Token::Number(number)) => found.scale = number,
            _ => {}
        }
        skip(lexer, 0)?;
        lexer.skip(b';');
        lexer.skip(b',');
    }
    Ok(found)
}

/// `{ time: value, … }`.
pub(super) fn samples(lexer: &mut Lexer<'_>, type_name: &str) -> Result<Value> {
    lexer.expect(b'{')?;
    let mut samples: Vec<(f64, Stored)> = Vec::new();
    while !lexer.skip(b'}') {
        let Token::Number(time) = lexer.next()? else {
            return Err(lexer.error("a time is missing"));
        };
        if !time.is_finite() {
            return Err(lexer.error("a time must be finite"));
        }
        lexer.expect(b':')?;
        samples.push((time, Stored::Read(typed(lexer, type_name)?)));
        lexer.skip(b',');
    }
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The last one of a time counts.
    samples.reverse();
    samples.dedup_by_key(|sample| sample.0);
    samples.reverse();
    Ok(Value::Samples(samples))
}

/// `{ string name = "value" … }`.
pub(super) fn selections(lexer: &mut Lexer<'_>) -> Result<Vec<(String, String)>> {
    lexer.expect(b'{')?;
    let mut selections = Vec::new();
    while !lexer.skip(b'}') {
        lexer.word()?;
        let set = match lexer.next()? {
            Token::Word(word) => word.to_owned(),
            Token::Text(text) => text,
            _ => return Err(lexer.error("the name of a set of variants is missing")),
        };
        lexer.expect(b'=')?;
        selections.push((set, lexer.text()?));
        lexer.skip(b';');
    }
    Ok(selections)
}

fn for_each<'a>(
    lexer: &mut Lexer<'a>,
    mut item: impl FnMut(&mut Lexer<'a>) -> Result<()>,
) -> Result<()> {
    if lexer.peek()? == Token::Word("None") {
        lexer.next()?;
        return Ok(());
    }
    if !lexer.skip(b'[') {
        return item(lexer);
    }
    while !lexer.skip(b']') {
        item(lexer)?;
        lexer.skip(b',');
    }
    Ok(())
}

/// Steps over a value of any kind.
pub(super) fn skip(lexer: &mut Lexer<'_>, nesting: usize) -> Result<()> {
    if nesting > MAX_NESTING {
        return Err(lexer.error("brackets are nested too deep"));
    }
    let end = match lexer.next()? {
        Token::Mark(b'[') => b']',
        Token::Mark(b'(') => b')',
        Token::Mark(b'{') => b'}',
        Token::Asset(_) => {
            if let Token::Path(_) = lexer.peek()? {
                lexer.next()?;
            }
            return Ok(());
        }
        Token::End | Token::Mark(_) => return Err(lexer.error("a value is missing")),
        _ => return Ok(()),
    };
    while !lexer.skip(end) {
        if let Token::Mark(b',' | b';' | b':' | b'=' | b'.') = lexer.peek()? {
            lexer.next()?;
        } else {
            skip(lexer, nesting + 1)?;
        }
    }
    Ok(())
}

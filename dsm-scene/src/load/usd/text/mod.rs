//! The text encoding of USD layers.

mod lexer;
mod values;

use self::lexer::{Lexer, Token};
use self::values::{offset, paths, references, samples, selections, skip, typed, words};
use super::layer::{Layer, MAX_DEPTH, PrimSpec, Property, Specifier};
use super::value::{ListOp, Numbers, Stored, TimeOffset, Value};
use crate::error::{Error, Place, Result};

/// What a text begins with.
pub(super) const MAGIC: &[u8] = b"#usda";

/// Reads a layer.
pub(super) fn read(bytes: &[u8]) -> Result<Layer> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        Error::malformed(Place::Byte(error.valid_up_to() as u64), "not a text in UTF-8")
    })?;
    if !text.starts_with("#usda 1.") {
        return Err(Error::malformed(Place::Line(1), "not a USD text: must begin with #usda 1.0"));
    }
    let mut parser = Parser { lexer: Lexer::new(text), prims: vec![PrimSpec::default()] };
    if parser.lexer.skip(b'(') {
        parser.metadata(0)?;
    }
    while parser.lexer.peek()? != Token::End {
        parser.statement(0, 0)?;
    }
    Ok(Layer { prims: parser.prims, packed: None })
}

/// How a list is edited.
#[derive(Clone, Copy, PartialEq)]
enum Edit {
    Set,
    Prepend,
    Append,
    Delete,
    Reorder,
}

impl Edit {
    fn of(word: &str) -> Option<Self> {
        Some(match word {
            "prepend" => Self::Prepend,
            "append" | "add" => Self::Append,
            "delete" => Self::Delete,
            "reorder" => Self::Reorder,
            _ => return None,
        })
    }

    fn list<T: Clone + PartialEq>(self, items: Vec<T>) -> ListOp<T> {
        let edit = ListOp::default();
        match self {
            Self::Set => ListOp::of(items),
            Self::Prepend => ListOp { prepended: items, ..edit },
            Self::Append => ListOp { appended: items, ..edit },
            Self::Delete => ListOp { deleted: items, ..edit },
            Self::Reorder => edit,
        }
    }
}

struct Parser<'a> {
    lexer: Lexer<'a>,
    prims: Vec<PrimSpec>,
}

impl<'a> Parser<'a> {
    fn prim(&mut self, index: u32) -> &mut PrimSpec {
        &mut self.prims[index as usize]
    }

    /// A prim, set of variants or property of prim `owner`.
    fn statement(&mut self, owner: u32, depth: usize) -> Result<()> {
        if self.lexer.skip(b';') {
            return Ok(());
        }
        let word = self.lexer.word()?;
        match word {
            "def" => self.child(owner, Specifier::Def, depth),
            "over" => self.child(owner, Specifier::Over, depth),
            "class" => self.child(owner, Specifier::Class, depth),
            "variantSet" => self.variants(owner, depth),
            "reorder" => {
                // Of children, of properties or of a relationship's targets.
                let what = self.lexer.word()?;
                if what == "rel" {
                    self.lexer.word()?;
                }
                self.lexer.expect(b'=')?;
                skip(&mut self.lexer, 0)
            }
            _ => self.property(owner, word),
        }
    }

    fn child(&mut self, owner: u32, specifier: Specifier, depth: usize) -> Result<()> {
        if depth >= MAX_DEPTH {
            return Err(self.lexer.error("prims are nested too deep"));
        }
        let mut type_name = "";
        if let Token::Word(word) = self.lexer.peek()? {
            type_name = word;
            self.lexer.next()?;
        }
        let name = self.lexer.text()?;
        let index = match self.prim(owner).child(&name) {
            Some(index) => index,
            None => {
                self.prims.push(PrimSpec::default());
                let index = self.prims.len() as u32 - 1;
                self.prim(owner).add_child(&name, index);
                index
            }
        };
        let prim = self.prim(index);
        prim.specifier = specifier;
        prim.type_name = type_name.to_owned();
        self.body(index, depth + 1)
    }

    /// Metadata in brackets and statements in braces.
    fn body(&mut self, prim: u32, depth: usize) -> Result<()> {
        if self.lexer.skip(b'(') {
            self.metadata(prim)?;
        }
        self.lexer.expect(b'{')?;
        while !self.lexer.skip(b'}') {
            self.statement(prim, depth)?;
        }
        Ok(())
    }

    fn variants(&mut self, owner: u32, depth: usize) -> Result<()> {
        if depth >= MAX_DEPTH {
            return Err(self.lexer.error("variants are nested too deep"));
        }
        let set = self.lexer.text()?;
        self.lexer.expect(b'=')?;
        self.lexer.expect(b'{')?;
        while !self.lexer.skip(b'}') {
            let name = self.lexer.text()?;
            self.prims.push(PrimSpec::default());
            let index = self.prims.len() as u32 - 1;
            self.prim(owner).variants.push((set.clone(), name, index));
            self.body(index, depth + 1)?;
        }
        Ok(())
    }

    /// What is said of a layer or prim, after its bracket.
    fn metadata(&mut self, prim: u32) -> Result<()> {
        while !self.lexer.skip(b')') {
            if self.lexer.skip(b';') || self.lexer.skip(b',') {
                continue;
            }
            if let Token::Text(_) = self.lexer.peek()? {
                // A comment.
                self.lexer.next()?;
                continue;
            }
            let mut name = self.lexer.word()?;
            let edit = Edit::of(name);
            if edit.is_some() {
                name = self.lexer.word()?;
            }
            self.lexer.expect(b'=')?;
            let edit = edit.unwrap_or(Edit::Set);
            if name == "subLayers" {
                self.sublayers(prim)?;
                continue;
            }
            let lexer = &mut self.lexer;
            let value = match name {
                "references" | "payload" => Value::References(edit.list(references(lexer)?)),
                "inherits" | "specializes" => Value::Paths(edit.list(paths(lexer)?)),
                "variantSets" => Value::Names(edit.list(words(lexer)?)),
                "variants" => Value::Selections(selections(lexer)?),
                "inactiveIds" => Value::Integers(edit.list(numbers(lexer)?)),
                "active" | "instanceable" => typed(lexer, "bool")?,
                "metersPerUnit" | "timeCodesPerSecond" | "framesPerSecond" => {
                    typed(lexer, "double")?
                }
                "upAxis" | "defaultPrim" => typed(lexer, "token")?,
                _ => {
                    skip(lexer, 0)?;
                    Value::Other
                }
            };
            let name = match name {
                "inherits" => "inheritPaths",
                "variantSets" => "variantSetNames",
                "variants" => "variantSelection",
                name => name,
            };
            self.join(prim, name, value);
        }
        Ok(())
    }

    /// Sets a field, or adds to the edits of its list.
    fn join(&mut self, prim: u32, name: &str, value: Value) {
        let fields = &mut self.prim(prim).fields;
        match (fields.get_mut(name), value) {
            (Some(Stored::Read(Value::References(list))), Value::References(more)) => {
                list.join(more);
            }
            (Some(Stored::Read(Value::Paths(list))), Value::Paths(more)) => list.join(more),
            (Some(Stored::Read(Value::Names(list))), Value::Names(more)) => list.join(more),
            (Some(Stored::Read(Value::Integers(list))), Value::Integers(more)) => list.join(more),
            (_, value) => {
                fields.insert(name.to_owned(), Stored::Read(value));
            }
        }
    }

    fn sublayers(&mut self, prim: u32) -> Result<()> {
        let (mut names, mut offsets) = (Vec::new(), Vec::new());
        self.lexer.expect(b'[')?;
        while !self.lexer.skip(b']') {
            let Token::Asset(name) = self.lexer.next()? else {
                return Err(self.lexer.error("a file is missing"));
            };
            names.push(name.to_owned());
            let has_offset = self.lexer.skip(b'(');
            offsets.push(if has_offset { offset(&mut self.lexer)? } else { TimeOffset::NONE });
            self.lexer.skip(b',');
        }
        self.join(prim, "subLayers", Value::Words(names));
        self.join(prim, "subLayerOffsets", Value::Offsets(offsets));
        Ok(())
    }

    /// `[prepend] [custom] [uniform] type name[.timeSamples] [= value] [(metadata)]`.
    fn property(&mut self, owner: u32, first: &'a str) -> Result<()> {
        let mut word = first;
        let mut edit = Edit::Set;
        loop {
            match (word, Edit::of(word)) {
                ("custom" | "uniform" | "varying" | "config", _) => {}
                (_, Some(found)) => edit = found,
                _ => break,
            }
            word = self.lexer.word()?;
        }
        let type_name = word;
        if self.lexer.skip(b'[') {
            self.lexer.expect(b']')?;
        }
        let whole = self.lexer.word()?;
        let (name, part) = whole.split_once('.').unwrap_or((whole, ""));
        let has_value = self.lexer.skip(b'=');
        let mut property = self.prim(owner).properties.remove(name).unwrap_or_default();
        if has_value {
            let lexer = &mut self.lexer;
            if type_name == "rel" || part == "connect" {
                let list = edit.list(paths(lexer)?);
                match &mut property.targets {
                    Some(Stored::Read(Value::Paths(before))) => before.join(list),
                    targets => *targets = Some(Stored::Read(Value::Paths(list))),
                }
            } else if part == "timeSamples" {
                property.samples = Some(Stored::Read(samples(lexer, type_name)?));
            } else if part.is_empty() {
                property.default = Some(Stored::Read(typed(lexer, type_name)?));
            } else {
                skip(lexer, 0)?;
            }
        }
        if self.lexer.skip(b'(') {
            self.property_metadata(&mut property)?;
        }
        self.prim(owner).properties.insert(name.to_owned(), property);
        Ok(())
    }

    fn property_metadata(&mut self, property: &mut Property) -> Result<()> {
        while !self.lexer.skip(b')') {
            if self.lexer.skip(b';') || self.lexer.skip(b',') {
                continue;
            }
            match self.lexer.next()? {
                Token::Text(_) => continue,
                Token::Word(word) => {
                    let name = match Edit::of(word) {
                        Some(_) => self.lexer.word()?,
                        None => word,
                    };
                    self.lexer.expect(b'=')?;
                    if name == "interpolation" {
                        property.interpolation = Some(self.lexer.text()?);
                    } else {
                        skip(&mut self.lexer, 0)?;
                    }
                }
                _ => return Err(self.lexer.error("a name is missing")),
            }
        }
        Ok(())
    }
}

/// Whole numbers of a list.
fn numbers(lexer: &mut Lexer<'_>) -> Result<Vec<i64>> {
    match typed(lexer, "int64")? {
        Value::Numbers(Numbers { data, .. }) => {
            Ok(data.into_iter().map(|number| number as i64).collect())
        }
        _ => Ok(Vec::new()),
    }
}

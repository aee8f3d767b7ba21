//! Keys of a TOML table, removed from it by the structures they fill.

use crate::args::similar;
use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, forward_to_deserialize_any};
use std::fmt;
use toml::Spanned;
use toml::de::DeTable;

/// An error in a manifest, with its position.
#[derive(Debug)]
pub(super) struct Problem {
    message: String,
    /// Byte offset in the text where it begins.
    at: Option<usize>,
}

impl Problem {
    pub(super) fn new(message: impl Into<String>, at: usize) -> Self {
        Self { message: message.into(), at: Some(at) }
    }

    pub(super) fn from_toml(error: &toml::de::Error) -> Self {
        Self { message: error.message().to_owned(), at: error.span().map(|s| s.start) }
    }

    /// The message under a heading, such as `measurement 2`.
    pub(super) fn within(mut self, heading: &str) -> Self {
        self.message = format!("{heading}: {}", self.message);
        self
    }

    /// `line 4, column 1: …`
    pub(super) fn in_text(&self, text: &str) -> String {
        let Some(before) = self.at.and_then(|at| text.get(..at)) else { return self.message.clone() };
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
        format!("line {line}, column {column}: {}", self.message)
    }
}

/// A table from which structures take their keys one after the other.
pub(super) struct Keys<'i> {
    table: DeTable<'i>,
    /// Its position.
    pub(super) at: usize,
    known: Vec<&'static str>,
}

impl<'i> Keys<'i> {
    pub(super) fn new(table: Spanned<DeTable<'i>>) -> Self {
        Self { at: table.span().start, table: table.into_inner(), known: Vec::new() }
    }

    /// Fills a `T` from the keys named like its fields; all of them have a default.
    pub(super) fn take<T: Deserialize<'i>>(&mut self) -> Result<T, Problem> {
        let fields = fields::<T>();
        self.known.extend(fields);
        let (own, rest) = std::mem::take(&mut self.table)
            .into_iter()
            .partition(|(key, _)| fields.contains(&key.get_ref().as_ref()));
        self.table = rest;
        let own = toml::de::Deserializer::from(Spanned::new(0..0, own));
        T::deserialize(own).map_err(|e| Problem::from_toml(&e))
    }

    /// Whether a key remains.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// The first remaining key that resembles one of `words`, and that word.
    pub(super) fn meant(&self, words: &[&'static str]) -> Option<(&str, &'static str)> {
        let keys = self.table.keys().map(|key| key.get_ref().as_ref());
        keys.filter_map(|key| Some((key, similar(key, words.iter().copied())?))).next()
    }

    /// The remaining key that names a file in other words, if there is one.
    pub(super) fn names_file(&self) -> Option<&str> {
        self.table
            .keys()
            .map(|key| key.get_ref().as_ref())
            .find(|key| similar(key, ["file", "path", "files"]).is_some())
    }

    /// Names of tables that are parsed elsewhere, so that the error for a similar name can suggest them.
    pub(super) fn know(&mut self, words: &[&'static str]) {
        self.known.extend(words);
    }

    /// Refuses all keys that no structure took; `elsewhere` says where some keys belong.
    pub(super) fn finish(self, elsewhere: &[(&[&str], &str)]) -> Result<(), Problem> {
        let Some(key) = self.table.keys().min_by_key(|key| key.span().start) else { return Ok(()) };
        let (at, name) = (key.span().start, key.get_ref().as_ref());
        if let Some((_, why)) = elsewhere.iter().find(|(known, _)| known.contains(&name)) {
            return Err(Problem::new(format!("{name}: {why}"), at));
        }
        let meant =
            similar(name, self.known).map(|known| format!("; did you mean `{known}`?")).unwrap_or_default();
        Err(Problem::new(format!("unknown key `{name}`{meant}"), at))
    }
}

/// The names of a structure's fields, aliases included.
pub(super) fn fields<'de, T: Deserialize<'de>>() -> &'static [&'static str] {
    match T::deserialize(FieldNames) {
        Err(Names(fields)) => fields,
        Ok(_) => &[],
    }
}

/// A deserializer that fails with the field names it is asked for.
struct FieldNames;

#[derive(Debug)]
struct Names(&'static [&'static str]);

impl<'de> Deserializer<'de> for FieldNames {
    type Error = Names;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Names> {
        Err(Names(&[]))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Names> {
        Err(Names(fields))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

impl fmt::Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("names of fields")
    }
}

impl std::error::Error for Names {}

impl de::Error for Names {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self(&[])
    }
}

//! JSON as programs write it: also with `NaN` and `Infinity`, and with several values in succession.

use std::borrow::Cow;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};

/// Maximum number of values: one gigabyte of them.
const MOST: usize = (1 << 30) / size_of::<Node>();

/// A value; objects keep the order of their names.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    /// `null`, `NaN` and infinity.
    Missing,
    Number(f64),
    /// Also `true` and `false`.
    Text(String),
    List(Vec<Node>),
    Object(Vec<(String, Node)>),
}

/// All values of a text, or the problem and its line.
pub(super) fn parse(text: &[u8]) -> Result<Vec<Node>, String> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let marks = text.iter().filter(|b| matches!(b, b',' | b'[' | b'{' | b'\n')).count();
    if marks > MOST {
        return Err(format!("it holds more than {MOST} values; write it as CSV"));
    }
    let text = String::from_utf8_lossy(text);
    let text = with_null_for_words(&text);
    let values = serde_json::Deserializer::from_str(&text).into_iter();
    values.collect::<Result<_, _>>().map_err(|error| error.to_string())
}

/// The text with `null` in place of the non-standard words that Python and JavaScript write.
fn with_null_for_words(text: &str) -> Cow<'_, str> {
    const WORDS: [&str; 4] = ["-Infinity", "Infinity", "-NaN", "NaN"];
    if !WORDS.iter().any(|word| text.contains(word)) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while !rest.is_empty() {
        let (plain, quoted) = rest.split_at(rest.find('"').unwrap_or(rest.len()));
        out.push_str(&WORDS.iter().fold(plain.to_owned(), |text, word| text.replace(word, "null")));
        let (quoted, behind) = quoted.split_at(end_of_quote(quoted));
        out.push_str(quoted);
        rest = behind;
    }
    Cow::Owned(out)
}

/// Number of bytes from the opening quote of a text to the end of its closing quote.
fn end_of_quote(text: &str) -> usize {
    let mut escaped = false;
    for (at, byte) in text.bytes().enumerate().skip(1) {
        match byte {
            b'"' if !escaped => return at + 1,
            _ => escaped = byte == b'\\' && !escaped,
        }
    }
    text.len()
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Missing)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Node, E> {
        Ok(Node::Text(value.to_string()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
        Ok(Node::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node, E> {
        Ok(Node::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
        Ok(Node::Number(value))
    }

    fn visit_str<E>(self, text: &str) -> Result<Node, E> {
        Ok(Node::Text(text.replace(char::is_control, " ")))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<Node, A::Error> {
        let mut list = Vec::new();
        while let Some(value) = values.next_element()? {
            list.push(value);
        }
        list.shrink_to_fit();
        Ok(Node::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut values: A) -> Result<Node, A::Error> {
        let mut object = Vec::new();
        while let Some(entry) = values.next_entry()? {
            object.push(entry);
        }
        Ok(Node::Object(object))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_are_those_of_the_grammar() {
        let number = Node::Number;
        let text = |text: &str| Node::Text(text.to_owned());
        for (written, read) in [
            ("[1, -2.5e3,null]", Node::List(vec![number(1.0), number(-2500.0), Node::Missing])),
            ("[NaN, -Infinity, -NaN]", Node::List(vec![Node::Missing; 3])),
            ("[\"\\\"NaN\", NaN, \"NaN\\\\\", NaN]", {
                Node::List(vec![text("\"NaN"), Node::Missing, text("NaN\\"), Node::Missing])
            }),
            (
                "{\"t\": 0, \"x (\\u00b5m)\":[], \"a\": 1}",
                Node::Object(vec![
                    ("t".to_owned(), number(0.0)),
                    ("x (\u{b5}m)".to_owned(), Node::List(Vec::new())),
                    ("a".to_owned(), number(1.0)),
                ]),
            ),
            ("\"a\\\"b\\\\ \\ud83d\\ude00\\n\"", text("a\"b\\ \u{1f600} ")),
            ("true", text("true")),
            ("{}", Node::Object(Vec::new())),
            // One third, exact to the last digit.
            ("0.3333333333333333", number(1.0 / 3.0)),
        ] {
            assert_eq!(parse(written.as_bytes()), Ok(vec![read]), "{written}");
        }
        assert_eq!(parse(b"{}\n[ ]\n").map(|all| all.len()), Ok(2));
        for (written, problem) in [
            ("[1,\n2", "EOF while parsing a list at line 2 column 1"),
            ("[1 2]", "expected `,` or `]` at line 1 column 4"),
            ("[1,]", "trailing comma at line 1 column 4"),
            ("{\"t\" 0}", "expected `:` at line 1 column 6"),
            ("{t: 0}", "key must be a string at line 1 column 2"),
            ("[0x1]", "expected `,` or `]` at line 1 column 3"),
            ("\"\\ud83d\\ude", "EOF while parsing a string at line 1 column 11"),
            ("[1e999]", "number out of range at line 1 column 6"),
        ] {
            assert_eq!(parse(written.as_bytes()), Err(problem.to_owned()), "{written}");
        }
        let deep = "[".repeat(100_000);
        assert!(parse(deep.as_bytes()).unwrap_err().contains("recursion limit"));
    }

    proptest! {
        #[test]
        fn texts_of_any_kind_are_read_or_refused(
            words in prop::collection::vec(
                prop::sample::select(vec![
                    "[", "]", "{", "}", ",", ":", "\"", "\\", "\\u", "d83d", "t", "1", "-", "e5", "null", "NaN", " ",
                    "\n", "\u{b5}",
                ]),
                0..60,
            )
        ) {
            let _ = parse(words.concat().as_bytes());
        }
    }
}

//! JSON as programs write it: with `NaN` and `Infinity` too, and with several values one after the other.

/// Lists and objects in each other, at most.
const DEEPEST: usize = 64;
/// Values at most: a gigabyte of them.
const MOST: usize = (1 << 30) / size_of::<Node>();

/// A value.
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

/// All values of a text, or why not and in which line.
pub(super) fn parse(text: &[u8]) -> Result<Vec<Node>, String> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut parser = Parser { text, at: 0, values: 0 };
    let mut found = Vec::new();
    while parser.next_byte().is_some() {
        found.push(parser.value(0).map_err(|problem| parser.located(&problem))?);
    }
    Ok(found)
}

struct Parser<'a> {
    text: &'a [u8],
    at: usize,
    values: usize,
}

impl Parser<'_> {
    fn located(&self, problem: &str) -> String {
        let before = &self.text[..self.at.min(self.text.len())];
        let line = memchr::memchr_iter(b'\n', before).count() + 1;
        let column = before.len() - memchr::memrchr(b'\n', before).map_or(0, |at| at + 1) + 1;
        format!("line {line}, column {column}: {problem}")
    }

    /// The next byte that is no blank.
    fn next_byte(&mut self) -> Option<u8> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_ascii_start().len();
        self.text.get(self.at).copied()
    }

    fn value(&mut self, depth: usize) -> Result<Node, String> {
        self.values += 1;
        if self.values > MOST {
            return Err(format!("it holds more than {MOST} values; write it as CSV"));
        }
        match self.next_byte() {
            None => Err("it ends where a value should stand".to_owned()),
            Some(b'[' | b'{') if depth == DEEPEST => {
                Err(format!("more than {DEEPEST} lists and objects lie in each other"))
            }
            Some(b'[') => self.list(depth),
            Some(b'{') => self.object(depth),
            Some(b'"') => Ok(Node::Text(self.text()?)),
            Some(_) => self.number_or_word(),
        }
    }

    /// Steps over a separator; `false` at the closing mark.
    fn goes_on(&mut self, close: u8, within: &str) -> Result<bool, String> {
        match self.next_byte() {
            Some(b',') => {
                self.at += 1;
                Ok(true)
            }
            Some(byte) if byte == close => {
                self.at += 1;
                Ok(false)
            }
            Some(_) => Err(format!("`,` or `{}` should stand in {within}", char::from(close))),
            None => Err(format!("it ends within {within}")),
        }
    }

    fn list(&mut self, depth: usize) -> Result<Node, String> {
        self.at += 1;
        let mut values = Vec::new();
        if self.next_byte() == Some(b']') {
            self.at += 1;
            return Ok(Node::List(values));
        }
        loop {
            values.push(self.value(depth + 1)?);
            if !self.goes_on(b']', "a list")? {
                values.shrink_to_fit();
                return Ok(Node::List(values));
            }
        }
    }

    fn object(&mut self, depth: usize) -> Result<Node, String> {
        self.at += 1;
        let mut values = Vec::new();
        if self.next_byte() == Some(b'}') {
            self.at += 1;
            return Ok(Node::Object(values));
        }
        loop {
            if self.next_byte() != Some(b'"') {
                return Err("a name in quotes should stand in an object".to_owned());
            }
            let name = self.text()?;
            if self.next_byte() != Some(b':') {
                return Err("`:` should stand behind a name".to_owned());
            }
            self.at += 1;
            values.push((name, self.value(depth + 1)?));
            if !self.goes_on(b'}', "an object")? {
                return Ok(Node::Object(values));
            }
        }
    }

    /// A text in quotes.
    fn text(&mut self) -> Result<String, String> {
        self.at += 1;
        let mut bytes = Vec::new();
        loop {
            let rest = &self.text[self.at..];
            let Some(plain) = memchr::memchr2(b'"', b'\\', rest) else {
                return Err("it ends within a text".to_owned());
            };
            bytes.extend_from_slice(&rest[..plain]);
            self.at += plain + 1;
            if rest[plain] == b'"' {
                return Ok(String::from_utf8_lossy(&bytes).into_owned());
            }
            let escaped = self.text.get(self.at).copied().ok_or("it ends within a text")?;
            self.at += 1;
            let plain = match escaped {
                b'u' => self.escaped()?,
                b'n' | b'r' | b't' | b'b' | b'f' => ' ',
                other => char::from(other),
            };
            bytes.extend_from_slice(plain.encode_utf8(&mut [0; 4]).as_bytes());
        }
    }

    /// The character of `\u00b5`, or of two such for one beyond 16 bits.
    fn escaped(&mut self) -> Result<char, String> {
        let mut units = vec![self.unit()?];
        if (0xd800..0xdc00).contains(&units[0]) && self.text[self.at..].starts_with(b"\\u") {
            self.at += 2;
            units.push(self.unit()?);
        }
        let decoded = char::decode_utf16(units).next();
        Ok(decoded.and_then(Result::ok).unwrap_or(char::REPLACEMENT_CHARACTER))
    }

    /// Four hexadecimal digits.
    fn unit(&mut self) -> Result<u16, String> {
        let digits = self.text.get(self.at..self.at + 4).and_then(|d| std::str::from_utf8(d).ok());
        let unit = digits.and_then(|digits| u16::from_str_radix(digits, 16).ok());
        let unit = unit.ok_or("four hexadecimal digits should stand behind `\\u`")?;
        self.at += 4;
        Ok(unit)
    }

    fn number_or_word(&mut self) -> Result<Node, String> {
        let rest = &self.text[self.at..];
        let ends =
            |b: &u8| b.is_ascii_whitespace() || matches!(b, b',' | b']' | b'}' | b':' | b'[' | b'{' | b'"');
        let word = &rest[..rest.iter().position(ends).unwrap_or(rest.len())];
        let node = match word {
            b"null" | b"NaN" | b"-NaN" | b"Infinity" | b"-Infinity" => Node::Missing,
            b"true" => Node::Text("true".to_owned()),
            b"false" => Node::Text("false".to_owned()),
            _ if word.first().is_some_and(|b| b.is_ascii_digit() || *b == b'-') => {
                match fast_float2::parse::<f64, _>(word) {
                    Ok(value) if value.is_finite() => Node::Number(value),
                    Ok(_) => Node::Missing,
                    Err(_) => return Err(unknown(word)),
                }
            }
            _ => return Err(unknown(word)),
        };
        self.at += word.len();
        Ok(node)
    }
}

fn unknown(word: &[u8]) -> String {
    let word: String = String::from_utf8_lossy(word).chars().filter(|c| !c.is_control()).take(24).collect();
    format!("`{word}` is no value")
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
            ("[NaN, -Infinity, 1e999]", Node::List(vec![Node::Missing; 3])),
            (
                "{\"t\": 0, \"x (\\u00b5m)\":[]}",
                Node::Object(vec![
                    ("t".to_owned(), number(0.0)),
                    ("x (\u{b5}m)".to_owned(), Node::List(Vec::new())),
                ]),
            ),
            ("\"a\\\"b\\\\ \\ud83d\\ude00\"", text("a\"b\\ \u{1f600}")),
            ("\"\\ud83d\"", text("\u{fffd}")),
            ("true", text("true")),
            ("{}", Node::Object(Vec::new())),
            // One third to the last digit.
            ("0.3333333333333333", number(1.0 / 3.0)),
        ] {
            assert_eq!(parse(written.as_bytes()), Ok(vec![read]), "{written}");
        }
        assert_eq!(parse(b"{}\n[ ]\n").map(|all| all.len()), Ok(2));
        for (written, problem) in [
            ("[1,\n2", "line 2, column 2: it ends within a list"),
            ("[1 2]", "line 1, column 4: `,` or `]` should stand in a list"),
            ("[1,]", "line 1, column 4: `` is no value"),
            ("{\"t\" 0}", "line 1, column 6: `:` should stand behind a name"),
            ("{t: 0}", "line 1, column 2: a name in quotes should stand in an object"),
            ("[0x1]", "line 1, column 2: `0x1` is no value"),
            ("\"\\ud83d\\ude", "line 1, column 10: four hexadecimal digits should stand behind `\\u`"),
            ("\"\\u12", "line 1, column 4: four hexadecimal digits should stand behind `\\u`"),
        ] {
            assert_eq!(parse(written.as_bytes()), Err(problem.to_owned()), "{written}");
        }
        let deep = "[".repeat(100_000);
        assert!(parse(deep.as_bytes()).unwrap_err().contains("more than 64 lists"));
    }

    proptest! {
        #[test]
        fn texts_of_any_kind_are_read_or_refused(
            words in prop::collection::vec(
                prop::sample::select(vec![
                    "[", "]", "{", "}", ",", ":", "\"", "\\", "\\u", "d83d", "t", "1", "-", "e5", "null", " ", "\n", "\u{b5}",
                ]),
                0..60,
            )
        ) {
            let _ = parse(words.concat().as_bytes());
        }
    }
}

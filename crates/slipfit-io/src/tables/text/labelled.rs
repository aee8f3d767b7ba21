//! Lines of names and values in the format of the Arduino serial plotter: `t:0 x:512`, `t=0, x=512`.

use super::{
    layout::text,
    number::{self, Cell},
};
use crate::{
    columns::name::Name,
    report::{Decimal, Note},
};

/// Maximum number of different names in the first lines.
const MOST: usize = 256;

/// The names, in order of appearance.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Labels(Vec<Vec<u8>>);

/// A name and its value as written.
type Pair<'a> = (&'a [u8], &'a [u8]);

impl Labels {
    /// Names in the first lines, if most of these lines, and at least `fewest`, have this form.
    pub(super) fn find(lines: &[&[u8]], fewest: usize) -> Option<Self> {
        let filled = lines.iter().filter(|line| !line.trim_ascii().is_empty()).count();
        let rows: Vec<Vec<Pair<'_>>> = lines.iter().filter_map(|line| pairs(line)).collect();
        if rows.len() < fewest || rows.len() * 2 <= filled {
            return None;
        }
        let mut labels: Vec<Vec<u8>> = Vec::new();
        for (label, _) in rows.iter().flatten() {
            if !labels.iter().any(|known| known == label) {
                labels.push(label.to_vec());
            }
        }
        (labels.len() <= MOST).then_some(Self(labels))
    }

    /// The values of a line in the order of the names; any other line, or one with additional names, becomes a remark.
    pub(super) fn line(&self, line: &[u8], out: &mut Vec<u8>) {
        if line.trim_ascii().is_empty() {
            return out.extend_from_slice(line);
        }
        let mut values: Vec<&[u8]> = vec![b""; self.0.len()];
        let known = pairs(line).is_some_and(|pairs| {
            pairs.iter().all(|(label, value)| {
                let place = self.0.iter().position(|known| known == label);
                place.inspect(|i| values[*i] = value).is_some()
            })
        });
        if known {
            out.extend_from_slice(&values.join(&b'\t'));
        } else {
            out.extend_from_slice(b"# ");
            out.extend_from_slice(line);
        }
    }

    pub(super) fn names(&self) -> Vec<Name> {
        self.0.iter().map(|label| Name::parse(&text(label))).collect()
    }

    pub(super) fn note(&self) -> Note {
        let names: Vec<_> = self.0.iter().take(8).map(|label| text(label)).collect();
        let more = if self.0.len() > names.len() { ", …" } else { "" };
        Note::new(format!(
            "the names in front of the values were read as columns: {}{more}",
            names.join(", ")
        ))
    }
}

/// Names and numbers of a line; `None` for any other line.
fn pairs(line: &[u8]) -> Option<Vec<Pair<'_>>> {
    let is_separator = |b: &u8| matches!(b, b' ' | b'\t' | b',' | b';' | b'\r');
    let mut rest = line;
    let mut pairs = Vec::new();
    loop {
        while let [first, behind @ ..] = rest
            && is_separator(first)
        {
            rest = behind;
        }
        if rest.is_empty() {
            return (!pairs.is_empty()).then_some(pairs);
        }
        let mark = rest.iter().position(|b| matches!(b, b':' | b'='))?;
        let (label, behind) = (rest[..mark].trim_ascii_end(), rest[mark + 1..].trim_ascii_start());
        let is_name = !label.first()?.is_ascii_digit() && !label.iter().any(is_separator);
        let end = behind.iter().position(is_separator).unwrap_or(behind.len());
        let value = &behind[..end];
        // `x:y` names something else, as does a time of day.
        if !is_name || value.is_empty() || number::cell(value, Decimal::Point) == Cell::Text {
            return None;
        }
        let plain = matches!(value[0], b'0'..=b'9' | b'+' | b'-' | b'.') && value.contains(&b':');
        if plain {
            return None;
        }
        pairs.push((label, value));
        rest = &behind[end..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_told_from_other_lines() {
        let of = |line: &str| {
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            pairs(line.as_bytes()).map(|pairs| {
                pairs.iter().map(|(l, v)| text(l) + "|" + &text(v)).collect::<Vec<_>>().join(" ")
            })
        };
        for line in ["t:0 x:512", "t:0,x:512\r", "t: 0, x: 512", "t:0\tx:512", "t=0; x = 512", " t:0  x:512 "]
        {
            assert_eq!(of(line).as_deref(), Some("t|0 x|512"), "{line}");
        }
        assert_eq!(of("x:nan t:-1.5e3").as_deref(), Some("x|nan t|-1.5e3"));
        for line in
            ["", "ready", "t:0 512", "12:34:56", "time:12:34:56", "t:0 x:", "t:0 x:y", "x:0,53", "0:1"]
        {
            assert_eq!(of(line), None, "{line}");
        }
    }
}

//! Parts of workbooks: XML in an archive.

use std::io::{BufRead, BufReader, Read};

use quick_xml::{
    Reader,
    events::{BytesRef, BytesStart, Event},
};

use crate::{
    error::ReadProblem,
    format::Format,
    tables::unpack::{Archive, BUDGET},
};

/// Passes every event of a part to `each` until it returns `false`; does nothing if the part is missing.
pub(super) fn events_while(
    archive: &mut Archive,
    part: &str,
    format: Format,
    mut each: impl FnMut(Event<'_>) -> Result<bool, ReadProblem>,
) -> Result<(), ReadProblem> {
    let Ok(file) = archive.by_name(part) else { return Ok(()) };
    let mut reader =
        Reader::from_reader(Box::new(BufReader::new(file.take(BUDGET as u64))) as Box<dyn BufRead + '_>);
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer) {
            Ok(Event::Eof) => return Ok(()),
            Ok(event) => {
                if !each(event)? {
                    return Ok(());
                }
            }
            Err(error) => return Err(format.broken(format!("{part}: {error}"))),
        }
    }
}

/// The value of an attribute.
pub(super) fn attribute(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = tag.attributes().flatten().find(|a| a.key.as_ref() == name)?;
    Some(unescaped(&found.value))
}

/// Text with the five XML entities replaced.
fn unescaped(text: &str) -> String {
    if !text.contains('&') {
        return text.to_owned();
    }
    let plain = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
    plain.replace("&apos;", "'").replace("&amp;", "&")
}

/// The character that a reference in a text represents.
pub(super) fn character(reference: &BytesRef<'_>) -> Option<char> {
    match &**reference {
        "lt" => Some('<'),
        "gt" => Some('>'),
        "amp" => Some('&'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => reference.resolve_char_ref().ok().flatten(),
    }
}

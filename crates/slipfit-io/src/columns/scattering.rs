//! Scattering parameters by their names.

/// Ports of a scattering parameter named in a header, `S21` or `Trc1_S11`: to which and from which.
pub(super) fn scattering(header: &str) -> Option<(u8, u8)> {
    let words = header.split(|c: char| !c.is_ascii_alphanumeric());
    words.into_iter().find_map(|word| match word.as_bytes() {
        [b'S' | b's', into @ b'1'..=b'9', from @ b'1'..=b'9'] => Some((*into, *from)),
        _ => None,
    })
}

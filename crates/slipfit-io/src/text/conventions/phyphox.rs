//! phyphox, the phone's laboratory: quoted headers with units in brackets,
//! numbers such as `0.000000000E0`, in five dialects.

use super::{Convention, Layout, Look};

pub(super) struct Phyphox;

impl Convention for Phyphox {
    fn name(&self) -> &'static str {
        "phyphox"
    }

    fn fits(&self, look: &Look) -> bool {
        let header = look.lines.last().map(String::as_str).unwrap_or_default();
        header.starts_with("\"Time (s)\"") && look.headers.iter().all(|h| h.ends_with(')'))
    }

    fn adjust(&self, _: &Look, _: &mut Layout) {}
}

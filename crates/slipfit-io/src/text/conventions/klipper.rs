//! Klipper, firmware of 3D printers: raw accelerations and their spectra.

use super::{Convention, Layout, Look};
use crate::columns::names::Name;

pub(super) struct Klipper;

impl Convention for Klipper {
    fn name(&self) -> &'static str {
        "Klipper"
    }

    fn fits(&self, look: &Look) -> bool {
        let headers: Vec<&str> = look.headers.iter().map(String::as_str).collect();
        matches!(
            headers[..],
            ["time", "accel_x", "accel_y", "accel_z", ..] | ["freq", "psd_x", "psd_y", "psd_z", ..]
        )
    }

    /// Klipper's raw data are in seconds and mm/s², as its documentation says.
    fn adjust(&self, _: &Look, layout: &mut Layout) {
        for name in &mut layout.head.names {
            let unit = match name.header.as_str() {
                "time" => "s",
                "freq" => "Hz",
                header if header.starts_with("accel_") => "mm/s^2",
                _ => continue,
            };
            *name = Name { unit: unit.to_owned(), ..Name::parse(&name.header) };
        }
        layout.head.notes.push("Klipper names no units: seconds and mm/s^2 are those it writes".to_owned());
    }
}

//! A picture and its file formats.

use super::figure::Figure;
#[cfg(feature = "png")]
use super::png;
use super::svg;
use std::path::Path;

/// File format of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Scalable; text stays text.
    Svg,
    /// Pixels, at twice the size.
    #[cfg(feature = "png")]
    Png,
}

impl Format {
    /// The format given by the extension of a file name; `None` if it is not known.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match ending.as_str() {
            "svg" => Some(Self::Svg),
            #[cfg(feature = "png")]
            "png" => Some(Self::Png),
            _ => None,
        }
    }
}

/// A figure before it is written in a file format.
pub struct Picture(pub(super) Figure);

impl Picture {
    /// As an element of an HTML page.
    pub(crate) fn inline_svg(&self) -> String {
        svg::inline(&self.0)
    }

    /// The picture in a file format; `None` if there is not enough memory for its pixels.
    pub fn render(&self, format: Format) -> Option<Vec<u8>> {
        match format {
            Format::Svg => Some(svg::render(&self.0)),
            #[cfg(feature = "png")]
            Format::Png => png::render(&self.0),
        }
    }
}

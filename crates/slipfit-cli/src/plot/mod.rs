//! Pictures, drawn once and written as SVG or PNG.

mod axis;
mod chart;
mod dark;
mod decimate;
mod figure;
mod files;
mod font;
mod grid;
mod heat;
mod levels;
mod panel;
mod png;
mod resonance;
mod ringdown;
mod series;
mod svg;
pub(crate) mod terminal;

pub(crate) use chart::{Chart, Look, Scaled, Series, page};
pub(crate) use dark::dark_rules;
pub(crate) use heat::{HeatMap, heat_maps};
pub(crate) use svg::escape;

use crate::batch::Row;
use crate::command::levels::AnalysedLevels;
use crate::command::resonance::AnalysedCurve;
use crate::command::ringdown::Analysed;
use crate::command::series::AnalysedSeries;
use crate::failure::Failure;
use std::path::Path;

/// File format of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    Svg,
    Png,
}

impl Format {
    /// By the ending of the file's name.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => Err(Failure::new(format!(
                "--plot {}: no picture format is known by that ending",
                path.display()
            ))
            .hint("name the file .svg or .png")),
        }
    }
}

/// The picture of a ring-down.
pub(crate) fn ringdown(analysed: &Analysed<'_>, format: Format) -> Result<Vec<u8>, Failure> {
    Picture(ringdown::figure(analysed)).render(format)
}

/// The picture of a resonance curve.
pub(crate) fn resonance(analysed: &AnalysedCurve<'_>, format: Format) -> Result<Vec<u8>, Failure> {
    Picture(resonance::figure(analysed)).render(format)
}

/// The picture of drive levels.
pub(crate) fn levels(analysed: &AnalysedLevels<'_>, format: Format) -> Result<Vec<u8>, Failure> {
    let sentence = crate::report::levels_sentence(analysed.answer);
    page("Amplitude over the level of the drive", &sentence, &levels::charts(analysed)).render(format)
}

/// The picture of a series.
pub(crate) fn series(analysed: &AnalysedSeries<'_>, format: Format) -> Result<Vec<u8>, Failure> {
    Picture(series::figure(analysed)).render(format)
}

/// The picture across many files.
pub(crate) fn files(rows: &[Row], format: Format) -> Result<Vec<u8>, Failure> {
    Picture(files::figure(rows)).render(format)
}

/// The panels of an answer, each a picture of its own.
pub(crate) fn ringdown_panels(analysed: &Analysed<'_>) -> Vec<Picture> {
    ringdown::panels(analysed).into_iter().map(Picture).collect()
}

/// Likewise of a resonance curve.
pub(crate) fn resonance_panels(analysed: &AnalysedCurve<'_>) -> Vec<Picture> {
    resonance::panels(analysed).into_iter().map(Picture).collect()
}

/// Likewise of drive levels.
pub(crate) fn levels_panels(analysed: &AnalysedLevels<'_>) -> Vec<Picture> {
    levels::charts(analysed).iter().map(|chart| Picture(chart::draw(chart))).collect()
}

/// Likewise of a series.
pub(crate) fn series_panels(analysed: &AnalysedSeries<'_>) -> Vec<Picture> {
    series::panels(analysed).into_iter().map(Picture).collect()
}

/// A picture not yet in any format.
pub(crate) struct Picture(figure::Figure);

impl Picture {
    /// As an element of an HTML page.
    pub(crate) fn inline_svg(&self) -> String {
        svg::inline(&self.0)
    }

    /// In a file format.
    pub(crate) fn render(&self, format: Format) -> Result<Vec<u8>, Failure> {
        match format {
            Format::Svg => Ok(svg::render(&self.0)),
            Format::Png => png::render(&self.0).ok_or_else(|| Failure::new("the picture could not be drawn")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that are none, and nothing at all: still a picture.
    #[test]
    fn a_poor_answer_still_makes_a_picture() {
        type Change = fn(&mut slipfit::ringdown::Answer);
        let changes: [Change; 4] = [
            |_| (),
            |a| {
                a.envelope.clear();
                a.loss.clear();
            },
            |a| {
                a.envelope
                    .iter_mut()
                    .for_each(|p| (p.amplitude, p.fitted, p.std_error) = (f64::NAN, 0.0, f64::INFINITY))
            },
            |a| {
                a.comparison.clear();
                a.parameters.clear();
                a.loss.iter_mut().for_each(|p| (p.loss_per_cycle, p.fitted) = (f64::INFINITY, f64::NAN));
            },
        ];
        for change in changes {
            crate::command::ringdown::by_hand(change, |analysed| {
                let svg = String::from_utf8(ringdown(analysed, Format::Svg).unwrap()).unwrap();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
                assert!(ringdown(analysed, Format::Png).unwrap().len() > 1000);
            });
        }
    }

    #[test]
    fn the_ending_decides() {
        assert_eq!(Format::of(Path::new("a/b.SVG")).ok(), Some(Format::Svg));
        assert_eq!(Format::of(Path::new("b.png")).ok(), Some(Format::Png));
        assert!(Format::of(Path::new("b.pdf")).is_err() && Format::of(Path::new("svg")).is_err());
    }
}

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
mod images;
mod levels;
mod panel;
mod picture;
#[cfg(feature = "png")]
mod png;
mod resonance;
mod ringdown;
mod series;
mod svg;

pub use chart::{Chart, Scaled, Series, SeriesStyle, page};
pub use dark::dark_rules;
pub use decimate::decimate;
pub use heat::{HeatMap, heat_maps};
pub use images::{Image, images};
pub use picture::{Format, Picture};

use crate::Sentence;
use crate::row::Row;
use crate::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries};

/// The figure of a ring-down.
pub fn ringdown(analysed: &AnalysedRingdown<'_>) -> Picture {
    Picture(ringdown::figure(analysed))
}

/// The figure of a resonance curve.
pub fn resonance(analysed: &AnalysedCurve<'_>) -> Picture {
    Picture(resonance::figure(analysed))
}

/// The figure of drive levels.
pub fn levels(analysed: &AnalysedLevels<'_>) -> Picture {
    let sentence = analysed.answer.sentence();
    page("Amplitude over the level of the drive", &sentence, &levels::charts(analysed))
}

/// The figure of a series.
pub fn series(analysed: &AnalysedSeries<'_>) -> Picture {
    Picture(series::figure(analysed))
}

/// The figure across many files.
pub fn files(rows: &[Row]) -> Picture {
    Picture(files::figure(rows))
}

/// The panels of an answer, each as a separate picture.
pub(crate) fn ringdown_panels(analysed: &AnalysedRingdown<'_>) -> Vec<Picture> {
    ringdown::panels(analysed).into_iter().map(Picture).collect()
}

/// The same as [`ringdown_panels`].
pub(crate) fn resonance_panels(analysed: &AnalysedCurve<'_>) -> Vec<Picture> {
    resonance::panels(analysed).into_iter().map(Picture).collect()
}

/// The same as [`ringdown_panels`].
pub(crate) fn levels_panels(analysed: &AnalysedLevels<'_>) -> Vec<Picture> {
    levels::charts(analysed).iter().map(|chart| Picture(chart::draw(chart))).collect()
}

/// The same as [`ringdown_panels`].
pub(crate) fn series_panels(analysed: &AnalysedSeries<'_>) -> Vec<Picture> {
    series::panels(analysed).into_iter().map(Picture).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Non-finite numbers and missing results still give a picture.
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
                a.parameters = Default::default();
                a.loss.iter_mut().for_each(|p| (p.loss_per_cycle, p.fitted) = (f64::INFINITY, f64::NAN));
            },
        ];
        for change in changes {
            crate::example::by_hand(change, |analysed| {
                let svg = String::from_utf8(ringdown(analysed).render(Format::Svg).unwrap()).unwrap();
                assert!(!svg.contains("NaN"), "{svg}");
                assert!(!svg.contains("inf"), "{svg}");
                assert!(ringdown(analysed).render(Format::Png).unwrap().len() > 1000);
            });
        }
    }

    #[test]
    fn the_ending_decides() {
        assert_eq!(Format::of(Path::new("a/b.SVG")), Some(Format::Svg));
        assert_eq!(Format::of(Path::new("b.png")), Some(Format::Png));
        assert_eq!(Format::of(Path::new("b.pdf")), None);
        assert_eq!(Format::of(Path::new("svg")), None);
    }
}

//! Images of a map, each with its colour bar and the distribution of its values.

use super::Picture;
use super::axis::Axis;
use super::figure::{Anchor, Color, Figure, Point, wrap};
use super::heat::{NONE, darkening};
use super::panel::{INK, Panel};

const IMAGE: Point = [460.0, 400.0];
const BAR: f64 = 118.0;
const HISTOGRAM: f64 = 330.0;
const BINS: usize = 40;
/// Maximum number of cells along a side; in larger maps neighbours are averaged.
const FINEST: usize = 256;
/// Maximum number of pixels that show their value and trace under the pointer.
const MOST_NOTES: usize = 10_000;
/// End of the grey core of a doubtful cell, as a fraction of its side.
const CORE: f64 = 0.75;
/// Fraction of the values at either end that the colour scale leaves out.
const OUTSIDE: f64 = 0.01;

/// A value for each pixel.
#[derive(Debug, Clone)]
pub struct Image {
    /// Quantity, with its unit.
    pub title: String,
    /// Row by row; `None` if there is no value.
    pub values: Vec<Option<f64>>,
    /// Unreliable values, which are drawn with a grey core and excluded from scale and histogram; empty for none.
    pub doubtful: Vec<bool>,
}

impl Image {
    /// The values that set the scale: the reliable ones, or all if there are no others.
    fn counted(&self) -> Vec<f64> {
        let finite = |sound: bool| -> Vec<f64> {
            let values = self.values.iter().enumerate();
            let kept = values.filter(|(i, _)| !(sound && self.doubtful.get(*i) == Some(&true)));
            kept.filter_map(|(_, value)| value.filter(|v| v.is_finite())).collect()
        };
        let sound = finite(true);
        if sound.is_empty() { finite(false) } else { sound }
    }
}

/// Images of one grid, one below the other, each with its colour bar and a histogram.
///
/// The colour scale leaves out one value in a hundred at either end. `notes` describes each pixel and is shown
/// with the value under the pointer, if the format allows it; pictures of more than ten thousand pixels omit it.
pub fn images(
    heading: &str,
    caption: &str,
    [rows, columns]: [usize; 2],
    images: &[Image],
    notes: &dyn Fn(usize, usize) -> String,
) -> Picture {
    let width = IMAGE[0] + BAR + HISTOGRAM;
    let lines = wrap(caption, 13.5, width - 60.0);
    let height = 50.0 + images.len() as f64 * IMAGE[1] + 24.0 + 19.0 * lines.len() as f64;
    let mut figure = Figure::new(width, height);
    figure.text([30.0, 32.0], heading, 18.0, INK, Anchor::Start);
    for (i, image) in images.iter().enumerate() {
        let top = 50.0 + i as f64 * IMAGE[1];
        let scale = scale(image.counted());
        figure.place([0.0, top], drawn(image, [rows, columns], scale, notes));
        figure.place([IMAGE[0], top], bar(scale));
        figure.place([IMAGE[0] + BAR, top], histogram(image, scale));
    }
    for (i, line) in lines.into_iter().enumerate() {
        let y = 50.0 + images.len() as f64 * IMAGE[1] + 16.0 + 19.0 * i as f64;
        figure.text([30.0, y], line, 13.5, INK.faded(0.8), Anchor::Start);
    }
    Picture(figure)
}

/// Ends of the colour scale.
fn scale(mut sorted: Vec<f64>) -> Option<[f64; 2]> {
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = |part: f64| sorted[(part * last as f64).round() as usize];
    let [low, high] = [at(OUTSIDE), at(1.0 - OUTSIDE)];
    // If all values are equal, the axis adds room around them.
    let axis = Axis::linear(low, high, "");
    Some([axis.low, axis.high])
}

fn colour(value: Option<f64>, scale: Option<[f64; 2]>) -> Color {
    match (value.filter(|v| v.is_finite()), scale) {
        (Some(value), Some([low, high])) => darkening((value - low) / (high - low)),
        _ => NONE,
    }
}

fn drawn(
    image: &Image,
    [rows, columns]: [usize; 2],
    scale: Option<[f64; 2]>,
    notes: &dyn Fn(usize, usize) -> String,
) -> Figure {
    let mut figure = Figure::new(IMAGE[0], IMAGE[1]);
    let axis = |length: usize, label: &str| Axis::linear(-0.5, length as f64 - 0.5, label);
    let mut panel = Panel::new(&mut figure, &image.title, axis(columns, "x"), axis(rows, "y"));
    let [tall, wide] = [rows.div_ceil(FINEST).max(1), columns.div_ceil(FINEST).max(1)];
    for top in (0..rows).step_by(tall) {
        for left in (0..columns).step_by(wide) {
            let (bottom, right) = ((top + tall).min(rows), (left + wide).min(columns));
            let cell = (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x)));
            let (mut doubtful, mut all) = (0, 0);
            let held: Vec<f64> = cell
                .inspect(|(y, x)| {
                    all += 1;
                    doubtful += usize::from(image.doubtful.get(y * columns + x) == Some(&true));
                })
                .filter_map(|(y, x)| image.values.get(y * columns + x).copied().flatten())
                .filter(|v| v.is_finite())
                .collect();
            let mean = (!held.is_empty()).then(|| held.iter().sum::<f64>() / held.len() as f64);
            let low = [left as f64 - 0.5, top as f64 - 0.5];
            panel.patch(low, [right as f64 - 0.5, bottom as f64 - 0.5], colour(mean, scale));
            // A cell that averages several pixels gets a core if most of them are doubtful.
            if 2 * doubtful > all && mean.is_some() {
                let core = |from: usize, to: usize, part: f64| from as f64 + part * (to - from) as f64 - 0.5;
                let ends = [1.0 - CORE, CORE].map(|part| [core(left, right, part), core(top, bottom, part)]);
                panel.patch(ends[0], ends[1], NONE);
            }
        }
    }
    if rows * columns <= MOST_NOTES {
        let mut points = Vec::new();
        let mut told = Vec::new();
        for y in 0..rows {
            for x in 0..columns {
                let Some(at) = panel.at([x as f64, y as f64]) else { continue };
                points.push(at);
                let value = image.values.get(y * columns + x).copied().flatten();
                let value = value.map_or_else(|| "no value".to_owned(), |v| format!("{v:.6e}"));
                told.push(format!("{}\n{}: {value}", notes(y, x), image.title));
            }
        }
        // Invisible dots that carry the values under the pointer.
        let side = (IMAGE[0] / columns.max(1) as f64).min(IMAGE[1] / rows.max(1) as f64);
        figure.dots(points, (0.4 * side).max(0.5) as f32, INK.faded(0.0), told);
    }
    figure
}

fn bar(scale: Option<[f64; 2]>) -> Figure {
    const STEPS: usize = 120;
    let mut figure = Figure::new(BAR, IMAGE[1]);
    let Some([low, high]) = scale else { return figure };
    let x = Axis { low: 0.0, high: 1.0, log: false, label: String::new(), names: Vec::new(), hidden: false };
    let mut panel = Panel::new(&mut figure, "", x, Axis::linear(low, high, ""));
    let at = |i: usize| low + (high - low) * i as f64 / STEPS as f64;
    for i in 0..STEPS {
        panel.patch([0.0, at(i)], [1.0, at(i + 1)], darkening((i as f64 + 0.5) / STEPS as f64));
    }
    figure
}

fn histogram(image: &Image, scale: Option<[f64; 2]>) -> Figure {
    let mut figure = Figure::new(HISTOGRAM, IMAGE[1]);
    let Some([low, high]) = scale else {
        let axis = |label: &str| Axis::linear(0.0, 1.0, label);
        Panel::new(&mut figure, "", axis(&image.title), axis("pixels")).note("no value");
        return figure;
    };
    let mut counts = [0_usize; BINS];
    let mut outside = 0_usize;
    for value in image.counted() {
        let place = (value - low) / (high - low);
        if (0.0..=1.0).contains(&place) {
            counts[((place * BINS as f64) as usize).min(BINS - 1)] += 1;
        } else {
            outside += 1;
        }
    }
    let most = counts.iter().copied().max().unwrap_or(0) as f64;
    let y = Axis::linear(0.0, (1.08 * most).max(1.0), "pixels");
    let mut panel = Panel::new(&mut figure, "", Axis::linear(low, high, image.title.clone()), y);
    let width = (high - low) / BINS as f64;
    for (i, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let from = low + i as f64 * width;
        let color = darkening(0.15 + 0.85 * (i as f64 + 0.5) / BINS as f64);
        panel.patch([from, 0.0], [from + width, *count as f64], color);
    }
    if outside > 0 {
        panel.remark(&format!("{outside} beyond the scale"));
    }
    figure
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Format;

    #[test]
    fn doubtful_values_stretch_no_scale() {
        let values: Vec<Option<f64>> = (0..40).map(|i| Some(f64::from(i))).chain([Some(1e6)]).collect();
        let with = |doubtful: Vec<bool>| {
            let image = Image { title: String::new(), values: values.clone(), doubtful };
            scale(image.counted()).expect("values")
        };
        let last = |from: usize| (0..41).map(|i| i >= from).collect();
        assert!(with(last(41))[1] > 1e5);
        assert!(with(last(40))[1] < 100.0);
        // There are no others.
        assert!(with(last(0))[1] > 1e5);
    }

    #[test]
    fn every_pixel_tells_its_trace_and_value() {
        let values = (0..6).map(|i| (i != 4).then_some(f64::from(i))).collect();
        let image = Image { title: "x_F (nm)".into(), values, doubtful: Vec::new() };
        let note = |y: usize, x: usize| format!("stack.npy[{y}, {x}]");
        let picture = images("Map", "caption", [2, 3], &[image], &note);
        let text = String::from_utf8(picture.render(Format::Svg).unwrap_or_default()).unwrap_or_default();
        assert_eq!(text.matches("stack.npy[").count(), 6, "{text}");
        assert!(text.contains("stack.npy[1, 2]\nx_F (nm): 5.000000e0"), "{text}");
        assert!(text.contains("stack.npy[1, 1]\nx_F (nm): no value"), "{text}");
    }

    #[test]
    fn doubtful_pixels_have_a_grey_core() {
        let grey = |doubtful: Vec<bool>| {
            let values = vec![Some(1.0), Some(2.0), None, Some(3.0)];
            let image = Image { title: "x_F (nm)".into(), values, doubtful };
            let picture = images("Map", "caption", [2, 2], &[image], &|_, _| String::new());
            let svg = String::from_utf8(picture.render(Format::Svg).unwrap_or_default()).unwrap_or_default();
            svg.matches("#cdd0d4").count()
        };
        // A cell without a value is entirely grey.
        assert_eq!(grey(vec![true, false, true, true]), grey(Vec::new()) + 2);
    }

    #[test]
    fn one_value_in_a_hundred_does_not_stretch_the_colours() {
        let mut values: Vec<Option<f64>> = (0..1000).map(|i| Some(f64::from(i))).collect();
        values[0] = Some(-1e9);
        values[1] = Some(f64::NAN);
        let of = |values| scale(Image { title: String::new(), values, doubtful: Vec::new() }.counted());
        assert_eq!(of(values), Some([11.0, 989.0]));
        assert_eq!(of(vec![None, Some(f64::NAN)]), None);
        assert_eq!(of(vec![Some(3.0), Some(3.0)]), Some([1.5, 4.5]));
    }
}

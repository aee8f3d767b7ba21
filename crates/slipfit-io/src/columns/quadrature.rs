//! Choice of the two columns that hold the outputs of a lock-in or the parts of a complex response.

use super::{chooser::Chooser, name, role::Role};

/// Words by which alone the names of two columns differ: the word for the real part, the word for the imaginary part,
/// and whether these words are ambiguous, so that the numbers have to confirm the pair.
const WORDS: &[(&str, &str, bool)] = &[
    ("re", "im", false),
    ("real", "imag", false),
    ("real", "imaginary", false),
    ("realteil", "imagin\u{e4}rteil", false),
    ("xreal", "ximag", false),
    ("inphase", "outofphase", false),
    ("inphase", "quadrature", false),
    ("inphase", "quad", false),
    ("x", "y", true),
    ("vx", "vy", true),
    ("ux", "uy", true),
    ("i", "q", true),
    ("cos", "sin", true),
    ("cosine", "sine", true),
    // The dissipative part is in quadrature with the force.
    ("dispersive", "absorptive", true),
    ("dispersion", "absorption", true),
    ("elastic", "absorptive", true),
    ("elastic", "dissipative", true),
    ("el", "abs", true),
];

/// Two columns that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pair {
    pub(crate) real: usize,
    pub(crate) imaginary: usize,
    /// Whether the names are just `X` and `Y`.
    bare: bool,
    /// Whether such names mean something else unless the numbers confirm the pair.
    vague: bool,
}

impl Pair {
    pub(crate) const WHY: &'static str = "one of two parts of a response";

    /// The other of the two.
    pub(crate) fn other(self, than: usize) -> Option<usize> {
        match than {
            than if than == self.real => Some(self.imaginary),
            than if than == self.imaginary => Some(self.real),
            _ => None,
        }
    }
}

/// Splits a header in lower case into words and numbers; a phrase of several words becomes a single word.
fn parts(header: &str) -> Vec<String> {
    let mut lower = header.to_lowercase();
    for between in ["-", " ", "_"] {
        let phrase = |words: &[&str]| words.join(between);
        lower = lower.replace(&phrase(&["out", "of", "phase"]), "outofphase");
        lower = replaced_word(&lower, &phrase(&["in", "phase"]), "inphase");
    }
    let mut parts: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in lower.chars() {
        let goes_on = c.is_alphabetic() && last.is_alphabetic() || c.is_numeric() && last.is_numeric();
        match parts.last_mut() {
            Some(part) if goes_on => part.push(c),
            _ if c.is_alphanumeric() => parts.push(c.to_string()),
            _ => {}
        }
        last = c;
    }
    parts
}

/// The text with `word` replaced unless a letter precedes it: `gain phase` is not `in phase`.
fn replaced_word(text: &str, word: &str, by: &str) -> String {
    match text.find(word) {
        Some(at) if !text[..at].ends_with(char::is_alphabetic) => text.replacen(word, by, 1),
        _ => text.to_owned(),
    }
}

/// Index of the only word in which two names differ.
fn difference(a: &[String], b: &[String]) -> Option<usize> {
    if a.len() != b.len() {
        return None;
    }
    let mut places = (0..a.len()).filter(|&i| a[i] != b[i]);
    let place = places.next()?;
    places.next().is_none().then_some(place)
}

impl Chooser<'_> {
    /// The first two columns whose names differ only in which part of one response they hold.
    pub(crate) fn quadrature_pair(&self, taken: &[usize]) -> Option<Pair> {
        let pairs = self.quadrature_pairs(taken);
        let paired = |i: usize| pairs.iter().any(|pair| pair.other(i).is_some());
        let modulus = self.near.iter().copied().find(|&i| {
            self.roles[i] == Role::Amplitude && !taken.contains(&i) && !paired(i) && self.filled(i)
        });
        let fits = |pair: &&Pair| {
            pair.bare
                || !pair.vague
                || modulus.is_none_or(|modulus| self.is_modulus(modulus, pair.real, pair.imaginary))
        };
        pairs.iter().find(fits).copied()
    }

    /// All such pairs, in the order of the columns.
    pub(super) fn quadrature_pairs(&self, taken: &[usize]) -> Vec<Pair> {
        let headed =
            |i: &usize| !self.head.names[*i].header.is_empty() && !taken.contains(i) && self.filled(*i);
        let columns: Vec<usize> = self.near.iter().copied().filter(headed).collect();
        let parts: Vec<Vec<String>> = columns.iter().map(|&i| parts(&self.head.names[i].header)).collect();
        let mut pairs: Vec<Pair> = Vec::new();
        for first in 0..columns.len() {
            for second in first + 1..columns.len() {
                let Some(place) = difference(&parts[first], &parts[second]) else { continue };
                let (a, b) = (parts[first][place].as_str(), parts[second][place].as_str());
                let listed = WORDS.iter().find_map(|&(real, imaginary, vague)| match (a, b) {
                    words if words == (real, imaginary) => Some((first, second, vague)),
                    words if words == (imaginary, real) => Some((second, first, vague)),
                    _ => None,
                });
                let Some((real, imaginary, vague)) = listed else { continue };
                // Three axes are not a lock-in.
                let third = parts.iter().any(|other| {
                    difference(&parts[first], other) == Some(place)
                        && a.ends_with(['x', 'y'])
                        && other[place].strip_suffix('z') == Some(&a[..a.len() - 1])
                });
                let (real, imaginary) = (columns[real], columns[imaginary]);
                let swings = |i: usize| self.finite(i).any(|v| v < 0.0);
                let used = |i: usize| pairs.iter().any(|pair| pair.other(i).is_some());
                if third || used(real) || used(imaginary) {
                    continue;
                }
                // A background can keep both parts above zero.
                let by_resonance = || {
                    let frequency = self.of_role(Role::Frequency, &[]);
                    frequency.is_some_and(|over| self.are_parts_not_amplitudes(over, real, imaginary))
                };
                if vague && !swings(real) && !swings(imaginary) && !by_resonance() {
                    continue;
                }
                let alone = |i: usize| name::words(&self.head.names[i].bare).len() == 1;
                let bare = a.len() == 1 && alone(real) && alone(imaginary) && parts[first].len() <= 2;
                pairs.push(Pair { real, imaginary, bare, vague });
            }
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{columns::head::Head, options::ReadOptions};

    fn found(headers: &[&str], values: &[Vec<f64>]) -> Option<(usize, usize)> {
        let head = Head::of(headers.iter().map(|h| (*h).to_owned()).collect::<Vec<String>>());
        let options = ReadOptions::default();
        let pair = Chooser::of_curve(&head, values, &options).quadrature_pair(&[0]);
        pair.map(|pair| (pair.real, pair.imaginary))
    }

    #[test]
    fn two_parts_of_one_response_are_told_by_the_one_word_in_which_their_names_differ() {
        let values = [vec![9.0, 10.0, 11.0], vec![1.0, 0.5, -1.0], vec![-0.1, -5.0, -0.1]];
        for names in [
            ["X", "Y"],
            ["Demod x", "Demod y"],
            ["LI Demod 1 X (A)", "LI Demod 1 Y (A)"],
            ["Input 1 X (V)", "Input 1 Y (V)"],
            ["Lock-in X (V)", "Lock-in Y (V)"],
            ["X1", "Y1"],
            ["Vx (V)", "Vy (V)"],
            ["demods/0/sample.x", "demods/0/sample.y"],
            ["re:Trc1_S21", "im:Trc1_S21"],
            ["S21_re", "S21_im"],
            ["S21 (Re)", "S21 (Im)"],
            ["S21 Real", "S21 Imag"],
            ["xreal", "ximag"],
            ["I", "Q"],
            ["cos (nm)", "sin (nm)"],
            ["Amp cos phi", "Amp sin phi"],
            ["In-phase (V)", "Out-of-phase (V)"],
            ["in phase", "quadrature"],
            ["S11 in-phase", "S11 quadrature"],
            ["dispersive", "absorptive"],
            ["elastic", "absorptive"],
            ["A_el (nm)", "A_abs (nm)"],
        ] {
            assert_eq!(found(&["f", names[0], names[1]], &values), Some((1, 2)), "{names:?}");
            assert_eq!(found(&["f", names[1], names[0]], &values), Some((2, 1)), "{names:?}");
        }
        for names in [["X1", "Y2"], ["X (V)", "Y (m)"], ["gain phase", "gain quadrature"], ["A", "B"]] {
            assert_eq!(found(&["f", names[0], names[1]], &values), None, "{names:?}");
        }
        let amplitudes = [vec![9.0, 10.0, 11.0], vec![1.0, 5.0, 1.0], vec![1.0, 2.0, 1.0]];
        assert_eq!(found(&["f", "X1", "Y1"], &amplitudes), None, "amplitudes along two axes");
    }

    #[test]
    fn parts_that_a_background_keeps_above_zero_are_told_from_amplitudes() {
        let f: Vec<f64> = (0..61).map(|i| 99.0 + f64::from(i) / 30.0).collect();
        let detuning = |f: f64| (f - 100.0) / 0.2;
        let real = |f: f64| 3.0 - detuning(f) / (1.0 + detuning(f).powi(2));
        let imaginary = |f: f64| 2.0 - 1.0 / (1.0 + detuning(f).powi(2));
        let column = |of: &dyn Fn(f64) -> f64| f.iter().map(|f| of(*f)).collect::<Vec<f64>>();
        let parts = [f.clone(), column(&real), column(&imaginary)];
        assert_eq!(found(&["frequency (Hz)", "X (V)", "Y (V)"], &parts), Some((1, 2)));
        let amplitude = |f: f64| (1.0 + detuning(f).powi(2)).sqrt().recip();
        let axes = [f.clone(), column(&amplitude), column(&|f| 0.3 * amplitude(f))];
        assert_eq!(found(&["frequency (Hz)", "X (V)", "Y (V)"], &axes), None);
    }

    #[test]
    fn three_axes_and_two_beside_another_amplitude_are_no_pair() {
        let (x, y) = (vec![1.0, 0.5, -1.0], vec![-0.1, -5.0, -0.1]);
        let f = vec![9.0, 10.0, 11.0];
        let r: Vec<f64> = x.iter().zip(&y).map(|(x, y): (&f64, &f64)| 0.7 * x.hypot(*y)).collect();
        let axes = [f.clone(), x.clone(), y.clone(), y.clone()];
        assert_eq!(found(&["f", "accel x", "accel y", "accel z"], &axes), None);
        let beside = |r: &[f64]| {
            found(&["f", "Demod x", "Demod y", "R"], &[f.clone(), x.clone(), y.clone(), r.to_vec()])
        };
        assert_eq!(beside(&r), Some((1, 2)), "its modulus");
        assert_eq!(beside(&[1.0, 2.0, 3.0]), None, "the amplitude of something else");
    }
}

//! Fourier transform of real values; their number is a power of two.
//!
//! Natively realfft is used, planned for the available vector instructions. In the browser only rustfft's radix 4 is
//! used, because a planner would include algorithms for every other length, a twentieth of the page's size.

#[cfg(not(target_arch = "wasm32"))]
pub(super) use planned::{forward, inverse};
#[cfg(target_arch = "wasm32")]
pub(super) use radix4::{forward, inverse};

#[cfg(not(target_arch = "wasm32"))]
mod planned {
    use nalgebra::Complex;
    use realfft::RealFftPlanner;
    use std::cell::RefCell;

    thread_local! {
        // Planning costs more than one transform; records of equal length share a plan.
        static PLANNER: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
    }

    /// The transform of n values, up to half the sampling rate (n/2 + 1 of them); `values` are overwritten. Returns
    /// false without doing anything if the lengths do not match.
    pub(in crate::signal) fn forward(
        values: &mut [f64],
        spectrum: &mut [Complex<f64>],
        scratch: &mut Vec<Complex<f64>>,
    ) -> bool {
        let plan = PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(values.len()));
        scratch.resize(plan.get_scratch_len(), Complex::default());
        plan.process_with_scratch(values, spectrum, scratch).is_ok()
    }

    /// The values of a transform, times their number; `spectrum` is overwritten.
    pub(in crate::signal) fn inverse(
        spectrum: &mut [Complex<f64>],
        values: &mut [f64],
        scratch: &mut Vec<Complex<f64>>,
    ) -> bool {
        let plan = PLANNER.with_borrow_mut(|planner| planner.plan_fft_inverse(values.len()));
        scratch.resize(plan.get_scratch_len(), Complex::default());
        plan.process_with_scratch(spectrum, values, scratch).is_ok()
    }
}

#[cfg(any(target_arch = "wasm32", test))]
mod radix4 {
    use nalgebra::Complex;
    use rustfft::algorithm::Radix4;
    use rustfft::{Fft as _, FftDirection};
    use std::cell::RefCell;
    use std::collections::BTreeMap;
    use std::rc::Rc;

    /// By length and direction (true: forward).
    type Plans = BTreeMap<(usize, bool), Rc<Radix4<f64>>>;

    thread_local! {
        static PLANS: RefCell<Plans> = RefCell::default();
    }

    /// Transforms complex numbers in place; their number is a power of two.
    fn transform(numbers: &mut Vec<Complex<f64>>, direction: FftDirection) {
        let key = (numbers.len(), direction == FftDirection::Forward);
        let plan = PLANS.with_borrow_mut(|plans| {
            plans.entry(key).or_insert_with(|| Rc::new(Radix4::new(key.0, direction))).clone()
        });
        let count = numbers.len();
        numbers.resize(count + plan.get_inplace_scratch_len(), Complex::default());
        let (numbers, scratch) = numbers.split_at_mut(count);
        plan.process_with_scratch(numbers, scratch);
    }

    fn lengths_match(values: usize, spectrum: usize) -> bool {
        values.is_power_of_two() && spectrum == values / 2 + 1
    }

    /// The transform of n values, up to half the sampling rate (n/2 + 1 of them). Returns false without doing
    /// anything if the lengths do not match.
    pub(in crate::signal) fn forward(
        values: &mut [f64],
        spectrum: &mut [Complex<f64>],
        scratch: &mut Vec<Complex<f64>>,
    ) -> bool {
        let fit = lengths_match(values.len(), spectrum.len());
        if fit {
            scratch.clear();
            scratch.extend(values.iter().map(|v| Complex::new(*v, 0.0)));
            transform(scratch, FftDirection::Forward);
            spectrum.copy_from_slice(&scratch[..spectrum.len()]);
        }
        fit
    }

    /// The values of a transform, times their number.
    pub(in crate::signal) fn inverse(
        spectrum: &mut [Complex<f64>],
        values: &mut [f64],
        scratch: &mut Vec<Complex<f64>>,
    ) -> bool {
        let fit = lengths_match(values.len(), spectrum.len());
        if fit {
            // The transform of a real signal above half the sampling rate is the conjugate of that below.
            let above = values.len() - spectrum.len();
            scratch.clear();
            scratch.extend_from_slice(spectrum);
            scratch.extend(spectrum[1..=above].iter().rev().map(Complex::conj));
            transform(scratch, FftDirection::Inverse);
            values.iter_mut().zip(&*scratch).for_each(|(value, c)| *value = c.re);
        }
        fit
    }
}

#[cfg(test)]
mod tests {
    use super::{planned, radix4};
    use nalgebra::Complex;

    #[test]
    fn both_transforms_are_one() {
        let mut scratch = Vec::new();
        for power in 1..13 {
            let n = 1usize << power;
            let values: Vec<f64> = (0..n).map(|i| crate::noise::jitter(i, 5)).collect();
            let mut spectra = [(); 2].map(|()| vec![Complex::default(); n / 2 + 1]);
            let mut back = [(); 2].map(|()| vec![0.0; n]);
            assert!(planned::forward(&mut values.clone(), &mut spectra[0], &mut scratch), "{n}");
            assert!(radix4::forward(&mut values.clone(), &mut spectra[1], &mut scratch), "{n}");
            let scale = (n as f64).sqrt();
            for (one, other) in spectra[0].iter().zip(&spectra[1]) {
                assert!((one - other).norm() < 1e-13 * scale, "{n}: {one} and {other}");
            }
            assert!(planned::inverse(&mut spectra[0].clone(), &mut back[0], &mut scratch), "{n}");
            assert!(radix4::inverse(&mut spectra[1], &mut back[1], &mut scratch), "{n}");
            for ((one, other), v) in back[0].iter().zip(&back[1]).zip(&values) {
                assert!(
                    (one / n as f64 - v).abs() < 1e-14 && (other / n as f64 - v).abs() < 1e-14,
                    "{n}: {v}"
                );
            }
        }
    }

    #[test]
    fn lengths_that_do_not_belong_together_are_refused() {
        let (mut values, mut spectrum) = ([0.0; 8], [Complex::default(); 4]);
        assert!(!radix4::forward(&mut values, &mut spectrum, &mut Vec::new()));
        assert!(!radix4::inverse(&mut spectrum, &mut values, &mut Vec::new()));
        assert!(!planned::forward(&mut values, &mut spectrum, &mut Vec::new()));
        assert!(!planned::inverse(&mut spectrum, &mut values, &mut Vec::new()));
    }
}

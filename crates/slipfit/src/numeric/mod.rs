//! Numerical building blocks: vectorised trigonometry, double-double arithmetic, quadrature, dual numbers, sums of
//! products, roots, sorting, robust statistics.

pub(crate) mod double_double;
pub(crate) mod dual;
pub(crate) mod order;
pub(crate) mod products;
pub(crate) mod quadrature;
pub(crate) mod robust;
pub(crate) mod roots;
pub(crate) mod trig;
pub(crate) mod wide;

/// Runs a kernel with the widest vector instructions of this machine.
///
/// A WebAssembly module compiled with SIMD does not start without it, so it contains its kernels once; natively they
/// exist for every width, and the machine chooses at run time.
#[inline(always)]
pub(crate) fn dispatch<Op: pulp::WithSimd>(op: Op) -> Op::Output {
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    {
        pulp::wasm::enable_simd128();
        match pulp::wasm::Simd128::try_new() {
            Some(simd) => pulp::Simd::vectorize(simd, op),
            None => unreachable!("lanes are enabled"),
        }
    }
    #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
    pulp::Arch::new().dispatch(op)
}

/// The golden section, `(√5 - 1)/2`: it divides a bracket, and its multiples modulo one are evenly distributed.
pub(crate) const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_8;

/// Sum of `of(value)` over all values; in separate lanes, because in a single chain each addition waits for the last.
#[inline(always)]
pub(crate) fn sum_of(values: &[f64], of: impl Fn(f64) -> f64) -> f64 {
    const LANES: usize = 16;
    let (pieces, rest) = values.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for piece in pieces {
        for k in 0..LANES {
            sums[k] += of(piece[k]);
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|v| of(*v)).sum::<f64>()
}

/// Minimum and maximum; in separate lanes, because in a single chain each comparison waits for the last.
pub(crate) fn extremes(values: &[f64]) -> (f64, f64) {
    const LANES: usize = 8;
    let mut low = [f64::INFINITY; LANES];
    let mut high = [f64::NEG_INFINITY; LANES];
    let mut chunks = values.chunks_exact(LANES);
    for part in &mut chunks {
        for k in 0..LANES {
            low[k] = if part[k] < low[k] { part[k] } else { low[k] };
            high[k] = if part[k] > high[k] { part[k] } else { high[k] };
        }
    }
    let least = low.iter().chain(chunks.remainder()).fold(f64::INFINITY, |a, &v| a.min(v));
    let greatest = high.iter().chain(chunks.remainder()).fold(f64::NEG_INFINITY, |a, &v| a.max(v));
    (least, greatest)
}

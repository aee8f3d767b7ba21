//! The Python extension `slipfit._core`: conversions between Python and the libraries.
//!
//! The package in `python/slipfit` is what users import; it contains the signatures, the documentation and the
//! types. Nothing is computed here.

mod answer;
mod arrays;
mod batch;
mod capsule;
mod column;
mod failure;
mod fits;
mod interrupt;
mod reading;
mod simulate;
mod stack;

/// Conversions between Python and the libraries.
#[pyo3::pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use crate::answer::{
        Answer, check_ringdown, levels_answer, parameter_names, resonance_answer, ringdown_answer,
        series_answer,
    };
    #[pymodule_export]
    use crate::batch::{ArrowStream, ArrowTable, Source, fit_batch, fit_stream};
    #[pymodule_export]
    use crate::fits::{curve, envelope, waveform};
    #[pymodule_export]
    use crate::reading::{
        Curve, Levels, Record, curve_of_arrays, levels_of_arrays, read_curve, read_levels, read_record,
        record_of_arrays, unit_factor, unit_of_name,
    };
    #[pymodule_export]
    use crate::simulate::{decay, driven, readings};
    #[pymodule_export]
    use crate::stack::Stack;

    /// Version of slipfit.
    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}

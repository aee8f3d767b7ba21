#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| slipfit_fuzz::bytes(bytes));

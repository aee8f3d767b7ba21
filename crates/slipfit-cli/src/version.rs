//! Which slipfit this is.

/// Version, and the commit it was built from where that is known: `0.1.0 (0123456789ab)`.
pub(crate) fn long() -> String {
    match option_env!("SLIPFIT_COMMIT") {
        Some(commit) => format!("{} ({commit})", env!("CARGO_PKG_VERSION")),
        None => env!("CARGO_PKG_VERSION").to_owned(),
    }
}

//! The page, embedded in the program by build.rs.

/// A file of the page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asset {
    /// Its path below the page, such as `vendor/uplot/LICENSE`.
    pub(super) path: &'static str,
    /// Its content, compressed by gzip.
    pub(super) packed: &'static [u8],
}

include!(concat!(env!("OUT_DIR"), "/site.rs"));

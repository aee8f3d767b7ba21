//! The page, packed into the program by build.rs.

/// A file of the page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asset {
    /// Its path below the page, as `vendor/uplot/LICENSE`.
    pub(super) path: &'static str,
    /// Its content, packed by gzip.
    pub(super) packed: &'static [u8],
}

include!(concat!(env!("OUT_DIR"), "/site.rs"));

//! A report to hand in, as one HTML page, or as tables in Markdown or LaTeX.

mod formula;
mod html;
mod latex;
mod markdown;
mod symbol;

pub use html::{fragment, html};
pub use latex::latex;
pub use markdown::markdown;

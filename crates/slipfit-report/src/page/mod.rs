//! A report to hand in, as one page of HTML, as tables of Markdown or of LaTeX.

mod formula;
mod html;
mod latex;
mod markdown;
mod symbol;

pub use html::{fragment, html};
pub use latex::latex;
pub use markdown::markdown;

//! Width and styles of the screen.

use anstyle::{AnsiColor, Style};

/// Width in columns of the screen a report is laid out for.
pub(crate) const WIDTH: usize = 80;

pub(crate) const ANSWER: Style = Style::new().bold();
pub(crate) const HEADING: Style = AnsiColor::Cyan.on_default();
pub(crate) const CHOSEN: Style = AnsiColor::Green.on_default();
pub(crate) const DIM: Style = Style::new().dimmed();

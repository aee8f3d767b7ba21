//! An answer in one plain sentence.

mod levels;
mod resonance;
mod ringdown;
mod series;

/// An answer that can be summarised in a sentence.
pub trait Sentence {
    /// What the data say about sliding friction: how much of the loss it carries and how sure
    /// that is, or why that cannot be determined.
    fn sentence(&self) -> String;
}

impl Sentence for slipfit::ringdown::Answer {
    fn sentence(&self) -> String {
        ringdown::sentence(self)
    }
}

impl Sentence for slipfit::resonance::Answer {
    fn sentence(&self) -> String {
        resonance::sentence(self)
    }
}

impl Sentence for slipfit::levels::Answer {
    fn sentence(&self) -> String {
        levels::sentence(self)
    }
}

impl Sentence for slipfit::series::Answer {
    fn sentence(&self) -> String {
        series::sentence(self)
    }
}

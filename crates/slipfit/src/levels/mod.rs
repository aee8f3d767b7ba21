//! Drive levels: amplitude at resonance versus drive. A straight line with a threshold, below which friction keeps the
//! mass at rest.

mod analyse;
mod answer;
mod bend;
mod branch;
mod breakaway;
mod criteria;
mod curve;
mod exact_motion;
mod height;
mod level_row;
mod line;
mod measurement;
mod noise;
mod plateau;
mod quantities;
mod sorted;

pub use analyse::{analyse, analyse_with};
pub use answer::{Answer, Breakaway, Diagnostics, FittedLevels, LevelPoint};
pub use criteria::{Criteria, LevelCriteria};
pub use height::peak_height;
pub use measurement::{Levels, LevelsBuilder, Options};

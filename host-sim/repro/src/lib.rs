//! What the papers claim, measured.

pub mod campaign;
pub mod drive_study;
mod oracle;
pub mod recovery;
pub mod ring_study;
mod statistics;
pub mod table2;

pub use oracle::Oracle;
pub use statistics::{Estimate, Waits, standard_deviation};

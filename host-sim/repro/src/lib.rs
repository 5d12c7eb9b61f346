//! The papers' claims, measured in the simulator.
//!
//! | module | measures |
//! |---|---|
//! | [`table2`] | \[001\] Table 2: every method's distance from the grid of perfect sensors, and the factors that decide it |
//! | [`recovery`] | \[001\] Fig. 7: a sensor's confidence in and after a fault |
//! | [`campaign`] | every method against every kind of fault, and the sensors' health |
//! | [`drive_study`] | \[004\]: drives to a goal with failing sensors |
//! | [`ring_study`] | \[003\]: how many faulty sonars the check finds, and how exact the polygon is |
//!
//! Each module returns numbers; the program `certainty` prints them and draws the charts. An [`Oracle`]
//! stands beside the methods where a limit is needed.

pub mod campaign;
pub mod drive_study;
mod oracle;
pub mod recovery;
pub mod ring_study;
mod statistics;
pub mod table2;

pub use oracle::Oracle;
pub use statistics::{Spread, Waits, mean, standard_deviation};

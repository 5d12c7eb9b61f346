//! x
#![no_std]
#![forbid(unsafe_code)]
pub mod certainty;
pub mod sensor;
pub mod transducer;
pub mod units;

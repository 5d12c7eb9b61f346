//! Runs with generated input through fusion and ring diagnosis, the same on every machine.
//!
//! | module | is |
//! |---|---|
//! | [`fusion_run`] | generated readings through the Smart Car's fusion level |
//! | [`ring_run`] | a generated room through the diagnosis of a sonar ring |
//!
//! The input is generated in integers, so each machine must compute the same digest. The image `bench` runs
//! both, and counts instructions of fusion, control and ring diagnosis on a Cortex-M3 under QEMU.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod fusion_run;
pub mod ring_run;

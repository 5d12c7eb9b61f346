//! Made-up runs through the firmware's real parts, to compare machines and count instructions.
//!
//! | module | is |
//! |---|---|
//! | [`rehearsal`] | made-up readings through the fusion level |
//! | [`ring_rehearsal`] | a made-up room through the diagnosis of a sonar ring |
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod rehearsal;
pub mod ring_rehearsal;

//! The certainty grid wired to range sensors through embedded-hal.
#![no_std]
#![forbid(unsafe_code)]

//! What the Smart Car's firmware runs on.

#[cfg(feature = "emulated-board")]
pub mod board;

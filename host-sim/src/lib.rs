//! Simulated and recorded range sensors for [`certainty_core`].
pub mod export;
pub mod fault;
pub mod quantity;
pub mod replay;
pub mod transducer;
pub mod world;

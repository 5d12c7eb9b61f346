//! A board's telemetry as a host hears it.
//!
//! [`Port`] is where the bytes come from, [`Port::listen`] reads them on a thread of its own, and a
//! [`Session`] keeps what they say: the map and whether it is whole, every sensor's last word, and
//! what was lost on the way. The frames themselves are
//! [`certainty_firmware::telemetry`]'s.

mod port;
mod session;

pub use port::{Arrival, Port, PortError};
pub use session::{SensorState, Session};

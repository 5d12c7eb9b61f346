//! Text that people bring: unpacked, split into lines, and tables with a header.
//!
//! Recordings, tables of measured points and rows of sonars all come in through `Text`: a file or
//! stdin, plain or packed ([`Packing`]), in UTF-8 or, with a byte order mark, UTF-16. `table` splits
//! lines into fields and reads headers. A file that is none of ours gets an [`InputError`] that says
//! what it looks like and how to bring it in.

mod foreign;
mod lines;
mod table;
mod text;
mod unpack;

pub use foreign::Foreign;
pub use text::InputError;
pub use unpack::Packing;

pub(crate) use lines::{BadLine, LONGEST_LINE};
pub(crate) use table::{Column, Fields, Separator, Unit, number};
pub(crate) use text::Text;
#[cfg(test)]
pub(crate) use unpack::gzip;

//! Pictures and maps out.

mod shown;

pub(crate) use shown::shown;

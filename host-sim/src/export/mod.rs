//! Pictures and maps out.

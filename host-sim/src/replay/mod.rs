//! Recordings in.

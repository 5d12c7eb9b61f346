//! What these tests share.

pub(crate) mod input;
pub(crate) mod map;
pub(crate) mod program;
pub(crate) mod recording;
pub(crate) mod shape;

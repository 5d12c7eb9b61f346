//! The program `certainty`.
fn main() {}

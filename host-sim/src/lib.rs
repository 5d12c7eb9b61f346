//! Simulated and recorded range sensors for [`certainty_core`], and what is learned from them.
//!
//! | module | is |
//! |---|---|
//! | [`world`] | obstacles, and how far it is to the nearest |
//! | [`transducer`] | simulated sensors, down to the byte of a GP2D02 |
//! | [`fault`] | faults that wrap any sensor |
//! | [`calibration`] | sensors' characteristics, from measured bytes, and what is left of their errors |
//! | [`replay`] | recordings of real robots |
//! | [`fusion`] | the core's grids at sizes chosen at run time |
//! | [`robot`] | a robot that drives by the core's control level, its sensors failing |
//! | [`experiment`] | the Smart Car in a world, scored against perfect sensors |
//! | [`export`] | pictures and maps for other programs |
//! | [`plot`] | charts as PNG and SVG |
//! | [`quantity`] | lengths, angles and times with their units |
//! | [`toml_file`] | files that people write, and complaints with their line |
//! | [`cli`] | the program `certainty` |

pub mod calibration;
pub mod cli;
pub mod experiment;
pub mod export;
pub mod fault;
pub mod fusion;
pub mod plot;
pub mod quantity;
pub mod replay;
pub mod robot;
pub mod toml_file;
pub mod transducer;
pub mod world;

//! Simulated and recorded range sensors for [`certainty_core`], and what is learned from them.
//!
//! | module | is |
//! |---|---|
//! | [`world`] | obstacles, and how far it is to the nearest |
//! | [`transducer`] | simulated sensors, down to the byte of a GP2D02 |
//! | [`bench`](mod@bench) | the same pin by pin, for the shipped drivers: GP2D02s, servos, rangers and what is wrong with their wires |
//! | [`fault`] | faults that wrap any sensor |
//! | [`backend`] | where the firmware's application runs: here, under QEMU, on an emulated board |
//! | [`calibration`] | sensors' characteristics, from measured bytes, and what is left of their errors |
//! | [`replay`] | recordings of real robots |
//! | [`fusion`] | the core's grids at sizes chosen at run time |
//! | [`ring`] | a sonar ring and laser scanners in a world: echoes, faults, and how well these are found |
//! | [`robot`] | a robot that drives by the core's control level, its sensors failing |
//! | [`experiment`] | the Smart Car in a world, scored against perfect sensors |
//! | [`monitor`] | a board's telemetry, heard live or from a file |
//! | [`export`] | pictures and maps for other programs |
//! | [`plot`] | charts as PNG and SVG |
//! | [`quantity`] | lengths, angles and times with their units |
//! | [`toml_file`] | files that people write, and complaints with their line |

pub mod backend;
pub mod bench;
pub mod calibration;
pub mod experiment;
pub mod export;
pub mod fault;
pub mod fusion;
pub mod monitor;
pub mod plot;
pub mod quantity;
pub mod replay;
pub mod ring;
pub mod robot;
pub mod toml_file;
pub mod transducer;
pub mod world;

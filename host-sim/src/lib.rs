//! Simulated and recorded range sensors for [`certainty_core`], and robots that use them.
//!
//! | module | is |
//! |---|---|
//! | [`world`] | obstacles, and the distance to the first along a ray |
//! | [`transducer`] | simulated sensors, down to the byte of a GP2D02 |
//! | [`bench`](mod@bench) | simulated devices pin by pin, for the shipped drivers: GP2D02s, servos, rangers, motors and faults of their wires |
//! | [`fault`] | faults that wrap any sensor |
//! | [`backend`] | runs of the firmware's application: in this process, under QEMU, on an emulated board |
//! | [`calibration`] | sensors' characteristics from measured bytes, and their remaining errors |
//! | [`replay`] | recordings of real robots |
//! | [`fusion`] | the core's grids at sizes chosen at run time |
//! | [`input`](mod@input) | text that people bring: unpacked, split into lines, tables with a header |
//! | [`ring`] | a sonar ring and laser scanners in a world: echoes and faults |
//! | [`robot`] | a robot that drives by the core's control level, with faulty sensors |
//! | [`simulation`] | the Smart Car in a world, scored against perfect sensors |
//! | [`monitor`] | reception of a board's telemetry, live or from a file |
//! | [`export`] | pictures and maps for other programs |
//! | [`plot`] | charts as PNG and SVG |
//! | [`random`] | independent streams of random numbers for sensors and faults |
//! | [`quantity`] | lengths, angles and times with their units |
//! | [`toml_file`] | TOML files, and errors with their line |

pub mod backend;
pub mod bench;
pub mod calibration;
pub mod export;
pub mod fault;
pub mod fusion;
pub mod input;
pub mod monitor;
pub mod plot;
pub mod quantity;
pub mod random;
pub mod replay;
pub mod ring;
pub mod robot;
pub mod simulation;
pub mod toml_file;
pub mod transducer;
pub mod world;

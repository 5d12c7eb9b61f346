//! Faults that wrap any sensor.

//! Obstacles.

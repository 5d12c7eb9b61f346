//! Images for the STM32F100RB; they are in `src/bin`.
#![no_std]

//! The binary from outside: command line, outputs, exit codes.

mod bench;
mod calibrate;
mod compare;
mod experiments;
mod gpu;
mod interruption;
mod render;
mod run;
mod usage;
mod verify;

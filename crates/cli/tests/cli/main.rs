//! The binary from outside: command line, outputs, exit codes, pages.

mod bench;
mod calibrate;
mod compare;
mod experiments;
// The template runs in a shell.
#[cfg(unix)]
mod farm;
mod gpu;
// Examples are lines for a shell.
#[cfg(unix)]
mod help;
mod hostile;
mod inspect;
mod interruption;
mod light;
mod metrics;
// The browser is talked to over descriptors that a shell hands on.
#[cfg(unix)]
mod page;
mod pieces;
mod render;
mod run;
mod seeds;
mod sequence;
mod usage;
mod verify;
// What stands in for ffmpeg is a script.
#[cfg(unix)]
mod video;

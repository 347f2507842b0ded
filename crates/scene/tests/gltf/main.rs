//! glTF files: what they mean, what is said about bad ones, and that no damage makes the loader panic.

mod assets;
mod builder;
mod faults;
mod features;
mod mutation;

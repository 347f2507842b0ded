//! Words every Sheer crate speaks: colour, hashes, threshold maps, blue noise.

pub mod colour;

//! Words every Sheer crate speaks: colour, hashes, threshold maps, masks, blue noise.

pub mod bibliography;
pub mod blue_noise;
pub mod caught_panic;
pub mod colour;
pub mod coverage;
pub mod hash;
pub mod mask;
pub mod parameter;
pub mod spatio_temporal;
#[cfg(test)]
mod spectrum;
pub mod suggestion;
pub mod text;
pub mod threshold_map;
mod void_and_cluster;

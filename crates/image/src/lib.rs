//! Images in memory and on disk: planes, EXR, PNG, the tone curve.
//!
//! This crate is the only one that reads and writes pixel files. In memory everything is linear light, top
//! row first; [`Tone`] is the one way from linear light to a display.

mod decode;
mod error;
mod exr_file;
mod merge;
mod metadata;
mod output;
mod panorama;
mod picture;
mod piece;
mod planes;
mod png_file;
mod raster;
mod region;
mod tone;
mod whole_file;

pub use decode::{TextureLimits, decode_texture, texture_size};
pub use error::ImageError;
pub use exr_file::{decode_exr, encode_exr, read_exr, write_exr};
pub use merge::{MergeError, Merged, check_frames, merge};
pub use metadata::Metadata;
pub use output::{FileFormat, check_place, check_writable, write_frame};
pub use panorama::{decode_panorama, read_panorama};
pub use picture::{Picture, decode_picture, read_picture};
pub use piece::{Piece, SampleRange};
pub use planes::{Band, Pixel, PixelLayers, Planes};
pub use png_file::{encode_png, read_png, write_png};
pub use raster::Image;
pub use region::Region;
pub use tone::{DisplayShare, Tone, ToneCurve, display, display_over_black, u8_from_unit, unit_from_u8};
pub use whole_file::{read_whole, temporary_beside, write_whole};

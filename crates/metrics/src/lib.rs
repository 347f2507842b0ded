//! Image in, number out: how far a picture is from its reference.
//!
//! Structural similarity, PSNR and FLIP compare what a display shows ([`sheer_image::display_over_black`]);
//! RMS and bias compare linear light; flicker takes either; tPSNR and ColorVideoVDP take displayed clips;
//! [`Ghosting`] takes linear light and where a clip was [uncovered](Uncovering); [`FragmentDifference`]
//! counts pixels. No function here knows which method made a picture, and none depends on the number of
//! threads: sums run row by row in a fixed order.

mod convolve;
mod difference;
mod error;
mod false_colour;
mod flicker;
mod flip;
mod fragments;
mod ghosting;
mod ssim;
pub mod statistics;
mod temporal_psnr;
mod video_vdp;

pub use convolve::gaussian_blur;
pub use difference::{bias, bias_per_channel, psnr_db, rms, rms_per_channel};
pub use error::MetricError;
pub use false_colour::{error_legend, error_map, false_colour};
pub use flicker::{Flicker, flicker};
pub use flip::{DEFAULT_PIXELS_PER_DEGREE, flip, flip_map};
pub use fragments::FragmentDifference;
pub use ghosting::{Ghosting, Uncovering};
pub use ssim::{ssim, ssim_map};
pub use temporal_psnr::TemporalPsnr;
pub use video_vdp::{LEAST_VDP_SIDE_PX, video_vdp_jod};

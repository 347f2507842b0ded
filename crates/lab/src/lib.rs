//! The laboratory: plays clips, compares methods, verifies what papers and methods promise, makes the papers'
//! experiments again, calibrates.
//!
//! Pictures from elsewhere are judged by the same figures ([`Judging`]).
//!
//! What is measured comes out as plain data: numbers, tables, plots, pictures. How they are written, and
//! which backend renders, is up to the program: everything here works on any
//! [`Backend`](sheer_render::Backend), but for the promises of [`verify`], which are the CPU's.
//!
//! ```
//! use sheer_lab::{Clip, Silent, with_reference};
//! use sheer_render::{Antialiasing, Settings, Stage, backend::Cpu};
//!
//! let scene = sheer_gallery::open("layers:count=2,alpha=0.5")?.scene;
//! let mut stage = Stage::new(scene, &Default::default(), None)?;
//! let clip = Clip {
//!     settings: Settings { size: [16, 9], ..Default::default() },
//!     antialiasing: Antialiasing::TAA,
//!     frame_count: 4,
//!     keeps_frames: false,
//! };
//! let methods = with_reference(vec!["list".parse()?])?;
//! let measured = clip.play(&Cpu, &mut stage, &methods, None, &Silent)?;
//! assert!(measured[1].rms < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod agreement;
pub mod calibrate;
mod clip;
mod comparison_row;
mod cost;
mod error;
pub mod experiments;
mod exposure;
mod figures;
mod file_name;
mod foreign;
mod measured;
mod pictures;
mod play;
pub mod plot;
mod progress;
mod quality;
mod reference;
mod seeded;
mod shown;
mod tally;
mod truth;
pub mod verify;

pub use crate::{
    clip::{Clip, with_reference},
    comparison_row::ComparisonRow,
    cost::measure_cost,
    error::{LabError, Result},
    exposure::Exposure,
    figures::{Column, Datum, Figures, Name, number},
    file_name::file_name_from,
    foreign::{Foreign, ForeignJudged},
    measured::{AgainstTruth, Measured, figures, selected_figures},
    pictures::{Judged, Judging, picture_figures},
    play::{Event, Timeline, picture, play},
    progress::{Progress, Silent},
    quality::ERROR_FULL_SCALE,
    reference::{REFERENCE, Reference},
    seeded::{Estimate, Seeded},
    tally::Tally,
    truth::Truth,
};

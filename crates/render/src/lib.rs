//! Order-independent transparency: the methods, the CPU backend, temporal accumulation.
//!
//! A [`Stage`] holds a scene at a time, ready to be traced; a [`Method`] says how transparency is resolved; a
//! [`Pipeline`] renders frame after frame with both and adds them up over time.
//!
//! ```
//! use sheer_render::{Antialiasing, Pipeline, Settings, Stage};
//!
//! let scene = sheer_gallery::open("layers:count=2,alpha=0.5")?.scene;
//! let mut stage = Stage::new(scene, &Default::default(), None)?;
//! let settings = Settings { size: [8, 4], ..Default::default() };
//! let mut pipeline = Pipeline::new("std".parse()?, Antialiasing::ACCUMULATE, settings)?;
//! for index in 0..9 {
//!     stage.advance(pipeline.clock().at(index));
//!     pipeline.render(&stage, index)?;
//! }
//! let planes = pipeline.planes();
//! assert_eq!(planes.colour.size(), (8, 4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod backend;
mod clock;
pub mod contract;
mod cost;
pub mod cpu;
mod error;
mod fragments;
mod light_buffers;
pub mod limits;
pub mod method;
mod pipeline;
mod settings;
pub mod shadow;
mod stage;
pub mod temporal;

pub use crate::{
    backend::Backend,
    clock::Clock,
    cost::{Counters, StepTime, Timings},
    error::RenderError,
    fragments::RayFragment,
    method::{Method, MethodError},
    pipeline::Pipeline,
    settings::{Background, FrameSettings, LayerSplit, Settings},
    shadow::Shadow,
    stage::{Moment, Stage, lift},
    temporal::Antialiasing,
};

/// The program in the README compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

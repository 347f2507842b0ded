//! The CPU backend: the default and the gold standard. Deterministic: the same bits for any number of
//! threads.

mod display_share;
mod draw;
mod glass;
mod layer_filter;
mod layered;
mod object_space;
mod ordered;
mod samples;
pub mod shade;
mod single_fragment;
mod tile;
mod tracer;
mod transparency;
mod unordered;
mod workspace;

pub use self::{
    display_share::{display_share, uniform_display_share},
    draw::Rendered,
    tracer::depth_range,
    transparency::{OwnOrdered, OwnSelection, OwnThreshold, OwnUnordered, Transparency, render},
};

//! Tests that look at several parts of the crate, at shaders through naga or at functions of shaders on a
//! device.

mod architecture;
mod atlas;
mod functions;
mod harness;
mod layout;
mod path;
mod shaders;
mod surface;
mod traversal;

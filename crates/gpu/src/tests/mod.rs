//! Tests that look at several parts of the crate, at shaders through naga or at functions of shaders on a device.

mod atlas;
mod functions;
mod harness;
mod layout;
mod shaders;
mod surface;
mod traversal;

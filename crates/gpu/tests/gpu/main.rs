//! The GPU backend from outside. One binary: what links the whole of the backend links it once, and the tests
//! run beside each other.

mod family;
mod glass;
mod own_device;
mod robustness;
mod shadow_maps;
mod stochastic;
mod twin;

//! The CPU backend from outside. One binary: what links the whole of it links it once, and the tests run
//! beside each other.

mod clip_planes;
mod crop;
mod display;
mod examples;
mod family;
mod fragments;
mod glass;
mod instances;
mod methods;
mod shadows;
mod stochastic;
mod thresholds;
mod units;

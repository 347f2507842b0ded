//! The built-in scenes, one file or folder a scene; the catalogue lists them.

pub(crate) mod arena;
pub(crate) mod calibration;
pub(crate) mod hairball;
pub(crate) mod layers;
pub(crate) mod motor;
pub(crate) mod pane;
pub(crate) mod plume;
pub(crate) mod smoke_square;
pub(crate) mod windy_hill;

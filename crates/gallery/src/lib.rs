//! Built-in scenes, made from seeded parts so that the same text gives the same bits everywhere.
//!
//! [`open`] takes what a user writes: a name with parameters, or the path of a file. [`catalogue`] lists what
//! there is, one row a scene.
//!
//! A scene is a file of `scene`, or a folder where it has parts of its own, and a row of the catalogue: its
//! description, its parameters and the function that builds it. What scenes share are kits: in `kit`,
//! `palette` holds the materials of the town, `house`, `leaf`, `foliage`, `furniture`, `square` and `smoke`
//! are what stands in it; `hair`, `body`, `girl`, `grass` and `wind` make what grows and sways, and
//! `mechanical` what is turned, milled and bent. Below both, `builder` puts parts together, `shape` models,
//! `paint` makes textures, `rng` draws random numbers.

mod builder;
mod catalogue;
mod error;
mod kit;
mod open;
mod paint;
mod rng;
mod scene;
mod seed;
mod shape;

pub use crate::{
    catalogue::{BuiltinInfo, build, catalogue},
    error::GalleryError,
    open::{open, open_with},
    scene::layers::{LayerColours, glass_layers_closed_form, layers_closed_form},
};

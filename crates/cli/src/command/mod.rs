//! The verbs, one file each.

pub(crate) mod methods;
pub(crate) mod render;
pub(crate) mod scenes;

//! Tests of the records and the atlas, and of a scene on a device.

mod arrangement;
mod layout;
mod probe;

use sheer_render::Method;

use crate::{bvh, shader::Linker, tables::Tables};

/// A piece with all that it imports; rays are traced through our own tree.
fn join(piece: &str) -> String {
    let method: Method = "std".parse().unwrap();
    Linker::new()
        .method(&method)
        .constants(Tables::new(false, [0, 0]).constants())
        .constants(bvh::constants())
        .alias("shadow", "shared/shadow_deep")
        .alias("traverse", "shared/traverse_bvh")
        .link(piece)
        .unwrap()
}

//! Both sides lay the records out alike, and every piece compiles.

use std::mem::offset_of;

use naga::{
    Module, TypeInner,
    valid::{Capabilities, ValidationFlags, Validator},
};

use super::harness::link;
use crate::scene::records::{Light, Lobe, Material, MeshOffsets, Object, Opacity, Texture, TextureUse};

fn module(piece: &str) -> Module {
    let text = link(piece);
    let module =
        naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    module
}

/// Panics unless a struct of a module has that size and its members have these names and offsets.
fn check(module: &Module, name: &str, size: usize, offsets: &[(&str, usize)]) {
    let (_, found) = module.types.iter().find(|(_, found)| found.name.as_deref() == Some(name)).unwrap();
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
    let members: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
    assert_eq!(members, offsets, "members of {name}");
    assert_eq!(*span as usize, size, "size of {name}");
}

macro_rules! check_record {
    ($module:expr, $record:ident { $($field:ident),+ $(,)? }) => {
        check(
            $module,
            stringify!($record),
            size_of::<$record>(),
            &[$((stringify!($field), offset_of!($record, $field))),+],
        );
    };
}

#[test]
fn records_lie_in_memory_as_the_shaders_read_them() {
    let module = &module("shared/shade");
    check_record!(
        module,
        MeshOffsets {
            first_index,
            vertex_count,
            positions,
            normals,
            tangents,
            colours,
            uv_sets,
            uv_set_count
        }
    );
    check_record!(
        module,
        Object { id, geometry, material, first_triangle, look, first_deformed_normal, mesh, axes }
    );
    check(
        module,
        "Opacity",
        size_of::<Opacity>(),
        &[
            ("uv", offset_of!(Opacity, uv)),
            ("alpha", offset_of!(Opacity, alpha)),
            ("texture", offset_of!(Opacity, texture)),
            ("cutoff", offset_of!(Opacity, cutoff)),
            ("opacity", offset_of!(Opacity, opacity)),
        ],
    );
    check_record!(module, TextureUse { x_axis, y_axis, translation, texture, uv_set });
    check_record!(
        module,
        Material {
            base_colour,
            model,
            emissive,
            metallic,
            roughness,
            transmission,
            normal_scale,
            occlusion_strength,
            textures,
        }
    );
    check_record!(module, Texture { origin, size, wrap, layer, filtering, srgb });
    check_record!(module, Light { position, kind, direction, range, intensity, inner_cosine, outer_cosine });
    check_record!(module, Lobe { direction, sharpness, radiance });
}

#[test]
#[should_panic(expected = "members of Light")]
fn a_record_with_two_members_swapped_is_noticed() {
    check_record!(
        &module("shared/shade"),
        Light { position, kind, direction, range, intensity, outer_cosine, inner_cosine }
    );
}

#[test]
#[should_panic(expected = "size of Lobe")]
fn a_record_that_is_too_short_is_noticed() {
    check(
        &module("shared/shade"),
        "Lobe",
        28,
        &[
            ("direction", offset_of!(Lobe, direction)),
            ("sharpness", offset_of!(Lobe, sharpness)),
            ("radiance", offset_of!(Lobe, radiance)),
        ],
    );
}

#[test]
fn every_piece_of_the_scene_compiles_alone() {
    for piece in [
        "shared/environment",
        "shared/receiver",
        "shared/scene",
        "shared/shade",
        "shared/shadow_deep",
        "shared/surface",
        "shared/texture",
        "shared/vector",
        "probe/surface",
    ] {
        module(piece);
    }
}

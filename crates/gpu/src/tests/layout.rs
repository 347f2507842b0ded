//! Shaders lay out every struct that Rust shares with them as Rust does, and every piece of a scene compiles.

use naga::{Module, TypeInner};

use super::{
    harness::{link, link_with_glass},
    shaders::{validate, validated},
};
use crate::shader::{
    Linker,
    declaration::{Declaration, ShaderType},
    record::{self, scene::Light},
};

/// Panics unless a struct of a module has the size that Rust gives it, and members of the same names at the
/// same offsets.
fn check(module: &Module, expected: &Declaration) {
    let Declaration { name, size, members, .. } = expected;
    let (_, found) = module.types.iter().find(|(_, found)| found.name.as_deref() == Some(*name)).unwrap();
    let TypeInner::Struct { members: found, span } = &found.inner else { panic!("{name} is no struct") };
    let found: Vec<_> = found.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
    let members: Vec<_> = members.iter().map(|member| (member.name, member.offset)).collect();
    assert_eq!(found, members, "members of {name}");
    assert_eq!(*span as usize, *size, "size of {name}");
}

/// What naga makes of a struct's declaration alone.
fn module_of(declaration: &Declaration) -> Module {
    let linked = Linker::new().link(&format!("struct/{}", declaration.name)).unwrap();
    validated(&linked).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn structs_lie_in_memory_as_shaders_read_them() {
    for declaration in record::all() {
        check(&module_of(&declaration), &declaration);
    }
}

#[test]
#[should_panic(expected = "members of Light")]
fn a_struct_with_two_members_swapped_is_noticed() {
    let mut light = Light::declaration().unwrap();
    let module = module_of(&light);
    light.members.swap(0, 2);
    check(&module, &light);
}

#[test]
#[should_panic(expected = "size of Light")]
fn a_struct_that_is_too_short_is_noticed() {
    let mut light = Light::declaration().unwrap();
    let module = module_of(&light);
    light.size -= 4;
    check(&module, &light);
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
        for linked in [link(piece), link_with_glass(piece)] {
            validate(&linked).unwrap_or_else(|error| panic!("{piece}: {error}"));
        }
    }
}

//! Scenes of one mesh, as the formats of scanners and printers hold them.

use glam::{Quat, Vec3, Vec4};
use sheer_scene::{
    Scene, SceneError,
    model::{AlphaMode, Instance, Material, Mesh, Node, SceneParts, Transform},
};

/// Linear grey of what has no colour.
pub(super) const GREY: Vec4 = Vec4::new(0.5, 0.5, 0.5, 1.0);

/// A scene of one mesh of a program's own, shown as the same mesh in a file would be: without lights, in the
/// neutral surroundings of files, seen from both sides, blended where the base colour or a vertex is not
/// opaque. `base_colour`: linear, straight, multiplied with the colours of the vertices.
///
/// # Errors
/// [`SceneError::Invalid`] says what is wrong with the mesh.
pub fn scene_of_mesh(name: &str, mesh: Mesh, base_colour: Vec4) -> Result<Scene, SceneError> {
    let mut parts = SceneParts { name: name.to_owned(), exposure: 1.0, ..SceneParts::default() };
    place(&mut parts, mesh, base_colour, Transform::IDENTITY);
    Scene::new(parts)
}

/// Puts one mesh into a scene, with a material that takes its alpha from `base_colour` and the vertices.
pub(super) fn place(parts: &mut SceneParts, mesh: Mesh, base_colour: Vec4, transform: Transform) {
    let is_transparent = base_colour.w < 1.0 || mesh.colours.iter().any(|colour| colour.w < 1.0);
    let alpha_mode = if is_transparent { AlphaMode::Blend } else { AlphaMode::Opaque };
    let material =
        Material { base_colour, alpha_mode, roughness: 0.6, double_sided: true, ..Material::default() };
    place_with(parts, mesh, material, transform);
}

/// The same with any material.
pub(super) fn place_with(parts: &mut SceneParts, mesh: Mesh, material: Material, transform: Transform) {
    parts.materials.push(material);
    parts.nodes.push(Node { transform, ..Node::default() });
    parts.meshes.push(mesh);
    parts.instances.push(Instance::default());
}

/// From a world with +Z up, seen from -Y, to one with +Y up, seen from +Z.
pub(super) fn from_z_up() -> Transform {
    let rotation = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    Transform::Trs { translation: Vec3::ZERO, rotation, scale: Vec3::ONE }
}

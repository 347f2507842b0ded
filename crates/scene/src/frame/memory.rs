//! What frames of a scene will hold, and take in memory with the acceleration structure over them.

use super::{
    instances::Sharing,
    pose::{instance_moves, moving_nodes},
    property::Changing,
};
use crate::{
    cost::{Drawn, light_buffer_bytes, of_object},
    model::{AlphaMode, LightKind, SceneParts},
};

/// The size of frames that share triangles as they do by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameSize {
    /// Triangles with a number: those of all instances.
    pub triangles: u64,
    /// Triangles that are stored.
    pub stored_triangles: u64,
    /// What all takes.
    pub bytes: u64,
}

impl FrameSize {
    /// The size of frames of these parts.
    #[must_use]
    pub fn of(parts: &SceneParts) -> Self {
        let (node_moves, changing) = (moving_nodes(parts), Changing::of(parts));
        let is_shared = Sharing::default().choose(parts, |index| changing.has(parts, index));
        let mut are_stored = vec![false; parts.meshes.len()];
        let mut size = Self::default();
        let mut moving_triangles = 0_u64;
        for (index, instance) in (0..).zip(&parts.instances) {
            let mesh = &parts.meshes[instance.mesh as usize];
            let is_opaque = parts.materials[mesh.material as usize].alpha_mode == AlphaMode::Opaque;
            let triangles = mesh.indices.len() as u64;
            let shares = is_shared[index as usize];
            // The first that shares them brings them.
            let is_known = shares && std::mem::replace(&mut are_stored[instance.mesh as usize], true);
            let moves = instance_moves(parts, &node_moves, index) || changing.has(parts, index);
            let drawn = Drawn { moves: moves && !shares, is_opaque };
            moving_triangles = moving_triangles.saturating_add(if drawn.moves { triangles } else { 0 });
            size.add(triangles, if is_known { 0 } else { triangles }, drawn);
        }
        // Quads, each of which is an object.
        for _ in parts.particles.iter().flat_map(|system| &system.particles) {
            moving_triangles = moving_triangles.saturating_add(2);
            size.add(2, 2, Drawn { moves: true, is_opaque: false });
        }
        if parts.lights.iter().any(|light| light.kind == LightKind::Directional) {
            size.bytes = size.bytes.saturating_add(light_buffer_bytes(moving_triangles));
        }
        size
    }

    /// Adds an object of so many triangles, of which so many are stored.
    fn add(&mut self, triangles: u64, stored: u64, drawn: Drawn) {
        self.triangles = self.triangles.saturating_add(triangles);
        self.stored_triangles = self.stored_triangles.saturating_add(stored);
        self.bytes = self.bytes.saturating_add(of_object(stored, drawn));
    }
}

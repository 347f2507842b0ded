//! Instances that share the triangles of their mesh, beside the same with triangles of their own.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use glam::{Affine2, Affine3A, Mat3, Quat, Vec2, Vec3, Vec4};
use sheer_image::Image;
use sheer_scene::{
    Animator, Beam, CameraChoice, Frame, Scene, Sharing,
    model::{
        AlphaMode, Animation, Channel, Filter, Instance, Interpolation, Keys, Material, Mesh, Minification,
        MorphTarget, Node, SceneParts, Texture, TextureRef, Track, Transform, Wrap,
    },
    particle::{Particle, ParticleSystem, Turbulence},
};

const SHARED: Sharing = Sharing { least_saved: 1, flattened: false };
const COPIED: Sharing = Sharing { least_saved: 1, flattened: true };

/// A bumpy sheet with all that a mesh can have but a skin.
fn sheet(material: u32, cells: u32) -> Mesh {
    let side = cells + 1;
    let at = |index: u32| Vec2::new((index % side) as f32, (index / side) as f32) / cells as f32;
    let points: Vec<Vec2> = (0..side * side).map(at).collect();
    let square = |cell: u32| {
        let a = cell / cells * side + cell % cells;
        [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
    };
    Mesh {
        name: format!("sheet of {}", cells * cells * 2),
        material,
        positions: points.iter().map(|p| Vec3::new(p.x, 0.2 * (7.0 * p.x * p.y).sin(), p.y)).collect(),
        normals: points.iter().map(|p| Vec3::new(0.3 * p.x, 1.0, -0.2 * p.y).normalize()).collect(),
        tangents: points.iter().map(|p| Vec3::new(1.0, 0.1 * p.y, 0.0).normalize().extend(1.0)).collect(),
        uv_sets: vec![points.clone(), points.iter().map(|p| *p * Vec2::new(3.0, 0.5)).collect()],
        colours: points.iter().map(|p| Vec4::new(p.x, 1.0, p.y, 0.4 + 0.5 * p.x)).collect(),
        indices: (0..cells * cells).flat_map(square).collect(),
        ..Mesh::default()
    }
}

fn texture() -> Texture {
    let texel = |x: u32, y: u32| [(x * 30) as u8, 200, (y * 25) as u8, (x * y * 4 + 20) as u8];
    Texture {
        name: String::new(),
        image: Arc::new(Image::from_fn(8, 8, texel).unwrap()),
        srgb: true,
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Linear,
        minification: Minification::default(),
    }
}

/// Sheets of four materials, each at seven places of which two move, one of them morphed; a mesh too small to
/// share, a mesh that is there once, and particles.
fn scene() -> Arc<Scene> {
    let used = Some(TextureRef {
        uv_set: 1,
        transform: Affine2::from_scale_angle_translation(Vec2::new(2.0, 1.0), 0.4, Vec2::X),
        ..TextureRef::new(0)
    });
    let material = |alpha_mode, double_sided| Material {
        alpha_mode,
        double_sided,
        base_colour: Vec4::new(0.9, 0.8, 0.7, 0.6),
        base_colour_texture: used,
        normal_texture: used,
        ..Material::default()
    };
    let materials = vec![
        Material::default(),
        material(AlphaMode::Blend, true),
        Material { transmission: 0.5, ..material(AlphaMode::Blend, false) },
        material(AlphaMode::Mask { cutoff: 0.3 }, false),
    ];
    let mut meshes: Vec<Mesh> = (0..4).map(|material| sheet(material, 3 + material)).collect();
    meshes.push(sheet(1, 2));
    meshes.push(sheet(2, 4));
    let morph = MorphTarget { positions: vec![Vec3::Y; 36], ..MorphTarget::default() };
    meshes.push(Mesh { morph_targets: vec![morph], ..sheet(3, 5) });

    let mut parts =
        SceneParts { name: "sheets".into(), materials, meshes, exposure: 1.0, ..SceneParts::default() };
    parts.textures.push(texture());
    let mut channels = Vec::new();
    for place in 0..7_u32 {
        let turn = place as f32;
        let scale = [Vec3::ONE, Vec3::new(-1.0, 0.5, 2.0), Vec3::new(0.3, 0.0, 0.3)][place as usize % 3];
        let transform = Transform::Trs {
            translation: Vec3::new(1.7 * turn - 4.0, 0.3 * turn, -0.5 * turn),
            rotation: Quat::from_rotation_y(turn) * Quat::from_rotation_x(0.5 * turn),
            scale,
        };
        parts.nodes.push(Node { name: String::new(), parent: None, transform });
        if place >= 5 {
            let times_secs = vec![0.0, 1.0];
            let values = vec![Vec3::new(turn, 0.0, 0.0), Vec3::new(turn, 1.0, -2.0)];
            let keys = Keys { times_secs: times_secs.clone(), values, interpolation: Interpolation::Linear };
            channels.push(Channel { node: place, track: Track::Translation(keys) });
            // Through a mirror, which changes the side that is the front.
            let values = vec![Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0)];
            let keys = Keys { times_secs, values, interpolation: Interpolation::Linear };
            channels.push(Channel { node: place, track: Track::Scale(keys) });
        }
        let meshes = 0..if place == 0 { 7 } else { 5 };
        for mesh in meshes {
            parts.instances.push(Instance {
                node: place,
                node_from_object: Affine3A::from_translation(Vec3::Z * mesh as f32),
                mesh,
                id: place,
                geometry: mesh,
                skin: None,
                morph_weights: vec![0.5; parts.meshes[mesh as usize].morph_targets.len()],
            });
        }
    }
    parts.animations.push(Animation { channels, ..Animation::default() });
    parts.particles.push(particles());
    Arc::new(Scene::new(parts).unwrap())
}

fn particles() -> ParticleSystem {
    let particle = |index: u32| Particle {
        birth_secs: 0.0,
        lifetime_secs: 10.0,
        origin: Vec3::new(index as f32, 2.0, 0.0),
        velocity: Vec3::Y,
        acceleration: Vec3::ZERO,
        half_size: [0.2; 2],
        rotation_rad: 0.0,
        spin_rad_per_sec: 1.0,
        alpha: 0.5,
        tint: Vec3::ONE,
        tile: 0,
    };
    ParticleSystem {
        name: String::new(),
        material: 1,
        atlas: [1, 1],
        particles: (0..3).map(particle).collect(),
        loop_secs: None,
        turbulence: Turbulence::default(),
        fade: [0.0; 2],
        near_fade: [0.0; 2],
    }
}

fn animator(scene: &Arc<Scene>, sharing: Sharing) -> Animator {
    let camera = scene.camera(&CameraChoice::Default).unwrap();
    Animator::with_sharing(Arc::clone(scene), camera, sharing)
}

/// All that a frame says of a point of a triangle, as text: floats with all of their digits.
fn described(frame: &Frame, triangle: u32, [u, v]: [f32; 2]) -> String {
    let object = frame.object(triangle);
    let beams = [0.0, 0.3].map(|width| Beam { direction: Vec3::new(0.6, -0.8, 0.0), width });
    let alpha = beams.map(|beam| frame.opacity(triangle, u, v, beam.width));
    let per_side = [true, false].map(|ccw| {
        let seen = beams.map(|beam| frame.opacity_for_camera(triangle, u, v, ccw, beam.width));
        let surfaces = beams.map(|beam| frame.surface(triangle, u, v, ccw, beam));
        (seen, frame.side(triangle, ccw), surfaces)
    });
    let light = [true, false]
        .map(|ccw| beams.map(|beam| frame.light_through(triangle, u, v, ccw, alpha[1], beam.width)));
    format!(
        "{:?}",
        (
            (object.id, object.geometry, object.material, object.first_triangle),
            (frame.primitive(triangle), frame.corners(triangle), frame.corners_in_object(triangle)),
            (frame.is_opaque(triangle), alpha, per_side, light, frame.positions(triangle, u, v)),
        )
    )
}

#[test]
fn triangles_that_are_not_stored_are_what_they_would_be() {
    let scene = scene();
    let (mut shared, mut copied) = (animator(&scene, SHARED), animator(&scene, COPIED));
    let mut still = Vec::new();
    for [time_secs, previous_secs] in [[0.0, 0.0], [0.25, 0.0], [0.75, 0.25], [0.75, 0.75]] {
        let (shared, copied) =
            (shared.advance(time_secs, previous_secs), copied.advance(time_secs, previous_secs));
        assert_eq!(shared.triangle_count(), copied.triangles().len());
        assert_eq!(copied.triangle_count(), copied.triangles().len());
        assert_eq!((shared.instances().len(), shared.static_counts().instances), (28, 20));
        // Four sheets at seven places: 18, 32, 50 and 72 triangles.
        assert_eq!(shared.triangle_count() - shared.triangles().len(), 7 * (18 + 32 + 50 + 72));
        for triangle in 0..shared.triangle_count() as u32 {
            for point in [[0.2, 0.3], [0.0, 1.0]] {
                assert_eq!(described(shared, triangle, point), described(copied, triangle, point));
            }
        }
        for axes in [Mat3::IDENTITY, Mat3::from_rotation_x(0.7)] {
            assert_eq!(shared.bounds_in(axes), copied.bounds_in(axes));
        }
        // What moves, and particles.
        assert_eq!(shared.is_still(), copied.is_still());
        still.push(shared.is_still());
    }
    assert_eq!(still, [true, false, false, true]);
}

#[test]
fn an_instance_that_moves_is_not_still() {
    let mut parts = scene().parts().clone();
    parts.particles.clear();
    let scene = Arc::new(Scene::new(parts).unwrap());
    let mut animator = animator(&scene, SHARED);
    assert!(!animator.advance(0.5, 0.25).is_still());
    assert!(animator.advance(0.5, 0.5).is_still());
    // A whole turn of the clip later it is where it was.
    assert!(animator.advance(1.25, 0.25).is_still());
}

#[test]
fn meshes_are_shared_where_it_saves_what_is_asked() {
    let scene = scene();
    // Six copies of each sheet.
    let saved = 6 * (18 + 32 + 50 + 72);
    for (least_saved, count) in [(saved, 28), (saved + 1, 0), (Sharing::default().least_saved, 0)] {
        let animator = animator(&scene, Sharing { least_saved, ..Sharing::default() });
        assert_eq!(animator.frame().instances().len(), count, "{least_saved}");
    }
}

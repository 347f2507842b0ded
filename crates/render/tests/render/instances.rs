//! Scenes whose instances share the triangles of their mesh look as if they did not.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{Affine3A, Quat, Vec3, Vec4};
use sheer_image::Planes;
use sheer_render::{
    Antialiasing, Method, Pipeline, Settings, Shadow, Stage, method::METHODS, shadow::SHADOWS,
};
use sheer_scene::{
    CameraChoice, Scene, Sharing,
    model::{
        AlphaMode, Animation, Channel, Instance, Interpolation, Keys, Light, LightKind, Material, Mesh, Node,
        SceneParts, Track, Transform,
    },
};

const SIZE: [u32; 2] = [64, 48];

/// A ball of 8 × 6 × 2 triangles with an alpha that differs from vertex to vertex.
fn ball(material: u32) -> Mesh {
    let (steps, rings) = (8, 6);
    let points = (0..=rings).flat_map(|ring| {
        (0..steps).map(move |step| {
            let (polar, turn) =
                (3.1 * ring as f32 / rings as f32 + 0.02, std::f32::consts::FRAC_PI_4 * step as f32);
            Vec3::new(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin())
        })
    });
    let positions: Vec<Vec3> = points.collect();
    let square = |cell: u32| {
        let (ring, step) = (cell / steps, cell % steps);
        let at = |ring: u32, step: u32| ring * steps + step % steps;
        let [a, b, c, d] = [at(ring, step), at(ring, step + 1), at(ring + 1, step + 1), at(ring + 1, step)];
        [[a, b, c], [a, c, d]]
    };
    Mesh {
        material,
        colours: positions.iter().map(|p| Vec4::new(0.6, 0.8, 0.9, 0.5 + 0.4 * p.y)).collect(),
        normals: positions.clone(),
        indices: (0..steps * rings).flat_map(square).collect(),
        positions,
        ..Mesh::default()
    }
}

/// Balls of three materials, turned, squeezed and mirrored, of which one moves through the others.
fn balls() -> Scene {
    let material = |alpha_mode, double_sided| Material { alpha_mode, double_sided, ..Material::default() };
    let mut parts = SceneParts {
        name: "balls".into(),
        materials: vec![
            material(AlphaMode::Opaque, false),
            material(AlphaMode::Blend, true),
            Material { transmission: 0.4, ..material(AlphaMode::Blend, false) },
        ],
        meshes: (0..3).map(ball).collect(),
        exposure: 1.0,
        ..SceneParts::default()
    };
    for index in 0..24_u32 {
        let turn = 0.7 * index as f32;
        let transform = Transform::Trs {
            translation: Vec3::new(3.0 * turn.sin(), 0.25 * index as f32 - 3.0, 2.0 * (1.9 * turn).cos()),
            rotation: Quat::from_rotation_z(turn),
            scale: Vec3::new(if index % 2 == 0 { 0.8 } else { -0.6 }, 0.7, 0.3 + 0.03 * index as f32),
        };
        parts.nodes.push(Node { name: String::new(), parent: None, transform });
        parts.instances.push(Instance {
            node: index,
            node_from_object: Affine3A::IDENTITY,
            mesh: index % 3,
            id: index,
            geometry: 0,
            skin: None,
            morph_weights: Vec::new(),
        });
    }
    let keys = Keys {
        times_secs: vec![0.0, 1.0],
        values: vec![Vec3::new(-3.0, 0.0, 0.0), Vec3::new(3.0, 1.0, 0.0)],
        interpolation: Interpolation::Linear,
    };
    let channels = vec![Channel { node: 7, track: Track::Translation(keys) }];
    parts.animations.push(Animation { channels, ..Animation::default() });
    let rotation = Quat::from_rotation_x(-1.0);
    let transform = Transform::Trs { translation: Vec3::ZERO, rotation, scale: Vec3::ONE };
    parts.nodes.push(Node { name: String::new(), parent: None, transform });
    parts.lights.push(Light {
        name: String::new(),
        node: 24,
        intensity: Vec3::splat(3.0),
        kind: LightKind::Directional,
    });
    Scene::new(parts).unwrap()
}

/// Two stages of a scene: its instances share triangles, or have their own.
fn stages(scene: &Scene) -> [Stage; 2] {
    [false, true].map(|flattened| {
        let sharing = Sharing { least_saved: 1, flattened };
        let stage = Stage::with_sharing(scene.clone(), &CameraChoice::Default, Some(2), sharing).unwrap();
        assert_eq!(stage.frame().instances().is_empty(), flattened);
        assert_eq!(stage.frame().triangles().is_empty(), !flattened);
        stage
    })
}

fn play(stage: &mut Stage, method: &Method, settings: Settings) -> Planes {
    let mut pipeline = Pipeline::new(method.clone(), Antialiasing::TAA, settings).unwrap();
    for index in 0..3 {
        stage.advance(pipeline.clock().at(index));
        pipeline.render(stage, index).unwrap();
    }
    pipeline.planes().clone()
}

#[test]
fn every_method_and_every_shadow_map_shows_shared_triangles_as_if_they_were_copied() {
    let scene = balls();
    let [mut shared, mut copied] = stages(&scene);
    // Maps keep what they find in the order of depth and triangle; rays multiply as they go, so that their
    // rounding has the order of the tree.
    let maps: Vec<&str> = SHADOWS.iter().map(|info| info.id).filter(|id| *id != "deep").collect();
    for (index, info) in METHODS.iter().enumerate() {
        let shadow: Shadow = format!("{}:resolution=128", maps[index % maps.len()]).parse().unwrap();
        let settings = Settings { size: SIZE, shadow, ..Settings::default() };
        let method = info.id.parse().unwrap();
        let [shared, copied] = [play(&mut shared, &method, settings), play(&mut copied, &method, settings)];
        assert!(shared == copied, "{} under {shadow}", info.id);
    }
}

#[test]
fn shadow_rays_pass_shared_triangles_as_if_they_were_copied() {
    let scene = balls();
    let method = "baseline".parse().unwrap();
    let settings = Settings { size: SIZE, ..Settings::default() };
    let [shared, copied] = stages(&scene).map(|mut stage| play(&mut stage, &method, settings));
    let pairs = shared.colour.as_slice().iter().flatten().zip(copied.colour.as_slice().iter().flatten());
    let most = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // Some dozens of factors in another order, each of a rounding.
    assert!(most < 1e-5, "{most}");
}

#[test]
fn the_comparison_notices_a_ball_that_is_elsewhere() {
    let scene = balls();
    let mut parts = scene.parts().clone();
    parts.instances[4].node_from_object = Affine3A::from_translation(Vec3::X * 0.01);
    let moved = Scene::new(parts).unwrap();
    let method = "baseline".parse().unwrap();
    let settings = Settings { size: SIZE, ..Settings::default() };
    let [mut shared, _] = stages(&scene);
    let [mut elsewhere, _] = stages(&moved);
    assert!(play(&mut shared, &method, settings) != play(&mut elsewhere, &method, settings));
}

//! A camera's near and far plane cut the view, and nothing else.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{Affine3A, Vec3, Vec4};
use sheer_render::{Antialiasing, Background, Pipeline, Settings, Stage};
use sheer_scene::{
    Camera, CameraChoice, ClipPlanes, Lens, Scene, SceneParts,
    camera::{CameraKey, CameraMotion},
    model::{AlphaMode, Instance, Material, Mesh, Node, ShadingModel, Transform},
};

/// Depths of three panes in front of a camera, each of an opacity of its own, wider than its view.
const DEPTHS: [f32; 3] = [1.0, 2.0, 3.0];
const ALPHAS: [f32; 3] = [0.5, 0.25, 0.125];

fn panes(lens: Lens, clip: ClipPlanes) -> Scene {
    let mut parts = SceneParts { exposure: 1.0, ..SceneParts::default() };
    parts.nodes = vec![Node { name: String::new(), parent: None, transform: Transform::IDENTITY }];
    for (index, (depth, alpha)) in DEPTHS.into_iter().zip(ALPHAS).enumerate() {
        parts.materials.push(Material {
            base_colour: Vec4::new(1.0, 1.0, 1.0, alpha),
            alpha_mode: AlphaMode::Blend,
            model: ShadingModel::Unlit,
            double_sided: true,
            ..Material::default()
        });
        let corner = |x: f32, y: f32| Vec3::new(x, y, -depth);
        parts.meshes.push(Mesh {
            material: index as u32,
            positions: vec![corner(-99.0, -99.0), corner(99.0, -99.0), corner(0.0, 99.0)],
            indices: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        parts.instances.push(Instance {
            node: 0,
            node_from_object: Affine3A::IDENTITY,
            mesh: index as u32,
            id: index as u32,
            geometry: 0,
            skin: None,
            morph_weights: Vec::new(),
        });
    }
    let key = CameraKey { time_secs: 0.0, eye: Vec3::ZERO, target: Vec3::NEG_Z };
    parts.cameras = vec![Camera {
        name: "static".to_owned(),
        lens,
        clip,
        motion: CameraMotion::Path { keys: vec![key] },
    }];
    Scene::new(parts).unwrap()
}

/// The least and the greatest opacity of a picture; its rays run up to 60° beside the axis.
fn opacities(method: &str, lens: Lens, clip: ClipPlanes) -> [f32; 2] {
    let mut stage = Stage::new(panes(lens, clip), &CameraChoice::Default, Some(1)).unwrap();
    let settings = Settings { size: [24, 16], background: Background::None, ..Settings::default() };
    let mut pipeline = Pipeline::new(method.parse().unwrap(), Antialiasing::NONE, settings).unwrap();
    stage.advance(pipeline.clock().at(0));
    pipeline.render(&stage, 0).unwrap();
    let alphas = || pipeline.planes().colour.as_slice().iter().map(|colour| colour[3]);
    [alphas().fold(f32::INFINITY, f32::min), alphas().fold(0.0, f32::max)]
}

#[test]
fn panes_beyond_the_planes_are_not_seen_whatever_the_angle() {
    let lenses = [Lens::Perspective { yfov_rad: 1.9 }, Lens::Orthographic { half_height: 2.0 }];
    for lens in lenses {
        for method in ["baseline", "list", "peel"] {
            for (near, far, seen) in [
                (0.0, f32::INFINITY, 0..3),
                (0.99, 3.01, 0..3),
                (1.01, f32::INFINITY, 1..3),
                (0.0, 2.99, 0..2),
                (1.5, 2.5, 1..2),
                (2.1, 2.2, 0..0),
            ] {
                let through: f32 = ALPHAS[seen.clone()].iter().map(|alpha| 1.0 - alpha).product();
                let found = opacities(method, lens, ClipPlanes { near, far });
                let holds = found.iter().all(|alpha| (alpha - (1.0 - through)).abs() < 1e-5);
                assert!(
                    holds,
                    "{method}, {lens:?}, {near} to {far}: {found:?}, {seen:?} of the panes wanted"
                );
            }
        }
    }
}

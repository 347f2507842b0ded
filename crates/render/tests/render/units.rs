//! The unit of a scene, and where it lies, change nothing in its picture.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{Affine3A, EulerRot, Quat, Vec3, Vec4};
use sheer_render::{Antialiasing, Pipeline, Settings, Stage};
use sheer_scene::{
    CameraChoice, Scene,
    model::{AlphaMode, Instance, Light, LightKind, Material, Mesh, Node, SceneParts, Transform},
};

const SIZE: [u32; 2] = [96, 96];
/// Rows and columns of the finely divided ball.
const DIVISIONS: u32 = 24;

/// A ball of many triangles over a floor, half transparent, in the sun; lengths times `unit`.
fn scene(unit: f32) -> Scene {
    let (columns, rows) = (2 * DIVISIONS, DIVISIONS);
    let point = |column: u32, row: u32| {
        let (turn, lift) = (
            column as f32 / columns as f32 * std::f32::consts::TAU,
            row as f32 / rows as f32 * std::f32::consts::PI,
        );
        Vec3::new(turn.sin() * lift.sin(), 1.2 + lift.cos(), turn.cos() * lift.sin()) * unit
    };
    let ball = Mesh {
        positions: (0..=rows).flat_map(|row| (0..columns).map(move |column| point(column, row))).collect(),
        indices: (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (row, column)))
            .flat_map(|(row, column)| {
                let at = |row: u32, column: u32| row * columns + column % columns;
                let [a, b] = [at(row, column), at(row, column + 1)];
                let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
                [[a, c, b], [b, c, d]]
            })
            .collect(),
        ..Mesh::default()
    };
    let floor = Mesh {
        positions: [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]
            .map(|(x, z)| Vec3::new(x, 0.0, z) * unit)
            .into(),
        indices: vec![[0, 2, 1], [0, 3, 2]],
        material: 1,
        ..Mesh::default()
    };
    let instance = |mesh: u32| Instance {
        node: 0,
        node_from_object: Affine3A::IDENTITY,
        mesh,
        id: mesh,
        geometry: 0,
        skin: None,
        morph_weights: Vec::new(),
    };
    let down = Quat::from_euler(EulerRot::XYZ, -1.0, 0.5, 0.0);
    let sun = Transform::Trs { translation: Vec3::ZERO, rotation: down, scale: Vec3::ONE };
    let node = |transform: Transform| Node { name: String::new(), parent: None, transform };
    let glass = Material {
        alpha_mode: AlphaMode::Blend,
        base_colour: Vec4::new(0.9, 0.3, 0.1, 0.6),
        ..Material::default()
    };
    Scene::new(SceneParts {
        name: "unit".to_owned(),
        nodes: vec![node(Transform::IDENTITY), node(sun)],
        meshes: vec![ball, floor],
        instances: vec![instance(0), instance(1)],
        materials: vec![glass, Material { double_sided: true, ..Material::default() }],
        lights: vec![Light {
            name: String::new(),
            node: 1,
            intensity: Vec3::splat(3.0),
            kind: LightKind::Directional,
        }],
        exposure: 1.0,
        ..SceneParts::default()
    })
    .unwrap()
}

fn picture(unit: f32, shadow: &str) -> Vec<f32> {
    let scene = scene(unit).framed_for(SIZE);
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    let settings = Settings { size: SIZE, shadow: shadow.parse().unwrap(), ..Settings::default() };
    let mut pipeline = Pipeline::new("baseline".parse().unwrap(), Antialiasing::NONE, settings).unwrap();
    stage.advance(pipeline.clock().at(0));
    pipeline.render(&stage, 0).unwrap();
    pipeline.planes().colour.as_slice().as_flattened().to_vec()
}

/// Share of values that differ by more than a hundredth.
fn differing(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).filter(|(a, b)| (*a - *b).abs().is_nan() || (*a - *b).abs() >= 0.01).count() as f64
        / a.len() as f64
}

#[test]
fn a_scene_looks_the_same_in_every_unit() {
    for shadow in ["deep", "deep-map:resolution=128"] {
        let metres = picture(1.0, shadow);
        let lit = metres.iter().filter(|value| **value > 0.05).count();
        assert!(lit > metres.len() / 2, "{lit} values of {}", metres.len());
        for unit in [1e-9, 1e-5, 1e4, 1e9] {
            // Rounding at the edges of triangles, of their shadows, and of texels of a map on another grid.
            let share = differing(&picture(unit, shadow), &metres);
            assert!(share < 0.03, "{shadow}, a unit of {unit}: {share}");
        }
        // Another scene differs.
        assert!(differing(&picture(1.0, "deep"), &vec![0.0; metres.len()]) > 0.5);
    }
}

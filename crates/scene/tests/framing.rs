//! The view that is made up where a scene has no camera.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use glam::{Vec2, Vec3};
use sheer_scene::{
    Animator, CameraChoice, CameraPose, Scene,
    model::{
        Animation, Channel, Instance, Interpolation, Keys, Material, Mesh, Node, Property, SceneParts, Track,
        Transform,
    },
    particle::{Particle, ParticleSystem, Turbulence},
};

/// Landscape, the default, square, portrait, and strips.
const SIZES: [[u32; 2]; 6] = [[1200, 500], [960, 540], [300, 300], [540, 960], [2000, 40], [40, 2000]];
/// What is left free at each side, as a share of the picture; the view fills 88 % of it.
const MARGIN: f32 = 0.055;

/// A box with corners on all sides, one triangle a face.
fn box_of(low: Vec3, high: Vec3) -> Mesh {
    let corner =
        |index: usize| Vec3::from_array(std::array::from_fn(|axis| [low, high][index >> axis & 1][axis]));
    Mesh {
        positions: (0..8).map(corner).collect(),
        indices: vec![[0, 1, 2], [4, 5, 6], [0, 1, 4], [2, 3, 6], [0, 2, 4], [1, 3, 7]],
        ..Mesh::default()
    }
}

fn scene_of(mesh: Mesh, transform: Transform, animations: Vec<Animation>) -> Scene {
    let parts = SceneParts {
        name: "test".to_owned(),
        nodes: vec![Node { transform, ..Node::default() }],
        instances: vec![Instance::default()],
        meshes: vec![mesh],
        materials: vec![Material::default()],
        animations,
        exposure: 1.0,
        ..SceneParts::default()
    };
    Scene::new(parts).unwrap()
}

/// Where points lie in a picture, as shares of its width and height: lowest and highest.
fn extent_in(pose: &CameraPose, points: impl Iterator<Item = Vec3>, size: [u32; 2]) -> [Vec2; 2] {
    let size = Vec2::new(size[0] as f32, size[1] as f32);
    points.fold([Vec2::INFINITY, Vec2::NEG_INFINITY], |[low, high], point| {
        let at = pose.project(point, size).unwrap() / size;
        [low.min(at), high.max(at)]
    })
}

/// The picture holds all of a scene at the given times, and as much of it as fits.
fn check_framed(scene: &Scene, times_secs: &[f32], size: [u32; 2], what: &str) {
    let scene = Arc::new(scene.clone().framed_for(size));
    let camera = scene.camera(&CameraChoice::Default).unwrap();
    let mut animator = Animator::new(Arc::clone(&scene), camera);
    let mut whole = [Vec2::INFINITY, Vec2::NEG_INFINITY];
    for &time_secs in times_secs {
        let frame = animator.advance(time_secs, time_secs);
        let [low, high] = extent_in(frame.camera(), frame.triangles().iter().flatten().copied(), size);
        whole = [whole[0].min(low), whole[1].max(high)];
    }
    let [low, high] = whole;
    assert!(low.min_element() >= MARGIN && high.max_element() <= 1.0 - MARGIN, "{what}: {low} to {high}");
    // The side that decides is filled.
    let filled = (high - low).max_element();
    assert!(filled > 0.87, "{what}: fills {filled}");
}

#[test]
fn a_model_fits_into_pictures_of_every_shape() {
    for (name, high) in [
        ("a cube", Vec3::ONE),
        ("a tower", Vec3::new(1.0, 9.0, 1.0)),
        ("a board", Vec3::new(4.0, 2.0, 0.1)),
        ("a floor", Vec3::new(5.0, 0.1, 5.0)),
        ("a needle", Vec3::new(0.01, 0.01, 7.0)),
    ] {
        let scene = scene_of(box_of(Vec3::ZERO, high), Transform::IDENTITY, Vec::new());
        for size in SIZES {
            check_framed(&scene, &[0.0], size, &format!("{name} in {size:?}"));
        }
    }
}

#[test]
fn what_is_never_shown_takes_no_place_and_what_is_shown_once_has_it() {
    let far = Transform::from_translation(Vec3::X * 40.0);
    let shown = |keys: &[(f32, f32)]| {
        let mut parts =
            scene_of(box_of(Vec3::ZERO, Vec3::ONE), Transform::IDENTITY, Vec::new()).parts().clone();
        parts.nodes.push(Node { transform: far, ..Node::default() });
        parts.instances.push(Instance { node: 1, id: 1, ..Instance::default() });
        let visible = Keys {
            times_secs: keys.iter().map(|(time, _)| *time).collect(),
            values: keys.iter().map(|(_, value)| *value).collect(),
            interpolation: Interpolation::Step,
        };
        let properties = vec![Property::Visibility { node: 1, visible }];
        parts.animations = vec![Animation { properties, ..Animation::default() }];
        Scene::new(parts).unwrap()
    };
    let size = [960, 540];
    check_framed(&shown(&[(0.0, 0.0)]), &[0.0], size, "hidden for ever");
    check_framed(
        &shown(&[(0.0, 0.0), (1.0, 1.0), (1.001, 0.0), (9.0, 0.0)]),
        &[0.0, 1.0],
        size,
        "shown once",
    );
}

#[test]
fn a_view_framed_for_another_shape_does_not_fit() {
    let scene = scene_of(box_of(Vec3::ZERO, Vec3::ONE), Transform::IDENTITY, Vec::new());
    let pose =
        scene.framed_for([960, 540]).camera(&CameraChoice::Default).unwrap().pose_on_rails(0.0).unwrap();
    let corners = box_of(Vec3::ZERO, Vec3::ONE).positions;
    let [low, _] = extent_in(&pose, corners.into_iter(), [540, 960]);
    assert!(low.x < 0.0, "{low}");
}

#[test]
fn the_unit_of_a_model_does_not_matter() {
    for unit in [1e-9_f32, 1e-6, 1e-3, 1e3, 1e6, 1e9] {
        let mesh = box_of(Vec3::new(-1.0, 0.0, -2.0) * unit, Vec3::ONE * unit);
        let scene = scene_of(mesh, Transform::IDENTITY, Vec::new());
        for size in SIZES {
            check_framed(&scene, &[0.0], size, &format!("a unit of {unit} in {size:?}"));
        }
        // The same look from where it stands still.
        let [walking, standing] = [CameraChoice::Default, CameraChoice::Named("static".to_owned())]
            .map(|choice| scene.camera(&choice).unwrap().pose_on_rails(0.0).unwrap());
        assert_eq!(walking, standing);
    }
}

#[test]
fn a_model_far_from_the_origin_is_framed_as_well_as_its_coordinates_allow() {
    let offset = Vec3::new(4.0e5, -2.0e5, 6.0e6);
    let mesh = box_of(offset, offset + Vec3::splat(100.0));
    let scene = scene_of(mesh.clone(), Transform::IDENTITY, Vec::new());
    for size in SIZES {
        let pose = scene
            .clone()
            .framed_for(size)
            .camera(&CameraChoice::Default)
            .unwrap()
            .pose_on_rails(0.0)
            .unwrap();
        let [low, high] = extent_in(&pose, mesh.positions.iter().copied(), size);
        assert!(low.min_element() > 0.03 && high.max_element() < 0.97, "{size:?}: {low} to {high}");
    }
}

#[test]
fn the_whole_clip_is_framed() {
    let keys = Keys {
        times_secs: vec![0.0, 1.0, 2.0],
        values: vec![Vec3::ZERO, Vec3::new(20.0, 0.0, 0.0), Vec3::new(0.0, 9.0, 0.0)],
        interpolation: Interpolation::Linear,
    };
    let animation = Animation {
        channels: vec![Channel { node: 0, track: Track::Translation(keys) }],
        ..Animation::default()
    };
    let moving = scene_of(box_of(Vec3::ZERO, Vec3::ONE), Transform::IDENTITY, vec![animation]);
    let times_secs: Vec<f32> = (0..200).map(|step| step as f32 * 0.01).collect();
    for size in SIZES {
        check_framed(&moving, &times_secs, size, &format!("a clip in {size:?}"));
    }
}

#[test]
fn particles_are_framed_with_their_size() {
    let particle = Particle {
        birth_secs: 0.0,
        lifetime_secs: f32::INFINITY,
        origin: Vec3::ZERO,
        velocity: Vec3::ZERO,
        acceleration: Vec3::ZERO,
        half_size: [2.0; 2],
        rotation_rad: 0.7,
        spin_rad_per_sec: 0.0,
        alpha: 1.0,
        tint: Vec3::ONE,
        tile: 0,
    };
    let parts = SceneParts {
        materials: vec![Material::default()],
        particles: vec![ParticleSystem {
            name: String::new(),
            material: 0,
            atlas: [1, 1],
            particles: vec![particle, Particle { origin: Vec3::X * 8.0, ..particle }],
            loop_secs: None,
            turbulence: Turbulence::default(),
            fade: [0.0; 2],
            near_fade: [0.0; 2],
        }],
        exposure: 1.0,
        ..SceneParts::default()
    };
    let scene = Scene::new(parts).unwrap();
    for size in SIZES {
        let scene = Arc::new(scene.clone().framed_for(size));
        let camera = scene.camera(&CameraChoice::Default).unwrap();
        let animator = Animator::new(scene, camera);
        let frame = animator.frame();
        let [low, high] = extent_in(frame.camera(), frame.triangles().iter().flatten().copied(), size);
        assert!(low.min_element() > MARGIN && high.max_element() < 1.0 - MARGIN, "{size:?}: {low} to {high}");
    }
}

#[test]
fn a_point_a_line_along_the_view_and_nothing_are_looked_at_all_the_same() {
    let along = Vec3::new(0.55, 0.42, 1.0);
    for positions in [vec![Vec3::splat(3.0); 3], vec![Vec3::ZERO, along, 2.0 * along], Vec::new()] {
        let indices = if positions.is_empty() { Vec::new() } else { vec![[0, 1, 2]] };
        let mesh = Mesh { positions: positions.clone(), indices, ..Mesh::default() };
        let scene = scene_of(mesh, Transform::IDENTITY, Vec::new());
        let pose = scene.camera(&CameraChoice::Default).unwrap().pose_on_rails(0.0).unwrap();
        assert!(pose.world_from_camera.is_finite());
        for point in positions {
            let at = pose.project(point, Vec2::ONE).unwrap();
            assert!((at - 0.5).abs().max_element() < 0.45, "{point} is at {at}");
        }
    }
}

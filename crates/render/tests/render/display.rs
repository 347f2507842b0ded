//! How much of a picture is display-referred.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{Affine3A, Vec3, Vec4};
use sheer_image::{DisplayShare, Image};
use sheer_render::{Antialiasing, Background, Settings, Stage, cpu::display_share};
use sheer_scene::{
    CameraChoice, Scene,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    model::{AlphaMode, Instance, Material, Mesh, Node, SceneParts, ShadingModel, Transform},
};

const SIZE: [u32; 2] = [32, 16];
/// Pixels to a scene unit: the picture is 2 units high.
const SCALE: f32 = 8.0;

/// Upright rectangles of height 1 before a camera at +Z: left and right edge, depth, model and opacity of
/// each.
fn stage(cards: &[(f32, f32, f32, ShadingModel, f32)]) -> Stage {
    clipped(cards, ClipPlanes::NONE)
}

fn clipped(cards: &[(f32, f32, f32, ShadingModel, f32)], clip: ClipPlanes) -> Stage {
    let mut parts = SceneParts { name: "cards".into(), exposure: 1.0, ..SceneParts::default() };
    parts.nodes.push(Node { name: String::new(), parent: None, transform: Transform::IDENTITY });
    for (index, &(left, right, z, model, alpha)) in (0..).zip(cards) {
        parts.materials.push(Material {
            model,
            base_colour: Vec4::new(1.0, 1.0, 1.0, alpha),
            alpha_mode: if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque },
            double_sided: true,
            ..Material::default()
        });
        let corners = [(left, -0.5), (right, -0.5), (right, 0.5), (left, 0.5)];
        parts.meshes.push(Mesh {
            positions: corners.map(|(x, y)| Vec3::new(x, y, z)).into(),
            indices: vec![[0, 1, 2], [0, 2, 3]],
            material: index,
            ..Mesh::default()
        });
        parts.instances.push(Instance {
            node: 0,
            node_from_object: Affine3A::IDENTITY,
            mesh: index,
            id: index,
            geometry: 0,
            skin: None,
            morph_weights: Vec::new(),
        });
    }
    let key = CameraKey { time_secs: 0.0, eye: Vec3::Z * 4.0, target: Vec3::ZERO };
    parts.cameras.push(Camera {
        name: "front".into(),
        lens: Lens::Orthographic { half_height: 1.0 },
        clip,
        motion: CameraMotion::Path { keys: vec![key] },
    });
    Stage::new(Scene::new(parts).unwrap(), &CameraChoice::Default, Some(1)).unwrap()
}

fn share(stage: &Stage, background: Background, antialiasing: Antialiasing) -> DisplayShare {
    let settings = Settings { size: SIZE, background, ..Settings::default() };
    display_share(stage, &settings, antialiasing).unwrap()
}

fn shares(stage: &Stage, background: Background, antialiasing: Antialiasing) -> Image<f32> {
    match share(stage, background, antialiasing) {
        DisplayShare::PerPixel(shares) => shares,
        uniform => panic!("the scene mixes both kinds of light, and the share is {uniform:?}"),
    }
}

/// The pixel at a point of the plane of the cards.
fn pixel(x: f32) -> (u32, u32) {
    ((16.0 + x * SCALE) as u32, 8)
}

const LIT: ShadingModel = ShadingModel::MetallicRoughness;
const UNLIT: ShadingModel = ShadingModel::Unlit;
const WHITE: Background = Background::Colour(Vec3::ONE);

#[test]
fn light_of_one_kind_takes_no_ray() {
    let lit = stage(&[(-0.5, 0.5, 0.0, LIT, 1.0)]);
    let unlit = stage(&[(-0.5, 0.5, 0.0, UNLIT, 1.0)]);
    let luminous = stage(&[(-0.5, 0.5, 0.0, ShadingModel::Luminous, 1.0)]);
    for background in [Background::Environment, Background::None] {
        assert_eq!(share(&lit, background, Antialiasing::NONE), DisplayShare::Nothing);
        assert_eq!(share(&luminous, background, Antialiasing::NONE), DisplayShare::Nothing);
    }
    for background in [WHITE, Background::None] {
        assert_eq!(share(&unlit, background, Antialiasing::TAA), DisplayShare::Everything);
    }
}

#[test]
fn a_share_is_what_is_seen_of_each_kind() {
    // From left to right: an unlit card, one half unlit before lit, one of a quarter lit before nothing.
    let stage = stage(&[
        (-1.5, -0.75, 0.0, UNLIT, 1.0),
        (-0.5, 0.25, 0.0, UNLIT, 0.5),
        (-0.5, 0.25, -1.0, LIT, 1.0),
        (0.5, 1.25, 0.0, LIT, 0.25),
    ]);
    for antialiasing in [Antialiasing::NONE, Antialiasing::TAA] {
        let cards = |background| {
            let shares = shares(&stage, background, antialiasing);
            [-1.1, -0.1, 0.9, 1.8].map(|x| shares[pixel(x)])
        };
        assert_eq!(cards(WHITE), [1.0, 0.5, 0.75, 1.0]);
        assert_eq!(cards(Background::Environment), [1.0, 0.5, 0.0, 0.0]);
        // Of what there is, not of the pixel.
        assert_eq!(cards(Background::None), [1.0, 0.5, 0.0, 0.0]);
    }
}

#[test]
fn edges_have_the_share_of_their_area() {
    // The card ends three quarters into a pixel, beyond its centre.
    let edge = 0.5 + 0.75 / SCALE;
    let stage = stage(&[(-1.0, edge, 0.0, LIT, 1.0)]);
    let at_edge = pixel(edge - 0.01);
    assert_eq!(shares(&stage, WHITE, Antialiasing::ACCUMULATE)[at_edge], 0.25);
    // Without anti-aliasing there is one sample, as in the picture.
    assert_eq!(shares(&stage, WHITE, Antialiasing::NONE)[at_edge], 0.0);
}

#[test]
fn what_the_clipping_planes_cut_off_has_no_share() {
    // The camera stands at 4: a lit card at 1, an unlit one at 0, a lit one at -2.
    let cards = [(-1.0, 1.0, 1.0, LIT, 0.5), (-1.0, 1.0, 0.0, UNLIT, 0.5), (-1.0, 1.0, -2.0, LIT, 1.0)];
    let share = |clip| shares(&clipped(&cards, clip), Background::None, Antialiasing::NONE)[pixel(0.0)];
    assert_eq!(share(ClipPlanes::NONE), 0.25);
    assert_eq!(share(ClipPlanes { near: 3.5, far: f32::INFINITY }), 0.5);
    assert_eq!(share(ClipPlanes { near: 3.5, far: 5.0 }), 1.0);
}

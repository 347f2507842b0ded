//! What an animator makes of a scene and a time.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use sheer_image::Image;
use sheer_scene::{
    Animator, Beam, Camera, CameraChoice, FaceSide, Frame, Scene,
    camera::{CameraKey, CameraMotion},
    model::{
        AlphaMode, Animation, Channel, Factor, Influence, Instance, Interpolation, Keys, Light, LightKind,
        Material, Mesh, MorphTarget, Node, Property, SceneParts, Skin, Texture, TextureRef, TextureSlot,
        Track, Transform, Wrap,
    },
    particle::{Particle, ParticleSystem, Turbulence},
};

/// It sees the texels of textures themselves.
const BEAM: Beam = Beam { direction: Vec3::NEG_Z, width: 0.0 };

/// A quad in the xy plane, two triangles, facing +Z.
fn quad() -> Mesh {
    Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(x, y, 0.0))
            .into(),
        uv_sets: vec![vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO]],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn parts_with(mesh: Mesh, material: Material, transform: Transform) -> SceneParts {
    SceneParts {
        name: "test".to_owned(),
        nodes: vec![Node { name: String::new(), parent: None, transform }],
        instances: vec![Instance {
            node: 0,
            node_from_object: Affine3A::IDENTITY,
            mesh: 0,
            id: 7,
            geometry: 0,
            skin: None,
            morph_weights: vec![0.0; mesh.morph_targets.len()],
        }],
        meshes: vec![mesh],
        materials: vec![material],
        exposure: 1.0,
        ..SceneParts::default()
    }
}

fn animator(parts: SceneParts) -> Animator {
    let scene = Arc::new(Scene::new(parts).unwrap());
    let camera = scene.camera(&CameraChoice::Default).unwrap();
    Animator::new(scene, camera)
}

fn sliding(keys: [Vec3; 2]) -> Vec<Animation> {
    let keys = Keys { times_secs: vec![0.0, 1.0], values: keys.into(), interpolation: Interpolation::Linear };
    vec![Animation {
        name: String::new(),
        channels: vec![Channel { node: 0, track: Track::Translation(keys) }],
        properties: Vec::new(),
    }]
}

#[test]
fn what_never_moves_comes_first_and_stays() {
    let mut parts = parts_with(quad(), Material::default(), Transform::IDENTITY);
    let mut still = parts.instances[0].clone();
    still.id = 8;
    still.node = 1;
    parts.nodes.push(Node { name: String::new(), parent: None, transform: Transform::IDENTITY });
    parts.instances.push(still);
    parts.animations = sliding([Vec3::ZERO, Vec3::X]);
    let mut animator = animator(parts);
    let frame = animator.advance(0.5, 0.25);
    assert_eq!((frame.static_count(), frame.triangles().len()), (2, 4));
    assert_eq!((frame.object(0).id, frame.object(2).id), (8, 7));
    assert_eq!(frame.triangles()[2][0], Vec3::new(-0.5, -1.0, 0.0));
}

#[test]
fn surfaces_know_where_they_were() {
    let mut parts = parts_with(quad(), Material::default(), Transform::IDENTITY);
    parts.animations = sliding([Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0)]);
    let mut animator = animator(parts);
    let surface = animator.advance(0.5, 0.25).surface(0, 0.2, 0.3, true, BEAM);
    assert!((surface.position - surface.previous_position - Vec3::new(0.5, 0.0, 0.0)).length() < 1e-6);
    let surface = animator.advance(0.5, 0.5).surface(0, 0.2, 0.3, true, BEAM);
    assert_eq!(surface.position, surface.previous_position);
}

#[test]
fn a_mirrored_instance_shows_its_front_where_it_was_mirrored_to() {
    let mirror = Transform::Trs {
        translation: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        scale: Vec3::new(-1.0, 1.0, 1.0),
    };
    let frame = animator(parts_with(quad(), Material::default(), mirror));
    let frame = frame.frame();
    // Seen from +Z the mirrored triangle runs clockwise, and is still the front.
    assert_eq!(frame.side(0, false), FaceSide::Front);
    assert_eq!(frame.opacity_for_camera(0, 0.3, 0.3, false, 0.0), 1.0);
    assert_eq!(frame.opacity_for_camera(0, 0.3, 0.3, true, 0.0), 0.0, "single-sided");
    assert_eq!(frame.opacity(0, 0.3, 0.3, 0.0), 1.0, "light is stopped by either side");
    let surface = frame.surface(0, 0.3, 0.3, false, BEAM);
    assert!((surface.normal - Vec3::Z).length() < 1e-6, "{surface:?}");
}

#[test]
fn alpha_modes_mean_what_they_say() {
    let image =
        Arc::new(Image::from_fn(2, 1, |x, _| [255, 255, 255, if x == 0 { 51 } else { 204 }]).unwrap());
    let texture = Texture {
        name: String::new(),
        image,
        srgb: true,
        wrap: [Wrap::ClampToEdge; 2],
        filter: sheer_scene::model::Filter::Nearest,
        minification: sheer_scene::model::Minification::default(),
    };
    let opacities = |alpha_mode, whole: Option<f32>| {
        let material = Material {
            alpha_mode,
            base_colour: Vec4::new(1.0, 1.0, 1.0, 0.5),
            base_colour_texture: Some(TextureRef::new(0)),
            ..Material::default()
        };
        let mut parts = parts_with(quad(), material, Transform::IDENTITY);
        parts.textures = vec![texture.clone()];
        let scene = Scene::new(parts).unwrap();
        let scene = Arc::new(whole.map_or(scene.clone(), |alpha| scene.with_alpha(alpha)));
        let camera = scene.camera(&CameraChoice::Default).unwrap();
        let animator = Animator::new(scene, camera);
        // The second triangle's corners lie at u = 0, 1, 0: near the first and near the second.
        [animator.frame().opacity(1, 0.05, 0.05, 0.0), animator.frame().opacity(1, 0.9, 0.05, 0.0)]
    };
    let close = |found: [f32; 2], expected: [f32; 2]| {
        assert!((found[0] - expected[0]).abs() < 1e-6 && (found[1] - expected[1]).abs() < 1e-6, "{found:?}");
    };
    close(opacities(AlphaMode::Opaque, None), [1.0, 1.0]);
    close(opacities(AlphaMode::Blend, None), [0.1, 0.4]);
    close(opacities(AlphaMode::Mask { cutoff: 0.3 }, None), [0.0, 1.0]);
    close(opacities(AlphaMode::Opaque, Some(0.3)), [0.3, 0.3]);
    close(opacities(AlphaMode::Blend, Some(0.5)), [0.1, 0.4]);
    close(opacities(AlphaMode::Mask { cutoff: 0.3 }, Some(0.25)), [0.0, 0.25]);
}

#[test]
fn skins_and_morphs_bend_positions_and_normals() {
    let mut mesh = quad();
    mesh.normals = vec![Vec3::Z; 4];
    mesh.influences_per_vertex = 4;
    let bound = Influence { joint: 0, weight: 1.0 };
    mesh.influences = [bound, Influence::default(), Influence::default(), Influence::default()].repeat(4);
    mesh.morph_targets = vec![MorphTarget { positions: vec![Vec3::Z; 4], ..MorphTarget::default() }];
    let mut parts = parts_with(mesh, Material::default(), Transform::from_translation(Vec3::splat(100.0)));
    let quarter = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    parts.nodes.push(Node {
        name: "joint".to_owned(),
        parent: None,
        transform: Transform::Trs { translation: Vec3::Y, rotation: quarter, scale: Vec3::ONE },
    });
    parts.skins = vec![Skin { name: String::new(), joints: vec![1], inverse_bind: vec![Affine3A::IDENTITY] }];
    parts.instances[0].skin = Some(0);
    parts.instances[0].morph_weights = vec![0.5];
    let animator = animator(parts);
    let surface = animator.frame().surface(0, 0.0, 0.0, true, BEAM);
    // Morphed to z = 0.5, then turned so that z becomes x, then lifted; the node's own place does not count.
    assert!((surface.position - Vec3::new(0.5, 0.0, 1.0)).length() < 1e-5, "{:?}", surface.position);
    assert!((surface.normal - Vec3::X).length() < 1e-5, "{:?}", surface.normal);
}

fn linear<T>(from: T, to: T) -> Keys<T> {
    Keys { times_secs: vec![0.0, 1.0], values: vec![from, to], interpolation: Interpolation::Linear }
}

/// A scene with an animation of a property, and of nothing else.
fn with_property(material: Material, property: Property) -> SceneParts {
    let mut parts = parts_with(quad(), material, Transform::IDENTITY);
    parts.animations =
        vec![Animation { name: String::new(), channels: Vec::new(), properties: vec![property] }];
    parts
}

#[test]
fn an_animated_opacity_is_that_of_its_moment() {
    let material = Material { alpha_mode: AlphaMode::Blend, ..Material::default() };
    let factor = linear(Vec4::ONE, Vec4::new(1.0, 0.0, 0.0, 0.0));
    let parts = with_property(material, Property::BaseColour { material: 0, factor: factor.clone() });
    let mut animator = animator(parts.clone());
    for (time_secs, alpha) in [(0.0, 1.0), (0.25, 0.75), (0.75, 0.25), (1.25, 0.75)] {
        let frame = animator.advance(time_secs, 0.0);
        assert!((frame.opacity(0, 0.2, 0.2, 0.0) - alpha).abs() < 1e-6, "{time_secs}");
        let green = frame.surface(0, 0.2, 0.2, true, BEAM).base_colour.y;
        assert!((green - alpha).abs() < 1e-6, "{time_secs}: {green}");
        assert_eq!(frame.is_still(), time_secs == 0.0);
        assert!(frame.animates_materials());
    }
    // The opacity that a user asks for is the whole of it; the colour still changes.
    let scene = Arc::new(Scene::new(parts).unwrap().with_alpha(0.5));
    let camera = scene.camera(&CameraChoice::Default).unwrap();
    let mut animator = Animator::new(scene, camera);
    let frame = animator.advance(0.75, 0.0);
    assert_eq!(frame.opacity(0, 0.2, 0.2, 0.0), 0.5);
    assert!((frame.surface(0, 0.2, 0.2, true, BEAM).base_colour.y - 0.25).abs() < 1e-6);
    // What is opaque is not made anew for its colour.
    let parts = with_property(Material::default(), Property::BaseColour { material: 0, factor });
    let opaque = self::animator(parts);
    assert_eq!(opaque.frame().static_count(), 2);
}

#[test]
fn animated_numbers_of_a_material_are_those_of_the_moment() {
    let masked = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        base_colour: Vec4::new(1.0, 1.0, 1.0, 0.5),
        ..Material::default()
    };
    let value = linear(0.0, 1.0);
    let property = Property::Factor { material: 0, which: Factor::AlphaCutoff, value: value.clone() };
    let mut animator = animator(with_property(masked.clone(), property));
    assert_eq!(animator.advance(0.4, 0.4).opacity(0, 0.2, 0.2, 0.0), 1.0);
    assert_eq!(animator.advance(0.6, 0.6).opacity(0, 0.2, 0.2, 0.0), 0.0);

    let property =
        Property::Emissive { material: 0, factor: Keys::constant(Vec3::X), strength: linear(0.0, 8.0) };
    let mut animator = self::animator(with_property(masked.clone(), property));
    assert_eq!(animator.advance(0.5, 0.5).surface(0, 0.2, 0.2, true, BEAM).emissive, Vec3::X * 4.0);

    let property = Property::Factor { material: 0, which: Factor::Roughness, value };
    let mut animator = self::animator(with_property(masked, property));
    let frame = animator.advance(0.25, 0.5);
    assert_eq!(frame.surface(0, 0.2, 0.2, true, BEAM).roughness, 0.25);
    assert!(!frame.is_still() && frame.static_count() == 2);
}

#[test]
fn a_texture_is_laid_out_as_at_the_moment_for_colour_and_opacity() {
    let texels = [[255, 0, 0, 255], [0, 0, 255, 51]];
    let texture = Texture {
        name: String::new(),
        image: Arc::new(Image::from_vec(2, 1, texels.to_vec()).unwrap()),
        srgb: true,
        wrap: [Wrap::Repeat; 2],
        filter: sheer_scene::model::Filter::Nearest,
        minification: sheer_scene::model::Minification::default(),
    };
    let material = Material {
        alpha_mode: AlphaMode::Blend,
        base_colour_texture: Some(TextureRef::new(0)),
        ..Material::default()
    };
    let property = Property::TextureTransform {
        material: 0,
        slot: TextureSlot::BaseColour,
        offset: linear(Vec2::ZERO, Vec2::X),
        rotation_rad: Keys::constant(0.0),
        scale: Keys::constant(Vec2::ONE),
    };
    let parts = SceneParts { textures: vec![texture], ..with_property(material, property) };
    let mut animator = animator(parts);
    // u is 0.25 where u and v are, and 0.75 half a picture later.
    let mut seen = |time_secs| {
        let frame = animator.advance(time_secs, 0.0);
        let at = (0.05, 0.2);
        (frame.surface(0, at.0, at.1, true, BEAM).base_colour, frame.opacity(0, at.0, at.1, 0.0))
    };
    for (time_secs, colour, alpha) in [(0.0, Vec3::X, 1.0), (0.5, Vec3::Z, 0.2)] {
        let (found, opacity) = seen(time_secs);
        assert!(found.abs_diff_eq(colour, 1e-5) && (opacity - alpha).abs() < 1e-5, "{found} {opacity}");
    }
}

#[test]
fn a_hidden_node_is_not_there_and_nor_is_what_hangs_on_it() {
    let property = Property::Visibility { node: 0, visible: linear(0.0, 1.0) };
    let mut parts = with_property(Material::default(), property);
    parts.nodes.push(Node { name: String::new(), parent: Some(0), transform: Transform::IDENTITY });
    parts.instances[0].node = 1;
    let kind = LightKind::Directional;
    parts.lights = vec![Light { name: String::new(), node: 1, intensity: Vec3::ONE, kind }];
    let mut animator = animator(parts);
    let mut shown = |time_secs, previous_secs| {
        let frame = animator.advance(time_secs, previous_secs);
        (
            frame.triangles().len(),
            frame.previous_moving().len(),
            frame.lights()[0].intensity.x,
            frame.is_still(),
        )
    };
    assert_eq!(shown(0.25, 0.0), (0, 0, 0.0, true));
    assert_eq!(shown(0.75, 0.25), (2, 2, 1.0, false));
    assert_eq!(shown(0.25, 0.75), (0, 0, 0.0, false));
}

#[test]
fn an_animated_light_shines_as_at_the_moment() {
    let property = Property::LightIntensity {
        lights: vec![0],
        colour: linear(Vec3::X, Vec3::Y),
        intensity: Keys::constant(4.0),
    };
    let mut parts = with_property(Material::default(), property);
    let kind = LightKind::Directional;
    parts.lights = vec![Light { name: String::new(), node: 0, intensity: Vec3::ONE, kind }];
    let mut animator = animator(parts);
    let frame = animator.advance(0.25, 0.0);
    assert_eq!(frame.lights()[0].intensity, Vec3::new(3.0, 1.0, 0.0));
    assert!(!frame.is_still());
}

#[test]
fn colours_and_texture_coordinates_morph_by_the_weights_of_the_moment() {
    let mut mesh = quad();
    mesh.colours = vec![Vec4::ONE; 4];
    mesh.morph_targets = vec![MorphTarget {
        colours: vec![Vec4::new(0.0, -0.5, 0.0, -0.8); 4],
        uv_sets: vec![vec![Vec2::X * 0.5; 4]],
        ..MorphTarget::default()
    }];
    let texels = [[255, 255, 255, 255], [0, 0, 0, 255]];
    let texture = Texture {
        name: String::new(),
        image: Arc::new(Image::from_vec(2, 1, texels.to_vec()).unwrap()),
        srgb: true,
        wrap: [Wrap::Repeat; 2],
        filter: sheer_scene::model::Filter::Nearest,
        minification: sheer_scene::model::Minification::default(),
    };
    let material = Material {
        alpha_mode: AlphaMode::Blend,
        emissive: Vec3::ONE,
        emissive_texture: Some(TextureRef::new(0)),
        ..Material::default()
    };
    let mut parts = parts_with(mesh, material, Transform::IDENTITY);
    parts.textures = vec![texture];
    let weights = linear(vec![0.0], vec![2.0]);
    parts.animations = vec![Animation {
        name: String::new(),
        channels: vec![Channel { node: 0, track: Track::MorphWeights(weights) }],
        properties: Vec::new(),
    }];
    let mut animator = animator(parts);
    for (time_secs, alpha, green, texel) in
        [(0.0, 1.0, 1.0, 1.0), (0.5, 0.2, 0.5, 0.0), (0.99, 0.0, 0.01, 1.0)]
    {
        let frame = animator.advance(time_secs, 0.0);
        let surface = frame.surface(0, 0.05, 0.2, true, BEAM);
        assert!((frame.opacity(0, 0.05, 0.2, 0.0) - alpha).abs() < 1e-5, "{time_secs}");
        assert!((surface.base_colour.y - green).abs() < 1e-5, "{time_secs}: {surface:?}");
        assert!((surface.emissive.x - texel).abs() < 1e-5, "{time_secs}");
        // Nothing moves, but all looks otherwise.
        assert_eq!(frame.is_still(), time_secs == 0.0);
    }
}

fn particles() -> SceneParts {
    let mut parts = parts_with(quad(), Material::default(), Transform::IDENTITY);
    parts.materials.push(Material { alpha_mode: AlphaMode::Blend, ..Material::default() });
    parts.particles = vec![ParticleSystem {
        name: "puffs".to_owned(),
        material: 1,
        atlas: [1, 1],
        particles: vec![
            Particle {
                birth_secs: 0.0,
                lifetime_secs: 2.0,
                origin: Vec3::ZERO,
                velocity: Vec3::X,
                acceleration: Vec3::ZERO,
                half_size: [0.5, 0.5],
                rotation_rad: 0.0,
                spin_rad_per_sec: 0.0,
                alpha: 0.4,
                tint: Vec3::ONE,
                tile: 0,
            };
            3
        ],
        loop_secs: None,
        turbulence: Turbulence::default(),
        fade: [0.0, 0.0],
        near_fade: [0.0, 0.0],
    }];
    parts.particles[0].particles[1].birth_secs = 1.5;
    parts.cameras = vec![Camera::fixed("static", 0.8, Vec3::new(3.0, 2.0, 9.0), Vec3::ZERO)];
    parts
}

#[test]
fn a_frame_is_still_when_nothing_that_is_seen_has_changed() {
    let fixed = || Camera::fixed("static", 0.8, Vec3::new(3.0, 2.0, 9.0), Vec3::ZERO);
    let scene = || {
        let mut parts = parts_with(quad(), Material::default(), Transform::IDENTITY);
        parts.nodes.push(Node { name: String::new(), parent: None, transform: Transform::IDENTITY });
        parts.instances[0].node = 1;
        parts.cameras = vec![fixed()];
        parts
    };
    let is_still = |parts: SceneParts, time_secs| animator(parts).advance(time_secs, 0.25).is_still();

    assert!(is_still(scene(), 0.5));
    // What is animated holds nothing that is seen; then a light; then the mesh.
    let mut parts = SceneParts { animations: sliding([Vec3::ZERO, Vec3::X]), ..scene() };
    assert!(is_still(parts.clone(), 0.5));
    let kind = LightKind::Point { range: f32::INFINITY };
    parts.lights = vec![Light { name: String::new(), node: 0, intensity: Vec3::ONE, kind }];
    assert!(!is_still(parts.clone(), 0.5) && is_still(parts.clone(), 0.25));
    parts.lights[0].node = 1;
    assert!(is_still(parts.clone(), 0.5));
    parts.instances[0].node = 0;
    assert!(!is_still(parts.clone(), 0.5) && is_still(parts, 0.25));

    let mut moving = fixed();
    let key = |time_secs, x| CameraKey { time_secs, eye: Vec3::new(x, 0.0, 9.0), target: Vec3::ZERO };
    moving.motion = CameraMotion::Path { keys: vec![key(0.0, 0.0), key(1.0, 1.0)] };
    let parts = SceneParts { cameras: vec![moving], ..scene() };
    assert!(!is_still(parts.clone(), 0.5) && is_still(parts.clone(), 0.25));
    // Both moments lie behind the end of the path.
    assert!(animator(parts).advance(3.0, 2.0).is_still());
    assert!(!is_still(particles(), 0.5) && is_still(particles(), 0.25));
}

#[test]
fn particles_face_the_camera_live_and_die_and_keep_their_identity() {
    let mut animator = animator(particles());
    let ids = |frame: &Frame| -> Vec<u32> {
        let quads = frame.static_count()..frame.triangles().len();
        quads.step_by(2).map(|triangle| frame.object(triangle as u32).id).collect()
    };
    assert_eq!(ids(animator.advance(1.0, 1.0)), [8, 10], "the second is not born");
    assert_eq!(ids(animator.advance(1.75, 1.75)), [8, 9, 10]);
    assert_eq!(ids(animator.advance(2.5, 2.5)), [9], "two have died");

    let frame = animator.advance(1.0, 0.9);
    let triangle = frame.static_count() as u32;
    let [a, b, c] = frame.triangles()[triangle as usize];
    let normal = (b - a).cross(c - a).normalize();
    assert!((normal + frame.camera().forward()).length() < 1e-5, "{normal}");
    assert!((frame.opacity(triangle, 0.2, 0.2, 0.0) - 0.4).abs() < 1e-6);
    let surface = frame.surface(triangle, 0.2, 0.2, true, BEAM);
    assert!((surface.position - surface.previous_position - Vec3::X * 0.1).length() < 1e-5);
}

#[test]
fn no_point_of_a_triangle_is_more_opaque_than_its_bound() {
    let image =
        Image::from_fn(8, 8, |x, y| [255, 255, 255, if (x + y) % 3 == 0 { 255 } else { 90 }]).unwrap();
    let texture = Texture {
        name: String::new(),
        image: Arc::new(image),
        srgb: true,
        wrap: [Wrap::Repeat; 2],
        filter: Default::default(),
        minification: Default::default(),
    };
    let colours: Vec<Vec4> = [0.3, 0.9, 0.1, 0.5].map(|alpha| Vec4::new(1.0, 1.0, 1.0, alpha)).into();
    let modes = [AlphaMode::Blend, AlphaMode::Mask { cutoff: 0.2 }, AlphaMode::Opaque];
    for (mode, textured, opacity) in
        modes.into_iter().flat_map(|mode| [(mode, false, 1.0), (mode, true, 1.0), (mode, true, 0.6)])
    {
        let material = Material {
            alpha_mode: mode,
            base_colour: Vec4::new(1.0, 1.0, 1.0, 0.8),
            base_colour_texture: textured.then(|| TextureRef::new(0)),
            opacity,
            ..Material::default()
        };
        let mesh = Mesh { colours: colours.clone(), ..quad() };
        let mut parts = parts_with(mesh, material, Transform::IDENTITY);
        parts.textures = vec![texture.clone()];
        let animator = animator(parts);
        let frame = animator.frame();
        for triangle in 0..2 {
            let bound = frame.most_opacity(triangle);
            let weights =
                (0..=20).flat_map(|u| (0..=20 - u).map(move |v| (u as f32 / 20.0, v as f32 / 20.0)));
            let most = weights.map(|(u, v)| frame.opacity(triangle, u, v, 0.0)).fold(0.0, f32::max);
            assert!(most <= bound, "{mode:?} {textured} {opacity}: {most} of {bound}");
            // And no bound is far from what is there, but where the texture is clear at the densest corner.
            assert!(textured || bound <= most * 1.01, "{mode:?} {opacity}: {most} of {bound}");
        }
    }
}

#[test]
fn particles_are_where_they_were_in_the_frame_before_however_that_is_known() {
    // They come, go, start anew and fade before a camera that moves through them.
    let mut parts = particles();
    let system = &mut parts.particles[0];
    let first = system.particles[0];
    system.particles = (0..90)
        .map(|index| Particle {
            birth_secs: index as f32 * 0.037,
            lifetime_secs: 0.3 + (index % 7) as f32 * 0.2,
            origin: Vec3::new((index % 9) as f32 - 4.0, (index % 5) as f32 - 2.0, (index % 11) as f32),
            spin_rad_per_sec: index as f32 * 0.1,
            ..first
        })
        .collect();
    system.loop_secs = Some(2.5);
    system.near_fade = [3.0, 0.5];
    let key = |time_secs, z| CameraKey { time_secs, eye: Vec3::new(0.2, 0.1, z), target: Vec3::NEG_Z };
    parts.cameras[0].motion = CameraMotion::Path { keys: vec![key(0.0, 14.0), key(3.0, 4.0)] };

    let lists = |frame: &Frame| (frame.triangles().to_vec(), frame.previous_moving().to_vec());
    let mut played = animator(parts.clone());
    let mut counts = Vec::new();
    for (time_secs, previous_secs) in
        [(0.1, 0.0), (0.2, 0.1), (0.3, 0.2), (0.3, 0.3), (1.1, 0.4), (1.4, 1.1), (1.2, 1.4)]
    {
        let alone = lists(animator(parts.clone()).advance(time_secs, previous_secs));
        let played = lists(played.advance(time_secs, previous_secs));
        counts.push(alone.1.len());
        assert_eq!(played, alone, "{time_secs} after {previous_secs}");
    }
    counts.sort_unstable();
    counts.dedup();
    assert!(counts.len() > 3, "quads come and go: {counts:?}");
    // The camera alone makes the quads elsewhere.
    let turned = lists(played.advance(1.2, 1.1));
    assert_ne!(turned.1, turned.0[turned.0.len() - turned.1.len()..]);
}

#[test]
fn a_made_up_view_holds_the_whole_scene_and_fills_the_picture() {
    let transform = Transform::from_translation(Vec3::new(40.0, -3.0, 7.0));
    let animator = animator(parts_with(quad(), Material::default(), transform));
    let size = Vec2::new(960.0, 540.0);
    let corners = animator.frame().triangles().iter().flatten();
    let seen: Vec<Vec2> =
        corners.map(|&corner| animator.frame().camera().project(corner, size).unwrap()).collect();
    assert!(seen.iter().all(|at| at.cmpge(Vec2::ZERO).all() && at.cmple(size).all()), "{seen:?}");
    let height = seen.iter().map(|at| (at.y - 270.0).abs()).fold(0.0, f32::max);
    assert!(height > 0.7 * 270.0, "{seen:?}");
}

#[test]
fn scenes_with_a_fault_are_refused_with_its_place() {
    let fault = |break_it: &dyn Fn(&mut SceneParts)| {
        let mut parts = particles();
        break_it(&mut parts);
        Scene::new(parts).unwrap_err().to_string()
    };
    assert!(
        fault(&|parts| parts.meshes[0].indices[1][2] = 4).contains("mesh 0 '': an index is out of range")
    );
    assert!(fault(&|parts| parts.meshes[0].positions[0].y = f32::NAN).contains("a position is not finite"));
    assert!(fault(&|parts| parts.nodes[0].parent = Some(0)).contains("node 0 '': its parent"));
    assert!(
        fault(&|parts| parts.materials[1].roughness = 1.5)
            .contains("material 1 '': a factor is not in [0, 1]")
    );
    assert!(
        fault(&|parts| parts.particles[0].particles[2].alpha = -1.0).contains("particle system 0 'puffs'")
    );
    assert!(fault(&|parts| parts.instances[0].morph_weights.push(0.0)).contains("instance 0: morph weights"));
    assert!(fault(&|parts| parts.exposure = 0.0).contains("exposure"));
    assert!(Scene::new(particles()).is_ok(), "and without a fault it is taken");
}

#[test]
fn light_takes_the_colour_of_what_it_shines_through() {
    let colour = Vec3::new(1.0, 0.5, 0.0);
    let through = |alpha: f32, transmission: f32, whole: Option<f32>| {
        let material = Material {
            alpha_mode: AlphaMode::Blend,
            base_colour: colour.extend(alpha),
            transmission,
            ..Material::default()
        };
        let scene = Scene::new(parts_with(quad(), material, Transform::IDENTITY)).unwrap();
        let scene = Arc::new(whole.map_or(scene.clone(), |alpha| scene.with_alpha(alpha)));
        let camera = scene.camera(&CameraChoice::Default).unwrap();
        let animator = Animator::new(scene, camera);
        let frame = animator.frame();
        assert_eq!(frame.tints_light(), transmission > 0.0);
        let found = frame.light_through(0, 0.3, 0.3, true, frame.opacity(0, 0.3, 0.3, 0.0), 0.0);
        found.to_array().map(|channel| (channel * 1e4).round() / 1e4)
    };
    // No transmission: grey. Glass all over the surface: its transmission times its colour. Glass over half
    // of it: the other half is white.
    assert_eq!(through(0.3, 0.0, None), [0.7, 0.7, 0.7]);
    assert_eq!(through(0.2, 0.8, None), [0.8, 0.4, 0.0]);
    assert_eq!(through(0.1, 0.8, None), [0.9, 0.7, 0.5]);
    // A texel that transmits less than the material: what passes has the colour. The ends are clear and
    // black.
    assert_eq!(through(0.6, 0.8, None), [0.4, 0.2, 0.0]);
    assert_eq!(through(0.0, 0.8, None), [1.0, 1.0, 1.0]);
    assert_eq!(through(1.0, 0.8, None), [0.0, 0.0, 0.0]);
    assert_eq!(through(0.2, 0.8, Some(0.5)), [0.5, 0.25, 0.0]);
}

#[test]
fn a_body_absorbs_its_thickness_in_the_world_once() {
    let material = Material {
        alpha_mode: AlphaMode::Blend,
        base_colour: Vec4::new(1.0, 1.0, 1.0, 0.2),
        transmission: 0.8,
        thickness: 0.25,
        absorption: Vec3::new(0.0, 1.0, 2.0),
        ..Material::default()
    };
    // Twice as large in the world as in the mesh.
    let transform =
        Transform::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::splat(2.0) };
    let scene = Arc::new(Scene::new(parts_with(quad(), material, transform)).unwrap());
    let camera = scene.camera(&CameraChoice::Default).unwrap();
    let animator = Animator::new(scene, camera);
    let through =
        |counter_clockwise: bool| animator.frame().light_through(0, 0.3, 0.3, counter_clockwise, 0.2, 0.0);
    let expected = 0.8 * (-0.5 * Vec3::new(0.0, 1.0, 2.0)).exp();
    assert!(through(true).abs_diff_eq(expected, 1e-6), "{} {expected}", through(true));
    // Where a ray leaves a body it has paid already.
    assert!(through(false).abs_diff_eq(Vec3::splat(0.8), 1e-6), "{}", through(false));
}

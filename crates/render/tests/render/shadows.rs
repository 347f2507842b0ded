//! Every shadow technique against deep rays and closed forms.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{Affine3A, EulerRot, Quat, Vec3, Vec4};
use sheer_render::{
    Antialiasing, Pipeline, Settings, Shadow, Stage,
    shadow::{SHADOWS, Shadows},
};
use sheer_scene::{
    CameraChoice, Scene,
    model::{AlphaMode, Instance, Light, LightKind, Material, Mesh, Node, SceneParts, Transform},
};

/// A floor at height 0 under square sheets, and lights.
struct Room {
    parts: SceneParts,
}

const SUN: LightKind = LightKind::Directional;
const LAMP: LightKind = LightKind::Point { range: f32::INFINITY };
const SPOT: LightKind = LightKind::Spot { range: f32::INFINITY, inner_cone_rad: 0.6, outer_cone_rad: 0.7 };

impl Room {
    fn new() -> Self {
        let mut room =
            Self { parts: SceneParts { name: "room".into(), exposure: 1.0, ..SceneParts::default() } };
        room.sheet(Material::default(), 5.0, Transform::IDENTITY);
        room
    }

    fn node(&mut self, transform: Transform) -> u32 {
        self.parts.nodes.push(Node { name: String::new(), parent: None, transform });
        self.parts.nodes.len() as u32 - 1
    }

    /// A horizontal square of so much half a side, placed.
    fn sheet(&mut self, material: Material, half: f32, transform: Transform) {
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
        let index = self.parts.meshes.len() as u32;
        self.parts.materials.push(Material { double_sided: true, ..material });
        self.parts.meshes.push(Mesh {
            positions: corners.map(|(x, z)| Vec3::new(x, 0.0, z)).into(),
            indices: vec![[0, 2, 1], [0, 3, 2]],
            material: index,
            ..Mesh::default()
        });
        let node = self.node(transform);
        self.parts.instances.push(Instance {
            node,
            node_from_object: Affine3A::IDENTITY,
            mesh: index,
            id: index,
            geometry: 0,
            skin: None,
            morph_weights: Vec::new(),
        });
    }

    /// Sheets of one opacity at heights 1, 1.1, 1.2…
    fn layers(mut self, count: u32, material: &Material) -> Self {
        for layer in 0..count {
            self.sheet(
                material.clone(),
                2.0,
                Transform::from_translation(Vec3::Y * (1.0 + 0.1 * layer as f32)),
            );
        }
        self
    }

    /// A light at height 4 that shines straight down, turned aside by an angle.
    fn lit(mut self, kind: LightKind, aside_rad: f32) -> Stage {
        let down = Quat::from_euler(EulerRot::XYZ, -std::f32::consts::FRAC_PI_2 + aside_rad, 0.0, 0.0);
        let place = Transform::Trs { translation: Vec3::Y * 4.0, rotation: down, scale: Vec3::ONE };
        let node = self.node(place);
        self.parts.lights.push(Light { name: String::new(), node, intensity: Vec3::splat(10.0), kind });
        Stage::new(Scene::new(self.parts).unwrap(), &CameraChoice::Default, Some(2)).unwrap()
    }
}

fn film(alpha: f32) -> Material {
    Material {
        alpha_mode: AlphaMode::Blend,
        base_colour: Vec4::new(1.0, 1.0, 1.0, alpha),
        ..Material::default()
    }
}

fn shadows(stage: &Stage, technique: &str, frame: u32) -> Shadows {
    let shadow: Shadow = technique.parse().unwrap();
    Shadows::new(stage, &shadow, frame, 0).unwrap()
}

/// What of the light arrives at a point of a level surface.
fn arriving(stage: &Stage, shadows: &Shadows, point: Vec3) -> Vec3 {
    shadows.transmittance(stage, 0, point, Vec3::Y, [1, 2, 3])
}

/// Points of the floor under the sheets, off the edges of texels and triangles.
fn points() -> impl Iterator<Item = Vec3> {
    (0..64).map(|at| Vec3::new((at % 8) as f32 * 0.13 - 0.46, 0.0, (at / 8) as f32 * 0.131 - 0.45))
}

/// Techniques whose answer is not random and, behind everything, exact; and deep rays. With the error that is
/// left.
const EXACT_BEHIND: [(&str, f32); 6] = [
    ("deep", 1e-5),
    ("deep-map:resolution=128,tolerance=0", 1e-4),
    ("deep-map:resolution=128,tolerance=0.03", 0.03),
    ("opacity-map:resolution=128,layers=4", 1e-4),
    ("fourier:resolution=128,terms=3", 1e-3),
    ("stochastic-map:resolution=128,samples=4,correct=on", 1e-5),
];

#[test]
fn behind_constant_layers_the_light_is_the_closed_form() {
    for kind in [SUN, LAMP, SPOT] {
        for (count, alpha) in [(1, 0.3_f32), (2, 0.45), (4, 0.2)] {
            let stage = Room::new().layers(count, &film(alpha)).lit(kind, 0.1);
            let expected = (1.0 - alpha).powi(count as i32);
            for (technique, tolerance) in EXACT_BEHIND {
                let shadows = shadows(&stage, technique, 0);
                for point in points() {
                    let found = arriving(&stage, &shadows, point);
                    let error = (found - expected).abs().max_element();
                    assert!(
                        error <= tolerance,
                        "{technique}, {kind:?}, {count} layers: {found}, not {expected}"
                    );
                }
            }
        }
    }
}

/// Mean and variance over frames of what arrives at a point.
fn moments(stage: &Stage, technique: &str, point: Vec3, frames: u32) -> (f64, f64) {
    let draw = |frame| f64::from(arriving(stage, &shadows(stage, technique, frame), point).x);
    let values: Vec<f64> = (0..frames).map(draw).collect();
    let mean = values.iter().sum::<f64>() / f64::from(frames);
    (mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::from(frames - 1))
}

#[test]
fn a_stochastic_map_is_unbiased_and_strata_calm_it() {
    const FRAMES: u32 = 600;
    let point = Vec3::new(0.21, 0.0, 0.13);
    for (kind, count, alpha) in [(SUN, 4, 0.2_f32), (LAMP, 2, 0.45), (SPOT, 2, 0.3)] {
        let stage = Room::new().layers(count, &film(alpha)).lit(kind, 0.1);
        let truth = f64::from((1.0 - alpha).powi(count as i32));
        let [naive, stratified] = ["naive", "stratified"].map(|sampling| {
            let keys = format!("stochastic-map:resolution=16,samples=8,filter=0,sampling={sampling}");
            let (mean, variance) = moments(&stage, &keys, point, FRAMES);
            let z = (mean - truth) / (variance / f64::from(FRAMES)).sqrt();
            // Nine values in all: 3.7 standard deviations happen once in 500 runs.
            assert!(z.abs() < 3.7, "{keys}, {kind:?}: mean {mean}, not {truth}, z {z}");
            variance
        });
        // A coin for each sample makes a binomial; the estimate of its variance from 600 draws is off by 6 %.
        assert!((naive / (truth * (1.0 - truth) / 8.0) - 1.0).abs() < 0.25, "{kind:?}: {naive}");
        assert!(stratified < 0.75 * naive, "{kind:?}: naive {naive}, stratified {stratified}");
        let taps = "stochastic-map:resolution=16,samples=8,filter=3,taps=16";
        let (mean, variance) = moments(&stage, taps, point, FRAMES);
        let z = (mean - truth) / (variance / f64::from(FRAMES)).sqrt();
        assert!(z.abs() < 3.7, "{taps}, {kind:?}: mean {mean}, z {z}");
        // Negative control: one map for all frames is found to be off.
        let one = moments(&stage, "stochastic-map:resolution=16,samples=1,filter=0", point, 1).0;
        assert!((one - truth).abs() > 0.1, "one sample is 0 or 1");
    }
}

#[test]
fn alpha_correction_helps_between_layers_where_it_is_fed() {
    // Between the layers the correction is biased (ST section 4); with samples enough it goes.
    let stage = Room::new().layers(4, &film(0.2)).lit(SUN, 0.0);
    let point = Vec3::new(0.21, 1.15, 0.13);
    let truth = 0.8_f64.powi(2);
    let error = |samples: u32| {
        let keys = format!("stochastic-map:resolution=16,samples={samples},filter=0,correct=on");
        let (mean, variance) = moments(&stage, &keys, point, 300);
        ((mean - truth).abs(), variance)
    };
    let ((few, few_variance), (many, many_variance)) = (error(4), error(64));
    assert!(many < 0.02 && many <= few + 0.01, "{few}, {many}");
    assert!(many_variance < 0.3 * few_variance, "{few_variance}, {many_variance}");
}

#[test]
fn between_layers_each_technique_keeps_to_its_bound() {
    let (count, alpha) = (4, 0.3_f32);
    let stage = Room::new().layers(count, &film(alpha)).lit(SUN, 0.0);
    let visibility = |above: i32| (1.0 - alpha).powi(above);
    for (technique, tolerance) in [
        ("deep", 1e-5),
        ("deep-map:resolution=64,tolerance=0", 1e-4),
        ("deep-map:resolution=64,tolerance=0.02", 0.0201),
        // Three spaces between four layers: with 3 of its own each blocker but the last fills one, and half
        // of it counts in the middle.
        ("opacity-map:resolution=64,layers=3", alpha * visibility(1)),
        // Fine layers tell the blockers apart.
        ("opacity-map:resolution=64,layers=64", 1e-4),
        // Ringing: steps of 0.36 in optical depth; each of four is off by at most 1 / (π (terms + 1) |sin π
        // x|) twice, at a ninth of the period or more. The unit tests hold the series to the sharper bound.
        ("fourier:resolution=64,terms=7", 0.2),
        ("fourier:resolution=64,terms=40", 0.06),
    ] {
        let shadows = shadows(&stage, technique, 0);
        for below in 1..count as i32 {
            // Under `below` of the sheets, counted from the light.
            let height = 1.0 + 0.1 * (count as f32 - below as f32) - 0.05;
            let found = arriving(&stage, &shadows, Vec3::new(0.2, height, 0.1)).x;
            let error = (found - visibility(below)).abs();
            assert!(error <= tolerance, "{technique} under {below}: {found}, not {}", visibility(below));
        }
        let above = arriving(&stage, &shadows, Vec3::new(0.2, 2.0, 0.1)).x;
        assert!(above > 0.999, "{technique}: nothing shadows what lies before everything: {above}");
    }
}

/// All techniques as they are by default, but small.
fn all() -> impl Iterator<Item = String> {
    let small = |info: &sheer_render::shadow::ShadowInfo| match info.id {
        "deep" => info.id.to_owned(),
        id => format!("{id}:resolution=256"),
    };
    let more = ["naive,samples=1,filter=5", "stratified,correct=on", "stratified,filter=4,taps=16"];
    let more = more.map(|keys| format!("stochastic-map:resolution=256,sampling={keys}"));
    SHADOWS.iter().map(small).chain(more)
}

#[test]
fn opaque_things_cast_whole_shadows_through_films() {
    for kind in [SUN, LAMP, SPOT] {
        let stage = Room::new().layers(1, &Material::default()).layers(3, &film(0.3)).lit(kind, 0.2);
        for technique in all() {
            let shadows = shadows(&stage, &technique, 0);
            for point in points() {
                let found = arriving(&stage, &shadows, point);
                assert_eq!(found, Vec3::ZERO, "{technique}, {kind:?} at {point}");
            }
        }
    }
}

/// The least that arrives anywhere on a floor that nothing stands on, if its normal is said to be `normal`.
fn least_on_the_bare_floor(stage: &Stage, technique: &str, normal: Vec3) -> f32 {
    let shadows = shadows(stage, technique, 0);
    let at = |at: u32| Vec3::new((at % 61) as f32 * 0.131 - 3.93, 0.0, (at / 61) as f32 * 0.127 - 3.81);
    let arriving = |point| shadows.transmittance(stage, 0, point, normal, [1, 2, 3]);
    (0..3600).map(|index| arriving(at(index)).min_element()).fold(1.0, f32::min)
}

#[test]
fn a_lit_plane_does_not_shadow_itself() {
    // From straight down to a sun that stands 4° above the floor.
    for (kind, aside) in [(SUN, 0.0), (SUN, 0.7), (SUN, 1.3), (SUN, 1.5), (LAMP, 0.0), (SPOT, 0.3)] {
        let stage = Room::new().lit(kind, aside);
        for technique in all() {
            let least = least_on_the_bare_floor(&stage, &technique, Vec3::Y);
            assert!(least >= 0.99, "{technique}, {kind:?} aside by {aside}: {least}");
            // Negative control: a bias that takes the floor to face the light finds acne wherever a slope
            // needs more.
            if technique != "deep" && aside > 1.0 {
                let to_light = -stage.frame().lights()[0].direction;
                let least = least_on_the_bare_floor(&stage, &technique, to_light);
                assert!(least < 0.9, "{technique} aside by {aside}: the check is blind");
            }
        }
    }
}

#[test]
fn a_point_off_the_plane_by_more_than_the_bias_is_in_shadow() {
    // The bias is too small to let light through: two sheets a thousandth of the room apart.
    let mut room = Room::new();
    room.sheet(Material::default(), 2.0, Transform::from_translation(Vec3::Y * 0.05));
    let stage = room.lit(SUN, 0.3);
    for technique in all() {
        let shadows = shadows(&stage, &technique, 0);
        for point in points() {
            assert_eq!(arriving(&stage, &shadows, point), Vec3::ZERO, "{technique}: light leaks at {point}");
        }
        // Negative control: a point below the floor, as a wrong bias would make of one on it, is dark.
        let stage = Room::new().lit(SUN, 0.3);
        let shadows = self::shadows(&stage, &technique, 0);
        assert_eq!(arriving(&stage, &shadows, Vec3::new(0.2, -0.3, 0.1)), Vec3::ZERO, "{technique}");
    }
}

#[test]
fn coloured_glass_casts_coloured_shadows() {
    // Glass all over the sheet that transmits 0.8 of the light in its colour.
    let glass = Material { base_colour: Vec4::new(1.0, 0.5, 0.1, 0.2), transmission: 0.8, ..film(0.2) };
    let expected = 0.8 * Vec3::new(1.0, 0.5, 0.1);
    for kind in [SUN, LAMP, SPOT] {
        let stage = Room::new().layers(1, &glass).lit(kind, 0.1);
        for (technique, tolerance) in EXACT_BEHIND {
            let found = arriving(&stage, &shadows(&stage, technique, 0), Vec3::new(0.2, 0.0, 0.1));
            let error = (found - expected).abs().max_element();
            assert!(error <= tolerance + 1e-5, "{technique}, {kind:?}: {found}, not {expected}");
        }
    }
    // One layer: 64 strata miss each channel by less than a sample.
    let stage = Room::new().layers(1, &glass).lit(SUN, 0.1);
    let map = shadows(&stage, "stochastic-map:resolution=64,samples=64,filter=0", 0);
    let found = arriving(&stage, &map, Vec3::new(0.2, 0.0, 0.1));
    assert!((found - expected).abs().max_element() <= 1.0 / 64.0, "{found}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut stages = [1, 2].map(|threads| {
        let scene = sheer_gallery::open("smoke-square:particles=200").unwrap().scene;
        Stage::new(scene, &CameraChoice::Default, Some(threads)).unwrap()
    });
    let mut render = |technique: &str| {
        let settings = Settings { size: [48, 27], shadow: technique.parse().unwrap(), ..Settings::default() };
        stages.each_mut().map(|stage| {
            let mut pipeline = Pipeline::new("std".parse().unwrap(), Antialiasing::NONE, settings).unwrap();
            stage.advance(pipeline.clock().at(0));
            let (counters, timings) = pipeline.render(stage, 0).unwrap();
            assert!(timings.shadow_ms <= timings.trace_ms);
            (pipeline.planes().clone(), counters)
        })
    };
    let [(deep, _), _] = render("deep");
    for technique in all() {
        let [one, two] = render(&technique);
        assert_eq!(one, two, "{technique}");
        assert_eq!(one.0 == deep, technique == "deep", "{technique}: the map is not looked at");
    }
}

#[test]
fn maps_too_large_for_any_machine_are_refused() {
    let stage = Room::new().lit(LAMP, 0.0);
    let shadow: Shadow = "stochastic-map:resolution=8192,samples=64".parse().unwrap();
    let refused = Shadows::new(&stage, &shadow, 0, 0).unwrap_err().to_string();
    assert!(refused.contains("resolution="), "{refused}");
}

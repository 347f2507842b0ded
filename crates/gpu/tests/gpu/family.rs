//! Methods that take fragments in any order, drawn on the device, against the CPU.
//!
//! Both sides see the same hits by the same arithmetic. What differs: which pixels a triangle covers at its
//! edges, the 16-bit sums of the blending units, and roots, powers and logarithms, which a device may round
//! in its own way.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{fs, path::Path, sync::Arc};

use glam::{Affine3A, Vec3, Vec4};
use sheer_gpu::{AdapterChoice, Gpu, GpuError, GpuPathChoice, GpuPipeline, GpuStage};
use sheer_image::Planes;
use sheer_render::{Antialiasing, Background, Counters, Settings, Stage as CpuStage};
use sheer_scene::{
    CameraChoice, ClipPlanes, Scene,
    camera::{Camera, CameraKey, CameraMotion, Lens},
    model::{AlphaMode, Instance, Material, Mesh, Node, SceneParts, ShadingModel, Transform},
};

/// Some with an opacity for everything. All are less than 32 deep.
const SCENES: [(&str, Option<f32>); 5] = [
    ("layers:count=6,alpha=0.3,colours=rainbow", None),
    ("pane", None),
    ("smoke-square:particles=200", None),
    ("gltf/Fox/Fox.gltf", Some(0.4)),
    ("gltf/NegativeScaleTest/NegativeScaleTest.gltf", Some(0.6)),
];
const SIZE: [u32; 2] = [96, 64];
/// Pixels that may differ by anything: an edge of a triangle may be drawn into one pixel here and into its
/// neighbour there.
const OUTLIERS: f64 = 0.005;

/// How far colours may be from the CPU's, as shares of the brighter one or of 1: root mean square over the
/// transparent pixels, and the most.
#[derive(Clone, Copy, Debug)]
struct Bound {
    rms: f64,
    most: f64,
}

/// The same operations in the same order, in 32 bits: what differs is the roots and exponentials of shading,
/// by some units in the last place, and the visibility of what is at the brim of a light's cone or of a
/// shadow.
const EXACT: Bound = Bound { rms: 5e-5, most: 5e-4 };
/// Sums of radiance, of weights and products of transmittance are rounded to 11 bits once a fragment: by 2⁻¹²
/// at most each, of random sign. For the 20 fragments that a pixel has at most, √20 · √3 · 2⁻¹² = 1.9e-3, and
/// four times that where it is at its worst; pixels have 5 of them on average, and errors of uniform
/// distribution a root mean square of 1/√3 of the most: 5.5e-4.
const HALF_SUMS: Bound = Bound { rms: 6e-4, most: 7.6e-3 };

fn scene(text: &str, alpha: Option<f32>) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(text);
    let text = if text.contains('/') { file.to_str().unwrap() } else { text };
    let scene = sheer_gallery::open(text).unwrap().scene;
    match alpha {
        Some(alpha) => scene.with_alpha(alpha),
        None => scene,
    }
}

/// A scene on both sides.
struct Sides {
    gpu: Arc<Gpu>,
    on_gpu: GpuStage,
    on_cpu: CpuStage,
    settings: Settings,
}

impl Sides {
    fn of(scene: impl Into<Arc<Scene>>) -> Self {
        let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
        let scene = scene.into();
        let on_gpu = GpuStage::new(&gpu, Arc::clone(&scene), &CameraChoice::Default, None).unwrap();
        let on_cpu = CpuStage::new(scene, &CameraChoice::Default, None).unwrap();
        Self { gpu, on_gpu, on_cpu, settings: Settings { size: SIZE, ..Settings::default() } }
    }

    /// The same without anything behind, so that alpha is seen.
    fn over_nothing(scene: impl Into<Arc<Scene>>) -> Self {
        let mut sides = Self::of(scene);
        sides.settings.background = Background::None;
        sides
    }

    fn pipeline(&self, method: &str) -> Result<GpuPipeline, GpuError> {
        let method = method.parse().unwrap();
        GpuPipeline::new(&self.gpu, GpuPathChoice::Raster, method, Antialiasing::NONE, self.settings)
    }

    fn draw(&mut self, method: &str) -> (Planes, Counters) {
        let mut pipeline = self.pipeline(method).unwrap();
        self.on_gpu.advance(pipeline.clock().at(0)).unwrap();
        let (counters, _) = pipeline.render(&mut self.on_gpu, 0).unwrap();
        (pipeline.planes().unwrap(), counters)
    }

    fn expect(&mut self, method: &str) -> (Planes, Counters) {
        let method = method.parse().unwrap();
        let mut pipeline = sheer_render::Pipeline::new(method, Antialiasing::NONE, self.settings).unwrap();
        self.on_cpu.advance(pipeline.clock().at(0));
        let (counters, _) = pipeline.render(&self.on_cpu, 0).unwrap();
        (pipeline.planes().clone(), counters)
    }
}

/// Differences of the pixels that are transparent on either side, without the outliers.
fn difference(a: &Planes, b: &Planes) -> Bound {
    let pairs = a.colour.as_slice().iter().zip(b.colour.as_slice());
    let transparent = a.transparent.as_slice().iter().zip(b.transparent.as_slice());
    let of_channel = |(a, b): (&f32, &f32)| f64::from((a - b).abs() / a.abs().max(b.abs()).max(1.0));
    let mut differences: Vec<f64> = pairs
        .zip(transparent)
        .filter(|(_, (a, b))| **a || **b)
        .map(|((a, b), _)| a.iter().zip(b).map(of_channel).fold(0.0, f64::max))
        .collect();
    assert!(differences.iter().all(|difference| difference.is_finite()));
    assert!(differences.len() > 200, "{} pixels say little", differences.len());
    differences.sort_unstable_by(f64::total_cmp);
    let outliers = OUTLIERS * a.colour.as_slice().len() as f64;
    differences.truncate(differences.len() - outliers as usize);
    let squares: f64 = differences.iter().map(|difference| difference * difference).sum();
    Bound {
        rms: (squares / differences.len() as f64).sqrt(),
        most: differences.last().copied().unwrap_or(0.0),
    }
}

impl Bound {
    fn holds(self, bound: Self) -> bool {
        self.rms <= bound.rms && self.most <= bound.most
    }
}

/// Each method's picture is the CPU's on all scenes; on the first one the next method's is not.
fn check(methods: &[(&str, Bound)]) {
    for (index, (text, alpha)) in SCENES.into_iter().enumerate() {
        let mut sides = Sides::of(scene(text, alpha));
        let drawn: Vec<_> = methods.iter().map(|(method, _)| sides.draw(method)).collect();
        for (at, &(method, bound)) in methods.iter().enumerate() {
            let (expected, counters) = sides.expect(method);
            let (found, found_counters) = &drawn[at];
            let found_difference = difference(found, &expected);
            eprintln!("{text}, {method}: {found_difference:?}");
            assert!(found_difference.holds(bound), "{text}, {method}: {found_difference:?}, not {bound:?}");
            if index > 0 {
                continue;
            }
            // There are no edges in sight: all counts are the same.
            let merged = [found_counters.merged, counters.merged];
            assert_eq!(merged[0], merged[1], "{method}");
            assert_eq!(found_counters.hits, counters.hits, "{method}");
            let other = (at + 1) % methods.len();
            let control = difference(&drawn[other].0, &expected);
            assert!(!control.holds(bound), "{} passes for {method}: {control:?}", methods[other].0);
        }
    }
}

/// All fragments in order and what changes a pixel in the order of triangles. Layers are drawn from the back:
/// with three places the methods differ.
#[test]
fn methods_that_go_through_lists_give_the_cpus_pictures() {
    check(&[("list", EXACT), ("mlab:k=2", EXACT), ("adaptive:nodes=3", EXACT)]);
}

#[test]
fn methods_that_add_up_give_the_cpus_pictures() {
    check(&[
        ("weighted", HALF_SUMS),
        ("moments", HALF_SUMS),
        ("weighted:weight=eq8", HALF_SUMS),
        ("moments:order=6", HALF_SUMS),
        ("weighted:weight=eq10", HALF_SUMS),
        ("moments:order=8", HALF_SUMS),
    ]);
}

#[test]
fn methods_that_keep_the_nearest_give_the_cpus_pictures() {
    check(&[("kbuffer:k=32", EXACT), ("peel:layers=3", EXACT), ("peel:layers=5", EXACT)]);
}

/// Three sheets in one place, each of two triangles, in front of another one.
fn sheets_in_one_place() -> Scene {
    let colours = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
    let mesh = |material| Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(x, y, 0.0))
            .into(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    };
    let place = |index: u32| if index == 3 { Vec3::new(0.0, 0.0, -0.5) } else { Vec3::ZERO };
    Scene::new(SceneParts {
        name: "sheets".to_owned(),
        nodes: vec![Node { name: String::new(), parent: None, transform: Transform::IDENTITY }],
        instances: (0..4)
            .map(|index| Instance {
                node: 0,
                node_from_object: Affine3A::from_translation(place(index)),
                mesh: index,
                id: index,
                geometry: index,
                skin: None,
                morph_weights: Vec::new(),
            })
            .collect(),
        meshes: (0..4).map(mesh).collect(),
        materials: colours
            .map(|rgb| Material {
                base_colour: Vec4::from((rgb, 0.5)),
                alpha_mode: AlphaMode::Blend,
                model: ShadingModel::Unlit,
                ..Material::default()
            })
            .into(),
        // No edge is in sight but the diagonals, and these lie beside the centres of pixels: a rasteriser may
        // draw an edge into another pixel than rays find it in.
        cameras: vec![Camera {
            name: "front".to_owned(),
            lens: Lens::Orthographic { half_height: 0.6 },
            clip: ClipPlanes::NONE,
            motion: CameraMotion::Path {
                keys: vec![CameraKey {
                    time_secs: 0.0,
                    eye: Vec3::new(0.013, 0.007, 1.0),
                    target: Vec3::new(0.013, 0.007, 0.0),
                }],
            },
        }],
        exposure: 1.0,
        ..SceneParts::default()
    })
    .unwrap()
}

#[test]
fn surfaces_in_one_place_are_all_seen_in_the_order_of_their_triangles() {
    let mut sides = Sides::of(sheets_in_one_place());
    let (expected, _) = sides.expect("list");
    for method in ["list", "peel:layers=4", "kbuffer:k=4"] {
        let found = difference(&sides.draw(method).0, &expected);
        assert!(found.holds(EXACT), "{method}: {found:?}");
    }
    let (_, counters) = sides.draw("kbuffer:k=2");
    let (_, expected_counters) = sides.expect("kbuffer:k=2");
    assert_eq!(counters.merged, expected_counters.merged);
    assert_eq!([counters.hits, counters.shaded], [expected_counters.hits, expected_counters.shaded]);
    assert!(!difference(&sides.draw("peel:layers=2").0, &expected).holds(EXACT));
}

#[test]
fn what_has_no_place_is_merged_and_never_lost() {
    // White layers: their order does not show, a lost one would by 0.05 · 0.95³⁹ = 6.8e-3. All pixels are
    // alike, so that the mean is the most: 36 products and as many sums that are rounded by 2⁻¹² at most, of
    // random sign: √36 · √2 · 2⁻¹² = 2.1e-3, and not twice that.
    const ALIKE: Bound = Bound { rms: 4e-3, most: 4e-3 };
    // Nodes for 32 fragments a pixel are there; of eight more, transmittance is right, whichever those are.
    let mut sides = Sides::over_nothing(scene("layers:count=40,alpha=0.05", None));
    let (expected, _) = sides.expect("list");
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    for (method, merged) in [("list", 8), ("kbuffer:k=4", 36)] {
        let (found, counters) = sides.draw(method);
        assert_eq!(counters.merged, merged * pixels, "{method}");
        let found = difference(&found, &expected);
        assert!(found.holds(ALIKE), "{method}: {found:?}");
    }
    let (lost, _) = sides.draw("peel:layers=39");
    assert!(!difference(&lost, &expected).holds(ALIKE));
}

#[test]
fn several_samples_a_pixel_are_refused_with_advice() {
    let sides = Sides::of(scene("layers:count=1", None));
    let error = sides.pipeline("list:samples=4").unwrap_err();
    assert!(error.to_string().contains("--backend cpu"), "{error}");
    assert!(matches!(error, GpuError::Unsupported { .. }));
}

/// Bytes a pixel that methods take on the raster path, beyond what all have.
const BYTES: &[(&str, u32, &str)] = &[
    ("std", 28, "surface 16, depth 4, nearest fragment 4, count 4"),
    ("std:hybrid=0.1", 270, "list"),
    ("joint", 270, "list"),
    ("list", 270, "first node 4, 32 nodes of 8, sums of what has no node 10"),
    ("mlab", 270, "list"),
    ("adaptive", 270, "list"),
    ("weighted", 10, "sums 8, transmittance 2"),
    ("moments:order=4", 28, "absorbance 4, moments 16, sums 8"),
    ("moments:order=6", 36, "absorbance 4, moments 24, sums 8"),
    ("moments:order=8", 44, "absorbance 4, moments 32, sums 8"),
    ("peel", 36, "two layers of 8, depth 4, light 16"),
    ("stochastic:samples=4", 76, "4 samples of depth 4, sums 8 and transmittance 2; what fragments tell 20"),
    ("kbuffer:k=8", 74, "8 depths of 4, 8 triangles of 4, sums of what has no place 10"),
];

#[test]
fn methods_take_the_memory_that_the_documentation_says() {
    let sides = Sides::of(scene("layers:count=1", None));
    let mut rows = String::new();
    for (method, bytes, what) in BYTES {
        let found = sides.pipeline(method).unwrap().method_bytes_per_pixel();
        // What a picture has once: the counter of nodes, the sums of rounds that there are not.
        let once = 32.0 / f64::from(SIZE[0] * SIZE[1]);
        assert!((f64::from(*bytes)..=f64::from(*bytes) + once).contains(&found), "{method}: {found}");
        rows += &format!("| `{method}` | {bytes} | {what} |\n");
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/gpu-memory.md");
    let text = fs::read_to_string(file).unwrap();
    assert!(text.contains(&rows), "docs/gpu-memory.md has another table than\n{rows}");
}

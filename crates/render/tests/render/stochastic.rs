//! Stochastic transparency on real scenes and on fragments made up.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::Vec3;
use sheer_core::{colour::Premul, hash::Pcg32};
use sheer_image::Planes;
use sheer_render::{
    Antialiasing, Background, Counters, Method, Pipeline, Settings, Stage,
    contract::{
        Fragment, OrderedCompositing, PixelSite, Selection, Threshold, UnorderedCompositing, Visitor,
    },
};
use sheer_scene::CameraChoice;

/// Of numbers that come one at a time.
#[derive(Clone, Copy, Default)]
struct Moments {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count
    }

    fn variance(&self) -> f64 {
        (self.squares - self.sum * self.mean()) / (self.count - 1.0)
    }

    /// Standard errors between the mean and what it should be.
    fn z(&self, expected: f64) -> f64 {
        (self.mean() - expected) / (self.variance() / self.count).sqrt()
    }
}

fn stage(scene: &str, alpha: Option<f32>, threads: usize) -> Stage {
    let scene = sheer_gallery::open(scene).unwrap().scene;
    let scene = if let Some(alpha) = alpha { scene.with_alpha(alpha) } else { scene };
    Stage::new(scene, &CameraChoice::Default, Some(threads)).unwrap()
}

fn small(width: u32, height: u32) -> Settings {
    Settings { size: [width, height], ..Settings::default() }
}

fn render(stage: &mut Stage, method: &str, settings: Settings) -> (Planes, Counters) {
    let mut pipeline = Pipeline::new(method.parse().unwrap(), Antialiasing::NONE, settings).unwrap();
    stage.advance(pipeline.clock().at(0));
    let (counters, _) = pipeline.render(stage, 0).unwrap();
    (pipeline.planes().clone(), counters)
}

fn colours(planes: &Planes) -> impl Iterator<Item = Premul> {
    planes.colour.as_slice().iter().copied().map(Premul::from_array)
}

fn greatest_difference(one: &Planes, two: &Planes) -> f32 {
    let difference =
        |(a, b): (Premul, Premul)| (a.rgb - b.rgb).abs().max_element().max((a.alpha - b.alpha).abs());
    colours(one).zip(colours(two)).map(difference).fold(0.0, f32::max)
}

/// A fragment that covers whole samples.
#[derive(Clone, Copy)]
struct Piece {
    alpha: f32,
    depth: f32,
    surface: u32,
    is_back: bool,
    coverage: u64,
    rgb: Vec3,
}

/// Fills a pixel with pieces in the order given: its light, and what is left of the background at each
/// sample.
struct Fill<'a> {
    site: PixelSite,
    pieces: &'a [Piece],
}

impl Visitor for Fill<'_> {
    type Output = (Vec3, Vec<f32>);

    fn threshold(self, _: &impl Threshold) -> Self::Output {
        unreachable!("only compositing methods are asked")
    }

    fn selection(self, _: &impl Selection) -> Self::Output {
        unreachable!("only compositing methods are asked")
    }

    fn ordered(self, _: &impl OrderedCompositing) -> Self::Output {
        unreachable!("only compositing methods are asked")
    }

    fn unordered(self, method: &impl UnorderedCompositing) -> Self::Output {
        let samples = method.samples();
        let mut pixel = method.begin(&self.site);
        for pass in 0..method.pass_count() {
            if method.begin_pass(&mut pixel, pass).is_break() {
                break;
            }
            for piece in self.pieces {
                let fragment = Fragment {
                    alpha: piece.alpha,
                    coverage: piece.coverage & samples.all(),
                    depths: &vec![piece.depth; samples.count as usize],
                    order: piece.surface,
                    instance: piece.surface,
                    geometry: 0,
                    primitive: 0,
                    is_back: piece.is_back,
                };
                let _ = method.add(&mut pixel, pass, &fragment, || piece.rgb);
            }
        }
        let transmittance = (0..samples.count as usize).map(|sample| method.transmittance(&pixel, sample));
        (method.resolve(&pixel), transmittance.collect())
    }
}

fn fill(method: &str, frame: u32, pieces: &[Piece]) -> (Vec3, Vec<f32>) {
    let site = PixelSite { pixel: [3, 5], frame, seed: 0, depth_range: [1.0, 100.0] };
    method.parse::<Method>().unwrap().visit(Fill { site, pieces })
}

/// Layers front to back, some at one depth, over some of the samples.
fn pile(random: &mut Pcg32) -> Vec<Piece> {
    (0..12)
        .map(|surface| Piece {
            alpha: random.range(0.05, 0.95),
            depth: 1.0 + (surface / 3) as f32,
            surface,
            is_back: false,
            coverage: u64::from(random.next_u32()) << 32 | u64::from(random.next_u32()) | 1,
            rgb: Vec3::new(random.next_f32(), random.next_f32(), random.next_f32()),
        })
        .collect()
}

#[test]
fn the_order_of_fragments_does_not_show() {
    let mut random = Pcg32::new(1, 0);
    for samples in [1, 4, 8, 64] {
        for keys in
            ["", "estimator=basic", "estimator=basic,correct=off", "correct=off", "passes=3,masks=naive"]
        {
            let method = format!("stochastic:samples={samples},placement=box,{keys}");
            for frame in 0..20 {
                let mut pieces = pile(&mut random);
                let (rgb, seen) = fill(&method, frame, &pieces);
                for last in (1..pieces.len()).rev() {
                    pieces.swap(last, random.below(last as u32 + 1) as usize);
                }
                let (shuffled, seen_shuffled) = fill(&method, frame, &pieces);
                // Winners are compared exactly, so that the basic estimator has the same bits; sums and
                // products round.
                let rounding = if keys.ends_with("basic,correct=off") { 0.0 } else { 1e-5 };
                assert!((rgb - shuffled).abs().max_element() <= rounding, "{method}: {rgb} {shuffled}");
                let differs = seen.iter().zip(&seen_shuffled).any(|(a, b)| (a - b).abs() > rounding);
                assert!(!differs, "{method}: {seen:?} {seen_shuffled:?}");
            }
        }
    }
}

#[test]
fn a_front_and_a_back_face_of_one_object_draw_masks_of_their_own_and_two_front_faces_do_not() {
    let white =
        Piece { alpha: 0.5, depth: 1.0, surface: 7, is_back: false, coverage: u64::MAX, rgb: Vec3::ONE };
    let black = Piece { depth: 2.0, rgb: Vec3::ZERO, ..white };
    let seen_of_background = |is_back: bool| {
        let pieces = [white, Piece { is_back, ..black }];
        let method = "stochastic:samples=8,seed-by=object,estimator=basic,correct=off";
        let mut seen = Moments::default();
        for frame in 0..2000 {
            seen.add(f64::from(fill(method, frame, &pieces).1.iter().sum::<f32>()) / 8.0);
        }
        seen
    };
    assert!(seen_of_background(true).z(0.25).abs() < 4.0);
    assert_eq!(seen_of_background(false).mean(), 0.5, "identical masks hide one another");
}

#[test]
fn a_pixel_is_seeded_by_what_the_key_says() {
    let piece =
        Piece { alpha: 0.5, depth: 1.0, surface: 7, is_back: false, coverage: u64::MAX, rgb: Vec3::ONE };
    // Which samples are left: in 16 frames two different seeds never agree throughout.
    let masks = |keys: &str, first: u32, piece: Piece| {
        let method = format!("stochastic:samples=16,estimator=basic,correct=off,{keys}");
        (first..first + 16).map(|frame| fill(&method, frame, &[piece]).1).collect::<Vec<_>>()
    };
    let moved = Piece { depth: 1.5, ..piece };
    assert_ne!(masks("seed-by=depth", 0, piece), masks("seed-by=depth", 0, moved));
    for keys in ["seed-by=object", "seed-by=primitive"] {
        assert_eq!(masks(keys, 0, piece), masks(keys, 0, moved), "{keys}");
        assert_ne!(masks(keys, 0, piece), masks(keys, 0, Piece { surface: 8, ..piece }), "{keys}");
    }
    assert_ne!(masks("reseed=on", 0, piece), masks("reseed=on", 16, piece));
    assert_eq!(masks("reseed=off", 0, piece), masks("reseed=off", 16, piece));
}

#[test]
fn passes_share_what_a_fragment_covers_between_them() {
    // Over all passes a fragment covers ⌊αS⌋ samples or one more, whatever the number of passes.
    let piece =
        Piece { alpha: 0.37, depth: 1.0, surface: 7, is_back: false, coverage: u64::MAX, rgb: Vec3::ONE };
    for (samples, passes) in [(4, 2), (8, 8), (1, 16), (3, 5), (64, 64)] {
        let method = format!("stochastic:samples={samples},passes={passes},estimator=basic,correct=off");
        let count = (samples * passes) as f32;
        let mut mean = Moments::default();
        for frame in 0..400 {
            let covered = fill(&method, frame, &[piece]).0.x * count;
            // A step of alpha in ten bits is that many samples.
            let step = count / 1024.0;
            let is_close = (covered - 0.37 * count).abs() < 1.01 + step;
            assert!((covered - covered.round()).abs() < 1e-2 && is_close, "{method}: {covered}");
            mean.add(f64::from(covered));
        }
        assert!(mean.z(f64::from(0.37 * count)).abs() < 4.0, "{method}: {}", mean.mean());
    }
}

#[test]
fn adaptive_passes_end_where_nothing_varies_and_go_on_where_something_does() {
    let alike =
        Piece { alpha: 0.4, depth: 1.0, surface: 0, is_back: false, coverage: u64::MAX, rgb: Vec3::ONE };
    let dark = Piece { depth: 2.0, surface: 1, rgb: Vec3::ZERO, ..alike };
    let passes = |keys: &str, pieces: &[Piece]| {
        struct Count<'a>(&'a [Piece]);
        impl Visitor for Count<'_> {
            type Output = usize;
            fn threshold(self, _: &impl Threshold) -> usize {
                unreachable!("only compositing methods are asked")
            }
            fn selection(self, _: &impl Selection) -> usize {
                unreachable!("only compositing methods are asked")
            }
            fn ordered(self, _: &impl OrderedCompositing) -> usize {
                unreachable!("only compositing methods are asked")
            }

            fn unordered(self, method: &impl UnorderedCompositing) -> usize {
                let site = PixelSite { pixel: [3, 5], frame: 0, seed: 0, depth_range: [1.0, 100.0] };
                let mut pixel = method.begin(&site);
                for pass in 0..method.pass_count() {
                    if method.begin_pass(&mut pixel, pass).is_break() {
                        return pass;
                    }
                    for piece in self.0 {
                        let Piece { alpha, depth, surface, is_back, coverage, rgb } = *piece;
                        let fragment = Fragment {
                            alpha,
                            coverage: coverage & method.samples().all(),
                            depths: &[depth],
                            order: surface,
                            instance: surface,
                            geometry: 0,
                            primitive: 0,
                            is_back,
                        };
                        let _ = method.add(&mut pixel, pass, &fragment, || rgb);
                    }
                }
                method.pass_count()
            }
        }
        format!("stochastic:samples=4,passes=32,{keys}").parse::<Method>().unwrap().visit(Count(pieces))
    };
    // Total alpha, then two passes a round; four rounds at least.
    assert_eq!(passes("adaptive=0.01", &[alike]), 9);
    let few = passes("adaptive=0.03", &[alike, dark]);
    let many = passes("adaptive=0.01", &[alike, dark]);
    assert!(few < many && passes("", &[alike, dark]) == 65, "{few} {many}");
}

#[test]
fn the_ends_of_alpha_are_those_of_a_list() {
    for (alpha, scene) in [(0.0, "layers:count=4,colours=rainbow"), (1.0, "layers:count=4,colours=rainbow")] {
        let scene = format!("{scene},alpha={alpha},background=0.25");
        let mut stage = stage(&scene, None, 2);
        let (exact, _) = render(&mut stage, "list", small(24, 16));
        for keys in [
            "samples=1",
            "samples=64,estimator=basic",
            "correct=off,masks=laine-karras",
            "placement=gaussian",
        ] {
            let (planes, _) = render(&mut stage, &format!("stochastic:{keys}"), small(24, 16));
            assert!(greatest_difference(&exact, &planes) < 1e-5, "{keys} at alpha {alpha}");
        }
    }
}

#[test]
fn sixty_four_samples_of_corrected_depth_come_near_the_exact_picture() {
    let mut stage = stage("smoke-square:particles=400", None, 2);
    let settings = Settings { start_secs: 6.0, ..small(48, 27) };
    let (exact, _) = render(&mut stage, "list", settings);
    let error = |planes: &Planes| {
        let squares = colours(&exact).zip(colours(planes)).map(|(a, b)| (a.rgb - b.rgb).length_squared());
        (squares.sum::<f32>() / (48.0 * 27.0 * 3.0)).sqrt()
    };
    let errors = ["samples=4", "samples=16", "samples=64"]
        .map(|keys| error(&render(&mut stage, &format!("stochastic:{keys}"), settings).0));
    // At least as fast as 1/√S, less what chance may do.
    assert!(errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1], "{errors:?}");
    assert!(errors[2] < 0.01, "{errors:?}");
}

/// Per block of a picture and channel, the z of the mean over many seeds, from the variance between them; the
/// largest.
fn worst_block(stage: &mut Stage, method: &str, reference: &str) -> f64 {
    const SIZE: [u32; 2] = [32, 18];
    const BLOCK_PX: u32 = 6;
    const SEEDS: u32 = 160;
    let settings =
        |seed| Settings { seed, start_secs: 6.0, background: Background::None, ..small(SIZE[0], SIZE[1]) };
    let blocks = |planes: &Planes| {
        let mut sums = vec![[0.0_f64; 3]; 6 * 3];
        for (at, colour) in (0..).zip(colours(planes)) {
            let block = at / SIZE[0] / BLOCK_PX * 6 + at % SIZE[0] / BLOCK_PX;
            for (sum, value) in sums[block as usize].iter_mut().zip(colour.rgb.to_array()) {
                *sum += f64::from(value);
            }
        }
        sums
    };
    let exact = blocks(&render(stage, reference, settings(0)).0);
    let mut moments = vec![[Moments::default(); 3]; exact.len()];
    for seed in 0..SEEDS {
        let found = blocks(&render(stage, method, settings(seed)).0);
        for (moments, found) in moments.iter_mut().zip(found) {
            (0..3).for_each(|channel| moments[channel].add(found[channel]));
        }
    }
    let pairs = moments.iter().flatten().zip(exact.iter().flatten());
    // Blocks without anything transparent differ by rounding or not at all.
    let random = pairs.filter(|(moments, exact)| moments.variance() > 1e-8 * *exact * *exact);
    random.map(|(moments, exact)| moments.z(*exact).abs()).fold(0.0, f64::max)
}

#[test]
fn without_correction_real_scenes_are_right_on_average() {
    // 54 blocks and channels, and Student's distribution with 159 degrees: beyond 4.5 once in two thousand
    // such pictures.
    let mut stage = stage("smoke-square:particles=400", None, 2);
    for keys in [
        "estimator=basic",
        "estimator=depth",
        "estimator=basic,masks=laine-karras",
        "estimator=depth,dither=tile",
    ] {
        let method = format!("stochastic:samples=4,correct=off,{keys}");
        let z = worst_block(&mut stage, &method, "list");
        assert!(z > 0.5 && z < 4.5, "{keys}: z {z}");
    }
    let z = worst_block(&mut stage, "stochastic:samples=4,correct=off,estimator=basic,masks=a2c", "list");
    assert!(z > 8.0, "masks that are always the same pass for unbiased: z {z}");
}

#[test]
fn any_number_of_threads_and_another_trace_for_each_pass_give_the_same_bits() {
    let keys = [
        "",
        ":passes=2,placement=box,estimator=basic",
        ":filter=bilateral,adaptive=0.01,passes=6",
        ":masks=laine-karras",
    ];
    let mut stages = [1, 3].map(|threads| stage("smoke-square:particles=400", None, threads));
    for keys in keys {
        let method = format!("stochastic{keys}");
        let settings = Settings { start_secs: 6.0, ..small(40, 23) };
        let [one, three] = stages.each_mut().map(|stage| render(stage, &method, settings));
        assert_eq!(one, three, "{method}");
        let separator = if keys.is_empty() { ':' } else { ',' };
        let retraced = render(&mut stages[0], &format!("{method}{separator}retrace=on"), settings);
        assert_eq!(retraced.0, one.0, "{method}");
        assert!(retraced.1.camera_rays > one.1.camera_rays, "{method}");
    }
}

#[test]
fn without_a_background_alpha_is_the_share_that_is_covered() {
    let mut stage = stage("plume:particles=200", None, 2);
    let settings = Settings { background: Background::None, ..small(48, 27) };
    let (exact, _) = render(&mut stage, "list", settings);
    let (corrected, _) = render(&mut stage, "stochastic", settings);
    for (colour, exact) in colours(&corrected).zip(colours(&exact)) {
        assert!((colour.alpha - exact.alpha).abs() < 1e-5);
        assert!(exact.alpha > 0.0 || colour == Premul::CLEAR);
    }
    let (basic, _) = render(&mut stage, "stochastic:samples=16,estimator=basic,correct=off", settings);
    assert!(colours(&basic).all(|colour| (colour.alpha * 16.0).fract() < 1e-5), "a share of 16 samples");
    let sum = |planes: &Planes| colours(planes).map(|colour| colour.alpha).sum::<f32>();
    assert!((sum(&basic) / sum(&exact) - 1.0).abs() < 0.02);
}

#[test]
fn samples_spread_over_a_pixel_smooth_the_edges_of_opaque_and_transparent_surfaces() {
    // An animated cube alone before nothing: alpha is its coverage times its opacity.
    let folder =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/gltf/SimpleInstancing/SimpleInstancing.gltf");
    for alpha in [1.0, 0.5] {
        let mut stage = stage(folder, Some(alpha), 2);
        let settings = |width, height| Settings { background: Background::None, ..small(width, height) };
        let (fine, _) = render(&mut stage, "list", settings(320, 192));
        // Means over 8×8 pixels of a finer picture.
        let coarse = |x: u32, y: u32| {
            let places = (0..64).map(|at| (x * 8 + at % 8, y * 8 + at / 8));
            places.map(|place| fine.colour[place][3]).sum::<f32>() / 64.0
        };
        let mut error = |method: &str| {
            let (planes, _) = render(&mut stage, method, settings(40, 24));
            let places = (0..24).flat_map(|y| (0..40).map(move |x| (x, y)));
            let squares = places.map(|(x, y)| (planes.colour[(x, y)][3] - coarse(x, y)).powi(2));
            (squares.sum::<f32>() / 960.0).sqrt()
        };
        let [centre, eight, many] = ["placement=centre", "placement=box", "placement=box,samples=64"]
            .map(|keys| error(&format!("stochastic:{keys}")));
        assert!(eight < 0.4 * centre && many < 0.5 * eight, "alpha {alpha}: {centre}, {eight}, {many}");
    }
}

#[test]
fn a_bilateral_filter_takes_noise_away() {
    let mut stage = stage("layers:count=8,alpha=0.2,colours=rainbow,background=0.25", None, 2);
    let (exact, _) = render(&mut stage, "list", small(48, 27));
    let mut error = |filter: &str| {
        let method = format!("stochastic:samples=4,filter={filter}");
        let (planes, _) = render(&mut stage, &method, small(48, 27));
        let pairs = colours(&exact).zip(colours(&planes));
        pairs.map(|(a, b)| (a.rgb - b.rgb).length_squared()).sum::<f32>().sqrt()
    };
    let [noisy, filtered] = ["none", "bilateral"].map(&mut error);
    // Total alpha is the same everywhere: a plain Gaussian, which leaves 0.28 of the deviation of independent
    // pixels, more at the border.
    assert!(filtered < 0.4 * noisy && filtered > 0.2 * noisy, "{filtered} of {noisy}");
}

#[test]
fn laine_and_karras_spread_the_error_over_neighbours() {
    // Means over blocks of 8×8 pixels: stratified neighbours make up for one another.
    let mut stage = stage("layers:count=1,alpha=0.45,colours=white,background=0", None, 2);
    let mut deviation = |masks: &str| {
        let mut values = Moments::default();
        for seed in 0..8 {
            let settings = Settings { seed, ..small(64, 64) };
            let method = format!("stochastic:samples=4,estimator=basic,correct=off,seed-by=object,{masks}");
            let (planes, _) = render(&mut stage, &method, settings);
            for block in 0..64 {
                let (left, top) = (block % 8 * 8, block / 8 * 8);
                let places = (0..64).map(|at| (left + at % 8, top + at / 8));
                let sum: f32 = places.map(|place| planes.colour[place][0]).sum();
                values.add(f64::from(sum / 64.0));
            }
        }
        assert!((values.mean() - 0.45).abs() < 0.01, "{masks}: {}", values.mean());
        values.variance().sqrt()
    };
    let random = deviation("masks=stratified");
    for masks in ["masks=laine-karras", "dither=tile"] {
        let spread = deviation(masks);
        assert!(spread < 0.4 * random, "{masks}: {spread} of {random}");
    }
}

#[test]
fn laine_and_karras_spread_the_error_over_layers_that_come_front_to_back() {
    let pieces: Vec<Piece> = (0..8)
        .map(|surface| Piece {
            alpha: 0.25,
            depth: 1.0 + surface as f32,
            surface,
            is_back: false,
            coverage: u64::MAX,
            rgb: Vec3::ONE,
        })
        .collect();
    let deviation = |masks: &str| {
        let method = format!("stochastic:samples=16,estimator=basic,correct=off,masks={masks}");
        let mut seen = Moments::default();
        (0..4000).for_each(|frame| seen.add(f64::from(fill(&method, frame, &pieces).0.x)));
        assert!(seen.z(1.0 - 0.75_f64.powi(8)).abs() < 4.0, "{masks}: {}", seen.mean());
        seen.variance().sqrt()
    };
    let [own, stratified] = ["laine-karras", "stratified"].map(deviation);
    assert!(own < 0.8 * stratified, "{own} of {stratified}");
}

//! The family of compositing methods on fragments of our own making, in any order, and on scenes whose answer
//! is known.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::iter;

use glam::Vec3;
use proptest::prelude::{Strategy, prop, prop_assert, proptest};
use sheer_core::hash::Pcg32;
use sheer_gallery::{LayerColours, layers_closed_form};
use sheer_image::Planes;
use sheer_render::{
    Antialiasing, Counters, Method, Pipeline, Settings, Stage,
    contract::{
        Fragment, MIN_VISIBILITY, Memory, OrderedCompositing, PixelSite, Selection, Threshold,
        UnorderedCompositing, Visitor,
    },
    method::{Family, variants},
};
use sheer_scene::CameraChoice;

/// No fragment is nearer or further, scene units.
const DEPTH_RANGE: [f32; 2] = [1.0, 20.0];
/// What sums and products of some dozen 32-bit terms may be off by.
const ROUNDING: f32 = 2e-5;

/// Every method whose fragments come in any order and whose answer is no matter of chance, with its defaults
/// and with each word of its own choices.
fn family() -> Vec<String> {
    let is_certain = |method: &Method| method.family() == Family::Unordered && !method.visit(IsRandom);
    let family: Vec<String> = variants().filter(is_certain).map(|method| method.to_string()).collect();
    assert!(family.len() > 7, "{family:?}");
    family
}

struct IsRandom;

impl Visitor for IsRandom {
    type Output = bool;

    fn threshold(self, _: &impl Threshold) -> bool {
        panic!("no compositing method")
    }

    fn selection(self, _: &impl Selection) -> bool {
        panic!("no compositing method")
    }

    fn ordered(self, _: &impl OrderedCompositing) -> bool {
        panic!("no compositing method")
    }

    fn unordered(self, method: &impl UnorderedCompositing) -> bool {
        method.is_random()
    }
}

/// A fragment without a scene.
#[derive(Clone, Copy, Debug)]
struct Made {
    depth: f32,
    order: u32,
    alpha: f32,
    rgb: Vec3,
}

/// What comes of fragments, handed over in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Filled {
    rgb: Vec3,
    transmittance: f32,
    merged_count: u32,
}

struct Fill<'a>(&'a [Made]);

impl Visitor for Fill<'_> {
    type Output = Filled;

    fn threshold(self, _: &impl Threshold) -> Filled {
        panic!("no compositing method")
    }

    fn selection(self, _: &impl Selection) -> Filled {
        panic!("no compositing method")
    }

    fn ordered(self, _: &impl OrderedCompositing) -> Filled {
        panic!("no compositing method")
    }

    fn unordered(self, method: &impl UnorderedCompositing) -> Filled {
        let mut pixel =
            method.begin(&PixelSite { pixel: [3, 5], frame: 0, seed: 0, depth_range: DEPTH_RANGE });
        for pass in 0..method.pass_count() {
            if method.begin_pass(&mut pixel, pass).is_break() {
                break;
            }
            let _ = self.0.iter().try_for_each(|made| {
                let fragment = Fragment {
                    alpha: made.alpha,
                    coverage: 1,
                    depths: &[made.depth],
                    order: made.order,
                    instance: 0,
                    geometry: 0,
                    primitive: made.order,
                    is_back: false,
                };
                method.add(&mut pixel, pass, &fragment, || made.rgb)
            });
        }
        Filled {
            rgb: method.resolve(&pixel),
            transmittance: method.transmittance(&pixel, 0),
            merged_count: method.merged_count(&pixel),
        }
    }
}

struct IsOrderIndependent;

impl Visitor for IsOrderIndependent {
    type Output = bool;

    fn threshold(self, _: &impl Threshold) -> bool {
        panic!("no compositing method")
    }

    fn selection(self, _: &impl Selection) -> bool {
        panic!("no compositing method")
    }

    fn ordered(self, _: &impl OrderedCompositing) -> bool {
        panic!("no compositing method")
    }

    fn unordered(self, method: &impl UnorderedCompositing) -> bool {
        method.is_order_independent()
    }
}

fn fill(method: &str, fragments: &[Made]) -> Filled {
    method.parse::<Method>().unwrap().visit(Fill(fragments))
}

/// Sorted and blended by the definition of OVER, in 64 bits.
fn exact(fragments: &[Made]) -> (Vec3, f32) {
    let mut sorted = fragments.to_vec();
    sorted.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.order.cmp(&b.order)));
    let blended = sorted.iter().fold((glam::DVec3::ZERO, 1.0), |(rgb, visibility), made| {
        let alpha = f64::from(made.alpha);
        (rgb + visibility * alpha * made.rgb.as_dvec3(), visibility * (1.0 - alpha))
    });
    (blended.0.as_vec3(), blended.1 as f32)
}

fn error(method: &str, fragments: &[Made]) -> f32 {
    (fill(method, fragments).rgb - exact(fragments).0).abs().max_element()
}

/// Fragments at depths of which some coincide.
fn stacks(count: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<Made>> {
    let fragment = (4_u32..80, 0.01_f32..0.99, prop::array::uniform3(0.0_f32..1.0));
    prop::collection::vec(fragment, count).prop_map(|fragments| {
        let made = fragments.into_iter().zip(0..).map(|((depth, alpha, rgb), order)| Made {
            depth: 0.25 * depth as f32,
            order,
            alpha,
            rgb: rgb.into(),
        });
        made.collect()
    })
}

fn random_stack(random: &mut Pcg32, count: u32, alphas: [f32; 2]) -> Vec<Made> {
    let made = |order| Made {
        depth: random.range(DEPTH_RANGE[0], DEPTH_RANGE[1]),
        order,
        alpha: random.range(alphas[0], alphas[1]),
        rgb: Vec3::new(random.range(0.0, 1.0), random.range(0.0, 1.0), random.range(0.0, 1.0)),
    };
    (0..count).map(made).collect()
}

fn shuffled(fragments: &[Made], random: &mut Pcg32) -> Vec<Made> {
    let mut keyed: Vec<(f32, Made)> = fragments.iter().map(|made| (random.range(0.0, 1.0), *made)).collect();
    keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
    keyed.into_iter().map(|(_, made)| made).collect()
}

proptest! {
    #[test]
    fn one_fragment_is_exact_for_every_method(stack in stacks(1..=1)) {
        for method in &family() {
            let filled = fill(method, &stack);
            prop_assert!(error(method, &stack) < ROUNDING, "{method}: {filled:?}");
            prop_assert!(filled.merged_count == 0, "{method}");
        }
    }

    #[test]
    fn as_many_fragments_as_there_are_places_are_exact(stack in stacks(0..=12)) {
        let places = stack.len().max(1);
        for method in [
            "list".to_owned(),
            format!("peel:layers={places}"),
            format!("kbuffer:k={places}"),
            format!("mlab:k={places}"),
            format!("adaptive:nodes={}", places.max(2)),
        ] {
            prop_assert!(error(&method, &stack) < ROUNDING, "{method}: {}", error(&method, &stack));
            prop_assert!(fill(&method, &stack).merged_count == 0, "{method}");
        }
    }

    /// Nothing is dropped: the background is seen by the product of all transmittances, though places are too
    /// few. But for peeling, where it is that of the layers drawn.
    #[test]
    fn the_background_is_exact_for_every_method_but_peeling(stack in stacks(0..=40)) {
        for method in &family() {
            let mut drawn = stack.clone();
            if method.starts_with("peel") {
                drawn.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.order.cmp(&b.order)));
                drawn.truncate(method.parse::<Method>().unwrap().value("layers").parse().unwrap());
            }
            let (expected, found) = (exact(&drawn).1, fill(method, &stack).transmittance);
            prop_assert!((found - expected).abs() < ROUNDING, "{method}: {found}, not {expected}");
        }
    }

    /// What these show is a mean of the colours, by weights of their own.
    #[test]
    fn blended_colours_lie_between_those_of_the_fragments(stack in stacks(1..=40)) {
        let least = stack.iter().map(|made| made.rgb).reduce(Vec3::min).unwrap();
        let most = stack.iter().map(|made| made.rgb).reduce(Vec3::max).unwrap();
        for method in family().iter().filter(|method| !method.starts_with("adaptive")) {
            let Filled { rgb, transmittance, .. } = fill(method, &stack);
            let opacity = 1.0 - transmittance;
            let inside = (rgb - opacity * least + ROUNDING).min_element() >= 0.0
                && (opacity * most - rgb + ROUNDING).min_element() >= 0.0;
            prop_assert!(inside, "{method}: {rgb} of opacity {opacity}, {least} to {most}");
        }
    }

    /// Steps are joined towards the eye, so a fragment is never seen by more than its share.
    #[test]
    fn adaptive_transparency_never_shows_too_much(stack in stacks(1..=40)) {
        let found = fill("adaptive:nodes=3", &stack).rgb;
        let excess = (found - exact(&stack).0).max_element();
        prop_assert!(excess < ROUNDING && found.min_element() >= 0.0, "{excess}");
    }

    /// Of k layers all but the last are the nearest fragments: the error is at most what is seen behind those
    /// of the colours there.
    #[test]
    fn an_overflow_errs_only_behind_the_nearest(stack in stacks(1..=40)) {
        let mut sorted = stack.clone();
        sorted.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.order.cmp(&b.order)));
        for (method, kept) in [("mlab:k=3", 2), ("mlab:k=8", 7), ("peel:layers=3", 3)] {
            let near = &sorted[..kept.min(sorted.len())];
            let bound = exact(near).1;
            prop_assert!(error(method, &stack) <= bound + ROUNDING, "{method}: {} {bound}", error(method, &stack));
        }
    }

    #[test]
    fn fragments_without_a_place_are_counted(stack in stacks(0..=40)) {
        for (method, places) in [
            ("list", 40),
            ("peel:layers=3", 40),
            ("kbuffer:k=3", 3),
            ("mlab:k=5", 5),
            ("adaptive:nodes=4", 4),
            ("weighted", 1),
            ("moments", 1),
        ] {
            let expected = stack.len().saturating_sub(places) as u32;
            prop_assert!(fill(method, &stack).merged_count == expected, "{method}");
        }
    }
}

#[test]
fn without_a_fragment_nothing_is_there() {
    for method in &family() {
        let nothing = Filled { rgb: Vec3::ZERO, transmittance: 1.0, merged_count: 0 };
        assert_eq!(fill(method, &[]), nothing, "{method}");
    }
}

#[test]
fn opacities_next_to_both_ends_and_depths_at_both_ends_give_numbers() {
    let mut random = Pcg32::new(3, 0);
    let mut stack = random_stack(&mut random, 24, [0.01, 0.02]);
    for (at, made) in stack.iter_mut().enumerate() {
        made.depth = DEPTH_RANGE[at % 2];
        made.alpha = [0.01, 1.0_f32.next_down(), 0.5][at % 3];
    }
    for method in &family() {
        for count in 1..=stack.len() {
            let filled = fill(method, &stack[..count]);
            assert!(
                filled.rgb.is_finite() && filled.rgb.max_element() <= 1.0 + ROUNDING,
                "{method}: {filled:?}"
            );
            assert!((0.0..=1.0).contains(&filled.transmittance), "{method}: {filled:?}");
        }
    }
}

#[test]
fn shuffled_fragments_give_the_same_pixel_where_the_method_says_so() {
    let mut random = Pcg32::new(5, 0);
    for method in &family() {
        let mut worst = 0.0_f32;
        for _ in 0..100 {
            let stack = random_stack(&mut random, 24, [0.05, 0.5]);
            let first = fill(method, &stack);
            for _ in 0..4 {
                let other = fill(method, &shuffled(&stack, &mut random));
                let difference = (other.rgb - first.rgb).abs().max_element();
                worst = worst.max(difference).max((other.transmittance - first.transmittance).abs());
                assert_eq!(other.merged_count, first.merged_count, "{method}");
            }
        }
        let bound = match method.as_str() {
            // Sorted before anything is added up.
            method if method.starts_with("list") || method.starts_with("peel") => 0.0,
            // The reconstruction multiplies the rounding of its moments by up to the inverse of their bias
            // (5e-7), of which little is left where fragments are many.
            method if method.starts_with("moments") => 5e-3,
            _ => ROUNDING,
        };
        if method.parse::<Method>().unwrap().visit(IsOrderIndependent) {
            assert!(worst <= bound, "{method}: {worst}");
        } else {
            assert!(worst > 0.02, "{method} does depend on order, the check is blind: {worst}");
        }
    }
}

#[test]
fn two_fragments_are_exact_for_all_but_means() {
    let mut random = Pcg32::new(9, 0);
    let two = |alphas: [f32; 2]| {
        let made = |at: usize, rgb| Made { depth: [2.0, 9.0][at], order: at as u32, alpha: alphas[at], rgb };
        [made(1, Vec3::Y), made(0, Vec3::X)]
    };
    for _ in 0..100 {
        let alphas = [random.range(0.02, 0.95), random.range(0.02, 0.95)];
        let stack = two(alphas);
        for method in ["list", "peel:layers=2", "kbuffer:k=1", "mlab:k=2", "adaptive:nodes=2"] {
            assert!(error(method, &stack) < ROUNDING, "{method} {alphas:?}");
        }
        let [front, back] = alphas;
        let opacity = front + back - front * back;
        let ratio_of = |method: &str| {
            let rgb = fill(method, &stack).rgb;
            assert!(
                (rgb.x + rgb.y - opacity).abs() < ROUNDING,
                "{method} {alphas:?}: the rest is background"
            );
            rgb.y / rgb.x * front / back
        };
        // What is seen of the back for the front, by weights of α·f(z).
        let eq7 = |z: f32| 10.0 / (1e-5 + (z / 5.0).powi(2) + (z / 200.0).powi(6));
        let expected = back / front * eq7(9.0) / eq7(2.0);
        assert!((ratio_of("weighted") / expected - 1.0).abs() < 1e-3, "{alphas:?}");
        // A quarter of a fragment's own absorbance hides it: between both lie three quarters of the front's
        // and one of the back's. That is the front's, and exact, where both are equal.
        for order in [4, 6, 8] {
            let expected = (1.0 - front).powf(0.75) * (1.0 - back).powf(0.25);
            let found = ratio_of(&format!("moments:order={order}"));
            assert!((found - expected).abs() < 0.01, "order {order} {alphas:?}: {found}, not {expected}");
        }
    }
    for order in [4, 6, 8] {
        let method = format!("moments:order={order}");
        assert!(
            error(&method, &two([0.4, 0.4])) < 2e-3 && error(&method, &two([0.1, 0.9])) > 0.01,
            "{method}"
        );
    }
}

/// Root mean square error over random stacks of 24 fragments.
fn stack_error(method: &str) -> f32 {
    let mut random = Pcg32::new(21, 0);
    let squares = (0..400).map(|_| {
        let stack = random_stack(&mut random, 24, [0.05, 0.6]);
        (fill(method, &stack).rgb - exact(&stack).0).length_squared()
    });
    (squares.sum::<f32>() / 1200.0).sqrt()
}

#[test]
fn each_method_comes_nearer_with_more_of_what_it_has() {
    let with = |pattern: &str, values: &[u32]| {
        let errors = values.iter().map(|value| stack_error(&pattern.replace('#', &value.to_string())));
        errors.collect::<Vec<f32>>()
    };
    for (pattern, values) in [
        ("peel:layers=#", &[1, 2, 4, 8, 16, 24][..]),
        ("kbuffer:k=#", &[1, 2, 4, 8, 16, 24]),
        ("mlab:k=#", &[1, 2, 4, 8, 16, 24]),
        ("adaptive:nodes=#", &[2, 4, 8, 16, 24]),
        ("moments:order=#", &[4, 6, 8]),
    ] {
        let errors = with(pattern, values);
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{pattern}: {errors:?}");
        if values.ends_with(&[24]) {
            assert!(errors[values.len() - 1] < 1e-5 && errors[0] > 0.02, "{pattern}: {errors:?}");
        }
    }
}

/// Renders one frame.
fn picture(scene: &str, method: &str) -> (Planes, Counters) {
    let scene = sheer_gallery::open(scene).unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    picture_of(&mut stage, method)
}

fn picture_of(stage: &mut Stage, method: &str) -> (Planes, Counters) {
    let settings = Settings { size: [48, 27], start_secs: 6.0, ..Settings::default() };
    let mut pipeline = Pipeline::new(method.parse().unwrap(), Antialiasing::NONE, settings).unwrap();
    stage.advance(pipeline.clock().at(0));
    let (counters, _) = pipeline.render(stage, 0).unwrap();
    (pipeline.planes().clone(), counters)
}

fn worst_difference(planes: &Planes, others: impl Iterator<Item = Vec3>) -> f32 {
    let colours = planes.colour.as_slice().iter().map(|&[r, g, b, _]| Vec3::new(r, g, b));
    colours.zip(others).map(|(colour, other)| (colour - other).abs().max_element()).fold(0.0, f32::max)
}

#[test]
fn stacked_layers_come_within_the_bound_of_each_method() {
    for (count, alpha) in [(1, 0.3), (2, 0.45), (6, 0.7), (8, 0.3), (20, 0.1)] {
        for (word, colours) in [
            ("white", LayerColours::White),
            ("rainbow", LayerColours::Rainbow),
            ("red-green", LayerColours::RedGreen),
        ] {
            let scene = format!("layers:count={count},alpha={alpha},colours={word},background=0.25");
            let expected = layers_closed_form(count, alpha, colours, 0.25);
            let seen_behind = |layers: u32| (1.0_f32 - alpha).powi(layers.min(count) as i32);
            let beyond = |layers: u32| seen_behind(layers) - seen_behind(count);
            let opacity = beyond(0);
            let is_one_colour = count == 1 || colours == LayerColours::White;
            let mean = if is_one_colour { 0.0 } else { opacity };
            for (method, bound) in [
                ("list", 0.0),
                // The background for what lies behind the last layer: up to all of what is seen there.
                ("peel:layers=4", beyond(4)),
                // What lies behind the layers that keep their places may be mixed up, where it has several
                // colours.
                ("mlab:k=4", if is_one_colour { 0.0 } else { beyond(3) }),
                // One step holds it all in the worst case, which hides each layer by all others.
                ("adaptive:nodes=4", if count <= 4 { 0.0 } else { opacity }),
                // Means: of one colour they are that colour; of several, whatever of them.
                ("kbuffer:k=4", if count <= 5 { 0.0 } else { mean }),
                ("weighted", mean),
                ("moments:order=4", mean),
                ("moments:order=8", mean),
            ] {
                let worst = worst_difference(&picture(&scene, method).0, iter::repeat(expected));
                // The backend leaves out a background that is seen by less than its least visibility.
                let slack = ROUNDING + 0.25 * MIN_VISIBILITY;
                assert!(worst <= bound + slack, "{scene} {method}: {worst}, bound {bound}");
            }
        }
    }
}

#[test]
fn where_nothing_overflows_a_scene_looks_as_with_lists() {
    let scene = sheer_gallery::open("smoke-square:particles=200").unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap();
    let (listed, _) = picture_of(&mut stage, "list");
    let reference: Vec<Vec3> =
        listed.colour.as_slice().iter().map(|&[r, g, b, _]| Vec3::new(r, g, b)).collect();
    let mut error = |method: &str| {
        let (planes, counters) = picture_of(&mut stage, method);
        assert_eq!(planes.depth, listed.depth, "{method}");
        (worst_difference(&planes, reference.iter().copied()), counters.merged)
    };
    for method in ["peel:layers=64", "kbuffer:k=32", "mlab:k=32", "adaptive:nodes=32"] {
        let (worst, merged) = error(method);
        assert!(worst < ROUNDING && merged == 0, "{method}: {worst}, {merged} merged");
    }
    for method in ["peel:layers=1", "kbuffer:k=1", "mlab:k=1", "adaptive:nodes=2", "weighted", "moments"] {
        let (worst, merged) = error(method);
        assert!(worst > 50.0 * ROUNDING, "{method}: {worst}: the check is blind");
        assert_eq!(merged > 0, !method.starts_with("peel"), "{method}");
    }
}

#[test]
fn passes_that_trace_anew_give_the_same_picture_for_more_rays() {
    let pixels = 48 * 27;
    for (method, passes) in [("peel:layers=4", 4), ("adaptive", 2), ("moments", 2)] {
        let scene = "layers:count=6,alpha=0.3,colours=rainbow";
        let (kept, once) = picture(scene, method);
        let separator = if method.contains(':') { ',' } else { ':' };
        let (traced, anew) = picture(scene, &format!("{method}{separator}retrace=on"));
        assert_eq!(kept, traced, "{method}");
        assert_eq!((once.camera_rays, anew.camera_rays), (pixels, passes * pixels), "{method}");
    }
    // Passes end when nothing is left: two that find a layer, one that finds none.
    let (_, counters) = picture("layers:count=2,alpha=0.3", "peel:layers=64,retrace=on");
    assert_eq!(counters.camera_rays, 3 * pixels);
}

#[test]
fn memory_is_bounded_for_all_but_lists() {
    for method in &family() {
        let memory = method.parse::<Method>().unwrap().memory();
        assert_eq!(matches!(memory, Memory::PerFragment(16)), method == "list", "{method}: {memory:?}");
    }
    let bytes = |method: &str| method.parse::<Method>().unwrap().memory();
    assert_eq!(
        [4, 6, 8].map(|order| bytes(&format!("moments:order={order}"))),
        [28, 36, 44].map(Memory::Bounded)
    );
    assert_eq!(bytes("mlab:k=8"), Memory::Bounded(96));
    assert_eq!(bytes("std"), Memory::Bounded(0));
}

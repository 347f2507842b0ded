//! Shader functions held against their CPU twins, on many random inputs and on whatever adapter there is.
//!
//! Integers have to be equal bit by bit. Floats may differ where WGSL lets them: a division is within 2.5 ulp
//! (WGSL, section 15.7.4), a product and a sum may be fused. Sines and logarithms have no bits that two
//! devices share.

use bytemuck::Zeroable as _;
use glam::{UVec2, Vec3};
use sheer_core::{
    coverage::Correction,
    hash::{Pcg32, mcguire3, pcg, pcg2d, pcg3d, pcg4d, unit_from_bits},
    mask,
};
use sheer_render::{
    Method,
    contract::{self, OrderedCompositing, Selection, Site, Threshold, UnorderedCompositing, Visitor},
    method::Family,
};
use sheer_scene::{CameraPose, ClipPlanes, Lens};
use wgpu::{BufferBindingType, BufferUsages};

use super::harness::{self, COMPUTE, is_software};
use crate::{
    resource::bind_group::{buffer_entry, read_only_entry, whole},
    shader::{
        Linker,
        binding::{BIND_FRAME, BIND_PROBE_IN, BIND_PROBE_OUT, BIND_TABLES},
        constant::Constant,
        linked::Linked,
        numbers::PROBE_GROUP,
        record::frame::FrameUniform,
    },
    tables::Tables,
};

/// Inputs of a probe.
const COUNT: usize = 1 << 16;

/// What a probe writes for its inputs: `words_out` for each.
fn run(shader: &Linked, tables: &Tables, input: &[u32], words_out: usize) -> Vec<u32> {
    run_in(&FrameUniform::zeroed(), shader, tables, input, words_out)
}

/// The same where a probe asks for what a frame is rendered with.
fn run_in(
    frame: &FrameUniform,
    shader: &Linked,
    tables: &Tables,
    input: &[u32],
    words_out: usize,
) -> Vec<u32> {
    let uniform = buffer_entry(BIND_FRAME, COMPUTE, BufferBindingType::Uniform);
    let written = buffer_entry(BIND_PROBE_OUT, COMPUTE, BufferBindingType::Storage { read_only: false });
    let layouts = [
        [uniform, read_only_entry(BIND_TABLES, COMPUTE)],
        [read_only_entry(BIND_PROBE_IN, COMPUTE), written],
    ];
    let pipeline = harness::pipeline(shader, &layouts.each_ref().map(|entries| &entries[..]));
    let frame = harness::buffer(bytemuck::bytes_of(frame), BufferUsages::UNIFORM);
    let storage = |words: &[u32]| harness::buffer(bytemuck::cast_slice(words), BufferUsages::STORAGE);
    let (input, tables) = (storage(input), storage(&tables.words));
    let output = harness::results(4 * COUNT * words_out);
    let groups = [
        [whole(BIND_FRAME, &frame), whole(BIND_TABLES, &tables)],
        [whole(BIND_PROBE_IN, &input), whole(BIND_PROBE_OUT, &output)],
    ];
    let groups = groups.each_ref().map(|entries| &entries[..]);
    bytemuck::pod_collect_to_vec(&harness::run(&pipeline, &groups, COUNT as u32 / PROBE_GROUP, &output))
}

/// Random words, the same in each run.
fn random_words(count: usize) -> Vec<u32> {
    let mut random = Pcg32::new(14, count as u64);
    (0..count).map(|_| random.next_u32()).collect()
}

/// Of each column of `width`, in how many rows two results differ.
fn differences<const WIDTH: usize>(one: &[u32], other: &[[u32; WIDTH]]) -> [usize; WIDTH] {
    assert_eq!(one.len(), other.len() * WIDTH);
    let rows = || one.chunks_exact(WIDTH).zip(other);
    std::array::from_fn(|column| rows().filter(|(row, other)| row[column] != other[column]).count())
}

/// Units in the last place between two positive floats.
fn ulps(one: u32, other: u32) -> u32 {
    one.abs_diff(other)
}

/// The first `count` of these, without the last one, which rests on a sine.
const HASH_COLUMNS: usize = 14;

fn hashes(v: [u32; 4]) -> [u32; HASH_COLUMNS] {
    let [x, y, z, _] = v;
    let ([a, b], [c, d, e], [f, g, h, i]) = (pcg2d([x, y]), pcg3d([x, y, z]), pcg4d(v));
    let product = (u64::from(x) * u64::from(y)) >> 32;
    let sine = mcguire3(Vec3::from([x, y, z].map(|number| (number % 1000) as f32)));
    [
        pcg(x),
        a,
        b,
        c,
        d,
        e,
        f,
        g,
        h,
        i,
        unit_from_bits(x).to_bits(),
        product as u32,
        x.rotate_left(16),
        sine.to_bits(),
    ]
}

#[test]
fn hashes_are_those_of_the_cpu_bit_by_bit() {
    let input = random_words(4 * COUNT);
    let expected: Vec<_> = input.as_chunks().0.iter().map(|v| hashes(*v)).collect();
    let tables = Tables::new(&[], [0, 0]);
    let shader = Linker::new().link("probe/hash").unwrap();
    let differ = differences(&run(&shader, &tables, &input, HASH_COLUMNS), &expected);
    assert_eq!(differ[..HASH_COLUMNS - 1], [0; HASH_COLUMNS - 1]);
    // Negative control: another multiplier changes all hashes that have it, and no other column.
    let line = |value: u32| Constant::new("LCG_MULTIPLIER", value).to_string();
    let (right, wrong) = (line(sheer_core::hash::LCG_MULTIPLIER), line(sheer_core::hash::LCG_MULTIPLIER + 4));
    assert!(shader.text.contains(&right));
    let mut slip = shader.clone();
    slip.text = shader.text.replace(&right, &wrong);
    let off = differences(&run(&slip, &tables, &input, HASH_COLUMNS), &expected);
    assert!(off[1..10].iter().all(|count| *count > COUNT / 2), "{off:?}");
    assert_eq!((off[0], &off[10..13]), (0, &[0; 3][..]));
}

/// The bits of the sine hash differ from device to device; that it is uniform does not.
#[test]
fn the_sine_hash_is_uniform_on_the_device_too() {
    let input = random_words(4 * COUNT);
    let shader = Linker::new().link("probe/hash").unwrap();
    let words = run(&shader, &Tables::new(&[], [0, 0]), &input, HASH_COLUMNS);
    let values = words.chunks_exact(HASH_COLUMNS).map(|row| f32::from_bits(row[HASH_COLUMNS - 1]));
    assert!(uniformity_z(values.clone()).abs() < 5.0, "z {}", uniformity_z(values.clone()));
    assert!(uniformity_z(values.map(|value| value * value)).abs() > 5.0, "the check is blind");
}

/// Standard deviations by which the chi-square statistic of 64 equally likely bins exceeds its mean.
fn uniformity_z(values: impl Iterator<Item = f32>) -> f64 {
    let mut counts = [0_u32; 64];
    values.for_each(|value| {
        assert!((0.0..1.0).contains(&value), "{value}");
        counts[(value * 64.0) as usize] += 1;
    });
    let expected = f64::from(counts.iter().sum::<u32>()) / 64.0;
    let chi_square: f64 = counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
    (chi_square - 63.0) / (2.0 * 63.0_f64).sqrt()
}

fn masks(samples: u32, [x, y, z, w]: [u32; 4]) -> [u32; 6] {
    let alpha = mask::quantised_alpha(unit_from_bits(x), y);
    let size = mask::set_size(alpha, samples, z >> (u32::BITS - mask::ALPHA_BITS));
    [
        alpha,
        size,
        mask::coin_mask(alpha, [z, w]) as u32,
        mask::mask_table(samples).pick(size, w) as u32,
        mask::along_curve([x, y]),
        mask::stratified_threshold(x, y),
    ]
}

#[test]
fn masks_are_those_of_the_cpu_bit_by_bit() {
    let input = random_words(4 * COUNT);
    for samples in [1, 4, 8, 31, 32] {
        let expected: Vec<_> = input.as_chunks().0.iter().map(|v| masks(samples, *v)).collect();
        let tables = Tables::new(&[], [samples, 0]);
        let shader = Linker::new().constants(tables.constants()).link("probe/mask").unwrap();
        assert_eq!(differences(&run(&shader, &tables, &input, 6), &expected), [0; 6], "{samples} samples");
        // Negative control: with another table only what comes from it differs.
        let mut other = tables.clone();
        other.words.iter_mut().for_each(|word| *word = !*word);
        let off = differences(&run(&shader, &other, &input, 6), &expected);
        assert!(off[3] > COUNT / 4 && off[..3] == [0; 3] && off[4..] == [0; 2], "{samples} samples: {off:?}");
    }
}

#[test]
fn opacities_are_decided_upon_as_on_the_cpu() {
    // Opacities from below 0 to above 1, both ends and the least that counts among them.
    let mut input: Vec<u32> = random_words(2 * COUNT)
        .into_iter()
        .map(|bits| (unit_from_bits(bits) * 1.2 - 0.1).to_bits())
        .collect();
    for (index, alpha) in
        [0.0, 1.0, contract::MIN_ALPHA, contract::MIN_ALPHA.next_down()].into_iter().enumerate()
    {
        input[2 * index] = alpha.to_bits();
    }
    for correction in [Correction::NONE, Correction::DLSS, Correction::new([-0.5, 3.0, 0.0, 0.0]).unwrap()] {
        let expected: Vec<[f32; 2]> =
            input.as_chunks().0.iter().map(|pair: &[u32; 2]| pair.map(f32::from_bits)).collect();
        let method = "std".parse::<Method>().unwrap().with_correction(correction, "std");
        let shader = Linker::new().method(&method).link("probe/decide").unwrap();
        let rows = run(&shader, &Tables::new(&[], [0, 0]), &input, 2);
        for (row, [alpha, threshold]) in rows.chunks_exact(2).zip(expected) {
            let (coverage, wanted) = (f32::from_bits(row[0]), correction.coverage(alpha));
            // Three products and sums, fused or not: three roundings of numbers up to 3.
            let bound = if correction == Correction::NONE { 0.0 } else { 3.0 * 2.0 * f32::EPSILON };
            assert!((coverage - wanted).abs() <= bound, "{correction:?} of {alpha}: {coverage}, {wanted}");
            assert_eq!(row[1] == 1, contract::keeps(alpha, || threshold), "{alpha} against {threshold}");
        }
    }
}

/// A ray's last bit decides which of two surfaces is in front that lie in one plane, so that the rays have to
/// be the same.
#[test]
fn rays_of_the_camera_are_those_of_the_cpu() {
    const SIZE: [u32; 2] = [331, 187];
    let mut random = Pcg32::new(16, 0);
    let input: Vec<u32> =
        (0..COUNT).flat_map(|_| SIZE.map(|side| random.range(0.0, side as f32).to_bits())).collect();
    let [eye, target] = [Vec3::new(3.1, 1.7, -5.3), Vec3::new(-0.4, 0.9, 2.2)];
    let poses = [Lens::Perspective { yfov_rad: 0.7 }, Lens::Orthographic { half_height: 2.3 }]
        .map(|lens| CameraPose::looking_at(lens, eye, target))
        .map(|pose| CameraPose { clip: ClipPlanes { near: 0.3, far: 9.1 }, ..pose });
    for pose in &poses {
        let frame = FrameUniform {
            camera: pose.into(),
            size: SIZE.into(),
            inverse_height: (SIZE[1] as f32).recip(),
            ..FrameUniform::zeroed()
        };
        let shader = Linker::new().alias("limit", "shared/limit_none").link("probe/camera").unwrap();
        let rows = run_in(&frame, &shader, &Tables::new(&[], [0, 0]), &input, 8);
        let expected: Vec<[u32; 8]> = input
            .as_chunks()
            .0
            .iter()
            .map(|sample: &[u32; 2]| {
                let ray = pose.ray(sample.map(f32::from_bits).into(), UVec2::from(SIZE).as_vec2());
                let [ox, oy, oz] = ray.origin.to_array();
                let [x, y, z] = ray.direction.to_array();
                [ox, oy, oz, x, y, z, ray.nearest, ray.furthest].map(f32::to_bits)
            })
            .collect();
        let differ = differences(&rows, &expected);
        println!("{:?}: {differ:?} of {COUNT} differ", pose.lens);
        if is_software() {
            assert_eq!(differ[..6], [0; 6], "{:?}", pose.lens);
        }
        // A sum of three products may be fused, and is divided by.
        for (row, wanted) in rows.chunks_exact(8).zip(&expected) {
            assert!(row[6..].iter().zip(&wanted[6..]).all(|(&one, &other)| ulps(one, other) <= 4));
        }
    }
}

/// A site with random ids, in a picture and a scene of common size.
fn site(random: &mut Pcg32) -> Site {
    Site {
        pixel: [random.below(4096), random.below(4096)],
        frame: random.below(100_000),
        seed: random.next_u32(),
        instance: random.next_u32(),
        geometry: random.below(1 << 20),
        primitive: random.next_u32(),
        back: random.below(2),
        position: [(); 3].map(|()| random.range(-10.0, 10.0)).into(),
        position_in_object: [(); 3]
            .map(|()| random.range(-1.0, 1.0) * random.range(-30.0, 60.0).exp2())
            .into(),
        footprint_in_object: random.range(-45.0, 45.0).exp2(),
    }
}

fn words_of(site: &Site) -> [u32; 15] {
    let &Site { pixel: [x, y], instance, geometry, primitive, back, .. } = site;
    let [px, py, pz] = site.position.to_array().map(f32::to_bits);
    let [ox, oy, oz] = site.position_in_object.to_array().map(f32::to_bits);
    let footprint = site.footprint_in_object.to_bits();
    [x, y, site.frame, site.seed, instance, geometry, primitive, back, px, py, pz, ox, oy, oz, footprint]
}

struct ThresholdsAt<'a>(&'a [Site]);

impl Visitor for ThresholdsAt<'_> {
    type Output = Vec<u32>;

    fn threshold(self, method: &impl Threshold) -> Vec<u32> {
        let tables = contract::Tables::get();
        self.0.iter().map(|site| method.threshold(site, &tables).to_bits()).collect()
    }

    fn selection(self, method: &impl Selection) -> Vec<u32> {
        let tables = contract::Tables::get();
        let threshold = |site: &Site| method.threshold(site.pixel, site.frame, site.seed, &tables);
        self.0.iter().map(|site| threshold(site).to_bits()).collect()
    }

    fn ordered(self, _: &impl OrderedCompositing) -> Vec<u32> {
        panic!("a compositing method has no threshold")
    }

    fn unordered(self, _: &impl UnorderedCompositing) -> Vec<u32> {
        panic!("a compositing method has no threshold")
    }
}

fn random_sites() -> Vec<Site> {
    let mut random = Pcg32::new(15, 0);
    let mut sites: Vec<_> = (0..COUNT).map(|_| site(&mut random)).collect();
    for (index, footprint) in [0.0, f32::MIN_POSITIVE, f32::MAX, f32::INFINITY].into_iter().enumerate() {
        sites[index].footprint_in_object = footprint;
    }
    sites
}

/// Thresholds of a method at all sites: on the device and on the CPU.
fn thresholds(text: &str, sites: &[Site]) -> [Vec<u32>; 2] {
    let method: Method = text.parse().unwrap();
    let tables = Tables::new(method.info().tables, [0, 0]);
    let linker = Linker::new().method(&method).constants(tables.constants());
    let on_device = if method.family() == Family::Selection {
        let input: Vec<u32> = sites.iter().flat_map(|site| words_of(site).into_iter().take(4)).collect();
        run(&linker.link("probe/selection").unwrap(), &tables, &input, 1)
    } else {
        let input: Vec<u32> = sites.iter().flat_map(words_of).collect();
        run(&linker.link("probe/threshold").unwrap(), &tables, &input, 1)
    };
    [on_device, method.visit(ThresholdsAt(sites))]
}

/// How many thresholds differ, and by how many ulp at most.
fn deviation([on_device, on_cpu]: &[Vec<u32>; 2]) -> (usize, u32) {
    let pairs = on_device.iter().zip(on_cpu).map(|(&one, &other)| ulps(one, other));
    (pairs.clone().filter(|&ulps| ulps > 0).count(), pairs.max().unwrap())
}

/// All settings that make a method with integer hashes another one.
const INTEGER_METHODS: &[&str] = &[
    "roulette",
    "std",
    "std:identity=object",
    "std:identity=primitive,rehash=9",
    "std:rehash=1",
    "std:noise=object",
    "std:noise=object,identity=primitive,rehash=9",
    "std:noise=off",
    "dtaa",
    "dtaa:noise=off",
    "dtaa-unique",
    "dtaa-unique:identity=primitive,rehash=25",
    "dtaa-unique:noise=object",
    "stbn",
    "stbn:identity=object,rehash=16",
    "joint",
    "joint:cycle=still",
    "joint:noise=off",
];

#[test]
fn thresholds_of_integer_hashes_are_those_of_the_cpu() {
    let sites = random_sites();
    for text in INTEGER_METHODS {
        let (count, most) = deviation(&thresholds(text, &sites));
        println!("{text}: {count} of {COUNT} thresholds differ, by {most} ulp at most");
        // The only operation that may round otherwise is the division, by up to 2.5 ulp (WGSL, section
        // 15.7.4).
        let bound = if ["roulette", "stbn"].iter().any(|exact| text.starts_with(exact)) { 0 } else { 3 };
        assert!(most <= bound, "{text}: {most} ulp");
    }
}

#[test]
fn thresholds_of_another_seed_are_other_ones() {
    let sites = random_sites();
    let moved: Vec<_> = sites.iter().map(|site| Site { seed: site.seed ^ 1, ..*site }).collect();
    for text in INTEGER_METHODS {
        let [on_device, _] = thresholds(text, &sites);
        let [_, on_cpu] = thresholds(text, &moved);
        let (count, _) = deviation(&[on_device, on_cpu]);
        assert!(count > COUNT / 2, "{text}: the probe is blind, {count} differ");
    }
}

/// A logarithm that is off by an ulp moves the weight of the blend by as much, at the edge of an octave into
/// another pair of cells. So nearly all thresholds agree to four digits, and a few are other draws.
#[test]
fn nearly_all_thresholds_of_hashed_places_agree() {
    let sites = random_sites();
    for text in ["hashed", "hashed:scale=2.5"] {
        let [on_device, on_cpu] = thresholds(text, &sites);
        let off = on_device
            .iter()
            .zip(&on_cpu)
            .filter(|&(&one, &other)| (f32::from_bits(one) - f32::from_bits(other)).abs() > 1e-4)
            .count();
        println!("{text}: {off} of {COUNT} thresholds differ by more than 1e-4");
        assert!(off < COUNT / 1000, "{text}: {off} differ");
        let shifted = on_cpu.iter().skip(1).zip(&on_device);
        let unlike =
            shifted.filter(|&(&one, &other)| (f32::from_bits(one) - f32::from_bits(other)).abs() > 1e-4);
        assert!(unlike.count() > COUNT * 9 / 10, "the check is blind");
    }
}

/// No two devices share the bits of a sine that is blown up ten thousand times, so that thresholds are only
/// as good as random: uniform. A software adapter's sine is nearly as good as the CPU's: there a good part of
/// the thresholds agree, which shows that the same is hashed.
#[test]
fn thresholds_of_sine_hashes_are_uniform() {
    let sites = random_sites();
    let sites: Vec<_> = (0..)
        .zip(sites)
        // Ids of a common scene: the sine wants small numbers.
        .map(|(index, site): (u32, _)| Site {
            instance: index % 251,
            geometry: index % 17,
            primitive: index,
            seed: site.seed % 64,
            ..site
        })
        .collect();
    for text in [
        "roulette:hash=mcguire",
        "std:hash=mcguire,identity=primitive",
        "stbn:hash=mcguire,identity=primitive",
    ] {
        let both = thresholds(text, &sites);
        let (count, _) = deviation(&both);
        println!("{text}: {count} of {COUNT} thresholds differ");
        assert!(!is_software() || count < COUNT * 3 / 4, "{text}: {count} thresholds differ");
        for values in &both {
            let z = uniformity_z(values.iter().map(|bits| f32::from_bits(*bits)));
            assert!(z.abs() < 5.0, "{text}: z {z}");
        }
    }
}

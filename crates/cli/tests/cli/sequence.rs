//! `sheer render`: which frames, seen from where, of how many samples.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{fs, path::Path};

use sheer_image::{DisplayShare, Planes, Tone, display_over_black, read_exr};
use sheer_metrics::psnr_db;

use crate::run::{attribute, json, names_in, sheer, succeed};

fn colour(folder: &Path, name: &str) -> Vec<[f32; 4]> {
    let Planes { colour, .. } = read_exr(&folder.join(name)).unwrap();
    colour.as_slice().to_vec()
}

#[test]
fn frames_are_a_number_or_a_range() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "render layers --size 8x6 -a none --frames 3..5 -o a##.png");
    succeed(folder.path(), "render layers --size 8x6 -a none --frames 7..=8 -o a##.png");
    assert_eq!(names_in(folder.path()), ["a03.png", "a04.png", "a07.png", "a08.png"]);
    for (wrong, said) in [
        ("--frames 5..5", "24..48"),
        ("--frames 5..3", "24..48"),
        ("--frames -1..3", "-1"),
        ("--frames 3..5 --first-frame 3", "leave out --first-frame"),
        ("--fps 0", "frames a second"),
        ("--samples 0", "0"),
        ("--samples 4 -a taa", "--aa"),
        ("--shutter 0.5", "--samples"),
        ("--samples 4 --shutter 2", "from 0 to 1"),
    ] {
        let outcome = sheer(folder.path(), &format!("render layers --size 8x6 {wrong} -o b##.png"));
        assert_eq!(outcome.code, Some(2), "{wrong}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{wrong}: {outcome:?}");
    }
}

#[test]
fn one_picture_of_frames_that_do_not_add_up_says_which_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let clip = "render arena --time 6 -m std --size 16x9";
    succeed(folder.path(), &format!("{clip} -a none --frames 2..6 -o all-##.exr"));
    let one = succeed(folder.path(), &format!("{clip} -a none --frames 2..6 -o one.exr"));
    assert!(one.stderr.contains("one.exr is frame 2 alone: under -a none each of the 4 frames"), "{one:?}");
    assert!(one.stderr.contains("--first-frame 5 for the last"), "{one:?}");
    assert_eq!(colour(folder.path(), "one.exr"), colour(folder.path(), "all-02.exr"));
    succeed(folder.path(), &format!("{clip} -a none --first-frame 5 -o last.exr"));
    assert_eq!(colour(folder.path(), "last.exr"), colour(folder.path(), "all-05.exr"));
    for (how, option) in [("--samples 2", "under --samples"), ("--raw -a taa", "under --raw")] {
        let one = succeed(folder.path(), &format!("{clip} {how} --frames 3 -o one.exr"));
        assert!(one.stderr.contains(option), "{how}: {one:?}");
    }
    // What adds up shows all, and whoever asks for nothing has nothing left out.
    for quiet in ["-a taa --frames 3", "-a none", "-a none --frames 1", "-a none --frames 3 -q"] {
        let one = succeed(folder.path(), &format!("{clip} {quiet} -o one.exr"));
        assert!(!one.stderr.contains("warning"), "{quiet}: {one:?}");
    }
}

#[test]
fn the_frame_rate_says_when_a_frame_is() {
    let folder = tempfile::tempdir().unwrap();
    let arena = "render arena -m baseline -a none --size 24x14 --time 6";
    succeed(folder.path(), &format!("{arena} --frames 10..11 -o at30-##.exr"));
    succeed(folder.path(), &format!("{arena} --fps 15 --frames 5..6 -o at15-##.exr"));
    succeed(folder.path(), &format!("{arena} --frames 5..6 -o other-##.exr"));
    assert_eq!(colour(folder.path(), "at30-10.exr"), colour(folder.path(), "at15-05.exr"));
    assert_ne!(colour(folder.path(), "at30-10.exr"), colour(folder.path(), "other-05.exr"));
}

#[test]
fn a_part_of_a_sequence_fits_to_the_others() {
    let folder = tempfile::tempdir().unwrap();
    for aa in ["taa", "layered"] {
        let clip = format!("render smoke-square --camera path -a {aa} --size 48x27");
        succeed(folder.path(), &format!("{clip} --frames 0..81 -o whole-####.exr"));
        // All of the past, as much as the default, and none.
        let early = succeed(folder.path(), &format!("{clip} --frames 8..10 -o early-####.exr"));
        let late = succeed(folder.path(), &format!("{clip} --frames 80..81 -o late-####.exr"));
        assert!(!early.stderr.contains("warning") && !late.stderr.contains("warning"), "{late:?}");
        let cold = succeed(folder.path(), &format!("{clip} --frames 80..81 --warm-up 0 -o cold-####.exr"));
        assert!(cold.stderr.contains("frame 80 comes after 0 frames of history"), "{cold:?}");

        assert_eq!(colour(folder.path(), "early-0008.exr"), colour(folder.path(), "whole-0008.exr"), "{aa}");
        let shown = |name: &str| {
            let planes = read_exr(&folder.path().join(name)).unwrap();
            display_over_black(&planes.colour, Tone::default(), &DisplayShare::Nothing)
        };
        let at_the_seam =
            |part: &str| psnr_db(&shown("whole-0080.exr"), &shown(&format!("{part}-0080.exr"))).unwrap();
        assert!(at_the_seam("late") > 55.0, "{aa}: {} dB", at_the_seam("late"));
        assert!(at_the_seam("cold") < 40.0, "{aa}: the check is blind, {} dB", at_the_seam("cold"));
    }
}

#[test]
fn what_is_there_is_left_alone_and_the_rest_as_if_nothing_were() {
    let folder = tempfile::tempdir().unwrap();
    for (aa, name) in [("taa", "a"), ("none", "b"), ("accumulate", "c")] {
        let clip = format!("render arena --time 6 -a {aa} --size 16x9 --frames 6");
        succeed(folder.path(), &format!("{clip} -o {name}-whole-##.exr"));
        let there = folder.path().join(format!("{name}-part-03.exr"));
        fs::write(&there, "somebody's").unwrap();
        succeed(folder.path(), &format!("{clip} --skip-existing -o {name}-part-##.exr"));
        assert_eq!(fs::read(&there).unwrap(), b"somebody's");
        for frame in ["00", "02", "04", "05"] {
            let [whole, part] =
                ["whole", "part"].map(|of| colour(folder.path(), &format!("{name}-{of}-{frame}.exr")));
            assert_eq!(whole, part, "{aa}, frame {frame}");
        }
        let again = succeed(folder.path(), &format!("{clip} --skip-existing -o {name}-part-##.exr"));
        assert!(again.stderr.contains("nothing to render"), "{again:?}");
    }
}

#[test]
fn a_final_frame_is_the_mean_of_its_own_samples() {
    let folder = tempfile::tempdir().unwrap();
    let clip = "render arena --time 5.5 --fps 2 -m baseline --size 24x14 --samples 8";
    succeed(folder.path(), &format!("{clip} --frames 2 -o a-##.exr"));
    succeed(folder.path(), &format!("{clip} --frames 1..2 -o b-##.exr"));
    succeed(folder.path(), &format!("{clip} --first-frame 1 -o single.exr"));
    succeed(folder.path(), &format!("{clip} --first-frame 1 --shutter 1 -o blurred.exr"));
    let still =
        "render arena --time 5.5 --fps 2 -m baseline --size 24x14 -a accumulate --first-frame 1 --frames 64";
    succeed(folder.path(), &format!("{still} -o still.exr"));
    let [first, second, alone, single, blurred, still] =
        ["a-00.exr", "a-01.exr", "b-01.exr", "single.exr", "blurred.exr", "still.exr"]
            .map(|name| colour(folder.path(), name));
    assert_eq!((&second, &second), (&alone, &single));
    // The same moment as that of a still, but for the noise of few samples: nearer than the frame before, and
    // than with an open shutter.
    let distance = |other: &[[f32; 4]]| -> f32 {
        let differences = still.iter().zip(other).map(|(a, b)| (a[0] - b[0]).powi(2));
        differences.sum()
    };
    assert!(distance(&second) < distance(&first), "{} {}", distance(&second), distance(&first));
    assert_ne!(second, blurred);
    assert_eq!(attribute(&folder.path().join("blurred.exr"), "samples").as_deref(), Some("8"));
    assert_eq!(attribute(&folder.path().join("blurred.exr"), "shutter").as_deref(), Some("1"));
}

#[test]
fn a_view_of_ones_own_is_given_as_inspect_tells_it() {
    let folder = tempfile::tempdir().unwrap();
    let report = json(&succeed(folder.path(), "inspect pane --json -").stdout);
    let options = report["view"]["options"].as_str().unwrap();
    let picture = "render pane -m baseline -a none --size 32x18";
    succeed(folder.path(), &format!("{picture} --camera static -o named.exr"));
    succeed(folder.path(), &format!("{picture} {options} -o own.exr"));
    let (place, _) = options.split_once("--fov").unwrap();
    succeed(folder.path(), &format!("{picture} {place} --ortho 4 -o ortho.exr"));
    let [named, own, ortho] = ["named.exr", "own.exr", "ortho.exr"].map(|name| colour(folder.path(), name));
    // Angles in degrees and a target on the axis are rounded: what is hit at an edge may differ.
    let differing = |other: &[[f32; 4]]| {
        named.iter().zip(other).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-3)).count()
    };
    assert!(differing(&own) < 6, "{} of {} pixels", differing(&own), named.len());
    assert!(differing(&ortho) > 60, "{}", differing(&ortho));
    for (wrong, said) in [
        ("--eye 1,2", "three numbers"),
        ("--eye 1,2,nan", "three numbers"),
        ("--eye 1,2,3 --target 1,2,3", "the same point"),
        ("--eye 1,2,3 --up 0,0,0", "give a direction as in 0,1,0"),
        ("--target 1,2,3", "--eye"),
        ("--eye 1,2,3 --camera orbit", "--camera"),
        ("--fov 180", "179"),
        ("--fov 30 --ortho 2", "--ortho"),
        ("--ortho 0", "above 0"),
    ] {
        let outcome = sheer(folder.path(), &format!("{picture} {wrong} -o b.exr"));
        assert_eq!(outcome.code, Some(2), "{wrong}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{wrong}: {outcome:?}");
    }
}

//! `sheer render --crop` and `--sample-range`, and `sheer merge`, which puts the pieces together.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{fs, path::Path};

use sheer_image::{DisplayShare, Planes, Tone, display_over_black, read_exr, read_png};
use sheer_metrics::psnr_db;

use crate::run::{attribute, names_in, sheer, succeed};

/// Six parts of a picture of 48×27 pixels, with edges where no tile has any.
const CROPS: [&str; 6] =
    ["0,0,17,13", "17,0,20,13", "37,0,11,13", "0,13,17,14", "17,13,20,14", "37,13,11,14"];

/// Renders all of a picture as `NAME.exr`, and its crops.
fn render_with_crops(folder: &Path, name: &str, picture: &str) -> Vec<String> {
    succeed(folder, &format!("render {picture} --size 48x27 -o {name}.exr"));
    let crop = |crop: &&str| {
        let file = format!("{name}-{crop}.exr");
        succeed(folder, &format!("render {picture} --size 48x27 --crop {crop} -o {file}"));
        file
    };
    CROPS.iter().map(crop).collect()
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap()
}

#[test]
fn six_crops_are_the_whole_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let arena = "arena --time 6 --seed 3";
    for (name, how) in [
        ("none", "-m joint -a none"),
        ("accumulate", "-m std -a accumulate --frames 3"),
        ("samples", "-m dtaa --samples 2 --shutter 0.5"),
        ("raw", "-m joint -a layered --raw"),
        ("filter", "-m stochastic:samples=4,filter=bilateral -a none"),
    ] {
        let mut crops = render_with_crops(folder.path(), name, &format!("{arena} {how}"));
        crops.rotate_left(4);
        succeed(folder.path(), &format!("merge {} -o merged.exr", crops.join(" ")));
        // The same file: all planes, and what its header says.
        assert_eq!(
            bytes(folder.path(), "merged.exr"),
            bytes(folder.path(), &format!("{name}.exr")),
            "{name}"
        );
    }
    let crop = folder.path().join("none-17,13,20,14.exr");
    let said = ["size", "crop", "seed", "method", "aa", "scene", "frame"].map(|key| attribute(&crop, key));
    let expected = ["48x27", "17,13,20,14", "3", "joint", "none", "arena", "0"];
    assert_eq!(said, expected.map(|text| Some(text.to_owned())));
    assert!(attribute(&crop, "pose").unwrap().starts_with("--eye "));
    assert_eq!(attribute(&crop, "scene_hash").unwrap().len(), 16);
    assert_eq!(read_exr(&crop).unwrap().colour.size(), (20, 14));
}

#[test]
fn a_merged_png_shows_display_referred_light_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let picture = "pane -a accumulate --frames 2 --background #406080";
    let crops = render_with_crops(folder.path(), "whole", picture);
    succeed(folder.path(), &format!("render {picture} --size 48x27 --exposure 1 -o whole.png"));
    succeed(folder.path(), &format!("merge {} --exposure 1 -o merged.png", crops.join(" ")));
    succeed(
        folder.path(),
        &format!("render {picture} --size 48x27 --crop 17,0,20,13 --exposure 1 -o part.png"),
    );
    let [whole, merged, part] =
        ["whole", "merged", "part"].map(|name| read_png(&folder.path().join(format!("{name}.png"))).unwrap());
    assert_eq!(whole, merged);
    assert!((0..13).all(|y| (0..20).all(|x| part[(x, y)] == whole[(x + 17, y)])));
}

#[test]
fn sample_ranges_are_the_whole_to_rounding() {
    let folder = tempfile::tempdir().unwrap();
    for (name, how) in [
        ("accumulate", "-a accumulate --frames 16 --first-frame 7"),
        ("samples", "--samples 16 --shutter 0.5 --first-frame 7"),
    ] {
        let picture = format!("render arena --time 6 -m std --size 48x27 {how}");
        succeed(folder.path(), &format!("{picture} -o {name}.exr"));
        let pieces = ["10..=15", "0..4", "4..5", "5..10"].map(|range| {
            let file = format!("{name}-{range}.exr");
            succeed(folder.path(), &format!("{picture} --sample-range {range} -o {file}"));
            file
        });
        succeed(folder.path(), &format!("merge {} -o merged.exr", pieces.join(" ")));
        let [whole, merged, part] = [format!("{name}.exr"), "merged.exr".to_owned(), pieces[0].clone()]
            .map(|file| read_exr(&folder.path().join(file)).unwrap());
        let furthest = |other: &Planes| {
            let pixels = whole.colour.as_slice().iter().zip(other.colour.as_slice());
            let differences =
                pixels.flat_map(|(a, b)| (0..4).map(|at| (a[at] - b[at]).abs() / a[at].abs().max(1.0)));
            differences.fold(0.0, f32::max)
        };
        assert!(furthest(&merged) < 1e-6, "{name}: {}", furthest(&merged));
        assert!(furthest(&part) > 1e-3, "{name}: the check is blind");
        assert_eq!(Planes { colour: whole.colour.clone(), ..merged }, whole, "{name}");
        for key in ["samples", "frame", "sample_range", "pose", "time_secs"] {
            let [whole, merged] = [format!("{name}.exr"), "merged.exr".to_owned()]
                .map(|file| attribute(&folder.path().join(file), key));
            assert_eq!(whole, merged, "{name}: {key}");
        }
    }
    // Frames of a sequence in parts, and parts of parts.
    let clip = "render arena --time 6 -m std --size 48x27 --samples 4 --frames 2";
    succeed(folder.path(), &format!("{clip} -o a-##.exr"));
    succeed(folder.path(), &format!("{clip} --sample-range 0..3 -o b-##.exr"));
    succeed(folder.path(), &format!("{clip} --sample-range 3..4 --crop 0,0,48,9 -o c-##.exr"));
    succeed(folder.path(), &format!("{clip} --sample-range 3..4 --crop 0,9,48,18 -o d-##.exr"));
    let outcome = sheer(folder.path(), "merge b-01.exr c-01.exr d-01.exr -o e.exr");
    assert!(
        outcome.stderr.contains("c-01.exr and b-01.exr overlap: both have the pixels 0,0,48,9"),
        "{outcome:?}"
    );
    succeed(folder.path(), &format!("{clip} --sample-range 0..3 --crop 0,0,48,9 -o f-##.exr"));
    succeed(folder.path(), &format!("{clip} --sample-range 0..3 --crop 0,9,48,18 -o g-##.exr"));
    succeed(folder.path(), "merge c-01.exr d-01.exr f-01.exr g-01.exr -o merged.exr");
    let [whole, merged] = ["a-01.exr", "merged.exr"].map(|name| read_exr(&folder.path().join(name)).unwrap());
    for (a, b) in whole.colour.as_slice().iter().zip(merged.colour.as_slice()) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6 * a.abs().max(1.0)), "{a:?} {b:?}");
    }
}

#[test]
fn a_history_that_stands_still_needs_no_more_than_its_margin() {
    let folder = tempfile::tempdir().unwrap();
    // Wide enough that the margin of 44 pixels does not reach the far edge.
    let picture = "render pane --camera static -m std --size 160x16 --frames 24";
    for (aa, margin) in [("taa", 3), ("layered", 44)] {
        succeed(folder.path(), &format!("{picture} -a {aa} -o whole.exr"));
        succeed(folder.path(), &format!("{picture} -a {aa} --crop 0,0,80,16 --margin {margin} -o left.exr"));
        succeed(
            folder.path(),
            &format!("{picture} -a {aa} --crop 80,0,80,16 --margin {margin} -o right.exr"),
        );
        succeed(folder.path(), "merge left.exr right.exr -o merged.exr");
        let [whole, merged] =
            ["whole.exr", "merged.exr"].map(|name| read_exr(&folder.path().join(name)).unwrap());
        assert_eq!(whole, merged, "{aa}");
        assert_eq!(attribute(&folder.path().join("merged.exr"), "margin"), Some(margin.to_string()));
        succeed(folder.path(), &format!("{picture} -a {aa} --crop 0,0,80,16 --margin 0 -o bare.exr"));
        let bare = read_exr(&folder.path().join("bare.exr")).unwrap();
        let differs = (0..80).any(|x| bare.colour[(x, 8)] != whole.colour[(x, 8)]);
        assert!(differs, "{aa}: the check is blind");
        let outcome = sheer(folder.path(), "merge bare.exr right.exr -o no.exr");
        assert!(outcome.stderr.contains("its margin is"), "{outcome:?}");
    }
}

#[test]
fn pieces_that_do_not_belong_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let render = |scene: &str, more: &str| {
        succeed(folder.path(), &format!("render {scene} -a none --size 16x8 {more}"));
    };
    render("layers", "--crop 0,0,8,8 -o left.exr");
    render("layers", "--crop 8,0,8,8 -o right.exr");
    render("layers", "--crop 8,0,8,8 --seed 1 -o seed.exr");
    render("layers:count=3", "--crop 8,0,8,8 -o scene.exr");
    render("layers", "--crop 8,0,8,8 --alpha 0.5 -o alpha.exr");
    render("layers", "--crop 8,0,8,8 -m std -o method.exr");
    render("layers", "--crop 8,0,8,8 --frames 3..4 -o frame-##.exr");
    render("layers", "--crop 8,0,8,8 --background none -o background.exr");
    render("layers", "--crop 8,0,8,8 --eye 0,0,9 -o eye.exr");
    render("layers", "--crop 7,0,9,8 -o wide.exr");
    render("layers", "--crop 8,0,8,8 -o right.png");
    fs::write(folder.path().join("text.exr"), "no picture").unwrap();
    succeed(folder.path(), "merge right.exr left.exr -o merged.exr");
    for (pieces, said) in [
        (
            "left.exr",
            "no piece has the pixels 8,0,8,8 of the picture of 16x8: render them with --crop 8,0,8,8",
        ),
        ("left.exr wide.exr", "left.exr and wide.exr overlap: both have the pixels 7,0,1,8"),
        ("left.exr seed.exr", "seed.exr does not belong to left.exr: its seed is 1, that of the other 0"),
        ("left.exr scene.exr", "scene.exr does not belong to left.exr: its scene_hash is"),
        ("left.exr alpha.exr", "its scene_hash is"),
        ("left.exr method.exr", "its method is std, that of the other joint"),
        ("left.exr frame-03.exr", "its frame is 3, that of the other 0"),
        ("left.exr background.exr", "its background is none, that of the other env"),
        ("left.exr eye.exr", "its camera is eye=0,0,9"),
        ("left.exr right.png", "right.png is no piece of a picture"),
        ("left.exr text.exr", "text.exr is no piece of a picture: it does not read as OpenEXR"),
        ("left.exr absent.exr", "cannot read absent.exr"),
    ] {
        let outcome = sheer(folder.path(), &format!("merge {pieces} -o no.exr"));
        assert_eq!(outcome.code, Some(1), "{pieces}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{pieces}: {outcome:?}");
        assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
    }
    assert!(!names_in(folder.path()).contains(&"no.exr".to_owned()));

    for (wrong, code, said) in [
        ("render layers --size 16x8 --crop 9,0,8,8", 2, "--crop 9,0,8,8 reaches beyond the picture of 16x8"),
        ("render layers --size 16x8 --crop 0,0,0,8", 2, "X,Y,WIDTH,HEIGHT"),
        ("render layers --size 16x8 --margin 4", 2, "--crop"),
        ("render layers -a taa --sample-range 0..4", 2, "-a accumulate"),
        ("render layers -a accumulate --frames 4 --sample-range 0..4 -o a##.exr", 2, "in one file"),
        ("render layers -a accumulate --frames 4 --sample-range 2..5", 2, "reaches beyond the 4 samples"),
        ("render layers --samples 4 --sample-range 3..3", 2, "16..32"),
        ("merge left.exr right.exr -o a.jpg", 2, ".png or .exr"),
        ("merge -o a.exr", 2, "PIECE"),
    ] {
        let outcome = sheer(folder.path(), wrong);
        assert_eq!(outcome.code, Some(code), "{wrong}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{wrong}: {outcome:?}");
    }
}

#[test]
fn pieces_of_sequences_are_put_together_frame_by_frame() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let clip = "render arena --time 6 -m std -a none --size 24x14 --frames 9..12";
    for (name, more) in [
        ("whole", ""),
        ("left", "--crop 0,0,10,14"),
        ("right", "--crop 10,0,14,14"),
        ("seed", "--crop 10,0,14,14 --seed 1"),
    ] {
        succeed(folder, &format!("{clip} {more} -o {name}-####.exr"));
    }
    let early = clip.replace("9..12", "8..11");
    succeed(folder, &format!("{early} --crop 10,0,14,14 -o early-####.exr"));
    let outcome = succeed(folder, "merge right-####.exr left-%04d.exr -o all/####.exr --progress json");
    assert!(outcome.stderr.contains("wrote all/####.exr: 24x14, 3 frames of 2 pieces"), "{outcome:?}");
    assert!(outcome.stdout.ends_with("{\"percent\":100,\"done\":3,\"expected\":3}\n"), "{outcome:?}");
    assert_eq!(names_in(&folder.join("all")), ["0009.exr", "0010.exr", "0011.exr"]);
    for frame in ["0009", "0010", "0011"] {
        let [merged, whole] = ["all/", "whole-"].map(|name| bytes(folder, &format!("{name}{frame}.exr")));
        assert_eq!(merged, whole, "frame {frame}");
    }

    // Another frame under a number of the sequence, and one frame of another seed.
    fs::create_dir(folder.join("wrong")).unwrap();
    for (from, to) in [
        ("right-0009.exr", "order-0009.exr"),
        ("right-0011.exr", "order-0010.exr"),
        ("right-0010.exr", "order-0011.exr"),
        ("right-0009.exr", "mixed-0009.exr"),
        ("seed-0010.exr", "mixed-0010.exr"),
        ("right-0011.exr", "mixed-0011.exr"),
        ("right-0009.exr", "gap-0009.exr"),
        ("right-0011.exr", "gap-0011.exr"),
    ] {
        fs::copy(folder.join(from), folder.join("wrong").join(to)).unwrap();
    }
    for (arguments, code, said) in [
        (
            "left-####.exr early-####.exr -o no-####.exr",
            1,
            "left-0008.exr is missing: the pieces have frames from 8 to 11",
        ),
        ("left-####.exr wrong/gap-####.exr -o no-####.exr", 1, "wrong/gap-0010.exr is missing"),
        (
            "left-####.exr wrong/order-####.exr -o no-####.exr",
            1,
            "wrong/order-0010.exr does not belong to left-0010.exr: its frame is 11",
        ),
        (
            "left-####.exr wrong/mixed-####.exr -o no-####.exr",
            1,
            "wrong/mixed-0010.exr does not belong to left-0010.exr: its seed is 1",
        ),
        (
            "left-####.exr seed-####.exr -o no-####.exr",
            1,
            "seed-0009.exr does not belong to left-0009.exr: its seed is 1",
        ),
        ("left-####.exr -o no-####.exr", 1, "no piece has the pixels 10,0,14,14"),
        ("left-####.exr absent-####.exr -o no-####.exr", 1, "absent-####.exr: there is no such file"),
        ("left-####.exr right-####.exr -o no.exr", 2, "no.exr: the pieces are those of a sequence; put ####"),
        (
            "left-0009.exr right-0009.exr -o no-####.exr",
            2,
            "no-####.exr: the pieces are those of one picture",
        ),
        (
            "left-####.exr right-0009.exr -o no-####.exr",
            2,
            "right-0009.exr is one file and left-####.exr numbered ones",
        ),
        ("left-####.exr right-####.exr -o left-####.exr", 2, "left-0009.exr is one of the pieces"),
        ("left-0009.exr right-0009.exr -o right-0009.exr", 2, "right-0009.exr is one of the pieces"),
        ("left-####.exr right-####.exr -o no-####.jpg", 2, ".png or .exr"),
    ] {
        let outcome = sheer(folder, &format!("merge {arguments}"));
        assert_eq!(outcome.code, Some(code), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{arguments}: {outcome:?}");
        assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
    }
    assert!(names_in(folder).iter().all(|name| !name.starts_with("no")), "{:?}", names_in(folder));
}

#[test]
fn a_gpu_says_that_it_renders_whole_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let picture = "render layers --size 16x8 -a none --backend gpu --crop 0,0,8,8 -o a.exr";
    let outcome = sheer(folder.path(), picture);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("leave out --crop, or take --backend cpu"), "{outcome:?}");
}

#[test]
fn a_margin_hides_the_seam_of_moving_crops() {
    // Between what is left with the default margins and without any, by 10 dB or more.
    const LEAST_DB: f64 = 70.0;
    let folder = tempfile::tempdir().unwrap();
    let shown = |name: &str| {
        let planes = read_exr(&folder.path().join(name)).unwrap();
        display_over_black(&planes.colour, Tone::default(), &DisplayShare::Nothing)
    };
    for aa in ["taa", "layered"] {
        let clip = format!("render smoke-square --camera path -m joint -a {aa} --size 96x54 --frames 40");
        succeed(folder.path(), &format!("{clip} -o whole.exr"));
        for (name, margin) in [("default", ""), ("bare", "--margin 0")] {
            succeed(folder.path(), &format!("{clip} --crop 0,0,48,54 {margin} -o {name}-left.exr"));
            succeed(folder.path(), &format!("{clip} --crop 48,0,48,54 {margin} -o {name}-right.exr"));
            succeed(folder.path(), &format!("merge {name}-left.exr {name}-right.exr -o {name}.exr"));
        }
        let [default, bare] =
            ["default.exr", "bare.exr"].map(|name| psnr_db(&shown("whole.exr"), &shown(name)).unwrap());
        assert!(default > LEAST_DB, "{aa}: {default} dB");
        assert!(bare < LEAST_DB, "{aa}: the check is blind, {bare} dB");
    }
}

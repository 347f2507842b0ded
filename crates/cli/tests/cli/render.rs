//! `sheer render`.

use std::fs;

use sheer_image::{Planes, read_exr, read_png};

use crate::run::{attribute, names_in, sheer, succeed};

#[test]
fn a_png_has_the_size_asked_for_and_stdout_stays_empty() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = succeed(folder.path(), "render layers --size 24x10 --frames 3 -o a.png");
    assert_eq!(read_png(&folder.path().join("a.png")).unwrap().size(), (24, 10));
    assert_eq!(outcome.stdout, "");
    assert!(
        outcome.stderr.contains("3 frames") && outcome.stderr.contains("1.00 shaded"),
        "{}",
        outcome.stderr
    );
    assert_eq!(names_in(folder.path()), ["a.png"]);
    let quiet = succeed(folder.path(), "render layers --size 24x10 --frames 3 -o a.png --quiet");
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}

#[test]
fn an_exr_carries_all_planes_and_how_it_was_made() {
    let folder = tempfile::tempdir().unwrap();
    succeed(
        folder.path(),
        "render layers:count=2 -m roulette -a accumulate --frames 4 --size 24x10 --seed 7 -o a.exr",
    );
    let path = folder.path().join("a.exr");
    let planes = read_exr(&path).unwrap();
    assert_eq!((planes.width(), planes.height()), (24, 10));
    assert!(planes.depth.as_slice().iter().all(|depth| depth.is_finite()));
    assert!(planes.instance.as_slice().iter().all(|&id| id != Planes::NO_ID));
    assert!(planes.colour.as_slice().iter().all(|pixel| pixel[3] == 1.0));
    let bytes = fs::read(path).unwrap();
    for key in [
        "sheer.scene",
        "sheer.method",
        "sheer.aa",
        "sheer.shadow",
        "sheer.seed",
        "sheer.commit",
        "sheer.version",
    ] {
        assert!(bytes.windows(key.len()).any(|window| window == key.as_bytes()), "{key}");
    }
    assert_eq!(planes.layers, None);
    succeed(folder.path(), "render layers:count=2 -a layered --frames 2 --size 24x10 -o layered.exr");
    let layers = read_exr(&folder.path().join("layered.exr")).unwrap().layers.unwrap();
    assert!(layers.as_slice().iter().all(|layers| (layers.coverage - 0.36).abs() < 1e-6));
}

#[test]
fn a_sequence_holds_every_frame_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "render layers --size 8x6 --frames 3 --first-frame 9 -o a-####.png");
    succeed(folder.path(), "render layers --size 8x6 --frames 2 -a none -o b%02d.exr");
    let names = ["a-0009.png", "a-0010.png", "a-0011.png", "b00.exr", "b01.exr"];
    assert_eq!(names_in(folder.path()), names);
    assert_eq!(read_png(&folder.path().join("a-0010.png")).unwrap().size(), (8, 6));
}

#[test]
fn raw_frames_are_jittered_single_samples_with_layers() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // A sheet of white at half opacity before black: samples are one or the other, but for rounding.
    let scene = "render layers:count=1,alpha=0.5,background=0 --size 16x9 --seed 7";
    succeed(folder.path(), &format!("{scene} --frames 2 --first-frame 5 --raw -o raw-####.exr"));
    succeed(folder.path(), &format!("{scene} --frames 7 -o summed.exr"));
    let is_sample = |pixel: &[f32; 4]| pixel[0] == 0.0 || (pixel[0] - 1.0).abs() < 1e-6;
    let colour = |name: &str| read_exr(&path(name)).unwrap().colour;
    assert!(!colour("summed.exr").as_slice().iter().all(is_sample), "the check for samples is blind");
    assert_ne!(colour("raw-0005.exr"), colour("raw-0006.exr"));
    for name in ["raw-0005.exr", "raw-0006.exr"] {
        let planes = read_exr(&path(name)).unwrap();
        assert!(planes.colour.as_slice().iter().all(is_sample), "{name} is added up");
        assert!(planes.transparent.as_slice().iter().all(|&is| is), "{name}");
        let layers = planes.layers.unwrap();
        for (layers, colour) in layers.as_slice().iter().zip(planes.colour.as_slice()) {
            assert_eq!((layers.coverage, layers.is_front), (0.5, colour[0] > 0.5), "{name}");
            assert!(layers.front_depth < layers.back_depth, "{name}: {layers:?}");
        }
    }
    let jitter = |name: &str| {
        ["jitter.X", "jitter.Y"].map(|key| attribute(&path(name), key).unwrap().parse::<f32>().unwrap())
    };
    assert_ne!(jitter("raw-0005.exr"), jitter("raw-0006.exr"));
    assert!(jitter("raw-0005.exr").iter().all(|offset| offset.abs() < 0.5));
    assert_eq!(attribute(&path("raw-0006.exr"), "frame").as_deref(), Some("6"));
    assert_eq!(attribute(&path("raw-0006.exr"), "seed").as_deref(), Some("7"));
    assert_eq!(attribute(&path("summed.exr"), "jitter.X"), None);
}

#[test]
fn a_raw_frame_without_jitter_is_the_picture_without_anti_aliasing() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for method in ["std", "joint", "baseline"] {
        let arguments = format!("render smoke-square -m {method} -a none --size 32x18");
        succeed(folder.path(), &format!("{arguments} -o plain.exr"));
        let outcome = succeed(folder.path(), &format!("{arguments} --raw --frames 5 -o raw.exr"));
        assert!(outcome.stderr.contains("1 frame;"), "{}", outcome.stderr);
        let [plain, raw] = ["plain.exr", "raw.exr"].map(|name| read_exr(&path(name)).unwrap());
        assert_eq!(plain.layers, None);
        assert!(raw.layers.is_some());
        assert_eq!(Planes { layers: None, ..raw }, plain, "{method}");
        assert_eq!(attribute(&path("raw.exr"), "jitter.X").as_deref(), Some("0"));
    }
}

#[test]
fn raw_frames_do_not_fit_a_png() {
    let folder = tempfile::tempdir().unwrap();
    for output in ["a.png", "a-####.png"] {
        let outcome = sheer(folder.path(), &format!("render layers --size 8x6 --frames 1 --raw -o {output}"));
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stderr.contains("--raw writes .exr"), "{outcome:?}");
    }
    assert_eq!(names_in(folder.path()), [""; 0]);
    succeed(folder.path(), "render layers:count=2 --size 8x6 --frames 1 --raw");
    assert_eq!(names_in(&folder.path().join("sheer-out")), ["layers.exr"]);
}

#[test]
fn without_anti_aliasing_one_frame_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = succeed(folder.path(), "render layers --size 8x6 -a none --frames 5 -o a.png");
    assert!(outcome.stderr.contains("1 frame;"), "{}", outcome.stderr);
}

#[test]
fn a_background_of_none_leaves_the_sky_transparent_and_env_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "render smoke-square --size 32x18 -a none -m baseline";
    succeed(folder.path(), &format!("{arguments} --background none -o none.png"));
    succeed(folder.path(), &format!("{arguments} --background none -o none.exr"));
    succeed(folder.path(), &format!("{arguments} -o env.png"));
    let png = |name: &str| read_png(&folder.path().join(name)).unwrap();
    let exr = read_exr(&folder.path().join("none.exr")).unwrap();
    let (none, env) = (png("none.png"), png("env.png"));
    assert!(env.as_slice().iter().all(|pixel| pixel[3] == 255));
    assert!(none.as_slice().contains(&[0; 4]), "no pixel sees the sky");
    assert!(none.as_slice().iter().any(|pixel| pixel[3] == 255));
    for (shown, linear) in none.as_slice().iter().zip(exr.colour.as_slice()) {
        assert_eq!(shown[3], (linear[3] * 255.0).round() as u8);
    }
}

#[test]
fn a_background_colour_is_what_the_sky_shows() {
    let folder = tempfile::tempdir().unwrap();
    succeed(
        folder.path(),
        "render smoke-square --size 32x18 -a none -m baseline --background #ff0000 -o a.exr",
    );
    let planes = read_exr(&folder.path().join("a.exr")).unwrap();
    assert!(planes.colour.as_slice().contains(&[1.0, 0.0, 0.0, 1.0]));
}

#[test]
fn alpha_sets_the_opacity_of_every_material() {
    let folder = tempfile::tempdir().unwrap();
    let render = |alpha: &str, name: &str| {
        let what = "render layers:count=1,alpha=0.5,background=0 --size 4x4 -a none -m baseline";
        succeed(folder.path(), &format!("{what} --alpha {alpha} -o {name}"));
        read_exr(&folder.path().join(name)).unwrap().colour[(1, 1)][0]
    };
    assert_eq!(render("1", "opaque.exr"), 1.0);
    assert!((render("0.25", "quarter.exr") - 0.25).abs() < 1e-6);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    for threads in [1, 2] {
        let arguments = "render smoke-square --size 48x27 --frames 2";
        succeed(folder.path(), &format!("{arguments} --threads {threads} -o {threads}.exr"));
    }
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("1.exr") == bytes("2.exr"));
    succeed(folder.path(), "render smoke-square --size 48x27 --frames 2 --seed 1 -o seed.exr");
    assert!(
        bytes("1.exr") != bytes("seed.exr"),
        "another seed gives the same picture: the comparison is blind"
    );
}

#[test]
fn an_unwritable_output_fails_before_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("taken.png")).unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    // So many frames that a test which waits for one is noticed.
    let endless = "--size 4000x4000 --frames 1000000";
    for (command, said) in [
        (format!("render {endless} -o absent/a.png"), "absent"),
        (format!("render {endless} -o file/a-####.exr"), "file"),
        (format!("render {endless} -o taken.png"), "folder"),
        (format!("render {endless} -o file/a.png"), "file"),
        (format!("compare {endless} -o file"), "file"),
        (format!("compare {endless} -o file/below"), "file"),
        (format!("bench {endless} --json absent/a.json"), "absent"),
        ("verify --json absent/a.json".to_owned(), "absent"),
    ] {
        let outcome = sheer(folder.path(), &command);
        assert_eq!(outcome.code, Some(1), "{command}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{command}: {outcome:?}");
    }
    assert_eq!(names_in(folder.path()), ["file", "taken.png"]);
    assert_eq!(names_in(&folder.path().join("taken.png")), [""; 0]);
}

#[test]
fn an_output_that_is_not_named_goes_to_a_folder_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "render layers:count=2 --size 8x6 --frames 1");
    assert_eq!(names_in(&folder.path().join("sheer-out")), ["layers.png"]);
}

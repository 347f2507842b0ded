//! `sheer metrics`: pictures from anywhere, held against a reference; tables for spreadsheets and papers.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{fs, path::Path};

use image::{ImageFormat, Rgb, RgbImage};
use sheer_image::read_png;

use crate::run::{assert_numbers, json, names_in, sheer, succeed};

/// A picture of grey steps, in a format that its name tells, each step brighter by so much.
fn write(folder: &Path, name: &str, brighter: u8) {
    let picture = RgbImage::from_fn(48, 32, |x, y| Rgb([(2 * x + y) as u8 + brighter; 3]));
    picture.save(folder.join(name)).unwrap();
}

#[test]
fn figures_are_those_of_their_definitions() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "reference.png", 0);
    write(folder.path(), "brighter.png", 10);
    write(folder.path(), "same.webp", 0);
    let report = succeed(folder.path(), "metrics reference.png same=same.webp brighter.png --json -").stdout;
    let report = json(&report);
    assert_eq!((report["size"][0].as_u64(), report["size"][1].as_u64()), (Some(48), Some(32)));
    let [same, brighter] = [&report["rows"][0], &report["rows"][1]];
    assert_eq!(
        (same["picture"].as_str(), brighter["picture"].as_str()),
        (Some("same"), Some("brighter.png"))
    );
    assert_numbers(brighter, &["frames", "ssim", "psnr_db", "flip", "rms", "bias"]);
    assert_eq!((same["ssim"].as_f64(), same["rms"].as_f64()), (Some(1.0), Some(0.0)));
    assert!(same["psnr_db"].is_null() && same["flicker"].is_null(), "{same}");
    // Ten steps of 255 everywhere.
    let expected = 20.0 * (255.0_f64 / 10.0).log10();
    assert!((brighter["psnr_db"].as_f64().unwrap() - expected).abs() < 1e-3, "{brighter}");
    assert!(brighter["bias"].as_f64().unwrap() > 0.0);
}

#[test]
fn clips_are_folders_or_numbers_and_one_reference_does_for_all() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("clip")).unwrap();
    for frame in 1..4 {
        write(folder.path(), &format!("a-{frame:04}.png"), frame);
        write(&folder.path().join("clip"), &format!("{frame}.jpg"), frame);
    }
    let rows = |arguments: &str| {
        let report = succeed(folder.path(), &format!("metrics {arguments} --json -")).stdout;
        json(&report)["rows"].clone()
    };
    let clip = rows("clip a-####.png");
    assert_eq!(clip[0]["frames"].as_u64(), Some(3));
    assert_numbers(&clip[0], &["tpsnr_db", "flicker"]);
    // JPEG loses a little of the steps.
    assert!(clip[0]["psnr_db"].as_f64().unwrap() > 35.0, "{clip}");
    // From another number on, but not with a gap elsewhere.
    for (from, to) in [(1, 5), (2, 6), (3, 7), (1, 8), (2, 10), (3, 11)] {
        let name = |stem: char, frame: u32| folder.path().join(format!("{stem}-{frame:04}.png"));
        fs::copy(name('a', from), name(if to < 8 { 'b' } else { 'c' }, to)).unwrap();
    }
    assert_eq!(rows("a-####.png b-####.png")[0]["rms"].as_f64(), Some(0.0));
    let outcome = sheer(folder.path(), "metrics a-####.png c-####.png");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("c-0010.png and ./a-0002.png have other numbers"), "{outcome:?}");
    let still = rows("a-0001.png a-####.png");
    assert_eq!(still[0]["frames"].as_u64(), Some(3));
    let outcome = sheer(folder.path(), "metrics clip a-0001.png");
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("a-0001.png has 1 picture and the reference 3"), "{outcome:?}");
}

#[test]
fn linear_pictures_of_ours_are_shown_by_the_same_curve() {
    let folder = tempfile::tempdir().unwrap();
    let picture = "render layers:count=2 -m baseline -a none --size 24x16";
    succeed(folder.path(), &format!("{picture} -o linear.exr"));
    succeed(folder.path(), &format!("{picture} -o shown.png"));
    let report = succeed(folder.path(), "metrics linear.exr shown.png --json -").stdout;
    // A PNG has 256 steps.
    assert!(json(&report)["rows"][0]["psnr_db"].as_f64().unwrap() > 50.0, "{report}");
    let aces = succeed(folder.path(), "metrics linear.exr shown.png --tone aces --json -").stdout;
    assert!(json(&aces)["rows"][0]["psnr_db"].as_f64().unwrap() < 40.0, "the check is blind: {aces}");
}

#[test]
fn a_page_shows_pictures_and_errors_and_files_have_the_table() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "reference.png", 0);
    write(folder.path(), "a,b.png", 40);
    let arguments =
        ["metrics", "reference.png", "a,b.png", "--html", "page", "--csv", "a.csv", "--latex", "a.tex"];
    let outcome = succeed(folder.path(), &arguments.join(" "));
    assert!(outcome.stdout.starts_with("picture"), "{outcome:?}");
    let page = fs::read_to_string(folder.path().join("page/index.html")).unwrap();
    assert!(page.contains("a,b.png") && page.matches("data:image/png").count() == 3, "{page}");
    let files = names_in(&folder.path().join("page"));
    assert_eq!(files.len(), 4, "{files:?}");
    assert!(
        files
            .iter()
            .filter(|name| name.ends_with(".png"))
            .all(|name| { read_png(&folder.path().join("page").join(name)).unwrap().size() == (48, 32) })
    );
    let csv = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("picture,frames,SSIM,PSNR dB,FLIP,RMS,bias"));
    assert!(lines.next().unwrap().starts_with("\"a,b.png\",1,0."), "{csv}");
    let latex = fs::read_to_string(folder.path().join("a.tex")).unwrap();
    assert!(latex.starts_with("\\begin{tabular}{lrrrrrr}"), "{latex}");
    let printed = succeed(folder.path(), "metrics reference.png a,b.png --csv - --quiet").stdout;
    assert_eq!(printed, csv);
}

#[test]
fn what_cannot_be_compared_is_named() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a.png", 0);
    RgbImage::new(8, 8).save_with_format(folder.path().join("small.png"), ImageFormat::Png).unwrap();
    fs::write(folder.path().join("text.png"), "no picture").unwrap();
    for (arguments, code, said) in [
        ("metrics a.png", 2, "PICTURE"),
        ("metrics a.png b.png", 1, "b.png: there is no such file"),
        ("metrics a.png text.png", 1, "text.png"),
        ("metrics a.png small.png", 2, "small.png is 8x8 and the reference 48x32"),
        (
            "metrics a.png a.png --vdp --csv missing/a.csv",
            1,
            "cannot write missing/a.csv: the folder missing",
        ),
        ("metrics a.png =a.png", 1, "'=a.png' names no picture"),
        ("metrics a.png b=", 1, "'b=' names no picture"),
        ("metrics a.png a.png --csv - --json -", 2, "--json and --csv are both to go to stdout"),
        ("metrics a.png a.png --csv - --latex -", 2, "--csv and --latex are both to go to stdout"),
    ] {
        let outcome = sheer(folder.path(), arguments);
        assert_eq!(outcome.code, Some(code), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(said) && outcome.stdout.is_empty(), "{arguments}: {outcome:?}");
    }
}

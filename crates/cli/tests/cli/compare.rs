//! `sheer compare`.

use std::fs;

use sheer_image::read_png;

use crate::run::{assert_numbers, json, names_in, sheer, succeed};

#[test]
fn a_report_has_the_names_and_types_of_its_contract() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = succeed(
        folder.path(),
        "compare layers -m std -m roulette -a taa -a none --size 32x18 --frames 4 --seed 3 --threads 1 -o out",
    );
    let report = json(&fs::read_to_string(folder.path().join("out/report.json")).unwrap());
    assert_eq!(report["scene"], "layers");
    assert_eq!(report["size"], serde_json::json!([32, 18]));
    assert_eq!(report["backend"], "cpu");
    assert_numbers(&report, &["frames", "seed", "threads"]);
    assert_eq!((&report["frames"], &report["seed"], &report["threads"]), (&4.into(), &3.into(), &1.into()));
    for name in ["adapter", "version", "commit", "scene_hash", "shadow"] {
        assert!(report[name].as_str().is_some_and(|text| !text.is_empty()), "{name}");
    }
    let rows = report["rows"].as_array().unwrap();
    let named =
        |name: &str| rows.iter().map(|row| row[name].as_str().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(named("method"), ["baseline", "std", "roulette", "baseline", "std", "roulette"]);
    assert_eq!(named("aa"), ["taa", "taa", "taa", "none", "none", "none"]);
    for row in rows {
        assert_numbers(row, &["ms_median", "ms_min", "ms_max", "ssim", "flicker", "bias", "rms"]);
        assert_numbers(row, &["flip", "shaded_per_pixel", "hits_per_pixel"]);
        assert_numbers(row, &["memory_bytes_per_pixel", "merged_per_pixel"]);
        let is_reference = row["method"] == "baseline";
        assert_eq!(row["psnr_db"].is_null(), is_reference, "{row}");
        // The others dither each frame differently.
        assert_eq!(row["tpsnr_db"].is_null(), is_reference, "{row}");
        assert!(row.get("vdp_jod").is_none(), "{row}");
        assert_eq!(row["ssim"] == 1.0, is_reference, "{row}");
        assert_eq!(row["shaded_per_pixel"].as_f64().unwrap() <= 1.0, !is_reference, "{row}");
        assert_eq!(row["reference"], "same");
        assert!(row.get("ghosting").is_none(), "{row}");
    }
    // The table has a heading and a line for each row; talk is elsewhere.
    assert_eq!(outcome.stdout.lines().count(), 1 + rows.len(), "{}", outcome.stdout);
    assert!(outcome.stdout.starts_with("method"));
    assert!(outcome.stderr.contains("index.html"));
}

#[test]
fn the_folder_holds_page_report_and_pictures_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "compare layers -m std:hash=mcguire --size 32x18 --frames 2");
    let out = folder.path().join("sheer-out");
    let names = [
        "index.html",
        "layered-baseline.png",
        "layered-std-hash-mcguire-error.png",
        "layered-std-hash-mcguire.png",
        "report.json",
    ];
    assert_eq!(names_in(&out), names);
    assert_eq!(read_png(&out.join("layered-baseline.png")).unwrap().size(), (32, 18));
    let page = fs::read_to_string(out.join("index.html")).unwrap();
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 3);
    assert!(page.contains("std:hash=mcguire") && !page.contains("https:"));
    assert_eq!(names_in(folder.path()), ["sheer-out"]);
}

#[test]
fn clips_are_judged_as_a_whole_where_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "compare layers -m std -m dtaa -a taa --size 64x36 --frames 6 --vdp -o out";
    let stdout = succeed(folder.path(), arguments).stdout;
    let report = json(&fs::read_to_string(folder.path().join("out/report.json")).unwrap());
    let rows = report["rows"].as_array().unwrap();
    let jods: Vec<f64> = rows.iter().map(|row| row["vdp_jod"].as_f64().unwrap()).collect();
    assert_eq!(jods[0], 10.0, "the exact clip differs from itself");
    // Layers with the same threshold hide one another.
    assert!(jods[1] < 10.0 && jods[2] < jods[1], "{jods:?}");
    assert!(stdout.lines().next().unwrap().contains("VDP JOD"));

    let outcome = sheer(folder.path(), "compare layers --size 64x3 --vdp -o small");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("4 pixels"), "{outcome:?}");
}

#[test]
fn the_truth_stands_beside_the_same_antialiasing_where_both_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |references: &str, out: &str| {
        let arguments =
            format!("compare pane --camera path -m std -a taa -a none --size 32x18 --frames 8 -o {out}");
        let stdout = succeed(folder.path(), &format!("{arguments} {references}")).stdout;
        let report = json(&fs::read_to_string(folder.path().join(out).join("report.json")).unwrap());
        let heading = stdout.lines().next().unwrap().to_owned();
        (heading, report["rows"].as_array().unwrap().clone())
    };
    let (heading, both) = compare("--reference same --reference truth:samples=4", "both");
    assert!(heading.contains("truth SSIM") && heading.matches("SSIM").count() == 2, "{heading}");
    let of =
        |reference: &str| -> Vec<_> { both.iter().filter(|row| row["reference"] == reference).collect() };
    let (same, truth) = (of("same"), of("truth:samples=4"));
    assert_eq!((same.len(), truth.len(), both.len()), (4, 4, 8));
    for (same, truth) in same.into_iter().zip(truth) {
        assert_eq!((&same["method"], &same["aa"]), (&truth["method"], &truth["aa"]));
        assert_numbers(
            truth,
            &["ssim", "psnr_db", "tpsnr_db", "flip", "flicker", "bias", "rms", "ms_median"],
        );
        assert!(truth["ssim"].as_f64().unwrap() < 1.0, "{truth}");
        assert_eq!(same["ssim"] == 1.0, same["method"] == "baseline", "{same}");
    }
    let names = names_in(&folder.path().join("both"));
    for name in ["taa-truth.png", "none-truth.png", "taa-baseline-error.png", "taa-std-error.png"] {
        assert!(names.iter().any(|found| found == name), "{name} is not among {names:?}");
    }

    let (heading, alone) = compare("--reference truth", "alone");
    assert!(heading.contains("truth SSIM") && heading.matches("SSIM").count() == 1, "{heading}");
    assert!(alone.len() == 4 && alone.iter().all(|row| row["reference"] == "truth"), "{alone:?}");

    let twice = sheer(folder.path(), "compare pane --reference truth,truth:samples=4 -o twice");
    assert_eq!(twice.code, Some(2), "{twice:?}");
    assert!(twice.stderr.contains("one truth"), "{twice:?}");
}

#[test]
fn a_single_frame_has_no_change() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "compare layers -m std --size 32x18 --frames 1 -o out");
    let report = json(&fs::read_to_string(folder.path().join("out/report.json")).unwrap());
    assert!(report["rows"].as_array().unwrap().iter().all(|row| row["tpsnr_db"].is_null()));
}

#[test]
fn memory_and_merged_fragments_of_the_family_are_in_the_report() {
    let folder = tempfile::tempdir().unwrap();
    succeed(
        folder.path(),
        "compare layers:count=6 -m std -m list -m mlab:k=4 -m peel -a none --size 32x18 --frames 1 -o out",
    );
    let report = json(&fs::read_to_string(folder.path().join("out/report.json")).unwrap());
    let figures = |method: &str| {
        let row = report["rows"].as_array().unwrap().iter().find(|row| row["method"] == method).unwrap();
        ["memory_bytes_per_pixel", "merged_per_pixel"].map(|name| row[name].as_f64().unwrap())
    };
    assert_eq!(figures("std"), [0.0, 0.0]);
    // Six fragments a pixel, of 16 bytes each.
    assert_eq!(figures("list"), [96.0, 0.0]);
    assert_eq!(figures("mlab:k=4"), [48.0, 2.0]);
    assert_eq!(figures("peel"), [12.0, 0.0]);
}

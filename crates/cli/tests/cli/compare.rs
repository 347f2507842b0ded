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
fn pictures_of_other_programs_stand_beside_the_methods() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let clip = "layers:count=2 --size 32x18 --frames 4..12";
    for frames in ["own/##.exr", "shown/##.png"] {
        succeed(folder, &format!("render {clip} -m std -a taa --warm-up 0 -o {frames}"));
    }
    succeed(folder, "render layers:count=2 --size 32x18 -m baseline -a none --frames 1 -o one.exr");
    let with = "--with own=own/##.exr --with shown=shown/##.png --with one=one.exr";
    let both = "--reference same,truth:samples=2 --csv a.csv";
    let outcome = succeed(folder, &format!("compare {clip} -m std -a taa -a none {with} {both} -o out"));

    let report = json(&fs::read_to_string(folder.join("out/report.json")).unwrap());
    let rows = report["rows"].as_array().unwrap();
    let row = |method: &str, aa: &str, reference: &str| {
        let is_meant = |row: &&serde_json::Value| {
            row["method"] == method && row["aa"] == aa && row["reference"] == reference
        };
        rows.iter().find(is_meant).unwrap_or_else(|| panic!("{method} {aa} {reference}"))
    };
    // Two methods and three others, under two anti-aliasings, against two references.
    assert_eq!(rows.len(), 20);
    for reference in ["same", "truth:samples=2"] {
        // The pictures are those of the method.
        let [own, shown, std] = ["own", "shown", "std"].map(|name| row(name, "taa", reference));
        for figure in ["ssim", "psnr_db", "tpsnr_db", "flip", "flicker", "rms", "bias"] {
            assert_eq!(own[figure], std[figure], "{figure} {reference}");
        }
        // Eight bits are less, and say nothing of linear light.
        let [of_shown, of_std] = [shown, std].map(|row| row["ssim"].as_f64().unwrap());
        assert!((of_shown - of_std).abs() < 0.01 && of_shown != of_std, "{of_shown} and {of_std}");
        assert!(shown["rms"].is_null() && shown["bias"].is_null(), "{shown}");
        assert_eq!(own["pictures"], "own/##.exr");
        assert!(own["ms_median"].is_null() && own["shaded_per_pixel"].is_null(), "{own}");
        assert!(std["ms_median"].is_number() && std.get("pictures").is_none(), "{std}");
    }
    let one = row("one", "none", "same");
    assert!(one["flicker"].is_null() && one["tpsnr_db"].is_null(), "one picture has no change: {one}");
    // Without anti-aliasing this still scene is the same in every frame, and the picture is exact.
    assert_eq!((&one["psnr_db"], one["rms"].as_f64()), (&serde_json::Value::Null, Some(0.0)));
    assert_ne!(row("own", "none", "same")["rms"], 0.0, "the check is not blind");

    assert_eq!(outcome.stdout.lines().filter(|line| line.starts_with("own ")).count(), 2);
    let csv = fs::read_to_string(folder.join("a.csv")).unwrap();
    assert!(csv.lines().any(|line| line.starts_with("own,taa,,,,0.")), "{csv}");
    let page = fs::read_to_string(folder.join("out/index.html")).unwrap();
    assert!(page.contains("Pictures of another program") && page.contains("data-label=\"own · taa\""));
    let names = names_in(&folder.join("out"));
    for name in ["taa-own.png", "taa-own-error.png", "none-one.png", "none-one-error.png"] {
        assert!(names.iter().any(|found| found == name), "{name} is not among {names:?}");
    }

    for (with, code, said) in [
        ("own", 2, "give NAME=PATTERN"),
        ("std=one.exr", 2, "a picture of that name"),
        ("truth=one.exr", 2, "a picture of that name"),
        ("a=absent.png", 1, "absent.png: there is no such picture"),
        ("a=own/###.exr", 1, "own/008.exr: there is no such picture; --with a takes those of frames 8 to 11"),
        ("a=out/report.json", 1, "report.json"),
    ] {
        let outcome = sheer(folder, &format!("compare {clip} -m std --with {with} -o refused"));
        assert_eq!(outcome.code, Some(code), "{with}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{with}: {outcome:?}");
    }
    assert!(!folder.join("refused").exists(), "a folder is left without a report");
    let outcome = sheer(folder, "compare layers --size 32x20 --frames 1 -m std --with a=one.exr -o refused");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("one.exr is 32x18 and the comparison 32x20"), "{outcome:?}");
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

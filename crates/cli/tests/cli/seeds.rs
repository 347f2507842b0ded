//! `--seeds` of `compare` and `bench`, and pictures of several seeds in `metrics`: means with intervals.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{fs, path::Path};

use image::{Rgb, RgbImage};
use serde_json::Value;

use crate::run::{json, sheer, succeed};

/// Half of the 95 % confidence interval of three numbers: Student's t of two degrees of freedom in closed
/// form.
fn half_width(values: [f64; 3]) -> f64 {
    let mean = values.iter().sum::<f64>() / 3.0;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 2.0;
    0.95 * (2.0 / (1.0 - 0.95_f64.powi(2))).sqrt() * (variance / 3.0).sqrt()
}

fn report(folder: &Path, out: &str) -> Value {
    json(&fs::read_to_string(folder.join(out).join("report.json")).unwrap())
}

fn row<'r>(report: &'r Value, method: &str) -> &'r Value {
    report["rows"].as_array().unwrap().iter().find(|row| row["method"] == method).unwrap()
}

#[test]
fn figures_over_seeds_are_means_with_the_interval_of_their_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let clip = "compare layers -m std -m weighted -a taa --size 24x14 --frames 4";
    let outcome = succeed(folder, &format!("{clip} --seed 7 --seeds 3 --csv a.csv --latex a.tex -o all"));
    let all = report(folder, "all");
    assert_eq!((&all["seed"], &all["seeds"]), (&7.into(), &3.into()));
    let alone = [7, 8, 9].map(|seed| {
        let stdout = succeed(folder, &format!("{clip} --seed {seed} -o {seed}")).stdout;
        assert!(!stdout.contains('±') && !stdout.contains("seeds"), "{stdout}");
        report(folder, &seed.to_string())
    });
    assert!(alone[0].get("seeds").is_none() && row(&alone[0], "std").get("ci95").is_none());

    let std = row(&all, "std");
    assert_eq!(std["seeds"], 3);
    for figure in ["ssim", "psnr_db", "flip", "flicker", "rms", "bias", "shaded_per_pixel"] {
        let values = [0, 1, 2].map(|at| row(&alone[at], "std")[figure].as_f64().unwrap());
        let [mean, half] = [&std[figure], &std["ci95"][figure]].map(|value| value.as_f64().unwrap());
        assert!((mean - values.iter().sum::<f64>() / 3.0).abs() < 1e-9 * mean.abs().max(1.0), "{figure}");
        let expected = half_width(values);
        assert!((half - expected).abs() < 1e-6 * expected.max(1e-6), "{figure}: {half}, not {expected}");
    }
    let interval = std["ci95"]["ssim"].as_f64().unwrap();
    assert!(interval > 0.0, "the check is blind");
    // What is not random has nothing to vary, and the exact one was rendered once.
    let [weighted, baseline] = ["weighted", "baseline"].map(|method| row(&all, method));
    assert_eq!((&weighted["seeds"], &baseline["seeds"]), (&3.into(), &1.into()));
    for figure in ["ssim", "rms", "bias", "shaded_per_pixel"] {
        assert_eq!((&weighted["ci95"][figure], &baseline["ci95"][figure]), (&0.0.into(), &0.0.into()));
    }
    assert!(weighted["ci95"]["ms_median"].is_number() && baseline["ci95"]["ms_median"].is_null());
    assert!(
        outcome
            .stderr
            .contains("the same with every seed, which is why the interval is ±0: baseline, weighted"),
        "{outcome:?}"
    );
    let line = outcome.stdout.lines().find(|line| line.starts_with("weighted")).unwrap();
    assert!(line.contains(" ±0 ") && outcome.stdout.contains("SSIM"), "{outcome:?}");

    let csv = fs::read_to_string(folder.join("a.csv")).unwrap();
    let cells =
        |line: usize| csv.lines().nth(line).unwrap().split(',').map(str::to_owned).collect::<Vec<_>>();
    let at = cells(0).iter().position(|title| title == "SSIM ci95").unwrap();
    let of_std = (1..).map(cells).find(|cells| cells[0] == "std").unwrap();
    assert!((of_std[at].parse::<f64>().unwrap() - interval).abs() < 1e-9, "{csv}");
    assert_eq!(cells(0)[at - 1], "SSIM");
    let latex = fs::read_to_string(folder.join("a.tex")).unwrap();
    assert!(latex.contains("$\\pm$") && !latex.contains('±'), "{latex}");
    let page = fs::read_to_string(folder.join("all/index.html")).unwrap();
    assert!(page.contains("means over 3 seeds from 7 on"), "the page does not say so");
}

#[test]
fn where_shadows_are_random_each_seed_has_a_reference_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let clip = "compare layers -m std -a none --size 24x14 --frames 2 --reference same,truth:samples=2 \
                --shadow stochastic-map:resolution=16";
    succeed(folder, &format!("{clip} --seeds 2 -o both"));
    let both = report(folder, "both");
    assert_eq!((&row(&both, "baseline")["seeds"], &row(&both, "std")["seeds"]), (&2.into(), &2.into()));
    for seed in [0, 1] {
        succeed(folder, &format!("{clip} --seed {seed} -o {seed}"));
    }
    let [first, second] = ["0", "1"].map(|out| row(&report(folder, out), "std")["rms"].as_f64().unwrap());
    let mean = row(&both, "std")["rms"].as_f64().unwrap();
    assert!((mean - 0.5 * (first + second)).abs() < 1e-9, "{mean}, not that of {first} and {second}");
}

#[test]
fn what_frames_cost_is_measured_with_each_seed() {
    let folder = tempfile::tempdir().unwrap();
    let bench =
        "bench calibration -m baseline -m std --size 24x14 --frames 2 --seeds 3 --json a.json --html a.html";
    let outcome = succeed(folder.path(), bench);
    let report = json(&fs::read_to_string(folder.path().join("a.json")).unwrap());
    assert_eq!(report["seeds"], 3);
    let [baseline, std] = ["baseline", "std"].map(|method| row(&report, method));
    for row in [baseline, std] {
        assert_eq!((&row["seeds"], row["ms"].as_array().unwrap().len()), (&3.into(), 2), "{row}");
        assert!(row["ci95"]["ms_median"].as_f64().unwrap() > 0.0, "{row}");
    }
    // The ratio is that of each seed.
    assert_eq!((&baseline["ratio"], &baseline["ci95"]["ratio"]), (&1.0.into(), &0.0.into()));
    assert_eq!(baseline["ci95"]["shaded"], 0.0);
    assert!(std["ci95"]["shaded"].as_f64().unwrap() > 0.0, "{std}");
    assert!(outcome.stderr.contains("±0: baseline\n"), "{outcome:?}");
    assert!(fs::read_to_string(folder.path().join("a.html")).unwrap().contains("over 3 seeds"));
    for wrong in ["--seeds 0", "--seeds 101", "--seeds x"] {
        assert_eq!(sheer(folder.path(), &format!("bench layers {wrong}")).code, Some(2), "{wrong}");
    }
}

#[test]
fn pictures_under_one_name_are_those_of_several_seeds() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, brighter) in [("reference", 0), ("a", 10), ("b", 20), ("c", 40)] {
        let picture = RgbImage::from_fn(48, 32, |x, y| Rgb([(2 * x + y) as u8 + brighter; 3]));
        picture.save(folder.join(format!("{name}.png"))).unwrap();
    }
    let rows = |arguments: &str| {
        let text = succeed(folder, &format!("metrics reference.png {arguments} --json -")).stdout;
        json(&text)["rows"].as_array().unwrap().clone()
    };
    let together = rows("x=a.png x=b.png other=reference.png x=c.png");
    assert_eq!((together.len(), &together[0]["picture"], &together[0]["seeds"]), (2, &"x".into(), &3.into()));
    assert!(together[1].get("ci95").is_none(), "{:?}", together[1]);
    let values = [0, 1, 2].map(|at| rows("a.png b.png c.png")[at]["rms"].as_f64().unwrap());
    let [mean, half] =
        [&together[0]["rms"], &together[0]["ci95"]["rms"]].map(|value| value.as_f64().unwrap());
    assert!((mean - values.iter().sum::<f64>() / 3.0).abs() < 1e-9);
    assert!((half / half_width(values) - 1.0).abs() < 1e-6, "{half}");
    let table = succeed(folder, "metrics reference.png x=a.png x=b.png x=c.png y=a.png --html page").stdout;
    assert!(table.contains('±') && table.lines().count() == 3, "{table}");
}

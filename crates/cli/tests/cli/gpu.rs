//! `sheer devices` and `--backend gpu`.

use std::fs;

use sheer_image::{Planes, read_exr, read_png};
use sheer_metrics::rms;

use crate::run::{json, sheer, succeed};

#[test]
fn devices_lists_every_adapter_in_words_and_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = succeed(folder.path(), "devices --json a.json");
    assert_eq!(outcome.stderr, "");
    let report = json(&fs::read_to_string(folder.path().join("a.json")).unwrap());
    let devices = report["devices"].as_array().unwrap();
    assert!(!devices.is_empty());
    assert_eq!(outcome.stdout.lines().count(), 1 + devices.len(), "{}", outcome.stdout);
    for (index, device) in devices.iter().enumerate() {
        assert_eq!(device["index"], index);
        for name in ["name", "type", "driver", "api", "automatic"] {
            assert!(device[name].as_str().is_some_and(|text| !text.is_empty()), "{name}: {device}");
        }
        assert!(device["ray_query"].is_boolean() && device["timestamps"].is_boolean(), "{device}");
        assert!(device["msaa"].is_array() && device["max_storage_bytes"].is_u64(), "{device}");
        assert!(device["paths"].as_array().unwrap().contains(&device["automatic"]), "{device}");
        assert!(outcome.stdout.contains(device["name"].as_str().unwrap()), "{}", outcome.stdout);
    }
    let stdout = succeed(folder.path(), "devices --json -").stdout;
    assert_eq!(json(&stdout), report);
}

#[test]
fn an_adapter_that_is_not_there_is_a_failure_that_says_which_are() {
    let folder = tempfile::tempdir().unwrap();
    let report = json(&succeed(folder.path(), "devices --json -").stdout);
    let name = report["devices"][0]["name"].as_str().unwrap();
    let outcome = sheer(folder.path(), "render layers --size 8x8 --backend gpu --adapter abacus -o a.png");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("'abacus'") && outcome.stderr.contains(name), "{outcome:?}");
    assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
}

#[test]
fn what_is_asked_for_wrongly_is_wrong_use_on_a_gpu_too() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = sheer(folder.path(), "render layers --camera nix --size 8x8 --backend gpu -o a.png");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("no camera 'nix'"), "{outcome:?}");
}

#[test]
fn raw_frames_are_the_processors_samples_with_layers() {
    let folder = tempfile::tempdir().unwrap();
    let planes = |name: &str| read_exr(&folder.path().join(name)).unwrap();
    let raw = "render layers:count=3,colours=red-green,background=1 -m std --camera orbit --size 16x9 --raw";
    for (backend, frames) in [("cpu", "--first-frame 4 --frames 1"), ("gpu:ray", "--frames 5")] {
        let file = backend.replace(':', "-");
        succeed(folder.path(), &format!("{raw} {frames} --backend {backend} -o {file}-####.exr"));
    }
    let [cpu, gpu, before] = ["cpu-0004.exr", "gpu-ray-0004.exr", "gpu-ray-0003.exr"].map(planes);
    let colour = |planes: &Planes| planes.colour.par_map(|&[r, g, b, _]| [r, g, b]);
    // One sample of three layers: rounding. Frames that were added up, or another frame's, are further apart
    // by far.
    assert!(rms(&colour(&cpu), &colour(&gpu)).unwrap() < 1e-5);
    assert!(rms(&colour(&gpu), &colour(&before)).unwrap() > 1e-2);
    let layers = |planes: Planes| planes.layers.expect("raw frames have layers").into_vec();
    for (cpu, gpu) in layers(cpu).iter().zip(layers(gpu)) {
        assert_eq!(cpu.is_front, gpu.is_front);
        assert!((cpu.coverage - gpu.coverage).abs() < 1e-6, "{cpu:?} {gpu:?}");
        let motions = [(cpu.front_motion, gpu.front_motion), (cpu.back_motion, gpu.back_motion)];
        assert!(
            motions.iter().all(|(a, b)| (0..2).all(|axis| (a[axis] - b[axis]).abs() < 1e-3)),
            "{cpu:?} {gpu:?}"
        );
    }
}

#[test]
fn the_truth_is_to_be_had_from_the_device() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |backend: &str| {
        let arguments = "compare layers:count=3 -m baseline -m std -a taa --size 16x9 --frames 4";
        let truth = "--reference truth:samples=4";
        succeed(folder.path(), &format!("{arguments} {truth} --backend {backend} -o out"));
        json(&fs::read_to_string(folder.path().join("out/report.json")).unwrap())
    };
    let [cpu, gpu] = ["cpu", "gpu:ray"].map(compare);
    for (cpu, gpu) in cpu["rows"].as_array().unwrap().iter().zip(gpu["rows"].as_array().unwrap()) {
        assert_eq!([&cpu["method"], &cpu["reference"]], [&gpu["method"], &gpu["reference"]]);
        let error = |row: &serde_json::Value| row["rms"].as_f64().unwrap();
        assert!((error(cpu) - error(gpu)).abs() < 1e-4, "{cpu} {gpu}");
    }
}

#[test]
fn a_picture_by_rays_is_the_processors_and_says_nothing_of_the_driver() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let arguments = "render layers -m baseline -a none --size 64x36";
    for backend in ["cpu", "gpu:ray"] {
        let file = backend.replace(':', "-");
        let outcome = succeed(folder.path(), &format!("{arguments} --backend {backend} -o {file}.exr"));
        assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
        succeed(folder.path(), &format!("{arguments} --backend {backend} -o {file}.png --quiet"));
        assert_eq!(read_png(&path(&format!("{file}.png"))).unwrap().size(), (64, 36));
    }
    let colour = |name: &str| read_exr(&path(name)).unwrap().colour.par_map(|&[r, g, b, _]| [r, g, b]);
    // Sums of nine layers of at most 1 each: rounding. Pictures of another number of layers are further apart
    // by far.
    let difference = rms(&colour("cpu.exr"), &colour("gpu-ray.exr")).unwrap();
    assert!(difference < 1e-5, "{difference}");
    succeed(folder.path(), "render layers:count=7 -m baseline -a none --size 64x36 -o other.exr");
    assert!(rms(&colour("cpu.exr"), &colour("other.exr")).unwrap() > 1e-3);
}

#[test]
fn reports_name_backend_and_adapter_and_passes_have_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let devices = json(&succeed(folder.path(), "devices --json -").stdout);
    let [name, driver] =
        ["name", "driver"].map(|key| devices["devices"][0][key].as_str().unwrap().to_owned());
    let arguments = "bench layers -m baseline -m std --size 32x18 --frames 3 --backend gpu:ray";
    let outcome = succeed(folder.path(), &format!("{arguments} --json a.json --html a.html"));
    let report = json(&fs::read_to_string(folder.path().join("a.json")).unwrap());
    assert_eq!(report["backend"], "gpu:ray");
    let adapter = report["adapter"].as_str().unwrap();
    assert!(adapter.contains(&name) && adapter.contains(&driver), "{adapter}");
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap();
    let is_timed = devices["devices"][0]["timestamps"] == true;
    assert_eq!(page.contains("Passes"), is_timed);
    for row in report["rows"].as_array().unwrap() {
        assert_eq!(row.get("steps").is_some(), is_timed, "{row}");
        for step in row["steps"].as_array().into_iter().flatten() {
            assert!(step["ms_median"].as_f64().unwrap() >= 0.0, "{row}");
            let step = step["name"].as_str().unwrap();
            assert!(outcome.stdout.contains(step) && page.contains(step), "{step}");
        }
    }

    succeed(folder.path(), "compare layers -m std --size 32x18 --frames 2 --backend gpu:ray -o out");
    let report = json(&fs::read_to_string(folder.path().join("out/report.json")).unwrap());
    assert_eq!((&report["backend"], report["adapter"].as_str().unwrap()), (&"gpu:ray".into(), adapter));
    let on_processor = succeed(folder.path(), "bench layers -m std --size 8x8 --frames 1 --json -").stdout;
    assert!(json(&on_processor)["rows"][0].get("steps").is_none());
}

#[test]
fn memory_is_what_was_allocated_and_a_reference_that_overflows_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |scene: &str| {
        let arguments = format!("compare {scene} -m weighted --size 32x18 --frames 2 -a none");
        let outcome = succeed(folder.path(), &format!("{arguments} --backend gpu:raster -o out"));
        let report = json(&fs::read_to_string(folder.path().join("out/report.json")).unwrap());
        let rows = report["rows"].as_array().unwrap();
        // Sums in four half floats and a transmittance in one.
        assert_eq!(rows[1]["memory_bytes_per_pixel"], 10.0, "{report}");
        let merged = rows[0]["merged_per_pixel"].as_f64().unwrap();
        (outcome.stderr.contains("not against the exact answer"), merged)
    };
    assert_eq!(compare("layers:count=4"), (false, 0.0));
    // A pool of 32 fragments a pixel.
    let (is_said, merged) = compare("layers:count=40");
    assert!(is_said && (merged - 8.0).abs() < 1e-6, "{is_said} {merged}");
}

#[test]
fn calibration_on_a_gpu_shows_the_processors_opacities() {
    let folder = tempfile::tempdir().unwrap();
    let table = |backend: &str| {
        let arguments = "calibrate -m baseline -a none --size 160x90 --frames 2 --backend";
        succeed(folder.path(), &format!("{arguments} {backend}")).stdout
    };
    assert_eq!(table("gpu:ray"), table("cpu"));
}

#[test]
fn experiments_say_which_backend_made_them_and_what_it_does_not_run() {
    let folder = tempfile::tempdir().unwrap();
    // Curves without a picture, and a method that is not to be had by rays.
    let arguments = "experiments sequences growth --size 16x9 --backend gpu:ray -o out";
    let outcome = succeed(folder.path(), arguments);
    assert!(outcome.stderr.contains("growth is not run by --backend gpu:ray"), "{outcome:?}");
    assert!(outcome.stdout.contains("not run: method list"), "{outcome:?}");
    let report = json(&fs::read_to_string(folder.path().join("out/experiments.json")).unwrap());
    assert_eq!(report["backend"], "gpu:ray");
    let experiments = report["experiments"].as_array().unwrap();
    assert!(experiments[0].get("refused").is_none() && experiments[1]["refused"].is_string(), "{report}");
}

//! `sheer calibrate`.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::fs;

use crate::run::{json, sheer, succeed};

/// The measured opacities of a table.
fn measured(stdout: &str) -> Vec<f64> {
    let rows = stdout.lines().skip(1).take(10);
    rows.map(|row| row.split_whitespace().nth(2).unwrap().parse().unwrap()).collect()
}

#[test]
fn accumulation_shows_the_opacities_and_its_file_corrects_a_method() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "calibrate -m roulette -a accumulate --size 320x180 --frames 32 -o a.json";
    let opacities = measured(&succeed(folder.path(), arguments).stdout);
    // Independent pixels, 26 by 84. A frame k counts with the mean of 1/n over those means of n frames, the
    // last 16, that it is in.
    let weights = (1..=32_u32).map(|k| (k.max(17)..=32).map(|n| 1.0 / f64::from(n)).sum::<f64>() / 16.0);
    let share = weights.map(|weight| weight * weight).sum::<f64>() / (26.0 * 84.0);
    for (level, opacity) in opacities.iter().enumerate() {
        let alpha = (level + 1) as f64 / 10.0;
        let deviation = (alpha * (1.0 - alpha) * share).sqrt();
        // Four decimals are printed.
        assert!((opacity - alpha).abs() < 4.0 * deviation + 1e-4, "{opacity} for {alpha} ± {deviation}");
    }
    let file = json(&fs::read_to_string(folder.path().join("a.json")).unwrap());
    assert_eq!(file["coefficients"].as_array().unwrap().len(), 4);

    fs::write(folder.path().join("half.json"), r#"{"coefficients":[0,0.5,0,0]}"#).unwrap();
    let halved = "calibrate -m roulette:correction=half.json -a accumulate --size 320x180 --frames 32";
    let halved = measured(&succeed(folder.path(), halved).stdout);
    assert!((halved[7] - 0.4).abs() < 0.02, "{halved:?}");
}

#[test]
fn a_correction_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bad.json"), r#"{"coefficients":[0,1]}"#).unwrap();
    for file in ["missing.json", "bad.json"] {
        let outcome = sheer(folder.path(), &format!("calibrate -m roulette:correction={file}"));
        assert_eq!(outcome.code, Some(2));
        assert!(outcome.stderr.contains(file) && outcome.stderr.contains("coefficients"), "{outcome:?}");
    }
}

//! Layered accumulation against plain temporal anti-aliasing, both held against the truth.

use sheer_render::{Antialiasing, Backend};

use super::{
    claims::{Sample, at_least, at_most, greater},
    findings::{Claim, Findings},
    lab::{Lab, Played, Take},
};
use crate::{AgainstTruth, Result};

const METHODS: &[&str] = &["std", "joint"];
const COLUMNS: &[&str] = &[
    "ms",
    "truth SSIM",
    "truth PSNR dB",
    "truth tPSNR dB",
    "truth flicker",
    "ghosting",
    "truth RMS",
    "truth bias",
    "shaded/px",
    "hits/px",
];
/// Samples a pixel of the truth: fewer than `compare` takes, as most of the time goes there.
const TRUTH_SAMPLES: u32 = 8;
const FRAMES: u32 = 16;
/// The moving clips: scene, camera, start in seconds.
const CLIPS: [(&str, &str, f32); 5] = [
    ("pane", "path", 0.0),
    ("arena", "static", 6.0),
    ("motor", "orbit", 1.0),
    ("windy-hill", "static", 1.0),
    ("smoke-square", "path", 3.0),
];
/// Of the way from `std` to `baseline`, both under TAA, that layers are to go at least.
const WAY: f64 = 0.75;

/// A figure against the truth, by seed.
fn sample(played: &Played, method: &str, name: &str, of: impl Fn(&AgainstTruth) -> f64) -> Sample {
    let sample = played.sample(method, |row| row.against_truth.as_ref().map_or(f64::NAN, &of));
    Sample::new(name, sample.values)
}

/// The same of each seed for what has no chance.
fn repeated(sample: &Sample, count: usize) -> Sample {
    Sample::new(sample.name.clone(), vec![sample.values[0]; count])
}

/// Claims of one clip, and the two ways whose ratio decides on average.
fn judge(scene: &str, under_taa: &Played, under_layers: &Played) -> (Vec<Claim>, [Sample; 2]) {
    let ssim = |played, method, name| sample(played, method, name, |row| row.ssim);
    let layered = ssim(under_layers, "joint", "joint under layered");
    let std = ssim(under_taa, "std", "std under taa");
    let joint = ssim(under_taa, "joint", "joint under taa");
    let count = layered.values.len();
    let baseline = repeated(&ssim(under_taa, "baseline", "baseline under taa"), count);
    let quantity = format!("{scene}: SSIM to the truth");
    let mut claims = vec![
        greater(&quantity, &layered, &std),
        greater(&quantity, &layered, &joint),
        greater(&quantity, &layered, &baseline).remark(
            "One shaded fragment a pixel is ahead of the exact method under plain TAA.",
            "The exact method under plain TAA is ahead.",
        ),
    ];
    let rms = |played, method, name| sample(played, method, name, |row| row.rms);
    if scene == "smoke-square" {
        claims.push(at_most(
            &format!("{scene}: RMS to the truth"),
            &rms(under_layers, "joint", "joint under layered"),
            0.5,
            &rms(under_taa, "std", "std under taa"),
        ));
    }
    let flicker = |played, method, name| sample(played, method, name, |row| row.flicker);
    claims.push(at_most(
        &format!("{scene}: flicker"),
        &flicker(under_layers, "joint", "joint under layered"),
        1.2,
        &repeated(&flicker(under_taa, "baseline", "baseline under taa"), count),
    ));
    let over_std = |of: &Sample| of.values.iter().zip(&std.values).map(|(own, std)| own - std).collect();
    (claims, [&layered, &baseline].map(|of| Sample::new(of.name.clone(), over_std(of))))
}

/// Each clip under both.
pub(super) fn layered<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut ways: [Vec<Sample>; 2] = Default::default();
    for (scene, camera, start_secs) in CLIPS {
        let take = Take {
            scene,
            alpha: None,
            camera,
            start_secs,
            frames: FRAMES,
            antialiasing: Antialiasing::TAA,
            methods: METHODS,
            truth_samples: Some(TRUTH_SAMPLES),
        };
        let mut truth = lab.truth(&take);
        let under_taa = lab.play_with(&take, &mut truth)?;
        let take = Take { antialiasing: Antialiasing::LAYERED, ..take };
        let under_layers = lab.play_with(&take, &mut truth)?;
        let (claims, way) = judge(scene, &under_taa, &under_layers);
        findings.claims.extend(claims);
        for (ways, way) in ways.iter_mut().zip(way) {
            ways.push(way);
        }
        for (played, label) in [(&under_taa, "taa"), (&under_layers, "layered")] {
            findings.commands.push(played.command.clone());
            findings.tables.push((format!("{scene} under {label}"), played.figures(COLUMNS)));
            findings.pictures.extend(played.pictures(&["baseline", "std", "joint"]).map(|mut picture| {
                picture.label = format!("{scene}: {} under {label}", picture.label);
                picture
            }));
        }
    }
    let [layered, baseline] = ways.map(|ways| mean_of(&ways));
    findings.claims.push(at_least(
        "lead in SSIM over std under taa, mean of the clips,",
        &layered,
        WAY,
        &baseline,
    ));
    Ok(findings)
}

/// The mean of several samples, seed by seed.
fn mean_of(samples: &[Sample]) -> Sample {
    let seeds = samples[0].values.len();
    let mean =
        |seed: usize| samples.iter().map(|sample| sample.values[seed]).sum::<f64>() / samples.len() as f64;
    Sample::new(samples[0].name.clone(), (0..seeds).map(mean).collect())
}

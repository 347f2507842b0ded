//! What the static blue noise that all layers share does, and the worst opacity of nine thresholds.

use sheer_render::{Antialiasing, Backend, Settings, contract::Tables};

use super::{
    claims::{Sample, at_least, at_most, greater},
    findings::Findings,
    lab::{Lab, Take},
    layers::exponential_errors,
};
use crate::{
    Datum, Figures, Result,
    plot::{Axis, Plot, Series},
};

/// Stacks of equal layers: how many, and their alpha. In the last two every alpha passes the least stratum
/// alone.
const STACKS: [(u32, f32); 4] = [(2, 0.45), (8, 0.2), (20, 0.1), (40, 0.05)];
/// The paper's method, its maps redrawn after each cycle, an offset into the noise for each layer, and both.
const METHODS: [&str; 7] = [
    "roulette",
    "std",
    "std:rehash=9",
    "std:noise=object",
    "std:noise=object,rehash=9",
    "std:noise=off",
    "joint",
];

/// Stacks of faint layers, and the correlation of the error with the noise in still smoke.
pub(super) fn shared_noise<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let mut findings = Findings::default();
    stacks(lab, &mut findings)?;
    correlations(lab, &mut findings)?;
    Ok(findings)
}

/// Errors of exponential averages, which have a closed form to be held against.
fn stacks<B: Backend>(lab: &Lab<'_, B>, findings: &mut Findings) -> Result<()> {
    let mut rows = Vec::new();
    for (count, alpha) in STACKS {
        let errors = METHODS
            .iter()
            .map(|method| Ok(Sample::new(*method, exponential_errors(lab, method, count, alpha)?)))
            .collect::<Result<Vec<Sample>>>()?;
        let [roulette, std, redrawn, own, ..] = errors.as_slice() else {
            unreachable!("one sample a method")
        };
        let quantity = format!("{count} × {alpha}: RMS error");
        // Where alpha passes the least stratum alone, maps have no part in the decision.
        if f64::from(alpha) < 1.0 / 9.0 {
            findings.claims.push(at_least(&quantity, std, 2.0, roulette).remark(
                "All layers ask the same noise of the pixel: they are all there or all not.",
                "Layers that share their noise do not go together here.",
            ));
            findings.claims.push(at_least(&quantity, redrawn, 0.8, std).remark(
                "Other maps each nine frames do not help: below an alpha of 1/9 the map says only when, not whether.",
                "Other maps each nine frames help.",
            ));
            findings.claims.push(at_most(&quantity, own, 0.6, std).remark(
                "An offset into the noise for each layer makes them independent of one another.",
                "An offset into the noise for each layer is not enough.",
            ));
        }
        let numbers = errors.iter().map(|sample| Datum::Number(Some(sample.mean()), 4));
        rows.push([Datum::Word(format!("{count} × {alpha}"))].into_iter().chain(numbers).collect());
    }
    let titles: Vec<&str> = ["layers"].into_iter().chain(METHODS).collect();
    let caption = "RMS error of an exponential average of weight 0.1 without clipping; red and green layers over blue, mean of all seeds.";
    findings.tables.push((caption.to_owned(), Figures::of_data(&titles, rows)));
    Ok(())
}

/// Pearson's correlation of a picture's error with the blue noise of its pixels, where something transparent
/// is.
fn correlations<B: Backend>(lab: &Lab<'_, B>, findings: &mut Findings) -> Result<()> {
    const METHODS: [&str; 5] = ["std", "std:rehash=9", "std:noise=object", "roulette", "joint"];
    /// Four cycles of nine.
    const FRAMES: u32 = 36;
    const SMOKE_SECS: f32 = 6.0;
    let mut stage = lab.open("smoke-square", "static", None)?;
    let noise = Tables::get();
    let mut pictures = |method: &str, seed: u32| {
        let settings = Settings { seed, ..lab.settings(SMOKE_SECS) };
        let method = method.parse()?;
        lab.progress.step();
        Ok::<_, crate::LabError>(
            crate::picture(lab.backend, &mut stage, &method, Antialiasing::ACCUMULATE, settings, FRAMES)?.0,
        )
    };
    let exact = pictures("baseline", lab.seed)?;
    let mut samples = Vec::new();
    for method in METHODS {
        let mut values = Vec::new();
        for seed in lab.seeds() {
            let picture = pictures(method, seed)?;
            let mut pairs = Vec::new();
            for (x, y) in (0..picture.height()).flat_map(|y| (0..picture.width()).map(move |x| (x, y))) {
                if exact.transparent[(x, y)] || picture.transparent[(x, y)] {
                    let brightness = |colour: [f32; 4]| f64::from(colour[0] + colour[1] + colour[2]) / 3.0;
                    let error = brightness(picture.colour[(x, y)]) - brightness(exact.colour[(x, y)]);
                    pairs.push([error, f64::from(noise.blue_noise_at([x, y]))]);
                }
            }
            values.push(correlation(&pairs));
        }
        samples.push(Sample::new(method, values));
    }
    let strength = |at: usize| {
        let Sample { name, values } = &samples[at];
        Sample::new(name.clone(), values.iter().map(|value| value.abs()).collect())
    };
    let rows = samples
        .iter()
        .map(|sample| vec![Datum::Word(sample.name.clone()), Datum::Number(Some(sample.mean()), 3)]);
    let caption = "Correlation of the error of still smoke with the static blue noise, 36 frames of one moment added up.";
    findings.tables.push((caption.to_owned(), Figures::of_data(&["method", "correlation"], rows.collect())));
    let half = Sample::new("a quarter", vec![0.25; samples[0].values.len()]);
    findings.claims.push(
        greater("strength of the correlation of error and noise in still smoke", &strength(0), &half).remark(
            "What is left of error in stills is the noise that all layers share.",
            "The error is not that of the shared noise alone.",
        ),
    );
    findings.claims.push(
        greater("strength of the correlation", &strength(0), &strength(2))
            .remark("With an offset for each object the noise is gone from the error.", ""),
    );
    Ok(())
}

/// Pearson's correlation coefficient; 0 where either side never varies.
fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let count = pairs.len() as f64;
    let mean = |at: usize| pairs.iter().map(|pair| pair[at]).sum::<f64>() / count;
    let means = [mean(0), mean(1)];
    let product = |a: usize, b: usize| {
        pairs.iter().map(|pair| (pair[a] - means[a]) * (pair[b] - means[b])).sum::<f64>()
    };
    let scale = (product(0, 0) * product(1, 1)).sqrt();
    if scale > 0.0 { product(0, 1) / scale } else { 0.0 }
}

/// A still pane at every opacity that nine thresholds show without rounding, and at one half, which lies
/// between two.
pub(super) fn pane_opacities<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    const METHODS: [&str; 4] = ["roulette", "std", "stbn", "joint"];
    const NINTHS: [f32; 7] = [2.0, 3.0, 4.0, 4.5, 5.0, 6.0, 7.0];
    let mut findings = Findings::default();
    let mut rows = Vec::new();
    let mut by_alpha: Vec<Vec<Sample>> = Vec::new();
    for ninths in NINTHS {
        // At k ninths the least k strata pass whole, and no other.
        let scene = format!("pane:alpha={}", ninths / 9.0);
        let played = lab.play(&Take {
            scene: &scene,
            alpha: None,
            camera: "static",
            start_secs: 0.0,
            frames: 36,
            antialiasing: Antialiasing::TAA,
            methods: &METHODS,
            truth_samples: None,
        })?;
        let samples: Vec<Sample> =
            METHODS.iter().map(|method| played.sample(method, |row| row.ssim)).collect();
        let numbers = samples.iter().map(|sample| Datum::Number(Some(sample.mean()), 4));
        rows.push([Datum::Word(format!("{ninths}/9"))].into_iter().chain(numbers).collect());
        if ninths == 4.5 {
            findings.commands.push(played.command.clone());
        }
        by_alpha.push(samples);
    }
    let at = |alpha: usize, method: usize| {
        let Sample { name, values } = &by_alpha[alpha][method];
        Sample::new(format!("{name} at {}/9", NINTHS[alpha]), values.clone())
    };
    // Places among the methods and the opacities that claims are about.
    let (std, stbn) = (1, 2);
    let [third, four_ninths, half, five_ninths] = [1, 2, 3, 4];
    for other in [four_ninths, five_ninths] {
        findings.claims.push(greater("SSIM", &at(other, std), &at(half, std)).remark(
            "One half lies between two ninths: one threshold in nine decides by the blue noise alone, pixel by pixel.",
            "One half is no worse than its neighbours.",
        ));
    }
    for alpha in [third, four_ninths] {
        findings.claims.push(greater("SSIM", &at(alpha, std), &at(alpha, stbn)).remark(
            "Where alpha is a ninth, `std` is ahead of `stbn`, as the paper has it.",
            "`stbn` is ahead even where alpha is a ninth.",
        ));
    }
    findings.claims.push(
        greater("SSIM", &at(half, stbn), &at(half, std))
            .remark("The opacity that everybody tries first is the worst that `std` has.", ""),
    );
    let titles: Vec<&str> = ["alpha"].into_iter().chain(METHODS).collect();
    findings
        .tables
        .push(("SSIM of a still pane by its opacity.".to_owned(), Figures::of_data(&titles, rows)));
    let series = METHODS.iter().enumerate().map(|(method, name)| {
        let points = NINTHS
            .iter()
            .zip(&by_alpha)
            .map(|(ninths, samples)| [f64::from(ninths / 9.0), samples[method].mean()]);
        Series::line(name, points).with_dots()
    });
    findings.plots.push((
        "SSIM over the opacity of a still pane.".to_owned(),
        Plot {
            description: "SSIM of a still pane over its opacity, a line for each method".to_owned(),
            x: Axis::new("alpha"),
            y: Axis::new("SSIM"),
            series: series.collect(),
        },
    ));
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_is_one_of_what_goes_together_and_nothing_of_what_does_not() {
        let line: Vec<[f64; 2]> = (0..9).map(|at| [f64::from(at), 3.0 - 2.0 * f64::from(at)]).collect();
        assert!((correlation(&line) + 1.0).abs() < 1e-12);
        assert!(correlation(&[[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]).abs() < 1e-12);
        assert_eq!(correlation(&[[1.0, 0.0], [1.0, 1.0]]), 0.0);
    }
}

//! What a frame costs along a clip, and what quality it buys.

use sheer_metrics::statistics::quantile;
use sheer_render::{Antialiasing, Backend};

use super::{
    claims::{Sample, at_least, at_most, claim, falling, less_as},
    findings::Findings,
    lab::{Lab, Take, time_plot},
    quality::HEIGHT_OF_FIGHT_SECS,
};
use crate::{
    Datum, Figures, Result,
    plot::{Axis, Plot, Series},
};

/// Pure, the hybrids of STD Fig. 11 and 12, exact.
const METHODS: &[&str] = &["std", "std:hybrid=0.95", "std:hybrid=0.75", "std:hybrid=0.5", "baseline"];

/// STD Fig. 11: ten seconds of the fight.
pub(super) fn fight<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    along(lab, "arena", "static", 24, 12, false)
}

/// STD Fig. 12: twelve seconds through the smoke.
pub(super) fn smoke<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    along(lab, "smoke-square", "path", 24, 15, true)
}

/// Frames of a clip, `step` apart; of one where the baseline's time swings, that of std ought not to.
fn along<B: Backend>(
    lab: &Lab<'_, B>,
    scene: &str,
    camera: &str,
    count: u32,
    step: u32,
    swings: bool,
) -> Result<Findings> {
    let moments = lab.moments(0.0, count, step);
    let mut stage = lab.open(scene, camera, None)?;
    let tallies = lab.time(&mut stage, METHODS, &moments)?;
    let pixels = f64::from(lab.size[0] * lab.size[1]);
    let swing = |at: usize| tallies[at].ms(1.0) / tallies[at].ms(0.5);
    let rows = METHODS.iter().zip(&tallies).enumerate().map(|(at, (method, tally))| {
        let ms = tally.frame_ms();
        let figures = [
            quantile(&ms, 0.5),
            quantile(&ms, 0.0),
            quantile(&ms, 1.0),
            swing(at),
            tally.ms(0.5) / tallies[METHODS.len() - 1].ms(0.5),
            tally.shaded() / pixels,
            tally.hits() / pixels,
        ];
        let numbers = figures.into_iter().zip([1, 1, 1, 2, 3, 2, 2]);
        let numbers = numbers.map(|(value, decimals)| Datum::Number(Some(value), decimals));
        [Datum::Word((*method).to_owned())].into_iter().chain(numbers).collect()
    });
    let titles = ["method", "ms", "min", "max", "max/median", "of baseline", "shaded/px", "hits/px"];
    let (pure, exact) = (0, METHODS.len() - 1);
    let growth = |at: usize| tallies[at].ms(1.0) - tallies[at].ms(0.0);
    let times = |at: usize| Sample::new(METHODS[at], tallies[at].frame_ms());
    let mut claims = vec![
        less_as(
            format!(
                "std is faster than the baseline frame by frame, {:.2} of its median and {:.2} of its slowest",
                tallies[pure].ms(0.5) / tallies[exact].ms(0.5),
                tallies[pure].ms(1.0) / tallies[exact].ms(1.0)
            ),
            &times(pure),
            &times(exact),
        ),
        at_least("time of a frame", &times(exact - 1), 0.9, &times(exact)).remark(
            "Here a hybrid down to one half hardly pays.",
            "Here even a hybrid down to one half pays.",
        ),
        claim(
            "the hybrids lie between std and the baseline, in the order of their thresholds, within 5 % of time".to_owned(),
            tallies.windows(2).all(|pair| pair[0].ms(0.5) <= pair[1].ms(0.5) * 1.05),
        ),
    ];
    if swings {
        claims.push(claim(
            format!(
                "std stays nearly constant: from its fastest to its slowest frame it adds {:.1} ms, a tenth or less of the {:.1} ms of the baseline",
                growth(pure),
                growth(exact)
            ),
            growth(pure) <= 0.1 * growth(exact),
        ));
    }
    Ok(Findings {
        claims,
        tables: vec![(String::new(), Figures::of_data(&titles, rows.collect()))],
        plots: vec![("Time of a frame over the clip.".to_owned(), time_plot(&moments, METHODS, &tallies))],
        ..Findings::default()
    })
}

/// From pure to exact.
const THRESHOLDS: [f32; 7] = [1.0, 0.95, 0.75, 0.5, 0.25, 0.1, 0.0];
/// Exact fragments at most, where many faint layers would each be shaded: the fall-back of STD section 3.4.
const LAYERS: [u32; 4] = [1, 2, 4, 8];

/// STD Fig. 13, and the fall-back for many faint layers.
pub(super) fn hybrid<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let by_threshold = THRESHOLDS.map(|threshold| format!("std:hybrid={threshold}"));
    let by_layers = LAYERS.map(|layers| format!("std:hybrid=0.5,layers={layers}"));
    let methods: Vec<&str> = by_threshold.iter().chain(&by_layers).map(String::as_str).collect();
    let mut findings = Findings::default();
    for (scene, camera, start_secs) in
        [("arena", "static", HEIGHT_OF_FIGHT_SECS), ("smoke-square", "path", 4.0)]
    {
        let played = lab.play(&Take {
            scene,
            alpha: None,
            camera,
            start_secs,
            frames: 12,
            antialiasing: Antialiasing::TAA,
            methods: &methods,
            truth_samples: None,
        })?;
        let errors: Vec<Sample> =
            by_threshold.iter().map(|method| played.sample(method, |row| row.rms)).collect();
        let times: Vec<f64> = by_threshold.iter().map(|method| played.row(method).ms_median).collect();
        findings.claims.extend([
            falling(
                format!("{scene}: the error falls with every step of the threshold from 1 to 0"),
                &errors,
            ),
            claim(
                format!("{scene}: the time rises with it, within 5 %"),
                times.windows(2).all(|pair| pair[1] >= pair[0] * 0.95),
            ),
            at_most(&format!("{scene}: RMS error"), &errors[3], 0.5, &errors[0]).remark(
                "",
                "Where tens of layers each take little, half the visibility is far from the end.",
            ),
            claim(format!("{scene}: a threshold of 0 is the baseline to the bit"), errors[6].mean() == 0.0),
        ]);
        let dots = |methods: &[String]| -> Vec<[f64; 2]> {
            methods.iter().map(|method| [played.row(method).ms_median, played.row(method).ssim]).collect()
        };
        let plot = Plot {
            description: format!("SSIM over milliseconds of a frame of {scene}, a point for each threshold"),
            x: Axis::new("ms").logarithmic(),
            y: Axis::new("SSIM"),
            series: vec![
                Series::line("threshold 1 to 0", dots(&by_threshold)).with_dots(),
                Series::line("0.5, at most 1, 2, 4, 8 layers", dots(&by_layers)).with_dots(),
            ],
        };
        findings.commands.push(played.command.clone());
        let columns = &["ms", "SSIM", "PSNR dB", "FLIP", "RMS", "bias", "shaded/px"];
        findings.tables.push((format!("{scene} at {start_secs} s"), played.figures(columns)));
        findings.plots.push((format!("Quality against time: {scene}."), plot));
        findings.pictures.extend(played.pictures(&["std:hybrid=1", "std:hybrid=0.95", "std:hybrid=0.5"]));
    }
    Ok(findings)
}

//! The pictures of STD: one fragment a pixel in still and moving scenes.

use std::collections::HashMap;

use sheer_image::{DisplayShare, Planes, Tone, display_over_black};
use sheer_metrics::{Flicker, gaussian_blur};
use sheer_render::{Antialiasing, Backend, Clock, Moment, Settings};

use super::{
    claims::{Sample, at_least, at_most, claim, greater, less},
    findings::{Claim, Findings},
    lab::{Lab, Played, Take, findings_of},
};
use crate::{
    Datum, Figures, REFERENCE, Result, Timeline,
    play::{Event, play},
    plot::{Axis, Plot, Series},
};

/// What the paper compares, its appendix included, and ours.
const METHODS: &[&str] = &["roulette", "std", "dtaa", "dtaa-unique", "stbn", "joint"];
const COLUMNS: &[&str] = &["SSIM", "PSNR dB", "tPSNR dB", "FLIP", "flicker", "RMS", "bias", "shaded/px"];
/// Two errors are called equal that differ by less than this share: the seed moves them by as much.
const EQUAL: f64 = 0.03;

fn take<'a>(scene: &'a str, camera: &'a str, start_secs: f32, frames: u32) -> Take<'a> {
    Take {
        scene,
        alpha: None,
        camera,
        start_secs,
        frames,
        antialiasing: Antialiasing::TAA,
        methods: METHODS,
        truth_samples: None,
    }
}

/// What is missing to a perfect SSIM.
fn error(played: &Played, method: &str) -> Sample {
    played.sample(method, |row| 1.0 - row.ssim)
}

fn ssim(played: &Played, method: &str) -> Sample {
    played.sample(method, |row| row.ssim)
}

/// That a method has a higher SSIM than another.
fn better(played: &Played, method: &str, other: &str) -> Claim {
    greater("SSIM", &ssim(played, method), &ssim(played, other))
}

/// STD Fig. 6.
pub(super) fn still_pane<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let played = lab.play(&take("pane", "static", 0.0, 48))?;
    let mut claims: Vec<Claim> =
        ["roulette", "dtaa", "dtaa-unique"].iter().map(|other| better(&played, "std", other)).collect();
    claims.push(better(&played, "std", "stbn").remark(
        "",
        "The pane has an opacity of one half, which nine thresholds show worst: `pane-opacities` has the others.",
    ));
    Ok(Findings {
        claims,
        ..findings_of(&played, COLUMNS, &["baseline", "roulette", "std", "dtaa", "stbn", "joint"])
    })
}

/// STD Fig. 7.
pub(super) fn moving_pane<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let methods = &[METHODS, &["std:align=off", "std:align=round", "std:align=dead"]].concat();
    let played = lab.play(&Take { methods, ..take("pane", "path", 0.0, 32) })?;
    let at_worst_equal =
        |other: &str| at_most("1 − SSIM", &error(&played, "std"), 1.0 + EQUAL, &error(&played, other));
    let mut claims: Vec<Claim> =
        ["roulette", "dtaa", "dtaa-unique"].iter().map(|other| at_worst_equal(other)).collect();
    claims.push(
        at_worst_equal("stbn")
            .remark("", "One half is the worst opacity of nine thresholds here, too: see `pane-opacities`."),
    );
    claims.push(better(&played, "std", "std:align=off").remark(
        "On a flat pane alignment does what the paper says.",
        "Alignment does not pay by SSIM; what it prevents is the change of colour of `alignment`.",
    ));
    Ok(Findings {
        claims,
        ..findings_of(&played, COLUMNS, &["baseline", "roulette", "std", "std:align=off", "stbn", "joint"])
    })
}

/// STD Fig. 5: a pane under a camera that moves by a fraction of a pixel a frame.
pub(super) fn alignment<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    const METHODS: [&str; 7] =
        ["std", "std:align=off", "std:align=round", "std:align=dead", "dtaa", "dtaa:align=off", "roulette"];
    /// Multiples of real time.
    const SPEEDS: [f32; 4] = [0.25, 1.0, 2.0, 4.0];
    let mut stage = lab.open("pane", "path", None)?;
    // One line a method, mean of all seeds; one sum a method and seed, over all speeds.
    let mut lines: Vec<Vec<[f64; 2]>> = vec![Vec::new(); METHODS.len()];
    let mut sums: Vec<Sample> =
        METHODS.iter().map(|method| Sample::new(*method, vec![0.0; lab.seeds().count()])).collect();
    let mut findings = Findings::default();
    for speed in SPEEDS {
        let (motion_px, flicker) = coarse_flicker(lab, &mut stage, &METHODS, speed)?;
        for ((line, sum), flicker) in lines.iter_mut().zip(&mut sums).zip(flicker) {
            line.push([motion_px, flicker.mean()]);
            for (sum, value) in sum.values.iter_mut().zip(&flicker.values) {
                *sum += value / SPEEDS.len() as f64;
            }
        }
    }
    let quantity = "coarse flicker, mean of all speeds,";
    let [std, off, round, dead, dtaa, dtaa_off, _] = sums.as_slice() else {
        unreachable!("one sample a method")
    };
    findings.claims.extend([
        less(quantity, std, off).remark("On a flat pane alignment does what the paper says.", ""),
        less(quantity, dtaa, dtaa_off),
        less(quantity, std, round).remark(
            "",
            "The draw between four places has a price of its own: rounding flickers less, and lags behind instead.",
        ),
        less(quantity, dead, std).remark(
            "What the authors' own code does differently calms the pane further.",
            "The authors' dead zone and box change nothing for the better here.",
        ),
    ]);
    let rows = (0..SPEEDS.len()).map(|at| {
        let motion = Datum::Number(Some(lines[0][at][0]), 3);
        [motion].into_iter().chain(lines.iter().map(|line| Datum::Number(Some(line[at][1]), 5))).collect()
    });
    let titles: Vec<&str> = ["motion px"].into_iter().chain(METHODS).collect();
    findings.tables.push((
        "Coarse flicker by mean motion of the pane, pixels a frame.".to_owned(),
        Figures::of_data(&titles, rows.collect()),
    ));
    let plot = Plot {
        description: "Coarse flicker of the pane over its motion in pixels a frame, a line for each method"
            .to_owned(),
        x: Axis::new("motion, pixels a frame").logarithmic(),
        y: Axis::new("coarse flicker").with_zero(),
        series: METHODS
            .iter()
            .zip(lines)
            .map(|(method, line)| Series::line(method, line).with_dots())
            .collect(),
    };
    findings.plots.push(("Flicker of colours averaged over a few pixels.".to_owned(), plot));
    Ok(findings)
}

/// The pattern itself averages out over so many pixels: what is left is the change of colour that the paper
/// shows.
const COARSE_SIGMA_PX: f32 = 3.0;

/// Mean motion of transparent pixels, pixels a frame, and the flicker of each method's blurred error where
/// something transparent is, with each of the seeds.
fn coarse_flicker<B: Backend>(
    lab: &Lab<'_, B>,
    stage: &mut B::Stage,
    methods: &[&str],
    speed: f32,
) -> Result<(f64, Vec<Sample>)> {
    const FRAMES: u32 = 36;
    let settings = lab.settings(0.0);
    let mut pipelines = Vec::new();
    for seed in lab.seeds() {
        pipelines.extend(lab.pipelines(methods, Antialiasing::TAA, Settings { seed, ..settings })?);
    }
    let mut flickers = vec![Flicker::<3>::new(); pipelines.len()];
    pipelines.extend(lab.pipelines(&[REFERENCE], Antialiasing::TAA, settings)?);
    let (mut motion_px, mut count) = (0.0, 0.0);
    let clock = Clock::new(&settings, Antialiasing::TAA);
    let slow = |time_secs: f32| 1.0 + speed * time_secs;
    let moments: Vec<Moment> = (0..FRAMES)
        .map(|index| clock.at(index))
        .map(|at| Moment { time_secs: slow(at.time_secs), previous_secs: slow(at.previous_secs) })
        .collect();
    play(lab.backend, stage, &mut pipelines, Timeline::Moments(&moments), |event| {
        let (index, pipelines) = match event {
            Event::Rendered { .. } => {
                lab.progress.step();
                return Ok(());
            }
            Event::Frame { index, pipelines, .. } => (index, pipelines),
        };
        let Some((reference, contestants)) = pipelines.split_last().filter(|_| index >= FRAMES / 2) else {
            return Ok(());
        };
        let planes = lab.planes(reference)?;
        for (motion, _) in
            planes.motion.as_slice().iter().zip(planes.transparent.as_slice()).filter(|(_, seen)| **seen)
        {
            motion_px += f64::from(motion[0].hypot(motion[1]));
            count += 1.0;
        }
        // Elsewhere no method differs from another; there all have the colour of the reference.
        let coarse = |pipeline: &B::Pipeline| -> Result<_> {
            let colour = &lab.planes(pipeline)?.colour;
            let shown = display_over_black(colour, Tone::default(), &DisplayShare::Nothing);
            Ok(gaussian_blur(&shown, COARSE_SIGMA_PX))
        };
        let exact = coarse(reference)?;
        for (flicker, pipeline) in flickers.iter_mut().zip(contestants) {
            flicker.add(&exact, &coarse(pipeline)?)?;
        }
        Ok(())
    })?;
    let of_method = |(at, method): (usize, &&str)| {
        let values = flickers.iter().skip(at).step_by(methods.len()).map(Flicker::value).collect();
        Sample::new(*method, values)
    };
    Ok((motion_px / f64::max(count, 1.0), methods.iter().enumerate().map(of_method).collect()))
}

/// STD Fig. 9.
pub(super) fn smoke<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let more = [
        "std:align=off",
        "std:align=round",
        "std:align=dead",
        "std:noise=object",
        "std:align=off,noise=object",
        "joint:align=off",
    ];
    let methods = &[METHODS, &more].concat();
    let played = lab.play(&Take { methods, ..take("smoke-square", "path", 3.0, 24) })?;
    let of = |method: &str| ssim(&played, method);
    let [std, unique] = ["std", "dtaa-unique"].map(|method| of(method).mean());
    // By how much of white noise's lead over `std` another setting catches up, seed by seed.
    let lead = |method: &str| {
        let values = of(method).values.iter().zip(&of("std").values).map(|(own, std)| own - std).collect();
        Sample::new(format!("{method} over std"), values)
    };
    let claims = vec![
        better(&played, "std", "dtaa"),
        claim(
            format!("std {std:.4} and dtaa-unique {unique:.4} are similar: SSIM within 0.03"),
            (std - unique).abs() < 0.03,
        ),
        better(&played, "std", "roulette").remark(
            "White noise is noisier, as the paper has it.",
            "White noise is ahead, and the paper has it behind: it shows DLSS, this is fidelity under plain TAA.",
        ),
        better(&played, "std:align=off", "std").remark(
            "The alignment of motion vectors, which saves flat colours from drifting, costs detail where everything is noise.",
            "Alignment costs nothing here.",
        ),
        at_least("lead in SSIM", &lead("std:align=off"), 0.5, &lead("roulette")).remark(
            "Most of the gap to white noise is the alignment.",
            "The alignment is less than half of the gap to white noise.",
        ),
        better(&played, "std:align=off,noise=object", "std:align=off").remark(
            "What remains of the gap is in part the noise that all layers share: see `shared-noise`.",
            "An offset into the noise for each particle gains nothing under a moving camera.",
        ),
        better(&played, "joint", "std").remark(
            "Layers that cannot mask one another gain, aligned as `std` is.",
            "",
        ),
        better(&played, "joint:align=off", "roulette").remark(
            "Without alignment a pattern beats white noise, if layers cannot mask one another.",
            "Even without alignment white noise stays ahead.",
        ),
        better(&played, "joint:align=off", "stbn"),
    ];
    Ok(Findings {
        claims,
        ..findings_of(
            &played,
            COLUMNS,
            &["baseline", "roulette", "std", "std:align=off", "stbn", "joint:align=off"],
        )
    })
}

/// When the fight of `arena` is at its height, seconds.
pub(super) const HEIGHT_OF_FIGHT_SECS: f32 = 6.0;

/// STD Fig. 1, 8 and 14.
pub(super) fn fight<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let methods = &[METHODS, &["std:align=off"]].concat();
    let played = lab.play(&Take { methods, ..take("arena", "static", HEIGHT_OF_FIGHT_SECS, 24) })?;
    let (lost, table) = lost_objects(lab)?;
    let mut claims: Vec<Claim> = ["dtaa-unique", "std", "joint"]
        .iter()
        .map(|method| less("objects lost, mean of all seeds,", &lost[*method], &lost["dtaa"]))
        .collect();
    claims.extend(["dtaa", "dtaa-unique"].map(|other| better(&played, "std", other)));
    claims.extend(["stbn", "roulette"].map(|other| {
        better(&played, "std", other).remark(
            "",
            "The paper has it the other way round: it shows DLSS, which takes dithering for detail; this is fidelity under plain TAA.",
        )
    }));
    claims.push(better(&played, "std:align=off", "std").remark(
        "Part of the gap is the alignment of motion vectors.",
        "The alignment of motion vectors is no part of the gap.",
    ));
    claims.push(better(&played, "joint", "std"));
    let pictures = &["baseline", "roulette", "std", "dtaa", "dtaa-unique", "stbn", "joint"];
    let mut findings = findings_of(&played, COLUMNS, pictures);
    let caption = format!(
        "Objects at {HEIGHT_OF_FIGHT_SECS} s that ought to be seen and get less than {LOST_SHARE} of their pixels, over {COUNTED_FRAMES} frames"
    );
    findings.tables.push((caption, table));
    Ok(Findings { claims, ..findings })
}

/// Five cycles of nine, nine cycles of five.
const COUNTED_FRAMES: u32 = 45;
/// An object is there if it ought to win so many pixels a frame: its count over all frames then has a
/// deviation of 5 %.
const LEAST_PIXELS: f64 = 9.0;
/// It is lost if it gets less than this share of them.
const LOST_SHARE: f64 = 0.25;

/// Counts the objects of the fight that a method never or hardly ever shows, with each of the seeds.
fn lost_objects<B: Backend>(lab: &Lab<'_, B>) -> Result<(HashMap<String, Sample>, Figures)> {
    let mut stage = lab.open("arena", "static", None)?;
    let time_secs = HEIGHT_OF_FIGHT_SECS;
    let height = [Moment { time_secs, previous_secs: time_secs }];
    play(lab.backend, &mut stage, &mut [], Timeline::Moments(&height), |_| Ok(()))?;
    // Without bias: it says how often each object ought to be seen.
    let mut seen = |method: &str, seed: u32, frames: u32| -> Result<HashMap<u32, f64>> {
        let settings = Settings { seed, ..lab.settings(time_secs) };
        let mut pipelines = lab.pipelines(&[method], Antialiasing::NONE, settings)?;
        let mut counts: HashMap<u32, f64> = HashMap::new();
        play(lab.backend, &mut stage, &mut pipelines, Timeline::Still(frames), |event| {
            let Event::Frame { pipelines, .. } = event else { return Ok(()) };
            for &instance in lab.planes(&pipelines[0])?.instance.as_slice() {
                if instance != Planes::NO_ID {
                    *counts.entry(instance).or_default() += 1.0 / f64::from(frames);
                }
            }
            lab.progress.step();
            Ok(())
        })?;
        Ok(counts)
    };
    let expected = seen("roulette", lab.seed.wrapping_add(lab.seed_count), 2 * COUNTED_FRAMES)?;
    let there: Vec<_> = expected.iter().filter(|(_, count)| **count >= LEAST_PIXELS).collect();
    let mut lost = HashMap::new();
    let mut rows = Vec::new();
    for method in METHODS {
        let mut counts_of_lost = Vec::new();
        for seed in lab.seeds() {
            let counts = seen(method, seed, COUNTED_FRAMES)?;
            let shares = there.iter().map(|(id, wanted)| counts.get(id).copied().unwrap_or(0.0) / **wanted);
            counts_of_lost.push(shares.filter(|share| *share < LOST_SHARE).count() as f64);
        }
        let lost_objects = Sample::new(*method, counts_of_lost);
        rows.push(vec![
            Datum::Word((*method).to_owned()),
            Datum::Number(Some(there.len() as f64), 0),
            Datum::Number(Some(lost_objects.mean()), 1),
        ]);
        lost.insert((*method).to_owned(), lost_objects);
    }
    Ok((lost, Figures::of_data(&["method", "objects", "lost"], rows)))
}

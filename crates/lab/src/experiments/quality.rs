//! The pictures of STD: one fragment a pixel in still and moving scenes.

use std::collections::HashMap;

use sheer_image::{Planes, ToneCurve, display_over_black};
use sheer_metrics::{Flicker, gaussian_blur};
use sheer_render::{Antialiasing, Backend, Clock, Moment, Settings};

use super::{
    findings::{Claim, Findings},
    lab::{Lab, Played, Take, claim, findings_of},
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
    Take { scene, alpha: None, camera, start_secs, frames, antialiasing: Antialiasing::TAA, methods: METHODS }
}

/// What is missing to a perfect SSIM.
fn error(played: &Played, method: &str) -> f64 {
    1.0 - played.row(method).ssim
}

fn is_at_least_as_good(played: &Played, method: &str, other: &str) -> bool {
    error(played, method) <= error(played, other) * (1.0 + EQUAL)
}

/// That a method has a higher SSIM than others, one claim each.
fn better(played: &Played, method: &str, others: &[&str]) -> Vec<Claim> {
    let against = |other: &&str| {
        let [own, its] = [method, other].map(|method| played.row(method).ssim);
        claim(format!("SSIM of {method} {own:.4} > {other} {its:.4}"), own > its)
    };
    others.iter().map(against).collect()
}

/// STD Fig. 6.
pub(super) fn still_pane<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let played = lab.play(&take("pane", "static", 0.0, 48))?;
    let claims = better(&played, "std", &["roulette", "dtaa", "dtaa-unique", "stbn"]);
    Ok(Findings {
        claims,
        ..findings_of(&played, COLUMNS, &["baseline", "roulette", "std", "dtaa", "stbn", "joint"])
    })
}

/// STD Fig. 7.
pub(super) fn moving_pane<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let played = lab.play(&take("pane", "path", 0.0, 32))?;
    let against = |other: &&str| {
        let [own, its] = ["std", other].map(|method| played.row(method).ssim);
        let text = format!("SSIM of std {own:.4} best or equal to {other} {its:.4}");
        claim(text, is_at_least_as_good(&played, "std", other))
    };
    let claims = ["roulette", "dtaa", "dtaa-unique", "stbn"].iter().map(against).collect();
    Ok(Findings {
        claims,
        ..findings_of(&played, COLUMNS, &["baseline", "roulette", "std", "dtaa", "stbn", "joint"])
    })
}

/// STD Fig. 5: a pane under a camera that moves by a fraction of a pixel a frame.
pub(super) fn alignment<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    const METHODS: [&str; 5] = ["std", "std:align=off", "dtaa", "dtaa:align=off", "roulette"];
    /// Multiples of real time.
    const SPEEDS: [f32; 6] = [0.25, 0.5, 1.0, 2.0, 3.0, 4.0];
    let mut stage = lab.open("pane", "path", None)?;
    let mut lines: Vec<Vec<[f64; 2]>> = vec![Vec::new(); METHODS.len()];
    let mut findings = Findings::default();
    for speed in SPEEDS {
        let (motion_px, flicker) = coarse_flicker(lab, &mut stage, &METHODS, speed)?;
        for (line, flicker) in lines.iter_mut().zip(flicker) {
            line.push([motion_px, flicker]);
        }
    }
    for (on, off) in [(0, 1), (2, 3)] {
        let mean =
            |at: usize| lines[at].iter().map(|[_, flicker]| flicker).sum::<f64>() / SPEEDS.len() as f64;
        let (with, without) = (mean(on), mean(off));
        let text = format!(
            "{}: coarse flicker {with:.5} aligned < {without:.5} not aligned, {:.2} of it, mean of all speeds",
            METHODS[on],
            with / without
        );
        findings.claims.push(claim(text, with < without));
    }
    let rows = (0..SPEEDS.len()).map(|at| {
        let motion = Datum::Number(Some(lines[0][at][0]), 3);
        [motion].into_iter().chain(lines.iter().map(|line| Datum::Number(Some(line[at][1]), 5))).collect()
    });
    let titles = ["motion px", METHODS[0], METHODS[1], METHODS[2], METHODS[3], METHODS[4]];
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
/// something transparent is.
fn coarse_flicker<B: Backend>(
    lab: &Lab<'_, B>,
    stage: &mut B::Stage,
    methods: &[&str],
    speed: f32,
) -> Result<(f64, Vec<f64>)> {
    const FRAMES: u32 = 54;
    let settings = lab.settings(0.0);
    let all: Vec<&str> = methods.iter().copied().chain([REFERENCE]).collect();
    let mut pipelines = lab.pipelines(&all, Antialiasing::TAA, settings)?;
    let mut flickers = vec![Flicker::<3>::new(); methods.len()];
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
            Event::Frame { index, pipelines } => (index, pipelines),
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
            let shown = display_over_black(&lab.planes(pipeline)?.colour, ToneCurve::default());
            Ok(gaussian_blur(&shown, COARSE_SIGMA_PX))
        };
        let exact = coarse(reference)?;
        for (flicker, pipeline) in flickers.iter_mut().zip(contestants) {
            flicker.add(&exact, &coarse(pipeline)?)?;
        }
        Ok(())
    })?;
    Ok((motion_px / f64::max(count, 1.0), flickers.iter().map(Flicker::value).collect()))
}

/// STD Fig. 9.
pub(super) fn smoke<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let methods = &[METHODS, &["std:align=off", "joint:align=off"]].concat();
    let played = lab.play(&Take { methods, ..take("smoke-square", "path", 3.0, 24) })?;
    let mut claims = better(&played, "std", &["dtaa"]);
    let [std, unique] = ["std", "dtaa-unique"].map(|method| played.row(method).ssim);
    let text = format!("std {std:.4} and dtaa-unique {unique:.4} are similar: SSIM within 0.03");
    claims.push(claim(text, (std - unique).abs() < 0.03));
    let [roulette, joint] = ["roulette", "joint"].map(|method| played.row(method).ssim);
    claims.push(claim(format!("roulette {roulette:.4} is noisier than std {std:.4}"), roulette < std));
    claims.push(claim(format!("SSIM of joint {joint:.4} > std {std:.4}"), joint > std));
    Ok(Findings {
        claims,
        ..findings_of(&played, COLUMNS, &["baseline", "roulette", "std", "dtaa-unique", "stbn", "joint"])
    })
}

/// When the fight of `arena` is at its height, seconds.
pub(super) const HEIGHT_OF_FIGHT_SECS: f32 = 6.0;

/// STD Fig. 1, 8 and 14.
pub(super) fn fight<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let played = lab.play(&take("arena", "static", HEIGHT_OF_FIGHT_SECS, 24))?;
    let (lost, table) = lost_objects(lab)?;
    let mut claims: Vec<Claim> = ["dtaa-unique", "std", "joint"]
        .iter()
        .map(|method| {
            let [dtaa, own] = [lost["dtaa"], lost[*method]];
            claim(format!("dtaa loses {dtaa} objects that {method} keeps all but {own} of"), dtaa > own)
        })
        .collect();
    claims.extend(better(&played, "std", &["dtaa", "dtaa-unique", "stbn", "roulette"]));
    claims.extend(better(&played, "joint", &["std"]));
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

/// Counts the objects of the fight that a method never or hardly ever shows.
fn lost_objects<B: Backend>(lab: &Lab<'_, B>) -> Result<(HashMap<String, usize>, Figures)> {
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
    let expected = seen("roulette", lab.seed.wrapping_add(1), 2 * COUNTED_FRAMES)?;
    let there: Vec<_> = expected.iter().filter(|(_, count)| **count >= LEAST_PIXELS).collect();
    let mut lost = HashMap::new();
    let mut rows = Vec::new();
    for method in METHODS {
        let counts = seen(method, lab.seed, COUNTED_FRAMES)?;
        let shares = there.iter().map(|(id, wanted)| counts.get(id).copied().unwrap_or(0.0) / **wanted);
        let lost_count = shares.filter(|share| *share < LOST_SHARE).count();
        rows.push(vec![
            Datum::Word((*method).to_owned()),
            Datum::Number(Some(there.len() as f64), 0),
            Datum::Number(Some(lost_count as f64), 0),
        ]);
        lost.insert((*method).to_owned(), lost_count);
    }
    Ok((lost, Figures::of_data(&["method", "objects", "lost"], rows)))
}

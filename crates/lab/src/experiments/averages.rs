//! What adding up over time does: to sequences, to opacities, to layers.

use sheer_core::threshold_map::{std_maps, threshold_index};
use sheer_gallery::{LayerColours, layers_closed_form};
use sheer_render::{Antialiasing, Backend, Settings};
use sheer_scene::CameraChoice;

use super::{
    findings::Findings,
    lab::{Lab, Take, claim, picture},
};
use crate::{
    Datum, Figures, LabError, Result, Timeline, calibrate, file_name_from,
    play::{Event, play},
    plot::{Axis, Plot, Series},
};

/// Weight of a new frame in the exponential average (STD Eq. 2).
const WEIGHT: f64 = 0.1;
/// Frames until the average has settled, as many after that are measured.
const SETTLED: usize = 90;
const SHOWN: usize = 36;

/// STD Fig. 4: the exponential average of the tests that one pixel makes of an alpha, in the order of the
/// walk and sorted.
pub(super) fn sequences<B: Backend>(_: &Lab<'_, B>) -> Result<Findings> {
    let mut walk: [u8; 9] =
        std::array::from_fn(|frame| threshold_index(&std_maps()[0], [0, 0], frame as u32));
    let walked = walk;
    walk.sort_unstable();
    let mut findings = Findings::default();
    let mut rows = Vec::new();
    for alpha in [1.0 / 3.0, 5.0 / 9.0] {
        let average = |order: [u8; 9]| -> Vec<f64> {
            let mut value = alpha;
            let step = |frame: usize| {
                let passes = f64::from(order[frame % 9]) / 9.0 < alpha - 1e-9;
                value += WEIGHT * (f64::from(u8::from(passes)) - value);
                value
            };
            (0..SETTLED + SHOWN).map(step).skip(SETTLED).collect()
        };
        let [spread, clumped] = [average(walked), average(walk)];
        let variance = |values: &[f64]| {
            values.iter().map(|value| (value - alpha).powi(2)).sum::<f64>() / values.len() as f64
        };
        let (low, high) = (variance(&spread), variance(&clumped));
        let text = format!("alpha {alpha:.2}: the walk's average varies less, {low:.5} < {high:.5} sorted");
        findings.claims.push(claim(text, low < high));
        rows.push(vec![
            Datum::Number(Some(alpha), 3),
            Datum::Number(Some(low), 6),
            Datum::Number(Some(high), 6),
        ]);
        let points =
            |values: Vec<f64>| (0..).zip(values).map(|(at, value): (u32, f64)| [f64::from(at), value]);
        let plot = Plot {
            description: format!("Exponential average of the tests of alpha {alpha:.2} over frames"),
            x: Axis::new("frame").of_counts(),
            y: Axis::new("average"),
            series: vec![
                Series::guide("alpha", [[0.0, alpha], [SHOWN as f64 - 1.0, alpha]]),
                Series::line("walk of STD", points(spread)),
                Series::line("sorted", points(clumped)),
            ],
        };
        findings.plots.push((format!("Average of the tests, alpha {alpha:.2}."), plot));
    }
    let titles = ["alpha", "variance of the walk", "variance sorted"];
    findings.tables.push((String::new(), Figures::of_data(&titles, rows)));
    Ok(findings)
}

/// STD Fig. 2: what is shown of ten opacities.
pub(super) fn opacities<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    const FRAMES: u32 = 90;
    /// Opacity that no one tells from the wanted one: half a step of 8 bits at mid-grey, twice.
    const UNSEEN: f64 = 0.004;
    let areas = calibrate::areas(lab.size)?;
    let mut stage = lab.open("calibration", "static", None)?;
    let mut findings = Findings::default();
    let mut rows = Vec::new();
    let mut lines = vec![Series::guide("no error", [[0.1, 0.0], [1.0, 0.0]])];
    for (method, antialiasing) in [
        ("roulette", Antialiasing::ACCUMULATE),
        ("roulette", Antialiasing::TAA),
        ("std", Antialiasing::ACCUMULATE),
        ("std", Antialiasing::TAA),
        ("joint", Antialiasing::TAA),
        ("dtaa", Antialiasing::TAA),
    ] {
        let settings = lab.settings(0.0);
        let mut pipelines = lab.pipelines(&[method], antialiasing, settings)?;
        let [pipeline] = &mut pipelines[..] else { unreachable!("one method has one pipeline") };
        let timeline = Timeline::of(&settings, antialiasing, FRAMES);
        let shown =
            calibrate::shown_opacities(lab.backend, &mut stage, pipeline, areas, timeline, lab.progress)?;
        let wanted = |at: usize| (at + 1) as f64 / calibrate::LEVELS as f64;
        let errors: Vec<f64> = shown.iter().enumerate().map(|(at, shown)| shown - wanted(at)).collect();
        let worst = errors.iter().fold(0.0, |worst: f64, error| worst.max(error.abs()));
        let pairs: Vec<[f64; 2]> = shown.iter().enumerate().map(|(at, &shown)| [shown, wanted(at)]).collect();
        let fit = sheer_core::coverage::Correction::fit(&pairs);
        let coefficients = fit.map(|fit| fit.coefficients().map(f64::from));
        let name = format!("{method}, {antialiasing}");
        if antialiasing == Antialiasing::ACCUMULATE {
            let text =
                format!("plain accumulation needs no correction: {method} is off by {worst:.4} at most");
            findings.claims.push(claim(text, worst <= UNSEEN));
        }
        lines.push(Series::line(&name, (0..errors.len()).map(|at| [wanted(at), errors[at]])));
        let coefficient = |at: usize| Datum::Number(coefficients.map(|found| found[at]), 4);
        rows.push(
            [Datum::Word(name.clone()), Datum::Number(Some(worst), 4)]
                .into_iter()
                .chain((0..4).map(coefficient))
                .collect(),
        );
        if antialiasing == Antialiasing::TAA {
            findings.pictures.push(picture(&name, &*lab.planes(pipeline)?));
        }
    }
    let titles = ["method", "largest error", "c0", "c1", "c2", "c3"];
    findings.tables.push((
        "Opacity shown less wanted, and the cubic from the opacity wanted to the coverage to feed."
            .to_owned(),
        Figures::of_data(&titles, rows),
    ));
    let plot = Plot {
        description: "Opacity shown less opacity wanted, over the opacity wanted".to_owned(),
        x: Axis::new("opacity wanted"),
        y: Axis::new("shown less wanted"),
        series: lines,
    };
    findings.plots.push(("How much anti-aliasing moves opacities.".to_owned(), plot));
    findings.commands.push("sheer calibrate -m std -a taa --html calibration.html".to_owned());
    Ok(findings)
}

/// Stacks of equal layers: how many, and their alpha.
const STACKS: [(u32, f32); 4] = [(2, 0.45), (4, 0.3), (8, 0.2), (20, 0.1)];
/// Largest error of `joint` on them, as a share of that of `std`.
const JOINT_SHARE: f64 = 0.55;
/// Longest time of `joint`, as a multiple of that of `std`.
const JOINT_TIME: f64 = 1.3;

/// Our own method: layers cannot mask one another.
pub(super) fn joint<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    const METHODS: [&str; 5] = ["roulette", "std", "std:rehash=9", "stbn", "joint"];
    let mut findings = Findings::default();
    let mut rows = Vec::new();
    for (count, alpha) in STACKS {
        let errors = METHODS
            .iter()
            .map(|method| exponential_error(lab, method, count, alpha))
            .collect::<Result<Vec<f64>>>()?;
        let share = errors[4] / errors[1];
        let text =
            format!("{count} layers of {alpha}: error of joint {share:.2} of std, at most {JOINT_SHARE}");
        findings.claims.push(claim(text, share <= JOINT_SHARE));
        let numbers = errors.iter().map(|&error| Datum::Number(Some(error), 4));
        rows.push([Datum::Word(format!("{count} × {alpha}"))].into_iter().chain(numbers).collect());
    }
    let titles = ["layers", "roulette", "std", "std:rehash=9", "stbn", "joint"];
    let caption = "RMS error of an exponential average of weight 0.1 without clipping; red and green layers over blue, four seeds.";
    findings.tables.push((caption.to_owned(), Figures::of_data(&titles, rows)));

    let clips = [
        ("smoke-square", "static", None, 6.0),
        ("smoke-square", "path", None, 4.0),
        ("arena", "static", None, 6.0),
    ]
    .map(|(scene, camera, alpha, time)| (scene.to_owned(), camera, alpha, time));
    let files = lab
        .files
        .iter()
        .flat_map(|file| ["static", "orbit"].map(|camera| (file.clone(), camera, Some(0.3), 0.0)));
    for (scene, camera, alpha, start_secs) in clips.into_iter().chain(files) {
        let antialiasing = Antialiasing::TAA;
        let played = lab.play(&Take {
            scene: &scene,
            alpha,
            camera,
            start_secs,
            frames: 24,
            antialiasing,
            methods: &METHODS,
        })?;
        let [joint, std] = ["joint", "std"].map(|method| played.row(method));
        let name = format!("{}, camera {camera}", file_name_from(&short_name(&scene)));
        let text = format!("{name}: SSIM of joint {:.4} > std {:.4}", joint.ssim, std.ssim);
        findings.claims.push(claim(text, joint.ssim > std.ssim));
        let ratio = joint.ms_median / std.ms_median;
        let text = format!("{name}: time of joint {ratio:.2} of std, at most {JOINT_TIME}");
        findings.claims.push(claim(text, ratio <= JOINT_TIME));
        let columns = &["ms", "SSIM", "PSNR dB", "tPSNR dB", "FLIP", "flicker", "RMS", "bias", "hits/px"];
        findings.commands.push(played.command.replace(&scene, &short_name(&scene)));
        findings.tables.push((name, played.figures(columns)));
        findings.pictures.extend(played.pictures(&["baseline", "std", "joint"]));
    }
    Ok(findings)
}

/// A file's name without its folders.
pub(super) fn short_name(scene: &str) -> String {
    scene.rsplit(['/', '\\']).next().unwrap_or(scene).to_owned()
}

/// Root mean square over pixels, channels, the last 18 of 90 frames and four seeds by which an exponential
/// average misses the closed form.
fn exponential_error<B: Backend>(lab: &Lab<'_, B>, method: &str, count: u32, alpha: f32) -> Result<f64> {
    const SIZE: [u32; 2] = [48, 27];
    const FRAMES: u32 = 90;
    const MEASURED: u32 = 18;
    const SEEDS: u32 = 4;
    let scene = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
    let expected = layers_closed_form(count, alpha, LayerColours::RedGreen, 1.0).as_dvec3();
    let stage =
        lab.backend.stage(sheer_gallery::open(&scene)?.scene.into(), &CameraChoice::Default, lab.threads);
    let mut stage = stage.map_err(|error| LabError::of_backend(lab.backend, error))?;
    let (mut sum, mut terms) = (0.0, 0_u32);
    for seed in 0..SEEDS {
        let settings = Settings { size: SIZE, seed: lab.seed.wrapping_add(seed), ..Settings::default() };
        let mut pipelines = lab.pipelines(&[method], Antialiasing::NONE, settings)?;
        let mut averages = vec![glam::DVec3::ZERO; (SIZE[0] * SIZE[1]) as usize];
        play(lab.backend, &mut stage, &mut pipelines, Timeline::Still(FRAMES), |event| {
            let Event::Frame { index, pipelines } = event else { return Ok(()) };
            // A young average is a plain mean, as that of TAA.
            let weight = WEIGHT.max(1.0 / (f64::from(index) + 1.0));
            let planes = lab.planes(&pipelines[0])?;
            for (average, &[r, g, b, _]) in averages.iter_mut().zip(planes.colour.as_slice()) {
                *average += weight * (glam::Vec3::new(r, g, b).as_dvec3() - *average);
                if index >= FRAMES - MEASURED {
                    sum += (*average - expected).length_squared();
                    terms += 3;
                }
            }
            Ok(())
        })?;
    }
    Ok((sum / f64::from(terms)).sqrt())
}

//! What adding up over time does: to sequences, to opacities, to layers.

use sheer_render::{Antialiasing, Backend};

use super::{
    claims::{Sample, at_most, claim, greater},
    findings::Findings,
    lab::{Lab, Take, picture},
    layers::exponential_errors,
};
use crate::{
    Datum, Figures, Result, Timeline, calibrate, file_name_from,
    plot::{Axis, Plot, Series},
};

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
            .map(|method| Ok(Sample::new(*method, exponential_errors(lab, method, count, alpha)?)))
            .collect::<Result<Vec<Sample>>>()?;
        let quantity = format!("{count} layers of {alpha}: error");
        findings.claims.push(at_most(&quantity, &errors[4], JOINT_SHARE, &errors[1]));
        let numbers = errors.iter().map(|sample| Datum::Number(Some(sample.mean()), 4));
        rows.push([Datum::Word(format!("{count} × {alpha}"))].into_iter().chain(numbers).collect());
    }
    let titles = ["layers", "roulette", "std", "std:rehash=9", "stbn", "joint"];
    let caption = "RMS error of an exponential average of weight 0.1 without clipping; red and green layers over blue, mean of all seeds.";
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
            truth_samples: None,
        })?;
        let name = format!("{}, camera {camera}", file_name_from(&short_name(&scene)));
        let [joint, std] = ["joint", "std"].map(|method| played.sample(method, |row| row.ssim));
        findings.claims.push(greater(&format!("{name}: SSIM"), &joint, &std));
        let [joint, std] = ["joint", "std"].map(|method| played.sample(method, |row| row.ms_median));
        findings.claims.push(at_most(&format!("{name}: time"), &joint, JOINT_TIME, &std));
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

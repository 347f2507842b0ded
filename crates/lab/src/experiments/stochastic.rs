//! The figures and the table of ST.

use sheer_image::Planes;
use sheer_metrics::{rms, statistics::quantile};
use sheer_render::{
    Antialiasing, Backend, Settings, StepTime, Timings,
    backend::StepClock,
    shadow::{Sampling, Shadow, visibility::Blockers},
};

use super::{
    claims::{Sample, claim, falling, less, less_as},
    findings::Findings,
    lab::{Lab, Played, Take, picture},
};
use crate::{
    Datum, Figures, Result, Timeline,
    play::{Event, play},
    plot::{Axis, Plot, Series},
};

const COLUMNS: &[&str] = &["ms", "SSIM", "PSNR dB", "FLIP", "RMS", "bias", "bytes/px"];
/// As usual as on hardware, twice that, and what the paper asks of the basic method.
const SAMPLES: [u32; 3] = [8, 16, 64];

fn motor<B: Backend>(lab: &Lab<'_, B>, alpha: f32, methods: &[String]) -> Result<Played> {
    let methods: Vec<&str> = methods.iter().map(String::as_str).collect();
    lab.play(&Take {
        scene: "motor",
        alpha: Some(alpha),
        camera: "static",
        start_secs: 0.0,
        frames: 4,
        antialiasing: Antialiasing::NONE,
        methods: &methods,
        truth_samples: None,
    })
}

/// ST Fig. 2: the basic method with more and more samples.
pub(super) fn samples<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let methods = SAMPLES.map(|samples| format!("stochastic:samples={samples},estimator=basic,correct=off"));
    let played = motor(lab, 0.3, &methods)?;
    let errors = methods.each_ref().map(|method| played.sample(method, |row| row.rms));
    let falls = errors[0].mean() / errors[2].mean();
    // Samples of one fragment are stratified and those of several are not: between 1/√S and 1/S.
    let claims = vec![
        falling("the error falls with the samples", &errors),
        claim(
            format!("from 8 to 64 samples it falls by {falls:.2}, between √8 less a tenth and 8"),
            (8.0_f64.sqrt() * 0.9..=8.0).contains(&falls),
        ),
    ];
    let shown: Vec<&str> = methods.iter().map(String::as_str).chain(["baseline"]).collect();
    Ok(Findings {
        claims,
        commands: vec![played.command.clone()],
        tables: vec![(String::new(), played.figures(COLUMNS))],
        pictures: played.pictures(&shown).collect(),
        ..Findings::default()
    })
}

/// From basic to the final algorithm, in the paper's order.
const ESTIMATORS: [&str; 4] = [
    "estimator=basic,correct=off",
    "estimator=basic,correct=on",
    "estimator=depth,correct=off",
    "estimator=depth,correct=on",
];

/// ST Fig. 4: what noise reduction does, at 8, 16 and 64 samples.
pub(super) fn estimators<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let mut findings = Findings::default();
    for alpha in [0.3, 0.4] {
        let with = |samples: u32| ESTIMATORS.map(|keys| format!("stochastic:samples={samples},{keys}"));
        let all: Vec<String> = SAMPLES.iter().flat_map(|&samples| with(samples)).collect();
        let played = motor(lab, alpha, &all)?;
        let rows = SAMPLES.iter().map(|&samples| {
            let errors = with(samples).map(|method| played.sample(&method, |row| row.rms));
            let [basic, corrected, depth, both] = errors.each_ref().map(Sample::mean);
            let text = format!(
                "alpha {alpha}, {samples} samples: RMS {basic:.4} basic > {corrected:.4} corrected > {depth:.4} depth > {both:.4} depth, corrected"
            );
            findings.claims.push(falling(text, &errors).remark(
                "",
                "Not every step of the paper gains here: colours of layers differ, and ST says of its Example 1 that alpha correction then may not.",
            ));
            let numbers = errors.iter().map(|sample| Datum::Number(Some(sample.mean()), 4));
            [Datum::Word(samples.to_string())].into_iter().chain(numbers).collect()
        });
        let titles = ["samples", "basic", "corrected", "depth", "depth, corrected"];
        let table = Figures::of_data(&titles, rows.collect());
        findings.tables.push((format!("RMS error in linear light, alpha {alpha}."), table));
        findings.commands.push(played.command.clone());
        if alpha == 0.4 {
            let shown = with(8);
            let shown: Vec<&str> = shown.iter().map(String::as_str).chain(["baseline"]).collect();
            findings.pictures.extend(played.pictures(&shown));
        }
    }
    Ok(findings)
}

/// ST Fig. 3: visibility along a ray from a light, and what stochastic maps make of it.
pub(super) fn visibility<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    const BLOCKERS: u32 = 8;
    const DRAWS: u32 = 400;
    const STEPS: u32 = 200;
    let blockers = Blockers::random(BLOCKERS, lab.seed);
    let depths = || (0..=STEPS).map(|step| step as f32 / STEPS as f32);
    let mut findings = Findings::default();
    let mut rows = Vec::new();
    let mut spreads = Vec::new();
    for samples in [8, 32, 256, 1024] {
        let draws: Vec<_> = (0..DRAWS)
            .map(|draw| blockers.sample(samples, Sampling::Naive, lab.seed.wrapping_add(draw)))
            .collect();
        let (mut off, mut worst_mean, mut band) = (0.0, 0.0_f64, Vec::new());
        for depth in depths() {
            let truth = f64::from(blockers.truth(depth));
            let found: Vec<f64> = draws.iter().map(|draw| f64::from(draw.at(depth))).collect();
            off += found.iter().map(|value| (value - truth).powi(2)).sum::<f64>();
            let mean = found.iter().sum::<f64>() / f64::from(DRAWS);
            // Of so many draws of so many samples each.
            let error = (truth * (1.0 - truth) / f64::from(DRAWS * samples)).sqrt();
            worst_mean = worst_mean.max(if error > 0.0 { (mean - truth).abs() / error } else { 0.0 });
            band.push([f64::from(depth), quantile(&found, 0.05), quantile(&found, 0.95)]);
        }
        let spread = (off / f64::from(DRAWS * (STEPS + 1))).sqrt();
        spreads.push(spread);
        // Of 8 blockers as many independent deviations: the largest stays below 4 in all but 1 of 2000 runs.
        let text = format!(
            "{samples} samples: the mean of {DRAWS} draws is the truth, {worst_mean:.2} standard errors off at most"
        );
        findings.claims.push(claim(text, worst_mean < 4.0));
        let line = |of: &dyn Fn(f32) -> f32| -> Vec<[f64; 2]> {
            depths().map(|depth| [f64::from(depth), f64::from(of(depth))]).collect()
        };
        let plot = Plot {
            description: format!(
                "Visibility over depth with {samples} samples: the truth, two draws, and where nine in ten lie"
            ),
            x: Axis::new("depth"),
            y: Axis::new("visibility").with_zero(),
            series: vec![
                Series::line("truth", line(&|depth| blockers.truth(depth))).with_band(band),
                Series::line("one draw", line(&|depth| draws[0].at(depth))),
                Series::line("another", line(&|depth| draws[1].at(depth))),
            ],
        };
        findings.plots.push((format!("{samples} samples; nine in ten draws lie in the band."), plot));
        rows.push(vec![Datum::Word(samples.to_string()), Datum::Number(Some(spread), 5)]);
    }
    let falls = spreads[0] / spreads[3];
    // √128 = 11.3, with the scatter of 400 draws.
    let text = format!("from 8 to 1024 samples the spread falls by {falls:.1}, as 1/√S");
    findings.claims.push(claim(text, (10.2..12.5).contains(&falls)));
    findings.tables.push((
        "RMS deviation from the true visibility.".to_owned(),
        Figures::of_data(&["samples", "RMS"], rows),
    ));
    Ok(findings)
}

/// A frame and what it took.
struct Still {
    planes: Planes,
    timings: Timings,
    steps: Vec<StepTime>,
}

/// Renders one frame of a stage, where it is, under some shadows and without jitter.
fn still<B: Backend>(
    lab: &Lab<'_, B>,
    stage: &mut B::Stage,
    method: &str,
    shadow: &str,
    size: [u32; 2],
    frame: u32,
) -> Result<Still> {
    let shadow = shadow.parse::<Shadow>()?;
    let settings = Settings { size, seed: lab.seed, shadow, first_frame: frame, ..Settings::default() };
    let mut pipelines = lab.pipelines(&[method], Antialiasing::NONE, settings)?;
    let mut timings = Timings::default();
    play(lab.backend, stage, &mut pipelines, Timeline::Still(1), |event| {
        if let Event::Rendered { cost, .. } = event {
            timings = cost.1;
        }
        Ok(())
    })?;
    lab.progress.step();
    let planes = lab.planes(&pipelines[0])?.into_owned();
    Ok(Still { planes, timings, steps: lab.backend.steps(&pipelines[0]).to_vec() })
}

/// Eight samples a texel and no filter, so that the noise is seen (ST Fig. 5).
const SHADOWS: [(&str, &str); 3] = [
    ("naive", "stochastic-map:samples=8,sampling=naive,filter=1"),
    ("stratified", "stochastic-map:samples=8,sampling=stratified,filter=1"),
    ("stratified, corrected", "stochastic-map:samples=8,sampling=stratified,correct=on,filter=1"),
];
/// What else there is.
const OTHER_SHADOWS: [(&str, &str); 3] =
    [("deep map", "deep-map"), ("opacity map", "opacity-map"), ("Fourier", "fourier")];

/// ST Fig. 5: noise in stochastic shadow maps, and the techniques beside them.
pub(super) fn shadows<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    /// Pictures with noise of their own, of which the mean error is taken.
    const FRAMES: u32 = 4;
    let mut findings = Findings::default();
    for (scene, start_secs) in [("plume:particles=20000", 0.0), ("windy-hill", 0.0), ("smoke-square", 5.0)] {
        let stage = &mut lab.open(scene, "static", None)?;
        let start = lab.moments(start_secs, 1, 1);
        play(lab.backend, stage, &mut [], Timeline::Moments(&start), |_| Ok(()))?;
        let rgb = |rendered: &Still| rendered.planes.colour.map(|&[r, g, b, _]| [r, g, b]);
        let exact = still(lab, stage, "baseline", "deep", lab.size, 0)?;
        // The noise alone: a map has errors that no number of samples mends, and they are those of the map
        // that keeps every blocker.
        let sharp = rgb(&still(lab, stage, "baseline", "deep-map:tolerance=0", lab.size, 0)?);
        let mut rows = Vec::new();
        let mut noise = Vec::new();
        for (name, shadow) in SHADOWS.iter().chain(&OTHER_SHADOWS) {
            let (mut to_exact, mut to_sharp, mut ms) = (0.0, Vec::new(), Vec::new());
            for frame in 0..FRAMES {
                let rendered = still(lab, stage, "baseline", shadow, lab.size, frame)?;
                to_exact += rms(&rgb(&exact), &rgb(&rendered))? / f64::from(FRAMES);
                to_sharp.push(rms(&sharp, &rgb(&rendered))?);
                ms.push(rendered.timings.shadow_ms);
                if frame == 0 && scene != "smoke-square" {
                    findings.pictures.push(picture(name, &rendered.planes));
                }
            }
            let to_sharp = Sample::new(*name, to_sharp);
            rows.push(vec![
                Datum::Word((*name).to_owned()),
                Datum::Number(Some(to_exact), 5),
                Datum::Number(Some(to_sharp.mean()), 5),
                Datum::Number(Some(quantile(&ms, 0.5)), 1),
            ]);
            noise.push(to_sharp);
        }
        if scene != "smoke-square" {
            findings.pictures.push(picture("deep rays", &exact.planes));
        }
        let quantity = format!("{scene}: noise");
        findings
            .claims
            .extend([less(&quantity, &noise[1], &noise[0]), less(&quantity, &noise[2], &noise[1])]);
        let titles = ["shadow", "RMS to deep rays", "RMS to the full map", "map ms"];
        findings.tables.push((scene.to_owned(), Figures::of_data(&titles, rows)));
    }
    findings.commands = SHADOWS
        .iter()
        .map(|(_, shadow)| format!("sheer render windy-hill -m baseline -a none --shadow {shadow}"))
        .collect();
    Ok(findings)
}

/// The paper's picture, samples and shadow samples (ST Table 1): 2048² in all, 16 of them a lookup.
const TABLE_SIZE: [u32; 2] = [500, 500];
const TABLE_SHADOW: &str = "stochastic-map:resolution=1024,samples=4,filter=2";
/// The final algorithm of ST section 3.5, each pass over the geometry anew; one exact pass; peeling without
/// samples, as in the paper.
const FINAL: &str = "stochastic:samples=8,placement=box,retrace=on";
const BLENDED: &str = "list:samples=8";
const PEELING: &str = "peel:layers=10,retrace=on";

/// ST Table 1: what the passes cost.
pub(super) fn table<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let mut findings = Findings::default();
    for scene in ["motor", "hairball", "windy-hill"] {
        let stage = &mut lab.open(scene, "static", None)?;
        let mut turn = |method, frame| still(lab, stage, method, TABLE_SHADOW, TABLE_SIZE, frame);
        let (blended, stochastic, peeled) = (turn(BLENDED, 0)?, turn(FINAL, 0)?, turn(PEELING, 0)?);
        let without_map = |rendered: &Still| rendered.timings.trace_ms - rendered.timings.shadow_ms;
        // The paper tells the time of peeling on its motor alone.
        if scene == "motor" {
            let (mut passes, mut peels) = (vec![without_map(&stochastic)], vec![without_map(&peeled)]);
            for frame in 1..lab.seed_count {
                passes.push(without_map(&turn(FINAL, frame)?));
                peels.push(without_map(&turn(PEELING, frame)?));
            }
            let [passes, peels] = [Sample::new(FINAL, passes), Sample::new(PEELING, peels)];
            let text = format!(
                "{scene}: ten peels take longer than all passes of stochastic transparency, {:.2} of their time; the paper has 1.5",
                peels.mean() / passes.mean()
            );
            findings.claims.push(less_as(text, &passes, &peels).remark(
                "",
                "By rays ten peels are the cheaper ones: the order of the paper does not carry over.",
            ));
        }
        let base = without_map(&blended);
        // Steps are of all threads together on the processor; a picture waits for a share of them.
        let together = match lab.backend.step_clock() {
            StepClock::Threads => lab.backend.threads(stage) as f64,
            StepClock::Device => 1.0,
        };
        let mut rows = Vec::new();
        let mut row = |name: &str, ms: f64| {
            rows.push(vec![
                Datum::Word(name.to_owned()),
                Datum::Number(Some(ms), 0),
                Datum::Number(Some(ms / base), 2),
            ]);
        };
        row("one exact blended pass", base);
        row("stochastic shadow map", stochastic.timings.shadow_ms);
        for step in &stochastic.steps {
            row(step.name, step.ms / together);
        }
        let whole = stochastic.timings.trace_ms;
        row("the whole of it", whole);
        row("depth peeling, 10 layers, one sample", without_map(&peeled));
        let titles = ["step", "ms", "of one blended pass"];
        findings.tables.push((scene.to_owned(), Figures::of_data(&titles, rows)));
        let times = without_map(&stochastic) / base;
        let text = format!("{scene}: all passes take {times:.2} times one blended pass, at most four");
        findings.claims.push(claim(text, times <= 4.0));
    }
    findings.commands.push(format!("sheer bench motor --size 500x500 --frames 3 --shadow {TABLE_SHADOW} -m {BLENDED} -m {FINAL} -m {PEELING}"));
    Ok(findings)
}

/// ST section 5: the time of stochastic transparency grows with the fragments, that of peeling with their
/// square.
pub(super) fn growth<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    const COUNTS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
    const METHODS: [&str; 3] = ["list", "stochastic:samples=8,retrace=on", "peel:layers=64,retrace=on"];
    const REPEATS: u32 = 5;
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); METHODS.len()];
    for count in COUNTS {
        let stage = &mut lab.open(&format!("layers:count={count},alpha=0.02"), "static", None)?;
        let mut ms = vec![Vec::new(); METHODS.len()];
        for frame in 0..=REPEATS {
            for (method, ms) in METHODS.iter().zip(&mut ms) {
                let rendered = still(lab, stage, method, "deep", lab.size, frame)?;
                // The first warms up.
                if frame > 0 {
                    ms.push(rendered.timings.trace_ms);
                }
            }
        }
        for (times, ms) in times.iter_mut().zip(&ms) {
            times.push(quantile(ms, 0.5));
        }
    }
    // From 16 to 64 layers: what each pixel costs whatever its layers is left behind.
    let exponent = |times: &[f64]| (times[6] / times[4]).log2() / 2.0;
    let [stochastic, peeling] = [exponent(&times[1]), exponent(&times[2])];
    let rows = COUNTS.iter().enumerate().map(|(at, count)| {
        let numbers = times.iter().map(|times| Datum::Number(Some(times[at]), 2));
        [Datum::Word(count.to_string())].into_iter().chain(numbers).collect()
    });
    let titles = ["layers", METHODS[0], METHODS[1], METHODS[2]];
    let lines = METHODS.iter().zip(&times).map(|(method, times)| {
        let points = COUNTS.iter().zip(times).map(|(&count, &ms)| [f64::from(count), ms]);
        Series::line(method, points).with_dots()
    });
    let plot = Plot {
        description: "Milliseconds of a frame over the number of layers, both logarithmic".to_owned(),
        x: Axis::new("layers").logarithmic(),
        y: Axis::new("ms").logarithmic(),
        series: lines.collect(),
    };
    Ok(Findings {
        claims: vec![
            claim(
                format!(
                    "stochastic transparency grows as the fragments to the power {stochastic:.2}: linearly"
                ),
                (0.7..1.3).contains(&stochastic),
            ),
            claim(
                format!("peeling grows as the fragments to the power {peeling:.2}: with the square"),
                (1.6..2.3).contains(&peeling),
            ),
        ],
        tables: vec![("Milliseconds of a frame.".to_owned(), Figures::of_data(&titles, rows.collect()))],
        plots: vec![("Time over the number of layers.".to_owned(), plot)],
        ..Findings::default()
    })
}

/// What people use where fragments cannot be sorted.
const FAMILY: &[&str] = &[
    "list",
    "stochastic",
    "stochastic:samples=64",
    "peel:layers=4",
    "peel",
    "kbuffer",
    "weighted",
    "mlab",
    "adaptive",
    "moments:order=4",
    "moments:order=6",
    "moments:order=8",
    "std",
];
/// Every built-in scene that has more to show than its opacities.
const SCENES: [(&str, &str, f32); 8] = [
    ("layers:count=8,alpha=0.3,colours=rainbow", "static", 0.0),
    ("smoke-square", "path", 5.0),
    ("pane", "static", 0.0),
    ("arena", "static", super::quality::HEIGHT_OF_FIGHT_SECS),
    ("motor", "static", 0.0),
    ("windy-hill", "static", 0.0),
    ("hairball", "static", 0.0),
    ("plume:particles=20000", "static", 0.0),
];

/// The family on every scene.
pub(super) fn family<B: Backend>(lab: &Lab<'_, B>) -> Result<Findings> {
    let mut findings = Findings::default();
    let built_in = SCENES.map(|(scene, camera, start_secs)| (scene.to_owned(), camera, start_secs, None));
    let files = lab.files.iter().map(|file| (file.clone(), "static", 0.0, Some(0.3)));
    for (scene, camera, start_secs, alpha) in built_in.into_iter().chain(files) {
        let antialiasing = Antialiasing::NONE;
        let played = lab.play(&Take {
            scene: &scene,
            alpha,
            camera,
            start_secs,
            frames: 2,
            antialiasing,
            methods: FAMILY,
            truth_samples: None,
        })?;
        let short = super::averages::short_name(&scene);
        // The baseline ends at a visibility of a thousandth.
        let exact = played.row("list").rms;
        findings.claims.push(claim(format!("{short}: list is exact, RMS {exact:.5}"), exact < 2e-3));
        // They see every fragment, whatever the order, where peeling leaves off.
        let bounded = ["mlab", "moments:order=8"];
        let worst = bounded.iter().map(|method| played.row(method).rms).fold(0.0, f64::max);
        let peeled = played.row("peel:layers=4").rms;
        let text = format!(
            "{short}: mlab and moments of order 8 are nearer than four layers peeled, RMS {worst:.5} < {peeled:.5}"
        );
        findings.claims.push(
            claim(text, worst < peeled || peeled == 0.0)
                .remark("", "Four layers are nearly all that there is to see here."),
        );
        findings.commands.push(played.command.replace(&scene, &short));
        let columns = &[
            "ms",
            "SSIM",
            "PSNR dB",
            "FLIP",
            "RMS",
            "bias",
            "shaded/px",
            "hits/px",
            "bytes/px",
            "merged/px",
        ];
        findings.tables.push((short, played.figures(columns)));
        findings.pictures.extend(played.pictures(&[
            "baseline",
            "stochastic",
            "weighted",
            "moments:order=8",
            "mlab",
            "peel:layers=4",
        ]));
    }
    Ok(findings)
}

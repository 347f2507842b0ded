//! docs/performance.md: what was measured, as tables, held against what the project aims at.

use std::fmt::Write as _;

use crate::{
    Measured, Taken,
    frames::{FrameTimes, Growth},
    mitsuba::MitsubaTimes,
    plot,
    rays::{EMBREE, OBVHS, Question, RayRow, RayTimes, SHEER},
    statistics::{Ratio, exponent, median, ratio},
};

/// What a ratio to Embree is taken against.
#[derive(Clone, Copy)]
enum Against {
    /// The faster of the two ways with packets.
    Packets,
    Continuation,
    /// The fastest way there is.
    Best,
}

impl Against {
    fn holds(self, row: &RayRow) -> bool {
        match self {
            Self::Packets => row.mode.starts_with("packets"),
            Self::Continuation => row.mode == "continuation",
            Self::Best => true,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Packets => "Embree's best packets",
            Self::Continuation => "Embree's continuation rays",
            Self::Best => "Embree's best way",
        }
    }
}

/// How many times as fast as Embree we want to be, on the scenes in their order.
const RAY_AIMS: [(Question, Against, [f64; 3]); 4] = [
    (Question::Stochastic, Against::Packets, [2.0, 1.7, 1.6]),
    (Question::Samples, Against::Packets, [2.8, 1.8, 1.8]),
    (Question::Layers, Against::Continuation, [7.0, 4.0, 1.5]),
    (Question::Shadow, Against::Best, [1.3, 1.3, 1.3]),
];
/// Exponent of the growth of a `std` frame with the number of particles.
const EXPONENT_AIM: f64 = 0.35;
/// Speed-up of the second thread.
const THREADS_AIM: f64 = 1.85;
/// Slowest `std` frame of the path to the median.
const PATH_AIM: f64 = 1.5;
/// Times as fast as Mitsuba at equal error.
const MITSUBA_AIM: f64 = 10.0;

/// The document; `command` is how it is made.
pub(crate) fn text(measured: &Measured) -> String {
    let mut text = String::from(
        "# Performance\n\nMade by `cargo xtask bench-peers` from what it measured; the figures themselves are in `docs/performance.json`. \
         Engines take turns within a run, each figure is the median of all turns, and a ratio is the median of the turns' ratios with the \
         smallest and the largest in brackets. An aim that is not reached is marked ✗.\n",
    );
    if let Some(taken) = &measured.rays {
        rays(&mut text, taken);
    }
    if let Some(taken) = &measured.frames {
        frames(&mut text, taken);
    }
    if let Some(taken) = &measured.mitsuba {
        mitsuba(&mut text, taken);
    }
    text
}

/// The chart of growth, if there is what it shows.
pub(crate) fn chart(measured: &Measured) -> Option<String> {
    measured.frames.as_ref().map(|taken| plot::log_log(&growth(&taken.values)))
}

/// Adds a line.
macro_rules! line {
    ($text:expr) => { line!($text, "") };
    ($text:expr, $($format:tt)*) => {
        writeln!($text, $($format)*).expect("writing to a string never fails")
    };
}

fn provenance<T>(text: &mut String, taken: &Taken<T>) {
    let Taken { commit, processor, cores, load, command, .. } = taken;
    let load = load.map_or_else(String::new, |load| format!(", {load:.1} other processes running"));
    line!(text, "Measured at commit {commit} on {processor} ({cores} cores{load}), `{command}`.\n");
}

fn rays(text: &mut String, taken: &Taken<RayTimes>) {
    let times = &taken.values;
    line!(text, "\n## Rays\n");
    provenance(text, taken);
    let embree = times.embree.as_deref().unwrap_or("not there");
    line!(
        text,
        "One thread, {} turns, its processor time. Embree {embree} from the Python wheel `embreex`, tree of quality MEDIUM, opacity by filter functions that are arguments \
         of the query; obvhs 0.4, compressed tree of eight children, preset `medium_build`; Sheer on its `{}` path. The camera's rays come in tiles \
         of 8 × 8 pixels, packets are blocks of {} of them, or samples of a pixel. The scenes are those of \
         `cargo bench --package sheer-accel`:\n",
        times.rows.first().map_or(0, |row| row.ms.len()),
        times.path,
        if times.packet_width == 16 { "4 × 4" } else { "4 × 2" }
    );
    line!(
        text,
        "| scene | triangles | layers a ray | trees built in (ms, all threads) |\n|---|---:|---:|---|"
    );
    for scene in &times.scenes {
        let builds: Vec<String> =
            scene.build_ms.iter().map(|(engine, ms)| format!("{engine} {ms:.0}")).collect();
        line!(text, "| {} | {} | {:.1} | {} |", scene.name, scene.triangles, scene.layers, builds.join(", "));
    }
    let scenes: Vec<&str> = times.scenes.iter().map(|scene| scene.name.as_str()).collect();
    if times.embree.is_some() {
        ray_aims(text, times, &scenes);
    }
    for question in Question::ALL {
        line!(
            text,
            "\n### {}\n\nMillion rays a second; in brackets the share of rays with another answer than Sheer's single rays, in ‰.\n",
            question.title()
        );
        line!(text, "| engine | {} |\n|---|{}", scenes.join(" | "), "---:|".repeat(scenes.len()));
        let first: Vec<&RayRow> =
            times.rows.iter().filter(|row| row.question == question && row.scene == scenes[0]).collect();
        for named in first {
            let cell = |scene: &&str| {
                find(times, question, scene, &named.engine, &named.mode).map_or_else(String::new, speed)
            };
            let cells: Vec<String> = scenes.iter().map(cell).collect();
            line!(text, "| {}, {} | {} |", named.engine, named.mode, cells.join(" | "));
        }
    }
    line!(
        text,
        "\nAnswers differ where a ray meets the edge of a triangle, or of a texel, within the rounding of an engine; Embree's and obvhs's test are not \
         watertight, and continuation rays lose layers at one distance. More than 2 % of rays is an error.\n"
    );
}

fn speed(row: &RayRow) -> String {
    let rate = row.rays as f64 / (1e3 * median(&row.ms));
    let permille = 1e3 * row.differing as f64 / row.rays as f64;
    if row.differing == 0 { format!("{rate:.2}") } else { format!("{rate:.2} ({permille:.2})") }
}

fn find<'a>(
    times: &'a RayTimes,
    question: Question,
    scene: &str,
    engine: &str,
    mode: &str,
) -> Option<&'a RayRow> {
    let is_it = |row: &&RayRow| {
        row.question == question && row.scene == scene && row.engine == engine && row.mode == mode
    };
    times.rows.iter().find(is_it)
}

/// The fastest of an engine's ways that may count.
fn fastest<'a>(
    times: &'a RayTimes,
    question: Question,
    scene: &str,
    engine: &str,
    counts: impl Fn(&RayRow) -> bool,
) -> Option<&'a RayRow> {
    let rows = times
        .rows
        .iter()
        .filter(|row| row.question == question && row.scene == scene && row.engine == engine && counts(row));
    rows.min_by(|a, b| median(&a.ms).total_cmp(&median(&b.ms)))
}

fn ray_aims(text: &mut String, times: &RayTimes, scenes: &[&str]) {
    line!(text, "\nHow many times as fast Sheer's best way is, and what it is to be:\n");
    line!(text, "| | against | {} |\n|---|---|{}", scenes.join(" | "), "---|".repeat(scenes.len()));
    for (question, against, aims) in RAY_AIMS {
        let cell = |(scene, aim): (&&str, f64)| {
            let ours = fastest(times, question, scene, SHEER, |_| true)?;
            let theirs = fastest(times, question, scene, EMBREE, |row| against.holds(row))?;
            let ratio = ratio(&theirs.ms, &ours.ms);
            Some(format!("{} by {}, {}", ratio_text(ratio), ours.mode, at_least(ratio.median, aim)))
        };
        let cells: Vec<String> = scenes.iter().zip(aims).map(|pair| cell(pair).unwrap_or_default()).collect();
        line!(text, "| {} | {} | {} |", question.title(), against.name(), cells.join(" | "));
    }
    for question in Question::ALL {
        let cell = |scene: &&str| {
            let ours = fastest(times, question, scene, SHEER, |_| true)?;
            let theirs = fastest(times, question, scene, OBVHS, |_| true)?;
            Some(ratio_text(ratio(&theirs.ms, &ours.ms)))
        };
        let cells: Vec<String> = scenes.iter().map(|scene| cell(scene).unwrap_or_default()).collect();
        line!(text, "| {} | obvhs | {} |", question.title(), cells.join(" | "));
    }
}

fn ratio_text(ratio: Ratio) -> String {
    format!("**{:.2}** ({:.2}–{:.2})", ratio.median, ratio.min, ratio.max)
}

fn at_least(value: f64, aim: f64) -> String {
    format!("aim {aim} {}", if value >= aim { "✓" } else { "✗" })
}

fn at_most(value: f64, aim: f64) -> String {
    format!("aim at most {aim} {}", if value <= aim { "✓" } else { "✗" })
}

fn frames(text: &mut String, taken: &Taken<FrameTimes>) {
    let times = &taken.values;
    line!(text, "\n## Whole frames\n");
    provenance(text, taken);
    line!(
        text,
        "A frame with building, shadows, shading and, where it is added up over time, that; all threads.\n"
    );
    line!(text, "| method | ms a frame | slowest over fastest | command |\n|---|---:|---:|---|");
    for run in &times.whole {
        for row in &run.rows {
            let low = row.ms.iter().copied().fold(f64::INFINITY, f64::min);
            let high = row.ms.iter().copied().fold(0.0, f64::max);
            line!(
                text,
                "| {} | {:.1} | {:.2} | `{}` |",
                row.name(),
                row.whole_ms_median,
                high / low,
                run.command
            );
        }
    }

    line!(text, "\n### More particles\n\n![Time of a frame by number of particles](performance.svg)\n");
    let lines = growth(times);
    let counts: Vec<String> =
        lines.first().iter().flat_map(|line| &line.points).map(|[x, _]| format!("{x}")).collect();
    line!(
        text,
        "Milliseconds of a frame, and the exponent of the number of particles that fits best (least squares of logarithms):\n"
    );
    line!(text, "| method | {} | exponent |\n|---|{}---:|", counts.join(" | "), "---:|".repeat(counts.len()));
    for line in &lines {
        let cells: Vec<String> = line.points.iter().map(|[_, ms]| format!("{ms:.1}")).collect();
        let exponent = exponent(&line.points);
        let aim = if line.name.starts_with("std at ") {
            format!(", {}", at_most(exponent, EXPONENT_AIM))
        } else {
            String::new()
        };
        line!(text, "| {} | {} | {exponent:.2}{aim} |", line.name, cells.join(" | "));
    }
    let is_first = |growth: &&Growth| growth.particles == times.growth[0].particles;
    line!(text);
    for growth in times.growth.iter().filter(is_first) {
        line!(text, "    {}", growth.run.command);
    }

    let [one, two] =
        [0, 1].map(|which: usize| times.threads.iter().map(|pair| pair[which]).collect::<Vec<_>>());
    let speedup = ratio(&one, &two);
    line!(text, "\n### Two threads\n");
    line!(
        text,
        "Two threads are {} times as fast as one, {} ({:.1} and {:.1} ms a frame).\n\n    {}",
        ratio_text(speedup),
        at_least(speedup.median, THREADS_AIM),
        median(&one),
        median(&two),
        times.threads_command
    );

    line!(text, "\n### Along the path\n");
    for row in &times.path.rows {
        let (middle, slowest) = (median(&row.ms), row.ms.iter().copied().fold(0.0, f64::max));
        let at = row.ms.iter().position(|&ms| ms == slowest).unwrap_or_default();
        line!(
            text,
            "The slowest of {} `{}` frames takes {:.2} times the median, {} ({slowest:.1} and {middle:.1} ms; frame {at}).\n\n    {}",
            row.ms.len(),
            row.method,
            slowest / middle,
            at_most(slowest / middle, PATH_AIM),
            times.path.command
        );
    }
}

/// A method's frame times by number of particles.
fn growth(times: &FrameTimes) -> Vec<plot::Line> {
    let mut lines: Vec<plot::Line> = Vec::new();
    for Growth { particles, size, run } in &times.growth {
        for row in &run.rows {
            let name = format!("{} at {}", row.name(), size.replace('x', " × "));
            let point = [f64::from(*particles), row.whole_ms_median];
            match lines.iter_mut().find(|line| line.name == name) {
                Some(line) => line.points.push(point),
                None => lines.push(plot::Line { name, points: vec![point] }),
            }
        }
    }
    lines
}

fn mitsuba(text: &mut String, taken: &Taken<MitsubaTimes>) {
    let times = &taken.values;
    line!(text, "\n## Mitsuba 3\n");
    provenance(text, taken);
    let ms = median(&times.ms);
    line!(
        text,
        "Mitsuba {} ({}) renders the cloud of `smoke`, its opacity at vertices in place of textures, {} × {} pixels, with {} samples a pixel \
         in {ms:.0} ms after its kernels are compiled; the root of its mean square error is {:.5}, against {} frames of `baseline`. That both show the same \
         was tested on blocks of 16 × 16 pixels: p = {:.3}, and a picture 2 % brighter is found out. How long Sheer takes to have no larger error, all threads for both:\n",
        times.version,
        times.variant,
        times.size[0],
        times.size[1],
        times.samples,
        times.rms,
        times.reference_frames,
        times.p
    );
    line!(text, "| method | frames | error | ms | times as fast |\n|---|---:|---:|---:|---|");
    for row in &times.rows {
        let Some(frames) = row.frames else {
            line!(text, "| `{}` | never | {:.5} | | |", row.method, row.rms);
            continue;
        };
        let whole: Vec<f64> = row.frame_ms.iter().map(|ms| ms * f64::from(frames)).collect();
        let ratio = ratio(&times.ms, &whole);
        line!(
            text,
            "| `{}` | {frames} | {:.5} | {:.1} | {}, {} |",
            row.method,
            row.rms,
            median(&whole),
            ratio_text(ratio),
            at_least(ratio.median, MITSUBA_AIM)
        );
    }
    if times.rows.iter().any(|row| row.frames.is_none()) {
        line!(text, "\nNever: not within {} frames; the error is the one then.", times.most_frames);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(engine: &str, mode: &str, ms: &[f64]) -> RayRow {
        RayRow {
            scene: "smoke".to_owned(),
            question: Question::Stochastic,
            engine: engine.to_owned(),
            mode: mode.to_owned(),
            rays: 1000,
            differing: 1,
            ms: ms.to_vec(),
        }
    }

    #[test]
    fn the_best_of_each_engine_is_compared_and_a_missed_aim_is_marked() {
        let times = RayTimes {
            rows: vec![
                row(SHEER, "single", &[4.0, 4.0, 4.0]),
                row(SHEER, "tiles", &[1.0, 1.0, 1.0]),
                row(EMBREE, "single", &[0.5, 0.5, 0.5]),
                row(EMBREE, "packets", &[3.0, 3.0, 3.0]),
                row(EMBREE, "packets, coherent", &[1.5, 1.6, 1.7]),
            ],
            ..RayTimes::default()
        };
        let mut text = String::new();
        ray_aims(&mut text, &times, &["smoke"]);
        assert!(text.contains("| **1.60** (1.50–1.70) by tiles, aim 2 ✗ |"), "{text}");
    }

    #[test]
    fn aims_are_reached_from_both_sides() {
        assert_eq!(at_least(2.0, 2.0), "aim 2 ✓");
        assert_eq!(at_most(0.36, 0.35), "aim at most 0.35 ✗");
    }
}

//! `sheer bench`: what methods cost.

use sheer_render::{Antialiasing, Clock, Pipeline};

use crate::{
    args::{BenchArguments, DEFAULT_SIZE},
    output::{self, TextOutput},
    report::{
        json::{self, Benchmark, BenchmarkRow},
        table::{Table, number},
    },
    setup::{self, without_repeats},
    tally::Tally,
};

pub(crate) fn run(arguments: &BenchArguments) -> anyhow::Result<()> {
    let talk = arguments.machine.apply()?;
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let settings = arguments.frames.settings(DEFAULT_SIZE);
    let frame_count = arguments.frames.frames;
    let methods = without_repeats(&arguments.methods);
    let mut opened = arguments.scene.open(arguments.machine, talk)?;
    let stage = &mut opened.stage;

    // The cost of adding frames up is no part of a frame's time, so they are not added up.
    let clock = Clock::new(&settings, Antialiasing::None);
    let pipelines = methods.iter().map(|method| Pipeline::new(method.clone(), Antialiasing::None, settings));
    let mut pipelines = pipelines.collect::<Result<Vec<_>, _>>()?;
    let mut tallies = vec![Tally::default(); methods.len()];
    let progress = talk.progress(u64::from(frame_count + 1) * methods.len() as u64);

    // Warm-up: tables are built, memory is touched, the processor leaves its sleep.
    stage.advance(clock.at(0));
    for pipeline in &mut pipelines {
        pipeline.render(stage, 0)?;
        progress.inc(1);
    }
    // All methods take turns at each frame, so that a change in the machine's speed meets all of them, and none is always the first.
    for index in 0..frame_count {
        stage.advance(clock.at(index));
        for turn in 0..methods.len() {
            let at = (turn + index as usize) % methods.len();
            tallies[at].add(pipelines[at].render(stage, index)?);
            progress.inc(1);
        }
    }
    progress.finish_and_clear();

    let rows: Vec<BenchmarkRow> = (methods.iter().zip(&tallies))
        .map(|(method, tally)| BenchmarkRow {
            method: method.to_string(),
            ms: tally.frame_ms(),
            ms_median: tally.ms(0.5),
            ms_min: tally.ms(0.0),
            ms_max: tally.ms(1.0),
            ms_spread: tally.ms(0.75) - tally.ms(0.25),
            ratio: tally.ms(0.5) / tallies[0].ms(0.5),
            build_ms_median: tally.build_ms(),
            rays: tally.rays(),
            shaded: tally.shaded(),
            mray_per_s: tally.mray_per_s(),
        })
        .collect();
    let run = setup::describe(&arguments.scene, arguments.machine, &opened, &settings, frame_count);
    let report = Benchmark { run, rows };
    let text = json::text(&report)?;
    match &json {
        Some(output) if output.is_stdout() => output.write(&text),
        Some(output) => output.write(&text).and_then(|()| output::print(&table(&report))),
        None => output::print(&table(&report)),
    }
}

fn table(report: &Benchmark) -> String {
    let [width, height] = report.run.size;
    let pixels = f64::from(width) * f64::from(height);
    let mut table = Table::new(&[
        "method",
        "ms",
        "spread",
        "min",
        "max",
        "ratio",
        "build ms",
        "rays/px",
        "shaded/px",
        "Mray/s",
    ]);
    for row in &report.rows {
        table.add(vec![
            row.method.clone(),
            number(row.ms_median, 2),
            number(row.ms_spread, 2),
            number(row.ms_min, 2),
            number(row.ms_max, 2),
            number(row.ratio, 3),
            number(row.build_ms_median, 2),
            number(row.rays / pixels, 2),
            number(row.shaded / pixels, 2),
            number(row.mray_per_s, 2),
        ]);
    }
    table.text()
}

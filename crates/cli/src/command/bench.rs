//! `sheer bench`: what methods cost.

use sheer_render::{Antialiasing, Clock, Method, Pipeline};

use crate::{
    args::{BenchArguments, DEFAULT_SIZE},
    output::{self, TextOutput},
    report::{
        benchmark::figures,
        json::{self, Benchmark, BenchmarkRow},
        page,
    },
    setup::{self, without_repeats},
    tally::Tally,
};

pub(crate) fn run(arguments: &BenchArguments) -> anyhow::Result<()> {
    let talk = arguments.machine.apply()?;
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let html = arguments.html.as_deref().map(TextOutput::open).transpose()?;
    let settings = arguments.light.under(arguments.frames.settings(DEFAULT_SIZE));
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

    let rows = methods.iter().zip(&tallies).map(|(method, tally)| row(method, tally, &tallies[0])).collect();
    let run = setup::describe(&arguments.scene, arguments.machine, &opened, &settings, frame_count);
    let report = Benchmark { run, rows };
    if let Some(output) = &html {
        output.write(&page::benchmark::text(&report)?)?;
    }
    if let Some(output) = &json {
        output.write(&json::text(&report)?)?;
    }
    let replaces_table = |output: &Option<TextOutput<'_>>| output.as_ref().is_some_and(TextOutput::is_stdout);
    if replaces_table(&json) || replaces_table(&html) {
        Ok(())
    } else {
        output::print(&figures(&report).text())
    }
}

fn row(method: &Method, tally: &Tally, first: &Tally) -> BenchmarkRow {
    BenchmarkRow {
        method: method.to_string(),
        ms: tally.frame_ms(),
        ms_median: tally.ms(0.5),
        ms_min: tally.ms(0.0),
        ms_max: tally.ms(1.0),
        ms_spread: tally.ms(0.75) - tally.ms(0.25),
        ratio: tally.ms(0.5) / first.ms(0.5),
        build_ms_median: tally.build_ms(),
        shadow_ms_median: tally.shadow_ms(),
        rays: tally.rays(),
        shaded: tally.shaded(),
        mray_per_s: tally.mray_per_s(),
    }
}

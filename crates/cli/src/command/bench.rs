//! `sheer bench`: what methods cost.

use sheer_render::{Antialiasing, Clock, Method, Settings};

use crate::{
    args::{BenchArguments, DEFAULT_SIZE},
    backend::{Renderer, Task},
    output::{self, TextOutput},
    report::{
        benchmark::{figures, passes},
        json::{self, Benchmark, BenchmarkRow, Step},
        page,
    },
    setup::{self, without_repeats},
    talk::Talk,
    tally::Tally,
};

pub(crate) fn run(arguments: &BenchArguments) -> anyhow::Result<()> {
    arguments.backend.run(arguments)
}

impl Task for BenchArguments {
    fn run_on(&self, renderer: &impl Renderer) -> anyhow::Result<()> {
        bench(self, renderer)
    }
}

fn bench<R: Renderer>(arguments: &BenchArguments, renderer: &R) -> anyhow::Result<()> {
    let talk = arguments.machine.apply()?;
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let html = arguments.html.as_deref().map(TextOutput::open).transpose()?;
    let settings = arguments.light.under(arguments.frames.settings(DEFAULT_SIZE));
    let frame_count = arguments.frames.frames;
    let methods = without_repeats(&arguments.methods);
    let mut opened = arguments.scene.open(renderer, arguments.machine, talk)?;
    let tallies = measure(renderer, &mut opened.stage, &methods, settings, frame_count, talk)?;

    let rows = methods.iter().zip(&tallies).map(|(method, tally)| row(method, tally, &tallies[0])).collect();
    let run = setup::describe(renderer, &arguments.scene, &opened, &settings, frame_count);
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
        let passes = passes(&report).map(|passes| format!("\n{}", passes.text()));
        output::print(&(figures(&report).text() + &passes.unwrap_or_default()))
    }
}

/// What the frames of each method cost.
fn measure<R: Renderer>(
    renderer: &R,
    stage: &mut R::Stage,
    methods: &[Method],
    settings: Settings,
    frame_count: u32,
    talk: Talk,
) -> anyhow::Result<Vec<Tally>> {
    // The cost of adding frames up is no part of a frame's time, so they are not added up.
    let antialiasing = Antialiasing::None;
    let clock = Clock::new(&settings, antialiasing);
    let pipelines = methods.iter().map(|method| renderer.pipeline(method, antialiasing, settings));
    let mut pipelines = pipelines.collect::<anyhow::Result<Vec<_>>>()?;
    pipelines.iter().flat_map(|pipeline| renderer.notes(pipeline)).for_each(|note| talk.warn(note));
    let mut tallies = vec![Tally::default(); methods.len()];
    let progress = talk.progress(u64::from(frame_count + 1) * methods.len() as u64);

    // Warm-up: tables are built, memory is touched, the processor leaves its sleep.
    renderer.advance(stage, clock.at(0))?;
    for pipeline in &mut pipelines {
        renderer.render(pipeline, stage, 0)?;
        progress.inc(1);
    }
    // All methods take turns at each frame, so that a change in the machine's speed meets all of them, and none is always the first.
    for index in 0..frame_count {
        renderer.advance(stage, clock.at(index))?;
        for turn in 0..methods.len() {
            let at = (turn + index as usize) % methods.len();
            tallies[at].add(renderer.render(&mut pipelines[at], stage, index)?);
            tallies[at].add_steps(renderer.steps(&pipelines[at]));
            progress.inc(1);
        }
    }
    progress.finish_and_clear();
    Ok(tallies)
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
        steps: tally.steps().map(|(name, ms_median)| Step { name, ms_median }).collect(),
    }
}

//! `sheer bench`: what methods cost.

use sheer_lab::{Progress as _, Seeded, Tally, Timeline, measure_cost};
use sheer_render::{Antialiasing, Backend, Settings};

use crate::{
    args::{BenchArguments, DEFAULT_SIZE},
    backend::Task,
    output::{self, TextOutput},
    report::{
        benchmark::{figures, passes},
        data_files::DataFiles,
        json::{self, Benchmark, BenchmarkRow, Row, Run},
        page,
        table::Table,
    },
    setup::{self, without_repeats},
};

pub(crate) fn run(arguments: &BenchArguments) -> anyhow::Result<()> {
    arguments.backend.run(arguments)
}

impl Task for BenchArguments {
    fn run_on<B: Backend + 'static>(&self, backend: &B) -> anyhow::Result<()> {
        bench(self, backend)
    }
}

fn bench<B: Backend>(arguments: &BenchArguments, backend: &B) -> anyhow::Result<()> {
    let console = arguments.machine.apply()?;
    // What can go wrong goes wrong before the first frame.
    let (to_json, to_html) = (arguments.json.as_deref(), arguments.html.as_deref());
    arguments.data.check_stdout(&[("--json", to_json), ("--html", to_html)])?;
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let html = arguments.html.as_deref().map(TextOutput::open).transpose()?;
    let data_files = DataFiles::open(&arguments.data)?;
    let settings = arguments.light.under(arguments.frames.settings(DEFAULT_SIZE)?);
    let frame_count = arguments.frames.count();
    let methods = without_repeats(&arguments.methods);
    let mut opened = arguments.scene.open(backend, settings.size, arguments.machine, console)?;
    let timeline = Timeline::of(&settings, Antialiasing::NONE, frame_count);
    let antialiasings = without_repeats(&arguments.antialiasings);
    let contestants: Vec<_> =
        antialiasings.iter().flat_map(|aa| methods.iter().map(move |method| (method, *aa))).collect();
    let seeds = arguments.seeds.from(settings.seed);
    let bar = console.bar();
    // One frame more warms up.
    bar.expect((u64::from(frame_count) + 1) * (contestants.len() * seeds.len()) as u64);
    let mut of_seeds: Vec<Vec<Tally>> = Vec::with_capacity(seeds.len());
    for &seed in &seeds {
        let settings = Settings { seed, ..settings };
        of_seeds.push(measure_cost(
            backend,
            &mut opened.stage,
            &contestants,
            settings,
            timeline,
            true,
            &bar,
        )?);
    }
    drop(bar);

    let row = |(at, &(method, aa)): (usize, &(_, _))| {
        let rows = of_seeds.iter().map(|tallies| BenchmarkRow::new(method, aa, &tallies[at], &tallies[0]));
        Seeded::of(rows.collect()).map(Row)
    };
    let rows = contestants.iter().enumerate().filter_map(row).collect();
    let run = setup::describe(backend, &arguments.scene, &opened, &settings, frame_count);
    let run = Run { seeds: arguments.seeds.count(), ..run };
    let report = Benchmark { run, rows };
    if let Some(output) = &html {
        output.write(&page::benchmark::text(&report)?)?;
    }
    if let Some(output) = &json {
        output.write(&json::text(&report)?)?;
    }
    let figures = figures(&report);
    arguments.seeds.explain(&figures, console);
    data_files.write(&figures)?;
    let replaces_table = |output: &Option<TextOutput<'_>>| output.as_ref().is_some_and(TextOutput::is_stdout);
    if replaces_table(&json) || replaces_table(&html) || data_files.is_stdout() {
        Ok(())
    } else {
        let passes = passes(&report).map(|passes| format!("\n{}", Table::of(&passes).text()));
        output::print(&(Table::of(&figures).text() + &passes.unwrap_or_default()))
    }
}

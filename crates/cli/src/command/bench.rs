//! `sheer bench`: what methods cost.

use sheer_lab::{Timeline, measure_cost};
use sheer_render::{Antialiasing, Backend};

use crate::{
    args::{BenchArguments, DEFAULT_SIZE},
    backend::Task,
    output::{self, TextOutput},
    report::{
        benchmark::{figures, passes},
        data_files::DataFiles,
        json::{self, Benchmark, BenchmarkRow},
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
    let tallies =
        measure_cost(backend, &mut opened.stage, &contestants, settings, timeline, true, &console.bar())?;

    let row = |(&(method, aa), tally)| BenchmarkRow::new(method, aa, tally, &tallies[0]);
    let rows = contestants.iter().zip(&tallies).map(row).collect();
    let run = setup::describe(backend, &arguments.scene, &opened, &settings, frame_count);
    let report = Benchmark { run, rows };
    if let Some(output) = &html {
        output.write(&page::benchmark::text(&report)?)?;
    }
    if let Some(output) = &json {
        output.write(&json::text(&report)?)?;
    }
    let figures = figures(&report);
    data_files.write(&figures)?;
    let replaces_table = |output: &Option<TextOutput<'_>>| output.as_ref().is_some_and(TextOutput::is_stdout);
    if replaces_table(&json) || replaces_table(&html) || data_files.is_stdout() {
        Ok(())
    } else {
        let passes = passes(&report).map(|passes| format!("\n{}", Table::of(&passes).text()));
        output::print(&(Table::of(&figures).text() + &passes.unwrap_or_default()))
    }
}

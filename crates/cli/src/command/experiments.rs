//! `sheer experiments`: the figures of the papers, made again and measured, in one report.

use std::path::Path;

use sheer_lab::{
    LabError, Progress as _,
    experiments::{Experiment, Lab},
};
use sheer_render::{Backend, backend::Cpu};

use crate::{
    args::{DEFAULT_EXPERIMENT_SIZE, ExperimentsArguments},
    backend::Task,
    output,
    report::{
        experiments::{Experiments, Section},
        page,
    },
    setup,
};

pub(crate) fn run(arguments: &ExperimentsArguments) -> anyhow::Result<()> {
    if arguments.list {
        let line = |e: &Experiment<Cpu>| format!("{:<14} {} ({})\n", e.id, e.title, e.source);
        return output::print(&Experiment::ALL.iter().map(line).collect::<String>());
    }
    arguments.backend.run(arguments)
}

impl Task for ExperimentsArguments {
    fn run_on<B: Backend + 'static>(&self, backend: &B) -> anyhow::Result<()> {
        experiment(self, backend)
    }
}

fn experiment<B: Backend + 'static>(arguments: &ExperimentsArguments, backend: &B) -> anyhow::Result<()> {
    let chosen = Experiment::chosen(&arguments.names)?;
    let console = arguments.machine.apply()?;
    let folder = arguments.output.as_path();
    output::open_folder(folder)?;
    let bar = console.counter();
    let load = arguments.load.options();
    let lab = Lab {
        backend,
        size: arguments.size.unwrap_or(DEFAULT_EXPERIMENT_SIZE).0,
        seed: arguments.seed,
        seed_count: arguments.seeds,
        threads: arguments.machine.threads,
        progress: &bar,
        files: &arguments.files,
        load: &load,
    };
    let mut sections = Vec::new();
    for experiment in chosen {
        console.note(format_args!("{}: {}", experiment.id, experiment.title));
        sections.push(match (experiment.run)(&lab) {
            Ok(findings) => Section::new(experiment, findings)?,
            // The other experiments are worth having all the same.
            Err(LabError::Unsupported(why)) => {
                bar.warn(&format!("{} is not run by --backend {}: {why}", experiment.id, backend.name()));
                Section::refused(experiment, why.to_string())
            }
            Err(error) => return Err(error.into()),
        });
    }
    let settings = lab.settings(0.0);
    drop(bar);

    let report = Experiments { run: setup::describe_many(backend, &settings), sections };
    write(&report, folder)?;
    output::print(&report.verdicts())?;
    console.note(format_args!(
        "wrote {}, results.md and experiments.json beside it",
        folder.join("index.html").display()
    ));
    Ok(())
}

/// Writes the pictures and charts, then what refers to them.
fn write(report: &Experiments, folder: &Path) -> anyhow::Result<()> {
    for section in &report.sections {
        for (at, png) in section.pictures_png.iter().enumerate() {
            output::write_file(&folder.join(section.picture_file(at)), png)?;
        }
        for (at, (_, plot)) in section.findings.plots.iter().enumerate() {
            let svg = page::chart_file(plot.clone())?;
            output::write_file(&folder.join(section.chart_file(at)), svg.as_bytes())?;
        }
    }
    output::write_file(&folder.join("experiments.json"), report.json()?.as_bytes())?;
    output::write_file(&folder.join("results.md"), report.markdown(".").as_bytes())?;
    output::write_file(&folder.join("index.html"), page::experiments::text(report)?.as_bytes())
}

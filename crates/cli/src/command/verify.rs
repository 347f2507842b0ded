//! `sheer verify`: the papers' numbers and the methods' promises, from theory, as printed, and as measured;
//! and whether a GPU keeps them.

use anyhow::{anyhow, ensure};
use sheer_gpu::GpuBackend;
use sheer_lab::{
    number,
    verify::{Check, Twins, Value, judge, promises, twins},
};

use crate::{
    args::{DEFAULT_SIZE, SceneArguments, VerifyArguments},
    console::Console,
    failure::Misuse,
    output::{self, TextOutput},
    report::{
        json::{self, Verification},
        table::Table,
    },
    setup::without_repeats,
    version::{COMMIT, VERSION},
};

pub(crate) fn run(arguments: &VerifyArguments) -> anyhow::Result<()> {
    let VerifyArguments { scenes, methods, alpha, .. } = arguments;
    let gpu = arguments.backend.gpu()?;
    if gpu.is_none() && !(scenes.is_empty() && methods.is_empty() && alpha.is_none()) {
        let problem =
            "scenes, --method and --alpha are for --backend gpu, gpu:ray or gpu:raster, held against the CPU";
        return Err(Misuse(problem.to_owned()).into());
    }
    let console = arguments.machine.apply()?;
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let mut checks = match &gpu {
        None => promises(arguments.machine.threads, &console.bar())?,
        Some(gpu) => hold(gpu, arguments, console)?,
    };
    ensure!(!checks.is_empty(), "nothing could be compared");
    judge(&mut checks);

    let report = Verification { version: VERSION, commit: COMMIT, checks };
    let text = json::text(&report)?;
    match &json {
        Some(output) if output.is_stdout() => output.write(&text)?,
        Some(output) => output.write(&text).and_then(|()| output::print(&table(&report)))?,
        None => output::print(&table(&report))?,
    }
    let failed: Vec<&str> =
        report.checks.iter().filter(|check| !check.pass).map(|check| check.name.as_str()).collect();
    ensure!(
        failed.is_empty(),
        anyhow!("{} of {} checks failed: {}", failed.len(), report.checks.len(), failed.join("; "))
    );
    console.note(format_args!("all {} checks passed", report.checks.len()));
    Ok(())
}

/// Holds a GPU against the CPU in what the user asked for.
fn hold(gpu: &GpuBackend, arguments: &VerifyArguments, console: Console) -> anyhow::Result<Vec<Check>> {
    let load = |text: String| {
        let scene = SceneArguments {
            alpha: arguments.alpha,
            load: arguments.load.clone(),
            ..SceneArguments::of(&text)
        };
        anyhow::Ok((scene.text.clone(), scene.load(DEFAULT_SIZE.0, console)?))
    };
    let asked = Twins {
        scenes: without_repeats(&arguments.scenes).into_iter().map(load).collect::<Result<_, _>>()?,
        alpha: arguments.alpha,
        methods: without_repeats(&arguments.methods),
        threads: arguments.machine.threads,
    };
    Ok(twins(gpu, &asked, &console.bar())?)
}

fn table(report: &Verification) -> String {
    let mut table = Table::new(&["check", "closed form", "paper", "measured", "z", ""]);
    for check in &report.checks {
        table.add(vec![
            check.name.clone(),
            value(check.closed_form),
            value(check.paper),
            value(check.measured),
            number(check.z, 2),
            match (check.pass, check.differs_from_paper()) {
                (true, false) => "ok",
                (true, true) => "ok, not as printed",
                (false, _) => "FAILED",
            }
            .to_owned(),
        ]);
    }
    table.text()
}

fn value(value: Option<Value>) -> String {
    let short = |value: f64| if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.4}") };
    match value {
        None => "–".to_owned(),
        Some(Value::Number(value)) => short(value),
        Some(Value::Colour(colour)) => colour.map(short).join(" "),
    }
}

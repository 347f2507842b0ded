//! `sheer verify`: the papers' numbers and the methods' promises, from theory, as printed, and as measured; and whether a GPU keeps them.

use anyhow::{anyhow, ensure};
use sheer_metrics::statistics::{sidak, two_sided_p};

use crate::{
    COMMIT, VERSION,
    args::VerifyArguments,
    failure::Misuse,
    output::{self, TextOutput},
    report::{
        json::{self, Check, Value, Verification},
        table::{Table, number},
    },
    talk::Talk,
};

mod ends;
mod layers;
mod maps;
mod picture;
mod stacked;
mod stochastic;
mod threads;
mod twins;
mod unbiased;

/// Probability that any of the random checks fails although nothing is wrong. The seeds are fixed, so it is paid once, not each run.
const LEVEL: f64 = 1e-3;

pub(crate) fn run(arguments: &VerifyArguments) -> anyhow::Result<()> {
    let VerifyArguments { scenes, methods, alpha, .. } = arguments;
    let gpu = arguments.backend.gpu()?;
    if gpu.is_none() && !(scenes.is_empty() && methods.is_empty() && alpha.is_none()) {
        let problem =
            "scenes, --method and --alpha are for --backend gpu, gpu:ray or gpu:raster, held against the CPU";
        return Err(Misuse(problem.to_owned()).into());
    }
    let talk = arguments.machine.apply()?;
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    let mut checks = match &gpu {
        None => promises(arguments.machine.threads, talk)?,
        Some(gpu) => twins::checks(arguments, gpu, talk)?,
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
    talk.note(format_args!("all {} checks passed", report.checks.len()));
    Ok(())
}

/// What papers and methods promise, kept by the CPU.
fn promises(threads: Option<usize>, talk: Talk) -> anyhow::Result<Vec<Check>> {
    type Group = fn(Option<usize>) -> anyhow::Result<Vec<Check>>;
    let groups: [(&str, Group); 7] = [
        ("threshold maps", |_| Ok(maps::checks())),
        ("layers", layers::checks),
        ("alpha 0 and 1", ends::checks),
        ("threads", |_| threads::checks()),
        ("unbiased methods", unbiased::checks),
        ("stacked layers", stacked::checks),
        ("stochastic", |_| stochastic::checks()),
    ];
    let progress = talk.progress(groups.len() as u64);
    let mut checks = Vec::new();
    for (name, group) in groups {
        progress.set_message(format!("{name:<18}"));
        checks.extend(group(threads)?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(checks)
}

/// Something that has one right answer.
fn exact(name: impl Into<String>, source: &str, expected: f64, paper: Option<f64>, measured: f64) -> Check {
    Check {
        name: name.into(),
        source: source.to_owned(),
        closed_form: Some(Value::Number(expected)),
        paper: paper.map(Value::Number),
        measured: Some(Value::Number(measured)),
        samples: None,
        z: None,
        pass: expected.to_bits() == measured.to_bits(),
    }
}

/// Passes or fails everything that has a `z`: all of them together err with probability [`LEVEL`].
fn judge(checks: &mut [Check]) {
    let count = checks.iter().filter(|check| check.z.is_some()).count();
    let level = sidak(LEVEL, count as u64);
    for check in checks {
        if let Some(z) = check.z {
            check.pass = two_sided_p(z) >= level;
        }
    }
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
            if check.pass { "ok" } else { "FAILED" }.to_owned(),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn random(z: f64) -> Check {
        Check { z: Some(z), pass: false, ..exact("", "", 0.0, None, 0.0) }
    }

    #[test]
    fn chance_passes_and_what_is_beyond_it_fails() {
        let mut checks =
            vec![random(0.0), random(-3.5), random(7.0), random(f64::INFINITY), random(f64::NAN)];
        judge(&mut checks);
        assert_eq!(
            checks.iter().map(|check| check.pass).collect::<Vec<_>>(),
            [true, true, false, false, false]
        );
    }

    #[test]
    fn the_more_checks_the_wider_the_band_of_chance() {
        let mut alone = [random(3.5)];
        judge(&mut alone);
        assert!(!alone[0].pass);
    }

    #[test]
    fn exact_checks_allow_nothing() {
        assert!(exact("", "", 1512.0, None, 1512.0).pass);
        assert!(!exact("", "", 1512.0, None, 1512.0_f64.next_up()).pass);
    }
}

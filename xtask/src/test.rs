//! `cargo xtask test`: the one command that says whether the project is sound. CI runs it and nothing else.

use std::{
    process::Command,
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context as _, anyhow, ensure};

use crate::{
    binaries, rules, setup, wheel,
    workspace::{call, call_with, root, sources},
};

type Step<'a> = (&'static str, Box<dyn FnOnce() -> anyhow::Result<()> + 'a>);

/// Settings of Mesa's software driver, which compiles a shader with shading in it for longer than the test
/// around it runs: narrow vectors and no optimisation by LLVM take less than half of the time. The pictures
/// are the same to the bit. Other drivers do not read these variables (Mesa, "Environment variables").
const SOFTWARE_DRIVER: [(&str, &str); 2] = [("LP_NATIVE_VECTOR_WIDTH", "128"), ("GALLIVM_PERF", "nopt")];

/// Runs the steps until one fails, and tells the time that each took.
pub(crate) fn run() -> anyhow::Result<()> {
    setup::authorise()?;
    thread::scope(|scope| {
        // Packages come over a network, which leaves the processors to the compiler.
        let programs = scope.spawn(setup::programs);
        // From what needs least to what needs most, so that a slip is told early.
        let steps: [Step<'_>; 10] = [
            ("toolchain", Box::new(setup::toolchain)),
            ("format", Box::new(format)),
            ("rules", Box::new(rules::run)),
            ("lint", Box::new(lint)),
            ("build", Box::new(|| call("cargo", &["test", "--workspace", "--locked", "--no-run"]))),
            ("programs", Box::new(|| programs.join().map_err(|_| anyhow!("installing has panicked"))?)),
            ("wheel", Box::new(wheel::install)),
            ("test", Box::new(|| binaries::run(&SOFTWARE_DRIVER))),
            ("document", Box::new(document)),
            ("package", Box::new(package)),
        ];
        let mut times: Vec<(&str, Duration)> = Vec::new();
        let mut result = Ok(());
        for (name, step) in steps {
            let start = Instant::now();
            result = step();
            times.push((name, start.elapsed()));
            if result.is_err() {
                break;
            }
        }
        eprintln!("\n{}", table(&times));
        result
    })
}

fn lint() -> anyhow::Result<()> {
    call("cargo", &["clippy", "--workspace", "--all-targets", "--locked", "--", "-D", "warnings"])
}

fn document() -> anyhow::Result<()> {
    let arguments = ["doc", "--workspace", "--no-deps", "--locked"];
    call_with("cargo", &arguments, &[("RUSTDOCFLAGS", "-D warnings")])
}

/// What would be published, put together and not built, which takes seconds: all that manifests need is
/// there.
fn package() -> anyhow::Result<()> {
    let what = ["package", "--workspace", "--locked", "--no-verify", "--allow-dirty"];
    // The wheel of the one is what is published, and nothing of the other.
    let others = ["--exclude", "sheer-python", "--exclude", "xtask"];
    call("cargo", &[&what[..], &others[..]].concat())
}

/// Every file by itself: what follows modules misses those that a macro declares, as tables of methods do.
fn format() -> anyhow::Result<()> {
    eprintln!("$ rustfmt --check, all sources");
    let mut rustfmt = Command::new("rustfmt");
    rustfmt.arg("--check").args(sources(&["*.rs"])?).current_dir(root());
    ensure!(rustfmt.status().context("cannot run rustfmt")?.success(), "run rustfmt on these files");
    Ok(())
}

/// The steps' times, a line each, and their sum.
fn table(times: &[(&str, Duration)]) -> String {
    let row = |name: &str, time: Duration| format!("{name:<10}{:>8.1} s\n", time.as_secs_f64());
    let rows: String = times.iter().map(|&(name, time)| row(name, time)).collect();
    rows + &row("all", times.iter().map(|(_, time)| *time).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_tells_each_time_and_their_sum() {
        let times = [("format", Duration::from_millis(1500)), ("test", Duration::from_secs(600))];
        assert_eq!(table(&times), "format         1.5 s\ntest         600.0 s\nall          601.5 s\n");
    }
}

//! All tests, two binaries at a time: a binary has tests that keep one processor busy alone, as compiling a
//! shader does, and at its end one that the others wait for.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::Mutex,
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context as _, bail, ensure};
use serde_json::Value;

use crate::{wheel, workspace::root};

/// More would take more memory than small machines have.
const AT_A_TIME: usize = 2;
/// Test targets that take longest: they begin first, so that the others fill the time beside them.
const LONGEST: [&str; 3] = ["gpu", "cli", "sheer_gpu"];

/// Something that runs tests.
struct Job {
    name: String,
    command: Command,
}

/// What came of it.
struct Outcome {
    name: String,
    time: Duration,
    passed: bool,
}

/// Runs all tests and what the documentation shows, in this environment, and fails if one of them fails.
pub(crate) fn run(environment: &[(&str, &str)]) -> anyhow::Result<()> {
    let mut jobs = test_binaries()?;
    let place = |job: &Job| LONGEST.iter().position(|name| *name == job.name).unwrap_or(LONGEST.len());
    jobs.sort_by_key(place);
    let mut examples = Command::new("cargo");
    examples.args(["test", "--doc", "--workspace", "--locked"]).current_dir(root());
    jobs.insert(0, Job { name: "documentation's examples".to_owned(), command: examples });
    jobs.push(Job { name: "Python".to_owned(), command: wheel::tests() });
    for job in &mut jobs {
        job.command.envs(environment.iter().copied());
    }
    let outcomes = at_a_time(AT_A_TIME, jobs)?;

    let mut by_time: Vec<&Outcome> = outcomes.iter().collect();
    by_time.sort_by_key(|outcome| std::cmp::Reverse(outcome.time));
    eprintln!("\nbinaries by their time:");
    for Outcome { name, time, .. } in by_time {
        eprintln!("{name:<26}{:>8.1} s", time.as_secs_f64());
    }
    let failed: Vec<&str> =
        outcomes.iter().filter(|outcome| !outcome.passed).map(|outcome| outcome.name.as_str()).collect();
    ensure!(failed.is_empty(), "tests failed in: {}", failed.join(", "));
    Ok(())
}

/// The binaries that `cargo test` would run, as it would run them.
fn test_binaries() -> anyhow::Result<Vec<Job>> {
    let mut cargo = Command::new("cargo");
    cargo.args(["test", "--workspace", "--locked", "--no-run", "--message-format=json-render-diagnostics"]);
    let output = cargo.stderr(Stdio::inherit()).current_dir(root()).output()?;
    ensure!(output.status.success(), "cargo test --no-run failed");
    let jobs = String::from_utf8(output.stdout)?.lines().filter_map(job).collect::<Vec<_>>();
    ensure!(!jobs.is_empty(), "cargo names no test binary");
    Ok(jobs)
}

/// A binary out of one of Cargo's messages, if it is about one.
fn job(message: &str) -> Option<Job> {
    let message: Value = serde_json::from_str(message).ok()?;
    if message["profile"]["test"] != true {
        return None;
    }
    let executable = PathBuf::from(message["executable"].as_str()?);
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
    let mut command = Command::new(executable);
    command.arg("--quiet").current_dir(folder).env("CARGO_MANIFEST_DIR", folder);
    Some(Job { name: message["target"]["name"].as_str()?.to_owned(), command })
}

/// Runs jobs, so many side by side; what each has to say comes when it has ended, in one piece.
fn at_a_time(count: usize, jobs: Vec<Job>) -> anyhow::Result<Vec<Outcome>> {
    let waiting = Mutex::new(jobs.into_iter());
    let ended = Mutex::new(Vec::new());
    let work = || -> anyhow::Result<()> {
        loop {
            // The lock is held no longer than it takes to fetch a job.
            let next = waiting.lock().expect("no thread panics with the lock").next();
            let Some(Job { name, mut command }) = next else { return Ok(()) };
            let start = Instant::now();
            let output = command.stdin(Stdio::null()).output();
            let output = output.with_context(|| format!("cannot run the tests of {name}"))?;
            let (time, passed) = (start.elapsed(), output.status.success());
            let mut ended = ended.lock().expect("no thread panics with the lock");
            eprintln!(
                "\n{name}: {} in {:.1} s\n{}{}",
                if passed { "passed" } else { "FAILED" },
                time.as_secs_f64(),
                String::from_utf8_lossy(&output.stdout),
                String::from_utf8_lossy(&output.stderr)
            );
            ended.push(Outcome { name, time, passed });
        }
    };
    thread::scope(|scope| {
        let workers: Vec<_> = (0..count).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            match worker.join() {
                Ok(result) => result?,
                Err(_) => bail!("a thread that runs tests has panicked"),
            }
        }
        Ok(())
    })?;
    Ok(ended.into_inner().expect("no thread panics with the lock"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn test_binaries_are_told_from_other_messages() {
        let message = |is_test: bool| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"/a/b/Cargo.toml","target":{{"name":"gpu"}},"profile":{{"test":{is_test}}},"executable":"/t/gpu-1"}}"#
            )
        };
        let found = job(&message(true)).unwrap();
        assert_eq!((found.name.as_str(), found.command.get_current_dir()), ("gpu", Some(Path::new("/a/b"))));
        assert_eq!(found.command.get_program(), "/t/gpu-1");
        assert!(job(&message(false)).is_none());
        assert!(job(r#"{"reason":"build-finished","success":true}"#).is_none());
        assert!(job(r#"{"profile":{"test":true},"executable":null}"#).is_none());
    }

    #[test]
    fn every_job_runs_and_a_failure_is_told() {
        let job = |name: &str, program: &str| Job { name: name.to_owned(), command: Command::new(program) };
        let jobs = vec![job("first", "true"), job("second", "false"), job("third", "true")];
        let mut outcomes = at_a_time(2, jobs).unwrap();
        outcomes.sort_by(|a, b| a.name.cmp(&b.name));
        let passed: Vec<bool> = outcomes.iter().map(|outcome| outcome.passed).collect();
        assert_eq!(passed, [true, false, true]);
        assert!(at_a_time(2, vec![job("none", "/nowhere/at/all")]).is_err());
    }
}

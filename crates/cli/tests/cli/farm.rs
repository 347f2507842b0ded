//! The job template of `farm/`, run on this machine by Open Job Description's own program.

#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use crate::run::{names_in, stand_in, succeed};

const FRAMES: usize = 12;

/// Runs a clip of twelve frames in three chunks, with `sheer` as the program that renders.
fn run_job(folder: &Path, sheer: &Path) -> Output {
    // Packages for Python are where `cargo xtask setup` puts them.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let openjd = target.join("python/bin/openjd");
    assert!(openjd.exists(), "{} is missing: `cargo xtask setup` installs it", openjd.display());
    let template = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../farm/sheer-render.yaml");
    let mut command = Command::new(openjd);
    command.arg("run").arg(template).current_dir(folder);
    for parameter in [
        format!("Sheer={}", sheer.display()),
        format!("Folder={}", folder.join("frames").display()),
        format!("LastFrame={}", FRAMES - 1),
        "FramesPerChunk=4".to_owned(),
        "Camera=path".to_owned(),
        "Samples=2".to_owned(),
        "Size=64x36".to_owned(),
    ] {
        command.args(["-p", &parameter]);
    }
    command.output().unwrap()
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat()
}

/// The bytes of each frame that is there.
fn frames(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| {
        let bytes = fs::read(folder.join(&name)).unwrap();
        (name, bytes)
    };
    names_in(folder).into_iter().map(read).collect()
}

#[test]
fn a_job_whose_task_was_killed_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let frames_folder = folder.path().join("frames");
    // The second task is killed once its first frame is there.
    let script = format!(
        r#"case "$*" in *"4..=7"*) ;; *) exec "{sheer}" "$@" ;; esac
"{sheer}" "$@" &
until [ -e "{frames}/0004.png" ] || ! kill -0 $!; do sleep 0.005; done
kill -KILL $!
wait $!"#,
        sheer = env!("CARGO_BIN_EXE_sheer"),
        frames = frames_folder.display(),
    );
    stand_in(folder.path(), "mortal", &script);

    let killed = run_job(folder.path(), &folder.path().join("bin/mortal"));
    assert!(!killed.status.success(), "{}", text(&killed));
    let left = frames(&frames_folder);
    assert!((5..8).contains(&left.len()), "{} frames: {}", left.len(), text(&killed));
    let written =
        |(name, _): &(String, Vec<u8>)| frames_folder.join(name).metadata().unwrap().modified().unwrap();
    let times: Vec<_> = left.iter().map(written).collect();

    let finished = run_job(folder.path(), &PathBuf::from(env!("CARGO_BIN_EXE_sheer")));
    assert!(finished.status.success(), "{}", text(&finished));
    assert!(text(&finished).contains("openjd_progress: 100"), "{}", text(&finished));
    let all = frames(&frames_folder);
    assert_eq!(left.iter().map(written).collect::<Vec<_>>(), times, "what was there is rendered again");

    // What one machine renders without a break.
    let whole = folder.path().join("whole");
    let clip = "render smoke-square --camera path -m joint --samples 2 --size 64x36 --frames 12";
    succeed(folder.path(), &format!("{clip} -o {}/####.png", whole.display()));
    assert!(all == frames(&whole), "{:?}", names_in(&frames_folder));
    assert_eq!(all.len(), FRAMES);
}

//! `sheer render -o clip.mp4`: a video by an installed ffmpeg, for which scripts stand in here.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{
    env, fs,
    path::Path,
    process::{Command, Output, Stdio},
    thread,
    time::Duration,
};

use sheer_image::read_png;

use crate::run::{Outcome, command, names_in, sheer, stand_in, succeed};

/// Writes what it is told and given: the arguments, and the frames under the name of the last one.
const KEEPS: &str = r#"printf '%s\n' "$@" > arguments.txt; for file; do :; done; cat > "$file""#;

/// The program, for which `bin` in the folder comes first on the path.
fn with_stand_in(folder: &Path, arguments: &str) -> Command {
    let system = env::var_os("PATH").unwrap();
    let path = env::join_paths([folder.join("bin")].into_iter().chain(env::split_paths(&system))).unwrap();
    let mut command = command(folder, arguments);
    command.env("PATH", path);
    command
}

fn run(mut command: Command) -> Outcome {
    let output = command.output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn ffmpeg_gets_the_frames_of_a_sequence_and_how_to_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stand_in(folder, "ffmpeg", KEEPS);
    for (clip, video, told) in [
        (
            "-a taa --fps 24 --frames 2..5 --crop 4,0,8,10",
            "clip.mp4",
            ["-video_size\n8x10\n", "-framerate\n24\n", "rgb0", "libx264", "aa=taa"],
        ),
        (
            "--samples 2 --frames 3 --background none --exposure 1",
            "clip.webm",
            ["-video_size\n16x10\n", "-framerate\n30\n", "rgba", "libvpx-vp9", "samples=2"],
        ),
    ] {
        let clip = format!("render layers:count=2 -m std --size 16x10 {clip}");
        let outcome = run(with_stand_in(folder, &format!("{clip} -o {video}")));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert!(outcome.stderr.contains(video) && outcome.stderr.contains("3 frames"), "{outcome:?}");
        succeed(folder, &format!("{clip} -o {video}.frames/####.png"));

        let given = fs::read(folder.join(video)).unwrap();
        let frames = folder.join(format!("{video}.frames"));
        let of_file = |name: &String| read_png(&frames.join(name)).unwrap().as_slice().to_vec();
        let expected: Vec<[u8; 4]> = names_in(&frames).iter().flat_map(of_file).collect();
        assert!(given == expected.as_flattened(), "{video}: other pixels");
        // The check is not blind: frames differ.
        assert_ne!(given[..given.len() / 3], given[given.len() / 3..2 * given.len() / 3]);

        let arguments = fs::read_to_string(folder.join("arguments.txt")).unwrap();
        assert!(told.iter().all(|words| arguments.contains(words)), "{arguments}");
    }
    let expected = ["arguments.txt", "bin", "clip.mp4", "clip.mp4.frames", "clip.webm", "clip.webm.frames"];
    assert_eq!(names_in(folder), expected);
    // What is there is left alone.
    let again = run(with_stand_in(folder, "render layers --size 16x10 --skip-existing -o clip.mp4"));
    assert!(again.stderr.contains("nothing to render"), "{again:?}");
}

#[test]
fn a_video_that_cannot_be_made_is_an_error_and_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("clip.mp4"), "old").unwrap();
    let clip = "render layers:count=1 -m std -a none --size 64x64 --frames 40 -o clip.mp4";
    for script in [
        // At once, in the middle, and at the end.
        "echo \"Unknown encoder 'libx264'\" >&2; exit 8",
        "head -c 20000 > /dev/null; echo \"Unknown encoder 'libx264'\" >&2; exit 8",
        "cat > /dev/null; echo \"Unknown encoder 'libx264'\" >&2; exit 8",
    ] {
        stand_in(folder, "ffmpeg", script);
        let outcome = run(with_stand_in(folder, clip));
        assert_eq!(outcome.code, Some(1), "{script}: {outcome:?}");
        assert!(outcome.stderr.contains("clip.mp4: ffmpeg failed: Unknown encoder 'libx264'"), "{outcome:?}");
        assert_eq!(names_in(folder), ["bin", "clip.mp4"], "{script}");
        assert_eq!(fs::read_to_string(folder.join("clip.mp4")).unwrap(), "old");
    }
    let nothing = folder.join("nothing");
    fs::create_dir(&nothing).unwrap();
    let mut without = command(folder, clip);
    without.env("PATH", &nothing);
    let outcome = run(without);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    for said in ["there is no ffmpeg", "install", "####.png"] {
        assert!(outcome.stderr.contains(said), "{outcome:?}");
    }
}

#[test]
fn what_a_video_cannot_hold_is_wrong_use() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, code, said) in [
        ("--size 15x10 -o a.mp4", 2, "--size asks for 15x10 pixels: make that 16x10"),
        ("--size 16x10 --crop 0,0,8,5 -o a.mp4", 2, "--crop asks for 8x5 pixels: make that 8x6"),
        ("--size 16x10 --background none -o a.mp4", 2, ".webm"),
        ("--size 16x10 -o a-##.mp4", 2, "leave the place of a number out"),
        ("--size 16x10 --raw -o a.mp4", 1, ".exr"),
        ("--size 16x10 -o absent/a.mp4", 1, "absent"),
        ("--size 16x10 -o a.gif", 2, ".webm for a video"),
        ("--size 16x10 -o absent/##.gif", 2, ".webm for a video"),
    ] {
        let outcome = sheer(folder.path(), &format!("render layers {arguments}"));
        assert_eq!(outcome.code, Some(code), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{arguments}: {outcome:?}");
    }
    let merged = sheer(folder.path(), "merge a.exr -o a.mp4");
    assert_eq!(merged.code, Some(2), "{merged:?}");
    assert!(merged.stderr.contains("end its name with .png or .exr") && !merged.stderr.contains("video"));
    assert!(names_in(folder.path()).is_empty());
}

#[test]
fn an_interrupted_video_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Each says when it may be interrupted: while frames come, and when they all have come.
    for (frames, script) in [
        (1_000_000, r#"for file; do :; done; exec > "$file"; head -c 10000; : > begun; cat"#),
        (2, r#"for file; do :; done; cat > "$file"; : > begun; exec sleep 600"#),
    ] {
        stand_in(folder, "ffmpeg", script);
        let clip = format!("render layers:count=1 -m std -a none --size 64x64 --frames {frames} -o clip.mp4");
        let mut child = with_stand_in(folder, &clip).stderr(Stdio::piped()).spawn().unwrap();
        while !folder.join("begun").exists() && child.try_wait().unwrap().is_none() {
            thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(names_in(folder).len(), 3, "a temporary file is there");
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let Output { status, stderr, .. } = child.wait_with_output().unwrap();
        assert_eq!(status.code(), Some(130));
        assert!(stderr.is_empty(), "ffmpeg did not fail: {}", String::from_utf8_lossy(&stderr));
        assert_eq!(names_in(folder), ["begun", "bin"]);
        fs::remove_file(folder.join("begun")).unwrap();
    }
}

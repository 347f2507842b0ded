//! What must not stop, hang or disguise anything, nor take the machine's memory, whatever it is given.
#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

mod files;

use std::{
    fmt, fs,
    path::Path,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use self::files::{End, FILES, Hostile};
use crate::run::{Outcome, command, names_in, sheer};

/// Nothing here takes longer than a few seconds; what hangs is ended after this.
const HANGS_AFTER: Duration = Duration::from_secs(120);

/// Waits for an end, and makes one where none comes. With the outcome comes the most memory that was taken,
/// in bytes, as far as the system says.
fn finish(mut child: Child) -> (Outcome, u64) {
    let start = Instant::now();
    let mut peak_bytes = 0;
    while child.try_wait().unwrap().is_none() {
        peak_bytes = peak_bytes.max(peak_of(child.id()).unwrap_or(0));
        if start.elapsed() > HANGS_AFTER {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("it hangs");
        }
        thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let outcome =
        Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) };
    (outcome, peak_bytes)
}

/// The most memory that a process of the binary has had so far, in bytes. Until its program is loaded, a
/// child shows the memory of its parent, which here is that of all tests together.
fn peak_of(process: u32) -> Option<u64> {
    let program = fs::read_link(format!("/proc/{process}/exe")).ok()?;
    if program != fs::canonicalize(env!("CARGO_BIN_EXE_sheer")).ok()? {
        return None;
    }
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

fn run(command: &mut Command) -> Outcome {
    measure(command).0
}

fn measure(command: &mut Command) -> (Outcome, u64) {
    finish(command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
}

#[cfg(unix)]
#[test]
fn a_pipe_in_place_of_a_file_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = |name: &str| {
        let path = folder.path().join(name);
        assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    };
    ["pipe.gltf", "pipe.glb", "pipe.bin", "pipe.png", "pipe.json"].iter().for_each(|name| pipe(name));
    let scene = |name: &str, buffer: &str, image: &str| {
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}], "buffers": [{{"uri": "{buffer}", "byteLength": 36}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}], "images": [{{"uri": "{image}"}}], "textures": [{{"source": 0}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}}],
            "materials": [{{"emissiveTexture": {{"index": 0}}}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}]}}"#
        );
        fs::write(folder.path().join(name), json).unwrap();
    };
    scene("buffer.gltf", "pipe.bin", "absent.png");
    let triangle = "data:;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA";
    scene("image.gltf", triangle, "pipe.png");
    for (arguments, name) in [
        ("pipe.gltf", "pipe.gltf"),
        ("pipe.glb", "pipe.glb"),
        ("buffer.gltf", "pipe.bin"),
        ("image.gltf", "pipe.png"),
        ("layers -m std:correction=pipe.json", "pipe.json"),
    ] {
        let arguments = format!("render {arguments} --size 8x8 -a none -o a.png");
        let outcome = run(&mut command(folder.path(), &arguments));
        assert!(outcome.stderr.contains(name), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains("no regular file"), "{arguments}: {outcome:?}");
    }
}

#[test]
fn more_threads_than_any_machine_has_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for threads in ["99999999", "99999999999999999999999"] {
        let mut command = command(folder.path(), "render layers --size 8x8 -a none -o a.png");
        let outcome = run(command.env("RAYON_NUM_THREADS", threads));
        assert_eq!(outcome.code, Some(2), "{outcome:?}");
        assert!(outcome.stderr.contains("RAYON_NUM_THREADS is 9999"), "{outcome:?}");
    }
    for threads in ["2", "", "many"] {
        let mut command = command(folder.path(), "render layers --size 8x8 -a none -o a.png");
        let outcome = run(command.env("RAYON_NUM_THREADS", threads));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
    }
}

#[test]
fn a_frame_number_of_seventy_thousand_places_is_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = sheer(folder.path(), &format!("render layers --size 8x8 -o {}.png", "#".repeat(70_000)));
    assert_eq!(outcome.code, Some(1), "{:?}", outcome.code);
    assert!(outcome.stderr.starts_with("sheer: error: cannot write 0000"));
}

/// A file whose mesh draws points, which is worth a warning, under a name.
fn named_points(folder: &Path, name: &str) {
    let name = serde_json::Value::from(name);
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0, "camera": 0, "name": {name}}}],
        "accessors": [{{"componentType": 5126, "type": "VEC3", "count": 3}}], "extensionsUsed": [{name}],
        "cameras": [{{"name": {name}, "type": "perspective", "perspective": {{"yfov": 1, "znear": 0.1}}}}],
        "meshes": [{{"name": {name}, "primitives": [{{"attributes": {{"POSITION": 0}}, "mode": 0}}]}}]}}"#
    );
    fs::write(folder.join("named.gltf"), json).unwrap();
}

#[test]
fn names_out_of_files_do_nothing_to_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    named_points(folder.path(), "a\u{1b}]0;title\u{7}\u{9b}2J\n\r\u{202e}b");
    for arguments in ["named.gltf", "named.gltf --camera nix"] {
        let arguments = format!("render {arguments} --size 8x8 -a none -o a.png");
        let outcome = sheer(folder.path(), &arguments);
        assert!(outcome.stderr.contains("a\\u{1b}]0;title"), "{outcome:?}");
        let acts = |character: char| (character.is_control() && character != '\n') || character == '\u{202e}';
        assert!(!outcome.stderr.contains(acts), "{outcome:?}");
        for line in outcome.stderr.lines() {
            assert!(line.starts_with("sheer: "), "{line}");
        }
    }
}

/// What a hostile file may take.
const LIMIT_BYTES: u64 = 1_000_000_000;

/// What is wrong with how a file ends, if anything.
fn fault(file: &Hostile, folder: &Path) -> Option<String> {
    (file.make)(&folder.join(file.name));
    let arguments = format!("render {} --size 32x18 -a none --memory-limit 1GB -o a.png", file.name);
    let start = Instant::now();
    let (outcome, peak_bytes) = measure(&mut command(folder, &arguments));
    println!(
        "{:>8.1?} {:>5} MB  {}: {:.200}",
        start.elapsed(),
        peak_bytes / 1_000_000,
        file.name,
        outcome.stderr
    );

    let is_picture = names_in(folder).contains(&"a.png".to_owned());
    let left = names_in(folder).into_iter().find(|name| name.starts_with(".sheer-"));
    let says = |what: &str| outcome.stderr.contains(what);
    let is_error = outcome.code == Some(1) && says("sheer: error: ") && says(file.name) && !is_picture;
    let ends_well = match file.end {
        End::Picture => outcome.code == Some(0) && is_picture,
        End::Error(text) => is_error && says(text),
        End::BeyondLimit(place) => {
            is_error && says(place) && (says("MB") || says("GB") || says("TB")) && says("--memory-limit")
        }
        End::Any => is_error || (outcome.code == Some(0) && is_picture),
    };
    let problem = |problem: fmt::Arguments<'_>| {
        Some(format!("{}: {problem}: {:?} is wanted, {outcome:.600?} came", file.name, file.end))
    };
    if !ends_well {
        problem(format_args!("it ends otherwise"))
    } else if peak_bytes > LIMIT_BYTES {
        problem(format_args!("it takes {peak_bytes} bytes"))
    } else if outcome.stderr.len() > 100_000 || left.is_some() {
        problem(format_args!("it says too much, or leaves {left:?}"))
    } else {
        None
    }
}

#[test]
fn no_file_takes_more_than_the_memory_limit() {
    let mut faults = Vec::new();
    for file in FILES {
        let folder = tempfile::tempdir().unwrap();
        faults.extend(fault(file, folder.path()));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_file_that_takes_more_than_is_wanted_is_found() {
    // The control: a file that is drawn is taken for one that should not be, and the other way round.
    let drawn = FILES.iter().find(|file| matches!(file.end, End::Picture)).unwrap();
    let refused = FILES.iter().find(|file| matches!(file.end, End::BeyondLimit(_))).unwrap();
    for (file, end) in [(drawn, refused.end), (refused, drawn.end), (refused, End::BeyondLimit("nowhere"))] {
        let folder = tempfile::tempdir().unwrap();
        let wrong = Hostile { end, ..*file };
        assert!(fault(&wrong, folder.path()).is_some(), "{}", file.name);
    }
    if cfg!(target_os = "linux") {
        let folder = tempfile::tempdir().unwrap();
        let large =
            command(folder.path(), "render layers --size 4000x2000 -a none -o a.png").spawn().unwrap();
        let peak_bytes = finish(large).1;
        assert!(peak_bytes > 100_000_000, "{peak_bytes}");
    }
}

#[test]
fn an_allocation_that_nobody_counted_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    // A picture is no part of a scene: what it takes is found out as it is taken.
    let arguments = "render layers --size 16000x16000 -a none --memory-limit 500MB -o a.png";
    let (outcome, peak_bytes) = measure(&mut command(folder.path(), arguments));
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("the memory limit of 500 MB is reached"), "{outcome:?}");
    assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
    assert!(peak_bytes < 500_000_000, "{peak_bytes}");
    assert_eq!(names_in(folder.path()), [""; 0]);
}

/// The shell limits its own address space, and what it starts.
#[cfg(target_os = "linux")]
#[test]
fn a_system_without_memory_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let sheer = env!("CARGO_BIN_EXE_sheer");
    let run_in = |kilobytes: u32, arguments: &str| {
        let line = format!("ulimit -v {kilobytes}; exec '{sheer}' {arguments}");
        run(Command::new("sh").args(["-c", &line]).current_dir(folder.path()))
    };
    // What is free is known to be little, or is said to be much.
    for limit in ["", "--memory-limit 100GB"] {
        let arguments = format!("render layers --size 16000x16000 -a none -o a.png --threads 2 {limit}");
        let outcome = run_in(1_500_000, &arguments);
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stderr.starts_with("sheer: error: "), "{outcome:?}");
        assert!(outcome.stderr.contains("memory"), "{outcome:?}");
    }
    // Drivers crash without memory: they are not asked.
    for arguments in ["devices", "render layers --size 8x8 -a none --backend gpu -o a.png"] {
        let outcome = run_in(300_000, arguments);
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stderr.contains("a graphics driver may take"), "{outcome:?}");
    }
}

/// The first amount of memory in a text, in bytes.
fn first_amount(text: &str) -> Option<u64> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let amount = words.windows(2).find(|pair| {
        ["MB", "GB"].contains(&pair[1].trim_end_matches([',', ';'])) && pair[0].parse::<f64>().is_ok()
    })?;
    let unit = if amount[1].starts_with('M') { 1e6 } else { 1e9 };
    Some((amount[0].parse::<f64>().ok()? * unit) as u64)
}

/// What is counted before loading is near what is taken then: not less, so that the limit holds, and not so
/// much more that sound files would be refused.
#[cfg(target_os = "linux")]
#[test]
fn the_estimate_is_near_what_a_scene_takes() {
    const TRIANGLES: usize = 600_000;
    let folder = tempfile::tempdir().unwrap();
    let corners = (0..3 * TRIANGLES).flat_map(|corner| {
        let triangle = corner / 3;
        let at = [(triangle % 800) as f32, (triangle / 800) as f32, (triangle % 7) as f32];
        let offset = [[0.0, 0.0, 0.0], [0.9, 0.0, 0.1], [0.0, 0.9, 0.2]][corner % 3];
        [at[0] + offset[0], at[1] + offset[1], at[2] + offset[2]]
    });
    let bytes: Vec<u8> = corners.flat_map(f32::to_le_bytes).collect();
    fs::write(folder.path().join("corners.bin"), &bytes).unwrap();
    let empty = files::triangle_of(TRIANGLES, "corners.bin");
    let animated = |json: &mut serde_json::Value| {
        json["animations"] = serde_json::json!([{"samplers": [{"input": 1, "output": 2}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]);
    };
    for (name, material, moves) in [
        ("opaque.gltf", serde_json::json!({}), false),
        ("blended.gltf", serde_json::json!({"alphaMode": "BLEND"}), false),
        ("moving.gltf", serde_json::json!({}), true),
        ("moving-blended.gltf", serde_json::json!({"alphaMode": "BLEND"}), true),
    ] {
        let mut json = empty.clone();
        json["materials"] = serde_json::json!([material]);
        if moves {
            animated(&mut json);
        }
        fs::write(folder.path().join(name), json.to_string()).unwrap();
        let arguments = |limit: &str| {
            format!("render {name} --size 16x9 -a none --threads 2 -o a.png --memory-limit {limit}")
        };
        let refused = run(&mut command(folder.path(), &arguments("90MB")));
        let estimate = first_amount(&refused.stderr).unwrap_or_else(|| panic!("{refused:?}"));
        let (drawn, peak) = measure(&mut command(folder.path(), &arguments("100GB")));
        assert_eq!(drawn.code, Some(0), "{drawn:?}");
        // The program itself, and the file that is read.
        let (_, base) = measure(&mut command(folder.path(), "render layers --size 16x9 -a none -o b.png"));
        let taken = peak.saturating_sub(base + bytes.len() as u64);
        println!("{name}: {} MB estimated, {} MB taken", estimate / 1_000_000, taken / 1_000_000);
        assert!(taken <= estimate, "{name}: {estimate} estimated, {taken} taken");
        assert!(estimate < 5 * taken / 2, "{name}: {estimate} estimated, {taken} taken");
    }
}

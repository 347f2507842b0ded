//! Wrong use, lists, help.

use std::process::Stdio;

use sheer_gallery::catalogue;
use sheer_render::{method::METHODS, shadow::SHADOWS};

use crate::run::{command, names_in, sheer, succeed};

#[test]
fn wrong_use_exits_with_2_and_one_line_that_says_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, said) in [
        ("", "scenes"),
        ("frobnicate", "frobnicate"),
        ("rendre layers", "'render'"),
        ("render nowhere", "'nowhere' is neither a built-in scene nor"),
        ("render layers:count=0", "1..=64"),
        ("render layers --camera nix --size 8x8", "no camera 'nix'; it has: static"),
        ("render smok-square", "the nearest is 'smoke-square'"),
        ("render pane --camera pth --size 8x8", "the nearest is 'path'"),
        ("render layers -m sdt", "there are: baseline, roulette, std"),
        ("render layers -m sdt", "the nearest is 'std'"),
        ("render layers -m std:hsah=pcg", "hash (pcg|mcguire)"),
        ("render layers -m std:hsah=pcg", "the nearest is 'hash'"),
        ("render layers -m std:hash=mcgiure", "the nearest is 'mcguire'"),
        ("render layers -a layerd", "the nearest is 'layered'"),
        ("render layers --tone agxx", "the nearest is 'agx'"),
        ("render layers --backend gpu:rya", "the nearest is 'gpu:ray'"),
        ("render layers --environment stduio", "the nearest is 'studio'"),
        ("render layers --shadow deep-mpa", "the nearest is 'deep-map'"),
        ("render layers --progress jsno", "'json'"),
        ("compare layers --reference turth", "the nearest is 'truth'"),
        ("experiments joitn", "the nearest is 'joint'"),
        ("completions bsh", "'bash'"),
        ("render layers -a fxaa", "none, accumulate, taa"),
        ("render layers --size 0x9", "WIDTHxHEIGHT"),
        ("render layers --frames 0", "0"),
        ("render layers --alpha 1.5", "from 0 to 1"),
        ("render layers --time nan", "seconds"),
        ("render layers --background blue", "#7f7f7f"),
        ("render layers --tone filmic", "there are: pbr-neutral, none, aces"),
        ("render layers --exposure bright", "stops"),
        ("render layers --environment sunny", "scene (the scene's own), none (no light), studio"),
        ("render layers --environment-strength -1", "from 0"),
        ("render layers --threads 0", "0"),
        ("render layers --shadow shallow", "there are: deep, stochastic-map, deep-map, opacity-map, fourier"),
        ("compare layers --shadow deep-map:tolerance=2", "0.0..=0.5"),
        ("bench pane --shadow stochastic-map:resolution=8192,samples=64 --size 8x8", "lower resolution="),
        ("render layers --adapter 0", "--backend gpu"),
        ("calibrate --adapter 0", "--backend gpu"),
        ("render layers --backend tpu", "cpu, gpu, gpu:ray, gpu:raster"),
        ("render layers -o picture.jpg", ".png or .exr"),
        ("compare layers --sizes 8x8", "--size"),
        ("compare layers --reference truht", "there are: same, truth, truth:samples=N"),
        ("compare layers --reference truth:samples=0", "1..=4096"),
        ("bench nowhere", "nowhere"),
    ] {
        let outcome = sheer(folder.path(), arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.starts_with("sheer: error: "), "{arguments}: {outcome:?}");
        assert_eq!(outcome.stderr.lines().count(), 1, "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{arguments}: {outcome:?}");
        assert_eq!(outcome.stdout, "", "{arguments}");
    }
    let left: Vec<String> = names_in(folder.path()).into_iter().filter(|name| name != "sheer-out").collect();
    assert_eq!(left, [""; 0]);
}

#[test]
fn a_file_that_cannot_be_read_is_a_failure_and_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.glb"), "no glTF").unwrap();
    for file in ["absent.gltf", "broken.glb"] {
        let outcome = sheer(folder.path(), &format!("render {file} -o a.png"));
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stderr.contains(file), "{outcome:?}");
        assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
    }
    assert_eq!(names_in(folder.path()), ["broken.glb"]);
}

#[test]
fn a_part_that_is_lost_is_a_warning_or_under_strict_a_failure() {
    const POSITIONS: &str = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let folder = tempfile::tempdir().unwrap();
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
            "materials": [{{"emissiveTexture": {{"index": 0}}}}], "textures": [{{"source": 0}}],
            "images": [{{"uri": "gone.png"}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "buffers": [{{"byteLength": 36, "uri": "data:;base64,{POSITIONS}"}}]}}"#
    );
    std::fs::write(folder.path().join("a.gltf"), json).unwrap();
    let loss = "a.gltf: images[0] ('gone.png'): cannot read gone.png";
    let outcome = succeed(folder.path(), "render a.gltf -m baseline -a none --size 8x8 -o a.png");
    assert!(outcome.stderr.contains(&format!("warning: {loss}")), "{outcome:?}");
    for verb in ["render", "compare", "bench"] {
        let outcome = sheer(folder.path(), &format!("{verb} a.gltf --strict --size 8x8"));
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stderr.contains(&format!("error: {loss}")), "{outcome:?}");
    }
}

#[test]
fn lists_have_one_line_each_with_the_name_first() {
    let folder = tempfile::tempdir().unwrap();
    let first_words = |verb: &str| {
        let outcome = succeed(folder.path(), verb);
        assert_eq!(outcome.stderr, "");
        outcome.stdout.lines().map(|line| line.split(' ').next().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(first_words("scenes"), catalogue().iter().map(|info| info.name).collect::<Vec<_>>());
    assert_eq!(first_words("methods"), METHODS.iter().map(|info| info.id).collect::<Vec<_>>());
    let long = succeed(folder.path(), "methods --long").stdout;
    assert!(SHADOWS.iter().all(|info| long.contains(&format!("\n{} ", info.id))), "{long}");
    let long = succeed(folder.path(), "scenes --long").stdout;
    assert!(long.contains("\n    count=8  "), "{long}");
}

#[test]
fn help_and_version_go_to_stdout() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in ["--help", "render --help", "help compare"] {
        assert!(succeed(folder.path(), arguments).stdout.contains("Usage:"));
    }
    assert!(succeed(folder.path(), "--version").stdout.starts_with("sheer "));
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = command(folder.path(), "bench layers --size 64x36 --frames 4")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), String::from_utf8(output.stderr).unwrap().as_str()), (Some(0), ""));
}

//! Tone, exposure and surroundings.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{fs, path::Path, slice, time::Duration};

use base64::{Engine as _, prelude::BASE64_STANDARD};
use glam::Vec3;
use serde_json::{Value, json};
use sheer_core::colour::{linear_from_srgb, srgb_from_linear};
use sheer_image::{Image, Metadata, Planes, Tone, ToneCurve, encode_exr, read_exr, read_png, u8_from_unit};

use crate::run::{command, json as parsed, sheer, succeed};

/// A file of upright rectangles of height 1.6, seen by a camera that is 2 units high: left and right edge,
/// depth and material of each.
fn cards(folder: &Path, cards: &[(f32, f32, f32, Value)]) {
    let (mut bytes, mut accessors, mut meshes, mut nodes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (index, (left, right, z, _)) in cards.iter().enumerate() {
        let corners = [
            [*left, -0.8, *z],
            [*right, -0.8, *z],
            [*right, 0.8, *z],
            [*left, -0.8, *z],
            [*right, 0.8, *z],
            [*left, 0.8, *z],
        ];
        bytes.extend(corners.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
        accessors.push(json!({
            "bufferView": 0, "byteOffset": 72 * index, "componentType": 5126, "count": 6, "type": "VEC3",
            "min": [left, -0.8, z], "max": [right, 0.8, z],
        }));
        meshes.push(json!({"primitives": [{"attributes": {"POSITION": index}, "material": index}]}));
        nodes.push(json!({"mesh": index}));
    }
    nodes.push(json!({"camera": 0, "translation": [0, 0, 5]}));
    let materials: Vec<_> = cards.iter().map(|card| card.3.clone()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    let file = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes, "meshes": meshes, "materials": materials, "accessors": accessors,
        "extensionsUsed": ["KHR_materials_unlit"],
        "bufferViews": [{"buffer": 0, "byteLength": bytes.len()}],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0.1, "zfar": 10}}],
    });
    fs::write(folder.join("cards.gltf"), file.to_string()).unwrap();
}

fn lit(colour: [f32; 3], alpha: f32) -> Value {
    let mode = if alpha < 1.0 { "BLEND" } else { "OPAQUE" };
    json!({
        "alphaMode": mode, "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [colour[0], colour[1], colour[2], alpha], "metallicFactor": 0},
    })
}

/// An unlit material whose colour is that of bytes.
fn unlit(bytes: [u8; 3]) -> Value {
    let [r, g, b] = bytes.map(|byte| linear_from_srgb(f32::from(byte) / 255.0));
    json!({
        "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1]},
        "extensions": {"KHR_materials_unlit": {}},
    })
}

fn png(folder: &Path, arguments: &str) -> Image<[u8; 4]> {
    succeed(folder, &format!("render cards.gltf --size 48x24 {arguments} -o a.png"));
    read_png(&folder.join("a.png")).unwrap()
}

fn exr(folder: &Path, arguments: &str) -> Planes {
    succeed(folder, &format!("render cards.gltf --size 48x24 {arguments} -o a.exr"));
    read_exr(&folder.join("a.exr")).unwrap()
}

/// Whether a pixel shows bytes, to a level.
fn shows(pixel: [u8; 4], bytes: [u8; 3]) -> bool {
    pixel[3] == 255 && pixel.iter().zip(bytes).all(|(&shown, byte)| shown.abs_diff(byte) <= 1)
}

const CORNER: (u32, u32) = (0, 0);
const LEFT: (u32, u32) = (12, 12);
const RIGHT: (u32, u32) = (36, 12);

#[test]
fn a_background_colour_comes_out_as_it_was_given() {
    let folder = tempfile::tempdir().unwrap();
    cards(folder.path(), &[(-1.5, -0.5, 0.0, lit([0.8; 3], 0.5)), (0.5, 1.5, 0.0, lit([0.8; 3], 1.0))]);
    for bytes in [[255, 255, 255], [106, 122, 138], [255, 0, 0], [0, 0, 0], [32, 32, 32]] {
        let [r, g, b] = bytes;
        let background = format!("--background #{r:02x}{g:02x}{b:02x}");
        for technique in
            ["-m baseline -a none", "-a layered --frames 3", "-m weighted -a taa --frames 3 --tone aces"]
        {
            let picture = png(folder.path(), &format!("{background} {technique} --exposure 1.5"));
            assert!(shows(picture[CORNER], bytes), "{bytes:?} {technique}: {:?}", picture[CORNER]);
        }
        let [r, g, b, a] = exr(folder.path(), &format!("{background} -m baseline -a none")).colour[CORNER];
        let linear = bytes.map(|byte| linear_from_srgb(f32::from(byte) / 255.0));
        assert!((Vec3::new(r, g, b) - Vec3::from_array(linear)).abs().max_element() < 1e-5 && a == 1.0);
    }
}

#[test]
fn unlit_colours_come_out_as_they_were_given_beside_lit_ones() {
    let folder = tempfile::tempdir().unwrap();
    for bytes in [[255, 255, 255], [230, 225, 210], [40, 30, 20]] {
        cards(folder.path(), &[(-1.5, -0.5, 0.0, unlit(bytes)), (0.5, 1.5, 0.0, lit([0.8; 3], 1.0))]);
        for background in ["env", "none", "#804020"] {
            for technique in
                ["-m baseline -a none", "-m std -a layered --frames 3", "-m list -a accumulate --frames 3"]
            {
                let picture = |tone: &str| {
                    png(folder.path(), &format!("--background {background} {technique} --tone {tone}"))
                };
                let (neutral, aces) = (picture("pbr-neutral"), picture("aces"));
                for shown in [neutral[LEFT], aces[LEFT]] {
                    assert!(shows(shown, bytes), "{bytes:?} {background} {technique}: {shown:?}");
                }
                // The curve does apply to what is lit.
                assert_ne!(neutral[RIGHT], aces[RIGHT], "{background} {technique}");
            }
        }
    }
}

#[test]
fn what_mixes_with_the_background_goes_over_from_one_kind_to_the_other() {
    let folder = tempfile::tempdir().unwrap();
    cards(folder.path(), &[(-1.5, -0.5, 0.0, lit([0.3; 3], 0.25)), (0.5, 1.5, 0.0, lit([0.3; 3], 0.75))]);
    let arguments = "--background #ffffff -m baseline -a none --exposure -1 --tone aces";
    let (shown, linear) = (png(folder.path(), arguments), exr(folder.path(), arguments));
    let tone = Tone { curve: ToneCurve::Aces, exposure_ev: -1.0 };
    for (place, share) in [(LEFT, 0.75), (RIGHT, 0.25)] {
        let [r, g, b, _] = linear.colour[place];
        let wanted = tone.apply(Vec3::new(r, g, b), share).map(srgb_from_linear);
        assert!(
            shows(shown[place], wanted.to_array().map(u8_from_unit)),
            "{:?}, {wanted} wanted",
            shown[place]
        );
    }
}

#[test]
fn exposure_and_tone_change_pictures_and_no_light() {
    let folder = tempfile::tempdir().unwrap();
    cards(folder.path(), &[(0.5, 1.5, 0.0, lit([0.2; 3], 1.0))]);
    let base = "-m baseline -a none --background none --tone none";
    let dark = png(folder.path(), base)[RIGHT][0];
    let bright = png(folder.path(), &format!("{base} --exposure 1"))[RIGHT][0];
    let doubled = srgb_from_linear(2.0 * linear_from_srgb(f32::from(dark) / 255.0));
    assert!(f32::from(bright).mul_add(1.0 / 255.0, -doubled).abs() < 0.01, "{dark} {bright}");
    let light = |arguments: &str| exr(folder.path(), &format!("{base} {arguments}")).colour;
    assert_eq!(light(""), light("--exposure 3"));
    assert_eq!(light(""), light("--environment-strength 1"));
    // Reports say which.
    let run = "cards.gltf -m std -a none --frames 2 --size 32x16";
    succeed(folder.path(), &format!("compare {run} --tone agx --exposure -0.5 --environment plain -o out"));
    let report = parsed(&fs::read_to_string(folder.path().join("out/report.json")).unwrap());
    assert_eq!((&report["tone"], &report["exposure_ev"]), (&json!("agx"), &json!(-0.5)));
    assert_eq!((&report["environment"], &report["environment_strength"]), (&json!("plain"), &json!(1.0)));
    let page = fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    assert!(
        page.contains("tone agx, -0.5 EV") && page.contains("surroundings plain"),
        "the page does not say so"
    );
    // What is measured on displayed pictures is measured under them.
    let ssim = |tone: &str| {
        succeed(
            folder.path(),
            &format!(
                "compare smoke-square:particles=100 -m std -a none --frames 2 --size 32x18 --tone {tone} -o {tone}"
            ),
        );
        parsed(&fs::read_to_string(folder.path().join(tone).join("report.json")).unwrap())["rows"][1].clone()
    };
    let (neutral, aces) = (ssim("pbr-neutral"), ssim("aces"));
    assert_ne!(neutral["ssim"], aces["ssim"]);
    assert_eq!(neutral["rms"], aces["rms"]);
}

/// A panorama of 64×32 texels.
fn write_panorama(path: &Path, radiance: impl Fn(u32, u32) -> [f32; 3]) {
    let mut planes = Planes::new(64, 32).unwrap();
    planes.colour = Image::from_fn(64, 32, |x, y| {
        let [r, g, b] = radiance(x, y);
        [r, g, b, 1.0]
    })
    .unwrap();
    fs::write(path, encode_exr(&planes, &Metadata::default()).unwrap()).unwrap();
}

#[test]
fn surroundings_light_and_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    cards(folder.path(), &[(0.5, 1.5, 0.0, lit([0.5; 3], 1.0))]);
    let red = |environment: &str| {
        let planes = exr(folder.path(), &format!("-m baseline -a none --environment {environment}"));
        [planes.colour[RIGHT][0], planes.colour[CORNER][0]]
    };
    assert_eq!(red("none"), [0.0, 0.0]);
    let plain = red("plain");
    // Half of the light is reflected by the base, some more by the surface.
    assert!((0.5..0.6).contains(&plain[0]) && plain[1] == 1.0, "{plain:?}");
    let double = red("plain --environment-strength 2");
    assert!((double[0] - 2.0 * plain[0]).abs() < 1e-5 && double[1] == 2.0, "{double:?}");
    assert_eq!(red("studio"), red("scene"), "files are shown in the studio");
    assert_ne!(red("studio"), plain);

    // An even panorama is the plain room, and colour and direction are its own.
    write_panorama(&folder.path().join("even.exr"), |_, _| [1.0; 3]);
    let even = red("even.exr");
    assert!((even[0] - plain[0]).abs() < 1e-3 && (even[1] - 1.0).abs() < 1e-5, "{even:?} {plain:?}");
    write_panorama(
        &folder.path().join("sides.exr"),
        |x, _| if x < 32 { [0.0, 0.0, 2.0] } else { [4.0, 0.0, 0.0] },
    );
    let planes = exr(folder.path(), "-m baseline -a none --environment sides.exr");
    // The camera looks towards -Z, a quarter of the width from the left; the card faces +Z.
    assert_eq!(planes.colour[CORNER], [0.0, 0.0, 2.0, 1.0]);
    let [r, _, b, _] = planes.colour[RIGHT];
    assert!(r > 1.9 && b < 0.05, "{r} {b}");
}

#[test]
fn the_strongest_light_of_a_panorama_casts_a_shadow() {
    let folder = tempfile::tempdir().unwrap();
    // A sun towards +Z, low on the left of the cards: one stands before the other.
    let wall = (-1.8, 1.8, -0.5, lit([0.5; 3], 1.0));
    let post = (-0.2, 0.2, 0.0, lit([0.5; 3], 1.0));
    // Columns 48 and 49 of 64 are towards +Z, seen from +X; row 15 is just above the horizon.
    write_panorama(&folder.path().join("sun.exr"), |x, y| {
        if (x, y) == (54, 15) { [400.0, 380.0, 350.0] } else { [0.25; 3] }
    });
    let brightness = |file: &[(f32, f32, f32, Value)]| {
        cards(folder.path(), file);
        let planes = exr(folder.path(), "-m baseline -a none --environment sun.exr");
        (0..48).map(|x| planes.colour[(x, 12)][0]).collect::<Vec<_>>()
    };
    let alone = brightness(slice::from_ref(&wall));
    let behind = brightness(&[wall, post]);
    let darker = (0..48).filter(|&x| behind[x] < 0.5 * alone[x]).count();
    // As wide as the post and beside it, since the sun stands aside.
    assert!((3..=9).contains(&darker), "{darker} columns are in the shadow: {alone:?} {behind:?}");
}

#[test]
fn panoramas_that_are_none_end_in_an_error_that_names_them() {
    let folder = tempfile::tempdir().unwrap();
    cards(folder.path(), &[(0.5, 1.5, 0.0, lit([0.5; 3], 1.0))]);
    fs::write(folder.path().join("text.hdr"), "no panorama").unwrap();
    fs::create_dir(folder.path().join("folder.exr")).unwrap();
    let mut planes = Planes::new(8, 8).unwrap();
    planes.colour = Image::filled(8, 8, [1.0; 4]).unwrap();
    fs::write(folder.path().join("square.exr"), encode_exr(&planes, &Metadata::default()).unwrap()).unwrap();
    for (file, said) in [
        ("absent.hdr", "absent.hdr"),
        ("text.hdr", "Radiance HDR or OpenEXR"),
        ("folder.exr", "no regular file"),
        ("square.exr", "twice as wide"),
    ] {
        let outcome =
            sheer(folder.path(), &format!("render cards.gltf --size 8x8 --environment {file} -o a.png"));
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stderr.contains(file) && outcome.stderr.contains(said), "{outcome:?}");
        assert!(!folder.path().join("a.png").exists());
    }
}

/// What would never end if it were opened.
#[cfg(unix)]
#[test]
fn a_pipe_is_no_panorama() {
    let folder = tempfile::tempdir().unwrap();
    let made = std::process::Command::new("mkfifo").arg(folder.path().join("pipe.exr")).status().unwrap();
    assert!(made.success());
    let mut child =
        command(folder.path(), "render layers --size 8x8 --environment pipe.exr -o a.png").spawn().unwrap();
    for _ in 0..600 {
        if let Some(status) = child.try_wait().unwrap() {
            assert_eq!(status.code(), Some(1));
            return;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    child.kill().unwrap();
    panic!("it waits for the other end of the pipe");
}

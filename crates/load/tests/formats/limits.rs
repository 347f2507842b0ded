//! What files may take: counted before it is taken.

use std::{fmt::Write as _, path::Path};

use sheer_core::text::MemorySize;
use sheer_load::{LoadError, LoadOptions, Loaded, read};

use crate::{hair::Hair, stl};

/// Vertices along a side of a sheet.
const SIDE: usize = 60;

fn limited(bytes: &[u8], name: &str, limit: u64) -> Result<Loaded, LoadError> {
    let options = LoadOptions { memory_limit: Some(MemorySize(limit)), ..LoadOptions::default() };
    read(bytes, Path::new(name), &options)
}

/// A sheet of squares in each format.
fn sheets() -> Vec<(&'static str, Vec<u8>)> {
    let points = || (0..SIDE * SIDE).map(|at| [at % SIDE, at / SIDE]);
    let corners = || points().filter(|[x, y]| x + 1 < SIDE && y + 1 < SIDE);
    let squares = || corners().map(|[x, y]| [0, 1, SIDE + 1, SIDE].map(|step| y * SIDE + x + step));
    let mut obj = String::new();
    points().for_each(|[x, y]| writeln!(obj, "v {x} {y} 0").unwrap());
    squares().for_each(|square| {
        let [a, b, c, d] = square.map(|corner| corner + 1);
        writeln!(obj, "f {a} {b} {c} {d}").unwrap();
    });
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        SIDE * SIDE,
        squares().count()
    );
    points().for_each(|[x, y]| writeln!(ply, "{x} {y} 0").unwrap());
    squares().for_each(|[a, b, c, d]| writeln!(ply, "4 {a} {b} {c} {d}").unwrap());
    let triangle = stl::binary(b"", [0; 2])[84..134].to_vec();
    let mut stl = vec![0; 80];
    stl.extend(7000_u32.to_le_bytes());
    (0..7000).for_each(|_| stl.extend(&triangle));
    let hair = Hair {
        strand_count: 1000,
        segments: None,
        default_segments: 3,
        points: (0..4000).map(|at| [at as f32, (at * at % 7) as f32, 0.0]).collect(),
        ..Hair::two_strands()
    };
    vec![("a.obj", obj.into_bytes()), ("a.ply", ply.into_bytes()), ("a.stl", stl), ("a.hair", hair.bytes())]
}

#[test]
fn what_a_file_takes_is_held_against_the_limit_before_it_is_taken() {
    for (name, bytes) in sheets() {
        // About 7000 triangles, at some 200 bytes each in a frame and as many on the way there.
        limited(&bytes, name, 20_000_000).unwrap();
        for limit in [bytes.len() as u64 / 2, bytes.len() as u64 + 1000, 1_200_000] {
            let error = limited(&bytes, name, limit).unwrap_err();
            assert!(matches!(error, LoadError::Limit { .. }), "{name}, {limit}: {error}");
            let message = error.to_string();
            assert!(message.contains("raise --memory-limit"), "{message}");
        }
    }
}

#[test]
fn names_are_not_copied_at_length_to_all_that_bears_them() {
    // One long name, many pieces of it.
    let mut text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\no {}\n", "x".repeat(1_000_000));
    (0..2000).for_each(|material| write!(text, "usemtl m{material}\nf 1 2 3\n").unwrap());
    let loaded = limited(text.as_bytes(), "a.obj", 20_000_000).unwrap();
    assert!(loaded.scene.parts().meshes.iter().all(|mesh| mesh.name.len() == 256));
}

//! Damaged files: whatever happens to the bytes, reading ends with a scene or an error.

use sheer_core::hash::Pcg32;

use crate::{hair::Hair, reading::load, stl};

/// Damaged versions of each file, unless the environment says how many.
const ROUNDS: u32 = 600;
const ROUNDS_VARIABLE: &str = "SHEER_DAMAGE_ROUNDS";

fn files() -> Vec<(&'static str, Vec<u8>)> {
    let obj = "mtllib none.mtl\no a\nusemtl b\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\n\
               vn 0 0 1\ns 1\nf 1/1/1 2/2/1 3/-1/-1 4/1/1\ns off\nf 1 2 4\nf -1 -2 -3 -4 1\nl 1 2 3\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
               element face 2\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0 1 2 3 4\n1 0 0 1 2 3 4\n1 1 0 1 2 3 4\n0 1 0 1 2 3 4\n3 0 1 2\n4 0 1 2 3\n";
    let mut binary_ply =
        b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
            .to_vec();
    for number in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        binary_ply.extend(number.to_be_bytes());
    }
    for number in [7_i32, 0, 1, 2, -1, 2, 1, 0] {
        binary_ply.extend(number.to_be_bytes());
    }
    let text_stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                    endfacet\nendsolid a\n";
    let hair = Hair {
        thickness: Some(vec![0.1; 5]),
        transparency: Some(vec![0.5; 5]),
        colours: Some(vec![[0.5; 3]; 5]),
        ..Hair::two_strands()
    };
    vec![
        ("a.obj", obj.into()),
        ("a.ply", ply.into()),
        ("b.ply", binary_ply),
        ("a.stl", text_stl.into()),
        ("b.stl", stl::binary(b"COLOR=abcd", [0x8123, 77])),
        ("a.hair", hair.bytes()),
    ]
}

/// A place in a list of so many.
fn place(chance: &mut Pcg32, count: usize) -> usize {
    chance.below(count.max(1) as u32) as usize
}

/// One to four wounds: bytes overwritten, cut out, cut off, doubled, or words exchanged.
fn damage(bytes: &mut Vec<u8>, chance: &mut Pcg32) {
    const WORDS: [&[u8]; 10] = [
        b"-1",
        b"0",
        b"4294967296",
        b"1e39",
        b"nan",
        b"-9999999999999999999",
        b"",
        b"/",
        b"\n",
        b"\xff\xff\xff\xff",
    ];
    for _ in 0..=place(chance, 4) {
        let at = place(chance, bytes.len());
        let length = place(chance, (bytes.len() - at).min(16) + 1);
        match place(chance, 6) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..at + length)),
            2 => {
                let copy = bytes[at..at + length].to_vec();
                let to = place(chance, bytes.len());
                bytes.splice(to..to, copy);
            }
            3 => {
                let word = WORDS[place(chance, WORDS.len())];
                bytes.splice(at..at + length, word.iter().copied());
            }
            4 => bytes[at..at + length].iter_mut().for_each(|byte| *byte = chance.next_u32() as u8),
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << place(chance, 8);
                }
            }
        }
    }
}

#[test]
fn no_damage_makes_a_loader_panic() {
    let asked = std::env::var(ROUNDS_VARIABLE).ok().map(|rounds| rounds.parse().unwrap());
    let rounds: u32 = asked.unwrap_or(ROUNDS);
    let mut chance = Pcg32::new(7, 0);
    for (name, sound) in files() {
        assert!(load(&sound, name).is_ok(), "{name} is sound");
        let mut kinds = [0_u32; 2];
        for _ in 0..rounds {
            let mut bytes = sound.clone();
            damage(&mut bytes, &mut chance);
            kinds[usize::from(load(&bytes, name).is_ok())] += 1;
        }
        // Damage does harm, and some of it can be lived with.
        assert!(kinds.iter().all(|count| *count > rounds / 50), "{name}: {kinds:?} refused and read");
    }
}

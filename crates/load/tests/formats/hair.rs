//! Hair files.

use glam::Vec3;
use sheer_scene::model::{AlphaMode, ShadingModel};

use crate::reading::{close, parts_of, refused, warned};

/// A file in the making: two strands, of two and of one segment, or of two each without a list of segments.
pub(crate) struct Hair {
    pub(crate) strand_count: u32,
    pub(crate) default_segments: u32,
    pub(crate) default_transparency: f32,
    pub(crate) segments: Option<Vec<u16>>,
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) thickness: Option<Vec<f32>>,
    pub(crate) transparency: Option<Vec<f32>>,
    pub(crate) colours: Option<Vec<[f32; 3]>>,
}

impl Hair {
    pub(crate) fn two_strands() -> Self {
        Self {
            strand_count: 2,
            default_segments: 0,
            default_transparency: 0.0,
            segments: Some(vec![2, 1]),
            points: vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.5]],
            thickness: None,
            transparency: None,
            colours: None,
        }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let arrays = [
            self.segments.is_some(),
            true,
            self.thickness.is_some(),
            self.transparency.is_some(),
            self.colours.is_some(),
        ];
        let bits = arrays.iter().enumerate().map(|(bit, there)| u32::from(*there) << bit).sum::<u32>();
        let mut bytes = b"HAIR".to_vec();
        for word in [self.strand_count, self.points.len() as u32, bits, self.default_segments] {
            bytes.extend(word.to_le_bytes());
        }
        for number in [0.1, self.default_transparency, 1.0, 0.0, 0.0] {
            bytes.extend(f32::to_le_bytes(number));
        }
        bytes.resize(128, 0);
        bytes.extend(self.segments.iter().flatten().flat_map(|count| count.to_le_bytes()));
        let vectors = self.points.iter().flatten();
        bytes.extend(vectors.flat_map(|number| number.to_le_bytes()));
        for list in [&self.thickness, &self.transparency] {
            bytes.extend(list.iter().flatten().flat_map(|number| number.to_le_bytes()));
        }
        bytes.extend(self.colours.iter().flatten().flatten().flat_map(|number| number.to_le_bytes()));
        bytes
    }
}

#[test]
fn strands_become_ribbons_along_their_points() {
    let parts = parts_of(&Hair::two_strands().bytes(), "a.hair");
    let mesh = &parts.meshes[0];
    assert_eq!((mesh.positions.len(), mesh.indices.len()), (10, 6), "two triangles a segment");
    for (at, point) in Hair::two_strands().points.iter().enumerate() {
        let [left, right] = [mesh.positions[2 * at], mesh.positions[2 * at + 1]];
        assert!(close(0.5 * (left + right), Vec3::from(*point)));
        assert!((left.distance(right) - 0.1).abs() < 1e-5, "as wide as the header says");
        assert!(close(mesh.normals[2 * at], Vec3::Z), "the direction of the hair");
        assert!((right - left).dot(mesh.normals[2 * at]).abs() < 1e-6);
    }
    let material = &parts.materials[0];
    assert_eq!((material.model, material.alpha_mode), (ShadingModel::Fibre, AlphaMode::Opaque));
    assert!(close(mesh.colours[0].truncate(), Vec3::X));
    let up = parts.nodes[0].transform.to_affine().transform_vector3(Vec3::Z);
    assert!(close(up, Vec3::Y));
}

#[test]
fn points_have_their_own_thickness_transparency_and_colour() {
    let hair = Hair {
        thickness: Some(vec![0.4, 0.2, 0.0, 0.4, 0.1]),
        transparency: Some(vec![0.0, 0.25, 1.0, 0.0, 0.5]),
        colours: Some(vec![[0.0, 1.0, 0.0]; 5]),
        ..Hair::two_strands()
    };
    let parts = parts_of(&hair.bytes(), "a.hair");
    let mesh = &parts.meshes[0];
    assert!((mesh.positions[2].distance(mesh.positions[3]) - 0.2).abs() < 1e-5);
    let alphas: Vec<f32> = mesh.colours.iter().step_by(2).map(|colour| colour.w).collect();
    assert_eq!(alphas, [1.0, 0.75, 0.0, 1.0, 0.5]);
    assert!(close(mesh.colours[4].truncate(), Vec3::Y));
    assert_eq!(parts.materials[0].alpha_mode, AlphaMode::Blend);
}

#[test]
fn odd_files_are_drawn_as_far_as_they_are_sound() {
    // No list of segments: all strands have as many.
    let even = Hair {
        segments: None,
        default_segments: 1,
        points: vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]],
        ..Hair::two_strands()
    };
    assert_eq!(parts_of(&even.bytes(), "a.hair").meshes[0].indices.len(), 4);
    // A strand of one point, and points that are one, have nothing to see, and are no harm.
    let dots = Hair { segments: Some(vec![0, 3]), ..Hair::two_strands() };
    assert_eq!(parts_of(&dots.bytes(), "a.hair").meshes[0].indices.len(), 6);
    let still = Hair { points: vec![[2.0; 3]; 5], ..Hair::two_strands() };
    assert!(parts_of(&still.bytes(), "a.hair").meshes[0].normals.iter().all(|normal| normal.is_finite()));
    let clear = Hair { default_transparency: 7.0, ..Hair::two_strands() };
    assert_eq!(parts_of(&clear.bytes(), "a.hair").meshes[0].colours[0].w, 0.0);
    let mut broken = Hair::two_strands();
    broken.points[4][1] = f32::INFINITY;
    let parts = warned(&broken.bytes(), "a.hair", "one strand with a point or thickness that is not finite");
    assert_eq!(parts.meshes[0].indices.len(), 4);
    let mut longer = Hair::two_strands().bytes();
    longer.extend([1, 2, 3]);
    assert_eq!(parts_of(&longer, "a.hair").meshes[0].indices.len(), 6);
}

#[test]
fn what_cannot_be_read_is_named_with_its_byte_or_strand() {
    let bytes = Hair::two_strands().bytes();
    refused(&bytes[..100], "a.hair", "header: this is no hair file");
    refused(b"hair", "a.hair", "this is no hair file");
    refused(&bytes[..140], "a.hair", "byte 132: 5 points of 12 bytes should stand here");
    let mut bald = bytes.clone();
    bald[12] = 1;
    refused(&bald, "a.hair", "byte 12: the file has no points");
    let greedy = Hair { segments: Some(vec![2, 9]), ..Hair::two_strands() };
    let parts = warned(&greedy.bytes(), "a.hair", "strand 1: it needs points 3 to 13, but there are only 5");
    assert_eq!(parts.meshes[0].indices.len(), 4, "the strand before it is drawn");
    // Cut short within its colours: those that are missing are the file's own.
    let coloured = Hair { colours: Some(vec![[0.0, 1.0, 0.0]; 5]), ..Hair::two_strands() }.bytes();
    let parts = warned(&coloured[..coloured.len() - 12], "a.hair", "5 colours of 12 bytes should stand here");
    assert!(
        close(parts.meshes[0].colours[0].truncate(), Vec3::Y)
            && close(parts.meshes[0].colours[9].truncate(), Vec3::X)
    );
    let thin = Hair { thickness: Some(vec![0.0; 5]), ..Hair::two_strands() };
    let parts = warned(&thin.bytes(), "a.hair", "they have no thickness");
    let mesh = &parts.meshes[0];
    assert!(mesh.positions[0].distance(mesh.positions[1]) > 1e-3);
    let many = Hair { strand_count: u32::MAX, ..Hair::two_strands() };
    refused(&many.bytes(), "a.hair", "byte 128: 4294967295 numbers of segments");
    let endless = Hair { segments: None, default_segments: u32::MAX, ..Hair::two_strands() };
    refused(&endless.bytes(), "a.hair", "strand 0: it needs points");
}

//! Modelling: quads, blocks, lathes and tubes, with texture coordinates in metres so that nothing is ever
//! stretched.
//!
//! Unless a texture is fitted to a surface, texture coordinates are metres along it (v downwards), and the
//! material scales metres to tiles.

use std::{collections::BTreeMap, f32::consts::TAU};

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec4};

/// Triangles in the making. `brush` is the linear colour that new vertices get, as a factor on the material's
/// own.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) colours: Vec<Vec4>,
    pub(crate) indices: Vec<[u32; 3]>,
    brush: Vec4,
    /// Added to planar texture coordinates, so that equal parts do not show equal texels.
    uv_shift: Vec2,
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colours: Vec::new(),
            indices: Vec::new(),
            brush: Vec4::ONE,
            uv_shift: Vec2::ZERO,
        }
    }
}

/// Shapes by material index: what becomes one object of the scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Model {
    shapes: BTreeMap<u32, Shape>,
}

/// A vertex to be added; the brush colours it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) uv: Vec2,
}

impl Model {
    /// The shape with this material, painted with this linear tint from here on.
    pub(crate) fn paint(&mut self, material: u32, tint: Vec3) -> &mut Shape {
        let shape = self.shapes.entry(material).or_default();
        shape.brush = tint.extend(1.0);
        shape
    }

    /// A model of one shape.
    pub(crate) fn from_shape(material: u32, shape: Shape) -> Self {
        Self { shapes: BTreeMap::from([(material, shape)]) }
    }

    /// Moves every vertex of a material to where `moved` says of its position and normal.
    pub(crate) fn warp(&mut self, material: u32, moved: impl Fn(Vec3, Vec3) -> Vec3) {
        if let Some(shape) = self.shapes.get_mut(&material) {
            for (position, &normal) in shape.positions.iter_mut().zip(&shape.normals) {
                *position = moved(*position, normal);
            }
        }
    }

    /// Colours every vertex of a material by what `colour` says of its position and normal.
    pub(crate) fn tint(&mut self, material: u32, colour: impl Fn(Vec3, Vec3) -> Vec3) {
        if let Some(shape) = self.shapes.get_mut(&material) {
            for ((own, &position), &normal) in
                shape.colours.iter_mut().zip(&shape.positions).zip(&shape.normals)
            {
                *own = colour(position, normal).extend(own.w);
            }
        }
    }

    /// Adds another model, moved.
    pub(crate) fn append(&mut self, other: &Self, self_from_other: Affine3A) {
        for (&material, shape) in &other.shapes {
            self.shapes.entry(material).or_default().append(shape, self_from_other);
        }
    }

    /// Multiplies every vertex colour by what `factor` says of its position and normal: baked occlusion and
    /// dirt.
    pub(crate) fn shade(&mut self, factor: impl Fn(Vec3, Vec3) -> f32) {
        for shape in self.shapes.values_mut() {
            shape.shade(&factor);
        }
    }

    pub(crate) fn into_shapes(self) -> impl Iterator<Item = (u32, Shape)> {
        self.shapes.into_iter().filter(|(_, shape)| !shape.indices.is_empty())
    }
}

impl Shape {
    /// Sets the linear tint and alpha of what comes next.
    pub(crate) fn brush(&mut self, rgba: Vec4) -> &mut Self {
        self.brush = rgba;
        self
    }

    /// Moves planar texture coordinates of what comes next.
    pub(crate) fn shift_uv(&mut self, by: Vec2) -> &mut Self {
        self.uv_shift = by;
        self
    }

    /// An empty shape with the same brush.
    pub(crate) fn like(&self) -> Self {
        Self { brush: self.brush, ..Self::default() }
    }

    pub(crate) fn vertex(&mut self, vertex: Vertex) -> u32 {
        self.positions.push(vertex.position);
        self.normals.push(vertex.normal);
        self.uvs.push(vertex.uv);
        self.colours.push(self.brush);
        self.positions.len() as u32 - 1
    }

    /// A flat polygon of four corners, counter-clockwise seen from the front, with given texture coordinates.
    pub(crate) fn quad_uv(&mut self, corners: [Vec3; 4], uvs: [Vec2; 4]) {
        let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize_or(Vec3::Y);
        let first = self.positions.len() as u32;
        for (position, uv) in corners.into_iter().zip(uvs) {
            self.vertex(Vertex { position, normal, uv });
        }
        self.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    /// A flat polygon of four corners (lower left, lower right, upper right, upper left) with texture
    /// coordinates in metres.
    pub(crate) fn quad(&mut self, corners: [Vec3; 4]) {
        let along = (corners[1] - corners[0]).normalize_or(Vec3::X);
        let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize_or(Vec3::Y);
        let up = normal.cross(along);
        let shift = self.uv_shift;
        self.quad_uv(corners, corners.map(|p| shift + Vec2::new(p.dot(along), -p.dot(up))));
    }

    /// A triangle with texture coordinates in metres; its first edge is the horizontal of the texture.
    pub(crate) fn triangle(&mut self, corners: [Vec3; 3]) {
        let along = (corners[1] - corners[0]).normalize_or(Vec3::X);
        let normal = along.cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
        let up = normal.cross(along);
        let first = self.positions.len() as u32;
        for position in corners {
            let uv = self.uv_shift + Vec2::new(position.dot(along), -position.dot(up));
            self.vertex(Vertex { position, normal, uv });
        }
        self.indices.push([first, first + 1, first + 2]);
    }

    /// A parallelogram: `right` and `up` are its edges, its front is where they turn counter-clockwise.
    pub(crate) fn panel(&mut self, corner: Vec3, right: Vec3, up: Vec3) {
        self.quad([corner, corner + right, corner + right + up, corner + up]);
    }

    /// A parallelogram that the whole texture is fitted to.
    pub(crate) fn fitted_panel(&mut self, corner: Vec3, right: Vec3, up: Vec3, uv_min: Vec2, uv_max: Vec2) {
        self.quad_uv(
            [corner, corner + right, corner + right + up, corner + up],
            [Vec2::new(uv_min.x, uv_max.y), uv_max, Vec2::new(uv_max.x, uv_min.y), uv_min],
        );
    }

    /// An axis-aligned block; its faces look outwards.
    pub(crate) fn block(&mut self, low: Vec3, high: Vec3) {
        self.box_of(low, Vec3::X * (high.x - low.x), Vec3::Y * (high.y - low.y), Vec3::Z * (high.z - low.z));
    }

    /// A right-handed parallelepiped with these three edges.
    pub(crate) fn box_of(&mut self, corner: Vec3, x: Vec3, y: Vec3, z: Vec3) {
        self.panel(corner + z, x, y);
        self.panel(corner + x, -x, y);
        self.panel(corner, z, y);
        self.panel(corner + x + z, -z, y);
        self.panel(corner + y + z, x, -z);
        self.panel(corner, x, z);
    }

    /// A beam of rectangular section from one point to another; `side` tells which way its width lies.
    pub(crate) fn beam(&mut self, from: Vec3, to: Vec3, side: Vec3, width: f32, depth: f32) {
        let along = to - from;
        let across = (side - along * side.dot(along) / along.length_squared()).normalize_or(Vec3::X) * width;
        let out = across.cross(along).normalize_or(Vec3::Z) * depth;
        self.box_of(from - 0.5 * across - 0.5 * out, across, along, out);
    }

    /// A surface of revolution around +Y through `centre`: `profile` is (radius, height) from the bottom
    /// outwards to the top. Sharp where the profile turns by more than about 40 degrees, smooth elsewhere.
    pub(crate) fn lathe(&mut self, centre: Vec3, profile: &[(f32, f32)], segment_count: u32) {
        let widest = profile.iter().fold(0.0_f32, |widest, point| widest.max(point.0));
        let slope = |i: usize| {
            let ((r0, y0), (r1, y1)) = (profile[i], profile[i + 1]);
            Vec2::new(y1 - y0, r0 - r1).normalize_or(Vec2::X)
        };
        let mut travelled = 0.0;
        for i in 0..profile.len() - 1 {
            let own = slope(i);
            let soft = |other: Vec2| if own.dot(other) > 0.766 { (own + other).normalize() } else { own };
            let low = if i > 0 { soft(slope(i - 1)) } else { own };
            let high = if i + 2 < profile.len() { soft(slope(i + 1)) } else { own };
            let length = Vec2::from(profile[i]).distance(profile[i + 1].into());
            let first = self.positions.len() as u32;
            for s in 0..=segment_count {
                let turn = TAU * s as f32 / segment_count as f32;
                let (sin, cos) = turn.sin_cos();
                for ((radius, height), normal, v) in
                    [(profile[i], low, travelled), (profile[i + 1], high, travelled + length)]
                {
                    self.vertex(Vertex {
                        position: centre + Vec3::new(radius * sin, height, radius * cos),
                        normal: Vec3::new(normal.x * sin, normal.y, normal.x * cos),
                        uv: self.uv_shift + Vec2::new(turn * widest, -v),
                    });
                }
            }
            for s in 0..segment_count {
                let at = first + 2 * s;
                if profile[i].0 > 0.0 {
                    self.indices.push([at, at + 2, at + 3]);
                }
                if profile[i + 1].0 > 0.0 {
                    self.indices.push([at, at + 3, at + 1]);
                }
            }
            travelled += length;
        }
    }

    /// A round tube along points, each with its own radius, open at both ends.
    pub(crate) fn tube(&mut self, points: &[(Vec3, f32)], segment_count: u32) {
        let direction = |i: usize| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(points.len() - 1));
            (points[high].0 - points[low].0).normalize_or(Vec3::Y)
        };
        let mut side = direction(0).any_orthonormal_vector();
        let first = self.positions.len() as u32;
        let mut travelled = 0.0;
        for (i, &(centre, radius)) in points.iter().enumerate() {
            let along = direction(i);
            side = (side - along * side.dot(along)).normalize_or(along.any_orthonormal_vector());
            let other = along.cross(side);
            if i > 0 {
                travelled += centre.distance(points[i - 1].0);
            }
            for s in 0..=segment_count {
                let turn = TAU * s as f32 / segment_count as f32;
                let normal = side * turn.cos() + other * turn.sin();
                let uv = self.uv_shift + Vec2::new(turn * points[0].1, -travelled);
                self.vertex(Vertex { position: centre + normal * radius, normal, uv });
            }
        }
        let ring = segment_count + 1;
        for i in 0..points.len() as u32 - 1 {
            for s in 0..segment_count {
                let at = first + i * ring + s;
                self.indices.extend([[at, at + 1, at + ring + 1], [at, at + ring + 1, at + ring]]);
            }
        }
    }

    /// Gives every vertex the brush of another shape.
    pub(crate) fn repaint(&mut self, like: &Self) {
        self.colours.fill(like.brush);
    }

    /// Adds another shape, moved and tinted with the brush it was painted with.
    pub(crate) fn append(&mut self, other: &Self, self_from_other: Affine3A) {
        let first = self.positions.len() as u32;
        let normal_matrix: Mat3A = self_from_other.matrix3.inverse().transpose();
        self.positions.extend(other.positions.iter().map(|&p| self_from_other.transform_point3(p)));
        self.normals.extend(other.normals.iter().map(|&n| (normal_matrix * n).normalize_or(Vec3::Y)));
        self.uvs.extend_from_slice(&other.uvs);
        self.colours.extend_from_slice(&other.colours);
        let mirrored = self_from_other.matrix3.determinant() < 0.0;
        self.indices.extend(other.indices.iter().map(|&[a, b, c]| {
            let [b, c] = if mirrored { [c, b] } else { [b, c] };
            [a + first, b + first, c + first]
        }));
    }

    fn shade(&mut self, factor: &impl Fn(Vec3, Vec3) -> f32) {
        for ((colour, &position), &normal) in self.colours.iter_mut().zip(&self.positions).zip(&self.normals)
        {
            *colour = (colour.truncate() * factor(position, normal)).extend(colour.w);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume that the triangles enclose: positive if they look outwards.
    fn sixfold_volume(shape: &Shape) -> f32 {
        let corner = |i: u32| shape.positions[i as usize];
        shape.indices.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum()
    }

    fn normals_agree_with_winding(shape: &Shape) -> bool {
        shape.indices.iter().all(|&[a, b, c]| {
            let corner = |i: u32| shape.positions[i as usize];
            let face = (corner(b) - corner(a)).cross(corner(c) - corner(a));
            [a, b, c].iter().all(|&i| face.dot(shape.normals[i as usize]) > 0.0)
        })
    }

    #[test]
    fn solids_look_outwards_and_enclose_their_volume() {
        let mut block = Shape::default();
        block.block(Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 4.0, 6.0));
        assert!((sixfold_volume(&block) / 6.0 - 6.0).abs() < 1e-4);
        let mut drum = Shape::default();
        drum.lathe(Vec3::ZERO, &[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)], 64);
        assert!((sixfold_volume(&drum) / 6.0 - TAU).abs() < 0.02);
        let mut tube = Shape::default();
        tube.tube(&[(Vec3::ZERO, 0.5), (Vec3::X, 0.4), (Vec3::new(2.0, 1.0, 0.0), 0.2)], 12);
        let mut beam = Shape::default();
        beam.beam(Vec3::ZERO, Vec3::new(0.0, 3.0, 1.0), Vec3::X, 0.2, 0.1);
        assert!((sixfold_volume(&beam) / 6.0 - 0.02 * 10.0_f32.sqrt()).abs() < 1e-4);
        for shape in [block, drum, tube, beam] {
            assert!(normals_agree_with_winding(&shape));
        }
    }

    #[test]
    fn a_mirrored_copy_still_looks_outwards() {
        let mut block = Shape::default();
        block.block(Vec3::ZERO, Vec3::ONE);
        let mut copy = Shape::default();
        copy.append(&block, Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
        assert!(normals_agree_with_winding(&copy) && sixfold_volume(&copy) > 0.0);
    }

    #[test]
    fn planar_texture_coordinates_are_metres() {
        let mut shape = Shape::default();
        shape.panel(Vec3::new(4.0, 1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 3.0);
        assert_eq!(shape.uvs[2] - shape.uvs[0], Vec2::new(2.0, -3.0));
    }
}

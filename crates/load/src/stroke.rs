//! Points and lines, drawn as bodies that are about a pixel wide in the view that frames the scene: an
//! octahedron for a point, a prism for a line. Being convex and seen from outside alone, they cover what is
//! behind them once, with the opacity of their material.
//!
//! Quads that face the camera would take fewer triangles, but could not follow nodes, skins and morphs, nor
//! cast shadows that stay. They are shown in their colour, unlit: a point has no side that light could meet.

use std::collections::HashMap;

use glam::{Affine3A, Vec3};
use sheer_scene::model::{Mesh, MorphTarget, SceneParts, ShadingModel};

/// Their width as a share of the extent of the scene: about a pixel of a picture of the default size.
pub(super) const WIDTH_SHARE: f32 = 1.0 / 500.0;
/// How many are drawn of a mesh, at some 2 kB each with what a frame needs; of more, every so many-th.
const MOST_STROKES: usize = 1 << 19;
/// Triangles of the body of a point, and of a line.
const TRIANGLES: [usize; 2] = [8, 6];
/// Vertices of either.
const VERTICES: u64 = 6;

/// Of the body that a stroke becomes, its vertices with their attributes and its triangles.
const BODY_BYTES: usize = 600;

/// Triangles and vertices that so many strokes become at most.
pub(super) fn most_of_bodies(count: usize) -> [u64; 2] {
    let strokes = count.min(MOST_STROKES) as u64;
    [strokes * TRIANGLES[0] as u64, strokes * VERTICES]
}

/// Points or lines of a mesh, by the indices of its vertices.
#[derive(Clone, Debug)]
pub(super) enum Strokes {
    Points(Vec<u32>),
    Lines(Vec<[u32; 2]>),
}

/// A mesh without triangles, whose strokes are still to be made into some.
pub(super) struct Sketch {
    /// Index into the scene's meshes.
    pub(super) mesh: u32,
    pub(super) strokes: Strokes,
}

impl Strokes {
    fn len(&self) -> usize {
        match self {
            Self::Points(points) => points.len(),
            Self::Lines(lines) => lines.len(),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What their bodies will take as a mesh.
    pub(super) fn body_bytes(&self) -> usize {
        self.len().min(MOST_STROKES) * BODY_BYTES
    }

    /// Keeps what refers to sound vertices alone.
    pub(super) fn retain(&mut self, is_sound: impl Fn(u32) -> bool) {
        match self {
            Self::Points(points) => points.retain(|point| is_sound(*point)),
            Self::Lines(lines) => lines.retain(|ends| ends.iter().all(|end| is_sound(*end))),
        }
    }

    /// Leaves out evenly what is too much, and says so.
    pub(super) fn thin_out(&mut self) -> Option<String> {
        let count = self.len();
        let step = count.div_ceil(MOST_STROKES);
        if step <= 1 {
            return None;
        }
        let what = match self {
            Self::Points(points) => {
                *points = points.iter().copied().step_by(step).collect();
                "points"
            }
            Self::Lines(lines) => {
                *lines = lines.iter().copied().step_by(step).collect();
                "lines"
            }
        };
        Some(format!("of {count} {what} one in {step} is drawn"))
    }
}

/// Gives sketched meshes their triangles, and materials that show their colour as it is. The scene's
/// instances and nodes are in place, and all indices are in range.
pub(super) fn draw(parts: &mut SceneParts, sketches: Vec<Sketch>) {
    if sketches.is_empty() {
        return;
    }
    let (extent, scale_of) = extent_and_scales(parts);
    let mut unlit: HashMap<u32, u32> = HashMap::new();
    for Sketch { mesh: index, strokes } in sketches {
        let scale = scale_of.get(&index).copied().unwrap_or(1.0);
        let radius = 0.5 * WIDTH_SHARE * extent / scale;
        let mesh = &mut parts.meshes[index as usize];
        *mesh = drawn(mesh, &strokes, radius);
        let materials = &mut parts.materials;
        mesh.material = *unlit.entry(mesh.material).or_insert_with_key(|&material| {
            let mut material = materials[material as usize].clone();
            material.model = ShadingModel::Unlit;
            material.double_sided = false;
            materials.push(material);
            materials.len() as u32 - 1
        });
    }
}

/// Length of the diagonal of a box around everything at rest, skins aside, and the scale of the first
/// instance of each mesh.
fn extent_and_scales(parts: &SceneParts) -> (f32, HashMap<u32, f32>) {
    let mut world_from_node: Vec<Affine3A> = Vec::with_capacity(parts.nodes.len());
    for node in &parts.nodes {
        let parent = node.parent.map_or(Affine3A::IDENTITY, |parent| world_from_node[parent as usize]);
        world_from_node.push(parent * node.transform.to_affine());
    }
    let mut scale_of = HashMap::new();
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for instance in &parts.instances {
        let world_from_object = world_from_node[instance.node as usize] * instance.node_from_object;
        let scale = world_from_object.matrix3.determinant().abs().cbrt();
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        scale_of.entry(instance.mesh).or_insert(scale);
        for position in &parts.meshes[instance.mesh as usize].positions {
            let point = world_from_object.transform_point3(*position);
            if point.is_finite() {
                (low, high) = (low.min(point), high.max(point));
            }
        }
    }
    let extent = (high - low).length();
    // A point alone is as large as if it stood in a scene of size 1.
    (if extent > 0.0 && extent.is_finite() { extent } else { 1.0 }, scale_of)
}

/// The bodies of strokes, with the attributes of the vertices that they come from.
fn drawn(mesh: &Mesh, strokes: &Strokes, radius: f32) -> Mesh {
    let mut bodies = Bodies::default();
    match strokes {
        Strokes::Points(points) => {
            points.iter().for_each(|&point| bodies.add_point(point, mesh.positions[point as usize], radius));
        }
        Strokes::Lines(lines) => {
            lines.iter().for_each(|&ends| {
                bodies.add_line(ends, ends.map(|end| mesh.positions[end as usize]), radius);
            });
        }
    }
    let Bodies { positions, sources, indices } = bodies;
    fn gather<T: Copy>(list: &[T], sources: &[u32]) -> Vec<T> {
        if list.is_empty() { Vec::new() } else { sources.iter().map(|&from| list[from as usize]).collect() }
    }
    let per_vertex = mesh.influences_per_vertex;
    let influences =
        sources.iter().flat_map(|&from| &mesh.influences[from as usize * per_vertex..][..per_vertex]);
    Mesh {
        name: mesh.name.clone(),
        material: mesh.material,
        uv_sets: mesh.uv_sets.iter().map(|set| gather(set, &sources)).collect(),
        colours: gather(&mesh.colours, &sources),
        influences: influences.copied().collect(),
        influences_per_vertex: per_vertex,
        morph_targets: (mesh.morph_targets.iter())
            .map(|target| MorphTarget {
                positions: gather(&target.positions, &sources),
                normals: Vec::new(),
                tangents: Vec::new(),
                colours: gather(&target.colours, &sources),
                uv_sets: target.uv_sets.iter().map(|set| gather(set, &sources)).collect(),
            })
            .collect(),
        positions,
        indices,
        ..Mesh::default()
    }
}

/// Bodies as they are made.
#[derive(Default)]
struct Bodies {
    positions: Vec<Vec3>,
    /// The vertex that each one comes from.
    sources: Vec<u32>,
    indices: Vec<[u32; 3]>,
}

impl Bodies {
    fn add_point(&mut self, source: u32, at: Vec3, radius: f32) {
        let first = self.positions.len() as u32;
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            self.positions.extend([at + axis * radius, at - axis * radius]);
        }
        self.sources.extend([source; 6]);
        for octant in 0..8_u32 {
            let [x, y, z] = [octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2)].map(|at| first + at);
            // Each mirroring turns the winding.
            self.indices.push(if octant.count_ones() % 2 == 0 { [x, y, z] } else { [x, z, y] });
        }
    }

    fn add_line(&mut self, ends: [u32; 2], [from, to]: [Vec3; 2], radius: f32) {
        // A line without a length has nothing to see.
        let Some(along) = (to.as_dvec3() - from.as_dvec3()).try_normalize() else { return };
        let along = along.as_vec3();
        let first = self.positions.len() as u32;
        let right = along.any_orthonormal_vector();
        let up = along.cross(right);
        for (end, at) in ends.into_iter().zip([from, to]) {
            for corner in 0..3_u8 {
                let (sin, cos) = (std::f32::consts::TAU / 3.0 * f32::from(corner)).sin_cos();
                self.positions.push(at + (right * cos + up * sin) * radius);
                self.sources.push(end);
            }
        }
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let [a, b, c, d] = [corner, next, 3 + next, 3 + corner].map(|at| first + at);
            self.indices.extend([[a, b, c], [a, c, d]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec4;

    use super::*;
    use sheer_scene::model::{Instance, Material, Node, Transform};

    /// A scene of one mesh of three vertices, ten units long, at a node of a scale.
    fn scene(scale: f32) -> SceneParts {
        let transform = Transform::Trs {
            translation: Vec3::ZERO,
            rotation: glam::Quat::IDENTITY,
            scale: Vec3::splat(scale),
        };
        SceneParts {
            nodes: vec![Node { transform, ..Node::default() }],
            meshes: vec![Mesh {
                positions: vec![Vec3::ZERO, Vec3::X * 10.0, Vec3::X * 5.0],
                colours: vec![Vec4::ONE, Vec4::ZERO, Vec4::W],
                ..Mesh::default()
            }],
            instances: vec![Instance::default()],
            materials: vec![Material { double_sided: true, ..Material::default() }],
            exposure: 1.0,
            ..SceneParts::default()
        }
    }

    fn drawn_scene(scale: f32, strokes: Strokes) -> SceneParts {
        let mut parts = scene(scale);
        draw(&mut parts, vec![Sketch { mesh: 0, strokes }]);
        parts
    }

    /// All triangles look away from a point inside.
    fn is_closed_outwards(mesh: &Mesh, inside: Vec3) -> bool {
        mesh.indices.iter().all(|corners| {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
            (b - a).cross(c - a).dot(a - inside) > 0.0
        })
    }

    #[test]
    fn a_point_is_a_small_body_of_its_colour() {
        let parts = drawn_scene(1.0, Strokes::Points(vec![1]));
        let mesh = &parts.meshes[0];
        assert_eq!((mesh.positions.len(), mesh.indices.len()), (6, TRIANGLES[0]));
        assert!(is_closed_outwards(mesh, Vec3::X * 10.0));
        assert!(mesh.colours.iter().all(|colour| *colour == Vec4::ZERO));
        assert!(mesh.positions.iter().all(|at| (at.distance(Vec3::X * 10.0) - 0.01).abs() < 1e-6));
        let material = &parts.materials[mesh.material as usize];
        assert!(material.model == ShadingModel::Unlit && !material.double_sided);
        assert_eq!(parts.materials[0].model, ShadingModel::MetallicRoughness, "others keep theirs");
    }

    #[test]
    fn a_line_is_a_prism_as_wide_in_the_world_whatever_its_scale() {
        for scale in [1e-6, 1.0, 1e6] {
            let parts = drawn_scene(scale, Strokes::Lines(vec![[0, 1], [2, 2]]));
            let mesh = &parts.meshes[0];
            assert_eq!((mesh.positions.len(), mesh.indices.len()), (6, TRIANGLES[1]), "one has no length");
            assert!(mesh.positions.iter().all(|at| (at.y.hypot(at.z) - 0.01).abs() < 1e-5), "{scale}");
            // The ends stay open: they look along the line.
            assert!(is_closed_outwards(mesh, Vec3::X * 5.0));
            assert_eq!(mesh.colours[0], Vec4::ONE);
            assert_eq!(mesh.colours[5], Vec4::ZERO);
        }
    }

    #[test]
    fn too_many_are_thinned_out_evenly_and_it_is_said() {
        let mut few = Strokes::Points((0..10).collect());
        assert_eq!(few.thin_out(), None);
        let mut many = Strokes::Points((0..3 * MOST_STROKES as u32).collect());
        assert_eq!(many.thin_out(), Some(format!("of {} points one in 3 is drawn", 3 * MOST_STROKES)));
        let Strokes::Points(points) = many else { panic!("they were points") };
        assert_eq!((points.len(), points[1]), (MOST_STROKES, 3));
    }
}

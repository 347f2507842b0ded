//! Scene + time → frame: world-space triangles with ids, opacity and surfaces.
//!
//! Triangles that never move come first and are made once; those of animated nodes, skins and morphs follow, then particle quads. So an
//! acceleration structure over the first part can be kept. Positions of the previous frame are kept beside the moving ones: they give the
//! motion vectors.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use crate::{
    camera::CameraPose,
    model::{AlphaMode, LightKind, Material, Mesh, ShadingModel, TextureRef},
    scene::Scene,
};

mod animator;
mod deform;
mod pose;
mod storage;

pub use animator::Animator;
pub(crate) use deform::for_each_vertex_at_rest;
pub(crate) use pose::camera_pose;
pub use storage::{
    Look, MIRRORED, NO_TEXTURE, OPAQUE, SINGLE_SIDED, SLOT, StaticCounts, TINTED, TriangleOpacity,
};

/// Which side of a triangle is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSide {
    /// Its vertices run counter-clockwise.
    Front,
    /// They run clockwise.
    Back,
}

/// A thing with an identity: one primitive of one instance, or one particle quad.
#[derive(Clone, Debug)]
pub struct Object {
    /// As `InstanceID()` of STD Listing 4; stable over time.
    pub id: u32,
    /// As `GeometryIndex()` of STD Listing 4.
    pub geometry: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// Index of its first triangle in [`Frame::triangles`].
    pub first_triangle: u32,
    look: Look,
}

/// A light at the time of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameLight {
    /// Position in world; without meaning for directional lights.
    pub position: Vec3,
    /// Unit direction in which it shines.
    pub direction: Vec3,
    /// As in [`crate::model::Light::intensity`].
    pub intensity: Vec3,
    /// Its shape.
    pub kind: LightKind,
}

/// Everything shading needs to know of a point on a surface. Colours are linear.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Point in world.
    pub position: Vec3,
    /// Where this point of the surface was in the previous frame, world.
    pub previous_position: Vec3,
    /// Unit normal of the triangle, towards the viewer.
    pub geometric_normal: Vec3,
    /// Unit normal for shading, towards the viewer's side; of a fibre its direction.
    pub normal: Vec3,
    /// Which side is seen.
    pub side: FaceSide,
    /// Reflectance, or radiance if unlit.
    pub base_colour: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Emitted radiance.
    pub emissive: Vec3,
    /// Share of environment light that arrives, 0 to 1.
    pub occlusion: f32,
    /// How light meets it.
    pub model: ShadingModel,
}

/// The geometry of one moment.
#[derive(Clone, Debug)]
pub struct Frame {
    scene: Arc<Scene>,
    time_secs: f32,
    camera: CameraPose,
    previous_camera: CameraPose,
    static_counts: StaticCounts,
    triangles: Vec<[Vec3; 3]>,
    /// Of the triangles that are not static.
    previous_moving: Vec<[Vec3; 3]>,
    triangle_object: Vec<u32>,
    objects: Vec<Object>,
    /// A triangle's flags, and its index into `opacities` unless it is opaque.
    opacity_slot: Vec<u32>,
    opacities: Vec<TriangleOpacity>,
    deformed_normals: Vec<Vec3>,
    lights: Vec<FrameLight>,
}

impl Frame {
    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Seconds.
    #[must_use]
    pub fn time_secs(&self) -> f32 {
        self.time_secs
    }

    /// The camera now.
    #[must_use]
    pub fn camera(&self) -> &CameraPose {
        &self.camera
    }

    /// The camera in the previous frame.
    #[must_use]
    pub fn previous_camera(&self) -> &CameraPose {
        &self.previous_camera
    }

    /// All triangles in world space; the first [`Self::static_count`] never move.
    #[must_use]
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }

    /// How many triangles never move.
    #[must_use]
    pub fn static_count(&self) -> usize {
        self.static_counts.triangles
    }

    /// Lights now.
    #[must_use]
    pub fn lights(&self) -> &[FrameLight] {
        &self.lights
    }

    /// The object a triangle belongs to.
    #[must_use]
    pub fn object(&self, triangle: u32) -> &Object {
        &self.objects[self.triangle_object[triangle as usize] as usize]
    }

    /// Index of a triangle within its object, as `PrimitiveIndex()`.
    #[must_use]
    pub fn primitive(&self, triangle: u32) -> u32 {
        triangle - self.object(triangle).first_triangle
    }

    /// Corners of a triangle in the space of its object, where they never move: those of the mesh, not skinned or morphed, or of a square
    /// of side 1 for a particle.
    #[must_use]
    pub fn corners_in_object(&self, triangle: u32) -> [Vec3; 3] {
        let object = self.object(triangle);
        let primitive = (triangle - object.first_triangle) as usize;
        match object.look {
            Look::Quad { .. } => QUAD_UVS[primitive & 1].map(|corner| corner.extend(0.0)),
            Look::Rigid { mesh, .. } | Look::Deformed { mesh, .. } => {
                let mesh = &self.scene.parts().meshes[mesh as usize];
                mesh.indices[primitive].map(|vertex| mesh.positions[vertex as usize])
            }
        }
    }

    /// The side of a triangle that a ray meets which sees its vertices counter-clockwise (or not): mirrored objects are turned around.
    #[must_use]
    pub fn side(&self, triangle: u32, counter_clockwise: bool) -> FaceSide {
        let mirrored = self.opacity_slot[triangle as usize] & MIRRORED != 0;
        if counter_clockwise != mirrored { FaceSide::Front } else { FaceSide::Back }
    }

    /// Whether the triangle is opaque all over.
    #[must_use]
    pub fn is_opaque(&self, triangle: u32) -> bool {
        self.opacity_slot[triangle as usize] & OPAQUE != 0
    }

    /// Opacity of a point of a triangle, 0 to 1: OPAQUE materials 1, MASK materials 0 or 1, BLEND materials their alpha.
    /// `u` and `v` are the barycentric weights of the second and third vertex.
    #[must_use]
    #[inline]
    pub fn opacity(&self, triangle: u32, u: f32, v: f32) -> f32 {
        let slot = self.opacity_slot[triangle as usize];
        if slot & OPAQUE != 0 { 1.0 } else { self.table_opacity(slot, u, v) }
    }

    /// The same for a camera ray: the back of a single-sided surface is not there.
    #[must_use]
    #[inline]
    pub fn opacity_for_camera(&self, triangle: u32, u: f32, v: f32, counter_clockwise: bool) -> f32 {
        let slot = self.opacity_slot[triangle as usize];
        let front = counter_clockwise != (slot & MIRRORED != 0);
        if slot & SINGLE_SIDED != 0 && !front {
            0.0
        } else if slot & OPAQUE != 0 {
            1.0
        } else {
            self.table_opacity(slot, u, v)
        }
    }

    /// Whether the light that passes a surface somewhere takes its colour.
    #[must_use]
    pub fn tints_light(&self) -> bool {
        self.scene.parts().materials.iter().any(|material| material.transmission > 0.0)
    }

    /// Share of the light, red, green and blue, that passes a point of a triangle whose opacity there is `alpha`.
    ///
    /// `1 - coverage · (1 - tint)` (McGuire and Enderton 2011, section 2), where the tint is the material's transmission times its base
    /// colour, and the coverage is the opacity before the transmission was taken out of it. Where that would be more than the whole, the
    /// transmission is less than the material's (a texture lowers it): all light that passes has the base colour.
    #[must_use]
    pub fn light_through(&self, triangle: u32, u: f32, v: f32, alpha: f32) -> Vec3 {
        if self.opacity_slot[triangle as usize] & TINTED == 0 {
            return Vec3::splat(1.0 - alpha);
        }
        let transmission = self.scene.parts().materials[self.object(triangle).material as usize].transmission;
        let base_colour = self.surface(triangle, u, v, true).base_colour.clamp(Vec3::ZERO, Vec3::ONE);
        let coverage = alpha / (1.0 - transmission);
        if coverage <= 1.0 {
            1.0 - coverage * (1.0 - transmission * base_colour)
        } else {
            (1.0 - alpha) * base_colour
        }
    }

    #[inline]
    fn table_opacity(&self, slot: u32, u: f32, v: f32) -> f32 {
        let entry = &self.opacities[(slot & SLOT) as usize];
        let w = 1.0 - u - v;
        // From the first vertex on, not as a weighted sum: three equal alphas give exactly theirs, so that 1 stays opaque.
        let [first, second, third] = entry.alpha;
        let mut alpha = first + u * (second - first) + v * (third - first);
        if entry.texture != NO_TEXTURE {
            let uv = w * entry.uv[0] + u * entry.uv[1] + v * entry.uv[2];
            alpha *= self.scene.samplers()[entry.texture as usize].sample_alpha(uv);
        }
        if entry.cutoff >= 0.0 {
            alpha = f32::from(alpha >= entry.cutoff);
        }
        (alpha * entry.opacity).clamp(0.0, 1.0)
    }

    /// Where a point of a triangle is, and where it was in the previous frame, world.
    #[must_use]
    pub fn positions(&self, triangle: u32, u: f32, v: f32) -> [Vec3; 2] {
        let weights = [1.0 - u - v, u, v];
        let position = mix(weights, self.triangles[triangle as usize]);
        let previous = (triangle as usize).checked_sub(self.static_counts.triangles);
        [position, previous.map_or(position, |moving| mix(weights, self.previous_moving[moving]))]
    }

    /// The surface at a point of a triangle, seen by a ray that finds its vertices counter-clockwise (or not).
    #[must_use]
    pub fn surface(&self, triangle: u32, u: f32, v: f32, counter_clockwise: bool) -> Surface {
        let weights = [1.0 - u - v, u, v];
        let corners = self.triangles[triangle as usize];
        let [position, previous_position] = self.positions(triangle, u, v);
        let object = self.object(triangle);
        let material = &self.scene.parts().materials[object.material as usize];
        let side = self.side(triangle, counter_clockwise);
        let winding_normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let geometric_normal = if counter_clockwise { winding_normal } else { -winding_normal };
        // The outward normal is that of the front side.
        let outward = if side == FaceSide::Front { geometric_normal } else { -geometric_normal };
        let attributes = self.attributes(object, triangle, weights, corners, outward);

        let mut surface = Surface {
            position,
            previous_position,
            geometric_normal,
            normal: attributes.normal,
            side,
            base_colour: material.base_colour.truncate() * attributes.tint,
            metallic: material.metallic,
            roughness: material.roughness,
            emissive: material.emissive,
            occlusion: 1.0,
            model: material.model,
        };
        self.apply_textures(material, &attributes, &mut surface);
        if side == FaceSide::Back && !matches!(surface.model, ShadingModel::Smoke | ShadingModel::Fibre) {
            surface.normal = -surface.normal;
        }
        surface
    }

    /// Interpolated vertex attributes.
    fn attributes(
        &self,
        object: &Object,
        triangle: u32,
        weights: [f32; 3],
        corners: [Vec3; 3],
        outward: Vec3,
    ) -> Attributes<'_> {
        let primitive = (triangle - object.first_triangle) as usize;
        let mesh_of = |mesh: u32| {
            let mesh = &self.scene.parts().meshes[mesh as usize];
            (mesh, mesh.indices[primitive].map(|index| index as usize))
        };
        match &object.look {
            Look::Quad { right, up, tile_origin, tile_size, tint } => {
                let local_corners = QUAD_UVS[primitive & 1];
                let uvs = local_corners.map(|local| *tile_origin + local * *tile_size);
                // A sphere inscribed in the quad; the corners outside it look sideways.
                let disc = mix(weights, local_corners) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
                let height = (1.0 - disc.length_squared()).max(0.05).sqrt();
                let normal = (*right * disc.x + *up * disc.y + right.cross(*up) * height).normalize();
                Attributes { weights, corners, normal, tangent: None, tint: *tint, uvs: CornerUvs::Quad(uvs) }
            }
            Look::Rigid { mesh, normal_from_object, vector_from_object } => {
                let (mesh, vertices) = mesh_of(*mesh);
                let normal = gather(&mesh.normals, vertices)
                    .map(|normals| *normal_from_object * mix(weights, normals));
                let tangent = gather(&mesh.tangents, vertices).map(|tangents| {
                    let tangent = mix(weights, tangents);
                    (*vector_from_object * tangent.xyz()).extend(tangent.w)
                });
                self.mesh_attributes(mesh, vertices, weights, corners, normal.unwrap_or(outward), tangent)
            }
            Look::Deformed { mesh, first_normal } => {
                let (mesh, vertices) = mesh_of(*mesh);
                let normal = first_normal.map(|first| {
                    mix(weights, vertices.map(|vertex| self.deformed_normals[first as usize + vertex]))
                });
                self.mesh_attributes(mesh, vertices, weights, corners, normal.unwrap_or(outward), None)
            }
        }
    }

    fn mesh_attributes<'a>(
        &'a self,
        mesh: &'a Mesh,
        vertices: [usize; 3],
        weights: [f32; 3],
        corners: [Vec3; 3],
        normal: Vec3,
        tangent: Option<Vec4>,
    ) -> Attributes<'a> {
        let tint =
            gather(&mesh.colours, vertices).map_or(Vec3::ONE, |colours| mix(weights, colours).truncate());
        let normal = normal.normalize_or(Vec3::Y);
        Attributes { weights, corners, normal, tangent, tint, uvs: CornerUvs::Mesh { mesh, vertices } }
    }

    /// Multiplies textures into the surface and bends its normal.
    fn apply_textures(&self, material: &Material, attributes: &Attributes<'_>, surface: &mut Surface) {
        let sample = |used: &TextureRef| {
            let uv = mix(attributes.weights, attributes.uvs.of(used));
            self.scene.samplers()[used.texture as usize].sample(uv)
        };
        if let Some(used) = &material.base_colour_texture {
            surface.base_colour *= sample(used).truncate();
        }
        if let Some(used) = &material.metallic_roughness_texture {
            let texel = sample(used);
            surface.roughness *= texel.y;
            surface.metallic *= texel.z;
        }
        if let Some(used) = &material.emissive_texture {
            surface.emissive *= sample(used).truncate();
        }
        if let Some(used) = &material.occlusion_texture {
            surface.occlusion = 1.0 + material.occlusion_strength * (sample(used).x - 1.0);
        }
        if let Some(used) = &material.normal_texture {
            let texel = sample(used).truncate() * 2.0 - Vec3::ONE;
            let bent = texel * Vec3::new(material.normal_scale, material.normal_scale, 1.0);
            surface.normal = attributes.bend(used, bent);
        }
    }
}

/// Corners of a particle quad's two triangles in its tile, lower left first: they run counter-clockwise seen from the camera.
const QUAD_UVS: [[Vec2; 3]; 2] = [[Vec2::Y, Vec2::ONE, Vec2::X], [Vec2::Y, Vec2::X, Vec2::ZERO]];

/// Vertex attributes at a point of a triangle.
struct Attributes<'a> {
    weights: [f32; 3],
    corners: [Vec3; 3],
    /// Unit, outward.
    normal: Vec3,
    /// World, with the bitangent's sign in w.
    tangent: Option<Vec4>,
    tint: Vec3,
    uvs: CornerUvs<'a>,
}

/// Texture coordinates of a triangle's corners.
enum CornerUvs<'a> {
    Quad([Vec2; 3]),
    Mesh { mesh: &'a Mesh, vertices: [usize; 3] },
}

impl CornerUvs<'_> {
    fn of(&self, used: &TextureRef) -> [Vec2; 3] {
        let raw = match self {
            Self::Quad(uvs) => *uvs,
            Self::Mesh { mesh, vertices } => corner_uvs(mesh, *vertices, used.uv_set),
        };
        raw.map(|uv| used.transform.transform_point2(uv))
    }
}

impl Attributes<'_> {
    /// A tangent-space normal in world. Without a given tangent it follows the texture's u axis across the triangle.
    fn bend(&self, used: &TextureRef, in_tangent: Vec3) -> Vec3 {
        let (tangent, bitangent_sign) = match self.tangent {
            Some(tangent) => (tangent.truncate(), tangent.w),
            None => {
                let [a, b, c] = self.corners;
                let [uv_a, uv_b, uv_c] = self.uvs.of(used);
                let (to_b, to_c) = (uv_b - uv_a, uv_c - uv_a);
                let area = to_b.perp_dot(to_c);
                (((b - a) * to_c.y - (c - a) * to_b.y) * area.signum(), self.handedness(area))
            }
        };
        let tangent = (tangent - self.normal * self.normal.dot(tangent)).normalize_or_zero();
        if tangent == Vec3::ZERO {
            return self.normal;
        }
        let bitangent = self.normal.cross(tangent) * bitangent_sign;
        (tangent * in_tangent.x + bitangent * in_tangent.y + self.normal * in_tangent.z)
            .normalize_or(self.normal)
    }

    /// Sign of `normal × tangent` against the direction in which the image's v falls: up in the image is +Y of a normal map.
    fn handedness(&self, uv_area: f32) -> f32 {
        let winding = (self.corners[1] - self.corners[0]).cross(self.corners[2] - self.corners[0]);
        -(uv_area.signum() * winding.dot(self.normal).signum())
    }
}

fn corner_uvs(mesh: &Mesh, vertices: [usize; 3], uv_set: u32) -> [Vec2; 3] {
    mesh.uv_sets.get(uv_set as usize).map_or([Vec2::ZERO; 3], |set| vertices.map(|vertex| set[vertex]))
}

fn gather<T: Copy>(list: &[T], vertices: [usize; 3]) -> Option<[T; 3]> {
    (!list.is_empty()).then(|| vertices.map(|vertex| list[vertex]))
}

fn mix<T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(
    weights: [f32; 3],
    [a, b, c]: [T; 3],
) -> T {
    a * weights[0] + b * weights[1] + c * weights[2]
}

impl TriangleOpacity {
    fn new(material: &Material, vertex_alpha: [f32; 3], uvs: impl Fn(&TextureRef) -> [Vec2; 3]) -> Self {
        let opaque = material.alpha_mode == AlphaMode::Opaque;
        let texture = material.base_colour_texture.filter(|_| !opaque);
        let uv =
            texture.map_or([Vec2::ZERO; 3], |used| uvs(&used).map(|uv| used.transform.transform_point2(uv)));
        Self {
            uv,
            alpha: if opaque { [1.0; 3] } else { vertex_alpha.map(|alpha| alpha * material.base_colour.w) },
            texture: texture.map_or(NO_TEXTURE, |used| used.texture),
            cutoff: if let AlphaMode::Mask { cutoff } = material.alpha_mode { cutoff.max(0.0) } else { -1.0 },
            opacity: material.opacity,
        }
    }
}

//! Surfaces: what shading needs of a point of a triangle, interpolated from its vertices and looked up in its
//! textures.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use super::{
    FaceSide, Frame, Object,
    attribute::{QUAD_UVS, VertexLists, gather, mix},
    footprint::{Ellipse, evening_power, texel_density},
    storage::{Look, OPAQUE, TINTED},
};
use crate::{
    model::{Material, Mesh, ShadingModel, TextureRef},
    texture::Footprint,
};

/// A ray and how wide it is where it meets a surface: what textures are looked up with.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Unit direction, world.
    pub direction: Vec3,
    /// Across it, world units; 0 looks at the textures' texels themselves.
    pub width: f32,
}

/// Light that a surface lets through in its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmitted {
    /// Share of the light that meets the surface, before it is filtered: 0 to 1.
    pub share: f32,
    /// What is left of that in red, green and blue, linear: the base colour, and what the body behind the
    /// surface absorbs. 0 to 1.
    pub filter: Vec3,
}

/// Everything shading needs to know of a point on a surface. Colours are linear.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The point, world.
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
    /// Perceptual roughness, 0 (a mirror) to 1.
    pub roughness: f32,
    /// Radiance that it emits by itself, linear.
    pub emissive: Vec3,
    /// Share of environment light that arrives, 0 to 1.
    pub occlusion: f32,
    /// How light meets it.
    pub model: ShadingModel,
}

impl Frame {
    /// The surface at a point of a triangle, seen by a beam that finds its vertices counter-clockwise (or
    /// not).
    #[must_use]
    pub fn surface(&self, triangle: u32, u: f32, v: f32, counter_clockwise: bool, beam: Beam) -> Surface {
        let weights = [1.0 - u - v, u, v];
        let corners = self.corners(triangle);
        let [position, previous_position] = self.positions(triangle, u, v);
        let object = self.object(triangle);
        let material = &self.materials()[object.material as usize];
        let side = self.side(triangle, counter_clockwise);
        let (to_b, to_c) = (corners[1] - corners[0], corners[2] - corners[0]);
        let power = evening_power(to_b, to_c);
        let winding_normal = (to_b * power).cross(to_c * power).normalize_or_zero();
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
        self.apply_textures(material, &attributes, beam, &mut surface);
        if side == FaceSide::Back && !matches!(surface.model, ShadingModel::Smoke | ShadingModel::Fibre) {
            surface.normal = -surface.normal;
        }
        surface
    }

    /// Share of the light, red, green and blue, that passes a point of a triangle whose opacity there is
    /// `alpha`, in a beam of a width, world units, that finds its vertices counter-clockwise (or not).
    ///
    /// `1 - coverage · (1 - tint)` (McGuire and Enderton 2011, section 2): see [`Self::transmitted`].
    #[must_use]
    pub fn light_through(
        &self,
        triangle: u32,
        u: f32,
        v: f32,
        counter_clockwise: bool,
        alpha: f32,
        width: f32,
    ) -> Vec3 {
        let unfiltered = Vec3::splat(1.0 - alpha);
        self.transmitted(triangle, u, v, counter_clockwise, alpha, width)
            .map_or(unfiltered, |Transmitted { share, filter }| unfiltered - share * (Vec3::ONE - filter))
    }

    /// The light that a point of a triangle transmits in its colour; none if it has no transmission. The
    /// rest of what passes its opacity `alpha` keeps its own.
    ///
    /// The coverage of the surface is its opacity before the transmission was taken out of it. Where that
    /// would be more than the whole, the transmission is less than the material's (a texture lowers it): all
    /// light that passes is transmitted.
    #[must_use]
    pub fn transmitted(
        &self,
        triangle: u32,
        u: f32,
        v: f32,
        counter_clockwise: bool,
        alpha: f32,
        width: f32,
    ) -> Option<Transmitted> {
        let flags = self.flags(triangle);
        if flags & TINTED == 0 || flags & OPAQUE != 0 {
            return None;
        }
        let weights = [1.0 - u - v, u, v];
        let corners = self.corners(triangle);
        let object = self.object(triangle);
        let material = &self.materials()[object.material as usize];
        let attributes = self.attributes(object, triangle, weights, corners, Vec3::Y);
        // In a beam that meets the surface head on.
        let sample = |used: &TextureRef| {
            let uvs = attributes.uvs.of(used);
            let sampler = &self.scene.samplers()[used.texture as usize];
            let footprint = Footprint::round(width * texel_density(&corners, &uvs, sampler.size()));
            sampler.sample(mix(weights, uvs), &footprint)
        };

        let mut filter = material.base_colour.truncate() * attributes.tint;
        if let Some(used) = &material.base_colour_texture {
            filter *= sample(used).truncate();
        }
        filter = filter.clamp(Vec3::ZERO, Vec3::ONE);
        // A ray meets the front of a closed body once on its way through, whatever its direction: so the
        // whole thickness counts there, and nothing is counted twice.
        let has_body = material.thickness > 0.0 && material.absorption != Vec3::ZERO;
        if has_body && self.side(triangle, counter_clockwise) == FaceSide::Front {
            let factor = material.thickness_texture.as_ref().map_or(1.0, |used| sample(used).y);
            let thickness = material.thickness * object.look.scale() * factor;
            filter *= (-material.absorption * thickness).exp();
        }
        let transmission = material.transmission;
        let share = (alpha * (transmission / (1.0 - transmission))).min(1.0 - alpha);
        Some(Transmitted { share, filter })
    }

    /// The vertex attributes of a mesh or of a quad, interpolated.
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
                let lists = VertexLists::new(mesh, None);
                mesh_attributes(lists, vertices, weights, corners, normal.unwrap_or(outward), tangent)
            }
            look @ Look::Deformed { mesh, first_normal, .. } => {
                let (mesh, vertices) = mesh_of(*mesh);
                let vectors =
                    |first: usize| mix(weights, vertices.map(|vertex| self.deformed_normals[first + vertex]));
                let normal = first_normal.map(|first| vectors(first as usize));
                let tangent = first_normal.zip(gather(&mesh.tangents, vertices)).map(|(first, tangents)| {
                    let sign = mix(weights, tangents).w;
                    vectors(first as usize + mesh.positions.len()).extend(sign)
                });
                let lists = self.vertex_lists(look, mesh);
                mesh_attributes(lists, vertices, weights, corners, normal.unwrap_or(outward), tangent)
            }
        }
    }

    /// Colours and texture coordinates of the vertices of an object that shows a mesh.
    pub(super) fn vertex_lists<'a>(&'a self, look: &Look, mesh: &'a Mesh) -> VertexLists<'a> {
        let morphed = match look {
            Look::Deformed { attributes: Some(index), .. } => Some(&self.morphed_attributes[*index as usize]),
            _ => None,
        };
        VertexLists::new(mesh, morphed)
    }

    /// Multiplies textures into the surface and bends its normal.
    fn apply_textures(
        &self,
        material: &Material,
        attributes: &Attributes<'_>,
        beam: Beam,
        surface: &mut Surface,
    ) {
        let mut ellipse = None;
        let mut sample = |used: &TextureRef| {
            let uvs = attributes.uvs.of(used);
            let sampler = &self.scene.samplers()[used.texture as usize];
            let ellipse =
                ellipse.get_or_insert_with(|| Ellipse::new(&attributes.corners, beam.direction, beam.width));
            sampler.sample(mix(attributes.weights, uvs), &ellipse.footprint(&uvs, sampler.size()))
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

fn mesh_attributes(
    lists: VertexLists<'_>,
    vertices: [usize; 3],
    weights: [f32; 3],
    corners: [Vec3; 3],
    normal: Vec3,
    tangent: Option<Vec4>,
) -> Attributes<'_> {
    let tint = gather(lists.colours, vertices).map_or(Vec3::ONE, |colours| mix(weights, colours).truncate());
    let normal = normal.normalize_or(Vec3::Y);
    Attributes { weights, corners, normal, tangent, tint, uvs: CornerUvs::Mesh { lists, vertices } }
}

/// Vertex attributes at a point of a triangle.
struct Attributes<'a> {
    weights: [f32; 3],
    corners: [Vec3; 3],
    /// Unit normal of the front side.
    normal: Vec3,
    /// World, with the bitangent's sign in w.
    tangent: Option<Vec4>,
    tint: Vec3,
    uvs: CornerUvs<'a>,
}

/// Texture coordinates of a triangle's corners.
enum CornerUvs<'a> {
    Quad([Vec2; 3]),
    Mesh { lists: VertexLists<'a>, vertices: [usize; 3] },
}

impl CornerUvs<'_> {
    fn of(&self, used: &TextureRef) -> [Vec2; 3] {
        let raw = match self {
            Self::Quad(uvs) => *uvs,
            Self::Mesh { lists, vertices } => lists.corner_uvs(*vertices, used.uv_set),
        };
        raw.map(|uv| used.transform.transform_point2(uv))
    }
}

impl Attributes<'_> {
    /// A tangent-space normal in world. Without a given tangent it follows the texture's u axis across the
    /// triangle.
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

    /// Sign of `normal × tangent` against the direction in which the image's v falls: up in the image is +Y
    /// of a normal map.
    fn handedness(&self, uv_area: f32) -> f32 {
        let winding = (self.corners[1] - self.corners[0]).cross(self.corners[2] - self.corners[0]);
        -(uv_area.signum() * winding.dot(self.normal).signum())
    }
}

//! The parts a scene is made of: plain data that loaders and programs fill in and
//! [`Scene::new`](crate::Scene::new) validates once.
//!
//! Spaces: `object` is a mesh's own, `world` is right-handed with +Y up, metres. A camera and a spot or
//! directional light look along their node's -Z (glTF 2.0). Texture coordinates have their origin in the
//! upper left corner. All colour factors are linear Rec. 709.

use std::sync::Arc;

use glam::{Affine2, Affine3A, Quat, Vec2, Vec3, Vec4};
use sheer_image::Image;

use crate::{camera::Camera, environment::Environment, particle::ParticleSystem};

/// Everything a scene consists of, not yet validated.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Name for reports: the built-in's name or the file's stem.
    pub name: String,
    /// Transform hierarchy; a parent stands before its children.
    pub nodes: Vec<Node>,
    /// Geometry, one glTF primitive each.
    pub meshes: Vec<Mesh>,
    /// Which mesh is drawn where.
    pub instances: Vec<Instance>,
    /// Joint sets for skinned instances.
    pub skins: Vec<Skin>,
    /// Materials that meshes and particle systems refer to.
    pub materials: Vec<Material>,
    /// Textures that materials refer to.
    pub textures: Vec<Texture>,
    /// Animations that all play at once, each looping by its own duration.
    pub animations: Vec<Animation>,
    /// Systems of particles, each drawn as a quad that faces the camera.
    pub particles: Vec<ParticleSystem>,
    /// Punctual lights; that of the surroundings is theirs.
    pub lights: Vec<Light>,
    /// Light from far away, and what a ray that leaves the scene sees.
    pub environment: Environment,
    /// Cameras; the first is the default.
    pub cameras: Vec<Camera>,
    /// Multiplies all radiance before the tone curve; 1 shows radiance 1 as display white.
    pub exposure: f32,
}

/// One transform of the hierarchy.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// Name for messages; may be empty.
    pub name: String,
    /// Index of the parent, which is smaller than this node's own.
    pub parent: Option<u32>,
    /// `parent_from_node` while no animation moves it.
    pub transform: Transform,
}

/// Where a node is in the space of its parent.
#[derive(Clone, Copy, Debug)]
pub enum Transform {
    /// Scale, then rotation, then translation; the only form that can be animated.
    Trs {
        /// Offset in the parent's space.
        translation: Vec3,
        /// A unit quaternion.
        rotation: Quat,
        /// Factors, negative ones mirror.
        scale: Vec3,
    },
    /// An affine map, which need not be made of scale, rotation and translation.
    Matrix(Affine3A),
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// Leaves a node where its parent is.
    pub const IDENTITY: Self =
        Self::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    /// A translation without rotation or scale.
    #[must_use]
    pub fn from_translation(translation: Vec3) -> Self {
        Self::Trs { translation, rotation: Quat::IDENTITY, scale: Vec3::ONE }
    }

    /// The transform as an affine map, `parent_from_node`.
    #[must_use]
    pub fn to_affine(self) -> Affine3A {
        match self {
            Self::Trs { translation, rotation, scale } => {
                Affine3A::from_scale_rotation_translation(scale, rotation, translation)
            }
            Self::Matrix(affine) => affine,
        }
    }
}

/// Triangles with their vertex attributes in object space. Empty attribute lists mean "none".
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name for messages.
    pub name: String,
    /// Index into [`SceneParts::materials`].
    pub material: u32,
    /// Positions of the vertices in object space.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals; none: flat shading.
    pub normals: Vec<Vec3>,
    /// Unit tangents with the bitangent's sign in w (glTF), where there are normals; none: derived from the
    /// texture coordinates where a normal map needs them.
    pub tangents: Vec<Vec4>,
    /// Texture coordinate sets, `TEXCOORD_0` first, each as long as `positions`.
    pub uv_sets: Vec<Vec<Vec2>>,
    /// Linear straight RGBA that multiplies the base colour.
    pub colours: Vec<Vec4>,
    /// Vertex indices, three a triangle, counter-clockwise seen from the front.
    pub indices: Vec<[u32; 3]>,
    /// Joint influences of each vertex, flattened: `influences_per_vertex` entries a vertex. Weights sum to
    /// one.
    pub influences: Vec<Influence>,
    /// 0 (not skinned), 4, 8, …
    pub influences_per_vertex: usize,
    /// Displacements of vertex attributes to blend in by morph weight.
    pub morph_targets: Vec<MorphTarget>,
}

/// The pull of one joint on one vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influence {
    /// Index into [`Skin::joints`].
    pub joint: u16,
    /// Share of the joint in the motion of the vertex, 0 to 1.
    pub weight: f32,
}

/// Displacements of a mesh's vertices; empty lists do not displace.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    /// Added to positions, times the weight.
    pub positions: Vec<Vec3>,
    /// Added to normals, times the weight.
    pub normals: Vec<Vec3>,
    /// Added to the directions of tangents, times the weight; none if the mesh has no tangents.
    pub tangents: Vec<Vec3>,
    /// Added to colours, times the weight; the sum is clamped to where colours may be.
    pub colours: Vec<Vec4>,
    /// Added to the texture coordinate sets, times the weight; at most as many sets as the mesh has.
    pub uv_sets: Vec<Vec<Vec2>>,
}

/// A mesh drawn at a node; by default the first at the first.
#[derive(Clone, Debug, Default)]
pub struct Instance {
    /// Where: index into [`SceneParts::nodes`].
    pub node: u32,
    /// A further transform below the node (`EXT_mesh_gpu_instancing`); identity otherwise.
    pub node_from_object: Affine3A,
    /// What: index into [`SceneParts::meshes`].
    pub mesh: u32,
    /// Object id, as `InstanceID()` of STD Listing 4; primitives of one glTF mesh at one node share it.
    pub id: u32,
    /// Which primitive of the glTF mesh, as `GeometryIndex()` of STD Listing 4.
    pub geometry: u32,
    /// Index into [`SceneParts::skins`]; a skinned instance ignores its own node's transform (glTF 2.0,
    /// 3.7.3.3).
    pub skin: Option<u32>,
    /// Morph weights at rest, one a morph target of the mesh (animation channels of `node` override them).
    pub morph_weights: Vec<f32>,
}

/// Joints of a skeleton.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Name for messages.
    pub name: String,
    /// Indices of the nodes that are the joints.
    pub joints: Vec<u32>,
    /// `joint_from_object` in the bind pose, one a joint.
    pub inverse_bind: Vec<Affine3A>,
}

/// How light meets a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShadingModel {
    /// glTF metallic-roughness (glTF 2.0, appendix B).
    #[default]
    MetallicRoughness,
    /// The base colour is what is seen (`KHR_materials_unlit`): display-referred, so that no tone curve
    /// applies to it in pictures for a display.
    Unlit,
    /// A puff of smoke: light wraps around a sphere inscribed in the quad and shines through it.
    Smoke,
    /// A thin fibre, of hair or grass: what stands in the place of vertex normals is the direction it runs
    /// in, and light meets it from all around.
    Fibre,
    /// The base colour is the radiance: a flame, a screen, a surface of known light.
    Luminous,
}

/// What the alpha of a surface means (glTF 2.0, 3.9.4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored: the surface is opaque.
    #[default]
    Opaque,
    /// Opaque where alpha is at least the cutoff, else not there: an alpha test, never blended.
    Mask {
        /// The least alpha that counts as opaque, 0 to 1.
        cutoff: f32,
    },
    /// Alpha is the opacity of the surface.
    Blend,
}

/// What a surface looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name for messages.
    pub name: String,
    /// How light meets it.
    pub model: ShadingModel,
    /// Linear factor on colour and alpha, not multiplied.
    pub base_colour: Vec4,
    /// sRGB colour texture with straight alpha.
    pub base_colour_texture: Option<TextureRef>,
    /// What is made of alpha.
    pub alpha_mode: AlphaMode,
    /// Multiplies the opacity after the alpha mode has had its say; 1 unless overridden for the whole scene.
    pub opacity: f32,
    /// Share of the light that meets the surface and shines through it in its base colour, below 1; the
    /// opacity is what is left when that share is taken out. It colours what is seen through the surface and
    /// the shadows that it casts ([`crate::Frame::light_through`]); 0 leaves grey what the opacity leaves.
    pub transmission: f32,
    /// Thickness of the body that lies under the front of the surface, in the units of its mesh; 0 for a
    /// surface without one.
    pub thickness: f32,
    /// Linear texture: a factor on the thickness in green.
    pub thickness_texture: Option<TextureRef>,
    /// What the body takes of the light that is transmitted, red, green and blue: after a world unit of its
    /// thickness `exp(-absorption)` is left (Beer and Lambert). At least 0.
    pub absorption: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f32,
    /// Linear texture: roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Linear texture of normals in tangent space, +Y up in the image.
    pub normal_texture: Option<TextureRef>,
    /// Scales the x and y of the normal texture.
    pub normal_scale: f32,
    /// Linear texture: occlusion of environment light in red.
    pub occlusion_texture: Option<TextureRef>,
    /// 0 ignores the occlusion texture, 1 takes it whole.
    pub occlusion_strength: f32,
    /// Emitted radiance (with `KHR_materials_emissive_strength` multiplied in).
    pub emissive: Vec3,
    /// sRGB texture that multiplies `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// Back faces are seen too. Single-sided back faces are not there for camera rays.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            model: ShadingModel::MetallicRoughness,
            base_colour: Vec4::ONE,
            base_colour_texture: None,
            alpha_mode: AlphaMode::Opaque,
            opacity: 1.0,
            transmission: 0.0,
            thickness: 0.0,
            thickness_texture: None,
            absorption: Vec3::ZERO,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            double_sided: false,
        }
    }
}

/// A material's use of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`SceneParts::textures`].
    pub texture: u32,
    /// Index into [`Mesh::uv_sets`]; a mesh without that set samples at (0, 0).
    pub uv_set: u32,
    /// `texture_from_mesh_uv` (`KHR_texture_transform`).
    pub transform: Affine2,
}

impl TextureRef {
    /// A texture used as it is, on the first coordinate set.
    #[must_use]
    pub fn new(texture: u32) -> Self {
        Self { texture, uv_set: 0, transform: Affine2::IDENTITY }
    }

    /// `texture_from_mesh_uv` of an offset, a rotation and a scale (`KHR_texture_transform`), which turns
    /// counter-clockwise in an image whose v points down.
    #[must_use]
    pub fn transform_of(offset: Vec2, rotation_rad: f32, scale: Vec2) -> Affine2 {
        Affine2::from_scale_angle_translation(scale, -rotation_rad, offset)
    }
}

impl Material {
    /// The place for a texture.
    pub fn texture_mut(&mut self, slot: TextureSlot) -> &mut Option<TextureRef> {
        match slot {
            TextureSlot::BaseColour => &mut self.base_colour_texture,
            TextureSlot::MetallicRoughness => &mut self.metallic_roughness_texture,
            TextureSlot::Normal => &mut self.normal_texture,
            TextureSlot::Occlusion => &mut self.occlusion_texture,
            TextureSlot::Emissive => &mut self.emissive_texture,
        }
    }
}

/// Texels and how they are looked up. Two textures may share one image.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Name for messages.
    pub name: String,
    /// Straight RGBA, 8 bits a channel.
    pub image: Arc<Image<[u8; 4]>>,
    /// The RGB channels are sRGB-encoded (alpha never is).
    pub srgb: bool,
    /// Behaviour outside [0, 1] in u and v.
    pub wrap: [Wrap; 2],
    /// How texels are interpolated where a footprint is no larger than a texel.
    pub filter: Filter,
    /// How they are where it is larger.
    pub minification: Minification,
}

/// Texture behaviour outside [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture is tiled.
    #[default]
    Repeat,
    /// The texture is tiled, every second tile mirrored.
    MirroredRepeat,
    /// The texels at the edge go on for ever.
    ClampToEdge,
}

/// How a texture is interpolated between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Filter {
    /// The mean of the four texels around a point, weighted by nearness.
    #[default]
    Linear,
    /// The texel in which the point lies.
    Nearest,
}

/// How a texture is looked up where a pixel sees more than a texel of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Minification {
    /// How texels of a level are interpolated.
    pub filter: Filter,
    /// How levels are.
    pub levels: LevelFilter,
}

/// How the levels of a mip chain are interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LevelFilter {
    /// The mean of the two levels whose texels are next in size to the footprint, weighted by nearness.
    #[default]
    Linear,
    /// The level whose texels are nearest in size.
    Nearest,
    /// There are no levels: the image as it is.
    None,
}

/// A clip of keyframes, which loops.
#[derive(Clone, Debug, Default)]
pub struct Animation {
    /// Name for messages.
    pub name: String,
    /// Tracks and what they move.
    pub channels: Vec<Channel>,
    /// What changes that is no transform and no morph weight.
    pub properties: Vec<Property>,
}

/// One animated property of one node.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Index into [`SceneParts::nodes`]; the node's transform is [`Transform::Trs`].
    pub node: u32,
    /// The property and its keys.
    pub track: Track,
}

/// Keys of an animated property.
#[derive(Clone, Debug)]
pub enum Track {
    /// Replaces the translation of the node.
    Translation(Keys<Vec3>),
    /// Replaces the rotation of the node.
    Rotation(Keys<Quat>),
    /// Replaces the scale of the node.
    Scale(Keys<Vec3>),
    /// Replaces the morph weights of the instances at the node.
    MorphWeights(Keys<Vec<f32>>),
}

/// An animated value of a material, a light, a camera or a node's visibility (`KHR_animation_pointer`). What
/// is made of several values has keys for each, a single one for what stays as it is.
#[derive(Clone, Debug)]
pub enum Property {
    /// Replaces the base colour of a material; its alpha counts as far as the alpha mode says.
    BaseColour {
        /// Index into [`SceneParts::materials`].
        material: u32,
        /// Linear factor on colour and alpha, not multiplied; clamped to where it may be.
        factor: Keys<Vec4>,
    },
    /// Replaces the radiance that a material emits.
    Emissive {
        /// Index into [`SceneParts::materials`].
        material: u32,
        /// Linear colour.
        factor: Keys<Vec3>,
        /// Multiplies it.
        strength: Keys<f32>,
    },
    /// Replaces a number of a material.
    Factor {
        /// Index into [`SceneParts::materials`].
        material: u32,
        /// Which number.
        which: Factor,
        /// Its values; clamped to where they may be.
        value: Keys<f32>,
    },
    /// Replaces how a texture of a material is laid out (`KHR_texture_transform`).
    TextureTransform {
        /// Index into [`SceneParts::materials`].
        material: u32,
        /// Which of its textures.
        slot: TextureSlot,
        /// Texture coordinates of the mesh's origin.
        offset: Keys<Vec2>,
        /// Counter-clockwise around the origin, radians.
        rotation_rad: Keys<f32>,
        /// Factors on the mesh's coordinates.
        scale: Keys<Vec2>,
    },
    /// Replaces the intensity of lights.
    LightIntensity {
        /// Indices into [`SceneParts::lights`].
        lights: Vec<u32>,
        /// Linear colour.
        colour: Keys<Vec3>,
        /// Multiplies it; units as [`Light::intensity`].
        intensity: Keys<f32>,
    },
    /// Replaces the share of the light that a material lets through in its colour.
    Transmission {
        /// Index into [`SceneParts::materials`].
        material: u32,
        /// [`Material::transmission`]; clamped to where it may be.
        share: Keys<f32>,
        /// The share is taken out of the alpha of the base colour, as that at rest has been.
        lowers_alpha: bool,
    },
    /// Replaces a number that shapes the light of lamps.
    LightShape {
        /// Indices into [`SceneParts::lights`].
        lights: Vec<u32>,
        /// Which number.
        which: LightNumber,
        /// Its values; clamped to where they may be.
        value: Keys<f32>,
    },
    /// Replaces a number of cameras that hang on nodes.
    Lens {
        /// Indices into [`SceneParts::cameras`].
        cameras: Vec<u32>,
        /// Which number.
        which: LensNumber,
        /// Its values; clamped to where they may be.
        value: Keys<f32>,
    },
    /// Shows a node and what hangs on it while the value is at least a half.
    Visibility {
        /// Index into [`SceneParts::nodes`].
        node: u32,
        /// 1 shown, 0 hidden.
        visible: Keys<f32>,
    },
}

/// A number of a material that can be animated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// [`AlphaMode::Mask`]'s cutoff.
    AlphaCutoff,
    /// [`Material::metallic`].
    Metallic,
    /// [`Material::roughness`].
    Roughness,
    /// [`Material::normal_scale`].
    NormalScale,
    /// [`Material::occlusion_strength`].
    OcclusionStrength,
}

/// A number of a light that can be animated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightNumber {
    /// Of a point or a spot.
    Range,
    /// Of a spot, radians from the axis.
    InnerCone,
    /// Of a spot, radians from the axis.
    OuterCone,
}

/// A number of a camera that can be animated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LensNumber {
    /// Vertical field of view of a perspective camera, radians.
    FieldOfView,
    /// Half the height of the view of an orthographic camera, world units.
    HalfHeight,
    /// [`ClipPlanes::near`](crate::ClipPlanes::near).
    Near,
    /// [`ClipPlanes::far`](crate::ClipPlanes::far).
    Far,
}

/// A place of a material for a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureSlot {
    /// [`Material::base_colour_texture`].
    BaseColour,
    /// [`Material::metallic_roughness_texture`].
    MetallicRoughness,
    /// [`Material::normal_texture`].
    Normal,
    /// [`Material::occlusion_texture`].
    Occlusion,
    /// [`Material::emissive_texture`].
    Emissive,
}

/// Key times and values.
#[derive(Clone, Debug)]
pub struct Keys<T> {
    /// Seconds, strictly increasing, at least one.
    pub times_secs: Vec<f32>,
    /// One value a time; for cubic splines three: in-tangent, value, out-tangent.
    pub values: Vec<T>,
    /// How to go from key to key.
    pub interpolation: Interpolation,
}

/// Interpolation between keys (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Interpolation {
    /// The value goes straight from key to key; rotations take the great arc.
    #[default]
    Linear,
    /// The value of the last key is held until the next.
    Step,
    /// The value follows a cubic Hermite spline with given tangents.
    CubicSpline,
}

impl LightKind {
    /// The widest that the cone of a spot may be, from its axis, and the narrowest.
    const CONES_RAD: [f32; 2] = [1e-4, std::f32::consts::FRAC_PI_2];

    /// Sets a number, as near as it may be; of a kind that lacks it nothing.
    pub fn set(&mut self, which: LightNumber, value: f32) {
        match (which, self) {
            (LightNumber::Range, Self::Point { range } | Self::Spot { range, .. }) => {
                *range = if value.is_nan() { f32::INFINITY } else { value.max(f32::MIN_POSITIVE) };
            }
            (LightNumber::InnerCone, Self::Spot { inner_cone_rad, .. }) => *inner_cone_rad = value.max(0.0),
            (LightNumber::OuterCone, Self::Spot { outer_cone_rad, .. }) => {
                let [narrowest, widest] = Self::CONES_RAD;
                *outer_cone_rad = value.max(narrowest).min(widest);
            }
            (
                LightNumber::Range | LightNumber::InnerCone | LightNumber::OuterCone,
                Self::Directional | Self::Point { .. },
            ) => {}
        }
    }

    /// The same light, whose inner cone is not wider than the outer one.
    #[must_use]
    pub fn with_nested_cones(self) -> Self {
        match self {
            Self::Spot { range, inner_cone_rad, outer_cone_rad } => {
                Self::Spot { range, inner_cone_rad: inner_cone_rad.min(outer_cone_rad), outer_cone_rad }
            }
            other => other,
        }
    }
}

/// A light with no extent (`KHR_lights_punctual`).
#[derive(Clone, Debug)]
pub struct Light {
    /// Name for messages.
    pub name: String,
    /// Node that says where the light is, and which way it looks: along -Z.
    pub node: u32,
    /// Linear RGB times intensity: illuminance (lux) for directional lights, luminous intensity (candela) for
    /// the others.
    pub intensity: Vec3,
    /// The shape of its light.
    pub kind: LightKind,
}

/// Shapes of punctual lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light from infinitely far away, such as the sun.
    Directional,
    /// A point that shines alike in all directions.
    Point {
        /// Beyond this distance there is no light; infinite if the file does not say.
        range: f32,
    },
    /// A point that shines into a cone around -Z.
    Spot {
        /// Beyond this distance there is no light.
        range: f32,
        /// Full intensity inside, radians from the axis.
        inner_cone_rad: f32,
        /// None outside, radians from the axis.
        outer_cone_rad: f32,
    },
}

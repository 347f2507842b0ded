//! glTF 2.0 files, `.gltf` and `.glb`.
//!
//! The JSON is read with this module's own [`schema`], because files in practice hold what stricter readers
//! refuse: buffers without data behind a compression extension, sparse accessors without a view, required
//! extensions newer than any list.
//!
//! **Trust.** A file is input from a stranger. Only files below its own folder, or one that the caller
//! allows, are opened. Every index, offset and length is checked where it is used, and recursion is avoided
//! where a file chooses the depth. What one file may take: the JSON costs at most about 200 times its size;
//! everything decoded from buffers together at most [`limits::BASE_BYTES`] plus
//! [`limits::BYTES_PER_INPUT_BYTE`] times the bytes read; images at most [`limits::IMAGE_BYTES`] together;
//! and at most [`limits::MAX_STORED_TRIANGLES`] triangles are held by a frame. Where there is a
//! [limit](LoadOptions::memory_limit), all of it is counted first ([`estimate`]) and held against that. Names
//! are cut, and what messages quote of a file is cut and escaped.

use std::path::Path;

use sheer_core::text::quoted;
use sheer_scene::{FrameSize, Scene, level_bytes, model::SceneParts};

use crate::{
    Clip, Contents, Extension, LoadError, LoadOptions, LoadWarning, Loaded, error::invalid_part, stroke,
};

mod accessor;
mod animation;
mod bake;
mod choice;
mod document;
#[cfg(feature = "draco")]
mod draco;
#[cfg(feature = "draco")]
mod draco_walk;
mod estimate;
mod image;
mod json_size;
#[cfg(feature = "ktx2")]
mod ktx2;
mod lenient;
mod limits;
mod material;
mod mesh;
mod meshopt;
mod node;
mod pointer;
mod resource;
mod schema;
mod texels;
mod topology;

use document::Document;
use limits::{MAX_DRAWN_TRIANGLES, MAX_STORED_TRIANGLES};
pub(super) use resource::{path_beside, read_beside, read_file, spelt_otherwise};

/// Extensions that are drawn as they say.
const DRAWN: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    #[cfg(feature = "draco")]
    "KHR_draco_mesh_compression",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    // Warned about where it is used: nothing refracts.
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    // What it absorbs, where there is transmission.
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    #[cfg(feature = "ktx2")]
    "KHR_texture_basisu",
    "KHR_texture_transform",
    // Metadata: there is nothing to see.
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Extensions whose absence changes the look but not the sense of a file, so that a file may even require
/// them.
const IGNORED: &[&str] = &[
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
];

/// Whether a file that begins with these bytes can be glTF: a container, or an object of JSON.
pub(super) fn begins_like_gltf(bytes: &[u8]) -> bool {
    resource::is_container(bytes) || bytes.trim_ascii_start().starts_with(b"{")
}

/// Loads the bytes of a file that lies, or could lie, at `path`.
pub(super) fn load_slice(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let document = Document::parse(bytes, path, options)?;
    check_extensions(&document)?;

    let mut parts = SceneParts {
        name: path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        exposure: 1.0,
        ..SceneParts::default()
    };
    let hierarchy = node::Hierarchy::build(&document)?;
    estimate::check(&document, &hierarchy)?;
    parts.nodes = hierarchy.nodes(&document);
    let cameras = hierarchy.cameras(&document)?;
    parts.cameras = cameras.sound;
    let lights = hierarchy.lights(&document)?;
    parts.lights = lights.sound;
    let skins = hierarchy.skins(&document)?;
    let mut materials = material::Materials::new(&document);
    let sketches = hierarchy.place_meshes(&document, &mut materials, &skins, &mut parts)?;
    parts.skins = skins.sound;
    let material_of = materials.index_of().to_vec();
    let transmissions;
    (parts.materials, parts.textures, transmissions) = materials.finish()?;
    document.take(level_bytes(&parts), "textures")?;
    stroke::draw(&mut parts, sketches);
    let targets = animation::Targets {
        hierarchy: &hierarchy,
        materials: &material_of,
        transmissions: &transmissions,
        lights: &lights.file_index,
        cameras: &cameras.file_index,
    };
    let clips;
    (parts.animations, clips) = animation::read(&document, &targets, &mut parts)?;

    check_triangles(&document, &parts)?;

    // A file of which nothing is left is an error.
    if parts.instances.is_empty()
        && let Some(error) = document.first_loss()
    {
        return Err(error);
    }

    let scene = Scene::new(parts).map_err(|error| {
        let (place, problem) = invalid_part(error);
        document.fault(place, problem)
    })?;
    let contents = contents(&document, clips);
    Ok(Loaded { scene, warnings: document.into_warnings(), contents })
}

/// Bounds what frames hold and number, since a file can ask for copies without end.
fn check_triangles(document: &Document<'_>, parts: &SceneParts) -> Result<(), LoadError> {
    let FrameSize { triangles, stored_triangles, .. } = FrameSize::of(parts);
    for (count, most) in [(stored_triangles, MAX_STORED_TRIANGLES), (triangles, MAX_DRAWN_TRIANGLES)] {
        if count > most {
            let problem = format!(
                "with their instances they draw {triangles} triangles, of which frames hold {stored_triangles}; more than {MAX_STORED_TRIANGLES} held or {MAX_DRAWN_TRIANGLES} drawn are too many, reduce or split the file"
            );
            return Err(document.limit("meshes", problem));
        }
    }
    Ok(())
}

/// What there is to choose from, and what becomes of the extensions.
fn contents(document: &Document<'_>, clips: Vec<Clip>) -> Contents {
    let root = &document.root;
    let mut extensions: Vec<Extension> = Vec::new();
    for name in root.extensions_used.iter().chain(&root.extensions_required) {
        if extensions.iter().all(|known| known.name != *name) {
            extensions.push(Extension {
                name: name.clone(),
                required: root.extensions_required.contains(name),
                has_effect: DRAWN.contains(&name.as_str()),
            });
        }
    }
    let shown_scene = document.choices.scene.or(root.scene).filter(|&index| index < root.scenes.len());
    Contents {
        format: "glTF 2.0".to_owned(),
        extensions,
        scenes: root.scenes.iter().map(|scene| scene.name.clone().unwrap_or_default()).collect(),
        shown_scene: shown_scene.or((!root.scenes.is_empty()).then_some(0)),
        clips,
        variants: root.extensions.variants.variants.iter().map(|variant| variant.name.clone()).collect(),
        shown_variant: document.choices.variant,
    }
}

/// Refuses a file that cannot be understood without an unknown extension; notes the ones that have no effect.
fn check_extensions(document: &Document<'_>) -> Result<(), LoadError> {
    let root = &document.root;
    for extension in &root.extensions_required {
        let name = extension.as_str();
        if !DRAWN.contains(&name) && !IGNORED.contains(&name) {
            let remedy = match name {
                "KHR_draco_mesh_compression" => "build with the cargo feature `draco`",
                "KHR_texture_basisu" => "build with the cargo feature `ktx2`",
                _ => "export the file again without it",
            };
            let problem = format!("the file needs the extension {name}, which is not supported; {remedy}");
            return Err(document.fault("extensionsRequired", problem));
        }
    }
    for extension in root.extensions_used.iter().chain(&root.extensions_required) {
        if !DRAWN.contains(&extension.as_str()) {
            document.warn(LoadWarning::ExtensionIgnored { extension: quoted(extension) });
        }
    }
    Ok(())
}

//! What a scene holds, for people and for programs.

use std::{collections::HashMap, fmt::Write as _, sync::Arc};

use glam::Vec3;
use serde::Serialize;
use sheer_core::text::beginning;
use sheer_image::Image;
use sheer_load::{Contents, Loaded};
use sheer_scene::{
    Camera, CameraChoice, CameraPose, Lens, Scene, SceneMemory,
    model::{AlphaMode, LightKind, Material, Mesh, ShadingModel},
    scene_lights,
};

use crate::{
    report::table::Table,
    version::{COMMIT, VERSION},
};

/// What a scene holds and what becomes of it.
#[derive(Debug, Serialize)]
pub(crate) struct Inspection {
    scene: String,
    /// Empty for a built-in scene.
    format: String,
    counts: Counts,
    /// Lowest and highest corner of everything at rest, world units.
    bounds: [[f32; 3]; 2],
    memory: Memory,
    extensions: Vec<Extension>,
    scenes: Vec<Choice>,
    clips: Vec<Clip>,
    variants: Vec<Choice>,
    cameras: Vec<CameraAtRest>,
    /// The view through `--camera static`, which is the default at time zero.
    view: CameraAtRest,
    lights: Vec<LightAtRest>,
    materials: Vec<Transparency>,
    warnings: Vec<String>,
    version: &'static str,
    commit: &'static str,
}

#[derive(Debug, Serialize)]
struct Counts {
    nodes: usize,
    meshes: usize,
    vertices: usize,
    /// Of all meshes, each once.
    triangles: usize,
    instances: usize,
    /// Of all instances.
    drawn_triangles: usize,
    particles: usize,
    skins: usize,
    morph_targets: usize,
    materials: usize,
    textures: usize,
    /// Textures may share them.
    images: usize,
}

/// Bytes, as [`SceneMemory`] has them.
#[derive(Debug, Serialize)]
struct Memory {
    geometry: u64,
    textures: u64,
    frame: u64,
}

impl From<SceneMemory> for Memory {
    fn from(SceneMemory { geometry, textures, frame }: SceneMemory) -> Self {
        Self { geometry, textures, frame }
    }
}

#[derive(Debug, Serialize)]
struct Extension {
    name: String,
    required: bool,
    has_effect: bool,
}

#[derive(Debug, Serialize)]
struct Choice {
    name: String,
    shown: bool,
}

#[derive(Debug, Serialize)]
struct Clip {
    name: String,
    plays: bool,
    duration_secs: Option<f32>,
}

/// A camera at time zero.
#[derive(Debug, Serialize)]
struct CameraAtRest {
    name: String,
    kind: &'static str,
    eye: [f32; 3],
    /// A point straight ahead, as far away as the middle of the scene.
    target: [f32; 3],
    up: [f32; 3],
    /// Of a perspective camera.
    yfov_degrees: Option<f32>,
    /// Of an orthographic camera, world units.
    height: Option<f32>,
    /// The options of `sheer render` that make this view.
    options: String,
}

#[derive(Debug, Serialize)]
struct LightAtRest {
    name: String,
    kind: &'static str,
    /// Linear red, green and blue: lux of a directional light, candela of others.
    intensity: [f32; 3],
    position: Option<[f32; 3]>,
    direction: Option<[f32; 3]>,
}

/// What can be seen through a material.
#[derive(Debug, Serialize)]
struct Transparency {
    name: String,
    mode: &'static str,
    cutoff: Option<f32>,
    /// Least and greatest alpha of factor, texture and vertices together.
    alpha: [f32; 2],
    transmission: f32,
    double_sided: bool,
    shading: &'static str,
    /// Triangles of all instances that have it.
    triangles: usize,
}

impl Inspection {
    pub(crate) fn of(text: &str, loaded: &Loaded) -> Self {
        let Loaded { scene, warnings, contents } = loaded;
        let Contents { format, extensions, scenes, shown_scene, clips, variants, shown_variant } = contents;
        let choices = |names: &[String], shown: &Option<usize>| {
            let each = names.iter().enumerate();
            each.map(|(at, name)| Choice { name: name.clone(), shown: *shown == Some(at) }).collect()
        };
        let view = CameraChoice::Named("static".to_owned());
        let view = scene.camera(&view).expect("every scene has a static camera");
        Self {
            scene: text.to_owned(),
            format: format.clone(),
            counts: Counts::of(scene),
            bounds: scene.bounds().map(Into::into),
            memory: Memory::from(scene.memory()),
            extensions: extensions
                .iter()
                .map(|extension| Extension {
                    name: extension.name.clone(),
                    required: extension.required,
                    has_effect: extension.has_effect,
                })
                .collect(),
            scenes: choices(scenes, shown_scene),
            clips: clips
                .iter()
                .map(|clip| Clip {
                    name: clip.name.clone(),
                    plays: clip.plays,
                    duration_secs: clip.plays.then_some(clip.duration_secs),
                })
                .collect(),
            variants: choices(variants, shown_variant),
            cameras: scene.parts().cameras.iter().map(|camera| CameraAtRest::of(scene, camera)).collect(),
            view: CameraAtRest::of(scene, &view),
            lights: lights(scene),
            materials: materials(scene),
            warnings: warnings.iter().map(ToString::to_string).collect(),
            version: VERSION,
            commit: COMMIT,
        }
    }

    /// As text: a paragraph, and a table for each kind of thing that there is.
    pub(crate) fn text(&self) -> String {
        let mut text = self.summary();
        let mut add = |title: &str, table: Table| {
            text += &format!("\n{title}\n{}", indented(&table.text()));
        };
        if !self.extensions.is_empty() {
            let mut table = Table::new(&["extension", "required", "what becomes of it"]);
            for Extension { name, required, has_effect } in &self.extensions {
                let fate = if *has_effect { "drawn" } else { "has no effect here" };
                table.add(vec![name.clone(), yes_or_no(*required), fate.to_owned()]);
            }
            add("Extensions", table);
        }
        for (title, option, choices) in
            [("Scenes", "--scene", &self.scenes), ("Variants of materials", "--variant", &self.variants)]
        {
            if !choices.is_empty() {
                let mut table = Table::new(&["#", "name", "shown"]);
                for (at, Choice { name, shown }) in choices.iter().enumerate() {
                    table.add(vec![at.to_string(), named(name), yes_or_no(*shown)]);
                }
                add(&format!("{title} ({option})"), table);
            }
        }
        if !self.clips.is_empty() {
            let mut table = Table::new(&["#", "name", "seconds", "plays"]);
            for (at, Clip { name, plays, duration_secs }) in self.clips.iter().enumerate() {
                let seconds = duration_secs.map_or("–".to_owned(), |secs| format!("{secs:.3}"));
                table.add(vec![at.to_string(), named(name), seconds, yes_or_no(*plays)]);
            }
            add("Animations (--clip)", table);
        }
        let mut table = Table::new(&["name", "kind", "eye", "target", "up", "field of view"]);
        let view = ("(default view)", &self.view);
        let all = self.cameras.iter().map(|camera| (camera.name.as_str(), camera));
        let all = all.chain(self.cameras.is_empty().then_some(view));
        for (name, camera) in all.clone() {
            let field = match (camera.yfov_degrees, camera.height) {
                (Some(degrees), _) => format!("{degrees:.1}° high"),
                (_, Some(height)) => format!("{height:.4} high"),
                _ => String::new(),
            };
            let [eye, target, up] = [camera.eye, camera.target, camera.up].map(vector);
            table.add(vec![named(name), camera.kind.to_owned(), eye, target, up, field]);
        }
        add("Cameras (--camera)", table);
        let mut table = Table::new(&["name", "as options"]);
        for (name, camera) in all {
            table.add(vec![named(name), camera.options.clone()]);
        }
        add("The same views, to start others from", table);
        if !self.lights.is_empty() {
            let mut table = Table::new(&["name", "kind", "intensity", "position", "direction"]);
            for light in &self.lights {
                let or_none = |given: Option<[f32; 3]>| given.map_or("–".to_owned(), vector);
                table.add(vec![
                    named(&light.name),
                    light.kind.to_owned(),
                    vector(light.intensity),
                    or_none(light.position),
                    or_none(light.direction),
                ]);
            }
            add("Lights", table);
        }
        if !self.materials.is_empty() {
            let titles = ["material", "mode", "alpha", "transmission", "sides", "shading", "triangles"];
            let mut table = Table::new(&titles);
            for material in &self.materials {
                let mode = match material.cutoff {
                    Some(cutoff) => format!("{} at {cutoff}", material.mode),
                    None => material.mode.to_owned(),
                };
                let [least, most] = material.alpha;
                table.add(vec![
                    named(&material.name),
                    mode,
                    if least == most { format!("{least:.3}") } else { format!("{least:.3} to {most:.3}") },
                    format!("{:.3}", material.transmission),
                    if material.double_sided { "both" } else { "front" }.to_owned(),
                    material.shading.to_owned(),
                    material.triangles.to_string(),
                ]);
            }
            add("Transparency by material", table);
        }
        if !self.warnings.is_empty() {
            text += "\nWarnings\n";
            text += &indented(&format!("{}\n", self.warnings.join("\n")));
        }
        text
    }

    fn summary(&self) -> String {
        let Counts {
            nodes,
            meshes,
            vertices,
            triangles,
            instances,
            drawn_triangles,
            particles,
            skins,
            morph_targets,
            materials,
            textures,
            images,
        } = self.counts;
        let format = if self.format.is_empty() { "built-in scene" } else { &self.format };
        let mut text = format!("{}: {format}\n", self.scene);
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "  {name:<10}{value}");
        };
        let meshes = counted(meshes, "mesh", "meshes");
        let vertices = counted(vertices, "vertex", "vertices");
        let triangles = counted(triangles, "triangle", "triangles");
        line("geometry", format!("{meshes} of {vertices} and {triangles}"));
        let instances = counted(instances, "instance", "instances");
        let nodes = counted(nodes, "node", "nodes");
        let triangles = counted(drawn_triangles, "triangle", "triangles");
        line("drawn", format!("{instances} at {nodes}, {triangles}"));
        if particles + skins + morph_targets > 0 {
            let particles = counted(particles, "particle", "particles");
            let skins = counted(skins, "skin", "skins");
            let targets = counted(morph_targets, "morph target", "morph targets");
            line("moving", format!("{particles}, {skins}, {targets}"));
        }
        let materials = counted(materials, "material", "materials");
        let textures = counted(textures, "texture", "textures");
        line("looks", format!("{materials}, {textures} of {}", counted(images, "image", "images")));
        let [low, high] = self.bounds;
        line("bounds", format!("{} to {}", vector(low), vector(high)));
        let Memory { geometry, textures, frame } = self.memory;
        let [all, geometry, textures, frame] =
            [geometry + textures + frame, geometry, textures, frame].map(megabytes);
        line(
            "memory",
            format!("about {all} MB: geometry {geometry}, textures {textures}, what is traced {frame}"),
        );
        text
    }
}

/// A number of things, in words.
fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

impl Counts {
    fn of(scene: &Scene) -> Self {
        let parts = scene.parts();
        let triangles = |mesh: &Mesh| mesh.indices.len();
        let drawn = parts.instances.iter().map(|instance| triangles(&parts.meshes[instance.mesh as usize]));
        let mut images: Vec<_> = parts.textures.iter().map(|texture| Arc::as_ptr(&texture.image)).collect();
        images.sort_unstable();
        images.dedup();
        Self {
            nodes: parts.nodes.len(),
            meshes: parts.meshes.len(),
            vertices: parts.meshes.iter().map(|mesh| mesh.positions.len()).sum(),
            triangles: parts.meshes.iter().map(triangles).sum(),
            instances: parts.instances.len(),
            drawn_triangles: drawn.sum(),
            particles: parts.particles.iter().map(|system| system.particles.len()).sum(),
            skins: parts.skins.len(),
            morph_targets: parts.meshes.iter().map(|mesh| mesh.morph_targets.len()).sum(),
            materials: parts.materials.len(),
            textures: parts.textures.len(),
            images: images.len(),
        }
    }
}

impl CameraAtRest {
    fn of(scene: &Scene, camera: &Camera) -> Self {
        let pose = scene.pose(camera, 0.0);
        let (centre, radius) = scene.bounding_sphere();
        let ahead = (centre - pose.eye()).dot(pose.forward()).max(0.1 * radius);
        let (kind, yfov_degrees, height) = match camera.lens {
            Lens::Perspective { yfov_rad } => ("perspective", Some(yfov_rad.to_degrees()), None),
            Lens::Orthographic { half_height } => ("orthographic", None, Some(2.0 * half_height)),
        };
        let (eye, target) = (pose.eye(), pose.eye() + pose.forward() * ahead);
        let up = Vec3::from(pose.world_from_camera.matrix3.y_axis);
        let options = view_options(&pose, camera.lens, ahead);
        Self {
            name: camera.name.clone(),
            kind,
            eye: eye.into(),
            target: target.into(),
            up: up.into(),
            yfov_degrees,
            height,
            options,
        }
    }
}

/// The options of `sheer render` that make a view, its target so many world units ahead.
pub(crate) fn view_options(pose: &CameraPose, lens: Lens, ahead: f32) -> String {
    let list = |Vec3 { x, y, z }: Vec3| format!("{x},{y},{z}");
    let (eye, target) = (pose.eye(), pose.eye() + pose.forward() * ahead);
    let up = pose.world_from_camera.matrix3.y_axis.into();
    let lens = match lens {
        Lens::Perspective { yfov_rad } => format!("--fov {}", yfov_rad.to_degrees()),
        Lens::Orthographic { half_height } => format!("--ortho {}", 2.0 * half_height),
    };
    format!("--eye {} --target {} --up {} {lens}", list(eye), list(target), list(up))
}

fn lights(scene: &Scene) -> Vec<LightAtRest> {
    let lights = scene.parts().lights.iter().zip(scene_lights(scene, 0.0));
    lights
        .map(|(light, placed)| {
            let (position, direction) = (Some(placed.position.into()), Some(placed.direction.into()));
            let (kind, position, direction) = match light.kind {
                LightKind::Directional => ("directional", None, direction),
                LightKind::Point { .. } => ("point", position, None),
                LightKind::Spot { .. } => ("spot", position, direction),
            };
            LightAtRest {
                name: light.name.clone(),
                kind,
                intensity: light.intensity.into(),
                position,
                direction,
            }
        })
        .collect()
}

fn materials(scene: &Scene) -> Vec<Transparency> {
    let parts = scene.parts();
    // Of each material, the range of its vertices' alpha and the triangles drawn in it.
    let mut vertices = vec![EMPTY; parts.materials.len()];
    let mut triangles = vec![0; parts.materials.len()];
    for mesh in &parts.meshes {
        let range = &mut vertices[mesh.material as usize];
        *range = mesh.colours.iter().fold(*range, |range, colour| widened(range, colour.w));
    }
    for instance in &parts.instances {
        let mesh = &parts.meshes[instance.mesh as usize];
        triangles[mesh.material as usize] += mesh.indices.len();
    }
    // Of each image, however many materials show it.
    let mut texels: HashMap<*const Image<[u8; 4]>, [f32; 2]> = HashMap::new();
    let mut of_image = |image: &Arc<Image<[u8; 4]>>| {
        *texels.entry(Arc::as_ptr(image)).or_insert_with(|| {
            let alphas = image.as_slice().iter().map(|texel| f32::from(texel[3]) / 255.0);
            alphas.fold(EMPTY, widened)
        })
    };
    let of = |(index, material): (usize, &Material)| {
        let (mode, cutoff) = match material.alpha_mode {
            AlphaMode::Opaque => ("opaque", None),
            AlphaMode::Mask { cutoff } => ("mask", Some(cutoff)),
            AlphaMode::Blend => ("blend", None),
        };
        let alpha = if mode == "opaque" {
            [1.0; 2]
        } else {
            let texture = material.base_colour_texture.map(|used| &parts.textures[used.texture as usize]);
            let texture = texture.map_or(EMPTY, |texture| of_image(&texture.image));
            let [texture, vertices] = [texture, vertices[index]].map(one_if_empty);
            [0, 1].map(|end| material.base_colour.w * texture[end] * vertices[end])
        };
        Transparency {
            name: material.name.clone(),
            mode,
            cutoff,
            alpha: alpha.map(|alpha| alpha * material.opacity),
            transmission: material.transmission,
            double_sided: material.double_sided,
            shading: match material.model {
                ShadingModel::MetallicRoughness => "metallic-roughness",
                ShadingModel::Unlit => "unlit",
                ShadingModel::Smoke => "smoke",
                ShadingModel::Fibre => "fibre",
                ShadingModel::Luminous => "luminous",
            },
            triangles: triangles[index],
        }
    };
    parts.materials.iter().enumerate().map(of).collect()
}

/// Least and greatest of no values.
const EMPTY: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// Least and greatest with one value more.
fn widened([low, high]: [f32; 2], value: f32) -> [f32; 2] {
    [low.min(value), high.max(value)]
}

/// What nobody changes is a factor of 1.
fn one_if_empty(range: [f32; 2]) -> [f32; 2] {
    if range == EMPTY { [1.0; 2] } else { range }
}

fn yes_or_no(is_so: bool) -> String {
    if is_so { "yes" } else { "no" }.to_owned()
}

/// A name for a cell: short, and without what a terminal would obey.
fn named(name: &str) -> String {
    const LONGEST: usize = 40;
    if name.is_empty() { "–".to_owned() } else { beginning(name, LONGEST) }
}

fn vector([x, y, z]: [f32; 3]) -> String {
    format!("({}, {}, {})", figure(x), figure(y), figure(z))
}

/// A number of about four digits.
fn figure(value: f32) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / 1e6)
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short_in_every_unit() {
        let figures = [0.0, -0.0, 1.0, -2.5, 0.333_33, 1e-9, 1.5e9, 123_456.0].map(figure);
        assert_eq!(figures, ["0", "0", "1", "-2.5", "0.333", "1.000e-9", "1.500e9", "123456"]);
    }

    #[test]
    fn names_cannot_act_on_a_terminal_or_fill_it() {
        assert_eq!(named("a\x1b[2Jb"), "a\\u{1b}[2Jb");
        assert_eq!(named(""), "–");
        assert_eq!(named(&"x".repeat(1000)).chars().count(), 41);
    }
}

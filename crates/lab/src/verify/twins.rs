//! A GPU held against the CPU: the same fragments in the same pixels, in the same colours.
//!
//! Both decide by the same integers and the same arithmetic, so that one frame tells. Where they may differ: a hardware's edges of triangles lie
//! between other pixels, its blending units add in half floats, its roots and powers round in their own way.

use std::sync::Arc;

use sheer_image::Planes;
use sheer_metrics::{
    FragmentDifference,
    statistics::{Moments, z_score},
};
use sheer_render::{
    Antialiasing, Backend, Counters, Method, Settings, Stage,
    backend::Cpu,
    method::{Family, METHODS, hashed, kbuffer, stochastic},
};
use sheer_scene::{CameraChoice, Scene};

use crate::{
    LabError, Progress, Result, picture,
    verify::check::{Check, Value},
};

/// Large enough that few pixels are edges.
const SIZE: [u32; 2] = [256, 144];
/// Colours, textures and shadows; none is deeper than the lists of a rasteriser.
const SCENES: [&str; 3] = ["layers:count=6,alpha=0.3,colours=rainbow", "pane", "smoke-square:particles=200"];
/// Beside all methods by their names.
const VARIANTS: [&str; 2] = ["std:hybrid=0.5,layers=3", "baseline:trace=continuation"];
/// Share of the pixels that may show the same fragment in another colour: where rays of light pass the edge of what casts a shadow.
const COLOUR_SHARE: f64 = 0.002;
/// The same of what is made of all fragments of a pixel, each of which may be in such a place or have its edge there.
const COLOUR_SHARE_COMPOSITED: f64 = 0.005;
/// Share of the pixels inside triangles where a logarithm of another last bit may draw another threshold.
const INSIDE_SHARE_HASHED: f64 = 0.001;
/// Hardware rounds the corners of triangles to 1/256 of a pixel, and the projection rounds before that.
const EDGE_PX: f32 = 1.0 / 64.0;
/// Accuracy of half floats, 2⁻¹¹, twice.
const COLOUR_BOUND: f32 = 1.0 / 1024.0;
/// Half floats round sums, weights and products by 2⁻¹² a fragment; up to 32 of them, once each.
const COLOUR_BOUND_COMPOSITED: f32 = 1.0 / 128.0;

/// Layers of [`transmittance`].
const LAYERS: (u32, f32) = (4, 0.3);
/// Frames of it.
const FRAMES: u32 = 4;

/// What a backend is held against the CPU with.
#[derive(Clone, Debug, Default)]
pub struct Twins {
    /// Scenes and their names, each once; some built-in ones if there is none.
    pub scenes: Vec<(String, Arc<Scene>)>,
    /// Opacity of every material of the built-in ones.
    pub alpha: Option<f32>,
    /// Methods, each once; all that the backend runs if there is none.
    pub methods: Vec<Method>,
    /// Threads to use, all the processor's by default.
    pub threads: Option<usize>,
}

/// Renders on both. Methods that the backend does not run are told of, and no failure unless the user asked for them.
///
/// # Errors
/// A picture could not be made.
pub fn twins<B: Backend>(backend: &B, asked: &Twins, progress: &dyn Progress) -> Result<Vec<Check>> {
    let names_methods = !asked.methods.is_empty();
    let methods = if names_methods { asked.methods.clone() } else { all_methods()? };
    let scenes = if asked.scenes.is_empty() { own_scenes(asked.alpha)? } else { asked.scenes.clone() };
    let (drawn_anew, methods): (Vec<_>, Vec<_>) =
        methods.into_iter().partition(|method| method.info().id == stochastic::INFO.id);
    progress.expect((methods.len() * scenes.len() + drawn_anew.len().min(1)) as u64);
    let mut checks = Vec::new();
    let mut refused: Vec<String> = Vec::new();
    for (name, scene) in scenes {
        let mut sides = Sides::new(name, &scene, backend, asked.threads)?;
        for method in &methods {
            match sides.check(method) {
                Ok(Compared::Check(check)) => checks.push(check),
                Ok(Compared::Overflow(fragments)) => progress.warn(&format!(
                    "{}: {method} had no place for {fragments:.2} fragments a pixel; not compared",
                    sides.scene
                )),
                Err(LabError::Unsupported(_)) if !names_methods => {
                    if !refused.contains(&method.to_string()) {
                        refused.push(method.to_string());
                    }
                }
                Err(error) => return Err(error),
            }
            progress.step();
        }
    }
    if let Some(method) = drawn_anew.first() {
        match transmittance(backend, asked.threads) {
            Ok(check) => checks.push(check),
            Err(LabError::Unsupported(_)) if !names_methods => refused.push(method.to_string()),
            Err(error) => return Err(error),
        }
        progress.step();
    }
    if !refused.is_empty() {
        progress.note(&format!("--backend {} does not run: {}", backend.name(), refused.join(", ")));
    }
    Ok(checks)
}

fn all_methods() -> Result<Vec<Method>> {
    let names = METHODS.iter().map(|info| info.id).chain(VARIANTS);
    Ok(names.map(str::parse).collect::<Result<_, _>>()?)
}

fn own_scenes(alpha: Option<f32>) -> Result<Vec<(String, Arc<Scene>)>> {
    let open = |name: &str| {
        let scene = sheer_gallery::open(name)?.scene;
        let scene = match alpha {
            Some(alpha) => scene.with_alpha(alpha),
            None => scene,
        };
        Ok((name.to_owned(), Arc::new(scene)))
    };
    SCENES.into_iter().map(open).collect()
}

/// A frame and what it cost.
fn frame<B: Backend>(backend: &B, stage: &mut B::Stage, method: &Method) -> Result<(Planes, Counters)> {
    // Not the first frame, whose number is 0 in every hash.
    let settings = Settings { size: SIZE, first_frame: 4, ..Settings::default() };
    picture(backend, stage, method, Antialiasing::NONE, settings, 1)
}

/// A scene on both sides.
struct Sides<'b, B: Backend> {
    scene: String,
    backend: &'b B,
    on_cpu: Stage,
    on_gpu: B::Stage,
}

/// What came of a comparison.
enum Compared {
    Check(Check),
    /// So many fragments a pixel had no place on the GPU, which sums them up instead: by its bound, not by mistake.
    Overflow(f64),
}

impl<'b, B: Backend> Sides<'b, B> {
    fn new(scene: String, opened: &Arc<Scene>, backend: &'b B, threads: Option<usize>) -> Result<Self> {
        let on_cpu = Cpu.stage(Arc::clone(opened), &CameraChoice::Default, threads)?;
        let on_gpu = backend.stage(Arc::clone(opened), &CameraChoice::Default, threads);
        let on_gpu = on_gpu.map_err(|error| LabError::of_backend(backend, error))?;
        Ok(Self { scene, backend, on_cpu, on_gpu })
    }

    fn check(&mut self, method: &Method) -> Result<Compared> {
        let (mut found, counters) = frame(self.backend, &mut self.on_gpu, method)?;
        let (expected, expected_counters) = frame(&Cpu, &mut self.on_cpu, method)?;
        if !method.family().shades_one_fragment() {
            // Where layers hide the background, what keeps sums alone does not know which fragment is the furthest. Colours tell.
            found.instance.clone_from(&expected.instance);
            found.primitive.clone_from(&expected.primitive);
        }
        let bounds = Bounds::of(method);
        let difference = FragmentDifference::measure(&expected, &found, bounds.colour)?;
        let pass = bounds.hold(&difference, &self.on_cpu);
        // What has no place in a k-buffer is summed up on a GPU, which cannot blend in order.
        let expected_merged = if method.info().id == kbuffer::INFO.id { 0 } else { expected_counters.merged };
        let overflow = (counters.merged as f64 - expected_merged as f64) / difference.pixels as f64;
        if !pass && overflow > COLOUR_SHARE {
            return Ok(Compared::Overflow(overflow));
        }
        Ok(Compared::Check(Check {
            name: format!("{}: {method} by {}, share of other pixels", self.scene, self.backend.name()),
            source: "the CPU".to_owned(),
            closed_form: Some(Value::Number(0.0)),
            paper: None,
            measured: Some(Value::Number(difference.other_share() + difference.colour_share())),
            samples: Some(difference.pixels as u64),
            z: None,
            pass,
        }))
    }
}

/// How far a GPU may be from the CPU.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Of a channel, as [`FragmentDifference::measure`] takes it.
    colour: f32,
    /// Of pixels whose colour may differ by more.
    colour_share: f64,
    /// Of pixels away from edges that may show another fragment.
    inside_share: f64,
}

impl Bounds {
    fn of(method: &Method) -> Self {
        let inside_share = if method.info().id == hashed::INFO.id { INSIDE_SHARE_HASHED } else { 0.0 };
        let (colour, colour_share) = match method.family() {
            Family::Threshold | Family::Selection => (COLOUR_BOUND, COLOUR_SHARE),
            Family::Ordered | Family::Unordered => (COLOUR_BOUND_COMPOSITED, COLOUR_SHARE_COMPOSITED),
        };
        Self { colour, colour_share, inside_share }
    }

    /// Whether few colours differ, and fragments only where the CPU meets other triangles right beside the pixel's centre.
    fn hold(self, difference: &FragmentDifference, stage: &Stage) -> bool {
        let is_inside = |&&other: &&(u32, u32)| !stage.is_near_edge(other, SIZE, EDGE_PX);
        let inside = difference.others.iter().filter(is_inside).count();
        difference.colour_share() <= self.colour_share
            && inside as f64 <= self.inside_share * difference.pixels as f64
    }
}

/// Samples of stochastic transparency lie elsewhere in the pixels of hardware and are drawn in rounds of as many as it has, which is another draw
/// of the same chance: its mean has to be the closed form (ST section 3.1).
fn transmittance<B: Backend>(backend: &B, threads: Option<usize>) -> Result<Check> {
    let (count, alpha) = LAYERS;
    let text = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
    let scene = sheer_gallery::open(&text)?.scene.into();
    let stage = backend.stage(scene, &CameraChoice::Default, threads);
    let mut stage = stage.map_err(|error| LabError::of_backend(backend, error))?;
    let method: Method = "stochastic:estimator=basic,correct=off".parse()?;
    let mut seen = Moments::default();
    for seed in 0..FRAMES {
        let settings = Settings { size: SIZE, seed, ..Settings::default() };
        let (planes, _) = picture(backend, &mut stage, &method, Antialiasing::NONE, settings, 1)?;
        // Red and green layers before blue.
        planes.colour.as_slice().iter().for_each(|&[_, _, blue, _]| seen.add(blue.into()));
    }
    let expected = (1.0 - f64::from(alpha)).powi(count as i32);
    Ok(Check {
        name: format!("{method} by {}: transmittance of {count}×{alpha}", backend.name()),
        source: "ST section 3.1".to_owned(),
        closed_form: Some(Value::Number(expected)),
        paper: None,
        measured: Some(Value::Number(seen.mean())),
        samples: Some(seen.count()),
        z: Some(z_score(seen.mean() - expected, seen.variance_of_mean().sqrt())),
        pass: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the second picture against the first: whether it is near enough, and the largest difference of what is.
    fn held(methods: [&str; 2]) -> (bool, f32) {
        let scene = sheer_gallery::open(SCENES[2]).unwrap().scene;
        let mut stage = Stage::new(scene, &CameraChoice::Default, None).unwrap();
        let methods = methods.map(|method| method.parse().unwrap());
        let [one, two] = [0, 1].map(|at| frame(&Cpu, &mut stage, &methods[at]).unwrap().0);
        let bounds = Bounds::of(&methods[0]);
        let difference = FragmentDifference::measure(&one, &two, bounds.colour).unwrap();
        (bounds.hold(&difference, &stage), difference.worst)
    }

    #[test]
    fn a_picture_is_like_itself_and_unlike_that_of_another_method() {
        for method in ["std", "weighted"] {
            assert_eq!(held([method, method]), (true, 0.0));
        }
        for methods in [
            ["std", "roulette"],
            ["joint", "std"],
            ["weighted", "moments"],
            ["mlab", "peel"],
            ["hashed", "std"],
        ] {
            assert!(!held(methods).0, "the check is blind for {methods:?}");
        }
    }
}

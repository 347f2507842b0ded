//! A GPU held against the CPU: the same fragments in the same pixels, in the same colours.
//!
//! Both decide by the same integers and the same arithmetic, so that one frame tells. Where they may differ: a hardware's edges of triangles lie
//! between other pixels, its blending units add in half floats, its roots and powers round in their own way.

use sheer_gpu::GpuError;
use sheer_image::Planes;
use sheer_metrics::{
    FragmentDifference,
    statistics::{Moments, z_score},
};
use sheer_render::{
    Antialiasing, Clock, Counters, Method, Settings,
    method::{Family, METHODS, hashed, kbuffer, stochastic},
};
use sheer_scene::CameraChoice;

use crate::{
    args::{SceneArguments, VerifyArguments},
    backend::{Cpu, Renderer},
    report::json::{Check, Value},
    setup::without_repeats,
    talk::Talk,
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

/// Renders with both. Methods that the GPU's path does not run are told of, and no failure unless the user asked for them.
pub(super) fn checks<R: Renderer>(
    arguments: &VerifyArguments,
    renderer: &R,
    talk: Talk,
) -> anyhow::Result<Vec<Check>> {
    let asked = !arguments.methods.is_empty();
    let methods = if asked { without_repeats(&arguments.methods) } else { all_methods()? };
    let own_scenes = SCENES.map(str::to_owned).to_vec();
    let scenes = if arguments.scenes.is_empty() { own_scenes } else { without_repeats(&arguments.scenes) };
    let (drawn_anew, methods): (Vec<_>, Vec<_>) =
        methods.into_iter().partition(|method| method.info().id == stochastic::INFO.id);
    let progress = talk.progress((methods.len() * scenes.len() + drawn_anew.len().min(1)) as u64);
    let mut checks = Vec::new();
    let mut refused: Vec<String> = Vec::new();
    for text in scenes {
        let scene = SceneArguments { text, camera: None, alpha: arguments.alpha };
        let mut sides = Sides::new(&scene, renderer, arguments.machine.threads, talk)?;
        for method in &methods {
            match sides.check(method) {
                Ok(Compared::Check(check)) => checks.push(check),
                Ok(Compared::Overflow(fragments)) => progress.suspend(|| {
                    talk.warn(format_args!(
                        "{}: {method} had no place for {fragments:.2} fragments a pixel; not compared",
                        scene.text
                    ));
                }),
                Err(error) if !asked && is_unsupported(&error) => refused.push(method.to_string()),
                Err(error) => return Err(error),
            }
            progress.inc(1);
        }
    }
    if let Some(method) = drawn_anew.first() {
        match transmittance(renderer, arguments.machine.threads) {
            Ok(check) => checks.push(check),
            Err(error) if !asked && is_unsupported(&error) => refused.push(method.to_string()),
            Err(error) => return Err(error),
        }
    }
    progress.finish_and_clear();
    if !refused.is_empty() {
        let refused = without_repeats(&refused).join(", ");
        talk.note(format_args!("--backend {} does not run: {refused}", renderer.word()));
    }
    Ok(checks)
}

fn is_unsupported(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(GpuError::Unsupported { .. }))
}

fn all_methods() -> anyhow::Result<Vec<Method>> {
    let names = METHODS.iter().map(|info| info.id).chain(VARIANTS);
    Ok(names.map(str::parse).collect::<Result<_, _>>()?)
}

/// A frame and what it cost.
fn frame<R: Renderer>(
    renderer: &R,
    stage: &mut R::Stage,
    method: &Method,
) -> anyhow::Result<(Planes, Counters)> {
    // Not the first frame, whose number is 0 in every hash.
    let settings = Settings { size: SIZE, first_frame: 4, ..Settings::default() };
    let mut pipeline = renderer.pipeline(method, Antialiasing::None, settings)?;
    renderer.advance(stage, Clock::new(&settings, Antialiasing::None).at(0))?;
    let (counters, _) = renderer.render(&mut pipeline, stage, 0)?;
    Ok((renderer.planes(&pipeline)?.into_owned(), counters))
}

/// A scene on both sides.
struct Sides<'r, R: Renderer> {
    scene: String,
    renderer: &'r R,
    on_cpu: <Cpu as Renderer>::Stage,
    on_gpu: R::Stage,
}

/// What came of a comparison.
enum Compared {
    Check(Check),
    /// So many fragments a pixel had no place on the GPU, which sums them up instead: by its bound, not by mistake.
    Overflow(f64),
}

impl<'r, R: Renderer> Sides<'r, R> {
    fn new(
        scene: &SceneArguments,
        renderer: &'r R,
        threads: Option<usize>,
        talk: Talk,
    ) -> anyhow::Result<Self> {
        let loaded = scene.load(talk)?;
        let on_cpu = Cpu.stage(loaded.clone(), &CameraChoice::Default, threads)?;
        let on_gpu = renderer.stage(loaded, &CameraChoice::Default, threads)?;
        Ok(Self { scene: scene.text.clone(), renderer, on_cpu, on_gpu })
    }

    fn check(&mut self, method: &Method) -> anyhow::Result<Compared> {
        let (mut found, counters) = frame(self.renderer, &mut self.on_gpu, method)?;
        let (expected, expected_counters) = frame(&Cpu, &mut self.on_cpu, method)?;
        if method.family() == Family::Compositing {
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
            name: format!("{}: {method} by {}, share of other pixels", self.scene, self.renderer.word()),
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
            Family::Compositing => (COLOUR_BOUND_COMPOSITED, COLOUR_SHARE_COMPOSITED),
        };
        Self { colour, colour_share, inside_share }
    }

    /// Whether few colours differ, and fragments only where the CPU meets other triangles right beside the pixel's centre.
    fn hold(self, difference: &FragmentDifference, stage: &<Cpu as Renderer>::Stage) -> bool {
        let is_inside = |&&other: &&(u32, u32)| !stage.is_near_edge(other, SIZE, EDGE_PX);
        let inside = difference.others.iter().filter(is_inside).count();
        difference.colour_share() <= self.colour_share
            && inside as f64 <= self.inside_share * difference.pixels as f64
    }
}

/// Samples of stochastic transparency lie elsewhere in the pixels of hardware and are drawn in rounds of as many as it has, which is another draw
/// of the same chance: its mean has to be the closed form (ST section 3.1).
fn transmittance<R: Renderer>(renderer: &R, threads: Option<usize>) -> anyhow::Result<Check> {
    let (count, alpha) = LAYERS;
    let text = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
    let scene = sheer_scene::open(&text)?.scene.into();
    let mut stage = renderer.stage(scene, &CameraChoice::Default, threads)?;
    let method: Method = "stochastic:estimator=basic,correct=off".parse()?;
    let mut seen = Moments::default();
    for seed in 0..FRAMES {
        let settings = Settings { size: SIZE, seed, ..Settings::default() };
        let mut pipeline = renderer.pipeline(&method, Antialiasing::None, settings)?;
        renderer.advance(&mut stage, Clock::new(&settings, Antialiasing::None).at(0))?;
        renderer.render(&mut pipeline, &mut stage, 0)?;
        let planes = renderer.planes(&pipeline)?;
        // Red and green layers before blue.
        planes.colour.as_slice().iter().for_each(|&[_, _, blue, _]| seen.add(blue.into()));
    }
    let expected = (1.0 - f64::from(alpha)).powi(count as i32);
    Ok(Check {
        name: format!("{method} by {}: transmittance of {count}×{alpha}", renderer.word()),
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
        let scene = SceneArguments { text: SCENES[2].to_owned(), camera: None, alpha: None };
        let loaded = scene.load(Talk { quiet: true }).unwrap();
        let mut stage = Cpu.stage(loaded, &CameraChoice::Default, None).unwrap();
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

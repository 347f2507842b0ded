//! A backend held against the CPU: the same fragments in the same pixels, in the same colours, alone and
//! added up over time.
//!
//! What may differ and why is said by [`Tolerance`]. A comparison that fails stays a failure, also where the
//! backend says that its memory was too small for the scene: the user is told so.

use std::sync::Arc;

use sheer_image::Planes;
use sheer_metrics::statistics::{Moments, z_score};
use sheer_render::{
    Antialiasing, Backend, Clock, Counters, Method, Settings, Stage, backend::Cpu, method::METHODS,
};
use sheer_scene::{CameraChoice, Scene};

use crate::{
    LabError, Progress, Result,
    agreement::{Disagreement, Tolerance},
    picture,
    verify::check::{Check, Value},
};

/// Large enough that few pixels are edges.
const SIZE: [u32; 2] = [256, 144];
/// Colours, textures and shadows; none is deeper than the lists of a rasteriser.
const SCENES: [&str; 3] = ["layers:count=6,alpha=0.3,colours=rainbow", "pane", "smoke-square:particles=200"];
/// Beside all methods by their names.
const VARIANTS: [&str; 2] = ["std:hybrid=0.5,layers=3", "baseline:trace=continuation"];
/// Frames that anti-aliasing adds up: the second has a history to fetch, the third one that was clipped.
const TAA_FRAMES: u32 = 3;
/// Share of pixels whose colour may differ then. A pixel that shows another fragment in one of the frames
/// moves the limits that history is clipped to for all pixels around it, 7×7 where transparent ones are.
const TAA_SHARE: f64 = 0.05;
/// Fragments of a pixel that have no place, beyond those that the method leaves without one, from which on a
/// warning says so.
const OVERFLOW_SHARE: f64 = 0.002;

/// Layers that cover every pixel whole: where samples lie makes no difference.
const LAYERS: (u32, f32) = (4, 0.3);
/// Pictures of them, each of a seed of its own.
const LAYER_FRAMES: u32 = 4;
/// A half float rounds a value by at most this share of it.
const HALF_ROUNDING: f64 = 1.0 / 2048.0;

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

/// Renders on both. Methods that the backend does not run are named, and no failure unless the user asked for
/// them.
///
/// # Errors
/// A picture could not be made.
pub fn twins<B: Backend>(backend: &B, asked: &Twins, progress: &dyn Progress) -> Result<Vec<Check>> {
    let names_methods = !asked.methods.is_empty();
    let methods = if names_methods { asked.methods.clone() } else { all_methods()? };
    let scenes = if asked.scenes.is_empty() { own_scenes(asked.alpha)? } else { asked.scenes.clone() };
    // Samples of stochastic transparency lie elsewhere in the pixels of hardware: these methods have a scene
    // where that does not matter.
    let (sampled, methods): (Vec<_>, Vec<_>) =
        methods.into_iter().partition(|method| method.info().id == "stochastic");
    progress.expect((methods.len() * scenes.len() + sampled.len()) as u64);

    let mut checks = Vec::new();
    let mut refused: Vec<String> = Vec::new();
    let mut take = |method: &Method, made: Result<Vec<Check>>| {
        progress.step();
        match made {
            Ok(made) => checks.extend(made),
            Err(LabError::Unsupported(_)) if !names_methods => refused.push(method.to_string()),
            Err(error) => return Err(error),
        }
        Ok(())
    };
    for (name, scene) in scenes {
        let mut sides = Sides::new(name, &scene, backend, asked.threads)?;
        for method in &methods {
            let made = sides.checks(method, progress);
            take(method, made)?;
        }
    }
    for method in &sampled {
        let made = layers(backend, method, asked.threads);
        take(method, made)?;
    }
    refused.sort_unstable();
    refused.dedup();
    if !refused.is_empty() {
        progress.note(&format!("--backend {} does not run: {}", backend.name(), refused.join(", ")));
    }
    Ok(checks)
}

fn all_methods() -> Result<Vec<Method>> {
    let names = METHODS.iter().map(|info| match info.id {
        // What has no place in a k-buffer is blended in no order on a GPU: it is compared where all have one.
        "kbuffer" => "kbuffer:k=32",
        id => id,
    });
    Ok(names.chain(VARIANTS).map(str::parse).collect::<Result<_, _>>()?)
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

/// A scene on both sides.
struct Sides<'b, B: Backend> {
    scene: String,
    backend: &'b B,
    on_cpu: Stage,
    on_backend: B::Stage,
}

impl<'b, B: Backend> Sides<'b, B> {
    fn new(scene: String, opened: &Arc<Scene>, backend: &'b B, threads: Option<usize>) -> Result<Self> {
        let on_cpu = Cpu.stage(Arc::clone(opened), &CameraChoice::Default, threads)?;
        let on_backend = backend.stage(Arc::clone(opened), &CameraChoice::Default, threads);
        let on_backend = on_backend.map_err(|error| LabError::of_backend(backend, error))?;
        Ok(Self { scene, backend, on_cpu, on_backend })
    }

    /// One frame of a method, and a few added up.
    fn checks(&mut self, method: &Method, progress: &dyn Progress) -> Result<Vec<Check>> {
        let Self { scene, backend, on_cpu, on_backend } = self;
        let (found, counters) = render(*backend, on_backend, method, Antialiasing::NONE, 1)?;
        let (expected, expected_counters) = render(&Cpu, on_cpu, method, Antialiasing::NONE, 1)?;
        let (added_up, _) = render(*backend, on_backend, method, Antialiasing::TAA, TAA_FRAMES)?;
        let (expected_sum, _) = render(&Cpu, on_cpu, method, Antialiasing::TAA, TAA_FRAMES)?;

        // The single frame: what each pixel shows, and where and how fast that is. Both sides were advanced
        // by TAA's clock last, but edges are those of that frame.
        on_cpu.advance(Clock::new(&settings(0), Antialiasing::NONE).at(0));
        let tolerance = Tolerance::of(method);
        let single = Disagreement::measure(on_cpu, &expected, &found, tolerance)?;
        // What has no place in a k-buffer is summed up on a GPU, which cannot blend in order.
        let expected_merged = if method.info().id == "kbuffer" { 0 } else { expected_counters.merged };
        let overflow = (counters.merged as f64 - expected_merged as f64) / single.pixels as f64;
        if overflow > OVERFLOW_SHARE {
            progress.warn(&format!(
                "{scene}: {method} had no place for {overflow:.2} fragments a pixel and summed them up"
            ));
        }

        // What TAA makes of several frames: colours alone, as everything else is of the last one.
        let over_time = Tolerance { colour_share: TAA_SHARE, inside_share: None, ..tolerance };
        let sum = Disagreement::measure(on_cpu, &expected_sum, &added_up, over_time)?;

        let check = |what: &str, share: f64, pass: bool| Check {
            name: format!("{scene}: {method} by {}, share of {what}", backend.name()),
            source: "the CPU".to_owned(),
            closed_form: Some(Value::Number(0.0)),
            paper: None,
            measured: Some(Value::Number(share)),
            samples: Some(single.pixels as u64),
            z: None,
            pass,
        };
        let mut checks = vec![
            check("other pixels", single.picture_share(), single.shows_same(tolerance)),
            check(
                "other depth, motion or transparency",
                single.surface_share(),
                single.has_same_surfaces(tolerance),
            ),
            check("other pixels under taa", sum.picture_share(), sum.shows_same(over_time)),
        ];
        // Layers are told apart where one fragment is shaded.
        if method.family().shades_one_fragment() {
            let (layered, _) = render(*backend, on_backend, method, Antialiasing::LAYERED, TAA_FRAMES)?;
            let (expected, _) = render(&Cpu, on_cpu, method, Antialiasing::LAYERED, TAA_FRAMES)?;
            let layered = Disagreement::measure(on_cpu, &expected, &layered, over_time)?;
            checks.push(check(
                "other pixels under layered",
                layered.picture_share(),
                layered.shows_same(over_time),
            ));
        }
        Ok(checks)
    }
}

/// What both sides render with: not the first frame, whose number is 0 in every hash.
fn settings(seed: u32) -> Settings {
    Settings { size: SIZE, first_frame: 4, seed, ..Settings::default() }
}

/// The last picture of a run, and what the run cost.
fn render<B: Backend>(
    backend: &B,
    stage: &mut B::Stage,
    method: &Method,
    antialiasing: Antialiasing,
    frames: u32,
) -> Result<(Planes, Counters)> {
    picture(backend, stage, method, antialiasing, settings(0), frames)
}

/// Stochastic transparency of layers that cover all pixels: the CPU's picture under the method that draws the
/// same masks, and, as what is seen of the background has no bias under any estimator, the closed form of its
/// mean (ST sections 3.1 to 3.4).
fn layers<B: Backend>(backend: &B, method: &Method, threads: Option<usize>) -> Result<Vec<Check>> {
    let (count, alpha) = LAYERS;
    let text = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
    let mut sides = Sides::new(text.clone(), &Arc::new(sheer_gallery::open(&text)?.scene), backend, threads)?;
    let twin = backend.twin(method).map_err(|error| LabError::of_backend(backend, error))?;
    let tolerance = Tolerance::of(method);

    let mut seen = Moments::default();
    let mut others = 0.0;
    for seed in 0..LAYER_FRAMES {
        let Sides { on_backend, .. } = &mut sides;
        let (found, _) = picture(backend, on_backend, method, Antialiasing::NONE, settings(seed), 1)?;
        let (expected, _) = picture(&Cpu, &mut sides.on_cpu, &twin, Antialiasing::NONE, settings(seed), 1)?;
        others += Disagreement::measure(&sides.on_cpu, &expected, &found, tolerance)?.picture_share();
        // Red and green layers before blue.
        found.colour.as_slice().iter().for_each(|&[_, _, blue, _]| seen.add(blue.into()));
    }

    let others = others / f64::from(LAYER_FRAMES);
    let transmittance = (1.0 - f64::from(alpha)).powi(count as i32);
    // The product of what the layers let through is rounded once a layer, that with the background once more.
    // It is the same rounding in every pixel, so that no mean takes it away: a bound, not a deviation.
    let rounding = f64::from(count + 1) * HALF_ROUNDING * transmittance;
    let difference = seen.mean() - transmittance;
    let beyond_rounding = (difference.abs() - rounding).max(0.0).copysign(difference);
    let name = |what: &str| format!("{method} by {}: {what} of {count}×{alpha}", backend.name());
    Ok(vec![
        Check {
            name: name("share of other pixels"),
            source: "the CPU".to_owned(),
            closed_form: Some(Value::Number(0.0)),
            paper: None,
            measured: Some(Value::Number(others)),
            samples: Some(seen.count()),
            z: None,
            pass: others <= tolerance.colour_share,
        },
        Check {
            name: name("transmittance"),
            source: "ST section 3.1".to_owned(),
            closed_form: Some(Value::Number(transmittance)),
            paper: None,
            measured: Some(Value::Number(seen.mean())),
            samples: Some(seen.count()),
            z: Some(z_score(beyond_rounding, seen.variance_of_mean().sqrt())),
            pass: false,
        },
    ])
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use sheer_image::DisplayShare;
    use sheer_render::{Pipeline, RenderError, StepTime, Timings, backend::StepClock};

    use super::*;
    use crate::{Silent, verify::check::judge};

    /// The CPU with a fault.
    struct Faulty {
        /// What it renders in place of a method.
        method: fn(&Method) -> Method,
        /// What becomes of a picture.
        planes: fn(&mut Planes),
        /// Fragments without a place.
        merged: u64,
    }

    const SOUND: Faulty = Faulty { method: Method::clone, planes: |_| (), merged: 0 };

    impl Backend for Faulty {
        type Stage = Stage;
        type Pipeline = Pipeline;
        type Error = RenderError;

        fn name(&self) -> &'static str {
            "faulty"
        }

        fn adapter(&self) -> String {
            Cpu.adapter()
        }

        fn stage(
            &self,
            scene: Arc<Scene>,
            camera: &CameraChoice,
            threads: Option<usize>,
        ) -> Result<Stage, RenderError> {
            Cpu.stage(scene, camera, threads)
        }

        fn threads(&self, stage: &Stage) -> usize {
            Cpu.threads(stage)
        }

        fn look_from(&self, stage: &mut Stage, pose: sheer_scene::CameraPose) {
            Cpu.look_from(stage, pose);
        }

        fn advance(&self, stage: &mut Stage, moment: sheer_render::Moment) -> Result<(), RenderError> {
            Cpu.advance(stage, moment)
        }

        fn pipeline(
            &self,
            method: &Method,
            antialiasing: Antialiasing,
            settings: Settings,
        ) -> Result<Pipeline, RenderError> {
            Cpu.pipeline(&(self.method)(method), antialiasing, settings)
        }

        fn is_unsupported(&self, error: &RenderError) -> bool {
            Cpu.is_unsupported(error)
        }

        fn twin(&self, method: &Method) -> Result<Method, RenderError> {
            Cpu.twin(method)
        }

        fn render(
            &self,
            pipeline: &mut Pipeline,
            stage: &mut Stage,
            index: u32,
        ) -> Result<(Counters, Timings), RenderError> {
            let (counters, timings) = Cpu.render(pipeline, stage, index)?;
            Ok((Counters { merged: counters.merged + self.merged, ..counters }, timings))
        }

        fn reset_history(&self, pipeline: &mut Pipeline) {
            Cpu.reset_history(pipeline);
        }

        fn planes<'p>(&self, pipeline: &'p Pipeline) -> Result<Cow<'p, Planes>, RenderError> {
            let mut planes = pipeline.planes().clone();
            (self.planes)(&mut planes);
            Ok(Cow::Owned(planes))
        }

        fn display_share(
            &self,
            stage: &Stage,
            settings: &Settings,
            antialiasing: Antialiasing,
        ) -> Result<DisplayShare, RenderError> {
            Cpu.display_share(stage, settings, antialiasing)
        }

        fn steps<'p>(&self, pipeline: &'p Pipeline) -> &'p [StepTime] {
            Cpu.steps(pipeline)
        }

        fn step_clock(&self) -> StepClock {
            Cpu.step_clock()
        }

        fn notes<'p>(&self, pipeline: &'p Pipeline) -> &'p [String] {
            Cpu.notes(pipeline)
        }

        fn bytes_per_pixel(&self, pipeline: &Pipeline, hits_per_pixel: f64) -> f64 {
            Cpu.bytes_per_pixel(pipeline, hits_per_pixel)
        }
    }

    /// Which checks of a method pass, in `layers` where the method is not a sampled one.
    fn passes(backend: &Faulty, method: &str) -> Vec<bool> {
        let scene = "layers:count=4,alpha=0.3,colours=rainbow";
        let asked = Twins {
            scenes: vec![(scene.to_owned(), Arc::new(sheer_gallery::open(scene).unwrap().scene))],
            methods: vec![method.parse().unwrap()],
            ..Twins::default()
        };
        let mut checks = twins(backend, &asked, &Silent).unwrap();
        judge(&mut checks);
        checks.iter().map(|check| check.pass).collect()
    }

    #[test]
    fn the_cpu_is_its_own_twin() {
        assert_eq!(passes(&SOUND, "std"), [true; 4]);
        for method in ["peel", "weighted"] {
            assert_eq!(passes(&SOUND, method), [true; 3], "{method}");
        }
        for method in ["stochastic", "stochastic:samples=4,estimator=basic,correct=off"] {
            assert_eq!(passes(&SOUND, method), [true; 2], "{method}");
        }
    }

    #[test]
    fn the_variant_of_stochastic_transparency_that_was_asked_for_is_tested() {
        // Another estimator draws the same masks and has the same mean of what is seen of the background.
        let other = |_: &Method| "stochastic:estimator=basic,correct=off".parse().unwrap();
        assert_eq!(passes(&Faulty { method: other, ..SOUND }, "stochastic:correct=off"), [false, true]);
        // Layers that hide one another in all samples or in none have another transmittance.
        let other = |_: &Method| "stochastic:masks=a2c,correct=off".parse().unwrap();
        assert_eq!(passes(&Faulty { method: other, ..SOUND }, "stochastic:correct=off"), [false, false]);
    }

    #[test]
    fn ids_depth_and_taa_are_compared() {
        let ids = |planes: &mut Planes| planes.primitive.as_mut_slice().iter_mut().for_each(|id| *id ^= 1);
        for method in ["baseline", "list", "peel", "kbuffer", "mlab"] {
            let faulty = Faulty { planes: ids, ..SOUND };
            assert!(!passes(&faulty, method)[0], "{method}");
        }
        let depth = |planes: &mut Planes| planes.depth.as_mut_slice().iter_mut().for_each(|z| *z *= 1.01);
        assert_eq!(passes(&Faulty { planes: depth, ..SOUND }, "std"), [true, false, true, true]);
        // What is added up shows in colours alone.
        let dim = |planes: &mut Planes| {
            for pixel in planes.colour.as_mut_slice() {
                *pixel = pixel.map(|value| 0.9 * value);
            }
        };
        assert_eq!(passes(&Faulty { planes: dim, ..SOUND }, "std")[2..], [false, false]);
    }

    #[test]
    fn a_failed_comparison_stays_a_failure_where_memory_ran_out() {
        let wrong = |planes: &mut Planes| planes.colour.as_mut_slice().fill([0.5; 4]);
        let overflowing = Faulty { planes: wrong, merged: 1_000_000, ..SOUND };
        assert!(!passes(&overflowing, "list")[0]);
    }
}

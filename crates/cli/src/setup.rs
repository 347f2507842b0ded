//! From arguments to a stage that can be rendered.

use std::{env, path::Path, sync::Arc};

use anyhow::Context as _;
use glam::Vec3;
use rayon::ThreadPoolBuilder;
use sheer_core::parameter::Choice as _;
use sheer_image::{Metadata, TextureLimits, Tone, read_panorama};
use sheer_lab::{Figures, file_name_from};
use sheer_load::LoadOptions;
use sheer_render::{Antialiasing, Backend, Method, RenderError, Settings, Shadow, limits::MOST_THREADS};
use sheer_scene::{Camera, CameraChoice, Environment, Lens, Scene, SceneError, Viewpoint};

use crate::{
    args::{
        EnvironmentChoice, FrameArguments, FrameSpan, LightArguments, LoadArguments, MachineArguments,
        SceneArguments, SeedsArguments, Size, ToneArguments, ViewArguments,
    },
    console::Console,
    failure::Misuse,
    memory,
    report::{inspection::view_options, json::Run},
    version::{COMMIT, VERSION},
};

/// Refuses what the environment asks for and no machine has: rayon would start as many threads as it is told.
pub(crate) fn check_environment() -> anyhow::Result<()> {
    for variable in ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"] {
        let Some(threads) = env::var_os(variable) else { continue };
        // What is no number counts for nothing.
        let is_number = |text: &&str| text.bytes().all(|byte| byte.is_ascii_digit());
        let Some(threads) = threads.to_str().filter(is_number) else { continue };
        if threads.parse::<usize>().map_or(!threads.is_empty(), |threads| threads > MOST_THREADS) {
            let problem =
                format!("{variable} is {threads}; set it to {MOST_THREADS} at most, or leave it out");
            return Err(Misuse(problem).into());
        }
    }
    Ok(())
}

impl MachineArguments {
    /// Limits the threads that work beside the stage's own, and memory, and tells how much may be said.
    pub(crate) fn apply(self) -> anyhow::Result<Console> {
        memory::limit(self.memory_limit);
        let pool = ThreadPoolBuilder::new().num_threads(self.threads.unwrap_or(0));
        pool.build_global().map_err(RenderError::from)?;
        Ok(Console { quiet: self.quiet, progress: self.progress })
    }
}

impl FrameArguments {
    /// The library's settings; `default_size` where the user named none.
    ///
    /// # Errors
    /// The first frame is given twice.
    pub(crate) fn settings(&self, default_size: Size) -> anyhow::Result<Settings> {
        let first_frame = match (self.frames, self.first_frame) {
            (Some(FrameSpan::From(..)), Some(_)) => {
                let problem = "--frames names the first frame already: leave out --first-frame, or give --frames a number";
                return Err(Misuse(problem.to_owned()).into());
            }
            (Some(FrameSpan::From(first, _)), None) => first,
            (Some(FrameSpan::Count(_)) | None, first) => first.unwrap_or(0),
        };
        Ok(Settings {
            size: self.size.unwrap_or(default_size).0,
            crop: None,
            seed: self.seed,
            background: self.background,
            shadow: Shadow::default(),
            start_secs: self.time,
            first_frame,
            frames_per_sec: self.fps,
            raw: false,
            tone: Tone::default(),
        })
    }

    /// How many frames.
    pub(crate) fn count(&self) -> u32 {
        let (FrameSpan::Count(count) | FrameSpan::From(_, count)) = self.frames.unwrap_or(FrameSpan::DEFAULT);
        count
    }
}

impl SeedsArguments {
    /// All of them.
    pub(crate) fn from(self, first: u32) -> Vec<u32> {
        (0..self.seeds).map(|at| first.wrapping_add(at)).collect()
    }

    /// What reports say of them: nothing where it is one.
    pub(crate) fn count(self) -> Option<u32> {
        (self.seeds > 1).then_some(self.seeds)
    }

    /// Says what figures over seeds are, and whose are certain.
    pub(crate) fn explain(self, figures: &Figures, console: Console) {
        if self.seeds == 1 {
            return;
        }
        console.note(format_args!(
            "figures are means over {} seeds ± half of the 95 % confidence interval (Student's t)",
            self.seeds
        ));
        note_certain(figures, console);
    }
}

/// Says what an interval of nothing means.
pub(crate) fn note_certain(figures: &Figures, console: Console) {
    let certain = figures.certain();
    if !certain.is_empty() {
        console.note(format_args!(
            "the same with every seed, which is why the interval is ±0: {}",
            certain.join(", ")
        ));
    }
}

impl LightArguments {
    /// The same settings under this light.
    pub(crate) fn under(self, settings: Settings) -> Settings {
        Settings { shadow: self.shadow, tone: self.tone.tone(), ..settings }
    }
}

impl ToneArguments {
    pub(crate) fn tone(self) -> Tone {
        Tone { curve: self.tone, exposure_ev: self.exposure }
    }
}

impl LoadArguments {
    /// The library's options.
    pub(crate) fn options(&self) -> LoadOptions {
        LoadOptions {
            strict: self.strict,
            allowed_folders: self.allowed_folders.clone(),
            memory_limit: Some(memory::left_by_the_program()),
            clip: self.clip.clone(),
            scene: self.scene.clone(),
            variant: self.variant.clone(),
        }
    }
}

/// An opened scene.
#[derive(Debug)]
pub(crate) struct Opened<S> {
    /// Ready to be rendered.
    pub(crate) stage: S,
    /// What it shows.
    pub(crate) view: View,
}

/// What a stage was made of.
#[derive(Debug)]
pub(crate) struct View {
    scene: Arc<Scene>,
    camera: Camera,
}

impl View {
    /// What tells the scene apart by its contents; takes time.
    pub(crate) fn scene_hash(&self) -> String {
        format!("{:016x}", self.scene.content_hash())
    }

    /// Where the camera is at a time, as the options of `sheer render` that would put it there.
    pub(crate) fn pose(&self, time_secs: f32) -> String {
        let pose = self.scene.pose(&self.camera, time_secs);
        view_options(&pose, pose.lens, 1.0)
    }
}

impl SceneArguments {
    /// Name for output files: that of the scene, or of its file, in characters that no shell or file system
    /// minds.
    pub(crate) fn file_stem(&self) -> String {
        let path = Path::new(&self.text);
        let stem = path.file_stem().map_or(self.text.as_str().into(), |stem| stem.to_string_lossy());
        // Parameters of built-in scenes stay out.
        file_name_from(stem.split(':').next().unwrap_or_default())
    }

    /// Loads the scene, to be seen in pictures of `size` pixels.
    pub(crate) fn load(&self, size: [u32; 2], console: Console) -> anyhow::Result<Arc<Scene>> {
        memory::start(&self.text);
        let loaded = sheer_gallery::open_with(&self.text, &self.load.options())?;
        for warning in &loaded.warnings {
            console.warn(format_args!("{}: {warning}", self.text));
        }
        let scene = self.surrounded(loaded.scene)?.framed_for(size);
        Ok(Arc::new(match self.alpha {
            Some(alpha) => scene.with_alpha(alpha),
            None => scene,
        }))
    }

    /// The scene in the surroundings that were asked for.
    fn surrounded(&self, scene: Scene) -> anyhow::Result<Scene> {
        let environment = match &self.environment {
            EnvironmentChoice::Scene => scene.parts().environment.clone(),
            EnvironmentChoice::Named(named) => (named.make)(),
            EnvironmentChoice::File(path) => {
                Environment::from_panorama(&read_panorama(path, TextureLimits::default())?)?
            }
        };
        Ok(scene.with_environment(environment.scaled(self.environment_strength)))
    }

    /// Loads the scene and builds what rendering pictures of `size` pixels needs.
    pub(crate) fn open<B: Backend>(
        &self,
        backend: &B,
        size: [u32; 2],
        machine: MachineArguments,
        console: Console,
    ) -> anyhow::Result<Opened<B::Stage>> {
        let scene = self.load(size, console)?;
        let camera = self.view.camera(self.camera.clone().unwrap_or_default(), &scene)?;
        let stage = backend
            .stage(Arc::clone(&scene), &camera, machine.threads)
            .with_context(|| format!("cannot set up {}", self.text))?;
        let camera = scene.camera(&camera)?;
        Ok(Opened { stage, view: View { scene, camera } })
    }
}

impl ViewArguments {
    /// The scene's camera of choice, or what these arguments make of it.
    ///
    /// # Errors
    /// The scene has no such camera, or it is to look at where it is.
    fn camera(&self, choice: CameraChoice, scene: &Scene) -> anyhow::Result<CameraChoice> {
        let lens = match (self.fov, self.ortho) {
            (Some(degrees), _) => Some(Lens::Perspective { yfov_rad: degrees.to_radians() }),
            (None, Some(height)) => Some(Lens::Orthographic { half_height: 0.5 * height }),
            (None, None) => None,
        };
        let viewpoint = Viewpoint { eye: self.eye, target: self.target, up: self.up, lens };
        viewpoint.camera(choice, scene).map_err(|error| match error {
            SceneError::NoDirection => {
                let problem = "--eye and --target are the same point: there is no direction to look in";
                Misuse(problem.to_owned()).into()
            }
            other => other.into(),
        })
    }

    /// As it was typed; empty where nothing was.
    fn typed(&self) -> String {
        let vectors = [("eye", self.eye), ("target", self.target), ("up", self.up)];
        let vectors = vectors.map(|(key, value)| value.map(|Vec3 { x, y, z }| format!("{key}={x},{y},{z}")));
        let numbers = [("fov", self.fov), ("ortho", self.ortho)];
        let numbers = numbers.map(|(key, value)| value.map(|value| format!("{key}={value}")));
        vectors.into_iter().chain(numbers).flatten().collect::<Vec<_>>().join(" ")
    }
}

impl SceneArguments {
    /// The view as reports name it: `default`, `orbit`, a camera's name, or what else was asked for.
    fn view_name(&self) -> String {
        let camera = match &self.camera {
            None if self.view.eye.is_some() => "",
            None | Some(CameraChoice::Default | CameraChoice::Own(_)) => "default",
            Some(CameraChoice::Orbit) => "orbit",
            Some(CameraChoice::Named(name)) => name,
        };
        format!("{camera} {}", self.view.typed()).trim().to_owned()
    }
}

/// How a picture was made, for its file.
pub(crate) fn metadata(
    backend: &impl Backend,
    scene: &SceneArguments,
    method: &Method,
    aa: Antialiasing,
    settings: &Settings,
) -> Metadata {
    Metadata::default()
        .with("scene", &scene.text)
        .with("camera", scene.view_name())
        .with("environment", &scene.environment)
        .with("environment_strength", scene.environment_strength)
        .with("method", method)
        .with("aa", aa)
        .with("shadow", settings.shadow)
        .with("background", settings.background)
        .with("fps", settings.frames_per_sec)
        .with("seed", settings.seed)
        .with("backend", backend.name())
        .with("commit", COMMIT)
        .with("version", VERSION)
}

/// How figures of many scenes came about.
pub(crate) fn describe_many(backend: &impl Backend, settings: &Settings) -> Run {
    let scene = SceneArguments::of("many");
    describe_scene(backend, &scene, String::new(), rayon::current_num_threads(), settings, 0)
}

/// How figures came about, for reports.
pub(crate) fn describe<B: Backend>(
    backend: &B,
    scene: &SceneArguments,
    opened: &Opened<B::Stage>,
    settings: &Settings,
    frames: u32,
) -> Run {
    let threads = backend.threads(&opened.stage);
    describe_scene(backend, scene, opened.view.scene_hash(), threads, settings, frames)
}

fn describe_scene(
    backend: &impl Backend,
    scene: &SceneArguments,
    scene_hash: String,
    threads: usize,
    settings: &Settings,
    frames: u32,
) -> Run {
    Run {
        scene: scene.text.clone(),
        scene_hash,
        camera: scene.view_name(),
        alpha: scene.alpha,
        size: settings.size,
        frames,
        first_frame: settings.first_frame,
        time_secs: settings.start_secs,
        shadow: settings.shadow.to_string(),
        environment: scene.environment.to_string(),
        environment_strength: scene.environment_strength,
        tone: settings.tone.curve.word(),
        exposure_ev: settings.tone.exposure_ev,
        backend: backend.name(),
        adapter: backend.adapter(),
        seed: settings.seed,
        seeds: None,
        version: VERSION,
        commit: COMMIT,
        threads,
    }
}

/// Each thing once, in the order in which they came first.
pub(crate) fn without_repeats<T: Clone + PartialEq>(things: &[T]) -> Vec<T> {
    let mut once: Vec<T> = Vec::new();
    for thing in things {
        if !once.contains(thing) {
            once.push(thing.clone());
        }
    }
    once
}

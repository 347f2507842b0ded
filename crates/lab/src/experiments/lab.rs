//! What experiments work with.

use std::{borrow::Cow, sync::Arc};

use sheer_image::{DisplayShare, Planes, Tone, display};
use sheer_load::LoadOptions;
use sheer_render::{Antialiasing, Backend, Clock, Method, Moment, Settings};
use sheer_scene::CameraChoice;

use super::{
    claims::Sample,
    findings::{Findings, Picture},
};
use crate::{
    Clip, Figures, LabError, Measured, Progress, Reference, Result, Tally, Timeline, Truth,
    foreign::Beside,
    measure_cost,
    plot::{Axis, Plot, Series},
    selected_figures, with_reference,
};

/// What all experiments of a run have in common.
pub struct Lab<'a, B: Backend> {
    /// What renders.
    pub backend: &'a B,
    /// Width and height of pictures, pixels.
    pub size: [u32; 2],
    /// Seed of the dithering, the first of several.
    pub seed: u32,
    /// How many seeds claims rest on, each one more than the one before; at least one.
    pub seed_count: u32,
    /// Threads to use, all the processor's by default.
    pub threads: Option<usize>,
    /// Steps with every frame.
    pub progress: &'a dyn Progress,
    /// Scene files of the user's own.
    pub files: &'a [String],
    /// How they are read.
    pub load: &'a LoadOptions,
}

/// A clip to be played.
#[derive(Clone, Copy, Debug)]
pub(super) struct Take<'a> {
    pub(super) scene: &'a str,
    pub(super) alpha: Option<f32>,
    /// `static`, `path` or `orbit`.
    pub(super) camera: &'a str,
    /// Of the first frame, seconds.
    pub(super) start_secs: f32,
    pub(super) frames: u32,
    pub(super) antialiasing: Antialiasing,
    pub(super) methods: &'a [&'a str],
    /// Samples a pixel of the truth, where methods are held against it as well.
    pub(super) truth_samples: Option<u32>,
}

impl Take<'_> {
    /// The command that plays it.
    fn command(&self, [width, height]: [u32; 2]) -> String {
        let alpha = self.alpha.map(|alpha| format!(" --alpha {alpha}")).unwrap_or_default();
        let methods: String = self.methods.iter().map(|method| format!(" -m {method}")).collect();
        let references = self.truth_samples.map(|samples| {
            format!(" --reference {} --reference {}", Reference::Same, Reference::Truth { samples })
        });
        let references = references.unwrap_or_default();
        format!(
            "sheer compare {}{alpha} --camera {} --time {} --frames {} --size {width}x{height} -a {}{methods}{references}",
            self.scene, self.camera, self.start_secs, self.frames, self.antialiasing
        )
    }
}

impl<B: Backend> Lab<'_, B> {
    /// Opens a scene.
    pub(super) fn open(&self, scene: &str, camera: &str, alpha: Option<f32>) -> Result<B::Stage> {
        let camera = match camera {
            "orbit" => CameraChoice::Orbit,
            name => CameraChoice::Named(name.to_owned()),
        };
        // What a file asks for in vain was said when the user rendered it; here it would drown the findings.
        let loaded = sheer_gallery::open_with(scene, self.load)?.scene;
        let loaded = match alpha {
            Some(alpha) => loaded.with_alpha(alpha),
            None => loaded,
        };
        let stage = self.backend.stage(Arc::new(loaded), &camera, self.threads);
        stage.map_err(|error| LabError::SetUp { scene: scene.to_owned(), source: error.into() })
    }

    /// The seeds that claims rest on.
    pub(super) fn seeds(&self) -> impl Iterator<Item = u32> + use<B> {
        let first = self.seed;
        (0..self.seed_count.max(1)).map(move |at| first.wrapping_add(at))
    }

    /// Settings of a clip.
    #[must_use]
    pub fn settings(&self, start_secs: f32) -> Settings {
        Settings { size: self.size, seed: self.seed, start_secs, ..Settings::default() }
    }

    /// Prepares methods that differ in nothing else.
    pub(super) fn pipelines(
        &self,
        methods: &[&str],
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> Result<Vec<B::Pipeline>> {
        let methods = methods.iter().map(|method| method.parse()).collect::<Result<Vec<Method>, _>>()?;
        crate::play::pipelines(self.backend, &methods, antialiasing, settings)
    }

    /// The picture of a pipeline so far.
    pub(super) fn planes<'p>(&self, pipeline: &'p B::Pipeline) -> Result<Cow<'p, Planes>> {
        self.backend.planes(pipeline).map_err(|error| LabError::of_backend(self.backend, error))
    }

    /// Plays a clip with its methods, each with all seeds, and the reference.
    pub(super) fn play(&self, take: &Take<'_>) -> Result<Played> {
        self.play_with(take, &mut self.truth(take))
    }

    /// What the methods of a clip are held against, where it asks for that: clips that differ in their
    /// anti-aliasing alone share it.
    pub(super) fn truth(&self, take: &Take<'_>) -> Option<Truth> {
        take.truth_samples.map(|samples| Truth::new(self.settings(take.start_secs), samples))
    }

    /// The same with a [`Self::truth`] that other clips share.
    pub(super) fn play_with(&self, take: &Take<'_>, truth: &mut Option<Truth>) -> Result<Played> {
        let methods = take.methods.iter().map(|method| method.parse()).collect::<Result<Vec<_>, _>>()?;
        let methods = with_reference(methods)?;
        let mut stage = self.open(take.scene, take.camera, take.alpha)?;
        let clip = Clip {
            settings: self.settings(take.start_secs),
            antialiasing: take.antialiasing,
            frame_count: take.frames,
            keeps_frames: false,
        };
        self.progress.name(take.scene.split(':').next().unwrap_or_default());
        let seeds: Vec<u32> = self.seeds().collect();
        let (contestants, nothing) = ((&methods[..], &seeds[..]), &mut Beside::default());
        let measured =
            clip.play_seeds(self.backend, &mut stage, contestants, truth.as_mut(), nothing, self.progress)?;
        Ok(Played { command: take.command(self.size), measured })
    }

    /// Renders moments by themselves, all methods in turn at each: what a frame costs along a clip.
    pub(super) fn time(
        &self,
        stage: &mut B::Stage,
        methods: &[&str],
        moments: &[Moment],
    ) -> Result<Vec<Tally>> {
        let methods = methods.iter().map(|method| method.parse()).collect::<Result<Vec<Method>, _>>()?;
        // The cost of adding frames up is no part of a frame's time (STD section 4), so they are not added
        // up.
        let methods: Vec<_> = methods.iter().map(|method| (method, Antialiasing::NONE)).collect();
        let timeline = Timeline::Moments(moments);
        measure_cost(self.backend, stage, &methods, self.settings(0.0), timeline, false, self.progress)
    }

    /// Moments `step` frames apart.
    pub(super) fn moments(&self, start_secs: f32, count: u32, step: u32) -> Vec<Moment> {
        let clock = Clock::new(&self.settings(start_secs), Antialiasing::NONE);
        (0..count).map(|index| clock.at(index * step)).collect()
    }
}

/// What came of a clip, and the command that makes it again.
#[derive(Debug)]
pub(super) struct Played {
    pub(super) command: String,
    /// Of each method, the reference among them, one for each seed.
    measured: Vec<Vec<Measured>>,
}

impl Played {
    /// What came of a method, by its text: means over the seeds.
    pub(super) fn row(&self, method: &str) -> Measured {
        Measured::mean(self.find(method).expect("the method took part"))
    }

    /// A figure of a method with each of the seeds.
    pub(super) fn sample(&self, method: &str, of: impl Fn(&Measured) -> f64) -> Sample {
        Sample::new(method, self.find(method).expect("the method took part").iter().map(of).collect())
    }

    fn find(&self, method: &str) -> Option<&[Measured]> {
        let of_method = self.measured.iter().find(|runs| runs[0].method.to_string() == method)?;
        Some(of_method)
    }

    /// The figures of all methods under these titles: means over the seeds.
    pub(super) fn figures(&self, columns: &[&str]) -> Figures {
        let means: Vec<Measured> = self.measured.iter().map(|runs| Measured::mean(runs)).collect();
        selected_figures(&means, columns)
    }

    /// The pictures of some methods.
    pub(super) fn pictures<'a>(&'a self, methods: &'a [&str]) -> impl Iterator<Item = Picture> + 'a {
        methods.iter().filter_map(|method| {
            let measured = self.find(method)?.first()?;
            Some(Picture { label: measured.method.to_string(), image: measured.picture.clone() })
        })
    }
}

/// A picture of planes: the light of the built-in scenes is scene-referred.
pub(super) fn picture(label: &str, planes: &Planes) -> Picture {
    Picture {
        label: label.to_owned(),
        image: display(&planes.colour, Tone::default(), &DisplayShare::Nothing),
    }
}

/// Milliseconds over seconds, a line for each method.
pub(super) fn time_plot(moments: &[Moment], methods: &[&str], tallies: &[Tally]) -> Plot {
    let points = |tally: &Tally| -> Vec<[f64; 2]> {
        moments.iter().zip(tally.frame_ms()).map(|(at, ms)| [f64::from(at.time_secs), ms]).collect()
    };
    Plot {
        description: "Milliseconds of a frame over the seconds of the clip, one line for each method"
            .to_owned(),
        x: Axis::new("s"),
        y: Axis::new("ms").with_zero(),
        series: methods
            .iter()
            .zip(tallies)
            .map(|(method, tally)| Series::line(method, points(tally)))
            .collect(),
    }
}

/// Findings of one clip: its command, its figures, its pictures.
pub(super) fn findings_of(played: &Played, columns: &[&str], pictures: &[&str]) -> Findings {
    Findings {
        commands: vec![played.command.clone()],
        tables: vec![(String::new(), played.figures(columns))],
        pictures: played.pictures(pictures).collect(),
        ..Findings::default()
    }
}

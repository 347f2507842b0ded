//! What experiments work with, and what they hand in.

use indicatif::ProgressBar;
use sheer_image::{Metadata, Planes, ToneCurve, display, encode_png};
use sheer_render::{Antialiasing, Clock, Method, Moment, Pipeline, Settings};
use sheer_scene::CameraChoice;

use crate::{
    args::{MachineArguments, SceneArguments},
    backend::Cpu,
    clip::{Clip, with_reference},
    report::{
        chart::{Axis, Plot, Series},
        comparison,
        experiments::{Claim, Findings, Picture},
        figures::Figures,
        json::{ComparisonRow, Run},
        page::comparison::Entry,
    },
    setup::{self, Opened},
    talk::Talk,
    tally::Tally,
};

/// What all experiments of a run have in common.
#[derive(Clone, Debug)]
pub(super) struct Lab<'a> {
    /// Width and height of pictures, pixels.
    pub(super) size: [u32; 2],
    /// Seed of the dithering.
    pub(super) seed: u32,
    /// Where it runs.
    pub(super) machine: MachineArguments,
    /// Ticks with every frame.
    pub(super) progress: ProgressBar,
    /// Scene files of the user's own.
    pub(super) files: &'a [String],
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
}

impl Take<'_> {
    /// The command that plays it.
    fn command(&self, [width, height]: [u32; 2]) -> String {
        let alpha = self.alpha.map(|alpha| format!(" --alpha {alpha}")).unwrap_or_default();
        let methods: String = self.methods.iter().map(|method| format!(" -m {method}")).collect();
        format!(
            "sheer compare {}{alpha} --camera {} --time {} --frames {} --size {width}x{height} -a {}{methods}",
            self.scene, self.camera, self.start_secs, self.frames, self.antialiasing
        )
    }
}

impl Lab<'_> {
    /// Opens a scene.
    pub(super) fn open(&self, scene: &str, camera: &str, alpha: Option<f32>) -> anyhow::Result<Opened> {
        let camera = match camera {
            "orbit" => CameraChoice::Orbit,
            name => CameraChoice::Named(name.to_owned()),
        };
        let scene = SceneArguments { text: scene.to_owned(), camera: Some(camera), alpha };
        // What a file asks for in vain was said when the user rendered it; here it would drown the findings.
        scene.open(&Cpu, self.machine, Talk { quiet: true })
    }

    /// Settings of a clip.
    pub(super) fn settings(&self, start_secs: f32) -> Settings {
        Settings { size: self.size, seed: self.seed, start_secs, ..Settings::default() }
    }

    /// Plays a clip with its methods and the reference.
    pub(super) fn play(&self, take: &Take<'_>) -> anyhow::Result<Played> {
        let methods = take.methods.iter().map(|method| method.parse()).collect::<Result<Vec<_>, _>>()?;
        let methods = with_reference(methods)?;
        let mut opened = self.open(take.scene, take.camera, take.alpha)?;
        let clip = Clip {
            settings: self.settings(take.start_secs),
            antialiasing: take.antialiasing,
            frame_count: take.frames,
            keeps_frames: false,
        };
        self.progress.set_message(format!("{:<14}", take.scene.split(':').next().unwrap_or_default()));
        let entries = clip.play(&Cpu, &mut opened.stage, &methods, |_| (), || self.progress.inc(1))?;
        let scene = SceneArguments { text: take.scene.to_owned(), camera: None, alpha: take.alpha };
        let run = setup::describe(&Cpu, &scene, &opened, &clip.settings, take.frames);
        Ok(Played { command: take.command(self.size), run, entries })
    }

    /// Renders moments by themselves, all methods in turn at each: what a frame costs along a clip.
    pub(super) fn time(
        &self,
        opened: &mut Opened,
        methods: &[&str],
        moments: &[Moment],
    ) -> anyhow::Result<Vec<Tally>> {
        let settings = self.settings(0.0);
        let pipelines = methods
            .iter()
            .map(|method| Ok(Pipeline::new(method.parse::<Method>()?, Antialiasing::None, settings)?));
        let mut pipelines = pipelines.collect::<anyhow::Result<Vec<_>>>()?;
        let mut tallies = vec![Tally::default(); methods.len()];
        for (index, &moment) in (0_u32..).zip(moments) {
            opened.stage.advance(moment);
            for turn in 0..methods.len() {
                let at = (turn + index as usize) % methods.len();
                tallies[at].add(pipelines[at].render(&opened.stage, index)?);
                self.progress.inc(1);
            }
        }
        Ok(tallies)
    }

    /// Moments `step` frames apart.
    pub(super) fn moments(&self, start_secs: f32, count: u32, step: u32) -> Vec<Moment> {
        let clock = Clock::new(&self.settings(start_secs), Antialiasing::None);
        (0..count).map(|index| clock.at(index * step)).collect()
    }
}

/// What came of a clip, and the command that makes it again.
#[derive(Debug)]
pub(super) struct Played {
    pub(super) command: String,
    run: Run,
    pub(super) entries: Vec<Entry>,
}

impl Played {
    /// The figures of a method, by its text.
    pub(super) fn row(&self, method: &str) -> &ComparisonRow {
        let entry = self.entries.iter().find(|entry| entry.row.method == method);
        &entry.expect("the method took part").row
    }

    /// All figures.
    pub(super) fn figures(&self, columns: &[&str]) -> Figures {
        let rows: Vec<_> = self.entries.iter().map(|entry| entry.row.clone()).collect();
        comparison::selected_figures(&self.run, &rows, columns)
    }

    /// The pictures of some methods.
    pub(super) fn pictures<'a>(&'a self, methods: &'a [&str]) -> impl Iterator<Item = Picture> + 'a {
        methods.iter().filter_map(|method| {
            let entry = self.entries.iter().find(|entry| entry.row.method == **method)?;
            Some(Picture { label: entry.row.method.clone(), png: entry.picture_png.clone() })
        })
    }
}

/// A picture of planes.
pub(super) fn picture(label: &str, planes: &Planes) -> anyhow::Result<Picture> {
    let shown = display(&planes.colour, ToneCurve::default());
    Ok(Picture { label: label.to_owned(), png: encode_png(&shown, &Metadata::default())? })
}

/// A claim of the paper, or of ours, and whether it held.
pub(super) fn claim(text: impl Into<String>, holds: bool) -> Claim {
    Claim { text: text.into(), holds }
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

//! The command line.

use std::{
    fmt, iter,
    path::{Path, PathBuf},
    str::FromStr,
};

use clap::{Args, Parser, Subcommand, ValueEnum, builder::RangedU64ValueParser, value_parser};
use clap_complete::Shell;
use glam::Vec3;
use sheer_core::{
    coverage::Correction,
    parameter::{Choice as _, split_name},
    suggestion::suggestion,
    text::MemorySize,
};
use sheer_gpu::{AdapterChoice, GpuPathChoice};
use sheer_image::{Region, ToneCurve, read_whole};
use sheer_lab::Reference;
use sheer_render::{
    Antialiasing, Backend, Background, Method, Shadow,
    backend::Cpu,
    limits::{
        FIELDS_OF_VIEW_DEGREES, FRAME_RATES, LAST_FRAME, LONGEST_SIDE_PX, MOST_EXPOSURE_EV, MOST_FRAMES,
        MOST_SAMPLES, MOST_STRENGTH, MOST_THREADS,
    },
};
use sheer_scene::{
    CameraChoice,
    environment::{NAMED, NamedEnvironment},
};

use crate::output;

/// Order-independent transparency: render, compare, measure.
#[derive(Debug, Parser)]
#[command(
    name = "sheer",
    version = concat!(env!("CARGO_PKG_VERSION"), " (", env!("SHEER_COMMIT"), ")"),
    arg_required_else_help = false,
    max_term_width = 100,
    after_help = "Exit codes: 0 done, 1 failed, 2 wrong use, 130 interrupted."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the built-in scenes.
    Scenes(ListArguments),
    /// List the transparency methods.
    Methods(ListArguments),
    /// List the GPUs of this machine and what they can run.
    Devices(DevicesArguments),
    /// Tell what a file or a built-in scene holds and what becomes of it.
    Inspect(InspectArguments),
    /// Render a picture or a sequence of frames.
    Render(RenderArguments),
    /// Put crops and sample ranges of a picture together again.
    Merge(MergeArguments),
    /// Compare methods with the exact answer: a table, a page and figures for programs.
    Compare(CompareArguments),
    /// Hold pictures from anywhere against a reference: SSIM, PSNR, FLIP, RMS, bias.
    Metrics(MetricsArguments),
    /// Measure what methods cost.
    Bench(BenchArguments),
    /// Measure what a method shows of ten opacities and fit the correction for it.
    Calibrate(CalibrateArguments),
    /// Make the papers' figures again, measure them and write one report.
    Experiments(ExperimentsArguments),
    /// Check the papers' numbers and the methods' promises: closed form, printed, measured; or hold a GPU
    /// against the CPU.
    Verify(VerifyArguments),
    /// Print what a shell needs to complete the command line.
    Completions(CompletionsArguments),
    /// Write the manual pages, one a command.
    #[command(hide = true)]
    Man(ManArguments),
}

#[derive(Args, Debug)]
pub(crate) struct ListArguments {
    /// Show the parameters as well, set as NAME:KEY=VALUE,KEY=VALUE.
    #[arg(long)]
    pub(crate) long: bool,
}

#[derive(Args, Debug)]
pub(crate) struct DevicesArguments {
    /// File for the same in JSON, - for stdout in place of the table.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct InspectArguments {
    /// Scene file, or built-in scene, NAME or NAME:KEY=VALUE,….
    #[arg(value_name = "FILE")]
    pub(crate) text: String,
    #[command(flatten)]
    pub(crate) load: LoadArguments,
    /// File for the same in JSON, - for stdout in place of the text.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct RenderArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Transparency method, NAME or NAME:KEY=VALUE,…; `sheer methods` lists them.
    #[arg(short, long, default_value = "joint", value_parser = method)]
    pub(crate) method: Method,
    /// none: one sample through each pixel centre; accumulate: the mean of the frames of one moment; taa:
    /// frames play and add up; layered: the same for what is transparent and what lies behind it, each by
    /// itself. Keys as those of methods: taa:weight=0.05,radius=2.
    #[arg(short = 'a', long = "aa", value_name = "AA", default_value = "layered")]
    pub(crate) antialiasing: Antialiasing,
    /// .png (sRGB, straight alpha) or .exr (linear, with depth, motion, ids, the mask of transparent pixels,
    /// and layers under `-a layered`); `####` or `%04d` in its name: every frame. .mp4 or .webm: a video of
    /// all frames, which an installed ffmpeg makes.
    ///
    /// sheer-out/SCENE.png if not given, .exr with --raw. A .webm keeps what --background none leaves
    /// transparent.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Write each frame as it was rendered, not added up: its one sample a pixel, the layers of methods that
    /// shade one fragment, depth, motion and ids, with its jitter beside them; to .exr, on the CPU.
    ///
    /// What a temporal technique or an upscaler is fed with, or learns from. Samples are offset from the
    /// pixel centres by sheer.jitter.X and sheer.jitter.Y (pixels, y down), attributes of the file like
    /// sheer.frame and sheer.seed; -a says how: none does not jitter. Without `####` in the name it is the
    /// first frame.
    #[arg(long)]
    pub(crate) raw: bool,
    /// Final frames: each is the mean of so many jittered samples of its own moment, while the clip plays,
    /// and owes nothing to those before it. In place of -a; one picture shows the first frame.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)), conflicts_with_all = ["antialiasing", "raw"])]
    pub(crate) samples: Option<u32>,
    /// Motion blur of --samples: the share of the time from frame to frame that the shutter is open, around
    /// the frame's moment; 0.5 is usual for film.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = shutter, requires = "samples")]
    pub(crate) shutter: f32,
    /// A part of the picture alone, in pixels of --size from the upper left corner: the same pixels as in the
    /// whole picture, to the bit under -a none, -a accumulate and --samples; on the CPU. An .exr file knows
    /// where it lies, `sheer merge` puts such files together.
    ///
    /// Under taa and layered it is so while nothing moves; what moves brings in what has not been rendered
    /// (docs/farm.md says what is left of it).
    #[arg(long, value_name = "X,Y,W,H")]
    pub(crate) crop: Option<Region>,
    /// Pixels around --crop that are rendered for the histories of taa and layered and not written [default:
    /// what they look at].
    #[arg(long, value_name = "N", requires = "crop")]
    pub(crate) margin: Option<u32>,
    /// Some of the samples of -a accumulate (of which there are as many as --frames) or of --samples alone:
    /// 16..32 are those from 16 up to 31. `sheer merge` puts the .exr files together.
    #[arg(long, value_name = "A..B", conflicts_with = "raw")]
    pub(crate) sample_range: Option<SampleSpan>,
    /// Leave out frames of a sequence whose files are there.
    #[arg(long)]
    pub(crate) skip_existing: bool,
    /// Under taa and layered, frames that are rendered before the first one and not written, so that a part
    /// of a sequence fits to the others; none before frame 0 [default, of a sequence: taa 40, layered 72].
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(0..=i64::from(MOST_FRAMES)))]
    pub(crate) warm_up: Option<u32>,
    #[command(flatten)]
    pub(crate) frames: FrameArguments,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

#[derive(Args, Debug)]
pub(crate) struct MergeArguments {
    /// The pieces of one picture, .exr files of `sheer render --crop X,Y,W,H` or `--sample-range A..B`, or of
    /// both, in any order: crops must cover the picture, sample ranges make up all samples. With `####` or
    /// `%04d` in the names, and in that of the output, the frames of sequences are put together one by one.
    #[arg(value_name = "PIECE", required = true)]
    pub(crate) pieces: Vec<PathBuf>,
    /// .exr or .png, as for `sheer render`: the picture that it would have rendered whole, crops to the bit,
    /// sample ranges to the rounding of means.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) tone: ToneArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

#[derive(Args, Debug)]
pub(crate) struct CompareArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Transparency method, NAME or NAME:KEY=VALUE,…; give as many as you like. baseline always takes part as
    /// the reference.
    #[arg(short, long = "method", value_name = "METHOD", default_values = COMPARED_METHODS, value_parser = method)]
    pub(crate) methods: Vec<Method>,
    /// none, accumulate, taa or layered, each with keys as methods have them; give as many as you like.
    #[arg(short = 'a', long = "aa", value_name = "AA", default_value = "layered")]
    pub(crate) antialiasings: Vec<Antialiasing>,
    /// What methods are held against: same (baseline under the same anti-aliasing) or truth[:samples=N] (the
    /// exact answer with N samples a pixel at the moment of each frame, 32 if not given, for the last quarter
    /// of the frames); give both for both.
    #[arg(long = "reference", value_name = "REFERENCE", default_value = "same", value_delimiter = ',')]
    pub(crate) references: Vec<Reference>,
    /// Pictures of another program beside the methods, as NAME=FILE or NAME=PATTERN with `####` or `%04d` for
    /// the number of the frame: .png, .jpg or .webp, shown as they are, or .exr or .hdr of linear light; give
    /// as many as you like.
    ///
    /// They have the size of the comparison. One file stands for the last frame; of numbered ones those of
    /// the last half of the frames are taken, as the figures of the methods are from there. Errors in linear
    /// light are told of .exr and .hdr alone.
    #[arg(long = "with", value_name = "NAME=PATTERN", value_parser = named_pattern)]
    pub(crate) foreign: Vec<NamedPattern>,
    /// Judge the clips with ColorVideoVDP as well, in just-objectionable differences; about as slow as
    /// rendering.
    #[arg(long)]
    pub(crate) vdp: bool,
    /// Folder for index.html, report.json and the pictures.
    #[arg(short, long, value_name = "DIR", default_value = output::FOLDER)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) data: DataArguments,
    #[command(flatten)]
    pub(crate) seeds: SeedsArguments,
    #[command(flatten)]
    pub(crate) frames: FrameArguments,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

#[derive(Args, Debug)]
pub(crate) struct MetricsArguments {
    /// What the pictures are held against: a .png, .jpg or .webp file, shown as it is, an .exr or .hdr file
    /// of linear light, or a clip: a folder of them, or a name with `####` or `%04d` for the number.
    #[arg(value_name = "REFERENCE")]
    pub(crate) reference: String,
    /// Pictures of the same size, or clips of as many, each as PATH or NAME=PATH.
    ///
    /// Several under one NAME were made with as many seeds: their figures are means ± half of the 95 %
    /// confidence interval (Student's t), in CSV and JSON under `ci95`, as with `--seeds` of `sheer compare`;
    /// the page shows the first.
    #[arg(value_name = "PICTURE", required = true)]
    pub(crate) pictures: Vec<String>,
    /// Folder for a page with slider and error maps, and the pictures as PNG.
    #[arg(long, value_name = "DIR")]
    pub(crate) html: Option<PathBuf>,
    /// File for the figures in JSON, - for stdout in place of the table.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) data: DataArguments,
    /// Judge with ColorVideoVDP as well, in just-objectionable differences.
    #[arg(long)]
    pub(crate) vdp: bool,
    /// Frames a second at which --vdp sees a clip.
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = frame_rate)]
    pub(crate) fps: f32,
    #[command(flatten)]
    pub(crate) tone: ToneArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

/// What figures are means over.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct SeedsArguments {
    /// How many seeds the figures rest on, from --seed on: with two or more, each is the mean over the seeds
    /// ± half of its 95 % confidence interval (Student's t).
    ///
    /// What is measured in pictures or counted (SSIM up to bias, shaded/px, rays/px…) differs by the
    /// dithering alone: in 95 of 100 such runs the interval holds the mean over all seeds. Decibels are
    /// averaged as such. What is timed (ms, min, max, spread, ratio…) is so anew with each seed, and its
    /// interval is that of the machine. What is not random has ±0, and the program names it; `baseline`,
    /// which `compare` renders once for all seeds, has no interval for its times. The scene is the same with
    /// every seed; pictures, charts of frames and lists of times are those of the first. CSV has the
    /// intervals in columns `… ci95`, JSON in an object `ci95` of each row, under the names of the figures.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u32).range(1..=100))]
    pub(crate) seeds: u32,
}

/// The table of figures in files.
#[derive(Args, Debug)]
pub(crate) struct DataArguments {
    /// File for the table as comma-separated values with all digits, - for stdout in place of the table.
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// File for the table in LaTeX (booktabs), - for stdout in place of the table.
    #[arg(long, value_name = "FILE")]
    pub(crate) latex: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct BenchArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Transparency method, NAME or NAME:KEY=VALUE,…; give as many as you like. Ratios are against the first.
    #[arg(short, long = "method", value_name = "METHOD", default_values = STD_METHODS, value_parser = method)]
    pub(crate) methods: Vec<Method>,
    /// none, accumulate, taa or layered, each with keys as methods have them; give as many as you like. What
    /// adding frames up takes is told by itself.
    #[arg(short = 'a', long = "aa", value_name = "AA", default_value = "none")]
    pub(crate) antialiasings: Vec<Antialiasing>,
    /// File for the figures, - for stdout in place of the table.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// File for a page with table and chart.
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) data: DataArguments,
    #[command(flatten)]
    pub(crate) seeds: SeedsArguments,
    #[command(flatten)]
    pub(crate) frames: FrameArguments,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

#[derive(Args, Debug)]
pub(crate) struct CalibrateArguments {
    /// Transparency method, NAME or NAME:KEY=VALUE,…; `sheer methods` lists them.
    #[arg(short, long, default_value = "std", value_parser = method)]
    pub(crate) method: Method,
    /// none, accumulate, taa or layered, each with keys as methods have them.
    #[arg(short = 'a', long = "aa", value_name = "AA", default_value = "taa")]
    pub(crate) antialiasing: Antialiasing,
    /// JSON file for the coefficients, to be given as METHOD:correction=FILE; - for stdout in place of the
    /// table.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// File for a page with plot, correction and picture.
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) frames: FrameArguments,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

#[derive(Args, Debug)]
pub(crate) struct ExperimentsArguments {
    /// Experiments by name; all if none is given.
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// List them.
    #[arg(long)]
    pub(crate) list: bool,
    /// Folder for index.html, results.md, experiments.json, pictures and charts.
    #[arg(short, long, value_name = "DIR", default_value = output::FOLDER)]
    pub(crate) output: PathBuf,
    #[arg(long, value_name = "WxH", help = format!("Width and height in pixels [default: {DEFAULT_EXPERIMENT_SIZE}]"))]
    pub(crate) size: Option<Size>,
    /// A scene file to take part where methods are compared, with all its materials at an opacity of 0.3;
    /// give as many as you like.
    #[arg(long = "file", value_name = "FILE")]
    pub(crate) files: Vec<String>,
    #[command(flatten)]
    pub(crate) load: LoadArguments,
    /// Seed of the dithering.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,
    /// How many seeds claims rest on, from --seed on: with two or more each says how likely it is to be
    /// chance.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) seeds: u32,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

#[derive(Args, Debug)]
pub(crate) struct VerifyArguments {
    /// Scenes in which a GPU has to show what the CPU shows: built-in ones or scene files; some of ours if
    /// none is given.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Methods that a GPU has to run as the CPU does, NAME or NAME:KEY=VALUE,…; all if none is given.
    #[arg(short, long = "method", value_name = "METHOD", value_parser = method)]
    pub(crate) methods: Vec<Method>,
    /// Set the opacity of every material of these scenes, 0 to 1.
    #[arg(long, value_name = "A", value_parser = unit)]
    pub(crate) alpha: Option<f32>,
    #[command(flatten)]
    pub(crate) load: LoadArguments,
    /// File for the figures, - for stdout in place of the table.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

#[derive(Args, Debug)]
pub(crate) struct CompletionsArguments {
    /// The shell.
    #[arg(value_name = "SHELL", value_enum)]
    pub(crate) shell: Shell,
}

#[derive(Args, Debug)]
pub(crate) struct ManArguments {
    /// Folder for the pages.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
}

/// What is compared unless the user says: the methods of the STD paper, and our own.
const COMPARED_METHODS: [&str; 7] = ["baseline", "joint", "roulette", "std", "dtaa", "dtaa-unique", "stbn"];
/// The methods of the STD paper, the exact one first.
const STD_METHODS: [&str; 6] = ["baseline", "roulette", "std", "dtaa", "dtaa-unique", "stbn"];

/// What is shown.
#[derive(Args, Debug)]
pub(crate) struct SceneArguments {
    /// Built-in scene, NAME or NAME:KEY=VALUE,…, or a .gltf, .glb, .obj, .ply, .stl or .hair file; `sheer
    /// scenes` lists the built-in ones.
    #[arg(value_name = "SCENE", default_value = "smoke-square")]
    pub(crate) text: String,
    /// static, path, orbit or the name of one of the scene's cameras; the scene's first if not given.
    #[arg(long, value_name = "NAME", value_parser = camera)]
    pub(crate) camera: Option<CameraChoice>,
    #[command(flatten)]
    pub(crate) view: ViewArguments,
    /// Set the opacity of every material, 0 to 1.
    #[arg(long, value_name = "A", value_parser = unit)]
    pub(crate) alpha: Option<f32>,
    /// What shines from all around: scene (the scene's own), none, studio, plain, or a panorama in a .hdr or
    /// .exr file, twice as wide as high. Lights of the scene shine in addition.
    #[arg(long, value_name = "NAME|FILE", default_value = "scene", value_parser = environment)]
    pub(crate) environment: EnvironmentChoice,
    /// How many times as bright the surroundings are.
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = strength, allow_negative_numbers = true)]
    pub(crate) environment_strength: f32,
    #[command(flatten)]
    pub(crate) load: LoadArguments,
}

impl SceneArguments {
    /// A scene as it is.
    pub(crate) fn of(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            camera: None,
            view: ViewArguments::default(),
            alpha: None,
            environment: EnvironmentChoice::Scene,
            environment_strength: 1.0,
            load: LoadArguments::default(),
        }
    }
}

/// Where the scene is seen from, where no camera of its own will do.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct ViewArguments {
    /// Look from this point, world units, instead of through a camera; `sheer inspect` tells the views that
    /// there are in this form.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, conflicts_with = "camera")]
    pub(crate) eye: Option<Vec3>,
    /// The point that is looked at; the middle of the scene if not given.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "eye")]
    pub(crate) target: Option<Vec3>,
    /// What is up in the picture: 0,1,0 if not given.
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true, requires = "eye")]
    pub(crate) up: Option<Vec3>,
    /// Height of the view in degrees; that of the camera if not given.
    #[arg(long, value_name = "DEGREES", value_parser = field_of_view, conflicts_with = "ortho")]
    pub(crate) fov: Option<f32>,
    /// Height of the view in world units, of parallel rays.
    #[arg(long, value_name = "HEIGHT", value_parser = view_height)]
    pub(crate) ortho: Option<f32>,
}

/// How a scene file is read.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct LoadArguments {
    /// Fail where a part of the file is broken or missing; otherwise what is sound is drawn, with a warning
    /// of what is lost.
    #[arg(long)]
    pub(crate) strict: bool,
    /// A folder besides the file's own that the files it refers to may lie in; give as many as you like.
    #[arg(long = "allow-folder", value_name = "DIR")]
    pub(crate) allowed_folders: Vec<PathBuf>,
    /// The animation of a file to play, by its name or its number from 0; all: all that do not get in each
    /// other's way, which is the default; none: everything at rest. `sheer inspect FILE` lists them.
    #[arg(long, value_name = "NAME|INDEX|all|none")]
    pub(crate) clip: Option<String>,
    /// The scene of a file to show, by its name or its number from 0; the file's own choice if not given.
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) scene: Option<String>,
    /// The variant of a file's materials to show, by its name or its number from 0.
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) variant: Option<String>,
}

/// Which frames are made of it.
#[derive(Args, Debug)]
pub(crate) struct FrameArguments {
    #[arg(long, value_name = "WxH", help = format!("Width and height in pixels [default: {DEFAULT_SIZE}; compare: {COMPARE_SIZE}]"))]
    pub(crate) size: Option<Size>,
    /// How many frames, or which: 24..48 are those from 24 up to 47, 24..=47 the same. One picture of
    /// `render` is what they have added up to, or the first where they do not (-a none, --samples, --raw)
    /// [default: 32].
    #[arg(long, value_name = "N|A..B")]
    pub(crate) frames: Option<FrameSpan>,
    /// Index of the first frame, where --frames does not name it [default: 0].
    #[arg(long, value_name = "I", value_parser = value_parser!(u32).range(..=i64::from(LAST_FRAME)))]
    pub(crate) first_frame: Option<u32>,
    /// Frames a second.
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = frame_rate)]
    pub(crate) fps: f32,
    /// Time of frame 0 in seconds.
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) time: f32,
    /// What lies behind everything: env (the scene's surroundings), #rrggbb, or none (the picture is
    /// transparent there).
    #[arg(long, value_name = "env|#rrggbb|none", default_value = "env")]
    pub(crate) background: Background,
    /// Seed of the dithering.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,
}

/// How light comes about.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct LightArguments {
    /// Shadow technique, NAME or NAME:KEY=VALUE,…: deep, stochastic-map, deep-map, opacity-map or fourier;
    /// `sheer methods --long` lists their keys.
    #[arg(long, value_name = "SHADOW", default_value_t)]
    pub(crate) shadow: Shadow,
    #[command(flatten)]
    pub(crate) tone: ToneArguments,
}

/// How linear light is displayed.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ToneArguments {
    /// Tone curve of pictures for a display (.png, pages and what is measured on displayed pictures):
    /// pbr-neutral, none, aces, aces-narkowicz, agx or reinhard. Backgrounds of one colour and unlit
    /// materials are shown as they are under any of them; .exr files have linear light.
    #[arg(long, value_name = "CURVE", default_value = ToneCurve::default().word(), value_parser = tone_curve)]
    pub(crate) tone: ToneCurve,
    /// Stops by which linear light is made brighter before the tone curve, negative for darker.
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    pub(crate) exposure: f32,
}

/// What renders.
#[derive(Args, Clone, Debug)]
pub(crate) struct BackendArguments {
    /// cpu; gpu: rays where the GPU traces them itself and the method goes by rays, raster otherwise; gpu:ray
    /// or gpu:raster: that alone.
    #[arg(long, default_value = "cpu")]
    pub(crate) backend: BackendChoice,
    /// The GPU: its number or a part of its name, as `sheer devices` has them; the most capable if not given.
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) adapter: Option<AdapterChoice>,
}

/// Where and how loudly.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct MachineArguments {
    /// Threads to use; all processors if not given. The pictures are the same.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::from(1..=MOST_THREADS as u64))]
    pub(crate) threads: Option<usize>,
    /// Memory that may be taken, as 800MB, 2GB or 1.5GiB: what would take more is refused. Three quarters of
    /// what is free if not given.
    #[arg(long, value_name = "SIZE")]
    pub(crate) memory_limit: Option<MemorySize>,
    /// Say nothing but errors.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// How to tell how far it is: bar, on a terminal; json and openjd (Open Job Description) print a line for
    /// each per cent on stdout.
    #[arg(long, value_name = "FORM", value_enum, default_value_t, hide_possible_values = true)]
    pub(crate) progress: ProgressForm,
}

/// How progress is told (`--progress`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressForm {
    /// A bar on a terminal, nothing elsewhere.
    #[default]
    Bar,
    /// `{"percent":25,"done":3,"expected":12}`
    Json,
    /// `openjd_progress: 25`, as Open Job Description has it.
    Openjd,
}

/// What shines from all around (`--environment`).
#[derive(Clone, Debug)]
pub(crate) enum EnvironmentChoice {
    /// The scene's own.
    Scene,
    /// One that has a name.
    Named(NamedEnvironment),
    /// A panorama.
    File(PathBuf),
}

/// The name of the scene's own surroundings.
const SCENE_ENVIRONMENT: &str = "scene";

impl fmt::Display for EnvironmentChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene => f.write_str(SCENE_ENVIRONMENT),
            Self::Named(named) => f.write_str(named.name),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size(pub(crate) [u32; 2]);

/// Of pictures and measurements.
pub(crate) const DEFAULT_SIZE: Size = Size([960, 540]);
/// Of comparisons, which render everything exactly as well: with the default scene, methods and frames, they
/// are to end within three minutes on two cores. 480×270 took 4 min 10 s under layered accumulation.
pub(crate) const COMPARE_SIZE: Size = Size([400, 225]);
/// Of experiments, of which there are many.
pub(crate) const DEFAULT_EXPERIMENT_SIZE: Size = Size([240, 135]);
/// Of a file with a correction; `sheer calibrate` writes a few hundred.
const LONGEST_CORRECTION_BYTES: u64 = 1 << 20;

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self([width, height]) = self;
        write!(f, "{width}x{height}")
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| text.parse().ok().filter(|side| (1..=LONGEST_SIDE_PX).contains(side));
        text.split_once('x')
            .and_then(|(width, height)| Some(Self([side(width)?, side(height)?])))
            .ok_or_else(|| format!("give WIDTHxHEIGHT as in 960x540, each from 1 to {LONGEST_SIDE_PX}"))
    }
}

/// Pictures of another program (`--with`).
#[derive(Clone, Debug)]
pub(crate) struct NamedPattern {
    /// What they are called.
    pub(crate) name: String,
    /// A file, or numbered ones.
    pub(crate) pattern: PathBuf,
}

/// Which frames of a run (`--frames`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameSpan {
    /// So many.
    Count(u32),
    /// From the first one so many.
    From(u32, u32),
}

impl FrameSpan {
    /// Where the user does not say.
    pub(crate) const DEFAULT: Self = Self::Count(32);
}

impl FromStr for FrameSpan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let span = if text.contains("..") {
            first_and_end(text).map(|(first, end)| Self::From(first, end - first))
        } else {
            text.parse().ok().map(Self::Count)
        };
        let is_sound = |&span: &Self| {
            let (Self::Count(count) | Self::From(_, count)) = span;
            let first = if let Self::From(first, _) = span { first } else { 0 };
            (1..=MOST_FRAMES).contains(&count) && first <= LAST_FRAME
        };
        span.filter(is_sound).ok_or_else(|| {
            format!("give a number of frames from 1 to {MOST_FRAMES}, or a range of them as 24..48, which ends with 47")
        })
    }
}

/// Some of the samples of a mean (`--sample-range`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleSpan {
    /// The first, counted from 0.
    pub(crate) first: u32,
    /// The one after the last.
    pub(crate) end: u32,
}

impl FromStr for SampleSpan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let span = first_and_end(text).filter(|(first, end)| first < end);
        span.map(|(first, end)| Self { first, end })
            .ok_or_else(|| "give a range of samples as 16..32, which ends with 31".to_owned())
    }
}

/// Reads `24..48` or `24..=47`: the first one and the one after the last, which is no less.
fn first_and_end(text: &str) -> Option<(u32, u32)> {
    let (first, end) = text.split_once("..")?;
    let end = match end.strip_prefix('=') {
        Some(last) => last.parse::<u32>().ok()?.checked_add(1)?,
        None => end.parse().ok()?,
    };
    let first = first.parse().ok()?;
    (first <= end).then_some((first, end))
}

/// What `--backend` may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BackendChoice {
    /// The processor.
    Cpu,
    /// A GPU.
    Gpu(GpuPathChoice),
}

impl BackendChoice {
    /// All with their names, in the order in which they are listed.
    fn all() -> impl Iterator<Item = (&'static str, Self)> {
        let on_gpu = GpuPathChoice::ALL.into_iter().map(|path| (path.name(), Self::Gpu(path)));
        iter::once((Cpu.name(), Self::Cpu)).chain(on_gpu)
    }
}

impl FromStr for BackendChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::all().find_map(|(name, choice)| (name == text).then_some(choice)).ok_or_else(|| {
            let names: Vec<&str> = Self::all().map(|(name, _)| name).collect();
            format!("there are: {}{}", names.join(", "), suggestion(text, names.iter().copied()))
        })
    }
}

#[expect(clippy::unnecessary_wraps, reason = "the argument parser wants a result")]
fn camera(text: &str) -> Result<CameraChoice, String> {
    Ok(match text {
        "orbit" => CameraChoice::Orbit,
        name => CameraChoice::Named(name.to_owned()),
    })
}

/// A method; a `correction` that is neither of the library's words is a file.
fn method(text: &str) -> Result<Method, String> {
    #[derive(serde::Deserialize)]
    struct CorrectionFile {
        coefficients: [f32; 4],
    }
    let parse = |text: &str| text.parse::<Method>().map_err(|error| error.to_string());
    let setting =
        split_name(text).1.split(',').map(str::trim).find(|setting| setting.starts_with("correction="));
    let file = setting.and_then(|setting| setting.strip_prefix("correction="));
    let (Some(setting), Some(file)) = (setting, file.filter(|file| !matches!(*file, "none" | "dlss"))) else {
        return parse(text);
    };
    let method = parse(&text.replacen(setting, "correction=none", 1))?;
    let expected = r#"give none, dlss or a JSON file with {"coefficients":[c0,c1,c2,c3]} as `sheer calibrate` writes it"#;
    let described = |problem: String| format!("cannot take the correction {file}: {problem}; {expected}");
    let json = read_whole(Path::new(file), LONGEST_CORRECTION_BYTES)
        .map_err(|error| described(error.to_string()))?;
    let CorrectionFile { coefficients } =
        serde_json::from_slice(&json).map_err(|error| described(error.to_string()))?;
    let correction = Correction::new(coefficients);
    let correction = correction.ok_or_else(|| described("a coefficient is not finite".to_owned()))?;
    Ok(method.with_correction(correction, text))
}

fn unit(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value| (0.0..=1.0).contains(value));
    value.ok_or_else(|| "give a number from 0 to 1".to_owned())
}

fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let numbers = numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
    let vector = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    vector.map(Vec3::from).ok_or_else(|| "give three numbers as in 0,1.5,-2".to_owned())
}

fn direction(text: &str) -> Result<Vec3, String> {
    let vector = vector(text).ok().filter(|vector| *vector != Vec3::ZERO);
    vector.ok_or_else(|| "give a direction as in 0,1,0".to_owned())
}

fn field_of_view(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value| FIELDS_OF_VIEW_DEGREES.contains(value));
    value.ok_or_else(|| {
        format!("give degrees from {} to {}", FIELDS_OF_VIEW_DEGREES.start(), FIELDS_OF_VIEW_DEGREES.end())
    })
}

fn view_height(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value: &f32| value.is_normal() && *value > 0.0);
    value.ok_or_else(|| "give a height above 0".to_owned())
}

fn shutter(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value| (0.0..=1.0).contains(value));
    value.ok_or_else(|| "give a share of the time between frames from 0 to 1".to_owned())
}

fn frame_rate(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value| FRAME_RATES.contains(value));
    value.ok_or_else(|| format!("give frames a second from {} to {}", FRAME_RATES.start(), FRAME_RATES.end()))
}

fn environment(text: &str) -> Result<EnvironmentChoice, String> {
    if text == SCENE_ENVIRONMENT {
        return Ok(EnvironmentChoice::Scene);
    }
    if let Some(named) = NAMED.into_iter().find(|named| named.name == text) {
        return Ok(EnvironmentChoice::Named(named));
    }
    let path = PathBuf::from(text);
    let is_panorama = path.extension().is_some_and(|extension| {
        extension.eq_ignore_ascii_case("hdr") || extension.eq_ignore_ascii_case("exr")
    });
    if is_panorama {
        return Ok(EnvironmentChoice::File(path));
    }
    let described = NAMED.map(|NamedEnvironment { name, what, .. }| format!("{name} ({what})")).join(", ");
    let nearest = suggestion(text, iter::once(SCENE_ENVIRONMENT).chain(NAMED.iter().map(|named| named.name)));
    Err(format!(
        "there are {SCENE_ENVIRONMENT} (the scene's own), {described}, and .hdr and .exr files{nearest}"
    ))
}

fn named_pattern(text: &str) -> Result<NamedPattern, String> {
    let parts = text.split_once('=').filter(|(name, pattern)| !name.is_empty() && !pattern.is_empty());
    let (name, pattern) = parts.ok_or(r#"give NAME=PATTERN as in theirs="theirs/####.png""#)?;
    Ok(NamedPattern { name: name.to_owned(), pattern: pattern.into() })
}

fn strength(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value| (0.0..=MOST_STRENGTH).contains(value));
    value.ok_or_else(|| format!("give a number from 0 to {MOST_STRENGTH}"))
}

fn seconds(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value: &f32| value.is_finite());
    value.ok_or_else(|| "give a number of seconds".to_owned())
}

fn tone_curve(text: &str) -> Result<ToneCurve, String> {
    let words = ToneCurve::WORDS;
    let described = || format!("there are: {}{}", words.join(", "), suggestion(text, words.iter().copied()));
    ToneCurve::from_word(text).ok_or_else(described)
}

fn exposure(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value: &f32| value.abs() <= MOST_EXPOSURE_EV);
    value.ok_or_else(|| format!("give a number of stops from -{MOST_EXPOSURE_EV} to {MOST_EXPOSURE_EV}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_from_one_up() {
        assert_eq!("960x540".parse(), Ok(Size([960, 540])));
        for wrong in ["", "960", "0x540", "960x", "960x540x3", "-1x1", "1e3x1", "99999x1", "960 x 540"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong} passed");
        }
    }
}

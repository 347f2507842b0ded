//! Frames one after the other on the device: a method, its shaders and what it has added up.
//!
//! A pipeline owns everything that depends on the method and the size of the picture: shaders, the buffers of
//! its pixels, its history, its shadow maps. What depends on the scene belongs to the stage, so that several
//! pipelines render the same moment of one stage, as `compare` and `bench` ask for. Nothing leaves the device
//! before it is read: [`GpuPipeline::submit`] sends a frame off and returns, [`GpuPipeline::render`] waits
//! for it and reads what it cost, [`GpuPipeline::planes`] reads the picture. [`GpuPipeline::record`] leaves
//! the sending to a caller who has an encoder and a texture for the picture.
//!
//! All of a pipeline's part of the device is one value, [`Resources`], which remembers the generation of the
//! device that it was made with: after a device is lost it is made anew as a whole, and nothing of the old
//! device can be left in it.
//!
//! A frame is one command buffer: shadow maps, the passes of the path, adding up, and the copies of counters
//! and timestamps. Bind group 0 is made again when the stage has other buffers, group 1 when the shadow maps
//! have.

use std::{sync::Arc, time::Instant};

use sheer_image::Planes;
use sheer_render::{
    Antialiasing, Clock, Counters, Method, Settings, StepTime, Timings,
    contract::{Alignment, Hybrid, Raster},
    temporal::{jitter, of_run},
};
use wgpu::BufferUsages;

use crate::{
    accel,
    device::{Gpu, Tracer},
    error::GpuError,
    frame::FrameParameters,
    layouts::Layouts,
    needs::Needs,
    opaque_input::{DepthKind, Opaque, OpaqueInput},
    path::{GpuPath, GpuPathChoice, choose_path},
    picture::{Picture, PicturePass},
    pixels::{LAYERS_BYTES, PIXEL_BYTES, read_planes},
    raster::{RasterPath, multisample::Sampling, plan::raster_of},
    ray::{OneLayer, RayPath, Search},
    recording::{Groups, Recording},
    resource::{
        bind_group::whole,
        buffer::{buffer, pixel_buffer},
    },
    shader::{
        Linker,
        binding::BIND_LAYERS,
        record::{frame::FrameUniform, pixel::Counts},
    },
    shadow::{self, MapRays, MapSettings, ShadowMaps},
    stage::GpuStage,
    tables::Tables,
    temporal::{self, History, NewFrame},
    timing::Timer,
};

/// What a frame costs.
const COUNTER_BYTES: u64 = size_of::<Counts>() as u64;
/// What the one shaded fragment of a pixel takes: the four words of shaders/shared/found.wgsl.
const SURFACE_BYTES: u64 = 16;
/// Passes of a frame that are timed: those of 64 peeled layers, and what comes with them.
const MOST_PASSES: u32 = 256;

/// What runs a method.
#[derive(Debug)]
enum Executor {
    Ray(RayPath),
    Raster(Box<RasterPath>),
}

/// What shaders differ by beside method and settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Linking {
    /// Whether they follow the light through coloured glass.
    has_glass: bool,
    /// In which kind of texture the caller's depths are, if the caller draws what is opaque.
    input: Option<DepthKind>,
}

/// Everything on the device that belongs to one pipeline.
#[derive(Debug)]
struct Resources {
    executor: Executor,
    layouts: Layouts,
    frame: wgpu::Buffer,
    tables: wgpu::Buffer,
    pixels: wgpu::Buffer,
    surfaces: wgpu::Buffer,
    /// What is known of the layers of each pixel, where the anti-aliasing asks for it.
    layers: Option<wgpu::Buffer>,
    /// Fills it where the executor does not.
    whole: Option<OneLayer>,
    counters: wgpu::Buffer,
    counters_read: wgpu::Buffer,
    history: History,
    timer: Timer,
    shadows: Option<ShadowMaps>,
    /// None before what it binds of the caller's is known.
    pass_group: Option<wgpu::BindGroup>,
    /// With the version of the stage that it was made for.
    scene_group: Option<(u64, wgpu::BindGroup)>,
    generation: u32,
    /// What its shaders were linked for.
    linking: Linking,
    /// What the caller has drawn behind the scene.
    opaque: Option<OpaqueInput>,
    /// Made when the first picture is asked for.
    picture: Option<PicturePass>,
}

/// A method and its accumulated history.
#[derive(Debug)]
pub struct GpuPipeline {
    gpu: Arc<Gpu>,
    method: Method,
    path: GpuPath,
    antialiasing: Antialiasing,
    settings: Settings,
    notes: Vec<String>,
    resources: Resources,
    steps: Vec<StepTime>,
}

impl GpuPipeline {
    /// Compiles what the method needs; nothing is rendered yet.
    ///
    /// # Errors
    /// The path does not run the method or the shadows, a part of the picture is asked for, the picture is
    /// too large, or the device refuses.
    pub fn new(
        gpu: &Arc<Gpu>,
        choice: GpuPathChoice,
        method: Method,
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> Result<Self, GpuError> {
        Self::linked(gpu, choice, method, antialiasing, settings, None)
    }

    /// The same for scenes behind which the caller draws, with depths in textures of `depth_format`: of depth
    /// or of floats. [`Self::record_over`] compiles no other shaders then.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_opaque(
        gpu: &Arc<Gpu>,
        choice: GpuPathChoice,
        method: Method,
        antialiasing: Antialiasing,
        settings: Settings,
        depth_format: wgpu::TextureFormat,
    ) -> Result<Self, GpuError> {
        let input = Some(DepthKind::of(depth_format));
        Self::linked(gpu, choice, method, antialiasing, settings, input)
    }

    fn linked(
        gpu: &Arc<Gpu>,
        choice: GpuPathChoice,
        method: Method,
        antialiasing: Antialiasing,
        settings: Settings,
        input: Option<DepthKind>,
    ) -> Result<Self, GpuError> {
        if let Some(crop) = settings.crop {
            return Err(GpuError::Unsupported {
                what: format!("a GPU renders whole pictures, not the part {crop} of one"),
                instead: "leave out --crop, or take --backend cpu".to_owned(),
            });
        }
        let (path, mut notes) = choose_path(gpu, choice, &method)?;
        if gpu.is_foreign() {
            Needs::of(&method, path)?.check(&gpu.report().name, &gpu.device())?;
        }
        let has_glass = gpu.expects_glass();
        if has_glass && !path.follows_glass() {
            notes.push(format!(
                "{method} is drawn by raster, where light passes coloured glass in grey; --backend cpu has its colours, \
                 gpu:ray those of methods that go by rays"
            ));
        }
        let linking = Linking { has_glass: has_glass && path.follows_glass(), input };
        let make = || Resources::new(gpu, path, &method, antialiasing, &settings, linking);
        let resources = gpu.scoped("what a method needs", make)?;
        Ok(Self {
            gpu: Arc::clone(gpu),
            method,
            path,
            antialiasing,
            settings,
            notes,
            resources,
            steps: Vec::new(),
        })
    }

    /// The clock to advance the stage by.
    #[must_use]
    pub fn clock(&self) -> Clock {
        Clock::new(&self.settings, self.antialiasing)
    }

    /// The method that it renders with, with all its parameters.
    #[must_use]
    pub fn method(&self) -> &Method {
        &self.method
    }

    /// Which path the method takes on this device.
    #[must_use]
    pub fn path(&self) -> GpuPath {
        self.path
    }

    /// What its user should know: why a method does not go by rays, for instance.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Where the time of the last frame went, by the device's clock; empty where it has none.
    #[must_use]
    pub fn steps(&self) -> &[StepTime] {
        &self.steps
    }

    /// Renders frame `index`, counted from the run's first, of a stage that has been advanced to it, and adds
    /// it to the history. A device that is lost on the way is replaced once; the history starts anew then.
    ///
    /// # Errors
    /// The device refuses, has no memory left, or is lost twice.
    pub fn render(&mut self, stage: &mut GpuStage, index: u32) -> Result<(Counters, Timings), GpuError> {
        self.twice_if_lost(|pipeline| pipeline.try_render(stage, index))
    }

    /// The same without waiting: the device works while the caller prepares the next frame. Nothing is read
    /// back, so that a frame's cost is unknown and a device that is lost on the way shows in the next call.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn submit(&mut self, stage: &mut GpuStage, index: u32) -> Result<(), GpuError> {
        self.twice_if_lost(|pipeline| pipeline.try_submit(stage, index))?;
        self.gpu.tidy_up()
    }

    /// Records frame `index` as [`Self::submit`] has it into an encoder of the caller's, and the picture so
    /// far into `picture`. Nothing is submitted, read back or waited for. What the frame is rendered with is
    /// written through the queue: the encoder is to be submitted before the next frame of this pipeline is
    /// recorded, and before its stage is advanced again.
    ///
    /// # Errors
    /// The device refuses, has no memory left, or is lost.
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &mut GpuStage,
        index: u32,
        picture: &Picture<'_>,
    ) -> Result<(), GpuError> {
        let gpu = Arc::clone(&self.gpu);
        gpu.scoped("a frame", || {
            self.try_record(encoder, stage, index, None)?;
            self.resources.record_picture(&gpu, encoder, picture)
        })
    }

    /// The same over what the caller has drawn: it takes the place of the background, hides what lies behind
    /// it, and its motion and depth are those of the picture where nothing else is.
    ///
    /// # Errors
    /// As [`Self::record`], or a texture of the caller's is smaller than the picture or has several samples a
    /// pixel.
    pub fn record_over(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &mut GpuStage,
        index: u32,
        opaque: &Opaque<'_>,
        picture: &Picture<'_>,
    ) -> Result<(), GpuError> {
        opaque.check(self.settings.size)?;
        let gpu = Arc::clone(&self.gpu);
        gpu.scoped("a frame", || {
            self.try_record(encoder, stage, index, Some(opaque))?;
            self.resources.record_picture(&gpu, encoder, picture)
        })
    }

    /// Where the sample of frame `index` lies beside the centre of each pixel, pixels: x to the right, y
    /// downwards, each in (-0.5, 0.5). For a caller whose own passes are to be jittered alike.
    #[must_use]
    pub fn jitter(&self, index: u32) -> [f32; 2] {
        jitter(self.antialiasing, self.settings.first_frame + index).into()
    }

    /// Goes on with pictures of another size, of which nothing has been added up yet. Memory is made anew,
    /// what has been compiled stays.
    ///
    /// # Errors
    /// The picture is too large, or the device refuses; the size is the old one then.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), GpuError> {
        let settings = Settings { size, ..self.settings };
        let linking = self.resources.linking;
        let Self { gpu, path, method, antialiasing, .. } = self;
        let make = || Resources::new(gpu, *path, method, *antialiasing, &settings, linking);
        self.resources = gpu.scoped("pictures of another size", make)?;
        self.settings = settings;
        Ok(())
    }

    fn twice_if_lost<T>(
        &mut self,
        mut render: impl FnMut(&mut Self) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let gpu = Arc::clone(&self.gpu);
        let generation = gpu.generation();
        match gpu.scoped("a frame", || render(self)) {
            Err(GpuError::DeviceLost { .. }) => {
                gpu.reopen(generation)?;
                render(self)
            }
            other => other,
        }
    }

    fn try_render(&mut self, stage: &mut GpuStage, index: u32) -> Result<(Counters, Timings), GpuError> {
        let start = Instant::now();
        let map_rays = self.try_submit(stage, index)?;
        let mut counters = self.resources.read_counters(&self.gpu)?;
        counters.shadow_rays += map_rays;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        self.steps = self.resources.timer.read(&self.gpu);
        Ok((counters, timings(stage.build_ms(), wall_ms, &self.steps)))
    }

    /// Sends a frame off; how many rays make its shadow maps.
    fn try_submit(&mut self, stage: &mut GpuStage, index: u32) -> Result<u64, GpuError> {
        let device = self.gpu.device();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let map_rays = self.try_record(&mut encoder, stage, index, None)?;
        self.resources.submit(&self.gpu, encoder)?;
        Ok(map_rays)
    }

    /// Makes everything anew that was made for another device, or for scenes of another kind.
    fn renew(&mut self, stage: &GpuStage, input: Option<DepthKind>) -> Result<(), GpuError> {
        // Shaders that follow light through coloured glass are others: scenes without it do not pay for it.
        let has_glass = self.path.follows_glass() && stage.frame().tints_light();
        let linking = Linking { has_glass, input };
        if self.resources.generation != self.gpu.generation() || self.resources.linking != linking {
            self.resources = Resources::new(
                &self.gpu,
                self.path,
                &self.method,
                self.antialiasing,
                &self.settings,
                linking,
            )?;
        }
        Ok(())
    }

    /// Records a frame; how many rays make its shadow maps.
    fn try_record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &mut GpuStage,
        index: u32,
        opaque: Option<&Opaque<'_>>,
    ) -> Result<u64, GpuError> {
        stage.renew()?;
        self.renew(stage, opaque.map(Opaque::depth_kind))?;
        let frame = self.settings.first_frame + index;
        let Settings { size, seed, background, .. } = self.settings;
        let hybrid = Search::of(&self.method).map_or(Hybrid::NONE, |search| search.hybrid);
        let jitter = jitter(self.antialiasing, frame);
        let parameters = FrameParameters { size, jitter, index: frame, seed, background, hybrid };
        self.resources.record(&self.gpu, encoder, stage, (&parameters, opaque), self.method.alignment())
    }

    /// Forgets what has been added up: the next frame shows something else, after a cut or a jump of the
    /// camera.
    pub fn reset_history(&mut self) {
        self.resources.history.reset();
    }

    /// The picture so far, read back: colour accumulated, everything else of the last frame.
    ///
    /// # Errors
    /// The device is lost, or the machine has no memory for it.
    pub fn planes(&self) -> Result<Planes, GpuError> {
        let Resources { pixels, layers, history, .. } = &self.resources;
        let read = || read_planes(&self.gpu, pixels, history.colour(), layers.as_ref(), self.settings.size);
        self.gpu.scoped("reading a picture", read)
    }

    /// Bytes a pixel that the method takes on the device beyond the pixels themselves, their history and
    /// opaque colour and depth.
    #[must_use]
    pub fn method_bytes_per_pixel(&self) -> f64 {
        let [width, height] = self.settings.size.map(f64::from);
        match &self.resources.executor {
            Executor::Ray(_) => 0.0,
            Executor::Raster(raster) => raster.method_bytes() as f64 / (width * height),
        }
    }
}

/// By the device's clock where it has one, else by ours, which counts everything as tracing. Adding up over
/// time is no part of a frame (STD section 4).
fn timings(build_ms: f64, wall_ms: f64, steps: &[StepTime]) -> Timings {
    let sum = |temporal: bool| -> f64 {
        steps.iter().filter(|step| (step.name == temporal::STEP) == temporal).map(|step| step.ms).sum()
    };
    let trace_ms = if steps.is_empty() { wall_ms } else { sum(false) };
    let shadow_ms = steps.iter().filter(|step| step.name == shadow::STEP).map(|step| step.ms).sum();
    Timings { build_ms, trace_ms, shadow_ms, resolve_ms: sum(true) }
}

impl Resources {
    fn new(
        gpu: &Arc<Gpu>,
        path: GpuPath,
        method: &Method,
        antialiasing: Antialiasing,
        settings: &Settings,
        linking: Linking,
    ) -> Result<Self, GpuError> {
        let generation = gpu.generation();
        let device = gpu.device();
        // What can be refused is, before anything is made.
        let maps = MapSettings::of(&settings.shadow)?;
        let (added_up, split) = of_run(settings, antialiasing);
        let mut more: Vec<_> = split.map(|_| Layouts::layers_entry()).into_iter().collect();
        more.extend(maps.iter().flat_map(|_| ShadowMaps::layout_entries(ShadowMaps::READERS, true)));
        let opaque = linking.input.map(|_| OpaqueInput::new(&device));
        more.extend(linking.input.iter().flat_map(|kind| OpaqueInput::layout_entries(*kind)));
        let layouts = Layouts::new(gpu, &GpuStage::layout_entries(gpu.tracer()), &more);
        // Memory that no technique differs in.
        let pixels = pixel_buffer(gpu, settings.size, "pixels", [PIXEL_BYTES, 0], BufferUsages::COPY_SRC)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let counters = buffer(&device, "counters", COUNTER_BYTES, usage);
        let read = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let counters_read = buffer(&device, "counters read", COUNTER_BYTES, read);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let frame = buffer(&device, "frame", size_of::<FrameUniform>() as u64, usage);
        let mask_sizes = match raster_of(method)? {
            Some(Raster::Multisample(multisample)) => Sampling::new(multisample, gpu.report())?.table_sizes(),
            Some(Raster::Lists | Raster::Passes(_)) | None => [0; 2],
        };
        let table_words = Tables::new(method.info().tables, mask_sizes);
        let words: &[u8] = bytemuck::cast_slice(&table_words.words);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let tables = buffer(&device, "tables", words.len() as u64, usage);
        gpu.queue().write_buffer(&tables, 0, words);
        let surfaces =
            pixel_buffer(gpu, settings.size, "surfaces", [SURFACE_BYTES, 0], BufferUsages::empty())?;
        let layers = split
            .map(|_| pixel_buffer(gpu, settings.size, "layers", [LAYERS_BYTES, 0], BufferUsages::COPY_SRC))
            .transpose()?;
        // Shaders: light first, since all that shades is linked with the way it is looked up.
        let mut linker = base_linker(gpu.tracer()).constants(table_words.constants());
        if linking.has_glass {
            linker = with_glass(linker);
        }
        if let Some(kind) = linking.input {
            linker = over_opaque(linker, kind);
        }
        if let Some(maps) = maps {
            linker = linker.alias("shadow", "shared/shadow_map").constants(maps.constants());
        }
        let shadows = maps.map(|maps| ShadowMaps::new(gpu, maps, &linker, &layouts)).transpose()?;
        let search = Search::of(method).map(|search| search.with_layers(split));
        let executor = match (path, search) {
            (GpuPath::Ray, Some(search)) => {
                Executor::Ray(RayPath::new(gpu, method, search, &linker, &layouts)?)
            }
            (_, search) => {
                Executor::Raster(Box::new(RasterPath::new(gpu, method, search, settings, &linker, &layouts)?))
            }
        };
        let whole = split
            .filter(|_| !search.is_some_and(Search::splits_layers))
            .map(|_| OneLayer::new(gpu, &linker, &layouts))
            .transpose()?;
        // What becomes of the pixels, and what they take.
        let history = History::new(gpu, added_up, settings.size)?;
        let timer =
            if gpu.is_foreign() { Timer::off() } else { Timer::new(&device, &gpu.queue(), MOST_PASSES) };
        gpu.check("what a method needs")?;
        Ok(Self {
            executor,
            layouts,
            frame,
            tables,
            pixels,
            surfaces,
            layers,
            whole,
            counters,
            counters_read,
            history,
            timer,
            shadows,
            pass_group: None,
            scene_group: None,
            generation,
            linking,
            opaque,
            picture: None,
        })
    }

    /// Records a frame; how many rays make its shadow maps.
    fn record(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        stage: &GpuStage,
        (parameters, opaque): (&FrameParameters, Option<&Opaque<'_>>),
        alignment: Alignment,
    ) -> Result<u64, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        // The frame's numbers and the room for its shadow maps.
        let uniform = FrameUniform::new(stage.frame(), stage.extent(), parameters);
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&uniform));
        let map_rays = match &mut self.shadows {
            Some(shadows) => shadows.prepare(gpu, stage, parameters)?,
            None => MapRays::default(),
        };
        let shows_other = match (&mut self.opaque, opaque) {
            (Some(input), Some(opaque)) => input.prepare(&queue, opaque),
            _ => false,
        };
        // Groups whose buffers are others now are bound anew.
        if map_rays.replaced || shows_other || self.pass_group.is_none() {
            self.pass_group = Some(self.layouts.pass_group(
                &device,
                [&self.pixels, &self.counters, &self.surfaces],
                more_entries(&self.layers, &self.shadows, &self.opaque),
            ));
        }
        if self.scene_group.as_ref().is_none_or(|(version, _)| *version != stage.version()) {
            let group = self.layouts.scene_group(&device, &self.frame, &self.tables, stage.entries());
            self.scene_group = Some((stage.version(), group));
        }
        let (Some((_, scene)), Some(pass)) = (&self.scene_group, &self.pass_group) else {
            unreachable!("made just now")
        };
        let groups = Groups { scene, pass };
        // The passes, in the order in which they need one another.
        self.timer.begin_frame();
        encoder.clear_buffer(&self.counters, 0, None);
        let mut recording = Recording {
            encoder: &mut *encoder,
            timer: &mut self.timer,
            size: parameters.size,
            triangle_count: uniform.triangle_count,
        };
        if let Some(shadows) = &self.shadows {
            shadows.record(&mut recording, groups.scene);
        }
        match &mut self.executor {
            Executor::Ray(path) => path.record(&mut recording, &groups),
            Executor::Raster(path) => path.record(&mut recording, &groups),
        }
        if let Some(whole) = &self.whole {
            whole.record(&mut recording, &groups);
        }
        self.history.record(
            gpu,
            encoder,
            &mut self.timer,
            (&self.pixels, self.layers.as_ref()),
            NewFrame {
                alignment,
                index: parameters.index,
                seed: parameters.seed,
                is_still: stage.frame().is_still() && opaque.is_none_or(Opaque::is_still),
            },
        );
        Ok(map_rays.count)
    }

    /// Sends a frame off, and what is read back of it.
    fn submit(&mut self, gpu: &Gpu, mut encoder: wgpu::CommandEncoder) -> Result<(), GpuError> {
        encoder.copy_buffer_to_buffer(&self.counters, 0, &self.counters_read, 0, COUNTER_BYTES);
        self.timer.resolve(&mut encoder);
        gpu.queue().submit([encoder.finish()]);
        gpu.check("a frame")
    }

    /// Records that the picture so far goes into a texture of the caller's.
    fn record_picture(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Picture<'_>,
    ) -> Result<(), GpuError> {
        let pass = match &mut self.picture {
            Some(pass) => pass,
            none => none.insert(PicturePass::new(gpu, &self.history)?),
        };
        pass.record(gpu, encoder, picture, &self.history);
        gpu.check("a picture")
    }

    /// Waits for the frame and reads what it cost.
    fn read_counters(&self, gpu: &Gpu) -> Result<Counters, GpuError> {
        let slice = self.counters_read.slice(..);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        gpu.wait()?;
        let counts: Counts = {
            let lost = |error: wgpu::MapRangeError| GpuError::DeviceLost { reason: error.to_string() };
            let view = slice.get_mapped_range().map_err(lost)?;
            bytemuck::pod_read_unaligned(&view)
        };
        self.counters_read.unmap();
        let Counts { camera_rays, shadow_rays, hits, shaded, merged } = counts;
        Ok(Counters {
            camera_rays: camera_rays.into(),
            shadow_rays: shadow_rays.into(),
            hits: hits.into(),
            shaded: shaded.into(),
            merged: merged.into(),
        })
    }
}

/// What group 1 has beside what all passes write.
fn more_entries<'a>(
    layers: &'a Option<wgpu::Buffer>,
    shadows: &'a Option<ShadowMaps>,
    opaque: &'a Option<OpaqueInput>,
) -> impl Iterator<Item = wgpu::BindGroupEntry<'a>> {
    let layers = layers.iter().map(|layers| whole(BIND_LAYERS, layers));
    let input = opaque.iter().flat_map(OpaqueInput::entries);
    layers.chain(shadows.iter().flat_map(ShadowMaps::entries)).chain(input)
}

/// What all methods have in common.
pub(crate) fn base_linker(tracer: Tracer) -> Linker {
    let traverse = match tracer {
        Tracer::Query => "shared/traverse_query",
        Tracer::Bvh => "shared/traverse_bvh",
    };
    Linker::new()
        .constants(accel::constants())
        .alias("traverse", traverse)
        // What a camera ray goes through, which on the raster path is something else.
        .alias("camera", traverse)
        .alias("shadow", "shared/shadow_deep")
        // Nothing tints what shines through it.
        .alias("glass", "shared/glass_none")
        .alias("tint", "shared/tint_none")
        // What lies behind the scene is the scene's own.
        .alias("limit", "shared/limit_none")
        .alias("backdrop", "shared/backdrop_scene")
        .alias("behind", "shared/behind_scene")
}

/// The same for scenes behind which the caller draws.
pub(crate) fn over_opaque(linker: Linker, kind: DepthKind) -> Linker {
    let limit = match kind {
        DepthKind::Depth => "shared/limit_depth",
        DepthKind::Float => "shared/limit_float",
    };
    linker
        .alias("limit", limit)
        .alias("backdrop", "shared/backdrop_opaque")
        .alias("behind", "shared/behind_opaque")
}

/// The same for scenes with coloured glass.
pub(crate) fn with_glass(linker: Linker) -> Linker {
    linker.alias("glass", "shared/glass").alias("tint", "shared/tint")
}

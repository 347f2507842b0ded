//! Stochastic transparency (ST) on targets of several samples a pixel.
//!
//! A round draws all transparent fragments twice: the first pass keeps the nearest depth that chance leaves
//! in each sample, the second adds up the light of all fragments in the samples that do not hide them. Before
//! the first round one pass multiplies up the total alpha. `estimator=basic` keeps colours in the first pass
//! and needs no second.
//!
//! Samples are the hardware's, 4 or 8 a pixel. The method's become rounds of as many, with R split over the
//! rounds: `samples=8` on a device that has 4 is the CPU's `samples=4,passes=2`. They lie where the hardware
//! has them, spread over the pixel as `placement=box` wants; the CPU's default is the centre. The two differ
//! only where a triangle covers a part of a pixel. What is opaque has one sample a pixel, in its centre, in
//! any case.
//!
//! Deviations from the CPU: a fragment has one depth for all samples, and of two at exactly the same depth
//! neither hides the other.

use sheer_render::{
    Method,
    contract::{Multisample, SampleContent},
};
use wgpu::{
    BindGroupEntry, BindGroupLayoutEntry, BufferBindingType, BufferUsages, CompareFunction, ShaderStages,
    TextureFormat, TextureSampleType, TextureUsages,
};

use super::{
    composite::Composite,
    draw::Draw,
    format::{ADD, DEPTH_FORMAT, MULTIPLY},
    opaque::Opaque,
    parts::Parts,
};
use crate::{
    compile::compute_pipeline,
    device::{AdapterReport, Gpu},
    error::GpuError,
    recording::{Groups, Recording},
    resource::{
        bind_group::{buffer_entry, group, texture_entry, texture_in, whole},
        buffer::{buffer, pixel_buffer},
        target::Target,
    },
    shader::{
        binding::{
            BIND_DEPTH_MAP, BIND_ENDED_ROUNDS, BIND_FRAGMENT_STATS, BIND_OPAQUE_SURFACES, BIND_ROUND,
            BIND_ROUND_TARGETS, BIND_TOTAL_TRANSMITTANCE,
        },
        constant::{self, Constant},
        record::pixel::{FragmentStats, Round, RoundSums},
    },
};

/// What the fragments of a pixel leave for those that come after them.
const STATS_BYTES: u64 = size_of::<FragmentStats>() as u64;
/// What a pixel keeps of the rounds that have ended.
const SUMS_BYTES: u64 = size_of::<RoundSums>() as u64;
/// Radiance times alpha and alpha, or a colour and a 1.
const SUMS_FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// The product of transmittances.
const TRANSMITTANCE_FORMAT: TextureFormat = TextureFormat::R16Float;
/// Masks that say which rounds take one more sample are one word.
const MOST_ROUNDS: u32 = u32::BITS;

/// How the method's samples are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sampling {
    /// Samples of a pixel of the targets.
    pub(crate) samples: u32,
    /// How often these are drawn.
    pub(crate) rounds: u32,
    keeps: SampleContent,
    is_corrected: bool,
}

fn unsupported<T>(what: String, instead: &str) -> Result<T, GpuError> {
    Err(GpuError::Unsupported { what, instead: format!("{instead}, or --backend cpu") })
}

impl Sampling {
    /// Divides the samples of a method into what the device has in a pixel and rounds of it.
    ///
    /// # Errors
    /// The device has no number of samples that fits, or the rounds would be too many.
    pub(crate) fn new(multisample: Multisample, report: &AdapterReport) -> Result<Self, GpuError> {
        let Multisample { samples, passes, keeps, is_corrected } = multisample;
        let fits = |count: &u32| samples.is_multiple_of(*count) && samples > 0;
        let Some(hardware) = report.msaa.iter().copied().filter(fits).max() else {
            let known: Vec<_> = report.msaa.iter().map(u32::to_string).collect();
            return unsupported(
                format!(
                    "{} has {} samples a pixel, {samples} are no multiple of that",
                    report.name,
                    known.join(" or ")
                ),
                "take samples=4, 8, 16, 32 or 64",
            );
        };
        let rounds = samples / hardware * passes;
        if rounds > MOST_ROUNDS {
            return unsupported(
                format!(
                    "{samples} samples in {passes} passes are {rounds} rounds of {hardware}, more than {MOST_ROUNDS}"
                ),
                "take fewer of them and accumulate over frames",
            );
        }
        Ok(Self { samples: hardware, rounds, keeps, is_corrected })
    }

    /// Whether samples keep colours, so that no further pass adds up the light of all fragments.
    fn keeps_colour(self) -> bool {
        self.keeps == SampleContent::Colour
    }

    /// The method with which the CPU draws the same masks.
    pub(crate) fn twin(self, method: &Method) -> Method {
        let Self { samples, rounds, .. } = self;
        let others =
            method.parameters().into_iter().filter(|known| !["samples", "passes"].contains(&known.key));
        let others = others.map(|known| format!(",{}={}", known.key, method.value(known.key)));
        let others = others.collect::<String>();
        let text = format!("{}:samples={samples},passes={rounds}{others}", method.info().id);
        text.parse().expect("keys and values are those of the method")
    }

    /// Winners alone have no pass after the first that could tell which of all fragments is the furthest:
    /// this one does both.
    fn has_total_alpha(self) -> bool {
        self.is_corrected || self.keeps_colour()
    }

    /// Of which tables of masks are needed: of the samples, and of the rounds.
    pub(crate) fn table_sizes(self) -> [u32; 2] {
        [self.samples, if self.rounds > 1 { self.rounds } else { 0 }]
    }

    /// Emitted for the method's shaders.
    pub(crate) fn constants(self) -> String {
        constant::text(&[
            Constant::new("ROUND_COUNT", self.rounds),
            Constant::new("HAS_TOTAL_ALPHA", self.has_total_alpha()),
            Constant::new("IS_CORRECTED", self.is_corrected),
        ])
    }
}

/// The passes of a round and of a frame, and the memory that they share.
#[derive(Debug)]
pub(super) struct MultisamplePasses {
    sampling: Sampling,
    opaque: Opaque,
    targets: Targets,
    fragment_stats: wgpu::Buffer,
    ended_rounds: wgpu::Buffer,
    total_alpha: wgpu::RenderPipeline,
    /// Keeps depths by chance or, for `estimator=basic`, the colours of those that win.
    keep: wgpu::RenderPipeline,
    /// Not made for `estimator=basic`, whose first pass keeps colours.
    accumulate: Option<wgpu::RenderPipeline>,
    end_round: wgpu::ComputePipeline,
    resolve: wgpu::ComputePipeline,
    composite: Composite,
    rounds: Vec<RoundGroups>,
    resolve_group: wgpu::BindGroup,
}

/// Group 2 of a round's passes.
#[derive(Debug)]
struct RoundGroups {
    keep: wgpu::BindGroup,
    accumulate: wgpu::BindGroup,
}

/// Targets with several samples a pixel.
#[derive(Debug)]
struct Targets {
    depth: Target,
    sums: Target,
    transmittance: Target,
}

impl Targets {
    fn new(parts: &Parts<'_>, sampling: Sampling) -> Result<Self, GpuError> {
        let target = |size, label, format| {
            let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
            Target::multisampled(parts.gpu, size, label, format, usage, sampling.samples)
        };
        // Shaders name it even where nothing is drawn to it.
        let size = if sampling.has_total_alpha() { parts.size } else { [1, 1] };
        Ok(Self {
            depth: target(parts.size, "stochastic depth", DEPTH_FORMAT)?,
            sums: target(parts.size, "stochastic sums", SUMS_FORMAT)?,
            transmittance: target(size, "total transmittance", TRANSMITTANCE_FORMAT)?,
        })
    }
}

fn depth_entry(stage: ShaderStages) -> BindGroupLayoutEntry {
    texture_entry(BIND_DEPTH_MAP, stage, TextureSampleType::Depth, true)
}

impl MultisamplePasses {
    /// What the times of its passes are reported as, in their order. Where samples keep colours that takes
    /// the place of depths, and nothing is accumulated.
    pub(super) const STEPS: [&str; 6] =
        [Opaque::STEP, "total alpha", "stochastic depth", "accumulate", "composite", Composite::STEP];
    /// The step in which samples keep colours.
    const COLOUR_STEP: &str = "stochastic colour";

    pub(super) fn new(parts: &Parts<'_>, sampling: Sampling) -> Result<Self, GpuError> {
        // Memory that all rounds share.
        let opaque = Opaque::new(parts)?;
        let targets = Targets::new(parts, sampling)?;
        let fragment_stats = pixel_buffer(
            parts.gpu,
            parts.size,
            "fragment statistics",
            [STATS_BYTES, 0],
            BufferUsages::COPY_DST,
        )?;
        let sums_bytes = if sampling.rounds > 1 { SUMS_BYTES } else { 0 };
        let ended_rounds = pixel_buffer(
            parts.gpu,
            parts.size,
            "ended rounds",
            [sums_bytes, SUMS_BYTES],
            BufferUsages::COPY_DST,
        )?;

        // What each round binds: the same but for its number.
        let round_numbers = RoundNumbers::new(parts, sampling.rounds);
        let mut layouts = None;
        let mut rounds = Vec::new();
        for round in 0..sampling.rounds {
            let shared = [
                texture_in(BIND_OPAQUE_SURFACES, &opaque.surface.view),
                round_numbers.entry(round),
                whole(BIND_FRAGMENT_STATS, &fragment_stats),
            ];
            let [keep_layout, accumulate_layout] = drawing_layouts();
            let (keep_layout, keep) = group(parts.gpu, "stochastic", &keep_layout, &shared);
            let with_depth: Vec<BindGroupEntry<'_>> =
                shared.into_iter().chain([texture_in(BIND_DEPTH_MAP, &targets.depth.view)]).collect();
            let (accumulate_layout, accumulate) =
                group(parts.gpu, "accumulate", &accumulate_layout, &with_depth);
            rounds.push(RoundGroups { keep, accumulate });
            layouts.get_or_insert((keep_layout, accumulate_layout));
        }
        let Some((keep_layout, accumulate_layout)) = layouts else {
            unreachable!("there is a round at least")
        };
        // Pipelines of the passes, from fragments to pixels.
        let Drawing { total_alpha, keep, accumulate } =
            drawing(parts, sampling, [&keep_layout, &accumulate_layout])?;
        let (resolve_layout, resolve_group) =
            resolve_group(parts.gpu, &targets, [&fragment_stats, &ended_rounds]);
        let composite = Composite::new(parts, &opaque)?;
        let [end_round, resolve] = resolving(parts, sampling, &resolve_layout)?;
        Ok(Self {
            sampling,
            opaque,
            targets,
            fragment_stats,
            ended_rounds,
            total_alpha,
            keep,
            accumulate,
            end_round,
            resolve,
            composite,
            rounds,
            resolve_group,
        })
    }

    pub(super) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        let [_, total_alpha, stochastic_depth, accumulate_step, resolve, _] = Self::STEPS;
        let Targets { depth, sums, transmittance } = &self.targets;
        self.opaque.record(recording, groups);
        recording.encoder.clear_buffer(&self.fragment_stats, 0, None);
        recording.encoder.clear_buffer(&self.ended_rounds, 0, None);
        if self.sampling.has_total_alpha() {
            let targets = [Some(transmittance.cleared(wgpu::Color::WHITE))];
            let own = Some(&self.rounds[0].keep);
            recording.draw(total_alpha, &self.total_alpha, groups, own, &targets, None);
        }
        for (index, round) in self.rounds.iter().enumerate() {
            if index > 0 {
                let own = Some(&self.resolve_group);
                recording.for_each_pixel(resolve, &self.end_round, groups, own);
            }
            let sums = [Some(sums.cleared(wgpu::Color::TRANSPARENT))];
            let depth = Some(depth.cleared_depth());
            let Some(accumulate) = &self.accumulate else {
                recording.draw(Self::COLOUR_STEP, &self.keep, groups, Some(&round.keep), &sums, depth);
                continue;
            };
            recording.draw(stochastic_depth, &self.keep, groups, Some(&round.keep), &[], depth);
            recording.draw(accumulate_step, accumulate, groups, Some(&round.accumulate), &sums, None);
        }
        recording.for_each_pixel(resolve, &self.resolve, groups, Some(&self.resolve_group));
        self.composite.record(recording, groups);
    }

    /// Targets, what fragments tell, and the sums of rounds.
    pub(super) fn bytes(&self) -> u64 {
        let Targets { depth, sums, transmittance } = &self.targets;
        let targets: u64 = [depth, sums, transmittance].into_iter().map(Target::bytes).sum();
        targets + self.fragment_stats.size() + self.ended_rounds.size()
    }
}

/// Layouts of group 2: of the passes that keep fragments by chance, and of the one that reads what they kept.
fn drawing_layouts() -> [Vec<BindGroupLayoutEntry>; 2] {
    let stage = ShaderStages::FRAGMENT;
    let keep = vec![
        texture_entry(BIND_OPAQUE_SURFACES, stage, TextureSampleType::Uint, false),
        buffer_entry(BIND_ROUND, stage, BufferBindingType::Uniform),
        buffer_entry(BIND_FRAGMENT_STATS, stage, BufferBindingType::Storage { read_only: false }),
    ];
    let mut accumulate = keep.clone();
    accumulate.push(depth_entry(stage));
    [keep, accumulate]
}

/// Pipelines of the passes that draw all transparent fragments.
struct Drawing {
    total_alpha: wgpu::RenderPipeline,
    keep: wgpu::RenderPipeline,
    accumulate: Option<wgpu::RenderPipeline>,
}

fn drawing(
    parts: &Parts<'_>,
    sampling: Sampling,
    [keep, accumulate]: [&wgpu::BindGroupLayout; 2],
) -> Result<Drawing, GpuError> {
    let linker = parts.method_linker.clone().constants(sampling.constants());
    let masks = parts.gpu.shader(&linker.link("pass/stochastic")?)?;
    let draw = |label, fragment, targets, depth| Draw {
        label,
        module: &masks,
        vertex: "vs_transparent",
        fragment,
        group: Some(keep),
        targets,
        depth,
        samples: sampling.samples,
    };
    // Total alpha, then what is kept by chance: depths, or the colours of winners.
    let total_alpha =
        draw("total alpha", "fs_total_alpha", &[(TRANSMITTANCE_FORMAT, Some(MULTIPLY))], None).build(parts);
    let nearest = Some(CompareFunction::Less);
    let winners = [(SUMS_FORMAT, None)];
    let (entry, targets) =
        if sampling.keeps_colour() { ("fs_colour", &winners[..]) } else { ("fs_depth", &[][..]) };
    let keep = draw("stochastic masks", entry, targets, nearest).build(parts);
    // Winners are shaded already: their second pass would be compiled for nothing.
    let accumulate = if sampling.keeps_colour() {
        None
    } else {
        let sums = parts.gpu.shader(&parts.linker.link("pass/stochastic_accumulate")?)?;
        let draw = Draw {
            label: "accumulate",
            module: &sums,
            vertex: "vs_transparent",
            fragment: "fs_accumulate",
            group: Some(accumulate),
            targets: &[(SUMS_FORMAT, Some(ADD))],
            depth: None,
            samples: sampling.samples,
        };
        Some(draw.build(parts))
    };
    parts.gpu.check("what stochastic transparency draws")?;
    Ok(Drawing { total_alpha, keep, accumulate })
}

fn resolve_group(
    gpu: &Gpu,
    targets: &Targets,
    [fragment_stats, ended_rounds]: [&wgpu::Buffer; 2],
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let stage = ShaderStages::COMPUTE;
    let samples =
        |binding| texture_entry(binding, stage, TextureSampleType::Float { filterable: false }, true);
    let buffer = |binding, read_only| buffer_entry(binding, stage, BufferBindingType::Storage { read_only });
    let layout = [
        buffer(BIND_FRAGMENT_STATS, true),
        depth_entry(stage),
        samples(BIND_ROUND_TARGETS),
        samples(BIND_TOTAL_TRANSMITTANCE),
        buffer(BIND_ENDED_ROUNDS, false),
    ];
    let entries = [
        whole(BIND_FRAGMENT_STATS, fragment_stats),
        texture_in(BIND_DEPTH_MAP, &targets.depth.view),
        texture_in(BIND_ROUND_TARGETS, &targets.sums.view),
        texture_in(BIND_TOTAL_TRANSMITTANCE, &targets.transmittance.view),
        whole(BIND_ENDED_ROUNDS, ended_rounds),
    ];
    group(gpu, "stochastic resolve", &layout, &entries)
}

/// Pipelines of the end of a round and of the last pass.
fn resolving(
    parts: &Parts<'_>,
    sampling: Sampling,
    own: &wgpu::BindGroupLayout,
) -> Result<[wgpu::ComputePipeline; 2], GpuError> {
    let piece = "pass/stochastic_resolve";
    // Without the method: so that its parameters make no other shader of it.
    let linker = parts.linker.clone().constants(sampling.constants());
    let module = parts.gpu.shader(&linker.link(piece)?)?;
    let groups = [&parts.layouts.scene, &parts.layouts.pass, own];
    let pipelines = ["cs_end_round", "cs_resolve"]
        .map(|entry| compute_pipeline(parts.gpu, "stochastic resolve", &groups, &module, entry));
    parts.gpu.check(piece)?;
    Ok(pipelines)
}

/// The numbers of all rounds, each where a uniform may begin.
struct RoundNumbers {
    buffer: wgpu::Buffer,
    stride: u64,
}

impl RoundNumbers {
    /// Bytes of a number, up to where uniforms end.
    const BYTES: u64 = 16;

    fn new(parts: &Parts<'_>, rounds: u32) -> Self {
        let device = parts.gpu.device();
        let stride = u64::from(device.limits().min_uniform_buffer_offset_alignment).max(Self::BYTES);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let buffer = buffer(&device, "rounds", stride * u64::from(rounds), usage);
        for index in 0..rounds {
            let offset = stride * u64::from(index);
            parts.gpu.queue().write_buffer(&buffer, offset, bytemuck::bytes_of(&Round { index }));
        }
        Self { buffer, stride }
    }

    fn entry(&self, round: u32) -> BindGroupEntry<'_> {
        let binding = wgpu::BufferBinding {
            buffer: &self.buffer,
            offset: self.stride * u64::from(round),
            size: wgpu::BufferSize::new(Self::BYTES),
        };
        BindGroupEntry { binding: BIND_ROUND, resource: wgpu::BindingResource::Buffer(binding) }
    }
}

//! Adding frames up over time, on the device: twin of [`sheer_render::temporal`]. The history never leaves it
//! until it is read back.

use sheer_render::{Antialiasing, contract::Alignment, temporal::layers};
use wgpu::{BufferBindingType, BufferUsages, ShaderStages};

use crate::{
    compile::{compute_pipeline, layout},
    device::Gpu,
    error::GpuError,
    pixels::COLOUR_BYTES,
    resource::{
        bind_group::{buffer_entry, group_of, whole},
        buffer::{buffer, pixel_buffer},
    },
    shader::{
        Linker,
        binding::{
            BIND_HISTORY, BIND_KEPT, BIND_MOVED, BIND_NEW_LAYERS, BIND_NEW_PIXELS, BIND_NEXT_HISTORY,
            BIND_NEXT_KEPT, BIND_TEMPORAL,
        },
        numbers::GROUP_SIDE,
        record::temporal::{KeptLayers, TemporalUniform},
    },
    timing::Timer,
};

/// What the time of adding up counts as.
pub(crate) const STEP: &str = "temporal";
/// Bytes of what is kept of a pixel's layers.
const KEPT_BYTES: u64 = size_of::<KeptLayers>() as u64;

/// The shader of a technique, and its entry points in their order: one pass that imports the technique's own
/// piece as `technique`, or the passes of the piece itself where layers are added up.
pub(crate) fn piece_of(antialiasing: &Antialiasing) -> (&'static str, &'static [&'static str]) {
    match layers(*antialiasing) {
        Some(_) => ("technique", &["cs_move", "cs_update", "cs_show"]),
        None => ("pass/resolve", &["cs_resolve"]),
    }
}

/// What is known of a frame beside its pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewFrame {
    /// See [`sheer_render::Method::alignment`].
    pub(crate) alignment: Alignment,
    /// Number of the frame in the clip.
    pub(crate) index: u32,
    /// Seed of the run's random numbers.
    pub(crate) seed: u32,
    /// See [`sheer_scene::Frame::is_still`].
    pub(crate) is_still: bool,
}

/// What has been added up. Two buffers take turns: the history that is read and the one that is written.
#[derive(Debug)]
pub(crate) struct History {
    size: [u32; 2],
    /// How many frames it has taken in.
    count: u32,
    /// How many frames in a row have shown the same, the last one among them.
    still_count: u32,
    layout: wgpu::BindGroupLayout,
    pipelines: Vec<wgpu::ComputePipeline>,
    uniform: wgpu::Buffer,
    colours: [wgpu::Buffer; 2],
    layers: Option<LayerBuffers>,
}

/// What is kept of the layers of each pixel.
#[derive(Debug)]
struct LayerBuffers {
    kept: [wgpu::Buffer; 2],
    /// What is kept, where it is in the new frame.
    moved: wgpu::Buffer,
}

impl LayerBuffers {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let kept = |label| pixel_buffer(gpu, size, label, [KEPT_BYTES, 0], BufferUsages::COPY_DST);
        Ok(Self { kept: [kept("layer history")?, kept("layer history")?], moved: kept("moved layers")? })
    }
}

impl History {
    /// A history of no frame, and the shaders that take frames in.
    ///
    /// # Errors
    /// A shader does not compile, or the picture is too large for a buffer.
    pub(crate) fn new(
        gpu: &Gpu,
        antialiasing: Antialiasing,
        [width, height]: [u32; 2],
    ) -> Result<Self, GpuError> {
        let device = gpu.device();
        let colour =
            || pixel_buffer(gpu, [width, height], "history", [COLOUR_BYTES, 0], BufferUsages::COPY_SRC);
        let colours = [colour()?, colour()?];
        let layers = layers(antialiasing).map(|_| LayerBuffers::new(gpu, [width, height])).transpose()?;
        let uniform_bytes = size_of::<TemporalUniform>() as u64;
        let uniform =
            buffer(&device, "temporal", uniform_bytes, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let list = |binding, read_only| {
            buffer_entry(binding, ShaderStages::COMPUTE, BufferBindingType::Storage { read_only })
        };
        let uniform_entry = buffer_entry(BIND_TEMPORAL, ShaderStages::COMPUTE, BufferBindingType::Uniform);
        let mut entries = vec![uniform_entry, list(BIND_NEW_PIXELS, true), list(BIND_NEXT_HISTORY, false)];
        if layers.is_some() {
            entries.extend([
                list(BIND_NEW_LAYERS, true),
                list(BIND_KEPT, true),
                list(BIND_MOVED, false),
                list(BIND_NEXT_KEPT, false),
            ]);
        } else {
            entries.push(list(BIND_HISTORY, true));
        }
        let layout = layout(gpu, "temporal", &entries);
        let (piece, entry_points) = piece_of(&antialiasing);
        let module = gpu.shader(&Linker::new().antialiasing(&antialiasing).link(piece)?)?;
        let pipelines = entry_points
            .iter()
            .map(|entry_point| compute_pipeline(gpu, "temporal", &[&layout], &module, entry_point))
            .collect();
        gpu.check("the history")?;
        Ok(Self {
            size: [width, height],
            count: 0,
            still_count: 0,
            layout,
            pipelines,
            uniform,
            colours,
            layers,
        })
    }

    /// Starts anew: the next frame owes nothing to those before it.
    pub(crate) fn reset(&mut self) {
        self.count = 0;
        self.still_count = 0;
    }

    /// Records that the next frame is taken in. One frame a submission: its settings are written before it
    /// begins. `layers` of the frame are there where the technique asks for them.
    pub(crate) fn record(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        (pixels, layers): (&wgpu::Buffer, Option<&wgpu::Buffer>),
        new: NewFrame,
    ) {
        let NewFrame { alignment, index: frame, seed, is_still } = new;
        let count = self.count;
        self.still_count = if is_still { self.still_count + 1 } else { 0 };
        let still_count = self.still_count;
        let Alignment { side_px: alignment_px, rule } = alignment;
        let (size, alignment_rule) = (self.size.into(), rule as u32);
        let uniform = TemporalUniform { size, count, alignment_px, frame, seed, alignment_rule, still_count };
        gpu.queue().write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let [old, next] = if self.count.is_multiple_of(2) { [1, 0] } else { [0, 1] };
        let mut entries = vec![
            whole(BIND_TEMPORAL, &self.uniform),
            whole(BIND_NEW_PIXELS, pixels),
            whole(BIND_NEXT_HISTORY, &self.colours[next]),
        ];
        match (&self.layers, layers) {
            (Some(LayerBuffers { kept, moved }), Some(layers)) => {
                // Layers say by their weight of 0 that nothing was there.
                if count == 0 {
                    encoder.clear_buffer(&kept[old], 0, None);
                }
                entries.extend([
                    whole(BIND_NEW_LAYERS, layers),
                    whole(BIND_KEPT, &kept[old]),
                    whole(BIND_MOVED, moved),
                    whole(BIND_NEXT_KEPT, &kept[next]),
                ]);
            }
            _ => entries.push(whole(BIND_HISTORY, &self.colours[old])),
        }
        let group = group_of(&gpu.device(), "temporal", &self.layout, &entries);
        let [columns, rows] = self.size.map(|side| side.div_ceil(GROUP_SIDE));
        // A pass each: what one writes, others read of their neighbours.
        for pipeline in &self.pipelines {
            let timestamp_writes = timer.compute_writes(STEP);
            let descriptor = wgpu::ComputePassDescriptor { label: Some(STEP), timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(columns, rows, 1);
        }
        self.count += 1;
    }

    /// The picture so far, linear and premultiplied, row by row.
    pub(crate) fn colour(&self) -> &wgpu::Buffer {
        &self.colours[self.latest()]
    }

    /// Which of [`Self::colours`] is the picture so far.
    pub(crate) fn latest(&self) -> usize {
        // Before the first frame there is nothing in either.
        usize::from(self.count > 0 && self.count.is_multiple_of(2))
    }

    /// Both pictures that take turns.
    pub(crate) fn colours(&self) -> &[wgpu::Buffer; 2] {
        &self.colours
    }

    /// The `TemporalUniform` of the frame that was recorded last.
    pub(crate) fn uniform(&self) -> &wgpu::Buffer {
        &self.uniform
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;
    use sheer_core::hash::Pcg32;
    use sheer_core::parameter::Choice as _;
    use sheer_image::{Image, Pixel, PixelLayers, Planes};
    use sheer_render::{
        FrameSettings, Settings,
        contract::AlignmentRule,
        temporal::{ANTIALIASINGS, History as CpuHistory},
    };
    use wgpu::util::DeviceExt as _;

    use super::*;
    use crate::{
        device::AdapterChoice,
        pixels::read_planes,
        shader::{
            numbers::NO_DEPTH,
            record::pixel::{LayersRecord, PixelRecord},
        },
    };

    /// No multiple of a workgroup's side.
    const SIZE: [u32; 2] = [37, 21];
    const SEED: u32 = 5;
    /// The most that two results may differ: colours up to 1 go through sums of 49 terms of three products
    /// each, 49 · 2⁻²⁴ ≈ 3e-6, and through a division by their standard deviation, which in noise is a third
    /// of the colours; devices divide and take roots with an error of a few units in the last place. Each
    /// frame keeps nine tenths of the error of the one before: ten times that in the long run.
    const ROUNDING: f32 = 3e-5;

    /// A frame of noise, opaque and transparent, that moves by fractions of a pixel, by whole ones, not at
    /// all, and out of the picture.
    fn noise(random: &mut Pcg32) -> Planes {
        let mut planes = Planes::with_layers(SIZE[0], SIZE[1]).unwrap();
        let motion = |random: &mut Pcg32| match random.below(4) {
            0 => [0.0; 2],
            1 => [random.below(9) as f32 - 4.0, random.below(9) as f32 - 4.0],
            2 => [random.range(-50.0, 50.0), random.range(-50.0, 50.0)],
            _ => [random.range(-4.0, 4.0), random.range(-4.0, 4.0)],
        };
        let mut pixel = |_, _| {
            let [motion, front_motion, back_motion] = [(); 3].map(|()| motion(random));
            let seen = random.below(8) > 0;
            let coverage = [0.0, 1.0, random.range(0.01, 0.99)][random.below(3) as usize];
            let share = if coverage > 0.0 && coverage < 1.0 { random.range(0.1, 0.9) } else { coverage };
            let absorbed = [(); 3].map(|()| (1.0 - coverage) * random.range(-0.5, 0.5).max(0.0));
            let layers = PixelLayers {
                coverage,
                absorbed,
                share,
                is_front: random.next_f32() < share,
                front_motion,
                front_depth: if coverage > 0.0 { random.range(0.1, 9.0) } else { f32::INFINITY },
                back_motion,
                back_depth: if seen { random.range(2.0, 6.0) } else { f32::INFINITY },
            };
            Pixel {
                colour: [(); 4].map(|()| random.next_f32()),
                motion,
                depth: if seen { random.range(0.1, 9.0) } else { f32::INFINITY },
                instance: if seen { random.below(9) } else { Planes::NO_ID },
                primitive: if seen { random.below(99) } else { Planes::NO_ID },
                transparent: random.below(2) == 1,
                layers,
            }
        };
        let pixels = Image::from_fn(SIZE[0], SIZE[1], &mut pixel).unwrap();
        planes.colour = pixels.par_map(|pixel| pixel.colour);
        planes.depth = pixels.par_map(|pixel| pixel.depth);
        planes.motion = pixels.par_map(|pixel| pixel.motion);
        planes.instance = pixels.par_map(|pixel| pixel.instance);
        planes.primitive = pixels.par_map(|pixel| pixel.primitive);
        planes.transparent = pixels.par_map(|pixel| pixel.transparent);
        planes.layers = Some(pixels.par_map(|pixel| pixel.layers));
        planes
    }

    fn records(planes: &Planes) -> Vec<PixelRecord> {
        let positions = (0..planes.height()).flat_map(|y| (0..planes.width()).map(move |x| (x, y)));
        let record = |(x, y)| {
            let pixel = planes.pixel(x, y);
            PixelRecord {
                colour: pixel.colour,
                motion: pixel.motion.into(),
                depth: if pixel.depth.is_finite() { pixel.depth } else { 0.0 },
                transparent: u32::from(pixel.transparent),
                instance: pixel.instance,
                primitive: pixel.primitive,
                padding: glam::UVec2::ZERO,
            }
        };
        positions.map(record).collect()
    }

    fn layer_records(planes: &Planes) -> Vec<LayersRecord> {
        let record = |layers: &PixelLayers| LayersRecord {
            coverage: layers.coverage,
            share: layers.share,
            front_motion: layers.front_motion.into(),
            back_motion: layers.back_motion.into(),
            front_depth: layers.front_depth.min(NO_DEPTH),
            back_depth: layers.back_depth.min(NO_DEPTH),
            is_front: u32::from(layers.is_front),
            absorbed: layers.absorbed,
        };
        planes.layers.as_ref().unwrap().as_slice().iter().map(record).collect()
    }

    /// Adds frames up on the device, those from `cut` on anew, and reads the last state back.
    fn on_device(
        gpu: &Gpu,
        antialiasing: Antialiasing,
        frames: &[Planes],
        alignment: Alignment,
        seed: u32,
        cut: Option<u32>,
    ) -> Planes {
        let (device, queue) = (gpu.device(), gpu.queue());
        let mut history = History::new(gpu, antialiasing, SIZE).unwrap();
        let mut timer = Timer::new(&device, &queue, 3);
        let mut planes = None;
        for (frame, current) in (0..).zip(frames) {
            if cut == Some(frame) {
                history.reset();
            }
            let buffer_of = |contents: &[u8]| {
                device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: None,
                    contents,
                    usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
                })
            };
            let pixels = buffer_of(bytemuck::cast_slice(&records(current)));
            let layers = buffer_of(bytemuck::cast_slice(&layer_records(current)));
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let new = NewFrame { alignment, index: frame, seed, is_still: is_still(frame) };
            history.record(gpu, &mut encoder, &mut timer, (&pixels, Some(&layers)), new);
            queue.submit([encoder.finish()]);
            gpu.check("adding up").unwrap();
            planes = Some(read_planes(gpu, &pixels, history.colour(), Some(&layers), SIZE).unwrap());
        }
        planes.unwrap()
    }

    fn on_processor(
        antialiasing: Antialiasing,
        frames: &[Planes],
        alignment: Alignment,
        cut: Option<u32>,
    ) -> Planes {
        let mut history = CpuHistory::new(antialiasing, SIZE).unwrap();
        for (frame, current) in (0..).zip(frames) {
            if cut == Some(frame) {
                history.reset();
            }
            let run = Settings { size: SIZE, seed: SEED, ..Settings::default() };
            let settings =
                FrameSettings { run, frame, jitter: Vec2::ZERO, layers: None, is_still: is_still(frame) };
            history.add(current.clone(), alignment, &settings).unwrap();
        }
        history.planes().clone()
    }

    /// The first frames move, the later ones stand still.
    fn is_still(frame: u32) -> bool {
        frame >= 6
    }

    fn frames() -> Vec<Planes> {
        let mut random = Pcg32::new(1, 0);
        (0..12).map(|_| noise(&mut random)).collect()
    }

    fn largest_difference(a: &Planes, b: &Planes) -> f32 {
        let values = |planes: &Planes| planes.colour.as_slice().as_flattened().to_vec();
        values(a).iter().zip(values(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn frames_add_up_to_the_same_picture_as_on_the_processor() {
        let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
        let frames = frames();
        // Of a greater weight, layers settle while the last frames stand still.
        for name in ANTIALIASINGS.iter().map(|info| info.id).chain(["layered:weight=0.5"]) {
            let antialiasing: Antialiasing = name.parse().unwrap();
            for &rule in AlignmentRule::ALL {
                let alignment = Alignment { side_px: 3, rule };
                for (count, cut) in [(1, None), (2, None), (12, None), (6, Some(3)), (12, Some(8))] {
                    let device = on_device(&gpu, antialiasing, &frames[..count], alignment, SEED, cut);
                    let processor = on_processor(antialiasing, &frames[..count], alignment, cut);
                    let difference = largest_difference(&device, &processor);
                    let what = format!("{antialiasing}, {rule:?}, {count} frames, anew from {cut:?}");
                    assert!(difference <= ROUNDING, "{what}: {difference}");
                    assert_eq!(Planes { colour: processor.colour.clone(), ..device }, processor, "{what}");
                }
            }
        }
    }

    #[test]
    fn the_comparison_finds_another_seed_and_another_rule() {
        let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
        let frames = frames();
        for &rule in AlignmentRule::ALL {
            let processor = on_processor(Antialiasing::TAA, &frames, Alignment { side_px: 3, rule }, None);
            let others = AlignmentRule::ALL.iter().copied().filter(|other| *other != rule);
            let reseeded = (rule == AlignmentRule::Random).then_some((rule, SEED + 1));
            for (wrong, seed) in others.map(|other| (other, SEED)).chain(reseeded) {
                let alignment = Alignment { side_px: 3, rule: wrong };
                let device = on_device(&gpu, Antialiasing::TAA, &frames, alignment, seed, None);
                let difference = largest_difference(&device, &processor);
                assert!(difference > 100.0 * ROUNDING, "{rule:?} against {wrong:?}: {difference}");
            }
        }
    }
}

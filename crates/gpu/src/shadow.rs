//! Stochastic shadow maps (ST section 3.6) for both paths.
//!
//! Before all else of a frame a compute pass follows the ray of each texel of each light through all
//! blockers, as the CPU does, with the same random masks: so the maps are the CPU's up to rounding, and
//! neither a limit on samples nor the edges of triangles make a difference. Drawing from the light with
//! multisampling, as the paper does, would be faster where the map is large, but has 4 or 8 samples at most
//! and a projection for each face of each kind of light.

use sheer_core::hash::pcg3d;
use sheer_render::{
    Shadow,
    shadow::projection::{DEPTH_ROUNDING, FACET_SLOPE, Face, FaceLens, Projection, STEEPEST, TAP_STEP},
};
use wgpu::{BindGroupEntry, BindGroupLayoutEntry, BufferBindingType, BufferUsages, ShaderStages};

use crate::{
    compile::{compute_pipeline, layout},
    device::Gpu,
    error::GpuError,
    frame::FrameParameters,
    layouts::Layouts,
    recording::Recording,
    resource::{
        bind_group::{buffer_entry, group_of, whole},
        buffer::{buffer, storage_limit},
    },
    shader::{
        Linker,
        binding::{BIND_SHADOW_FACES, BIND_SHADOW_LIGHTS, BIND_SHADOW_MAP},
        constant::{self, Constant},
        numbers::GROUP_SIDE,
        record::shadow::{ShadowFace, ShadowLight},
    },
    stage::GpuStage,
};

/// The step in which maps are made.
pub(crate) const STEP: &str = "shadow maps";

/// The technique's parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapSettings {
    resolution: u32,
    samples: u32,
    is_stratified: bool,
    is_corrected: bool,
    filter: u32,
    taps: u32,
}

impl MapSettings {
    /// None for deep shadow rays, which need no maps.
    ///
    /// # Errors
    /// The GPU has no such technique.
    pub(crate) fn of(shadow: &Shadow) -> Result<Option<Self>, GpuError> {
        let text = |key| shadow.value(key).unwrap_or_default();
        let count = |key| text(key).parse().unwrap_or(0);
        match shadow.info().id {
            "deep" => Ok(None),
            "stochastic-map" => Ok(Some(Self {
                resolution: count("resolution"),
                samples: count("samples"),
                is_stratified: text("sampling") == "stratified",
                is_corrected: text("correct") == "on",
                filter: count("filter"),
                taps: count("taps"),
            })),
            other => Err(GpuError::Unsupported {
                what: format!("there is no --shadow {other} on the GPU"),
                instead: "take --shadow stochastic-map, --shadow deep, or --backend cpu".to_owned(),
            }),
        }
    }

    /// Emitted for all shaders that make maps or look light up in them.
    pub(crate) fn constants(self) -> String {
        let Self { samples, is_stratified, is_corrected, filter, taps, .. } = self;
        let numbers = constant::text(&[
            Constant::new("SHADOW_SAMPLES", samples),
            Constant::new("SHADOW_FILTER", filter),
            Constant::new("SHADOW_TAPS", taps),
            Constant::new("FACET_SLOPE", FACET_SLOPE),
            Constant::new("STEEPEST", STEEPEST),
            Constant::new("DEPTH_ROUNDING", DEPTH_ROUNDING),
            Constant::new("TAP_STEP_X", TAP_STEP.x),
            Constant::new("TAP_STEP_Y", TAP_STEP.y),
        ]);
        numbers
            + &format!("const SHADOW_IS_STRATIFIED: bool = {is_stratified};\n")
            + &format!("const SHADOW_IS_CORRECTED: bool = {is_corrected};\n")
    }

    /// Numbers of a texel: the twin of `shadow_stride` in shaders/shared/shadow_texel.wgsl.
    fn stride(self, channels: u64) -> u64 {
        channels * u64::from(self.samples) + if self.is_corrected { 2 + 2 * channels } else { 0 }
    }
}

impl From<&Face> for ShadowFace {
    fn from(face: &Face) -> Self {
        let ([width, height], is_central, origin) = match face.lens {
            FaceLens::Parallel { low, texel } => (texel.into(), 0, low),
            FaceLens::Central { eye, half_width } => ([half_width; 2], 1, eye),
        };
        Self {
            right: face.axes.x_axis,
            width,
            up: face.axes.y_axis,
            height,
            forward: face.axes.z_axis,
            is_central,
            origin,
            padding: 0,
        }
    }
}

/// What it takes to make the maps of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MapRays {
    /// How many rays make them.
    pub(crate) count: u64,
    /// Whether they have other buffers now.
    pub(crate) replaced: bool,
}

/// The maps of all lights of a frame.
#[derive(Debug)]
pub(crate) struct ShadowMaps {
    settings: MapSettings,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    lights: wgpu::Buffer,
    faces: wgpu::Buffer,
    map: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// Workgroups of the pass; none without lights.
    groups: [u32; 3],
}

fn storage(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    buffer(device, label, size, BufferUsages::STORAGE | BufferUsages::COPY_DST)
}

impl ShadowMaps {
    /// The stages that look light up in maps: fragments are shaded in both.
    pub(crate) const READERS: ShaderStages = ShaderStages::FRAGMENT.union(ShaderStages::COMPUTE);

    pub(crate) fn new(
        gpu: &Gpu,
        settings: MapSettings,
        linker: &Linker,
        layouts: &Layouts,
    ) -> Result<Self, GpuError> {
        let device = gpu.device();
        let layout = layout(gpu, STEP, &Self::layout_entries(ShaderStages::COMPUTE, false));
        let piece = "pass/shadow_map";
        let module = gpu.shader(&linker.link(piece)?)?;
        let groups = [&layouts.scene, &layout];
        let pipeline = compute_pipeline(gpu, STEP, &groups, &module, "cs_shadow_map");
        // Shaders need something to bind before there is a light.
        let [lights, faces] = ["shadow lights", "shadow faces"].map(|label| storage(&device, label, 64));
        let map = storage(&device, "shadow map", 64);
        let group = own_group(&device, &layout, [&lights, &faces, &map]);
        gpu.check(piece)?;
        Ok(Self { settings, pipeline, layout, lights, faces, map, group, groups: [0; 3] })
    }

    /// The maps' part of the layout of group 1; the pass that makes the maps writes to them.
    pub(crate) fn layout_entries(visibility: ShaderStages, reads_map: bool) -> [BindGroupLayoutEntry; 3] {
        let storage = |read_only| BufferBindingType::Storage { read_only };
        [
            buffer_entry(BIND_SHADOW_LIGHTS, visibility, storage(true)),
            buffer_entry(BIND_SHADOW_FACES, visibility, storage(true)),
            buffer_entry(BIND_SHADOW_MAP, visibility, storage(reads_map)),
        ]
    }

    /// The maps' part of group 1.
    pub(crate) fn entries(&self) -> [BindGroupEntry<'_>; 3] {
        [
            whole(BIND_SHADOW_LIGHTS, &self.lights),
            whole(BIND_SHADOW_FACES, &self.faces),
            whole(BIND_SHADOW_MAP, &self.map),
        ]
    }

    /// Looks at the lights of a frame and makes room for their maps.
    ///
    /// # Errors
    /// The maps are larger than the device binds.
    pub(crate) fn prepare(
        &mut self,
        gpu: &Gpu,
        stage: &GpuStage,
        parameters: &FrameParameters,
    ) -> Result<MapRays, GpuError> {
        // Where each light's faces look, and where their texels lie.
        let frame = stage.frame();
        let (mut lights, mut faces, mut texels) = (Vec::new(), Vec::new(), 0_u64);
        self.groups = [0; 3];
        for (index, light) in (0..).zip(frame.lights()) {
            let projection = stage.pool().install(|| Projection::new(frame, light, self.settings.resolution));
            let side = projection.side() as u32;
            let face_count = projection.faces().len() as u32;
            let [key, ..] = pcg3d([parameters.index, parameters.seed, index]);
            let first_face = faces.len() as u32;
            // What is more than a word counts is more than a buffer holds: refused below.
            lights.push(ShadowLight { first_face, face_count, side, first_texel: texels as u32, key });
            faces.extend(projection.faces().iter().map(ShadowFace::from));
            texels += u64::from(face_count) * u64::from(side) * u64::from(side);
            let [columns, rows, count] = self.groups;
            let needed = [side, side * face_count].map(|length| length.div_ceil(GROUP_SIDE));
            self.groups = [columns.max(needed[0]), rows.max(needed[1]), count + 1];
        }
        // Room for all of them, and what shaders need to know.
        let channels = if frame.tints_light() { 3 } else { 1 };
        let replaced =
            self.make_room(gpu, lights.len(), faces.len(), texels * self.settings.stride(channels))?;
        let queue = gpu.queue();
        if !lights.is_empty() {
            queue.write_buffer(&self.lights, 0, bytemuck::cast_slice(&lights));
            queue.write_buffer(&self.faces, 0, bytemuck::cast_slice(&faces));
        }
        Ok(MapRays { count: texels, replaced })
    }

    /// Makes the buffers larger if they are too small; whether it did.
    fn make_room(&mut self, gpu: &Gpu, lights: usize, faces: usize, numbers: u64) -> Result<bool, GpuError> {
        let device = gpu.device();
        let limit = storage_limit(&device.limits());
        let needed = numbers.saturating_mul(size_of::<f32>() as u64);
        if needed > limit {
            return Err(GpuError::Limit {
                what: format!("stochastic maps for {lights} lights"),
                needed,
                limit,
                instead: "take a smaller resolution= or samples=, or --shadow deep".to_owned(),
            });
        }
        let mut replaced = false;
        let mut grow = |buffer: &mut wgpu::Buffer, label, needed| {
            if buffer.size() < needed {
                *buffer = storage(&device, label, needed);
                replaced = true;
            }
        };
        grow(&mut self.lights, "shadow lights", (lights * size_of::<ShadowLight>()) as u64);
        grow(&mut self.faces, "shadow faces", (faces * size_of::<ShadowFace>()) as u64);
        grow(&mut self.map, "shadow map", needed);
        if replaced {
            self.group = own_group(&device, &self.layout, [&self.lights, &self.faces, &self.map]);
            gpu.check("shadow maps")?;
        }
        Ok(replaced)
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, scene: &wgpu::BindGroup) {
        let [columns, rows, lights] = self.groups;
        if lights == 0 {
            return;
        }
        let mut pass = recording.compute_pass(STEP);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, scene, &[]);
        pass.set_bind_group(1, &self.group, &[]);
        pass.dispatch_workgroups(columns, rows, lights);
    }
}

/// Group 1 of the pass that makes the maps.
fn own_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    [lights, faces, map]: [&wgpu::Buffer; 3],
) -> wgpu::BindGroup {
    group_of(
        device,
        STEP,
        layout,
        &[whole(BIND_SHADOW_LIGHTS, lights), whole(BIND_SHADOW_FACES, faces), whole(BIND_SHADOW_MAP, map)],
    )
}

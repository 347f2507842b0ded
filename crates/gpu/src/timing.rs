//! What each pass of a frame takes, by the device's own clock.
//!
//! Timestamps are written at the ends of passes, which every device with `TIMESTAMP_QUERY` allows; neither
//! `TIMESTAMP_QUERY_INSIDE_ENCODERS` nor `TIMESTAMP_QUERY_INSIDE_PASSES`, which mobile and tiled devices
//! lack, is needed. A device without any timestamps gives no times.

use sheer_render::StepTime;
use wgpu::{
    BufferUsages, CommandEncoder, ComputePassTimestampWrites, Device, Features, MapMode, QuerySet, QueryType,
    Queue, RenderPassTimestampWrites,
};

use crate::device::Gpu;

/// Bytes of a timestamp in a buffer.
const TIMESTAMP_BYTES: u64 = size_of::<u64>() as u64;

/// Times the passes of one frame after the other: hands timestamps to passes while a frame is recorded, then
/// reads them all at once.
#[derive(Debug)]
pub(crate) struct Timer {
    clock: Option<Clock>,
    /// Steps whose passes were recorded, in their order.
    names: Vec<&'static str>,
    /// How many of them are on their way to be read.
    resolved: usize,
}

/// Where timestamps are written and read.
#[derive(Debug)]
struct Clock {
    queries: QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
    ms_per_tick: f64,
    /// The most passes of a frame.
    capacity: usize,
}

impl Clock {
    fn new(device: &Device, queue: &Queue, capacity: u32) -> Option<Self> {
        if !device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let capacity = capacity.min(wgpu::QUERY_SET_MAX_QUERIES / 2);
        let buffer = |label, usage| {
            let size = 2 * u64::from(capacity) * TIMESTAMP_BYTES;
            let descriptor =
                wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            device.create_buffer(&descriptor)
        };
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: QueryType::Timestamp,
                count: 2 * capacity,
            }),
            resolved: buffer("timestamps", BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            read: buffer("timestamps to read", BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            ms_per_tick: f64::from(queue.get_timestamp_period()) * 1e-6,
            capacity: capacity as usize,
        })
    }
}

impl Timer {
    /// Times nothing: where frames go into an encoder of the caller's, who reads nothing back.
    pub(crate) fn off() -> Self {
        Self { clock: None, names: Vec::new(), resolved: 0 }
    }

    /// A timer for frames of up to `capacity` passes; further ones are not timed.
    pub(crate) fn new(device: &Device, queue: &Queue, capacity: u32) -> Self {
        Self { clock: Clock::new(device, queue, capacity), names: Vec::new(), resolved: 0 }
    }

    /// Forgets passes of a frame whose times nobody has asked for.
    pub(crate) fn begin_frame(&mut self) {
        self.names.clear();
        self.resolved = 0;
    }

    /// What a compute pass is begun with, to count as step `name`. Passes of one name are added up.
    pub(crate) fn compute_writes(&mut self, name: &'static str) -> Option<ComputePassTimestampWrites<'_>> {
        let (queries, first) = self.next(name)?;
        Some(ComputePassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// What a render pass is begun with, to count as step `name`.
    pub(crate) fn render_writes(&mut self, name: &'static str) -> Option<RenderPassTimestampWrites<'_>> {
        let (queries, first) = self.next(name)?;
        Some(RenderPassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// The first of two queries for the next pass.
    fn next(&mut self, name: &'static str) -> Option<(&QuerySet, u32)> {
        let clock = self.clock.as_ref()?;
        // What was resolved belongs to the frame before, whether it was read or not.
        if self.resolved > 0 {
            self.names.clear();
            self.resolved = 0;
        }
        if self.names.len() == clock.capacity {
            return None;
        }
        self.names.push(name);
        Some((&clock.queries, 2 * (self.names.len() as u32 - 1)))
    }

    /// Records that the frame's timestamps are brought to where they can be read: after its last pass.
    pub(crate) fn resolve(&mut self, encoder: &mut CommandEncoder) {
        let Some(clock) = &self.clock else { return };
        if self.names.is_empty() || self.resolved > 0 {
            return;
        }
        self.resolved = self.names.len();
        let count = 2 * self.resolved as u32;
        encoder.resolve_query_set(&clock.queries, 0..count, &clock.resolved, 0);
        let bytes = u64::from(count) * TIMESTAMP_BYTES;
        encoder.copy_buffer_to_buffer(&clock.resolved, 0, &clock.read, 0, bytes);
    }

    /// Times of the steps of the last frame that was resolved and submitted, in order; waits for the device
    /// if it is not done. None where the device has no clock or is lost.
    pub(crate) fn read(&mut self, gpu: &Gpu) -> Vec<StepTime> {
        let Some(clock) = &self.clock else { return Vec::new() };
        if self.resolved == 0 {
            return Vec::new();
        }
        let names = std::mem::take(&mut self.names);
        self.resolved = 0;
        let bytes = 2 * names.len() as u64 * TIMESTAMP_BYTES;
        clock.read.map_async(MapMode::Read, ..bytes, |_| ());
        if gpu.wait().is_err() {
            return Vec::new();
        }
        // A lost device maps nothing.
        let Ok(view) = clock.read.get_mapped_range(..bytes) else { return Vec::new() };
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&view);
        drop(view);
        clock.read.unmap();
        added_up(&names, &ticks, clock.ms_per_tick)
    }
}

/// Begin and end of each pass as milliseconds, passes of one name as one step in the place of the first.
fn added_up(names: &[&'static str], ticks: &[u64], ms_per_tick: f64) -> Vec<StepTime> {
    let mut steps: Vec<StepTime> = Vec::new();
    for (&name, pass) in names.iter().zip(ticks.chunks_exact(2)) {
        // A clock that was set back between the two, which the specification allows, counts as none.
        let ms = pass[1].saturating_sub(pass[0]) as f64 * ms_per_tick;
        match steps.iter_mut().find(|step| step.name == name) {
            Some(step) => step.ms += ms,
            None => steps.push(StepTime { name, ms }),
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;
    use crate::{device::AdapterChoice, shader::Linker};

    #[test]
    fn passes_of_one_name_are_one_step_in_the_place_of_the_first() {
        let steps = added_up(&["peel", "blend", "peel"], &[10, 20, 20, 25, 30, 90], 0.5);
        let expected = [StepTime { name: "peel", ms: 35.0 }, StepTime { name: "blend", ms: 2.5 }];
        assert_eq!(steps, expected);
        assert_eq!(added_up(&["trace"], &[7, 3], 1.0), [StepTime { name: "trace", ms: 0.0 }]);
    }

    /// A shader that is at work for as long as it is told.
    const WORK: &str = "@group(0) @binding(0) var<storage, read_write> data: array<u32>;
        @compute @workgroup_size(64) fn cs_work(@builtin(global_invocation_id) id: vec3u) {
            var value = id.x;
            for (var i = 0u; i < data[0]; i += 1u) { value = value * 1664525u + 1013904223u; }
            data[id.x + 1u] = value;
        }";

    /// Runs the shader once for each number of rounds and gives the steps' times, with those by our clock
    /// around all.
    fn time(gpu: &Gpu, timer: &mut Timer, rounds: &[(&'static str, u32)]) -> (Vec<StepTime>, f64) {
        let (device, queue) = (gpu.device(), gpu.queue());
        let module =
            gpu.shader(&Linker::of_pieces(&[("work", WORK)], String::new()).link("work").unwrap()).unwrap();
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let groups: Vec<wgpu::BindGroup> = rounds
            .iter()
            .map(|&(_, rounds)| {
                let data = device.create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size: 4 * 4097,
                    usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                queue.write_buffer(&data, 0, bytemuck::bytes_of(&rounds));
                device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: None,
                    layout: &pipeline.get_bind_group_layout(0),
                    entries: &[wgpu::BindGroupEntry { binding: 0, resource: data.as_entire_binding() }],
                })
            })
            .collect();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for (&(name, _), group) in rounds.iter().zip(&groups) {
            let timestamp_writes = timer.compute_writes(name);
            let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(64, 1, 1);
        }
        timer.resolve(&mut encoder);
        let start = Instant::now();
        queue.submit([encoder.finish()]);
        let steps = timer.read(gpu);
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        gpu.check("timing").unwrap();
        (steps, wall_ms)
    }

    #[test]
    fn each_step_of_each_frame_is_timed_and_long_work_takes_longer() {
        let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
        let mut timer = Timer::new(&gpu.device(), &gpu.queue(), 2);
        for _ in 0..2 {
            let (steps, wall_ms) =
                time(&gpu, &mut timer, &[("short", 10), ("long", 200_000), ("beyond capacity", 1)]);
            let names: Vec<_> = steps.iter().map(|step| step.name).collect();
            assert_eq!(names, ["short", "long"]);
            // Twenty thousand times the work: no load of the machine turns the order around.
            assert!(steps[1].ms > steps[0].ms, "{steps:?}");
            assert!(steps.iter().map(|step| step.ms).sum::<f64>() <= wall_ms, "{steps:?} in {wall_ms} ms");
        }
        assert_eq!(timer.read(&gpu), [], "times are read once");
    }

    #[test]
    fn a_device_without_a_clock_gives_no_times() {
        let gpu = Gpu::new(&AdapterChoice::Best).unwrap();
        let mut timer = Timer { clock: None, names: Vec::new(), resolved: 0 };
        assert_eq!(time(&gpu, &mut timer, &[("short", 10)]).0, []);
    }
}

//! Adapters and devices: which one is taken, what is asked of it, and what becomes of its errors.

use std::{
    convert::Infallible,
    fmt,
    path::PathBuf,
    str::FromStr,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
};

use wgpu::{DeviceType, DownlevelFlags, ErrorFilter, Features, TextureFormat, TextureFormatFeatureFlags};

use crate::{
    compiled::Compiled,
    error::GpuError,
    shader::linked::{self, Linked},
};

/// Which adapter is taken.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The fastest by its kind, then the one that can trace rays.
    #[default]
    Best,
    /// The one at an index of [`adapters`], or the first whose name or driver contains a text, whatever its
    /// case.
    Named(String),
}

impl FromStr for AdapterChoice {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self::Named(text.to_owned()))
    }
}

/// How rays are traced on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tracer {
    /// By the device's own acceleration structures, from any shader.
    Query,
    /// Through the tree of [`sheer_accel`], by arithmetic alone: on devices that have no ray query.
    Bvh,
}

/// An adapter and what it can run.
#[derive(Clone, Debug)]
pub struct AdapterReport {
    /// The adapter's name, as the driver gives it.
    pub name: String,
    /// Discrete, integrated, virtual, software or unknown.
    pub kind: &'static str,
    /// Driver and its version.
    pub driver: String,
    /// The interface it is reached through.
    pub api: String,
    /// Whether rays can be traced by the device itself.
    pub ray_query: bool,
    /// Whether passes can be timed by the device.
    pub timestamps: bool,
    /// Samples a pixel that colour and depth targets may have beside one.
    pub msaa: Vec<u32>,
    /// The largest buffer that a shader reads, bytes.
    pub max_storage_bytes: u64,
    /// How many storage buffers one shader may bind.
    pub max_storage_buffers: u32,
    /// Whether there are compute shaders.
    pub compute: bool,
    /// Whether vertex shaders read storage buffers and fragment shaders write them.
    pub storage_in_raster: bool,
}

impl AdapterReport {
    fn new(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let features = adapter.features();
        let limits = adapter.limits();
        let flags = adapter.get_downlevel_capabilities().flags;
        let storage_in_raster = DownlevelFlags::VERTEX_STORAGE | DownlevelFlags::FRAGMENT_WRITABLE_STORAGE;
        Self {
            name: info.name,
            kind: kind_word(info.device_type),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            api: info.backend.to_string(),
            ray_query: features.contains(Features::EXPERIMENTAL_RAY_QUERY),
            timestamps: features.contains(Features::TIMESTAMP_QUERY),
            msaa: [4, 8].into_iter().filter(|&count| has_samples(adapter, count)).collect(),
            max_storage_bytes: limits.max_storage_buffer_binding_size,
            max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
            compute: flags.contains(DownlevelFlags::COMPUTE_SHADERS),
            storage_in_raster: flags.contains(storage_in_raster),
        }
    }

    /// The same, less what a device was opened without.
    fn of_device(adapter: &wgpu::Adapter, device: &wgpu::Device) -> Self {
        let (features, limits) = (device.features(), device.limits());
        let mut report = Self::new(adapter);
        report.ray_query = features.contains(Features::EXPERIMENTAL_RAY_QUERY);
        report.timestamps = features.contains(Features::TIMESTAMP_QUERY);
        if !features.contains(Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES) {
            // What WebGPU guarantees.
            report.msaa.retain(|&count| count == 4);
        }
        report.max_storage_bytes = limits.max_storage_buffer_binding_size;
        report.max_storage_buffers = limits.max_storage_buffers_per_shader_stage;
        report
    }
}

impl fmt::Display for AdapterReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {})", self.name, self.api, self.driver)
    }
}

fn kind_word(kind: DeviceType) -> &'static str {
    match kind {
        DeviceType::DiscreteGpu => "discrete",
        DeviceType::IntegratedGpu => "integrated",
        DeviceType::VirtualGpu => "virtual",
        DeviceType::Cpu => "software",
        DeviceType::Other => "unknown",
    }
}

/// Whether the targets of stochastic transparency may have so many samples.
fn has_samples(adapter: &wgpu::Adapter, count: u32) -> bool {
    let flag = match count {
        4 => TextureFormatFeatureFlags::MULTISAMPLE_X4,
        _ => TextureFormatFeatureFlags::MULTISAMPLE_X8,
    };
    // Four samples are there everywhere; the driver's word counts for more.
    let formats = [TextureFormat::Rgba16Float, TextureFormat::R16Float, TextureFormat::Depth32Float];
    formats.into_iter().all(|format| adapter.get_texture_format_features(format).flags.contains(flag))
}

fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // Names and lines within compiled shaders: drivers take longer to read them, and nobody looks at them,
    // since errors are told by the piece and its line before a driver sees anything.
    descriptor.flags.remove(wgpu::InstanceFlags::DEBUG);
    wgpu::Instance::new(descriptor)
}

/// All adapters, the best first.
fn sorted_adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let rank = |adapter: &wgpu::Adapter| {
        let kind = match adapter.get_info().device_type {
            DeviceType::DiscreteGpu => 0,
            DeviceType::IntegratedGpu => 1,
            DeviceType::VirtualGpu => 2,
            DeviceType::Cpu => 3,
            DeviceType::Other => 4,
        };
        (kind, !adapter.features().contains(Features::EXPERIMENTAL_RAY_QUERY))
    };
    adapters.sort_by_key(rank);
    adapters
}

/// All adapters of this machine, the best first.
#[must_use]
pub fn adapters() -> Vec<AdapterReport> {
    sorted_adapters(&instance()).iter().map(AdapterReport::new).collect()
}

/// The features that are used where an adapter has them; none is indispensable.
///
/// * `EXPERIMENTAL_RAY_QUERY`: [`Tracer::Query`]; without it our own tree is traversed.
/// * `TIMESTAMP_QUERY`: times of passes by the device's clock; without it the frame as a whole is timed from
///   outside.
/// * `FLOAT32_BLENDABLE`: sums of moments by the blending units; without it the method is refused.
/// * `TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES`: 8 samples a pixel; without it there are 4 and more passes.
fn wanted_features() -> Features {
    Features::EXPERIMENTAL_RAY_QUERY
        | Features::TIMESTAMP_QUERY
        | Features::FLOAT32_BLENDABLE
        | Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES
}

/// What has gone wrong on a device since it was last asked.
#[derive(Debug, Default)]
struct Faults {
    lost: Option<String>,
    errors: Vec<wgpu::Error>,
}

/// A device that is open.
#[derive(Clone, Debug)]
struct Open {
    device: wgpu::Device,
    queue: wgpu::Queue,
    faults: Arc<Mutex<Faults>>,
    generation: u32,
    compiled: Arc<Mutex<Compiled>>,
}

/// An adapter with its device.
///
/// One that [`Self::new`] has opened is replaced when it is lost: what was made with the old one has another
/// [`Self::generation`] and has to be made again. One that the caller has opened ([`Self::from_wgpu`]) stays
/// the caller's: no callback is set, nothing is reopened.
///
/// Shaders and pipelines are compiled once a device, whatever asks for them.
#[derive(Debug)]
pub struct Gpu {
    /// By what a lost device is replaced; none where it is the caller's.
    choice: Option<AdapterChoice>,
    tracer: Option<Tracer>,
    report: AdapterReport,
    /// Where the sources of shaders are written, if anywhere.
    pub(crate) shader_folder: Option<PathBuf>,
    open: Mutex<Open>,
    /// Whether the scene sent last has coloured glass: pipelines are made before they meet their stage, and
    /// are spared making their shaders twice where the guess is right.
    expects_glass: AtomicBool,
    wait_count: AtomicU64,
}

/// Nothing is left half-done by a panic here.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gpu {
    /// Opens the device of an adapter.
    ///
    /// # Errors
    /// There is no such adapter, or it opens no device.
    pub fn new(choice: &AdapterChoice) -> Result<Arc<Self>, GpuError> {
        Self::with_tracer(choice, None)
    }

    /// The same with a way of tracing rays instead of the best one.
    ///
    /// # Errors
    /// As [`Self::new`], or the adapter has no ray query.
    pub fn with_tracer(choice: &AdapterChoice, tracer: Option<Tracer>) -> Result<Arc<Self>, GpuError> {
        let (report, open) = open(choice, tracer, 0)?;
        Ok(Self::of_parts(Some(choice.clone()), tracer, report, open))
    }

    /// See [`Self::from_wgpu`], which looks at what the device was opened with.
    pub(crate) fn of_caller(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Arc<Self> {
        let report = AdapterReport::of_device(adapter, &device);
        let open = Open { device, queue, faults: Arc::default(), generation: 0, compiled: Arc::default() };
        Self::of_parts(None, None, report, open)
    }

    fn of_parts(
        choice: Option<AdapterChoice>,
        tracer: Option<Tracer>,
        report: AdapterReport,
        open: Open,
    ) -> Arc<Self> {
        Arc::new(Self {
            choice,
            tracer,
            report,
            shader_folder: linked::folder(),
            open: Mutex::new(open),
            expects_glass: AtomicBool::new(false),
            wait_count: AtomicU64::new(0),
        })
    }

    /// Whether the device is the caller's.
    pub(crate) fn is_foreign(&self) -> bool {
        self.choice.is_none()
    }

    /// The device that is open now: another one after it was lost.
    #[must_use]
    pub fn device(&self) -> wgpu::Device {
        lock(&self.open).device.clone()
    }

    /// The queue of the device that is open now.
    #[must_use]
    pub fn queue(&self) -> wgpu::Queue {
        lock(&self.open).queue.clone()
    }

    /// How many devices were lost before this one.
    #[must_use]
    pub fn generation(&self) -> u32 {
        lock(&self.open).generation
    }

    /// What it is and can run.
    #[must_use]
    pub fn report(&self) -> &AdapterReport {
        &self.report
    }

    /// Name and driver, for reports.
    #[must_use]
    pub fn description(&self) -> String {
        self.report.to_string()
    }

    /// How rays are traced.
    #[must_use]
    pub fn tracer(&self) -> Tracer {
        let best = if self.report.ray_query { Tracer::Query } else { Tracer::Bvh };
        self.tracer.unwrap_or(best)
    }

    /// The device's features.
    pub(crate) fn features(&self) -> Features {
        lock(&self.open).device.features()
    }

    /// Whether the scene sent last has coloured glass.
    pub(crate) fn expects_glass(&self) -> bool {
        self.expects_glass.load(Ordering::Relaxed)
    }

    /// Tells that a scene has been sent, and whether it has coloured glass.
    pub(crate) fn expect_glass(&self, has_glass: bool) {
        self.expects_glass.store(has_glass, Ordering::Relaxed);
    }

    /// Takes a new device in the place of a lost one. Nothing happens if that was done since `generation`.
    ///
    /// # Errors
    /// As [`Self::new`]; [`GpuError::DeviceLost`] where the device is the caller's.
    pub(crate) fn reopen(&self, generation: u32) -> Result<(), GpuError> {
        let Some(choice) = &self.choice else { return Err(lost_to_the_caller()) };
        let mut current = lock(&self.open);
        if current.generation == generation {
            *current = open(choice, self.tracer, generation + 1)?.1;
        }
        Ok(())
    }

    /// Where compiled shaders and pipelines of the open device are kept.
    pub(crate) fn compiled(&self) -> Arc<Mutex<Compiled>> {
        Arc::clone(&lock(&self.open).compiled)
    }

    /// From here on pipelines are compiled through a cache of the caller's, which may be kept from run to run
    /// (`Features::PIPELINE_CACHE`; made by `Device::create_pipeline_cache` of this device).
    pub fn use_pipeline_cache(&self, cache: wgpu::PipelineCache) {
        lock(&self.compiled()).driver_cache = Some(cache);
    }

    /// How many pipelines were compiled with the device that is open now.
    #[must_use]
    pub fn pipelines_compiled(&self) -> u64 {
        lock(&self.compiled()).pipeline_count
    }

    /// How often the device was waited for so far; every read-back is among them.
    #[must_use]
    pub fn wait_count(&self) -> u64 {
        self.wait_count.load(Ordering::Relaxed)
    }

    /// Does something with the device: on one of the caller's within error scopes of this thread, since no
    /// callback hears of its errors there.
    ///
    /// # Errors
    /// Those of `make`; the device is lost or has refused something.
    pub(crate) fn scoped<T>(
        &self,
        what: &str,
        make: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        if !self.is_foreign() {
            return make();
        }
        let device = self.device();
        let filters = [ErrorFilter::OutOfMemory, ErrorFilter::Validation, ErrorFilter::Internal];
        let scopes = filters.map(|filter| device.push_error_scope(filter));
        let made = if is_lost(&device) { Err(lost_to_the_caller()) } else { make() };
        // The scope pushed last is popped first; what has failed is known at once, without the device.
        let errors = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
        self.note(errors);
        let told = self.check(what);
        made.and_then(|made| told.map(|()| made))
    }

    /// Keeps errors for the next [`Self::check`].
    pub(crate) fn note(&self, errors: Vec<wgpu::Error>) {
        let open = lock(&self.open);
        lock(&open.faults).errors.extend(errors);
    }

    /// Loses the device, as a driver that has crashed does: to try what comes of it.
    pub fn lose_device(&self) {
        self.device().destroy();
    }

    /// The first thing that went wrong since the last call; `what` was being done.
    ///
    /// # Errors
    /// The device is lost, has no memory left, or has refused something.
    pub(crate) fn check(&self, what: &str) -> Result<(), GpuError> {
        let open = lock(&self.open);
        let mut faults = lock(&open.faults);
        let errors = std::mem::take(&mut faults.errors);
        if let Some(reason) = &faults.lost {
            return Err(GpuError::DeviceLost { reason: reason.clone() });
        }
        errors.into_iter().next().map_or(Ok(()), |error| Err(gpu_error(error, what)))
    }

    /// Compiles a linked shader, and writes its source to the folder that `SHEER_SHADERS` names.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with piece and line and what is wrong there, or when the source cannot be
    /// written.
    pub(crate) fn shader(&self, linked: &Linked) -> Result<wgpu::ShaderModule, GpuError> {
        if let Some(folder) = &self.shader_folder {
            linked.write(folder)?;
        }
        let compiled = self.compiled();
        if let Some(module) = lock(&compiled).module(&linked.text) {
            return Ok(module);
        }
        let device = self.device();
        let scope = device.push_error_scope(ErrorFilter::Validation);
        let source = wgpu::ShaderSource::Wgsl(linked.text.as_str().into());
        let label = Some(linked.piece.as_str());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(GpuError::Shader {
                piece: linked.piece.clone(),
                problem: linked.relocated(&error.to_string()),
            }),
            None => {
                lock(&compiled).keep_module(&linked.text, &module);
                Ok(module)
            }
        }
    }

    /// Waits until everything that was submitted is done.
    ///
    /// # Errors
    /// The device is lost.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        self.wait_count.fetch_add(1, Ordering::Relaxed);
        let result = self.device().poll(wgpu::PollType::wait_indefinitely());
        self.check("waiting for the device")?;
        result.map(|_| ()).map_err(|error| GpuError::DeviceLost { reason: error.to_string() })
    }

    /// The same, so that the time it takes is known; a device of the caller's is not waited for.
    ///
    /// # Errors
    /// As [`Self::wait`].
    pub(crate) fn settle(&self) -> Result<(), GpuError> {
        if self.is_foreign() { Ok(()) } else { self.wait() }
    }

    /// Lets wgpu give back what submissions that are done no longer need; waits for none.
    ///
    /// # Errors
    /// The device is lost.
    pub(crate) fn tidy_up(&self) -> Result<(), GpuError> {
        let polled = self.device().poll(wgpu::PollType::Poll);
        polled.map(|_| ()).map_err(|error| GpuError::DeviceLost { reason: error.to_string() })
    }
}

/// Whether a device is lost, without a callback: on such a device no buffer can be mapped.
fn is_lost(device: &wgpu::Device) -> bool {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("sheer: is the device there"),
        size: wgpu::COPY_BUFFER_ALIGNMENT,
        usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    });
    let is_mapped = buffer.get_mapped_range(..).is_ok();
    !is_mapped
}

fn lost_to_the_caller() -> GpuError {
    GpuError::DeviceLost { reason: "the program that opened it has to open another one".to_owned() }
}

/// An error of wgpu as one of ours; `what` was being done.
fn gpu_error(error: wgpu::Error, what: &str) -> GpuError {
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory { what: what.to_owned() },
        wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
            GpuError::Refused { what: what.to_owned(), problem: description }
        }
    }
}

fn open(
    choice: &AdapterChoice,
    tracer: Option<Tracer>,
    generation: u32,
) -> Result<(AdapterReport, Open), GpuError> {
    let adapter = choose(choice)?;
    let report = AdapterReport::new(&adapter);
    if tracer == Some(Tracer::Query) && !report.ray_query {
        return Err(GpuError::Unsupported {
            what: format!("{} has no ray query", report.name),
            instead: "leave the way of tracing to it, or take --backend gpu:raster".to_owned(),
        });
    }
    let mut features = adapter.features() & wanted_features();
    if tracer == Some(Tracer::Bvh) {
        features.remove(Features::EXPERIMENTAL_RAY_QUERY);
    }
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("sheer"),
        required_features: features,
        required_limits: adapter.limits(),
        experimental_features: experimental(features),
        memory_hints: wgpu::MemoryHints::Performance,
        trace: wgpu::Trace::Off,
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
        .map_err(|error| GpuError::NoDevice { adapter: report.name.clone(), problem: error.to_string() })?;
    let faults = Arc::new(Mutex::new(Faults::default()));
    let record = Arc::clone(&faults);
    device.on_uncaptured_error(Arc::new(move |error| lock(&record).errors.push(error)));
    let record = Arc::clone(&faults);
    device.set_device_lost_callback(move |_, reason| {
        let reason = if reason.is_empty() { "the driver gives no reason".to_owned() } else { reason };
        lock(&record).lost = Some(reason);
    });
    Ok((report, Open { device, queue, faults, generation, compiled: Arc::default() }))
}

/// Ray query is marked experimental in wgpu as a whole.
fn experimental(features: Features) -> wgpu::ExperimentalFeatures {
    if !features.contains(Features::EXPERIMENTAL_RAY_QUERY) {
        return wgpu::ExperimentalFeatures::disabled();
    }
    #[expect(unsafe_code, reason = "the only way to ray query in wgpu")]
    // SAFETY: what may go wrong there is a shader that misuses a query; ours ask for candidates only after
    // `proceed` was true and for the committed hit only after it was false, and all of them are traced in the
    // tests.
    unsafe {
        wgpu::ExperimentalFeatures::enabled()
    }
}

fn choose(choice: &AdapterChoice) -> Result<wgpu::Adapter, GpuError> {
    let mut adapters = sorted_adapters(&instance());
    if adapters.is_empty() {
        return Err(GpuError::NoAdapter { problem: "no adapter was found".to_owned() });
    }
    let AdapterChoice::Named(wanted) = choice else { return Ok(adapters.swap_remove(0)) };
    let reports: Vec<AdapterReport> = adapters.iter().map(AdapterReport::new).collect();
    let holds = |text: &str| text.to_lowercase().contains(&wanted.to_lowercase());
    let by_name = || reports.iter().position(|report| holds(&report.to_string()));
    let at = wanted.parse().ok().filter(|&at: &usize| at < adapters.len()).or_else(by_name);
    match at {
        Some(at) => Ok(adapters.swap_remove(at)),
        None => {
            let known = reports.iter().enumerate().map(|(at, report)| format!("{at}: {report}"));
            let known = known.collect::<Vec<_>>().join("; ");
            Err(GpuError::NoAdapter { problem: format!("there is no adapter '{wanted}'; there are {known}") })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::Linker;

    #[test]
    fn a_bad_shader_is_told_by_piece_and_line_and_the_device_lives() {
        let gpu = Gpu::new(&AdapterChoice::Best).expect("the tests need a Vulkan driver");
        let slip = "// The second line is wrong.\nfn helper() -> f32 { return nothing; }\n";
        let pass = "#import shared/helper\n@compute @workgroup_size(1)\nfn cs_slip() { let x = helper(); }\n";
        let linked = |helper| {
            let pieces = [("pass/slip", pass), ("shared/helper", helper)];
            Linker::of_pieces(&pieces, "const C: u32 = 1u;\n".to_owned()).link("pass/slip").unwrap()
        };
        let error = gpu.shader(&linked(slip)).unwrap_err().to_string();
        assert!(error.contains("pass/slip") && error.contains("nothing"), "{error}");
        assert!(error.contains("shared/helper.wgsl:2:"), "{error}");
        assert!(!error.contains("wgsl:3:"), "the line of the whole text is told: {error}");
        gpu.check("what came before").unwrap();
        gpu.shader(&linked("fn helper() -> f32 { return 1.0; }\n")).unwrap();
    }

    #[test]
    fn what_wgpu_refuses_is_told_once_and_the_device_lives() {
        let gpu = Gpu::new(&AdapterChoice::Best).expect("the tests need a Vulkan driver");
        let device = gpu.device();
        let size = device.limits().max_buffer_size + 4;
        let usage = wgpu::BufferUsages::STORAGE;
        let _ = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        });
        let error = gpu.check("a buffer beyond all bounds").unwrap_err();
        assert!(
            matches!(&error, GpuError::Refused { what, .. } if what.contains("beyond all bounds")),
            "{error}"
        );
        gpu.check("the same again").unwrap();
    }

    #[test]
    fn memory_that_runs_out_is_named_with_a_way_out() {
        let error =
            gpu_error(wgpu::Error::OutOfMemory { source: "none left".into() }, "list nodes").to_string();
        assert!(error.contains("no memory left for list nodes") && error.contains("--size"), "{error}");
    }
}

//! By rays or by raster: which of the two runs a method, and on which devices they run at all.

use sheer_render::Method;
use wgpu::{BindGroupLayoutEntry, BindingType, BufferBindingType};

use crate::{
    device::{AdapterReport, Gpu, Tracer},
    error::GpuError,
    layouts::Layouts,
    raster::RasterPath,
    ray::Search,
    stage::GpuStage,
};

/// How pixels come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GpuPath {
    /// Each pixel follows its ray.
    Ray,
    /// All triangles are drawn.
    Raster,
}

/// Which path the user asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GpuPathChoice {
    /// Rays where the device traces them itself and the method goes by rays, else raster.
    #[default]
    Automatic,
    /// Rays, through our own tree where the device has none.
    Ray,
    /// Raster, on any device that has storage buffers in vertex and fragment shaders.
    Raster,
}

impl GpuPath {
    /// Both, in the order in which they are listed.
    pub const ALL: [Self; 2] = [Self::Ray, Self::Raster];

    /// The paths that an adapter runs: none where it lacks compute shaders or binds too few storage buffers.
    #[must_use]
    pub fn supported_by(report: &AdapterReport) -> Vec<Self> {
        Self::ALL.into_iter().filter(|path| path.check(report).is_ok()).collect()
    }

    /// Storage buffers that a shader of the path binds at most, shadow maps aside.
    pub(crate) fn storage_buffer_count(self, tracer: Tracer) -> u32 {
        let is_storage = |entry: &&BindGroupLayoutEntry| {
            matches!(entry.ty, BindingType::Buffer { ty: BufferBindingType::Storage { .. }, .. })
        };
        let groups = Layouts::entries(&GpuStage::layout_entries(tracer), &[]);
        let common = groups.iter().flatten().filter(is_storage).count() as u32;
        match self {
            Self::Ray => common,
            Self::Raster => common + RasterPath::MOST_OWN_STORAGE_BUFFERS,
        }
    }

    /// Whether light that shines through coloured glass takes its colour.
    pub(crate) fn follows_glass(self) -> bool {
        self == Self::Ray
    }

    /// Whether an adapter has what the path cannot do without.
    fn check(self, report: &AdapterReport) -> Result<(), GpuError> {
        let tracer = if report.ray_query { Tracer::Query } else { Tracer::Bvh };
        let needed = self.storage_buffer_count(tracer);
        let name = &report.name;
        let problem = if !report.compute {
            format!("{name} has no compute shaders")
        } else if self == Self::Raster && !report.storage_in_raster {
            format!("{name} has no storage buffers in vertex or fragment shaders")
        } else if report.max_storage_buffers < needed {
            format!(
                "{name} binds {} storage buffers a shader, {needed} are needed",
                report.max_storage_buffers
            )
        } else {
            return Ok(());
        };
        Err(GpuError::Unsupported {
            what: problem,
            instead: "take another one of `sheer devices`, or --backend cpu".to_owned(),
        })
    }
}

impl GpuPathChoice {
    /// All, in the order in which they are listed.
    pub const ALL: [Self; 3] = [Self::Automatic, Self::Ray, Self::Raster];

    /// The name by which the backend is asked for.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Automatic => "gpu",
            Self::Ray => "gpu:ray",
            Self::Raster => "gpu:raster",
        }
    }
}

/// # Errors
/// Nothing but a rasteriser runs the method.
pub(crate) fn goes_by_rays(method: &Method) -> Result<(), GpuError> {
    if Search::of(method).is_some() {
        return Ok(());
    }
    Err(GpuError::Unsupported {
        what: format!("method {} wants its fragments in the order in which they are drawn", method.info().id),
        instead: "take --backend gpu or gpu:raster".to_owned(),
    })
}

/// Decides by what the user wants, what the method is and what the device can; and what the user should know
/// of it.
///
/// # Errors
/// The method does not go by rays, or the device does not run the path.
pub(crate) fn choose_path(
    gpu: &Gpu,
    choice: GpuPathChoice,
    method: &Method,
) -> Result<(GpuPath, Vec<String>), GpuError> {
    let (path, notes) = match choice {
        GpuPathChoice::Raster => (GpuPath::Raster, Vec::new()),
        GpuPathChoice::Ray => {
            goes_by_rays(method)?;
            (GpuPath::Ray, Vec::new())
        }
        GpuPathChoice::Automatic if Search::of(method).is_none() => (GpuPath::Raster, Vec::new()),
        GpuPathChoice::Automatic if gpu.tracer() == Tracer::Query => (GpuPath::Ray, Vec::new()),
        GpuPathChoice::Automatic => {
            let name = &gpu.report().name;
            let note = format!(
                "{name} has no ray query: {method} is drawn by raster; --backend gpu:ray traces it all the same"
            );
            (GpuPath::Raster, vec![note])
        }
    };
    path.check(gpu.report())?;
    Ok((path, notes))
}

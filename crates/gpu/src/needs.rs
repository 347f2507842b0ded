//! What a device has to be opened with, for callers who open it themselves.

use sheer_render::{Method, contract::Raster};
use wgpu::{DownlevelFlags, Features, Limits};

use crate::{
    device::Tracer,
    error::GpuError,
    path::{GpuPath, goes_by_rays},
    raster::plan::{blending_features, most_target_bytes, raster_of},
};

/// Uniform and vertex buffers that a stage binds beside storage buffers, at most.
const OTHER_BUFFERS: u32 = 4;
/// What group 1 has beside what every pass binds: the layers of pixels, and what shadow maps take.
const LAYER_BUFFERS: u32 = 1;
const SHADOW_MAP_BUFFERS: u32 = 3;

/// Features and limits that a device needs for a method on a path.
///
/// Several needs are one by [`Self::and`]. To open a device: `required_features: needs.features`,
/// `required_limits: needs.limits`, on an adapter that has [`Self::downlevel_flags`].
#[derive(Clone, Debug, PartialEq)]
pub struct Needs {
    /// Without these the method does not run.
    pub features: Features,
    /// With these it runs better: rays traced by the device, more samples a pixel in one pass.
    pub useful_features: Features,
    /// At least these.
    pub limits: Limits,
    /// What the adapter has to be capable of; no device is opened with more or less of it.
    pub downlevel_flags: DownlevelFlags,
}

impl Needs {
    /// What a method needs on a path, whatever the anti-aliasing; with deep shadow rays, see
    /// [`Self::with_shadow_maps`].
    ///
    /// # Errors
    /// The path does not run the method.
    pub fn of(method: &Method, path: GpuPath) -> Result<Self, GpuError> {
        let mut needs = Self::of_path(path);
        needs.add_storage_buffers(LAYER_BUFFERS);
        if path == GpuPath::Ray {
            goes_by_rays(method)?;
            return Ok(needs);
        }
        match raster_of(method)? {
            Some(Raster::Passes(passes)) => {
                needs.features |= blending_features(&passes);
                let bytes = &mut needs.limits.max_color_attachment_bytes_per_sample;
                *bytes = (*bytes).max(most_target_bytes(&passes));
            }
            Some(Raster::Multisample(_)) => {
                needs.useful_features |= Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
            }
            Some(Raster::Lists) | None => {}
        }
        Ok(needs)
    }

    /// What every method needs on a path.
    pub(crate) fn of_path(path: GpuPath) -> Self {
        let mut needs = Self {
            features: Features::empty(),
            useful_features: match path {
                GpuPath::Ray => Features::EXPERIMENTAL_RAY_QUERY,
                GpuPath::Raster => Features::empty(),
            },
            limits: Limits { max_storage_buffers_per_shader_stage: 0, ..Limits::default() },
            downlevel_flags: match path {
                GpuPath::Ray => DownlevelFlags::COMPUTE_SHADERS,
                GpuPath::Raster => {
                    DownlevelFlags::COMPUTE_SHADERS
                        | DownlevelFlags::VERTEX_STORAGE
                        | DownlevelFlags::FRAGMENT_WRITABLE_STORAGE
                }
            },
        };
        // Our own tree takes more buffers than the device's structures.
        needs.add_storage_buffers(path.storage_buffer_count(Tracer::Bvh));
        needs
    }

    fn add_storage_buffers(&mut self, count: u32) {
        let Limits {
            max_storage_buffers_per_shader_stage: buffers,
            max_buffers_and_acceleration_structures_per_shader_stage: all,
            ..
        } = &mut self.limits;
        *buffers += count;
        *all = (*all).max(*buffers + OTHER_BUFFERS);
    }

    /// The same with stochastic shadow maps (ST section 3.6).
    #[must_use]
    pub fn with_shadow_maps(mut self) -> Self {
        self.add_storage_buffers(SHADOW_MAP_BUFFERS);
        self
    }

    /// The same with rays that the device traces itself. wgpu has that marked as experimental: the device is
    /// opened with `ExperimentalFeatures::enabled()`.
    #[must_use]
    pub fn with_ray_query(mut self) -> Self {
        self.features |= Features::EXPERIMENTAL_RAY_QUERY;
        let all = self.limits.max_buffers_and_acceleration_structures_per_shader_stage;
        self.limits = self.limits.using_minimum_supported_acceleration_structure_values();
        let new = &mut self.limits.max_buffers_and_acceleration_structures_per_shader_stage;
        *new = (*new).max(all + 1);
        self
    }

    /// What both need: for a device on which methods are switched.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            features: self.features | other.features,
            useful_features: self.useful_features | other.useful_features,
            limits: self.limits.or_better_values_from(&other.limits),
            downlevel_flags: self.downlevel_flags | other.downlevel_flags,
        }
    }

    /// What is missing on a device or adapter of these features and limits, by wgpu's names; a limit with
    /// what it has to be and what it is. Empty if nothing is.
    #[must_use]
    pub fn missing(&self, features: Features, limits: &Limits) -> Vec<String> {
        let mut missing: Vec<_> =
            (self.features - features).iter_names().map(|(name, _)| name.to_owned()).collect();
        self.limits.check_limits_with_fail_fn(limits, false, |name, needed, found| {
            missing.push(format!("{name} {needed} (it has {found})"));
        });
        missing
    }

    /// [`GpuError::Lacks`] if a device has been opened with less.
    pub(crate) fn check(&self, adapter: &str, device: &wgpu::Device) -> Result<(), GpuError> {
        let missing = self.missing(device.features(), &device.limits());
        if missing.is_empty() {
            return Ok(());
        }
        Err(GpuError::Lacks { adapter: adapter.to_owned(), missing })
    }
}

#[cfg(test)]
mod tests {
    use sheer_render::method::METHODS;

    use super::*;

    fn needs(method: &str, path: GpuPath) -> Needs {
        Needs::of(&method.parse().unwrap(), path).unwrap()
    }

    #[test]
    fn what_is_missing_is_told_by_name_and_what_is_there_is_not() {
        let moments = needs("moments", GpuPath::Raster);
        let missing = moments.missing(Features::empty(), &Limits::default());
        assert!(missing.contains(&"FLOAT32_BLENDABLE".to_owned()), "{missing:?}");
        let count = moments.limits.max_storage_buffers_per_shader_stage;
        let limit = format!("max_storage_buffers_per_shader_stage {count} (it has 8)");
        assert!(missing.contains(&limit), "{missing:?}");
        assert_eq!(moments.missing(moments.features, &moments.limits), Vec::<String>::new());
    }

    #[test]
    fn two_needs_together_are_the_larger_of_each() {
        let [one, other] = ["moments", "std"].map(|method| needs(method, GpuPath::Raster));
        let both = one.clone().and(other.clone().with_shadow_maps().with_ray_query());
        for needs in [one, other.with_shadow_maps()] {
            assert_eq!(needs.missing(both.features, &both.limits), Vec::<String>::new());
        }
        assert!(both.features.contains(Features::FLOAT32_BLENDABLE | Features::EXPERIMENTAL_RAY_QUERY));
    }

    #[test]
    fn every_method_has_needs_on_the_paths_that_run_it_and_a_refusal_on_the_other() {
        for info in METHODS {
            let method: Method = info.id.parse().unwrap();
            assert!(Needs::of(&method, GpuPath::Raster).is_ok(), "{}", info.id);
            let by_rays = Needs::of(&method, GpuPath::Ray);
            assert_eq!(by_rays.is_ok(), crate::ray::Search::of(&method).is_some(), "{}", info.id);
        }
    }
}

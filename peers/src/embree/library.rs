//! The part of Embree 4's C interface that is needed (rtcore_device.h, rtcore_geometry.h, rtcore_scene.h,
//! rtcore_ray.h, rtcore_common.h), loaded at run time. Layouts are those of a library built for one level of
//! instances (`RTC_MAX_INSTANCE_LEVEL_COUNT` 1), with or without instance arrays.

use std::{
    ffi::{CStr, c_char, c_int, c_uint, c_void},
    fs,
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use libloading::{Library as Shared, Symbol};

pub(super) const INVALID: u32 = u32::MAX;
pub(super) const GEOMETRY_TYPE_TRIANGLE: c_int = 0;
pub(super) const BUFFER_TYPE_INDEX: c_int = 0;
pub(super) const BUFFER_TYPE_VERTEX: c_int = 1;
pub(super) const FORMAT_UINT3: c_int = 0x5003;
pub(super) const FORMAT_FLOAT3: c_int = 0x9003;
pub(super) const BUILD_QUALITY_MEDIUM: c_int = 1;
pub(super) const SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS: c_int = 1 << 3;
pub(super) const QUERY_FLAG_INVOKE_ARGUMENT_FILTER: c_int = 1 << 1;
pub(super) const QUERY_FLAG_COHERENT: c_int = 1 << 16;
pub(super) const FEATURE_FLAG_ALL: c_uint = u32::MAX;
pub(super) const DEVICE_PROPERTY_VERSION: c_int = 0;
pub(super) const DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED: c_int = 34;
pub(super) const DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED: c_int = 66;

/// `RTCRay`.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(super) struct Ray1 {
    pub(super) origin: [f32; 3],
    pub(super) t_near: f32,
    pub(super) direction: [f32; 3],
    pub(super) time: f32,
    pub(super) t_far: f32,
    pub(super) mask: u32,
    pub(super) id: u32,
    pub(super) flags: u32,
}

/// `RTCRayHit`; the padding that the alignment of `RTCHit` brings has room for `instPrimID`, which only
/// libraries with instance arrays write.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(super) struct RayHit1 {
    pub(super) ray: Ray1,
    pub(super) normal: [f32; 3],
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) primitive: u32,
    pub(super) geometry: u32,
    pub(super) instance: [u32; 2],
}

/// `RTCRay8` or `RTCRay16`. The former needs half the alignment and has no padding at its end, which nobody
/// looks for behind a pointer.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Rays<const N: usize> {
    pub(super) origin: [[f32; N]; 3],
    pub(super) t_near: [f32; N],
    pub(super) direction: [[f32; N]; 3],
    pub(super) time: [f32; N],
    pub(super) t_far: [f32; N],
    pub(super) mask: [u32; N],
    pub(super) id: [u32; N],
    pub(super) flags: [u32; N],
}

/// `RTCRayHit8` or `RTCRayHit16`, with room for `instPrimID`.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct RayHits<const N: usize> {
    pub(super) rays: Rays<N>,
    pub(super) normal: [[f32; N]; 3],
    pub(super) u: [f32; N],
    pub(super) v: [f32; N],
    pub(super) primitive: [u32; N],
    pub(super) geometry: [u32; N],
    pub(super) instance: [[u32; N]; 2],
}

/// Which lanes of a packet count: -1 for those.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Valid<const N: usize>(pub(super) [i32; N]);

/// `RTCRayQueryContext`, followed by what the filter is to know.
#[repr(C)]
pub(super) struct Context {
    pub(super) instance: [u32; 2],
    pub(super) filter: *mut c_void,
}

/// `RTCIntersectArguments` and `RTCOccludedArguments`, of a library without `RTC_MIN_WIDTH`; one with it
/// reads the width after them, and zero means none.
#[repr(C)]
pub(super) struct Arguments {
    pub(super) flags: c_int,
    pub(super) feature_mask: c_uint,
    pub(super) context: *mut Context,
    pub(super) filter: Option<unsafe extern "C" fn(*const FilterArguments)>,
    pub(super) user_geometry: *const c_void,
    pub(super) min_width_distance_factor: f32,
}

/// `RTCFilterFunctionNArguments`. Rays and hits have the layouts above with `count` in place of `N`.
#[repr(C)]
pub(super) struct FilterArguments {
    pub(super) valid: *mut c_int,
    pub(super) user: *mut c_void,
    pub(super) context: *mut Context,
    pub(super) ray: *const f32,
    pub(super) hit: *const f32,
    pub(super) count: c_uint,
}

// The sizes that a C compiler gives the structures of 4.4, with instance arrays.
const _: () = {
    assert!(size_of::<Ray1>() == 48 && size_of::<RayHit1>() == 96);
    assert!(size_of::<Rays<16>>() == 12 * 64 && size_of::<RayHits<16>>() == (12 + 9) * 64);
    assert!(size_of::<Rays<8>>() == 12 * 32, "the hits of eight rays follow them at once");
    assert!(size_of::<FilterArguments>() == 48);
};

/// `RTCDevice`, `RTCScene`, `RTCGeometry`.
pub(super) type Handle = *mut c_void;

/// What traces packets of a width.
#[derive(Clone, Copy)]
pub(super) struct PacketFunctions<const N: usize> {
    pub(super) intersect: unsafe extern "C" fn(*const Valid<N>, Handle, *mut RayHits<N>, *mut Arguments),
    pub(super) occluded: unsafe extern "C" fn(*const Valid<N>, Handle, *mut Rays<N>, *mut Arguments),
}

/// The functions, and the library that has to stay loaded for them.
pub(super) struct Library {
    pub(super) new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    pub(super) release_device: unsafe extern "C" fn(Handle),
    pub(super) get_device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    pub(super) get_device_error: unsafe extern "C" fn(Handle) -> c_int,
    pub(super) new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    pub(super) set_new_geometry_buffer:
        unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    pub(super) set_geometry_build_quality: unsafe extern "C" fn(Handle, c_int),
    pub(super) commit_geometry: unsafe extern "C" fn(Handle),
    pub(super) release_geometry: unsafe extern "C" fn(Handle),
    pub(super) new_scene: unsafe extern "C" fn(Handle) -> Handle,
    pub(super) release_scene: unsafe extern "C" fn(Handle),
    pub(super) attach_geometry: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    pub(super) set_scene_build_quality: unsafe extern "C" fn(Handle, c_int),
    pub(super) set_scene_flags: unsafe extern "C" fn(Handle, c_int),
    pub(super) commit_scene: unsafe extern "C" fn(Handle),
    pub(super) intersect1: unsafe extern "C" fn(Handle, *mut RayHit1, *mut Arguments),
    pub(super) occluded1: unsafe extern "C" fn(Handle, *mut Ray1, *mut Arguments),
    pub(super) packets8: PacketFunctions<8>,
    pub(super) packets16: PacketFunctions<16>,
    _shared: Shared,
}

impl Library {
    /// Loads a library file.
    pub(super) fn load(path: &Path) -> anyhow::Result<Self> {
        // SAFETY: the caller names a build of Embree, whose initialisers set up its own state alone.
        let shared =
            unsafe { Shared::new(path) }.with_context(|| format!("cannot load {}", path.display()))?;
        let missing = |name: &CStr| format!("{} has no {}", path.display(), name.to_string_lossy());
        macro_rules! function {
            ($name:literal) => {{
                // SAFETY: the signature that the field gives it is the one in Embree 4's headers.
                let symbol: Result<Symbol<'_, _>, _> = unsafe { shared.get($name.to_bytes_with_nul()) };
                *symbol.with_context(|| missing($name))?
            }};
        }
        Ok(Self {
            new_device: function!(c"rtcNewDevice"),
            release_device: function!(c"rtcReleaseDevice"),
            get_device_property: function!(c"rtcGetDeviceProperty"),
            get_device_error: function!(c"rtcGetDeviceError"),
            new_geometry: function!(c"rtcNewGeometry"),
            set_new_geometry_buffer: function!(c"rtcSetNewGeometryBuffer"),
            set_geometry_build_quality: function!(c"rtcSetGeometryBuildQuality"),
            commit_geometry: function!(c"rtcCommitGeometry"),
            release_geometry: function!(c"rtcReleaseGeometry"),
            new_scene: function!(c"rtcNewScene"),
            release_scene: function!(c"rtcReleaseScene"),
            attach_geometry: function!(c"rtcAttachGeometry"),
            set_scene_build_quality: function!(c"rtcSetSceneBuildQuality"),
            set_scene_flags: function!(c"rtcSetSceneFlags"),
            commit_scene: function!(c"rtcCommitScene"),
            intersect1: function!(c"rtcIntersect1"),
            occluded1: function!(c"rtcOccluded1"),
            packets8: PacketFunctions {
                intersect: function!(c"rtcIntersect8"),
                occluded: function!(c"rtcOccluded8"),
            },
            packets16: PacketFunctions {
                intersect: function!(c"rtcIntersect16"),
                occluded: function!(c"rtcOccluded16"),
            },
            _shared: shared,
        })
    }
}

/// A file `libembree4*.so*` in or below a folder, the first by name.
pub(super) fn find(folder: &Path) -> Option<PathBuf> {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    let is_library = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        path.is_file() && name.starts_with("libembree4") && name.contains(".so")
    };
    let here = entries.iter().find(|path| is_library(path)).cloned();
    // Links are not followed: a virtual environment links to its own folder.
    let is_folder = |path: &&PathBuf| path.is_dir() && !path.is_symlink();
    here.or_else(|| entries.iter().filter(is_folder).find_map(|path| find(path)))
}

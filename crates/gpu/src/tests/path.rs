//! Which paths run on which adapters.

use super::{harness::GPU, shaders::report};
use crate::{device::AdapterReport, path::GpuPath};

#[test]
fn what_an_adapter_lacks_takes_paths_from_it() {
    let all = report();
    assert_eq!(GpuPath::supported_by(&all), GpuPath::ALL);
    let lacking = AdapterReport { storage_in_raster: false, ..all.clone() };
    assert_eq!(GpuPath::supported_by(&lacking), [GpuPath::Ray]);
    let lacking = AdapterReport { compute: false, ..all.clone() };
    assert_eq!(GpuPath::supported_by(&lacking), []);
    // The default of WebGPU.
    let lacking = AdapterReport { max_storage_buffers: 8, ..all };
    assert_eq!(GpuPath::supported_by(&lacking), []);
}

#[test]
fn the_device_that_the_tests_run_on_has_both_paths() {
    assert_eq!(GpuPath::supported_by(GPU.report()), GpuPath::ALL);
}

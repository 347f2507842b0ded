//! Buffers of the device, and what happens when one is larger than the device allows.

use wgpu::BufferUsages;

use crate::{device::Gpu, error::GpuError};

/// The largest storage buffer that can be bound, bytes.
pub(crate) fn storage_limit(limits: &wgpu::Limits) -> u64 {
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

/// An error if `needed` is above `limit`.
///
/// # Errors
/// [`GpuError::Limit`] names `what` takes too much, and advises another scene or the CPU.
pub(crate) fn check_limit(what: &str, needed: u64, limit: u64) -> Result<(), GpuError> {
    if needed <= limit {
        return Ok(());
    }
    Err(GpuError::Limit {
        what: what.to_owned(),
        needed,
        limit,
        instead: "take a smaller scene or --backend cpu".to_owned(),
    })
}

/// A buffer of `size` bytes that starts with zeros.
pub(crate) fn buffer(device: &wgpu::Device, label: &str, size: u64, usage: BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// A storage buffer for a picture of so many columns and rows: so many bytes a pixel, and so many more.
///
/// # Errors
/// [`GpuError::Limit`] when the picture is too large for one binding, or empty; the device's own errors.
pub(crate) fn pixel_buffer(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    label: &str,
    [bytes_per_pixel, more_bytes]: [u64; 2],
    usage: BufferUsages,
) -> Result<wgpu::Buffer, GpuError> {
    let size = bytes_per_pixel * u64::from(width) * u64::from(height) + more_bytes;
    let device = gpu.device();
    let limit = storage_limit(&device.limits());
    if size > limit || size == 0 {
        return Err(GpuError::Limit {
            what: format!("{label} of a picture of {width}x{height} pixels"),
            needed: size,
            limit,
            instead: "take a size within that, and not zero".to_owned(),
        });
    }
    let buffer = buffer(&device, label, size, usage | BufferUsages::STORAGE);
    gpu.check(label)?;
    Ok(buffer)
}

/// A storage buffer of `needed` bytes, or of `wished` if that is more and the device allows it.
///
/// # Errors
/// [`GpuError::Limit`] when the device allows less than `needed`.
pub(crate) fn storage_buffer(
    device: &wgpu::Device,
    what: &str,
    needed: u64,
    wished: u64,
) -> Result<wgpu::Buffer, GpuError> {
    let limit = storage_limit(&device.limits()) / 4 * 4;
    check_limit(what, needed, limit)?;
    let size = needed.max(wished.min(limit)).next_multiple_of(4);
    Ok(buffer(device, what, size, BufferUsages::STORAGE | BufferUsages::COPY_DST))
}

/// A larger buffer if `buffer` has fewer than `needed` bytes: half again as large as before, or as needed. So
/// a scene that grows slowly seldom pays for new buffers.
///
/// # Errors
/// As [`storage_buffer`].
pub(crate) fn grown(
    device: &wgpu::Device,
    buffer: &wgpu::Buffer,
    what: &str,
    needed: u64,
) -> Result<Option<wgpu::Buffer>, GpuError> {
    let is_large_enough = needed <= buffer.size();
    (!is_large_enough).then(|| storage_buffer(device, what, needed, buffer.size() / 2 * 3)).transpose()
}

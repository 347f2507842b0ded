//! A storage buffer that holds a list whose first part never changes.

use bytemuck::Pod;

use super::buffer::{buffer, storage_limit};
use crate::error::GpuError;

/// What every list is used as.
pub(crate) const STORAGE: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_DST);

/// A list on the GPU.
#[derive(Debug)]
pub(crate) struct ListBuffer {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: wgpu::Buffer,
    /// Elements that there is room for; with room for none the buffer still has the size of one, since an
    /// empty one cannot be bound.
    capacity: usize,
}

impl ListBuffer {
    /// An empty list of `T`.
    pub(crate) fn new<T: Pod>(device: &wgpu::Device, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { label, usage, buffer: buffer(device, label, size_of::<T>() as u64, usage), capacity: 0 }
    }

    /// A list that never changes.
    pub(crate) fn filled<T: Pod>(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        label: &'static str,
        list: &[T],
    ) -> Result<Self, GpuError> {
        let mut buffer = Self::new::<T>(device, label, STORAGE);
        buffer.send(device, queue, list.len(), list)?;
        Ok(buffer)
    }

    /// Sends a list of which the first `static_count` elements are there already, unless the buffer has to
    /// grow. Returns whether it had to.
    pub(crate) fn send<T: Pod>(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        static_count: usize,
        list: &[T],
    ) -> Result<bool, GpuError> {
        let grows = list.len() > self.capacity;
        if grows {
            self.capacity = capacity::<T>(self.label, static_count, list.len(), &device.limits())?;
            let bytes = (self.capacity * size_of::<T>()) as u64;
            self.buffer = buffer(device, self.label, bytes, self.usage);
        }
        let first = if grows { 0 } else { static_count };
        let offset = (first * size_of::<T>()) as u64;
        queue.write_buffer(&self.buffer, offset, bytemuck::cast_slice(&list[first..]));
        Ok(grows)
    }

    pub(crate) fn wgpu(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        self.buffer.size()
    }
}

/// How many elements to make room for: half as many again as move, so that a scene that grows slowly is not
/// sent anew every frame.
fn capacity<T: Pod>(
    label: &str,
    static_count: usize,
    count: usize,
    limits: &wgpu::Limits,
) -> Result<usize, GpuError> {
    let limit = storage_limit(limits);
    let needed = count as u64 * size_of::<T>() as u64;
    if needed > limit {
        return Err(GpuError::Limit {
            what: format!("the list of {label}, in bytes,"),
            needed,
            limit,
            instead: "take a smaller scene or --backend cpu".to_owned(),
        });
    }
    let roomy = count + (count - static_count) / 2;
    Ok(roomy.min((limit / size_of::<T>() as u64) as usize))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(bytes: u64) -> wgpu::Limits {
        wgpu::Limits {
            max_storage_buffer_binding_size: bytes,
            max_buffer_size: 2 * bytes,
            ..wgpu::Limits::default()
        }
    }

    #[test]
    fn only_what_moves_gets_room_to_grow_and_never_beyond_the_limit() {
        let room = |still, count| capacity::<u32>("numbers", still, count, &limits(400)).unwrap();
        assert_eq!(room(60, 60), 60);
        assert_eq!(room(20, 60), 80);
        assert_eq!(room(0, 90), 100);
        assert_eq!(room(0, 0), 0);
    }

    #[test]
    fn a_list_beyond_the_limit_is_named_with_what_to_do() {
        let error = capacity::<u32>("numbers", 0, 101, &limits(400)).unwrap_err().to_string();
        assert!(error.contains("numbers") && error.contains("404") && error.contains("400"), "{error}");
        assert!(error.contains("--backend cpu"), "{error}");
    }
}

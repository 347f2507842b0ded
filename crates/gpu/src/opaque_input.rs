//! What the caller has drawn, as what lies behind the scene.
//!
//! Camera rays end at the caller's depth and see the caller's colour there; nothing else knows of it, so that
//! every method on every path takes it for the background.

use glam::Vec2;
use wgpu::{
    BindGroupEntry, BindGroupLayoutEntry, BufferBindingType, BufferUsages, ShaderStages, TextureFormat,
    TextureSampleType, TextureView,
};

use crate::{
    error::GpuError,
    resource::{
        bind_group::{buffer_entry, texture_entry, texture_in, whole},
        buffer::buffer,
    },
    shader::{
        binding::{BIND_INPUT, BIND_INPUT_COLOUR, BIND_INPUT_DEPTH, BIND_INPUT_MOTION},
        record::opaque::OpaqueUniform,
    },
    view::DepthRow,
};

/// What the caller has drawn of a frame: views of textures with one sample a pixel and the picture's size,
/// that can be bound (`TEXTURE_BINDING`).
#[derive(Clone, Copy, Debug)]
pub struct Opaque<'a> {
    colour: &'a TextureView,
    depth: &'a TextureView,
    depth_row: DepthRow,
    motion: Option<(&'a TextureView, [f32; 2])>,
    is_still: bool,
}

impl<'a> Opaque<'a> {
    /// * `colour`: linear, premultiplied values of a picture, in any format that shaders read as floats.
    /// * `depth`: of the projection `clip_from_view`, columns first: reversed or not, its far plane finite or
    ///   not. A format of depth (the view shows that aspect alone) or one of floats, whose red channel is it.
    ///   Where nothing was drawn it is the depth of the far plane.
    ///
    /// Both are of the view that the scene is seen through; jittered alike
    /// ([`GpuPipeline::jitter`](crate::GpuPipeline::jitter)) edges between the two are smoothed as well.
    /// Where no motion is told, all of it stands still in the world.
    #[must_use]
    pub fn new(colour: &'a TextureView, depth: &'a TextureView, clip_from_view: [[f32; 4]; 4]) -> Self {
        Self { colour, depth, depth_row: DepthRow::of(&clip_from_view), motion: None, is_still: false }
    }

    /// With its motion: red times `scale[0]` and green times `scale[1]` are columns and rows of pixels from
    /// this frame to the last, where a surface was minus where it is, rows counted downwards; without jitter.
    #[must_use]
    pub fn with_motion(self, motion: &'a TextureView, scale: [f32; 2]) -> Self {
        Self { motion: Some((motion, scale)), ..self }
    }

    /// It shows what it showed in the frame before, but for the jitter: where the scene stands still as well,
    /// layered accumulation takes the plain mean.
    #[must_use]
    pub fn still(self) -> Self {
        Self { is_still: true, ..self }
    }

    pub(crate) fn is_still(&self) -> bool {
        self.is_still
    }

    /// Whether all of it lies behind a picture of a size.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] names the texture that does not.
    pub(crate) fn check(&self, [width, height]: [u32; 2]) -> Result<(), GpuError> {
        let motion = self.motion.map(|(view, _)| ("motion", view));
        for (name, view) in [("colour", self.colour), ("depth", self.depth)].into_iter().chain(motion) {
            let texture = view.texture();
            let refused = |what: String, instead: &str| {
                Err(GpuError::Unsupported { what, instead: instead.to_owned() })
            };
            if texture.width() < width || texture.height() < height {
                let size = format!("{}x{}", texture.width(), texture.height());
                return refused(
                    format!("{name} of {size} pixels is smaller than the picture of {width}x{height}"),
                    "draw it in the size of the picture",
                );
            }
            if texture.sample_count() > 1 {
                let what = format!("{name} has {} samples a pixel", texture.sample_count());
                return refused(what, "resolve it to one");
            }
        }
        Ok(())
    }

    pub(crate) fn depth_kind(&self) -> DepthKind {
        DepthKind::of(self.depth.texture().format())
    }
}

/// In which kind of texture depths are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DepthKind {
    /// A format of depth.
    Depth,
    /// The first channel of floats.
    Float,
}

impl DepthKind {
    pub(crate) fn of(format: TextureFormat) -> Self {
        if format.has_depth_aspect() { Self::Depth } else { Self::Float }
    }
}

/// The part of group 1 that [`Opaque`] is bound in.
#[derive(Debug)]
pub(crate) struct OpaqueInput {
    uniform: wgpu::Buffer,
    /// Colour, depth and motion of the last frame.
    views: Option<[TextureView; 3]>,
}

impl OpaqueInput {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let bytes = size_of::<OpaqueUniform>() as u64;
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        Self { uniform: buffer(device, "opaque input", bytes, usage), views: None }
    }

    pub(crate) fn layout_entries(kind: DepthKind) -> [BindGroupLayoutEntry; 4] {
        let stages = ShaderStages::FRAGMENT | ShaderStages::COMPUTE;
        let floats = TextureSampleType::Float { filterable: false };
        let depth = match kind {
            DepthKind::Depth => TextureSampleType::Depth,
            DepthKind::Float => floats,
        };
        [
            buffer_entry(BIND_INPUT, stages, BufferBindingType::Uniform),
            texture_entry(BIND_INPUT_COLOUR, stages, floats, false),
            texture_entry(BIND_INPUT_DEPTH, stages, depth, false),
            texture_entry(BIND_INPUT_MOTION, stages, floats, false),
        ]
    }

    /// Takes what was drawn of a frame; whether it is in other textures than that of the frame before.
    pub(crate) fn prepare(&mut self, queue: &wgpu::Queue, opaque: &Opaque<'_>) -> bool {
        let (row, motion) = (opaque.depth_row, opaque.motion);
        let is_reversed = row.distance(0.0) > row.distance(1.0);
        let uniform = OpaqueUniform {
            depth_row: row.0,
            motion_scale: motion.map_or(Vec2::ZERO, |(_, scale)| scale.into()),
            has_motion: u32::from(motion.is_some()),
            nothing: if is_reversed { 0.0 } else { 1.0 },
        };
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        // Something has to be bound where no motion is told.
        let motion = motion.map_or(opaque.colour, |(view, _)| view);
        let views = [opaque.colour, opaque.depth, motion].map(TextureView::clone);
        let is_other = self.views.as_ref() != Some(&views);
        self.views = Some(views);
        is_other
    }

    pub(crate) fn entries(&self) -> impl Iterator<Item = BindGroupEntry<'_>> {
        let bindings = [BIND_INPUT_COLOUR, BIND_INPUT_DEPTH, BIND_INPUT_MOTION];
        let textures = self.views.iter().flat_map(move |views| bindings.into_iter().zip(views));
        let uniform = [whole(BIND_INPUT, &self.uniform)].into_iter();
        uniform.chain(textures.map(|(binding, view)| texture_in(binding, view)))
    }
}

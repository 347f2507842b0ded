//! The picture so far as a texture of the caller's.

use wgpu::{BlendState, BufferBindingType, ShaderStages, TextureFormat, TextureView};

use crate::{
    compile::{layout, render_pipeline},
    compiled::RenderKey,
    device::Gpu,
    error::GpuError,
    resource::bind_group::{buffer_entry, group_of, read_only_entry, whole},
    shader::{
        Linker,
        binding::{BIND_HISTORY, BIND_TEMPORAL},
    },
    temporal::History,
};

const PIECE: &str = "pass/picture";
const STEP: &str = "picture";

/// Where a picture goes: a view of a texture of the caller's that can be drawn to.
///
/// Colours are linear and premultiplied, without a tone curve; formats that end in `Srgb` encode them, those
/// of whole numbers cut them off at 1. The picture lies in the upper left corner; what the texture has beyond
/// it stays.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    view: &'a TextureView,
    format: TextureFormat,
    blend: Option<BlendState>,
}

impl<'a> Picture<'a> {
    /// Replaces what the view shows; it has the format of its texture.
    #[must_use]
    pub fn new(view: &'a TextureView) -> Self {
        Self { view, format: view.texture().format(), blend: None }
    }

    /// A view that shows its texture in another format.
    #[must_use]
    pub fn with_format(self, format: TextureFormat) -> Self {
        Self { format, ..self }
    }

    /// Blends it with what the view shows: `BlendState::PREMULTIPLIED_ALPHA_BLENDING` puts a picture without
    /// a background over it.
    #[must_use]
    pub fn with_blend(self, blend: BlendState) -> Self {
        Self { blend: Some(blend), ..self }
    }
}

/// The pass that draws a history into a texture.
#[derive(Debug)]
pub(crate) struct PicturePass {
    module: wgpu::ShaderModule,
    layout: wgpu::BindGroupLayout,
    /// One for each of the two pictures that take turns.
    groups: [wgpu::BindGroup; 2],
}

impl PicturePass {
    /// # Errors
    /// The shader does not compile.
    pub(crate) fn new(gpu: &Gpu, history: &History) -> Result<Self, GpuError> {
        let module = gpu.shader(&Linker::new().link(PIECE)?)?;
        let entries = [
            buffer_entry(BIND_TEMPORAL, ShaderStages::FRAGMENT, BufferBindingType::Uniform),
            read_only_entry(BIND_HISTORY, ShaderStages::FRAGMENT),
        ];
        let layout = layout(gpu, STEP, &entries);
        let group = |colour| {
            let entries = [whole(BIND_TEMPORAL, history.uniform()), whole(BIND_HISTORY, colour)];
            group_of(&gpu.device(), STEP, &layout, &entries)
        };
        let [first, second] = history.colours();
        let groups = [group(first), group(second)];
        Ok(Self { module, layout, groups })
    }

    /// Records that the picture so far is drawn.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Picture<'_>,
        history: &History,
    ) {
        let Picture { view, format, blend } = *picture;
        let key = RenderKey {
            module: self.module.clone(),
            vertex: "vs_picture",
            fragment: "fs_picture".to_owned(),
            groups: vec![self.layout.clone()],
            targets: vec![(format, blend)],
            depth: None,
            samples: 1,
        };
        let pipeline = render_pipeline(gpu, STEP, &key);
        let ops = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
        let attachment =
            wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(STEP),
            color_attachments: &[Some(attachment)],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &self.groups[history.latest()], &[]);
        pass.draw(0..3, 0..1);
    }
}

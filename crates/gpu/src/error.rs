//! What can go wrong on a GPU, each with what to do about it.

use sheer_image::ImageError;
use sheer_render::RenderError;
use sheer_scene::SceneError;

/// Why the GPU makes no picture.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No driver offers an adapter, or none that was asked for.
    #[error(
        "{problem}; install a Vulkan driver (Debian and Ubuntu: mesa-vulkan-drivers) or take --backend cpu"
    )]
    NoAdapter {
        /// What was looked for.
        problem: String,
    },
    /// The adapter is there but opens no device.
    #[error("{adapter} opens no device: {problem}; try another one of `sheer devices`")]
    NoDevice {
        /// The adapter's name, as the driver gives it.
        adapter: String,
        /// What the driver says.
        problem: String,
    },
    /// The adapter cannot do what was asked for.
    #[error("{what}: {instead}")]
    Unsupported {
        /// What cannot be done.
        what: String,
        /// What to do instead.
        instead: String,
    },
    /// A device of the caller's was opened without what is needed.
    #[error(
        "the device of {adapter} was opened without {}; ask for what `Needs` says, where the adapter has it",
        .missing.join(", ")
    )]
    Lacks {
        /// The adapter's name, as the driver gives it.
        adapter: String,
        /// Features and limits by wgpu's names; a limit with what it has to be and what it is.
        missing: Vec<String>,
    },
    /// A shader does not link or compile.
    #[error("shader {piece}: {problem}")]
    Shader {
        /// The piece that was asked for.
        piece: String,
        /// What is wrong and where.
        problem: String,
    },
    /// The scene needs more than the adapter allows.
    #[error("{what} takes {needed}, the adapter allows {limit}; {instead}")]
    Limit {
        /// What is too large.
        what: String,
        /// How much it takes.
        needed: u64,
        /// How much there may be.
        limit: u64,
        /// What to do about it.
        instead: String,
    },
    /// The device's memory is full.
    #[error("the device has no memory left for {what}; try a smaller --size or scene")]
    OutOfMemory {
        /// What was to be made.
        what: String,
    },
    /// The device is gone, and a new one failed as well or is up to the caller, whose device it was.
    #[error("the device was lost: {reason}")]
    DeviceLost {
        /// What the driver says.
        reason: String,
    },
    /// The driver or wgpu refuses what was recorded: a slip of ours.
    #[error("{what} was refused: {problem}")]
    Refused {
        /// What was being made or recorded.
        what: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The scene cannot be seen as asked.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The picture cannot be made.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// What the CPU prepares fails.
    #[error(transparent)]
    Render(#[from] RenderError),
}

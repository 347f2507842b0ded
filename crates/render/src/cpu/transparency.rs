//! What a frame is rendered with: a method of the table, or one of the caller's own under any of the
//! contracts.

use sheer_core::coverage::Correction;

use super::draw::{Draw, Rendered};
use crate::{
    contract::{
        Alignment, Hybrid, OrderedCompositing, Selection, Threshold, UnorderedCompositing, Visitor as _,
    },
    error::RenderError,
    method::Method,
    settings::FrameSettings,
    stage::Stage,
};

/// How transparency is resolved: by a [`Method`], or by a contract of the caller's own in one of the wrappers
/// [`OwnThreshold`], [`OwnSelection`], [`OwnOrdered`] and [`OwnUnordered`].
///
/// ```
/// use sheer_render::{
///     Antialiasing, Pipeline, Settings, Stage,
///     contract::{Alignment, Site, Tables, Threshold},
///     cpu::OwnThreshold,
/// };
///
/// /// Screen-door transparency: the four thresholds of a 2×2 ordered dither.
/// struct ScreenDoor;
///
/// impl Threshold for ScreenDoor {
///     fn threshold(&self, site: &Site, _: &Tables) -> f32 {
///         let [column, row] = site.pixel.map(|coordinate| coordinate as usize % 2);
///         [[0.125, 0.625], [0.875, 0.375]][row][column]
///     }
/// }
///
/// // A white layer of alpha 0.5 over black: it is kept in two pixels of four.
/// let scene = sheer_gallery::open("layers:count=1,alpha=0.5,colours=white,background=0")?.scene;
/// let stage = Stage::new(scene, &Default::default(), None)?;
/// let settings = Settings { size: [4, 2], ..Default::default() };
/// let mut pipeline = Pipeline::with_own(OwnThreshold(ScreenDoor), Antialiasing::NONE, settings)?;
/// pipeline.render(&stage, 0)?;
/// let white = |x, y| pipeline.planes().colour[(x, y)][0] > 0.5;
/// assert_eq!([white(0, 0), white(1, 0), white(0, 1), white(1, 1)], [true, false, false, true]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Transparency {
    /// Renders one frame of a stage.
    ///
    /// # Errors
    /// [`RenderError::Image`] if the size is zero or too much for the memory, [`RenderError::ShadowMaps`] if
    /// shadows are.
    fn render(&self, stage: &Stage, settings: &FrameSettings) -> Result<Rendered, RenderError>;

    /// How motion vectors are to be aligned under TAA (STD section 3.3.1).
    fn alignment(&self) -> Alignment {
        Alignment::NONE
    }
}

impl Transparency for Method {
    fn render(&self, stage: &Stage, settings: &FrameSettings) -> Result<Rendered, RenderError> {
        self.visit(Draw { stage, settings, hybrid: self.hybrid(), correction: self.correction() })
    }

    fn alignment(&self) -> Alignment {
        Self::alignment(self)
    }
}

/// Renders one frame of a stage.
///
/// # Errors
/// As [`Transparency::render`].
pub fn render(
    stage: &Stage,
    method: &impl Transparency,
    settings: &FrameSettings,
) -> Result<Rendered, RenderError> {
    method.render(stage, settings)
}

/// Rows `Wrapper: Contract, function of the visitor`: a wrapper for each contract, since a type may fulfil
/// several.
macro_rules! own {
    ($($(#[$about:meta])* $wrapper:ident : $contract:ident, $visit:ident;)+) => {
        $(
            $(#[$about])*
            #[derive(Clone, Copy, Debug)]
            pub struct $wrapper<M>(pub M);

            impl<M: $contract> Transparency for $wrapper<M> {
                fn render(&self, stage: &Stage, settings: &FrameSettings) -> Result<Rendered, RenderError> {
                    let draw =
                        Draw { stage, settings, hybrid: Hybrid::NONE, correction: Correction::NONE };
                    draw.$visit(&self.0)
                }
            }
        )+
    };
}

own! {
    /// A threshold method of the caller's own.
    OwnThreshold: Threshold, threshold;
    /// A selection method of the caller's own.
    OwnSelection: Selection, selection;
    /// A compositing method of the caller's own that wants its fragments front to back.
    OwnOrdered: OrderedCompositing, ordered;
    /// A compositing method of the caller's own that takes its fragments in any order.
    OwnUnordered: UnorderedCompositing, unordered;
}

//! A frame of a method: its pixels in parallel bands, traced as its family wants.

use std::{iter, time::Instant};

use rayon::prelude::*;
use sheer_core::{colour::Premul, coverage::Correction};
use sheer_image::{Image, Pixel, Planes, Region};

use super::{
    layer_filter, layered, samples,
    tile::{PixelRay, TILE_SIDE, pixels_of_tile},
    tracer::Tracer,
    workspace::{Byproducts, Nanoseconds},
};
use crate::{
    contract::{
        Hybrid, LayerFilter, OrderedCompositing, Selection, Tables, Threshold, UnorderedCompositing, Visitor,
    },
    cost::{Counters, StepTime},
    error::RenderError,
    settings::{FrameSettings, LayerSplit, Settings},
    shadow::Shadows,
    stage::Stage,
};

/// A frame and its cost.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture, one jittered sample a pixel.
    pub planes: Planes,
    /// What was traced and shaded.
    pub counters: Counters,
    /// Milliseconds from the first ray to the last pixel; building the acceleration structure comes on top.
    pub trace_ms: f64,
    /// Milliseconds of these that went into shadow maps.
    pub shadow_ms: f64,
    /// The steps of methods with an unordered gathering; empty for all others.
    pub steps: Vec<StepTime>,
}

/// Traces the pixels of a tile, given by column and row, and hands them out in the same order. Called once a
/// tile, so that the loop over tiles and threads need not be compiled for each method.
type TraceTile<'a> = dyn Fn(&mut Tracer<'_>, &[[u32; 2]], &mut Counters, &mut Vec<Pixel>) + Sync + 'a;

/// Renders a frame with a method of any family.
pub(super) struct Draw<'a> {
    pub(super) stage: &'a Stage,
    pub(super) settings: &'a FrameSettings,
    pub(super) hybrid: Hybrid,
    pub(super) correction: Correction,
}

impl Visitor for Draw<'_> {
    type Output = Result<Rendered, RenderError>;

    fn threshold(self, method: &impl Threshold) -> Self::Output {
        let (tables, hybrid) = (Tables::get(), self.hybrid);
        let find = |tracer: &mut Tracer<'_>, rays: &[PixelRay], counters: &mut Counters| {
            tracer.first_kept(method, &tables, rays, counters)
        };
        if self.splits_layers().is_some() {
            let choose = layered::by_threshold(method, &tables);
            return self.tiles(&|tracer, tile, counters, pixels| {
                tracer.layered(tile, counters, pixels, &choose, find);
            });
        }
        self.tiles(&|tracer, tile, counters, pixels| {
            tracer.stochastic(hybrid, tile, counters, pixels, find);
        })
    }

    fn selection(self, method: &impl Selection) -> Self::Output {
        let (tables, hybrid) = (Tables::get(), self.hybrid);
        let FrameSettings { run: Settings { seed, .. }, frame, .. } = *self.settings;
        let threshold = |at: [u32; 2]| method.threshold(at, frame, seed, &tables);
        let find = |tracer: &mut Tracer<'_>, rays: &[PixelRay], counters: &mut Counters| {
            tracer.first_exceeding(threshold, rays, counters)
        };
        if let Some(LayerSplit { least_share }) = self.splits_layers() {
            let choose = layered::by_selection(threshold, least_share);
            return self.tiles(&|tracer, tile, counters, pixels| {
                tracer.layered(tile, counters, pixels, &choose, find);
            });
        }
        self.tiles(&|tracer, tile, counters, pixels| {
            tracer.stochastic(hybrid, tile, counters, pixels, find);
        })
    }

    fn ordered(self, method: &impl OrderedCompositing) -> Self::Output {
        self.tiles(&|tracer, tile, counters, pixels| {
            tracer.composite_in_order(method, tile, counters, pixels);
        })
    }

    fn unordered(self, method: &impl UnorderedCompositing) -> Self::Output {
        let Some(filter) = method.layer_filter() else { return self.composited(method, None) };
        // A filter looks at the pixels around.
        let run = self.settings.run;
        let crop = run.crop.map(|crop| crop.grown(filter.radius_px, run.size));
        let settings = FrameSettings { run: Settings { crop, ..run }, ..*self.settings };
        let mut rendered = Draw { settings: &settings, ..self }.composited(method, Some(filter))?;
        if let (Some(crop), Some(grown)) = (run.crop, crop) {
            rendered.planes = rendered.planes.cut(crop.seen_from(&grown))?;
        }
        Ok(rendered)
    }
}

impl Draw<'_> {
    /// A frame of a method that is fed in no order, its transparent light filtered.
    fn composited(
        self,
        method: &impl UnorderedCompositing,
        filter: Option<LayerFilter>,
    ) -> Result<Rendered, RenderError> {
        let offsets = samples::offsets(method.samples(), self.settings.jitter);
        let pass_names = (0..method.pass_count()).map(|pass| method.pass_name(pass));
        let (stage, region) = (self.stage, self.settings.run.region());
        let (mut rendered, byproducts) = self.timed_tiles(&|tracer, tile, counters, pixels| {
            tracer.composite_unordered(method, &offsets, filter.is_some(), tile, counters, pixels);
        })?;
        let names = iter::once("gather").chain(pass_names).chain(["composite"]);
        let Nanoseconds { gather, passes, composite } = byproducts.nanoseconds;
        let times = iter::once(gather).chain(passes).chain([composite]);
        rendered.steps = names.zip(times).map(|(name, ns)| StepTime { name, ms: ns as f64 * 1e-6 }).collect();
        if let Some(filter) = filter {
            let start = Instant::now();
            let mut layer = Image::filled(region.width, region.height, Premul::CLEAR)?;
            for ([x, y], light) in byproducts.layer {
                layer[(x - region.left, y - region.top)] = light;
            }
            stage.pool().install(|| layer_filter::apply(&filter, &layer, &mut rendered.planes.colour));
            let ms = start.elapsed().as_secs_f64() * 1e3;
            rendered.trace_ms += ms;
            rendered.steps.push(StepTime { name: "filter", ms });
        }
        Ok(rendered)
    }

    /// How pixels are to be split into layers, if they are: the exact fragments of a hybrid and the
    /// stochastic one behind them are a single layer, as is what other methods composite.
    fn splits_layers(&self) -> Option<LayerSplit> {
        self.settings.layers.filter(|_| self.hybrid == Hybrid::NONE)
    }

    /// Calls `trace` for every tile, in parallel.
    fn tiles(self, trace: &TraceTile<'_>) -> Result<Rendered, RenderError> {
        Ok(self.timed_tiles(trace)?.0)
    }

    /// Calls `trace` for every tile, in parallel, and adds up what the pixels leave behind beside themselves.
    fn timed_tiles(self, trace: &TraceTile<'_>) -> Result<(Rendered, Byproducts), RenderError> {
        let Region { left, top, width, height } = self.settings.run.region();
        let planes = if self.settings.layers.is_some() { Planes::with_layers } else { Planes::new };
        let mut planes = planes(width, height)?;
        let start = Instant::now();
        let FrameSettings { run: Settings { seed, shadow, .. }, frame, .. } = self.settings;
        let pixels = width as usize * height as usize;
        let shadows = Shadows::for_pixels(self.stage, shadow, *frame, *seed, pixels)?;
        let (counters, byproducts) = self.stage.pool().install(|| {
            // A row of tiles a task: few enough that 2 to 64 threads share a frame evenly.
            let bands = planes.par_bands_mut(TILE_SIDE);
            let costs = bands.map(|mut band| {
                let mut tracer = Tracer::new(self.stage, self.settings, &shadows, self.correction);
                let mut counters = Counters::default();
                let (mut tile, mut pixels) = (Vec::new(), Vec::new());
                for column in (0..width).step_by(TILE_SIDE as usize) {
                    let of_tile = pixels_of_tile([column, band.y], [width, height]);
                    tile.clear();
                    tile.extend(of_tile.map(|[x, y]| [left + x, top + y]));
                    pixels.clear();
                    trace(&mut tracer, &tile, &mut counters, &mut pixels);
                    for (&[x, y], &pixel) in tile.iter().zip(&pixels) {
                        band.set(x - left, y - top - band.y, pixel);
                    }
                }
                (counters, tracer.byproducts)
            });
            costs.reduce(Default::default, |(counters, costs), (more, further)| {
                (counters + more, costs.plus(further))
            })
        });
        let counters = counters + Counters { shadow_rays: shadows.rays(), ..Counters::default() };
        let trace_ms = start.elapsed().as_secs_f64() * 1e3;
        let rendered =
            Rendered { planes, counters, trace_ms, shadow_ms: shadows.build_ms(), steps: Vec::new() };
        Ok((rendered, byproducts))
    }
}

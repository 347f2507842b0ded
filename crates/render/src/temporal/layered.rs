//! Layered accumulation: temporal anti-aliasing that keeps a history of what is transparent, the front, and
//! one of what lies behind it, the back, each reprojected by its own motion, and composites them by the exact
//! coverage. One shaded fragment a pixel feeds the one or the other (docs/layered.md).
//!
//! Histories are not clipped to the colours of their neighbourhood as tightly as plain temporal anti-aliasing
//! does, which cannot tell noise from detail: the new samples are held against the history pixel by pixel,
//! and only the mean of these residuals, as far as it is more than chance, moves the history.

use glam::{UVec2, Vec2, Vec3, Vec4};
use sheer_core::colour::mean_channel;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};
use sheer_image::{Image, ImageError, PixelLayers, Planes, Region};

use super::{
    align::Reprojection,
    jitter::long_jitter,
    layer_history::{FARTHEST, Kept, LayerHistory, Mean, Side},
    resample::{Around, Place, rgba_from_ycocga, ycocga_from_rgba},
    technique::{AntialiasingInfo, Past, Technique},
};
use crate::{
    contract::{ShaderConstant, ShaderValue},
    settings::LayerSplit,
};

/// The row of the technique in lists and help, and what a GPU needs of it.
pub(super) const INFO: AntialiasingInfo = AntialiasingInfo {
    id: "layered",
    title: "what is transparent and what lies behind it averaged each by itself, composited by the exact coverage",
    paper: "own; alpha correction after Enderton, Sintorn, Shirley, Luebke (ST), section 3.3; smoothing after Lee 1980",
    works: &[&bibliography::ST, &bibliography::LEE_1980],
    stores: "the average colour of both layers with the number and weight of their samples, coverage, depth",
    time_stands_still: false,
    warm_up_frames: 72,
    parameters: &[
        ParameterInfo {
            key: "weight",
            default: "0.1",
            range: ParameterRange::Real(0.001, 1.0),
            what: "of a new sample, once a layer holds as many as that takes, while anything moves",
        },
        ParameterInfo {
            key: "radius",
            default: "2",
            range: ParameterRange::Count(1, 8),
            what: "of the neighbourhood in which new samples are held against the history, pixels",
        },
        ParameterInfo {
            key: "sigma",
            default: "1.5",
            range: ParameterRange::Real(0.0, 100.0),
            what: "standard errors by which the mean of the new samples may differ from the front's history; the back's may by twice as many",
        },
        ParameterInfo {
            key: "smooth",
            default: "0.5",
            range: ParameterRange::Real(0.0, 100.0),
            what: "how much of the noise that is left in the front is taken for noise when it is shown; 0 shows the history as it is",
        },
        ParameterInfo {
            key: "share",
            default: "0.25",
            range: ParameterRange::Real(0.0, 0.5),
            what: "least share of either layer in the shaded samples, for methods that let it be chosen (joint)",
        },
    ],
    constants: &[
        ShaderConstant::real("BACK_SIGMAS", BACK_SIGMAS),
        ShaderConstant::real("CLIP_SIGMAS", CLIP_SIGMAS),
        ShaderConstant::real("LEAST_CLIPPING", LEAST_CLIPPING),
        ShaderConstant::real("LEAST_SAMPLES", LEAST_SAMPLES),
        ShaderConstant::real("DOUBT_STARTS", DOUBT[0]),
        ShaderConstant::real("DOUBT_ENDS", DOUBT[1]),
        ShaderConstant::real("MOST_FORGOTTEN", MOST_FORGOTTEN),
        ShaderConstant::real("BORROWED_COUNT", BORROWED_COUNT),
        ShaderConstant::real("DEPTH_TOLERANCE", DEPTH_TOLERANCE),
        ShaderConstant::real("LEAST_FITTING", LEAST_FITTING),
        ShaderConstant::real("LEAST_ERROR", LEAST_ERROR),
        ShaderConstant::real("STILL_GAIN", STILL_GAIN),
        ShaderConstant { name: "SMOOTHING_RADIUS", value: ShaderValue::I32(SMOOTHING_RADIUS as i32) },
    ],
};

/// Standard errors of the back over those of the front: its samples are fewer where the front is dense, and
/// what differs there from pixel to pixel is detail more than noise.
const BACK_SIGMAS: f32 = 2.0;
/// Standard deviations of the back's samples that its history may lie from their mean: three take nearly all
/// of what is wrong at edges, and hardly any of the detail.
const CLIP_SIGMAS: f32 = 3.0;
/// Fewer samples have no deviation to speak of.
const LEAST_CLIPPING: f32 = 3.0;
/// A mean of fewer samples, weighed, says nothing of its error.
const LEAST_SAMPLES: f32 = 2.0;
/// Standard errors from which on, and up to which, a history is doubted.
const DOUBT: [f32; 2] = [2.0, 6.0];
/// Share of its samples that a history loses in full doubt.
const MOST_FORGOTTEN: f32 = 0.75;
/// Samples that a colour counts as which is borrowed from the neighbours: the first own one replaces most of
/// it.
const BORROWED_COUNT: f32 = 0.25;
/// A history belongs to a surface whose depth lies between the least and the greatest around, or beyond by
/// this share of them.
const DEPTH_TOLERANCE: f32 = 0.3;
/// Least share of the pixels around a place, weighed bilinearly, that must belong to it.
const LEAST_FITTING: f32 = 0.05;
/// Errors below count as this one: a divisor.
const LEAST_ERROR: f32 = 1e-6;
/// Radius of the neighbourhood that the front is smoothed in, pixels: 5×5.
const SMOOTHING_RADIUS: i64 = 2;

/// Where nothing moves the nth sample weighs this over n: what motion left behind fades with the square of
/// the number while the mean converges.
const STILL_GAIN: f32 = 2.0;

/// Layered accumulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layered {
    /// Weight of a new sample.
    weight: f32,
    /// Radius of the neighbourhood of new samples, pixels.
    radius: u32,
    /// Standard errors by which the new samples may differ.
    sigmas: f32,
    /// Share of the remaining noise that is smoothed away.
    smooth: f32,
    /// Least share of either layer in the samples.
    least_share: f32,
}

/// How much of a layer there is in a pixel, over the probability of choosing it: with these weights, means of
/// samples through a whole pixel are those of what each layer adds to the picture.
fn weight(layers: &PixelLayers, side: Side) -> f32 {
    let PixelLayers { coverage, share, .. } = *layers;
    let (part, probability) = match side {
        Side::Front => (coverage, share),
        Side::Back => (1.0 - coverage, 1.0 - share),
    };
    if probability > 0.0 { part / probability } else { 1.0 }
}

/// A sample of one of the layers, and what it says of the history.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// YCoCg and alpha, premultiplied.
    colour: Vec4,
    /// What it differs from the history by; none without a history.
    residual: Option<Vec4>,
    /// See [`weight`].
    weight: f32,
    side: Side,
}

impl Sample {
    fn new(colour: [f32; 4], layers: &PixelLayers, moved: &Kept) -> Self {
        let side = if layers.is_front { Side::Front } else { Side::Back };
        let colour = ycocga_from_rgba(colour);
        let history = moved.mean(side);
        let residual = (history.count > 0.0).then(|| colour - history.colour);
        Self { colour, residual, weight: weight(layers, side), side }
    }
}

/// Sums over the samples of a layer in a neighbourhood.
#[derive(Clone, Copy, Debug)]
struct Sums {
    /// Weights of all samples, and their colours.
    all_weights: f32,
    colours: Vec4,
    /// Weights of those whose pixel has a history, and their squares.
    weights: f32,
    squared_weights: f32,
    /// What these differ from the history by, and its squares.
    residuals: Vec4,
    squared_residuals: Vec4,
}

impl Sums {
    const NONE: Self = Self {
        all_weights: 0.0,
        colours: Vec4::ZERO,
        weights: 0.0,
        squared_weights: 0.0,
        residuals: Vec4::ZERO,
        squared_residuals: Vec4::ZERO,
    };

    /// Adds a sample that counts by a share.
    fn add(&mut self, sample: &Sample, share: f32) {
        let Sample { colour, residual, .. } = *sample;
        let weight = sample.weight * share;
        self.all_weights += weight;
        self.colours += colour * weight;
        if let Some(residual) = residual {
            self.weights += weight;
            self.squared_weights += weight * weight;
            self.residuals += residual * weight;
            self.squared_residuals += residual * residual * weight;
        }
    }

    /// Of the front and of the back around a pixel, under a tent. Its spectrum is positive everywhere, so
    /// that a shift by the mean residual lessens every wave in a history; a box, which has the sign of some
    /// waves wrong, would make them grow from noise.
    fn around(samples: &Image<Sample>, [x, y]: [u32; 2], radius: u32) -> [Self; 2] {
        let (width, height) = samples.size();
        let tent = |a: u32, b: u32| 1.0 - a.abs_diff(b) as f32 / (radius + 1) as f32;
        let mut sums = [Self::NONE; 2];
        let (first, end) = (x.saturating_sub(radius), (x + radius + 1).min(width));
        for row in y.saturating_sub(radius)..=(y + radius).min(height - 1) {
            let start = row as usize * width as usize;
            let samples = &samples.as_slice()[start + first as usize..start + end as usize];
            for (column, sample) in (first..).zip(samples) {
                sums[sample.side as usize].add(sample, tent(row, y) * tent(column, x));
            }
        }
        sums
    }
}

impl Technique for Layered {
    fn jitter(&self, frame: u32) -> Vec2 {
        long_jitter(frame)
    }

    fn layers(&self) -> Option<LayerSplit> {
        Some(LayerSplit { least_share: self.least_share })
    }

    /// In every frame that is rectified, a history hears of those of the pixels in the neighbourhood. The
    /// picture is smoothed in the end.
    fn margin_px(&self) -> u32 {
        let rectified = (STILL_GAIN / self.weight).floor() as u32 + 1;
        self.radius.saturating_mul(rectified).saturating_add(SMOOTHING_RADIUS as u32)
    }

    fn resolve(
        &self,
        past: &Past,
        current: &mut Planes,
        Reprojection { region, .. }: Reprojection,
    ) -> Result<Option<LayerHistory>, ImageError> {
        let (width, height) = current.colour.size();
        let one_layer;
        let layers = match &current.layers {
            Some(layers) => layers,
            // Of whoever does not know of layers, all is one.
            None => {
                one_layer = Image::par_from_fn(width, height, |x, y| PixelLayers {
                    back_motion: current.motion[(x, y)],
                    back_depth: current.depth[(x, y)],
                    ..PixelLayers::EMPTY
                })?;
                &one_layer
            }
        };
        let kept = match (&past.layers, self.still_samples(past.still_count)) {
            (Some(LayerHistory(history)), Some(most)) => Image::par_from_fn(width, height, |x, y| {
                averaged(&history[(x, y)], current.colour[(x, y)], &layers[(x, y)], most)
            })?,
            (history, _) => self.rectified_history(history.as_ref(), &current.colour, layers, region)?,
        };
        // The picture.
        current.colour = Image::par_from_fn(width, height, |x, y| self.shown(&kept, [x, y]))?;
        Ok(Some(LayerHistory(kept)))
    }

    fn values(&self) -> Vec<String> {
        vec![
            self.weight.to_string(),
            self.radius.to_string(),
            self.sigmas.to_string(),
            self.smooth.to_string(),
            self.least_share.to_string(),
        ]
    }
}

impl Layered {
    /// The outcome of the study in docs/layered.md.
    pub(super) const DEFAULT: Self =
        Self { weight: 0.1, radius: 2, sigmas: 1.5, smooth: 0.5, least_share: 0.25 };

    pub(super) fn new(values: &Values) -> Self {
        Self {
            weight: values.real("weight"),
            radius: values.count("radius"),
            sigmas: values.real("sigma"),
            smooth: values.real("smooth"),
            least_share: values.real("share"),
        }
    }

    /// The histories with a new frame, held against it.
    fn rectified_history(
        self,
        history: Option<&LayerHistory>,
        colours: &Image<[f32; 4]>,
        layers: &Image<PixelLayers>,
        region: Region,
    ) -> Result<Image<Kept>, ImageError> {
        let (width, height) = colours.size();
        // Each layer's history, where it is now.
        let moved = match history {
            Some(LayerHistory(history)) => {
                Image::par_from_fn(width, height, |x, y| reprojected(history, layers, region, [x, y]))?
            }
            None => Image::filled(width, height, Kept::NONE)?,
        };
        // What the new samples say of it.
        let samples = Image::par_from_fn(width, height, |x, y| {
            Sample::new(colours[(x, y)], &layers[(x, y)], &moved[(x, y)])
        })?;
        Image::par_from_fn(width, height, |x, y| {
            let (own, sample, moved) = (&layers[(x, y)], &samples[(x, y)], &moved[(x, y)]);
            let [front, back] = Sums::around(&samples, [x, y], self.radius);
            let (hidden, coverage_count) = self.coverage(layers, moved, [x, y]);
            let moved = &Kept { back: clipped(moved.back, &samples, [x, y]), ..*moved };
            Kept {
                front: self.updated(Side::Front, moved, &front, sample, own),
                back: self.updated(Side::Back, moved, &back, sample, own),
                coverage: hidden.w,
                absorbed: hidden.truncate(),
                coverage_count,
                back_depth: own.back_depth.min(FARTHEST),
            }
        })
    }

    /// The most samples of a mean after so many frames in a row that show the same, once they are so many
    /// that the histories hold what is seen and nothing else; none before.
    fn still_samples(self, still_count: u32) -> Option<f32> {
        let samples = still_count as f32 / STILL_GAIN;
        (samples > 1.0 / self.weight).then_some(samples)
    }

    /// A layer of a pixel after the frame. Where it has no history and no sample of its own, the mean of the
    /// samples around stands in.
    fn updated(self, side: Side, moved: &Kept, sums: &Sums, sample: &Sample, layers: &PixelLayers) -> Mean {
        let mut mean = *moved.mean(side);
        let is_sampled = sample.side == side;
        if mean.count > 0.0 {
            let sigmas = match side {
                Side::Front => self.sigmas,
                Side::Back => self.sigmas * BACK_SIGMAS,
            };
            mean = rectified(mean, sums, sigmas);
        } else if !is_sampled && sums.all_weights > 0.0 {
            let colour = sums.colours / sums.all_weights;
            mean = Mean { colour, weight: weight(layers, side), count: BORROWED_COUNT, variance: 0.0 };
        }
        if is_sampled { mean.plus(sample.colour, sample.weight, 1.0 / self.weight) } else { mean }
    }

    /// What is absorbed, and the coverage: their means after the frame, and of how many frames. They are
    /// exact in each of them, so that what they vary by is the scene and the jitter, and a clip to the 3×3
    /// pixels around does no harm.
    fn coverage(self, layers: &Image<PixelLayers>, moved: &Kept, [x, y]: [u32; 2]) -> (Vec4, f32) {
        let (mut sum, mut squares) = (Vec4::ZERO, Vec4::ZERO);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let hidden = hidden_by(layers.get_clamped(i64::from(x) + dx, i64::from(y) + dy));
                sum += hidden;
                squares += hidden * hidden;
            }
        }
        let mean = sum / 9.0;
        let deviation = (squares / 9.0 - mean * mean).max(Vec4::ZERO).map(f32::sqrt);
        let clipped = moved.hidden().clamp(mean - deviation, mean + deviation);
        let count = (moved.coverage_count + 1.0).min(1.0 / self.weight);
        (clipped + (hidden_by(&layers[(x, y)]) - clipped) / count, count)
    }

    /// The front over the back.
    fn shown(self, kept: &Image<Kept>, [x, y]: [u32; 2]) -> [f32; 4] {
        let own = &kept[(x, y)];
        let coverage = match (own.front.count > 0.0, own.back.count > 0.0) {
            (true, true) => own.coverage,
            (true, false) => 1.0,
            (false, _) => 0.0,
        };
        let front = if coverage > 0.0 { self.smoothed(kept, [x, y]) } else { Vec4::ZERO };
        // Noise may take a dark pixel below black; cut off there, its mean would be too bright.
        let shown = rgba_from_ycocga(front * coverage + own.back.colour * (1.0 - coverage));
        if own.absorbed == Vec3::ZERO {
            return shown;
        }
        let absorbed = own.absorbed.extend(mean_channel(own.absorbed));
        let [red, green, blue, alpha] = rgba_from_ycocga(own.back.colour);
        // Behind a clear back, what is absorbed is covered.
        let covered = Vec4::W * absorbed.w;
        (Vec4::from(shown) - Vec4::new(red, green, blue, alpha) * absorbed + covered).to_array()
    }

    /// The front as it is shown: as far towards the mean of the 5×5 pixels around as what differs there is
    /// noise by what its samples vary over time (Lee 1980). The history stays as it is: smoothed again and
    /// again, it would lose its detail.
    fn smoothed(self, kept: &Image<Kept>, [x, y]: [u32; 2]) -> Vec4 {
        let own = kept[(x, y)].front.colour;
        let (mut count, mut sum, mut squares) = (0.0, Vec4::ZERO, 0.0);
        let (mut near_count, mut noise) = (0.0, 0.0);
        for dy in -SMOOTHING_RADIUS..=SMOOTHING_RADIUS {
            for dx in -SMOOTHING_RADIUS..=SMOOTHING_RADIUS {
                let neighbour = &kept.get_clamped(i64::from(x) + dx, i64::from(y) + dy).front;
                if neighbour.count <= 0.0 {
                    continue;
                }
                count += 1.0;
                sum += neighbour.colour;
                squares += neighbour.colour.x * neighbour.colour.x;
                if dx.abs() <= 1 && dy.abs() <= 1 {
                    near_count += 1.0;
                    noise += neighbour.variance / neighbour.count.max(1.0);
                }
            }
        }
        let mean = sum / count;
        let spread = (squares / count - mean.x * mean.x).max(0.0);
        let noise = self.smooth * noise / near_count;
        let gain = if spread > 0.0 { (1.0 - noise / spread).max(0.0) } else { 1.0 };
        mean + (own - mean) * gain
    }
}

/// What coloured glass absorbs, and the coverage.
fn hidden_by(layers: &PixelLayers) -> Vec4 {
    Vec3::from(layers.absorbed).extend(layers.coverage)
}

/// With another sample of what stands still: means of at most so many samples.
fn averaged(kept: &Kept, colour: [f32; 4], layers: &PixelLayers, most: f32) -> Kept {
    let side = if layers.is_front { Side::Front } else { Side::Back };
    let mean = kept.mean(side).plus(ycocga_from_rgba(colour), weight(layers, side), most);
    let coverage_count = (kept.coverage_count + 1.0).min(most);
    let hidden = kept.hidden() + (hidden_by(layers) - kept.hidden()) / coverage_count;
    let [front, back] = match side {
        Side::Front => [mean, kept.back],
        Side::Back => [kept.front, mean],
    };
    Kept {
        front,
        back,
        coverage: hidden.w,
        absorbed: hidden.truncate(),
        coverage_count,
        back_depth: layers.back_depth.min(FARTHEST),
    }
}

/// Pulls the history of the back into the ellipsoid of its samples in the 3×3 pixels around, as plain
/// temporal anti-aliasing does, but a wide one: it takes away what is plainly of another surface and no
/// detail.
fn clipped(mean: Mean, samples: &Image<Sample>, [x, y]: [u32; 2]) -> Mean {
    let (mut count, mut sum, mut squares) = (0.0, Vec4::ZERO, Vec4::ZERO);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let Sample { colour, side, .. } = *samples.get_clamped(i64::from(x) + dx, i64::from(y) + dy);
            if side == Side::Back {
                count += 1.0;
                sum += colour;
                squares += colour * colour;
            }
        }
    }
    if count < LEAST_CLIPPING || mean.count <= 0.0 {
        return mean;
    }
    let middle = sum / count;
    let deviation = (squares / count - middle * middle).max(Vec4::ZERO).map(f32::sqrt) * CLIP_SIGMAS;
    let offset = mean.colour - middle;
    let reach = (offset / deviation.max(Vec4::splat(LEAST_ERROR))).length();
    if reach <= 1.0 { mean } else { Mean { colour: middle + offset / reach, ..mean } }
}

/// Pulls a history to within some standard errors of what the samples around say, and forgets some of its
/// samples the further off it was.
fn rectified(mean: Mean, sums: &Sums, sigmas: f32) -> Mean {
    let samples = sums.weights * sums.weights / sums.squared_weights.max(f32::MIN_POSITIVE);
    if samples < LEAST_SAMPLES {
        return mean;
    }
    let residual = sums.residuals / sums.weights;
    let squares = sums.squared_residuals / sums.weights;
    let variance = (squares - residual * residual).max(Vec4::ZERO);
    let error = (variance / (samples - 1.0)).map(f32::sqrt);
    // The error is an estimate itself: as far out as Student's distribution has what the normal one has
    // within so many standard errors (the first term of Cornish and Fisher's expansion).
    let few = 1.0 + (sigmas * sigmas + 1.0) / (4.0 * (samples - 1.0));
    let excess = (residual.abs() - error * (sigmas * few)).max(Vec4::ZERO);
    let [starts, ends] = DOUBT;
    let reach = residual.x.abs() / (error.x * few).max(LEAST_ERROR);
    let doubt = ((reach - starts) / (ends - starts)).clamp(0.0, 1.0);
    let colour = mean.colour + residual.signum() * excess;
    Mean {
        // What is premultiplied exceeds an opacity of 1 as a whole.
        colour: colour / colour.w.max(1.0),
        count: mean.count * (1.0 - MOST_FORGOTTEN * doubt),
        ..mean
    }
}

/// The history of a pixel, each layer by its own motion; the front where it is now or just beside. Frames are
/// those of a region of the picture.
fn reprojected(history: &Image<Kept>, layers: &Image<PixelLayers>, region: Region, [x, y]: [u32; 2]) -> Kept {
    let own = &layers[(x, y)];
    let mut front = own;
    let (mut nearest, mut furthest) = (FARTHEST, 0.0_f32);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let neighbour = layers.get_clamped(i64::from(x) + dx, i64::from(y) + dy);
            nearest = nearest.min(neighbour.back_depth);
            furthest = furthest.max(neighbour.back_depth.min(FARTHEST));
            // A jittered ray misses a thin front now and then.
            if own.coverage <= 0.0 && neighbour.coverage > front.coverage {
                front = neighbour;
            }
        }
    }
    let place = |motion: [f32; 2]| {
        let at = UVec2::new(region.left + x, region.top + y).as_vec2() + Vec2::from(motion);
        Some(Place::inside(region, at)?.around(history))
    };
    let mut moved = Kept::NONE;
    let back_around = place(own.back_motion);
    if let Some(around) = &back_around {
        let depths = nearest * (1.0 - DEPTH_TOLERANCE)..=furthest * (1.0 + DEPTH_TOLERANCE);
        let fits = |kept: &Kept| kept.back.count > 0.0 && depths.contains(&kept.back_depth);
        moved.back = fetched(around, Side::Back, fits);
    }
    let front_around = if front.coverage > 0.0 { place(front.front_motion) } else { back_around };
    if let Some(around) = &front_around {
        // Without a front all around, nothing of one is left by the clip.
        if front.coverage > 0.0 {
            moved.front = fetched(around, Side::Front, |kept| kept.front.count > 0.0);
            let hidden = around.sharp(Kept::hidden);
            (moved.coverage, moved.absorbed) = (hidden.w, hidden.truncate());
        }
        moved.coverage_count =
            around.bilinear().map(|(kept, weight)| weight * kept.coverage_count).iter().sum();
    }
    moved
}

/// The mean of the pixels around a place that fit; sharp where all do.
fn fetched(around: &Around<'_, Kept>, side: Side, fits: impl Fn(&Kept) -> bool) -> Mean {
    let mut fitting = 0.0;
    let mut mean = Mean::NONE;
    for (kept, weight) in around.bilinear() {
        if weight > 0.0 && fits(kept) {
            let of_pixel = kept.mean(side);
            fitting += weight;
            mean.colour += of_pixel.colour * weight;
            mean.weight += of_pixel.weight * weight;
            mean.count += of_pixel.count * weight;
            mean.variance += of_pixel.variance * weight;
        }
    }
    if fitting < LEAST_FITTING {
        return Mean::NONE;
    }
    let is_sharp = !around.is_centre() && around.all(fits);
    let colour = if is_sharp { around.sharp(|kept| kept.mean(side).colour) } else { mean.colour / fitting };
    Mean {
        colour,
        weight: mean.weight / fitting,
        count: mean.count / fitting,
        variance: mean.variance / fitting,
    }
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::Pcg32;

    use super::*;
    use crate::contract::Alignment;

    const SIZE: u32 = 24;
    const STILL: Reprojection = Reprojection {
        alignment: Alignment::NONE,
        size: [SIZE; 2],
        region: Region { left: 0, top: 0, width: SIZE, height: SIZE },
        frame: 0,
        seed: 0,
    };
    const RED: [f32; 4] = [0.9, 0.1, 0.0, 1.0];
    const GREEN: [f32; 4] = [0.0, 0.6, 0.2, 1.0];

    /// A frame of a red front over a green back, each pixel showing one of them with the odds of `share`.
    fn frame(random: &mut Pcg32, coverage: f32, share: f32, layers: PixelLayers) -> Planes {
        let mut planes = Planes::with_layers(SIZE, SIZE).unwrap();
        for y in 0..SIZE {
            for x in 0..SIZE {
                let is_front = random.next_f32() < share;
                planes.colour[(x, y)] = if is_front { RED } else { GREEN };
                let own = PixelLayers { coverage, share, is_front, ..layers };
                planes.layers.as_mut().unwrap()[(x, y)] = own;
            }
        }
        planes
    }

    fn add(past: &mut Past, layered: Layered, mut planes: Planes) {
        let layers = layered.resolve(past, &mut planes, STILL).unwrap();
        *past = Past { planes, layers, count: past.count + 1, still_count: 0 };
    }

    fn nothing() -> Past {
        Past { planes: Planes::new(SIZE, SIZE).unwrap(), layers: None, count: 0, still_count: 0 }
    }

    #[test]
    fn even_layers_are_composited_by_their_coverage_from_the_second_frame_on() {
        let mut random = Pcg32::new(3, 0);
        let layers = PixelLayers { front_depth: 1.0, back_depth: 2.0, ..PixelLayers::EMPTY };
        for coverage in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let share = if coverage == 0.0 || coverage == 1.0 { coverage } else { 0.5 };
            let mut past = nothing();
            for _ in 0..2 {
                add(&mut past, Layered::DEFAULT, frame(&mut random, coverage, share, layers));
            }
            let exact = Vec4::from(RED) * coverage + Vec4::from(GREEN) * (1.0 - coverage);
            for pixel in past.planes.colour.as_slice() {
                assert!((Vec4::from(*pixel) - exact).abs().max_element() < 1e-5, "{coverage}: {pixel:?}");
            }
        }
    }

    #[test]
    fn a_picture_that_is_noise_keeps_its_mean() {
        // The front's samples are noise: what each pixel shows over many frames is their mean, within the
        // error of the mean, whatever the share of the samples is.
        let (frames, skipped) = (600, 100);
        for share in [0.25, 0.75] {
            let mut random = Pcg32::new(11, 0);
            let mut past = nothing();
            let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
            for index in 0..frames {
                let layers = PixelLayers { front_depth: 1.0, back_depth: 2.0, ..PixelLayers::EMPTY };
                let mut planes = frame(&mut random, 0.5, share, layers);
                let is_front = planes.layers.as_ref().unwrap().map(|layers| layers.is_front);
                for (pixel, is_front) in planes.colour.as_mut_slice().iter_mut().zip(is_front.as_slice()) {
                    if *is_front {
                        *pixel = [2.0 * random.next_f32(), 0.0, 0.0, 1.0];
                    }
                }
                add(&mut past, Layered::DEFAULT, planes);
                // Frames apart, means of the picture hardly depend on one another.
                if index >= skipped && index % 20 == 0 {
                    let reds = past.planes.colour.as_slice().iter().map(|pixel| f64::from(pixel[0]));
                    let mean = reds.sum::<f64>() / f64::from(SIZE * SIZE);
                    sum += mean;
                    squares += mean * mean;
                    count += 1.0;
                }
            }
            let mean = sum / count;
            let error = ((squares / count - mean * mean) / (count - 1.0)).sqrt();
            assert!((mean - 0.5).abs() < 5.0 * error, "{share}: {mean} ± {error}");
            assert!(error < 0.005, "the check is blind: {error}");
            // No wave grows out of the noise: everything stays within the range of the samples.
            for &[red, ..] in past.planes.colour.as_slice() {
                assert!((0.0..=1.0).contains(&red), "{share}: {red}");
            }
        }
    }

    #[test]
    fn what_stands_still_comes_to_the_mean_of_all_its_samples() {
        // A thin bright line behind a front is met by the ray of each tenth frame, another surface in all
        // others: a clip would take it for a ghost.
        let (coverage, line, ground) = (0.25, 4.0, 0.2);
        let exact = coverage * 0.5 + (1.0 - coverage) * (0.1 * line + 0.9 * ground);
        let last_of = |still_from: u32| {
            let mut random = Pcg32::new(17, 0);
            let mut past = nothing();
            for index in 0..2000_u32 {
                let mut planes = Planes::with_layers(SIZE, SIZE).unwrap();
                let meets = index.is_multiple_of(10);
                for y in 0..SIZE {
                    for x in 0..SIZE {
                        let is_front = random.next_f32() < coverage;
                        let back = if meets && x == SIZE / 2 { line } else { ground };
                        let value = if is_front { random.next_f32() } else { back };
                        planes.colour[(x, y)] = [value, value, value, 1.0];
                        planes.layers.as_mut().unwrap()[(x, y)] = PixelLayers {
                            coverage,
                            share: coverage,
                            is_front,
                            front_depth: 1.0,
                            back_depth: if meets && x == SIZE / 2 { 2.0 } else { 9.0 },
                            ..PixelLayers::EMPTY
                        };
                    }
                }
                past.still_count = (index + 1).saturating_sub(still_from);
                let layers = Layered::DEFAULT.resolve(&past, &mut planes, STILL).unwrap();
                past = Past { planes, layers, count: past.count + 1, ..past };
            }
            let column = (0..SIZE).map(|y| past.planes.colour[(SIZE / 2, y)][0]);
            column.sum::<f32>() / SIZE as f32
        };
        // 24 pixels of some 1,500 samples of the back each, of deviation 1.1.
        assert!((last_of(10) - exact).abs() < 5.0 * 1.2 / (24.0 * 1500.0_f32).sqrt(), "{}", last_of(10));
        // While things move it is taken for a ghost, rightly or not.
        assert!(last_of(u32::MAX) < 0.75 * exact, "{}", last_of(u32::MAX));
    }

    #[test]
    fn each_layer_follows_its_own_motion() {
        // A front of vertical stripes that moves two pixels a frame to the right over a back of horizontal
        // ones that stands still; each frame shows one of the layers whole.
        let stripe = |at: u32| if at % 8 < 4 { 1.0 } else { 0.0 };
        let mut past = nothing();
        for index in 0..6 {
            let mut planes = Planes::with_layers(SIZE, SIZE).unwrap();
            let is_front = index % 2 == 0;
            for y in 0..SIZE {
                for x in 0..SIZE {
                    let value = if is_front { stripe(x + 1000 - 2 * index) } else { stripe(y) };
                    planes.colour[(x, y)] = [value, value, value, 1.0];
                    planes.layers.as_mut().unwrap()[(x, y)] = PixelLayers {
                        absorbed: [0.0; 3],
                        coverage: 0.5,
                        share: 0.5,
                        is_front,
                        front_motion: [-2.0, 0.0],
                        front_depth: 1.0,
                        back_motion: [0.0; 2],
                        back_depth: 2.0,
                    };
                }
            }
            add(&mut past, Layered { smooth: 0.0, ..Layered::DEFAULT }, planes);
        }
        // The last frame showed the back alone; the front is where it would be by now.
        for (x, y) in [(12, 12), (14, 12), (16, 13), (18, 18)] {
            let exact = 0.5 * stripe(x + 1000 - 10) + 0.5 * stripe(y);
            let shown = past.planes.colour[(x, y)][0];
            assert!((shown - exact).abs() < 1e-4, "({x}, {y}): {shown}, {exact}");
        }
    }

    #[test]
    fn a_change_of_colour_is_followed_and_noise_is_not() {
        let layers = PixelLayers { back_depth: 2.0, ..PixelLayers::EMPTY };
        let shown_after = |noise: f32, shift: f32| {
            let mut random = Pcg32::new(7, 0);
            let mut past = nothing();
            for index in 0..40 {
                let mut planes = frame(&mut random, 0.0, 0.0, layers);
                for pixel in planes.colour.as_mut_slice() {
                    let value =
                        0.5 + noise * (random.next_f32() - 0.5) + if index == 39 { shift } else { 0.0 };
                    *pixel = [value, value, value, 1.0];
                }
                add(&mut past, Layered::DEFAULT, planes);
            }
            past.planes.colour[(SIZE / 2, SIZE / 2)][0]
        };
        // A shift of many standard errors arrives in the frame in which it happens.
        assert!(shown_after(0.1, 0.3) > 0.7, "{}", shown_after(0.1, 0.3));
        assert!((shown_after(0.1, 0.0) - 0.5).abs() < 0.03, "{}", shown_after(0.1, 0.0));
    }

    #[test]
    fn no_shift_makes_more_than_opaque() {
        // An opaque card that grows over a clear background: where it is, the neighbourhood gains opacity.
        let mut past = nothing();
        for index in 0..30 {
            let mut planes = Planes::with_layers(SIZE, SIZE).unwrap();
            for y in 0..SIZE {
                for x in 0..SIZE {
                    let is_card = x < 4 + index / 2;
                    planes.colour[(x, y)] = if is_card { [0.6, 0.0, 0.0, 1.0] } else { [0.0; 4] };
                    let back_depth = if is_card { 2.0 } else { f32::INFINITY };
                    planes.layers.as_mut().unwrap()[(x, y)] =
                        PixelLayers { back_depth, ..PixelLayers::EMPTY };
                }
            }
            add(&mut past, Layered::DEFAULT, planes);
            for &[r, _, _, a] in past.planes.colour.as_slice() {
                assert!(a <= 1.0001 && (r - 0.6 * a).abs() < 1e-4, "{index}: {r} {a}");
            }
        }
    }

    #[test]
    fn what_the_back_uncovers_has_no_history_of_what_covered_it() {
        let mut random = Pcg32::new(5, 0);
        let mut past = nothing();
        let near = PixelLayers { back_depth: 1.0, ..PixelLayers::EMPTY };
        for _ in 0..8 {
            let mut planes = frame(&mut random, 0.0, 0.0, near);
            planes.colour.as_mut_slice().fill(RED);
            add(&mut past, Layered::DEFAULT, planes);
        }
        let far = PixelLayers { back_depth: 5.0, ..PixelLayers::EMPTY };
        add(&mut past, Layered::DEFAULT, frame(&mut random, 0.0, 0.0, far));
        let shown = Vec4::from(past.planes.colour[(SIZE / 2, SIZE / 2)]);
        assert!((shown - Vec4::from(GREEN)).abs().max_element() < 1e-5, "{shown}");
    }
}

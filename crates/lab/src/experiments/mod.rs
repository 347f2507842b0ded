//! The figures of the papers, made again and measured.
//!
//! An experiment is a row of the table [`Experiment::ALL`] and a function that returns [`Findings`]: what was
//! claimed and whether it holds, tables, charts, pictures. Nothing fails where a claim does not hold: that is
//! a finding.

use sheer_render::Backend;

use crate::{LabError, Result};

mod averages;
mod findings;
mod lab;
mod quality;
mod speed;
mod stochastic;

pub use self::{
    findings::{Claim, Findings, Picture},
    lab::Lab,
};

/// What is made again on a backend.
#[derive(Debug)]
pub struct Experiment<B: Backend + 'static> {
    /// For the command line, file names and links.
    pub id: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Paper and figure.
    pub source: &'static str,
    /// What is done, and where and why the outcome differs from the paper's.
    pub account: &'static str,
    /// Makes it.
    pub run: fn(&Lab<'_, B>) -> Result<Findings>,
}

impl<B: Backend + 'static> Experiment<B> {
    /// All of them, in the order of the report.
    pub const ALL: &'static [Self] = &[
        Self {
            id: "fight",
            title: "A fight full of effects",
            source: "STD Fig. 1, 8 and 14",
            account: "Everything moves, under TAA. Objects are counted as lost that a method hardly ever shows although they ought to be seen: white noise says how \
                  often. `stbn` and `roulette` come out ahead of `std` here and the paper does not have it so: it shows DLSS, which takes dithering for \
                  detail, and we measure fidelity under plain TAA, whose reprojection mixes the places of a pattern.",
            run: quality::fight,
        },
        Self {
            id: "opacities",
            title: "Ten opacities",
            source: "STD section 3.2.1, Fig. 2",
            account: "How bright white of an opacity is over black, against that opacity. The paper corrects for DLSS, whose weights are not \
                  public; here our own anti-aliasing is measured.",
            run: averages::opacities,
        },
        Self {
            id: "sequences",
            title: "Why the order of thresholds matters",
            source: "STD Fig. 4",
            account: "The exponential average of the tests that one pixel makes: in the order of the serpentine walk, and with the same \
                  thresholds sorted.",
            run: averages::sequences,
        },
        Self {
            id: "alignment",
            title: "Motion vectors aligned to the pattern",
            source: "STD section 3.3.1, Fig. 5",
            account: "A moving camera under TAA, with motion vectors aligned to multiples of the pattern's side and without.",
            run: quality::alignment,
        },
        Self {
            id: "still-pane",
            title: "A pane, nothing moves",
            source: "STD Fig. 6",
            account: "One pane and nothing moves. `stbn` is ahead of `std`, which the paper leaves to its appendix and to the eye: its masks are blue in space as \
                  well as in time, and SSIM rewards that at the size of its window.",
            run: quality::still_pane,
        },
        Self {
            id: "moving-pane",
            title: "A pane, the camera moves",
            source: "STD Fig. 7",
            account: "The same pane while the camera passes. `stbn` is ahead again, for the same reason.",
            run: quality::moving_pane,
        },
        Self {
            id: "smoke",
            title: "Smoke over the square",
            source: "STD Fig. 9",
            account: "Tens of faint layers under a moving camera. Two things differ from the paper. The maps of stacked layers are not independent, so that `std` and \
                  `dtaa-unique` hide what they ought to show (see `docs/joint.md`), the more layers the worse; the paper's cloud is thinner. And alignment, \
                  which saves flat colours from drifting, costs detail where everything is noise: without it `std` and `joint` gain much, and `joint` is level with \
                  white noise.",
            run: quality::smoke,
        },
        Self {
            id: "time-fight",
            title: "Time over the fight",
            source: "STD Fig. 11",
            account: "Ten seconds of the fight, a frame every 0.4 s. Effects cover less of our picture than of the paper's, so that hybrids below 0.75 hardly pay, as the \
                  paper found as well.",
            run: speed::fight,
        },
        Self {
            id: "time-smoke",
            title: "Time on the way through the smoke",
            source: "STD Fig. 12",
            account: "Twelve seconds along the path, a frame every half second. What remains of growth in `std` is that of testing hits: shading is constant.",
            run: speed::smoke,
        },
        Self {
            id: "hybrid",
            title: "Between exact and stochastic",
            source: "STD section 3.4, Fig. 13",
            account: "Exact fragments first, then one draw. In smoke where tens of layers each take little, half the visibility is far from the end, and the error at 0.5 \
                  is still more than half; the limit of layers buys less than the same time spent on a threshold. At 0 under TAA nothing differs from the baseline.",
            run: speed::hybrid,
        },
        Self {
            id: "joint",
            title: "One threshold for all layers",
            source: "own; STD section 6, first item",
            account: "Equal times, as the table shows; `docs/joint.md` explains the method and weighs it.",
            run: averages::joint,
        },
        Self {
            id: "samples",
            title: "Random masks with more and more samples",
            source: "ST section 3.1, Fig. 2",
            account: "Single frames without anti-aliasing, alpha 0.3, the basic method.",
            run: stochastic::samples,
        },
        Self {
            id: "visibility",
            title: "Visibility as a stochastic map has it",
            source: "ST section 3.2, Fig. 3",
            account: "Eight random blockers along a ray from a light. The line is the truth, the steps are two draws.",
            run: stochastic::visibility,
        },
        Self {
            id: "estimators",
            title: "Less noise by alpha correction and by depth",
            source: "ST sections 3.3 and 3.4, Fig. 4",
            account: "Single frames without anti-aliasing. Alpha correction by itself gains little on this model and now and then nothing, as the colours of its layers \
                  differ (ST says as much of its Example 1); with depth it gains at every size.",
            run: stochastic::estimators,
        },
        Self {
            id: "shadows",
            title: "Noise in stochastic shadow maps",
            source: "ST section 3.6, Fig. 5",
            account: "Maps of 1024 texels without a filter. Against deep rays they have errors that no number of samples mends, so the noise is measured \
                  against the map that keeps every blocker.",
            run: stochastic::shadows,
        },
        Self {
            id: "passes",
            title: "What the passes cost",
            source: "ST Table 1",
            account: "500 × 500 pixels, 8 samples, 16 shadow samples, as in the paper, which needs three to four blended passes. Here a pass that shades is not much dearer \
                  than one that only traces, and the blended pass shades fragments that no sample sees, which the last pass of the algorithm does not. \
                  Step times are those of all threads by their number.",
            run: stochastic::table,
        },
        Self {
            id: "growth",
            title: "Time over the number of layers",
            source: "ST section 5, depth peeling",
            account: "Stacks of equal layers over the whole picture. Each pass traces its fragments anew, as a rasteriser draws them anew.",
            run: stochastic::growth,
        },
        Self {
            id: "family",
            title: "The family on every scene",
            source: "the methods that people use today",
            account: "Single frames without anti-aliasing. `bytes/px` is what a GPU would store beyond colour and depth, `merged/px` the fragments that found no place of their \
                  own; weighted blending and moments keep none apart. In hair and smoke four peeled layers are far from enough.",
            run: stochastic::family,
        },
    ];

    /// Those of these names, all where none is given.
    ///
    /// # Errors
    /// [`LabError::Misuse`] if there is none of such a name.
    pub fn chosen(names: &[String]) -> Result<Vec<&'static Self>> {
        if names.is_empty() {
            return Ok(Self::ALL.iter().collect());
        }
        let find = |name: &String| {
            Self::ALL.iter().find(|experiment| experiment.id == name).ok_or_else(|| {
                let known = Self::ALL.iter().map(|experiment| experiment.id).collect::<Vec<_>>().join(", ");
                LabError::Misuse(format!("there is no experiment '{name}'; there are: {known}"))
            })
        };
        names.iter().map(find).collect()
    }
}

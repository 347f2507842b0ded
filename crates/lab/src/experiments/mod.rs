//! The figures of the papers, made again and measured.
//!
//! An experiment is a row of the table [`Experiment::ALL`] and a function that returns [`Findings`]: what was
//! claimed and whether it holds, tables, charts, pictures. Nothing fails where a claim does not hold: that is
//! a finding.

use sheer_core::suggestion::suggestion;
use sheer_render::Backend;

use crate::{LabError, Result};

mod averages;
mod claims;
mod findings;
mod lab;
mod layered;
mod layers;
mod noise;
mod quality;
mod sequences;
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
    /// What is done. What came of it is in the claims and their remarks, which are chosen by what was
    /// measured.
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
            account: "Everything moves, under TAA. Objects are counted as lost that a method hardly ever shows although they ought to be seen: white noise says how often. The paper shows DLSS; here fidelity to the exact picture under plain TAA is measured.",
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
            account: "The exponential average of the tests that one pixel makes: of the two sequences that the paper prints, and of the walks of every pixel over every map.",
            run: sequences::sequences,
        },
        Self {
            id: "alignment",
            title: "Motion vectors aligned to the pattern",
            source: "STD section 3.3.1, Fig. 5",
            account: "A moving camera under TAA, with motion vectors aligned to multiples of the pattern's side at random, as in the paper, to the nearest one, as in the authors' code, and not at all.",
            run: quality::alignment,
        },
        Self {
            id: "still-pane",
            title: "A pane, nothing moves",
            source: "STD Fig. 6",
            account: "One pane of an opacity of one half, and nothing moves.",
            run: quality::still_pane,
        },
        Self {
            id: "moving-pane",
            title: "A pane, the camera moves",
            source: "STD Fig. 7",
            account: "The same pane while the camera passes.",
            run: quality::moving_pane,
        },
        Self {
            id: "smoke",
            title: "Smoke over the square",
            source: "STD Fig. 9",
            account: "Tens of faint layers under a moving camera, with motion vectors aligned and not, and with blue noise of their own for the particles.",
            run: quality::smoke,
        },
        Self {
            id: "shared-noise",
            title: "One blue noise for all layers",
            source: "STD Listing 4",
            account: "Stacks of faint layers in closed form, and still smoke, with the blue noise shared, as in the paper, from an offset of its own for each object, and none; with maps that stay and maps that are drawn anew.",
            run: noise::shared_noise,
        },
        Self {
            id: "pane-opacities",
            title: "A pane of every opacity",
            source: "STD section 3.3, Fig. 6",
            account: "The still pane at opacities of whole ninths, which nine thresholds show without rounding, and at one half between two of them.",
            run: noise::pane_opacities,
        },
        Self {
            id: "time-fight",
            title: "Time over the fight",
            source: "STD Fig. 11",
            account: "Ten seconds of the fight, a frame every 0.4 s.",
            run: speed::fight,
        },
        Self {
            id: "time-smoke",
            title: "Time on the way through the smoke",
            source: "STD Fig. 12",
            account: "Twelve seconds along the path, a frame every half second.",
            run: speed::smoke,
        },
        Self {
            id: "hybrid",
            title: "Between exact and stochastic",
            source: "STD section 3.4, Fig. 13",
            account: "Exact fragments first, then one draw; and a limit of exact layers.",
            run: speed::hybrid,
        },
        Self {
            id: "joint",
            title: "One threshold for all layers",
            source: "own; STD section 6, first item",
            account: "Stacks of layers in closed form, then clips; `docs/joint.md` explains the method and weighs it.",
            run: averages::joint,
        },
        Self {
            id: "layered",
            title: "Layers averaged each by itself",
            source: "own; STD section 6, ST section 3.3",
            account: "Moving clips under plain TAA and under layered accumulation, held against the exact picture of many samples at the moment of each frame; `docs/layered.md` explains it and has more clips.",
            run: layered::layered,
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
            account: "Single frames without anti-aliasing, alpha 0.3 and 0.4.",
            run: stochastic::estimators,
        },
        Self {
            id: "shadows",
            title: "Noise in stochastic shadow maps",
            source: "ST section 3.6, Fig. 5",
            account: "Maps of 1024 texels without a filter. The noise is measured against the map that keeps every blocker: against deep rays all maps have errors of their own.",
            run: stochastic::shadows,
        },
        Self {
            id: "passes",
            title: "What the passes cost",
            source: "ST Table 1",
            account: "500 × 500 pixels, 8 samples, 16 shadow samples, as in the paper. Step times are those of all threads by their number.",
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
            account: "Single frames without anti-aliasing. `bytes/px` is what a GPU would store beyond colour and depth, `merged/px` the fragments that found no place of their own; weighted blending and moments keep none apart.",
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
                let known: Vec<&str> = Self::ALL.iter().map(|experiment| experiment.id).collect();
                let nearest = suggestion(name, known.iter().copied());
                let known = known.join(", ");
                LabError::Misuse(format!("there is no experiment '{name}'; there are: {known}{nearest}"))
            })
        };
        names.iter().map(find).collect()
    }
}

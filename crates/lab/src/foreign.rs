//! Pictures of a clip that another program has made, beside the methods that play it.

use sheer_image::{DisplayShare, Image, Picture};
use sheer_metrics::Ghosting;
use sheer_render::Antialiasing;

use crate::{
    Figures, Judged, Judging, LabError, Result,
    figures::TRUTH_PREFIX,
    pictures::{Judgement, figure},
    shown::Shown,
};

/// The pictures of another program, of the size of the clip.
pub struct Foreign<'a> {
    /// What they are called.
    pub name: &'a str,
    /// Reads that of a frame, counted from the clip's first. Frames without one are left out; the last has
    /// one. Asked for the last half of the frames.
    pub picture: &'a dyn Fn(u32) -> Result<Option<Picture>>,
}

/// How they do beside methods under one anti-aliasing.
#[derive(Clone, Debug)]
pub struct ForeignJudged {
    /// That of the methods.
    pub antialiasing: Antialiasing,
    /// Against the reference under that anti-aliasing: means over the last half of the frames, as far as
    /// there are pictures.
    pub against_same: Judged,
    /// Against the truth, where there is one: over the last quarter.
    pub against_truth: Option<Judged>,
    /// As [`AgainstTruth::ghosting`](crate::AgainstTruth::ghosting).
    pub ghosting: Option<f64>,
    /// Whether they hold linear light. The errors in linear light of those that are made for a display, root
    /// mean square, bias and ghosting, say how the tone curve changes light and no more.
    pub in_linear_light: bool,
}

impl ForeignJudged {
    /// The figure under a title of [`figures`](crate::figures), where there is one: no time is known, nor
    /// what was shaded.
    fn figure(&self, title: &str) -> Option<f64> {
        let (judged, title) = match title.strip_prefix(TRUTH_PREFIX) {
            Some(title) => (self.against_truth.as_ref()?, title),
            None => (&self.against_same, title),
        };
        match title {
            "RMS" | "bias" | "ghosting" if !self.in_linear_light => None,
            "ghosting" => self.ghosting,
            _ => figure(judged, title),
        }
    }
}

impl Figures {
    /// Adds a row for each clip of pictures to those of methods, which have named the anti-aliasing or not.
    pub fn add_foreign<'j>(&mut self, judged: impl IntoIterator<Item = &'j ForeignJudged>, names_aa: bool) {
        for clip in judged {
            let names = [clip.against_same.name.clone(), clip.antialiasing.to_string()];
            self.add_row(&names[..if names_aa { 2 } else { 1 }], |title| clip.figure(title));
        }
    }
}

/// Pictures of several programs on their way through a clip; by default of none.
#[derive(Default)]
pub(crate) struct Beside<'a> {
    judging: Judging,
    last_frame: u32,
    clips: Vec<Contestant<'a>>,
}

/// The pictures of one.
struct Contestant<'a> {
    foreign: &'a Foreign<'a>,
    same: Judgement,
    truth: Judgement,
    ghosting: Ghosting<3>,
    in_linear_light: bool,
    /// At the end.
    judged: Option<(Judged, Option<Judged>)>,
}

impl<'a> Beside<'a> {
    pub(crate) fn new(foreign: &'a [Foreign<'a>], judging: Judging, frame_count: u32) -> Self {
        let clip = |foreign| Contestant {
            foreign,
            same: Judgement::new(judging),
            truth: Judgement::new(judging),
            ghosting: Ghosting::default(),
            in_linear_light: true,
            judged: None,
        };
        Self { judging, last_frame: frame_count.saturating_sub(1), clips: foreign.iter().map(clip).collect() }
    }

    /// Takes a frame, with what it is held against: the reference, and the truth with the pixels that were
    /// uncovered.
    pub(crate) fn add(
        &mut self,
        index: u32,
        reference: &Shown,
        truth: Option<(&Shown, &Image<bool>)>,
    ) -> Result<()> {
        for Contestant { foreign, same, truth: of_truth, ghosting, in_linear_light, judged } in
            &mut self.clips
        {
            let Some(picture) = (foreign.picture)(index)? else { continue };
            let found = Shown::new(&picture.colour, self.judging.tone, &picture.share);
            *in_linear_light &= picture.share == DisplayShare::Nothing;
            same.add(foreign.name, reference, &found)?;
            if let Some((truth, uncovered)) = truth {
                of_truth.add(foreign.name, truth, &found)?;
                ghosting.add(&truth.linear, &found.linear, uncovered)?;
            }
            if index == self.last_frame {
                let against_truth =
                    truth.map(|(truth, _)| of_truth.judged(foreign.name, truth, &found, &picture));
                let against_same = same.judged(foreign.name, reference, &found, &picture)?;
                *judged = Some((against_same, against_truth.transpose()?));
            }
        }
        Ok(())
    }

    /// What came of them.
    ///
    /// # Errors
    /// [`LabError::Misuse`] if the last frame has no picture.
    pub(crate) fn judged(self, antialiasing: Antialiasing) -> Result<Vec<ForeignJudged>> {
        let judged = self.clips.into_iter().map(|clip| match clip.judged {
            Some((against_same, against_truth)) => Ok(ForeignJudged {
                antialiasing,
                against_same,
                against_truth,
                ghosting: clip.ghosting.value(),
                in_linear_light: clip.in_linear_light,
            }),
            None => Err(LabError::Misuse(format!("{} has no picture of the last frame", clip.foreign.name))),
        });
        judged.collect()
    }
}

#[cfg(test)]
mod tests {
    use sheer_render::{Pipeline, Settings, Stage, backend::Cpu};
    use sheer_scene::CameraChoice;

    use super::*;
    use crate::{Clip, Reference, Silent, Truth, figures, with_reference};

    const SIZE: [u32; 2] = [24, 16];
    const FRAMES: u32 = 8;

    /// The clip under `taa` with these pictures beside it, against both references.
    fn beside(picture: &dyn Fn(u32) -> Result<Option<Picture>>) -> Result<(Figures, ForeignJudged)> {
        let scene = sheer_gallery::open("layers:count=2").unwrap().scene;
        let mut stage = Stage::new(scene, &CameraChoice::Default, Some(1)).unwrap();
        let settings = Settings { size: SIZE, ..Settings::default() };
        let clip =
            Clip { settings, antialiasing: Antialiasing::TAA, frame_count: FRAMES, keeps_frames: false };
        let methods = with_reference(vec!["std".parse().unwrap()]).unwrap();
        let mut truth = Truth::new(settings, 2);
        let foreign = [Foreign { name: "theirs", picture }];
        let (measured, mut judged) =
            clip.play_beside(&Cpu, &mut stage, (&methods, &[0]), Some(&mut truth), &foreign, &Silent)?;
        let mut figures = figures(&measured, true, &[Reference::Same, Reference::TRUTH]);
        figures.add_foreign(&judged, true);
        Ok((figures, judged.remove(0)))
    }

    fn grey(width: u32, value: f32, share: DisplayShare) -> Picture {
        let colour = Image::filled(width, SIZE[1], [value, value, value, 1.0]).unwrap();
        Picture { colour, share }
    }

    #[test]
    fn foreign_pictures_have_a_row_with_the_figures_that_are_known() {
        let (figures, judged) =
            beside(&|index| Ok(Some(grey(SIZE[0], 0.1 * index as f32, DisplayShare::Nothing)))).unwrap();
        assert_eq!((judged.against_same.frames, judged.against_truth.as_ref().unwrap().frames), (4, 2));
        let titles: Vec<&str> = figures.titles().collect();
        let rows: Vec<Vec<_>> = figures.cells().map(Iterator::collect).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!((rows[2][0].0, rows[2][1].0), ("theirs", "taa"));
        for (title, (_, value)) in titles.iter().zip(&rows[2]).skip(2) {
            let is_known = !title.contains("ms") && !["min", "max"].contains(title) && !title.contains("/px");
            let may_lack = *title == "ghosting";
            assert!(may_lack || value.is_some() == is_known, "{title}: {value:?}");
        }
        let figure =
            |title: &str| rows[2][titles.iter().position(|known| *known == title).unwrap()].1.unwrap();
        assert_eq!(figure("SSIM"), judged.against_same.ssim);
        assert_eq!(figure("truth bias"), judged.against_truth.unwrap().bias);
        assert_ne!(figure("SSIM"), figure("truth SSIM"));
        // What is made for a display says nothing of linear light.
        let shown = |_| Ok(Some(grey(SIZE[0], 0.5, DisplayShare::Everything)));
        let (figures, _) = beside(&shown).unwrap();
        let row: Vec<_> = figures.cells().last().unwrap().collect();
        let of_light = ["RMS", "bias", "ghosting", "truth RMS", "truth bias"];
        let of_light = titles.iter().zip(&row).filter(|(title, _)| of_light.contains(*title));
        assert!(of_light.clone().count() >= 4 && of_light.clone().all(|(_, (_, value))| value.is_none()));
    }

    #[test]
    fn one_picture_of_the_last_frame_will_do_and_the_exact_one_has_no_error() {
        let exact = {
            let scene = sheer_gallery::open("layers:count=2").unwrap().scene;
            let mut stage = Stage::new(scene, &CameraChoice::Default, Some(1)).unwrap();
            let settings = Settings { size: SIZE, ..Settings::default() };
            let mut pipeline =
                Pipeline::new("baseline".parse().unwrap(), Antialiasing::TAA, settings).unwrap();
            for index in 0..FRAMES {
                stage.advance(pipeline.clock().at(index));
                pipeline.render(&stage, index).unwrap();
            }
            let colour = pipeline.planes().colour.clone();
            Picture { colour, share: DisplayShare::Nothing }
        };
        let last = |index| Ok((index == FRAMES - 1).then(|| exact.clone()));
        let (_, judged) = beside(&last).unwrap();
        assert_eq!((judged.against_same.frames, judged.against_same.rms), (1, 0.0));
        // Layers without an edge need no more than one sample.
        assert!(judged.against_truth.unwrap().rms < 1e-6);
        let grey = |index| Ok((index == FRAMES - 1).then(|| grey(SIZE[0], 0.5, DisplayShare::Nothing)));
        let (_, judged) = beside(&grey).unwrap();
        assert!(judged.against_same.rms > 0.01 && judged.against_truth.unwrap().rms > 0.01);
    }

    #[test]
    fn pictures_of_another_size_or_without_an_end_are_refused() {
        let refused =
            |picture: &dyn Fn(u32) -> Result<Option<Picture>>| beside(picture).unwrap_err().to_string();
        let small = refused(&|_| Ok(Some(grey(8, 0.0, DisplayShare::Nothing))));
        assert!(small.contains("theirs is 8x16 and the reference 24x16"), "{small}");
        let short =
            refused(&|index| Ok((index < FRAMES - 1).then(|| grey(SIZE[0], 0.0, DisplayShare::Nothing))));
        assert!(short.contains("theirs has no picture of the last frame"), "{short}");
    }
}

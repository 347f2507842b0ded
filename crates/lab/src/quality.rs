//! What pictures are held against others by, frame by frame.

use sheer_metrics::{Flicker, TemporalPsnr, bias, flip, psnr_db, rms, ssim};

use crate::{Result, shown::Shown};

/// Error of a displayed image that error maps show in their last colour.
pub const ERROR_FULL_SCALE: f32 = 0.25;

/// Sums over frames, each held against that of a reference.
#[derive(Default)]
pub(crate) struct Quality {
    frames: u32,
    ssim: f64,
    psnr_db: f64,
    /// Those that equal the reference: their PSNR is infinite.
    equal_frames: u32,
    flip: f64,
    bias: f64,
    rms: f64,
    flicker: Flicker<3>,
    tpsnr: TemporalPsnr<3>,
}

impl Quality {
    pub(crate) fn add(&mut self, reference: &Shown, shown: &Shown) -> Result<()> {
        self.frames += 1;
        self.ssim += ssim(&reference.displayed, &shown.displayed)?;
        match psnr_db(&reference.displayed, &shown.displayed)? {
            f64::INFINITY => self.equal_frames += 1,
            psnr_db => self.psnr_db += psnr_db,
        }
        self.flip += flip(&reference.displayed, &shown.displayed)?;
        self.bias += bias(&reference.linear, &shown.linear)?;
        self.rms += rms(&reference.linear, &shown.linear)?;
        self.flicker.add(&reference.displayed, &shown.displayed)?;
        self.tpsnr.add(&reference.displayed, &shown.displayed)?;
        Ok(())
    }

    fn mean(&self, sum: f64) -> f64 {
        sum / f64::from(self.frames)
    }

    pub(crate) fn ssim(&self) -> f64 {
        self.mean(self.ssim)
    }

    /// The mean of the frames that differ from the reference; none where all equal it.
    pub(crate) fn psnr_db(&self) -> Option<f64> {
        let different = self.frames - self.equal_frames;
        (different > 0).then(|| self.psnr_db / f64::from(different))
    }

    /// None where the changes equal those of the reference, or for one frame.
    pub(crate) fn tpsnr_db(&self) -> Option<f64> {
        self.tpsnr.value_db().filter(|tpsnr_db| tpsnr_db.is_finite())
    }

    pub(crate) fn flip(&self) -> f64 {
        self.mean(self.flip)
    }

    pub(crate) fn flicker(&self) -> f64 {
        self.flicker.value()
    }

    pub(crate) fn bias(&self) -> f64 {
        self.mean(self.bias)
    }

    pub(crate) fn rms(&self) -> f64 {
        self.mean(self.rms)
    }
}

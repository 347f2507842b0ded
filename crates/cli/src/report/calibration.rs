//! What `sheer calibrate` found.

use sheer_core::coverage::Correction;

use super::{
    figures::{Column, Figures},
    json::Run,
};

/// What a method under an anti-aliasing shows of some opacities, and the correction that sets it right.
#[derive(Debug)]
pub(crate) struct Calibration {
    pub(crate) run: Run,
    pub(crate) method: String,
    pub(crate) aa: String,
    pub(crate) levels: Vec<Level>,
    pub(crate) correction: Correction,
}

/// Of one column of the scene.
#[derive(Debug)]
pub(crate) struct Level {
    /// From 1.
    pub(crate) number: usize,
    /// Opacity of the material.
    pub(crate) wanted: f64,
    /// Coverage that the method was fed with for it.
    pub(crate) fed: f64,
    /// Opacity in the picture.
    pub(crate) measured: f64,
    /// Coverage that shows what is wanted.
    pub(crate) corrected: f64,
}

const COLUMNS: &[Column<Level>] = &[
    Column {
        title: "wanted",
        meaning: "Opacity of the material.",
        decimals: 4,
        is_optional: false,
        value: |_, level| Some(level.wanted),
    },
    Column {
        title: "measured",
        meaning: "Opacity that the picture shows: brightness of white with this opacity over black, the mean over the last half of the frames.",
        decimals: 4,
        is_optional: false,
        value: |_, level| Some(level.measured),
    },
    Column {
        title: "corrected",
        meaning: "Coverage to feed the method with, so that it shows the opacity that is wanted.",
        decimals: 4,
        is_optional: false,
        value: |_, level| Some(level.corrected),
    },
];

impl Calibration {
    /// The table.
    pub(crate) fn figures(&self) -> Figures {
        Figures::new(&[("level", |level: &Level| level.number.to_string())], COLUMNS, &self.run, &self.levels)
    }

    /// The correction as a formula.
    pub(crate) fn formula(&self) -> String {
        let [constant, rest @ ..] = self.correction.coefficients();
        let terms = rest.into_iter().zip(["a", "a^2", "a^3"]).map(|(coefficient, power)| {
            let sign = if coefficient < 0.0 { '-' } else { '+' };
            format!(" {sign} {:.4} {power}", coefficient.abs())
        });
        format!("{constant:.4}{}", terms.collect::<String>())
    }

    /// Root mean square distance of the cubic from the points it was fitted to.
    pub(crate) fn residual(&self) -> f64 {
        let [c0, c1, c2, c3] = self.correction.coefficients().map(f64::from);
        let squares = self.levels.iter().map(|level| {
            let m = level.measured;
            (c0 + c1 * m + c2 * m * m + c3 * m.powi(3) - level.fed).powi(2)
        });
        (squares.sum::<f64>() / self.levels.len() as f64).sqrt()
    }

    /// For the terminal.
    pub(crate) fn text(&self) -> String {
        format!(
            "{}\ncoverage to feed, from opacity wanted: {}\nroot mean square residual: {:.4}\n\n{}",
            self.figures().text(),
            self.formula(),
            self.residual(),
            self.plot()
        )
    }

    /// Over the wanted opacities: `.` themselves, `o` measured, `x` corrected.
    fn plot(&self) -> String {
        const ROWS: usize = 10;
        let row = |value: f64| (value.clamp(0.0, 1.0) * ROWS as f64).round() as usize;
        let mut text = String::new();
        for at in (0..=ROWS).rev() {
            let mut line = format!("{:.1} |", at as f64 / ROWS as f64);
            for level in &self.levels {
                let marks = [(level.wanted, '.'), (level.measured, 'o'), (level.corrected, 'x')];
                line.push(' ');
                line.extend(marks.map(|(value, mark)| if row(value) == at { mark } else { ' ' }));
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text + ". wanted  o measured  x corrected\n"
    }
}

//! What `sheer calibrate` found.

use sheer_lab::calibrate::Calibration;

use super::{json::Run, table::Table};

/// What a method under an anti-aliasing shows of some opacities, how that came about, and the correction that
/// sets it right.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) run: Run,
    pub(crate) method: String,
    pub(crate) aa: String,
    pub(crate) calibration: Calibration,
}

impl Report {
    /// The correction as a formula.
    pub(crate) fn formula(&self) -> String {
        let [constant, rest @ ..] = self.calibration.correction.coefficients();
        let terms = rest.into_iter().zip(["a", "a^2", "a^3"]).map(|(coefficient, power)| {
            let sign = if coefficient < 0.0 { '-' } else { '+' };
            format!(" {sign} {:.4} {power}", coefficient.abs())
        });
        format!("{constant:.4}{}", terms.collect::<String>())
    }

    /// For the terminal.
    pub(crate) fn text(&self) -> String {
        format!(
            "{}\ncoverage to feed, from opacity wanted: {}\nroot mean square residual: {:.4}\n\n{}",
            Table::of(&self.calibration.figures()).text(),
            self.formula(),
            self.calibration.residual(),
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
            for level in &self.calibration.levels {
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

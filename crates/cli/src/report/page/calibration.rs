//! `sheer calibrate --html`: opacities wanted, measured and corrected.

use serde::Serialize;
use sheer_lab::{
    Figures,
    calibrate::{Calibration, Level},
    plot::{Axis, Plot, Series},
};

use super::{data_uri, fill};
use crate::report::{calibration::Report, chart::Chart, json::Run};

#[derive(Serialize)]
struct Context<'a> {
    run: &'a Run,
    method: &'a str,
    aa: &'a str,
    figures: Figures,
    opacity: Chart,
    formula: String,
    residual: String,
    picture: String,
}

/// The page as text; the picture is the last frame as PNG.
pub(crate) fn text(report: &Report, picture_png: &[u8]) -> anyhow::Result<String> {
    fill(
        "calibration.html",
        Context {
            run: &report.run,
            method: &report.method,
            aa: &report.aa,
            figures: report.calibration.figures(),
            opacity: chart(&report.calibration),
            formula: report.formula(),
            residual: format!("{:.4}", report.calibration.residual()),
            picture: data_uri(picture_png),
        },
    )
}

/// Over the wanted opacity. The correction is drawn as the curve that it is.
fn chart(calibration: &Calibration) -> Chart {
    const STEPS: u32 = 50;
    let curve = (0..=STEPS).map(|step| step as f32 / STEPS as f32);
    let curve = curve.map(|wanted| [wanted, calibration.correction.coverage(wanted)].map(f64::from));
    let measured = |level: &Level| [level.wanted, level.measured];
    let plot = Plot {
        description: "Opacity measured and coverage to feed over the opacity that is wanted".to_owned(),
        x: Axis::new("opacity wanted").with_zero(),
        y: Axis::new("opacity").with_zero(),
        series: vec![
            Series::guide("wanted", [[0.0, 0.0], [1.0, 1.0]]),
            Series::line("measured", calibration.levels.iter().map(measured)).with_dots(),
            Series::line("corrected", curve),
        ],
    };
    plot.into()
}

#[cfg(test)]
mod tests {
    use sheer_core::coverage::Correction;

    use super::{
        super::tests::{assert_sound, run_of},
        *,
    };

    #[test]
    fn the_page_needs_nothing_but_itself_and_names_the_correction() {
        let level = |number: usize| {
            let wanted = number as f64 / 10.0;
            Level { number, wanted, fed: wanted, measured: 0.9 * wanted, corrected: wanted }
        };
        let report = |method: &str| Report {
            run: run_of("calibration"),
            method: method.to_owned(),
            aa: "taa".to_owned(),
            calibration: Calibration { levels: (1..=10).map(level).collect(), correction: Correction::DLSS },
        };
        assert_sound(|method| text(&report(method), b"png").unwrap());
        let page = text(&report("std"), b"png").unwrap();
        assert!(page.contains("0.0113 + 1.6560 a"), "no coefficients");
    }
}

//! A chart with two logarithmic axes, as SVG.

use std::fmt::Write as _;

/// A name and the points it stands for, all of them positive.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<[f64; 2]>,
}

/// What makes a file of markup an SVG picture.
const NAMESPACE: &str = "http://www.w3.org/2000/svg";
const SIZE: [f64; 2] = [700.0, 400.0];
/// Left, right, top, bottom: room for labels.
const MARGINS: [f64; 4] = [60.0, 190.0, 15.0, 45.0];
/// Okabe and Ito's colours, which colour-blind readers tell apart.
const COLOURS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9"];

/// The chart of some lines: milliseconds by number of particles, with grid lines at powers of ten.
pub(crate) fn log_log(lines: &[Line]) -> String {
    let decades = |axis: usize| {
        let logarithms = lines.iter().flat_map(|line| &line.points).map(|point| point[axis].log10());
        let (low, high) =
            logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), l| (low.min(l), high.max(l)));
        // A single point has a decade around it.
        (low.floor(), high.ceil().max(low.floor() + 1.0))
    };
    let [left, right, top, bottom] = MARGINS;
    let ((x_low, x_high), (y_low, y_high)) = (decades(0), decades(1));
    let x_at = |l: f64| left + (l - x_low) / (x_high - x_low) * (SIZE[0] - left - right);
    let y_at = |l: f64| SIZE[1] - bottom - (l - y_low) / (y_high - y_low) * (SIZE[1] - top - bottom);
    let place = |[x, y]: [f64; 2]| [x_at(x.log10()), y_at(y.log10())];

    let mut svg = format!(
        "<svg xmlns=\"{NAMESPACE}\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        SIZE[0], SIZE[1]
    );
    let mut add = |element: String| writeln!(svg, "{element}").expect("writing to a string never fails");
    let grid = |x1: f64, y1: f64, x2: f64, y2: f64| {
        format!("<path d=\"M{x1:.1} {y1:.1} L{x2:.1} {y2:.1}\" stroke=\"#ddd\"/>")
    };
    let label = |x: f64, y: f64, anchor: &str, text: &str| {
        format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"#333\">{text}</text>")
    };
    for decade in x_low as i32..=x_high as i32 {
        let x = x_at(f64::from(decade));
        add(grid(x, top, x, SIZE[1] - bottom));
        add(label(x, SIZE[1] - bottom + 16.0, "middle", &power(decade)));
    }
    for decade in y_low as i32..=y_high as i32 {
        let y = y_at(f64::from(decade));
        add(grid(left, y, SIZE[0] - right, y));
        add(label(left - 6.0, y + 4.0, "end", &power(decade)));
    }
    add(label(0.5 * (left + SIZE[0] - right), SIZE[1] - 8.0, "middle", "particles"));
    let (x, y) = (16.0, 0.5 * (top + SIZE[1] - bottom));
    add(format!(
        "<text transform=\"translate({x} {y}) rotate(-90)\" text-anchor=\"middle\" fill=\"#333\">ms a frame</text>"
    ));
    for (line, colour) in lines.iter().zip(COLOURS.iter().cycle()) {
        let places: Vec<[f64; 2]> = line.points.iter().map(|&point| place(point)).collect();
        let path: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        add(format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            path.join(" ")
        ));
        for [x, y] in &places {
            add(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>"));
        }
        if let Some([x, y]) = places.last() {
            add(format!(
                "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{}</text>",
                x + 8.0,
                y + 4.0,
                line.name
            ));
        }
    }
    svg + "</svg>\n"
}

/// `1000`, `0.01`.
fn power(decade: i32) -> String {
    if decade < 0 {
        format!("{:.*}", decade.unsigned_abs() as usize, 10_f64.powi(decade))
    } else {
        format!("{:.0}", 10_f64.powi(decade))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_a_decade_apart_are_as_far_apart_as_grid_lines() {
        let line = Line { name: "std".to_owned(), points: vec![[1e3, 1.0], [1e4, 10.0], [1e5, 100.0]] };
        let svg = log_log(&[line]);
        // Two decades over 450 and 340 units.
        assert!(svg.contains("points=\"60.0,355.0 285.0,185.0 510.0,15.0\""), "{svg}");
        assert!(svg.contains(">100000</text>") && svg.contains(">std</text>"));
    }

    #[test]
    fn powers_of_ten_are_written_out() {
        assert_eq!([power(-2), power(0), power(3)], ["0.01", "1", "1000"]);
    }
}

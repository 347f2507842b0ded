//! Charts of lines and dots: where things go. The pages draw them.

use serde::Serialize;
use sheer_lab::{
    number,
    plot::{Axis, Mark, Plot, Series},
};

/// Width of a character of a name, in the units of the drawings, in which text is 12 high: generous, as fonts
/// differ.
const CHARACTER: f64 = 7.5;
/// Names closer than this to one another would overlap.
const LINE_HEIGHT: f64 = 16.0;
/// Around the plot: left for the numbers, above for the title of the vertical axis, below for the numbers and
/// title of the other.
const LEFT: f64 = 46.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 44.0;
/// Right of the plot: room for half a number where no names stand, and most room for names.
const RIGHT: f64 = 18.0;
const MOST_RIGHT: f64 = 260.0;
/// From the end of a line or the middle of a dot to its name.
const GAP: f64 = 10.0;

/// A plot, laid out for wide and for narrow pages.
#[derive(Debug, Serialize)]
pub(crate) struct Chart {
    description: String,
    x_title: String,
    y_title: String,
    wide: Drawing,
    narrow: Drawing,
    /// Names that the narrow drawing has no room for.
    legend: Vec<Key>,
}

#[derive(Debug, Serialize)]
struct Key {
    name: String,
    style: String,
}

#[derive(Debug, Serialize)]
struct Drawing {
    size: [f64; 2],
    /// Left, top, right and bottom of the plot.
    plot: [f64; 4],
    x_ticks: Vec<Tick>,
    y_ticks: Vec<Tick>,
    series: Vec<Drawn>,
}

#[derive(Debug, Serialize)]
struct Tick {
    at: f64,
    label: String,
}

#[derive(Debug, Serialize)]
struct Drawn {
    style: String,
    bands: Vec<String>,
    lines: Vec<String>,
    dots: Vec<Dot>,
    label: Option<Label>,
}

#[derive(Debug, Serialize)]
struct Dot {
    at: [f64; 2],
    title: String,
}

#[derive(Debug, Serialize)]
struct Label {
    at: [f64; 2],
    anchor: &'static str,
    text: String,
}

impl From<Plot> for Chart {
    fn from(plot: Plot) -> Self {
        let named = plot.series.iter().enumerate().filter(|(_, series)| series.mark != Mark::Dots);
        Self {
            wide: Drawing::new(&plot, Layout { size: [960.0, 320.0], names_lines: true, most_ticks: 8.0 }),
            narrow: Drawing::new(&plot, Layout { size: [360.0, 280.0], names_lines: false, most_ticks: 5.0 }),
            legend: named
                .map(|(at, series)| Key { name: series.name.clone(), style: style(at, series) })
                .collect(),
            description: plot.description,
            x_title: plot.x.title,
            y_title: plot.y.title,
        }
    }
}

/// How a series looks: there are eight colours, and the next eight are dashed.
fn style(at: usize, series: &Series) -> String {
    if series.mark == Mark::Guide {
        return "guide".to_owned();
    }
    format!("series-{}{}", at % 8, if at % 16 >= 8 { " dashed" } else { "" })
}

/// What the two drawings of a plot differ in.
#[derive(Clone, Copy)]
struct Layout {
    size: [f64; 2],
    names_lines: bool,
    /// On the horizontal axis.
    most_ticks: f64,
}

impl Drawing {
    fn new(plot: &Plot, layout: Layout) -> Self {
        let named = plot.series.iter().filter(|series| layout.names_lines && series.mark != Mark::Dots);
        let longest = named.clone().map(|series| series.name.chars().count()).max();
        let right = longest.map_or(RIGHT, |longest| (longest as f64 * CHARACTER + GAP).min(MOST_RIGHT));
        // All names have to find room beside the plot.
        let height = layout.size[1].max(TOP + BOTTOM + named.count() as f64 * LINE_HEIGHT);
        let size = [layout.size[0], height];
        let area = [LEFT, TOP, size[0] - right, height - BOTTOM];

        let shown = |point: &[f64; 2]| plot.x.has(point[0]) && plot.y.has(point[1]);
        let points = || {
            let lines = plot.series.iter().flat_map(|series| &series.points).copied();
            let bands = plot.series.iter().flat_map(|series| &series.band);
            lines.chain(bands.flat_map(|&[x, low, high]| [[x, low], [x, high]])).filter(shown)
        };
        // Lines may touch both ends of the plot, dots may not.
        let is_tight = plot.series.iter().all(|series| series.mark != Mark::Dots);
        let x =
            Scale::new(&plot.x, points().map(|[x, _]| x), layout.most_ticks, is_tight, [area[0], area[2]]);
        let y = Scale::new(&plot.y, points().map(|[_, y]| y), 6.0, false, [area[3], area[1]]);
        let mut series: Vec<Drawn> = plot
            .series
            .iter()
            .enumerate()
            .map(|(at, series)| Drawn {
                style: style(at, series),
                bands: bands(series, plot, &x, &y),
                lines: lines(series, plot, &x, &y),
                dots: dots(series, plot, &x, &y),
                label: None,
            })
            .collect();
        if layout.names_lines {
            name_lines(&plot.series, &mut series, &y, area);
        }
        name_dots(&plot.series, &mut series, area);
        Self { size, plot: area, x_ticks: x.ticks(), y_ticks: y.ticks(), series }
    }
}

/// From values to positions.
#[derive(Debug)]
struct Scale {
    is_logarithmic: bool,
    /// Ends of the axis, as logarithms where it is logarithmic.
    values: [f64; 2],
    positions: [f64; 2],
    ticks: Vec<f64>,
    decimals: usize,
}

impl Scale {
    fn new(
        axis: &Axis,
        values: impl Iterator<Item = f64>,
        most_ticks: f64,
        is_tight: bool,
        positions: [f64; 2],
    ) -> Self {
        let ends = values
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        let [low, high] = if ends[0] <= ends[1] { ends } else { [1.0, 1.0] };
        if axis.is_logarithmic {
            Self::logarithmic([low, high], most_ticks, is_tight, positions)
        } else {
            let low = if axis.begins_at_zero { low.min(0.0) } else { low };
            let least_step = if axis.counts { 1.0 } else { 0.0 };
            Self::linear([low, high], least_step, most_ticks, is_tight, positions)
        }
    }

    fn linear(
        [low, high]: [f64; 2],
        least_step: f64,
        most_ticks: f64,
        is_tight: bool,
        positions: [f64; 2],
    ) -> Self {
        let step = round_step((high - low) / (most_ticks - 1.0)).max(least_step);
        // A little less than a step beyond the last value, so that rounding adds none.
        let (mut first, mut last) = ((low / step + 1e-9).floor(), (high / step - 1e-9).ceil());
        if is_tight {
            (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
        } else if last <= first {
            last = first + 1.0;
        }
        let values = if is_tight { [low, high] } else { [first * step, last * step] };
        let ticks =
            (0..=(last - first).max(0.0) as u32).map(|count| (first + f64::from(count)) * step).collect();
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        Self { is_logarithmic: false, values, positions, ticks, decimals }
    }

    /// Ticks at 1, 2 and 5 times powers of ten, or at powers of ten or a hundred if these are too many; at
    /// equal steps within one power.
    fn logarithmic([low, high]: [f64; 2], most_ticks: f64, is_tight: bool, positions: [f64; 2]) -> Self {
        /// Share of the axis that stays clear at either end, and the least ratio of its ends.
        const CLEAR: f64 = 0.1;
        const LEAST_RATIO: f64 = 1.2;
        /// Below this ratio, powers of ten are too far apart.
        const CLOSE: f64 = 5.0;

        let widening = (LEAST_RATIO * low / high).max(1.0).sqrt();
        let clear = if is_tight { 1.0 } else { (high / low * widening * widening).powf(CLEAR) };
        let [low, high] = [low / widening / clear, high * widening * clear];
        let ends = [low, high].map(f64::log10);
        let is_inside = |tick: &f64| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(tick);
        if high / low < CLOSE {
            let step = round_step((high - low) / (most_ticks - 1.0));
            let ticks = (0..=(high / step) as u32).map(|count| f64::from(count) * step).filter(is_inside);
            return Self {
                is_logarithmic: true,
                values: ends,
                positions,
                ticks: ticks.collect(),
                decimals: 0,
            };
        }
        let powers = (ends[0].floor() as i32, ends[1].ceil() as i32);
        let choices: [(&[f64], usize); 5] =
            [(&[1.0, 2.0, 5.0], 1), (&[1.0], 1), (&[1.0], 2), (&[1.0], 5), (&[1.0], 20)];
        let choices = choices.map(|(factors, every)| {
            let powers = (powers.0..=powers.1).filter(|power| power.rem_euclid(every as i32) == 0);
            let ticks =
                powers.flat_map(|power| factors.iter().map(move |factor| factor * 10_f64.powi(power)));
            ticks.filter(is_inside).collect::<Vec<f64>>()
        });
        let is_few = |ticks: &&Vec<f64>| ticks.len() as f64 <= most_ticks;
        let ticks = choices.iter().find(is_few).unwrap_or(&choices[choices.len() - 1]).clone();
        Self { is_logarithmic: true, values: ends, positions, ticks, decimals: 0 }
    }

    fn position(&self, value: f64) -> f64 {
        let value = if self.is_logarithmic { value.log10() } else { value };
        let span = self.values[1] - self.values[0];
        let share = if span > 0.0 { (value - self.values[0]) / span } else { 0.0 };
        self.positions[0] + share * (self.positions[1] - self.positions[0])
    }

    fn ticks(&self) -> Vec<Tick> {
        self.ticks.iter().map(|&value| Tick { at: self.position(value), label: self.label(value) }).collect()
    }

    fn label(&self, value: f64) -> String {
        /// Numbers longer than this would not fit beside the plot.
        const LONGEST: f64 = 1e6;
        match value.abs() {
            size if size >= LONGEST => format!("{value:e}"),
            // Powers of ten and their multiples are short as they are.
            _ if self.is_logarithmic => format!("{}", (value * 1e9).round() / 1e9),
            _ => number(value, self.decimals),
        }
    }
}

/// 1, 2 or 5 times a power of ten, at least `wanted`.
fn round_step(wanted: f64) -> f64 {
    if wanted <= 0.0 {
        return 1.0;
    }
    let power = 10_f64.powf(wanted.log10().floor());
    // The factor is computed: of equal steps, rounding must not choose the next.
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= wanted * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// Runs of points that can be shown.
fn runs<const N: usize>(points: &[[f64; N]], shown: impl Fn(&[f64; N]) -> bool) -> Vec<&[[f64; N]]> {
    points.split(|point| !shown(point)).filter(|run| !run.is_empty()).collect()
}

fn coordinates(points: impl Iterator<Item = [f64; 2]>) -> String {
    points.map(|[x, y]| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

fn lines(series: &Series, plot: &Plot, x: &Scale, y: &Scale) -> Vec<String> {
    if series.mark == Mark::Dots {
        return Vec::new();
    }
    let runs = runs(&series.points, |point| plot.x.has(point[0]) && plot.y.has(point[1]));
    runs.iter()
        .map(|run| coordinates(run.iter().map(|point| [x.position(point[0]), y.position(point[1])])))
        .collect()
}

fn bands(series: &Series, plot: &Plot, x: &Scale, y: &Scale) -> Vec<String> {
    let shown = |&[at, low, high]: &[f64; 3]| plot.x.has(at) && plot.y.has(low) && plot.y.has(high);
    let outline = |run: &&[[f64; 3]]| {
        let above = run.iter().map(|&[at, _, high]| [x.position(at), y.position(high)]);
        let below = run.iter().rev().map(|&[at, low, _]| [x.position(at), y.position(low)]);
        coordinates(above.chain(below))
    };
    runs(&series.band, shown).iter().map(outline).collect()
}

/// Dots themselves, or the end of a line.
fn dots(series: &Series, plot: &Plot, x: &Scale, y: &Scale) -> Vec<Dot> {
    let mut shown = series.points.iter().filter(|point| plot.x.has(point[0]) && plot.y.has(point[1]));
    let dot = |point: &[f64; 2]| {
        let [x_text, y_text] = [point[0], point[1]].map(significant);
        let title = format!("{}: {x_text} {}, {y_text} {}", series.name, plot.x.title, plot.y.title);
        Dot { at: [x.position(point[0]), y.position(point[1])], title }
    };
    match series.mark {
        Mark::Dots => shown.map(dot).collect(),
        Mark::Line if series.marks_points => shown.map(dot).collect(),
        Mark::Line => shown.next_back().map(dot).into_iter().collect(),
        Mark::Guide => Vec::new(),
    }
}

/// With four digits or all before the point.
fn significant(value: f64) -> String {
    let digits = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    number(value, (3.0 - digits).clamp(0.0, 9.0) as usize)
}

/// Puts the names of lines right of the plot, at the height of their ends, moved apart.
fn name_lines(series: &[Series], drawn: &mut [Drawn], y: &Scale, area: [f64; 4]) {
    let mut ends: Vec<(usize, f64)> = series
        .iter()
        .enumerate()
        .filter(|(at, series)| series.mark != Mark::Dots && !drawn[*at].lines.is_empty())
        .map(|(at, series)| {
            let mut positions = series.points.iter().map(|point| y.position(point[1]));
            (at, positions.rfind(|position| position.is_finite()).unwrap_or(area[3]))
        })
        .collect();
    // From the lowest; of equals the first is above.
    ends.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.0.cmp(&a.0)));
    let mut limit = area[3];
    for (_, position) in &mut ends {
        *position = position.min(limit);
        limit = *position - LINE_HEIGHT;
    }
    // Those that have been moved out of the plot come back and move the ones below.
    let mut limit = area[1];
    for (at, position) in ends.into_iter().rev() {
        let position = position.max(limit);
        limit = position + LINE_HEIGHT;
        let text = series[at].name.clone();
        drawn[at].label = Some(Label { at: [area[2] + GAP, position], anchor: "start", text });
    }
}

/// Puts names beside dots, where they cover the fewest other names and dots.
fn name_dots(series: &[Series], drawn: &mut [Drawn], area: [f64; 4]) {
    /// Half the space that a dot takes.
    const DOT: f64 = 5.0;
    let mut taken: Vec<[f64; 4]> = (drawn.iter().flat_map(|drawn| &drawn.dots))
        .map(|&Dot { at: [x, y], .. }| [x - DOT, y - DOT, x + DOT, y + DOT])
        .collect();
    for (series, drawn) in series.iter().zip(drawn) {
        let Some(&Dot { at: [x, y], .. }) = drawn.dots.last().filter(|_| series.mark == Mark::Dots) else {
            continue;
        };
        let width = series.name.chars().count() as f64 * CHARACTER;
        let half = 0.5 * LINE_HEIGHT;
        // Right, left, above and below, then further above and below.
        let positions = [
            ([x + GAP, y], "start", 0.0),
            ([x - GAP, y], "end", -width),
            ([x, y - LINE_HEIGHT], "middle", -0.5 * width),
            ([x, y + LINE_HEIGHT], "middle", -0.5 * width),
            ([x + GAP, y - LINE_HEIGHT], "start", 0.0),
            ([x + GAP, y + LINE_HEIGHT], "start", 0.0),
            ([x - GAP, y - LINE_HEIGHT], "end", -width),
            ([x - GAP, y + LINE_HEIGHT], "end", -width),
            ([x, y - 2.0 * LINE_HEIGHT], "middle", -0.5 * width),
            ([x, y + 2.0 * LINE_HEIGHT], "middle", -0.5 * width),
        ];
        let boxes = positions.map(|(at, anchor, shift)| {
            let left = at[0] + shift;
            let space = [left, at[1] - half, left + width, at[1] + half];
            let outside =
                space[0] < area[0] || space[2] > area[2] || space[1] < area[1] || space[3] > area[3];
            let hidden: f64 = taken.iter().map(|other| overlap(space, *other)).sum();
            (hidden + if outside { width * LINE_HEIGHT } else { 0.0 }, at, anchor, space)
        });
        let [first, ..] = boxes;
        // Of equals the first.
        let best = boxes.into_iter().fold(first, |best, next| if next.0 < best.0 { next } else { best });
        taken.push(best.3);
        drawn.label = Some(Label { at: best.1, anchor: best.2, text: series.name.clone() });
    }
}

/// Area that two boxes (left, top, right, bottom) share.
fn overlap(a: [f64; 4], b: [f64; 4]) -> f64 {
    let side = |axis: usize| (a[axis + 2].min(b[axis + 2]) - a[axis].max(b[axis])).max(0.0);
    side(0) * side(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(x: Axis, y: Axis, series: Vec<Series>) -> Chart {
        Plot { description: String::new(), x, y, series }.into()
    }

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn steps_are_round_and_large_enough() {
        assert_eq!(
            [0.0, 0.9, 1.0, 1.1, 23.0, 0.03, 70.0].map(round_step),
            [1.0, 1.0, 1.0, 2.0, 50.0, 0.05, 100.0]
        );
    }

    #[test]
    fn a_linear_axis_has_round_numbers_around_its_values() {
        let line = || vec![Series::line("a", [[0.0, 0.93], [9.0, 0.991]])];
        let zoomed = chart(Axis::new("frame").of_counts(), Axis::new("SSIM"), line());
        assert_eq!(labels(&zoomed.wide.y_ticks), ["0.92", "0.94", "0.96", "0.98", "1.00"]);
        assert_eq!(labels(&zoomed.wide.x_ticks), ["0", "2", "4", "6", "8"]);
        let whole = chart(Axis::new("frame"), Axis::new("SSIM").with_zero(), line());
        assert_eq!(labels(&whole.wide.y_ticks).first(), Some(&"0.0"));
        let ys: Vec<f64> = zoomed.wide.y_ticks.iter().map(|tick| tick.at).collect();
        assert!(ys.is_sorted_by(|a, b| a > b), "upwards is not more: {ys:?}");
    }

    #[test]
    fn a_logarithmic_axis_gives_equal_ratios_equal_space() {
        let drawing = |points: &[[f64; 2]]| {
            let dots = vec![Series::dots("a", points.iter().copied())];
            chart(Axis::new("ms").logarithmic(), Axis::new("SSIM"), dots).wide
        };
        let wide = drawing(&[[10.0, 1.0], [1000.0, 1.0], [0.0, 1.0]]);
        assert_eq!(labels(&wide.x_ticks), ["10", "20", "50", "100", "200", "500", "1000"]);
        let at: Vec<f64> = wide.x_ticks.iter().map(|tick| tick.at).collect();
        assert!(((at[3] - at[0]) - (at[6] - at[3])).abs() < 1e-9);
        assert!(at[0] > wide.plot[0] && at[6] < wide.plot[2], "a dot touches the end");
        assert_eq!(wide.series[0].dots.len(), 2, "0 has a position");
        let wider = drawing(&[[0.003, 1.0], [4e7, 1.0]]);
        assert_eq!(labels(&wider.x_ticks), ["0.01", "1", "100", "10000", "1e6", "1e8"]);
        // Within a power of ten.
        let close = drawing(&[[165.0, 1.0], [190.0, 1.0]]);
        assert_eq!(labels(&close.x_ticks), ["160", "170", "180", "190"]);
        assert!(labels(&drawing(&[[170.0, 1.0]]).x_ticks).len() >= 2);
    }

    #[test]
    fn names_of_close_lines_do_not_overlap() {
        let names: Vec<String> = (0..30).map(|at| format!("method {at}")).collect();
        let series = names.iter().map(|name| Series::line(name, [[0.0, 5.0], [1.0, 1.0]])).collect();
        let drawing = chart(Axis::new("frame"), Axis::new("ms").with_zero(), series).wide;
        let labels = drawing.series.iter().map(|series| series.label.as_ref().unwrap().at[1]);
        let mut ys: Vec<f64> = labels.collect();
        ys.sort_by(f64::total_cmp);
        assert!(ys.windows(2).all(|pair| pair[1] - pair[0] >= LINE_HEIGHT - 1e-9), "{ys:?}");
        assert!(ys[0] >= drawing.plot[1] && ys[29] <= drawing.plot[3], "{ys:?}");
        let styles: std::collections::HashSet<_> =
            drawing.series.iter().map(|series| &series.style).collect();
        assert_eq!(styles.len(), 16);
    }

    #[test]
    fn names_of_close_dots_do_not_overlap() {
        let series = [("roulette", 168.0), ("std", 170.0), ("stbn", 172.0), ("dtaa", 173.0)];
        let series = series.map(|(name, ms)| Series::dots(name, [[ms, 0.95]]));
        let drawing = chart(Axis::new("ms").logarithmic(), Axis::new("SSIM"), series.into()).narrow;
        let space = |label: &Label| {
            let width = label.text.len() as f64 * CHARACTER;
            let shift = match label.anchor {
                "start" => 0.0,
                "end" => -width,
                _ => -0.5 * width,
            };
            let left = label.at[0] + shift;
            [left, label.at[1] - 6.0, left + width, label.at[1] + 6.0]
        };
        let spaces: Vec<_> =
            drawing.series.iter().map(|series| space(series.label.as_ref().unwrap())).collect();
        for (at, a) in spaces.iter().enumerate() {
            for b in &spaces[..at] {
                assert_eq!(overlap(*a, *b), 0.0, "{a:?} {b:?}");
            }
        }
        assert_eq!(overlap([0.0, 0.0, 2.0, 2.0], [1.0, 1.0, 3.0, 4.0]), 1.0, "the check is blind");
    }

    #[test]
    fn a_line_is_broken_where_it_has_no_value_and_bands_go_there_and_back() {
        let line = Series::line("a", [[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0], [3.0, 2.0]]);
        let line = line.with_band([[0.0, 0.5, 1.5], [2.0, 2.0, 4.0], [3.0, f64::INFINITY, 1.0]]);
        let drawing = chart(Axis::new("x"), Axis::new("y"), vec![line]).wide;
        assert_eq!(drawing.series[0].lines.len(), 2);
        let [band] = &drawing.series[0].bands[..] else { panic!("{:?}", drawing.series[0].bands) };
        assert_eq!(band.split(' ').count(), 4);
        // The band has its position in the plot.
        assert_eq!(labels(&drawing.y_ticks), ["0", "1", "2", "3", "4"]);
    }

    #[test]
    fn few_values_or_none_have_a_place() {
        for points in [vec![], vec![[7.0, 3.0]], vec![[7.0, 0.0]], vec![[f64::NAN, f64::INFINITY]]] {
            for x in [Axis::new("x"), Axis::new("x").of_counts(), Axis::new("x").logarithmic()] {
                let series = vec![Series::line("a", points.clone()), Series::dots("b", points.clone())];
                let chart = chart(x, Axis::new("y").with_zero(), series);
                for drawing in [&chart.wide, &chart.narrow] {
                    let ticks = drawing.x_ticks.iter().chain(&drawing.y_ticks);
                    assert!(ticks.clone().count() >= 2 && ticks.clone().all(|tick| tick.at.is_finite()));
                    let mut dots = drawing.series.iter().flat_map(|series| &series.dots);
                    assert!(dots.all(|dot| dot.at.iter().all(|at| at.is_finite())));
                }
            }
        }
    }
}

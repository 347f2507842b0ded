//! The pages of `compare`, `bench`, `calibrate` and `experiments`, looked at in a browser without a window.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{
    fs,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use tempfile::TempDir;

use self::browser::Visit;
use crate::run::succeed;

mod browser;

/// The pages, made once for all tests.
struct Pages {
    folder: TempDir,
}

impl Pages {
    fn get() -> &'static Self {
        static PAGES: OnceLock<Pages> = OnceLock::new();
        PAGES.get_or_init(|| {
            let folder = tempfile::tempdir().unwrap();
            let methods = "-m roulette -m std -m std:hash=mcguire --size 64x36 --frames 4 --quiet";
            succeed(folder.path(), &format!("compare layers {methods} -a taa -o compare"));
            succeed(folder.path(), &format!("bench layers {methods} --html bench.html"));
            succeed(
                folder.path(),
                "calibrate -m roulette -a accumulate --size 320x180 --frames 4 --quiet --html calibrate.html",
            );
            succeed(
                folder.path(),
                "experiments sequences visibility moving-pane --size 64x36 --quiet -o experiments",
            );
            Self { folder }
        })
    }

    fn comparison() -> PathBuf {
        Self::get().folder.path().join("compare/index.html")
    }

    fn all() -> [PathBuf; 4] {
        let file = |name| Self::get().folder.path().join(name);
        [Self::comparison(), file("bench.html"), file("calibrate.html"), file("experiments/index.html")]
    }
}

/// A page without its script.
fn without_script(page: &str) -> String {
    let (before, rest) = page.split_once("<script>").unwrap();
    format!("{before}{}", rest.split_once("</script>").unwrap().1)
}

/// Cuts of the two pictures, place of the divider, value of the slider.
fn split(visit: &Visit) -> [String; 4] {
    visit.evaluate(
        "[document.getElementById('left-half').style.clipPath, document.getElementById('right-half').style.clipPath, \
         document.getElementById('divider').style.left, document.getElementById('split').value]",
    )
}

/// Whether dragging in the picture moves the cut of both sides, divider and slider to where the mouse is.
fn divider_follows(visit: &Visit) -> bool {
    let place = |share| visit.place("document.getElementById('pane')", share);
    let before = split(visit);
    visit.drag(place(0.5), place(0.25));
    let after = split(visit);
    let number = |text: &str| {
        let digits: String = text.chars().filter(|c| c.is_ascii_digit() || *c == '.').collect();
        digits.parse::<f64>().unwrap_or(f64::NAN)
    };
    let is_quarter = |text: &str| (number(text) - 25.0).abs() < 1.0;
    before != after
        && is_quarter(&after[2])
        && is_quarter(&after[3])
        && after[0].contains("75%")
        && after[1].contains("25%")
}

#[test]
fn the_divider_follows_mouse_and_slider() {
    let visit = Visit::to(&Pages::comparison());
    assert!(divider_follows(&visit), "{:?}", split(&visit));
    let place = |share| visit.place("document.getElementById('split')", share);
    visit.drag(place(0.5), place(0.8));
    let after = split(&visit);
    let value: f64 = after[3].parse().unwrap();
    assert!((value - 80.0).abs() < 3.0, "{after:?}");
    assert_eq!(after[2], format!("{value}%"));
}

#[test]
fn a_page_without_its_script_has_no_viewer() {
    let visit = Visit::to_changed(&Pages::comparison(), without_script);
    assert!(visit.evaluate::<bool>("document.getElementById('viewer').hidden"));
    // Even if it were seen.
    let visit = Visit::to_changed(&Pages::comparison(), |page| {
        without_script(page).replace("aria-label=\"Picture viewer\" hidden", "")
    });
    assert!(!divider_follows(&visit), "the check takes a divider that does not move");
}

/// Transforms of the two pictures, and the zoom that is shown.
fn zoom(visit: &Visit) -> [String; 3] {
    visit.evaluate(
        "[getComputedStyle(document.getElementById('left-image')).transform, \
         getComputedStyle(document.getElementById('right-image')).transform, document.getElementById('zoom-level').textContent]",
    )
}

/// Whether both sides have the same zoom and place after zooming in, after moving about and after choosing
/// another method.
fn zoom_stays_in_step(visit: &Visit) -> bool {
    let mut seen = vec![zoom(visit)];
    visit.click("document.getElementById('zoom-in')");
    visit.click("document.getElementById('zoom-in')");
    seen.push(zoom(visit));
    let place = |share| visit.place("document.getElementById('pane')", share);
    visit.drag(place(0.2), place(0.4));
    seen.push(zoom(visit));
    let moves = seen.windows(2).all(|pair| pair[0] != pair[1]);
    visit.evaluate::<bool>(
        "(() => { const s = document.getElementById('left'); s.value = '1'; return s.dispatchEvent(new Event('change')); })()",
    );
    let stays = zoom(visit) == seen[2];
    moves && stays && seen[2][2] == "4×" && seen.iter().all(|[left, right, _]| left == right)
}

#[test]
fn zoom_stays_in_step_on_both_sides_and_across_methods() {
    let visit = Visit::to(&Pages::comparison());
    assert!(zoom_stays_in_step(&visit), "{:?}", zoom(&visit));
    // Scrolling keeps the point under the mouse.
    visit.click("document.getElementById('zoom-fit')");
    assert_eq!(zoom(&visit)[2], "1×");
    let [left, right]: [f64; 2] = visit.evaluate(
        "(() => { const p = document.getElementById('pane'), b = p.getBoundingClientRect(); \
         p.dispatchEvent(new WheelEvent('wheel', { deltaY: -500, clientX: b.left + b.width / 4, clientY: b.top, cancelable: true })); \
         const i = document.getElementById('left-image').getBoundingClientRect(); \
         return [(b.left + b.width / 4 - i.left) / i.width, 0.25]; })()",
    );
    assert!((left - right).abs() < 1e-3 && zoom(&visit)[2] != "1×", "{left}");

    let one_sided = Visit::to_changed(&Pages::comparison(), |page| {
        page.replace("for (const { image } of sides)", "for (const { image } of sides.slice(0, 1))")
    });
    assert!(!zoom_stays_in_step(&one_sided), "the check takes a zoom of one side only");
}

#[test]
fn error_maps_take_the_place_of_the_pictures_and_back() {
    let visit = Visit::to(&Pages::comparison());
    let sources = || -> [String; 3] {
        visit.evaluate(
            "[document.getElementById('left-image').src, document.getElementById('left-tag').textContent, \
             String(document.getElementById('legend').hidden)]",
        )
    };
    let pictures = sources();
    visit.click("document.getElementById('show-error')");
    let errors = sources();
    let error_map: String = visit.evaluate("[...document.querySelectorAll('img.error')].at(-1).src");
    assert_eq!(errors, [error_map, "std:hash=mcguire: error".to_owned(), "false".to_owned()]);
    assert_ne!(errors[0], pictures[0]);
    // The exact picture, on the right, has no error.
    assert!(visit.evaluate::<bool>("document.getElementById('right-image').hidden"));
    visit.click("document.getElementById('show-picture')");
    assert_eq!(sources(), pictures);
    assert_eq!(pictures[2], "true");
}

/// Texts of a column, by the place of its heading among those of all tables.
fn column(visit: &Visit, at: usize) -> Vec<String> {
    visit.evaluate(&format!(
        "(() => {{ const heading = document.querySelectorAll('table.sortable th[scope=col]')[{at}]; \
         const rows = heading.closest('table').tBodies[0].rows; \
         return [...rows].map((row) => row.cells[heading.cellIndex].textContent); }})()"
    ))
}

/// Whether each heading sorts the rows one way and then the other, figures as numbers and missing ones last.
fn every_heading_sorts(visit: &Visit) -> Result<(), String> {
    let headings: Vec<String> = visit.evaluate(
        "[...document.querySelectorAll('table.sortable th[scope=col]')].map((heading) => heading.textContent)",
    );
    let numbers = |at| -> Vec<f64> {
        let texts = column(visit, at);
        texts.iter().filter(|text| *text != "–").map(|text| text.parse().unwrap()).collect()
    };
    for (at, heading) in headings.iter().enumerate() {
        let names_rows: bool = visit.evaluate(&format!(
            "document.querySelectorAll('table.sortable th[scope=col]')[{at}].cellIndex === 0"
        ));
        for ascending in [true, false] {
            visit.click(&format!("document.querySelectorAll('table.sortable th[scope=col] button')[{at}]"));
            let texts = column(visit, at);
            let is_sorted = match (names_rows, ascending) {
                (true, true) => texts.is_sorted(),
                (true, false) => texts.iter().rev().is_sorted(),
                (false, true) => numbers(at).is_sorted(),
                (false, false) => numbers(at).iter().rev().is_sorted(),
            };
            let missing_last = !texts.iter().skip_while(|text| *text != "–").any(|text| text != "–");
            let says: String = visit.evaluate(&format!(
                "document.querySelectorAll('table.sortable th[scope=col]')[{at}].getAttribute('aria-sort') ?? 'no'"
            ));
            let word = if ascending { "ascending" } else { "descending" };
            if !is_sorted || !missing_last || says != word {
                return Err(format!("{heading} {word}: {texts:?}, said to be {says}"));
            }
        }
    }
    Ok(())
}

#[test]
fn every_heading_of_the_tables_sorts_both_ways() {
    for page in Pages::all() {
        let visit = Visit::to(&page);
        every_heading_sorts(&visit).unwrap_or_else(|problem| panic!("{}: {problem}", page.display()));
    }
    let as_text = Visit::to_changed(&Pages::comparison(), |page| page.replace("return x - y;", "return 0;"));
    assert!(every_heading_sorts(&as_text).is_err(), "the check takes a table that is not sorted");
}

#[test]
fn nothing_is_asked_of_the_network_and_nothing_goes_wrong() {
    for page in Pages::all() {
        let visit = Visit::to(&page);
        assert_eq!(visit.requests(), Vec::<String>::new(), "{}", page.display());
        assert_eq!(visit.complaints(), Vec::<String>::new(), "{}", page.display());
        let svgs: usize = visit.evaluate("document.querySelectorAll('.chart svg.wide polyline').length");
        assert!(svgs > 0, "{} has no chart", page.display());
    }
    let asking = Visit::to_changed(&Pages::comparison(), |page| {
        let open = page.replace("default-src 'none'; img-src data:", "img-src *");
        open.replace("</main>", "<img src=\"http://127.0.0.1:9/a.png\"></main><script>nonsense()</script>")
    });
    assert_eq!(asking.requests(), ["http://127.0.0.1:9/a.png"]);
    assert!(
        asking.complaints().iter().any(|complaint| complaint.contains("nonsense")),
        "{:?}",
        asking.complaints()
    );
}

/// Pixels that the page is wider than the window.
fn overflow(visit: &Visit) -> i32 {
    visit.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
}

#[test]
fn pages_fit_a_phone_and_a_desk() {
    for page in Pages::all() {
        let visit = Visit::to(&page);
        for width in [390, 700, 1280] {
            visit.set_width(width);
            assert_eq!(overflow(&visit), 0, "{} at {width}", page.display());
            let smallest: f64 = visit.evaluate(
                "Math.min(...[...document.querySelectorAll('.chart text')].filter((text) => text.getBoundingClientRect().width) \
                 .map((text) => 12 * text.getScreenCTM().a))",
            );
            assert!(smallest >= 10.0, "{} at {width}: text of a chart is {smallest} px high", page.display());
        }
    }
    let wide = Visit::to_changed(&Pages::comparison(), |page| {
        page.replace("</main>", "<p style=\"width: 500px\">wide</p></main>")
    });
    wide.set_width(390);
    assert!(overflow(&wide) > 0, "the check takes a page that is too wide");
}

/// The least contrast (WCAG 2) between the page and its words and lines, and the page's lightness.
fn contrast(visit: &Visit) -> [f64; 2] {
    visit.evaluate(
        "(() => { const light = (colour) => { const [r, g, b] = colour.match(/[\\d.]+/g).map((v) => v / 255) \
           .map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * r + 0.7152 * g + 0.0722 * b; }; \
         const paper = light(getComputedStyle(document.body).backgroundColor); \
         const inks = [...document.querySelectorAll('h1, p, td, th, dd, figcaption, th button, .chart g, .chart .tick')] \
           .map((e) => { const s = getComputedStyle(e); return light(e.matches('.tick') ? s.fill : s.color); }); \
         return [Math.min(...inks.map((ink) => (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05))), paper]; })()",
    )
}

#[test]
fn pages_can_be_read_dark_and_light() {
    // WCAG 2.2, criterion 1.4.3.
    const LEAST_CONTRAST: f64 = 4.5;
    for page in Pages::all() {
        let visit = Visit::to(&page);
        let [light, dark] = [false, true].map(|is_dark| {
            visit.set_dark(is_dark);
            contrast(&visit)
        });
        assert!(light[1] > 0.8 && dark[1] < 0.05, "{}: {light:?} {dark:?}", page.display());
        assert!(
            light[0] >= LEAST_CONTRAST && dark[0] >= LEAST_CONTRAST,
            "{}: {light:?} {dark:?}",
            page.display()
        );
    }
    let faint =
        Visit::to_changed(&Pages::comparison(), |page| page.replace("--ink: #1d1c1a", "--ink: #c0c0c0"));
    faint.set_dark(false);
    assert!(contrast(&faint)[0] < LEAST_CONTRAST, "the check takes grey on white");
}

#[test]
fn charts_have_a_point_and_a_name_for_each_method() {
    let visit = Visit::to(&Pages::comparison());
    let names = |selector: &str| -> Vec<String> {
        visit.evaluate(&format!(
            "[...document.querySelectorAll('{selector}')].map((text) => text.textContent)"
        ))
    };
    let methods = ["baseline", "roulette", "std", "std:hash=mcguire"];
    assert_eq!(names(".pair .chart:first-child svg.narrow g text"), methods);
    // The exact picture has no PSNR.
    assert_eq!(names(".pair .chart:last-child svg.narrow g text"), methods[1..]);
    assert_eq!(names("section > .chart svg.wide g text"), methods);
    let titles = names(".pair .chart:first-child svg.narrow circle title");
    assert!(
        titles.len() == 4 && titles[0].starts_with("baseline: ") && titles[0].contains("1.000 SSIM"),
        "{titles:?}"
    );
}

#[test]
fn a_calibration_page_names_its_correction() {
    let [_, _, page, _] = Pages::all();
    assert!(Path::new(&page).exists());
    let text = fs::read_to_string(page).unwrap();
    for word in ["measured", "corrected", "residual", "a^3", "data:image/png;base64,"] {
        assert!(text.contains(word), "{word}");
    }
}

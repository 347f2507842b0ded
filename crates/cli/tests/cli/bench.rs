//! `sheer bench`.

use std::fs;

use crate::run::{assert_numbers, json, names_in, sheer, succeed};

#[test]
fn a_report_has_the_names_and_types_of_its_contract() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "bench layers -m baseline -m std --size 32x18 --frames 3 --shadow fourier:terms=3";
    let outcome = succeed(folder.path(), &format!("{arguments} --json a.json"));
    let report = json(&fs::read_to_string(folder.path().join("a.json")).unwrap());
    assert_eq!((&report["scene"], &report["frames"]), (&"layers".into(), &3.into()));
    assert_eq!(report["shadow"], "fourier:resolution=1024,terms=3");
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert!(row["method"].is_string());
        assert_eq!(row["ms"].as_array().unwrap().len(), 3);
        assert!(row["ms"].as_array().unwrap().iter().all(serde_json::Value::is_number));
        assert_numbers(
            row,
            &[
                "ms_median",
                "build_ms_median",
                "rays",
                "shaded",
                "mray_per_s",
                "ms_spread",
                "ratio",
                "shadow_ms_median",
            ],
        );
    }
    assert_eq!(rows[0]["ratio"], 1.0);
    // Nine surfaces before one pixel are shaded by one method and one of them by the other.
    assert_eq!(rows[1]["shaded"], f64::from(32 * 18));
    assert_eq!(rows[0]["shaded"], f64::from(9 * 32 * 18));
    assert!(outcome.stdout.starts_with("method"));

    let stdout = succeed(folder.path(), &format!("{arguments} --json -")).stdout;
    assert!(json(&stdout)["rows"].is_array(), "the table is mixed with the figures");
}

#[test]
fn a_page_and_figures_are_written_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "bench layers -m baseline -m std --size 32x18 --frames 3 --json a.json --html a.html";
    let stdout = succeed(folder.path(), arguments).stdout;
    assert_eq!(names_in(folder.path()), ["a.html", "a.json"]);
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap().replace("&#x2f;", "/");
    // The figures of the table, in the same words.
    let cells = stdout.lines().flat_map(str::split_whitespace);
    assert!(cells.clone().count() > 20);
    cells.for_each(|cell| assert!(page.contains(cell), "{cell}"));
    let outcome = sheer(folder.path(), "bench layers --size 32x18 --frames 1 --html missing/a.html");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("missing"), "{outcome:?}");
}

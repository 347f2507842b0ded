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
fn adding_frames_up_is_told_by_itself_and_with_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "bench layers -m std -m joint -a taa -a layered --size 32x18 --frames 3";
    let report = json(&succeed(folder.path(), &format!("{arguments} --json -")).stdout);
    let rows = report["rows"].as_array().unwrap();
    let names: Vec<[&str; 2]> =
        rows.iter().map(|row| ["method", "aa"].map(|key| row[key].as_str().unwrap())).collect();
    assert_eq!(names, [["std", "taa"], ["joint", "taa"], ["std", "layered"], ["joint", "layered"]]);
    for row in rows {
        let ms = |key: &str| row[key].as_f64().unwrap();
        assert!(ms("resolve_ms_median") > 0.0 && ms("whole_ms_median") > ms("ms_min"), "{row}");
    }
    assert_eq!(rows[0]["whole_ratio"], 1.0);
    let table = succeed(folder.path(), arguments).stdout;
    assert!(table.lines().next().unwrap().contains("whole ratio"), "{table}");
    // Where nothing is added up there is nothing to tell.
    let plain = succeed(folder.path(), "bench layers -m std --size 32x18 --frames 1").stdout;
    assert!(!plain.contains("whole") && !plain.contains("resolve"), "{plain}");
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
    assert!(outcome.stderr.contains("cannot write missing/a.html: the folder missing"), "{outcome:?}");
    let outcome = sheer(folder.path(), "bench layers --size 32x18 --frames 1 --json - --html -");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("--json and --html are both to go to stdout"), "{outcome:?}");
}

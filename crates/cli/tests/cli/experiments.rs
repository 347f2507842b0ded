//! `sheer experiments`.

use std::fs;

use crate::run::{json, names_in, sheer, succeed};

#[test]
fn a_report_holds_claims_tables_charts_and_pictures_and_refers_to_nothing_that_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let outcome =
        succeed(folder.path(), "experiments sequences visibility growth moving-pane --size 64x36 -o out");
    assert!(outcome.stdout.contains("✓ 1024 samples: the mean of 400 draws is the truth"), "{outcome:?}");
    let out = folder.path().join("out");
    let report = json(&fs::read_to_string(out.join("experiments.json")).unwrap());
    let experiments = report["experiments"].as_array().unwrap();
    let ids: Vec<_> = experiments.iter().map(|experiment| experiment["id"].as_str().unwrap()).collect();
    // As asked for, not as listed.
    assert_eq!(ids, ["sequences", "visibility", "growth", "moving-pane"]);
    for experiment in experiments {
        let claims = experiment["claims"].as_array().unwrap();
        assert!(claims.iter().all(|claim| claim["holds"].is_boolean()) && !claims.is_empty());
        assert!(!experiment["tables"].as_array().unwrap().is_empty(), "{experiment}");
    }
    let names = names_in(&out);
    let text = fs::read_to_string(out.join("results.md")).unwrap();
    let shown: Vec<&str> = text.split("](./").skip(1).map(|rest| rest.split(')').next().unwrap()).collect();
    assert!(shown.len() > 10, "{text}");
    for name in shown {
        assert!(names.iter().any(|there| there == name), "{name} is not among {names:?}");
    }
}

#[test]
fn what_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = sheer(folder.path(), "experiments still-pain");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("still-pane"), "{outcome:?}");
    assert!(names_in(folder.path()).is_empty());
    let outcome = sheer(folder.path(), "experiments opacities --size 32x18 -o out");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("too small"), "{outcome:?}");
    assert!(names_in(&folder.path().join("out")).is_empty());
}

#[test]
fn the_list_names_every_figure() {
    let folder = tempfile::tempdir().unwrap();
    let list = succeed(folder.path(), "experiments --list").stdout;
    for figure in ["STD Fig. 1", "Fig. 2", "Fig. 4", "Fig. 5", "Fig. 13", "ST Table 1", "joint"] {
        assert!(list.contains(figure), "{figure}: {list}");
    }
}

//! `sheer verify`.

use std::fs;

use crate::run::{json, sheer, succeed};

#[test]
fn all_checks_pass_and_have_the_names_and_types_of_their_contract() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = succeed(folder.path(), "verify --json a.json");
    let report = json(&fs::read_to_string(folder.path().join("a.json")).unwrap());
    let checks = report["checks"].as_array().unwrap();
    assert_eq!(outcome.stdout.lines().count(), 1 + checks.len());
    let is_value = |value: &serde_json::Value| {
        value.is_null()
            || value.is_number()
            || value
                .as_array()
                .is_some_and(|rgb| rgb.len() == 3 && rgb.iter().all(serde_json::Value::is_number))
    };
    for check in checks {
        assert!(check["name"].is_string() && check["source"].is_string() && check["pass"] == true, "{check}");
        assert!(["closed_form", "paper", "measured"].iter().all(|name| is_value(&check[name])), "{check}");
        assert!(check["measured"] != serde_json::Value::Null, "{check}");
        for name in ["samples", "z"] {
            assert!(
                check[name].is_number() || check.get(name).is_some_and(serde_json::Value::is_null),
                "{check}"
            );
        }
    }
    let paper = |name: &str| checks.iter().find(|check| check["name"] == name).unwrap()["paper"].clone();
    assert_eq!(paper("of these without close neighbours"), 1512.0);
    assert_eq!(paper("of these kept as maps"), 288.0);
}

#[test]
fn a_gpu_is_held_against_the_processor() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "verify layers:count=3 -m std -m weighted -m stochastic --backend gpu:raster --json -";
    let report = json(&succeed(folder.path(), arguments).stdout);
    let checks = report["checks"].as_array().unwrap();
    let names: Vec<_> = checks.iter().map(|check| check["name"].as_str().unwrap()).collect();
    // Methods in the scene: one frame, its surfaces, a few frames added up, layer by layer where one fragment
    // is shaded; and for the one whose samples are the hardware's, layers that it covers whole and their
    // closed form.
    assert_eq!(checks.len(), 9, "{names:?}");
    assert!(names[0].contains("layers:count=3") && names[0].contains("std by gpu:raster"), "{names:?}");
    assert!(names[1].contains("motion") && names[2].contains("taa"), "{names:?}");
    assert!(names[3].contains("layered"), "{names:?}");
    assert!(names[8].contains("transmittance") && checks[8]["z"].is_number(), "{checks:?}");
    assert!(checks.iter().all(|check| check["pass"] == true && check["measured"].is_number()), "{checks:?}");

    let refused = sheer(folder.path(), "verify layers -m weighted --backend gpu:ray");
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.stderr.contains("gpu:raster"), "{refused:?}");
    // What was asked for is tested or refused, never something else in its place.
    let arguments = "verify layers:count=1 -m stochastic:filter=bilateral --backend gpu:raster";
    let refused = sheer(folder.path(), arguments);
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.stderr.contains("filter=none"), "{refused:?}");
}

#[test]
fn what_only_a_gpu_has_to_show_is_wrong_use_on_the_processor() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in ["verify layers", "verify -m std", "verify --alpha 0.5", "verify --adapter 0"] {
        let outcome = sheer(folder.path(), arguments);
        assert_eq!(outcome.code, Some(2), "{outcome:?}");
        assert!(outcome.stderr.contains("--backend gpu"), "{outcome:?}");
    }
}

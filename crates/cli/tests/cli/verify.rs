//! `sheer verify`.

use std::fs;

use crate::run::{json, succeed};

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

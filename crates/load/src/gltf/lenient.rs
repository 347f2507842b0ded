//! JSON as exporters write it, where the specification is stricter, and what is wrong with it in the words of
//! the file. Only what does not parse as it stands comes here.

use serde::{Deserialize, de::DeserializeOwned};
use serde_json::{Number, Value};
use serde_path_to_error::{Path, Segment};
use sheer_core::text::quoted;

use super::schema::{Root, VersionOnly};

/// Integers beyond are not told apart by a double.
const GREATEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// Values that are left out of one file before it counts as broken altogether: each costs another attempt.
const MOST_LEFT_OUT: usize = 32;

/// A file that did not parse as it stands.
#[derive(Debug)]
pub(super) struct Parsed {
    pub root: Root,
    /// Something written off but plainly was understood.
    pub is_straightened: bool,
    /// Values that were left out, being of another type than they should.
    pub left_out: Vec<Fault>,
}

/// What is wrong, and where: a path of keys and indices.
#[derive(Debug, PartialEq)]
pub(super) struct Fault {
    pub place: String,
    pub problem: String,
}

/// Reads what is written off but plainly: whole numbers as `24.0` or `1e2`, `null` for what could have been
/// left out, a version that is a number. A value of a wrong type is left out if it can be. `check_version`
/// says what is wrong with a version.
pub(super) fn parse(
    json: &[u8],
    check_version: impl Fn(&VersionOnly) -> Option<String>,
) -> Result<Parsed, Fault> {
    let mut value: Value = serde_json::from_slice(json).map_err(|error| syntax_fault(&error))?;
    let mut is_straightened = straighten(&mut value);
    if let Some(version) = value.pointer_mut("/asset/version").filter(|version| version.is_number()) {
        *version = Value::String(version.to_string());
        is_straightened = true;
    }
    // Version 1 has another shape altogether: say that instead.
    let old = VersionOnly::deserialize(&value).ok().and_then(|only| check_version(&only));
    if let Some(problem) = old {
        return Err(Fault { place: "asset".to_owned(), problem });
    }
    let mut left_out = Vec::new();
    loop {
        match typed(&value) {
            Ok(root) => return Ok(Parsed { root, is_straightened, left_out }),
            Err((path, fault)) => {
                if left_out.len() == MOST_LEFT_OUT || !leave_out(&mut value, &path) {
                    return Err(fault);
                }
                left_out.push(fault);
            }
        }
    }
}

fn typed<T: DeserializeOwned>(value: &Value) -> Result<T, (Path, Fault)> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let path = error.path().to_string();
        let place = if path == "." { "JSON".to_owned() } else { path };
        let problem = in_words(&error.inner().to_string());
        let problem = format!("{problem}; export the file again, or check it with a glTF validator");
        (error.path().clone(), Fault { place, problem })
    })
}

/// Removes the value at a path from the object that it is in; false if it is not in one, or not a root's.
fn leave_out(value: &mut Value, path: &Path) -> bool {
    let mut steps: Vec<&Segment> = path.iter().collect();
    let Some(Segment::Map { key }) = steps.pop() else { return false };
    // A list of the root, such as all nodes, is more than a part.
    if steps.is_empty() {
        return false;
    }
    let holder = steps.into_iter().try_fold(value, |value, step| match step {
        Segment::Map { key } => value.get_mut(key),
        Segment::Seq { index } => value.get_mut(index),
        Segment::Enum { .. } | Segment::Unknown => None,
    });
    holder.and_then(Value::as_object_mut).is_some_and(|holder| holder.remove(key).is_some())
}

/// Numbers without a fraction become integers; keys with `null` go. Returns whether there were any.
fn straighten(value: &mut Value) -> bool {
    match value {
        Value::Number(number) => {
            let whole = number.as_f64().filter(|float| number.is_f64() && float.fract() == 0.0);
            if let Some(float) = whole.filter(|float| float.abs() <= GREATEST_WHOLE) {
                *number = Number::from(float as i64);
                return true;
            }
            false
        }
        Value::Array(values) => values.iter_mut().fold(false, |any, value| straighten(value) | any),
        Value::Object(values) => {
            let count = values.len();
            values.retain(|_, value| !value.is_null());
            let has_nulls = values.len() < count;
            values.values_mut().fold(has_nulls, |any, value| straighten(value) | any)
        }
        Value::Null | Value::Bool(_) | Value::String(_) => false,
    }
}

/// What is no JSON.
fn syntax_fault(error: &serde_json::Error) -> Fault {
    let text = error.to_string();
    let what = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
    // The JSON of a container is one long line.
    let place = match (error.line(), error.column()) {
        (0 | 1, column) => format!("JSON, byte {column}"),
        (line, column) => format!("JSON, line {line}, column {column}"),
    };
    let problem =
        format!("this is no JSON: {what}; export the file again, or check it with a glTF validator");
    Fault { place, problem }
}

/// A message of the parser without the names of its types.
fn in_words(message: &str) -> String {
    if let Some(field) = message.strip_prefix("missing field ") {
        return format!("it has no {}", field.trim_matches('`'));
    }
    let told = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "));
    if let Some((found, expected)) = told.and_then(|told| told.rsplit_once(", expected ")) {
        return format!("it is {}, and {} is expected", found_in_words(found), expected_in_words(expected));
    }
    if let Some((length, expected)) =
        message.strip_prefix("invalid length ").and_then(|told| told.split_once(", expected "))
    {
        return format!("it has a length of {length}, and {} is expected", expected_in_words(expected));
    }
    message.to_owned()
}

fn found_in_words(found: &str) -> String {
    match found {
        "map" => "an object".to_owned(),
        "sequence" => "a list".to_owned(),
        "unit value" => "null".to_owned(),
        _ => {
            let value = ["floating point `", "integer `", "boolean `"]
                .iter()
                .find_map(|kind| found.strip_prefix(kind)?.strip_suffix('`'));
            match (value, found.strip_prefix("string ")) {
                (Some(value), _) => value.to_owned(),
                (None, Some(text)) => format!("the text {}", quoted(text)),
                (None, None) => quoted(found),
            }
        }
    }
}

fn expected_in_words(expected: &str) -> String {
    match expected {
        "usize" | "u8" | "u16" | "u32" | "u64" => "a whole number from 0 on".to_owned(),
        "i8" | "i16" | "i32" | "i64" => "a whole number".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "an object".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "a text".to_owned(),
        _ if expected.starts_with("struct ") => "an object".to_owned(),
        _ => match expected.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length}"),
            None => expected.to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> Result<Parsed, Fault> {
        parse(json.as_bytes(), |only| (only.asset.version != "2.0").then(|| "old".to_owned()))
    }

    /// The place and the problem, without the advice, of what could not be read or was left out.
    fn fault(json: &str) -> (String, String) {
        let Fault { place, problem } = match read(json) {
            Ok(mut parsed) => parsed.left_out.remove(0),
            Err(fault) => fault,
        };
        (place, problem.split(';').next().unwrap().to_owned())
    }

    #[test]
    fn whole_numbers_may_have_a_point_and_an_exponent() {
        let Parsed { root, is_straightened, left_out } = read(
            r#"{"asset": {"version": "2.0"}, "accessors": [
                {"componentType": 5126.0, "count": 2.4e1, "type": "VEC3", "bufferView": 0.0, "byteOffset": null}
            ], "nodes": [{"mesh": 0, "translation": [0.0, 1.5, 2]}], "meshes": null}"#,
        )
        .unwrap();
        let accessor = &root.accessors[0];
        assert_eq!((accessor.count, accessor.component_type, accessor.buffer_view), (24, 5126, Some(0)));
        assert!(root.meshes.is_empty() && is_straightened && left_out.is_empty());
    }

    #[test]
    fn a_value_of_a_wrong_type_is_left_out_where_it_can_be() {
        let asset = r#""asset": {"version": "2.0"}"#;
        let json =
            format!(r#"{{{asset}, "nodes": [{{"mesh": 3}}, {{"mesh": "a", "camera": 2, "skin": []}}]}}"#);
        let Parsed { root, is_straightened, left_out } = read(&json).unwrap();
        assert_eq!((root.nodes[0].mesh, root.nodes[1].mesh, root.nodes[1].camera), (Some(3), None, Some(2)));
        let places: Vec<_> = left_out.iter().map(|fault| fault.place.as_str()).collect();
        assert_eq!(places, ["nodes[1].mesh", "nodes[1].skin"]);
        assert!(!is_straightened);
        // What has to be there cannot be left out, nor can a whole list, nor any number of values.
        for rest in [r#""buffers": [{"byteLength": "a"}]"#.to_owned(), r#""nodes": 7"#.to_owned(), {
            let many = vec![r#"{"mesh": "a"}"#; MOST_LEFT_OUT + 1].join(",");
            format!(r#""nodes": [{many}]"#)
        }] {
            assert!(read(&format!("{{{asset}, {rest}}}")).is_err(), "{rest}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_in_the_words_of_the_file() {
        let asset = r#""asset": {"version": "2.0"}"#;
        let cases = [
            (
                r#""nodes": [{}, {"mesh": 1.5}]"#,
                "nodes[1].mesh",
                "it is 1.5, and a whole number from 0 on is expected",
            ),
            (
                r#""nodes": [{"mesh": -1.0}]"#,
                "nodes[0].mesh",
                "it is -1, and a whole number from 0 on is expected",
            ),
            (r#""nodes": {"a": 1}"#, "nodes", "it is an object, and a list is expected"),
            (r#""buffers": [{"uri": "a"}]"#, "buffers[0]", "it has no byteLength"),
            (
                r#""nodes": [{"translation": [1, 2]}]"#,
                "nodes[0].translation",
                "it has a length of 2, and a list of 3 is expected",
            ),
            (r#""nodes": [{"name": 7}]"#, "nodes[0].name", "it is 7, and a text is expected"),
        ];
        for (rest, place, problem) in cases {
            let found = fault(&format!("{{{asset}, {rest}}}"));
            assert_eq!(found, (place.to_owned(), problem.to_owned()), "{rest}");
            for of_rust in ["usize", "struct", "sequence", "line 1"] {
                assert!(!found.1.contains(of_rust), "{found:?}");
            }
        }
    }

    #[test]
    fn what_is_no_json_is_told_with_its_place() {
        assert_eq!(fault("{\"asset\": }").0, "JSON, byte 11");
        assert_eq!(fault("{\n\"asset\": }").0, "JSON, line 2, column 10");
    }

    #[test]
    fn a_version_may_be_a_number_and_is_told_before_all_else() {
        let json = r#"{"asset": {"version": 1}, "nodes": {"a": {"camera": "b"}}}"#;
        assert_eq!(fault(json), ("asset".to_owned(), "old".to_owned()));
    }
}

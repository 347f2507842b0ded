//! Running the binary.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

/// What came of a run.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// The binary, with arguments separated by blanks, in a folder.
pub(crate) fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sheer"));
    command.args(arguments.split_whitespace()).current_dir(folder);
    command
}

/// Runs it to its end.
pub(crate) fn sheer(folder: &Path, arguments: &str) -> Outcome {
    let Output { status, stdout, stderr } = command(folder, arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Outcome { code: status.code(), stdout: text(stdout), stderr: text(stderr) }
}

/// Runs it and asserts that it went well.
pub(crate) fn succeed(folder: &Path, arguments: &str) -> Outcome {
    let outcome = sheer(folder, arguments);
    assert_eq!(outcome.code, Some(0), "{arguments}: {outcome:?}");
    outcome
}

/// Puts a script of a shell into the folder `bin`, by the name of a program that it stands in for.
#[cfg(unix)]
pub(crate) fn stand_in(folder: &Path, program: &str, script: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    let bin = folder.join("bin");
    fs::create_dir_all(&bin).unwrap();
    let file = bin.join(program);
    fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
}

/// Names in a folder, sorted.
pub(crate) fn names_in(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// What an EXR file says of how it was made, under `sheer.KEY`.
pub(crate) fn attribute(file: &Path, key: &str) -> Option<String> {
    let bytes = fs::read(file).unwrap();
    // A name and a type end with NUL, then come the length of the text and the text.
    let head = format!("sheer.{key}\0string\0");
    let at = bytes.windows(head.len()).position(|window| window == head.as_bytes())? + head.len();
    let length = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    Some(String::from_utf8(bytes[at + 4..at + 4 + length].to_vec()).unwrap())
}

/// A report, parsed.
pub(crate) fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

/// Asserts that an object has a number under each of these names.
pub(crate) fn assert_numbers(object: &serde_json::Value, names: &[&str]) {
    for name in names {
        assert!(object[name].is_number(), "{name} is {:?} in {object}", object.get(name));
    }
}

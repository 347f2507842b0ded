//! Ctrl-C.

#![cfg(unix)]

use std::{
    process::{Command, Stdio},
    thread,
    time::Duration,
};

use sheer_image::read_png;

use crate::run::{command, names_in};

#[test]
fn an_interrupted_run_leaves_whole_files_only() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = command(folder.path(), "render layers --size 320x200 --frames 1000000 -o a-#######.png")
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // In the middle of the run: some files are there, more are to come.
    while names_in(folder.path()).len() < 3 && child.try_wait().unwrap().is_none() {
        thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let names = names_in(folder.path());
    assert!(!names.is_empty());
    for name in names {
        assert_eq!(read_png(&folder.path().join(&name)).unwrap().size(), (320, 200), "{name}");
    }
}

//! The table of passes in ARCHITECTURE.md is that of the code.

use std::{collections::BTreeSet, fs, path::Path};

use sheer_render::{Method, method::METHODS};

use crate::{
    raster::RasterPath,
    ray::{RayPath, Search},
};

/// A row of the table: methods, passes by rays and passes by raster.
struct Row {
    methods: Vec<String>,
    passes: [Vec<String>; 2],
}

/// What stands between backquotes, or is parted by commas.
fn words(cell: &str) -> Vec<String> {
    cell.split(',').map(|word| word.trim().trim_matches('`').to_owned()).filter(|word| word != "–").collect()
}

/// The rows below the head `| family | methods | by rays | by raster |`.
fn table(text: &str) -> Vec<Row> {
    let rows = text.lines().skip_while(|line| !line.starts_with("| family | methods |")).skip(2);
    rows.take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<_> = line.trim_matches('|').split('|').collect();
            let [_, methods, rays, raster] = cells[..] else { panic!("{line} has other columns") };
            Row { methods: words(methods), passes: [words(rays), words(raster)] }
        })
        .collect()
}

/// The passes of a method by rays and by raster, as the code has them.
fn passes(method: &Method) -> [Vec<String>; 2] {
    let owned = |steps: Vec<&str>| steps.into_iter().map(str::to_owned).collect();
    let rays = Search::of(method).map(RayPath::steps).unwrap_or_default();
    [owned(rays), owned(RasterPath::steps(method).unwrap())]
}

/// Methods whose row tells other passes than the code, and methods that no row names.
fn wrong(text: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut named = BTreeSet::new();
    for row in table(text) {
        for name in &row.methods {
            let method: Method = name.parse().unwrap();
            named.insert(method.info().id);
            if passes(&method) != row.passes {
                wrong.push(format!("{name}: {:?}", passes(&method)));
            }
        }
    }
    let missing = METHODS.iter().filter(|info| !named.contains(info.id));
    wrong.extend(missing.map(|info| format!("{}: no row", info.id)));
    wrong
}

#[test]
fn the_table_of_passes_is_that_of_the_code() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ARCHITECTURE.md");
    let text = fs::read_to_string(file).unwrap();
    assert_eq!(wrong(&text), Vec::<String>::new());
    // Negative controls: a pass or a method that the table leaves out.
    assert!(!wrong(&text.replace("visibility, collect, ", "visibility, ")).is_empty());
    assert!(!wrong(&text.replace("`joint`", "`std`")).is_empty());
}

/// Files below `src` in which a device is waited for.
fn files_that_wait(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_that_wait(&path, found);
        } else if fs::read_to_string(&path).unwrap().contains(concat!(".po", "ll(")) {
            found.insert(path.file_name().unwrap().to_str().unwrap().to_owned());
        }
    }
}

#[test]
fn the_device_is_waited_for_in_one_place_which_counts() {
    let mut found = BTreeSet::new();
    files_that_wait(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
    assert_eq!(found, BTreeSet::from(["device.rs".to_owned()]));
}

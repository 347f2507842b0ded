//! Linking by hand-made pieces, and the project's own ones through naga, which needs no device.

use std::{collections::BTreeSet, fs, path::Path, sync::Arc};

use sheer_render::{
    Antialiasing, LayerSplit, Method,
    contract::Raster,
    method::{Family, variants},
    temporal::ANTIALIASINGS,
};

use crate::{
    device::{AdapterChoice, AdapterReport, Gpu, Tracer},
    error::GpuError,
    opaque_input::DepthKind,
    pipeline::{base_linker, over_opaque, with_glass},
    raster::{
        Lists,
        multisample::Sampling,
        plan::{self, raster_of},
    },
    ray::Search,
    shader::{Linker, linked::Linked},
    shadow::MapSettings,
    tables::Tables,
    temporal::{self, History},
};

fn linker(pieces: &[(&'static str, &'static str)]) -> Linker {
    Linker::of_pieces(pieces, "C\n".to_owned())
}

fn problem(linker: &Linker, piece: &str) -> String {
    linker.link(piece).unwrap_err().to_string()
}

/// What naga makes of a shader that is valid; the error by piece and line.
pub(super) fn validated(shader: &Linked) -> Result<naga::Module, String> {
    let text = &shader.text;
    let module =
        naga::front::wgsl::parse_str(text).map_err(|error| shader.relocated(&error.emit_to_string(text)))?;
    let capabilities = naga::valid::Capabilities::all();
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|error| shader.relocated(&error.emit_to_string(text)))?;
    Ok(module)
}

/// Whether naga takes a shader.
pub(super) fn validate(shader: &Linked) -> Result<(), String> {
    validated(shader).map(|_| ())
}

#[test]
fn a_piece_is_included_once_below_constants_and_enables() {
    let linker = linker(&[
        ("a", "enable x;\n#import b\n#import c\na"),
        ("b", "enable x;\nenable w;\n#import c\nb"),
        ("c", "c"),
    ]);
    assert_eq!(linker.link("a").unwrap().text, "enable w;\nenable x;\nC\nc\nb\na\n");
}

#[test]
fn an_alias_stands_for_a_piece() {
    let linker = linker(&[("a", "#import b\n#import other"), ("b", "b")]).alias("other", "b");
    assert_eq!(linker.link("a").unwrap().text, "C\nb\n");
    assert_eq!(linker.constants("D\n".to_owned()).link("other").unwrap().text, "C\nD\nb\n");
}

#[test]
fn a_template_is_expanded_once_for_each_word() {
    let linker = linker(&[
        ("a", "#expand t V=x\n#expand t V=y\n#expand t V=x"),
        ("t", "#import b\nf_V(V)"),
        ("b", "b"),
    ]);
    assert_eq!(linker.link("a").unwrap().text, "C\nb\nf_x(x)\nf_y(y)\n");
}

#[test]
fn slips_name_the_chain_that_leads_to_them() {
    let linker = linker(&[
        ("a", "#import b"),
        ("b", "#import c"),
        ("c", "#import a"),
        ("d", "#import e\n"),
        ("f", "#inport b"),
        ("g", "#expand f W=x"),
        ("h", "#expand f W"),
    ]);
    assert!(problem(&linker, "a").contains("include one another: a → b → c → a"));
    assert!(problem(&linker, "d").contains("no piece 'e': d → e"));
    assert!(problem(&linker, "f").contains("f.wgsl:1: '#inport b'"));
    assert!(problem(&linker, "g").contains("there is no W to replace: g → f"));
    assert!(problem(&linker, "h").contains("'W' is not NAME=WORD: h → f"));
}

/// Names of the files below a folder, without their ending.
fn names_below(folder: &Path, root: &Path, names: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            names_below(&path, root, names);
        } else {
            assert_eq!(path.extension().unwrap(), "wgsl", "{} is no shader", path.display());
            let name =
                path.with_extension("").strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
            names.insert(name);
        }
    }
}

#[test]
fn every_file_below_shaders_is_a_piece() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut names = BTreeSet::new();
    names_below(&root, &root, &mut names);
    let linker = Linker::new();
    assert!(names.iter().map(String::as_str).eq(linker.names().filter(|name| !name.starts_with("struct/"))));
}

/// Shaders that use all that threshold and selection methods bring, for each value of each choice.
fn probes_of_methods() -> Vec<(Method, Linked)> {
    let drawing = variants().filter(|method| method.family().shades_one_fragment());
    let probe = |method: Method| {
        let probe = if method.family() == Family::Selection { "probe/selection" } else { "probe/threshold" };
        let tables = Tables::new(&[], [4, 0]).constants();
        let text = Linker::new().method(&method).constants(tables).link(probe).unwrap();
        (method, text)
    };
    drawing.map(probe).collect()
}

#[test]
fn every_threshold_and_selection_method_is_a_valid_shader() {
    let probes = probes_of_methods();
    assert!(probes.len() > 7, "{}", probes.len());
    for (method, text) in probes {
        validate(&text).unwrap_or_else(|error| panic!("{method}: {error}"));
    }
}

#[test]
fn every_shared_piece_of_numbers_is_valid_alone() {
    // Its keys and constants are all that these pieces take of a method.
    let method: Method = "dtaa-unique".parse().unwrap();
    let linker = Linker::new().method(&method).constants(Tables::new(&[], [4, 0]).constants());
    for piece in ["decide", "dtaa_map", "hash", "mask", "object_draw", "site", "tables", "threshold_map"]
        .map(|name| format!("shared/{name}"))
    {
        validate(&linker.link(&piece).unwrap()).unwrap_or_else(|error| panic!("{piece}: {error}"));
    }
    for piece in ["probe/hash", "probe/mask", "probe/decide"] {
        validate(&linker.link(piece).unwrap()).unwrap_or_else(|error| panic!("{piece}: {error}"));
    }
}

#[test]
fn a_slip_in_a_shader_is_found() {
    let (_, shader) = probes_of_methods().swap_remove(0);
    for (from, to) in [("-> f32", "-> u32"), ("LCG_INCREMENT;", "LCG_INCREMENTS;"), ("v * ", "v *, ")] {
        assert!(shader.text.contains(from), "{from}");
        let mut slip = shader.clone();
        slip.text = shader.text.replacen(from, to, 1);
        assert!(validate(&slip).is_err(), "{from}");
    }
}

/// All shaders of both paths that a method may take, by name.
fn passes_of(method: &Method, linker: Linker, split: Option<LayerSplit>) -> Vec<(String, Linked)> {
    let plain = linker.constants(Tables::new(&[], [4, 0]).constants());
    let linker = plain.clone().method(method);
    let Some(search) = Search::of(method).map(|search| search.with_layers(split)) else {
        let raster = raster_of(method).unwrap().unwrap();
        let behind = ("pass/composite".to_owned(), plain.link("pass/composite").unwrap());
        // Targets of several samples have shaders and a test of their own.
        let front = (!matches!(raster, Raster::Multisample(_)))
            .then(|| ("pass/front".to_owned(), plan::link(&raster, linker.clone()).unwrap()));
        return front.into_iter().chain([behind]).collect();
    };
    let piece = search.piece().0;
    let mut passes = vec![(piece.to_owned(), search.link(linker.clone()).unwrap())];
    let mut more =
        |linker: &Linker, piece: &str| passes.push((piece.to_owned(), linker.link(piece).unwrap()));
    more(&plain, "pass/shade");
    if search.needs_order() {
        more(&plain, "pass/opaque");
        more(&plain, "pass/capture");
        more(&Lists::linker(linker, search), piece);
    } else {
        more(&linker, "pass/visibility");
        more(&linker.alias("find", "pass/find_visible"), piece);
    }
    passes
}

#[test]
fn every_pass_of_every_method_is_a_valid_shader() {
    let hybrids = ["std:hybrid=0.5", "joint:hybrid=0.5,layers=4"].map(|text| text.parse().unwrap());
    // What a rasteriser refuses has no shader.
    let drawn = variants().filter(|method| raster_of(method).is_ok());
    for method in drawn.chain(hybrids) {
        for tracer in [Tracer::Query, Tracer::Bvh] {
            for split in [None, Some(LayerSplit { least_share: 0.25 })] {
                for linker in [base_linker(tracer), with_glass(base_linker(tracer))] {
                    for (piece, text) in passes_of(&method, linker, split) {
                        validate(&text).unwrap_or_else(|error| {
                            panic!("{method}, {tracer:?}, {split:?}, {piece}: {error}")
                        });
                    }
                }
            }
        }
    }
}

#[test]
fn what_a_caller_has_drawn_ends_rays_in_every_pass() {
    let split = Some(LayerSplit { least_share: 0.25 });
    for text in ["std", "joint", "baseline", "weighted", "std:hybrid=0.5"] {
        let method: Method = text.parse().unwrap();
        for kind in [DepthKind::Depth, DepthKind::Float] {
            for (piece, shader) in passes_of(&method, over_opaque(base_linker(Tracer::Bvh), kind), split) {
                validate(&shader).unwrap_or_else(|error| panic!("{text}, {kind:?}, {piece}: {error}"));
                assert!(shader.text.contains("BIND_INPUT_DEPTH) var input_depth"), "{text}, {piece}");
            }
        }
    }
    validate(&Linker::new().link("pass/picture").unwrap()).unwrap();
}

/// What a device with four samples a pixel says of itself.
pub(super) fn report() -> AdapterReport {
    AdapterReport {
        name: "made up".to_owned(),
        kind: "software",
        driver: String::new(),
        api: String::new(),
        ray_query: false,
        timestamps: false,
        msaa: vec![4],
        max_storage_bytes: 1 << 27,
        max_storage_buffers: 64,
        compute: true,
        storage_in_raster: true,
    }
}

/// How the made-up device divides the samples of a method.
fn sampling(method: &Method) -> Result<Sampling, GpuError> {
    match raster_of(method)? {
        Some(Raster::Multisample(multisample)) => Sampling::new(multisample, &report()),
        other => panic!("{method} is drawn by {other:?}"),
    }
}

#[test]
fn every_pass_of_stochastic_transparency_is_a_valid_shader() {
    for settings in [
        "",
        "correct=off",
        "estimator=basic",
        "samples=16,passes=2,masks=naive",
        "masks=a2c,dither=tile",
        "seed-by=depth",
    ] {
        let method: Method = format!("stochastic:{settings}").parse().unwrap();
        let sampling = sampling(&method).unwrap();
        let tables = Tables::new(&[], sampling.table_sizes()).constants();
        let plain = base_linker(Tracer::Bvh).constants(tables);
        let sampled = plain.clone().constants(sampling.constants());
        for (piece, linker) in [
            ("pass/stochastic", sampled.clone().method(&method)),
            ("pass/stochastic_accumulate", plain),
            ("pass/stochastic_resolve", sampled),
        ] {
            validate(&linker.link(piece).unwrap())
                .unwrap_or_else(|error| panic!("{method}, {piece}: {error}"));
        }
    }
}

#[test]
fn every_anti_aliasing_technique_is_a_valid_shader() {
    for info in ANTIALIASINGS {
        let antialiasing: Antialiasing = info.id.parse().unwrap();
        let linker = Linker::new().antialiasing(&antialiasing);
        validate(&linker.link(temporal::piece_of(&antialiasing).0).unwrap())
            .unwrap_or_else(|error| panic!("{}: {error}", info.id));
    }
}

#[test]
fn what_the_hardware_cannot_draw_of_stochastic_transparency_is_refused_with_advice() {
    for settings in [
        "samples=3",
        "samples=6",
        "samples=64,passes=3",
        "masks=laine-karras",
        "placement=gaussian",
        "adaptive=0.1",
        "filter=bilateral",
    ] {
        let method: Method = format!("stochastic:{settings}").parse().unwrap();
        let error = sampling(&method).unwrap_err().to_string();
        assert!(error.contains("take ") && error.contains("--backend cpu"), "{settings}: {error}");
    }
}

#[test]
fn shadow_maps_are_valid_shaders_to_make_and_to_read() {
    for settings in ["", "samples=64,correct=on", "sampling=naive,taps=3", "filter=0"] {
        let maps = MapSettings::of(&format!("stochastic-map:{settings}").parse().unwrap()).unwrap().unwrap();
        for tracer in [Tracer::Query, Tracer::Bvh] {
            let linker = base_linker(tracer).constants(Tables::new(&[], [4, 0]).constants());
            let linker = linker.alias("shadow", "shared/shadow_map").constants(maps.constants());
            for piece in ["pass/shadow_map", "shared/shade"] {
                let text = linker.link(piece).unwrap();
                validate(&text).unwrap_or_else(|error| panic!("{settings}, {tracer:?}, {piece}: {error}"));
            }
        }
    }
    for other in ["deep-map", "opacity-map", "fourier"] {
        let error = MapSettings::of(&other.parse().unwrap()).unwrap_err().to_string();
        assert!(error.contains(other) && error.contains("take --shadow stochastic-map"), "{error}");
    }
}

fn taa() -> Antialiasing {
    "taa".parse().unwrap()
}

#[test]
fn the_sources_of_pipelines_are_written_where_the_user_asks() {
    let folder = std::env::temp_dir().join(format!("sheer-shaders-{}", std::process::id()));
    let mut gpu = Arc::into_inner(Gpu::new(&AdapterChoice::Best).unwrap()).unwrap();
    gpu.shader_folder = Some(folder.clone());
    History::new(&gpu, taa(), [8, 8]).unwrap();
    let files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    let [file] = &files[..] else { panic!("{files:?}") };
    let name = file.file_name().unwrap().to_str().unwrap();
    assert!(name.starts_with("pass-resolve-") && name.ends_with(".wgsl"), "{name}");
    let text = fs::read_to_string(file).unwrap();
    for piece in ["// constants.wgsl, from", "// temporal/taa.wgsl, from", "// struct/PixelRecord.wgsl, from"]
    {
        assert!(text.contains(piece), "{piece} is not in\n{text}");
    }
    naga::front::wgsl::parse_str(&text).unwrap();
    fs::remove_dir_all(&folder).unwrap();
    // A file in the way of the folder is told, with the variable that asked for it.
    fs::write(&folder, "").unwrap();
    let error = History::new(&gpu, taa(), [8, 8]).unwrap_err().to_string();
    fs::remove_file(&folder).unwrap();
    assert!(error.contains("SHEER_SHADERS") && error.contains("cannot be written"), "{error}");
}

#[test]
fn errors_are_told_by_piece_and_line_in_every_position() {
    let pieces = [
        ("pass/a", "#import shared/b\n\nfn a() -> u32 {\n    return b();\n}\n"),
        ("shared/b", "// A comment.\n#expand shared/t WORD=x\nfn b() -> f32 {\n    return x_one;\n}\n"),
        ("shared/t", "\nconst WORD_one: f32 = 1.0;\n"),
    ];
    let linked = Linker::of_pieces(&pieces, "const C: u32 = 1u;\n".to_owned()).link("pass/a").unwrap();
    let lines: Vec<_> = linked.text.lines().collect();
    for (piece, text) in pieces {
        // Every line that is left of a piece is led back to where it stands there.
        for (at, line) in lines.iter().enumerate() {
            let (from, row) = linked.origin(at + 1).unwrap();
            if from == piece {
                let original = text.lines().nth(row as usize - 1).unwrap();
                assert_eq!(*line, original.replace("WORD", "x"), "{piece}, line {row}");
            }
        }
    }
    // The wrong type is returned in line 4 of the pass, which is another line of the whole.
    let error = validate(&linked).unwrap_err();
    assert!(error.contains("pass/a.wgsl:"), "{error}");
    assert!(!error.contains("─ wgsl:"), "{error}");
    assert_eq!(linked.origin(0), None);
    assert_eq!(linked.origin(lines.len() + 1), None);
}

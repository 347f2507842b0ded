//! `sheer metrics`: pictures from anywhere, held against a reference.

use std::path::Path;

use sheer_image::{Picture, TextureLimits, read_picture};
use sheer_lab::{Judged, Judging, LabError, Progress as _, Seeded, file_name_from, picture_figures};
use sheer_metrics::LEAST_VDP_SIDE_PX;

use crate::{
    args::MetricsArguments,
    failure::Misuse,
    input::PictureInput,
    output::{self, TextOutput},
    report::{
        data_files::DataFiles,
        json::{self, JudgedPictures},
        page,
        table::Table,
    },
    setup,
};

pub(crate) fn run(arguments: &MetricsArguments) -> anyhow::Result<()> {
    // What can go wrong goes wrong before the first picture is read.
    let console = arguments.machine.apply()?;
    arguments.data.check_stdout(&[("--json", arguments.json.as_deref())])?;
    let reference = PictureInput::find(&arguments.reference)?;
    let inputs: Vec<PictureInput> =
        arguments.pictures.iter().map(|text| PictureInput::find(text)).collect::<anyhow::Result<_>>()?;
    for input in &inputs {
        let (frames, expected) = (input.frames.len(), reference.frames.len());
        if frames != expected && expected != 1 {
            let problem = format!(
                "{} has {frames} picture{} and the reference {expected}: give as many, or one reference for all",
                input.name,
                if frames == 1 { "" } else { "s" },
            );
            return Err(Misuse(problem).into());
        }
        if let Some((frame, other)) = input.out_of_step(&reference) {
            let problem = format!(
                "{} and {} have other numbers than those before them, counted from the first: a frame is missing of one of the clips",
                frame.display(),
                other.display()
            );
            return Err(Misuse(problem).into());
        }
    }
    let data_files = DataFiles::open(&arguments.data)?;
    let json = arguments.json.as_deref().map(TextOutput::open).transpose()?;
    if let Some(folder) = &arguments.html {
        output::open_folder(folder)?;
    }

    let tone = arguments.tone.tone();
    let judging = Judging { tone, vdp_frames_per_sec: arguments.vdp.then_some(arguments.fps) };
    let limits = TextureLimits::default();
    let read = |path: &Path| read_picture(path, limits).map_err(LabError::from);
    let first: Picture = read(&reference.frames[0])?;
    let (width, height) = first.colour.size();
    if arguments.vdp && width.min(height) < LEAST_VDP_SIDE_PX {
        let problem = format!("--vdp judges pictures from {LEAST_VDP_SIDE_PX} pixels a side up");
        return Err(Misuse(problem).into());
    }
    let bar = console.bar();
    bar.expect(inputs.iter().map(|input| input.frames.len() as u64).sum());
    let mut judged: Vec<Seeded<Judged>> = Vec::with_capacity(inputs.len());
    for input in &inputs {
        bar.name(&input.name);
        let run = judging.judge(&input.name, input.frames.len() as u32, |index| {
            bar.step();
            let index = index as usize;
            // One reference is the one for all.
            let expected = reference.frames.get(index).unwrap_or(&reference.frames[0]);
            Ok((read(expected)?, read(&input.frames[index])?))
        })?;
        // What has the name of another differs in its seed.
        match judged.iter_mut().find(|runs| input.is_named && runs.first().name == run.name) {
            Some(runs) => runs.add(run),
            None => judged.extend(Seeded::of(vec![run])),
        }
    }
    drop(bar);

    let figures = picture_figures(&judged);
    let report = JudgedPictures::new(&reference.name, [width, height], &tone, &judged);
    if let Some(folder) = &arguments.html {
        let last = read(&reference.frames[reference.frames.len() - 1])?;
        let page = page::pictures::Page::new(&reference.name, &last, tone, &judged)?;
        for (name, png) in page.files() {
            output::write_file(&folder.join(format!("{}.png", file_name_from(&name))), png)?;
        }
        let text = page.text(&report)?;
        output::write_file(&folder.join("index.html"), text.as_bytes())?;
        console.note(format_args!("wrote {}", folder.join("index.html").display()));
    }
    setup::note_certain(&figures, console);
    data_files.write(&figures)?;
    let prints_json = json.as_ref().is_some_and(TextOutput::is_stdout);
    if let Some(json) = json {
        json.write(&json::text(&report)?)?;
    }
    if prints_json || data_files.is_stdout() {
        return Ok(());
    }
    output::print(&Table::of(&figures).text())
}

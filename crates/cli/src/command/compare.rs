//! `sheer compare`: methods side by side with the exact answer.

use sheer_lab::{
    Clip, ERROR_FULL_SCALE, Measured, REFERENCE, Reference, Timeline, Truth, figures, file_name_from,
    with_reference,
};
use sheer_metrics::LEAST_VDP_SIDE_PX;
use sheer_render::{Backend, Settings};

use crate::{
    args::{COMPARE_SIZE, CompareArguments},
    backend::Task,
    failure::Misuse,
    output,
    report::{
        data_files::DataFiles,
        json::{self, Comparison, ComparisonRow},
        page::{
            self,
            comparison::{Entry, Page, TruthPicture},
        },
        table::Table,
    },
    setup::{self, without_repeats},
};

pub(crate) fn run(arguments: &CompareArguments) -> anyhow::Result<()> {
    arguments.backend.run(arguments)
}

impl Task for CompareArguments {
    fn run_on<B: Backend + 'static>(&self, backend: &B) -> anyhow::Result<()> {
        compare(self, backend)
    }
}

fn compare<B: Backend>(arguments: &CompareArguments, backend: &B) -> anyhow::Result<()> {
    let console = arguments.machine.apply()?;
    // What can go wrong goes wrong before the first frame.
    let folder = arguments.output.as_path();
    output::open_folder(folder)?;
    let data_files = DataFiles::open(&arguments.data)?;
    let settings = arguments.light.under(arguments.frames.settings(COMPARE_SIZE)?);
    if arguments.vdp && settings.size.into_iter().any(|side| side < LEAST_VDP_SIDE_PX) {
        let problem =
            format!("--vdp judges pictures from {LEAST_VDP_SIDE_PX} pixels a side up; try a larger --size");
        return Err(Misuse(problem).into());
    }
    let frame_count = arguments.frames.count();
    let methods = with_reference(without_repeats(&arguments.methods))?;
    let antialiasings = without_repeats(&arguments.antialiasings);
    let references = without_repeats(&arguments.references);
    let mut truth = truth(&references, settings)?;
    let mut opened = arguments.scene.open(backend, settings.size, arguments.machine, console)?;

    // All methods play the clip, once under each anti-aliasing; they share the truth.
    let mut measured = Vec::new();
    let mut true_pictures = Vec::new();
    let bar = console.bar();
    for &antialiasing in &antialiasings {
        let clip = Clip { settings, antialiasing, frame_count, keeps_frames: arguments.vdp };
        let timeline = Timeline::of(&settings, antialiasing, frame_count);
        measured.extend(clip.play(backend, &mut opened.stage, &methods, truth.as_mut(), &bar)?);
        if let Some(picture) = truth.as_ref().and_then(|truth| truth.picture(timeline)) {
            true_pictures.push(TruthPicture::new(antialiasing, &picture)?);
        }
    }
    drop(bar);
    measured.iter().filter_map(overflow_of_reference).for_each(|warning| console.warn(warning));

    // Pictures are encoded once, for their files and for the page.
    let entries = measured.into_iter().map(Entry::new).collect::<anyhow::Result<Vec<_>>>()?;
    for Entry { measured, picture_png, error_png } in &entries {
        let stem = file_name_from(&format!("{}-{}", measured.antialiasing, measured.method));
        output::write_file(&folder.join(format!("{stem}.png")), picture_png)?;
        if let Some(error) = error_png {
            output::write_file(&folder.join(format!("{stem}-error.png")), error)?;
        }
    }
    for TruthPicture { aa, png } in &true_pictures {
        output::write_file(&folder.join(format!("{}.png", file_name_from(&format!("{aa}-truth")))), png)?;
    }
    let run = setup::describe(backend, &arguments.scene, &opened, &settings, frame_count);
    let rows = entries.iter().flat_map(|Entry { measured, .. }| {
        references.iter().filter_map(|&reference| ComparisonRow::new(measured, reference))
    });
    let rows = rows.collect();
    let report = Comparison { run, reference: REFERENCE.to_owned(), rows };
    // What refers to the pictures comes last, so that an interrupted run leaves no report that lacks them.
    let page = Page {
        report: &report,
        references: &references,
        entries: &entries,
        true_pictures: &true_pictures,
        error_full_scale: ERROR_FULL_SCALE,
    };
    let page = page::comparison::text(&page)?;
    output::write_file(&folder.join("report.json"), json::text(&report)?.as_bytes())?;
    output::write_file(&folder.join("index.html"), page.as_bytes())?;
    let figures = figures(entries.iter().map(|entry| &entry.measured), true, &references);
    data_files.write(&figures)?;
    if !data_files.is_stdout() {
        output::print(&Table::of(&figures).text())?;
    }
    console.note(format_args!("wrote {} and report.json beside it", folder.join("index.html").display()));
    Ok(())
}

/// The truth, if it is asked for.
fn truth(references: &[Reference], settings: Settings) -> Result<Option<Truth>, Misuse> {
    let mut samples = references.iter().filter_map(|reference| match *reference {
        Reference::Truth { samples } => Some(samples),
        Reference::Same => None,
    });
    let truth = samples.next().map(|samples| Truth::new(settings, samples));
    if samples.next().is_some() {
        return Err(Misuse(
            "there is one truth a comparison; give --reference truth:samples=N once".to_owned(),
        ));
    }
    Ok(truth)
}

/// What to say of a reference that is not exact: a rasteriser's lists hold so many fragments and no more.
fn overflow_of_reference(measured: &Measured) -> Option<String> {
    let Measured { method, antialiasing, merged_per_pixel, .. } = measured;
    (method.to_string() == REFERENCE && *merged_per_pixel > 0.0).then(|| {
        format!(
            "{REFERENCE} ({antialiasing}) had no place for {merged_per_pixel:.3} fragments a pixel and summed them up: errors are not \
             against the exact answer; take --backend gpu:ray or cpu"
        )
    })
}

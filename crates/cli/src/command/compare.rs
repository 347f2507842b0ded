//! `sheer compare`: methods side by side with the exact answer.

use sheer_metrics::LEAST_VDP_SIDE_PX;

use crate::{
    args::{COMPARE_SIZE, CompareArguments},
    backend::{Renderer, Task},
    clip::{Clip, ERROR_FULL_SCALE, REFERENCE, with_reference},
    failure::Misuse,
    output,
    report::{
        comparison::figures,
        json::{self, Comparison, ComparisonRow},
        page::{
            self,
            comparison::{Entry, Page},
        },
    },
    setup::{self, file_name_from, without_repeats},
};

pub(crate) fn run(arguments: &CompareArguments) -> anyhow::Result<()> {
    arguments.backend.run(arguments)
}

impl Task for CompareArguments {
    fn run_on(&self, renderer: &impl Renderer) -> anyhow::Result<()> {
        compare(self, renderer)
    }
}

fn compare<R: Renderer>(arguments: &CompareArguments, renderer: &R) -> anyhow::Result<()> {
    let talk = arguments.machine.apply()?;
    let folder = arguments.output.as_path();
    output::open_folder(folder)?;
    let settings = arguments.light.under(arguments.frames.settings(COMPARE_SIZE));
    if arguments.vdp && settings.size.into_iter().any(|side| side < LEAST_VDP_SIDE_PX) {
        let problem =
            format!("--vdp judges pictures from {LEAST_VDP_SIDE_PX} pixels a side up; try a larger --size");
        return Err(Misuse(problem).into());
    }
    let frame_count = arguments.frames.frames;
    let methods = with_reference(without_repeats(&arguments.methods))?;
    let antialiasings = without_repeats(&arguments.antialiasings);
    let mut opened = arguments.scene.open(renderer, arguments.machine, talk)?;

    let mut entries = Vec::new();
    let progress = talk.progress(u64::from(frame_count) * (methods.len() * antialiasings.len()) as u64);
    for &antialiasing in &antialiasings {
        let clip = Clip { settings, antialiasing, frame_count, keeps_frames: arguments.vdp };
        let noted = |note: &str| progress.suspend(|| talk.warn(note));
        entries.extend(clip.play(renderer, &mut opened.stage, &methods, noted, || progress.inc(1))?);
    }
    progress.finish_and_clear();
    entries.iter().filter_map(overflow_of_reference).for_each(|warning| talk.warn(warning));

    for entry in &entries {
        let stem = file_name_from(&format!("{}-{}", entry.row.aa, entry.row.method));
        output::write_file(&folder.join(format!("{stem}.png")), &entry.picture_png)?;
        if let Some(error) = &entry.error_png {
            output::write_file(&folder.join(format!("{stem}-error.png")), error)?;
        }
    }
    let run = setup::describe(renderer, &arguments.scene, &opened, &settings, frame_count);
    let rows = entries.iter().map(|entry| entry.row.clone()).collect();
    let report = Comparison { run, reference: REFERENCE.to_owned(), rows };
    // What refers to the pictures comes last, so that an interrupted run leaves no report that lacks them.
    let page = Page { report: &report, entries: &entries, error_full_scale: ERROR_FULL_SCALE };
    let page = page::comparison::text(&page)?;
    output::write_file(&folder.join("report.json"), json::text(&report)?.as_bytes())?;
    output::write_file(&folder.join("index.html"), page.as_bytes())?;
    output::print(&figures(&report, true).text())?;
    talk.note(format_args!("wrote {} and report.json beside it", folder.join("index.html").display()));
    Ok(())
}

/// What to say of a reference that is not exact: a rasteriser's lists hold so many fragments and no more.
fn overflow_of_reference(entry: &Entry) -> Option<String> {
    let ComparisonRow { method, aa, merged_per_pixel, .. } = &entry.row;
    (method == REFERENCE && *merged_per_pixel > 0.0).then(|| {
        format!(
            "{REFERENCE} ({aa}) had no place for {merged_per_pixel:.3} fragments a pixel and summed them up: errors are not against \
             the exact answer; take --backend gpu:ray or cpu"
        )
    })
}

//! `sheer compare`: methods side by side with the exact answer.

use std::path::Path;

use sheer_image::{Picture, TextureLimits, read_picture};
use sheer_lab::{
    Clip, ComparisonRow, ERROR_FULL_SCALE, Foreign, ForeignJudged, Measured, Progress, REFERENCE, Reference,
    Seeded, Timeline, Truth, figures, file_name_from, with_reference,
};
use sheer_metrics::LEAST_VDP_SIDE_PX;
use sheer_render::{Backend, Method, Settings};

use crate::{
    args::{COMPARE_SIZE, CompareArguments},
    backend::Task,
    failure::Misuse,
    input::FramePictures,
    output,
    report::{
        data_files::DataFiles,
        json::{self, Comparison, Row, Run},
        page::{
            self,
            comparison::{Entry, ForeignEntry, Page, TruthPicture},
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
    arguments.data.check_stdout(&[])?;
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
    let seeds = Seeds::new(arguments, &settings);
    let mut truths = seeds.truths(&references, settings)?;
    let pictures = foreign_pictures(arguments, &methods, &settings)?;
    let folder = arguments.output.as_path();
    output::open_folder(folder)?;
    let data_files = DataFiles::open(&arguments.data)?;
    let mut opened = arguments.scene.open(backend, settings.size, arguments.machine, console)?;

    // Pictures of other programs are read as their frames come up.
    let readers: Vec<_> = pictures
        .iter()
        .map(|pictures| move |index: u32| pictures.file(settings.first_frame + index).map(read).transpose())
        .collect();
    let foreign: Vec<Foreign<'_>> = pictures
        .iter()
        .zip(&readers)
        .map(|(pictures, picture)| Foreign { name: pictures.name, picture })
        .collect();

    // All methods play the clip, once under each anti-aliasing; they share the truth.
    let mut measured = Vec::new();
    let mut judged = Vec::new();
    let mut true_pictures = Vec::new();
    let bar = console.bar();
    bar.expect(u64::from(frame_count) * (antialiasings.len() * seeds.contestants(&methods)) as u64);
    for &antialiasing in &antialiasings {
        let clip = Clip { settings, antialiasing, frame_count, keeps_frames: arguments.vdp };
        let timeline = Timeline::of(&settings, antialiasing, frame_count);
        let stage = &mut opened.stage;
        let (of_methods, of_others) =
            seeds.play(&clip, (backend, stage), &methods, &mut truths, &foreign, &bar)?;
        measured.extend(of_methods);
        judged.extend(of_others);
        if let Some(picture) = truths.first().and_then(|truth| truth.picture(timeline)) {
            true_pictures.push(TruthPicture::new(antialiasing, &picture)?);
        }
    }
    drop(bar);
    measured
        .iter()
        .map(Seeded::first)
        .filter_map(overflow_of_reference)
        .for_each(|warning| console.warn(warning));

    // Pictures are encoded once, for their files and for the page.
    let entries = measured.into_iter().map(Entry::new).collect::<anyhow::Result<Vec<_>>>()?;
    let patterns = pictures.iter().map(|pictures| pictures.pattern.display().to_string());
    let patterns = patterns.cycle().take(judged.len());
    let foreign_entries = judged.into_iter().zip(patterns);
    let foreign_entries = foreign_entries
        .map(|(judged, pattern)| ForeignEntry::new(judged, pattern))
        .collect::<anyhow::Result<Vec<_>>>()?;
    write_pictures(folder, &entries, &foreign_entries, &true_pictures)?;
    let run = setup::describe(backend, &arguments.scene, &opened, &settings, frame_count);
    let run = Run { seeds: arguments.seeds.count(), ..run };
    let rows = entries.iter().flat_map(|Entry { runs, .. }| {
        let row = |&reference: &Reference| {
            runs.try_map(|measured| ComparisonRow::new(measured, reference).ok_or(())).ok()
        };
        references.iter().filter_map(row)
    });
    let foreign_rows = foreign_entries.iter().flat_map(|ForeignEntry { judged, pattern, .. }| {
        let row = move |&reference: &Reference| {
            Seeded::of(vec![ComparisonRow::of_foreign(judged, pattern, reference)?])
        };
        references.iter().filter_map(row)
    });
    let rows = rows.chain(foreign_rows).map(Row).collect();
    let report = Comparison { run, reference: REFERENCE.to_owned(), rows };
    // What refers to the pictures comes last, so that an interrupted run leaves no report that lacks them.
    let page = Page {
        report: &report,
        references: &references,
        entries: &entries,
        foreign: &foreign_entries,
        true_pictures: &true_pictures,
        error_full_scale: ERROR_FULL_SCALE,
    };
    let page = page::comparison::text(&page)?;
    output::write_file(&folder.join("report.json"), json::text(&report)?.as_bytes())?;
    output::write_file(&folder.join("index.html"), page.as_bytes())?;
    let mut figures = figures(entries.iter().map(|entry| &entry.runs), true, &references);
    figures.add_foreign(foreign_entries.iter().map(|entry| &entry.judged), true);
    arguments.seeds.explain(&figures, console);
    data_files.write(&figures)?;
    if !data_files.is_stdout() {
        output::print(&Table::of(&figures).text())?;
    }
    console.note(format_args!("wrote {} and report.json beside it", folder.join("index.html").display()));
    Ok(())
}

/// Writes the pictures, and the error maps of those that have one.
fn write_pictures(
    folder: &Path,
    entries: &[Entry],
    foreign: &[ForeignEntry],
    truths: &[TruthPicture],
) -> anyhow::Result<()> {
    let write = |aa: &str, name: &str, picture: &[u8], error: Option<&[u8]>| -> anyhow::Result<()> {
        let stem = file_name_from(&format!("{aa}-{name}"));
        output::write_file(&folder.join(format!("{stem}.png")), picture)?;
        match error {
            Some(error) => output::write_file(&folder.join(format!("{stem}-error.png")), error),
            None => Ok(()),
        }
    };
    for entry @ Entry { picture_png, error_png, .. } in entries {
        let measured = entry.first();
        let (aa, method) = (measured.antialiasing.to_string(), measured.method.to_string());
        write(&aa, &method, picture_png, error_png.as_deref())?;
    }
    for ForeignEntry { judged, picture_png, error_png, .. } in foreign {
        let aa = judged.antialiasing.to_string();
        write(&aa, &judged.against_same.name, picture_png, Some(error_png))?;
    }
    truths.iter().try_for_each(|TruthPicture { aa, png }| write(aa, "truth", png, None))
}

/// The pictures of other programs, as far as can be told before the clip is rendered: their names are their
/// own, the files are there, and the first has the size of the clip.
fn foreign_pictures<'a>(
    arguments: &'a CompareArguments,
    methods: &[Method],
    settings: &Settings,
) -> anyhow::Result<Vec<FramePictures<'a>>> {
    // Names of files are made of them.
    let mut taken: Vec<String> = methods.iter().map(|method| file_name_from(&method.to_string())).collect();
    taken.push("truth".to_owned());
    let frame_count = arguments.frames.count();
    let judged = settings.first_frame + frame_count / 2..settings.first_frame + frame_count;
    let mut all = Vec::with_capacity(arguments.foreign.len());
    for named in &arguments.foreign {
        let stem = file_name_from(&named.name);
        if taken.contains(&stem) {
            let problem =
                format!("--with {}: there is a picture of that name already; give another", named.name);
            return Err(Misuse(problem).into());
        }
        taken.push(stem);
        let pictures = FramePictures::find(named, judged.clone())?;
        let (width, height) = read(pictures.first())?.colour.size();
        let [w, h] = settings.size;
        if [width, height] != [w, h] {
            let problem = format!(
                "{} is {width}x{height} and the comparison {w}x{h}: pictures are compared pixel by pixel; give --size {width}x{height}",
                pictures.first().display()
            );
            return Err(Misuse(problem).into());
        }
        all.push(pictures);
    }
    Ok(all)
}

fn read(path: &Path) -> sheer_lab::Result<Picture> {
    Ok(read_picture(path, TextureLimits::default())?)
}

/// The seeds of a comparison, and which of them share a reference.
struct Seeds {
    all: Vec<u32>,
    /// Whether even what is exact knows the seed, so that each has a reference and a truth of its own.
    apart: bool,
}

impl Seeds {
    fn new(arguments: &CompareArguments, settings: &Settings) -> Self {
        Self { all: arguments.seeds.from(settings.seed), apart: settings.shadow.is_random() }
    }

    /// Those that are rendered side by side.
    fn groups(&self) -> impl Iterator<Item = &[u32]> {
        self.all.chunks(if self.apart { 1 } else { self.all.len() })
    }

    /// How many pictures a frame takes.
    fn contestants(&self, methods: &[Method]) -> usize {
        self.groups().map(|seeds| 1 + (methods.len() - 1) * seeds.len()).sum()
    }

    /// The truth of each group, if it is asked for.
    fn truths(&self, references: &[Reference], settings: Settings) -> sheer_lab::Result<Vec<Truth>> {
        let truth = |seeds: &[u32]| Truth::among(references, Settings { seed: seeds[0], ..settings });
        self.groups().filter_map(|seeds| truth(seeds).transpose()).collect()
    }

    /// Plays a clip with all of them; pictures of other programs are held against the first reference.
    fn play<B: Backend>(
        &self,
        clip: &Clip,
        (backend, stage): (&B, &mut B::Stage),
        methods: &[Method],
        truths: &mut [Truth],
        foreign: &[Foreign<'_>],
        progress: &dyn Progress,
    ) -> sheer_lab::Result<(Vec<Seeded<Measured>>, Vec<ForeignJudged>)> {
        let mut truths = truths.iter_mut();
        let mut groups = self.groups().map(|seeds| {
            let settings = Settings { seed: seeds[0], ..clip.settings };
            (Clip { settings, ..*clip }, seeds, truths.next())
        });
        let Some((clip, seeds, truth)) = groups.next() else { return Ok(Default::default()) };
        let (mut all, judged) =
            clip.play_beside(backend, stage, (methods, seeds), truth, foreign, progress)?;
        for (clip, seeds, truth) in groups {
            let (more, _) = clip.play_beside(backend, stage, (methods, seeds), truth, &[], progress)?;
            for (runs, more) in all.iter_mut().zip(more) {
                runs.add(more.into_first());
            }
        }
        Ok((all, judged))
    }
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

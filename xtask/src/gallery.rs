//! `cargo xtask gallery DIR`: every scene file of a folder, rendered; a contact sheet to look at.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

use anyhow::{Context as _, ensure};
use clap::Args;
use image::{ExtendedColorType, ImageEncoder as _, codecs::jpeg::JpegEncoder};

use crate::workspace::{call, release_binary};

/// Render a folder of scenes.
#[derive(Args)]
pub(crate) struct Gallery {
    /// Folder with .gltf and .glb files, at any depth.
    folder: PathBuf,
    /// Where the sheet goes: OUT.md and a folder OUT with the pictures.
    #[arg(short, long, default_value = "docs/scenes")]
    out: PathBuf,
    /// Samples a pixel.
    #[arg(long, default_value_t = 32)]
    frames: u32,
    /// A second picture at this time, seconds, of files whose first one differs from it: shows what moves.
    #[arg(long, default_value_t = 0.6)]
    later: f32,
}

/// Good enough for a contact sheet, a tenth of a PNG.
const JPEG_QUALITY: u8 = 88;
const SIZE: &str = "384x216";

impl Gallery {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let mut files = Vec::new();
        collect(&self.folder, &mut files)?;
        files.sort();
        ensure!(!files.is_empty(), "{} holds no .gltf or .glb file", self.folder.display());
        call("cargo", &["build", "--release", "--package", "sheer"])?;
        fs::create_dir_all(&self.out).with_context(|| self.out.display().to_string())?;

        let name = self.out.file_name().context("--out has no name")?.to_string_lossy().into_owned();
        let mut sheet = format!(
            "# Scene files\n\nMade by `cargo xtask gallery DIR`: `baseline`, {} samples a pixel, the file's first camera or a made-up \
             three-quarter view. What moves is shown a second time {} s later.\n\n| file | at the start | later | remarks | credit |\n|---|---|---|---|---|\n",
            self.frames, self.later
        );
        let mut failed = Vec::new();
        for file in &files {
            let title = file.strip_prefix(&self.folder).unwrap_or(file).display().to_string();
            let stem =
                file.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
            let (first, second) =
                (self.out.join(format!("{stem}.jpg")), self.out.join(format!("{stem}-later.jpg")));
            let start = Instant::now();
            match self.picture(file, 0.0, &first) {
                Ok(remarks) => {
                    self.picture(file, self.later, &second)?;
                    let moves = fs::read(&first)? != fs::read(&second)?;
                    if !moves {
                        fs::remove_file(&second)?;
                    }
                    let credit = credit(file);
                    let later = if moves { format!("![]({name}/{stem}-later.jpg)") } else { String::new() };
                    sheet +=
                        &format!("| {title} | ![]({name}/{stem}.jpg) | {later} | {remarks} | {credit} |\n");
                    eprintln!("{title}: {:.1} s", start.elapsed().as_secs_f32());
                }
                Err(error) => {
                    eprintln!("{title}: {error:#}");
                    failed.push(title);
                }
            }
        }
        fs::write(self.out.with_extension("md"), sheet)?;
        ensure!(failed.is_empty(), "{} of {} files failed: {}", failed.len(), files.len(), failed.join(", "));
        Ok(())
    }

    /// Renders a file at a time into a JPEG; returns the renderer's warnings.
    fn picture(&self, file: &Path, time_secs: f32, out: &Path) -> anyhow::Result<String> {
        let png = out.with_extension("png");
        let mut command = Command::new(release_binary());
        command.arg("render").arg(file).args(["-m", "baseline", "-a", "accumulate", "--size", SIZE]);
        command
            .args(["--frames", &self.frames.to_string(), "--time", &time_secs.to_string(), "-o"])
            .arg(&png);
        let output = command.output()?;
        let talk = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        ensure!(output.status.success(), "{talk}");
        jpeg_from_png(&png, out)?;
        let lead = format!("sheer: warning: {}: ", file.display());
        let remarks =
            talk.lines().filter_map(|line| line.strip_prefix(&lead)).map(|line| line.replace('|', "\\|"));
        Ok(remarks.collect::<Vec<_>>().join("<br>"))
    }
}

/// Author and licence as a LICENSE.txt beside the file states them, in lines that begin with these words.
fn credit(file: &Path) -> String {
    let text = fs::read_to_string(file.with_file_name("LICENSE.txt")).unwrap_or_default();
    let line = |word: &str| text.lines().find_map(|line| line.strip_prefix(word)).map(str::trim);
    let parts = [line("Attribution:"), line("Licence (SPDX):")];
    parts.into_iter().flatten().collect::<Vec<_>>().join("; ").replace('|', "\\|")
}

/// Turns a PNG into a JPEG of another name.
pub(crate) fn jpeg_from_png(png: &Path, jpeg: &Path) -> anyhow::Result<()> {
    let picture = image::open(png)?.to_rgb8();
    fs::remove_file(png)?;
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY).write_image(
        &picture,
        picture.width(),
        picture.height(),
        ExtendedColorType::Rgb8,
    )?;
    fs::write(jpeg, bytes)?;
    Ok(())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "gltf" || extension == "glb") {
            files.push(path);
        }
    }
    Ok(())
}

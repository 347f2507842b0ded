//! From errors to messages and exit codes.

use std::{
    error::Error,
    io::{self, ErrorKind, Write as _},
    process::ExitCode,
};

use sheer_core::text::printable;
use sheer_gallery::GalleryError;
use sheer_gpu::GpuError;
use sheer_image::ImageError;
use sheer_lab::LabError;
use sheer_load::LoadError;
use sheer_render::RenderError;
use sheer_scene::SceneError;

/// Something was asked for that cannot be, whatever the state of the machine: exit code 2.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Misuse(pub(crate) String);

/// What the argument parser has to say: help and version are no errors, the rest is one line.
pub(crate) fn from_usage(usage: &clap::Error) -> anyhow::Result<()> {
    if !usage.use_stderr() {
        usage.print()?;
        return Ok(());
    }
    let text = usage.render().to_string();
    let said = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let said: Vec<&str> = said.filter(|line| !line.is_empty() && !line.starts_with("For more")).collect();
    let line = said.join(" ").replace(" tip: ", "; ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    Err(Misuse(format!("{line}; see --help")).into())
}

/// Prints an error as one line and gives its exit code.
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    if is_broken_pipe(error) {
        return ExitCode::SUCCESS;
    }
    let line = message(error).split_whitespace().collect::<Vec<_>>().join(" ");
    // Where even stderr is closed, only the exit code is left.
    let _ = writeln!(io::stderr(), "sheer: error: {}", printable(&line));
    if is_misuse(error) { ExitCode::from(2) } else { ExitCode::FAILURE }
}

/// What went wrong and why; library errors that already quote their cause do not quote it twice.
fn message(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |said, cause| match said.as_str() {
        "" => cause,
        _ if said.contains(&cause) => said,
        _ => format!("{said}: {cause}"),
    })
}

/// The reader of our output has seen enough, as `head` has after ten lines.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == ErrorKind::BrokenPipe)
}

fn is_misuse(error: &anyhow::Error) -> bool {
    error.chain().any(is_misuse_itself)
}

/// Whatever caused it.
fn is_misuse_itself(cause: &(dyn Error + 'static)) -> bool {
    cause.is::<Misuse>()
        || cause.downcast_ref().is_some_and(is_misuse_of_lab)
        || cause.downcast_ref().is_some_and(is_misuse_of_gpu)
        || cause.downcast_ref().is_some_and(is_misuse_of_renderer)
        || cause.downcast_ref().is_some_and(is_misuse_of_gallery)
        || cause.downcast_ref().is_some_and(is_misuse_of_scene)
        || cause.downcast_ref().is_some_and(is_misuse_of_image)
}

// Transparent errors stand in the chain for what they hold.

fn is_misuse_of_lab(error: &LabError) -> bool {
    match error {
        LabError::Misuse(_) => true,
        LabError::Backend(error) | LabError::Unsupported(error) => is_misuse_itself(error.as_ref()),
        LabError::Render(render) => is_misuse_of_renderer(render),
        LabError::Gallery(gallery) => is_misuse_of_gallery(gallery),
        LabError::Scene(scene) => is_misuse_of_scene(scene),
        LabError::Image(image) => is_misuse_of_image(image),
        _ => false,
    }
}

fn is_misuse_of_gpu(error: &GpuError) -> bool {
    match error {
        GpuError::Scene(scene) => is_misuse_of_scene(scene),
        GpuError::Image(image) => is_misuse_of_image(image),
        GpuError::Render(render) => is_misuse_of_renderer(render),
        _ => false,
    }
}

fn is_misuse_of_renderer(error: &RenderError) -> bool {
    match error {
        RenderError::ShadowMaps { .. } => true,
        RenderError::Scene(scene) => is_misuse_of_scene(scene),
        _ => false,
    }
}

fn is_misuse_of_gallery(error: &GalleryError) -> bool {
    match error {
        GalleryError::Unknown { .. } | GalleryError::Parameter { .. } => true,
        GalleryError::Load(file) => {
            matches!(file, LoadError::UnknownFormat { .. } | LoadError::NoChoice { .. })
        }
        GalleryError::Scene(scene) => is_misuse_of_scene(scene),
    }
}

fn is_misuse_of_scene(error: &SceneError) -> bool {
    matches!(error, SceneError::NoCamera { .. })
}

fn is_misuse_of_image(error: &ImageError) -> bool {
    matches!(error, ImageError::UnknownExtension { .. })
}

#[cfg(test)]
mod tests {
    use anyhow::Context as _;

    use super::*;

    #[test]
    fn a_cause_is_said_once() {
        let cause = io::Error::other("disk on fire");
        let quoting = LoadError::Read { path: "a.glb".into(), source: cause };
        assert_eq!(message(&quoting.into()), "cannot read a.glb: disk on fire");
        let silent = Err::<(), _>(io::Error::other("disk on fire")).context("cannot read a.glb");
        assert_eq!(message(&silent.unwrap_err()), "cannot read a.glb: disk on fire");
    }
}

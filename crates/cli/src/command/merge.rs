//! `sheer merge`: crops and sample ranges of a picture, or of the frames of a sequence, put together again.

use std::path::PathBuf;

use sheer_image::{Merged, Piece, TextureLimits, check_frames, merge};
use sheer_lab::Progress as _;

use crate::{args::MergeArguments, failure::Misuse, input::FramePieces, memory, output::PictureOutput};

pub(crate) fn run(arguments: &MergeArguments) -> anyhow::Result<()> {
    // What can go wrong goes wrong before the first pixel is decoded.
    let console = arguments.machine.apply()?;
    let (frames, first) = match FramePieces::find(&arguments.pieces)? {
        Some(FramePieces { first, frames }) => (frames, Some(first)),
        None => (vec![arguments.pieces.clone()], None),
    };
    let output = output(arguments, first.is_some())?;
    output.check(first.unwrap_or(0))?;
    let numbered = || (first.unwrap_or(0)..).zip(&frames);
    for (number, pieces) in numbered() {
        if pieces.contains(&output.path(number)) {
            let problem =
                format!("{} is one of the pieces: give -o another name", output.path(number).display());
            return Err(Misuse(problem).into());
        }
    }
    memory::start("merge");
    let limits = || TextureLimits { max_bytes: memory::left_by_the_program().0, ..TextureLimits::default() };
    if first.is_some() {
        check_frames(&frames, limits())?;
    }

    let bar = console.bar();
    bar.expect(frames.len() as u64);
    let mut size = (0, 0);
    for (number, pieces) in numbered() {
        let Merged { planes, share, metadata } = merge(pieces, limits())?;
        size = planes.colour.size();
        let whole = Piece::whole([size.0, size.1]);
        output.write(number, &planes, &whole, arguments.tone.tone(), &share, &metadata)?;
        bar.step();
    }
    drop(bar);
    let (width, height) = size;
    let of = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let pieces = of(arguments.pieces.len(), "piece");
    let path = arguments.output.display();
    match first {
        Some(_) => {
            let frames = of(frames.len(), "frame");
            console.note(format_args!("wrote {path}: {width}x{height}, {frames} of {pieces}"));
        }
        None => console.note(format_args!("wrote {path}: {width}x{height} of {pieces}")),
    }
    Ok(())
}

/// Where the picture goes, or every one of a sequence.
fn output(arguments: &MergeArguments, is_sequence: bool) -> Result<PictureOutput, Misuse> {
    let path: &PathBuf = &arguments.output;
    match PictureOutput::from_path(path) {
        sequence @ PictureOutput::Sequence { .. } if is_sequence => Ok(sequence),
        PictureOutput::Sequence { .. } => Err(Misuse(format!(
            "{}: the pieces are those of one picture; leave the place of a number out of its name, or give pieces with ####",
            path.display()
        ))),
        _ if is_sequence => Err(Misuse(format!(
            "{}: the pieces are those of a sequence; put #### into its name for the number of the frame",
            path.display()
        ))),
        _ => Ok(PictureOutput::Single(path.clone())),
    }
}

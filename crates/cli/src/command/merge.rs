//! `sheer merge`: crops and sample ranges of a picture, put together again.

use sheer_image::{Merged, Piece, TextureLimits, merge};

use crate::{args::MergeArguments, memory, output::PictureOutput};

pub(crate) fn run(arguments: &MergeArguments) -> anyhow::Result<()> {
    let console = arguments.machine.apply()?;
    let output = PictureOutput::Single(arguments.output.clone());
    output.check(0)?;
    memory::start("merge");
    let limits = TextureLimits { max_bytes: memory::left_by_the_program().0, ..TextureLimits::default() };
    let Merged { planes, share, metadata } = merge(&arguments.pieces, limits)?;
    let (width, height) = planes.colour.size();
    output.write(0, &planes, &Piece::whole([width, height]), arguments.tone.tone(), &share, &metadata)?;
    let count = arguments.pieces.len();
    console.note(format_args!(
        "wrote {}: {width}x{height} of {count} piece{}",
        arguments.output.display(),
        if count == 1 { "" } else { "s" }
    ));
    Ok(())
}

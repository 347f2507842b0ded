//! `sheer merge`: crops and sample ranges of a picture, put together again.

use sheer_core::parameter::Choice as _;
use sheer_image::{FileFormat, Merged, Piece, TextureLimits, Tone, merge};

use crate::{args::MergeArguments, memory, output::PictureOutput};

pub(crate) fn run(arguments: &MergeArguments) -> anyhow::Result<()> {
    let console = arguments.machine.apply()?;
    let output = PictureOutput::Single(arguments.output.clone());
    let format = output.check(0)?;
    memory::start("merge");
    let limits = TextureLimits { max_bytes: memory::left_by_the_program().0, ..TextureLimits::default() };
    let Merged { planes, share, metadata } = merge(&arguments.pieces, limits)?;
    let tone = Tone { curve: arguments.tone, exposure_ev: arguments.exposure };
    let metadata = match format {
        FileFormat::Png => metadata.with("tone", tone.curve.word()).with("exposure_ev", tone.exposure_ev),
        FileFormat::Exr => metadata,
    };
    let (width, height) = planes.colour.size();
    output.write(0, &planes, &Piece::whole([width, height]), tone, &share, &metadata)?;
    let count = arguments.pieces.len();
    console.note(format_args!(
        "wrote {}: {width}x{height} of {count} piece{}",
        arguments.output.display(),
        if count == 1 { "" } else { "s" }
    ));
    Ok(())
}

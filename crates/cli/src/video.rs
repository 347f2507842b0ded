//! Clips as video: an installed ffmpeg takes the frames as they come, so that none of them is kept, and makes
//! a file that gets its name when it is whole.

use std::{
    fs::File,
    io::{self, Read as _, Seek as _, Write as _},
    path::Path,
    process::{Child, ChildStdin, Command, ExitStatus, Stdio},
    sync::{Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};

use anyhow::{Context as _, anyhow, bail};
use sheer_core::text::beginning;
use sheer_image::{Image, ImageError, Metadata, temporary_beside};
use tempfile::TempPath;

/// The program that makes videos.
const ENCODER: &str = "ffmpeg";
/// Characters of what it says when it fails.
const LONGEST_WORDS: usize = 400;
/// From one look at whether it has ended to the next.
const LOOK_AGAIN: Duration = Duration::from_millis(10);

/// What a video file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VideoFormat {
    /// H.264.
    Mp4,
    /// VP9.
    WebM,
}

impl VideoFormat {
    /// By the ending of the file, in upper or lower case.
    pub(crate) fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mp4" => Some(Self::Mp4),
            "webm" => Some(Self::WebM),
            _ => None,
        }
    }

    /// What ffmpeg has to be built with.
    fn encoder(self) -> &'static str {
        match self {
            Self::Mp4 => "libx264",
            Self::WebM => "libvpx-vp9",
        }
    }
}

/// What the frames of a video have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VideoStream {
    /// What the file is.
    pub(crate) format: VideoFormat,
    /// Width and height, pixels; even in MP4.
    pub(crate) size: [u32; 2],
    /// At which they are played.
    pub(crate) frames_per_sec: f32,
    /// Whether something is seen through them, which WebM alone holds.
    pub(crate) has_alpha: bool,
}

impl VideoStream {
    /// The arguments of ffmpeg, but for the file.
    fn arguments(&self, metadata: &Metadata) -> Vec<String> {
        let Self { format, size: [width, height], frames_per_sec, has_alpha } = self;
        let (given, kept) = if *has_alpha { ("rgba", "yuva420p") } else { ("rgb0", "yuv420p") };
        let encoder = format.encoder();
        // Frames as they are in memory. Colour is turned by the matrix of high definition, which is the one
        // that players take for granted in pictures of today's sizes; ffmpeg would take that of old
        // television. The curve is that of sRGB and stays.
        let mut arguments = format!(
            "-hide_banner -loglevel error -nostdin -y \
             -f rawvideo -pixel_format {given} -video_size {width}x{height} -framerate {frames_per_sec} -i pipe:0 \
             -vf scale=out_color_matrix=bt709:out_range=tv,format={kept} \
             -colorspace bt709 -color_primaries bt709 -color_trc iec61966-2-1 -color_range tv -c:v {encoder}"
        );
        // Of constant quality, for the eye rather than for a small file; the index comes first in MP4, so
        // that browsers begin at once.
        arguments += match format {
            VideoFormat::Mp4 => " -preset medium -crf 16 -movflags +faststart -f mp4",
            VideoFormat::WebM => " -crf 20 -b:v 0 -row-mt 1 -f webm",
        };
        let made = metadata.entries().map(|(key, text)| format!("{key}={text}")).collect::<Vec<_>>();
        let arguments = arguments.split_whitespace().map(str::to_owned);
        arguments.chain(["-metadata".to_owned(), format!("comment=Sheer: {}", made.join("; "))]).collect()
    }
}

/// A video that is being made. Dropped before its end, it leaves nothing.
#[derive(Debug)]
pub(crate) struct Video<'p> {
    path: &'p Path,
    format: VideoFormat,
    /// Closed at the end.
    frames: Option<ChildStdin>,
    /// What ffmpeg says: in a file, since nobody reads a pipe while frames are rendered.
    words: File,
}

impl<'p> Video<'p> {
    /// Starts ffmpeg. There is one video at a time.
    ///
    /// # Errors
    /// There is no ffmpeg, or no file can be made beside `path`.
    pub(crate) fn start(path: &'p Path, stream: VideoStream, metadata: &Metadata) -> anyhow::Result<Self> {
        let words = tempfile::tempfile().context("cannot make a temporary file; set TMPDIR to a folder")?;
        // From here on an interruption finds either nothing or both, ffmpeg and its file.
        let mut at_work = at_work();
        let file = temporary_beside(path)?.into_temp_path();
        let mut command = Command::new(ENCODER);
        command.args(stream.arguments(metadata)).arg(&file);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(words.try_clone()?);
        // Ctrl-C is for us, who end ffmpeg.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut encoder = match command.spawn() {
            Ok(encoder) => encoder,
            Err(error) if error.kind() == io::ErrorKind::NotFound => bail!(
                "cannot make {}: there is no {ENCODER} on the path; install it (apt install ffmpeg, brew install ffmpeg, winget \
                 install ffmpeg), or write the frames with -o \"NAME-####.png\"",
                path.display()
            ),
            Err(error) => bail!("cannot make {}: cannot run {ENCODER}: {error}", path.display()),
        };
        let frames = encoder.stdin.take();
        *at_work = Some(Encoding { encoder: Encoder(encoder), file });
        Ok(Self { path, format: stream.format, frames, words })
    }

    /// Takes the next frame, sRGB with straight alpha.
    ///
    /// # Errors
    /// ffmpeg has ended, in its words.
    pub(crate) fn add(&mut self, frame: &Image<[u8; 4]>) -> anyhow::Result<()> {
        let taken = self.frames.as_mut().map(|frames| frames.write_all(frame.as_slice().as_flattened()));
        match taken {
            Some(Ok(())) => Ok(()),
            _ => Err(self.failure()),
        }
    }

    /// Ends the video and gives it its name.
    ///
    /// # Errors
    /// ffmpeg fails, in its words, or the file cannot be renamed.
    pub(crate) fn finish(mut self) -> anyhow::Result<()> {
        drop(self.frames.take());
        if !end_of_encoder()?.success() {
            return Err(self.failure());
        }
        let mut at_work = at_work();
        if let Some(Encoding { file, .. }) = at_work.take() {
            let failed = |error: tempfile::PathPersistError| error.error;
            let renamed = file.persist(self.path).map_err(failed);
            renamed.map_err(|source| ImageError::Write { path: self.path.to_owned(), source })?;
        }
        Ok(())
    }

    /// What ffmpeg has said at its end.
    fn failure(&mut self) -> anyhow::Error {
        drop(self.frames.take());
        let ended = end_of_encoder().map_or_else(|error| error.to_string(), |status| status.to_string());
        let mut words = Vec::new();
        let is_read = self.words.rewind().and_then(|()| self.words.read_to_end(&mut words)).is_ok();
        let words = String::from_utf8_lossy(&words).split_whitespace().collect::<Vec<_>>().join(" ");
        let said = if is_read && !words.is_empty() { beginning(&words, LONGEST_WORDS) } else { ended };
        let (path, encoder) = (self.path.display(), self.format.encoder());
        let advice = if words.contains("Unknown encoder") {
            format!("; install one that is built with {encoder}, as that of apt install ffmpeg")
        } else {
            String::new()
        };
        anyhow!("cannot make {path}: {ENCODER} failed: {said}{advice}")
    }
}

impl Drop for Video<'_> {
    fn drop(&mut self) {
        drop(at_work().take());
    }
}

/// ffmpeg and the file that it writes, which has a name of its own until it is whole.
#[derive(Debug)]
struct Encoding {
    /// Ends before the file goes.
    encoder: Encoder,
    file: TempPath,
}

/// An ffmpeg that ends with its owner.
#[derive(Debug)]
struct Encoder(Child);

impl Drop for Encoder {
    fn drop(&mut self) {
        // One that has ended is not there to be told.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What is being encoded; held for moments only, so that an interruption can come between.
static AT_WORK: Mutex<Option<Encoding>> = Mutex::new(None);

fn at_work() -> MutexGuard<'static, Option<Encoding>> {
    // An encoding is there or not, whatever panicked.
    AT_WORK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends ffmpeg and removes what it has written: for whoever is about to end the program on the spot. As long
/// as the result is held, nobody notices and calls it a failure.
pub(crate) fn abandon() -> impl Sized {
    // Who holds the lock may be who is about to end the program.
    const TRIES: u32 = 100;
    for _ in 0..TRIES {
        if let Ok(mut at_work) = AT_WORK.try_lock() {
            drop(at_work.take());
            return Some(at_work);
        }
        thread::sleep(LOOK_AGAIN);
    }
    None
}

/// Waits until ffmpeg has ended.
fn end_of_encoder() -> io::Result<ExitStatus> {
    loop {
        let looked = at_work().as_mut().map(|Encoding { encoder, .. }| encoder.0.try_wait());
        match looked {
            Some(Ok(Some(status))) => return Ok(status),
            Some(Ok(None)) => thread::sleep(LOOK_AGAIN),
            Some(Err(error)) => return Err(error),
            None => return Err(io::ErrorKind::NotFound.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments(format: VideoFormat, has_alpha: bool) -> String {
        let stream = VideoStream { format, size: [64, 36], frames_per_sec: 23.976, has_alpha };
        stream.arguments(&Metadata::default().with("scene", "my model.glb").with("seed", 0)).join("\n")
    }

    #[test]
    fn a_video_is_known_by_its_ending() {
        let format = |name: &str| VideoFormat::from_path(Path::new(name));
        assert_eq!([format("a.mp4"), format("a/b.WebM")], [Some(VideoFormat::Mp4), Some(VideoFormat::WebM)]);
        assert_eq!([format("a.png"), format("mp4"), format("a.mp4.exr")], [None; 3]);
    }

    #[test]
    fn frames_are_told_as_they_are_and_kept_as_players_want_them() {
        let mp4 = arguments(VideoFormat::Mp4, false);
        let told = [
            "rawvideo\n-pixel_format\nrgb0\n-video_size\n64x36\n-framerate\n23.976\n",
            "format=yuv420p\n",
            "libx264",
        ];
        assert!(told.iter().all(|words| mp4.contains(words)), "{mp4}");
        assert!(mp4.ends_with("\ncomment=Sheer: scene=my model.glb; seed=0"), "{mp4}");
        let webm = arguments(VideoFormat::WebM, true);
        let told = ["-pixel_format\nrgba\n", "format=yuva420p\n", "libvpx-vp9"];
        assert!(told.iter().all(|words| webm.contains(words)), "{webm}");
    }
}

//! What is said to people, on stderr.

use std::{
    fmt::Display,
    io::{self, Write as _},
    time::Duration,
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// How much is said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Talk {
    /// Only errors.
    pub(crate) quiet: bool,
}

impl Talk {
    /// Says how it went.
    pub(crate) fn note(self, text: impl Display) {
        self.line(format_args!("sheer: {text}"));
    }

    /// Says what is shown differently from what was meant.
    pub(crate) fn warn(self, text: impl Display) {
        self.line(format_args!("sheer: warning: {text}"));
    }

    fn line(self, text: impl Display) {
        if !self.quiet {
            // A closed stderr is no reason to stop rendering.
            let _ = writeln!(io::stderr(), "{text}");
        }
    }

    /// A count of frames, where no one knows how many there will be; on a terminal only.
    pub(crate) fn frames(self) -> ProgressBar {
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let style = ProgressStyle::with_template("{msg}{spinner} {pos} frames, {elapsed}");
        let style = style.expect("the template names known fields");
        let bar = ProgressBar::with_draw_target(None, target).with_style(style);
        bar.enable_steady_tick(Duration::from_millis(500));
        bar
    }

    /// A bar with the time left; on a terminal only.
    pub(crate) fn progress(self, steps: u64) -> ProgressBar {
        // indicatif draws nothing where stderr is not a terminal.
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let style = ProgressStyle::with_template("{msg}{wide_bar} {pos}/{len}  {eta} left");
        let style = style.expect("the template names known fields").progress_chars("━╸ ");
        let bar = ProgressBar::with_draw_target(Some(steps), target).with_style(style);
        bar.enable_steady_tick(Duration::from_millis(500));
        bar
    }
}

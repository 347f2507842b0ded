//! What is said to people on stderr: notes, warnings, progress. Machine output goes to stdout (`output`), and
//! so does progress that a render farm listens for.

use std::{
    cell::Cell,
    fmt::Display,
    io::{self, Write as _},
    time::Duration,
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sheer_core::text::printable;
use sheer_lab::Progress;

use crate::args::ProgressForm;

/// Talks to whoever runs the program, or does not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    /// Says nothing but errors, which go another way (`failure`).
    pub(crate) quiet: bool,
    /// How it tells how far something is.
    pub(crate) progress: ProgressForm,
}

impl Console {
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
            // Names out of files are a part of it. A closed stderr is no reason to stop rendering.
            let _ = writeln!(io::stderr(), "{}", printable(&text.to_string()));
        }
    }

    /// A bar with the time left; on a terminal only.
    pub(crate) fn bar(self) -> Bar {
        let template = "{msg}{wide_bar} {pos}/{len}  {eta} left";
        self.show(Some(0), template)
    }

    /// A count of frames, where no one knows how many there will be; on a terminal only.
    pub(crate) fn counter(self) -> Bar {
        self.show(None, "{msg}{spinner} {pos} frames, {elapsed}")
    }

    fn show(self, length: Option<u64>, template: &str) -> Bar {
        // indicatif draws nothing where stderr is not a terminal.
        let is_drawn = !self.quiet && self.progress == ProgressForm::Bar;
        let target = if is_drawn { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template(template).expect("the template names known fields");
        let bar = ProgressBar::with_draw_target(length, target).with_style(style.progress_chars("━╸ "));
        bar.enable_steady_tick(Duration::from_millis(500));
        Bar { console: self, bar, told_percent: Cell::new(None) }
    }
}

/// How far something is, on a terminal; gone when dropped.
#[derive(Debug)]
pub(crate) struct Bar {
    console: Console,
    bar: ProgressBar,
    /// What was said last in lines.
    told_percent: Cell<Option<u64>>,
}

impl Bar {
    /// A line for programs, with every per cent that is new.
    fn tell(&self) {
        let (Some(expected @ 1..), done) = (self.bar.length(), self.bar.position()) else { return };
        let percent = 100 * done / expected;
        if self.told_percent.replace(Some(percent)) == Some(percent) {
            return;
        }
        // Whoever has stopped listening is no reason to stop rendering.
        let _ = match self.console.progress {
            ProgressForm::Bar => Ok(()),
            ProgressForm::Json => {
                writeln!(io::stdout(), r#"{{"percent":{percent},"done":{done},"expected":{expected}}}"#)
            }
            ProgressForm::Openjd => writeln!(io::stdout(), "openjd_progress: {percent}"),
        };
    }
}

impl Progress for Bar {
    fn expect(&self, steps: u64) {
        // What only counts has no length.
        if self.bar.length().is_some() {
            self.bar.inc_length(steps);
        }
    }

    fn name(&self, what: &str) {
        self.bar.set_message(format!("{what:<18}"));
    }

    fn step(&self) {
        self.bar.inc(1);
        self.tell();
    }

    fn note(&self, text: &str) {
        self.bar.suspend(|| self.console.note(text));
    }

    fn warn(&self, text: &str) {
        self.bar.suspend(|| self.console.warn(text));
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

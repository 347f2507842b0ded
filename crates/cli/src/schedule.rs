//! Which frames of a sequence are rendered: those that are to be written, and those before them that a
//! history over time needs.

use std::ops::Range;

/// Frames that are rendered one after the other, of which some are written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Stretch {
    /// Those that are rendered.
    pub(crate) rendered: Range<u32>,
    /// Those that are written: the last one that is rendered among them, ascending.
    pub(crate) written: Vec<u32>,
}

/// How much of the past a frame shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Memory {
    /// Of frames before it, so many at most are rendered for its sake; 0 where it stands for itself.
    Frames(u32),
    /// Everything since the first frame of the run, as a mean has it.
    Run,
}

/// The stretches in which frames of a run are rendered, of which those are written that `is_wanted` wants.
pub(crate) fn stretches(run: Range<u32>, memory: Memory, is_wanted: impl Fn(u32) -> bool) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for frame in run.clone().filter(|&frame| is_wanted(frame)) {
        let begin = match memory {
            Memory::Frames(before) => frame.saturating_sub(before),
            Memory::Run => run.start,
        };
        match stretches.last_mut() {
            // What is needed for this frame has been rendered in part already: go on from there.
            Some(last) if begin <= last.rendered.end => {
                last.rendered.end = frame + 1;
                last.written.push(frame);
            }
            _ => stretches.push(Stretch { rendered: begin..frame + 1, written: vec![frame] }),
        }
    }
    stretches
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(rendered: Range<u32>, written: impl IntoIterator<Item = u32>) -> Stretch {
        Stretch { rendered, written: written.into_iter().collect() }
    }

    #[test]
    fn a_run_begins_as_much_earlier_as_its_frames_remember() {
        let all = |_| true;
        assert_eq!(stretches(10..14, Memory::Frames(0), all), [stretch(10..14, 10..14)]);
        assert_eq!(stretches(10..14, Memory::Frames(4), all), [stretch(6..14, 10..14)]);
        assert_eq!(stretches(10..14, Memory::Frames(32), all), [stretch(0..14, 10..14)]);
        assert_eq!(stretches(10..14, Memory::Run, all), [stretch(10..14, 10..14)]);
    }

    #[test]
    fn what_is_there_is_rendered_only_for_what_follows() {
        let missing = |frame| matches!(frame, 3 | 12 | 13);
        let by_themselves = [stretch(3..4, [3]), stretch(12..14, [12, 13])];
        assert_eq!(stretches(0..20, Memory::Frames(0), missing), by_themselves);
        assert_eq!(
            stretches(0..20, Memory::Frames(4), missing),
            [stretch(0..4, [3]), stretch(8..14, [12, 13])]
        );
        assert_eq!(stretches(0..20, Memory::Frames(9), missing), [stretch(0..14, [3, 12, 13])]);
        assert_eq!(stretches(2..20, Memory::Run, missing), [stretch(2..14, [3, 12, 13])]);
        assert!(stretches(0..20, Memory::Frames(9), |_| false).is_empty());
    }
}

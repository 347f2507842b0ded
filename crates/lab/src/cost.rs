//! What frames cost, without anything being added up over time.

use sheer_render::{Antialiasing, Backend, Method, Settings, backend::StepClock};

use crate::{
    Progress, Result, Tally, Timeline,
    play::{Event, pipelines, play},
};

/// The cost of each frame under each method, all in turn at each frame. `warms_up`: the first frame is
/// rendered once more before, so that tables are built, memory is touched and the processor has left its
/// sleep.
///
/// # Errors
/// What the backend says.
pub fn measure_cost<B: Backend>(
    backend: &B,
    stage: &mut B::Stage,
    methods: &[Method],
    settings: Settings,
    timeline: Timeline<'_>,
    warms_up: bool,
    progress: &dyn Progress,
) -> Result<Vec<Tally>> {
    // The cost of adding frames up is no part of a frame's time (STD section 4), so they are not added up.
    let mut pipelines = pipelines(backend, methods, Antialiasing::NONE, settings)?;
    pipelines.iter().flat_map(|pipeline| backend.notes(pipeline)).for_each(|note| progress.warn(note));
    progress.expect(u64::from(timeline.frames() + u32::from(warms_up)) * methods.len() as u64);
    let mut tallies = vec![Tally::default(); methods.len()];

    if warms_up {
        let first = match timeline {
            Timeline::Clock(clock, frames) => Timeline::Clock(clock, frames.min(1)),
            Timeline::Moments(moments) => Timeline::Moments(&moments[..moments.len().min(1)]),
            Timeline::Still(frames) => Timeline::Still(frames.min(1)),
        };
        play(backend, stage, &mut pipelines, first, |event| {
            if matches!(event, Event::Rendered { .. }) {
                progress.step();
            }
            Ok(())
        })?;
    }
    play(backend, stage, &mut pipelines, timeline, |event| {
        if let Event::Rendered { at, pipeline, cost } = event {
            tallies[at].add(cost);
            // Times of all threads together would not add up to the frame's.
            if backend.step_clock() == StepClock::Device {
                tallies[at].add_steps(backend.steps(pipeline));
            }
            progress.step();
        }
        Ok(())
    })?;
    Ok(tallies)
}

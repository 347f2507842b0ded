//! What frames cost.

use sheer_render::{Antialiasing, Backend, Method, Settings, backend::StepClock};

use crate::{
    Progress, Result, Tally, Timeline,
    play::{Event, pipelines, play},
};

/// The cost of each frame with each method under its anti-aliasing, all in turn at each frame, whatever
/// moment the anti-aliasing would have a frame show. `warms_up`: the first frame is rendered once more
/// before, so that tables are built, memory is touched and the processor has left its sleep. `progress` hears
/// a step a frame and method, that first frame among them.
///
/// # Errors
/// What the backend says.
pub fn measure_cost<B: Backend>(
    backend: &B,
    stage: &mut B::Stage,
    methods: &[(&Method, Antialiasing)],
    settings: Settings,
    timeline: Timeline<'_>,
    warms_up: bool,
    progress: &dyn Progress,
) -> Result<Vec<Tally>> {
    let mut pipelines = Vec::new();
    for &(method, antialiasing) in methods {
        pipelines.extend(self::pipelines(backend, [method], antialiasing, settings)?);
    }
    // Under another anti-aliasing a method has the same to say.
    let first = methods.first().map(|(_, antialiasing)| *antialiasing);
    for (pipeline, _) in pipelines.iter().zip(methods).filter(|(_, (_, own))| Some(*own) == first) {
        backend.notes(pipeline).iter().for_each(|note| progress.warn(note));
    }
    let mut tallies = vec![Tally::default(); pipelines.len()];

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

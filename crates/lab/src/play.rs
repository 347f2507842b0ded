//! The one loop of every measurement: advance the stage, render, read.

use sheer_image::Planes;
use sheer_render::{Antialiasing, Backend, Clock, Counters, Method, Moment, Settings, Timings};

use crate::{LabError, Result};

/// Which moments are rendered, one frame each.
#[derive(Clone, Copy, Debug)]
pub enum Timeline<'m> {
    /// So many frames of a clock, from its first.
    Clock(Clock, u32),
    /// These.
    Moments(&'m [Moment]),
    /// So many frames of the moment that the stage is at, which is not advanced.
    Still(u32),
}

impl Timeline<'_> {
    /// The frames of a run.
    #[must_use]
    pub fn of(settings: &Settings, antialiasing: Antialiasing, frames: u32) -> Self {
        Self::Clock(Clock::new(settings, antialiasing), frames)
    }

    /// How many frames it has.
    #[must_use]
    pub fn frames(&self) -> u32 {
        match *self {
            Self::Clock(_, frames) | Self::Still(frames) => frames,
            Self::Moments(moments) => moments.len() as u32,
        }
    }

    /// Where the stage is taken for a frame.
    pub(crate) fn moment(&self, index: u32) -> Option<Moment> {
        match self {
            Self::Clock(clock, _) => Some(clock.at(index)),
            Self::Moments(moments) => Some(moments[index as usize]),
            Self::Still(_) => None,
        }
    }
}

/// What [`play`] has just done.
#[derive(Debug)]
pub enum Event<'p, B: Backend> {
    /// One of the pipelines has rendered the frame.
    Rendered {
        /// Which of them.
        at: usize,
        /// It.
        pipeline: &'p B::Pipeline,
        /// What the frame cost.
        cost: (Counters, Timings),
    },
    /// All pipelines have rendered the frame.
    Frame {
        /// Which frame, counted from the first.
        index: u32,
        /// In the order in which they were given.
        pipelines: &'p [B::Pipeline],
        /// At the moment of the frame.
        stage: &'p B::Stage,
    },
}

/// Renders the frames of a timeline, all pipelines in turn at each of them, so that a change in the machine's
/// speed meets all and no clip has to be kept. `watch` is called after every picture and after every frame.
///
/// # Errors
/// What the backend or `watch` says.
pub fn play<B: Backend>(
    backend: &B,
    stage: &mut B::Stage,
    pipelines: &mut [B::Pipeline],
    timeline: Timeline<'_>,
    mut watch: impl FnMut(Event<'_, B>) -> Result<()>,
) -> Result<()> {
    let failed = |error| LabError::of_backend(backend, error);
    for index in 0..timeline.frames() {
        if let Some(moment) = timeline.moment(index) {
            backend.advance(stage, moment).map_err(failed)?;
        }
        for turn in 0..pipelines.len() {
            // No pipeline is always the first after the change of frame.
            let at = (turn + index as usize) % pipelines.len();
            let cost = backend.render(&mut pipelines[at], stage, index).map_err(failed)?;
            watch(Event::Rendered { at, pipeline: &pipelines[at], cost })?;
        }
        watch(Event::Frame { index, pipelines, stage })?;
    }
    Ok(())
}

/// Prepares methods that differ in nothing else.
pub(crate) fn pipelines<'m, B: Backend>(
    backend: &B,
    methods: impl IntoIterator<Item = &'m Method>,
    antialiasing: Antialiasing,
    settings: Settings,
) -> Result<Vec<B::Pipeline>> {
    let pipeline = |method| backend.pipeline(method, antialiasing, settings);
    let pipelines = methods.into_iter().map(pipeline).collect::<Result<_, _>>();
    pipelines.map_err(|error| LabError::of_backend(backend, error))
}

/// The last picture of a run of one method, and what its frames cost together.
///
/// # Errors
/// What the backend says.
pub fn picture<B: Backend>(
    backend: &B,
    stage: &mut B::Stage,
    method: &Method,
    antialiasing: Antialiasing,
    settings: Settings,
    frames: u32,
) -> Result<(Planes, Counters)> {
    let mut pipelines = pipelines(backend, [method], antialiasing, settings)?;
    let mut counters = Counters::default();
    let timeline = Timeline::of(&settings, antialiasing, frames);
    play(backend, stage, &mut pipelines, timeline, |event| {
        if let Event::Rendered { cost: (of_frame, _), .. } = event {
            counters = counters + of_frame;
        }
        Ok(())
    })?;
    let planes = backend.planes(&pipelines[0]).map_err(|error| LabError::of_backend(backend, error))?;
    Ok((planes.into_owned(), counters))
}

#[cfg(test)]
mod tests {
    use sheer_render::{Stage, backend::Cpu};

    use super::*;

    #[test]
    fn pipelines_take_turns_and_see_the_same_moments() {
        let scene = sheer_gallery::open("layers:count=1").unwrap().scene;
        let mut stage = Stage::new(scene, &Default::default(), Some(1)).unwrap();
        let settings = Settings { size: [4, 2], ..Settings::default() };
        let methods = ["std", "roulette"].map(|name| name.parse::<Method>().unwrap());
        let mut both = pipelines(&Cpu, &methods, Antialiasing::NONE, settings).unwrap();
        let mut order = Vec::new();
        let mut frames = Vec::new();
        play(&Cpu, &mut stage, &mut both, Timeline::of(&settings, Antialiasing::NONE, 3), |event| {
            match event {
                Event::Rendered { at, .. } => order.push(at),
                Event::Frame { index, pipelines, .. } => frames.push((index, pipelines.len())),
            }
            Ok(())
        })
        .unwrap();
        assert_eq!(order, [0, 1, 1, 0, 0, 1]);
        assert_eq!(frames, [(0, 2), (1, 2), (2, 2)]);
    }

    #[test]
    fn a_stage_is_left_where_it_is_or_taken_where_it_is_told() {
        let scene = sheer_gallery::open("arena").unwrap().scene;
        let mut stage = Stage::new(scene, &Default::default(), Some(1)).unwrap();
        let settings = Settings { size: [4, 2], ..Settings::default() };
        let method = "std".parse::<Method>().unwrap();
        let mut corner = |timeline: Timeline<'_>| {
            let mut one = pipelines(&Cpu, [&method], Antialiasing::NONE, settings).unwrap();
            play(&Cpu, &mut stage, &mut one, timeline, |_| Ok(())).unwrap();
            stage.frame().triangles()[stage.frame().static_count()]
        };
        let later = [Moment { time_secs: 5.0, previous_secs: 5.0 }];
        let first = corner(Timeline::Still(2));
        let moved = corner(Timeline::Moments(&later));
        assert_ne!(first, moved);
        assert_eq!(corner(Timeline::Still(1)), moved);
    }
}

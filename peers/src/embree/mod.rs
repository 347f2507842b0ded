//! Embree 4: single rays, packets without and with the COHERENT flag, continuation rays. Packets have the
//! most rays for which the processor has a traversal, 16 with AVX-512 and 8 with AVX2: Embree takes wider
//! ones apart into single rays.
//!
//! Geometry has build quality MEDIUM, as HIGH splits triangles and may show a filter one hit twice. Opacity
//! is asked for by filter functions given as arguments of the query; they are compiled for each question, so
//! that what they cost is Embree's call and nothing of ours.
#![expect(unsafe_code, reason = "calls through a C interface")]

mod library;

use std::{path::Path, ptr};

use anyhow::{Context as _, ensure};
use library::{
    Arguments, Context, FilterArguments, Handle, Library, PacketFunctions, Ray1, RayHit1, RayHits, Rays,
    Valid,
};

use crate::rays::{Answer, Composite, LEAST_TRANSMITTANCE, Layer, Question, Scene, Workload, composite};

/// The library with a device of its own.
pub(crate) struct Embree {
    library: Library,
    device: Handle,
}

impl Embree {
    /// Looks for the library below a folder, such as that of the wheel `embreex`.
    pub(crate) fn load(folder: &Path) -> anyhow::Result<Self> {
        let path = library::find(folder).with_context(|| {
            format!(
                "there is no libembree4*.so below {}: install the Python wheel `embreex` there",
                folder.display()
            )
        })?;
        let library = Library::load(&path)?;
        // SAFETY: a null configuration asks for the defaults.
        let device = unsafe { (library.new_device)(ptr::null()) };
        let embree = Self { library, device };
        ensure!(!device.is_null(), "{} makes no device: is it built for this processor?", path.display());
        ensure!(
            embree.property(library::DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) != 0,
            "{} is built without filter functions",
            path.display()
        );
        Ok(embree)
    }

    /// `4.4.0`.
    pub(crate) fn version(&self) -> String {
        let version = self.property(library::DEVICE_PROPERTY_VERSION);
        format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }

    /// How many rays a packet has here.
    pub(crate) fn packet_width(&self) -> usize {
        if self.property(library::DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0 { 16 } else { 8 }
    }

    fn property(&self, property: i32) -> isize {
        // SAFETY: the device is alive as long as this is.
        unsafe { (self.library.get_device_property)(self.device, property) }
    }

    /// Builds the tree of a scene on all threads.
    pub(crate) fn build<'a>(&'a self, scene: &'a Scene) -> anyhow::Result<EmbreeScene<'a>> {
        let (library, triangles) = (&self.library, &scene.geometry.triangles);
        let count = triangles.len();
        // SAFETY: handles are those that Embree gave; the buffers have room for `count` triples of vertices
        // and `count` triples of indices, as asked for, and are filled before they are committed.
        let handle = unsafe {
            let geometry = (library.new_geometry)(self.device, library::GEOMETRY_TYPE_TRIANGLE);
            let buffer = library.set_new_geometry_buffer;
            let vertices =
                buffer(geometry, library::BUFFER_TYPE_VERTEX, 0, library::FORMAT_FLOAT3, 12, 3 * count);
            let indices = buffer(geometry, library::BUFFER_TYPE_INDEX, 0, library::FORMAT_UINT3, 12, count);
            ensure!(!vertices.is_null() && !indices.is_null(), "Embree has no memory for {count} triangles");
            ptr::copy_nonoverlapping(triangles.as_ptr().cast::<f32>(), vertices.cast(), 9 * count);
            for index in 0..3 * count {
                indices.cast::<u32>().add(index).write(index as u32);
            }
            (library.set_geometry_build_quality)(geometry, library::BUILD_QUALITY_MEDIUM);
            (library.commit_geometry)(geometry);
            let handle = (library.new_scene)(self.device);
            (library.set_scene_build_quality)(handle, library::BUILD_QUALITY_MEDIUM);
            (library.set_scene_flags)(handle, library::SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS);
            (library.attach_geometry)(handle, geometry);
            (library.release_geometry)(geometry);
            (library.commit_scene)(handle);
            handle
        };
        // SAFETY: the device is alive.
        let error = unsafe { (library.get_device_error)(self.device) };
        ensure!(error == 0, "Embree failed to build a scene: error {error}");
        Ok(EmbreeScene { library, handle, scene })
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        if !self.device.is_null() {
            // SAFETY: the device was made by this library and is released once.
            unsafe { (self.library.release_device)(self.device) };
        }
    }
}

/// How rays are handed over.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// One by one.
    Single,
    /// In packets.
    Packets { coherent: bool },
    /// One by one, a new ray from each hit on, as the papers' algorithm for all layers has it.
    Continuation,
}

impl Mode {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Packets { coherent: false } => "packets",
            Self::Packets { coherent: true } => "packets, coherent",
            Self::Continuation => "continuation",
        }
    }

    /// The ways in which a question can be asked.
    pub(crate) fn of(question: Question) -> &'static [Self] {
        const ALL: [Mode; 4] = [
            Mode::Single,
            Mode::Packets { coherent: false },
            Mode::Packets { coherent: true },
            Mode::Continuation,
        ];
        if question == Question::Layers { &ALL } else { &ALL[..3] }
    }
}

/// Rays as Embree wants them, written once.
pub(crate) struct Prepared<'a> {
    rays: Vec<Ray1>,
    packets: Packets,
    workload: &'a Workload,
}

/// Rays and which of them count.
type Packet<const N: usize> = (Rays<N>, Valid<N>);

/// All rays in packets.
enum Packets {
    Of8(Vec<Packet<8>>),
    Of16(Vec<Packet<16>>),
}

impl<'a> Prepared<'a> {
    /// In packets of `width`, 8 or 16.
    pub(crate) fn new(workload: &'a Workload, width: usize) -> Self {
        let rays: Vec<Ray1> = workload
            .rays
            .iter()
            .map(|ray| Ray1 {
                origin: ray.origin.to_array(),
                t_near: ray.t_min,
                direction: ray.direction.to_array(),
                time: 0.0,
                t_far: ray.t_max,
                mask: u32::MAX,
                id: 0,
                flags: 0,
            })
            .collect();
        let packets = if width == 16 {
            Packets::Of16(rays.chunks(16).map(packet).collect())
        } else {
            Packets::Of8(rays.chunks(8).map(packet).collect())
        };
        Self { rays, packets, workload }
    }
}

fn packet<const N: usize>(rays: &[Ray1]) -> Packet<N> {
    // Lanes without a ray repeat the last one and do not count.
    let lane = |lane: usize| &rays[lane.min(rays.len() - 1)];
    let row = |value: fn(&Ray1) -> f32| std::array::from_fn(|index| value(lane(index)));
    let packet = Rays {
        origin: [row(|ray| ray.origin[0]), row(|ray| ray.origin[1]), row(|ray| ray.origin[2])],
        t_near: row(|ray| ray.t_near),
        direction: [row(|ray| ray.direction[0]), row(|ray| ray.direction[1]), row(|ray| ray.direction[2])],
        time: [0.0; N],
        t_far: row(|ray| ray.t_far),
        mask: [u32::MAX; N],
        id: std::array::from_fn(|index| index as u32),
        flags: [0; N],
    };
    (packet, Valid(std::array::from_fn(|index| if index < rays.len() { -1 } else { 0 })))
}

/// A tree over the triangles of a scene.
pub(crate) struct EmbreeScene<'a> {
    library: &'a Library,
    handle: Handle,
    scene: &'a Scene,
}

impl Drop for EmbreeScene<'_> {
    fn drop(&mut self) {
        // SAFETY: the scene was made by this library and is released once, before the device.
        unsafe { (self.library.release_scene)(self.handle) };
    }
}

/// A hit that a filter takes or refuses.
struct Candidate {
    /// Which ray of the packet; 0 for a single one.
    lane: usize,
    triangle: u32,
    t: f32,
    u: f32,
    v: f32,
}

/// The filter function around a closure. Embree calls it within a query that [`query`] makes.
///
/// # Safety
/// `arguments` are those of Embree for a context of [`query`], whose filter is an `F`.
unsafe extern "C" fn filter<F: FnMut(Candidate) -> bool>(arguments: *const FilterArguments) {
    // SAFETY: by the promise above; nothing else refers to the closure during the query.
    let (arguments, accept) = unsafe { (&*arguments, &mut *(*(*arguments).context).filter.cast::<F>()) };
    let count = arguments.count as usize;
    for lane in 0..count {
        // SAFETY: `valid` has `count` entries; rays and hits have `count` values a row: of rays t is row 8
        // and the id row 10, of hits u, v and the triangle are rows 3 to 5 (rtcore_ray.h).
        unsafe {
            let valid = arguments.valid.add(lane);
            if *valid == 0 {
                continue;
            }
            let candidate = Candidate {
                lane: *arguments.ray.add(10 * count + lane).cast::<u32>() as usize,
                triangle: *arguments.hit.add(5 * count + lane).cast::<u32>(),
                t: *arguments.ray.add(8 * count + lane),
                u: *arguments.hit.add(3 * count + lane),
                v: *arguments.hit.add(4 * count + lane),
            };
            if !accept(candidate) {
                *valid = 0;
            }
        }
    }
}

/// Makes a query whose hits `accept` takes or refuses.
#[inline(always)]
fn query<F: FnMut(Candidate) -> bool>(coherent: bool, accept: &mut F, call: impl FnOnce(*mut Arguments)) {
    let mut context = Context { instance: [library::INVALID; 2], filter: ptr::from_mut(accept).cast() };
    call(&mut Arguments {
        flags: library::QUERY_FLAG_INVOKE_ARGUMENT_FILTER | coherence(coherent),
        feature_mask: library::FEATURE_FLAG_ALL,
        context: &mut context,
        filter: Some(filter::<F>),
        user_geometry: ptr::null(),
        min_width_distance_factor: 0.0,
    });
}

/// Makes a query that takes every hit.
#[inline(always)]
fn query_unfiltered(coherent: bool, call: impl FnOnce(*mut Arguments)) {
    call(&mut Arguments {
        flags: coherence(coherent),
        feature_mask: library::FEATURE_FLAG_ALL,
        context: ptr::null_mut(),
        filter: None,
        user_geometry: ptr::null(),
        min_width_distance_factor: 0.0,
    });
}

fn coherence(coherent: bool) -> i32 {
    if coherent { library::QUERY_FLAG_COHERENT } else { 0 }
}

impl EmbreeScene<'_> {
    /// Answers a question for each ray.
    pub(crate) fn answer(
        &self,
        question: Question,
        mode: Mode,
        prepared: &Prepared<'_>,
        answers: &mut [Answer],
    ) {
        match (question, mode) {
            (_, Mode::Packets { coherent }) => match &prepared.packets {
                Packets::Of8(packets) => {
                    PacketTracer { scene: self, coherent, functions: self.library.packets8 }.answer(
                        question,
                        packets,
                        &prepared.workload.seeds,
                        answers,
                    )
                }
                Packets::Of16(packets) => {
                    PacketTracer { scene: self, coherent, functions: self.library.packets16 }.answer(
                        question,
                        packets,
                        &prepared.workload.seeds,
                        answers,
                    );
                }
            },
            (Question::Layers, Mode::Continuation) => self.layers_by_continuation(prepared, answers),
            (Question::Closest, _) => self.closest(prepared, answers),
            (Question::Stochastic | Question::Samples, _) => self.stochastic(prepared, answers),
            (Question::Layers, _) => self.layers(prepared, answers),
            (Question::Shadow, _) => self.shadow(prepared, answers),
        }
    }

    #[inline(always)]
    fn intersect1(&self, ray: Ray1, arguments: *mut Arguments) -> RayHit1 {
        let mut hit = RayHit1 {
            ray,
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: library::INVALID,
            geometry: library::INVALID,
            instance: [library::INVALID; 2],
        };
        // SAFETY: the scene is committed, the layouts are Embree's, the arguments live until it returns.
        unsafe { (self.library.intersect1)(self.handle, &mut hit, arguments) };
        hit
    }

    #[inline(always)]
    fn occluded1(&self, mut ray: Ray1, arguments: *mut Arguments) {
        // SAFETY: as above.
        unsafe { (self.library.occluded1)(self.handle, &mut ray, arguments) };
    }

    fn closest(&self, prepared: &Prepared<'_>, answers: &mut [Answer]) {
        for (ray, answer) in prepared.rays.iter().zip(answers) {
            query_unfiltered(false, |arguments| *answer = answer1(&self.intersect1(*ray, arguments)));
        }
    }

    fn stochastic(&self, prepared: &Prepared<'_>, answers: &mut [Answer]) {
        let seeds = &prepared.workload.seeds;
        for ((ray, &seed), answer) in prepared.rays.iter().zip(seeds).zip(answers) {
            let mut accept = |hit: Candidate| self.scene.accepts(seed, hit.triangle, hit.u, hit.v);
            query(false, &mut accept, |arguments| *answer = answer1(&self.intersect1(*ray, arguments)));
        }
    }

    fn layers(&self, prepared: &Prepared<'_>, answers: &mut [Answer]) {
        let mut layers: Vec<Layer> = Vec::new();
        for (ray, answer) in prepared.rays.iter().zip(answers) {
            layers.clear();
            // Only what is opaque is a hit: it ends the search for what lies behind it.
            let mut accept = |hit: Candidate| {
                let alpha = self.scene.alpha(hit.triangle, hit.u, hit.v);
                layers.push(Layer { t: hit.t, triangle: hit.triangle, alpha });
                alpha >= 1.0
            };
            query(false, &mut accept, |arguments| {
                self.intersect1(*ray, arguments);
            });
            *answer = composite(&mut layers);
        }
    }

    fn layers_by_continuation(&self, prepared: &Prepared<'_>, answers: &mut [Answer]) {
        for (ray, answer) in prepared.rays.iter().zip(answers) {
            let (mut ray, mut composite) = (*ray, Composite::new());
            loop {
                let mut hit = None;
                query_unfiltered(false, |arguments| hit = Some(self.intersect1(ray, arguments)));
                let Some(hit) = hit.filter(|hit| hit.geometry != library::INVALID) else { break };
                let alpha = self.scene.alpha(hit.primitive, hit.u, hit.v);
                if !composite.add(hit.primitive, alpha) {
                    break;
                }
                // Past the rounding of the distance, or the same triangle would be hit again.
                ray.t_near = hit.ray.t_far * (1.0 + 4.0 * f32::EPSILON);
            }
            *answer = composite.answer();
        }
    }

    fn shadow(&self, prepared: &Prepared<'_>, answers: &mut [Answer]) {
        for (ray, answer) in prepared.rays.iter().zip(answers) {
            let mut transmittance = 1.0;
            let mut accept = |hit: Candidate| {
                transmittance *= 1.0 - self.scene.alpha(hit.triangle, hit.u, hit.v);
                transmittance < LEAST_TRANSMITTANCE
            };
            query(false, &mut accept, |arguments| self.occluded1(*ray, arguments));
            *answer = Answer { value: transmittance, index: 0 };
        }
    }
}

/// Packets of a width on a scene.
struct PacketTracer<'a, const N: usize> {
    scene: &'a EmbreeScene<'a>,
    coherent: bool,
    functions: PacketFunctions<N>,
}

impl<const N: usize> PacketTracer<'_, N> {
    fn answer(&self, question: Question, packets: &[Packet<N>], seeds: &[u32], answers: &mut [Answer]) {
        match question {
            Question::Closest => self.closest(packets, answers),
            Question::Stochastic | Question::Samples => self.stochastic(packets, seeds, answers),
            Question::Layers => self.layers(packets, answers),
            Question::Shadow => self.shadow(packets, answers),
        }
    }

    fn alpha(&self, hit: &Candidate) -> f32 {
        self.scene.scene.alpha(hit.triangle, hit.u, hit.v)
    }

    #[inline(always)]
    fn intersect(&self, (rays, valid): &Packet<N>, arguments: *mut Arguments) -> RayHits<N> {
        let mut hits = RayHits {
            rays: *rays,
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            primitive: [library::INVALID; N],
            geometry: [library::INVALID; N],
            instance: [[library::INVALID; N]; 2],
        };
        // SAFETY: the scene is committed, the layouts are Embree's, the arguments live until it returns.
        unsafe { (self.functions.intersect)(valid, self.scene.handle, &mut hits, arguments) };
        hits
    }

    #[inline(always)]
    fn occluded(&self, (rays, valid): &Packet<N>, arguments: *mut Arguments) {
        let mut rays = *rays;
        // SAFETY: as above.
        unsafe { (self.functions.occluded)(valid, self.scene.handle, &mut rays, arguments) };
    }

    fn closest(&self, packets: &[Packet<N>], answers: &mut [Answer]) {
        for (packet, answers) in packets.iter().zip(answers.chunks_mut(N)) {
            query_unfiltered(self.coherent, |arguments| write(&self.intersect(packet, arguments), answers));
        }
    }

    fn stochastic(&self, packets: &[Packet<N>], seeds: &[u32], answers: &mut [Answer]) {
        for ((packet, seeds), answers) in packets.iter().zip(seeds.chunks(N)).zip(answers.chunks_mut(N)) {
            let mut accept =
                |hit: Candidate| self.scene.scene.accepts(seeds[hit.lane], hit.triangle, hit.u, hit.v);
            query(self.coherent, &mut accept, |arguments| {
                write(&self.intersect(packet, arguments), answers);
            });
        }
    }

    fn layers(&self, packets: &[Packet<N>], answers: &mut [Answer]) {
        let mut layers: [Vec<Layer>; N] = std::array::from_fn(|_| Vec::new());
        for (packet, answers) in packets.iter().zip(answers.chunks_mut(N)) {
            layers.iter_mut().for_each(Vec::clear);
            let mut accept = |hit: Candidate| {
                let alpha = self.alpha(&hit);
                layers[hit.lane].push(Layer { t: hit.t, triangle: hit.triangle, alpha });
                alpha >= 1.0
            };
            query(self.coherent, &mut accept, |arguments| {
                self.intersect(packet, arguments);
            });
            for (answer, layers) in answers.iter_mut().zip(&mut layers) {
                *answer = composite(layers);
            }
        }
    }

    fn shadow(&self, packets: &[Packet<N>], answers: &mut [Answer]) {
        for (packet, answers) in packets.iter().zip(answers.chunks_mut(N)) {
            let mut transmittances = [1.0; N];
            let mut accept = |hit: Candidate| {
                let transmittance = &mut transmittances[hit.lane];
                *transmittance *= 1.0 - self.alpha(&hit);
                *transmittance < LEAST_TRANSMITTANCE
            };
            query(self.coherent, &mut accept, |arguments| self.occluded(packet, arguments));
            for (answer, &value) in answers.iter_mut().zip(&transmittances) {
                *answer = Answer { value, index: 0 };
            }
        }
    }
}

fn answer1(hit: &RayHit1) -> Answer {
    if hit.geometry == library::INVALID {
        Answer::NONE
    } else {
        Answer { value: hit.ray.t_far, index: hit.primitive }
    }
}

fn write<const N: usize>(hits: &RayHits<N>, answers: &mut [Answer]) {
    for (lane, answer) in answers.iter_mut().enumerate() {
        *answer = if hits.geometry[lane] == library::INVALID {
            Answer::NONE
        } else {
            Answer { value: hits.rays.t_far[lane], index: hits.primitive[lane] }
        };
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use sheer_accel::Ray;

    use super::*;

    #[test]
    fn a_packet_has_its_rays_in_lanes_and_the_rest_does_not_count() {
        let ray = |x: f32| Ray { origin: Vec3::X * x, direction: Vec3::Z, t_min: 0.5, t_max: 9.0 };
        let workload = Workload { rays: (0..10).map(|x| ray(x as f32)).collect(), seeds: vec![0; 10] };
        let prepared = Prepared::new(&workload, 8);
        let Packets::Of8(packets) = prepared.packets else { panic!("asked for packets of 8") };
        let (rays, valid) = packets[1];
        assert_eq!(valid.0, [-1, -1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(rays.origin[0][..3], [8.0, 9.0, 9.0]);
        assert_eq!((rays.t_near, rays.t_far), ([0.5; 8], [9.0; 8]));
        assert_eq!(rays.id, [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn a_folder_without_the_library_is_named() {
        let error = Embree::load(Path::new("/nowhere")).err().map(|error| error.to_string());
        assert!(error.is_some_and(|text| text.contains("/nowhere") && text.contains("embreex")));
    }
}

//! `arena`: heroes and raiders fight in a ring of stone at dusk, and a golem breathes fire (STD Fig. 1, 8 and
//! 11).
//!
//! Many small transparent things of middling opacity overlap: shields one in front of another, runes, fire,
//! drops, dust and health bars. Their number rises to two thirds of the clip and falls again; the clip loops.

use glam::Vec3;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
};

use self::spell::Effects;
use crate::{builder::SceneBuilder, kit::palette::Palette, seed::SEED};

mod body;
mod cast;
mod figure;
mod paint;
mod ring;
mod spell;

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "effects",
        default: "1.0",
        range: ParameterRange::Real(0.0, 8.0),
        what: "factor on the number of effects; 0 shows the figures alone",
    },
    SEED,
];

const YFOV_RAD: f32 = 0.70;

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let seed = values.count(SEED.key);
    let mut builder = SceneBuilder::new("arena", ring::dusk());
    let palette = Palette::new(&mut builder, seed);
    ring::raise(&mut builder, &palette, seed);
    let cast = cast::assemble(&mut builder, &palette, seed);
    spell::conjure(&mut builder, &cast, Effects { amount: values.real("effects"), seed });

    builder.camera(Camera::fixed(
        "static",
        YFOV_RAD,
        Vec3::new(-0.9, 2.75, 10.5),
        Vec3::new(0.10, 1.85, -1.0),
    ));
    let key = |time_secs, eye: Vec3, target: Vec3| CameraKey { time_secs, eye, target };
    builder.camera(Camera {
        name: "path".to_owned(),
        lens: Lens::Perspective { yfov_rad: 0.80 },
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(-7.6, 3.2, 5.8), Vec3::new(0.2, 1.6, -0.5)),
                key(2.5, Vec3::new(-4.4, 1.9, 6.4), Vec3::new(0.6, 1.8, -0.6)),
                key(5.0, Vec3::new(-0.9, 1.7, 7.4), Vec3::new(0.5, 2.0, -1.2)),
                key(7.0, Vec3::new(3.6, 2.1, 7.6), Vec3::new(0.2, 2.0, -1.2)),
                key(10.0, Vec3::new(8.6, 3.2, 5.0), Vec3::new(0.0, 1.7, -0.6)),
            ],
        },
    });
    // Within the ring: a wider circle would run through the pillars.
    let (target, eye) = (Vec3::new(0.0, 1.7, 0.0), Vec3::new(-0.6, 2.7, 9.4));
    builder.camera(Camera::orbit(Lens::Perspective { yfov_rad: 0.80 }, target, eye));
    builder.finish()
}

#[cfg(test)]
mod tests {
    use std::{
        collections::HashMap,
        sync::{Arc, LazyLock},
    };

    use glam::Vec2;
    use sheer_scene::{Animator, Frame, model::AlphaMode};

    use super::{figure::CLIP_SECS, *};
    use crate::catalogue;

    static SCENE: LazyLock<Arc<Scene>> = LazyLock::new(|| Arc::new(catalogue::build("arena").unwrap()));

    fn at(scene: &Arc<Scene>, time_secs: f32) -> Animator {
        let mut animator = Animator::new(Arc::clone(scene), scene.parts().cameras[0].clone());
        animator.advance(time_secs, time_secs);
        animator
    }

    fn blends(frame: &Frame, triangle: u32) -> bool {
        let material = &frame.scene().parts().materials[frame.object(triangle).material as usize];
        material.alpha_mode == AlphaMode::Blend
    }

    fn area(corners: [Vec3; 3]) -> f32 {
        0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length()
    }

    /// Corners by the id of what they belong to: everything that blends and is not shrunk to nothing.
    fn effects(frame: &Frame) -> HashMap<u32, Vec<Vec3>> {
        let mut found: HashMap<u32, Vec<Vec3>> = HashMap::new();
        for (triangle, &corners) in (0..).zip(frame.triangles()) {
            if blends(frame, triangle) && area(corners) > 1e-8 {
                found.entry(frame.object(triangle).id).or_default().extend(corners);
            }
        }
        found
    }

    #[test]
    fn effects_rise_to_two_thirds_of_the_clip_and_fall_again() {
        let counts: Vec<usize> =
            (0..20).map(|step| effects(at(&SCENE, 0.5 * step as f32).frame()).len()).collect();
        let peak = (0..20).max_by_key(|&step| counts[step]).unwrap();
        assert!((11..=15).contains(&peak), "{counts:?}");
        // Every other step counts: a salvo may be over within half a second.
        for pair in [0, 4, 8, 12].windows(2) {
            assert!(counts[pair[1]] > counts[pair[0]], "{counts:?}");
        }
        for pair in [14, 16, 18].windows(2) {
            assert!(counts[pair[1]] < counts[pair[0]], "{counts:?}");
        }
        assert!(counts[peak] > 4 * counts[0], "{counts:?}");
    }

    #[test]
    fn the_amount_of_effects_can_be_set_from_none() {
        let none = catalogue::build("arena:effects=0").unwrap();
        assert!(none.parts().particles.is_empty());
        assert!(none.parts().materials.iter().all(|material| material.alpha_mode != AlphaMode::Blend));
        let count = |text: &str| {
            let scene = Arc::new(catalogue::build(text).unwrap());
            effects(at(&scene, 6.5).frame()).len()
        };
        let (half, twice) = (count("arena:effects=0.5"), count("arena:effects=2"));
        let whole = effects(at(&SCENE, 6.5).frame()).len();
        assert!(half < whole * 3 / 4 && twice > whole * 3 / 2, "{half} {whole} {twice}");
    }

    #[test]
    fn no_effect_is_larger_than_the_arena_or_shares_its_identity() {
        for time_secs in [0.0, 3.4, 6.5, 8.0] {
            for corners in effects(at(&SCENE, time_secs).frame()).values() {
                let low = corners.iter().copied().reduce(Vec3::min).unwrap();
                let high = corners.iter().copied().reduce(Vec3::max).unwrap();
                // Two instances under one id would span the distance between them.
                let sky = low.length() > 100.0;
                let allowed = if sky { 2.0 * ring::ARENA_RADIUS } else { ring::FLOOR_RADIUS };
                assert!((high - low).max_element() < allowed, "{low} to {high} at {time_secs} s");
            }
        }
        let parts = SCENE.parts();
        let mut owner: HashMap<u32, u32> = HashMap::new();
        for instance in &parts.instances {
            assert_eq!(*owner.entry(instance.id).or_insert(instance.node), instance.node);
        }
    }

    #[test]
    fn figures_move_and_stay_on_the_floor() {
        let (mut travelled, mut previous) = (0.0_f32, None);
        for step in 0..40 {
            let animator = at(&SCENE, 0.25 * step as f32);
            let frame = animator.frame();
            let mut corners = Vec::new();
            for triangle in frame.static_count() as u32..frame.triangles().len() as u32 {
                if !blends(frame, triangle) {
                    corners.extend(frame.triangles()[triangle as usize]);
                }
            }
            let lowest = corners.iter().map(|corner| corner.y).fold(f32::MAX, f32::min);
            let widest = corners.iter().map(|corner| corner.with_y(0.0).length()).fold(0.0, f32::max);
            // Boulders are not round: a foot or a fist of the golem may press a hand's breadth into the
            // ground.
            assert!((-0.20..0.05).contains(&lowest), "{lowest} at step {step}");
            assert!(widest < ring::FLOOR_RADIUS, "{widest} at step {step}");
            if let Some(previous) = previous.replace(corners.clone()) {
                let pairs: Vec<(Vec3, Vec3)> = corners.into_iter().zip::<Vec<Vec3>>(previous).collect();
                let far = pairs.iter().map(|(now, then)| now.distance(*then)).fold(0.0, f32::max);
                // Nothing goes faster than the golem's fist, which falls from above its head in a quarter of
                // a second.
                assert!(far < 5.5, "{far} at step {step}");
                travelled += far;
            }
        }
        assert!(travelled > 20.0, "{travelled}");
    }

    #[test]
    fn the_clip_loops() {
        for animation in &SCENE.parts().animations {
            let ends = animation.channels.iter().map(|channel| channel.track.end_secs());
            assert_eq!(ends.fold(0.0, f32::max), CLIP_SECS, "{}", animation.name);
        }
        for system in &SCENE.parts().particles {
            assert_eq!(CLIP_SECS % system.loop_secs.unwrap(), 0.0, "{}", system.name);
        }
        let (start, end) = (at(&SCENE, 0.0), at(&SCENE, CLIP_SECS - 1e-3));
        // Particles come after all meshes.
        let mesh_count: usize = {
            let parts = SCENE.parts();
            parts.instances.iter().map(|instance| parts.meshes[instance.mesh as usize].indices.len()).sum()
        };
        let pairs = start.frame().triangles()[..mesh_count].iter().zip(end.frame().triangles());
        let far = pairs.flat_map(|(a, b)| [0, 1, 2].map(|corner| a[corner].distance(b[corner])));
        let far = far.fold(0.0, f32::max);
        assert!(far < 0.02, "a corner jumps by {far} m");
    }

    #[test]
    fn the_camera_on_its_path_touches_nobody() {
        let camera = SCENE.parts().cameras.iter().find(|camera| camera.name == "path").unwrap();
        for step in 0..=40 {
            let time_secs = 0.2475 * step as f32;
            let animator = at(&SCENE, time_secs);
            let frame = animator.frame();
            let eye = camera.pose_on_rails(time_secs).unwrap().eye();
            let solid = (0..).zip(frame.triangles()).filter(|(triangle, _)| frame.is_opaque(*triangle));
            let near = solid.flat_map(|(_, corners)| corners.map(|corner| corner.distance(eye)));
            let near = near.fold(f32::MAX, f32::min);
            assert!(near > 0.7, "{near} m at {time_secs} s");
        }
    }

    #[test]
    fn many_layers_overlap_in_the_still_view() {
        let animator = at(&SCENE, 6.4);
        let frame = animator.frame();
        let size = Vec2::new(32.0, 18.0);
        let layers: Vec<usize> = (0..18 * 32)
            .map(|pixel| {
                let ray = frame.camera().ray(Vec2::new((pixel % 32) as f32, (pixel / 32) as f32) + 0.5, size);
                let met = (0..).zip(frame.triangles()).filter(|(triangle, corners)| {
                    blends(frame, *triangle) && meets(ray.origin, ray.direction, **corners)
                });
                met.count()
            })
            .collect();
        let deep = layers.iter().filter(|&&count| count >= 4).count();
        // A quarter of the picture; dust and fire put tens of layers behind one another in places.
        assert!(deep * 4 > layers.len() && layers.iter().max() >= Some(&12), "{deep} {layers:?}");
    }

    /// Whether a ray meets a triangle (Möller and Trumbore 1997).
    fn meets(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
        let (ab, ac) = (b - a, c - a);
        let across = direction.cross(ac);
        let determinant = ab.dot(across);
        let from = origin - a;
        let u = from.dot(across) / determinant;
        let other = from.cross(ab);
        let v = direction.dot(other) / determinant;
        determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(other) / determinant > 0.0
    }

    #[test]
    fn the_arena_keeps_to_its_budget() {
        let animator = at(&SCENE, 6.5);
        let triangle_count = animator.frame().triangles().len();
        assert!((40_000..400_000).contains(&triangle_count), "{triangle_count} triangles");
        let moving = triangle_count - animator.frame().static_count();
        assert!(moving < 80_000, "{moving} triangles move");
    }
}

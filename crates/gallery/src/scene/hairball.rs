//! `hairball`: a sitting puppy under 300,000 transparent hairs (ST Fig. 7).
//!
//! The hairs are dealt out to locks like cards, one after the other: hairs that lie over one another belong
//! to different objects and so are dithered independently.

use std::f32::consts::TAU;

use glam::{Affine3A, EulerRot, Quat, Vec3};
use rayon::prelude::*;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    environment::{Environment, Lobe},
    model::Material,
};

use crate::{
    builder::SceneBuilder,
    kit::{
        body::{Body, Form, arc},
        hair::{self, Strand},
    },
    paint::smoothstep,
    rng::Rng,
    seed::SEED,
    shape::{Model, Shape},
};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "hairs",
        default: "300000",
        range: ParameterRange::Count(1, 1_000_000),
        what: "how many hairs the coat is made of",
    },
    ParameterInfo {
        key: "alpha",
        default: "0.5",
        range: ParameterRange::Real(0.0, 1.0),
        what: "opacity of a hair at its root; it fades towards its tip",
    },
    SEED,
];

/// Segments of a hair: 2.7 million triangles at the default. Fewer show corners in the ruff, more cost memory
/// for nothing seen.
const SEGMENTS: usize = 5;
/// Hairs of a lock: few enough locks that the scene stays light, few enough hairs that those of one lock
/// seldom meet in a pixel.
const LOCK_SIZE: u32 = 300;
/// Width of a hair at its root with the default count, metres: about half a pixel at the default size.
const WIDTH: f32 = 0.0012;
/// How far the skin lies below the surface that the hairs grow from, metres.
const SKIN_INSET: f32 = 0.006;
const EYE_RADIUS: f32 = 0.031;
const NOSE: Vec3 = Vec3::new(0.0, 0.868, 0.418);
const NOSE_RADII: Vec3 = Vec3::new(0.036, 0.027, 0.027);
const YFOV_RAD: f32 = 0.50;

/// The middle of an eye: `side` is 1 for the one at +X.
fn eye(side: f32) -> Vec3 {
    Vec3::new(side * 0.080, 0.918, 0.280)
}

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let lobe = |x: f32, y: f32, z: f32, radiance: Vec3, sharpness: f32| Lobe {
        direction: Vec3::new(x, y, z).normalize(),
        radiance,
        sharpness,
    };
    let mut builder = SceneBuilder::new(
        "hairball",
        Environment {
            zenith: Vec3::new(0.34, 0.37, 0.42),
            horizon: Vec3::new(0.36, 0.355, 0.35),
            ground: Vec3::new(0.24, 0.20, 0.17),
            lobes: vec![
                lobe(-0.7, 0.8, 0.9, Vec3::new(2.6, 2.3, 1.9), 14.0),
                lobe(0.9, 0.3, 0.7, Vec3::new(0.35, 0.42, 0.55), 4.0),
                // What glints in the eyes.
                lobe(-0.75, 0.75, 1.0, Vec3::splat(40.0), 260.0),
            ],
            ..Environment::black()
        },
    );
    let (key, rim, middle) = (Vec3::new(-3.7, 3.5, 1.6), Vec3::new(1.9, 2.2, -2.1), Vec3::Y * 0.55);
    builder.spot("key", key, middle, Vec3::new(84.0, 75.0, 62.0), [0.20, 0.62]);
    builder.spot("rim", rim, middle, Vec3::new(52.0, 50.0, 50.0), [0.16, 0.30]);
    put_room(&mut builder);
    put_puppy(&mut builder);
    put_coat(&mut builder, values);

    let (eye, target) = (Vec3::new(-0.95, 0.86, 2.75), Vec3::new(-0.06, 0.565, 0.0));
    let lens = Lens::Perspective { yfov_rad: YFOV_RAD };
    builder.camera(Camera::fixed("static", YFOV_RAD, eye, target));
    builder.camera(Camera::orbit(lens, Vec3::new(0.0, 0.56, 0.0), Vec3::new(-0.95, 0.86, 2.75)));
    let key = |time_secs, eye, target| CameraKey { time_secs, eye, target };
    // Up to the face and around it.
    builder.camera(Camera {
        name: "path".to_owned(),
        lens,
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(-1.7, 1.0, 2.4), Vec3::new(0.0, 0.55, 0.0)),
                key(4.0, Vec3::new(-0.5, 0.95, 1.6), Vec3::new(0.0, 0.75, 0.1)),
                key(8.0, Vec3::new(0.6, 1.0, 1.3), Vec3::new(0.0, 0.84, 0.15)),
            ],
        },
    });
    builder.finish()
}

/// A round floor that bends up into a wall: no horizon behind the animal, from wherever it is looked at.
fn put_room(builder: &mut SceneBuilder) {
    let plain = |name: &str, roughness| Material { name: name.to_owned(), roughness, ..Material::default() };
    let paper = builder.material(plain("paper", 0.95));
    let mut room = Model::default();
    let mut profile: Vec<(f32, f32)> = vec![(7.0, 3.6)];
    let bend = 1.6;
    profile.extend((0..=12).map(|step| {
        let (sin, cos) = (step as f32 / 12.0 * 0.25 * TAU).sin_cos();
        (7.0 - bend + bend * cos, bend - bend * sin)
    }));
    profile.push((0.0, 0.0));
    room.paint(paper, Vec3::new(0.20, 0.33, 0.34)).lathe(Vec3::ZERO, &profile, 96);
    builder.put("room", room);
    // A ball to play with.
    let rubber = builder.material(plain("rubber", 0.4));
    let (middle, radius) = (Vec3::new(-0.56, 0.12, 0.10), 0.12);
    let mut ball = Shape::default();
    ball.lathe(Vec3::ZERO, &arc(radius, 0.0, -1.0, 1.0, 48), 96);
    let mut toy = Model::from_shape(rubber, ball);
    toy.tint(rubber, |p, _| {
        let band = smoothstep(0.030, 0.033, p.y.abs());
        Vec3::new(0.86, 0.80, 0.66).lerp(Vec3::new(0.62, 0.07, 0.045), band)
    });
    let turn = Quat::from_euler(EulerRot::XYZ, 0.5, 0.0, 0.45);
    builder.put_at("ball", toy, Affine3A::from_rotation_translation(turn, middle));
}

fn limb(from: Vec3, to: Vec3, radius_from: f32, radius_to: f32) -> Form {
    Form::Limb { from, to, radius_from, radius_to }
}

/// The animal: it sits and looks along +Z.
fn body() -> Body {
    let ball = |centre: Vec3, radii: Vec3| Form::Ellipsoid { centre, radii };
    let v = Vec3::new;
    let mut forms = vec![
        ball(v(0.0, 0.24, -0.18), v(0.23, 0.235, 0.25)),
        limb(v(0.0, 0.30, -0.13), v(0.0, 0.55, 0.05), 0.205, 0.175),
        ball(v(0.0, 0.49, 0.10), v(0.175, 0.20, 0.155)),
        limb(v(0.0, 0.60, 0.06), v(0.0, 0.78, 0.09), 0.15, 0.145),
        ball(v(0.0, 0.90, 0.12), v(0.205, 0.178, 0.185)),
        limb(v(0.0, 0.850, 0.24), v(0.0, 0.838, 0.352), 0.080, 0.060),
        // The tail, curled around the right side.
        limb(v(0.02, 0.10, -0.38), v(0.24, 0.09, -0.42), 0.060, 0.062),
        limb(v(0.24, 0.09, -0.42), v(0.42, 0.08, -0.28), 0.062, 0.055),
        limb(v(0.42, 0.08, -0.28), v(0.47, 0.08, -0.08), 0.055, 0.035),
    ];
    for side in [-1.0, 1.0] {
        forms.extend([
            ball(v(side * 0.105, 0.850, 0.175), v(0.098, 0.090, 0.098)),
            limb(v(side * 0.105, 0.44, 0.12), v(side * 0.112, 0.08, 0.235), 0.080, 0.055),
            ball(v(side * 0.115, 0.045, 0.275), v(0.066, 0.046, 0.088)),
            ball(v(side * 0.205, 0.19, -0.05), v(0.115, 0.185, 0.200)),
            ball(v(side * 0.245, 0.045, 0.13), v(0.062, 0.046, 0.120)),
            limb(v(side * 0.118, 1.005, 0.085), v(side * 0.172, 1.135, 0.075), 0.062, 0.020),
        ]);
    }
    Body { forms, blend: 0.07 }
}

/// What lies under the coat, and what the coat leaves bare: eyes, nose and tongue.
fn put_puppy(builder: &mut SceneBuilder) {
    let matt = |name: &str, roughness| Material { name: name.to_owned(), roughness, ..Material::default() };
    let skin = builder.material(matt("skin", 0.9));
    let wet = builder.material(matt("wet", 0.05));
    let tongue = builder.material(matt("tongue", 0.35));
    let mut model = Model::default();
    let body = body();
    for &form in &body.forms {
        form.mesh(model.paint(skin, Vec3::ONE), SKIN_INSET);
    }
    // The skin has the colour of the undercoat.
    model.tint(skin, |p, n| coat_at(p, n).colour * 0.4);
    for side in [-1.0, 1.0] {
        let ball = |radii, centre| Form::Ellipsoid { centre, radii };
        ball(Vec3::splat(EYE_RADIUS), eye(side)).mesh(model.paint(wet, Vec3::new(0.020, 0.010, 0.006)), 0.0);
    }
    Form::Ellipsoid { centre: NOSE, radii: NOSE_RADII }.mesh(model.paint(wet, Vec3::splat(0.012)), 0.0);
    let lolling =
        Form::Ellipsoid { centre: Vec3::new(0.004, 0.758, 0.372), radii: Vec3::new(0.026, 0.042, 0.014) };
    lolling.mesh(model.paint(tongue, Vec3::new(0.72, 0.22, 0.22)), 0.0);
    builder.put("puppy", model);
}

/// The hair that grows at a point of the body.
#[derive(Clone, Copy, Debug)]
struct Coat {
    /// Linear colour of the outer coat.
    colour: Vec3,
    /// Length of a hair there, metres.
    length: f32,
    /// Which way it is combed; its length says how firmly.
    comb: Vec3,
}

const FAWN: Vec3 = Vec3::new(0.78, 0.34, 0.11);
const CREAM: Vec3 = Vec3::new(0.98, 0.87, 0.66);
const SABLE: Vec3 = Vec3::new(0.10, 0.055, 0.035);

fn coat_at(p: Vec3, n: Vec3) -> Coat {
    let ball = |centre: Vec3, inner: f32, outer: f32| 1.0 - smoothstep(inner, outer, p.distance(centre));
    let head = smoothstep(0.70, 0.80, p.y);
    let face = head * ball(Vec3::new(0.0, 0.86, 0.30), 0.13, 0.23);
    let muzzle = ball(Vec3::new(0.0, 0.84, 0.36), 0.06, 0.13);
    let ear = smoothstep(1.03, 1.08, p.y);
    let tail =
        smoothstep(0.30, 0.36, p.z.min(0.0).abs().max(p.x - 0.02)) * (1.0 - smoothstep(0.16, 0.22, p.y));
    let ruff = ball(Vec3::new(0.0, 0.60, 0.16), 0.16, 0.30) * (1.0 - head);
    let low = 1.0 - smoothstep(0.08, 0.20, p.y);
    let leg = (1.0 - smoothstep(0.30, 0.42, p.y)) * smoothstep(0.05, 0.14, p.z);

    // Cream in front and below, sable along the back and on the tips of the ears.
    let cheeks = ball(Vec3::new(0.0, 0.80, 0.26), 0.12, 0.19);
    let bib =
        smoothstep(0.10, 0.55, n.z - 0.25 * p.x.abs()) * (1.0 - smoothstep(0.74, 0.84, p.y)) * (1.0 - head);
    let blaze = (1.0 - smoothstep(0.012, 0.035, p.x.abs())) * face;
    let socks = (1.0 - smoothstep(0.10, 0.17, p.y)) * smoothstep(0.0, 0.1, p.z);
    let brush = tail * smoothstep(-0.16, 0.0, p.z + 0.1) * smoothstep(0.3, 0.4, p.x);
    let inner_ear = ear.max(smoothstep(0.98, 1.03, p.y))
        * smoothstep(0.3, 0.7, n.z)
        * (1.0 - smoothstep(1.08, 1.12, p.y));
    let cream = muzzle.max(cheeks).max(bib).max(blaze).max(socks).max(brush).max(0.7 * inner_ear);
    let back =
        smoothstep(0.2, 0.75, -n.z + 0.3 * n.y) * smoothstep(0.22, 0.40, p.y) * (1.0 - head) * (1.0 - low);
    let sable = (0.75 * back).max(smoothstep(1.10, 1.15, p.y));
    let colour = FAWN.lerp(SABLE, sable).lerp(CREAM, cream);

    let mut length = 0.105;
    for (share, of) in [
        (ruff, 0.165),
        (head, 0.078),
        (face, 0.036),
        (muzzle, 0.013),
        (leg, 0.065),
        (low * (1.0 - tail), 0.034),
        (ear, 0.050),
        (tail, 0.15),
    ] {
        length += (of - length) * share;
    }

    // Backwards from the nose over the head; down and back over the body; along the tail; up the ears.
    let from_nose = (p - NOSE).normalize_or(Vec3::Y);
    let mut comb = Vec3::new(0.35 * p.x.signum() * p.x.abs().min(0.2) * 5.0, -0.9, -0.25);
    comb = comb.lerp(Vec3::new(0.5 * n.x, -0.8, 0.35), ruff);
    comb = comb.lerp(from_nose * 0.9 - Vec3::Y * 0.25, head);
    comb = comb.lerp(from_nose, face);
    comb = comb.lerp(Vec3::new(0.25 * p.x.signum(), 0.85, -0.1), ear);
    let around_tail = Vec3::new(-(p.z + 0.13), 0.0, p.x - 0.15).normalize_or(Vec3::X);
    comb = comb.lerp(around_tail * 0.9 + Vec3::Y * 0.1, tail);
    Coat { colour, length, comb }
}

/// How often a hair is thrown again if it would get in the way of eyes or nose; after that it is taken as it
/// is, which never happens.
const MAX_THROWS: u32 = 64;

fn put_coat(builder: &mut SceneBuilder, values: &Values) {
    let (count, alpha, seed) = (values.count("hairs"), values.real("alpha"), values.count(SEED.key));
    let material = builder.material(hair::material("hair", 0.42));
    let body = body();
    // The same cover whatever the count: fewer hairs are broader.
    let width = WIDTH * (300_000.0 / count as f32).powf(0.7).clamp(0.5, 12.0);
    let lock_count = count.div_ceil(LOCK_SIZE);
    let locks: Vec<Shape> = (0..lock_count)
        .into_par_iter()
        .map(|lock| {
            let mut rng = Rng::new(seed, &format!("lock {lock}"));
            let mut shape = Shape::default();
            for _ in (lock..count).step_by(lock_count as usize) {
                add_hair(&mut shape, &mut rng, &body, seed, width, alpha);
            }
            shape
        })
        .collect();
    for shape in locks {
        builder.put("lock", Model::from_shape(material, shape));
    }
}

fn add_hair(shape: &mut Shape, rng: &mut Rng, body: &Body, seed: u32, width: f32, alpha: f32) {
    let mut points = [Vec3::ZERO; SEGMENTS + 1];
    let mut coat = coat_at(Vec3::ZERO, Vec3::Y);
    for _ in 0..MAX_THROWS {
        let (root, normal) = body.surface_point(rng);
        // Markings have soft edges: a hair may have the colour of a place nearby.
        coat = coat_at(root + rng.gaussian() * 0.012, normal);
        grow(&mut points, rng, body, seed, (root, normal), &coat);
        if !points.iter().any(|&point| in_the_way(point)) {
            break;
        }
    }
    let shade = rng.between(0.75, 1.15);
    let grey = rng.happens(0.06);
    let tip = if grey { coat.colour.lerp(CREAM, 0.6) } else { coat.colour } * shade;
    let strand = Strand {
        points: &points,
        width: width * rng.between(0.7, 1.3) * (0.55 + coat.length / 0.13),
        side: rng.direction(),
        twist_rad: rng.between(0.6, 1.6),
    };
    hair::ribbon(shape, &strand, |way| {
        // The undercoat is darker, and little light gets down to it.
        let colour = tip * (0.42 + 0.58 * smoothstep(-0.1, 0.6, way));
        colour.extend(alpha * (1.0 - 0.85 * way * way))
    });
}

/// Whether a hair through this point would hide an eye or the nose.
fn in_the_way(p: Vec3) -> bool {
    let bare_nose = ((p - NOSE) / (NOSE_RADII + 0.006)).length_squared() < 1.0;
    let before_eye = |side: f32| {
        // Eyes look forward and a little outwards.
        let gaze = Vec3::new(0.42 * side, 0.05, 1.0).normalize();
        let offset = p - eye(side);
        let along = offset.dot(gaze).clamp(0.0, 0.12);
        (offset - gaze * along).length() < EYE_RADIUS + 0.002
    };
    bare_nose || before_eye(-1.0) || before_eye(1.0)
}

/// Lets a hair grow: out of the skin, then the way it is combed, held off the body and drawn towards the
/// middle of its tuft.
fn grow(
    points: &mut [Vec3; SEGMENTS + 1],
    rng: &mut Rng,
    body: &Body,
    seed: u32,
    (root, normal): (Vec3, Vec3),
    coat: &Coat,
) {
    let stray = rng.happens(0.04);
    let length = coat.length * rng.between(0.65, 1.1) * if stray { 1.25 } else { 1.0 };
    let step = length / SEGMENTS as f32;
    let wander = rng.gaussian() * if stray { 0.5 } else { 0.16 };
    let inward = hair::tuft(root, 0.035 + 0.12 * coat.length, seed).centre - root;
    let inward = inward - normal * normal.dot(inward);
    let comb = coat.comb - normal * normal.dot(coat.comb);
    let mut direction = (normal * 0.8 + comb * 0.7 + wander).normalize_or(normal);
    points[0] = root;
    for i in 1..=SEGMENTS {
        let way = i as f32 / SEGMENTS as f32;
        let mut next = points[i - 1] + direction * step;
        // Tips of a tuft come together.
        next += inward * if stray { 0.0 } else { 0.9 * way / SEGMENTS as f32 };
        // Two pushes: in a crease the first one leads into the other side.
        let least = 0.12 * length * way.sqrt();
        let mut away = normal;
        for _ in 0..2 {
            let field = body.field(next);
            next += field.away * (least - field.distance).max(0.0);
            away = field.away;
        }
        points[i] = next;
        let lie = comb - away * away.dot(comb);
        direction = (direction + lie * 0.75 + wander * 0.5 + Vec3::NEG_Y * 0.10).normalize_or(direction);
    }
}

#[cfg(test)]
mod tests {
    use sheer_scene::model::Mesh;

    use super::*;
    use crate::{catalogue, kit::body::ON_SURFACE};

    const PER_HAIR: usize = 2 * SEGMENTS + 1;

    fn locks(scene: &Scene) -> Vec<&Mesh> {
        scene.parts().meshes.iter().filter(|mesh| mesh.name == "lock").collect()
    }

    #[test]
    fn there_are_as_many_hairs_and_objects_as_asked_for() {
        for (count, objects) in [(1, 1), (300, 1), (301, 2), (4000, 14)] {
            let scene = catalogue::build(&format!("hairball:hairs={count}")).unwrap();
            let locks = locks(&scene);
            assert_eq!(locks.len(), objects, "{count} hairs");
            let triangles: usize = locks.iter().map(|mesh| mesh.indices.len()).sum();
            assert_eq!(triangles as u32, count * hair::triangle_count(SEGMENTS as u32));
            let mut ids: Vec<u32> = scene.parts().instances.iter().map(|instance| instance.id).collect();
            ids.dedup();
            assert!(ids.is_sorted() && ids.len() >= objects, "each lock is an object of its own");
        }
    }

    #[test]
    fn hairs_start_on_the_body_and_leave_eyes_and_nose_free() {
        let scene = catalogue::build("hairball:hairs=6000,seed=2").unwrap();
        let body = body();
        for mesh in locks(&scene) {
            for hair in mesh.positions.chunks_exact(PER_HAIR) {
                let root = 0.5 * (hair[0] + hair[1]);
                assert!(body.field(root).distance.abs() < 2.0 * ON_SURFACE);
                let tip = hair[PER_HAIR - 1];
                assert!(body.field(tip).distance > 0.0, "no tip grows back into the body: {tip}");
                assert!(!in_the_way(root) && !in_the_way(tip), "{root} {tip}");
            }
        }
        // What would be found.
        assert!(in_the_way(eye(1.0) + Vec3::Z * 0.05) && in_the_way(NOSE));
    }

    #[test]
    fn hairs_narrow_and_fade_towards_their_tips() {
        let scene = catalogue::build("hairball:hairs=500,alpha=0.4").unwrap();
        for mesh in locks(&scene) {
            for (hair, colours) in
                mesh.positions.chunks_exact(PER_HAIR).zip(mesh.colours.chunks_exact(PER_HAIR))
            {
                let width = |i: usize| hair[2 * i].distance(hair[2 * i + 1]);
                assert!((1..SEGMENTS).all(|i| width(i) < width(i - 1)));
                assert!((colours[0].w - 0.4).abs() < 1e-6 && colours[PER_HAIR - 1].w < 0.1);
            }
        }
    }
}

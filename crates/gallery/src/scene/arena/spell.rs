//! The effects of the arena: everything that is transparent, when it comes and when it goes.
//!
//! Light that shines by itself is a surface of that radiance which covers what is behind it; nothing is added
//! to what is behind.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec2, Vec3, Vec4};
use sheer_scene::{
    model::{AlphaMode, Animation, Channel, Interpolation, Keys, Material, ShadingModel, TextureRef, Track},
    particle::{Particle, ParticleSystem, Turbulence},
};

use super::{
    body::{GOLEM_MOUTH, crescent, staff_tip},
    cast::{BARRIER_SECS, BREATH_SECS, CAST, Cast, HEART, SLASH, SMASH_SECS, WATER_SECS},
    figure::{Actor, CHEST, CLIP_SECS, HEAD, LEFT_HAND, RIGHT_HAND, ROOT},
    paint::{self, DROP, FLAME_ATLAS, FLAME_TILES, GLOW, SPARK},
    ring,
};
use crate::{
    builder::SceneBuilder,
    kit::smoke,
    rng::Rng,
    shape::{Model, Shape, Vertex},
};

/// How much of everything.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effects {
    /// Factor on every number of effects.
    pub(super) amount: f32,
    pub(super) seed: u32,
}

/// Linear colours of the magic of either side.
const ICE: Vec3 = Vec3::new(0.22, 0.62, 1.0);
const SEA: Vec3 = Vec3::new(0.10, 0.85, 0.80);
const GOLD: Vec3 = Vec3::new(1.0, 0.68, 0.20);
const VIOLET: Vec3 = Vec3::new(0.62, 0.16, 1.0);
const EMBER: Vec3 = Vec3::new(1.0, 0.26, 0.05);

/// How far the barrier stands in front of the one who holds it, how wide it reaches, and how high.
const BARRIER_RADIUS: f32 = 2.1;
const BARRIER_HALF_TURN_RAD: f32 = 1.15;
const BARRIER_HEIGHT: f32 = 3.3;
/// Fire in the braziers repeats after this time, a whole share of the clip.
const BRAZIER_LOOP_SECS: f32 = 2.0;
const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// The figure that a bolt is thrown at, and how far before its heart the bolt bursts.
type Target<'a> = (&'a Actor, f32);

/// Effects in the making.
struct Conjurer<'a> {
    builder: &'a mut SceneBuilder,
    cast: &'a Cast,
    rng: Rng,
    amount: f32,
    /// Mesh effects asked for so far.
    asked: u32,
    channels: Vec<Channel>,
    fire: Vec<Particle>,
    light: Vec<Particle>,
    drops: Vec<Particle>,
    dust: Vec<Particle>,
}

/// Adds all effects; none at all if their amount is zero.
pub(super) fn conjure(builder: &mut SceneBuilder, cast: &Cast, effects: Effects) {
    if effects.amount <= 0.0 {
        return;
    }
    let mut conjurer = Conjurer {
        builder,
        cast,
        rng: Rng::new(effects.seed, "spells"),
        amount: effects.amount,
        asked: 0,
        channels: Vec::new(),
        fire: Vec::new(),
        light: Vec::new(),
        drops: Vec::new(),
        dust: Vec::new(),
    };
    conjurer.raise_shields();
    conjurer.raise_barrier(effects.seed);
    conjurer.draw_circles(effects.seed);
    conjurer.light_pillar();
    conjurer.swing_blades(effects.seed);
    conjurer.show_health();
    conjurer.throw_bolts();
    conjurer.breathe_fire();
    conjurer.call_water();
    conjurer.smash();
    conjurer.finish(effects.seed);
}

/// A particle that neither turns nor changes its size.
fn mote(birth_secs: f32, lifetime_secs: f32, origin: Vec3) -> Particle {
    Particle {
        birth_secs,
        lifetime_secs,
        origin,
        velocity: Vec3::ZERO,
        acceleration: Vec3::ZERO,
        half_size: [0.1, 0.1],
        rotation_rad: 0.0,
        spin_rad_per_sec: 0.0,
        alpha: 1.0,
        tint: Vec3::ONE,
        tile: GLOW,
    }
}

/// A puff of smoke or dust, before it is told where to go.
fn puff(birth_secs: f32, lifetime_secs: f32, origin: Vec3, rng: &mut Rng) -> Particle {
    Particle {
        rotation_rad: rng.between(0.0, TAU),
        spin_rad_per_sec: rng.about(0.0, 0.4),
        tile: rng.below(smoke::ATLAS[0] * smoke::ATLAS[1]),
        ..mote(birth_secs, lifetime_secs, origin)
    }
}

impl Conjurer<'_> {
    /// How many of what there are `base` of by default.
    fn number(&self, base: u32) -> u32 {
        (base as f32 * self.amount).round() as u32
    }

    /// Whether the next of the effects that are meshes is there: all by default, an even share of them below
    /// that.
    fn next_is_there(&mut self) -> bool {
        self.asked += 1;
        (self.asked as f32 * 0.618_034).fract() < self.amount
    }

    /// A surface that shines with `radiance` times the texture and covers what is behind it.
    fn shining(&mut self, name: &str, texture: Option<u32>, radiance: Vec4) -> u32 {
        self.builder.material(Material {
            name: name.to_owned(),
            model: ShadingModel::Luminous,
            base_colour: radiance,
            base_colour_texture: texture.map(TextureRef::new),
            alpha_mode: AlphaMode::Blend,
            double_sided: true,
            ..Material::default()
        })
    }

    /// Lets a node grow to `size` at the start of a time and shrink to nothing at its end.
    fn show(&mut self, node: u32, [start, end]: [f32; 2], grow_secs: f32, size: Vec3, hidden: Vec3) {
        self.channels.push(Channel {
            node,
            track: Track::Scale(Keys {
                times_secs: vec![0.0, start, start + grow_secs, end - grow_secs, end, CLIP_SECS],
                values: vec![hidden, hidden, size, size, hidden, hidden],
                interpolation: Interpolation::Linear,
            }),
        });
    }

    fn raise_shields(&mut self) {
        let facet = self.builder.texture("facet", paint::facet);
        let cast = self.cast;
        let shields: [(&Actor, f32, Vec3, [f32; 2]); 9] = [
            (&cast.tidecaller, 1.30, SEA, [1.5, 8.7]),
            (&cast.healer, 1.30, GOLD, [2.1, 8.3]),
            (&cast.warlocks[0], 1.25, VIOLET, [2.7, 8.4]),
            (&cast.knights[2], 1.20, ICE, [3.0, 8.0]),
            (&cast.knights[0], 1.22, ICE, [3.5, 7.8]),
            (&cast.warlocks[1], 1.35, EMBER, [3.9, 7.7]),
            (&cast.knights[1], 1.22, ICE, [4.5, 7.5]),
            (&cast.raiders[1], 1.35, EMBER, [5.0, 7.3]),
            (&cast.warden, 1.25, ICE, [5.5, 7.6]),
        ];
        for (actor, radius, colour, time) in shields {
            if !self.next_is_there() {
                continue;
            }
            let material = self.builder.material(Material {
                name: "shield".to_owned(),
                base_colour: (0.25 * colour).extend(0.80),
                base_colour_texture: Some(TextureRef::new(facet)),
                emissive: 0.95 * colour,
                emissive_texture: Some(TextureRef::new(facet)),
                alpha_mode: AlphaMode::Blend,
                roughness: 0.16,
                double_sided: true,
                ..Material::default()
            });
            let prop = self.builder.prop("shield", geodesic(material));
            // More effects: shells around shells.
            for shell in 0..self.amount.ceil() as u32 {
                let node = self.builder.joint("shield", None, Vec3::ZERO);
                self.builder.hang(&prop, node);
                self.channels.push(actor.follow(node, 0.85));
                let size = Vec3::splat(radius * (1.0 + 0.05 * shell as f32));
                let late = 0.15 * shell as f32 / self.amount;
                self.show(node, [time[0] + late, time[1] - late], 0.22, size, Vec3::ZERO);
            }
        }
    }

    /// Where the holder of the barrier stands, and the unit direction along the ground from there to the
    /// golem's mouth.
    fn against_golem(&self) -> (Vec3, Vec3) {
        let middle = 0.5 * (BREATH_SECS[0] + BREATH_SECS[1]);
        let warden = self.cast.warden.point(ROOT, Vec3::ZERO, middle);
        let mouth = self.cast.golem.point(HEAD, GOLEM_MOUTH, middle);
        (warden, (mouth - warden).with_y(0.0).normalize())
    }

    fn raise_barrier(&mut self, seed: u32) {
        let texture = self.builder.texture("curtain", move || paint::curtain(seed));
        let material = self.shining("barrier", Some(texture), (1.5 * ICE).extend(0.95));
        let (warden, towards) = self.against_golem();
        for shell in 0..1 + self.amount.ceil() as u32 {
            if !self.next_is_there() {
                continue;
            }
            let prop = self.builder.prop("barrier", barrier(material, BARRIER_RADIUS + 0.16 * shell as f32));
            let node = self.builder.joint("barrier", None, warden);
            self.builder.hang(&prop, node);
            let turn = Quat::from_rotation_y(towards.x.atan2(towards.z));
            let keys =
                Keys { times_secs: vec![0.0], values: vec![turn], interpolation: Interpolation::Linear };
            self.channels.push(Channel { node, track: Track::Rotation(keys) });
            let late = 0.12 * shell as f32 / self.amount.max(1.0);
            // It rises out of the ground and sinks back into it.
            let time = [BARRIER_SECS[0] + late, BARRIER_SECS[1] - late];
            self.show(node, time, 0.4, Vec3::ONE, Vec3::new(1.0, 0.0, 1.0));
        }
        self.flare("barrier", warden + 1.4 * towards + Vec3::Y * 1.2, 7.0 * ICE, 7.0, BARRIER_SECS);
    }

    /// A lamp that is there for a while; the rest of the time it is too deep under the ground to reach
    /// anything.
    fn flare(&mut self, name: &str, at: Vec3, candela: Vec3, range: f32, [start, end]: [f32; 2]) {
        let below = at - Vec3::Y * (2.0 * range + 10.0);
        let node = self.builder.joint(name, None, below);
        self.builder.lamp_on(name, node, candela, range);
        let keys = Keys {
            times_secs: vec![0.0, start, end, CLIP_SECS],
            values: vec![below, at, below, below],
            interpolation: Interpolation::Step,
        };
        self.channels.push(Channel { node, track: Track::Translation(keys) });
    }

    fn draw_circles(&mut self, seed: u32) {
        let texture = self.builder.texture("circle", move || paint::circle(seed));
        let cast = self.cast;
        let circles: [(&Actor, f32, Vec3, [f32; 2]); 6] = [
            (&cast.tidecaller, 1.6, SEA, [0.9, 8.9]),
            (&cast.healer, 1.9, GOLD, [1.7, 8.5]),
            (&cast.warlocks[0], 1.6, VIOLET, [1.6, 8.6]),
            (&cast.warlocks[1], 1.6, EMBER, [2.2, 8.0]),
            (&cast.warden, 1.75, ICE, [3.7, 8.4]),
            (&cast.golem, 3.0, EMBER, [4.3, 7.9]),
        ];
        for (index, (actor, radius, colour, time)) in circles.into_iter().enumerate() {
            if !self.next_is_there() {
                continue;
            }
            let material = self.shining("circle", Some(texture), (2.0 * colour).extend(0.92));
            let mut model = Model::default();
            let (right, up) = (Vec3::X * 2.0, Vec3::Z * -2.0);
            model.paint(material, Vec3::ONE).fitted_panel(
                -0.5 * (right + up),
                right,
                up,
                Vec2::ZERO,
                Vec2::ONE,
            );
            let prop = self.builder.prop("circle", model);
            let node = self.builder.joint("circle", None, Vec3::ZERO);
            self.builder.hang(&prop, node);
            // Circles that overlap lie at heights of their own, above the inlays of the floor.
            self.channels.push(actor.follow(node, 0.03 + 0.012 * index as f32));
            let turn = if index % 2 == 0 { TAU } else { -TAU };
            let keys = Keys {
                times_secs: (0..=4).map(|quarter| CLIP_SECS * quarter as f32 / 4.0).collect(),
                values: (0..=4).map(|quarter| Quat::from_rotation_y(turn * quarter as f32 / 4.0)).collect(),
                interpolation: Interpolation::Linear,
            };
            self.channels.push(Channel { node, track: Track::Rotation(keys) });
            self.show(node, time, 0.5, Vec3::new(radius, 1.0, radius), Vec3::ZERO);
        }
    }

    /// Light that rises around the healer.
    fn light_pillar(&mut self) {
        let time = [2.4, 7.9];
        let healer = self.cast.healer.point(ROOT, Vec3::ZERO, time[0]);
        let material = self.shining("pillar of light", None, (1.3 * GOLD).extend(0.42));
        for radius in [0.55, 0.85, 1.15] {
            if !self.next_is_there() {
                continue;
            }
            let mut model = Model::default();
            let height = 4.6 - 1.4 * radius;
            column(model.paint(material, Vec3::ONE), radius, height);
            let prop = self.builder.prop("pillar of light", model);
            let node = self.builder.joint("pillar of light", None, healer + Vec3::Y * 0.02);
            self.builder.hang(&prop, node);
            self.show(node, time, 0.6, Vec3::ONE, Vec3::new(1.0, 0.0, 1.0));
        }
        for _ in 0..self.number(90) {
            let birth_secs = self.rng.between(time[0], time[1] - 1.2);
            let away = Vec2::from_angle(self.rng.between(0.0, TAU)) * self.rng.between(0.4, 1.2);
            let size = self.rng.between(0.03, 0.07);
            self.light.push(Particle {
                velocity: Vec3::Y * self.rng.between(0.8, 1.7),
                half_size: [size, 0.6 * size],
                tint: 4.0 * GOLD,
                tile: SPARK,
                ..mote(birth_secs, 1.6, healer + Vec3::new(away.x, 0.1, away.y))
            });
        }
    }

    /// What a blade leaves in the air.
    fn swing_blades(&mut self, seed: u32) {
        let texture = self.builder.texture("trail", move || paint::trail(seed));
        let cast = self.cast;
        let bright = self.shining("trail", Some(texture), Vec4::new(1.5, 2.1, 2.8, 0.9));
        let dark = self.shining("trail", Some(texture), Vec4::new(2.8, 0.55, 0.16, 0.9));
        let heroes = cast.knights.iter().map(|actor| (actor, bright));
        for (actor, material) in heroes.chain(cast.raiders.iter().map(|actor| (actor, dark))) {
            let prop = self.builder.prop("trail", crescent(material, 0.55, 1.65));
            for start in actor.starts(SLASH) {
                if !self.next_is_there() {
                    continue;
                }
                let node = self.builder.joint("trail", Some(actor.root), Vec3::Y * 1.25);
                self.builder.hang(&prop, node);
                // While the blade comes down, and a little longer.
                self.show(node, [start + 0.30, start + 0.72], 0.10, Vec3::ONE, Vec3::ZERO);
            }
        }
    }

    /// A bar above every head: a dark card and, in front of it, one that shrinks with every blow.
    fn show_health(&mut self) {
        let frame = self.shining("health frame", None, Vec4::new(0.012, 0.012, 0.016, 0.62));
        let [green, red] = [Vec4::new(0.10, 0.85, 0.16, 0.80), Vec4::new(0.95, 0.10, 0.05, 0.80)]
            .map(|colour| self.shining("health", None, colour));
        let cast = self.cast;
        // Hats are higher than helmets.
        let [hat, helmet] = [2.42, 2.16];
        let bar = |colour, height| move |actor| (actor, colour, height, 0.40);
        let everybody = [&cast.warden, &cast.tidecaller, &cast.healer].into_iter().map(bar(green, hat));
        let everybody = everybody.chain(cast.knights.iter().map(bar(green, helmet)));
        let everybody = everybody.chain(cast.warlocks.iter().map(bar(red, hat)));
        let everybody = everybody.chain(cast.raiders.iter().map(bar(red, helmet)));
        for (actor, colour, height, half) in everybody.chain([(&cast.golem, red, 4.7, 1.0)]) {
            let tall = 0.075 * f32::sqrt(half / 0.40);
            let node = self.builder.joint("health", None, Vec3::ZERO);
            self.channels.push(actor.follow(node, height));
            let mut card = Model::default();
            let rim = 0.025;
            card.paint(frame, Vec3::ONE).panel(
                Vec3::new(-half - rim, -0.5 * tall - rim, 0.0),
                Vec3::X * 2.0 * (half + rim),
                Vec3::Y * (tall + 2.0 * rim),
            );
            let prop = self.builder.prop("health frame", card);
            self.builder.hang(&prop, node);
            let mut filling = Model::default();
            filling.paint(colour, Vec3::ONE).panel(
                Vec3::Y * (-0.5 * tall),
                Vec3::X * (2.0 * half),
                Vec3::Y * tall,
            );
            let prop = self.builder.prop("health", filling);
            let full = self.builder.joint("health", Some(node), Vec3::new(-half, 0.0, 0.02));
            self.builder.hang(&prop, full);
            // Three blows; the clip ends with all of them healed, since it loops.
            let mut left = 1.0;
            let mut keys =
                Keys { times_secs: vec![0.0], values: vec![Vec3::ONE], interpolation: Interpolation::Linear };
            for blow in 0..3 {
                let start = 2.6 + 1.7 * blow as f32 + self.rng.about(0.0, 0.5);
                keys.times_secs.extend([start, start + 0.15]);
                keys.values.push(Vec3::new(left, 1.0, 1.0));
                left -= self.rng.between(0.08, 0.26);
                keys.values.push(Vec3::new(left, 1.0, 1.0));
            }
            keys.times_secs.extend([9.0, CLIP_SECS]);
            keys.values.extend([Vec3::new(left, 1.0, 1.0), Vec3::ONE]);
            self.channels.push(Channel { node: full, track: Track::Scale(keys) });
        }
    }

    fn throw_bolts(&mut self) {
        let cast = self.cast;
        let golem = (&cast.golem, 0.7);
        let (tidecaller, healer) = ((&cast.tidecaller, 1.35), (&cast.healer, 1.35));
        let [in_front, _, behind] = &cast.knights;
        let (in_front, behind) = ((in_front, 1.3), (behind, 1.3));
        // Who, and at whom in turn; bolts burst where there may be a shield.
        let throws: [(&Actor, Vec3, &[Target<'_>]); 5] = [
            (&cast.warden, ICE, &[golem]),
            (&cast.tidecaller, SEA, &[golem]),
            (&cast.healer, GOLD, &[(&cast.raiders[2], 0.3)]),
            (&cast.warlocks[0], VIOLET, &[tidecaller, tidecaller, in_front, in_front, tidecaller]),
            (&cast.warlocks[1], EMBER, &[healer, behind]),
        ];
        for (caster, colour, targets) in throws {
            for (start, &(target, before)) in caster.starts(CAST).zip(targets.iter().cycle()) {
                for shot in 0..self.number(3) {
                    // The salvo flies off with the thrust of the staff, bolt after bolt within a third of a
                    // second.
                    let start = start + 0.46 + 0.33 * shot as f32 / (3.0 * self.amount);
                    self.throw(caster, start, target, before, colour);
                }
            }
        }
    }

    /// A bolt with its trail and its burst.
    fn throw(&mut self, caster: &Actor, start: f32, target: &Actor, before: f32, colour: Vec3) {
        // It flies on a parabola that bends at random and ends where it meets its target.
        let from = caster.point(RIGHT_HAND, staff_tip(), start);
        let aim = target.point(CHEST, HEART, start + 0.6) + self.rng.gaussian() * 0.15;
        let to = aim - (aim - from).normalize() * before;
        let flight_secs = from.distance(to) / 11.0;
        let bend =
            Vec3::new(self.rng.about(0.0, 5.0), self.rng.between(-9.0, -1.0), self.rng.about(0.0, 5.0));
        let velocity = (to - from) / flight_secs - 0.5 * bend * flight_secs;
        let flying = Particle { velocity, acceleration: bend, ..mote(start, flight_secs, from) };
        // The bolt itself: a halo, a glow and a white core that fly together.
        let white = Vec3::splat(0.5) + colour;
        for (half_size, alpha, tint) in
            [(0.55, 0.45, 2.0 * colour), (0.24, 0.85, 3.5 * colour), (0.11, 1.0, 6.0 * white)]
        {
            self.light.push(Particle { half_size: [half_size; 2], alpha, tint, ..flying });
        }
        // Sparks that it leaves along its way.
        for _ in 0..self.number(22) {
            let age = self.rng.unit() * flight_secs;
            let at = from + velocity * age + 0.5 * bend * age * age;
            let size = self.rng.between(0.06, 0.15);
            self.light.push(Particle {
                velocity: 0.06 * velocity + self.rng.gaussian() * 0.18,
                half_size: [size, 0.3 * size],
                alpha: 0.75,
                tint: colour * self.rng.between(1.5, 4.0),
                tile: if self.rng.happens(0.4) { SPARK } else { GLOW },
                ..mote(start + age, self.rng.between(0.25, 0.65), at + self.rng.gaussian() * 0.03)
            });
        }
        // It bursts in a flash and throws sparks back.
        let burst_secs = start + flight_secs;
        self.light.push(Particle {
            half_size: [0.3, 1.0],
            alpha: 0.8,
            tint: 3.0 * white,
            ..mote(burst_secs, 0.3, to)
        });
        for _ in 0..self.number(16) {
            let size = self.rng.between(0.03, 0.07);
            let out = self.rng.direction() - 0.35 * velocity.normalize();
            self.light.push(Particle {
                velocity: out * self.rng.between(1.0, 3.6),
                acceleration: 0.5 * GRAVITY,
                half_size: [size, 0.4 * size],
                tint: 4.0 * colour + Vec3::splat(0.4),
                tile: SPARK,
                ..mote(burst_secs, self.rng.between(0.3, 0.7), to)
            });
        }
    }

    /// A jet of fire from the golem's mouth that breaks on the barrier.
    fn breathe_fire(&mut self) {
        let (warden, towards) = self.against_golem();
        let side = Vec3::Y.cross(towards);
        let hit = warden + towards * (BARRIER_RADIUS + 0.35) + Vec3::Y * 1.35;
        let flight_secs = 0.5;
        for _ in 0..self.number(560) {
            let birth_secs = self.rng.between(BREATH_SECS[0], BREATH_SECS[1]);
            let mouth = self.cast.golem.point(HEAD, GOLEM_MOUTH, birth_secs);
            let spread = side * self.rng.gaussian().x * 0.32 + Vec3::Y * self.rng.gaussian().x * 0.30;
            let lifetime_secs = flight_secs * self.rng.between(0.85, 1.0);
            let end = mouth.lerp(hit + spread, lifetime_secs / flight_secs);
            let heat = self.rng.unit();
            self.fire.push(Particle {
                velocity: (end - mouth) / lifetime_secs,
                half_size: [0.12, self.rng.between(0.34, 0.62)],
                rotation_rad: self.rng.between(0.0, TAU),
                spin_rad_per_sec: self.rng.about(0.0, 5.0),
                alpha: self.rng.between(0.45, 0.9),
                tint: Vec3::new(2.3, 1.3, 0.5) * (0.5 + 0.9 * heat * heat),
                tile: self.rng.below(FLAME_TILES),
                ..mote(birth_secs, lifetime_secs, mouth + self.rng.gaussian() * 0.06)
            });
        }
        self.splash_fire(hit, towards, flight_secs);
        for _ in 0..self.number(70) {
            let birth_secs = self.rng.between(BREATH_SECS[0] + 0.6, BREATH_SECS[1] + 0.6);
            self.dust.push(Particle {
                velocity: Vec3::Y * self.rng.between(0.7, 1.3) + towards * 0.2 + self.rng.gaussian() * 0.15,
                half_size: [0.3, self.rng.between(0.7, 1.2)],
                alpha: self.rng.between(0.12, 0.3),
                tint: Vec3::splat(0.13),
                ..puff(birth_secs, 2.2, hit + Vec3::Y * 1.1, &mut self.rng)
            });
        }
        let middle = 0.5 * (BREATH_SECS[0] + BREATH_SECS[1]);
        let mouth = self.cast.golem.point(HEAD, GOLEM_MOUTH, middle);
        let time = [BREATH_SECS[0] + 0.1, BREATH_SECS[1] + 0.2];
        // Beside the jet, which would swallow its light.
        let beside = mouth.lerp(hit, 0.62) + side * 0.9 + Vec3::Y * 0.5;
        let beside =
            if beside.z > hit.z { beside } else { mouth.lerp(hit, 0.62) - side * 0.9 + Vec3::Y * 0.5 };
        self.flare("breath", beside, Vec3::new(38.0, 14.0, 3.2), 11.0, time);
    }

    /// What spreads along the barrier from where the jet hits it.
    fn splash_fire(&mut self, hit: Vec3, towards: Vec3, flight_secs: f32) {
        let side = Vec3::Y.cross(towards);
        for _ in 0..self.number(420) {
            let birth_secs = self.rng.between(BREATH_SECS[0], BREATH_SECS[1]) + 0.9 * flight_secs;
            let angle = self.rng.between(-0.35, PI + 0.35);
            let along = side * angle.cos() + Vec3::Y * angle.sin();
            let speed = self.rng.between(1.2, 4.2);
            self.fire.push(Particle {
                velocity: along * speed + towards * 0.25,
                // The wall is round: what spreads along it turns around it.
                acceleration: towards * (-0.35 * speed * angle.cos().powi(2)) + Vec3::Y * 1.3
                    - along * speed * 0.5,
                half_size: [0.16, self.rng.between(0.26, 0.52)],
                rotation_rad: self.rng.between(0.0, TAU),
                spin_rad_per_sec: self.rng.about(0.0, 4.0),
                alpha: self.rng.between(0.35, 0.8),
                tint: Vec3::new(2.0, 1.0, 0.35) * self.rng.between(0.35, 1.0),
                tile: self.rng.below(FLAME_TILES),
                ..mote(birth_secs, self.rng.between(0.45, 0.95), hit + self.rng.gaussian() * 0.12)
            });
        }
    }

    /// Water that is thrown in an arc at the golem, splashes and turns to steam.
    fn call_water(&mut self) {
        let flight_secs = 0.95;
        for index in 0..self.number(1200) {
            let birth_secs = self.rng.between(WATER_SECS[0], WATER_SECS[1]);
            let from = self.cast.tidecaller.point(RIGHT_HAND, staff_tip(), birth_secs);
            let aim = self.cast.golem.point(CHEST, Vec3::new(0.3, 1.1, 0.75), birth_secs + flight_secs);
            // Three strands that wind around each other.
            let turn = TAU * (1.1 * birth_secs + index as f32 / 3.0);
            let strand = Vec3::new(0.3 * turn.cos(), 0.3 * turn.sin(), 0.0);
            let to = aim + 1.1 * strand + self.rng.gaussian() * 0.14;
            let velocity = (to - from) / flight_secs - 0.5 * GRAVITY * flight_secs;
            let size = if self.rng.happens(0.15) {
                self.rng.between(0.05, 0.08)
            } else {
                self.rng.between(0.022, 0.048)
            };
            self.drops.push(Particle {
                velocity,
                acceleration: GRAVITY,
                half_size: [0.7 * size, size],
                alpha: self.rng.between(0.45, 0.8),
                tint: Vec3::new(0.45, 0.85, 1.0),
                tile: DROP,
                ..mote(birth_secs, flight_secs, from + 0.5 * strand)
            });
            if index.is_multiple_of(3) {
                let size = self.rng.between(0.025, 0.06);
                let out = self.rng.direction() - 0.5 * velocity.normalize() + Vec3::Y * 0.5;
                self.drops.push(Particle {
                    velocity: out * self.rng.between(0.8, 3.0),
                    acceleration: GRAVITY,
                    half_size: [size; 2],
                    alpha: 0.7,
                    tint: Vec3::new(0.6, 0.9, 1.0),
                    tile: DROP,
                    ..mote(birth_secs + flight_secs, self.rng.between(0.35, 0.7), to)
                });
            }
            if index.is_multiple_of(12) {
                let rise = Vec3::Y * self.rng.between(0.5, 1.1);
                self.dust.push(Particle {
                    velocity: rise + self.rng.gaussian() * 0.2,
                    half_size: [0.2, self.rng.between(0.5, 0.9)],
                    alpha: self.rng.between(0.12, 0.30),
                    tint: Vec3::new(0.75, 0.82, 0.88),
                    ..puff(birth_secs + flight_secs, 1.5, to, &mut self.rng)
                });
            }
        }
    }

    /// Dust and splinters where the golem's fists come down, and what they stir up along the ground.
    fn smash(&mut self) {
        for hand in [RIGHT_HAND, LEFT_HAND] {
            let fist = self.cast.golem.point(hand, Vec3::Y * -1.2, SMASH_SECS + 0.05).with_y(0.15);
            for _ in 0..self.number(80) {
                let around = Vec2::from_angle(self.rng.between(0.0, TAU));
                let out =
                    Vec3::new(around.x, self.rng.between(0.05, 0.4), around.y) * self.rng.between(0.9, 2.9);
                let lifetime_secs = self.rng.between(1.4, 2.8);
                self.dust.push(Particle {
                    velocity: out,
                    acceleration: -out / lifetime_secs * 0.85,
                    half_size: [0.2, self.rng.between(0.5, 0.95)],
                    alpha: self.rng.between(0.20, 0.48),
                    // Light scatters many times in a puff, so that it is brighter than single scattering
                    // makes it.
                    tint: Vec3::new(2.2, 1.75, 1.4),
                    ..puff(SMASH_SECS + self.rng.between(-0.02, 0.1), lifetime_secs, fist, &mut self.rng)
                });
            }
            for _ in 0..self.number(40) {
                let size = self.rng.between(0.025, 0.06);
                let out = self.rng.direction() * Vec3::new(1.0, 0.4, 1.0) + Vec3::Y * 0.9;
                self.light.push(Particle {
                    velocity: out * self.rng.between(1.5, 4.5),
                    acceleration: GRAVITY,
                    half_size: [size, 0.6 * size],
                    tint: 4.0 * EMBER + Vec3::splat(0.2),
                    tile: SPARK,
                    ..mote(SMASH_SECS, self.rng.between(0.4, 0.8), fist)
                });
            }
        }
        // Feet raise dust while the fight is hot.
        let cast = self.cast;
        let fighters: Vec<&Actor> = cast.knights.iter().chain(&cast.raiders).chain([&cast.golem]).collect();
        for _ in 0..self.number(150) {
            let birth_secs = 1.5 + 5.2 * self.rng.unit().powf(0.6);
            let actor = *self.rng.pick(&fighters);
            let spread = self.rng.gaussian() * Vec3::new(0.5, 0.0, 0.5);
            let at = actor.point(ROOT, spread + Vec3::Y * 0.2, birth_secs);
            self.dust.push(Particle {
                velocity: self.rng.gaussian() * Vec3::new(0.22, 0.05, 0.22) + Vec3::Y * 0.12,
                half_size: [0.2, self.rng.between(0.45, 0.85)],
                alpha: self.rng.between(0.06, 0.20),
                tint: Vec3::new(1.9, 1.55, 1.25),
                ..puff(birth_secs, self.rng.between(1.2, 2.4), at, &mut self.rng)
            });
        }
    }

    /// Fire in the braziers, and sparks that fly up from it.
    fn kindle(&mut self) -> Vec<Particle> {
        let mut flames = Vec::new();
        for fire in ring::braziers() {
            for _ in 0..self.number(56) {
                let around = self.rng.gaussian() * Vec3::new(0.20, 0.02, 0.20);
                let lifetime_secs = self.rng.between(0.6, 1.15);
                let tall = self.rng.between(0.75, 1.35);
                flames.push(Particle {
                    velocity: Vec3::Y * tall - around * 0.9,
                    half_size: [self.rng.between(0.24, 0.34), 0.06],
                    rotation_rad: self.rng.between(0.0, TAU),
                    spin_rad_per_sec: self.rng.about(0.0, 2.5),
                    alpha: self.rng.between(0.45, 0.85),
                    tint: Vec3::new(2.2, 1.25, 0.45) * self.rng.between(0.45, 1.1),
                    tile: self.rng.below(FLAME_TILES),
                    ..mote(
                        self.rng.between(0.0, BRAZIER_LOOP_SECS),
                        lifetime_secs,
                        fire + around + Vec3::Y * 0.2,
                    )
                });
            }
            for _ in 0..self.number(12) {
                let birth_secs = self.rng.between(0.0, CLIP_SECS);
                let drift = self.rng.gaussian() * 0.25 + Vec3::Y * self.rng.between(0.9, 1.7);
                self.light.push(Particle {
                    velocity: drift,
                    acceleration: self.rng.gaussian() * 0.3,
                    half_size: [0.035, 0.02],
                    tint: Vec3::new(6.0, 1.8, 0.4),
                    tile: SPARK,
                    ..mote(birth_secs, self.rng.between(1.2, 2.4), fire + Vec3::Y * 0.5)
                });
            }
        }
        flames
    }

    /// Everything that is a particle enters the scene.
    fn finish(mut self, seed: u32) {
        let flames = self.kindle();
        let clouds = self.clouds();

        let atlas = self.builder.texture("flames", move || paint::flames(seed));
        let shining = self.shining("flames", Some(atlas), Vec4::ONE);
        let water = self.builder.material(Material {
            name: "drops".to_owned(),
            base_colour: Vec4::new(0.5, 0.75, 0.85, 1.0),
            base_colour_texture: Some(TextureRef::new(atlas)),
            alpha_mode: AlphaMode::Blend,
            emissive: Vec3::new(0.03, 0.10, 0.13),
            roughness: 0.12,
            double_sided: true,
            ..Material::default()
        });
        let smoke = smoke::material(self.builder, seed);
        let still = Turbulence::default();
        // Turbulence turns a whole number of times in a loop, so that the clip has no seam.
        let licking = Turbulence { amplitude: 0.05, scale: 1.3, speed: 0.5 };
        let rolling = Turbulence { amplitude: 0.07, scale: 1.8, speed: 0.2 };
        let mut system = |name: &str, material, atlas, particles, loop_secs, turbulence, fade, near_fade| {
            self.builder.particles(ParticleSystem {
                name: name.to_owned(),
                material,
                atlas,
                particles,
                loop_secs: Some(loop_secs),
                turbulence,
                fade,
                near_fade,
            });
        };
        let near = [0.9, 0.25];
        system("braziers", shining, FLAME_ATLAS, flames, BRAZIER_LOOP_SECS, licking, [0.15, 0.55], near);
        system("breath", shining, FLAME_ATLAS, self.fire, CLIP_SECS, licking, [0.10, 0.40], near);
        system("bolts", shining, FLAME_ATLAS, self.light, CLIP_SECS, still, [0.04, 0.35], near);
        system("water", water, FLAME_ATLAS, self.drops, CLIP_SECS, still, [0.05, 0.10], near);
        system("dust", smoke, smoke::ATLAS, self.dust, CLIP_SECS, rolling, [0.12, 0.55], [1.6, 0.4]);
        system("clouds", smoke, smoke::ATLAS, clouds, CLIP_SECS, still, [0.3, 0.3], near);
        self.builder.animate(Animation {
            name: "effects".to_owned(),
            channels: self.channels,
            properties: Vec::new(),
        });
    }

    /// Cards of cloud beyond the arena that catch the last light.
    fn clouds(&mut self) -> Vec<Particle> {
        let mut clouds = Vec::new();
        for bank in 0..self.number(9) {
            let turn = 0.53 + 0.045 * (bank as f32 - 4.0) + self.rng.about(0.0, 0.015);
            let middle = ring::around(turn, self.rng.between(155.0, 170.0), self.rng.between(34.0, 60.0));
            let across = Vec3::Y.cross(middle).normalize();
            for _ in 0..7 {
                let stray = self.rng.gaussian();
                let birth_secs = self.rng.between(0.0, CLIP_SECS);
                clouds.push(Particle {
                    velocity: across * 0.25,
                    half_size: [9.0, 12.0],
                    alpha: self.rng.between(0.22, 0.5),
                    // Light scatters many times in a cloud; scattered once it would be grey against the sky.
                    tint: Vec3::new(2.3, 1.6, 1.5),
                    spin_rad_per_sec: 0.0,
                    ..puff(
                        birth_secs,
                        CLIP_SECS,
                        middle + across * (13.0 * stray.x) + Vec3::Y * (1.8 * stray.y),
                        &mut self.rng,
                    )
                });
            }
        }
        clouds
    }
}

/// A unit sphere of triangles that show their edges. Four small triangles carry one of the texture's, so that
/// the sphere is rounder than its pattern.
fn geodesic(material: u32) -> Model {
    let mut model = Model::default();
    let shape = model.paint(material, Vec3::ONE);
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let corner = |index: usize| {
        let (a, b) = (if index & 1 == 0 { 1.0 } else { -1.0 }, if index & 2 == 0 { golden } else { -golden });
        match index / 4 {
            0 => Vec3::new(0.0, a, b),
            1 => Vec3::new(a, b, 0.0),
            _ => Vec3::new(b, 0.0, a),
        }
    };
    let corners: [Vec3; 12] = std::array::from_fn(|index| corner(index).normalize());
    // Neighbours are the pairs at the shortest distance; three mutual neighbours make a face.
    let near = |a: usize, b: usize| corners[a].distance(corners[b]) < 1.1;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let mut face = [corners[a], corners[b], corners[c]];
                    if (face[1] - face[0]).cross(face[2] - face[0]).dot(face[0]) < 0.0 {
                        face.swap(1, 2);
                    }
                    split(shape, face, None, 3);
                }
            }
        }
    }
    model
}

/// Splits a triangle of the unit sphere `depth` times; the texture is fitted to the triangles before the last
/// split.
fn split(shape: &mut Shape, corners: [Vec3; 3], uvs: Option<[Vec2; 3]>, depth: u32) {
    if depth == 0 {
        let first = shape.positions.len() as u32;
        for (position, uv) in corners.into_iter().zip(uvs.unwrap_or(FACET)) {
            shape.vertex(Vertex { position, normal: position, uv });
        }
        shape.indices.push([first, first + 1, first + 2]);
        return;
    }
    let uvs = if depth == 1 { Some(uvs.unwrap_or(FACET)) } else { None };
    let middle = |a: usize, b: usize| (0.5 * (corners[a] + corners[b])).normalize();
    let [ab, bc, ca] = [middle(0, 1), middle(1, 2), middle(2, 0)];
    let [a, b, c] = corners;
    let uv_middle = |a: usize, b: usize| uvs.map(|uvs| 0.5 * (uvs[a] + uvs[b]));
    let (uv_ab, uv_bc, uv_ca) = (uv_middle(0, 1), uv_middle(1, 2), uv_middle(2, 0));
    let uv = |index: usize| uvs.map(|uvs| uvs[index]);
    let together = |a: Option<Vec2>, b: Option<Vec2>, c: Option<Vec2>| Some([a?, b?, c?]);
    split(shape, [a, ab, ca], together(uv(0), uv_ab, uv_ca), depth - 1);
    split(shape, [ab, b, bc], together(uv_ab, uv(1), uv_bc), depth - 1);
    split(shape, [ca, bc, c], together(uv_ca, uv_bc, uv(2)), depth - 1);
    split(shape, [ab, bc, ca], together(uv_ab, uv_bc, uv_ca), depth - 1);
}

/// Where a facet's corners lie in its texture.
const FACET: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// A curtain around the origin that faces +Z, thinner towards its top.
fn barrier(material: u32, radius: f32) -> Model {
    let mut model = Model::default();
    let shape = model.paint(material, Vec3::ONE);
    let (columns, rows) = (28, 6);
    let first = shape.positions.len() as u32;
    for row in 0..=rows {
        let up = row as f32 / rows as f32;
        for column in 0..=columns {
            let along = column as f32 / columns as f32 * 2.0 - 1.0;
            let (sin, cos) = (BARRIER_HALF_TURN_RAD * along).sin_cos();
            // It fades towards its top and its sides.
            let alpha = (1.0 - 0.45 * up * up) * (1.0 - along.powi(6));
            shape.brush(Vec3::ONE.extend(alpha)).vertex(Vertex {
                position: Vec3::new(radius * sin, BARRIER_HEIGHT * up, radius * cos),
                normal: Vec3::new(sin, 0.0, cos),
                uv: Vec2::new(radius * BARRIER_HALF_TURN_RAD * along / BARRIER_HEIGHT, 1.0 - up),
            });
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = first + row * (columns + 1) + column;
            let above = at + columns + 1;
            shape.indices.extend([[at, at + 1, above + 1], [at, above + 1, above]]);
        }
    }
    model
}

/// An open cylinder that fades from the ground to nothing.
fn column(shape: &mut Shape, radius: f32, height: f32) {
    let (segments, rows) = (36, 5);
    let first = shape.positions.len() as u32;
    for row in 0..=rows {
        let up = row as f32 / rows as f32;
        for segment in 0..=segments {
            let (sin, cos) = (TAU * segment as f32 / segments as f32).sin_cos();
            shape.brush(Vec3::ONE.extend((1.0 - up) * (1.0 - up))).vertex(Vertex {
                position: Vec3::new(radius * sin, height * up, radius * cos),
                normal: Vec3::new(sin, 0.0, cos),
                uv: Vec2::ZERO,
            });
        }
    }
    for row in 0..rows {
        for segment in 0..segments {
            let at = first + row * (segments + 1) + segment;
            let above = at + segments + 1;
            shape.indices.extend([[at, at + 1, above + 1], [at, above + 1, above]]);
        }
    }
}

//! How the parts of the motor move: slider-crank, cams with flat followers, meshing gears. Angles are
//! clockwise seen from the front (from +z), from straight up, as engines are described; gears alone count
//! counter-clockwise from +x.

use std::f32::consts::{PI, TAU};

use glam::Vec2;

use crate::kit::mechanical::Outline;

/// A crank, a connecting rod and a piston on a line through the crank's axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct SliderCrank {
    /// Radius of the circle of the crank pin: half the stroke.
    pub(super) crank_radius: f32,
    /// Distance between the two pins of the rod.
    pub(super) rod_length: f32,
}

impl SliderCrank {
    /// Height of the piston's pin above the crank's axis, the crank pin being turned by `turn_rad` away from
    /// the cylinder.
    pub(super) fn height(self, turn_rad: f32) -> f32 {
        let (sin, cos) = turn_rad.sin_cos();
        let across = self.crank_radius * sin;
        self.crank_radius * cos + (self.rod_length * self.rod_length - across * across).sqrt()
    }

    /// How far the rod leans clockwise.
    pub(super) fn lean_rad(self, turn_rad: f32) -> f32 {
        -(self.crank_radius * turn_rad.sin() / self.rod_length).asin()
    }
}

/// Straight up, turned clockwise.
pub(super) fn clockwise(turn_rad: f32) -> Vec2 {
    Vec2::new(turn_rad.sin(), turn_rad.cos())
}

/// A cam that lifts a flat follower. Its support function is the base circle's radius plus the lift, and a
/// flat follower rises by just that: the contact is exact at every angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cam {
    pub(super) base_radius: f32,
    pub(super) lift: f32,
    /// The follower rests unless the nose is nearer than this.
    pub(super) half_duration_rad: f32,
}

impl Cam {
    /// How far the follower is lifted when the nose has turned away from it by `turn_rad`: a raised cosine.
    pub(super) fn lift(self, turn_rad: f32) -> f32 {
        let turn = (turn_rad + PI).rem_euclid(TAU) - PI;
        if turn.abs() >= self.half_duration_rad {
            return 0.0;
        }
        0.5 * self.lift * (1.0 + (PI * turn / self.half_duration_rad).cos())
    }

    fn slope(self, turn_rad: f32) -> f32 {
        let turn = (turn_rad + PI).rem_euclid(TAU) - PI;
        if turn.abs() >= self.half_duration_rad {
            return 0.0;
        }
        let rate = PI / self.half_duration_rad;
        -0.5 * self.lift * rate * (rate * turn).sin()
    }

    /// The cam with its nose turned clockwise to `nose_rad`: the envelope of its follower, `h n + h' n'`.
    pub(super) fn outline(self, nose_rad: f32, count: u32) -> Outline {
        (0..count)
            .map(|i| {
                let turn = -TAU * i as f32 / count as f32;
                let (normal, tangent) = (clockwise(nose_rad + turn), clockwise(nose_rad + turn + 0.5 * PI));
                (self.base_radius + self.lift(turn)) * normal + self.slope(turn) * tangent
            })
            .collect()
    }
}

/// A gear in its place: the direction of one of its tooth middles, counter-clockwise from +x.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meshing {
    pub(super) centre: Vec2,
    pub(super) teeth: u32,
    pub(super) turn_rad: f32,
}

impl Meshing {
    /// Turns a gear at `centre` so that a gap of it takes the tooth of this one.
    pub(super) fn drives(self, centre: Vec2, teeth: u32) -> Self {
        let towards = (centre - self.centre).to_angle();
        let own_pitch = TAU / self.teeth as f32;
        let other_pitch = TAU / teeth as f32;
        // Teeth past the line of centres, which the other gear sees running the other way.
        let past = (towards - self.turn_rad) / own_pitch;
        let turn_rad = towards + PI + other_pitch * (past - 0.5);
        Self { centre, teeth, turn_rad }
    }
}

/// Directions of the crank pins, clockwise from straight up, that balance best: the cross plane of a V8,
/// thirds for three and six.
pub(super) fn throws(count: u32) -> Vec<f32> {
    let turns: &[f32] = match count {
        1 => &[0.0],
        2 => &[0.0, 0.5],
        3 => &[0.0, 1.0 / 3.0, 2.0 / 3.0],
        4 => &[0.0, 0.25, 0.75, 0.5],
        5 => &[0.0, 0.4, 0.6, 0.8, 0.2],
        _ => &[0.0, 1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0, 0.0],
    };
    turns.iter().map(|turn| turn * TAU).collect()
}

/// When each cylinder fires, in crank angle from 0 to 4π: at a top dead centre, and of two cylinders that
/// reach theirs together one turn apart.
pub(super) fn firing_angles(top_dead_centres_rad: &[f32]) -> Vec<f32> {
    let mut taken: Vec<f32> = Vec::new();
    let mut fire = |&top: &f32| {
        let mut angle = top.rem_euclid(TAU);
        // A hair below a whole turn is the same top dead centre as none.
        if TAU - angle < 1e-3 {
            angle = 0.0;
        }
        if taken.iter().any(|other| (other - angle).abs() < 1e-3) {
            angle += TAU;
        }
        taken.push(angle);
        angle
    };
    top_dead_centres_rad.iter().map(&mut fire).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_piston_stops_at_both_dead_centres() {
        let crank = SliderCrank { crank_radius: 0.5, rod_length: 1.5 };
        assert!((crank.height(0.0) - 2.0).abs() < 1e-6);
        assert!((crank.height(PI) - 1.0).abs() < 1e-6);
        // A quarter turn: the rod, the crank and the cylinder make a right-angled triangle.
        assert!((crank.height(0.5 * PI) - 2.0_f32.sqrt()).abs() < 1e-6);
        assert!((crank.lean_rad(0.5 * PI) + (1.0_f32 / 3.0).asin()).abs() < 1e-6);
    }

    #[test]
    fn a_cam_reaches_as_far_as_it_lifts() {
        let cam = crate::scene::motor::valves::CAM;
        let outline = cam.outline(0.7, 1440);
        for step in 0..90 {
            // A flat follower in this direction lies on the outermost point.
            let direction = TAU * step as f32 / 90.0;
            let reach = outline.iter().map(|p| p.dot(clockwise(direction))).fold(0.0, f32::max);
            let expected = cam.base_radius + cam.lift(0.7 - direction);
            assert!((reach - expected).abs() < 1e-5, "{direction}: {reach} {expected}");
        }
        let convex = (0..outline.len()).all(|i| {
            let at = |k: usize| outline[(i + k) % outline.len()];
            (at(1) - at(0)).perp_dot(at(2) - at(1)) > 0.0
        });
        assert!(convex, "a hollow flank would not touch a flat follower");
    }

    #[test]
    fn a_tooth_of_the_driver_meets_a_gap_of_the_driven() {
        let driver = Meshing { centre: Vec2::new(1.0, 2.0), teeth: 17, turn_rad: 0.3 };
        let driven = driver.drives(Vec2::new(-1.0, 3.0), 40);
        let towards = (driven.centre - driver.centre).to_angle();
        let share = |gear: Meshing, direction: f32| {
            ((direction - gear.turn_rad) / TAU * gear.teeth as f32).rem_euclid(1.0)
        };
        // Counted against each other, the two run half a tooth apart.
        let sum = share(driver, towards) + share(driven, towards + PI);
        assert!((sum.rem_euclid(1.0) - 0.5).abs() < 1e-4, "{sum}");
    }
}

//! The motor's triangles, its kinematics and its loop.

use std::{f32::consts::TAU, sync::Arc};

use glam::Quat;
use sheer_scene::{
    Animator,
    model::{AlphaMode, Keys, Track},
};

use super::{
    assembly::{BANKS, CRANK, CYCLE_SECS},
    kinematics::{Meshing, clockwise},
    timing::{CAM_TEETH, CRANK_TEETH, MODULE, train},
    *,
};
use crate::catalogue;

/// Tracks of all instances whose part has this name.
fn tracks<'a>(scene: &'a Scene, name: &str) -> Vec<Vec<&'a Track>> {
    let parts = scene.parts();
    let nodes = (0..parts.nodes.len() as u32).filter(|&node| parts.nodes[node as usize].name == name);
    let channels = &parts.animations[0].channels;
    nodes.map(|node| channels.iter().filter(|c| c.node == node).map(|c| &c.track).collect()).collect()
}

fn translation(tracks: &[&Track], time_secs: f32) -> Vec3 {
    let keys = tracks.iter().find_map(|track| match track {
        Track::Translation(keys) => Some(keys),
        _ => None,
    });
    keys.unwrap().value_at(time_secs)
}

fn rotation(tracks: &[&Track], time_secs: f32) -> Quat {
    let keys = tracks.iter().find_map(|track| match track {
        Track::Rotation(keys) => Some(keys),
        _ => None,
    });
    keys.unwrap().value_at(time_secs)
}

/// Times between keys as well as on them.
fn moments() -> impl Iterator<Item = f32> {
    (0..97).map(|i| CYCLE_SECS * i as f32 / 96.7)
}

#[test]
fn it_has_the_papers_number_of_triangles_all_of_them_blended() {
    let scene = Arc::new(catalogue::build("motor").unwrap());
    let camera = scene.camera(&sheer_scene::CameraChoice::Default).unwrap();
    let count = Animator::new(Arc::clone(&scene), camera).frame().triangles().len();
    // The caption of ST Fig. 2: 322K triangles; give or take one in a hundred.
    assert!((318_780..=325_220).contains(&count), "{count}");
    assert!(scene.parts().materials.iter().all(|material| {
        material.alpha_mode == AlphaMode::Blend && material.base_colour.w == 0.3 && material.double_sided
    }));
    let opaque = catalogue::build("motor:alpha=1,cylinders=1").unwrap();
    assert!(opaque.parts().materials.iter().all(|material| material.base_colour.w == 1.0));
}

#[test]
fn pistons_follow_the_closed_form_and_rods_join_them_to_the_crank() {
    let scene = catalogue::build("motor").unwrap();
    let cylinders = Layout { cylinders: 4 }.cylinders();
    let (pistons, rods) = (tracks(&scene, "piston"), tracks(&scene, "connecting rod"));
    assert_eq!((pistons.len(), rods.len(), cylinders.len()), (8, 8, 8));
    let mut highest = 0.0_f32;
    for ((piston, rod), cylinder) in pistons.iter().zip(&rods).zip(&cylinders) {
        let axis = clockwise(cylinder.bank.tilt_rad());
        for time_secs in moments() {
            let crank = 2.0 * TAU * time_secs / CYCLE_SECS;
            let pin = translation(piston, time_secs);
            // By the law of cosines, solved for the side along the cylinder.
            let (r, l) = (CRANK.crank_radius, CRANK.rod_length);
            let angle = crank + cylinder.throw_rad - cylinder.bank.tilt_rad();
            let expected = r * angle.cos() + (l * l - (r * angle.sin()).powi(2)).sqrt();
            assert!((pin.truncate().dot(axis) - expected).abs() < 3e-4, "{pin} {expected}");
            assert!(pin.truncate().perp_dot(axis).abs() < 1e-5, "{pin} is beside its bore");
            let end = translation(rod, time_secs) + rotation(rod, time_secs) * Vec3::Y * l;
            assert!(end.distance(pin) < 1e-3, "{end} {pin}");
            highest = highest.max(expected);
        }
    }
    assert!((highest - CRANK.crank_radius - CRANK.rod_length).abs() < 1e-2);
}

#[test]
fn eight_cylinders_fire_evenly() {
    let mut fires: Vec<f32> = Layout { cylinders: 4 }.cylinders().iter().map(|c| c.fires_rad).collect();
    fires.sort_by(f32::total_cmp);
    for (index, angle) in fires.iter().enumerate() {
        assert!((angle - index as f32 * 0.25 * TAU - fires[0]).abs() < 1e-3, "{fires:?}");
    }
}

#[test]
fn camshafts_turn_at_half_the_crankshafts_speed_the_same_way() {
    let scene = catalogue::build("motor").unwrap();
    let time_secs = 0.05;
    let turn = |name: &str| {
        let all = tracks(&scene, name);
        let change = |time_secs| rotation(&all[0], 0.0).inverse() * rotation(&all[0], time_secs);
        let (axis, angle) = change(time_secs).to_axis_angle();
        axis.z * angle
    };
    assert!((turn("crankshaft") + 2.0 * TAU * time_secs / CYCLE_SECS).abs() < 1e-4);
    assert!((turn("crankshaft") - 2.0 * turn("intake camshaft")).abs() < 1e-4);
    assert!((turn("cam gear") - turn("exhaust camshaft")).abs() < 1e-4);
    assert_eq!(2 * CRANK_TEETH, CAM_TEETH);
}

#[test]
fn teeth_of_the_timing_gears_mesh_at_all_times() {
    use crate::kit::mechanical::gear;
    let placed = |meshing: Meshing, turned: f32| -> Vec<Vec2> {
        let rotation = Vec2::from_angle(meshing.turn_rad + turned);
        gear(meshing.teeth, MODULE).into_iter().map(|p| meshing.centre + rotation.rotate(p)).collect()
    };
    let inside = |outline: &[Vec2], p: Vec2| {
        let crossings = (0..outline.len()).filter(|&i| {
            let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    };
    let mut clashes = [0, 0];
    for bank in BANKS {
        let gears = train(bank);
        for (driver, driven) in [(0, 1), (1, 2), (2, 3), (3, 4), (3, 5)] {
            for step in 0..7 {
                // Within one pitch of the crank gear.
                let share = step as f32 / 7.0 / (2.0 * CRANK_TEETH as f32);
                for (control, off) in [0.0, 0.5 * TAU / CAM_TEETH as f32].into_iter().enumerate() {
                    let turned = |i: usize| -TAU * gears[i].turns * share;
                    let one = placed(gears[driver].meshing, turned(driver));
                    let other = placed(gears[driven].meshing, turned(driven) + off);
                    clashes[control] += one.iter().filter(|&&p| inside(&other, p)).count();
                    clashes[control] += other.iter().filter(|&&p| inside(&one, p)).count();
                }
            }
        }
    }
    // The control is half a pitch off: tooth on tooth.
    assert!(clashes[0] == 0 && clashes[1] > 100, "{clashes:?}");
}

#[test]
fn the_clip_closes() {
    let scene = catalogue::build("motor:cylinders=3").unwrap();
    let channels = &scene.parts().animations[0].channels;
    let ends = |keys: &Keys<Vec3>| keys.values[0].distance(keys.values[keys.values.len() - 1]);
    for channel in channels {
        let name = &scene.parts().nodes[channel.node as usize].name;
        match &channel.track {
            Track::Translation(keys) | Track::Scale(keys) => assert!(ends(keys) < 1e-4, "{name}"),
            Track::Rotation(keys) => {
                let change = keys.values[0].inverse() * keys.values[keys.values.len() - 1];
                // The twelve balls of a bearing may take each other's places.
                let symmetry = if name == "bearing balls" { 12.0 } else { 1.0 };
                let turns = change.to_axis_angle().1 / TAU * symmetry;
                assert!((turns - turns.round()).abs() < 1e-3, "{name}: {turns}");
            }
            Track::MorphWeights(_) => unreachable!("nothing is soft in here"),
        }
        assert_eq!(channel.track.end_secs(), CYCLE_SECS, "{name}");
    }
}

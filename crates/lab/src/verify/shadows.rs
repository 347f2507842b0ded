//! Shadows behind constant layers: what of the light arrives is in closed form, exactly for maps that know
//! all blockers, on average for those that draw at random.

use glam::{Affine3A, Quat, Vec3, Vec4};
use sheer_metrics::statistics::{Moments, z_score};
use sheer_render::{Shadow, Stage, shadow::Shadows};
use sheer_scene::{
    CameraChoice, Scene, SceneParts,
    model::{AlphaMode, Instance, Light, LightKind, Material, Mesh, Node, Transform},
};

use super::estimate::mean_z;
use crate::{
    Result,
    verify::check::{Check, Value},
};

/// Layers between light and floor, and their opacity.
const COUNT: u32 = 4;
const ALPHA: f64 = 0.2;
/// Maps that are drawn of a stochastic technique: one lookup each, so that all are independent.
const MAPS: u32 = 1500;
/// Where the floor is lit, off the edges of texels and triangles.
const POINT: Vec3 = Vec3::new(0.21, 0.0, 0.13);

/// Techniques whose answer behind everything is exact but for what they say of themselves: the keys, and the
/// error that is left.
const EXACT: [(&str, f64, &str); 5] = [
    ("deep", 1e-5, "exact rays"),
    ("deep-map:resolution=128,tolerance=0", 1e-4, "Lokovic and Veach 2000"),
    ("opacity-map:resolution=128,layers=4", 1e-4, "Yuksel and Keyser 2008"),
    ("fourier:resolution=128,terms=3", 1e-3, "Jansen and Bavoil 2010"),
    ("stochastic-map:resolution=128,samples=4,correct=on", 1e-5, "ST section 3.3"),
];

/// Techniques that are right on average.
const RANDOM: [(&str, &str); 2] = [
    ("stochastic-map:resolution=16,samples=8,filter=0,sampling=naive", "ST section 3.2"),
    ("stochastic-map:resolution=16,samples=8,filter=0,sampling=stratified", "ST section 3.2"),
];

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let stage = room(ALPHA, threads)?;
    let mut checks = Vec::new();
    for (technique, tolerance, source) in EXACT {
        checks.push(behind_everything(&stage, technique, tolerance, source)?);
    }
    for (technique, source) in RANDOM {
        checks.extend(on_average(&stage, technique, source)?);
    }
    Ok(checks)
}

/// Horizontal films over a floor, below a sun that shines down a little aside.
fn room(alpha: f64, threads: Option<usize>) -> Result<Stage> {
    let sheet = |half: f32, material| Mesh {
        positions: vec![
            Vec3::new(-half, 0.0, -half),
            Vec3::new(-half, 0.0, half),
            Vec3::new(half, 0.0, half),
            Vec3::new(half, 0.0, -half),
        ],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    };
    let film = Material {
        alpha_mode: AlphaMode::Blend,
        base_colour: Vec4::new(1.0, 1.0, 1.0, alpha as f32),
        double_sided: true,
        ..Material::default()
    };
    let node = |transform| Node { name: String::new(), parent: None, transform };
    // The floor, then the films; each instance stands at the node of its own index, the sun at the last.
    let heights = (0..COUNT).map(|layer| 1.0 + 0.1 * layer as f32);
    let places = [0.0].into_iter().chain(heights).map(|height| Transform::from_translation(Vec3::Y * height));
    let down = Transform::Trs {
        translation: Vec3::Y * 4.0,
        rotation: Quat::from_rotation_x(0.1 - std::f32::consts::FRAC_PI_2),
        scale: Vec3::ONE,
    };
    let instance = |index| Instance {
        node: index,
        node_from_object: Affine3A::IDENTITY,
        mesh: index.min(1),
        id: index,
        geometry: 0,
        skin: None,
        morph_weights: Vec::new(),
    };
    let sun =
        Light { name: String::new(), node: COUNT + 1, intensity: Vec3::ONE, kind: LightKind::Directional };
    let parts = SceneParts {
        name: "films".to_owned(),
        nodes: places.chain([down]).map(node).collect(),
        meshes: vec![sheet(5.0, 0), sheet(2.0, 1)],
        instances: (0..=COUNT).map(instance).collect(),
        materials: vec![Material { double_sided: true, ..Material::default() }, film],
        lights: vec![sun],
        exposure: 1.0,
        ..SceneParts::default()
    };
    Ok(Stage::new(Scene::new(parts)?, &CameraChoice::Default, threads)?)
}

/// What of the light arrives on the floor. Another frame draws another map.
fn arriving(stage: &Stage, shadow: &Shadow, frame: u32) -> Result<f64> {
    let shadows = Shadows::new(stage, shadow, frame, 0)?;
    Ok(f64::from(shadows.transmittance(stage, 0, POINT, Vec3::Y, [1, 2, 3]).x))
}

/// `Π (1 - alpha)` of all layers (ST Eq. 3).
fn truth() -> f64 {
    (1.0 - f64::from(ALPHA as f32)).powi(COUNT as i32)
}

fn behind_everything(stage: &Stage, technique: &str, tolerance: f64, source: &str) -> Result<Check> {
    let found = arriving(stage, &technique.parse()?, 0)?;
    Ok(Check {
        name: format!("{technique}: light behind {COUNT}×{ALPHA}"),
        source: source.to_owned(),
        closed_form: Some(Value::Number(truth())),
        paper: None,
        measured: Some(Value::Number(found)),
        samples: None,
        z: None,
        pass: (found - truth()).abs() <= tolerance,
    })
}

/// The mean of many maps, and of naive sampling, a coin for each sample, their deviation as well.
fn on_average(stage: &Stage, technique: &str, source: &str) -> Result<Vec<Check>> {
    let shadow: Shadow = technique.parse()?;
    let found = (0..MAPS).map(|frame| arriving(stage, &shadow, frame)).collect::<Result<Vec<f64>>>()?;
    let check = |what: &str, closed_form: f64, measured: f64, z: f64| Check {
        name: format!("{technique}: {what} behind {COUNT}×{ALPHA}"),
        source: source.to_owned(),
        closed_form: Some(Value::Number(closed_form)),
        paper: None,
        measured: Some(Value::Number(measured)),
        samples: Some(u64::from(MAPS)),
        z: Some(z),
        pass: false,
    };
    let (truth, moments) = (truth(), found.iter().copied().collect::<Moments>());
    let mut checks = vec![check("mean light", truth, moments.mean(), mean_z(truth, &moments))];
    let coins = truth * (1.0 - truth) / 8.0;
    let squares: Moments = found.iter().map(|light| (light - truth).powi(2)).collect();
    if technique.ends_with("naive") {
        let z = z_score(squares.mean() - coins, squares.variance_of_mean().sqrt());
        checks.push(check("deviation of the light", coins.sqrt(), squares.mean().sqrt(), z));
    }
    Ok(checks)
}

#[cfg(test)]
mod tests {
    use super::{super::check::judge, *};

    fn judged(mut checks: Vec<Check>) -> Vec<bool> {
        judge(&mut checks);
        checks.iter().map(|check| check.pass).collect()
    }

    #[test]
    fn films_that_are_a_little_denser_fail_every_row() {
        let denser = room(ALPHA + 0.02, None).unwrap();
        for (technique, tolerance, source) in EXACT {
            assert!(!behind_everything(&denser, technique, tolerance, source).unwrap().pass, "{technique}");
        }
        for (technique, source) in RANDOM {
            let verdicts = judged(on_average(&denser, technique, source).unwrap());
            assert!(!verdicts[0], "{technique}: the check is blind");
        }
    }

    #[test]
    fn strata_are_no_coins() {
        let stage = room(ALPHA, None).unwrap();
        let found = on_average(&stage, RANDOM[0].0, "").unwrap();
        assert_eq!(judged(found), [true, true]);
        let shadow: Shadow = RANDOM[1].0.parse().unwrap();
        let squares: Moments =
            (0..MAPS).map(|frame| (arriving(&stage, &shadow, frame).unwrap() - truth()).powi(2)).collect();
        let coins = truth() * (1.0 - truth()) / 8.0;
        assert!(z_score(squares.mean() - coins, squares.variance_of_mean().sqrt()) < -5.0, "{squares:?}");
    }
}

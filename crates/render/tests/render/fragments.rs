//! The list of a pixel's fragments is what the exact answer is made of.

use glam::UVec2;
use sheer_render::{Antialiasing, Background, Pipeline, RayFragment, Settings, Stage};

/// What `baseline` lets through a pixel's middle is the product of what the fragments do; without the
/// last of them it is not.
#[test]
fn fragments_leave_the_coverage_of_the_exact_picture() {
    const SIZE: [u32; 2] = [32, 18];
    let scene = sheer_gallery::open("smoke-square:particles=300").unwrap().scene;
    let stage = Stage::new(scene, &Default::default(), None).unwrap();
    let settings = Settings { size: SIZE, background: Background::None, ..Settings::default() };
    let mut pipeline = Pipeline::new("baseline".parse().unwrap(), Antialiasing::NONE, settings).unwrap();
    pipeline.render(&stage, 0).unwrap();
    let mut deep = 0;
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let middle = UVec2::new(x, y).as_vec2() + 0.5;
            let fragments = stage.fragments_through(middle, SIZE);
            let coverage = |list: &[RayFragment]| 1.0 - list.iter().map(|f| 1.0 - f.alpha).product::<f32>();
            let found = pipeline.planes().colour[(x, y)][3];
            assert!((coverage(&fragments) - found).abs() < 1e-5, "{x}, {y}: {fragments:?} but {found}");
            let distances: Vec<f32> = fragments.iter().map(|f| f.distance).collect();
            assert!(distances.is_sorted());
            if let [front @ .., last] = &fragments[..]
                && front.len() > 1
            {
                deep += 1;
                let cut = coverage(front);
                assert!((cut - found).abs() > 1e-5 || last.alpha * (1.0 - cut) < 1e-4, "{x}, {y}");
            }
        }
    }
    assert!(deep > 30, "{deep} pixels have layers");
}

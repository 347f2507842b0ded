//! A part of a picture.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use sheer_image::{Planes, Region};
use sheer_render::{Antialiasing, Pipeline, RenderError, Settings, Stage};
use sheer_scene::CameraChoice;

fn rendered(crop: Option<Region>) -> Result<Planes, RenderError> {
    let scene = sheer_gallery::open("layers:count=3").unwrap().scene;
    let mut stage = Stage::new(scene, &CameraChoice::Default, Some(1))?;
    let settings = Settings { size: [40, 24], crop, ..Settings::default() };
    let mut pipeline = Pipeline::new("joint".parse().unwrap(), Antialiasing::NONE, settings)?;
    stage.advance(pipeline.clock().at(0));
    pipeline.render(&stage, 0)?;
    Ok(pipeline.planes().clone())
}

#[test]
fn a_part_has_the_pixels_of_the_whole() {
    let region = Region { left: 11, top: 5, width: 17, height: 13 };
    assert_eq!(rendered(Some(region)).unwrap(), rendered(None).unwrap().cut(region).unwrap());
}

#[test]
fn a_part_beyond_the_picture_is_refused() {
    let crop = Region { left: 30, top: 0, width: 11, height: 8 };
    let error = rendered(Some(crop)).unwrap_err();
    assert!(matches!(error, RenderError::Crop { .. }), "{error}");
    assert_eq!(error.to_string(), "the part 30,0,11,8 reaches beyond the picture of 40x24 pixels");
}

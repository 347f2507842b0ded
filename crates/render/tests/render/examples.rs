//! The examples do what they say.

use std::fs;

#[path = "../../examples/fly.rs"]
#[expect(dead_code, reason = "its main is not called")]
mod fly;
#[path = "../../examples/fragments.rs"]
#[expect(dead_code, reason = "its main is not called")]
mod fragments;
#[path = "../../examples/own_method.rs"]
#[expect(dead_code, reason = "its main is not called")]
mod own_method;
#[path = "../../examples/picture.rs"]
#[expect(dead_code, reason = "its main is not called")]
mod picture;

#[test]
fn the_picture_is_a_file_of_its_size() {
    let path = std::env::temp_dir().join(format!("sheer-example-{}.png", std::process::id()));
    picture::write(&path, [32, 18]).unwrap();
    let picture = sheer_image::read_png(&path).unwrap();
    fs::remove_file(&path).unwrap();
    assert_eq!(picture.size(), (32, 18));
    let colours: std::collections::HashSet<_> = picture.as_slice().iter().collect();
    assert!(colours.len() > 100, "{} colours", colours.len());
}

#[test]
fn a_flight_comes_closer_to_the_exact_picture_until_the_cut_and_after_it() {
    let errors = fly::errors([64, 36], 24).unwrap();
    assert_eq!(errors.len(), 24);
    assert!(errors[11] < 0.7 * errors[0], "{errors:?}");
    // The history has begun anew.
    assert!(errors[12] > errors[11], "{errors:?}");
    assert!(errors[23] < 0.7 * errors[12], "{errors:?}");
}

#[test]
fn the_own_method_has_less_noise_than_white_noise() {
    let [own, white] = own_method::errors([64, 36]).unwrap();
    assert!(own < white && white > 0.0, "{own}, {white}");
}

#[test]
fn fragments_come_front_to_back_and_let_less_and_less_through() {
    let fragments = fragments::fragments([64, 36]).unwrap();
    assert!(fragments.len() > 1, "{}", fragments.len());
    for pair in fragments.windows(2) {
        assert!(pair[0].distance <= pair[1].distance && pair[1].transmittance < pair[0].transmittance);
        assert!(pair[1].alpha > 0.0);
    }
}

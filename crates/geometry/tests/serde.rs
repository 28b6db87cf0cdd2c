//! The plain types as serde writes and reads them.
#![cfg(feature = "serde")]

use std::fmt::Debug;

use rotund_geometry::glam::Vec3;
use rotund_geometry::vanilla::{Line, Point, Quad};
use rotund_geometry::{Aabb, BilinearPatch, Hit, Method, Ray, RoundedCone, Sphere, Triangle};
use serde::{Serialize, de::DeserializeOwned};

fn assert_comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).expect("it can be written");
    let back: T = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(back, *value, "{text}");
}

#[test]
fn every_plain_type_comes_back_from_json() {
    let ray = Ray::new(Vec3::new(0.1, 0.2, 5.0), Vec3::NEG_Z);
    let hit: Hit = Sphere::default().closest(&ray).expect("near the middle");
    assert_comes_back(&hit);
    assert_comes_back(&Aabb { min: Vec3::splat(0.1), max: Vec3::ONE });
    assert_comes_back(&Sphere::default());
    assert_comes_back(&RoundedCone::default());
    assert_comes_back(&BilinearPatch::default());
    assert_comes_back(&Triangle::default());
    assert_comes_back(&Point::default());
    assert_comes_back(&Line::default());
    assert_comes_back(&Quad::default());
}

#[test]
fn a_ray_without_end_comes_back_from_json() {
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    assert_comes_back(&ray);
    assert_comes_back(&Ray { t_min: 0.5, t_max: 0.7, ..ray });
    let short = serde_json::from_str(r#"{"origin": [0, 0, 0], "direction": [1, 0, 0]}"#);
    assert_eq!(short.ok(), Some(ray), "an interval that is not written is that of Ray::new");
    for t_max in [f32::NAN, f32::NEG_INFINITY] {
        let wrong = Ray { t_max, ..ray };
        assert!(serde_json::to_string(&wrong).is_err(), "{t_max} would come back as infinity");
    }
}

#[test]
fn a_field_of_a_ray_that_is_misspelled_is_an_error() {
    let text = r#"{"origin": [0, 0, 0], "direction": [1, 0, 0], "tmin": 1}"#;
    let error = serde_json::from_str::<Ray>(text).expect_err("t_min is misspelled").to_string();
    assert!(error.contains("`tmin`") && error.contains("`t_min`"), "{error}");
}

#[test]
fn a_method_is_written_by_its_name() {
    for method in Method::ALL {
        assert_comes_back(&method);
        let text = serde_json::to_string(&method).expect("a name can be written");
        assert_eq!(text, format!("\"{method}\""));
    }
    assert!(serde_json::from_str::<Method>("\"yocto\"").is_err());
}

//! The scenes of the repository and their generated shapes.

#![cfg(feature = "load")]

use rotund_geometry::{
    Aabb,
    glam::{Vec3, vec3},
};
use rotund_scene::{Elements, LoadOptions, Scene, Shape, load};

fn scene(name: &str) -> Scene {
    let path = format!("{}/../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let loaded = load(path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.warnings, Vec::<String>::new(), "{name} loads without a warning");
    loaded.scene
}

fn shape(scene: &Scene, name: &str) -> Shape {
    let found = scene.shapes.iter().find(|shape| shape.name == name);
    found.unwrap_or_else(|| panic!("a shape {name}")).clone()
}

#[test]
fn every_scene_has_the_cameras_and_lights_of_the_family() {
    for name in ["shapes1", "shapes2", "shapes3", "shapes4", "glass", "patches"] {
        let scene = scene(name);
        for camera in ["default", "front", "back"] {
            assert!(
                scene.cameras.iter().any(|c| c.name == camera),
                "{name} has the camera {camera}"
            );
        }
        // Small lights behind glass cause fireflies, so those of that scene are larger and dimmer.
        let radiance = Vec3::splat(if name == "glass" { 5.0 } else { 20.0 });
        let lights = scene.materials.iter().filter(|m| m.emission == radiance).count();
        assert_eq!((lights, scene.environments.len()), (2, 1), "{name}");
    }
}

#[test]
fn surfaces_have_the_size_and_number_of_quads_of_their_parameters() {
    let (first, fourth) = (scene("shapes1"), scene("shapes4"));
    let table = [
        // scene, shape, elements, vertices, largest coordinates
        (&first, "sphere", 6144, 6534, vec3(0.075, 0.075, 0.075)),
        (&first, "uvsphere-flipcap", 1024, 1089, vec3(0.075, 0.075, 0.051_967)),
        (&first, "disk", 1024, 1089, vec3(0.075, 0.075, 0.0)),
        (&first, "uvcylinder", 3072, 3267, vec3(0.075, 0.075, 0.075)),
        (&first, "cube", 6144, 6534, vec3(0.075, 0.075, 0.075)),
        (&fourth, "points-grid", 66_049, 66_049, vec3(0.075, 0.075, 0.0)),
        (&fourth, "thickpoints-grid", 289, 289, vec3(0.075, 0.075, 0.0)),
        (&fourth, "lines-grid", 65_536, 65_792, vec3(0.0375, 0.0375, 0.0)),
        (&fourth, "thicklines-grid", 256, 272, vec3(0.0375, 0.0375, 0.0)),
    ];
    for (scene, name, elements, vertices, extent) in table {
        let shape = shape(scene, name);
        assert_eq!((shape.elements.count(), shape.positions.len()), (elements, vertices), "{name}");
        let bounds = Aabb::from_points(shape.positions.iter().copied());
        assert!(bounds.max.distance(extent) < 1e-6, "{name}: {}", bounds.max);
        assert!(bounds.min.distance(-extent) < 1e-6, "{name}: {}", bounds.min);
        for (normal, uv) in shape.normals.iter().zip(&shape.texcoords) {
            assert!((normal.length() - 1.0).abs() < 1e-5, "{name}: unit normals");
            assert!(uv.min_element() >= 0.0 && uv.max_element() <= 1.0, "{name}: {uv}");
        }
    }
    assert!(shape(&fourth, "points-grid").radii.iter().all(|&r| r == 7.5e-5), "thin");
    assert!(shape(&fourth, "thicklines-grid").radii.iter().all(|&r| r == 7.5e-4), "thick");
}

#[test]
fn quads_are_oriented_as_their_normals() {
    let scene = scene("shapes1");
    // The uv sphere is an exception: its quads have the orientation of yocto-gl's file, its normals
    // point out.
    for name in ["floor", "sphere", "disk", "uvcylinder", "cube"] {
        let shape = shape(&scene, name);
        let Elements::Quads(quads) = &shape.elements else { panic!("{name} has quads") };
        for quad in quads {
            let [a, b, c, d] = quad.map(|v| shape.positions[v as usize]);
            let around = (c - a).cross(d - b);
            let sum: Vec3 = quad.iter().map(|&v| shape.normals[v as usize]).sum();
            assert!(around.dot(sum) > 0.0, "{name}: {quad:?}");
        }
    }
}

#[test]
fn hair_is_rooted_on_its_sphere_tapers_and_clumps() {
    let scene = scene("shapes3");
    let spread = |name: &str| {
        let shape = shape(&scene, name);
        assert_eq!(
            (shape.elements.count(), shape.positions.len()),
            (4 * 65_536, 5 * 65_536),
            "{name}"
        );
        let mut octants = [0; 8];
        let mut apart = 0.0;
        for (strand, radii) in shape.positions.chunks(5).zip(shape.radii.chunks(5)) {
            let root = strand[0];
            assert!((root.length() - 0.06).abs() < 1e-4, "{name}: a root at {root}");
            assert_eq!((radii[0], radii[4]), (1.5e-4, 7.5e-5), "{name}");
            octants[usize::from(root.x > 0.0)
                + 2 * usize::from(root.y > 0.0)
                + 4 * usize::from(root.z > 0.0)] += 1;
            apart += f64::from(strand[4].distance(root * (0.075 / 0.06)));
        }
        for count in octants {
            assert!((7500..9000).contains(&count), "{name} grows evenly: {octants:?}");
        }
        apart / 65_536.0
    };
    let (blown, straight, clumped) =
        (spread("hairball1"), spread("hairball2"), spread("hairball3"));
    assert!(straight < 1e-4, "straight hair stands out: {straight}");
    assert!(blown > 1e-3 && clumped > 1e-3, "the others do not: {blown} and {clumped}");
}

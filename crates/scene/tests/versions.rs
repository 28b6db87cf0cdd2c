//! All versions of the scene format, as yocto-gl wrote them.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec3, vec2, vec3};
use rotund_scene::{Elements, LoadOptions, Loaded, MaterialKind, load};
use std::{fs, path::Path};
use tempfile::TempDir;

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\n";

/// Creates a folder with `scene.json` and all files that it may name.
fn folder(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, content).expect("writes the file");
    };
    write("shapes/floor.ply", TRIANGLE.as_bytes());
    write("shapes/thing.obj", QUAD.as_bytes());
    write("subdivs/monkey.obj", QUAD.as_bytes());
    write("subdivs/control.ply", TRIANGLE.as_bytes());
    let frames = "ply\nformat ascii 1.0\nelement instance 2\nproperty float xx\nproperty float xy\n\
        property float xz\nproperty float yx\nproperty float yy\nproperty float yz\nproperty float zx\n\
        property float zy\nproperty float zz\nproperty float ox\nproperty float oy\nproperty float oz\n\
        end_header\n1 0 0 0 1 0 0 0 1 5 0 0\n0 1 0 -1 0 0 0 0 1 0 0 7\n";
    write("instances/many.ply", frames.as_bytes());
    // One pixel of red, green, blue and exponent.
    write("textures/sky.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x81");
    write("scene.json", scene.as_bytes());
    folder
}

fn loaded(folder: &Path) -> Loaded {
    let loaded = load(folder.join("scene.json"), &LoadOptions::default());
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.warnings, Vec::<String>::new());
    loaded
}

/// Asserts the content that all versions of the scene below have.
fn assert_is_the_scene(why: &str, loaded: &Loaded) {
    let scene = &loaded.scene;
    let [camera] = &scene.cameras[..] else { panic!("{why}: one camera") };
    assert_eq!((camera.name.as_str(), camera.lens, camera.orthographic), ("default", 0.1, true));
    assert!(
        camera.world_from_camera.translation.distance(vec3(0.0, 0.0, 2.0).into()) < 1e-6,
        "{why}: stands two meters away"
    );
    assert!((camera.focus - 2.0).abs() < 1e-6, "{why}: and looks at the origin");
    let [sky] = &scene.environments[..] else { panic!("{why}: one environment") };
    assert_eq!((sky.name.as_str(), sky.emission), ("sky", Vec3::splat(0.5)), "{why}");
    let texture = &scene.textures[sky.emission_tex.expect("a texture") as usize];
    assert_eq!(texture.color_at(0, 0).truncate(), vec3(1.0, 0.5, 0.25), "{why}");
    let kinds: Vec<_> = scene.materials.iter().map(|material| material.kind).collect();
    assert_eq!(kinds, [MaterialKind::Reflective, MaterialKind::Volumetric], "{why}");
    let names: Vec<_> = scene.instances.iter().map(|instance| instance.name.as_str()).collect();
    assert_eq!(names, ["floor", "thing", "monkey"], "{why}");
    let elements =
        |instance: usize| &scene.shapes[scene.instances[instance].shape as usize].elements;
    assert_eq!(*elements(0), Elements::Triangles(vec![[0, 1, 2]]), "{why}");
    assert_eq!(*elements(1), Elements::Quads(vec![[0, 1, 2, 3]]), "{why}");
    assert_eq!(elements(2).count(), 4, "{why}: subdivided once");
    let [first, second, third] = [0, 1, 2].map(|i| scene.instances[i].material);
    assert_eq!([first, second, third], [0, 1, 0], "{why}");
    let moved = scene.instances[1].world_from_object.transform_point3(Vec3::ZERO);
    assert_eq!(moved, vec3(3.0, 0.0, 0.0), "{why}");
}

const VERSION_40: &str = r#"{
    "asset": { "copyright": "nobody" },
    "cameras": { "default": { "lens": 0.1, "ortho": true, "focus": 9,
        "lookat": [0, 0, 2, 0, 0, 0, 0, 1, 0] } },
    "environments": { "sky": { "emission": [0.5, 0.5, 0.5], "emission_tex": "sky",
        "lookat": [0, 0, 2, 0, 0, 0, 0, 1, 0] } },
    "materials": { "gold": { "type": "metallic" }, "cloud": { "type": "volume", "color_tex": "" } },
    "instances": { "floor": { "shape": "floor", "material": "gold" } },
    "objects": {
        "thing": { "shape": "thing", "material": "cloud", "frame": [1,0,0, 0,1,0, 0,0,1, 3,0,0] },
        "monkey": { "shape": "nowhere", "material": "gold" }
    },
    "subdivs": { "monkey": { "shape": "nowhere", "subdivisions": 1, "displacement": 0.1,
        "displacement_tex": "sky" } }
}"#;

const VERSION_41: &str = r#"{
    "asset": { "version": "4.1", "generator": "someone" },
    "cameras": { "default": { "lens": 0.1, "orthographic": true,
        "lookat": [0, 0, 2, 0, 0, 0, 0, 1, 0] } },
    "textures": { "heaven": "sky.hdr" },
    "environments": { "sky": { "emission": [0.5, 0.5, 0.5], "emission_tex": "heaven" } },
    "materials": { "gold": { "type": "metallic" }, "cloud": { "type": "volumetric" } },
    "shapes": { "floor": { "datafile": "floor.ply" }, "quad": "thing.obj",
        "monkey": { "datafile": "floor.ply" } },
    "subdivs": { "one": { "datafile": "monkey.obj", "shape": "monkey", "subdivisions": 1,
        "displacement_tex": "" } },
    "instances": {
        "floor": { "shape": "floor", "material": "gold" },
        "thing": { "shape": "quad", "material": "cloud", "frame": [1,0,0, 0,1,0, 0,0,1, 3,0,0] },
        "monkey": { "shape": "monkey", "material": "gold" }
    }
}"#;

/// Returns the scene in any version with arrays.
fn version_42(version: &str) -> String {
    format!(
        r#"{{
    "asset": {{ "version": {version}, "copyright": "nobody", "generator": "someone" }},
    "cameras": [{{ "name": "default", "lens": 0.1, "orthographic": true, "focus": 2,
        "frame": [1,0,0, 0,1,0, 0,0,1, 0,0,2] }}],
    "textures": [{{ "name": "sky", "uri": "textures/sky.hdr" }}],
    "environments": [{{ "name": "sky", "emission": [0.5, 0.5, 0.5], "emission_tex": 0 }}],
    "materials": [{{ "name": "gold", "type": "reflective", "color_tex": -1 }},
        {{ "name": "cloud", "type": "volumetric" }}],
    "shapes": [{{ "name": "floor", "uri": "shapes/floor.ply" }},
        {{ "name": "thing", "uri": "shapes/thing.obj" }}, {{ "name": "monkey", "uri": "shapes/gone.ply" }}],
    "subdivs": [{{ "name": "monkey", "shape": 2, "uri": "subdivs/monkey.obj", "subdivisions": 1,
        "displacement_tex": "" }}],
    "instances": [{{ "name": "floor", "shape": 0, "material": 0 }},
        {{ "name": "thing", "shape": 1, "material": 1, "frame": [1,0,0, 0,1,0, 0,0,1, 3,0,0] }},
        {{ "name": "monkey", "shape": 2, "material": 0 }}]
}}"#
    )
}

#[test]
fn all_versions_load_the_same_scene() {
    let table = [
        ("4.0, which has no number", VERSION_40.to_owned()),
        ("4.1", VERSION_41.to_owned()),
        ("4.2", version_42("\"4.2\"")),
        ("4.3", version_42("\"4.3\"")),
        ("5.0", version_42("\"5.0\"")),
        ("a number that is none", version_42("4.2")),
        (
            "arrays with references by name",
            version_42("\"4.2\"").replace("\"shape\": 1", "\"shape\": \"thing\""),
        ),
        (
            "files without the folder that they are in",
            version_42("\"4.2\"")
                .replace("subdivs/monkey", "monkey")
                .replace("shapes/thing", "thing")
                .replace("textures/sky", "sky"),
        ),
    ];
    for (why, text) in table {
        let folder = folder(&text);
        assert_is_the_scene(why, &loaded(folder.path()));
    }
}

#[test]
fn an_unknown_version_is_a_warning_and_read_as_the_latest() {
    let folder = folder(&version_42("\"6.1\""));
    let loaded = load(folder.path().join("scene.json"), &LoadOptions::default()).expect("loads");
    let [warning] = &loaded.warnings[..] else { panic!("one warning: {:?}", loaded.warnings) };
    assert!(warning.contains("asset.version") && warning.contains("6.1"), "{warning}");
    assert_is_the_scene("6.1", &loaded);
}

#[test]
fn reflection_and_transmission_determine_a_missing_type() {
    use MaterialKind::{Glossy, Matte, Reflective, Refractive, Transparent};
    let table = [
        // before there were versions                                       the kind
        (r#"{ "color": [1, 1, 1], "roughness": 0.1 }"#, Matte),
        (r#"{ "specular": 1, "roughness": 0.25 }"#, Glossy),
        (r#"{ "coat": 1 }"#, Glossy),
        (r#"{ "metallic": 1, "specular": 1 }"#, Reflective),
        (r#"{ "transmission": 1, "specular": 1 }"#, Transparent),
        (r#"{ "transmission": 1, "specular": 1, "thin": false }"#, Refractive),
        (r#"{ "translucency": 1, "thin": false, "scattering": [0.4, 0.2, 0.1] }"#, Refractive),
        (r#"{ "type": "plastic", "transmission": 1 }"#, Glossy),
        (r#"{ "type": "metal" }"#, Reflective),
        (r#"{ "type": "glass", "trdepth": 0.001 }"#, Refractive),
        (r#"{ "type": "thinglass" }"#, Transparent),
    ];
    for (material, kind) in table {
        let folder = folder(&format!(r#"{{ "materials": {{ "m": {material} }} }}"#));
        assert_eq!(loaded(folder.path()).scene.materials[0].kind, kind, "{material}");
        let asset = r#""asset": { "version": "4.2" }"#;
        let versioned = material.replace("\"type\": \"plastic\", ", "");
        let text = format!(r#"{{ {asset}, "materials": [{versioned}] }}"#);
        fs::write(folder.path().join("scene.json"), text).expect("writes the scene");
        let kind = loaded(folder.path()).scene.materials[0].kind;
        let typed = [("metal\"", Reflective), ("\"glass", Refractive), ("thinglass", Transparent)];
        let expected = typed.iter().find(|(name, _)| material.contains(name)).map(|typed| typed.1);
        assert_eq!(kind, expected.unwrap_or(Matte), "of version 4.2: {material}");
    }
}

#[test]
fn a_gltf_material_becomes_the_nearest_kind_with_a_warning() {
    for (metallic, kind) in [("0", MaterialKind::Glossy), ("1", MaterialKind::Reflective)] {
        let folder = folder(&format!(
            r#"{{ "materials": [{{ "type": "gltfpbr", "metallic": {metallic} }}] }}"#
        ));
        let loaded =
            load(folder.path().join("scene.json"), &LoadOptions::default()).expect("loads");
        assert_eq!(loaded.scene.materials[0].kind, kind);
        let [warning] = &loaded.warnings[..] else { panic!("one warning: {:?}", loaded.warnings) };
        assert!(warning.contains("materials[0].type") && warning.contains("gltfpbr"), "{warning}");
    }
}

#[test]
fn the_error_for_an_unknown_name_lists_the_possible_files() {
    let table = [
        ("\"shape\": \"floor\"", "\"shape\": \"cellar\"", "shapes/cellar.ply or .obj"),
        ("\"emission_tex\": \"sky\"", "\"emission_tex\": \"earth\"", "textures/earth.hdr, .exr"),
    ];
    for (from, to, part) in table {
        let folder = folder(&VERSION_40.replace(from, to));
        let error = load(folder.path().join("scene.json"), &LoadOptions::default());
        let message = error.expect_err(to).to_string();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn an_object_of_version_40_is_repeated_for_each_frame_of_a_file() {
    let scene = r#"{ "materials": { "m": {} }, "objects": { "tree": { "instance": "many",
        "shape": "floor", "material": "m", "frame": [1,0,0, 0,1,0, 0,0,1, 1,2,3] } } }"#;
    let folder = folder(scene);
    let loaded = loaded(folder.path());
    let instances = &loaded.scene.instances;
    let names: Vec<_> = instances.iter().map(|instance| instance.name.as_str()).collect();
    assert_eq!(names, ["tree_0", "tree_1"]);
    let places: Vec<_> =
        instances.iter().map(|i| i.world_from_object.transform_point3(Vec3::ZERO)).collect();
    // The frame of the file is applied after that of the object: the second one rotates x to y.
    assert_eq!(places, [vec3(6.0, 2.0, 3.0), vec3(-2.0, 1.0, 10.0)]);
    let table = [
        ("no such file", "many", "few", &["few.ply", "instances[0].instance"][..]),
        ("out of the folder", "many", "../../many", &["instances[0].instance", "folder"]),
    ];
    for (why, from, to, parts) in table {
        let spoiled = scene.replace(from, to);
        fs::write(folder.path().join("scene.json"), spoiled).expect("writes the scene");
        let error = load(folder.path().join("scene.json"), &LoadOptions::default());
        let message = error.expect_err(why).to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{why}: {message}");
    }
    let broken = [
        ("flat", "1 0 0 0 1 0 0 0 1 5 0 0", "1 0 0 0 1 0 0 0 0 5 0 0", "instance 0"),
        ("cut", "0 1 0 -1 0 0 0 0 1 0 0 7", "0 1", "before instance 1 of 2"),
        ("without an origin", "property float oz\n", "", "ox oy oz"),
    ];
    fs::write(folder.path().join("scene.json"), scene).expect("writes the scene");
    let path = folder.path().join("instances/many.ply");
    let good = fs::read_to_string(&path).expect("reads the frames");
    for (why, from, to, part) in broken {
        fs::write(&path, good.replace(from, to)).expect("writes the frames");
        let error = load(folder.path().join("scene.json"), &LoadOptions::default());
        let message = error.expect_err(why).to_string();
        assert!(message.contains(part) && message.contains("many.ply"), "{why}: {message}");
    }
}

#[test]
fn a_scene_without_a_camera_gets_one_that_sees_it() {
    let folder = folder(&version_42("\"4.2\"").replace("\"cameras\": [", "\"photos\": ["));
    let loaded = load(folder.path().join("scene.json"), &LoadOptions::default()).expect("loads");
    let [camera] = &loaded.scene.cameras[..] else { panic!("one camera") };
    let middle = camera.ray(vec2(0.5, 0.5), Default::default());
    // The scene extends from x = 0 to x = 4.
    let toward = vec3(2.0, 0.5, 0.0) - middle.origin;
    assert!(middle.direction.dot(toward.normalize()) > 0.99, "{middle:?}");
}

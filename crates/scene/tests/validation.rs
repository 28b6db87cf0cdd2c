//! Scenes made in code: constructors, and the errors of validation.

use rotund_geometry::{
    Ray,
    glam::{Affine3A, Mat3A, Vec2, Vec3, Vec4},
};
use rotund_scene::{
    Camera, Elements, Environment, Instance, Material, Pixels, Scene, SceneError, Shape, Texture,
    Trees,
};

/// Returns a valid scene with one item of every kind.
fn valid() -> Scene {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    let named = |name: &str, shape: Shape| Shape { name: name.to_owned(), ..shape };
    let mut scene = Scene::default();
    scene.cameras.push(Camera { name: "front".to_owned(), ..Camera::default() });
    scene.environments.push(Environment { emission_tex: Some(1), ..Environment::default() });
    scene.textures = vec![
        Texture::from_rgba8(2, 1, &[0, 0, 0, 255, 255, 255, 255, 255]).expect("four bytes each"),
        Texture { pixels: Pixels::Floats(vec![[1.0; 4]]), ..Texture::default() },
    ];
    let painted = Material { color_tex: Some(0), ..Material::default() };
    scene.add(named("cloud", Shape::points(corners, 0.1)), painted);
    scene.add(named("hair", Shape::lines(corners, [0.1, 0.2, 0.3, 0.4], [[0, 1], [1, 2]])), {
        Material { normal_tex: Some(1), ..Material::default() }
    });
    let colored = Shape { colors: vec![Vec4::ONE; 4], ..Shape::triangles(corners, [[0, 1, 2]]) };
    scene.add(named("sheet", colored), Material::default());
    scene.add(Shape::quads(corners, vec![[0, 1, 2, 3]]), Material::default());
    scene
}

#[test]
fn a_scene_with_items_of_every_kind_is_valid() {
    assert_eq!(valid().validate(), Ok(()));
    assert_eq!(Scene::default().validate(), Ok(()));
    assert!(Trees::build(&Scene::default()).is_ok(), "no instances are no mistake");
}

/// Returns a picture of 2 x 2 white pixels but the last.
fn sky(last: [f32; 4]) -> Texture {
    let mut pixels = vec![[1.0; 4]; 4];
    pixels[3] = last;
    Texture { name: "sky".into(), width: 2, height: 2, pixels: Pixels::Floats(pixels) }
}

#[test]
fn errors_name_item_element_and_value() {
    type Mistake = fn(&mut Scene);
    let table: &[(Mistake, &str)] = &[
        (|s| s.instances[2].shape = 7, "instances[2]: shape is 7, but the scene has 4 shapes"),
        (
            |s| {
                s.instances[1].material = u32::MAX;
                s.instances[1].name = "wig".to_owned();
            },
            "instances[1] \"wig\": material is 4294967295, but the scene has 4 materials",
        ),
        (
            |s| s.instances[3].world_from_object = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)),
            "instances[3]: world_from_object is (1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0), \
             expected finite numbers and a finite inverse: three independent axes, of neither \
             extremely small nor large scale",
        ),
        (
            |s| s.instances[0].world_from_object.translation.y = f32::NAN,
            "instances[0]: world_from_object is (1, 0, 0, 0, 1, 0, 0, 0, 1, 0, NaN, 0), \
             expected finite numbers and a finite inverse: three independent axes, of neither \
             extremely small nor large scale",
        ),
        (
            |s| s.materials[0].color_tex = Some(2),
            "materials[0]: color_tex is 2, but the scene has 2 textures",
        ),
        (
            |s| s.environments[0].emission_tex = Some(9),
            "environments[0]: emission_tex is 9, but the scene has 2 textures",
        ),
        (
            |s| s.environments[0].emission.z = -1.0,
            "environments[0]: emission is (0, 0, -1), \
             expected finite numbers that are not negative",
        ),
        (
            |s| s.materials[1].roughness = 1.5,
            "materials[1]: roughness is 1.5, expected between 0 and 1",
        ),
        (|s| s.materials[1].ior = 0.0, "materials[1]: ior is 0, expected a positive finite number"),
        (
            |s| s.materials[1].trdepth = f32::INFINITY,
            "materials[1]: trdepth is inf, expected a positive finite number",
        ),
        (
            |s| s.materials[1].anisotropy = 1.0,
            "materials[1]: anisotropy is 1, expected between -1 and 1, both excluded",
        ),
        (
            |s| s.materials[1].opacity = f32::NAN,
            "materials[1]: opacity is NaN, expected between 0 and 1",
        ),
        (
            |s| s.cameras[0].aspect = 0.0,
            "cameras[0] \"front\": aspect is 0, expected a positive finite number",
        ),
        (
            |s| s.cameras[0].lens = f32::NAN,
            "cameras[0] \"front\": lens is NaN, expected a positive finite number",
        ),
        (
            |s| s.cameras[0].film = -0.1,
            "cameras[0] \"front\": film is -0.1, expected a positive finite number",
        ),
        (
            |s| s.cameras[0].focus = 0.0,
            "cameras[0] \"front\": focus is 0, expected a positive finite number",
        ),
        (
            |s| s.cameras[0].aperture = -1.0,
            "cameras[0] \"front\": aperture is -1, expected a finite number that is not negative",
        ),
        (
            |s| s.cameras[0].world_from_camera.matrix3 = Mat3A::ZERO,
            "cameras[0] \"front\": world_from_camera is (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0), \
             expected finite numbers and a finite inverse: three independent axes, of neither \
             extremely small nor large scale",
        ),
        (
            |s| {
                s.cameras[0] = Camera::look_at(Vec3::ONE, Vec3::ONE, Vec3::Y);
            },
            "cameras[0]: world_from_camera is \
             (NaN, NaN, NaN, NaN, NaN, NaN, NaN, NaN, NaN, 1, 1, 1), expected finite numbers; \
             `Camera::look_at` returns others if `eye` is `target`, or `up` is zero or parallel to \
             the view",
        ),
        (
            |s| s.instances[0].world_from_object = Affine3A::from_scale(Vec3::splat(1e30)),
            "instances[0]: world_from_object is (1e30, 0, 0, 0, 1e30, 0, 0, 0, 1e30, 0, 0, 0), \
             expected finite numbers and a finite inverse: three independent axes, of neither \
             extremely small nor large scale",
        ),
        (
            |s| s.cameras[0].focus = f32::INFINITY,
            "cameras[0] \"front\": focus is inf, expected a positive finite number",
        ),
        (
            |s| s.materials[1].albedo.y = 1.5,
            "materials[1]: albedo is (0, 1.5, 0), expected numbers from 0 to 1",
        ),
        (
            |s| s.materials[1].albedo.z = f32::NAN,
            "materials[1]: albedo is (0, 0, NaN), expected numbers from 0 to 1",
        ),
        (
            |s| {
                s.textures[1] = sky([0.0, -0.5, 1.0, 1.0]);
                s.environments[0].emission_tex = Some(1);
            },
            "textures[1] \"sky\": pixel (1, 1) is (0, -0.5, 1, 1), \
             expected an emission that is not negative",
        ),
        (
            |s| {
                s.textures[1] = sky([-1e-20, 0.0, 1.0, 1.0]);
                s.materials[0].emission_tex = Some(1);
            },
            "textures[1] \"sky\": pixel (1, 1) is (-1e-20, 0, 1, 1), \
             expected an emission that is not negative",
        ),
        (
            |s| s.shapes[0].elements = Elements::Points(5),
            "shapes[0] \"cloud\": has 5 points, but only 4 positions",
        ),
        (
            |s| s.shapes[0].elements = Elements::Points(u32::MAX),
            "shapes[0] \"cloud\": has 4294967295 points, but a tree holds at most 2147483646",
        ),
        (
            |s| s.shapes[0].radii.clear(),
            "shapes[0] \"cloud\": radii is empty, but points need one for each position",
        ),
        (
            |s| s.shapes[1].radii.truncate(3),
            "shapes[1] \"hair\": radii has 3 values for 4 positions",
        ),
        (
            |s| s.shapes[1].radii[2] = -0.5,
            "shapes[1] \"hair\": radii[2] is -0.5, expected a finite number that is not negative",
        ),
        (
            |s| s.shapes[1].elements = Elements::Lines(vec![[0, 1], [3, 4]]),
            "shapes[1] \"hair\": lines[1] names vertex 4, but the shape has 4 positions",
        ),
        (
            |s| s.shapes[2].elements = Elements::Triangles(vec![[0, 1, 90]]),
            "shapes[2] \"sheet\": triangles[0] names vertex 90, but the shape has 4 positions",
        ),
        (
            |s| s.shapes[3].elements = Elements::Quads(vec![[0, 1, 2, 3], [8, 1, 2, 9]]),
            "shapes[3]: quads[1] names vertex 8, but the shape has 4 positions",
        ),
        (
            |s| s.shapes[2].normals = vec![Vec3::Z],
            "shapes[2] \"sheet\": normals has 1 values for 4 positions",
        ),
        (
            |s| s.shapes[2].texcoords = vec![Vec2::ZERO; 5],
            "shapes[2] \"sheet\": texcoords has 5 values for 4 positions",
        ),
        (
            |s| s.shapes[2].colors.truncate(2),
            "shapes[2] \"sheet\": colors has 2 values for 4 positions",
        ),
        (
            |s| s.shapes[2].colors[3].w = -1.0,
            "shapes[2] \"sheet\": colors[3] is (1, 1, 1, -1), \
             expected finite numbers that are not negative",
        ),
        (
            |s| s.shapes[2].positions[1].x = f32::NEG_INFINITY,
            "shapes[2] \"sheet\": positions[1] is (-inf, 0, 0), expected finite numbers",
        ),
        (
            |s| s.shapes[3].normals = vec![Vec3::NAN; 4],
            "shapes[3]: normals[0] is (NaN, NaN, NaN), expected finite numbers",
        ),
        (
            |s| s.shapes[3].texcoords = vec![Vec2::INFINITY; 4],
            "shapes[3]: texcoords[0] is (inf, inf), expected finite numbers",
        ),
        (|s| s.textures[0].width = 3, "textures[0]: is 3 x 1, but has 2 pixels"),
        (|s| s.textures[0].height = 0, "textures[0]: height is 0, expected at least one pixel"),
        (
            |s| s.textures[1].pixels = Pixels::Floats(vec![[0.0, 1.0, f32::NAN, 1.0]]),
            "textures[1]: pixel (0, 0) is (0, 1, NaN, 1), expected finite numbers",
        ),
    ];
    for (mistake, expected) in table {
        let mut scene = valid();
        mistake(&mut scene);
        let error = scene.validate().expect_err(expected);
        assert_eq!(error.to_string(), *expected);
        assert_eq!(Trees::build(&scene).err(), Some(error), "trees are not built: {expected}");
    }
}

#[test]
fn the_first_of_several_mistakes_is_reported_in_arrays_of_any_length() {
    for bad in [0, 1, 4095, 4096, 99_999] {
        let mut cloud = Shape::points(vec![Vec3::ZERO; 100_000], 0.1);
        cloud.radii[bad..].fill(f32::NAN);
        let mut scene = Scene::default();
        scene.add(cloud, Material::default());
        let error = scene.validate().expect_err("a NaN");
        assert!(
            matches!(error, SceneError::VertexValue { vertex, .. } if vertex == bad),
            "{error}"
        );
    }
}

#[test]
fn tiled_textures_keep_their_size() {
    let bytes: Vec<u8> = (0..64 * 48 * 4).map(|i: u32| (i / 7) as u8).collect();
    let texture = Texture::from_rgba8(64, 48, &bytes).expect("four bytes each");
    assert!(matches!(texture.pixels, Pixels::TiledBytes(_)), "large enough for tiles");
    let mut scene = Scene { textures: vec![texture], ..Scene::default() };
    assert_eq!(scene.validate(), Ok(()));
    scene.textures[0].height = 64;
    let error = scene.validate().expect_err("another height").to_string();
    assert_eq!(error, "textures[0]: is 64 x 64, but has 3072 pixels");
}

#[test]
fn bytes_of_a_texture_are_four_for_each_pixel() {
    let texture = Texture::from_rgba8(1, 2, &[255, 0, 0, 255, 0, 0, 255, 128]).expect("fits");
    assert_eq!(texture.color_at(0, 0), Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert_eq!(texture.color_at(0, 1), Vec4::new(0.0, 0.0, 1.0, 128.0 / 255.0));
    for bytes in [0, 15, 17, 20] {
        let error = Texture::from_rgba8(2, 2, &vec![0; bytes]).expect_err("too few or too many");
        assert_eq!(error, SceneError::ByteCount { width: 2, height: 2, bytes });
    }
    let huge = Texture::from_rgba8(u32::MAX, u32::MAX, &[]).expect_err("no overflow").to_string();
    let bytes = (4 * (u128::from(u32::MAX)).pow(2)).to_string();
    assert!(huge.contains(&format!("needs {bytes} bytes")), "{huge}");
    assert_eq!(Texture::default().color(Vec2::splat(0.3)), Vec4::ONE);
}

#[test]
fn constructors_fill_the_arrays() {
    let ends = [Vec3::ZERO, Vec3::X];
    let line = Shape::lines(ends, 0.25, [[0, 1]]);
    assert_eq!(line.radii, [0.25, 0.25], "one radius for all");
    assert_eq!(line, Shape::lines(ends.to_vec(), vec![0.25; 2], vec![[0, 1]]));
    assert_eq!(line, Shape::lines(&ends[..], &[0.25; 2][..], &[[0, 1]][..]));
    assert_eq!(Shape::points(ends, [0.1, 0.2]).elements, Elements::Points(2));
    assert_eq!(Instance::new(3, 4).world_from_object, Affine3A::IDENTITY);
}

#[test]
fn a_camera_looks_at_its_target() {
    let (eye, target) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-2.0, 0.5, 1.0));
    let camera = Camera { aperture: 0.2, ..Camera::look_at(eye, target, Vec3::Y) };
    for lens in [Vec2::ZERO, Vec2::X, Vec2::new(-0.6, 0.8)] {
        // The target is in the middle of the picture, and in focus.
        let ray = camera.ray(Vec2::splat(0.5), lens);
        let t = (target - ray.origin).dot(ray.direction);
        assert!(ray.at(t).distance(target) < 1e-5, "{lens}: {ray:?}");
    }
    let up = camera.ray(Vec2::new(0.5, 0.0), Vec2::ZERO).direction;
    assert!(up.y > camera.ray(Vec2::new(0.5, 1.0), Vec2::ZERO).direction.y, "v runs down");
    for (eye, up) in [(target, Vec3::Y), (eye, target - eye), (eye, Vec3::ZERO)] {
        let scene = Scene { cameras: vec![Camera::look_at(eye, target, up)], ..Scene::default() };
        let error = scene.validate().expect_err("no such camera").to_string();
        assert!(error.starts_with("cameras[0]: world_from_camera is ("), "{error}");
    }
}

#[test]
fn an_orthographic_camera_shows_its_width() {
    for aspect in [2.0, 0.5] {
        let camera = Camera { aspect, ..Camera::default().orthographic(6.0) };
        let [a, b] = [0.0, 1.0].map(|s| camera.ray(Vec2::splat(s), Vec2::ZERO).origin);
        let size = (b - a).abs().truncate();
        assert_eq!(size.max_element(), 6.0, "the longer side");
        assert_eq!(size.min_element(), 3.0, "the shorter side");
        assert_eq!(camera.ray(Vec2::ZERO, Vec2::ZERO).direction, Vec3::NEG_Z);
    }
}

#[test]
fn bounds_contain_instances_with_their_radii() {
    let mut scene = Scene::default();
    assert!(scene.bounds().is_empty(), "nothing");
    let ball = scene.add(Shape::points([Vec3::ZERO], 0.5), Material::default());
    scene.instances[ball as usize].world_from_object =
        Affine3A::from_translation(Vec3::new(3.0, 0.0, 0.0))
            * Affine3A::from_scale(Vec3::splat(2.0));
    let sheet = Shape::triangles([Vec3::ZERO, Vec3::X, Vec3::Y], [[0, 1, 2]]);
    let sheet = scene.add(sheet, Material::default());
    assert_eq!(scene.instance_bounds(ball).min, Vec3::new(2.0, -1.0, -1.0));
    assert_eq!(scene.instance_bounds(ball).max, Vec3::new(4.0, 1.0, 1.0));
    assert_eq!(scene.instance_bounds(sheet).max, Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(scene.bounds(), scene.instance_bounds(ball).union(scene.instance_bounds(sheet)));
}

#[test]
fn rays_spawned_at_a_hit_leave_its_surface() {
    let mut scene = Scene::default();
    scene.add(Shape::points([Vec3::ZERO, Vec3::new(0.0, 0.0, 10.0)], 1.0), Material::default());
    scene.instances[0].world_from_object = Affine3A::from_scale(Vec3::new(3.0, 0.1, 1.0));
    let trees = Trees::build(&scene).expect("valid");
    let hit = trees.closest(&scene, &Ray::new(Vec3::new(0.5, 0.02, 5.0), Vec3::NEG_Z));
    let hit = hit.expect("aimed at the first ball");
    let up = trees.closest(&scene, &hit.spawn(Vec3::Z)).expect("the second ball");
    assert_eq!((hit.element, up.element), (0, 1));
    assert!(!trees.any(&scene, &hit.spawn_to(Vec3::new(0.0, 0.0, 8.9))), "just before it");
    assert!(trees.any(&scene, &hit.spawn_to(Vec3::new(0.0, 0.0, 9.1))), "just inside of it");
    assert!(!trees.any(&scene, &hit.spawn_to(up.position)), "its own surface does not count");
}

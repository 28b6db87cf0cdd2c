//! Evaluation has the semantics of yocto-gl.

mod support;

use rotund_geometry::{
    Ray,
    glam::{Affine3A, Vec2, Vec3, Vec4, vec2, vec3},
};
use rotund_scene::{
    Camera, Elements, Environment, Material, MaterialKind, Method, Pixels, Scene, Shape, Texture,
    Trees,
};
use support::scene_of;

fn assert_near(a: Vec3, b: Vec3, why: &str) {
    assert!(a.distance(b) < 1e-5, "{why}: {a} is not {b}");
}

/// Four pixels: black, red / green, white.
fn four_pixels() -> Texture {
    let pixels = vec![[0, 0, 0, 255], [255, 0, 0, 255], [0, 255, 0, 255], [255, 255, 255, 51]];
    Texture { name: String::new(), width: 2, height: 2, pixels: Pixels::Bytes(pixels) }
}

#[test]
fn a_texture_repeats_and_its_pixels_are_centred_at_their_corners() {
    let texture = four_pixels();
    let table = [
        // where                              uv               color
        ("the first pixel", vec2(0.0, 0.0), [0.0, 0.0, 0.0]),
        ("the second pixel", vec2(0.5, 0.0), [1.0, 0.0, 0.0]),
        ("the second row", vec2(0.0, 0.5), [0.0, 1.0, 0.0]),
        ("half way along a row", vec2(0.25, 0.0), [0.5, 0.0, 0.0]),
        ("from the last to the first", vec2(0.75, 0.0), [0.5, 0.0, 0.0]),
        ("in the middle of all four", vec2(0.25, 0.25), [0.5, 0.5, 0.25]),
        ("one to the right", vec2(1.5, 0.0), [1.0, 0.0, 0.0]),
        ("one to the left", vec2(-0.5, 0.0), [1.0, 0.0, 0.0]),
        ("far below", vec2(0.0, -7.5), [0.0, 1.0, 0.0]),
        ("no number", vec2(f32::NAN, 0.0), [0.0, 0.0, 0.0]),
        ("infinite", vec2(f32::INFINITY, 0.0), [0.0, 0.0, 0.0]),
    ];
    for (why, uv, color) in table {
        assert_near(texture.color(uv).truncate(), color.into(), why);
    }
}

#[test]
fn bytes_are_srgb_as_colour_linear_as_data_and_alpha_is_always_linear() {
    let pixels = Pixels::Bytes(vec![[128, 10, 255, 128]]);
    let texture = Texture { name: String::new(), width: 1, height: 1, pixels };
    let (color, data) = (texture.color(Vec2::ZERO), texture.data(Vec2::ZERO));
    // IEC 61966-2-1: 128 is 0.2158605, 10 is in the linear part.
    assert_near(color.truncate(), vec3(0.215_860_5, 10.0 / 255.0 / 12.92, 1.0), "colour");
    assert_near(data.truncate(), vec3(128.0, 10.0, 255.0) / 255.0, "data");
    assert_eq!((color.w, data.w), (128.0 / 255.0, 128.0 / 255.0), "alpha");
}

#[test]
fn a_camera_looks_along_its_negative_z_with_u_right_and_v_down() {
    let camera = Camera { aspect: 2.0, ..Camera::default() };
    let middle = camera.ray(vec2(0.5, 0.5), Vec2::ZERO);
    assert_near(middle.direction, Vec3::NEG_Z, "the middle");
    let corner = camera.ray(vec2(1.0, 1.0), Vec2::ZERO).direction;
    // Film 36 by 18 mm behind a lens of 50 mm.
    assert_near(corner, vec3(0.018, -0.009, -0.05).normalize(), "the lower right corner");
    assert_eq!(camera.resolution(720), (720, 360));
    assert_eq!(Camera { aspect: 0.5, ..camera.clone() }.resolution(720), (360, 720));
    assert_eq!(Camera { aspect: 2.4, ..camera.clone() }.resolution(720), (720, 300));
    assert_eq!(Camera { aspect: 1e9, ..camera }.resolution(0), (1, 1), "never without pixels");
}

#[test]
fn all_points_of_a_lens_see_the_same_point_of_the_plane_in_focus() {
    for orthographic in [false, true] {
        let camera = Camera { aperture: 0.2, focus: 3.0, orthographic, ..Camera::default() };
        let uv = vec2(0.8, 0.3);
        let focused = |lens: Vec2| {
            let ray = camera.ray(uv, lens);
            ray.at((-3.0 - ray.origin.z) / ray.direction.z)
        };
        let middle = focused(Vec2::ZERO);
        for lens in [vec2(1.0, 0.0), vec2(0.0, -1.0), vec2(-0.6, 0.6)] {
            assert_near(focused(lens), middle, "focus");
            let origin = camera.ray(uv, lens).origin - camera.ray(uv, Vec2::ZERO).origin;
            assert_near(origin, (0.1 * lens).extend(0.0), "the aperture is a diameter");
        }
    }
}

#[test]
fn an_orthographic_camera_has_parallel_rays_over_film_by_lens() {
    let camera = Camera { orthographic: true, lens: 0.03, ..Camera::default() };
    let ray = camera.ray(vec2(1.0, 0.0), Vec2::ZERO);
    assert_near(ray.direction, Vec3::NEG_Z, "parallel");
    assert_near(ray.origin, vec3(0.6, 0.4, 0.0), "36 by 24 mm over 30 mm, halved");
}

#[test]
fn an_environment_is_laid_out_by_longitude_and_polar_angle() {
    let sky = Environment {
        name: String::new(),
        world_from_environment: Affine3A::IDENTITY,
        emission: Vec3::ONE,
        emission_tex: None,
    };
    let table = [
        ("x", Vec3::X, vec2(0.0, 0.5)),
        ("z, a quarter round", 7.0 * Vec3::Z, vec2(0.25, 0.5)),
        ("-z", Vec3::NEG_Z, vec2(0.75, 0.5)),
        ("45 degrees up", vec3(-1.0, 1.0, 0.0), vec2(0.5, 0.25)),
    ];
    for (why, direction, uv) in table {
        assert!(sky.uv(direction).distance(uv) < 1e-6, "{why}: {}", sky.uv(direction));
        assert_near(sky.direction(uv), direction.normalize(), why);
    }
    assert!(sky.uv(Vec3::Y).y == 0.0 && sky.uv(Vec3::NEG_Y).y == 1.0, "the poles");
    let turned = Environment {
        world_from_environment: Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2),
        ..sky.clone()
    };
    let expected = turned.world_from_environment.inverse().transform_vector3(Vec3::Z);
    assert!(turned.uv(Vec3::Z).distance(sky.uv(expected)) < 1e-6, "in the environment's frame");
    let scene = Scene { environments: vec![sky.clone(), sky], ..Scene::default() };
    assert_eq!(scene.eval_environment(Vec3::X), Vec3::splat(2.0), "environments add up");
}

/// A quad from 0 to 1 with the corner at (1, 1) lifted, under `method`.
fn lifted_quad(method: Method) -> Shape {
    Shape {
        method,
        elements: Elements::Quads(vec![[0, 1, 2, 3]]),
        positions: vec![Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 1.0), Vec3::Y],
        texcoords: vec![Vec2::ZERO, vec2(1.0, 0.0), vec2(4.0, 4.0), vec2(0.0, 1.0)],
        ..Shape::default()
    }
}

#[test]
fn a_vanilla_quad_is_linear_in_two_triangles_and_a_patch_is_bilinear() {
    let scene = |method| scene_of(lifted_quad(method), Affine3A::IDENTITY, MaterialKind::Matte);
    let (vanilla, enhanced) = (scene(Method::Vanilla), scene(Method::Enhanced));
    let uv = vec2(0.5, 0.75);
    // In the triangle p2 p3 p1 with weights 1/4, 1/2 and 1/4.
    assert_near(vanilla.eval_position(0, 0, uv), vec3(0.5, 0.75, 0.25), "vanilla");
    assert_eq!(vanilla.eval_texcoord(0, 0, uv), vec2(1.25, 1.5), "vanilla");
    assert_near(enhanced.eval_position(0, 0, uv), vec3(0.5, 0.75, 0.375), "enhanced");
    // Weights 1/8, 1/8, 3/8 and 3/8.
    assert_eq!(enhanced.eval_texcoord(0, 0, uv), vec2(1.625, 1.875), "enhanced");
}

#[test]
fn tangents_are_the_derivatives_of_position_by_texture_coordinates() {
    for method in [Method::Vanilla, Method::Enhanced] {
        let scene = scene_of(lifted_quad(method), Affine3A::IDENTITY, MaterialKind::Matte);
        let (uv, step) = (vec2(0.3, 0.4), 1.0 / 64.0);
        let (tu, tv) = scene.eval_tangents(0, 0, uv);
        for across in [vec2(step, 0.0), vec2(0.0, step)] {
            let moved =
                scene.eval_position(0, 0, uv + across) - scene.eval_position(0, 0, uv - across);
            let painted =
                scene.eval_texcoord(0, 0, uv + across) - scene.eval_texcoord(0, 0, uv - across);
            assert_near(tu * painted.x + tv * painted.y, moved, "the chain rule");
        }
    }
}

#[test]
fn alpha_is_the_square_of_the_roughness_with_a_lower_bound() {
    use MaterialKind::{Glossy, Matte, Reflective, Refractive};
    let table = [
        // kind, roughness, alpha
        (Matte, 0.0, 0.0009),
        (Glossy, 0.02, 0.0009),
        (Glossy, 0.2, 0.04),
        (Glossy, 1.0, 1.0),
        (Reflective, 0.0, 0.0),
        (Reflective, 0.029, 0.0),
        (Reflective, 0.031, 0.031 * 0.031),
        (Refractive, 0.02, 0.0),
        (Refractive, 0.5, 0.25),
    ];
    for (kind, roughness, alpha) in table {
        let mut scene = scene_of(lifted_quad(Method::Vanilla), Affine3A::IDENTITY, kind);
        scene.materials[0].roughness = roughness;
        let found = scene.eval_material(0, 0, Vec2::ZERO).alpha;
        assert!((found - alpha).abs() < 1e-7, "{kind:?} {roughness}: {found} is not {alpha}");
    }
}

#[test]
fn textures_and_vertex_colours_multiply() {
    let mut shape = lifted_quad(Method::Enhanced);
    shape.texcoords = vec![vec2(0.5, 0.5); 4];
    shape.colors = vec![Vec4::new(0.5, 1.0, 0.25, 0.5); 4];
    let mut scene = scene_of(shape, Affine3A::IDENTITY, MaterialKind::Reflective);
    let red = Texture { pixels: Pixels::Bytes(vec![[255, 0, 0, 255]; 4]), ..four_pixels() };
    scene.textures = vec![four_pixels(), red];
    scene.materials[0] = Material {
        color: vec3(0.8, 0.6, 0.4),
        emission: Vec3::splat(2.0),
        roughness: 0.5,
        opacity: 0.5,
        color_tex: Some(0),
        emission_tex: Some(0),
        roughness_tex: Some(0),
        albedo: vec3(0.5, 0.25, 1.0),
        scattering_tex: Some(1),
        ..scene.materials[0].clone()
    };
    let point = scene.eval_material(0, 0, vec2(0.3, 0.3));
    assert_near(point.color, vec3(0.4, 0.6, 0.1), "white pixel times vertex colour");
    assert_near(point.emission, vec3(1.0, 2.0, 0.5), "emission takes vertex colour as well");
    assert!((point.opacity - 0.5 * 0.2 * 0.5).abs() < 1e-6, "three opacities: {}", point.opacity);
    assert!((point.alpha - 0.25).abs() < 1e-6, "roughness times green: {}", point.alpha);
    assert_near(point.albedo, vec3(0.5, 0.0, 0.0), "scattering times its texture");
}

#[test]
fn white_light_is_attenuated_to_the_colour_over_trdepth() {
    let mut scene =
        scene_of(lifted_quad(Method::Vanilla), Affine3A::IDENTITY, MaterialKind::Refractive);
    scene.materials[0].color = vec3(1.0, 0.5, 0.0);
    scene.materials[0].trdepth = 0.1;
    let extinction = scene.eval_material(0, 0, Vec2::ZERO).extinction;
    let left = (-0.1 * extinction).exp();
    assert_near(left, vec3(1.0, 0.5, 1e-4), "black is held at 1e-4");
    assert!(extinction.x == 0.0, "white does not absorb");
}

#[test]
fn normals_turn_to_the_viewer_unless_the_surface_refracts() {
    for method in [Method::Vanilla, Method::Enhanced] {
        for (kind, turns) in [
            (MaterialKind::Matte, true),
            (MaterialKind::Glossy, true),
            (MaterialKind::Reflective, true),
            (MaterialKind::Refractive, false),
        ] {
            let scene = scene_of(lifted_quad(method), Affine3A::IDENTITY, kind);
            let trees = Trees::build(&scene).expect("the scene is valid");
            let below = Ray::new(vec3(0.25, 0.25, -3.0), Vec3::Z);
            let hit = trees.closest(&scene, &below).expect("aimed at it");
            let normal = scene.shading_normal(&hit, Vec3::NEG_Z);
            assert_eq!(normal.z < 0.0, turns, "{kind:?} from behind: {normal}");
            assert!(hit.normal.z > 0.0, "the geometric normal keeps its side");
        }
    }
}

#[test]
fn a_normal_map_tilts_in_image_rows_that_run_down() {
    let mut shape = lifted_quad(Method::Enhanced);
    shape.positions[2].z = 0.0;
    // v runs down: the corner at y = 1 is the top of the image.
    shape.texcoords = vec![vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)];
    let mut scene = scene_of(shape, Affine3A::IDENTITY, MaterialKind::Matte);
    // A normal that points right and up in the picture.
    let up_right = [204, 204, 204, 255];
    scene.textures = vec![Texture {
        name: String::new(),
        width: 1,
        height: 1,
        pixels: Pixels::Bytes(vec![up_right]),
    }];
    scene.materials[0].normal_tex = Some(0);
    let normal = scene.eval_shading_normal(0, 0, vec2(0.5, 0.5));
    assert_near(normal, Vec3::ONE.normalize(), "right is x, up is y");
}

#[test]
fn vanilla_points_and_lines_face_the_viewer() {
    let outgoing = vec3(1.0, 2.0, 2.0);
    let line = Shape {
        method: Method::Vanilla,
        elements: Elements::Lines(vec![[0, 1]]),
        positions: vec![Vec3::NEG_X, Vec3::X],
        normals: vec![Vec3::X, Vec3::X],
        radii: vec![0.1, 0.1],
        ..Shape::default()
    };
    let point = Shape { elements: Elements::Points(2), ..line.clone() };
    let ray = Ray::new(vec3(-1.0, 0.01, 5.0), Vec3::NEG_Z);
    for (shape, expected, position) in [
        (point, outgoing.normalize(), vec3(-1.0, 0.0, 0.0)),
        (line, vec3(0.0, 2.0, 2.0).normalize(), vec3(-1.0, 0.0, 0.0)),
    ] {
        let scene = scene_of(shape, Affine3A::IDENTITY, MaterialKind::Glossy);
        let hit = Trees::build(&scene)
            .expect("the scene is valid")
            .closest(&scene, &ray)
            .expect("aimed at it");
        assert_near(scene.shading_normal(&hit, outgoing), expected, "faces the viewer");
        assert_near(hit.position, position, "shades on the axis");
    }
}

#[test]
fn tubes_interpolate_along_their_axis_and_spheres_have_one_value() {
    let tube = Shape {
        elements: Elements::Lines(vec![[0, 1]]),
        positions: vec![Vec3::ZERO, 4.0 * Vec3::X],
        texcoords: vec![vec2(0.0, 0.5), vec2(1.0, 0.5)],
        radii: vec![0.5, 0.5],
        ..Shape::default()
    };
    let scene = scene_of(tube, Affine3A::IDENTITY, MaterialKind::Matte);
    let trees = Trees::build(&scene).expect("the scene is valid");
    for (x, u) in [(-0.3, 0.0), (0.0, 0.0), (1.0, 0.25), (3.0, 0.75), (4.4, 1.0)] {
        let ray = Ray::new(vec3(x, 0.1, 5.0), Vec3::NEG_Z);
        let hit = trees.closest(&scene, &ray).expect("aimed at it");
        let texcoord = scene.eval_texcoord(0, hit.element, hit.uv);
        assert!(texcoord.distance(vec2(u, 0.5)) < 1e-5, "at {x}: {texcoord}");
    }
}

//! Shading normals are on the side of the viewer, and mirror images about them are never below the
//! surface.

mod support;

use rotund_geometry::{
    Ray,
    glam::{Affine3A, Vec2, Vec3, vec2, vec3},
};
use rotund_scene::{
    ElementKind, Elements, MaterialKind, Method, Pixels, Scene, SceneHit, Shape, Texture, Trees,
};
use support::{Random, frames, ray_at, scene_of, shapes};

/// Returns a random normal map that is steeper than any real one.
fn wild_map(random: &mut Random) -> Texture {
    let pixels = (0..64).map(|_| {
        let [x, y] = [0, 1].map(|_| (random.unit() * 255.0) as u8);
        [x, y, 128 + (random.unit() * 60.0) as u8, 255]
    });
    let pixels = Pixels::Bytes(pixels.collect());
    Texture { name: String::new(), width: 8, height: 8, pixels }
}

/// Returns the shapes of [`shapes`] with vertex normals that are unrelated to the faces.
fn bent_shapes(random: &mut Random) -> Vec<Shape> {
    let mut all = shapes(random, 30, 0.5);
    for shape in &mut all {
        shape.normals = shape.positions.iter().map(|_| random.direction()).collect();
    }
    all
}

/// Returns the height of the mirror image of `outgoing` above the surface, on the side of the
/// viewer, in `f64`.
fn height(normal: Vec3, outgoing: Vec3, geometric: Vec3) -> f64 {
    let [n, o, g] = [normal, outgoing, geometric].map(|v| v.as_dvec3());
    let mirrored = 2.0 * n.dot(o) * n - o;
    mirrored.dot(g) * g.dot(o).signum()
}

#[test]
fn mirror_images_are_never_below_the_surface_in_any_frame() {
    let mut random = Random(61);
    let (mut bent, mut count) = (0, 0);
    for (why, frame) in frames() {
        for shape in bent_shapes(&mut random) {
            for kind in [MaterialKind::Glossy, MaterialKind::Refractive] {
                let mut scene = scene_of(shape.clone(), frame, kind);
                scene.textures = vec![wild_map(&mut random)];
                scene.materials[0].normal_tex = Some(0);
                scene.shapes[0].method = Method::Enhanced;
                let trees = Trees::build(&scene).expect("the scene is valid");
                for _ in 0..200 {
                    let ray = ray_at(&mut random, &scene, 0.5);
                    let Some(hit) = trees.closest(&scene, &ray) else { continue };
                    let outgoing = -ray.direction.normalize();
                    let normal = scene.shading_normal(&hit, -ray.direction);
                    let side = hit.normal.dot(outgoing).signum();
                    let height = height(normal, outgoing, hit.normal);
                    assert!(height >= 0.0, "{why}, {kind:?}: {height} below at {hit:?}");
                    assert!((normal.length() - 1.0).abs() < 1e-6, "{why}: {normal}");
                    let facing = normal.dot(outgoing);
                    if kind == MaterialKind::Refractive {
                        assert!(side * facing >= 0.0, "{why}: keeps the side of the surface");
                    } else {
                        assert!(facing >= 0.0, "{why}: turns to the viewer");
                    }
                    let own = scene.eval_shading_normal(hit.instance, hit.element, hit.uv);
                    bent += u32::from(own.dot(normal).abs() < 0.999);
                    count += 1;
                }
            }
        }
    }
    assert!(count > 8_000 && bent > count / 20, "{bent} of {count} normals had to be bent");
}

#[test]
fn a_normal_whose_mirror_image_is_above_the_surface_is_unchanged() {
    let mut random = Random(67);
    for shape in bent_shapes(&mut random) {
        let mut scene = scene_of(shape, frames()[0].1, MaterialKind::Glossy);
        scene.shapes[0].method = Method::Enhanced;
        let trees = Trees::build(&scene).expect("the scene is valid");
        let mut left = 0;
        for _ in 0..2000 {
            let ray = ray_at(&mut random, &scene, 0.5);
            let Some(hit) = trees.closest(&scene, &ray) else { continue };
            let outgoing = -ray.direction.normalize();
            let own = scene.eval_shading_normal(hit.instance, hit.element, hit.uv);
            if height(own, outgoing, hit.normal) < 1e-5 {
                continue;
            }
            left += 1;
            let normal = scene.shading_normal(&hit, outgoing);
            let expected = if own.dot(outgoing) >= 0.0 { own } else { -own };
            assert!(normal.distance(expected) < 1e-5, "{normal} is not {expected} at {hit:?}");
        }
        assert!(left > 100, "{left} normals were left");
    }
}

/// Returns a saddle in a frame with a normal map of one colour.
fn mapped_saddle(pixel: [u8; 4], frame: Affine3A) -> Scene {
    let shape = Shape {
        elements: Elements::Quads(vec![[0, 1, 2, 3]]),
        positions: vec![
            vec3(0.0, 0.0, 0.2),
            vec3(1.0, 0.0, -0.2),
            vec3(1.0, 1.0, 0.2),
            vec3(0.0, 1.0, -0.2),
        ],
        // v runs down the image, so that up on the saddle is up in the image.
        texcoords: vec![vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)],
        ..Shape::default()
    };
    let mut scene = scene_of(shape, frame, MaterialKind::Matte);
    let pixels = Pixels::Bytes(vec![pixel]);
    scene.textures = vec![Texture { name: String::new(), width: 1, height: 1, pixels }];
    scene.materials[0].normal_tex = Some(0);
    scene
}

#[test]
fn a_normal_map_follows_the_tangents_of_the_patch_in_every_frame() {
    let mut random = Random(71);
    for (why, frame) in frames() {
        // Tilted along +u of the image, by about 27 degrees.
        let scene = mapped_saddle([191, 128, 255, 255], frame);
        let mut tilts = Vec::new();
        for _ in 0..200 {
            let uv = random.uv();
            let geometric = scene.eval_normal(0, 0, uv);
            let (by_u, _) = scene.eval_tangents(0, 0, uv);
            let along = (by_u - geometric * geometric.dot(by_u)).normalize();
            let normal = scene.eval_shading_normal(0, 0, uv);
            // The rounding of a byte is at most 1/255 of the map.
            let sideways = normal.dot(geometric.cross(along));
            assert!(sideways.abs() < 6e-3, "{why}: tilts along u and not across: {sideways}");
            let tilt = normal.dot(along).atan2(normal.dot(geometric)).to_degrees();
            assert!((tilt - 26.6).abs() < 0.5, "{why}: {tilt} degrees");
            tilts.push(along);
        }
        let turned = tilts.iter().any(|t| t.dot(tilts[0]) < 0.99);
        assert!(turned, "{why}: the tangents vary over a patch, unlike those of two triangles");
    }
}

#[test]
fn vanilla_triangles_of_a_quad_share_one_tangent_and_one_normal() {
    let mut scene = mapped_saddle([191, 128, 255, 255], frames()[0].1);
    scene.set_method(ElementKind::Quads, Method::Vanilla);
    let first = scene.eval_tangents(0, 0, vec2(0.1, 0.2));
    assert_eq!(scene.eval_tangents(0, 0, vec2(0.9, 0.7)), first);
    let ray = |x: f32, y: f32| Ray::new(vec3(x, y, 5.0), Vec3::NEG_Z);
    let trees = Trees::build(&scene).expect("the scene is valid");
    let normal = |x, y| {
        let hit: SceneHit = trees.closest(&scene, &ray(x, y)).expect("aimed at it");
        scene.shading_normal(&hit, Vec3::Z)
    };
    assert!(normal(0.2, 0.2).distance(normal(0.8, 0.9)) < 1e-6, "the mean of both");
}

#[test]
fn spheres_and_tubes_take_normal_maps_in_their_own_tangents() {
    let mut random = Random(73);
    for mut shape in shapes(&mut random, 3, 0.5) {
        let round = matches!(shape.elements.kind(), ElementKind::Points | ElementKind::Lines);
        if !round {
            continue;
        }
        shape.method = Method::Enhanced;
        let mut scene = scene_of(shape, frames()[0].1, MaterialKind::Matte);
        let pixels = Pixels::Bytes(vec![[191, 128, 255, 255]]);
        scene.textures = vec![Texture { name: String::new(), width: 1, height: 1, pixels }];
        scene.materials[0].normal_tex = Some(0);
        let uv = Vec2::new(0.3, 0.45);
        let (geometric, normal) =
            (scene.eval_normal(0, 1, uv), scene.eval_shading_normal(0, 1, uv));
        let tilt = normal.dot(geometric).acos().to_degrees();
        assert!((tilt - 26.6).abs() < 0.5, "{tilt} degrees");
        let (by_u, _) = scene.eval_tangents(0, 1, uv);
        assert!(normal.dot(by_u) > 0.0, "towards u");
    }
}

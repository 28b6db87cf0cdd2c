//! Points and lines of one shape are one body: what a path meets is the boundary of their union.

#[path = "../../geometry/src/test_random.rs"]
mod random;

use glam::{Vec2, Vec3};
use random::Random;
use rotund_geometry::Ray;
use rotund_scene::{
    Camera, Environment, Material, MaterialKind, Overlap, Scene, SceneHit, Shape, Trees,
};
use rotund_trace::{Options, Sequence, Shard, View, World};

/// A tube along x from -1 to 1, cut into pieces that share their end balls.
fn tube(pieces: u32) -> Shape {
    let x = |i: u32| -1.0 + 2.0 * i as f32 / pieces as f32;
    let positions: Vec<Vec3> = (0..=pieces).map(|i| Vec3::X * x(i)).collect();
    let lines: Vec<[u32; 2]> = (0..pieces).map(|i| [i, i + 1]).collect();
    Shape::lines(positions, 0.3, lines)
}

/// A polyline that bends sharply, so that the pieces on either side of a vertex overlap.
fn zigzag() -> Shape {
    let positions: Vec<Vec3> =
        (0..7).map(|i| Vec3::new(i as f32 / 3.0 - 1.0, 0.4 * (i % 2) as f32, 0.1)).collect();
    let lines: Vec<[u32; 2]> = (0..6).map(|i| [i, i + 1]).collect();
    Shape::lines(positions, 0.2, lines)
}

fn glass() -> Material {
    Material { kind: MaterialKind::Refractive, ior: 1.5, color: Vec3::ONE, ..Material::default() }
}

fn materials() -> [(&'static str, Material); 5] {
    // Light that travels 0.5 m in the body keeps these shares.
    let (color, trdepth) = (Vec3::new(0.8, 0.4, 0.2), 0.5);
    [
        ("glass", glass()),
        ("absorbing glass", Material { color, trdepth, ..glass() }),
        ("half opaque", Material { opacity: 0.5, color: Vec3::splat(0.5), ..Material::default() }),
        (
            "scattering",
            Material {
                kind: MaterialKind::Volumetric,
                color,
                trdepth,
                albedo: Vec3::splat(0.9),
                ..Material::default()
            },
        ),
        (
            "transparent",
            Material { kind: MaterialKind::Transparent, color: Vec3::splat(0.8), ..glass() },
        ),
    ]
}

fn scene(shape: Shape, material: Material) -> Scene {
    let mut scene = Scene {
        cameras: vec![Camera::look_at(Vec3::new(0.4, 0.8, 3.0), Vec3::ZERO, Vec3::Y)],
        environments: vec![Environment { emission: Vec3::ONE, ..Environment::default() }],
        ..Scene::default()
    };
    scene.add(shape, material);
    // A floor in bands, so that refraction shows.
    for i in 0..6 {
        let x = i as f32 - 3.0;
        let corners = [[x, -2.0], [x, 2.0], [x + 1.0, 2.0], [x + 1.0, -2.0]]
            .map(|[x, z]| Vec3::new(x, -0.7, z));
        let color = Vec3::splat(if i % 2 == 0 { 0.2 } else { 0.8 });
        scene.add(Shape::quads(corners, [[0, 1, 2, 3]]), Material { color, ..Material::default() });
    }
    scene
}

const OPTIONS: Options = Options {
    width: 48,
    height: 32,
    samples: 64,
    bounces: 12,
    seed: 5,
    clamp: None,
    view: View::Path,
    sequence: Sequence::Sobol,
    shard: Shard { index: 0, count: 1 },
    transparent: false,
    recenter: true,
};

/// Mean of each of 24 blocks of 8 x 8 pixels.
fn blocks(scene: &Scene, options: &Options) -> Vec<f64> {
    let world = World::new(scene).expect("a valid scene");
    let image = world.render(0, options).expect("a picture").image();
    let mut sums = vec![0.0; 24];
    for (index, pixel) in image.pixels.iter().enumerate() {
        let (x, y) = (index % 48, index / 48);
        let luminance: f32 = pixel[..3].iter().sum();
        sums[y / 8 * 6 + x / 8] += f64::from(luminance) / (3.0 * 64.0);
    }
    sums
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_tube_in_pieces_looks_like_the_whole() {
    for (name, material) in materials() {
        let whole = blocks(&scene(tube(1), material.clone()), &OPTIONS);
        let other = Options { seed: 99, ..OPTIONS };
        let noise = largest_difference(&whole, &blocks(&scene(tube(1), material.clone()), &other));
        for pieces in [2, 8, 64] {
            let found = blocks(&scene(tube(pieces), material.clone()), &OPTIONS);
            let off = largest_difference(&found, &whole);
            assert!(off <= 2.0 * noise, "{name}, {pieces} pieces: {off}, noise {noise}");
        }
        let separate = Shape { overlap: Overlap::Separate, ..tube(8) };
        let off = largest_difference(&blocks(&scene(separate, material), &OPTIONS), &whole);
        assert!(off > 2.0 * noise, "{name}: whole surfaces of eight pieces show: {off}, {noise}");
    }
}

#[test]
fn coincident_beads_look_like_one() {
    for (name, material) in materials() {
        let beads = |count: usize| Shape::points(vec![Vec3::ZERO; count], 0.6);
        let one = blocks(&scene(beads(1), material.clone()), &OPTIONS);
        let many = blocks(&scene(beads(5), material), &OPTIONS);
        let off = largest_difference(&one, &many);
        // A body is entered by other code than a lone ball, which rounds alike.
        assert!(off < 1e-3, "{name}: {off}");
    }
}

#[test]
fn a_glass_union_in_a_white_furnace_is_invisible() {
    let options = Options { bounces: 64, samples: 256, view: View::Furnace, ..OPTIONS };
    for shape in [tube(8), zigzag()] {
        let mut scene = scene(shape, glass());
        scene.instances.truncate(1);
        let world = World::new(&scene).expect("a valid scene");
        let image = world.render(0, &options).expect("a picture").image();
        let sum: f64 = image.pixels.iter().map(|pixel| f64::from(pixel[1])).sum();
        let mean = sum / image.pixels.len() as f64;
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
    }
}

/// Follows rays that go inside and outside at random, and returns how many were followed. Each ray
/// that goes inside must next leave, and each that goes outside must next enter.
fn wander(scene: &Scene, count: usize, random: &mut Random) -> usize {
    let trees = Trees::build(scene).expect("a valid scene");
    let mut followed = 0;
    let camera = &scene.cameras[0];
    while followed < count {
        let ray = camera.ray(Vec2::new(random.unit(), random.unit()), Vec2::ZERO);
        let mut hit = trees.closest(scene, &ray);
        let mut direction = ray.direction;
        for _ in 0..64 {
            let Some(here) = hit else { break };
            let side = here.normal.dot(direction);
            // Straight on, or anywhere.
            if random.below(2) == 0 {
                direction = random.direction().as_vec3();
            }
            let inside = here.normal.dot(direction) < 0.0;
            let ray = here.spawn(direction);
            let next = trees.closest_after(scene, &ray, here.left_by(direction));
            followed += 1;
            let says = |hit: &SceneHit| hit.normal.dot(direction);
            match next {
                Some(next) if inside => {
                    assert!(says(&next) > -1e-3, "{side} {here:?} {ray:?} {next:?}");
                }
                Some(next) => assert!(says(&next) < 1e-3, "{side} {here:?} {ray:?} {next:?}"),
                None => assert!(!inside, "no exit: {here:?} {ray:?}"),
            }
            hit = next;
        }
    }
    followed
}

#[test]
fn no_bounce_ends_on_the_wrong_side() {
    let mut random = Random(0x5EED);
    let crowd = |random: &mut Random| {
        let positions: Vec<Vec3> = (0..200).map(|_| random.in_cube() * 0.5).collect();
        let radii: Vec<f32> = (0..200).map(|_| 0.05 + 0.15 * random.unit()).collect();
        (positions, radii)
    };
    let (positions, radii) = crowd(&mut random);
    let balls = Shape::points(positions.clone(), radii.clone());
    let lines: Vec<[u32; 2]> = (0..199).map(|i| [i, i + 1]).collect();
    let cones = Shape::lines(positions, radii, lines);
    // Balls that touch in a plane, so that every crease is where two surfaces meet.
    let touching: Vec<Vec3> =
        (0..64).map(|i| Vec3::new((i % 8) as f32, (i / 8) as f32, 0.0) * 0.25 - 0.9).collect();
    let touching = Shape::points(touching, 0.125);
    for shape in [zigzag(), tube(64), balls, cones, touching] {
        let mut scene = scene(shape, glass());
        scene.instances.truncate(1);
        wander(&scene, 40_000, &mut random);
    }
}

#[test]
fn the_inside_of_a_body_has_no_surfaces() {
    let mut scene = scene(tube(8), glass());
    scene.instances.truncate(1);
    let trees = Trees::build(&scene).expect("a valid scene");
    let along = Ray::new(Vec3::new(-5.0, 0.05, 0.0), Vec3::X);
    let entry = trees.closest(&scene, &along).expect("the tube");
    let exit = trees.closest(&scene, &entry.spawn(Vec3::X)).expect("the far end");
    assert!(exit.position.x > 1.0, "{exit:?}");
    let inside = Ray { t_max: 0.5, ..Ray::new(Vec3::ZERO, Vec3::X) };
    assert!(!trees.any(&scene, &inside));
    scene.set_overlap(Overlap::Separate);
    let mut trees = trees;
    trees.refit(&scene).expect("the same shapes");
    assert!(trees.any(&scene, &inside), "the ends of the pieces");
}

#[test]
fn what_is_covered_does_not_shine() {
    let lamp = Material {
        emission: Vec3::splat(3.0),
        color: Vec3::ZERO,
        opacity: 0.5,
        ..Material::default()
    };
    let options = Options { samples: 1024, bounces: 4, ..OPTIONS };
    let light_of = |shape: Shape| {
        let mut scene = scene(shape, lamp.clone());
        scene.environments.clear();
        blocks(&scene, &options).iter().sum::<f64>()
    };
    let one = light_of(Shape::points([Vec3::ZERO], 0.4));
    for (what, shape) in [
        ("copies", Shape::points(vec![Vec3::ZERO; 5], 0.4)),
        ("balls inside", Shape::points(vec![Vec3::ZERO; 3], [0.1, 0.4, 0.3])),
    ] {
        let share = light_of(shape) / one;
        assert!((share - 1.0).abs() < 0.004, "{what}: {share}");
    }
    let whole = light_of(tube(1));
    let share = light_of(tube(8)) / whole;
    assert!((share - 1.0).abs() < 0.004, "a tube in pieces: {share}");
}

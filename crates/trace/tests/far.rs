//! Scenes far from the origin are rendered about their camera.

mod support;

use glam::{Affine3A, Vec3, Vec3A};
use rotund_scene::Scene;
use rotund_trace::{Film, Options, View, World};

const OPTIONS: Options = Options {
    width: 24,
    height: 16,
    samples: 4,
    bounces: 4,
    seed: 1,
    sequence: rotund_trace::Sequence::Sobol,
    shard: rotund_trace::Shard { index: 0, count: 1 },
    view: View::Path,
    clamp: None,
    transparent: false,
    recenter: true,
};

fn render(scene: &Scene, options: &Options) -> Film {
    World::new(scene).expect("a valid scene").render(0, options).expect("a picture")
}

/// Frames with few digits, so that they can be moved without rounding.
fn moved(by: Vec3) -> Scene {
    let mut scene = support::glass_over_a_floor();
    scene.cameras[0].world_from_camera = Affine3A::from_translation(by);
    for instance in &mut scene.instances {
        instance.world_from_object = Affine3A::from_translation(by - 4.0 * Vec3::Z);
    }
    scene
}

#[test]
fn a_scene_far_away_makes_the_bits_of_one_at_the_origin() {
    let (here, there) = (moved(Vec3::ZERO), moved(Vec3::new(65536.0, -32768.0, 131_072.0)));
    let expected = render(&here, &OPTIONS);
    assert_eq!(render(&there, &OPTIONS), expected);
    // Rendering again, resuming, and another view in between all find the scene they should.
    let world = World::new(&there).expect("a valid scene");
    let half = Options { samples: 2, ..OPTIONS };
    let mut film = world.render(0, &half).expect("a picture");
    let position = Options { view: View::Position, ..OPTIONS };
    assert_eq!(world.render(0, &position).expect("a picture").samples(), 4);
    let go_on = &mut |_: &rotund_trace::Progress<'_>| std::ops::ControlFlow::Continue(());
    world.resume(&mut film, 0, &OPTIONS, go_on).expect("a picture");
    assert_eq!(film, expected);
    assert_ne!(render(&there, &Options { recenter: false, ..OPTIONS }), expected);
}

#[test]
fn each_camera_decides_for_itself() {
    let mut scene = moved(Vec3::ZERO);
    let mut far = scene.cameras[0].clone();
    far.world_from_camera.translation += Vec3A::new(1e6, 0.0, 0.0);
    scene.cameras.push(far);
    let world = World::new(&scene).expect("a valid scene");
    let [first, second] = [0, 1].map(|camera| world.render(camera, &OPTIONS).expect("a picture"));
    assert_eq!(first, world.render(0, &OPTIONS).expect("a picture"));
    assert_ne!(first, second);
}

#[test]
fn layers_show_positions_where_they_are() {
    let place = Vec3::new(65536.0, -32768.0, 131_072.0);
    let layers =
        World::new(&moved(place)).expect("a valid scene").layers(0, &OPTIONS).expect("layers");
    let center = layers.position[8 * 24 + 12];
    assert!(center.distance(place) < 10.0, "{center}");
}

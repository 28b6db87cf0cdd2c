//! The examples, run on small pictures: they do what they say.

#[path = "../examples/ambient_occlusion.rs"]
mod ambient_occlusion;
#[path = "../examples/ethanol.rs"]
mod ethanol;
#[path = "../examples/particles.rs"]
mod particles;
#[path = "../examples/window.rs"]
mod window;

use rotund_trace::{Film, Options, World, output};
use std::time::Duration;

const SIZE: [u32; 2] = [48, 32];

fn options(samples: u32) -> Options {
    Options { width: SIZE[0], height: SIZE[1], samples, ..Options::default() }
}

#[test]
fn ambient_occlusion_darkens_the_contact_and_nothing_else() {
    let scene = ambient_occlusion::ball_on_a_floor();
    let world = World::new(&scene).expect("a valid scene");
    let film = ambient_occlusion::occlusion(&world, 0, &options(64), 2.0).expect("a film");
    assert_eq!((film.samples(), film.rejected()), (64, 0));
    let image = film.image();
    let at = |x: usize, y: usize| image.pixels[y * SIZE[0] as usize + x];
    assert_eq!(at(1, 0)[3], 0.0, "nothing is there");
    let [top, contact, floor] = [at(24, 2)[0], at(24, 22)[0], at(2, 31)[0]];
    assert!(top > 0.8 && floor > 0.9 && contact < 0.7, "{top}, {contact}, {floor}");
    // Other threads make the same bits.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let again = pool.install(|| ambient_occlusion::occlusion(&world, 0, &options(64), 2.0));
    assert_eq!(again.expect("a film"), film);
    assert!(ambient_occlusion::occlusion(&world, 1, &options(64), 2.0).is_err(), "no camera 1");
}

#[test]
fn particles_go_from_memory_to_a_png() {
    let scene = particles::galaxy(20_000);
    let film = particles::render(&scene, &options(4)).expect("a picture");
    let image = film.image();
    assert_eq!(image.pixels[0], [0.0; 4], "the background is transparent");
    let mean = |channel: usize| image.pixels.iter().map(|p| p[channel]).sum::<f32>();
    let [red, _, blue, alpha] = [0, 1, 2, 3].map(mean);
    assert!(alpha > 100.0 && red > 10.0 && blue > 10.0, "{red}, {blue}, {alpha}");
    let center = (12..20).flat_map(|y| &image.pixels[y * 48 + 20..y * 48 + 28]);
    let [red, blue] = center.fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[2]]);
    assert!(red > blue, "it is warmer in the middle: red {red}, blue {blue}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("particles.png");
    output::write(&path, &film).expect("a PNG");
    assert!(std::fs::read(path).expect("the PNG").starts_with(b"\x89PNG"));
}

#[test]
fn a_window_shows_a_picture_that_converges() {
    let scene = window::balls();
    let world = World::new(&scene).expect("a valid scene");
    let options = options(64);
    let mut film = Film::for_options(&options).expect("a film");
    // A deadline that has passed still brings the picture on by one batch, here a whole pass.
    let complete = window::render_frame(&world, &mut film, &options, Duration::ZERO);
    assert_eq!(complete, Ok(false));
    assert_eq!(film.samples(), 1);
    let mut frames = 1;
    while window::render_frame(&world, &mut film, &options, Duration::ZERO) == Ok(false) {
        frames += 1;
        assert!(frames < 64, "it does not converge");
    }
    assert_eq!(film, world.render(0, &options).expect("a picture"));
}

#[test]
fn a_molecule_has_atoms_and_bonds() {
    let scene = ethanol::molecule(&ethanol::ETHANOL);
    assert_eq!(scene.shapes[0].elements.count(), 9);
    assert_eq!(scene.shapes[1].elements.count(), 8, "a chain of 3, and 6 hydrogens");
    let film =
        World::new(&scene).expect("a valid scene").render(0, &options(4)).expect("a picture");
    let image = film.image();
    let oxygen = image.pixels.iter().filter(|p| p[0] > 4.0 * p[1]).count();
    assert!(oxygen > 3, "{oxygen} red pixels");
}

//! The render loop of a window or a server: each frame renders until a deadline and shows what
//! there is. The film keeps its samples between frames, so a picture at rest converges; a camera
//! that moves begins a new film.
//!
//! ```text
//! cargo run --release -p rotund-trace --example window
//! ```

use rotund_trace::scene::geometry::glam::Vec3;
use rotund_trace::scene::{Camera, Environment, Material, Scene, Shape};
use rotund_trace::{Film, Options, RenderError, World, output};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Adds samples to a film until a deadline, and returns whether it is complete. Progress is
/// reported at least every 0.1 s whatever the size of the picture, so the deadline is missed by no
/// more than that.
pub(crate) fn render_frame(
    world: &World<'_>,
    film: &mut Film,
    options: &Options,
    time: Duration,
) -> Result<bool, RenderError> {
    let deadline = Instant::now() + time;
    world.resume(film, 0, options, &mut |_progress| {
        // A window would look for input here, a server for a request that was withdrawn.
        if Instant::now() < deadline { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    })?;
    Ok(film.samples() >= options.samples)
}

/// Three balls under a sky.
pub(crate) fn balls() -> Scene {
    let mut scene = Scene {
        cameras: vec![Camera::look_at(Vec3::new(0.0, 1.0, 6.0), Vec3::ZERO, Vec3::Y)],
        environments: vec![Environment { emission: Vec3::ONE, ..Environment::default() }],
        ..Scene::default()
    };
    let grey = Material { color: Vec3::splat(0.5), ..Material::default() };
    let centers = [-1.2, 0.0, 1.2].map(|x| Vec3::new(x, 0.0, 0.0));
    scene.add(Shape::points(centers, vec![0.5, 0.7, 0.5]), grey);
    scene
}

#[allow(dead_code, reason = "the test of the examples calls what main calls")]
#[expect(clippy::print_stdout, reason = "an example is here to be seen")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = balls();
    let world = World::new(&scene)?;
    let options = Options { samples: 256, ..Options::default() };
    let mut film = Film::for_options(&options)?;
    let mut frame = 0;
    loop {
        let complete = render_frame(&world, &mut film, &options, Duration::from_millis(200))?;
        // Pixels are means of their own samples, so the image is right in the middle of a pass.
        let image = film.image();
        frame += 1;
        println!("frame {frame}: {} pixels, {} samples", image.pixels.len(), film.samples());
        if complete {
            break;
        }
    }
    Ok(output::write("window.png", &film)?)
}

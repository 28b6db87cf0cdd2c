//! Millions of coloured particles from memory to a PNG.
//!
//! ```text
//! cargo run --release -p rotund-trace --example particles -- 5000000 particles.png
//! ```

use rotund_trace::scene::geometry::glam::{Vec3, Vec4};
use rotund_trace::scene::{Camera, Environment, Material, Scene, Shape};
use rotund_trace::{Film, Options, Sampler, Sequence, World, output};

/// A spiral galaxy of `count` particles, brighter and warmer towards the center.
pub(crate) fn galaxy(count: u32) -> Scene {
    // So small that neighbours rarely overlap.
    let radius = 0.25 / (count.max(1) as f32).cbrt();
    let (positions, colors): (Vec<Vec3>, Vec<Vec4>) = (0..count).map(particle).unzip();
    let particles = Shape { colors, ..Shape::points(positions, radius) };
    let eye = Vec3::new(0.0, 1.2, 2.4);
    let mut scene = Scene {
        cameras: vec![Camera::look_at(eye, Vec3::ZERO, Vec3::Y)],
        environments: vec![Environment { emission: Vec3::splat(0.6), ..Environment::default() }],
        ..Scene::default()
    };
    // The colours of the vertices scale that of the material.
    scene.add(particles, Material { color: Vec3::ONE, ..Material::default() });
    scene
}

fn particle(index: u32) -> (Vec3, Vec4) {
    let [a, b, c, d] = Sampler::new(Sequence::Independent, 1, 0, 0, index).set(0);
    let distance = a.sqrt();
    let arm = std::f32::consts::PI * (b * 2.0).floor();
    let angle = 4.0 * distance + arm + (c - 0.5) * (1.0 - 0.5 * distance);
    let height = 0.2 * (d - 0.5) * (1.0 - distance);
    let position = Vec3::new(distance * angle.cos(), height, distance * angle.sin());
    let color = Vec3::new(1.0, 0.7, 0.4).lerp(Vec3::new(0.2, 0.4, 1.0), distance);
    (position, color.extend(1.0))
}

/// Renders a galaxy before a transparent background.
pub(crate) fn render(scene: &Scene, options: &Options) -> Result<Film, Box<dyn std::error::Error>> {
    let options = Options { transparent: true, ..options.clone() };
    Ok(World::new(scene)?.render(0, &options)?)
}

#[allow(dead_code, reason = "the test of the examples calls what main calls")]
#[expect(clippy::print_stdout, reason = "an example is here to be seen")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let count = arguments.next().map_or(Ok(5_000_000), |count| count.parse())?;
    let path = arguments.next().unwrap_or_else(|| "particles.png".to_owned());
    let film = render(&galaxy(count), &Options { samples: 16, ..Options::default() })?;
    output::write(&path, &film)?;
    println!("{path}: {count} particles");
    Ok(())
}

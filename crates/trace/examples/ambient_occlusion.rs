//! A custom integrator: ambient occlusion, the share of the hemisphere above a point that
//! nothing blocks within a distance. It shows contacts and creases without any light.
//!
//! ```text
//! cargo run --release -p rotund-trace --example ambient_occlusion
//! ```

use rotund_trace::scene::geometry::Ray;
use rotund_trace::scene::geometry::glam::{Vec2, Vec3};
use rotund_trace::scene::{Camera, Material, Scene, Shape};
use rotund_trace::{
    Film, FilmSample, Options, RenderError, Sampler, World, camera_ray, output, warp,
};

/// Renders the ambient occlusion of what a camera sees, up to `reach` meters from each point.
pub(crate) fn occlusion(
    world: &World<'_>,
    camera: usize,
    options: &Options,
    reach: f32,
) -> Result<Film, RenderError> {
    let camera = world.camera(camera)?;
    let size = [options.width, options.height];
    let mut film = Film::for_options(options)?;
    // The closure runs on all threads. Its result depends on pixel and sample alone, so the film
    // does too.
    film.accumulate(options.samples, |x, y, sample| {
        let sampler = Sampler::new(options.sequence, options.seed, x, y, sample);
        let ray = camera_ray(camera, size, [x, y], &sampler);
        let Some(hit) = world.closest(&ray) else { return FilmSample::default() };
        let normal = world.scene().shading_normal(&hit, -ray.direction);
        // A direction with density cos / pi: the cosine of ambient light cancels.
        let [u, v, ..] = sampler.set(1);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let local = warp::cosine_hemisphere(Vec2::new(u, v));
        let incoming = local.x * tangent + local.y * bitangent + local.z * normal;
        let open = !world.any(&Ray { t_max: reach, ..hit.spawn(incoming) });
        FilmSample::from(Vec3::splat(f32::from(u8::from(open))))
    });
    Ok(film)
}

/// A ball on a floor, before the camera.
pub(crate) fn ball_on_a_floor() -> Scene {
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 6.0), Vec3::new(0.0, 0.5, 0.0), Vec3::Y);
    let mut scene = Scene { cameras: vec![camera], ..Scene::default() };
    scene.add(Shape::points([Vec3::new(0.0, 1.0, 0.0)], 1.0), Material::default());
    let corner = |x, z| Vec3::new(x, 0.0, z);
    let corners = [corner(-9.0, 9.0), corner(9.0, 9.0), corner(9.0, -9.0), corner(-9.0, -9.0)];
    scene.add(Shape::quads(corners, [[0, 1, 2, 3]]), Material::default());
    scene
}

#[allow(dead_code, reason = "the test of the examples calls what main calls")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = ball_on_a_floor();
    let world = World::new(&scene)?;
    let film = occlusion(&world, 0, &Options::default(), 2.0)?;
    Ok(output::write("ambient-occlusion.png", &film)?)
}

//! Irradiance from round and curved lights on a surface that is near, far, partly below the
//! horizon, or in contact: by light samples alone, by BSDF samples alone, and rendered with both.
//! The expected value is a closed form, or a quadrature in `f64` over the exact surface.

use super::{SAMPLES, drawn, lambert, shining};
use crate::{Options, Sampler, Sequence, World, warp};
use glam::{Affine3A, DVec3, Mat3A, Vec2, Vec3, Vec3A};
use rotund_geometry::{Ray, leave_surface};
use rotund_scene::{Camera, Elements, Instance, Material, Method, Scene, Shape, Trees};
use std::f64::consts::{PI, TAU};

/// A receiving surface: position and normal.
type Receiver = (Vec3, Vec3);

/// The estimators that a test covers.
#[derive(Clone, Copy, PartialEq)]
enum Ask {
    /// Light samples, surface samples, and a picture by both.
    All,
    /// Surface samples, and a picture by both. The light is so near that its points are sampled too
    /// rarely where they contribute most, so light samples alone converge slowly.
    Union,
    /// Surface samples only, where no camera has a view.
    Surface,
}

/// Compares both samplers and their combination with `expected`. `outwards` points along the
/// surface to where a camera sees it unoccluded.
fn assert_lit(why: &str, light: &Scene, at: Receiver, outwards: Vec3, ask: Ask, expected: f64) {
    let within = |name: &str, found: f64, tolerance: f64| {
        let error = (found / expected - 1.0).abs();
        assert!(error < tolerance, "{why}, {name}: {found}, not {expected}");
    };
    if ask == Ask::All {
        within("from the light", drawn(light, at.0, at.1), 2e-3);
    }
    let (found, deviation) = found_by_chance(light, at);
    within("from the surface", found, (5.0 * deviation / expected).max(2e-3));
    if ask != Ask::Surface {
        within("rendered", rendered(light, at, outwards), 2e-3);
    }
}

/// Estimates the irradiance from cosine-distributed directions. Returns it with a bound on its
/// standard deviation.
fn found_by_chance(scene: &Scene, (position, normal): Receiver) -> (f64, f64) {
    let trees = Trees::build(scene).expect("the scene is valid");
    let (x, y) = normal.any_orthonormal_pair();
    let hits = (0..SAMPLES).filter(|&index| {
        let [u, v, ..] = Sampler::new(Sequence::Sobol, 3, 0, 0, index).set(0);
        let local = warp::cosine_hemisphere(Vec2::new(u, v));
        let incoming = local.x * x + local.y * y + local.z * normal;
        let start = leave_surface(position, 0.0, normal, incoming);
        trees.any(scene, &Ray::new(start, incoming))
    });
    let share = hits.count() as f64 / f64::from(SAMPLES);
    // The deviation of independent numbers, which a low-discrepancy sequence undercuts.
    (PI * share, PI * (share * (1.0 - share) / f64::from(SAMPLES)).sqrt())
}

/// Measures the irradiance by the renderer: a camera just above a white square looks at its center.
fn rendered(light: &Scene, (position, normal): Receiver, outwards: Vec3) -> f64 {
    const SIDE: u32 = 4;
    const REACH: f32 = 0.01;
    let mut scene = light.clone();
    let (x, y) = normal.any_orthonormal_pair();
    let corner = |s: f32, t: f32| position + 0.1 * REACH * (s * x + t * y);
    scene.shapes.push(Shape {
        method: Method::Vanilla,
        elements: Elements::Quads(vec![[0, 1, 2, 3]]),
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        ..Shape::default()
    });
    scene.materials.push(Material { color: Vec3::ONE, ..Material::default() });
    scene.instances.push(Instance {
        name: String::new(),
        world_from_object: Affine3A::IDENTITY,
        shape: 1,
        material: 1,
    });
    // Nearly parallel to the surface, below the light that touches it.
    let back = (outwards + 0.01 * normal).normalize();
    let (right, up) = back.any_orthonormal_pair();
    scene.cameras.push(Camera {
        world_from_camera: Affine3A {
            matrix3: Mat3A::from_cols(right.into(), up.into(), back.into()),
            translation: Vec3A::from(position + REACH * back),
        },
        // A field of view so narrow that it sees a tenth of the square.
        lens: 500.0,
        aspect: 1.0,
        ..Camera::default()
    });
    let options = Options {
        width: SIDE,
        height: SIDE,
        samples: 4 * SAMPLES / (SIDE * SIDE),
        bounces: 2,
        ..Options::default()
    };
    let world = World::new(&scene).expect("a valid scene");
    let seen = world.closest(&scene.cameras[0].ray(Vec2::splat(0.5), Vec2::ZERO));
    assert_eq!(seen.map(|hit| hit.instance), Some(1), "the square is seen at {position}");
    let film = world.render(0, &options).expect("a picture");
    assert_eq!(film.rejected(), 0, "all samples are numbers");
    let pixels = film.image().pixels;
    PI * pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / pixels.len() as f64
}

#[test]
fn a_ball_lights_as_the_integral_over_its_directions_says() {
    let scene = shining(Elements::Points(1), Method::Enhanced, &[[0.0; 3]], &[0.5]);
    for (why, position, normal) in [
        ("near", [0.1, -0.8, 0.2], [0.1, 1.0, 0.0]),
        ("far", [3.0, -20.0, 1.0], [0.0, 1.0, 0.0]),
        ("partly below the horizon", [0.2, -1.5, 0.1], [0.9, 0.1, 0.0]),
        ("near and mostly below the horizon", [0.0, -0.52, 0.0], [1.0, -0.2, 0.0]),
        ("touching", [0.05, -0.5, 0.0], [0.0, 1.0, 0.0]),
        ("touching, a hundredth of the radius away", [0.005, -0.5, 0.0], [0.0, 1.0, 0.0]),
    ] {
        let at = (Vec3::from(position), Vec3::from(normal).normalize());
        // Around the direction to the center, the positive part of a + b cos(azimuth) has a
        // closed-form integral.
        let to = -at.0.as_dvec3();
        let aperture = (0.5 / to.length()).asin();
        let cosine = at.1.as_dvec3().dot(to.normalize());
        const STEPS: u32 = 10_000;
        let ring = |k: u32| {
            let angle = aperture * (f64::from(k) + 0.5) / f64::from(STEPS);
            let a = cosine * angle.cos();
            let b = (1.0 - cosine * cosine).max(0.0).sqrt() * angle.sin();
            let azimuth = if a >= b { PI } else { (-a / b).clamp(-1.0, 1.0).acos() };
            2.0 * (a * azimuth + b * azimuth.sin()) * angle.sin()
        };
        let expected = (0..STEPS).map(ring).sum::<f64>() * aperture / f64::from(STEPS);
        let outwards = at.0.reject_from_normalized(at.1).normalize();
        assert_lit(why, &scene, at, outwards, Ask::All, expected);
    }
    // From the point of contact the ball covers the whole hemisphere.
    let contact = (-0.5 * Vec3::Y, Vec3::Y);
    assert_lit("the point of contact", &scene, contact, Vec3::X, Ask::Surface, PI);
}

#[test]
fn a_rounded_cone_lights_as_the_integral_over_its_surface_says() {
    let (r0, r1, half) = (0.5, 0.2, 0.8);
    let scene = shining(
        Elements::Lines(vec![[0, 1]]),
        Method::Enhanced,
        &[[-0.8, 0.0, 0.0], [0.8, 0.0, 0.0]],
        &[0.5, 0.2],
    );
    // Sine of the angle by which the normals of the flank lean towards the thin end.
    let lean: f64 = (r0 - r1) / (2.0 * half);
    let upright = (1.0 - lean * lean).sqrt();
    let normal_at = |along: f64, azimuth: f64| {
        let side = (1.0 - along * along).sqrt();
        DVec3::new(along, side * azimuth.cos(), side * azimuth.sin())
    };
    let flank_at = |u: f64, azimuth: f64| {
        let n = normal_at(lean, azimuth);
        (DVec3::X * (half * (2.0 * u - 1.0)) + (r0 + u * (r1 - r0)) * n, n)
    };
    let lit = |at: Receiver| {
        let cap = |center: f64, radius: f64, from: f64, to: f64| {
            integrated(at, [1.0, 0.5], |u, v| {
                let n = normal_at(from + u * (to - from), TAU * v);
                (DVec3::X * center + radius * n, n, TAU * radius * radius * (to - from).abs())
            })
        };
        // Parameters of the point nearest to the receiver.
        let eye = at.0.as_dvec3();
        let along = eye.x + half - eye.y.hypot(eye.z) * lean / upright;
        let focus =
            [(along / (2.0 * half)).clamp(0.0, 1.0), eye.z.atan2(eye.y).rem_euclid(TAU) / TAU];
        let flank = integrated(at, focus, |u, v| {
            let (q, n) = flank_at(u, TAU * v);
            // Circumference times the slant height per unit of u.
            (q, n, TAU * (r0 + u * (r1 - r0)) * upright * 2.0 * half * upright)
        });
        flank + cap(-half, r0, -1.0, lean) + cap(half, r1, 1.0, lean)
    };
    let (contact, out) = flank_at(0.4, PI);
    let (contact, floor) = (contact.as_vec3(), -out.as_vec3());
    // Direction of the line in which the plane below touches the flank.
    let line = Vec3::Z.cross(floor);
    for (why, position, normal, ask) in [
        ("near", Vec3::new(0.1, -0.8, 0.2), Vec3::new(0.1, 1.0, 0.0), Ask::All),
        ("far", Vec3::new(3.0, -20.0, 1.0), Vec3::Y, Ask::All),
        ("partly below the horizon", Vec3::new(0.2, -1.5, 0.1), Vec3::new(0.9, 0.1, 0.0), Ask::All),
        ("beyond an end", Vec3::new(2.0, 0.3, 0.2), Vec3::new(-1.0, 0.0, 0.1), Ask::All),
        ("half below the horizon", Vec3::new(0.0, -0.4, 0.1), Vec3::new(1.0, 0.0, 0.2), Ask::All),
        ("touching", contact + 0.05 * Vec3::Z, floor, Ask::Union),
        ("touching, nearer", contact + 0.01 * Vec3::Z, floor, Ask::Union),
        ("touching, beyond the thin end", contact - 1.2 * line + 0.03 * Vec3::Z, floor, Ask::All),
    ] {
        let at = (position, normal.normalize());
        let outwards = Vec3::Z.reject_from_normalized(at.1).normalize();
        assert_lit(why, &scene, at, outwards, ask, lit(at));
    }
    assert_lit("the point of contact", &scene, (contact, floor), Vec3::Z, Ask::Surface, PI);
}

#[test]
fn a_patch_lights_as_the_closed_form_of_its_outline_says() {
    let floats = |corners: [[f32; 3]; 4]| corners.map(|c| Vec3::from(c).as_dvec3());
    let above = [[-0.5, 0.0, -0.4], [0.6, 0.2, -0.5], [0.5, -0.1, 0.5], [-0.4, 0.3, 0.6]];
    let standing = [[-0.5, 0.0, 0.0], [0.6, 0.0, 0.0], [0.5, 0.9, -0.13], [-0.4, 0.8, -0.1]];
    let on_a_corner = [[0.0, 0.0, 0.0], [0.6, 0.4, 0.0], [0.2, 0.9, -0.05], [-0.4, 0.3, -0.05]];
    for (why, corners, position, normal) in [
        ("near", above, [0.1, -0.4, 0.2], [0.1, 1.0, 0.0]),
        ("far", above, [3.0, -20.0, 1.0], [0.0, 1.0, 0.0]),
        ("partly below the horizon", above, [0.2, -1.5, 0.1], [0.9, 0.1, 0.0]),
        ("near, partly below the horizon", above, [0.0, -0.2, 0.1], [1.0, 0.2, 0.0]),
        ("an edge touches", standing, [0.1, 0.0, 0.1], [0.0, 1.0, 0.0]),
        ("an edge touches, nearer", standing, [0.1, 0.0, 0.02], [0.0, 1.0, 0.0]),
        ("a corner touches", on_a_corner, [0.0, 0.0, 0.05], [0.0, 1.0, 0.0]),
    ] {
        let scene = shining(Elements::Quads(vec![[0, 1, 2, 3]]), Method::Enhanced, &corners, &[]);
        let at = (Vec3::from(position), Vec3::from(normal).normalize());
        let [p00, p10, p11, p01] = floats(corners);
        // If all of the patch faces the eye with one side, it covers the same directions as its
        // outline.
        let eye = at.0.as_dvec3();
        let seen = |i: u32, j: u32| {
            let (u, v) = (f64::from(i) / 32.0, f64::from(j) / 32.0);
            let cross = (p10 - p00).lerp(p11 - p01, v).cross((p01 - p00).lerp(p11 - p10, u));
            cross.dot(p00.lerp(p10, u).lerp(p01.lerp(p11, u), v) - eye) > 0.0
        };
        let side = seen(0, 0);
        assert!(
            (0..=32).all(|i| (0..=32).all(|j| seen(i, j) == side)),
            "{why}: both sides are seen"
        );
        let outwards = Vec3::Z.reject_from_normalized(at.1).normalize();
        let expected = lambert(&floats(corners), eye, at.1.as_dvec3());
        assert_lit(why, &scene, at, outwards, Ask::All, expected);
    }
}

/// Integrates the irradiance from a convex surface `(position, normal, area)` over the unit square
/// by the midpoint rule, with smaller steps towards `focus`.
fn integrated(
    (position, normal): Receiver,
    focus: [f64; 2],
    surface: impl Fn(f64, f64) -> (DVec3, DVec3, f64),
) -> f64 {
    const STEPS: u32 = 400;
    let (at, up) = (position.as_dvec3(), normal.as_dvec3());
    // Positions and weights on both sides of the focus, with cubic spacing.
    let [columns, rows] = focus.map(|focus| {
        let side = move |length: f64| {
            (0..STEPS).map(move |k| {
                let t = (f64::from(k) + 0.5) / f64::from(STEPS);
                (focus + length * t * t * t, length.abs() * 3.0 * t * t / f64::from(STEPS))
            })
        };
        side(-focus).chain(side(1.0 - focus)).collect::<Vec<_>>()
    });
    let mut sum = 0.0;
    for &(u, width) in &columns {
        for &(v, height) in &rows {
            let (q, n, area) = surface(u, v);
            let to = q - at;
            let [arriving, leaving] = [up.dot(to), -n.dot(to)].map(|x| x.max(0.0));
            sum += width * height * area * arriving * leaving / to.length_squared().powi(2);
        }
    }
    sum
}

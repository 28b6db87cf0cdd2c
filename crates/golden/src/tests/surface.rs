//! Faults of single rays: without noise, each one is found.

use super::{case, reference};
use crate::case::of_folder;
use crate::check::{Check, Finding};
use crate::probe::Probe;
use crate::subject::{Plan, Subject};
use crate::surface::Surface;
use glam::{Vec2, Vec3};
use rotund_bvh::Isa;
use rotund_scene::{Elements, Scene};
use rotund_trace::Sequence;

/// Results of all rays of a picture, so that a fault can be planted in one of them.
struct Rays {
    width: usize,
    height: usize,
    /// Sixteen per pixel.
    probes: Vec<Probe>,
}

impl Rays {
    fn of(name: &str) -> Self {
        let Surface { width, height, .. } = reference(name).surface;
        let subject = Subject::new(name, case(name).load().unwrap(), Isa::default_set()).unwrap();
        let probes = std::sync::Mutex::new(vec![Probe::default(); 16 * width * height]);
        Surface::measure(width, height, |uv, ray| {
            let probe = subject.probe(uv, ray);
            probes.lock().unwrap()[index(uv, ray, width, height)] = probe;
            probe
        });
        Self { width, height, probes: probes.into_inner().unwrap() }
    }

    /// Returns the findings with a fault in one ray.
    fn with_fault(&self, name: &str, at: usize, fault: impl Fn(&mut Probe) + Sync) -> Vec<Finding> {
        let surface = Surface::measure(self.width, self.height, |uv, ray| {
            let i = index(uv, ray, self.width, self.height);
            let mut probe = self.probes[i];
            if i == at {
                fault(&mut probe);
            }
            probe
        });
        surface.compare(&reference(name).surface)
    }
}

fn index(uv: Vec2, ray: usize, width: usize, height: usize) -> usize {
    let (x, y) = ((uv.x * width as f32) as usize, (uv.y * height as f32) as usize);
    16 * (y * width + x) + ray
}

/// Returns the findings in a modified scene.
fn tampered(name: &str, tamper: impl FnOnce(&mut Scene)) -> Vec<Finding> {
    let expected = reference(name).surface;
    let mut scene = case(name).load().unwrap();
    tamper(&mut scene);
    let subject = Subject::new(name, scene, Isa::default_set()).unwrap();
    subject.surface(expected.width as u32, expected.height as u32).compare(&expected)
}

#[track_caller]
fn assert_caught(findings: &[Finding], check: Check, words: &str) {
    let named = |finding: &Finding| finding.check == check && finding.text.contains(words);
    assert!(findings.iter().any(named), "no {check} with {words:?} in {findings:?}");
}

#[test]
fn one_ray_that_goes_wrong_is_caught_in_any_pixel_of_every_kind_of_picture() {
    type Fault = fn(&mut Probe);
    let faults: [(&str, Check, Fault); 7] = [
        ("leaks", Check::Coverage, |probe| *probe = Probe::default()),
        ("leaks behind the first surface", Check::Crossings, |probe| probe.crossings -= 1),
        ("meets a surface twice", Check::Crossings, |probe| probe.crossings += 1),
        ("casts the other shadow", Check::Shadow, |probe| probe.escapes ^= true),
        ("has its normal flipped", Check::Normal, |probe| probe.normal = -probe.normal),
        ("has its texture shifted by a sixteenth", Check::Texcoord, |probe| {
            probe.texcoord.x += 1.0 / 16.0;
        }),
        ("has another colour", Check::Color, |probe| probe.color.y += 0.1),
    ];
    for name in
        ["points-enhanced", "lines-enhanced", "quads-enhanced", "triangles", "glass-vanilla"]
    {
        let rays = Rays::of(name);
        let hits: Vec<usize> =
            (0..rays.probes.len()).filter(|&i| rays.probes[i].crossings > 0).collect();
        for (number, (why, check, fault)) in faults.into_iter().enumerate() {
            // Each fault is in another ray and pixel.
            let at = hits[hits.len() * (2 * number + 1) / (2 * faults.len())];
            let (x, y) = (at / 16 % rays.width, at / 16 / rays.width);
            let findings = rays.with_fault(name, at, fault);
            assert_caught(&findings, check, &format!("pixel ({x}, {y})"));
            let only = findings.iter().all(|finding| finding.text.ends_with("so in 1 pixels"));
            assert!(only, "{name}, a ray {why}: {findings:?}");
        }
        assert!(rays.with_fault(name, usize::MAX, |_| {}).is_empty(), "{name} without a fault");
    }
}

#[test]
fn a_hole_of_one_ray_is_caught_in_every_pixel_that_has_a_surface() {
    let expected = reference("quads-enhanced").surface;
    for i in (0..expected.planes[0].len()).filter(|&i| expected.planes[0][i] > 0.0) {
        let mut leaky = expected.clone();
        leaky.planes[0][i] -= 1.0 / 16.0;
        assert!(leaky.differs_at(&expected, i), "pixel {i}");
    }
}

#[test]
fn one_flipped_vertex_normal_is_caught() {
    let findings = tampered("quads-enhanced", |scene| {
        let saddle = scene.shapes.iter_mut().find(|shape| !shape.normals.is_empty()).unwrap();
        let middle = saddle.normals.len() / 2;
        saddle.normals[middle] = -saddle.normals[middle];
    });
    assert_caught(&findings, Check::Normal, "pixel");
    assert!(findings.iter().all(|finding| finding.check == Check::Normal), "{findings:?}");
}

#[test]
fn texture_coordinates_shifted_by_a_sixteenth_of_a_texel_are_caught() {
    for name in ["triangles", "quads-vanilla", "quads-enhanced"] {
        let findings = tampered(name, |scene| {
            for shape in &mut scene.shapes {
                shape.texcoords.iter_mut().for_each(|texcoord| texcoord.x += 1.0 / 256.0);
            }
        });
        assert_caught(&findings, Check::Texcoord, "pixel");
    }
}

#[test]
fn a_shape_that_is_a_hundredth_too_small_or_elsewhere_is_caught() {
    let smaller = tampered("points-vanilla", |scene| {
        scene.shapes.iter_mut().flat_map(|shape| &mut shape.radii).for_each(|r| *r *= 0.99);
    });
    assert_caught(&smaller, Check::Coverage, "pixel");
    let nearer = tampered("orthographic-enhanced", |scene| {
        let view = scene.cameras[0].world_from_camera.matrix3.z_axis;
        scene.instances.iter_mut().for_each(|i| i.world_from_object.translation += 0.01 * view);
    });
    assert_caught(&nearer, Check::Depth, "pixel");
}

#[test]
fn a_missing_quad_is_caught() {
    let findings = tampered("glass-enhanced", |scene| {
        let shape = scene.shapes.iter_mut().find(|shape| shape.name == "bulging-box").unwrap();
        let Elements::Quads(quads) = &mut shape.elements else { panic!("a box of quads") };
        quads.pop();
    });
    assert_caught(&findings, Check::Crossings, "pixel");
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    for case in of_folder(&super::folder()).unwrap() {
        let mut pictures = Vec::new();
        for isa in Isa::available() {
            let subject = Subject::new(&case.name, case.load().unwrap(), isa).unwrap();
            let (width, height) = subject.scene.cameras[0].resolution(48);
            let sequence = Sequence::Sobol;
            let plan = Plan { width, height, bounces: 8, samples: 2, sequence };
            let light = subject.measure(&plan, 1, 5).unwrap();
            pictures.push((isa, light, subject.surface(width, height)));
        }
        let (_, light, surface) = &pictures[0];
        assert!(surface.planes[0].iter().any(|&coverage| coverage > 0.0), "{}", case.name);
        for (isa, other_light, other_surface) in &pictures[1..] {
            assert!(light == other_light, "{}: light by {isa:?}", case.name);
            assert!(surface == other_surface, "{}: surface by {isa:?}", case.name);
        }
    }
}

#[test]
fn a_ray_that_leaves_a_surface_does_not_meet_it_again() {
    // One ball in front of the camera: each ray enters and leaves it.
    let name = "materials-enhanced";
    let subject = Subject::new(name, case(name).load().unwrap(), Isa::default_set()).unwrap();
    let ball = subject.scene.instances[1].world_from_object.translation;
    let camera = subject.scene.cameras[0].world_from_camera;
    let to_ball = camera.inverse().transform_point3(ball.into());
    let film = Vec2::new(to_ball.x, -to_ball.y) / -to_ball.z * subject.scene.cameras[0].lens;
    let size =
        Vec2::new(1.0, 1.0 / subject.scene.cameras[0].aspect) * subject.scene.cameras[0].film;
    let probe = subject.probe(film / size + 0.5, 0);
    // Two walls of the ball, and the floor behind it.
    assert_eq!(probe.crossings, 3, "{probe:?}");
    assert!(probe.normal.distance(Vec3::ZERO) > 0.999, "{probe:?}");
}

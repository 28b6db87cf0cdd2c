//! The scenes that trees are built over: a generated one, or the shapes of a file.

use super::bodies::{self, Body};
use super::measure::{Subject, measure};
use super::progress::Progress;
use super::recipe::{self, Target};
use super::shoot::Primitive;
use super::{Args, Load, Sheet, memory};
use anyhow::{Result, ensure};
use rotund_bvh::MAX_PRIMITIVES;
use rotund_geometry::glam::Vec3;
use rotund_geometry::{BilinearPatch, RoundedCone, Sphere, Triangle};
use rotund_report::console::say;
use rotund_scene::{Elements, LoadOptions, Shape, load_bytes};

const MILLION: usize = 1_000_000;

/// Generates or loads the scene, and measures each of its trees.
pub(super) fn measure_all(
    name: &str,
    args: &Args,
    load: Load<'_>,
    sheets: &mut Vec<Sheet>,
) -> Result<()> {
    let recipe = Subject { name, known_to_peer: true };
    match name {
        "spheres-1M" => {
            let (spheres, hash) = recipe::spheres(MILLION, 1, 0.002);
            check(name, hash, 0x0915_ef57_9e5f_da21)?;
            sheets.extend(solids(&recipe, &spheres, &Target::UNIT, args)?);
        }
        "spheres-10M" => {
            let (spheres, hash) = recipe::spheres(10 * MILLION, 11, 0.000_928_317_8);
            check(name, hash, 0x7d1d_4cee_a667_c619)?;
            sheets.extend(solids(&recipe, &spheres, &Target::UNIT, args)?);
        }
        "cones-1M" => {
            let (cones, hash) = recipe::cones(50_000);
            check(name, hash, 0x8990_b660_83f1_cf0c)?;
            sheets.extend(solids(&recipe, &cones, &Target::UNIT, args)?);
        }
        "patches-1M" => {
            let (patches, hash) = recipe::patches(1000);
            check(name, hash, 0x1613_fb93_455e_a7e8)?;
            let corners = patches.iter().flat_map(|p| [p.p00, p.p10, p.p11, p.p01]);
            sheets.extend(surfaces(&recipe, &patches, &Target::around(corners), args)?);
        }
        "triangles-1M" => {
            let (triangles, hash) = recipe::triangles(1000);
            check(name, hash, 0xe700_bba1_7a89_c000)?;
            let corners = triangles.iter().flat_map(|t| [t.p0, t.p1, t.p2]);
            sheets.extend(surfaces(&recipe, &triangles, &Target::around(corners), args)?);
        }
        "tracts-218K" | "vessels-4K" => {
            let cones = tubes(name)?;
            let vertices = cones.iter().flat_map(|cone| [cone.p0, cone.p1]);
            let recipe = Subject { known_to_peer: false, ..recipe };
            sheets.extend(solids(&recipe, &cones, &Target::around(vertices), args)?);
        }
        _ => match name.strip_prefix("spheres-").and_then(|rest| rest.strip_suffix('M')) {
            Some(millions) => sheets.extend(many_spheres(name, millions, args)?),
            None => {
                let (scene_name, scene) = load(name)?;
                // A lone shape has the name of its file; the ground below it is not measured.
                let lone = scene.shapes.iter().any(|shape| shape.name == scene_name);
                for (index, shape) in scene.shapes.iter().enumerate() {
                    if !lone || shape.name == scene_name {
                        sheets.extend(shape_sheet(&scene_name, index, shape, args)?);
                    }
                }
            }
        },
    }
    Ok(())
}

/// Measures closest hits and occlusion, or crossings if `args` asks for them.
fn solids<P: Primitive<Tree: Body>>(
    subject: &Subject<'_>,
    solids: &[P],
    target: &Target,
    args: &Args,
) -> Result<Option<Sheet>> {
    if args.crossings {
        bodies::measure(subject, solids, target, args)?;
        return Ok(None);
    }
    measure(subject, solids, target, args)
}

/// Measures closest hits and occlusion of primitives that have no inside.
fn surfaces<P: Primitive>(
    subject: &Subject<'_>,
    primitives: &[P],
    target: &Target,
    args: &Args,
) -> Result<Option<Sheet>> {
    if args.crossings {
        say(format!("{}: skipped: triangles and quads have no inside to enter", subject.name))?;
        return Ok(None);
    }
    measure(subject, primitives, target, args)
}

/// Returns all lines of a generated scene of tubes as one body.
fn tubes(name: &str) -> Result<Vec<RoundedCone>> {
    let json = match name {
        "tracts-218K" => include_bytes!("tracts.json").as_slice(),
        _ => include_bytes!("vessels.json"),
    };
    let no_files = |_: &str| None;
    let scene = load_bytes(format!("{name}.json"), json, &no_files, &LoadOptions::default())?.scene;
    let cones = scene.shapes.iter().flat_map(|shape| {
        let vertex = |v: u32| (shape.positions[v as usize], shape.radii[v as usize]);
        let Elements::Lines(lines) = &shape.elements else { return Vec::new() };
        let cone = |&[a, b]: &[u32; 2]| {
            let ((p0, r0), (p1, r1)) = (vertex(a), vertex(b));
            RoundedCone { p0, r0, p1, r1 }
        };
        lines.iter().map(cone).collect()
    });
    Ok(cones.collect())
}

fn check(name: &str, hash: u64, expected: u64) -> Result<()> {
    ensure!(hash == expected, "{name} has the hash {hash:016x} and not {expected:016x}");
    Ok(())
}

/// Measures as many million spheres as given, which fill the same volume as `spheres-1M`.
fn many_spheres(name: &str, millions: &str, args: &Args) -> Result<Option<Sheet>> {
    let count = millions.parse::<usize>().ok().and_then(|n| n.checked_mul(MILLION)).unwrap_or(0);
    ensure!(count > 0, "{name}: a whole number of millions was expected, as in spheres-100M");
    ensure!(
        count <= MAX_PRIMITIVES,
        "{name}: a tree holds at most {MAX_PRIMITIVES} primitives, whose numbers have 31 bits"
    );
    // 16 bytes are the sphere itself; the others are the peak that `measure` reports.
    let needed = 110.0 * count as f64 * memory::GIB_PER_BYTE;
    if let Some(free) = memory::free_gib() {
        ensure!(
            needed < free,
            "{name} needs about {needed:.0} GiB, and {free:.0} GiB are free: take fewer spheres"
        );
    }
    let base = 0.002 / (count as f32 / MILLION as f32).cbrt();
    let progress = Progress::new(name, count);
    progress.stage("drawing the spheres");
    let (spheres, _) = recipe::spheres(count, 1, base);
    drop(progress);
    solids(&Subject { name, known_to_peer: false }, &spheres, &Target::UNIT, args)
}

/// Measures a shape of a scene file, in its own space.
fn shape_sheet(scene: &str, index: usize, shape: &Shape, args: &Args) -> Result<Option<Sheet>> {
    let at = |vertex: u32| shape.positions[vertex as usize];
    let radius = |vertex: u32| shape.radii.get(vertex as usize).copied().unwrap_or(0.001);
    // The box of a single point is that of its ball.
    let centers = Target::around(shape.positions.iter().copied());
    let spread = |p: Vec3| [p - Vec3::splat(radius(0)), p + Vec3::splat(radius(0))];
    let target = match shape.positions.first() {
        Some(&first) if !centers.has_volume() => Target::around(spread(first).into_iter()),
        _ => centers,
    };
    let name = match shape.name.as_str() {
        "" => format!("{scene} {index}"),
        name if name == scene => scene.to_owned(),
        name => format!("{scene} {name}"),
    };
    let subject = Subject { name: &name, known_to_peer: false };
    if !target.has_volume() {
        say(format!("{name}: skipped: it has no vertices, or all of them at one point"))?;
        return Ok(None);
    }
    match &shape.elements {
        Elements::Points(count) => {
            let sphere = |v| Sphere { center: at(v), radius: radius(v) };
            let spheres: Vec<Sphere> = (0..*count).map(sphere).collect();
            solids(&subject, &spheres, &target, args)
        }
        Elements::Lines(lines) => {
            let cone = |&[a, b]: &[u32; 2]| RoundedCone {
                p0: at(a),
                r0: radius(a),
                p1: at(b),
                r1: radius(b),
            };
            let cones: Vec<RoundedCone> = lines.iter().map(cone).collect();
            solids(&subject, &cones, &target, args)
        }
        Elements::Triangles(triangles) => {
            let triangle = |t: &[u32; 3]| Triangle { p0: at(t[0]), p1: at(t[1]), p2: at(t[2]) };
            let triangles: Vec<Triangle> = triangles.iter().map(triangle).collect();
            surfaces(&subject, &triangles, &target, args)
        }
        Elements::Quads(quads) => {
            let patch = |q: &[u32; 4]| {
                let [p00, p10, p11, p01] = q.map(at);
                BilinearPatch { p00, p10, p01, p11 }
            };
            let patches: Vec<BilinearPatch> = quads.iter().map(patch).collect();
            surfaces(&subject, &patches, &target, args)
        }
    }
}

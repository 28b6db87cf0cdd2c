//! A molecule from arrays: atoms as spheres, bonds as rounded cones.
//!
//! ```text
//! cargo run --release -p rotund-trace --example ethanol
//! ```

use rotund_trace::scene::geometry::glam::{Vec3, Vec4};
use rotund_trace::scene::{Camera, Environment, Material, MaterialKind, Scene, Shape};
use rotund_trace::{Options, World, output};

/// An atom: chemical element, and position in ångström.
pub(crate) type Atom = (&'static str, [f32; 3]);

/// Ethanol. The positions are one conformation, with bonds of the usual lengths.
pub(crate) const ETHANOL: [Atom; 9] = [
    ("C", [1.17, -0.40, 0.00]),
    ("C", [-0.05, 0.54, 0.00]),
    ("O", [-1.23, -0.27, 0.00]),
    ("H", [-1.97, 0.34, 0.00]),
    ("H", [2.09, 0.19, 0.00]),
    ("H", [1.17, -1.04, 0.89]),
    ("H", [1.17, -1.04, -0.89]),
    ("H", [-0.03, 1.18, 0.88]),
    ("H", [-0.03, 1.18, -0.88]),
];

/// Makes a scene of atoms, with a bond between each two that are near enough.
pub(crate) fn molecule(atoms: &[Atom]) -> Scene {
    let positions: Vec<Vec3> = atoms.iter().map(|&(_, position)| position.into()).collect();
    let radii: Vec<f32> = atoms.iter().map(|&(element, _)| radius(element)).collect();
    let colors: Vec<Vec4> = atoms.iter().map(|&(element, _)| color(element).extend(1.0)).collect();
    let count = atoms.len() as u32;
    let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
    let bonds: Vec<[u32; 2]> = pairs
        .filter(|&[a, b]| {
            let (a, b) = (a as usize, b as usize);
            positions[a].distance(positions[b]) < 2.2 * (radii[a] + radii[b])
        })
        .collect();

    let eye = Vec3::new(1.5, 1.5, 8.0);
    let mut scene = Scene {
        cameras: vec![Camera::look_at(eye, Vec3::ZERO, Vec3::Y)],
        environments: vec![Environment { emission: Vec3::ONE, ..Environment::default() }],
        ..Scene::default()
    };
    let glossy = Material { kind: MaterialKind::Glossy, color: Vec3::ONE, ..Material::default() };
    let glossy = Material { roughness: 0.3, ..glossy };
    scene.add(Shape { colors: colors.clone(), ..Shape::points(positions.clone(), radii) }, glossy);
    // A bond has the colours of its atoms, and runs between their centers.
    let matte = Material { color: Vec3::ONE, ..Material::default() };
    scene.add(Shape { colors, ..Shape::lines(positions, 0.12, bonds) }, matte);
    scene
}

fn radius(element: &str) -> f32 {
    if element == "H" { 0.25 } else { 0.4 }
}

fn color(element: &str) -> Vec3 {
    match element {
        "C" => Vec3::splat(0.1),
        "O" => Vec3::new(0.8, 0.05, 0.05),
        "N" => Vec3::new(0.1, 0.2, 0.8),
        _ => Vec3::splat(0.8),
    }
}

#[allow(dead_code, reason = "the test of the examples calls what main calls")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = molecule(&ETHANOL);
    let film = World::new(&scene)?.render(0, &Options::default())?;
    Ok(output::write("ethanol.png", &film)?)
}

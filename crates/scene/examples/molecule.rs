//! A molecule from arrays: atoms are spheres, bonds are rounded cones between them. Rays pick an
//! atom or a bond, and a mistake in the arrays is reported as an error that names it.

use rotund_scene::geometry::{
    Ray,
    glam::{Vec3, Vec4},
};
use rotund_scene::{Elements, Material, MaterialKind, Scene, SceneError, Shape, Trees};

/// Element, position in ångströms.
const ETHANOL: [(char, [f32; 3]); 9] = [
    ('C', [-1.19, -0.26, 0.0]),
    ('C', [0.0, 0.64, 0.0]),
    ('O', [1.19, -0.14, 0.0]),
    ('H', [-2.11, 0.33, 0.0]),
    ('H', [-1.17, -0.90, 0.89]),
    ('H', [-1.17, -0.90, -0.89]),
    ('H', [0.02, 1.28, 0.89]),
    ('H', [0.02, 1.28, -0.89]),
    ('H', [1.95, 0.46, 0.0]),
];

/// Pairs of atoms.
const BONDS: [[u32; 2]; 8] = [[0, 1], [1, 2], [0, 3], [0, 4], [0, 5], [1, 6], [1, 7], [2, 8]];

/// A scene of two shapes: instance 0 holds the atoms, instance 1 the bonds. Their elements are
/// numbered as in the arrays.
fn molecule(atoms: &[(char, [f32; 3])], bonds: &[[u32; 2]]) -> Scene {
    let positions: Vec<Vec3> = atoms.iter().map(|&(_, position)| position.into()).collect();
    let look = |&(element, _): &(char, _)| match element {
        'C' => (0.35, Vec4::new(0.1, 0.1, 0.1, 1.0)),
        'O' => (0.33, Vec4::new(0.8, 0.05, 0.05, 1.0)),
        _ => (0.25, Vec4::new(0.9, 0.9, 0.9, 1.0)),
    };
    let (radii, colors): (Vec<f32>, Vec<Vec4>) = atoms.iter().map(look).unzip();
    let named = |name: &str, shape: Shape| Shape {
        name: name.to_owned(),
        // A bond has the color of the atom at each end, and changes along its axis.
        colors: colors.clone(),
        ..shape
    };
    // Vertex colors scale the color of the material, so that one is white.
    let plastic = Material {
        kind: MaterialKind::Glossy,
        color: Vec3::ONE,
        roughness: 0.2,
        ..Material::default()
    };
    let mut scene = Scene::default();
    scene.add(named("atoms", Shape::points(positions.clone(), radii)), plastic.clone());
    scene.add(named("bonds", Shape::lines(positions, 0.12, bonds)), plastic);
    scene
}

pub(crate) fn main() {
    let scene = molecule(&ETHANOL, &BONDS);
    // `Trees::build` validates first: what rays and shading rely on holds from here on.
    let trees = Trees::build(&scene).expect("the arrays belong together");

    // Pick the oxygen from above, and the bond between the carbons through its middle.
    let pick = |x: f32, y: f32| {
        trees.closest(&scene, &Ray::new(Vec3::new(x, y, 10.0), Vec3::NEG_Z)).expect("aimed at it")
    };
    let atom = pick(1.19, -0.14);
    assert_eq!((atom.instance, atom.element), (0, 2));
    assert!((atom.position.z - 0.33).abs() < 1e-6, "its radius above the plane");
    let bond = pick(-0.595, 0.19);
    assert_eq!((bond.instance, bond.element), (1, 0));

    // The middle of the C-O bond has the mean of both colors.
    let bond = pick(0.595, 0.25);
    let color = scene.eval_material(bond.instance, bond.element, bond.uv).color;
    assert_eq!((bond.instance, bond.element), (1, 1));
    assert!((color.x - 0.45).abs() < 0.01, "{color}");

    // A bond to an atom that does not exist.
    let error =
        Trees::build(&molecule(&ETHANOL, &[[0, 1], [8, 9]])).expect_err("there is no atom 9");
    let text = "shapes[1] \"bonds\": lines[1] names vertex 9, but the shape has 9 positions";
    assert_eq!(error.to_string(), text);
    assert!(matches!(error, SceneError::VertexOutOfRange { element: 1, vertex: 9, .. }));

    // More atoms than positions.
    let mut scene = scene;
    scene.shapes[0].elements = Elements::Points(10);
    let error = scene.validate().expect_err("ten atoms at nine positions");
    assert_eq!(error.to_string(), "shapes[0] \"atoms\": has 10 points, but only 9 positions");
}

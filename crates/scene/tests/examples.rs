//! Runs the examples, which check their results by assertions.

#[path = "../examples/hair.rs"]
mod hair;
#[path = "../examples/molecule.rs"]
mod molecule;

#[test]
fn hair_has_tangents_and_texture_coordinates_along_its_strands() {
    hair::main();
}

#[test]
fn a_molecule_is_validated_and_picked() {
    molecule::main();
}

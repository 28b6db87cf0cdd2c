//! Runs the examples, which check their results by assertions.

#[path = "../examples/capsules.rs"]
mod capsules;
#[path = "../examples/torus.rs"]
mod torus;

#[test]
fn a_swarm_of_capsules_is_refitted_and_picked() {
    capsules::main();
}

#[test]
fn a_chain_of_tori_is_picked() {
    torus::main();
}

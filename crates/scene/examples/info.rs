//! Lists the shapes of scene files: `cargo run --example info -- scenes/shapes4.json`.

use rotund_scene::{LoadOptions, load};

#[expect(clippy::print_stdout, reason = "an example is here to be seen")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args().skip(1) {
        let loaded = load(&path, &LoadOptions::default())?;
        println!("{path}");
        for shape in &loaded.scene.shapes {
            let kind = shape.elements.kind();
            println!(
                "  {:16} {:7} {kind:?}, {:?}",
                shape.name,
                shape.elements.count(),
                shape.method
            );
        }
        for warning in loaded.warnings {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}

//! `info <scene>`: what a scene holds, without rendering it.

use crate::console::{Table, say};
use crate::scene_source::{LoadArgs, load};
use anyhow::Result;
use rotund_scene::{ElementKind, Method, Shape};

const EXAMPLES: &str = "\
Examples:
  cargo xtask info shapes4
  cargo xtask info path/to/scene.json";

/// Options of `info`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The name of a scene in `scenes/`, or the path of a JSON, PLY or OBJ file.
    scene: String,
    #[command(flatten)]
    loading: LoadArgs,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let loaded = load(&args.scene, &args.loading)?;
    let scene = &loaded.scene;
    say(format!(
        "{}: {} environments, {} textures, {} materials, {} instances",
        loaded.name,
        scene.environments.len(),
        scene.textures.len(),
        scene.materials.len(),
        scene.instances.len()
    ))?;

    let mut cameras = Table::new(&["camera", "kind", "width / height", "aperture"]);
    for camera in &scene.cameras {
        let kind = if camera.orthographic { "orthographic" } else { "perspective" };
        let [aspect, aperture] =
            [camera.aspect, camera.aperture].map(|value| format!("{value:.3}"));
        cameras.row([camera.name.clone(), kind.to_owned(), aspect, aperture]);
    }
    say(format!("\n{cameras}"))?;

    let mut shapes = Table::new(&["shape", "kind", "method", "elements", "vertices", "placed"]);
    for (index, shape) in scene.shapes.iter().enumerate() {
        let placed = scene.instances.iter().filter(|instance| instance.shape as usize == index);
        shapes.row([
            shape.name.clone(),
            kind(shape).to_owned(),
            method(shape).to_owned(),
            shape.elements.count().to_string(),
            shape.positions.len().to_string(),
            placed.count().to_string(),
        ]);
    }
    say(format!("\n{shapes}"))
}

fn kind(shape: &Shape) -> &'static str {
    match shape.elements.kind() {
        ElementKind::Points => "points",
        ElementKind::Lines => "lines",
        ElementKind::Triangles => "triangles",
        ElementKind::Quads => "quads",
    }
}

fn method(shape: &Shape) -> &'static str {
    match (shape.elements.kind(), shape.method) {
        (ElementKind::Triangles, _) => "",
        (_, Method::Vanilla) => "vanilla",
        (_, Method::Enhanced) => "enhanced",
    }
}

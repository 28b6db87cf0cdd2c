//! `moved <scene>`: does a picture stay the same where the world is far away, tiny or huge?
//!
//! Renders the enhanced picture of a scene as it is; then with everything moved away from the origin,
//! and with everything modelled in other units, camera included, so that the pictures should be the
//! same. What is left is rounding: positions in single precision have 24 bits, so at 10 km from the
//! origin they are a multiple of a millimeter. To tell it from noise, the picture with another seed
//! is held against the first as well.

use anyhow::{Result, bail};
use glam::{DAffine3, DVec3};
use rotund::{Cancelled, PictureArgs, enhance, prepare_folder, take, write_text};
use rotund_image::{Difference, Image, Metrics};
use rotund_report::console::{Table, say};
use rotund_scene::Scene;
use serde_json::json;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  cargo xtask moved shapes4
  cargo xtask moved shapes4 --camera front --offset 1e4,1e5 --scale 0.001,1000";

/// Options of `moved`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The name of a scene in `scenes/`, or the path of a JSON, PLY or OBJ file.
    scene: String,
    /// How far everything is moved along x, y and z, in meters: cameras and instances.
    #[arg(long, value_name = "METERS", value_delimiter = ',', default_value = "1e4")]
    offset: Vec<f64>,
    /// How much larger everything is: vertices, radii, frames, cameras and depths inside materials.
    #[arg(long, value_name = "FACTORS", value_delimiter = ',', default_value = "1e-3,1e3")]
    scale: Vec<f64>,
    /// The folder to write to; `out/`, the name of the scene and `-moved` if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the content of `metrics.json` instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    picture: PictureArgs,
}

/// A picture that should be the same.
struct Variant {
    name: String,
    scene: Scene,
    seed: u64,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let (mut source, camera, options) = args.picture.load(&args.scene)?;
    let folder = args.out.unwrap_or_else(|| Path::new("out").join(source.name.clone() + "-moved"));
    prepare_folder(&folder)?;
    enhance(&mut source.scene, &args.picture.kinds.kinds());
    let scene = source.scene;

    let seed = options.seed;
    let mut variants =
        vec![Variant { name: "another-seed".into(), scene: scene.clone(), seed: seed ^ 1 << 63 }];
    for &offset in &args.offset {
        let scene = place(&scene, 1.0, DVec3::splat(offset));
        variants.push(Variant { name: format!("offset-{offset}"), scene, seed });
    }
    for &scale in &args.scale {
        let scene = place(&scene, scale, DVec3::ZERO);
        variants.push(Variant { name: format!("scale-{scale}"), scene, seed });
    }

    let picture = |scene: &Scene, seed, label: &str| -> Result<Image> {
        let options = rotund_trace::Options { seed, ..options.clone() };
        let shot = args.picture.shot.with_threads(|| take(scene, camera, &options, label))?;
        if shot.interrupted {
            bail!(Cancelled(format!("{} holds the pictures before {label}", folder.display())));
        }
        rotund_trace::output::write(folder.join(format!("{label}.png")), &shot.film)?;
        Ok(shot.film.image())
    };
    let base = picture(&scene, seed, "as-it-is")?;
    let mut rows: Vec<(String, Metrics)> = Vec::new();
    for Variant { name, scene, seed } in variants {
        let difference = Difference::between(&picture(&scene, seed, &name)?, &base)?;
        difference.flip_map().write(folder.join(format!("{name}-flip.png")))?;
        rows.push((name, difference.metrics));
    }

    let metrics: serde_json::Map<_, _> =
        rows.iter().map(|(name, metrics)| (name.clone(), json!(metrics))).collect();
    let metrics = serde_json::to_string_pretty(&metrics)?;
    write_text(&folder.join("metrics.json"), &(metrics.clone() + "\n"))?;
    if args.json { say(metrics) } else { say(table(&rows).to_string()) }
}

fn table(rows: &[(String, Metrics)]) -> Table {
    let mut table =
        Table::new(&["against as-it-is", "light", "rel_mse", "flip_mean", "changed_fraction"]);
    for (name, m) in rows {
        table.row([
            name.clone(),
            format!("{:.5}", m.luminance_ratio),
            format!("{:.6}", m.rel_mse),
            format!("{:.5}", m.flip_mean),
            format!("{:.4}", m.changed_fraction),
        ]);
    }
    table
}

/// The same scene, `scale` times as large in its own data, then moved by its frames.
fn place(scene: &Scene, scale: f64, offset: DVec3) -> Scene {
    let mut scene = scene.clone();
    let factor = scale as f32;
    for shape in &mut scene.shapes {
        shape.positions.iter_mut().for_each(|position| *position *= factor);
        shape.radii.iter_mut().for_each(|radius| *radius *= factor);
    }
    let frame = |frame: glam::Affine3A| {
        let frame = frame.as_daffine3();
        let translation = offset + scale * frame.translation;
        DAffine3 { translation, ..frame }.as_affine3a()
    };
    for instance in &mut scene.instances {
        instance.world_from_object = frame(instance.world_from_object);
    }
    for camera in &mut scene.cameras {
        camera.world_from_camera = frame(camera.world_from_camera);
        camera.focus *= factor;
        camera.aperture *= factor;
        if camera.orthographic {
            camera.film *= factor;
        }
    }
    scene.materials.iter_mut().for_each(|material| material.trdepth *= factor);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rotund_scene::{Camera, Material};

    #[test]
    fn everything_with_a_length_is_scaled_and_frames_carry_the_offset() {
        let camera = Camera { aperture: 0.1, focus: 2.0, ..Camera::default() };
        let material = Material { trdepth: 0.5, ..Material::default() };
        let scene = Scene { cameras: vec![camera], materials: vec![material], ..Scene::default() };
        let placed = place(&scene, 10.0, DVec3::new(1.0, 2.0, 3.0));
        let camera = &placed.cameras[0];
        assert_eq!(Vec3::from(camera.world_from_camera.translation), Vec3::new(1.0, 2.0, 3.0));
        assert_eq!((camera.aperture, camera.focus, camera.film), (1.0, 20.0, 0.036));
        assert_eq!(placed.materials[0].trdepth, 5.0);
    }
}

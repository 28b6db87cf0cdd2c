//! What decides the pixels of a render, in words and as a hash.

use crate::scene_source::NamedScene;
use rotund_scene::{Elements, Scene, Shape};
use rotund_trace::{Options, Origin, Shard};
use std::fmt;

/// Program and version, which are part of every film.
const PROGRAM: &str = concat!("rotund ", env!("CARGO_PKG_VERSION"));

/// Returns the origin of a film: the program, and scene, camera and options in words and as a hash.
pub(crate) fn origin(scene: &NamedScene, camera: usize, options: &Options) -> Origin {
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    hash.scene(&scene.scene);
    // All options but those that have fields in the header of a film.
    let decisive = Options {
        width: 0,
        height: 0,
        seed: 0,
        samples: 0,
        shard: Shard::default(),
        ..options.clone()
    };
    hash.debug(&(camera, decisive));
    let program = PROGRAM.to_owned();
    Origin { program, hash: hash.0, label: label(scene, camera, options) }
}

/// Returns scene, camera and options in words.
fn label(scene: &NamedScene, camera: usize, options: &Options) -> String {
    let camera = &scene.scene.cameras[camera].name;
    let mut label = format!("{}, camera {camera}, {} bounces", scene.name, options.bounces);
    // Options are named only if they differ from the default.
    let usual = Options::default();
    if options.sequence != usual.sequence {
        label += &format!(", {:?} numbers", options.sequence).to_lowercase();
    }
    if options.view != usual.view {
        label += &format!(", view {}", options.view);
    }
    if options.transparent {
        label += ", transparent";
    }
    if let Some(clamp) = options.clamp {
        label += &format!(", clamped to {clamp}");
    }
    label
}

/// FNV-1a over 32-bit words. It detects mistakes; it is no protection against forgery.
struct Hash(u64);

impl Hash {
    fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3);
    }

    fn floats<const N: usize>(&mut self, vectors: impl Iterator<Item = [f32; N]>) {
        vectors.for_each(|vector| vector.iter().for_each(|x| self.word(x.to_bits())));
    }

    fn words<const N: usize>(&mut self, vectors: &[[u32; N]]) {
        vectors.iter().flatten().for_each(|&word| self.word(word));
    }

    fn scene(&mut self, scene: &Scene) {
        // Every field is named, so that a new one cannot be forgotten.
        let Scene { cameras, environments, textures, materials, shapes, instances } = scene;
        for shape in shapes {
            self.shape(shape);
        }
        for texture in textures {
            self.debug(&(texture.width, texture.height));
            let places = (0..texture.height).flat_map(|y| (0..texture.width).map(move |x| (x, y)));
            self.floats(places.map(|(x, y)| texture.color_at(x, y).to_array()));
        }
        self.debug(&(cameras, materials, instances, environments));
    }

    fn shape(&mut self, shape: &Shape) {
        let Shape {
            name: _,
            method,
            overlap,
            elements,
            positions,
            normals,
            texcoords,
            colors,
            radii,
        } = shape;
        let lengths = [elements.count(), positions.len(), normals.len(), texcoords.len()];
        self.debug(&(method, overlap, elements.kind(), lengths, colors.len(), radii.len()));
        match elements {
            Elements::Points(count) => self.word(*count),
            Elements::Lines(lines) => self.words(lines),
            Elements::Triangles(triangles) => self.words(triangles),
            Elements::Quads(quads) => self.words(quads),
        }
        self.floats(positions.iter().map(|p| p.to_array()));
        self.floats(normals.iter().map(|n| n.to_array()));
        self.floats(texcoords.iter().map(|t| t.to_array()));
        self.floats(colors.iter().map(|c| c.to_array()));
        self.floats(radii.iter().map(|&r| [r]));
    }

    /// Hashes the debug text of a small value.
    fn debug(&mut self, value: &impl fmt::Debug) {
        format!("{value:?}").bytes().for_each(|byte| self.word(u32::from(byte)));
    }
}

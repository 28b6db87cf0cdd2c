//! What decides the pixels of a render, in words and as a hash.

use crate::scene_source::NamedScene;
use rotund_scene::{ElementKind, Elements, Method, Overlap, Scene, Shape};
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
    for kind in kinds(&scene.scene) {
        label += &format!(", {kind}");
    }
    // Options are named only if they differ from the default.
    let usual = Options::default();
    if options.sequence != usual.sequence {
        label += &format!(", {:?} numbers", options.sequence).to_lowercase();
    }
    if options.view != usual.view {
        label += &format!(", view {}", options.view);
    }
    if options.transparent {
        label += ", transparent background";
    }
    if !options.recenter {
        label += ", layers";
    }
    if let Some(clamp) = options.clamp {
        label += &format!(", clamped to {clamp}");
    }
    label
}

/// Describes how the kinds of elements of a scene that differ between the methods are traced; a
/// kind is there several times if its shapes differ.
fn kinds(scene: &Scene) -> Vec<String> {
    let of_shape = |shape: &Shape| {
        let (kind, method) = (shape.elements.kind(), shape.method);
        let separate = shape.overlap == Overlap::Separate && kind != ElementKind::Quads;
        (kind, method, separate)
    };
    let mut texts = Vec::new();
    for kind in [ElementKind::Points, ElementKind::Lines, ElementKind::Quads] {
        for method in Method::ALL {
            for (separate, suffix) in [(false, ""), (true, " (separate)")] {
                if scene.shapes.iter().any(|shape| of_shape(shape) == (kind, method, separate)) {
                    texts.push(format!("{kind} {method}{suffix}"));
                }
            }
        }
    }
    texts
}

/// A hash of 64 bits. A single word that differs always changes it. It detects mistakes, and is no
/// protection against forgery.
struct Hash(u64);

impl Hash {
    fn word(&mut self, word: u64) {
        // Both steps are one to one. The product spreads each bit upwards, by the golden ratio, and
        // the shift brings the upper half down again.
        let product = (self.0 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = product ^ product >> 32;
    }

    /// Hashes two numbers at a time.
    fn words(&mut self, words: &[u32]) {
        for pair in words.chunks(2) {
            let high = pair.get(1).copied().unwrap_or_default();
            self.word(u64::from(pair[0]) | u64::from(high) << 32);
        }
    }

    fn floats<const N: usize>(&mut self, vectors: impl Iterator<Item = [f32; N]>) {
        vectors.for_each(|vector| self.words(&vector.map(f32::to_bits)));
    }

    fn scene(&mut self, scene: &Scene) {
        // Every field is named, so that a new one cannot be forgotten.
        let Scene { cameras, environments, textures, materials, shapes, instances } = scene;
        for shape in shapes {
            self.shape(shape);
        }
        for texture in textures {
            self.debug(&(texture.width, texture.height));
            texture.for_each_color(|color| self.words(&color.to_array().map(f32::to_bits)));
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
            Elements::Points(count) => self.words(&[*count]),
            Elements::Lines(lines) => self.words(lines.as_flattened()),
            Elements::Triangles(triangles) => self.words(triangles.as_flattened()),
            Elements::Quads(quads) => self.words(quads.as_flattened()),
        }
        self.floats(positions.iter().map(|p| p.to_array()));
        self.floats(normals.iter().map(|n| n.to_array()));
        self.floats(texcoords.iter().map(|t| t.to_array()));
        self.floats(colors.iter().map(|c| c.to_array()));
        self.floats(radii.iter().map(|&r| [r]));
    }

    /// Hashes the debug text of a small value.
    fn debug(&mut self, value: &impl fmt::Debug) {
        format!("{value:?}").bytes().for_each(|byte| self.word(byte.into()));
    }
}

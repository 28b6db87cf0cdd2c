//! Scenes that combine what paths treat in different ways: solids that absorb and scatter, clouds,
//! surfaces that are there by chance, round and flat lamps, skies, textures, and bodies that
//! overlap. Lamps are large, so that plain paths find them.

use glam::{Affine3A, Quat, Vec2, Vec3};
use rotund_scene::{
    Camera, Elements, Environment, Material, MaterialKind, Method, Overlap, Pixels, Scene, Shape,
    Texture,
};

/// A generator of random numbers.
pub(super) struct Random(pub(super) u64);

impl Random {
    /// In `0.0..1.0`.
    pub(super) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let bits = (self.0 ^ self.0 >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd);
        (bits >> 40) as f32 / (1 << 24) as f32
    }

    pub(super) fn pair(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + self.unit() * (high - low)
    }

    fn chance(&mut self, share: f32) -> bool {
        self.unit() < share
    }

    fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f32) as usize).min(count - 1)
    }

    fn vector(&mut self, low: f32, high: f32) -> Vec3 {
        Vec3::new(self.between(low, high), self.between(low, high), self.between(low, high))
    }

    fn place(&mut self) -> Vec3 {
        self.vector(-1.0, 1.0).with_y(self.between(0.1, 1.4))
    }
}

/// A matte floor before a camera that looks down on it from `eye`.
pub(super) fn floor(eye: Vec3) -> Scene {
    let camera = Camera { lens: 0.036, ..Camera::look_at(eye, 0.4 * Vec3::Y, Vec3::Y) };
    let mut scene = Scene { cameras: vec![camera], ..Scene::default() };
    let corners = [[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]];
    let shape = Shape::quads(corners.map(Vec3::from_array), [[0, 1, 2, 3]]);
    scene.add(shape, Material { color: Vec3::new(0.8, 0.7, 0.6), ..Material::default() });
    scene
}

/// A sky, with a broad sun or of one radiance.
pub(super) fn add_sky(scene: &mut Scene, sunny: bool, turn: f32) {
    let texel = |i: usize| {
        if (36..40).contains(&i) { [12.0, 11.0, 9.0, 1.0] } else { [0.3, 0.4, 0.5, 1.0] }
    };
    let emission_tex = sunny.then_some(scene.textures.len() as u32);
    if sunny {
        let pixels = Pixels::Floats((0..128).map(texel).collect());
        scene.textures.push(Texture { name: String::new(), width: 16, height: 8, pixels });
    }
    scene.environments.push(Environment {
        world_from_environment: Affine3A::from_quat(Quat::from_rotation_y(turn)),
        emission: Vec3::ONE,
        emission_tex,
        ..Environment::default()
    });
}

/// A box whose faces point outwards.
pub(super) fn solid_box(center: Vec3, half: Vec3) -> Shape {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        center + half * Vec3::new(side(0), side(1), side(2))
    };
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Shape::quads((0..8).map(corner).collect::<Vec<_>>(), faces)
}

fn shape(random: &mut Random) -> Shape {
    let (center, size) = (random.place(), random.between(0.15, 0.6));
    let mut shape = match random.index(5) {
        0 => Shape::points([center], size),
        1 => {
            let other = center + size * random.vector(-1.0, 1.0);
            Shape::points([center, other], vec![size, random.between(0.1, 0.5)])
        }
        2 => {
            let ends = [random.place(), center, random.place()];
            let radii: Vec<f32> = (0..3).map(|_| random.between(0.05, 0.3)).collect();
            Shape::lines(ends, radii, [[0, 1], [1, 2]])
        }
        3 => solid_box(center, random.vector(0.1, 0.5)),
        _ => {
            let [a, b] = [0, 1].map(|_| size * random.vector(-1.0, 1.0));
            let opposite = center + a + b + 0.2 * random.vector(-1.0, 1.0);
            Shape::quads([center, center + a, opposite, center + b], [[0, 1, 2, 3]])
        }
    };
    let count = shape.positions.len();
    if random.chance(0.3) {
        shape.overlap = Overlap::Separate;
    }
    if let (Elements::Quads(quads), true) = (&shape.elements, random.chance(0.3)) {
        shape.texcoords = (0..count).map(|_| 2.0 * random.pair()).collect();
        if count == 8 && random.chance(0.5) {
            shape.normals = shape.positions.iter().map(|&p| p - center).collect();
        }
        if random.chance(0.5) {
            let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            shape.elements = Elements::Triangles(halves.collect());
        }
    }
    if random.chance(0.15) {
        let mut color = |_| {
            let opacity = if random.chance(0.5) { 1.0 } else { 0.6 };
            random.vector(0.3, 1.0).extend(opacity)
        };
        shape.colors = (0..count).map(&mut color).collect();
    }
    shape
}

/// The texture is the first of the scene.
fn material(random: &mut Random) -> Material {
    let kinds = [
        MaterialKind::Matte,
        MaterialKind::Glossy,
        MaterialKind::Reflective,
        MaterialKind::Refractive,
        MaterialKind::Refractive,
        MaterialKind::Refractive,
        MaterialKind::Transparent,
        MaterialKind::Volumetric,
    ];
    let kind = kinds[random.index(kinds.len())];
    let mut material = Material { kind, color: random.vector(0.2, 0.95), ..Material::default() };
    if random.chance(0.4) {
        material.roughness = random.between(0.2, 0.8);
    }
    if [MaterialKind::Refractive, MaterialKind::Volumetric].contains(&kind) {
        material.trdepth = random.between(0.1, 1.0);
        if random.chance(0.5) {
            material.albedo = random.vector(0.3, 1.0);
            material.anisotropy = random.between(-0.5, 0.7);
        }
        if random.chance(0.3) {
            material.color = Vec3::ONE;
        } else if random.chance(0.2) {
            material.color.x = 1.0;
        }
    }
    if random.chance(0.2) {
        material.opacity = random.between(0.3, 0.9);
    }
    let mut texture = || random.chance(0.1).then_some(0);
    material.color_tex = texture();
    material.roughness_tex = texture();
    material.scattering_tex = texture();
    material.normal_tex = texture();
    material.emission_tex = texture();
    if random.chance(0.1) {
        material.emission = random.vector(0.5, 1.5);
    }
    material
}

/// Returns a scene that depends on a number.
pub(super) fn scene(number: u64) -> Scene {
    let random = &mut Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(99));
    let mut scene = floor(Vec3::new(random.between(-1.0, 1.0), random.between(1.2, 2.5), 2.8));
    if random.chance(0.2) {
        scene.cameras[0].aperture = 0.2;
    }
    if random.chance(0.15) {
        scene.cameras[0] = scene.cameras[0].clone().orthographic(3.0);
    }
    let mut texel = |_| {
        let mut byte = |low: usize| (low + random.index(256 - low)) as u8;
        [byte(90), byte(90), byte(150), if byte(0) < 128 { 120 } else { 255 }]
    };
    let pixels = Pixels::Bytes((0..16).map(&mut texel).collect());
    scene.textures.push(Texture { name: String::new(), width: 4, height: 4, pixels });
    match random.index(4) {
        0 => scene.materials[0].kind = MaterialKind::Glossy,
        1 => scene.materials[0].kind = MaterialKind::Reflective,
        _ => {}
    }
    scene.materials[0].roughness = 0.5;
    for _ in 0..1 + random.index(5) {
        let (mut shape, material) = (shape(random), material(random));
        let whole = material.opacity >= 1.0
            && material.color_tex.is_none()
            && shape.colors.iter().all(|color| color.w >= 1.0);
        // Paths pass a vanilla point at its center and not where they meet it, so that a shadow ray
        // through it has another direction than the path.
        if whole && material.kind != MaterialKind::Volumetric && random.chance(0.15) {
            shape.method = Method::Vanilla;
        }
        scene.add(shape, material);
        if random.chance(0.3) {
            let even = random.chance(0.5);
            let scale =
                if even { Vec3::splat(random.between(0.6, 1.2)) } else { random.vector(0.6, 1.2) };
            let turn = Quat::from_rotation_y(random.between(0.0, 6.0));
            let frame = Affine3A::from_scale_rotation_translation(scale, turn, Vec3::ZERO);
            scene.instances.last_mut().expect("it was added").world_from_object = frame;
        }
    }
    if random.chance(0.1) {
        let fog = Material {
            kind: MaterialKind::Volumetric,
            color: Vec3::splat(0.5),
            trdepth: 3.0,
            albedo: Vec3::new(0.9, 0.8, 0.6),
            anisotropy: 0.4,
            ..Material::default()
        };
        scene.add(Shape::points([Vec3::ZERO], 5.0), fog);
    }
    let lamps = random.index(3);
    for _ in 0..lamps {
        let emission = random.between(2.0, 6.0) * random.vector(0.5, 1.0);
        let mut shape = shape(random);
        if random.chance(0.5) {
            shape.positions.iter_mut().for_each(|position| position.y += 1.2);
        }
        let emission_tex = random.chance(0.2).then_some(0);
        scene.add(shape, Material { emission, emission_tex, ..Material::default() });
    }
    if lamps == 0 || random.chance(0.7) {
        let turn = random.between(0.0, 6.0);
        add_sky(&mut scene, random.chance(0.5), turn);
    }
    scene
}

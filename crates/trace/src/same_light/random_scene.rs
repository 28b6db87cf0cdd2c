//! Scenes that combine what paths treat in different ways: solids that absorb and scatter, clouds,
//! surfaces that are there by chance, round and flat lamps, skies, textures, and bodies that
//! overlap.

use super::random_shape::{Random, rectangle, round_to_decimals, shape};
use glam::{Affine3A, Quat, Vec3};
use rotund_scene::{
    Camera, Environment, Material, MaterialKind, Method, Pixels, Scene, Shape, Texture,
};

/// A matte floor before a camera that looks down on it from `eye`.
pub(crate) fn floor(eye: Vec3) -> Scene {
    let camera = Camera { lens: 0.036, ..Camera::look_at(eye, 0.4 * Vec3::Y, Vec3::Y) };
    let mut scene = Scene { cameras: vec![camera], ..Scene::default() };
    let corners = [[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]];
    let shape = Shape::quads(corners.map(Vec3::from_array), [[0, 1, 2, 3]]);
    scene.add(shape, Material { color: Vec3::new(0.8, 0.7, 0.6), ..Material::default() });
    scene
}

/// A texture of noise, parts of which are half there.
fn add_texture(scene: &mut Scene, random: &mut Random) {
    let mut texel = |_| {
        let mut byte = |low: usize| (low + random.index(256 - low)) as u8;
        [byte(90), byte(90), byte(150), if byte(0) < 128 { 120 } else { 255 }]
    };
    let pixels = Pixels::Bytes((0..16).map(&mut texel).collect());
    scene.textures.push(Texture { name: String::new(), width: 4, height: 4, pixels });
}

/// A sky, with a broad sun or of one radiance.
pub(crate) fn add_sky(scene: &mut Scene, sunny: bool, turn: f32) {
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
        if random.chance(0.3) {
            material.ior = random.between(1.2, 1.8);
        }
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

/// Turns about the vertical through the origin, and scales or mirrors.
fn frame(random: &mut Random) -> Affine3A {
    let scale = match random.index(4) {
        0 => Vec3::ONE,
        1 => Vec3::splat(random.between(0.6, 1.2)),
        2 => random.vector(0.6, 1.2),
        _ => Vec3::new(1.0, 1.0, -1.0),
    };
    let turn = Quat::from_rotation_y(random.between(0.0, 6.0));
    Affine3A::from_scale_rotation_translation(scale, turn, Vec3::ZERO)
}

/// Glass or metal before the floor, so near that little else is seen.
///
/// Lamps are small and skies dim, so that most of the light on and behind the bodies comes through
/// or off others.
pub(crate) fn scene_of_casters(number: u64) -> Scene {
    let random = &mut Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(7));
    let eye = Vec3::new(random.between(-1.0, 1.0), random.between(0.3, 1.6), 2.4);
    let mut scene = floor(eye);
    scene.cameras[0].lens = random.between(0.04, 0.07);
    add_texture(&mut scene, random);
    if random.chance(0.2) {
        scene.cameras[0].aperture = 0.1;
    }
    let floors = [MaterialKind::Matte, MaterialKind::Matte, MaterialKind::Reflective];
    let ground = &mut scene.materials[0];
    (ground.kind, ground.roughness) =
        (floors[random.index(floors.len())], random.between(0.2, 0.6));
    for _ in 0..1 + random.index(3) {
        let (mut shape, mut caster) = (shape(random), material(random));
        caster.kind = match random.index(4) {
            0 => MaterialKind::Reflective,
            1 => MaterialKind::Transparent,
            _ => MaterialKind::Refractive,
        };
        caster.emission = Vec3::ZERO;
        if caster.kind == MaterialKind::Refractive && random.chance(0.7) {
            caster.trdepth = random.between(0.1, 0.5);
        }
        let center = Vec3::new(random.between(-0.4, 0.4), 0.4, random.between(-0.4, 0.4));
        let middle = shape.positions.iter().sum::<Vec3>() / shape.positions.len() as f32;
        shape.positions.iter_mut().for_each(|position| *position += center - middle);
        scene.add(shape, caster);
    }
    for _ in 0..1 + random.index(2) {
        let center = Vec3::new(
            random.between(-1.0, 1.0),
            random.between(1.0, 1.4),
            random.between(-0.8, 1.0),
        );
        let size = random.between(0.1, 0.3);
        let mut shape = match random.index(3) {
            0 => Shape::points([center], size),
            1 => {
                let end = center + 2.0 * size * random.vector(-1.0, 1.0);
                Shape::lines([center, end], vec![0.5 * size, 0.7 * size], [[0, 1]])
            }
            _ => rectangle(random, center, 1.5 * size),
        };
        if random.chance(0.7) {
            round_to_decimals(&mut shape.positions);
        }
        let emission = random.vector(0.5, 1.0) / (size * size);
        scene.add(shape, Material { emission, ..Material::default() });
    }
    let (sunny, turn) = (random.chance(0.3), random.between(0.0, 6.0));
    add_sky(&mut scene, sunny, turn);
    if !sunny {
        scene.environments[0].emission = Vec3::splat(0.02);
    }
    add_rarities(&mut scene, random);
    scene
}

/// Changes a scene, whose first instance is the floor and whose last one is a lamp, by what few
/// scenes have.
fn add_rarities(scene: &mut Scene, random: &mut Random) {
    let lamp = scene.instances.len() - 1;
    let in_lamp = scene.shapes[scene.instances[lamp].shape as usize].positions[0];
    for instance in &mut scene.instances[1..lamp] {
        if random.chance(0.1) {
            instance.world_from_object = frame(random);
        }
    }
    if random.chance(0.1) {
        scene.cameras[0] = scene.cameras[0].clone().orthographic(2.0);
    }
    let lamp = scene.materials.last_mut().expect("it is that of the lamp");
    if random.chance(0.1) {
        lamp.opacity = 0.5;
    }
    lamp.emission_tex = random.chance(0.1).then_some(0);
    let kind = MaterialKind::Refractive;
    let glass = Material { kind, color: random.vector(0.3, 1.0), ..Material::default() };
    if random.chance(0.1) {
        let eye = scene.cameras[0].world_from_camera.translation.into();
        let color = if random.chance(0.5) { Vec3::ONE } else { glass.color };
        let around = Material { color, trdepth: 1.0, ..glass.clone() };
        scene.add(Shape::points([eye], 0.4), around);
    }
    if random.chance(0.1) {
        scene.add(Shape::points([in_lamp], 0.5), Material { trdepth: 0.5, ..glass.clone() });
    }
    if random.chance(0.1) {
        let kind = MaterialKind::Volumetric;
        let albedo = random.vector(0.2, 0.9);
        let cloud = Material { kind, trdepth: 0.5, albedo, ..glass };
        scene.add(Shape::points([random.place()], 0.5), cloud);
    }
}

/// Returns a scene that depends on a number. Its lamps are large, so that plain paths find them.
pub(crate) fn scene(number: u64) -> Scene {
    let random = &mut Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(99));
    let mut scene = floor(Vec3::new(random.between(-1.0, 1.0), random.between(1.2, 2.5), 2.8));
    if random.chance(0.2) {
        scene.cameras[0].aperture = 0.2;
    }
    if random.chance(0.15) {
        scene.cameras[0] = scene.cameras[0].clone().orthographic(3.0);
    }
    add_texture(&mut scene, random);
    match random.index(4) {
        0 => scene.materials[0].kind = MaterialKind::Glossy,
        1 => scene.materials[0].kind = MaterialKind::Reflective,
        _ => {}
    }
    scene.materials[0].roughness = 0.5;
    if random.chance(0.25) {
        let corners = [[-2.0, 0.0, -1.5], [2.0, 0.0, -1.5], [2.0, 2.0, -1.5], [-2.0, 2.0, -1.5]];
        let wall = Shape::quads(corners.map(Vec3::from_array), [[0, 1, 2, 3]]);
        scene.add(wall, Material { color: random.vector(0.2, 0.9), ..Material::default() });
    }
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
            scene.instances.last_mut().expect("it was added").world_from_object = frame(random);
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

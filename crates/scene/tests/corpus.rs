//! Malformed files, from fuzzing and from deterministic corruption of valid ones: nothing may
//! panic, hang, or load with an index out of range.

#![cfg(feature = "load")]

mod support;

use rotund_scene::{LoadOptions, load};
use std::{fs, path::Path};
use support::{Random, input, whole};

const ASCII: &[u8] = b"ply\nformat ascii 1.0\ncomment good\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nproperty float radius\nelement face 2\n\
    property list uchar int vertex_indices\nend_header\n\
    0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n3 0 1 2\n4 0 1 2 3\n";

fn binary() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nproperty float radius\nelement line 1\n\
        property list uchar int vertex_indices\nend_header\n"
        .to_vec();
    for i in 0..12 {
        bytes.extend((i as f32 * 0.1).to_le_bytes());
    }
    bytes.push(3);
    for i in 0..3_i32 {
        bytes.extend(i.to_le_bytes());
    }
    bytes
}

const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2//1 -1\nl 1 2 3\n";

const SWC: &[u8] = b"# cell\n1 1 0 0 0 2 -1\n2 1 0 2 0 2 1\n3 1 0 -2 0 2 1\n4 3 5 0 0 1 1\n\
    5 3 9 1 0 0 4\n6,2,-4,0,0,0.5,1\n7,2,-9,1,0,,6\n";

const MOLECULE: &[u8] = b"4\nProperties=species:S:1:pos:R:3:radius:R:1\nC 0 0 0 1.5\n\
    O 1.2 0 0 1\nH -0.6 0.9 0 0.5\nH -0.6 -0.9 0 0.5\n";

fn tck() -> Vec<u8> {
    let mut bytes = b"mrtrix tracks\ndatatype: Float32LE\ncount: 2\nfile: . 60\nEND\n".to_vec();
    bytes.resize(60, 0);
    let (nan, end) = ([f32::NAN; 3], [f32::INFINITY; 3]);
    let points =
        [[0.0; 3], [1.0, 0.0, 0.5], [1.0, 2.0, 1.0], nan, [4.0; 3], [4.0, 5.0, 4.0], nan, end];
    bytes.extend(points.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

fn trk() -> Vec<u8> {
    let mut bytes = vec![0; 1000];
    let mut put = |at: usize, part: &[u8]| bytes[at..at + part.len()].copy_from_slice(part);
    put(0, b"TRACK");
    put(6, &[4, 0, 5, 0, 6, 0]);
    for i in 0..3 {
        put(12 + 4 * i, &1.5_f32.to_le_bytes());
    }
    // One scalar, one property, and a transform that scales by 1.5.
    put(36, &[1]);
    put(238, &[1]);
    for (row, x) in [1.5_f32, 1.5, 1.5, 1.0].into_iter().enumerate() {
        put(440 + 20 * row, &x.to_le_bytes());
    }
    put(948, b"LAS");
    put(988, &[2, 0, 0, 0, 2, 0, 0, 0]);
    put(996, &1000_i32.to_le_bytes());
    for count in [3_i32, 2] {
        bytes.extend(count.to_le_bytes());
        bytes.extend((0..4 * count + 1).flat_map(|i| (i as f32 * 0.7).to_le_bytes()));
    }
    bytes
}

const SCENE: &[u8] = br#"{ "asset": { "version": "4.2" }, "cameras": [{ "lookat": [0,1,2, 0,0,0, 0,1,0] }],
    "textures": [{ "generator": { "uv_grid": { "size": 4 } } }],
    "materials": [{ "type": "glossy", "color": [1, 0.5, 0], "color_tex": 0, "normal_tex": 0 }],
    "shapes": [{ "name": "s", "method": "vanilla", "generator": { "lines_grid": { "steps": 2, "lines": 2,
        "size": [1, 1], "radius": [0.1, 0.2] } } }],
    "instances": [{ "shape": 0, "material": 0, "frame": [1,0,0, 0,1,0, 0,0,1, 0,0,0] }] }"#;

/// Returns a corrupted copy: cut, overwritten, duplicated or joined.
fn spoiled(good: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..1 + (random.unit() * 4.0) as usize {
        let at = (random.unit() * bytes.len() as f32) as usize;
        let until = (at + 1 + (random.unit() * 12.0) as usize).min(bytes.len());
        match (random.unit() * 6.0) as u32 {
            0 => bytes.truncate(at),
            1 => bytes[at..until].iter_mut().for_each(|b| *b = (random.unit() * 256.0) as u8),
            2 => {
                let piece = bytes[at..until].to_vec();
                bytes.splice(at..at, piece);
            }
            3 => drop(bytes.drain(at..until)),
            // Digits change counts, indices and signs.
            4 => bytes[at] = b"0123456789-.e"[(random.unit() * 13.0) as usize],
            _ => bytes.splice(at..at, *b"999999999").for_each(drop),
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

#[test]
fn corrupted_files_are_refused_or_load_as_valid_scenes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let binary = binary();
    let (tck, trk) = (tck(), trk());
    for (name, good) in [
        ("a.ply", ASCII),
        ("b.ply", &binary[..]),
        ("c.obj", OBJ),
        ("d.json", SCENE),
        ("e.swc", SWC),
        ("f.tck", &tck[..]),
        ("g.trk", &trk[..]),
        ("h.xyz", MOLECULE),
    ] {
        let path = folder.path().join(name);
        let scene = if name == "d.json" { path.clone() } else { folder.path().join("scene.json") };
        let around = format!(
            r#"{{ "materials": [{{ "color": [1, 1, 1] }}], "shapes": [{{ "uri": "{name}" }}],
            "instances": [{{ "shape": 0, "material": 0 }}] }}"#
        );
        fs::write(folder.path().join("scene.json"), around).expect("writes the scene");
        let mut random = Random(41);
        let (mut refused, mut loaded) = (0, 0);
        for _ in 0..500 {
            let bytes = spoiled(good, &mut random);
            fs::write(&path, &bytes).expect("writes the file");
            let Ok(result) = load(&scene, &LoadOptions::default()) else {
                refused += 1;
                continue;
            };
            loaded += 1;
            whole::check(&result.scene);
        }
        assert!(refused > 100 && loaded > 10, "{name}: {refused} refused, {loaded} loaded");
    }
}

#[test]
fn inputs_found_by_fuzzing_are_refused_or_load_as_valid_scenes() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    for target in ["ply", "obj", "mtl", "swc", "tck", "trk", "points", "scene", "texture"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join(input::MESH.0), input::MESH.1).expect("writes the mesh");
        let mut outcomes = [0, 0];
        for entry in fs::read_dir(corpus.join(target)).expect("a corpus") {
            let bytes = fs::read(entry.expect("an entry").path()).expect("reads the file");
            let Some((name, file, scene)) = input::files(target, &bytes) else { continue };
            fs::write(folder.path().join(&name), file).expect("writes the file");
            fs::write(folder.path().join("scene.json"), scene).expect("writes the scene");
            let lone = input::lone(target, &name);
            for name in std::iter::once("scene.json".to_owned()).chain(lone) {
                let result = load(folder.path().join(name), &LoadOptions::default());
                outcomes[usize::from(result.is_ok())] += 1;
                if let Ok(loaded) = result {
                    whole::check(&loaded.scene);
                }
            }
        }
        let [refused, loaded] = outcomes;
        // Materials that make no sense are left out.
        assert!(refused > 0 || target == "mtl", "{target}: nothing is refused");
        assert!(loaded > 0, "{target}: {refused} refused, {loaded} loaded");
    }
}

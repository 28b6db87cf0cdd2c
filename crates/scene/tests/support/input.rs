//! Conversion of the bytes of a fuzzer to a scene file and the file that it names.

/// Returns name and content of the file that the scene names, and the scene; `None` to skip an
/// input.
pub(crate) fn files(target: &str, bytes: &[u8]) -> Option<(String, Vec<u8>, Vec<u8>)> {
    match target {
        "ply" | "obj" | "swc" | "tck" | "trk" => {
            let name = format!("shape.{target}");
            let scene = AROUND_A_SHAPE.replace("FILE", &name);
            Some((name, bytes.to_vec(), scene.into_bytes()))
        }
        "points" => {
            // The first byte selects the format, which decides where the content leaves a choice.
            let (first, bytes) = bytes.split_first()?;
            let name = ["points.xyz", "points.txt", "points.pts"][usize::from(first % 3)];
            let scene = AROUND_A_SHAPE.replace("FILE", name);
            Some((name.to_owned(), bytes.to_vec(), scene.into_bytes()))
        }
        // The materials of the mesh beside it.
        "mtl" => {
            let scene = AROUND_A_SHAPE.replace("FILE", MESH.0);
            Some(("shape.mtl".to_owned(), bytes.to_vec(), scene.into_bytes()))
        }
        "texture" => {
            // The first byte selects the name, which does not matter.
            let (first, bytes) = bytes.split_first()?;
            let name = ["image.png", "image.jpg", "image.hdr", "image.exr"][usize::from(first % 4)];
            let scene = AROUND_A_TEXTURE.replace("FILE", name);
            Some((name.to_owned(), bytes.to_vec(), scene.into_bytes()))
        }
        "scene" => {
            let shape = QUAD.as_bytes().to_vec();
            (!asks_for_much(bytes)).then(|| ("shape.ply".to_owned(), shape, bytes.to_vec()))
        }
        _ => None,
    }
}

/// A mesh, by name and content, that stands beside the files of every input.
pub(crate) const MESH: (&str, &str) = (
    "mesh.obj",
    "mtllib shape.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n\
     usemtl b\nf 1/1 3/1 4/1\nl 1 3\n",
);

/// Returns the file to load by itself after the scene, if the input is the file of a shape.
pub(crate) fn lone(target: &str, name: &str) -> Option<String> {
    match target {
        "mtl" => Some(MESH.0.to_owned()),
        "scene" | "texture" => None,
        _ => Some(name.to_owned()),
    }
}

/// Returns true for scenes that are valid but slow, such as those with generators of a million
/// elements.
fn asks_for_much(bytes: &[u8]) -> bool {
    let has = |word: &[u8]| bytes.windows(word.len()).any(|window| window == word);
    let long = bytes.windows(3).any(|window| window.iter().all(u8::is_ascii_digit));
    // Each level quadruples the quads, of which a generator may create thousands.
    let deepest = if has(b"generator") { b'2' } else { b'4' };
    let deep = bytes.windows(16).any(|w| {
        w.starts_with(b"subdivisions\"") && w.iter().any(|&c| c > deepest && c.is_ascii_digit())
    });
    let exponent = bytes.windows(2).any(|w| w[0].is_ascii_digit() && w[1] | 32 == b'e');
    (has(b"generator") || has(b"subdivisions")) && (long || exponent || deep)
}

const AROUND_A_SHAPE: &str = r#"{
  "materials": [{ "type": "glossy", "color": [1, 1, 1], "roughness": 0.5, "normal_tex": 0 }],
  "textures": [{ "generator": { "bumps": { "size": 8, "bumps": 2, "height": 0.5 } } }],
  "shapes": [{ "uri": "FILE" }],
  "instances": [{ "shape": 0, "material": 0 }]
}"#;

const AROUND_A_TEXTURE: &str = r#"{
  "textures": [{ "uri": "FILE" }],
  "materials": [{ "color": [1, 1, 1], "color_tex": 0, "normal_tex": 0 }],
  "shapes": [{ "generator": { "disk": { "steps": 2, "radius": 1 } } }],
  "instances": [{ "shape": 0, "material": 0 }]
}"#;

const QUAD: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n1 1 1\n0 1 0\n4 0 1 2 3\n";

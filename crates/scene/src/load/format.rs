//! The structure of scene files for serde, with the defaults of the format.

use super::collection::{Collection, Reference, items, items_or_files, object};
use crate::{Method, Overlap, camera::look_at, generate};
use glam::{Affine3A, DAffine3, Vec3};
use serde::{Deserialize, Deserializer};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct SceneFile {
    #[serde(deserialize_with = "object")]
    pub asset: AssetFile,
    /// The method of shapes that do not have their own.
    pub method: Option<Method>,
    #[serde(deserialize_with = "items")]
    pub cameras: Collection<CameraFile>,
    #[serde(deserialize_with = "items")]
    pub environments: Collection<EnvironmentFile>,
    #[serde(deserialize_with = "items_or_files")]
    pub textures: Collection<TextureFile>,
    #[serde(deserialize_with = "items")]
    pub materials: Collection<MaterialFile>,
    #[serde(deserialize_with = "items_or_files")]
    pub shapes: Collection<ShapeFile>,
    #[serde(deserialize_with = "items")]
    pub subdivs: Collection<SubdivFile>,
    #[serde(deserialize_with = "items")]
    pub instances: Collection<InstanceFile>,
    /// More instances, in files of version 4.0.
    #[serde(deserialize_with = "items")]
    pub objects: Collection<InstanceFile>,
}

/// A scene file, which must be an object.
#[derive(Debug, Deserialize)]
pub(super) struct Whole(#[serde(deserialize_with = "object")] pub SceneFile);

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct AssetFile {
    /// A string; some files have a number.
    pub version: serde_json::Value,
    /// Declared so that it is no unknown field; the value is not used. `IgnoredAny` would count as
    /// unknown.
    #[serde(rename = "copyright")]
    _copyright: serde_json::Value,
    #[serde(rename = "generator")]
    _generator: serde_json::Value,
}

#[derive(Debug, Deserialize)]
#[serde(default)]
pub(super) struct CameraFile {
    pub name: String,
    pub frame: Frame,
    pub lookat: Option<LookAt>,
    #[serde(alias = "ortho")]
    pub orthographic: bool,
    pub lens: f32,
    pub film: f32,
    pub aspect: f32,
    pub focus: Option<f32>,
    pub aperture: f32,
}

impl Default for CameraFile {
    fn default() -> Self {
        let crate::Camera { name, orthographic, lens, film, aspect, aperture, .. } =
            crate::Camera::default();
        let (frame, lookat, focus) = (Frame::default(), None, None);
        Self { name, frame, lookat, orthographic, lens, film, aspect, focus, aperture }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct EnvironmentFile {
    pub name: String,
    pub frame: Frame,
    pub lookat: Option<LookAt>,
    pub emission: [f32; 3],
    pub emission_tex: Option<Reference>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct TextureFile {
    pub name: String,
    pub uri: Option<String>,
    /// A file in the folder `textures`, in version 4.1.
    pub datafile: Option<String>,
    pub generator: Option<generate::Image>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum MaterialType {
    #[default]
    Matte,
    #[serde(alias = "plastic")]
    Glossy,
    #[serde(alias = "metallic", alias = "metal")]
    Reflective,
    #[serde(alias = "glass")]
    Refractive,
    #[serde(alias = "thinglass")]
    Transparent,
    #[serde(alias = "volume")]
    Volumetric,
    Subsurface,
    GltfPbr,
}

#[derive(Debug, Deserialize)]
#[serde(default)]
pub(super) struct MaterialFile {
    pub name: String,
    #[serde(rename = "type")]
    pub kind: Option<MaterialType>,
    /// This and the next four fields determine the type in files older than the field `type`.
    pub specular: f32,
    pub coat: f32,
    pub transmission: f32,
    pub translucency: f32,
    pub thin: bool,
    pub emission: [f32; 3],
    pub color: [f32; 3],
    pub roughness: f32,
    pub metallic: f32,
    pub ior: f32,
    pub trdepth: f32,
    pub scattering: [f32; 3],
    pub scanisotropy: f32,
    pub opacity: f32,
    pub emission_tex: Option<Reference>,
    pub color_tex: Option<Reference>,
    pub roughness_tex: Option<Reference>,
    pub scattering_tex: Option<Reference>,
    pub normal_tex: Option<Reference>,
}

impl Default for MaterialFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: None,
            specular: 0.0,
            coat: 0.0,
            transmission: 0.0,
            translucency: 0.0,
            thin: true,
            emission: [0.0; 3],
            color: [0.0; 3],
            roughness: 0.0,
            metallic: 0.0,
            ior: 1.5,
            trdepth: 0.01,
            scattering: [0.0; 3],
            scanisotropy: 0.0,
            opacity: 1.0,
            emission_tex: None,
            color_tex: None,
            roughness_tex: None,
            scattering_tex: None,
            normal_tex: None,
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ShapeFile {
    pub name: String,
    pub uri: Option<String>,
    /// A file in the folder `shapes`, in version 4.1.
    pub datafile: Option<String>,
    pub generator: Option<generate::Geometry>,
    pub method: Option<Method>,
    pub overlap: Option<Overlap>,
}

impl From<String> for TextureFile {
    fn from(datafile: String) -> Self {
        Self { datafile: Some(datafile), ..Self::default() }
    }
}

impl From<String> for ShapeFile {
    fn from(datafile: String) -> Self {
        Self { datafile: Some(datafile), ..Self::default() }
    }
}

/// A control mesh whose subdivision replaces a shape.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub(super) struct SubdivFile {
    pub name: String,
    pub shape: Option<Reference>,
    pub uri: Option<String>,
    /// A file in the folder `subdivs`, in version 4.1.
    pub datafile: Option<String>,
    pub generator: Option<generate::Geometry>,
    pub subdivisions: u32,
    pub catmullclark: bool,
    pub smooth: bool,
    pub displacement: f32,
    pub displacement_tex: Option<Reference>,
}

impl Default for SubdivFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            shape: None,
            uri: None,
            datafile: None,
            generator: None,
            subdivisions: 0,
            catmullclark: true,
            smooth: true,
            displacement: 0.0,
            displacement_tex: None,
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct InstanceFile {
    pub name: String,
    pub frame: Frame,
    pub lookat: Option<LookAt>,
    pub shape: Option<Reference>,
    pub material: Option<Reference>,
    /// The name of a PLY file of frames in the folder `instances`, in version 4.0: the instance is
    /// repeated for each frame.
    pub instance: Option<String>,
}

/// Twelve numbers, flat or in four vectors: the x, y and z axes and the origin. They are double, so
/// that the sum of an origin and the offset of a shape far away is rounded once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame(pub DAffine3);

impl Frame {
    pub(super) fn single(self) -> Affine3A {
        self.0.as_affine3a()
    }
}

impl Default for Frame {
    fn default() -> Self {
        Self(DAffine3::IDENTITY)
    }
}

impl<'de> Deserialize<'de> for Frame {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "expected a frame: 12 numbers, or 4 vectors of 3 numbers")]
        enum Form {
            Flat([f64; 12]),
            Nested([[f64; 3]; 4]),
        }
        Ok(Self(match Form::deserialize(deserializer)? {
            Form::Flat(numbers) => DAffine3::from_cols_array(&numbers),
            Form::Nested(columns) => DAffine3::from_cols_array_2d(&columns),
        }))
    }
}

/// Nine numbers, in version 4.0: eye, target and up vector.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct LookAt([f32; 9]);

impl LookAt {
    fn vectors(self) -> [Vec3; 3] {
        let [ex, ey, ez, cx, cy, cz, ux, uy, uz] = self.0;
        [Vec3::new(ex, ey, ez), Vec3::new(cx, cy, cz), Vec3::new(ux, uy, uz)]
    }

    pub(super) fn distance(self) -> f32 {
        let [eye, center, _] = self.vectors();
        eye.distance(center)
    }

    /// Returns the frame at the eye whose -z axis points to the target. The early loader of
    /// yocto-gl flipped z for anything but cameras, but the files that it converted to version 4.2
    /// do not.
    pub(super) fn frame(self) -> Affine3A {
        let [eye, center, up] = self.vectors();
        look_at(eye, center, up)
    }
}

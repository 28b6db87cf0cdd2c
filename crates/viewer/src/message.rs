//! The messages between a viewer and its client: requests, events and frames.
//!
//! All are data with a JSON form. Points of the picture are `[u, v]` in `0.0..=1.0`: u runs right,
//! v runs down.

use crate::settings::Settings;
use crate::side::Side;
use glam::Affine3A;
use rotund_scene::Camera;
use serde::{Deserialize, Serialize};

/// What a client asks for: `{"type": "grab", "at": [0.5, 0.5]}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// The size of the picture in pixels; larger ones than [`crate::LONGEST_SIDE`] are reduced.
    Size {
        /// Pixels in a row.
        width: u32,
        /// Number of rows.
        height: u32,
        /// Keep the aspect of the camera: the longer side is the larger of width and height.
        /// Otherwise the camera takes the aspect of the picture.
        keep_aspect: bool,
    },
    /// A hand takes hold of what is below this point of the picture: orbits turn about it, and
    /// pans move with it. Pictures are previews until [`Request::Release`].
    Grab {
        /// A point of the picture.
        at: [f32; 2],
    },
    /// Moves the camera.
    Move(Motion),
    /// The hand lets go.
    // Braces make serde refuse fields, which it ignores for a variant without.
    Release {},
    /// Turns the camera to the surface below a point of the picture, and focuses on it.
    Focus {
        /// A point of the picture.
        at: [f32; 2],
    },
    /// Moves the camera back until all is in the picture.
    FrameAll {},
    /// Takes this camera, but with the aspect of the picture unless that is kept.
    Camera {
        /// The camera.
        camera: CameraText,
    },
    /// Takes a camera of the scene.
    SceneCamera {
        /// Its index.
        index: usize,
    },
    /// Takes these settings.
    Settings {
        /// All settings.
        settings: Settings,
    },
    /// Asks what is at a point of the picture; [`Event::Inspection`] answers the last such request,
    /// with nothing while there is no scene.
    Inspect {
        /// A point of the picture.
        at: [f32; 2],
    },
    /// A frame has been shown, so another may be sent.
    Shown {
        /// [`FrameHeader::id`] of the frame.
        frame: u64,
    },
}

/// A movement of the camera; parts that are absent are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Motion {
    /// Number of the input, which frames repeat in [`FrameHeader::input`].
    pub input: u64,
    /// Turns the camera about what was grabbed: right and down, in heights of the picture.
    pub orbit: [f32; 2],
    /// Moves the camera so that what was grabbed moves right and down, in heights of the picture.
    pub pan: [f32; 2],
    /// Moves towards what is below `at`: by 1, to half the distance; by -1, to twice the distance.
    pub zoom: f32,
    /// A point of the picture, for `zoom`; the center if absent.
    pub at: Option<[f32; 2]>,
    /// Turns the camera on the spot: right and down, in heights of the picture.
    pub look: [f32; 2],
    /// Moves the camera right, up and forward, in units of the distance to what it looks at.
    pub fly: [f32; 3],
}

/// A camera as in a scene file: an entry of `cameras` there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraText {
    /// Name of the camera.
    pub name: String,
    /// Axes x, y and z and the origin of the frame.
    pub frame: [f32; 12],
    /// Whether the projection is orthographic.
    pub orthographic: bool,
    /// Focal length in meters.
    pub lens: f32,
    /// Longer side of the film in meters.
    pub film: f32,
    /// Width over height.
    pub aspect: f32,
    /// Distance to the plane in focus, in meters.
    pub focus: f32,
    /// Diameter of the lens in meters.
    pub aperture: f32,
}

impl Default for CameraText {
    fn default() -> Self {
        Self::from(&Camera::default())
    }
}

impl From<&Camera> for CameraText {
    fn from(camera: &Camera) -> Self {
        let Camera {
            ref name,
            world_from_camera,
            orthographic,
            lens,
            film,
            aspect,
            focus,
            aperture,
        } = *camera;
        let frame = world_from_camera.to_cols_array();
        Self { name: name.clone(), frame, orthographic, lens, film, aspect, focus, aperture }
    }
}

impl From<&CameraText> for Camera {
    fn from(text: &CameraText) -> Self {
        let CameraText { ref name, frame, orthographic, lens, film, aspect, focus, aperture } =
            *text;
        let world_from_camera = Affine3A::from_cols_array(&frame);
        Self {
            name: name.clone(),
            world_from_camera,
            orthographic,
            lens,
            film,
            aspect,
            focus,
            aperture,
        }
    }
}

/// What a viewer tells a client: `{"type": "status", ...}`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Event {
    /// Camera, size or settings have changed, by a request or a reload.
    State(Box<State>),
    /// How far the picture is.
    Status(Status),
    /// Answers [`Request::Inspect`].
    Inspection(Box<Inspection>),
    /// The scene is being loaded.
    Loading {
        /// What is being done, in words.
        what: String,
        /// Seconds since it began.
        seconds: f32,
    },
    /// Something did not work: a request was refused, or the scene cannot be loaded. The picture
    /// stays as it was.
    Problem {
        /// One sentence.
        text: String,
    },
    /// The scene, which could not be loaded before, is loaded.
    Solved,
}

/// What a client sees, and how.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct State {
    /// Grows with every change of the picture but movements of the camera: frames of an earlier
    /// epoch show something else, and must not be taken for this.
    pub epoch: u64,
    /// Name of the scene.
    pub scene: String,
    /// Warnings of the loader.
    pub warnings: Vec<String>,
    /// Names of the cameras of the scene.
    pub cameras: Vec<String>,
    /// Number of points, lines, triangles and quads, each instance counted.
    pub elements: [u64; 4],
    /// The camera.
    pub camera: CameraText,
    /// Pixels in a row of the whole picture.
    pub width: u32,
    /// Rows of the whole picture.
    pub height: u32,
    /// All settings.
    pub settings: Settings,
}

/// What a viewer is doing for a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Activity {
    /// There is no scene yet.
    Loading,
    /// The camera moves; pictures are previews.
    Moving,
    /// Samples are being added.
    Refining,
    /// All samples that were asked for are there.
    Done,
}

/// How far a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Status {
    /// [`State::epoch`] of the picture.
    pub epoch: u64,
    /// What is being done.
    pub activity: Activity,
    /// Samples that every pixel has.
    pub samples: u32,
    /// Samples that were asked for.
    pub wanted: u32,
    /// Rays per second while rendering, shadow rays included.
    pub rays_per_second: f64,
    /// Seconds of rendering for this picture.
    pub seconds: f64,
    /// Root mean square error of the picture over its mean, estimated from its two halves; `None`
    /// before there are two samples.
    pub noise: Option<f64>,
    /// Samples brighter than any light.
    pub fireflies: u64,
}

/// What a frame shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct FrameHeader {
    /// Number of the frame, for [`Request::Shown`].
    pub id: u64,
    /// [`State::epoch`] of the picture.
    pub epoch: u64,
    /// Which picture of a comparison.
    pub side: Side,
    /// [`Motion::input`] of the last movement that the frame shows.
    pub input: u64,
    /// Pixels in a row, fewer than those of [`State`] for a preview.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Samples that every pixel has.
    pub samples: u32,
    /// Whether the picture has fewer pixels or less precise ones than it will have at rest.
    pub preview: bool,
    /// Whether its noise has been removed.
    pub denoised: bool,
    /// Media type of the bytes: `image/png`, which is exact, or `image/jpeg`.
    pub media: &'static str,
}

/// An encoded picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// What it shows.
    pub header: FrameHeader,
    /// The encoded picture.
    pub bytes: Vec<u8>,
}

/// What a viewer sends to a client.
#[derive(Clone, Debug)]
pub enum Output {
    /// A message.
    Event(Event),
    /// A picture.
    Frame(Frame),
}

/// What is at a point of the picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// The point that was asked for.
    pub at: [f32; 2],
    /// Column and row of the pixel.
    pub pixel: [u32; 2],
    /// Linear radiance and alpha of the pixel of the full picture; `None` while there is none.
    pub value: Option<[f32; 4]>,
    /// The first surface of the ray through the center of the pixel.
    pub hit: Option<Surface>,
}

/// A surface that a ray meets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Surface {
    /// Index and name of the instance.
    pub instance: (u32, String),
    /// Index and name of the shape.
    pub shape: (u32, String),
    /// Index and name of the material.
    pub material: (u32, String),
    /// Kind of the material.
    pub material_kind: String,
    /// Index of the element.
    pub element: u32,
    /// Kind of the element: points, lines, triangles or quads.
    pub kind: &'static str,
    /// Method that the element is traced by: `vanilla` or `enhanced`.
    pub method: &'static str,
    /// Distance from the camera in meters.
    pub t: f32,
    /// Position in world space.
    pub position: [f32; 3],
    /// Bound on the distance of the position from the exact surface, in meters.
    pub error: f32,
    /// Geometric normal.
    pub normal: [f32; 3],
    /// Shading normal towards the viewer.
    pub shading_normal: [f32; 3],
    /// Parameters of the element.
    pub uv: [f32; 2],
    /// Texture coordinates.
    pub texcoord: [f32; 2],
}

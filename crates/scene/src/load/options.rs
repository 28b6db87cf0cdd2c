//! Options of loading.

/// Security and error-recovery options for loading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Allow a scene to name files outside its own folder. Off by default, so that a scene from an
    /// untrusted source can read only the files that came with it.
    pub allow_outside_folder: bool,
    /// Replace a texture that cannot be read with a white one, and add a warning, instead of
    /// returning an error.
    pub keep_going: bool,
    /// The radius of all points and lines of a file that is loaded by itself. By default it is the
    /// radius in the file, or else half the median distance between neighbouring points, within
    /// bounds that keep points and lines visible and apart.
    pub radius: Option<f32>,
    /// The axis that points up in a file that is loaded by itself. By default it is z for TCK, TRK,
    /// points as text and PLY files of points alone, and y for all others.
    pub up: Option<Up>,
    /// Leave out the floor of a file that is loaded by itself.
    pub without_floor: bool,
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// The y axis, as in scenes.
    Y,
    /// The z axis, as in scans, maps and medical images.
    Z,
}

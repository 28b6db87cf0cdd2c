//! Which kinds of elements are traced exactly: the switch between vanilla and enhanced.

use rotund_scene::{ElementKind, Method, Scene};

/// A kind of element that has two methods. Triangles have one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// Spheres instead of discs.
    Points,
    /// Rounded cones instead of distances to a segment.
    Lines,
    /// Bilinear patches instead of two triangles.
    Quads,
}

/// Options to choose among them.
#[derive(Clone, Debug, clap::Args)]
pub struct KindArgs {
    /// Which kinds of elements are exact in the enhanced picture; the others stay vanilla.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "points,lines,quads")]
    kinds: Vec<Kind>,
}

impl KindArgs {
    /// The kinds, each once and in order.
    pub fn kinds(&self) -> Vec<Kind> {
        let all = [Kind::Points, Kind::Lines, Kind::Quads];
        all.into_iter().filter(|kind| self.kinds.contains(kind)).collect()
    }
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Lines => "lines",
            Self::Quads => "quads",
        }
    }
}

/// Makes the shapes of these kinds enhanced and all others vanilla.
pub fn enhance(scene: &mut Scene, kinds: &[Kind]) {
    for shape in &mut scene.shapes {
        let enhanced = match shape.elements.kind() {
            ElementKind::Points => kinds.contains(&Kind::Points),
            ElementKind::Lines => kinds.contains(&Kind::Lines),
            ElementKind::Quads => kinds.contains(&Kind::Quads),
            ElementKind::Triangles => false,
        };
        shape.method = if enhanced { Method::Enhanced } else { Method::Vanilla };
    }
}

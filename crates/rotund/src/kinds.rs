//! The kinds of elements that the enhanced picture traces exactly.

use crate::message::warn;
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

/// Options that choose kinds.
#[derive(Clone, Debug, clap::Args)]
pub struct KindArgs {
    /// Kinds of elements that are traced exactly in the enhanced picture; the others stay vanilla.
    /// Default: points,lines,quads.
    #[arg(long, value_enum, value_delimiter = ',')]
    kinds: Option<Vec<Kind>>,
}

impl KindArgs {
    /// Returns the kinds, each once and in order.
    pub fn kinds(&self) -> Vec<Kind> {
        let chosen = self.kinds.as_deref().unwrap_or(&Kind::ALL);
        Kind::ALL.into_iter().filter(|kind| chosen.contains(kind)).collect()
    }

    /// Returns the kinds that a method traces exactly: none if it is the vanilla one, which makes a
    /// choice of kinds worth a warning.
    pub(crate) fn kinds_by(&self, method: Method) -> Vec<Kind> {
        match method {
            Method::Enhanced => self.kinds(),
            Method::Vanilla => {
                if self.kinds.is_some() {
                    warn("--kinds changes nothing: the vanilla method traces no kind exactly");
                }
                Vec::new()
            }
        }
    }
}

impl Kind {
    const ALL: [Self; 3] = [Self::Points, Self::Lines, Self::Quads];

    /// Returns the name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Lines => "lines",
            Self::Quads => "quads",
        }
    }

    fn element_kind(self) -> ElementKind {
        match self {
            Self::Points => ElementKind::Points,
            Self::Lines => ElementKind::Lines,
            Self::Quads => ElementKind::Quads,
        }
    }
}

/// Makes the shapes of these kinds enhanced and all others vanilla.
pub fn enhance(scene: &mut Scene, kinds: &[Kind]) {
    // Triangles look the same by both; one value makes the labels of equal films equal.
    scene.set_method(ElementKind::Triangles, Method::Vanilla);
    for kind in Kind::ALL {
        let enhanced = kinds.contains(&kind);
        let method = if enhanced { Method::Enhanced } else { Method::Vanilla };
        scene.set_method(kind.element_kind(), method);
    }
}

//! What the two renders of a comparison differ in.

use crate::kinds::{Kind, enhance};
use rotund_report::compare::Pair;
use rotund_scene::{Overlap, Scene};

/// What the two renders of a comparison differ in.
#[derive(Clone, Debug)]
pub(super) struct Subject {
    overlap: bool,
    kinds: Vec<Kind>,
}

impl Subject {
    /// Compares what overlaps, or else the methods; `kinds` are enhanced.
    pub(super) fn new(overlap: bool, kinds: Vec<Kind>) -> Self {
        Self { overlap, kinds }
    }

    pub(super) fn pair_of(overlap: bool) -> &'static Pair {
        if overlap { &Pair::OVERLAPS } else { &Pair::METHODS }
    }

    pub(super) fn pair(&self) -> &'static Pair {
        Self::pair_of(self.overlap)
    }

    /// Prepares the scene for the first or the second render.
    pub(super) fn prepare(&self, scene: &mut Scene, index: usize) {
        if self.overlap {
            scene.set_overlap([Overlap::Separate, Overlap::Union][index]);
            enhance(scene, &self.kinds);
        } else {
            enhance(scene, [&[], self.kinds.as_slice()][index]);
        }
    }

    /// Returns the names of the kinds that are enhanced.
    pub(super) fn kind_names(&self) -> Vec<&'static str> {
        self.kinds.iter().map(|kind| kind.name()).collect()
    }

    /// Returns which kinds are enhanced, in words.
    pub(super) fn settings(&self) -> String {
        let kinds = self.kind_names();
        let kinds = if kinds.is_empty() { "nothing".to_owned() } else { kinds.join(", ") };
        format!("enhanced: {kinds}")
    }
}

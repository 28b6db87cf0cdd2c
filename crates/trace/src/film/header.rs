//! What a film shows, and which samples of it.

use crate::{Options, ShardSet};
use std::fmt;

/// Where the samples of a film come from. Films of different origins are of different pictures.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Origin {
    /// Program and version, since another version may take other samples: `rotund 0.1.0`.
    pub program: String,
    /// A hash of everything that the samples depend on and that the header has no field for: scene,
    /// camera, and options such as the number of bounces.
    pub hash: u64,
    /// The picture in words, to tell it from another.
    pub label: String,
}

/// The size, origin and samples of a film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilmHeader {
    /// Pixels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Seed of the samples.
    pub seed: u64,
    /// Source of the samples.
    pub origin: Origin,
    /// Samples of each pixel that were asked for, over all shards.
    pub wanted: u32,
    /// The shards that the film holds.
    pub shards: ShardSet,
    /// Samples that every pixel has: the minimum over the pixels.
    pub samples: u32,
}

impl FilmHeader {
    /// Returns the header of a film of no samples and no origin.
    #[must_use]
    pub fn for_options(options: &Options) -> Self {
        let &Options { width, height, seed, samples: wanted, shard, .. } = options;
        let origin = Origin::default();
        Self { width, height, seed, origin, wanted, shards: shard.into(), samples: 0 }
    }

    /// Returns the number of samples of each pixel when the film is finished.
    #[must_use]
    pub fn share(&self) -> u32 {
        self.shards.share_of(self.wanted)
    }

    /// Returns true if every pixel has all samples that the shards of the film consist of.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.samples >= self.share()
    }

    /// Returns true if both are films of one picture, whichever shards of it.
    #[must_use]
    pub fn same_picture(&self, other: &Self) -> bool {
        self.picture() == other.picture()
    }

    /// Returns what films of one picture have in common.
    pub(super) fn picture(&self) -> (u32, u32, u64, u32, u32, &Origin) {
        let Self { width, height, seed, ref origin, wanted, ref shards, samples: _ } = *self;
        (width, height, seed, wanted, shards.count(), origin)
    }

    /// Describes in what the picture is another one, each with the value of this header and of the
    /// other.
    #[must_use]
    pub fn differences(&self, other: &Self) -> String {
        let size = |header: &Self| format!("{} x {}", header.width, header.height);
        let both = |value: &dyn Fn(&Self) -> String| (value(self), value(other));
        let fields = [
            both(&size),
            both(&|header| format!("seed {}", header.seed)),
            both(&|header| format!("{} samples", header.wanted)),
            both(&|header| format!("{} shards", header.shards.count())),
            both(&|header| header.origin.program.clone()),
        ];
        let unlike = fields.into_iter().filter(|(mine, others)| mine != others);
        let texts = unlike.map(|(mine, others)| format!("{mine}, not {others}"));
        texts.chain(self.origin.difference(&other.origin)).collect::<Vec<_>>().join("; ")
    }
}

impl Origin {
    /// Describes how scene, camera and options differ from those of the other origin, if they do.
    fn difference(&self, other: &Self) -> Option<String> {
        if (&self.label, self.hash) == (&other.label, other.hash) {
            return None;
        }
        // What the words leave out is in the hash.
        Some(if self.label == other.label {
            let Self { label, hash, .. } = self;
            let others = other.hash;
            format!(
                "{label}, but other shapes, materials, textures, cameras or environments \
                 ({hash:016x}, not {others:016x})"
            )
        } else {
            format!("{self}, not {other}")
        })
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({:016x})", self.label, self.hash)
    }
}

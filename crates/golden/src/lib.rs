//! Golden pictures: renders small pictures of scenes and compares each with a stored reference.

pub mod bless;
pub mod cases;
pub mod moments;
pub mod page;
pub mod reference;
pub mod significance;
pub mod surface;
#[cfg(test)]
mod tests;
pub mod verdict;

use anyhow::Result;
use cases::Case;
use moments::{Moments, Plan, Subject};
use reference::Reference;
use rotund_bvh::Isa;
use rotund_trace::Sequence;
use surface::Surface;
use verdict::{Verdict, judge};

/// Renders that a check makes of a picture. Fewer would make Student's t heavy in its tails; more
/// would take samples from each, and the samples of one render are better spread than those of two.
pub const REPLICAS: u32 = 32;
/// Renders that a reference is made of: its noise adds a sixteenth to that of a check.
pub const REFERENCE_REPLICAS: u32 = 256;
/// What random numbers references are made of. A check may use any other.
pub const REFERENCE_SEED: u32 = 0;

/// What came of rendering one picture.
pub enum Outcome {
    Judged(Box<Judged>),
    /// There is nothing to compare with, or nothing to compare.
    Failed(String),
}

/// A picture beside its reference.
pub struct Judged {
    pub reference: Reference,
    pub actual: Moments,
    pub surface: Surface,
    pub verdict: Verdict,
}

/// Renders a picture and holds it against its reference.
pub fn examine(
    case: &Case,
    sequence: Sequence,
    isa: Isa,
    seed: u32,
    pictures: usize,
) -> Result<Outcome> {
    if !case.reference.is_file() {
        let place = case.reference.display();
        return Ok(Outcome::Failed(format!("there is no reference {place} yet")));
    }
    let reference = Reference::read(&case.reference)?;
    let subject = Subject::new(case.load()?, isa)?;
    let Some(camera) = subject.scene.cameras.first() else {
        return Ok(Outcome::Failed("the scene has no camera".to_owned()));
    };
    let Moments { width, height, .. } = reference.moments;
    let (width, height) = (u32::try_from(width)?, u32::try_from(height)?);
    let size = camera.resolution(width.max(height));
    if size != (width, height) {
        let text = format!("{} x {} pixels instead of {width} x {height}", size.0, size.1);
        return Ok(Outcome::Failed(text));
    }
    let plan =
        Plan { width, height, bounces: reference.bounces, samples: reference.samples, sequence };
    let surface = subject.surface(width, height);
    let actual = Moments::measure(&subject, &plan, REPLICAS, seed)?;
    let mut verdict = judge(&actual, &reference.moments, pictures)?;
    verdict.findings.splice(0..0, surface.compare(&reference.surface));
    Ok(Outcome::Judged(Box::new(Judged { reference, actual, surface, verdict })))
}

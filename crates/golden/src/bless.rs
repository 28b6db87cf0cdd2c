//! Making references: the only way to add or change one.

use crate::case::Case;
use crate::check::Finding;
use crate::error::{GoldenError, Refused};
use crate::moments::Moments;
use crate::reference::Reference;
use crate::significance::{level, normal_quantile};
use crate::subject::{Plan, Subject};
use crate::verdict::{FLIP_CEILING, flip_of_noise, judge, surest_energy};
use crate::{REFERENCE_REPLICAS, REFERENCE_SEED, REPLICAS};
use rotund_bvh::Isa;
use rotund_image::CompareError;
use rotund_trace::{Options, Sequence};

/// Relative loss of light that every picture must reveal.
pub const SMALLEST_LOSS: f64 = 0.01;
/// Probability that a check misses such a loss.
pub const MISSED_LOSSES: f64 = 0.01;
/// Smallest and largest number of samples of a replica. They are doubled until the noise is low
/// enough.
const FEWEST_SAMPLES: u32 = 2;
const MOST_SAMPLES: u32 = 32;

/// Result of accepting a picture.
#[derive(Debug)]
pub enum Blessed {
    /// The picture had no reference.
    New(Reference),
    /// The picture agrees with its reference, which stays as it is to the bit.
    Unchanged,
    /// The new reference, and what differed from the old one; nothing if its size or number of
    /// samples changed.
    Changed(Reference, Vec<Finding>),
}

/// Renders the reference of a picture whose longer side gets `resolution` pixels. Nothing is
/// written.
///
/// Every picture meets the same standard, and a check is never weakened. Pictures are refused if
/// they are smaller than their reference was, too noisy to reveal a loss of one percent of the
/// light or to keep FLIP below [`FLIP_CEILING`], black, or with rejected samples.
pub(crate) fn bless(
    case: &Case,
    old: Option<&Reference>,
    resolution: u32,
    pictures: usize,
) -> Result<Blessed, GoldenError> {
    let subject = Subject::new(&case.name, case.load()?, Isa::default_set())?;
    let new = render(&subject, case, old, resolution, pictures)?;
    let Some(old) = old else { return Ok(Blessed::New(new)) };
    let same_size =
        (old.moments.width, old.moments.height) == (new.moments.width, new.moments.height);
    if !same_size || old.samples != new.samples || old.bounces != new.bounces {
        return Ok(Blessed::Changed(new, Vec::new()));
    }
    let mut findings = new.surface.compare(&old.surface);
    let verdict = judge(&new.moments, &old.moments, pictures)
        .map_err(|source| GoldenError::Compare { name: case.name.clone(), source })?;
    findings.extend(verdict.findings);
    Ok(if findings.is_empty() { Blessed::Unchanged } else { Blessed::Changed(new, findings) })
}

fn render(
    subject: &Subject,
    case: &Case,
    old: Option<&Reference>,
    resolution: u32,
    pictures: usize,
) -> Result<Reference, GoldenError> {
    let refused =
        |reason| GoldenError::Refused(Refused { pictures: vec![(case.name.clone(), reason)] });
    let incomparable = |source| GoldenError::Compare { name: case.name.clone(), source };
    let (width, height) = subject.resolution(resolution);
    if let Some(Moments { width: old_width, height: old_height, .. }) = old.map(|o| &o.moments)
        && (width as usize * height as usize) < old_width * old_height
    {
        return Err(refused(format!(
            "{width} x {height} pixels would weaken the check of {old_width} x {old_height}; \
             if that is intended, delete {} first",
            case.reference.display()
        )));
    }
    let bounces = Options::default().bounces;
    let sequence = Sequence::default();
    let mut plan = Plan { width, height, bounces, samples: FEWEST_SAMPLES, sequence };
    plan.samples = old.map_or(FEWEST_SAMPLES, |old| old.samples.max(FEWEST_SAMPLES));
    loop {
        // Few replicas are enough to see that more samples are needed.
        let first = subject.measure(&plan, REPLICAS, REFERENCE_SEED)?;
        if complaint(&first, pictures).map_err(incomparable)?.is_some()
            && plan.samples < MOST_SAMPLES
        {
            plan.samples *= 2;
            continue;
        }
        let moments = subject.measure(&plan, REFERENCE_REPLICAS, REFERENCE_SEED)?;
        match complaint(&moments, pictures).map_err(incomparable)? {
            None => {
                let surface = subject.surface(width, height);
                return Ok(Reference { moments, surface, samples: plan.samples, bounces });
            }
            Some(_) if plan.samples < MOST_SAMPLES => plan.samples *= 2,
            Some(complaint) => return Err(refused(complaint)),
        }
    }
}

/// Returns why a picture with these statistics cannot be a reference, if so.
fn complaint(moments: &Moments, pictures: usize) -> Result<Option<String>, CompareError> {
    if moments.rejected > 0 {
        let count = moments.rejected;
        return Ok(Some(format!("{count} samples are negative, infinite or not a number")));
    }
    if moments.mean.iter().all(|pixel| pixel.max_element() == 0.0) {
        return Ok(Some("the picture is black, so nothing can be checked".to_owned()));
    }
    // A check compares a picture of fewer replicas with the reference.
    let [actual, reference] =
        [REPLICAS, REFERENCE_REPLICAS].map(|replicas| Moments { replicas, ..moments.clone() });
    let energy = surest_energy(&actual, &reference);
    let sure = normal_quantile(level(3 * pictures)) + normal_quantile(2.0 * MISSED_LOSSES);
    let smallest_loss = sure * energy.error / energy.expected;
    if smallest_loss > SMALLEST_LOSS {
        return Ok(Some(format!(
            "the picture is so noisy that {:.1} % of the light could be lost unnoticed, {:.1} % \
             is the limit; take lights that are larger or nearer, or rougher surfaces",
            100.0 * smallest_loss,
            100.0 * SMALLEST_LOSS
        )));
    }
    let flip = flip_of_noise(&actual, &reference)?;
    if flip > FLIP_CEILING {
        return Ok(Some(format!(
            "the noise is visible: its FLIP error is {flip:.3}, {FLIP_CEILING} is the limit; take \
             lights that are larger or nearer, or rougher surfaces"
        )));
    }
    Ok(None)
}

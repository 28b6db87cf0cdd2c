//! Accepting pictures: the only way to make or change a reference.

use crate::cases::Case;
use crate::moments::{Moments, Plan, Subject};
use crate::reference::Reference;
use crate::significance::{level, normal_quantile};
use crate::verdict::{FLIP_CEILING, Finding, flip_of_noise, judge, surest_energy};
use crate::{REFERENCE_REPLICAS, REFERENCE_SEED, REPLICAS};
use anyhow::{Result, bail};
use rotund_bvh::Isa;
use rotund_trace::Sequence;

/// A loss of this share of the light has to be found in every picture, all but surely.
const SMALLEST_LOSS: f64 = 0.01;
/// How surely: it is missed once in a hundred times.
const MISSED: f64 = 0.01;
/// Samples of a replica: a quiet picture needs the fewest, and none may need more than the most.
const FEWEST_SAMPLES: u32 = 2;
const MOST_SAMPLES: u32 = 32;

/// What became of a picture.
#[derive(Debug)]
pub enum Blessed {
    /// There was no reference.
    New(Reference),
    /// The reference holds: the file stays as it is.
    Unchanged,
    /// What would fail now.
    Changed(Reference, Vec<Finding>),
}

/// Renders the reference of a picture, whose longer side gets `resolution` pixels. Writes nothing.
///
/// # Errors
///
/// Every picture is held to the same standard, and a check is never lowered: refused are pictures
/// that are smaller than their reference was, too noisy to find a loss of one percent of the light
/// or to keep their noise below [`FLIP_CEILING`], black, or with rejected samples.
pub fn bless(
    case: &Case,
    old: Option<&Reference>,
    resolution: u32,
    pictures: usize,
) -> Result<Blessed> {
    let subject = Subject::new(case.load()?, Isa::default_set())?;
    let new = render(&subject, case, old, resolution, pictures)?;
    let Some(old) = old else { return Ok(Blessed::New(new)) };
    let same_size =
        (old.moments.width, old.moments.height) == (new.moments.width, new.moments.height);
    if !same_size || old.samples != new.samples || old.bounces != new.bounces {
        return Ok(Blessed::Changed(new, Vec::new()));
    }
    let mut findings = new.surface.compare(&old.surface);
    findings.extend(judge(&new.moments, &old.moments, pictures)?.findings);
    Ok(if findings.is_empty() { Blessed::Unchanged } else { Blessed::Changed(new, findings) })
}

fn render(
    subject: &Subject,
    case: &Case,
    old: Option<&Reference>,
    resolution: u32,
    pictures: usize,
) -> Result<Reference> {
    let Some(camera) = subject.scene.cameras.first() else { bail!("the scene has no camera") };
    let (width, height) = camera.resolution(resolution);
    if let Some(Moments { width: old_width, height: old_height, .. }) = old.map(|o| &o.moments)
        && (width as usize * height as usize) < old_width * old_height
    {
        bail!(
            "{width} x {height} pixels would lower the check of {old_width} x {old_height}; \
             if that is meant, delete {} first",
            case.reference.display()
        );
    }
    let bounces = rotund_trace::Options::default().bounces;
    let sequence = Sequence::default();
    let mut plan = Plan { width, height, bounces, samples: FEWEST_SAMPLES, sequence };
    plan.samples = old.map_or(FEWEST_SAMPLES, |old| old.samples.max(FEWEST_SAMPLES));
    loop {
        // A first look is enough to see that more samples are needed.
        let first = Moments::measure(subject, &plan, REPLICAS, REFERENCE_SEED)?;
        if complaint(&first, pictures)?.is_some() && plan.samples < MOST_SAMPLES {
            plan.samples *= 2;
            continue;
        }
        let moments = Moments::measure(subject, &plan, REFERENCE_REPLICAS, REFERENCE_SEED)?;
        match complaint(&moments, pictures)? {
            None => {
                let surface = subject.surface(width, height);
                return Ok(Reference { moments, surface, samples: plan.samples, bounces });
            }
            Some(_) if plan.samples < MOST_SAMPLES => plan.samples *= 2,
            Some(complaint) => bail!("{complaint}"),
        }
    }
}

/// Why a picture that is as noisy as this one cannot be a reference.
fn complaint(moments: &Moments, pictures: usize) -> Result<Option<String>> {
    if moments.rejected > 0 {
        let count = moments.rejected;
        return Ok(Some(format!("{count} samples are negative, infinite or not a number")));
    }
    if moments.mean.iter().all(|pixel| pixel.max_element() == 0.0) {
        return Ok(Some("the picture is black: there is nothing to check".to_owned()));
    }
    // A check sees a picture of fewer replicas against this one, which has as many as it will have.
    let [actual, reference] =
        [REPLICAS, REFERENCE_REPLICAS].map(|replicas| Moments { replicas, ..moments.clone() });
    let energy = surest_energy(&actual, &reference);
    let sure = normal_quantile(level(3 * pictures)) + normal_quantile(2.0 * MISSED);
    let smallest_loss = sure * energy.error / energy.expected;
    if smallest_loss > SMALLEST_LOSS {
        return Ok(Some(format!(
            "the picture is so noisy that {:.1} % of the light could be lost unnoticed, {:.1} % \
             is the most; take lights that are larger or nearer, or rougher surfaces",
            100.0 * smallest_loss,
            100.0 * SMALLEST_LOSS
        )));
    }
    let flip = flip_of_noise(&actual, &reference)?;
    if flip > FLIP_CEILING {
        return Ok(Some(format!(
            "the noise can be seen: its FLIP error is {flip:.3}, {FLIP_CEILING} is the most; take \
             lights that are larger or nearer, or rougher surfaces"
        )));
    }
    Ok(None)
}

//! What a picture is, if it is a random variable: a mean and a variance for each pixel.

use crate::surface::{Probe, Surface};
use glam::{DVec3, Vec2};
use rotund_bvh::Isa;
use rotund_image::Image;
use rotund_scene::{Scene, SceneError, Trees};
use rotund_trace::{Lights, Options, RenderError, Sequence, World};

/// A scene that is ready to be looked at through its first camera.
#[derive(Debug)]
pub struct Subject {
    pub scene: Scene,
    trees: Trees,
    lights: Lights,
}

impl Subject {
    /// Builds what rays need, to be walked with these instructions.
    ///
    /// # Errors
    ///
    /// If the scene is not valid.
    pub fn new(scene: Scene, isa: Isa) -> Result<Self, SceneError> {
        let trees = Trees::build(&scene)?.with_isa(isa);
        let lights = Lights::build(&scene)?;
        Ok(Self { scene, trees, lights })
    }

    /// What there is to be seen, without light.
    ///
    /// # Panics
    ///
    /// If the scene has no camera.
    pub fn surface(&self, width: u32, height: u32) -> Surface {
        Surface::measure(width as usize, height as usize, |uv, ray| self.probe(uv, ray))
    }

    /// What one ray meets; see [`Probe::new`].
    pub fn probe(&self, image_uv: Vec2, ray: usize) -> Probe {
        Probe::new(&self.scene, &self.trees, &self.scene.cameras[0], image_uv, ray)
    }
}

/// How a picture is measured: as many small renders that differ in nothing but their seed. They are
/// independent of each other even where the samples of one render are not, so their spread says how
/// well their mean is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Segments of the longest path.
    pub bounces: u32,
    /// Samples per pixel of one replica.
    pub samples: u32,
    /// Where random numbers come from.
    pub sequence: Sequence,
}

/// Statistics of the replicas of a picture, in linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// How many renders there were.
    pub replicas: u32,
    /// Mean over the replicas, row by row.
    pub mean: Vec<DVec3>,
    /// Variance of one replica about the mean of all, estimated without bias.
    pub variance: Vec<DVec3>,
    /// Samples that were no radiance.
    pub rejected: u64,
}

impl Moments {
    /// Renders `replicas` pictures. Another `seed` gives others, independent of these.
    ///
    /// # Errors
    ///
    /// If the plan has no pixels, samples or bounces, or the scene no camera.
    pub fn measure(
        subject: &Subject,
        plan: &Plan,
        replicas: u32,
        seed: u32,
    ) -> Result<Self, RenderError> {
        let world = World::from_parts(&subject.scene, &subject.trees, &subject.lights)?;
        let mut moments = Self::empty(plan.width as usize, plan.height as usize);
        for replica in 0..replicas {
            let options = Options {
                width: plan.width,
                height: plan.height,
                samples: plan.samples,
                bounces: plan.bounces,
                seed: u64::from(seed) << 32 | u64::from(replica),
                sequence: plan.sequence,
                // The surfaces of the same picture are probed where they are.
                recenter: false,
                ..Options::default()
            };
            let film = world.render(0, &options)?;
            moments.rejected += film.rejected();
            let pixels = film.image().pixels.into_iter();
            moments.push(pixels.map(|[r, g, b, _]| DVec3::new(r.into(), g.into(), b.into())));
        }
        Ok(moments.finish())
    }

    fn empty(width: usize, height: usize) -> Self {
        let zeros = vec![DVec3::ZERO; width * height];
        Self { width, height, replicas: 0, mean: zeros.clone(), variance: zeros, rejected: 0 }
    }

    /// Adds a replica; until [`Self::finish`], `variance` holds sums of squares.
    ///
    /// Source: B. Welford, "Note on a method for calculating corrected sums of squares and products",
    /// Technometrics 4(3), 1962.
    fn push(&mut self, pixels: impl Iterator<Item = DVec3>) {
        self.replicas += 1;
        let count = f64::from(self.replicas);
        for ((mean, squares), x) in self.mean.iter_mut().zip(&mut self.variance).zip(pixels) {
            let before = x - *mean;
            *mean += before / count;
            *squares += before * (x - *mean);
        }
    }

    fn finish(mut self) -> Self {
        let freedom = f64::from(self.replicas.saturating_sub(1).max(1));
        self.variance.iter_mut().for_each(|squares| *squares /= freedom);
        self
    }

    /// The mean as a picture.
    pub fn picture(&self) -> Image {
        let pixels = self.mean.iter().map(|mean| mean.as_vec3().extend(1.0).to_array()).collect();
        Image { width: self.width as u32, height: self.height as u32, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_are_those_of_the_textbook() {
        let mut moments = Moments::empty(1, 1);
        for x in [2.0, 4.0, 4.0, 10.0] {
            moments.push([DVec3::splat(x)].into_iter());
        }
        let moments = moments.finish();
        assert_eq!(moments.mean, [DVec3::splat(5.0)]);
        let off = moments.variance[0] - DVec3::splat(12.0);
        assert!(off.abs().max_element() < 1e-12, "{off} off");
    }
}

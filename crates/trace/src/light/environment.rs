//! Sampling environments in proportion to their luminance above the mean.

use super::{luminance, mosaic::Mosaic};
use crate::distribution::Table;
use glam::{Vec2, Vec3};
use rotund_scene::{Environment, Scene, Texture};
use std::f32::consts::{PI, TAU};

/// The environments of a scene that are sampled.
///
/// A cell of the density lies between the centers of four pixels, where the look-up is bilinear.
/// The density is constant per solid angle within a cell, or within a block of cells of a
/// [`Mosaic`]. It is the mean of the cell minus the mean over all directions: BSDF samples cover
/// the constant part better, and multiple importance sampling combines both. A constant environment
/// is therefore never sampled.
///
/// Source: O. Karlík, M. Šik, P. Vévoda, T. Skřivan, J. Křivánek, "MIS Compensation: Optimizing
/// Sampling Techniques in Multiple Importance Sampling", SIGGRAPH Asia 2019.
#[derive(Clone, Debug, Default)]
pub(super) struct EnvironmentLights {
    /// Distribution of the environments, in proportion to their power above the mean.
    choice: Table,
    /// For each environment, its image if it is sampled.
    images: Vec<Option<EnvironmentImage>>,
}

#[derive(Clone, Debug)]
struct EnvironmentImage {
    environment: Environment,
    width: usize,
    height: usize,
    /// Density over columns and the cosine of the angle to the pole.
    mosaic: Mosaic,
}

impl EnvironmentLights {
    pub(super) fn new(scene: &Scene) -> Self {
        let of_environment = |environment: &Environment| {
            let texture = &scene.textures[environment.emission_tex? as usize];
            EnvironmentImage::new(environment, texture)
        };
        let images: Vec<Option<_>> = scene.environments.iter().map(of_environment).collect();
        let power = |image: &Option<EnvironmentImage>| image.as_ref().map_or(0.0, |i| i.power());
        Self { choice: Table::new(images.iter().map(power)), images }
    }

    /// Returns the number of environments of the scene.
    pub(super) fn len(&self) -> usize {
        self.images.len()
    }

    /// Returns the integral over all directions of the luminance above the mean.
    pub(super) fn power(&self) -> f32 {
        self.choice.sum
    }

    /// Samples a direction of unit length. Returns it with its density per solid angle.
    pub(super) fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        // The choice consumes the vertical number and rescales it, which keeps its stratification.
        let drawn = self.choice.draw(u.y)?;
        let image = self.images[drawn.cell].as_ref()?;
        let (direction, pdf) = image.sample(Vec2::new(u.x, drawn.rest))?;
        let of_other = |(index, other): (usize, &Option<EnvironmentImage>)| match other {
            Some(other) if index != drawn.cell => {
                self.choice.chance(index) * other.pdf(other.environment.uv(direction))
            }
            _ => 0.0,
        };
        let others: f32 = self.images.iter().enumerate().map(of_other).sum();
        Some((direction, drawn.chance * pdf + others))
    }

    /// Returns the density per solid angle of [`Self::sample`].
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let of_image = |(index, image): (usize, &Option<EnvironmentImage>)| {
            image.as_ref().map_or(0.0, |image| {
                self.choice.chance(index) * image.pdf(image.environment.uv(direction))
            })
        };
        self.images.iter().enumerate().map(of_image).sum()
    }

    /// Returns the radiance of a direction, as [`Scene::eval_environment`] does, and the density of
    /// [`Self::sample`]. Both need the texture coordinates of the direction, which are expensive.
    pub(super) fn radiance_and_pdf(&self, scene: &Scene, direction: Vec3) -> (Vec3, f32) {
        let (mut radiance, mut pdf) = (Vec3::ZERO, 0.0);
        for (index, environment) in scene.environments.iter().enumerate() {
            let Some(image) = &self.images[index] else {
                radiance += environment.radiance(scene, direction);
                continue;
            };
            let uv = environment.uv(direction);
            radiance += environment.radiance_at(scene, uv);
            pdf += self.choice.chance(index) * image.pdf(uv);
        }
        (radiance, pdf)
    }
}

impl EnvironmentImage {
    fn new(environment: &Environment, texture: &Texture) -> Option<Self> {
        let (width, height) = (texture.width as usize, texture.height as usize);
        if width == 0 || height == 0 {
            return None;
        }
        let mut pixels = Vec::with_capacity(width * height);
        texture.for_each_color(|color| {
            let bright = luminance(environment.emission * color.truncate());
            // A NaN pixel is not sampled.
            pixels.push(if bright.is_finite() { bright.max(0.0) } else { 0.0 });
        });
        let mut brightness = Vec::with_capacity(width * height);
        for row in 0..height {
            let below = &pixels[(row + 1) % height * width..][..width];
            let row = &pixels[row * width..][..width];
            let mean_between = |column: usize, right: usize| {
                0.25 * (row[column] + row[right] + below[column] + below[right])
            };
            brightness.extend((1..width).map(|right| mean_between(right - 1, right)));
            brightness.push(mean_between(width - 1, 0));
        }
        let edges: Vec<f32> =
            (0..=height).map(|edge| (edge as f32 / height as f32 * PI).cos()).collect();
        let of_row = |(row, cells): (usize, &[f32])| {
            let sum: f64 = cells.iter().map(|&cell| f64::from(cell)).sum();
            sum * f64::from(edges[row] - edges[row + 1])
        };
        let total: f64 = brightness.chunks_exact(width).enumerate().map(of_row).sum();
        let mean = (total / (2.0 * width as f64)) as f32;
        for cell in &mut brightness {
            *cell = (*cell - mean).max(0.0);
        }
        let mosaic = Mosaic::new(width, edges, &brightness);
        let image = Self { environment: environment.clone(), width, height, mosaic };
        (image.mosaic.sum > 0.0).then_some(image)
    }

    fn power(&self) -> f32 {
        (self.mosaic.sum / f64::from(self.columns_per_radian())) as f32
    }

    fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (place, density) = self.mosaic.draw(u)?;
        let cosine = place.y;
        let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        let (sin, cos) = (TAU * place.x / self.width as f32).sin_cos();
        let local = Vec3::new(sine * cos, cosine, sine * sin);
        let direction = self.environment.world_from_environment.transform_vector3(local);
        Some((direction.normalize(), density * self.columns_per_radian()))
    }

    /// Returns the density per solid angle at texture coordinates.
    fn pdf(&self, uv: Vec2) -> f32 {
        let cell = |x: f32, size: usize| ((x * size as f32) as usize).min(size - 1);
        let (column, row) = (cell(uv.x, self.width), cell(uv.y, self.height));
        self.mosaic.density(column, row) * self.columns_per_radian()
    }

    fn columns_per_radian(&self) -> f32 {
        self.width as f32 / TAU
    }
}

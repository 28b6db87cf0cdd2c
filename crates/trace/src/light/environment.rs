//! Light from infinitely far away, drawn where an image is brighter than its mean.

use crate::distribution::{Grid, Table};
use glam::{Vec2, Vec3};
use rotund_scene::{Environment, Scene, Texture};
use std::f32::consts::{PI, TAU};

use super::luminance;

/// The environments of a scene that are worth drawing from.
///
/// A cell of the density is what four pixels enclose, since between them the look-up is bilinear; it
/// is constant per solid angle within a cell. From each cell's mean the mean over all directions is
/// taken away: that part has no bright spots, so the BSDF samples do it better, and multiple
/// importance sampling lets each do its part. A constant environment is thus never drawn from.
///
/// Source: O. Karlík, M. Šik, P. Vévoda, T. Skřivan, J. Křivánek, "MIS Compensation: Optimizing
/// Sampling Techniques in Multiple Importance Sampling", SIGGRAPH Asia 2019.
#[derive(Clone, Debug, Default)]
pub(super) struct EnvironmentLights {
    /// Which of `images`, by what they add to the light of a surface.
    choice: Table,
    images: Vec<EnvironmentImage>,
}

#[derive(Clone, Debug)]
struct EnvironmentImage {
    environment: Environment,
    width: usize,
    height: usize,
    /// Cosines of the angle to the pole at the upper edge of each row, and at the lower of the last.
    edges: Vec<f32>,
    grid: Grid,
}

impl EnvironmentLights {
    pub(super) fn new(scene: &Scene) -> Self {
        let images: Vec<EnvironmentImage> = scene
            .environments
            .iter()
            .filter_map(|environment| {
                let texture = &scene.textures[environment.emission_tex? as usize];
                EnvironmentImage::new(environment, texture)
            })
            .collect();
        Self { choice: Table::new(images.iter().map(|image| image.grid.sum())), images }
    }

    /// The integral of the luminance above the mean over all directions.
    pub(super) fn power(&self) -> f32 {
        self.choice.sum
    }

    /// A direction, of unit length, and its density per solid angle.
    pub(super) fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        // The choice takes the vertical number and leaves it as even as it was.
        let drawn = self.choice.draw(u.y)?;
        let (direction, pdf) = self.images[drawn.cell].sample(Vec2::new(u.x, drawn.rest))?;
        let others: f32 = (0..self.images.len())
            .filter(|&image| image != drawn.cell)
            .map(|image| self.choice.chance(image) * self.images[image].pdf(direction))
            .sum();
        Some((direction, drawn.chance * pdf + others))
    }

    /// The density of [`Self::sample`].
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let of_one = |(index, image): (usize, &EnvironmentImage)| {
            self.choice.chance(index) * image.pdf(direction)
        };
        self.images.iter().enumerate().map(of_one).sum()
    }
}

impl EnvironmentImage {
    fn new(environment: &Environment, texture: &Texture) -> Option<Self> {
        let (width, height) = (texture.width as usize, texture.height as usize);
        if width == 0 || height == 0 {
            return None;
        }
        let mut image = Self {
            environment: environment.clone(),
            width,
            height,
            edges: (0..=height).map(|edge| (edge as f32 / height as f32 * PI).cos()).collect(),
            grid: Grid::new(0, 0, |_, _| 0.0),
        };
        let at = |column: usize, row: usize| {
            let color = texture.color_at((column % width) as u32, (row % height) as u32);
            let bright = luminance(environment.emission * color.truncate());
            // A pixel that is not a number is not worth drawing.
            if bright.is_finite() { bright.max(0.0) } else { 0.0 }
        };
        let mean_of_cell = |column: usize, row: usize| {
            0.25 * (at(column, row)
                + at(column + 1, row)
                + at(column, row + 1)
                + at(column + 1, row + 1))
        };
        let total: f64 = (0..height)
            .map(|row| {
                let sum: f64 = (0..width).map(|column| f64::from(mean_of_cell(column, row))).sum();
                sum * f64::from(image.solid_angle(row))
            })
            .sum();
        let mean = (total / f64::from(4.0 * PI)) as f32;
        image.grid = Grid::new(width, height, |column, row| {
            (mean_of_cell(column, row) - mean).max(0.0) * image.solid_angle(row)
        });
        (image.grid.sum() > 0.0).then_some(image)
    }

    /// Of one cell of a row.
    fn solid_angle(&self, row: usize) -> f32 {
        let (upper, lower) = (self.edges[row], self.edges[row + 1]);
        TAU / self.width as f32 * (upper - lower)
    }

    fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let ([column, row], chance, place) = self.grid.draw(u)?;
        let (upper, lower) = (self.edges[row], self.edges[row + 1]);
        let cosine = upper + place.y * (lower - upper);
        let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        let azimuth = TAU * (column as f32 + place.x) / self.width as f32;
        let local = Vec3::new(sine * azimuth.cos(), cosine, sine * azimuth.sin());
        let direction = self.environment.world_from_environment.transform_vector3(local);
        Some((direction.normalize(), chance / self.solid_angle(row)))
    }

    fn pdf(&self, direction: Vec3) -> f32 {
        let uv = self.environment.uv(direction);
        let cell = |x: f32, size: usize| ((x * size as f32) as usize).min(size - 1);
        let (column, row) = (cell(uv.x, self.width), cell(uv.y, self.height));
        self.grid.chance(column, row) / self.solid_angle(row)
    }
}

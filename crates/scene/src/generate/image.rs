//! Generated textures: test grids, bumps and the sky.

use super::{STEPS, Unfit, count, positive};
use crate::{Pixels, Texture};
use glam::{Mat3, Vec3};
use rotund_image::srgb_from_linear;
use serde::Deserialize;
use std::f32::consts::PI;

/// Squares of distinct hues under a fine white grid.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct UvGrid {
    /// Size of a side in pixels.
    size: u32,
}

impl UvGrid {
    pub(super) fn build(&self) -> Result<Texture, Unfit> {
        square_of_bytes(self.size, |u, v| {
            // Hues increase from cell to cell along a row, and continue in the next row up.
            let (column, row) = ((u * 8.0) as u32, ((1.0 - v) * 8.0).min(7.0) as u32);
            let hue = (column + (row + 5) % 8 * 8) as f32 / 64.0;
            let near_line = |x: f32| {
                let x = (x * 16.0).fract();
                x <= 0.005 || x >= 0.995
            };
            if near_line(u) || near_line(v) {
                rgb_from_hsv(hue, 0.2, 0.8)
            } else {
                rgb_from_hsv(hue, 0.8, if (column + row) % 2 == 0 { 0.55 } else { 0.45 })
            }
        })
    }
}

/// Light grey tiles with dark joints and a black frame, eight to a side.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FloorGrid {
    /// Size of a side in pixels.
    pub(super) size: u32,
}

impl FloorGrid {
    pub(super) fn build(&self) -> Result<Texture, Unfit> {
        square_of_bytes(self.size, |u, v| {
            let frame = |x: f32| !(0.0025..=0.9975).contains(&x);
            let joint = |x: f32| (x * 8.0 - (x * 8.0).round()).abs() <= 0.01;
            if frame(u) || frame(v) {
                Vec3::ZERO
            } else if joint(u) || joint(v) {
                Vec3::splat(0.2)
            } else {
                Vec3::splat(0.5)
            }
        })
    }
}

fn square_of_bytes(size: u32, color: impl Fn(f32, f32) -> Vec3) -> Result<Texture, Unfit> {
    let size = count("size", size, STEPS)?;
    let mut pixels = Vec::with_capacity(size as usize * size as usize);
    for y in 0..size {
        for x in 0..size {
            let [r, g, b] = color(x as f32 / size as f32, y as f32 / size as f32)
                .to_array()
                // As in yocto-gl, each byte covers an equal share of the range.
                .map(|linear| (srgb_from_linear(linear) * 256.0).min(255.0) as u8);
            pixels.push([r, g, b, 255]);
        }
    }
    Ok(Texture { name: String::new(), width: size, height: size, pixels: Pixels::Bytes(pixels) })
}

fn rgb_from_hsv(hue: f32, saturation: f32, value: f32) -> Vec3 {
    // Distances of the hue from red, green and blue around the circle, in sixths.
    let channel = |own: f32| {
        let distance = (hue * 6.0 - own).rem_euclid(6.0);
        let full = (distance.min(6.0 - distance) - 1.0).clamp(0.0, 1.0);
        value * (1.0 - saturation * full)
    };
    Vec3::new(channel(0.0), channel(2.0), channel(4.0))
}

/// Round bumps in rows and columns, as a normal map or as their heights for displacement.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Bumps {
    /// Size of a side in pixels.
    size: u32,
    /// Number of bumps along a side.
    bumps: u32,
    /// Height of each bump over its width.
    height: f32,
    /// Grey heights instead of normals; the top is white.
    #[serde(default)]
    displacement: bool,
}

impl Bumps {
    pub(super) fn build(&self) -> Result<Texture, Unfit> {
        let size = count("size", self.size, STEPS)?;
        let bumps = count("bumps", self.bumps, STEPS)? as f32;
        let height = positive("height", self.height)?;
        let mut pixels = Vec::with_capacity(size as usize * size as usize);
        for y in 0..size {
            for x in 0..size {
                // Offset from the centre of the bump, in units of its width, with y up.
                let place = |i: u32| (i as f32 * bumps / size as f32).fract() - 0.5;
                let (x, y) = (place(x), -place(y));
                // The bump is `height (1 - 4 r²)²`, flat at its rim.
                let flank = (1.0 - 4.0 * (x * x + y * y)).max(0.0);
                if self.displacement {
                    let grey = (flank * flank * 255.0).round() as u8;
                    pixels.push([grey, grey, grey, 255]);
                    continue;
                }
                let slope = -16.0 * height * flank;
                let normal = Vec3::new(-slope * x, -slope * y, 1.0).normalize();
                let [r, g, b] = normal.to_array().map(|c| ((0.5 * c + 0.5) * 255.0).round() as u8);
                pixels.push([r, g, b, 255]);
            }
        }
        let pixels = Pixels::Bytes(pixels);
        Ok(Texture { name: String::new(), width: size, height: size, pixels })
    }
}

/// A clear sky without the disc of the sun, over a diffuse ground.
///
/// Source: A. J. Preetham, P. Shirley, B. Smits, "A Practical Analytic Model for Daylight",
/// SIGGRAPH
/// 1999. Its tables are in the appendix of the paper.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sky {
    /// Width in pixels; the height is half of it.
    pub(super) width: u32,
    /// Elevation of the sun above the horizon, in the direction +z.
    pub(super) sun_elevation_degrees: f32,
    /// Haziness: 2 is very clear, 6 hazy.
    pub(super) turbidity: f32,
    /// Albedo of the ground.
    #[serde(default)]
    pub(super) ground_albedo: f32,
}

impl Sky {
    pub(super) fn build(&self) -> Result<Texture, Unfit> {
        let width = count("width", self.width, STEPS)?;
        let turbidity = positive("turbidity", self.turbidity)?;
        let elevation = self.sun_elevation_degrees;
        if !(0.0..=90.0).contains(&elevation) {
            let expected = "between 0 and 90";
            let parameter = "sun_elevation_degrees";
            return Err(Unfit { parameter, value: elevation.to_string(), expected });
        }
        let model = Daylight::new((90.0 - elevation).to_radians(), turbidity);
        let height = (width / 2).max(1);
        let mut pixels = vec![[0.0, 0.0, 0.0, 1.0]; width as usize * height as usize];
        let above = height / 2;
        let mut irradiance = Vec3::ZERO;
        let pixel_area = (PI / height as f32) * (2.0 * PI / width as f32);
        for y in 0..above {
            let theta = PI * (y as f32 + 0.5) / height as f32;
            let row = &mut pixels[(y * width) as usize..((y + 1) * width) as usize];
            for (x, pixel) in row.iter_mut().enumerate() {
                let phi = 2.0 * PI * (x as f32 + 0.5) / width as f32;
                let toward_z = theta.sin() * phi.sin();
                let radiance = model.radiance(theta, toward_z);
                irradiance += radiance * (theta.sin() * theta.cos() * pixel_area);
                *pixel = radiance.extend(1.0).to_array();
            }
        }
        let ground = (self.ground_albedo / PI * irradiance).extend(1.0).to_array();
        pixels[(above * width) as usize..].fill(ground);
        Ok(Texture { name: String::new(), width, height, pixels: Pixels::Floats(pixels) })
    }
}

/// Perez's distribution of luminance and of the chromaticities x and y, each scaled to its value at
/// the zenith.
struct Daylight {
    sun: f32,
    zenith: [f32; 3],
    /// The five parameters of Perez for Y, x and y.
    perez: [[f32; 5]; 3],
}

impl Daylight {
    fn new(sun: f32, turbidity: f32) -> Self {
        // Each parameter is linear in the turbidity.
        const PEREZ: [[[f32; 2]; 5]; 3] = [
            [
                [0.1787, -1.4630],
                [-0.3554, 0.4275],
                [-0.0227, 5.3251],
                [0.1206, -2.5771],
                [-0.0670, 0.3703],
            ],
            [
                [-0.0193, -0.2592],
                [-0.0665, 0.0008],
                [-0.0004, 0.2125],
                [-0.0641, -0.8989],
                [-0.0033, 0.0452],
            ],
            [
                [-0.0167, -0.2608],
                [-0.0950, 0.0092],
                [-0.0079, 0.2102],
                [-0.0441, -1.6537],
                [-0.0109, 0.0529],
            ],
        ];
        // Cubics in the angle of the sun, for the powers 2, 1 and 0 of the turbidity.
        const ZENITH_X: [[f32; 4]; 3] = [
            [0.001_66, -0.003_75, 0.002_09, 0.0],
            [-0.029_03, 0.063_77, -0.032_02, 0.003_94],
            [0.116_93, -0.211_96, 0.060_52, 0.258_86],
        ];
        const ZENITH_Y: [[f32; 4]; 3] = [
            [0.002_75, -0.006_10, 0.003_17, 0.0],
            [-0.042_14, 0.089_70, -0.041_53, 0.005_16],
            [0.153_46, -0.267_56, 0.066_70, 0.266_88],
        ];
        let horner = |c: &[f32; 4]| ((c[0] * sun + c[1]) * sun + c[2]) * sun + c[3];
        let chromaticity = |table: &[[f32; 4]; 3]| {
            let [square, linear, constant] = table.each_ref().map(horner);
            (square * turbidity + linear) * turbidity + constant
        };
        let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * sun);
        // Kilocandela per square meter, scaled by a tenth to radiance of about 1.
        let luminance = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
        Self {
            sun,
            zenith: [0.1 * luminance, chromaticity(&ZENITH_X), chromaticity(&ZENITH_Y)],
            perez: PEREZ.map(|table| table.map(|[slope, at_zero]| slope * turbidity + at_zero)),
        }
    }

    /// Returns linear RGB for the direction at `theta` from the zenith, whose component along +z is
    /// `toward_z`.
    fn radiance(&self, theta: f32, toward_z: f32) -> Vec3 {
        let toward_sun = toward_z * self.sun.sin() + theta.cos() * self.sun.cos();
        let gamma = toward_sun.clamp(-1.0, 1.0).acos();
        let distribution = |[a, b, c, d, e]: [f32; 5], theta: f32, gamma: f32| {
            // The model is not defined at the horizon itself.
            (1.0 + a * (b / theta.cos().max(0.001)).exp())
                * (1.0 + c * (d * gamma).exp() + e * gamma.cos() * gamma.cos())
        };
        let [luminance, x, y]: [f32; 3] = std::array::from_fn(|i| {
            self.zenith[i] * distribution(self.perez[i], theta, gamma)
                / distribution(self.perez[i], 0.0, self.sun)
        });
        let xyz = Vec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        // Conversion to the primaries of sRGB (IEC 61966-2-1).
        let rgb = Mat3::from_cols(
            Vec3::new(3.2406, -0.9689, 0.0557),
            Vec3::new(-1.5372, 1.8758, -0.2040),
            Vec3::new(-0.4986, 0.0415, 1.0570),
        ) * xyz;
        rgb.max(Vec3::ZERO)
    }
}

//! Draws a rounded cone in the terminal: the exact shape and the ribbon that approximates it.
//!
//! `cargo run --example silhouettes -p rotund-geometry`
#![expect(clippy::print_stdout, reason = "an example prints")]

use rotund_geometry::glam::Vec3;
use rotund_geometry::{Ray, RoundedCone, vanilla};

fn main() {
    let (p0, r0, p1, r1) = (Vec3::new(-0.7, -0.3, 0.0), 0.5, Vec3::new(0.9, 0.4, 0.6), 0.2);
    let exact = RoundedCone { p0, r0, p1, r1 };
    let ribbon = vanilla::Line { p0, r0, p1, r1 };
    println!("{:<44}a ribbon, facing each ray", "the convex hull of two balls");
    for row in 0..22_u8 {
        let mut line = String::new();
        for ray in (0..88_u8).map(|column| {
            let x = f32::from(column % 44) / 16.0 - 1.35;
            Ray::new(Vec3::new(x, 1.1 - f32::from(row) / 10.0, 5.0), Vec3::NEG_Z)
        }) {
            let hit = if line.len() < 44 { exact.closest(&ray) } else { ribbon.closest(&ray) };
            let light = Vec3::new(-0.6, 0.6, 0.5);
            let shade = |hit: rotund_geometry::Hit| {
                char::from(b".:-=+*#%@"[(8.0 * hit.normal.dot(light).clamp(0.0, 1.0)) as usize])
            };
            line.push(hit.map_or(' ', shade));
        }
        println!("{}", line.trim_end());
    }
}

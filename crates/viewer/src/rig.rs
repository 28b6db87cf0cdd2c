//! Movements of a camera by hand.

use crate::message::Motion;
use glam::{Affine3A, Mat3A, Quat, Vec2, Vec3, Vec3A};
use rotund_scene::Camera;
use std::f32::consts::PI;

/// A camera with the point that it turns about.
#[derive(Clone, Debug)]
pub(crate) struct Rig {
    pub(crate) camera: Camera,
    /// Orbits turn about it, pans move with it, and steps of flight are in units of its distance.
    pub(crate) pivot: Vec3,
}

/// Radians that a movement over the height of the picture turns the camera.
const TURN: f32 = PI;
/// Largest sine of the angle between view and horizon that a movement leads to: straight up and
/// down, right and left are undefined.
const STEEPEST: f32 = 0.9995;
/// Distances of the pivot from the eye, in units of the largest coordinate, below which single
/// precision shows.
const NEAREST: f32 = 1e-6;

impl Rig {
    pub(crate) fn new(camera: Camera, pivot: Vec3) -> Self {
        Self { camera, pivot }
    }

    fn eye(&self) -> Vec3 {
        self.camera.world_from_camera.translation.into()
    }

    fn axes(&self) -> [Vec3; 3] {
        let Mat3A { x_axis, y_axis, z_axis } = self.camera.world_from_camera.matrix3;
        [x_axis, y_axis, z_axis].map(Vec3::from)
    }

    /// Returns the distance of the pivot along the view; positive.
    pub(crate) fn depth(&self) -> f32 {
        let [_, _, back] = self.axes();
        let depth = (self.eye() - self.pivot).dot(back);
        let least = NEAREST * self.eye().abs().max(self.pivot.abs()).max_element();
        if depth > least { depth } else { self.eye().distance(self.pivot).max(least).max(1e-12) }
    }

    /// Returns the height in meters that the picture shows at the depth of the pivot.
    fn height(&self) -> f32 {
        let Camera { aspect, film, lens, orthographic, .. } = self.camera;
        let film = if aspect >= 1.0 { film / aspect } else { film };
        if orthographic { film / lens } else { self.depth() * film / lens }
    }

    /// Returns the point below a point of the picture, at the depth of the pivot.
    pub(crate) fn below(&self, at: [f32; 2]) -> Vec3 {
        let [_, _, back] = self.axes();
        let pinhole = Camera { aperture: 0.0, ..self.camera.clone() };
        let ray = pinhole.ray(Vec2::from(at), Vec2::ZERO);
        let along = -ray.direction.dot(back);
        if along > 1e-6 { ray.origin + ray.direction * (self.depth() / along) } else { self.pivot }
    }

    /// Moves the camera. `target` is the surface below [`Motion::at`] that zooming approaches.
    pub(crate) fn apply(&mut self, motion: &Motion, target: Option<Vec3>) {
        let [dx, dy] = motion.orbit;
        if [dx, dy] != [0.0; 2] {
            let turn = self.turn(dx * TURN, dy * TURN);
            let from_pivot = turn * (self.eye() - self.pivot);
            self.rotate(turn);
            self.camera.world_from_camera.translation = (self.pivot + from_pivot).into();
        }
        let [dx, dy] = motion.look;
        if [dx, dy] != [0.0; 2] {
            let turn = self.turn(dx * TURN, dy * TURN);
            let to_pivot = turn * (self.pivot - self.eye());
            self.rotate(turn);
            self.pivot = self.eye() + to_pivot;
        }
        let [right, up, back] = self.axes();
        let [dx, dy] = motion.pan;
        if [dx, dy] != [0.0; 2] {
            self.translate(self.height() * (dy * up - dx * right));
        }
        let [x, y, z] = motion.fly;
        if [x, y, z] != [0.0; 3] {
            self.translate(self.depth() * (x * right + y * up - z * back));
        }
        if motion.zoom != 0.0 {
            let factor = (-motion.zoom.clamp(-8.0, 8.0)).exp2();
            let target = target.unwrap_or_else(|| self.below(motion.at.unwrap_or([0.5; 2])));
            self.zoom(factor, target);
        }
    }

    /// Moves the eye towards `target`, to `factor` of the distance.
    fn zoom(&mut self, factor: f32, target: Vec3) {
        let toward = |p: Vec3| target + factor * (p - target);
        let eye = toward(self.eye());
        // Nearer, single precision has no steps left.
        let least = NEAREST * target.abs().max_element();
        if factor < 1.0 && eye.distance(target) <= least {
            return;
        }
        if self.camera.orthographic {
            // The size changes by the film, and the eye moves across the view only.
            let [_, _, back] = self.axes();
            let step = eye - self.eye();
            self.camera.film *= factor;
            self.translate(step - back * step.dot(back));
            return;
        }
        self.pivot = toward(self.pivot);
        self.camera.focus *= factor;
        self.camera.world_from_camera.translation = eye.into();
    }

    /// Turns to `target` and focuses on it; keeps the eye.
    pub(crate) fn focus(&mut self, target: Vec3) {
        let distance = self.eye().distance(target);
        if distance.is_nan() || distance <= 0.0 {
            return;
        }
        if self.camera.orthographic {
            let [_, _, back] = self.axes();
            let step = target - self.eye();
            self.translate(step - back * step.dot(back));
        } else {
            self.face((self.eye() - target) / distance);
        }
        self.pivot = target;
        self.camera.focus = distance;
    }

    /// Moves back until a ball is in the picture; keeps the direction of the view.
    pub(crate) fn frame(&mut self, center: Vec3, radius: f32) {
        let [_, _, back] = self.axes();
        let Camera { aspect, film, lens, orthographic, .. } = self.camera;
        let shorter = film * aspect.min(1.0 / aspect);
        // Half the shorter side of the film over the lens is the tangent of half the field of view.
        let tangent = 0.5 * shorter / lens;
        let distance = 1.1 * radius * (1.0 + tangent * tangent).sqrt() / tangent;
        if orthographic {
            self.camera.film *= 2.2 * radius / (shorter / lens);
        }
        let distance = if orthographic { 4.0 * radius } else { distance };
        self.pivot = center;
        self.camera.focus = distance;
        self.camera.world_from_camera.translation = (center + distance * back).into();
    }

    /// Widens the field of view, if need be, such that a picture of another aspect shows all that
    /// the camera frames: a phone held upright would cut off the sides.
    pub(crate) fn widen_to(&mut self, aspect: f32) {
        // Sides of the film in parts of the longer one.
        let sides = |aspect: f32| [aspect.min(1.0), aspect.recip().min(1.0)];
        let (own, other) = (sides(self.camera.aspect), sides(aspect));
        self.camera.lens /= (own[0] / other[0]).max(own[1] / other[1]);
    }

    /// Returns the rotation that turns the view right and down by these angles, bounded so that the
    /// view does not become vertical.
    fn turn(&self, right: f32, down: f32) -> Quat {
        let [side, up, back] = self.axes();
        // A camera that is upside down turns the other way.
        let [right, down] = if up.y < 0.0 { [-right, -down] } else { [right, down] };
        let now = back.y.clamp(-1.0, 1.0).asin();
        let steepest = STEEPEST.asin().max(now.abs());
        let rise = (now + down).clamp(-steepest, steepest) - now;
        let level = Vec3::Y.cross(back);
        let level = if level.length_squared() > 1e-6 { level.normalize() } else { side };
        Quat::from_rotation_y(-right) * Quat::from_axis_angle(level, -rise)
    }

    /// Turns the axes.
    fn rotate(&mut self, turn: Quat) {
        let [_, _, back] = self.axes();
        let [right, up, _] = self.axes().map(|axis| turn * axis);
        self.set_axes(right, up, turn * back);
    }

    /// Makes the view run along `-back`, with the horizon level unless the view is vertical.
    fn face(&mut self, back: Vec3) {
        let [right, up, _] = self.axes();
        let side = if up.y < 0.0 { Vec3::NEG_Y } else { Vec3::Y }.cross(back);
        let right = if side.length_squared() > 1e-6 { side } else { right };
        self.set_axes(right, back.cross(right), back);
    }

    /// Makes the axes orthonormal, so that the errors of many movements do not add up.
    fn set_axes(&mut self, right: Vec3, up: Vec3, back: Vec3) {
        let back = back.normalize_or(Vec3::Z);
        let right = (right - back * right.dot(back)).try_normalize();
        let right =
            right.unwrap_or_else(|| up.cross(back).normalize_or(back.any_orthonormal_vector()));
        let axes = Mat3A::from_cols(right.into(), back.cross(right).into(), back.into());
        let translation: Vec3A = self.camera.world_from_camera.translation;
        self.camera.world_from_camera = Affine3A { matrix3: axes, translation };
    }

    fn translate(&mut self, step: Vec3) {
        self.camera.world_from_camera.translation += Vec3A::from(step);
        self.pivot += step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig() -> Rig {
        Rig::new(Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::ZERO, Vec3::Y), Vec3::ZERO)
    }

    /// Returns where the picture shows a point, as the camera's inverse says.
    fn shown_at(camera: &Camera, point: Vec3) -> [f32; 2] {
        let p = camera.world_from_camera.inverse().transform_point3(point);
        let longer = if camera.orthographic { p.truncate() } else { p.truncate() / -p.z };
        let on_film = longer * camera.lens / camera.film;
        let (wide, high) = (camera.aspect.min(1.0), camera.aspect.max(1.0));
        [0.5 + on_film.x / wide, 0.5 - on_film.y * high]
    }

    fn near(a: [f32; 2], b: [f32; 2]) -> bool {
        Vec2::from(a).distance(Vec2::from(b)) < 1e-4
    }

    fn assert_rigid(camera: &Camera) {
        let matrix = camera.world_from_camera.matrix3;
        let error = matrix.transpose() * matrix - Mat3A::IDENTITY;
        assert!(error.x_axis.length() + error.y_axis.length() + error.z_axis.length() < 1e-5);
        assert!((matrix.determinant() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn an_orbit_keeps_distance_and_the_place_of_the_pivot_in_the_picture() {
        let mut rig = rig();
        rig.pivot = Vec3::new(0.4, 0.1, 0.3);
        let (before, distance) = (shown_at(&rig.camera, rig.pivot), rig.eye().distance(rig.pivot));
        for step in 0..1000 {
            let orbit = [0.03, if step % 40 < 20 { 0.02 } else { -0.02 }];
            rig.apply(&Motion { orbit, ..Motion::default() }, None);
        }
        assert!((rig.eye().distance(rig.pivot) - distance).abs() < 1e-3);
        assert!(near(shown_at(&rig.camera, rig.pivot), before));
        assert_rigid(&rig.camera);
        let [right, _, _] = rig.axes();
        assert!(right.y.abs() < 1e-3, "the horizon stays level");
    }

    #[test]
    fn a_hand_that_moves_right_and_down_takes_the_surface_with_it() {
        // A point on the near side of the pivot goes with the hand, whichever way it turns.
        let near_side = Vec3::new(0.2, 0.4, 1.0);
        let mut moved = rig();
        let before = shown_at(&moved.camera, near_side);
        moved.apply(&Motion { orbit: [0.02, 0.02], ..Motion::default() }, None);
        let after = shown_at(&moved.camera, near_side);
        assert!(after[0] > before[0] && after[1] > before[1], "{before:?} {after:?}");
        // To look right and down moves everything the other way.
        let mut turned = rig();
        turned.apply(&Motion { look: [0.02, 0.02], ..Motion::default() }, None);
        let after = shown_at(&turned.camera, near_side);
        assert!(after[0] < before[0] && after[1] < before[1], "{before:?} {after:?}");
    }

    #[test]
    fn a_picture_of_another_aspect_shows_all_that_the_camera_frames() {
        let corners = |camera: &Camera| {
            let ends = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
            ends.map(|at| {
                let ray = camera.ray(at, Vec2::ZERO);
                ray.origin + 3.0 * ray.direction
            })
        };
        for (own, other) in [(1.5, 0.5), (1.5, 3.0), (1.5, 1.2), (0.5, 2.0), (3.0, 0.46)] {
            let mut rig = rig();
            rig.camera.aspect = own;
            let corners = corners(&rig.camera);
            rig.widen_to(other);
            rig.camera.aspect = other;
            let seen = corners.map(|corner| shown_at(&rig.camera, corner));
            let wide = |axis: usize| seen.map(|at| at[axis]).into_iter().fold(0.0, f32::max);
            assert!(wide(0).max(wide(1)) < 1.0 + 1e-4, "{own} in {other}: {seen:?}");
            assert!(wide(0).max(wide(1)) > 1.0 - 1e-4, "{own} in {other} is too wide: {seen:?}");
        }
    }

    #[test]
    fn no_orbit_passes_the_vertical() {
        for sign in [1.0, -1.0] {
            let mut rig = rig();
            for _ in 0..100 {
                rig.apply(&Motion { orbit: [0.01, 0.1 * sign], ..Motion::default() }, None);
                let [_, up, back] = rig.axes();
                assert!(up.y > 0.0 && back.is_finite());
            }
            assert_rigid(&rig.camera);
        }
    }

    #[test]
    fn a_pan_moves_what_was_grabbed_by_as_much_as_the_hand() {
        for camera in [rig().camera, rig().camera.orthographic(7.0)] {
            let mut rig = Rig::new(camera, Vec3::new(0.3, 0.2, 0.1));
            let before = shown_at(&rig.camera, rig.pivot);
            let grabbed = rig.pivot;
            rig.apply(&Motion { pan: [0.15, -0.1], ..Motion::default() }, None);
            let after = shown_at(&rig.camera, grabbed);
            let [dx, dy] = [after[0] - before[0], after[1] - before[1]];
            assert!((dx - 0.15 / rig.camera.aspect).abs() < 1e-4 && (dy + 0.1).abs() < 1e-4);
        }
    }

    #[test]
    fn a_zoom_keeps_what_is_below_the_pointer_there_and_halves_its_distance() {
        for camera in [rig().camera, rig().camera.orthographic(7.0)] {
            let orthographic = camera.orthographic;
            let mut rig = Rig::new(camera, Vec3::ZERO);
            let target = Vec3::new(0.7, -0.3, 0.5);
            let (at, distance) = (shown_at(&rig.camera, target), rig.eye().distance(target));
            let film = rig.camera.film;
            rig.apply(&Motion { zoom: 1.0, at: Some(at), ..Motion::default() }, Some(target));
            assert!(near(shown_at(&rig.camera, target), at));
            if orthographic {
                assert!((rig.camera.film / film - 0.5).abs() < 1e-5);
            } else {
                assert!((rig.eye().distance(target) / distance - 0.5).abs() < 1e-5);
            }
            rig.apply(&Motion { zoom: -1.0, at: Some(at), ..Motion::default() }, Some(target));
            assert!((rig.eye().distance(target) - distance).abs() < 1e-4);
        }
    }

    #[test]
    fn a_zoom_without_end_never_leaves_the_numbers() {
        let mut rig = rig();
        for _ in 0..2000 {
            rig.apply(&Motion { zoom: 1.0, ..Motion::default() }, Some(Vec3::ONE));
            assert!(rig.camera.validate().is_ok());
        }
        assert!(rig.eye().distance(Vec3::ONE) > 0.0, "the eye never reaches the surface");
    }

    #[test]
    fn focus_centers_the_surface_and_frame_shows_a_whole_ball() {
        let mut rig = rig();
        let target = Vec3::new(2.0, 1.0, -1.0);
        rig.focus(target);
        assert!(near(shown_at(&rig.camera, target), [0.5, 0.5]));
        assert!((rig.camera.focus - rig.eye().distance(target)).abs() < 1e-5);
        rig.frame(target, 3.0);
        let [right, up, _] = rig.axes();
        for edge in [3.0 * right, -3.0 * right, 3.0 * up, -3.0 * up] {
            let at = shown_at(&rig.camera, target + edge);
            assert!(at.iter().all(|x| (0.0..=1.0).contains(x)), "{at:?}");
        }
    }
}

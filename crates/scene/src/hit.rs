//! Hits of rays and scenes.

use glam::{Vec2, Vec3};
use rotund_geometry::{Hit, Ray};

/// A point where a ray meets a surface of a scene, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// Index into [`crate::Scene::instances`].
    pub instance: u32,
    /// Index into the elements of the instance's shape.
    pub element: u32,
    /// Parameters of the point on the element. [`crate::Scene::eval_position`] rebuilds `position`
    /// from them, except for vanilla points and lines, whose position depends on the ray.
    pub uv: Vec2,
    /// Position along the ray, in units of its direction.
    pub t: f32,
    /// The point, within `error` of the surface.
    pub position: Vec3,
    /// Geometric normal of unit length, out of the solid whichever side the ray came from.
    pub normal: Vec3,
    /// Bound on the distance along `normal` from `position` to the surface. It covers the rounding
    /// of the transforms to object space and back, and the curvature of the surface along which
    /// rounding moves. [`Self::spawn`] steps off the surface by it, to either side of surfaces
    /// whose radius of curvature is not below a few roundings of the position: 10 if the frame
    /// only moves the instance, 40 in others, and more where a frame stretches.
    pub error: f32,
}

impl SceneHit {
    /// Returns the ray from this point in `direction`, of any length, that does not meet the
    /// surface it starts on again by rounding. It starts on the side that `direction` points to.
    ///
    /// ```
    /// use rotund_scene::{Material, Scene, Shape, Trees};
    /// use rotund_scene::geometry::{Ray, glam::Vec3};
    ///
    /// let mut scene = Scene::default();
    /// scene.add(Shape::points([Vec3::ZERO], 1.0), Material::default());
    /// let trees = Trees::build(&scene)?;
    /// let ray = Ray::new(Vec3::new(0.3, 0.2, 5.0), Vec3::NEG_Z);
    /// let hit = trees.closest(&scene, &ray).expect("aimed at it");
    /// assert!(!trees.any(&scene, &hit.spawn(ray.direction.reflect(hit.normal))));
    /// assert!(trees.any(&scene, &hit.spawn(ray.direction)), "the far side");
    /// # Ok::<(), rotund_scene::SceneError>(())
    /// ```
    #[must_use]
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        self.plain().spawn(direction)
    }

    /// Returns the ray from this point towards `point`, which is at `t = 1`, for visibility tests.
    /// It starts as [`Self::spawn`] does, and ends just before `point`, so that a surface there
    /// does not count: [`Hit::spawn_to`] states the distance and its limits.
    #[must_use]
    #[inline]
    pub fn spawn_to(&self, point: Vec3) -> Ray {
        self.plain().spawn_to(point)
    }

    /// Returns the instance whose outside a ray from this point in `direction` is on, for
    /// [`crate::Trees::closest_after`]; `None` if the ray goes inside.
    #[must_use]
    #[inline]
    pub fn left_by(&self, direction: Vec3) -> Option<u32> {
        (self.normal.dot(direction) >= 0.0).then_some(self.instance)
    }

    /// Returns the hit without its instance and element.
    #[inline]
    fn plain(&self) -> Hit {
        let Self { t, position, error, normal, uv, .. } = *self;
        Hit { t, position, error, normal, parameters: uv }
    }
}

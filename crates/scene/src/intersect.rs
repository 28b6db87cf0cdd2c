//! Ray queries on scenes: a tree over instances, whose leaves refer to a tree over the elements of
//! a shape.

use crate::{
    Scene, SceneError, SceneHit,
    placement::{Placement, Placements},
    plate::Plate,
    shape_tree::ShapeTree,
    validate::item,
};
use rayon::prelude::*;
use rotund_bvh::{Bvh, Isa, PrimitiveHit, Start, Statistics};
use rotund_geometry::{
    Hit, Ray,
    glam::{Vec2, Vec3},
    leave_surface,
};

/// The acceleration structure of one scene: bounding volume hierarchies over its instances and
/// elements.
///
/// The trees hold copies of the geometry and serve either [`crate::Method`], so methods, materials
/// and textures may change freely, with one exception: trees know the shapes that are one body into
/// which one can see (see [`crate::Overlap`]), so call [`Trees::refit`] where a material of points
/// or lines becomes opaque or ceases to be. After vertices, radii or frames moved, call
/// [`Trees::refit`]; after shapes, elements or instances were added or removed, build new trees.
#[derive(Clone, Debug)]
pub struct Trees {
    /// The tree over `placements`.
    upper: Bvh,
    placements: Vec<Placement>,
    /// The tree of each shape, followed by those that several instances share.
    trees: Vec<ShapeTree>,
    /// Planes around the elements of each tree of a flat shape.
    plates: Vec<Option<Plate>>,
    /// The number of elements of each shape.
    element_counts: Vec<usize>,
    instance_count: usize,
    /// For each shared tree, the number of elements before those of each of its instances.
    shared: Vec<Vec<u32>>,
    route: Route,
    /// Whether any placement is one body into which one can see.
    has_bodies: bool,
}

/// The source of position and normal of a [`SceneHit`].
///
/// Those of vanilla points and lines are always carried, since they depend on the ray and cannot be
/// rebuilt from parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Route {
    /// The intersection computes them.
    #[default]
    Carried,
    /// [`Scene::eval_position`] and [`Scene::eval_normal`] rebuild them from element and `uv`, as
    /// in a renderer that stores nothing else. `error` covers the additional rounding.
    Rebuilt,
}

/// Bound on the distance of a rebuilt point from the carried one beyond the error of the hit, per
/// unit of the size of the element in the world and of its distance from the origin.
/// `tests/frames.rs` holds it.
const ROUND_TRIP: f32 = 8.0 * f32::EPSILON;

impl Trees {
    /// Validates the scene and builds all trees, on all threads of the current rayon pool. The
    /// result does not depend on their number.
    ///
    /// # Errors
    ///
    /// If the scene is not valid: see [`Scene::validate`].
    pub fn build(scene: &Scene) -> Result<Self, SceneError> {
        scene.validate()?;
        let trees: Vec<_> = scene.shapes.par_iter().map(ShapeTree::build).collect();
        let Placements { placements, boxes, trees, plates, shared } = Placements::new(scene, trees);
        Ok(Self {
            upper: Bvh::build(&boxes),
            has_bodies: placements.iter().any(Placement::is_body),
            placements,
            trees,
            plates,
            element_counts: scene.shapes.iter().map(|shape| shape.elements.count()).collect(),
            instance_count: scene.instances.len(),
            shared,
            route: Route::default(),
        })
    }

    /// Refits the trees to a scene whose vertices, radii or frames changed, which is faster than
    /// building new ones. Queries return the same hits as newly built trees. Bounds are recomputed
    /// and the topology stays, so queries become slower as neighbours move apart; build new trees
    /// once that costs more than a build.
    ///
    /// Elements may also name other vertices, and instances other shapes.
    ///
    /// # Errors
    ///
    /// If the scene is not valid, or if it does not have as many shapes, elements in each shape, or
    /// instances as the one that the trees were built from. The trees are then as before.
    pub fn refit(&mut self, scene: &Scene) -> Result<(), SceneError> {
        scene.validate()?;
        self.check_counts(scene)?;
        let isa = self.upper.isa();
        let mut trees = std::mem::take(&mut self.trees);
        trees.truncate(scene.shapes.len());
        trees.par_iter_mut().zip(&scene.shapes).for_each(|(tree, shape)| tree.refit(shape));
        let placed = Placements::new(scene, trees);
        // Frames decide which instances share a tree, and so how many placements there are.
        let same = placed.placements.iter().map(|placement| placement.instance);
        let same = same.eq(self.placements.iter().map(|placement| placement.instance));
        if !same || self.upper.refit(&placed.boxes).is_err() {
            self.upper = Bvh::build(&placed.boxes).with_isa(isa);
        }
        self.has_bodies = placed.placements.iter().any(Placement::is_body);
        self.placements = placed.placements;
        self.trees = placed.trees.into_iter().map(|tree| tree.with_isa(isa)).collect();
        self.plates = placed.plates;
        self.shared = placed.shared;
        Ok(())
    }

    /// Checks that a scene has as many shapes, elements of each shape, and instances as the one
    /// that the trees were built of.
    ///
    /// # Errors
    ///
    /// If one of these numbers differs.
    pub fn check_counts(&self, scene: &Scene) -> Result<(), SceneError> {
        let changed =
            |item, what, before, now| Err(SceneError::Changed { item, what, before, now });
        let (before, now) = (self.element_counts.len(), scene.shapes.len());
        if before != now {
            return changed(None, "shapes", before, now);
        }
        for (index, (shape, &before)) in scene.shapes.iter().zip(&self.element_counts).enumerate() {
            let now = shape.elements.count();
            if before != now {
                return changed(Some(item("shapes", index, &shape.name)), "elements", before, now);
            }
        }
        let (before, now) = (self.instance_count, scene.instances.len());
        if before != now { changed(None, "instances", before, now) } else { Ok(()) }
    }

    /// Selects the instruction set of queries; answers are the same to the bit.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        let trees = self.trees.into_iter().map(|tree| tree.with_isa(isa)).collect();
        Self { upper: self.upper.with_isa(isa), trees, ..self }
    }

    /// Selects the source of position and normal of hits.
    #[must_use]
    pub fn with_route(self, route: Route) -> Self {
        Self { route, ..self }
    }

    /// Returns the first hit of the ray with `t` in `t_min..=t_max`. Of equal `t`, the lowest
    /// instance wins, and in it the lowest element.
    ///
    /// Where the points or lines of a shape are one body (see [`crate::Overlap`]), a hit is a
    /// boundary of it. Whether the ray starts inside is decided by its origin. For a ray that
    /// leaves a surface use [`Trees::closest_after`].
    ///
    /// # Panics
    ///
    /// May panic if `scene` is not the one that the trees were built from or refitted to.
    #[must_use]
    pub fn closest(&self, scene: &Scene, ray: &Ray) -> Option<SceneHit> {
        self.closest_after(scene, ray, None)
    }

    /// Returns the first hit of a ray that was spawned from a hit. `left` is the instance that the
    /// ray left, by [`SceneHit::left_by`].
    ///
    /// It is [`Trees::closest`], except at creases where elements of one body meet: there rounding
    /// may place the origin inside a neighbour of the element that the ray left. Such a ray enters
    /// the neighbour at once, and does not pass through it unnoticed.
    ///
    /// # Panics
    ///
    /// May panic if `scene` is not the one that the trees were built from or refitted to.
    #[must_use]
    pub fn closest_after(&self, scene: &Scene, ray: &Ray, left: Option<u32>) -> Option<SceneHit> {
        self.find(scene, ray, left, true)
    }

    /// [`Trees::closest_after`] for a renderer that needs the parameters of a hit only for colours
    /// and textures: `uv` is zero on enhanced points and lines without any.
    ///
    /// # Panics
    ///
    /// May panic if `scene` is not the one that the trees were built from or refitted to.
    #[must_use]
    pub fn closest_to_shade(
        &self,
        scene: &Scene,
        ray: &Ray,
        left: Option<u32>,
    ) -> Option<SceneHit> {
        self.find(scene, ray, left, self.route == Route::Rebuilt)
    }

    #[inline]
    fn find(
        &self,
        scene: &Scene,
        ray: &Ray,
        left: Option<u32>,
        with_parameters: bool,
    ) -> Option<SceneHit> {
        // Hits are written where they stay, and borrowed from there: copying one right after the
        // store stalls on store-to-load forwarding. One place has the closest, the other is free.
        let mut places = [None, None];
        if let [placement] = self.placements.as_slice() {
            self.closest_in(scene, placement, ray, left, &mut places[0]);
            return places[0].as_ref().map(|found| {
                self.scene_hit(scene, placement, found.id, &found.hit, with_parameters)
            });
        }
        let mut shrinking = *ray;
        let (mut closest, mut free) = (u32::MAX, 0);
        self.upper.visit(ray, |id| {
            let (placement, place) = (&self.placements[id as usize], &mut places[free & 1]);
            self.closest_in(scene, placement, &shrinking, left, place);
            if let Some(PrimitiveHit { hit: Hit { t, .. }, .. }) = place {
                let (t, last) = (*t, shrinking.t_max);
                // A tie goes to the first instance.
                if t.is_finite() && (t < last || (t == last && id < closest)) {
                    (closest, free) = (id, free ^ 1);
                    shrinking.t_max = t;
                }
            }
            shrinking.t_max
        });
        let placement = self.placements.get(closest as usize)?;
        let found = places[free & 1 ^ 1].as_ref()?;
        Some(self.scene_hit(scene, placement, found.id, &found.hit, with_parameters))
    }

    /// Writes the first hit of the ray in a placement, in object space, or `None` to `place`.
    #[inline(always)]
    fn closest_in(
        &self,
        scene: &Scene,
        placement: &Placement,
        ray: &Ray,
        left: Option<u32>,
        place: &mut Option<PrimitiveHit>,
    ) {
        let shape = &scene.shapes[placement.shape as usize];
        let tree = &self.trees[placement.tree as usize];
        let mut transformed = None;
        let ray = placement.ray_in_object(shape, ray, &mut transformed);
        if placement.is_union(shape) {
            *place = tree.boundary(ray, start(placement, left));
        } else if self.is_beside(placement, ray) {
            *place = None;
        } else {
            tree.closest(ray, shape.method, place);
        }
    }

    /// Returns true only if a ray in object space misses all elements of a placement.
    #[inline(always)]
    fn is_beside(&self, placement: &Placement, ray: &Ray) -> bool {
        self.plates[placement.tree as usize].as_ref().is_some_and(|plate| plate.is_missed(ray))
    }

    /// Converts the hit of an element of a placement to world space.
    #[inline(always)]
    fn scene_hit(
        &self,
        scene: &Scene,
        placement: &Placement,
        element: u32,
        hit: &Hit,
        with_parameters: bool,
    ) -> SceneHit {
        let (instance, element) = self.locate(placement, element);
        let shape = &scene.shapes[scene.instances[instance as usize].shape as usize];
        let world = placement.frame.world_hit(hit, || shape.curvature(element, hit));
        let skip =
            !with_parameters && shape.has_costly_parameters() && !scene.is_textured(instance);
        let uv = if skip { Vec2::ZERO } else { shape.uv(element, hit) };
        let hit = SceneHit {
            instance,
            element,
            uv,
            t: hit.t,
            position: world.position,
            normal: world.normal,
            error: world.error,
        };
        if self.route == Route::Carried || shape.is_ribbons() {
            return hit;
        }
        let bounds = placement.frame.world_bounds(shape.primitive(element).bounds());
        let scale = (bounds.max - bounds.min).length() + hit.position.length();
        SceneHit {
            position: scene.eval_position(instance, element, hit.uv),
            normal: scene.eval_normal(instance, element, hit.uv),
            // The distance of the hit from the surface, plus that of the rebuilt point from the
            // hit.
            error: 2.0 * hit.error + ROUND_TRIP * scale,
            ..hit
        }
    }

    /// Returns the size of the tree of each shape, in order.
    #[must_use]
    pub fn statistics(&self) -> Vec<Statistics> {
        self.trees[..self.shape_count()].iter().map(ShapeTree::statistics).collect()
    }

    fn shape_count(&self) -> usize {
        self.trees.len() - self.shared.len()
    }

    /// Returns instance and element of its shape for an element of the tree of a placement.
    fn locate(&self, placement: &Placement, element: u32) -> (u32, u32) {
        let Some(shared) = (placement.tree as usize).checked_sub(self.shape_count()) else {
            return (placement.instance, element);
        };
        let starts = &self.shared[shared];
        let place = starts.partition_point(|&start| start <= element) - 1;
        (placement.instance + place as u32, element - starts[place])
    }

    /// Returns whether a point on the surface of an element is inside its body and so not on its
    /// surface; see [`crate::Overlap`]. `error` bounds the distance of the point from the element.
    ///
    /// What is covered does not shine. A renderer that samples points on emitters asks this of
    /// points that its shadow rays reach: a body into which one can see does not stop them.
    ///
    /// # Panics
    ///
    /// May panic if `scene` is not the one that the trees were built from or refitted to.
    #[must_use]
    pub fn covers(
        &self,
        scene: &Scene,
        (instance, element): (u32, u32),
        position: Vec3,
        normal: Vec3,
        error: f32,
    ) -> bool {
        if !self.has_bodies {
            return false;
        }
        let after = self.placements.partition_point(|place| place.instance <= instance);
        let Some(placement) = after.checked_sub(1).map(|index| &self.placements[index]) else {
            return false;
        };
        if !placement.is_union(&scene.shapes[placement.shape as usize]) {
            return false;
        }
        let side = |direction: Vec3| {
            let origin = leave_surface(position, error, normal, direction);
            placement.frame.object_ray(&Ray::new(origin, direction)).origin
        };
        self.trees[placement.tree as usize].covers(element, side(-normal), side(normal))
    }

    /// Returns true if the ray has a hit with `t` in `t_min..=t_max`, that is, if
    /// [`Trees::closest`] finds one.
    ///
    /// # Panics
    ///
    /// May panic if `scene` is not the one that the trees were built from or refitted to.
    #[must_use]
    pub fn any(&self, scene: &Scene, ray: &Ray) -> bool {
        self.any_after(scene, ray, None)
    }

    /// Returns true if [`Trees::closest_after`] finds a hit.
    ///
    /// # Panics
    ///
    /// May panic if `scene` is not the one that the trees were built from or refitted to.
    #[must_use]
    pub fn any_after(&self, scene: &Scene, ray: &Ray, left: Option<u32>) -> bool {
        let test = |id: u32, ray: &Ray| {
            let placement = &self.placements[id as usize];
            let shape = &scene.shapes[placement.shape as usize];
            let tree = &self.trees[placement.tree as usize];
            let mut transformed = None;
            let ray = placement.ray_in_object(shape, ray, &mut transformed);
            if placement.is_union(shape) {
                return tree.boundary(ray, start(placement, left)).is_some();
            }
            !self.is_beside(placement, ray) && tree.any(ray, shape.method)
        };
        if self.placements.len() == 1 { test(0, ray) } else { self.upper.any(ray, test) }
    }
}

/// Returns what is known about the start of a ray that left an instance.
fn start(placement: &Placement, left: Option<u32>) -> Start {
    if left == Some(placement.instance) { Start::Outside } else { Start::ByPosition }
}

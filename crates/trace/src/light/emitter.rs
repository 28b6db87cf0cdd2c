//! One element of an emissive instance.

use super::flat::{self, SurfacePoint};
use super::owners::Owners;
use super::rectangle::Rectangle;
use super::round::{Ball, Cone, Density, RoundPoint};
use super::spherical_triangle::SphericalTriangle;
use super::tree::Extent;
use super::{LightSource, luminance};
use crate::warp;
use glam::{Affine3A, Vec2, Vec3};
use rotund_geometry::{Aabb, UNIT_ROUNDOFF};
use rotund_scene::{Elements, Instance, Method, Scene, SceneHit, Shape};

/// An emitting element in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    surface: Surface,
    instance: u32,
    element: u32,
    /// Radiance, if it is constant over the element.
    constant: Option<Vec3>,
    pub(super) power: f32,
    /// Center of the bounds, and the square of the distance from there at which the emitter is
    /// [`FAR`].
    center: Vec3,
    far2: f32,
    /// Bound on the distance of a sampled point from the surface: fewer than ten roundings, each
    /// relative to the largest coordinate involved, and the distance of a rectangle from the
    /// element that it replaces.
    error: f32,
}

/// Distance, in multiples of the radius of the bounds, beyond which a flat emitter is sampled by
/// area and not by solid angle. That takes a tenth of the time. With this limit it adds a fiftieth
/// to the noise of a room, and saves a twentieth of the time of the whole path.
const FAR: f32 = 1.5;

/// A sampled point of an emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmitterPoint {
    pub(super) source: LightSource,
    /// Parameters of the point on the element; `None` on round ones, where they are costly.
    pub(super) uv: Option<Vec2>,
    /// Density per solid angle.
    pub(super) pdf: f32,
}

/// The surfaces that points are sampled on.
#[derive(Clone, Copy, Debug)]
enum Surface {
    Triangle([Vec3; 3]),
    /// A rectangular quad, of either method.
    Rectangle(Rectangle),
    TwoTriangles([Vec3; 4]),
    /// A bilinear patch `p00 p10 p01 p11`.
    Patch([Vec3; 4]),
    Ball(Ball),
    Cone(Cone),
    /// The second triangle of a rectangle, which the element before represents.
    SecondHalf,
    /// A surface that is never sampled.
    None,
}

/// Appends emitters for all elements of an instance, in order, and returns the number of the first,
/// or `None` if its material does not emit. `owners` has those of the instances before.
pub(super) fn add_instance(
    scene: &Scene,
    index: u32,
    owners: &mut Owners,
    emitters: &mut Vec<Emitter>,
) -> Option<u32> {
    let instance = &scene.instances[index as usize];
    let material = &scene.materials[instance.material as usize];
    if material.emission.max_element() <= 0.0 {
        return None;
    }
    let shape = &scene.shapes[instance.shape as usize];
    let varies =
        material.emission_tex.is_some() || material.color_tex.is_some() || !shape.colors.is_empty();
    let emitter = |element: u32| {
        let surface = unowned_surface(shape, instance, element as usize, owners);
        let mut emitter = Emitter::dark(surface, index, element);
        let area = emitter.area();
        if area > 0.0 && area.is_finite() {
            let mean = emitter.mean_radiance(scene, varies);
            emitter.constant = (!varies).then_some(mean);
            emitter.power = luminance(mean) * area;
        }
        emitter
    };
    let first = emitters.len();
    emitters.extend((0..shape.elements.count() as u32).map(emitter));
    for second in first + 1..emitters.len() {
        let [a, b] = &mut emitters[second - 1..=second] else { continue };
        a.join(b);
    }
    Some(first as u32)
}

/// Returns an element that passes light on instead of emitting it. It has power if it can be
/// sampled.
pub(super) fn of_caster(scene: &Scene, index: u32, element: u32) -> Emitter {
    let instance = &scene.instances[index as usize];
    let shape = &scene.shapes[instance.shape as usize];
    let surface = surface(shape, instance, element as usize);
    let mut caster = Emitter::dark(surface, index, element);
    let area = caster.area();
    caster.power = if area.is_finite() { area } else { 0.0 };
    caster
}

fn surface(shape: &Shape, instance: &Instance, element: usize) -> Surface {
    let frame = &instance.world_from_object;
    let object = |vertex: u32| shape.positions[vertex as usize];
    let world = |vertex: u32| frame.transform_point3(object(vertex));
    let radius = |vertex: u32| shape.radii[vertex as usize];
    match (&shape.elements, shape.method) {
        (Elements::Triangles(triangles), _) => Surface::Triangle(triangles[element].map(world)),
        (Elements::Quads(quads), method) => {
            let corners = quads[element].map(world);
            let [p00, p10, p11, p01] = corners;
            match (Rectangle::try_new(corners), method) {
                (Some(rectangle), _) => Surface::Rectangle(rectangle),
                (None, Method::Vanilla) => Surface::TwoTriangles(corners),
                (None, Method::Enhanced) => Surface::Patch([p00, p10, p01, p11]),
            }
        }
        (Elements::Points(_) | Elements::Lines(_), Method::Vanilla) => Surface::None,
        (Elements::Points(_), Method::Enhanced) => scale(frame).map_or(Surface::None, |scale| {
            let vertex = element as u32;
            Surface::Ball(Ball { center: world(vertex), radius: scale * radius(vertex) })
        }),
        (Elements::Lines(lines), Method::Enhanced) => scale(frame).map_or(Surface::None, |scale| {
            let balls = lines[element]
                .map(|vertex| Ball { center: world(vertex), radius: scale * radius(vertex) });
            match Cone::try_new(balls) {
                Some(cone) => Surface::Cone(cone),
                // The larger ball contains the other.
                None if balls[0].radius >= balls[1].radius => Surface::Ball(balls[0]),
                None => Surface::Ball(balls[1]),
            }
        }),
    }
}

/// Returns the part of a surface that no emitter has yet, and records it.
fn unowned_surface(
    shape: &Shape,
    instance: &Instance,
    element: usize,
    owners: &mut Owners,
) -> Surface {
    let corner =
        |vertex: u32| instance.world_from_object.transform_point3(shape.positions[vertex as usize]);
    let is_first = match &shape.elements {
        Elements::Triangles(faces) => owners.take_face(faces[element].map(corner)),
        Elements::Quads(faces) => owners.take_face(faces[element].map(corner)),
        Elements::Points(_) | Elements::Lines(_) => true,
    };
    match surface(shape, instance, element) {
        _ if !is_first => Surface::None,
        Surface::Ball(ball) if !owners.take_ball(&ball) => Surface::None,
        Surface::Cone(cone) => {
            let caps = cone.balls.each_ref().map(|ball| owners.take_ball(ball));
            let is_first = owners.take_line(&cone.balls);
            if is_first { Surface::Cone(cone.with_caps(caps)) } else { Surface::None }
        }
        surface => surface,
    }
}

/// Returns the scale of a frame, if it is a similarity.
pub(super) fn scale(frame: &Affine3A) -> Option<f32> {
    let axes = frame.matrix3;
    let lengths2 = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.length_squared());
    let mean = (lengths2.iter().sum::<f32>() / 3.0).sqrt();
    // Frames in files are rounded to about six digits.
    let near = |x: f32, y: f32| (x - y).abs() <= 1e-5 * mean * mean;
    let same = lengths2.iter().all(|&l| near(l, mean * mean))
        && near(axes.x_axis.dot(axes.y_axis), 0.0)
        && near(axes.y_axis.dot(axes.z_axis), 0.0)
        && near(axes.z_axis.dot(axes.x_axis), 0.0);
    same.then_some(mean)
}

impl Emitter {
    /// An element without power.
    fn dark(surface: Surface, instance: u32, element: u32) -> Self {
        let mut emitter = Self {
            surface,
            instance,
            element,
            constant: None,
            power: 0.0,
            center: Vec3::ZERO,
            far2: 0.0,
            error: 0.0,
        };
        emitter.measure();
        emitter
    }

    /// Returns the indices of instance and element.
    pub(super) fn element(&self) -> (u32, u32) {
        (self.instance, self.element)
    }

    /// Computes the fields that depend on the bounds.
    fn measure(&mut self) {
        let Aabb { min, max } = self.extent().bounds;
        let off = match &self.surface {
            Surface::Rectangle(rectangle) => rectangle.off,
            _ => 0.0,
        };
        self.error = 10.0 * UNIT_ROUNDOFF * min.abs().max(max.abs()).max_element() + off;
        self.center = 0.5 * (min + max);
        self.far2 = FAR * FAR * 0.25 * (max - min).length_squared();
    }

    /// Joins two consecutive triangles of a mesh into one rectangle, if they make one: one emitter
    /// is chosen and sampled faster than two.
    fn join(&mut self, next: &mut Self) {
        if let (Surface::Triangle(a), Surface::Triangle(b)) = (&self.surface, &next.surface)
            && self.constant.is_some()
            && next.constant.is_some()
            && let Some(rectangle) = flat::around(*a, *b).and_then(Rectangle::try_new)
        {
            self.surface = Surface::Rectangle(rectangle);
            self.power += next.power;
            self.measure();
            next.surface = Surface::SecondHalf;
            next.power = 0.0;
        }
    }

    /// True if the element before represents this one.
    pub(super) fn is_second_half(&self) -> bool {
        matches!(self.surface, Surface::SecondHalf)
    }

    fn area(&self) -> f32 {
        match &self.surface {
            Surface::Triangle(corners) => flat::triangle_area(*corners),
            Surface::Rectangle(rectangle) => rectangle.area(),
            Surface::TwoTriangles(corners) => flat::triangle_areas(*corners).iter().sum(),
            Surface::Patch(corners) => {
                let [p00, p10, p01, p11] = *corners;
                flat::triangle_areas([p00, p10, p11, p01]).iter().sum()
            }
            Surface::Ball(ball) => ball.area(),
            Surface::Cone(cone) => cone.area(),
            Surface::SecondHalf | Surface::None => 0.0,
        }
    }

    /// Returns the radiance that a sampled point emits, scaled by opacity. `uv` is that of an
    /// [`EmitterPoint`].
    pub(super) fn radiance(&self, scene: &Scene, uv: Option<Vec2>, source: &LightSource) -> Vec3 {
        self.constant.unwrap_or_else(|| {
            let LightSource { position, normal, .. } = *source;
            let found =
                || scene.eval_round_parameters(self.instance, self.element, position, normal);
            uv.or_else(found).map_or(Vec3::ZERO, |uv| self.radiance_at(scene, uv))
        })
    }

    /// Returns the radiance emitted at the point with these parameters, scaled by opacity.
    fn radiance_at(&self, scene: &Scene, uv: Vec2) -> Vec3 {
        let material = scene.eval_material(self.instance, self.element, uv);
        material.opacity * material.emission
    }

    /// Returns the mean radiance, estimated from a few points if it varies. It only guides the
    /// choice of emitters.
    fn mean_radiance(&self, scene: &Scene, varies: bool) -> Vec3 {
        const STEPS: u16 = 4;
        let at = |uv| self.radiance_at(scene, uv);
        if !varies {
            return at(Vec2::splat(0.25));
        }
        let place = |i: u16| (f32::from(i) + 0.5) / f32::from(STEPS);
        let grid = (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| Vec2::new(place(i), place(j))));
        grid.map(at).sum::<Vec3>() / f32::from(STEPS * STEPS)
    }

    /// Returns the bounds for the light tree.
    pub(super) fn extent(&self) -> Extent {
        let (bounds, normal) = match &self.surface {
            Surface::Triangle(corners) => {
                let [p0, p1, p2] = *corners;
                (Aabb::from_points(*corners), (p1 - p0).cross(p2 - p0).normalize_or_zero())
            }
            Surface::Rectangle(Rectangle { corner, edges: [a, b], .. }) => {
                let ends = [*corner, corner + a, corner + b, corner + a + b];
                (Aabb::from_points(ends), a.cross(*b).normalize_or_zero())
            }
            Surface::TwoTriangles(corners) => {
                (Aabb::from_points(*corners), shared_normal(*corners))
            }
            Surface::Patch(corners) => {
                let [p00, p10, p01, p11] = *corners;
                (Aabb::from_points(*corners), shared_normal([p00, p10, p11, p01]))
            }
            Surface::Ball(ball) => (ball_bounds(ball), Vec3::ZERO),
            Surface::Cone(cone) => {
                let [b0, b1] = &cone.balls;
                (ball_bounds(b0).union(ball_bounds(b1)), Vec3::ZERO)
            }
            Surface::SecondHalf | Surface::None => (Aabb::EMPTY, Vec3::ZERO),
        };
        Extent { bounds, power: self.power, normal }
    }

    /// Returns the surface if it is a ball.
    pub(super) fn as_ball(&self) -> Option<Ball> {
        match &self.surface {
            Surface::Ball(ball) => Some(*ball),
            _ => None,
        }
    }

    /// Returns a ball around the surface.
    pub(super) fn ball(&self) -> Ball {
        match &self.surface {
            Surface::Ball(ball) => *ball,
            Surface::Cone(cone) => {
                let [b0, b1] = cone.balls;
                let reach = 0.5 * b0.center.distance(b1.center);
                let center = 0.5 * (b0.center + b1.center);
                Ball { center, radius: reach + b0.radius.max(b1.radius) }
            }
            _ => {
                let Aabb { min, max } = self.extent().bounds;
                Ball { center: 0.5 * (min + max), radius: 0.5 * (max - min).length() }
            }
        }
    }

    /// Samples a point that may be visible from `from`, or returns `None`.
    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterPoint> {
        let surface_point = |point: SurfacePoint| {
            let SurfacePoint { position, normal, uv, pdf_area } = point;
            let pdf = solid_angle_density(Density::Area(pdf_area), from, position, normal);
            EmitterPoint { source: self.source(position, normal), uv: Some(uv), pdf }
        };
        let round_point = |point: RoundPoint| {
            let RoundPoint { position, normal, density } = point;
            let source = self.source(position, normal);
            let pdf = solid_angle_density(density, from, position, normal);
            EmitterPoint { source, uv: None, pdf }
        };
        let point = match &self.surface {
            Surface::Triangle(corners) => self.of_triangles(&[*corners], from, u)?,
            Surface::Rectangle(rectangle) => {
                let seen = if self.is_far(from) { None } else { rectangle.sample(from, u) };
                let uv = seen.map_or(u, |(place, _)| place);
                let [a, b] = rectangle.edges;
                let position = rectangle.corner + uv.x * a + uv.y * b;
                let normal = rectangle.normal;
                let pdf = seen.map_or_else(
                    || {
                        let density = Density::Area(1.0 / rectangle.area());
                        solid_angle_density(density, from, position, normal)
                    },
                    |(_, pdf)| pdf,
                );
                EmitterPoint { source: self.source(position, normal), uv: Some(uv), pdf }
            }
            Surface::TwoTriangles(corners) => {
                self.of_triangles(&flat::halves(*corners), from, u)?
            }
            Surface::Patch(corners) => surface_point(flat::patch(*corners, u)?),
            Surface::Ball(ball) => round_point(ball.sample(from, u)),
            Surface::Cone(cone) => round_point(cone.sample(from, u)?),
            Surface::SecondHalf | Surface::None => return None,
        };
        (point.pdf > 0.0 && point.pdf.is_finite()).then_some(point)
    }

    /// Returns the density per solid angle with which [`Self::sample`] samples a point that a ray
    /// hit.
    pub(super) fn pdf(&self, from: Vec3, hit: &SceneHit) -> f32 {
        // From outside only the near side of a solid is sampled. A ray meets the far side through
        // a surface of partial opacity.
        let is_outside = match &self.surface {
            Surface::Ball(ball) => !ball.holds(from),
            Surface::Cone(cone) => !cone.holds(from),
            _ => false,
        };
        if is_outside && hit.normal.dot(from - hit.position) < 0.0 {
            return 0.0;
        }
        let density = match &self.surface {
            Surface::Triangle(corners) => self.density_of_triangles(&[*corners], from),
            Surface::TwoTriangles(corners) => {
                self.density_of_triangles(&flat::halves(*corners), from)
            }
            Surface::Rectangle(rectangle) => {
                let seen = if self.is_far(from) { None } else { rectangle.pdf(from) };
                seen.map_or_else(|| Density::Area(1.0 / rectangle.area()), Density::SolidAngle)
            }
            Surface::Patch(corners) => Density::Area(flat::patch_pdf(*corners, hit.uv)),
            Surface::Ball(ball) => ball.density(from),
            Surface::Cone(cone) => cone.density(from, hit.position),
            Surface::SecondHalf | Surface::None => return 0.0,
        };
        solid_angle_density(density, from, hit.position, hit.normal)
    }

    /// Samples a point of a triangle, or of the two that approximate a quad: uniformly by solid
    /// angle, or by area if the solid angle is too small.
    fn of_triangles(&self, triangles: &[[Vec3; 3]], from: Vec3, u: Vec2) -> Option<EmitterPoint> {
        let seen = self.seen(triangles, from);
        let weights = [0, 1].map(|index| match (&seen, triangles.get(index)) {
            (_, None) => 0.0,
            (Some(seen), _) => seen[index].solid_angle as f32,
            (None, Some(corners)) => flat::triangle_area(*corners),
        });
        let sum = weights[0] + weights[1];
        let share = weights[0] / sum;
        let (index, x) = if u.x < share || weights[1] <= 0.0 {
            (0, u.x / share)
        } else {
            (1, (u.x - share) / (1.0 - share))
        };
        let u = Vec2::new(x.clamp(0.0, 1.0_f32.next_down()), u.y);
        let corners = triangles[index];
        let place = match &seen {
            Some(seen) => seen[index].sample(u),
            None => warp::triangle(u),
        };
        let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
        let position = corners[0] + place.x * e1 + place.y * e2;
        let normal = e1.cross(e2).try_normalize()?;
        let density = match seen {
            Some(_) => Density::SolidAngle(1.0 / sum),
            None => Density::Area(1.0 / sum),
        };
        let pdf = solid_angle_density(density, from, position, normal);
        // The parameters of the second triangle of a quad start at the opposite corner.
        let uv = if index == 0 { place } else { 1.0 - place };
        Some(EmitterPoint { source: self.source(position, normal), uv: Some(uv), pdf })
    }

    /// Returns the density of [`Self::of_triangles`].
    fn density_of_triangles(&self, triangles: &[[Vec3; 3]], from: Vec3) -> Density {
        match self.seen(triangles, from) {
            Some(seen) => {
                Density::SolidAngle(1.0 / seen.iter().map(|t| t.solid_angle as f32).sum::<f32>())
            }
            None => Density::Area(1.0 / self.area()),
        }
    }

    /// Returns the spherical triangles, if they are sampled by solid angle from here.
    fn seen(&self, triangles: &[[Vec3; 3]], from: Vec3) -> Option<[SphericalTriangle; 2]> {
        if self.is_far(from) { None } else { SphericalTriangle::seen(triangles, from) }
    }

    fn is_far(&self, from: Vec3) -> bool {
        from.distance_squared(self.center) > self.far2
    }

    fn source(&self, position: Vec3, normal: Vec3) -> LightSource {
        LightSource { position, normal, error: self.error }
    }
}

fn ball_bounds(ball: &Ball) -> Aabb {
    let r = Vec3::splat(ball.radius);
    Aabb { min: ball.center - r, max: ball.center + r }
}

/// Returns the normal of a quad if it is flat, else zero.
fn shared_normal([p0, p1, p2, p3]: [Vec3; 4]) -> Vec3 {
    let a = (p1 - p0).cross(p3 - p0).normalize_or_zero();
    let b = (p3 - p2).cross(p1 - p2).normalize_or_zero();
    // A degenerate quad that is a triangle has a half without a normal.
    if b == Vec3::ZERO || a.dot(b) > 1.0 - 1e-5 { a } else { Vec3::ZERO }
}

/// Converts the density of a point to one per solid angle at `from`.
fn solid_angle_density(density: Density, from: Vec3, position: Vec3, normal: Vec3) -> f32 {
    match density {
        Density::SolidAngle(pdf) => pdf,
        Density::Area(pdf) => {
            let to = position - from;
            let distance2 = to.length_squared();
            pdf * distance2 * distance2.sqrt() / to.dot(normal).abs()
        }
    }
}

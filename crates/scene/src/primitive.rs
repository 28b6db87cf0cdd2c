//! Elements of shapes as geometric primitives, by the method of the shape.

use crate::{Elements, Method, Shape};
use glam::{Vec2, Vec3};
use rotund_geometry::{
    Aabb, BilinearPatch, Hit, RoundedCone, Sphere, Triangle,
    vanilla::{Line, Point, Quad},
};

/// The primitive of an element, in object space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Primitive {
    Point(Point),
    Sphere(Sphere),
    Line(Line),
    Cone(RoundedCone),
    Triangle(Triangle),
    Quad(Quad),
    Patch(BilinearPatch),
}

/// Calls one method of whichever primitive it is: they all have the same.
macro_rules! each {
    ($self:expr, $primitive:ident => $call:expr) => {
        match $self {
            Primitive::Point($primitive) => $call,
            Primitive::Sphere($primitive) => $call,
            Primitive::Line($primitive) => $call,
            Primitive::Cone($primitive) => $call,
            Primitive::Triangle($primitive) => $call,
            Primitive::Quad($primitive) => $call,
            Primitive::Patch($primitive) => $call,
        }
    };
}

impl Primitive {
    pub(crate) fn uv(&self, hit: &Hit) -> Vec2 {
        each!(self, primitive => primitive.uv(hit))
    }

    /// Returns a bound on the normal curvatures of the surface at a hit.
    fn curvature(&self, hit: &Hit) -> f32 {
        match self {
            Self::Sphere(sphere) => sphere.radius.recip(),
            // The body curves at most as the ball that touches it there.
            Self::Cone(cone) => {
                let radius = cone.r0 + hit.parameters.x * (cone.r1 - cone.r0);
                radius.max(0.0).recip()
            }
            Self::Patch(patch) => {
                // A step `(a, b)` in `uv` leaves the tangent plane by `a b m`, as the only second
                // derivative is the mixed one. Its squared length is at least
                // `2 |a b| (|du| |dv| - |du·dv|)`.
                let (du, dv) = patch.tangents(hit.parameters);
                let mixed = (patch.p11 - patch.p10) - (patch.p01 - patch.p00);
                let area = du.length() * dv.length() - du.dot(dv).abs();
                mixed.dot(hit.normal).abs() / area.max(0.0)
            }
            Self::Point(_) | Self::Line(_) | Self::Triangle(_) | Self::Quad(_) => 0.0,
        }
    }

    pub(crate) fn bounds(&self) -> Aabb {
        each!(self, primitive => primitive.bounds())
    }

    pub(crate) fn position(&self, uv: Vec2) -> Vec3 {
        each!(self, primitive => primitive.position(uv))
    }

    pub(crate) fn normal(&self, uv: Vec2) -> Vec3 {
        each!(self, primitive => primitive.normal(uv))
    }
}

impl Shape {
    pub(crate) fn is_round(&self) -> bool {
        matches!(self.elements, Elements::Points(_) | Elements::Lines(_))
    }

    /// Returns true for vanilla points and lines, which are ribbons that turn to the ray.
    pub(crate) fn is_ribbons(&self) -> bool {
        self.method == Method::Vanilla && self.is_round()
    }

    /// Returns true for spheres and cones, whose parameters are angles.
    pub(crate) fn has_costly_parameters(&self) -> bool {
        self.method == Method::Enhanced && self.is_round()
    }

    /// Returns the parameters of a hit of an element.
    pub(crate) fn uv(&self, element: u32, hit: &Hit) -> Vec2 {
        if self.has_costly_parameters() {
            self.primitive(element).uv(hit)
        } else {
            // The hit of all other primitives stores their parameters, so no vertices are fetched.
            hit.parameters
        }
    }

    /// Returns a bound on the normal curvatures of an element at a hit.
    pub(crate) fn curvature(&self, element: u32, hit: &Hit) -> f32 {
        // Vertices of flat elements are not fetched.
        let curved =
            self.method == Method::Enhanced && !matches!(self.elements, Elements::Triangles(_));
        if curved { self.primitive(element).curvature(hit) } else { 0.0 }
    }

    /// Returns the primitive of an element under the method of the shape.
    pub(crate) fn primitive(&self, element: u32) -> Primitive {
        let vanilla = self.method == Method::Vanilla;
        match &self.elements {
            Elements::Points(_) if vanilla => Primitive::Point(self.point(element)),
            Elements::Points(_) => Primitive::Sphere(self.sphere(element)),
            Elements::Lines(lines) => {
                let vertices = lines[element as usize];
                if vanilla {
                    Primitive::Line(self.line(vertices))
                } else {
                    Primitive::Cone(self.cone(vertices))
                }
            }
            Elements::Triangles(triangles) => {
                Primitive::Triangle(self.triangle(triangles[element as usize]))
            }
            Elements::Quads(quads) => {
                let vertices = quads[element as usize];
                if vanilla {
                    Primitive::Quad(self.quad(vertices))
                } else {
                    Primitive::Patch(self.patch(vertices))
                }
            }
        }
    }

    fn point(&self, element: u32) -> Point {
        let i = element as usize;
        Point { center: self.positions[i], radius: self.radii[i] }
    }

    pub(crate) fn sphere(&self, element: u32) -> Sphere {
        let i = element as usize;
        Sphere { center: self.positions[i], radius: self.radii[i] }
    }

    fn line(&self, [a, b]: [u32; 2]) -> Line {
        let (a, b) = (a as usize, b as usize);
        Line { p0: self.positions[a], r0: self.radii[a], p1: self.positions[b], r1: self.radii[b] }
    }

    pub(crate) fn cone(&self, [a, b]: [u32; 2]) -> RoundedCone {
        let (a, b) = (a as usize, b as usize);
        RoundedCone {
            p0: self.positions[a],
            r0: self.radii[a],
            p1: self.positions[b],
            r1: self.radii[b],
        }
    }

    pub(crate) fn triangle(&self, vertices: [u32; 3]) -> Triangle {
        let [p0, p1, p2] = vertices.map(|vertex| self.positions[vertex as usize]);
        Triangle { p0, p1, p2 }
    }

    fn quad(&self, vertices: [u32; 4]) -> Quad {
        let [p0, p1, p2, p3] = vertices.map(|vertex| self.positions[vertex as usize]);
        Quad { p0, p1, p2, p3 }
    }

    /// Converts the order of files, around the quad, to that of patches, row by row.
    pub(crate) fn patch(&self, vertices: [u32; 4]) -> BilinearPatch {
        let [p00, p10, p11, p01] = vertices.map(|vertex| self.positions[vertex as usize]);
        BilinearPatch { p00, p10, p01, p11 }
    }
}

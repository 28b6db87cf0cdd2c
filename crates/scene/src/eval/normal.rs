//! Shading normals, which ask the element, the method, the material and the viewer.

use super::{position::transform_normal, weights::Weights};
use crate::{
    ElementKind, Elements, MaterialKind, Method, Scene, SceneHit, Shape, Texture,
    primitive::Primitive,
};
use glam::{Mat3A, Vec2, Vec3};
use rotund_geometry::UNIT_ROUNDOFF;

impl Scene {
    /// The shading normal of a point by itself: of unit length, on the outside of a solid, neither turned
    /// to a viewer nor bounded for one. [`Self::shading_normal`] does both.
    ///
    /// Vanilla points and lines have none without a viewer, and give [`Self::eval_normal`].
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn eval_shading_normal(&self, instance: u32, element: u32, uv: Vec2) -> Vec3 {
        let geometric = self.eval_normal(instance, element, uv);
        self.bent_normal(instance, element, uv, geometric)
    }

    /// The normal that light scatters about at a hit, of unit length. `outgoing` points to the viewer and
    /// need not have unit length.
    ///
    /// | element | vanilla | enhanced |
    /// | --- | --- | --- |
    /// | point | `outgoing` | of the sphere, then the normal map |
    /// | line | `outgoing`, made orthogonal to the interpolated tangent | of the cone, then the normal map |
    /// | triangle, quad | of the vertices, else of the face (of a quad the mean of its two triangles); then the normal map | the same, of the patch; then bounded |
    ///
    /// Refractive surfaces keep their side, for it tells in from out; all others turn to the viewer.
    ///
    /// Bounded means that the mirror image of `outgoing` about the normal is not below the surface, where
    /// nothing reflects to: else the normal is turned towards the geometric one just so far that it is
    /// on the surface. Vanilla shapes do as yocto-gl does, and let such light be lost.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn shading_normal(&self, hit: &SceneHit, outgoing: Vec3) -> Vec3 {
        let instance = &self.instances[hit.instance as usize];
        let shape = &self.shapes[instance.shape as usize];
        let refractive =
            self.materials[instance.material as usize].kind == MaterialKind::Refractive;
        let outgoing = outgoing.normalize_or(hit.normal);
        if shape.method == Method::Enhanced {
            let normal = self.bent_normal(hit.instance, hit.element, hit.uv, hit.normal);
            // The side of the viewer is that of the surface, not of a normal that only pretends.
            let outside = hit.normal.dot(outgoing) >= 0.0;
            let up = if outside { hit.normal } else { -hit.normal };
            let normal = bounded(if outside { normal } else { -normal }, up, outgoing);
            return if refractive && !outside { -normal } else { normal };
        }
        let normal = match &shape.elements {
            Elements::Points(_) => return outgoing,
            Elements::Lines(lines) => {
                let [a, b] = lines[hit.element as usize].map(|vertex| vertex as usize);
                let tangent = Weights::new(shape, hit.element, hit.uv)
                    .of(&shape.normals)
                    .unwrap_or_else(|| shape.positions[b] - shape.positions[a]);
                let tangent =
                    instance.world_from_object.matrix3.mul_vec3(tangent).normalize_or_zero();
                return (outgoing - tangent * outgoing.dot(tangent)).normalize_or(hit.normal);
            }
            _ => self.bent_normal(hit.instance, hit.element, hit.uv, hit.normal),
        };
        if refractive || normal.dot(outgoing) >= 0.0 { normal } else { -normal }
    }

    /// `geometric`, or what vertices and the normal map make of it.
    fn bent_normal(&self, instance: u32, element: u32, uv: Vec2, geometric: Vec3) -> Vec3 {
        let (frame, shape) = self.placed(instance);
        let material = &self.materials[self.instances[instance as usize].material as usize];
        let normal = match &shape.elements {
            Elements::Points(_) | Elements::Lines(_) if shape.method == Method::Vanilla => {
                return geometric;
            }
            Elements::Points(_) | Elements::Lines(_) => geometric,
            Elements::Triangles(_) | Elements::Quads(_) => {
                let smooth = Weights::new(shape, element, uv)
                    .of(&shape.normals)
                    .map_or(Vec3::ZERO, |normal| transform_normal(&frame.matrix3, normal));
                // Vertices without a normal, or with normals that cancel, leave it to the face.
                if smooth == Vec3::ZERO {
                    face_normal(shape, element, &frame.matrix3, geometric)
                } else {
                    smooth
                }
            }
        };
        match material.normal_tex {
            Some(index) => {
                self.mapped_normal(instance, element, uv, &self.textures[index as usize], normal)
            }
            None => normal,
        }
    }

    /// How the point moves with its texture coordinates, in world space: the derivatives of position
    /// by `u` and by `v`. Zeros where texture coordinates do not vary, or where it is no finite number: there is
    /// no such derivative.
    ///
    /// Those of a patch vary over it. Two triangles share those of the first, as in yocto-gl. Spheres
    /// and cones give the derivatives by their own parameters; vanilla points and lines none.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn eval_tangents(&self, instance: u32, element: u32, uv: Vec2) -> (Vec3, Vec3) {
        let (frame, shape) = self.placed(instance);
        let (tu, tv) = shape.tangents(element, uv);
        let (tu, tv) = (frame.transform_vector3(tu), frame.transform_vector3(tv));
        // Of elements so large, small or flat that single precision cannot tell.
        if tu.is_finite() && tv.is_finite() { (tu, tv) } else { (Vec3::ZERO, Vec3::ZERO) }
    }

    /// `normal` bent by a normal map.
    fn mapped_normal(
        &self,
        instance: u32,
        element: u32,
        uv: Vec2,
        map: &Texture,
        normal: Vec3,
    ) -> Vec3 {
        let texcoord = self.eval_texcoord(instance, element, uv);
        let mut bent = 2.0 * map.data(texcoord).truncate() - Vec3::ONE;
        let (tu, tv) = self.eval_tangents(instance, element, uv);
        let Some(x) = (tu - normal * normal.dot(tu)).try_normalize() else { return normal };
        let y = normal.cross(x);
        // Rows of an image run down: a map's y points against v.
        if y.dot(tv) >= 0.0 {
            bent.y = -bent.y;
        }
        (x * bent.x + y * bent.y + normal * bent.z).normalize_or(normal)
    }
}

/// How far above the surface a mirror image is to be: twice what its height is rounded by here, which is at
/// most eight units of roundoff for three products and sums of unit vectors.
const LEAST_RISE: f32 = 16.0 * UNIT_ROUNDOFF;

/// `normal`, or what is as near to it as the mirror image of `outgoing` may be: not below the surface, whose
/// normal towards the viewer is `up`.
///
/// The mirror image is lifted straight up to the surface; the normal is half way between it and the
/// viewer. After A. Keller and others, "The Iray Light Transport Simulation and Rendering System", 2017,
/// appendix on shading normals.
fn bounded(normal: Vec3, up: Vec3, outgoing: Vec3) -> Vec3 {
    let mirrored = |normal: Vec3| 2.0 * normal.dot(outgoing) * normal - outgoing;
    let image = mirrored(normal);
    let height = image.dot(up);
    if height >= LEAST_RISE {
        // A mirror image tells a normal not from its opposite.
        return if normal.dot(outgoing) >= 0.0 { normal } else { -normal };
    }
    let along = (image - height * up).normalize_or_zero();
    let half = (along + LEAST_RISE * up + outgoing).normalize_or(up);
    // Where the viewer and the image are nearly opposite, few digits of what is half way are left.
    if mirrored(half).dot(up) >= 0.5 * LEAST_RISE { half } else { up }
}

/// The normal of a face: two triangles that stand for a quad share the mean of theirs, as in yocto-gl.
fn face_normal(shape: &Shape, element: u32, matrix: &Mat3A, geometric: Vec3) -> Vec3 {
    if shape.elements.kind() != ElementKind::Quads {
        return geometric;
    }
    let Primitive::Quad(quad) = shape.primitive(element) else { return geometric };
    let of_triangle = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).normalize_or_zero();
    let sum = of_triangle(quad.p0, quad.p1, quad.p3) + of_triangle(quad.p2, quad.p3, quad.p1);
    let mean = transform_normal(matrix, sum);
    if mean == Vec3::ZERO { geometric } else { mean }
}

impl Shape {
    /// In object space.
    fn tangents(&self, element: u32, uv: Vec2) -> (Vec3, Vec3) {
        match (self.primitive(element), &self.elements) {
            (Primitive::Patch(patch), Elements::Quads(quads)) => {
                let (du, dv) = patch.tangents(uv);
                if self.texcoords.is_empty() {
                    return (du, dv);
                }
                let [a, b, c, d] =
                    quads[element as usize].map(|vertex| self.texcoords[vertex as usize]);
                let by_u = (b - a) * (1.0 - uv.y) + (c - d) * uv.y;
                let by_v = (d - a) * (1.0 - uv.x) + (c - b) * uv.x;
                by_texcoords(du, dv, by_u, by_v)
            }
            (Primitive::Quad(quad), Elements::Quads(quads)) => {
                let [a, b, _, d] = quads[element as usize];
                self.tangents_of_triangle([a, b, d], quad.p1 - quad.p0, quad.p3 - quad.p0)
            }
            (Primitive::Triangle(triangle), Elements::Triangles(triangles)) => {
                let (du, dv) = (triangle.p1 - triangle.p0, triangle.p2 - triangle.p0);
                self.tangents_of_triangle(triangles[element as usize], du, dv)
            }
            (Primitive::Sphere(sphere), _) => sphere.tangents(uv),
            (Primitive::Cone(cone), _) => cone.tangents(uv),
            _ => (Vec3::ZERO, Vec3::ZERO),
        }
    }

    fn tangents_of_triangle(&self, vertices: [u32; 3], du: Vec3, dv: Vec3) -> (Vec3, Vec3) {
        if self.texcoords.is_empty() {
            return (du, dv);
        }
        let [a, b, c] = vertices.map(|vertex| self.texcoords[vertex as usize]);
        by_texcoords(du, dv, b - a, c - a)
    }
}

/// The chain rule: position and texture coordinates by the parameters gives position by texture
/// coordinates.
fn by_texcoords(du: Vec3, dv: Vec3, by_u: Vec2, by_v: Vec2) -> (Vec3, Vec3) {
    let determinant = by_u.perp_dot(by_v);
    let (tu, tv) =
        ((du * by_v.y - dv * by_u.y) / determinant, (dv * by_u.x - du * by_v.x) / determinant);
    if tu.is_finite() && tv.is_finite() { (tu, tv) } else { (Vec3::ZERO, Vec3::ZERO) }
}

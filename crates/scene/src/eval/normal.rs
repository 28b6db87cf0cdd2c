//! Shading normals, which ask the element, the method, the material and the viewer.

use super::{position::transform_normal, weights::Weights};
use crate::{
    Elements, MaterialKind, Method, Scene, SceneHit, Shape, Texture, primitive::Primitive,
};
use glam::{Mat3A, Vec2, Vec3};

impl Scene {
    /// The normal that light scatters about, of unit length. `outgoing` points to the viewer and need
    /// not have unit length.
    ///
    /// | element | vanilla | enhanced |
    /// | --- | --- | --- |
    /// | point | `outgoing` | of the sphere |
    /// | line | `outgoing`, made orthogonal to the interpolated tangent | of the cone |
    /// | triangle, quad | of the vertices, else of the face (of a quad the mean of its two triangles); then the normal map | the same, of the patch |
    ///
    /// Refractive surfaces keep their side, for it tells in from out; all others turn to the viewer.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn eval_shading_normal(&self, hit: &SceneHit, outgoing: Vec3) -> Vec3 {
        let instance = &self.instances[hit.instance as usize];
        let shape = &self.shapes[instance.shape as usize];
        let material = &self.materials[instance.material as usize];
        let matrix = &instance.world_from_object.matrix3;
        let vanilla = shape.method == Method::Vanilla;
        let normal = match &shape.elements {
            Elements::Points(_) if vanilla => return outgoing.normalize_or(hit.normal),
            Elements::Lines(lines) if vanilla => {
                let [a, b] = lines[hit.element as usize].map(|vertex| vertex as usize);
                let tangent = Weights::new(shape, hit.element, hit.uv)
                    .of(&shape.normals)
                    .unwrap_or_else(|| shape.positions[b] - shape.positions[a]);
                let tangent = matrix.mul_vec3(tangent).normalize_or_zero();
                let outgoing = outgoing.normalize_or_zero();
                return (outgoing - tangent * outgoing.dot(tangent)).normalize_or(hit.normal);
            }
            Elements::Points(_) | Elements::Lines(_) => hit.normal,
            Elements::Triangles(_) | Elements::Quads(_) => {
                let smooth = Weights::new(shape, hit.element, hit.uv)
                    .of(&shape.normals)
                    .map_or(Vec3::ZERO, |normal| transform_normal(matrix, normal));
                // Vertices without a normal, or with normals that cancel, leave it to the face.
                let normal =
                    if smooth == Vec3::ZERO { face_normal(shape, hit, matrix) } else { smooth };
                match material.normal_tex {
                    Some(index) => {
                        let map = &self.textures[index as usize];
                        self.mapped_normal(hit, map, normal)
                    }
                    None => normal,
                }
            }
        };
        if material.kind == MaterialKind::Refractive || normal.dot(outgoing) >= 0.0 {
            normal
        } else {
            -normal
        }
    }

    /// How the point moves with its texture coordinates, in world space: the derivatives of position
    /// by `u` and by `v`. Zeros where texture coordinates do not vary: there is no such derivative.
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
        (frame.transform_vector3(tu), frame.transform_vector3(tv))
    }

    /// `normal` bent by a normal map.
    fn mapped_normal(&self, hit: &SceneHit, map: &Texture, normal: Vec3) -> Vec3 {
        let texcoord = self.eval_texcoord(hit.instance, hit.element, hit.uv);
        let mut bent = 2.0 * map.data(texcoord).truncate() - Vec3::ONE;
        let (tu, tv) = self.eval_tangents(hit.instance, hit.element, hit.uv);
        let Some(x) = (tu - normal * normal.dot(tu)).try_normalize() else { return normal };
        let y = normal.cross(x);
        // Rows of an image run down: a map's y points against v.
        if y.dot(tv) >= 0.0 {
            bent.y = -bent.y;
        }
        (x * bent.x + y * bent.y + normal * bent.z).normalize_or(normal)
    }
}

/// The normal of a face: two triangles that stand for a quad share the mean of theirs, as in yocto-gl.
fn face_normal(shape: &Shape, hit: &SceneHit, matrix: &Mat3A) -> Vec3 {
    let Primitive::Quad(quad) = shape.primitive(hit.element) else { return hit.normal };
    let of_triangle = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).normalize_or_zero();
    let sum = of_triangle(quad.p0, quad.p1, quad.p3) + of_triangle(quad.p2, quad.p3, quad.p1);
    let mean = transform_normal(matrix, sum);
    if mean == Vec3::ZERO { hit.normal } else { mean }
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

//! Shading normals and tangents, by element, method, material and viewer.

use super::{position::transform_normal, weights::Weights};
use crate::{
    ElementKind, Elements, MaterialKind, Method, Scene, SceneHit, Shape, Texture,
    primitive::Primitive,
};
use glam::{Mat3A, Vec2, Vec3};
use rotund_geometry::UNIT_ROUNDOFF;

impl Scene {
    /// Returns the outward shading normal, neither flipped towards a viewer nor clamped; of unit
    /// length. [`Self::shading_normal`] does both.
    ///
    /// That of vanilla points and lines depends on the viewer; here it is [`Self::eval_normal`].
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_shading_normal(&self, instance: u32, element: u32, uv: Vec2) -> Vec3 {
        let geometric = self.eval_normal(instance, element, uv);
        self.bent_normal(instance, element, uv, geometric)
    }

    /// Returns the shading normal at a hit, of unit length. `outgoing` points to the viewer and
    /// need not have unit length.
    ///
    /// | element | vanilla | enhanced |
    /// | --- | --- | --- |
    /// | point | `outgoing` | sphere, normal map |
    /// | line | `outgoing`, orthogonal to the interpolated tangent | cone, normal map |
    /// | triangle, quad | vertices or face, normal map | vertices or patch, normal map, clamped |
    ///
    /// The face normal of a vanilla quad is the mean of those of its two triangles. Vertex normals
    /// replace it if the shape has them.
    ///
    /// Normals of refractive surfaces keep their side, which distinguishes inside from outside; all
    /// others are flipped towards the viewer.
    ///
    /// Clamping: if the mirror image of `outgoing` about a normal is below the surface, where no
    /// light can be reflected to, the normal is turned towards the geometric normal until the
    /// mirror image is on the surface. Vanilla shapes skip this, as yocto-gl does, and lose that
    /// energy.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn shading_normal(&self, hit: &SceneHit, outgoing: Vec3) -> Vec3 {
        let instance = &self.instances[hit.instance as usize];
        let shape = &self.shapes[instance.shape as usize];
        let material = &self.materials[instance.material as usize];
        let refractive = material.kind == MaterialKind::Refractive;
        let enhanced = shape.method == Method::Enhanced;
        let plain = match &shape.elements {
            Elements::Points(_) | Elements::Lines(_) => enhanced,
            Elements::Triangles(_) => shape.normals.is_empty(),
            Elements::Quads(_) => enhanced && shape.normals.is_empty(),
        };
        if plain && material.normal_tex.is_none() {
            // The usual case: the geometric normal, which needs no bound unless the viewer grazes.
            let rise = hit.normal.dot(outgoing);
            if rise * rise > 1e-6 * outgoing.length_squared() {
                return if rise >= 0.0 || refractive { hit.normal } else { -hit.normal };
            }
        }
        let outgoing = outgoing.normalize_or(hit.normal);
        if enhanced {
            let normal = self.bent_normal(hit.instance, hit.element, hit.uv, hit.normal);
            // The geometric normal decides on the side of the viewer.
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

    /// Returns the normal of the vertices, or else `geometric`, perturbed by the normal map.
    fn bent_normal(&self, instance: u32, element: u32, uv: Vec2, geometric: Vec3) -> Vec3 {
        let (frame, shape) = self.placed(instance);
        let material = &self.materials[self.instances[instance as usize].material as usize];
        let normal = match &shape.elements {
            Elements::Points(_) | Elements::Lines(_) if shape.method == Method::Vanilla => {
                return geometric;
            }
            Elements::Points(_) | Elements::Lines(_) => geometric,
            Elements::Triangles(_) | Elements::Quads(_) => {
                let smooth = if shape.normals.is_empty() {
                    Vec3::ZERO
                } else {
                    Weights::new(shape, element, uv)
                        .of(&shape.normals)
                        .map_or(Vec3::ZERO, |normal| transform_normal(&frame.matrix3, normal))
                };
                // Fall back to the face if vertices have no normals, or if those cancel.
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

    /// Returns the derivatives of position by the texture coordinates `u` and `v`, in world space.
    /// They are zero where they do not exist: texture coordinates do not vary, or the result is not
    /// finite.
    ///
    /// The derivatives of a patch vary over it. Both triangles of a vanilla quad have those of the
    /// first, as in yocto-gl. Spheres and cones return the derivatives by their own parameters, so
    /// that the first one of a cone is the tangent along its profile, from the first end to the
    /// second. Those of vanilla points and lines are zero: the tangent of a vanilla line is
    /// [`Self::eval_normal`].
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_tangents(&self, instance: u32, element: u32, uv: Vec2) -> (Vec3, Vec3) {
        let (frame, shape) = self.placed(instance);
        let (tu, tv) = shape.tangents(element, uv);
        let (tu, tv) = (frame.transform_vector3(tu), frame.transform_vector3(tv));
        // Elements that are extremely large, small or flat overflow `f32`.
        if tu.is_finite() && tv.is_finite() { (tu, tv) } else { (Vec3::ZERO, Vec3::ZERO) }
    }

    /// Perturbs `normal` by a normal map.
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
        // Rows of an image run down, so the y axis of a normal map is opposite to v.
        if y.dot(tv) >= 0.0 {
            bent.y = -bent.y;
        }
        (x * bent.x + y * bent.y + normal * bent.z).normalize_or(normal)
    }
}

/// Least height of a mirror image above the surface: twice the rounding error of the height as
/// computed here, which is at most eight units of roundoff for three products and sums of unit
/// vectors.
const LEAST_RISE: f32 = 16.0 * UNIT_ROUNDOFF;

/// Returns `normal`, turned so far towards `up` that the mirror image of `outgoing` about it is not
/// below the surface. `up` is the geometric normal on the side of the viewer.
///
/// The mirror image is projected to the surface along `up`, and the result is the half vector of it
/// and `outgoing`. After A. Keller and others, "The Iray Light Transport Simulation and Rendering
/// System", 2017, appendix on shading normals.
fn bounded(normal: Vec3, up: Vec3, outgoing: Vec3) -> Vec3 {
    let mirrored = |normal: Vec3| 2.0 * normal.dot(outgoing) * normal - outgoing;
    let image = mirrored(normal);
    let height = image.dot(up);
    if height >= LEAST_RISE {
        // A normal and its opposite have the same mirror image.
        return if normal.dot(outgoing) >= 0.0 { normal } else { -normal };
    }
    let along = (image - height * up).normalize_or_zero();
    let half = (along + LEAST_RISE * up + outgoing).normalize_or(up);
    // The half vector of nearly opposite directions loses its digits by cancellation.
    if mirrored(half).dot(up) >= 0.5 * LEAST_RISE { half } else { up }
}

/// Returns the normal of a face. Both triangles of a vanilla quad have the mean of their normals,
/// as in yocto-gl.
fn face_normal(shape: &Shape, element: u32, matrix: &Mat3A, geometric: Vec3) -> Vec3 {
    if shape.elements.kind() != ElementKind::Quads || shape.method == Method::Enhanced {
        return geometric;
    }
    let Primitive::Quad(quad) = shape.primitive(element) else { return geometric };
    let of_triangle = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).normalize_or_zero();
    let sum = of_triangle(quad.p0, quad.p1, quad.p3) + of_triangle(quad.p2, quad.p3, quad.p1);
    let mean = transform_normal(matrix, sum);
    if mean == Vec3::ZERO { geometric } else { mean }
}

impl Shape {
    /// Returns the derivatives of position by the texture coordinates, in object space.
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

/// Returns the derivatives of position by texture coordinates from those of both by the parameters
/// (chain rule).
fn by_texcoords(du: Vec3, dv: Vec3, by_u: Vec2, by_v: Vec2) -> (Vec3, Vec3) {
    let determinant = by_u.perp_dot(by_v);
    let (tu, tv) =
        ((du * by_v.y - dv * by_u.y) / determinant, (dv * by_u.x - du * by_v.x) / determinant);
    if tu.is_finite() && tv.is_finite() { (tu, tv) } else { (Vec3::ZERO, Vec3::ZERO) }
}

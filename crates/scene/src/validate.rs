//! Validation of scenes: trees, evaluation and rendering rely on what it checks.

use crate::{
    Camera, ElementKind, Elements, Environment, Instance, Material, Pixels, Scene, SceneError,
    SceneItem, Shape, Texture,
};
use glam::{Affine3A, Vec3, Vec4};
use rayon::prelude::*;
use rotund_bvh::MAX_PRIMITIVES;

impl Scene {
    /// Checks everything that ray queries, evaluation and rendering rely on.
    /// [`crate::Trees::build`] calls it first.
    ///
    /// - Indices are in range: of vertices in elements, of shapes and materials in instances, of
    ///   textures in materials and environments.
    /// - Normals, texture coordinates, colours and radii are absent or one for each position.
    ///   Points and lines have radii. There are no more points than positions.
    /// - Numbers are finite. Radii, colours and emission are not negative. Roughness, opacity and
    ///   albedo are between 0 and 1, anisotropy strictly between -1 and 1. Indices of refraction,
    ///   transmission depths, and the lens, film, aspect and focus of cameras are positive.
    /// - Frames have inverses.
    /// - Textures have as many pixels as their size says, and at least one. Those of emission have
    ///   no negative red, green or blue.
    ///
    /// It reads every array once, on all threads of the current rayon pool: tens of milliseconds
    /// for ten million points, a few percent of the time that their tree takes.
    ///
    /// # Errors
    ///
    /// Reports the first mistake in the order of the fields of [`Scene`], independent of the
    /// number of threads.
    pub fn validate(&self) -> Result<(), SceneError> {
        first_error(&self.cameras, camera)?;
        first_error(&self.environments, |i, environment| self.environment(i, environment))?;
        let of_emission = self.textures_of_emission();
        first_error(&self.textures, |i, it| texture(i, it, of_emission[i]))?;
        first_error(&self.materials, |i, material| self.material(i, material))?;
        first_error(&self.shapes, shape)?;
        first_error(&self.instances, |i, instance| self.instance(i, instance))
    }

    /// Returns for each texture whether it scales an emission.
    fn textures_of_emission(&self) -> Vec<bool> {
        let mut of_emission = vec![false; self.textures.len()];
        let environments = self.environments.iter().map(|it| it.emission_tex);
        for index in environments.chain(self.materials.iter().map(|it| it.emission_tex)).flatten() {
            // An index out of range is the mistake of another item.
            if let Some(it) = of_emission.get_mut(index as usize) {
                *it = true;
            }
        }
        of_emission
    }

    fn environment(&self, index: usize, environment: &Environment) -> Result<(), SceneError> {
        let item = || item("environments", index, &environment.name);
        frame(&item, "world_from_environment", &environment.world_from_environment)?;
        color(&item, "emission", environment.emission)?;
        self.texture_index(&item, "emission_tex", environment.emission_tex)
    }

    fn material(&self, index: usize, material: &Material) -> Result<(), SceneError> {
        let item = || item("materials", index, &material.name);
        color(&item, "emission", material.emission)?;
        color(&item, "color", material.color)?;
        number(&item, "roughness", material.roughness, "between 0 and 1", in_unit)?;
        number(&item, "ior", material.ior, POSITIVE, |x| x > 0.0)?;
        number(&item, "trdepth", material.trdepth, POSITIVE, |x| x > 0.0)?;
        let albedo = material.albedo;
        if !(albedo.cmpge(Vec3::ZERO).all() && albedo.cmple(Vec3::ONE).all()) {
            let (field, value, expected) =
                ("albedo", listed(albedo.as_ref()), "numbers from 0 to 1");
            return Err(SceneError::Value { item: item(), field, value, expected });
        }
        let expected = "between -1 and 1, both excluded";
        number(&item, "anisotropy", material.anisotropy, expected, |x| x.abs() < 1.0)?;
        number(&item, "opacity", material.opacity, "between 0 and 1", in_unit)?;
        self.texture_index(&item, "emission_tex", material.emission_tex)?;
        self.texture_index(&item, "color_tex", material.color_tex)?;
        self.texture_index(&item, "roughness_tex", material.roughness_tex)?;
        self.texture_index(&item, "scattering_tex", material.scattering_tex)?;
        self.texture_index(&item, "normal_tex", material.normal_tex)
    }

    fn instance(&self, index: usize, instance: &Instance) -> Result<(), SceneError> {
        let item = || item("instances", index, &instance.name);
        frame(&item, "world_from_object", &instance.world_from_object)?;
        in_range(&item, "shape", instance.shape, "shapes", self.shapes.len())?;
        in_range(&item, "material", instance.material, "materials", self.materials.len())
    }

    fn texture_index(
        &self,
        item: &dyn Fn() -> SceneItem,
        field: &'static str,
        index: Option<u32>,
    ) -> Result<(), SceneError> {
        index.map_or(Ok(()), |i| in_range(item, field, i, "textures", self.textures.len()))
    }
}

const POSITIVE: &str = "a positive finite number";

pub(crate) fn item(array: &'static str, index: usize, name: &str) -> SceneItem {
    SceneItem { array, index, name: name.to_owned() }
}

/// Returns the error of the first item that has one.
fn first_error<T: Sync>(
    items: &[T],
    check: impl Fn(usize, &T) -> Result<(), SceneError> + Sync,
) -> Result<(), SceneError> {
    let error = |(index, item)| check(index, item).err();
    items.par_iter().enumerate().find_map_first(error).map_or(Ok(()), Err)
}

impl Camera {
    /// Checks what [`Scene::validate`] checks of a camera, which errors call `cameras[0]`.
    ///
    /// # Errors
    ///
    /// If a number is not finite, the frame has no inverse, or lens, film, aspect or focus is not
    /// positive.
    pub fn validate(&self) -> Result<(), SceneError> {
        camera(0, self)
    }
}

fn camera(index: usize, camera: &Camera) -> Result<(), SceneError> {
    let item = || item("cameras", index, &camera.name);
    if !camera.world_from_camera.is_finite() {
        let value = listed(&camera.world_from_camera.to_cols_array());
        let expected = "finite numbers; `Camera::look_at` returns others if `eye` is `target`, or \
                        `up` is zero or parallel to the view";
        let field = "world_from_camera";
        return Err(SceneError::Value { item: item(), field, value, expected });
    }
    frame(&item, "world_from_camera", &camera.world_from_camera)?;
    number(&item, "lens", camera.lens, POSITIVE, |x| x > 0.0)?;
    number(&item, "film", camera.film, POSITIVE, |x| x > 0.0)?;
    number(&item, "aspect", camera.aspect, POSITIVE, |x| x > 0.0)?;
    number(&item, "focus", camera.focus, POSITIVE, |x| x > 0.0)?;
    number(&item, "aperture", camera.aperture, "a finite number that is not negative", |x| x >= 0.0)
}

fn texture(index: usize, texture: &Texture, of_emission: bool) -> Result<(), SceneError> {
    let Texture { name, width, height, pixels } = texture;
    let item = || item("textures", index, name);
    for (field, size) in [("width", *width), ("height", *height)] {
        if size == 0 {
            let (value, expected) = (size.to_string(), "at least one pixel");
            return Err(SceneError::Value { item: item(), field, value, expected });
        }
    }
    let expected = *width as usize * *height as usize;
    let (fits, count) = match pixels {
        Pixels::Bytes(bytes) => (bytes.len() == expected, bytes.len()),
        Pixels::Words(words) => (words.len() == expected, words.len()),
        Pixels::Floats(floats) => (floats.len() == expected, floats.len()),
        Pixels::TiledBytes(tiles) | Pixels::SharedExponent(tiles) => {
            let size @ [columns, rows] = tiles.size();
            (size == [*width as usize, *height as usize], columns * rows)
        }
    };
    if !fits {
        let (texture, width, height) = (item(), *width, *height);
        return Err(SceneError::PixelCount { texture, width, height, pixels: count });
    }
    let Pixels::Floats(floats) = pixels else { return Ok(()) };
    let refused = |bad: Option<usize>, expected| {
        bad.map_or(Ok(()), |i| {
            let (x, y) = (i % *width as usize, i / *width as usize);
            let (texture, value) = (item(), listed(&floats[i]));
            Err(SceneError::PixelValue { texture, x, y, value, expected })
        })
    };
    let infinite = first(floats, |pixel| !Vec4::from_array(*pixel).is_finite());
    refused(infinite, "finite numbers")?;
    if !of_emission {
        return Ok(());
    }
    let dark = first(floats, |&[r, g, b, _]| Vec3::new(r, g, b).cmplt(Vec3::ZERO).any());
    refused(dark, "an emission that is not negative")
}

/// Checks the arrays of a shape.
pub(crate) fn shape(index: usize, shape: &Shape) -> Result<(), SceneError> {
    let item = || item("shapes", index, &shape.name);
    let positions = shape.positions.len();
    let (kind, count) = (shape.elements.kind(), shape.elements.count());
    if count > MAX_PRIMITIVES {
        return Err(SceneError::TooMany { shape: item(), kind, count, limit: MAX_PRIMITIVES });
    }
    let lengths = [
        ("normals", shape.normals.len()),
        ("texcoords", shape.texcoords.len()),
        ("colors", shape.colors.len()),
        ("radii", shape.radii.len()),
    ];
    let other_length = |(_, length): &(_, usize)| *length != 0 && *length != positions;
    if let Some((array, length)) = lengths.into_iter().find(other_length) {
        return Err(SceneError::ArrayLength { shape: item(), array, length, positions });
    }
    let round = matches!(kind, ElementKind::Points | ElementKind::Lines);
    if round && count > 0 && positions > 0 && shape.radii.is_empty() {
        return Err(SceneError::MissingRadii { shape: item(), kind });
    }
    match &shape.elements {
        Elements::Points(points) if count > positions => {
            let (shape, points) = (item(), *points);
            Err(SceneError::MissingPositions { shape, points, positions })
        }
        Elements::Points(_) => Ok(()),
        Elements::Lines(lines) => vertices(&item, kind, lines, positions),
        Elements::Triangles(triangles) => vertices(&item, kind, triangles, positions),
        Elements::Quads(quads) => vertices(&item, kind, quads, positions),
    }?;
    let finite = "finite numbers";
    values(
        &item,
        "positions",
        &shape.positions,
        finite,
        |p| p.is_finite(),
        |p| listed(p.as_ref()),
    )?;
    values(&item, "normals", &shape.normals, finite, |n| n.is_finite(), |n| listed(n.as_ref()))?;
    values(
        &item,
        "texcoords",
        &shape.texcoords,
        finite,
        |t| t.is_finite(),
        |t| listed(t.as_ref()),
    )?;
    let expected = "finite numbers that are not negative";
    values(&item, "colors", &shape.colors, expected, is_color, |c| listed(c.as_ref()))?;
    let expected = "a finite number that is not negative";
    values(&item, "radii", &shape.radii, expected, is_radius, |r| short(*r))
}

/// Refuses the first value of an array that does not fit.
fn values<T: Sync>(
    shape: &dyn Fn() -> SceneItem,
    array: &'static str,
    values: &[T],
    expected: &'static str,
    fits: impl Fn(&T) -> bool + Sync,
    print: impl Fn(&T) -> String,
) -> Result<(), SceneError> {
    match first(values, |value| !fits(value)) {
        None => Ok(()),
        Some(vertex) => Err(SceneError::VertexValue {
            shape: shape(),
            array,
            vertex,
            value: print(&values[vertex]),
            expected,
        }),
    }
}

/// Refuses the first element with a vertex that is out of range.
fn vertices<const N: usize>(
    shape: &dyn Fn() -> SceneItem,
    kind: ElementKind,
    elements: &[[u32; N]],
    positions: usize,
) -> Result<(), SceneError> {
    match first_outside(elements, positions) {
        None => Ok(()),
        Some((element, vertex)) => {
            let shape = shape();
            Err(SceneError::VertexOutOfRange { shape, kind, element, vertex, positions })
        }
    }
}

fn in_range(
    item: &dyn Fn() -> SceneItem,
    field: &'static str,
    index: u32,
    what: &'static str,
    count: usize,
) -> Result<(), SceneError> {
    if (index as usize) < count {
        return Ok(());
    }
    Err(SceneError::IndexOutOfRange { item: item(), field, index, what, count })
}

fn number(
    item: &dyn Fn() -> SceneItem,
    field: &'static str,
    value: f32,
    expected: &'static str,
    fits: impl Fn(f32) -> bool,
) -> Result<(), SceneError> {
    if value.is_finite() && fits(value) {
        return Ok(());
    }
    Err(SceneError::Value { item: item(), field, value: short(value), expected })
}

fn color(item: &dyn Fn() -> SceneItem, field: &'static str, color: Vec3) -> Result<(), SceneError> {
    if color.is_finite() && color.cmpge(Vec3::ZERO).all() {
        return Ok(());
    }
    let (value, expected) = (listed(color.as_ref()), "finite numbers that are not negative");
    Err(SceneError::Value { item: item(), field, value, expected })
}

fn frame(
    item: &dyn Fn() -> SceneItem,
    field: &'static str,
    frame: &Affine3A,
) -> Result<(), SceneError> {
    if is_invertible(frame) {
        return Ok(());
    }
    let (value, expected) = (listed(&frame.to_cols_array()), INVERTIBLE);
    Err(SceneError::Value { item: item(), field, value, expected })
}

/// What [`is_invertible`] demands, for messages.
pub(crate) const INVERTIBLE: &str = "finite numbers and a finite inverse: three independent axes, of \
                                     neither extremely small nor large scale";

/// Returns true if the frame and its inverse are finite in `f32`.
pub(crate) fn is_invertible(frame: &Affine3A) -> bool {
    let determinant = frame.matrix3.determinant();
    frame.is_finite() && determinant != 0.0 && frame.inverse().is_finite()
}

fn in_unit(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

pub(crate) fn is_radius(radius: &f32) -> bool {
    radius.is_finite() & (*radius >= 0.0)
}

pub(crate) fn is_color(color: &Vec4) -> bool {
    color.is_finite() & color.cmpge(Vec4::ZERO).all()
}

/// Prints numbers as in `(0.5, NaN, 1)`.
pub(crate) fn listed(numbers: &[f32]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|&number| short(number)).collect();
    format!("({})", numbers.join(", "))
}

/// Prints a number, with an exponent where it would have many zeros.
pub(crate) fn short(number: f32) -> String {
    let plain = number.to_string();
    if plain.len() > 12 { format!("{number:e}") } else { plain }
}

/// Returns the index of the first bad value.
pub(crate) fn first<T: Sync>(values: &[T], bad: impl Fn(&T) -> bool + Sync) -> Option<usize> {
    const BLOCK: usize = 1 << 12;
    // Almost always there is none: one branch for a whole block is faster than one for each value.
    let any = |block: &[T]| block.iter().fold(false, |any, value| any | bad(value));
    let block = values.par_chunks(BLOCK).position_first(any)? * BLOCK;
    values[block..].iter().position(&bad).map(|i| block + i)
}

/// Returns the first element that names a vertex not below `count`, and that vertex.
pub(crate) fn first_outside<const N: usize>(
    elements: &[[u32; N]],
    count: usize,
) -> Option<(usize, u32)> {
    let outside = |vertex: &u32| *vertex as usize >= count;
    let any = |vertices: &[u32; N]| vertices.iter().fold(false, |any, v| any | outside(v));
    let element = first(elements, any)?;
    let vertex = elements[element].iter().copied().find(outside)?;
    Some((element, vertex))
}

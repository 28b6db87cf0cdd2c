//! Range checks of the numbers in a scene file.

use super::{
    context::Context,
    error::{LoadError, LoadProblem},
    format::{Frame, SceneFile},
};
use crate::validate::{INVERTIBLE, is_invertible, short};

/// Refuses numbers outside of their range, naming the field.
pub(super) fn check(context: &mut Context<'_>, file: &SceneFile) -> Result<(), LoadError> {
    let version = file.asset.version.to_string();
    if !["null", "4.0", "4.1", "4.2", "4.3", "5.0"].contains(&version.trim_matches('"')) {
        context.warn(format_args!("asset.version is {version}, which is not known; read as 5.0"));
    }
    numbers(file).map_err(|problem| context.fail(problem))
}

fn numbers(file: &SceneFile) -> Result<(), LoadProblem> {
    for (i, (_, camera)) in file.cameras.items.iter().enumerate() {
        let field = |name: &str| format!("cameras[{i}].{name}");
        frame(field("frame"), camera.frame)?;
        number(field("lens"), camera.lens, POSITIVE, |x| x > 0.0)?;
        number(field("film"), camera.film, POSITIVE, |x| x > 0.0)?;
        number(field("aspect"), camera.aspect, POSITIVE, |x| x > 0.0)?;
        let focus = camera.focus.unwrap_or(1.0);
        number(field("focus"), focus, POSITIVE, |x| x > 0.0)?;
        number(field("aperture"), camera.aperture, NOT_NEGATIVE, |x| x >= 0.0)?;
        if let Some(at) = camera.lookat {
            lookat(field("lookat"), at.frame())?;
        }
    }
    for (i, (_, environment)) in file.environments.items.iter().enumerate() {
        let field = |name: &str| format!("environments[{i}].{name}");
        frame(field("frame"), environment.frame)?;
        if let Some(at) = environment.lookat {
            lookat(field("lookat"), at.frame())?;
        }
        color(field("emission"), environment.emission)?;
    }
    for (i, (_, material)) in file.materials.items.iter().enumerate() {
        let field = |name: &str| format!("materials[{i}].{name}");
        color(field("emission"), material.emission)?;
        color(field("color"), material.color)?;
        number(field("roughness"), material.roughness, UNIT, in_unit)?;
        number(field("opacity"), material.opacity, UNIT, in_unit)?;
        number(field("ior"), material.ior, POSITIVE, |x| x > 0.0)?;
        number(field("trdepth"), material.trdepth, POSITIVE, |x| x > 0.0)?;
        let mut scattering = material.scattering.into_iter();
        scattering.try_for_each(|c| number(field("scattering"), c, UNIT, in_unit))?;
        let anisotropy = material.scanisotropy;
        number(field("scanisotropy"), anisotropy, "between -1 and 1", |x| x.abs() < 1.0)?;
    }
    for (i, (_, instance)) in file.instances.items.iter().enumerate() {
        let field = |name: &str| format!("instances[{i}].{name}");
        frame(field("frame"), instance.frame)?;
        if let Some(at) = instance.lookat {
            lookat(field("lookat"), at.frame())?;
        }
    }
    Ok(())
}

const POSITIVE: &str = "a positive finite number";
const NOT_NEGATIVE: &str = "a finite number that is not negative";
const UNIT: &str = "a number between 0 and 1";

fn in_unit(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

fn number(
    field: String,
    value: f32,
    expected: &'static str,
    fits: impl Fn(f32) -> bool,
) -> Result<(), LoadProblem> {
    if value.is_finite() && fits(value) {
        return Ok(());
    }
    Err(LoadProblem::Value { field, value: short(value), expected })
}

fn color(field: String, color: [f32; 3]) -> Result<(), LoadProblem> {
    color.into_iter().try_for_each(|c| number(field.clone(), c, NOT_NEGATIVE, |x| x >= 0.0))
}

fn lookat(field: String, frame: glam::Affine3A) -> Result<(), LoadProblem> {
    if frame.is_finite() {
        return Ok(());
    }
    Err(LoadProblem::Value {
        field,
        value: "without a direction".to_owned(),
        expected: "an eye, a target apart from it, and an up vector that is not parallel to the view",
    })
}

/// Refuses a frame that is not finite or whose inverse is not.
pub(super) fn frame(field: String, frame: Frame) -> Result<(), LoadProblem> {
    let frame = frame.single();
    if is_invertible(&frame) {
        return Ok(());
    }
    Err(LoadProblem::Value {
        field,
        value: format!("{:?}", frame.to_cols_array()),
        expected: INVERTIBLE,
    })
}

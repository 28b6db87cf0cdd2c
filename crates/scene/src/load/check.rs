//! Numbers of a scene file that mean something.

use super::format::{Frame, SceneFile};
use crate::{LoadError, validate::is_invertible};
use std::path::Path;

/// Refuses numbers that no scene can mean, naming the field.
pub(super) fn check(
    path: &Path,
    file: &SceneFile,
    warnings: &mut Vec<String>,
) -> Result<(), LoadError> {
    let version = file.asset.version.to_string();
    if !["null", "4.0", "4.1", "4.2", "4.3", "5.0"].contains(&version.trim_matches('"')) {
        warnings.push(format!(
            "{}: asset.version is {version}, which is not known; read as 5.0",
            path.display()
        ));
    }
    let checker = Checker { path };
    for (i, (_, camera)) in file.cameras.items.iter().enumerate() {
        let field = |name: &str| format!("cameras[{i}].{name}");
        checker.frame(field("frame"), camera.frame)?;
        checker.number(field("lens"), camera.lens, "a positive number", |x| x > 0.0)?;
        checker.number(field("film"), camera.film, "a positive number", |x| x > 0.0)?;
        checker.number(field("aspect"), camera.aspect, "a positive number", |x| x > 0.0)?;
        let focus = camera.focus.unwrap_or(1.0);
        checker.number(field("focus"), focus, "a positive number", |x| x > 0.0)?;
        checker.number(field("aperture"), camera.aperture, NOT_NEGATIVE, |x| x >= 0.0)?;
        if let Some(lookat) = camera.lookat {
            checker.lookat(field("lookat"), lookat.frame())?;
        }
    }
    for (i, (_, environment)) in file.environments.items.iter().enumerate() {
        let field = |name: &str| format!("environments[{i}].{name}");
        checker.frame(field("frame"), environment.frame)?;
        if let Some(lookat) = environment.lookat {
            checker.lookat(field("lookat"), lookat.frame())?;
        }
        checker.color(field("emission"), environment.emission)?;
    }
    for (i, (_, material)) in file.materials.items.iter().enumerate() {
        let field = |name: &str| format!("materials[{i}].{name}");
        checker.color(field("emission"), material.emission)?;
        checker.color(field("color"), material.color)?;
        checker.number(field("roughness"), material.roughness, UNIT, in_unit)?;
        checker.number(field("opacity"), material.opacity, UNIT, in_unit)?;
        checker.number(field("ior"), material.ior, "a positive number", |x| x > 0.0)?;
        checker.number(field("trdepth"), material.trdepth, "a positive number", |x| x > 0.0)?;
        checker.color(field("scattering"), material.scattering)?;
        let anisotropy = material.scanisotropy;
        checker.number(field("scanisotropy"), anisotropy, "between -1 and 1", |x| x.abs() < 1.0)?;
    }
    for (i, (_, instance)) in file.instances.items.iter().enumerate() {
        let field = |name: &str| format!("instances[{i}].{name}");
        checker.frame(field("frame"), instance.frame)?;
        if let Some(lookat) = instance.lookat {
            checker.lookat(field("lookat"), lookat.frame())?;
        }
    }
    Ok(())
}

const NOT_NEGATIVE: &str = "a number that is not negative";
const UNIT: &str = "a number between 0 and 1";

fn in_unit(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

struct Checker<'a> {
    path: &'a Path,
}

impl Checker<'_> {
    fn number(
        &self,
        field: String,
        value: f32,
        expected: &'static str,
        fits: impl Fn(f32) -> bool,
    ) -> Result<(), LoadError> {
        if value.is_finite() && fits(value) {
            return Ok(());
        }
        Err(LoadError::Value {
            path: self.path.to_owned(),
            field,
            value: value.to_string(),
            expected,
        })
    }

    fn color(&self, field: String, color: [f32; 3]) -> Result<(), LoadError> {
        color
            .into_iter()
            .try_for_each(|c| self.number(field.clone(), c, NOT_NEGATIVE, |x| x >= 0.0))
    }

    fn frame(&self, field: String, frame: Frame) -> Result<(), LoadError> {
        self::frame(self.path, || field, frame)
    }

    fn lookat(&self, field: String, frame: glam::Affine3A) -> Result<(), LoadError> {
        if frame.is_finite() {
            return Ok(());
        }
        Err(LoadError::Value {
            path: self.path.to_owned(),
            field,
            value: "without a direction".to_owned(),
            expected: "an eye, a centre apart from it, and an up vector across",
        })
    }
}

/// Refuses a frame without an inverse that `f32` can hold.
pub(super) fn frame(
    path: &Path,
    field: impl FnOnce() -> String,
    Frame(frame): Frame,
) -> Result<(), LoadError> {
    if is_invertible(&frame) {
        return Ok(());
    }
    Err(LoadError::Value {
        path: path.to_owned(),
        field: field(),
        value: format!("{:?}", frame.to_cols_array()),
        expected: "a frame with three independent axes",
    })
}

//! Shapes of types (gsd.readthedocs.io/en/stable/shapes.html): a JSON object for each, such as `{"type": "Sphere", "diameter": 2}`.

use halfline_ground::quote::quote;
use serde_json::Value;

/// The shape of the particles of a type.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// A sphere of this radius.
    Sphere(f64),
    /// Another shape, by its name.
    Other(String),
    /// No shape is given.
    None,
}

impl Shape {
    /// The shape of a text, or its problem. An ellipsoid with three equal semi-axes is a sphere.
    pub(super) fn of(text: &str) -> Result<Self, String> {
        if text.trim().is_empty() {
            return Ok(Self::None);
        }
        let shape: Value =
            serde_json::from_str(text).map_err(|error| format!("{} is not JSON ({error})", quote(text)))?;
        let Some(name) = shape.get("type") else { return Ok(Self::None) };
        let Some(name) = name.as_str() else { return Err("the type of the shape is not a text".into()) };
        let length = |key: &str| {
            let length = shape.get(key).and_then(Value::as_f64).filter(|x| *x > 0.0 && x.is_finite());
            length.ok_or_else(|| format!("{} of the shape {} is not a positive number", quote(key), quote(name)))
        };
        match name {
            "Sphere" => Ok(Self::Sphere(length("diameter")? / 2.0)),
            "Ellipsoid" if length("a")? == length("b")? && length("b")? == length("c")? => {
                Ok(Self::Sphere(length("a")?))
            }
            name => Ok(Self::Other(name.to_owned())),
        }
    }
}

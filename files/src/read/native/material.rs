//! The material of a `[[sphere]]` of a native scene file.

use super::table::TomlTable;
use halfline::error::{Error, Result};
use halfline::quote::quote;
use halfline::scene::Material;

/// The keys that belong to some materials.
const KEYS: [&str; 7] = ["diffuse", "specular", "gloss", "shine", "transmission", "index", "fuzz"];

/// Reads the material of the sphere with this index.
pub(super) fn read(table: &TomlTable<'_>, sphere: usize) -> Result<Material> {
    let name = table.get("material").map_or(Ok("phong"), |name| name.string())?;
    let own: &[&str] = match name {
        "phong" => &["diffuse", "specular", "shine", "transmission", "index"],
        "matte" => &[],
        "plastic" => &["gloss", "shine"],
        "metal" => &["fuzz"],
        "glass" => &["index"],
        _ => {
            let place = table.need("material")?.place();
            let problem = format!("{} is not a material", quote(name));
            return Err(Error::scene(place, problem, "use \"phong\", \"matte\", \"plastic\", \"metal\" or \"glass\""));
        }
    };
    let foreign = KEYS.into_iter().filter(|key| !own.contains(key)).find_map(|key| table.get(key));
    if let Some(value) = foreign {
        let problem = format!("the material {name} has no such key");
        let keys = if own.is_empty() {
            "it has none".to_owned()
        } else {
            format!("the keys of {name} are {}", own.join(", "))
        };
        let mend = format!("remove it, or change the material; {keys}");
        return Err(Error::scene(value.place(), problem, mend));
    }
    let number = |key, default| table.get(key).map_or(Ok(default), |value| value.number());
    let share = |key, default| number(key, default).map(|x| x as f32);
    let material = match name {
        "matte" => Material::default(),
        "plastic" => Material::Plastic {
            gloss: share("gloss", Material::GLOSS.into())?,
            shine: share("shine", Material::SHINE.into())?,
        },
        "metal" => Material::Metal { fuzz: share("fuzz", 0.0)? },
        "glass" => Material::Glass { index: number("index", Material::INDEX)? },
        _ => Material::Phong {
            diffuse: share("diffuse", 1.0)?,
            specular: share("specular", 0.0)?,
            shine: share("shine", 0.0)?,
            transmission: share("transmission", 0.0)?,
            index: number("index", 1.0)?,
        },
    };
    material.check(|key| table.place_of(key, key).named(format!("sphere {sphere} {key}")))?;
    Ok(material)
}

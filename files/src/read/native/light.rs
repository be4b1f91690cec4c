//! The lights and the sky of a native scene file: `[[light]]`, `[sky]` and `[occlusion]`.

use super::table::{TomlName, TomlTable};
use glam::DVec3;
use halfline::error::{Error, Place, Result};
use halfline::scene::{Light, LightSource, Lighting, MOST_RAYS, Sky, SkyColors};

/// Reads the lighting of a scene of that many spheres. The lights of a file cast shadows.
pub(super) fn read(root: &TomlTable<'_>, spheres: usize) -> Result<Lighting> {
    let tables = root.tables("light")?.enumerate();
    let lights: Vec<_> = tables.map(|(index, table)| light(&table?, index, spheres)).collect::<Result<_>>()?;
    let rays = root.get("occlusion").map(|value| occlusion(&value.table(TomlName::part("occlusion"))?)).transpose()?;
    let colors = root.get("sky").map(|value| colors(&value.table(TomlName::part("sky"))?)).transpose()?;
    // Colours alone do not say how many rays find them.
    let sky = rays.or(colors.map(|_| Sky::AT_CENTERS)).map(|sky| Sky { colors, ..sky });
    Ok(Lighting { shadows: !lights.is_empty(), lights, sky, bounces: None })
}

fn light(table: &TomlTable<'_>, index: usize, spheres: usize) -> Result<Light> {
    table.allow(&["direction", "position", "radius", "sphere", "color", "intensity"])?;
    let vector = |key| table.need(key)?.numbers().map(DVec3::from_array);
    let radius = table.get("radius");
    let source = match table.one_of(["direction", "position", "sphere"])? {
        "position" => match radius {
            Some(radius) => LightSource::Ball { center: vector("position")?, radius: radius.number()? },
            None => LightSource::Point(vector("position")?),
        },
        other => {
            if let Some(radius) = radius {
                let problem = format!("a light with a {other} has no radius of its own");
                return Err(Error::scene(radius.place(), problem, format!("remove it, or use position, not {other}")));
            }
            match other {
                "direction" => LightSource::Direction(vector("direction")?),
                _ => LightSource::Sphere(sphere(table)?),
            }
        }
    };
    let color = table.get("color").map_or(Ok([1.0; 3]), |color| color.color())?;
    let intensity = table.get("intensity").map_or(Ok(1.0), |intensity| intensity.number())? as f32;
    let light = Light { source, color, intensity };
    light.check(spheres, |key| place(table, key, format!("light {index} {key}")))?;
    Ok(light)
}

/// The index of the sphere that is the light; an error if it is negative or beyond u32. [`Light::check`] compares it with the
/// number of spheres.
fn sphere(table: &TomlTable<'_>) -> Result<u32> {
    let value = table.need("sphere")?;
    let id = value.whole_number()?;
    u32::try_from(id).map_err(|_| {
        Error::scene(value.place(), format!("there is no sphere {id}"), "give the index of a sphere, from 0")
    })
}

fn colors(table: &TomlTable<'_>) -> Result<SkyColors> {
    table.allow(&["zenith", "horizon"])?;
    let color = |key| table.need(key)?.color();
    Ok(SkyColors { zenith: color("zenith")?, horizon: color("horizon")?, is_shown: true })
}

fn occlusion(table: &TomlTable<'_>) -> Result<Sky> {
    table.allow(&["rays", "reach"])?;
    let standard = Sky::default();
    let rays = table.get("rays").map_or(Ok(standard.rays.into()), |rays| rays.whole_number())?;
    let reach = table.get("reach").map_or(Ok(standard.reach), |reach| reach.number())?;
    let rays = u32::try_from(rays).map_err(|_| {
        let mend = format!("give a whole number between 1 and {MOST_RAYS}");
        Error::scene(place(table, "rays", "occlusion.rays".into()), format!("the sky cannot have {rays} rays"), mend)
    })?;
    let sky = Sky { rays, reach, ..Sky::default() };
    sky.check(|key| place(table, key, format!("occlusion.{key}")))?;
    Ok(sky)
}

fn place(table: &TomlTable<'_>, key: &str, name: String) -> Place {
    table.place_of(key, key).named(name)
}

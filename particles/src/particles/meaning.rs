//! The meaning of fields by their names: one rule for all formats whose fields have names.

use super::colors::ColorType;
use super::role::Role;
use super::vectors::component;
use crate::npy::header::Scalar;
use halfline_ground::quote::quote;

/// A field of a row.
pub(crate) struct NamedField<'a> {
    pub(crate) name: &'a str,
    /// Numbers per row.
    pub(crate) count: usize,
    pub(crate) kind: FieldKind,
}

/// The content of a field.
pub(crate) enum FieldKind {
    /// Numbers of a binary type.
    Binary(Scalar),
    /// Numbers in text.
    Text,
    /// Something else, in words.
    Other(String),
}

/// The meanings of the fields of a row.
pub(crate) struct Meanings {
    /// The names and roles of the columns of each field; none where it has no numbers.
    pub(crate) fields: Vec<Vec<(String, Role)>>,
    /// The field that has a colour in one number of 4 bytes, 0xRRGGBB, perhaps as the bits of a float.
    pub(crate) packed: Option<usize>,
    /// The type of the colours' numbers, which decides how they become linear RGB.
    pub(crate) color_type: ColorType,
    /// Warnings about fields that are called like colours or radii and are not taken.
    pub(crate) warnings: Vec<String>,
}

/// The names of positions and colours that are one field.
const POSITIONS: [&str; 7] = ["positions", "position", "pos", "coords", "coordinates", "points", "xyz"];
const COLORS: [&str; 6] = ["colors", "color", "colours", "colour", "rgb", "rgba"];

/// The names of three fields that are a colour, in the order of preference.
const COLOR_SETS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["r", "g", "b"], ["diffuse_red", "diffuse_green", "diffuse_blue"]];

/// The names of a field that has a colour in one number.
const PACKED: [&str; 2] = ["rgb", "rgba"];

const RADII: [&str; 2] = ["radius", "radii"];
const DIAMETERS: [&str; 2] = ["diameter", "diameters"];

/// Whether a field of this name, in lower case, is a position, a colour or a radius where its shape and its type fit.
pub(crate) fn is_known(name: &str) -> bool {
    ["x", "y", "z"].contains(&name)
        || is_length(name)
        || POSITIONS.contains(&name)
        || COLORS.contains(&name)
        || COLOR_SETS.iter().flatten().any(|known| *known == name)
}

/// Whether a name, in lower case, means a radius or a diameter.
pub(crate) fn is_length(name: &str) -> bool {
    RADII.contains(&name) || DIAMETERS.contains(&name)
}

/// The meanings of the fields of a row. A name in lower case comes before the same in capitals.
pub(crate) fn meanings(fields: &[NamedField<'_>]) -> Meanings {
    let found = Found::of(Row { fields, names: fields.iter().map(|field| field.name.to_lowercase()).collect() });
    let color_type = found.color_type();
    Meanings {
        fields: (0..fields.len()).map(|k| found.columns(k)).collect(),
        packed: found.packed,
        color_type: color_type.unwrap_or_default(),
        warnings: found.warnings(color_type.is_some()),
    }
}

/// The fields of a row, and their names in lower case.
struct Row<'a> {
    fields: &'a [NamedField<'a>],
    names: Vec<String>,
}

impl Row<'_> {
    /// Whether a field has a name in capitals that another one has in lower case.
    fn is_second(&self, k: usize) -> bool {
        let (name, field) = (&self.names[k], &self.fields[k]);
        let is_first = |other: &NamedField<'_>| other.name == name && other.count == field.count;
        field.name != name && self.fields.iter().any(|other| is_first(other) && other.is_number())
    }

    /// The field that has the first of these names.
    fn find(&self, of: &[&str], fits: impl Fn(&NamedField<'_>) -> bool) -> Option<usize> {
        let is = |k: usize, name: &str| self.names[k] == name && fits(&self.fields[k]) && !self.is_second(k);
        of.iter().find_map(|name| (0..self.names.len()).find(|k| is(*k, name)))
    }

    /// The field of one number that has the first of these names.
    fn single(&self, of: &[&str]) -> Option<usize> {
        self.find(of, |field| field.count == 1 && field.is_number())
    }

    /// Whether each of three names has a field of one number.
    fn has_all(&self, set: &[&str; 3]) -> bool {
        set.iter().all(|name| self.single(&[name]).is_some())
    }

    /// The warning that fields whose names in lower case are such are not taken; `None` without such fields.
    fn unread(&self, is: impl Fn(&str) -> bool, what: &str, mend: &str) -> Option<String> {
        let shown = |k: usize| match (&self.fields[k].kind, self.fields[k].count) {
            (FieldKind::Other(kind), _) => format!("{} ({kind})", quote(self.fields[k].name)),
            (_, 1) => quote(self.fields[k].name).to_string(),
            (_, count) => format!("{} ({count} numbers)", quote(self.fields[k].name)),
        };
        let found: Vec<String> = (0..self.names.len()).filter(|k| is(&self.names[*k])).map(shown).collect();
        (!found.is_empty()).then(|| format!("{what} are not taken from {}: {mend}", found.join(", ")))
    }
}

impl NamedField<'_> {
    fn is_number(&self) -> bool {
        !matches!(self.kind, FieldKind::Other(_))
    }

    /// Whether its number of 4 bytes may be a colour.
    fn is_packed(&self) -> bool {
        matches!(self.kind, FieldKind::Binary(scalar) if self.count == 1 && scalar.size() == 4)
    }
}

/// The fields of a row that are positions, colours and radii.
struct Found<'a> {
    row: Row<'a>,
    /// A field of three coordinates.
    positions: Option<usize>,
    /// A field of three or four components of a colour.
    vector: Option<usize>,
    /// A field that has a colour in one number.
    packed: Option<usize>,
    /// The names of three fields that are a colour.
    set: Option<&'static [&'static str; 3]>,
    /// A radius or a diameter.
    length: Option<(usize, Role)>,
}

impl<'a> Found<'a> {
    fn of(row: Row<'a>) -> Self {
        let positions = row.find(&POSITIONS, |field| field.count == 3 && field.is_number());
        let positions = positions.filter(|_| !row.has_all(&["x", "y", "z"]));
        let vector = row.find(&COLORS, |field| [3, 4].contains(&field.count) && field.is_number());
        let packed = row.find(&PACKED, |field| field.is_packed()).filter(|_| vector.is_none());
        let set = COLOR_SETS.iter().find(|set| vector.or(packed).is_none() && row.has_all(set));
        let lengths = [(&RADII, Role::Radius), (&DIAMETERS, Role::Diameter)];
        let length = lengths.into_iter().find_map(|(names, role)| Some((row.single(names)?, role)));
        Self { row, positions, vector, packed, set, length }
    }

    /// The role of a field of one number.
    fn role(&self, name: &str) -> Role {
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name).filter(|_| self.positions.is_none());
        let part = || self.set.and_then(|set| set.iter().position(|part| *part == name)).map(Role::Color);
        let length = || self.length.filter(|(field, _)| self.row.names[*field] == name).map(|(_, role)| role);
        axis.map(Role::Position).or_else(part).or_else(length).unwrap_or(Role::Other)
    }

    /// The names and roles of the columns of a field; none where it has no numbers.
    fn columns(&self, k: usize) -> Vec<(String, Role)> {
        let (name, field) = (&self.row.names[k], &self.row.fields[k]);
        let parts = |named: [&str; 3], role: fn(usize) -> Role| {
            let others = (3..field.count).map(|k| (component(name, k), Role::Other));
            (0..3).map(|k| (named[k].to_owned(), role(k))).chain(others).collect()
        };
        match field.count {
            _ if !field.is_number() => Vec::new(),
            _ if self.positions == Some(k) => parts(["x", "y", "z"], Role::Position),
            _ if self.vector == Some(k) => parts(["r", "g", "b"], Role::Color),
            _ if self.packed == Some(k) => parts(["red", "green", "blue"], Role::Color),
            1 if self.role(name) != Role::Other && self.row.is_second(k) => vec![(field.name.to_owned(), Role::Other)],
            1 => vec![(field.name.to_owned(), self.role(name))],
            count => (0..count).map(|part| (component(field.name, part), Role::Other)).collect(),
        }
    }

    /// The type of the colours' numbers; `None` without colours.
    fn color_type(&self) -> Option<ColorType> {
        let type_of = |k: usize| match self.row.fields[k].kind {
            FieldKind::Binary(_) if self.packed == Some(k) => ColorType::Byte,
            FieldKind::Binary(scalar) => ColorType::of(scalar),
            _ => ColorType::Real,
        };
        let set = self.set.into_iter().flatten().filter_map(|name| self.row.single(&[name]));
        set.chain(self.vector).chain(self.packed).map(type_of).max()
    }

    /// Warnings about fields that are called like colours or radii and are not taken.
    fn warnings(&self, has_colors: bool) -> Vec<String> {
        // An `r` alone is any number.
        let is_color = |name: &str| COLORS.contains(&name) || [0, 2].iter().any(|set| COLOR_SETS[*set].contains(&name));
        let is_length = |name: &str| RADII.contains(&name) || DIAMETERS.contains(&name);
        let mend = "they are three numbers red, green and blue, a field rgb of three, or one of 4 bytes";
        let colors = || self.row.unread(is_color, "colours", mend);
        let radii = || self.row.unread(is_length, "radii", "a radius or a diameter is one number");
        let colors = (!has_colors).then(colors).flatten().into_iter();
        colors.chain(self.length.is_none().then(radii).flatten()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_called_like_a_colour_or_a_radius_is_taken_or_reported() {
        let number = |name: &str| Scalar::of_numpy(name).expect("a type");
        let (byte, short, real, long) = (number("|u1"), number("<u2"), number("<f4"), number("<f8"));
        let binary = |name, count, scalar| NamedField { name, count, kind: FieldKind::Binary(scalar) };
        let other = |name| NamedField { name, count: 1, kind: FieldKind::Other("<U3".into()) };
        let roles = |fields: &[NamedField<'_>]| -> Vec<Role> {
            meanings(fields).fields.concat().into_iter().map(|(_, role)| role).collect()
        };
        let color = [0, 1, 2].map(Role::Color);
        for names in [["red", "green", "blue"], ["R", "G", "B"], ["Diffuse_Red", "diffuse_green", "DIFFUSE_BLUE"]] {
            for (scalar, kind) in [(byte, ColorType::Byte), (short, ColorType::Whole), (long, ColorType::Real)] {
                let fields = names.map(|name| binary(name, 1, scalar));
                let found = meanings(&fields);
                assert_eq!(
                    (roles(&fields), found.color_type, found.warnings.len()),
                    (color.to_vec(), kind, 0),
                    "{names:?}"
                );
            }
        }
        for name in COLORS {
            assert_eq!(roles(&[binary(name, 3, short)]), color, "{name}");
            assert_eq!(roles(&[binary(name, 4, byte)]), [&color[..], &[Role::Other]].concat(), "{name}");
            let found = meanings(&[binary(name, 1, long)]);
            assert!(found.warnings.len() == 1 && found.warnings[0].contains(name), "{name}: {:?}", found.warnings);
        }
        for scalar in [real, number("<u4"), number("<i4")] {
            assert_eq!(meanings(&[binary("rgb", 1, scalar)]).packed, Some(0));
        }
        for (name, role) in [("radius", Role::Radius), ("Radii", Role::Radius), ("diameter", Role::Diameter)] {
            assert_eq!(roles(&[binary(name, 1, short)]), [role]);
            for field in [binary(name, 3, real), other(name)] {
                let found = meanings(&[field]);
                assert!(found.warnings.len() == 1 && found.warnings[0].contains(name), "{name}: {:?}", found.warnings);
            }
        }
        for fields in
            [vec![binary("red", 1, byte), binary("green", 1, byte)], vec![other("red"), other("green"), other("blue")]]
        {
            let found = meanings(&fields);
            assert!(found.warnings[0].contains("red") && !roles(&fields).contains(&color[0]), "{:?}", found.warnings);
        }
        let whole =
            [binary("rgb", 3, byte), binary("red", 1, real), binary("radius", 1, real), binary("diameter", 1, real)];
        let found = [&color[..], &[Role::Other, Role::Radius, Role::Other]].concat();
        assert_eq!((roles(&whole), meanings(&whole).warnings), (found, Vec::new()), "the first of several");
        assert_eq!(roles(&[binary("r", 1, real)]), [Role::Other]);
        assert_eq!(roles(&[binary("pos", 3, real)]), [0, 1, 2].map(Role::Position));
        let axis = [0, 1, 2].map(Role::Position);
        assert_eq!(roles(&["X", "Y", "Z"].map(|name| binary(name, 1, real))), axis);
        let names = ["X", "x", "Radius", "y", "radius", "z", "rgb", "RGB"];
        let [x, y, z] = axis;
        let found = [&[Role::Other, x, Role::Other, y, Role::Radius, z][..], &color, &[Role::Other]].concat();
        assert_eq!(roles(&names.map(|name| binary(name, 1, real))), found, "lower case comes first");
    }
}

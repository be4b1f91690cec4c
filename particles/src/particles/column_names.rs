//! Which columns of a table have which meaning, where their names do not say it.

use super::role::Role;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::{list, quote};
use std::str::FromStr;

/// Columns of a table by meaning: `x=pos_x,y=pos_y,z=pos_z,radius=r`, or by their number from 1: `x=1,y=2,z=3`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ColumnNames(Vec<(Role, ColumnKey)>);

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
enum ColumnKey {
    Name(String),
    /// From 0.
    Number(usize),
}

/// The meanings.
const MEANINGS: [(&str, Role); 9] = [
    ("x", Role::Position(0)),
    ("y", Role::Position(1)),
    ("z", Role::Position(2)),
    ("radius", Role::Radius),
    ("diameter", Role::Diameter),
    ("r", Role::Color(0)),
    ("g", Role::Color(1)),
    ("b", Role::Color(2)),
    ("element", Role::Symbol),
];

impl ColumnNames {
    /// The columns by meaning, and the names among them that have none: `chain,x=pos_x` gives `chain`.
    ///
    /// # Errors
    /// As [`ColumnNames::from_str`], for meanings.
    pub fn with_others(text: &str) -> Result<(Self, Vec<String>)> {
        let (named, others): (Vec<_>, Vec<_>) = text.split(',').partition(|part| part.contains('='));
        let others = others.into_iter().map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect();
        Ok((if named.is_empty() { Self::default() } else { named.join(",").parse()? }, others))
    }

    /// Whether no column is named.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether all columns are given by their number, so that a table needs no header.
    pub(crate) fn are_numbers(&self) -> bool {
        self.0.iter().all(|(_, key)| matches!(key, ColumnKey::Number(_)))
    }

    /// The given meaning of each column of a table with these names, or what is wrong with the table.
    pub(crate) fn roles(&self, names: &[String]) -> Result<Vec<Option<Role>>, String> {
        let mut roles = vec![None; names.len()];
        for (role, key) in &self.0 {
            let column = match key {
                ColumnKey::Number(n) if *n < names.len() => *n,
                ColumnKey::Number(n) => {
                    return Err(format!("column {} is named, but the table has {}", n + 1, names.len()));
                }
                ColumnKey::Name(name) => {
                    let same = |exact: bool| {
                        let is = move |other: &&String| {
                            if exact { *other == name } else { other.eq_ignore_ascii_case(name) }
                        };
                        (names.iter().position(|other| is(&other)), names.iter().filter(is).count())
                    };
                    match [same(true), same(false)].into_iter().find(|(_, count)| *count > 0) {
                        Some((Some(column), 1)) => column,
                        None => return Err(format!("the table has no column {}", quote(name))),
                        _ => return Err(format!("{} occurs twice", quote(name))),
                    }
                }
            };
            if roles[column].replace(*role).is_some() {
                return Err(format!("{} is given two meanings", quote(&names[column])));
            }
        }
        Ok(roles)
    }

    /// The name of a column without a header.
    pub(crate) fn name_of(role: Option<Role>, number: usize) -> String {
        let known = MEANINGS.iter().find(|(_, meaning)| Some(*meaning) == role);
        known.map_or_else(|| format!("column_{}", number + 1), |(name, _)| (*name).to_owned())
    }
}

impl FromStr for ColumnNames {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let fail = |problem: String| {
            let names = list(MEANINGS.iter().map(|(name, _)| *name));
            let mend = format!(
                "write MEANING=COLUMN with a name or a number from 1, such as x=1,y=2,z=3; the meanings are {names}"
            );
            Error::settings(problem, mend)
        };
        let mut columns: Vec<(Role, ColumnKey)> = Vec::new();
        for part in text.split(',') {
            let (meaning, column) = part.split_once('=').unwrap_or((part, ""));
            let (meaning, column) = (meaning.trim().to_lowercase(), column.trim());
            let Some((_, role)) = MEANINGS.iter().find(|(name, _)| *name == meaning) else {
                return Err(fail(format!("{} is not a meaning of a column", quote(&meaning))));
            };
            if columns.iter().any(|(known, _)| known == role) {
                return Err(fail(format!("{meaning} is given twice")));
            }
            let digits = !column.is_empty() && column.bytes().all(|byte| byte.is_ascii_digit());
            let key = match column.parse::<usize>() {
                Ok(number) if digits && number > 0 => ColumnKey::Number(number - 1),
                _ if digits => return Err(fail(format!("there is no column {column}"))),
                _ if column.is_empty() => return Err(fail(format!("{meaning} has no column"))),
                _ => ColumnKey::Name(column.to_owned()),
            };
            columns.push((*role, key));
        }
        let has = |role: Role| columns.iter().any(|(known, _)| *known == role);
        if has(Role::Radius) && has(Role::Diameter) {
            return Err(fail("radius and diameter exclude each other".into()));
        }
        let colors = (0..3).filter(|k| has(Role::Color(*k))).count();
        if colors % 3 != 0 {
            return Err(fail(format!("{colors} of r, g and b are given")));
        }
        Ok(Self(columns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meanings_have_columns_by_name_or_number() {
        let of = |text: &str, names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            text.parse::<ColumnNames>().expect("columns").roles(&names)
        };
        let [x, y, z] = [0, 1, 2].map(|k| Some(Role::Position(k)));
        assert_eq!(of("x=3,Y=2, z = 1 ", &["a", "b", "c", "d"]), Ok(vec![z, y, x, None]));
        assert_eq!(of("radius=R", &["r", "R"]), Ok(vec![None, Some(Role::Radius)]), "the exact name first");
        assert_eq!(of("x=Pos X,element=kind", &["KIND", "pos x"]), Ok(vec![Some(Role::Symbol), x]));
        assert_eq!(of("diameter=2a", &["1", "2a"]), Ok(vec![None, Some(Role::Diameter)]), "2a is no number");
        for (text, names, message) in [
            ("x=a", &["b"][..], "no column `a`"),
            ("x=2", &["b"], "column 2 is named, but the table has 1"),
            ("x=a", &["a", "a"], "`a` occurs twice"),
            ("x=a,y=1", &["a"], "`a` is given two meanings"),
        ] {
            let problem = of(text, names).expect_err(text);
            assert!(problem.contains(message), "{problem}");
        }
        for bad in [
            "",
            "x",
            "x=",
            "w=1",
            "x=0",
            "x=1,x=2",
            "x=1,,y=2",
            "r=1,g=2",
            "radius=1,diameter=2",
            "x=99999999999999999999",
        ] {
            assert!(matches!(bad.parse::<ColumnNames>(), Err(Error::Settings { .. })), "{bad}");
        }
    }
}

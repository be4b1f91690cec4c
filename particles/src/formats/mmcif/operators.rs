//! Data of an mmCIF file besides its atoms: the cell, the operators, and the assemblies made with them
//! (mmcif.wwpdb.org/dictionaries/mmcif_pdbx_v50.dic: `_cell`, `_pdbx_struct_oper_list`, `_pdbx_struct_assembly_gen`).

use super::symmetry::{self, Symmetry};
use super::token::number;
use super::tokens::Tokens;
use crate::lines::Spot;
use crate::particles::assembly::{Assembly, AssemblyPart, MOST_OPERATORS, unknown};
use crate::particles::molecule::cell;
use halfline_ground::Cell;
use halfline_ground::Operator;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::Ledger;
use halfline_ground::quote::{list, quote};
use std::collections::HashMap;

/// A value that is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OperatorItem {
    /// In [`Generator`]: the assembly, the operators, the chains.
    Assembly,
    Expression,
    Chains,
    /// In an operator: its name, and its numbers row by row.
    Operator,
    Number(usize),
    /// In the cell: edges, then angles.
    Cell(usize),
    /// In a small molecule.
    Symmetry(symmetry::SymmetryItem),
}

impl OperatorItem {
    /// The item of a tag in lower case.
    pub(super) fn of(tag: &str) -> Option<Self> {
        // Small-molecule files write `_cell_length_a`.
        if let Some(name) = tag.strip_prefix("_cell").and_then(|rest| rest.strip_prefix(['.', '_'])) {
            let names = ["length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma"];
            return names.iter().position(|known| *known == name).map(Self::Cell);
        }
        if let Some(name) = tag.strip_prefix("_pdbx_struct_assembly_gen.") {
            return match name {
                "assembly_id" => Some(Self::Assembly),
                "oper_expression" => Some(Self::Expression),
                "asym_id_list" => Some(Self::Chains),
                _ => None,
            };
        }
        let Some(name) = tag.strip_prefix("_pdbx_struct_oper_list.") else {
            return symmetry::SymmetryItem::of(tag).map(Self::Symmetry);
        };
        let digit = |byte: u8| (b'1'..=b'3').contains(&byte).then(|| usize::from(byte - b'1'));
        match name.as_bytes() {
            b"id" => Some(Self::Operator),
            [b'm', b'a', b't', b'r', b'i', b'x', b'[', row, b']', b'[', column, b']'] => {
                Some(Self::Number(4 * digit(*row)? + digit(*column)?))
            }
            [b'v', b'e', b'c', b't', b'o', b'r', b'[', row, b']'] => Some(Self::Number(4 * digit(*row)? + 3)),
            _ => None,
        }
    }
}

/// Chains of an assembly and the operators that apply to them, as written in the file.
#[derive(Debug, Clone, Default)]
struct Generator {
    assembly: String,
    expression: String,
    chains: String,
    at: Spot,
}

/// An operator as written in the file; NaN for missing or invalid numbers.
#[derive(Debug, Clone)]
struct ListedOperator {
    name: String,
    numbers: [f64; 12],
    at: Spot,
}

/// The data read so far.
#[derive(Debug)]
pub(super) struct Operators {
    generators: Vec<Generator>,
    list: Vec<ListedOperator>,
    cell: [f64; 6],
    /// Whether each angle is given.
    angles: [bool; 3],
    pub(super) symmetry: Symmetry,
    /// Bytes of both lists.
    ledger: Ledger,
}

impl Default for Operators {
    fn default() -> Self {
        Self {
            generators: Vec::new(),
            list: Vec::new(),
            // The dictionaries give the angles this default.
            cell: [f64::NAN, f64::NAN, f64::NAN, 90.0, 90.0, 90.0],
            angles: [false; 3],
            symmetry: Symmetry::default(),
            ledger: Ledger::default(),
        }
    }
}

impl Operators {
    /// Begins a row of a loop, or a single value, with this item.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub(super) fn begin(&mut self, item: OperatorItem, alone: bool, at: Spot) -> Result<()> {
        match item {
            OperatorItem::Assembly | OperatorItem::Expression | OperatorItem::Chains
                if !alone || self.generators.is_empty() =>
            {
                self.ledger.add(2 * size_of::<Generator>())?;
                self.generators.push(Generator { at, ..Generator::default() });
            }
            OperatorItem::Operator | OperatorItem::Number(_) if !alone || self.list.is_empty() => {
                self.ledger.add(2 * size_of::<ListedOperator>())?;
                self.list.push(ListedOperator { name: String::new(), numbers: [f64::NAN; 12], at });
            }
            _ => {}
        }
        Ok(())
    }

    /// Stores the current value.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short, and errors of [`Tokens::string`].
    pub(super) fn take(&mut self, item: OperatorItem, tokens: &Tokens) -> Result<()> {
        if matches!(
            item,
            OperatorItem::Assembly | OperatorItem::Expression | OperatorItem::Chains | OperatorItem::Operator
        ) {
            self.ledger.add(tokens.value().len())?;
        }
        match (item, self.generators.last_mut(), self.list.last_mut()) {
            (OperatorItem::Symmetry(item), ..) => self.symmetry.take(item, tokens)?,
            (OperatorItem::Cell(3..), ..) if tokens.value().is_empty() => {}
            (OperatorItem::Cell(k), ..) => {
                self.cell[k] = number(tokens.value()).unwrap_or(f64::NAN);
                if let Some(angle) = k.checked_sub(3) {
                    self.angles[angle] = true;
                }
            }
            (OperatorItem::Assembly, Some(generator), _) => generator.assembly = tokens.string()?,
            (OperatorItem::Chains, Some(generator), _) => generator.chains = tokens.string()?,
            (OperatorItem::Expression, Some(generator), _) => {
                (generator.expression, generator.at) = (tokens.string()?, tokens.spot());
            }
            (OperatorItem::Operator, _, Some(listed)) => listed.name = tokens.string()?,
            (OperatorItem::Number(k), _, Some(listed)) => {
                listed.numbers[k] = number(tokens.value()).unwrap_or(f64::NAN)
            }
            _ => {}
        }
        Ok(())
    }

    /// The cell, if it was given and has a volume.
    pub(super) fn cell(&self) -> Option<Cell> {
        let [a, b, c, alpha, beta, gamma] = self.cell;
        cell([a, b, c], [alpha, beta, gamma])
    }

    /// The message about a cell without some of its angles.
    pub(super) fn assumed_angles(&self) -> Option<String> {
        let names =
            ["alpha", "beta", "gamma"].iter().zip(self.angles).filter(|(_, given)| !given).map(|(name, _)| name);
        let names = list(names);
        let warning =
            format!("the file does not give {names} of the cell, so 90 degrees are taken, as the dictionary says");
        (self.angles != [true; 3] && self.cell().is_some()).then_some(warning)
    }

    /// The names of the assemblies, and the operators that the expression of each has, which are not looked up.
    pub(super) fn counts(&self) -> impl Iterator<Item = (String, u64)> {
        let places = self.places();
        let item = move |item: &str| ends(item, &places).map_or(1, |(a, b)| b.saturating_sub(a).saturating_add(1));
        let group = move |list: &str| list.split(',').map(&item).fold(0, u64::saturating_add);
        let count = move |expression: &str| {
            let bare: String = expression.split_whitespace().collect();
            bare.trim_matches(['(', ')']).split(")(").map(&group).fold(1, u64::saturating_mul)
        };
        self.generators.iter().map(move |generator| (generator.assembly.clone(), count(&generator.expression)))
    }

    /// The assembly with this name.
    ///
    /// # Errors
    /// [`Error::Settings`] with the names of the file, [`Error::Scene`] for invalid operators.
    pub(super) fn assembly(&self, id: &str, file: &Place) -> Result<Assembly> {
        let generators: Vec<&Generator> = self.generators.iter().filter(|generator| generator.assembly == id).collect();
        if generators.is_empty() {
            let mut ids: Vec<&String> = self.generators.iter().map(|generator| &generator.assembly).collect();
            ids.dedup();
            return Err(unknown(id, ids.into_iter(), file));
        }
        let (mut parts, places) = (Vec::new(), self.places());
        let mut total = 0;
        for generator in generators {
            let fail = |(problem, mend): (String, &str)| {
                Error::scene(generator.at.of(file.clone()).named("oper_expression"), problem, mend)
            };
            let groups = self.groups(&generator.expression, &places).map_err(fail)?;
            let product = groups.iter().try_fold(1_usize, |product, group| product.checked_mul(group.len()));
            total = product.and_then(|product| product.checked_add(total)).unwrap_or(usize::MAX);
            if total > MOST_OPERATORS {
                return Err(fail(too_many(&generator.expression)));
            }
            let chains = generator.chains.split(',').map(|name| name.trim().as_bytes().to_vec()).collect();
            parts.push(AssemblyPart { chains, operators: self.products(&groups, file)? });
        }
        Ok(Assembly { id: id.to_owned(), parts })
    }

    /// The products of one operator of each group, the first group changing last; the rightmost operator acts first. Their names are of the
    /// operators' places, since names of the file may be of any length.
    fn products(&self, groups: &[Vec<usize>], file: &Place) -> Result<Vec<(String, Operator)>> {
        let mut products: Vec<(String, Option<Operator>)> = vec![(String::new(), None)];
        for group in groups {
            let mut longer = Vec::with_capacity(products.len() * group.len());
            for (name, left) in &products {
                for n in group {
                    let right = self.operator(*n, file)?;
                    let operator = left.map_or(right, |left: Operator| left.after(&right));
                    longer.push((format!("{name}({n})"), Some(operator)));
                }
            }
            products = longer;
        }
        Ok(products.into_iter().filter_map(|(name, operator)| Some((name, operator?))).collect())
    }

    fn operator(&self, n: usize, file: &Place) -> Result<Operator> {
        let listed = &self.list[n];
        if listed.numbers.iter().any(|number| number.is_nan()) {
            let place = listed.at.of(file.clone()).named("_pdbx_struct_oper_list");
            let problem = format!("operator {} does not have 12 finite numbers", quote(&listed.name));
            return Err(Error::scene(place, problem, "give matrix[1][1] to matrix[3][3] and vector[1] to vector[3]"));
        }
        let [a, b, c, d, e, f, g, h, i, j, k, l] = listed.numbers;
        Ok(Operator([[a, b, c, d], [e, f, g, h], [i, j, k, l]]))
    }

    /// The indices of the operators by their names; of equal names the last.
    fn places(&self) -> HashMap<&str, usize> {
        self.list.iter().enumerate().map(|(n, listed)| (&listed.name[..], n)).collect()
    }

    /// The operators of an expression, as indices of the list: one group for `1,2` or `(1-60)`, two for
    /// `(1-60)(61-88)`. Or the problem and its remedy.
    fn groups(
        &self,
        expression: &str,
        places: &HashMap<&str, usize>,
    ) -> Result<Vec<Vec<usize>>, (String, &'static str)> {
        const MEND: &str = "use 1, (1-60) or (1-60)(61-88), with ids of _pdbx_struct_oper_list";
        let wrong = || (format!("{} is not an expression of operators", quote(expression)), MEND);
        let place = |name: &str| {
            let missing = || (format!("there is no operator {}", quote(name)), MEND);
            places.get(name).copied().ok_or_else(missing)
        };
        let group = |list: &str| {
            let mut group = Vec::new();
            for item in list.split(',').map(str::trim) {
                match ends(item, places) {
                    None => group.push(place(item)?),
                    Some((first, last)) if first <= last => {
                        // Their number is checked before they are looked up.
                        if last - first >= self.list.len() as u64 {
                            let problem =
                                format!("{} has more operators than the {} of the file", quote(item), self.list.len());
                            return Err((problem, MEND));
                        }
                        for name in first..=last {
                            group.push(place(&name.to_string())?);
                        }
                    }
                    Some(_) => return Err(wrong()),
                }
                if group.len() > MOST_OPERATORS {
                    return Err(too_many(expression));
                }
            }
            Ok(group)
        };
        let bare: String = expression.split_whitespace().collect();
        if !bare.contains(['(', ')']) {
            return Ok(vec![group(&bare)?]);
        }
        let inner = bare.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).ok_or_else(wrong)?;
        if inner.matches(")(").count() >= MOST_FACTORS {
            return Err(wrong());
        }
        inner.split(")(").map(group).collect()
    }
}

/// The numbers that an item such as `1-60` goes from and to; `None` for one operator.
fn ends(item: &str, places: &HashMap<&str, usize>) -> Option<(u64, u64)> {
    let (first, last) = item.split_once('-').filter(|_| !places.contains_key(item))?;
    Some((first.parse().ok()?, last.parse().ok()?))
}

/// The most factors of a product.
const MOST_FACTORS: usize = 64;

fn too_many(expression: &str) -> (String, &'static str) {
    let problem = format!("{} has more than {MOST_OPERATORS} operators", quote(expression));
    (problem, "use a smaller assembly")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `n` translations along x, the k-th by 2^k, and an operator that doubles.
    fn operators(n: usize) -> Operators {
        let row = |name: String, scale: f64, shift: f64| ListedOperator {
            name,
            numbers: [scale, 0.0, 0.0, shift, 0.0, scale, 0.0, 0.0, 0.0, 0.0, scale, 0.0],
            at: Spot::default(),
        };
        let shifts = (1..=n).map(|k| row(k.to_string(), 1.0, f64::powi(2.0, k as i32)));
        Operators { list: shifts.chain([row("X0".into(), 2.0, 0.0)]).collect(), ..Operators::default() }
    }

    fn moved(operators: &Operators, expression: &str) -> Result<Vec<f64>> {
        let generator = Generator { assembly: "1".into(), expression: expression.into(), ..Generator::default() };
        let operators = Operators { generators: vec![generator], list: operators.list.clone(), ..Operators::default() };
        let assembly = operators.assembly("1", &Place::file("text"))?;
        Ok(assembly.parts[0].operators.iter().map(|(_, operator)| operator.apply([1.0, 0.0, 0.0])[0]).collect())
    }

    #[test]
    fn expressions_are_multiplied_out() {
        let operators = operators(5);
        for (expression, expected) in [
            ("1", &[3.0][..]),
            ("1,3", &[3.0, 9.0]),
            ("(2-4)", &[5.0, 9.0, 17.0]),
            (" ( 1 , 3-4 ) ", &[3.0, 9.0, 17.0]),
            // The doubling acts on the position, and then the translation.
            ("(1,2)(X0)", &[4.0, 6.0]),
            ("(X0)(1-2)", &[6.0, 10.0]),
            ("(1-2)(3-4)", &[11.0, 19.0, 13.0, 21.0]),
            ("(X0)(X0)(1)", &[12.0]),
        ] {
            assert_eq!(moved(&operators, expression).expect(expression), expected, "{expression}");
        }
    }

    #[test]
    fn an_invalid_operator_expression_is_refused() {
        let many = operators(500);
        for (expression, problem) in [
            ("", "there is no operator ``"),
            ("(1", "is not an expression of operators"),
            ("1,(2)", "is not an expression of operators"),
            ("(1)(", "is not an expression of operators"),
            ("((1))", "there is no operator `(1"),
            ("4-2", "is not an expression of operators"),
            ("Y", "there is no operator `Y`"),
            ("1-999999999", "more operators than the 501"),
            ("1-18446744073709551615", "more operators than"),
            ("(1-500)(1-500)", "more than 65536 operators"),
            ("(1-500)(1-500)(1-500)(1-500)(1-500)(1-500)(1-500)(1-500)(1-500)", "more than 65536 operators"),
            ("495-505", "there is no operator `501`"),
        ] {
            let error = moved(&many, expression).expect_err(expression).to_string();
            assert!(error.contains(problem), "{expression}: {error}");
        }
        let error = moved(&many, &vec!["1-500"; 1000].join(",")).expect_err("a long list").to_string();
        assert!(error.contains("65536") && error.len() < 200, "{error}");
        let factors = "(1-500)".repeat(MOST_FACTORS + 1);
        assert!(moved(&many, &factors).expect_err("factors").to_string().contains("is not an expression of operators"));
        let mut broken = operators(2);
        broken.list[1].numbers[7] = f64::NAN;
        assert!(moved(&broken, "2").expect_err("not 12").to_string().contains("operator `2` does not have 12"));
        assert_eq!(moved(&broken, "1").expect("the other is good"), [3.0]);
    }

    /// The operators of a message about assemblies are counted without a look at them; an expression names any number.
    #[test]
    fn expressions_are_counted_without_their_operators() {
        let mut all = operators(20_000);
        let of = |expression: &str| Generator {
            assembly: "1".into(),
            expression: expression.into(),
            ..Generator::default()
        };
        for (expression, count) in
            [("1", 1), ("1,3", 2), ("(1-60)(61-88)", 60 * 28), ("(X0)(1-2,7)", 3), ("1-18446744073709551615", u64::MAX)]
        {
            all.generators = vec![of(expression)];
            assert_eq!(all.counts().next(), Some(("1".to_owned(), count)), "{expression}");
        }
        // A name of the file is one operator, also where it looks like a range.
        all.list[0].name = "1-60".into();
        all.generators = vec![of("1-60")];
        assert_eq!(all.counts().next(), Some(("1".to_owned(), 1)));
        all.generators = vec![of("(1-20000)(Q)"); 100_000];
        assert_eq!(all.counts().filter(|(_, count)| *count == 20_000).count(), 100_000);
    }

    #[test]
    fn the_name_of_an_operator_is_not_written_for_each_product() {
        let mut many = operators(20_000);
        many.list[20_000].name = "Q".repeat(1 << 20);
        let expression = format!("({})(1-20000)", "Q".repeat(1 << 20));
        assert_eq!(moved(&many, &expression).expect("operators").len(), 20_000);
    }
}

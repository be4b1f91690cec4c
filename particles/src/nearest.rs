//! The name that somebody meant.

use halfline_ground::quote::quote;
use strsim::damerau_levenshtein;

/// The name that differs from `text` in the fewest letters, if these are at most two and less than half.
pub(super) fn nearest<T: AsRef<str>>(text: &str, names: impl IntoIterator<Item = T>) -> Option<T> {
    // The longest name of a colour is `lightgoldenrodyellow`; the comparison takes time that grows with the product of the lengths.
    let text = Some(text.trim().to_ascii_lowercase()).filter(|text| text.len() <= 24)?;
    let distance = |name: &str| damerau_levenshtein(name, &text);
    let name = names.into_iter().min_by_key(|name| distance(name.as_ref()))?;
    (distance(name.as_ref()) <= 2.min(name.as_ref().len() / 2)).then_some(name)
}

/// A mend that begins with the nearest of the names, if there is one.
pub fn did_you_mean<'a>(text: &str, names: impl IntoIterator<Item = &'a str>, mend: String) -> String {
    match nearest(text, names) {
        Some(name) => format!("did you mean {}? {mend}", quote(name)),
        None => mend,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_letters_may_differ_and_less_than_half() {
        let of = |text: &str| nearest(text, ["chain", "vfov", "x", "up"]);
        assert_eq!(
            [of("chian"), of("Chains"), of("fov"), of("cha")],
            [Some("chain"), Some("chain"), Some("vfov"), Some("chain")]
        );
        assert_eq!([of("q"), of("ch"), of("residue"), of("")], [None, None, None, None]);
        assert_eq!(did_you_mean("chian", ["chain"], "use it".into()), "did you mean `chain`? use it");
    }
}

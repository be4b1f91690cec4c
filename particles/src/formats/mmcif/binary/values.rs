//! Values of MessagePack: the fields of maps.

use rmpv::Value;

/// Takes the value of a key out of a map; `None` where there is none.
pub(super) fn field(map: &mut Value, key: &str) -> Option<Value> {
    let Value::Map(entries) = map else { return None };
    let at = entries.iter().position(|(known, _)| known.as_str() == Some(key))?;
    Some(entries.swap_remove(at).1)
}

/// The array with this key, or the problem that there is none.
pub(super) fn array(mut map: Value, key: &str) -> Result<Vec<Value>, String> {
    match field(&mut map, key) {
        Some(Value::Array(found)) => Ok(found),
        _ => Err(format!("there is no array {key}")),
    }
}

/// A text.
pub(super) fn text(value: Option<Value>) -> Option<String> {
    if let Some(Value::String(text)) = value { text.into_str() } else { None }
}

/// A number.
pub(super) fn real(map: &mut Value, key: &str) -> Result<f64, String> {
    let number = field(map, key).and_then(|value| value.as_f64());
    number.filter(|x| x.is_finite()).ok_or_else(|| format!("{key} is not a finite number"))
}

/// A whole number.
pub(super) fn whole(map: &mut Value, key: &str) -> Result<i64, String> {
    field(map, key).and_then(|value| value.as_i64()).ok_or_else(|| format!("{key} is not a whole number"))
}

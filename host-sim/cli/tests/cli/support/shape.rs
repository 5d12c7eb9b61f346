//! The shape of a JSON document, for snapshots: its keys and the types of their values.

use serde_json::{Map, Value};

/// Returns the document with every value replaced by its type.
///
/// All elements of an array share one shape. A value of several types has the shape `{"any of": […]}`, with
/// `absent` for an object's optional key.
#[must_use]
pub(crate) fn shape(document: &Value) -> Value {
    match document {
        Value::Null => "null".into(),
        Value::Bool(_) => "boolean".into(),
        Value::Number(_) => "number".into(),
        Value::String(_) => "string".into(),
        Value::Array(elements) => elements
            .iter()
            .map(shape)
            .reduce(merge)
            .into_iter()
            .collect(),
        Value::Object(fields) => fields
            .iter()
            .map(|(key, value)| (key.clone(), shape(value)))
            .collect(),
    }
}

const ANY_OF: &str = "any of";

/// The shape of a value that has one shape or the other.
fn merge(a: Value, b: Value) -> Value {
    let mut shapes: Vec<Value> = Vec::new();
    for shape in [alternatives(a), alternatives(b)].concat() {
        let same_kind = |known: &&mut Value| match &shape {
            Value::Object(_) => known.is_object(),
            Value::Array(_) => known.is_array(),
            scalar => **known == *scalar,
        };
        match shapes.iter_mut().find(same_kind) {
            Some(known) => *known = merge_alike(known.take(), shape),
            None => shapes.push(shape),
        }
    }
    shapes.sort_by_key(ToString::to_string);
    match shapes.as_slice() {
        [one] => one.clone(),
        _ => Map::from_iter([(ANY_OF.to_owned(), Value::from(shapes))]).into(),
    }
}

fn alternatives(shape: Value) -> Vec<Value> {
    match shape.get(ANY_OF) {
        Some(Value::Array(shapes)) => shapes.clone(),
        _ => vec![shape],
    }
}

/// Merges two objects, two arrays or two equal scalars.
fn merge_alike(a: Value, b: Value) -> Value {
    match (a, b) {
        (Value::Object(mut a), Value::Object(mut b)) => {
            let keys: Vec<String> = a.keys().chain(b.keys()).cloned().collect();
            let absent = || Value::from("absent");
            let fields = keys.into_iter().filter_map(|key| {
                let (a, b) = (a.remove(&key), b.remove(&key));
                let merged = match (a, b) {
                    (None, None) => return None, // the key is in both, and was merged before
                    (a, b) => merge(a.unwrap_or_else(absent), b.unwrap_or_else(absent)),
                };
                Some((key, merged))
            });
            fields.collect()
        }
        (Value::Array(a), Value::Array(b)) => {
            a.into_iter().chain(b).reduce(merge).into_iter().collect()
        }
        (a, _) => a,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn elements_share_a_shape() {
        let document = json!({"list": [{"a": 1, "b": null}, {"a": 2, "b": [true]}, {"a": 3}]});
        let b = json!({"any of": ["absent", "null", ["boolean"]]});
        let expected = json!({"list": [{"a": "number", "b": b}]});
        assert_eq!(shape(&document), expected);
        assert_eq!(shape(&json!([])), json!([]));
    }
}

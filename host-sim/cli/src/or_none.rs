//! What may be given several times, or not at all in the word `none`.

use super::Failure;
use core::convert::Infallible;
use core::str::FromStr;

/// One of them, or the word that there is none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum OrNone<T> {
    None,
    Some(T),
}

impl<T: FromStr> FromStr for OrNone<T> {
    type Err = T::Err;

    fn from_str(text: &str) -> Result<Self, T::Err> {
        match text {
            "none" => Ok(Self::None),
            some => some.parse().map(Self::Some),
        }
    }
}

/// A name that is looked up later.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Name(pub String);

impl FromStr for Name {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.to_owned()))
    }
}

/// What was given at `option`; refused where that says both that there is none and that there is one.
pub(super) fn given<T: Clone>(option: &str, all: &[OrNone<T>]) -> Result<Vec<T>, Failure> {
    let some: Vec<T> = all
        .iter()
        .filter_map(|one| match one {
            OrNone::None => None,
            OrNone::Some(one) => Some(one.clone()),
        })
        .collect();
    if !some.is_empty() && some.len() < all.len() {
        let line = format!("{option}: none and another at once; leave out one of them");
        return Err(Failure::Input(line));
    }
    Ok(some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn none_and_one_contradict_each_other() {
        let given = |texts: &[&str]| {
            let all: Vec<OrNone<u8>> = texts.iter().map(|text| text.parse().unwrap()).collect();
            given("--option", &all)
        };
        assert_eq!(given(&[]).unwrap(), [0_u8; 0]);
        assert_eq!(given(&["none", "none"]).unwrap(), [0_u8; 0]);
        assert_eq!(given(&["3", "4"]).unwrap(), [3, 4]);
        assert!(given(&["3", "none"]).is_err() && given(&["none", "3"]).is_err());
        assert!("nones".parse::<OrNone<u8>>().is_err());
    }
}

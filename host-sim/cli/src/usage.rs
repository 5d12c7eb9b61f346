//! Usage errors and help, as clap reports them.

use crate::failure::Failure;
use crate::output;
use clap::Command;
use clap::error::ErrorKind;
use core::error::Error;
use core::num::{IntErrorKind, ParseIntError};
use std::ffi::OsString;

/// Handles an error of clap: prints help and version on stdout, and returns a usage error as one line that
/// names the subcommand's help.
pub(super) fn usage(
    error: &clap::Error,
    command: &Command,
    arguments: &[OsString],
) -> Result<(), Failure> {
    let text = error.render().to_string();
    if let ErrorKind::DisplayHelp | ErrorKind::DisplayVersion = error.kind() {
        return output::print(&text);
    }
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let what = text.split("\n\nUsage:").next().unwrap_or(text);
    let what = what.split("\n\nFor more information").next();
    let what = what.unwrap_or(text).trim_end();
    let what = match error.kind() {
        ErrorKind::InvalidUtf8 => not_text(arguments),
        _ => with_expected(what, error),
    };
    let first = arguments.first().and_then(|first| first.to_str());
    let subcommand = first.and_then(|name| command.find_subcommand(name));
    let of = subcommand.map_or_else(String::new, |named| format!("{} ", named.get_name()));
    Err(Failure::Input(format!("{what}; see certainty {of}--help")))
}

/// Returns `what` with the expected number in place of the parser's error about one.
fn with_expected(what: &str, error: &clap::Error) -> String {
    let source = error.source();
    let Some(number) = source.and_then(|source| source.downcast_ref::<ParseIntError>()) else {
        return what.to_owned();
    };
    let expected = match number.kind() {
        IntErrorKind::Zero => "expected a whole number of at least 1",
        IntErrorKind::PosOverflow => "too large, expected a smaller whole number",
        _ => "expected a whole number in digits alone, such as 7",
    };
    let what = what.strip_suffix(&number.to_string()).unwrap_or(what);
    format!("{what}{expected}")
}

/// Returns the error of arguments that are not UTF-8, with their options.
fn not_text(arguments: &[OsString]) -> String {
    let mut places: Vec<String> = Vec::new();
    let mut before: Option<&str> = None;
    for argument in arguments {
        let lossy = argument.to_string_lossy();
        if argument.to_str().is_none() {
            let option = match (lossy.strip_prefix("--"), before) {
                (Some(_), _) => lossy.split('=').next().unwrap_or(&lossy).to_owned(),
                (None, Some(option)) => option.to_owned(),
                (None, None) => format!("'{lossy}'"),
            };
            places.push(option);
        }
        before = argument.to_str().filter(|text| text.starts_with("--"));
    }
    let places = places.join(" or ");
    format!("{places}: the value is not UTF-8: expected text in UTF-8")
}

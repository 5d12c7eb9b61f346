//! Foreign text in messages of one line.

use std::path::Path;

/// `path` as text of one line: what would break the line or the terminal is escaped.
#[must_use]
pub fn shown(path: &Path) -> String {
    one_line(path.display().to_string())
}

/// `text` as one line: if it has control characters, it is escaped.
pub(super) fn one_line(text: String) -> String {
    if text.contains(char::is_control) {
        text.escape_debug().to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_a_line_break_stays_on_one_line() {
        assert_eq!(shown(Path::new("a\nb\u{1b}[1m")), "a\\nb\\u{1b}[1m");
        assert_eq!(shown(Path::new("logs/früh.csv")), "logs/früh.csv");
    }
}

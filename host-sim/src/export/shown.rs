//! Paths in messages.

use std::path::Path;

/// `path` as text of one line: what would break the line or the terminal is escaped.
pub(crate) fn shown(path: &Path) -> String {
    let text = path.display().to_string();
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

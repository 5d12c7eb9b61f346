//! Every path, command and test in `docs/paper-map.md` exists, and so do the files and links that it, the other
//! pages and every `README.md` name.

use certainty_tests::workspace;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The packages by which paths on the page begin, and their folders.
const PACKAGES: [(&str, &str); 6] = [
    ("core", "core/src"),
    ("control", "core/control/src"),
    ("ring", "core/ring/src"),
    ("firmware", "firmware/src"),
    ("sim", "host-sim/src"),
    ("repro", "host-sim/repro/src"),
];

/// Folders whose files may hold a test.
const TESTED: [&str; 4] = ["core", "firmware", "host-sim", "tests"];

/// Folders by which a path on the other pages begins.
const TOP: [&str; 6] = [
    "core/",
    "firmware/",
    "host-sim/",
    "tests/",
    "docs/",
    "fuzz/",
];

/// Keywords before the name of an item.
const ITEMS: [&str; 9] = [
    "fn", "struct", "enum", "trait", "type", "const", "static", "mod", "union",
];

/// Every file below a folder, without what Cargo builds.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if !path.is_dir() {
                found.push(path);
            } else if !path.ends_with("target") {
                open.push(path);
            }
        }
    }
    found
}

/// Every Rust file below a folder, with its text.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut files = files(folder);
    files.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    let with_text = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap();
        (path, text)
    };
    files.into_iter().map(with_text).collect()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.filter(|word| !word.is_empty())
}

/// The text without its comments, as far as they begin a line.
fn code(text: &str) -> String {
    let lines = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The names of a package: those of items, and all.
struct Names {
    items: BTreeSet<String>,
    all: BTreeSet<String>,
}

impl Names {
    fn of(folder: &Path) -> Self {
        let (mut items, mut all) = (BTreeSet::new(), BTreeSet::new());
        for (path, text) in sources(folder) {
            let text = code(&text);
            let mut before = "";
            for word in words(&text) {
                all.insert(word.to_owned());
                if ITEMS.contains(&before) {
                    items.insert(word.to_owned());
                }
                before = word;
            }
            // A module in a folder of its own.
            if path.ends_with("mod.rs") {
                let folder = path.parent().and_then(Path::file_name);
                items.extend(folder.map(|name| name.to_string_lossy().into_owned()));
            }
        }
        Self { items, all }
    }

    /// The first part of a path that is no item of the package, if any.
    ///
    /// The last part may be a variant, if a type precedes it.
    fn missing<'a>(&self, path: &[&'a str]) -> Option<&'a str> {
        let is_type = |name: &&str| name.starts_with(char::is_uppercase);
        let absent = |&number: &usize| {
            let variant = number > 0
                && number + 1 == path.len()
                && is_type(&path[number])
                && is_type(&path[number - 1]);
            let name = path[number];
            !(self.items.contains(name) || variant && self.all.contains(name))
        };
        (0..path.len()).find(absent).map(|number| path[number])
    }
}

/// The names of all test functions.
fn tests() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let folders = TESTED.map(|folder| workspace().join(folder));
    for (_, text) in folders.iter().flat_map(|folder| sources(folder)) {
        let mut attributed = false;
        for line in text.lines().map(str::trim) {
            if line == "#[test]" {
                attributed = true;
            } else if attributed && !line.starts_with("#[") {
                let name = line.strip_prefix("fn ").and_then(|rest| words(rest).next());
                found.extend(name.map(str::to_owned));
                attributed = false;
            }
        }
    }
    found
}

/// The names of the program's commands, which are variants of one enum.
fn commands() -> BTreeSet<String> {
    let main = fs::read_to_string(workspace().join("host-sim/cli/src/main.rs")).unwrap();
    let (_, variants) = main.split_once("enum Command {").unwrap();
    let (variants, _) = variants.split_once("\n}").unwrap();
    let names = variants
        .lines()
        .filter_map(|line| line.trim().split_once('('));
    names.map(|(name, _)| name.to_lowercase()).collect()
}

/// What a line has in backticks.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// The targets of a line's links.
fn links(line: &str) -> impl Iterator<Item = &str> {
    let after = line.split("](").skip(1);
    after.filter_map(|rest| rest.split(')').next())
}

/// The anchors that a Markdown file has: its headings in lower case, with hyphens.
fn anchors(file: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(file).unwrap();
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn everything_on_the_paper_map_exists() {
    let docs = workspace().join("docs");
    let page = fs::read_to_string(docs.join("paper-map.md")).unwrap();
    let packages: BTreeMap<_, _> = PACKAGES
        .map(|(name, folder)| (name, Names::of(&workspace().join(folder))))
        .into();
    let (tests, commands) = (tests(), commands());
    let mut wrong = Vec::new();
    let mut checked = 0;
    for (number, line) in (1..).zip(page.lines()) {
        let in_table = line.starts_with('|');
        let mut complain = |what: String| wrong.push(format!("{number}: {what}"));
        for name in quoted(line) {
            checked += 1;
            if let Some(command) = name.strip_prefix("certainty ") {
                let known = command == "…" || commands.contains(command);
                if !known {
                    complain(format!("no command '{command}'"));
                }
            } else if name.contains('/') {
                if !workspace().join(name).exists() {
                    complain(format!("no file {name}"));
                }
            } else if let Some((package, path)) = name.split_once("::") {
                let path: Vec<&str> = path.split("::").filter(|part| !part.is_empty()).collect();
                match packages.get(package) {
                    Some(names) => {
                        if let Some(missing) = names.missing(&path) {
                            complain(format!("no {missing} of {name} in certainty-{package}"));
                        }
                    }
                    None if in_table => complain(format!("{name} begins with no package")),
                    None => checked -= 1,
                }
            } else if in_table && !tests.contains(name) {
                complain(format!("no test {name}"));
            }
        }
    }
    assert!(wrong.is_empty(), "docs/paper-map.md\n{}", wrong.join("\n"));
    assert!(checked > 150, "only {checked} names were found to check");
}

/// The pages whose files and links are checked.
fn pages() -> Vec<PathBuf> {
    let docs = workspace().join("docs");
    let adr = fs::read_dir(docs.join("adr")).unwrap();
    let mut pages: Vec<_> = adr.map(|entry| entry.unwrap().path()).collect();
    pages.extend(
        [
            "ARCHITECTURE.md",
            "hardware.md",
            "paper-map.md",
            "reproduction.md",
        ]
        .map(|page| docs.join(page)),
    );
    pages.extend(["CONTRIBUTING.md", "README.md"].map(|page| workspace().join(page)));
    let below = TOP
        .iter()
        .flat_map(|folder| files(&workspace().join(folder)));
    pages.extend(below.filter(|path| path.ends_with("README.md")));
    pages
}

#[test]
fn files_and_links_of_the_pages_exist() {
    let mut wrong = Vec::new();
    let (mut readmes, mut checked) = (0, 0);
    for page in pages() {
        readmes += u32::from(page.ends_with("README.md"));
        let text = fs::read_to_string(&page).unwrap();
        let mut fenced = false;
        for (number, line) in (1..).zip(text.lines()) {
            if line.starts_with("```") {
                fenced = !fenced;
            }
            if fenced || line.starts_with("```") {
                continue;
            }
            let mut complain =
                |what: &str| wrong.push(format!("{}:{number}: no {what}", page.display()));
            let files = quoted(line).filter(|name| TOP.iter().any(|top| name.starts_with(top)));
            for file in files.filter(|file| !file.contains([' ', '*'])) {
                checked += 1;
                if !workspace().join(file).exists() {
                    complain(file);
                }
            }
            // Rustdoc checks the links to items, with `::`, of a README that is a crate's front page.
            for link in links(line).filter(|link| !link.starts_with("http") && !link.contains("::"))
            {
                checked += 1;
                let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
                let file = match file {
                    "" => page.clone(),
                    file => page.parent().unwrap().join(file),
                };
                if !file.exists() || !anchor.is_empty() && !anchors(&file).contains(anchor) {
                    complain(link);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(readmes > 8, "only {readmes} files README.md were found");
    assert!(checked > 80, "only {checked} names were found to check");
}

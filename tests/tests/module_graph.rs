//! The modules of a package form no circle of imports.
//!
//! The arrows are read from the sources: `use` declarations and paths that begin with `crate`, `self`, `super`
//! or a child module. A re-export (`pub use`) is no arrow of its own: an import through it
//! counts as an arrow to the module that has the item. Test modules are left out.

use certainty_tests::workspace;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemUse, UseTree, Visibility};

/// The folders of sources, one a package.
const PACKAGES: [&str; 12] = [
    "core/src",
    "core/control/src",
    "core/ring/src",
    "firmware/src",
    "firmware/bench/src",
    "firmware/boards/stm32f100/src/bin/smart_car",
    "firmware/bench/src/bin/bench",
    "host-sim/src",
    "host-sim/emulator/src",
    "host-sim/repro/src",
    "host-sim/cli/src",
    "tests/support",
];

/// A module by its names below the crate's root; the root itself is empty.
type Module = Vec<String>;

/// One file: its module, and what it imports and re-exports.
#[derive(Debug, Default)]
struct Source {
    file: PathBuf,
    /// Paths that it uses, as they are written.
    used: Vec<Vec<String>>,
    /// Names that it re-exports, with the paths that they stand for.
    reexports: BTreeMap<String, Vec<String>>,
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute
                .parse_args::<syn::Path>()
                .is_ok_and(|path| path.is_ident("test"))
    })
}

/// Every path of a `use` tree, with the name that it gets here; `*` for all names.
fn leaves(tree: &UseTree, before: &[String], found: &mut Vec<(Vec<String>, String)>) {
    let with = |name: &syn::Ident| {
        let mut path = before.to_vec();
        if name != "self" || before.is_empty() {
            path.push(name.to_string());
        }
        path
    };
    match tree {
        UseTree::Path(path) => leaves(&path.tree, &with(&path.ident), found),
        UseTree::Name(name) => {
            let path = with(&name.ident);
            let last = path.last().cloned().unwrap_or_default();
            found.push((path, last));
        }
        UseTree::Rename(rename) => found.push((with(&rename.ident), rename.rename.to_string())),
        UseTree::Glob(_) => found.push((before.to_vec(), "*".into())),
        UseTree::Group(group) => {
            for tree in &group.items {
                leaves(tree, before, found);
            }
        }
    }
}

impl<'ast> Visit<'ast> for Source {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Mod(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let mut found = Vec::new();
        leaves(&item.tree, &[], &mut found);
        for (path, name) in found {
            let private = matches!(item.vis, Visibility::Inherited);
            if private {
                self.used.push(path.clone());
            }
            // A child may import through a private `use` of its parent, too.
            if name != "*" {
                self.reexports.insert(name, path);
            }
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names = path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string());
        let names: Vec<String> = names.collect();
        if names.len() > 1 {
            self.used.push(names);
        }
        visit::visit_path(self, path);
    }
}

/// The modules of one package.
struct Package(BTreeMap<Module, Source>);

impl Package {
    fn read(folder: &Path) -> Self {
        let mut package = Self(BTreeMap::new());
        package.add(folder, &mut Vec::new());
        package
    }

    fn add(&mut self, folder: &Path, module: &mut Module) {
        let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
        for entry in entries {
            let path = entry.unwrap().path();
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                // Images are programs of their own.
                if stem != "bin" {
                    module.push(stem);
                    self.add(&path, module);
                    module.pop();
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let mut module = module.clone();
                if !["lib", "main", "mod"].contains(&stem.as_str()) {
                    module.push(stem);
                }
                let text = fs::read_to_string(&path).unwrap();
                let parsed =
                    syn::parse_file(&text).unwrap_or_else(|error| panic!("{path:?}: {error}"));
                if is_test(&parsed.attrs) {
                    continue;
                }
                let mut source = Source {
                    file: path,
                    ..Source::default()
                };
                source.visit_file(&parsed);
                let before = self.0.insert(module, source);
                assert!(before.is_none(), "two files for one module: {before:?}");
            }
        }
    }

    /// The module that holds what `path`, written in `from`, names; `None` outside the package.
    fn home(&self, from: &Module, path: &[String], depth: usize) -> Option<Module> {
        let mut names = path.iter();
        let first = names.next()?;
        let mut at = match first.as_str() {
            "crate" => Vec::new(),
            "self" => from.clone(),
            "super" => from.split_last()?.1.to_vec(),
            name => {
                let mut child = from.clone();
                child.push(name.to_owned());
                if !self.0.contains_key(&child) {
                    return None;
                }
                child
            }
        };
        for name in names {
            if name == "super" {
                at.pop();
                continue;
            }
            let mut child = at.clone();
            child.push(name.clone());
            if self.0.contains_key(&child) {
                at = child;
                continue;
            }
            return Some(self.behind_reexports(&at, name, depth).unwrap_or(at));
        }
        Some(at)
    }

    /// The module that `name` lives in, where `at` only re-exports it.
    fn behind_reexports(&self, at: &Module, name: &str, depth: usize) -> Option<Module> {
        let source = self.0.get(at)?;
        if depth == 0 {
            return None;
        }
        let path = source.reexports.get(name)?;
        self.home(at, path, depth - 1)
    }

    /// The arrows from each module, with the paths that make them.
    fn arrows(&self) -> BTreeMap<&Module, BTreeMap<Module, BTreeSet<String>>> {
        let mut arrows: BTreeMap<&Module, BTreeMap<Module, BTreeSet<String>>> = BTreeMap::new();
        for (module, source) in &self.0 {
            let of_this = arrows.entry(module).or_default();
            for path in &source.used {
                if let Some(home) = self.home(module, path, 8).filter(|home| home != module) {
                    of_this.entry(home).or_default().insert(path.join("::"));
                }
            }
        }
        arrows
    }

    /// A way from a module back to itself, as lines `file -> file: paths`; empty where there is none.
    fn circle(&self) -> Vec<String> {
        let arrows = self.arrows();
        let step = |from: &Module| -> Vec<Module> {
            arrows
                .get(from)
                .map_or_else(Vec::new, |to| to.keys().cloned().collect())
        };
        for start in self.0.keys() {
            // Breadth first, so that the shortest circle through `start` is found.
            let mut before: BTreeMap<Module, Module> = BTreeMap::new();
            let mut waiting = VecDeque::from([start.clone()]);
            while let Some(at) = waiting.pop_front() {
                for next in step(&at) {
                    if next == *start {
                        let mut way = vec![start.clone(), at.clone()];
                        while let Some(earlier) = before.get(way.last().unwrap()) {
                            way.push(earlier.clone());
                        }
                        way.reverse();
                        let pairs = way.windows(2);
                        return pairs
                            .map(|pair| {
                                let paths = &arrows[&pair[0]][&pair[1]];
                                let file = |module| self.0[module].file.display();
                                format!("{} -> {}: {paths:?}", file(&pair[0]), file(&pair[1]))
                            })
                            .collect();
                    }
                    if !before.contains_key(&next) && next != at {
                        before.insert(next.clone(), at.clone());
                        waiting.push_back(next);
                    }
                }
            }
        }
        Vec::new()
    }
}

#[test]
fn no_package_has_a_circle_of_modules() {
    let mut circles = Vec::new();
    for folder in PACKAGES {
        let package = Package::read(&workspace().join(folder));
        assert!(!package.0.is_empty(), "{folder}");
        circles.extend(package.circle());
    }
    assert!(circles.is_empty(), "{circles:#?}");
}

/// Sources in a scratch folder.
fn package(files: &[(&str, &str)]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    Package::read(folder.path()).circle()
}

#[test]
fn a_circle_of_two_files_is_found() {
    let circle = package(&[
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::B; pub struct A;"),
        ("b.rs", "pub struct B(pub Option<crate::a::A>);"),
    ]);
    assert_eq!(circle.len(), 2, "{circle:?}");
}

#[test]
fn a_child_that_needs_its_parent_is_a_circle() {
    let circle = package(&[
        ("lib.rs", "mod a;"),
        (
            "a/mod.rs",
            "mod b; use b::B; pub struct A(B); const N: u8 = 1;",
        ),
        ("a/b.rs", "use super::N; pub struct B([u8; N as usize]);"),
    ]);
    assert_eq!(circle.len(), 2, "{circle:?}");
}

#[test]
fn reexports_and_tests_are_no_arrows() {
    let none = package(&[
        ("lib.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
        (
            "a.rs",
            "pub struct A; #[cfg(test)] mod tests { use crate::B; }",
        ),
        ("b.rs", "use crate::A; pub struct B(A);"),
    ]);
    assert_eq!(none, [""; 0]);
}

#[test]
fn a_circle_through_a_reexport_is_found() {
    let circle = package(&[
        ("lib.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
        ("a.rs", "use super::B; pub struct A(B);"),
        ("b.rs", "use crate::A; pub struct B(A);"),
    ]);
    assert_eq!(circle.len(), 2, "{circle:?}");
}

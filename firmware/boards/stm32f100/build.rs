//! Finds the workspace's `memory.x` for the linker; the build script of every image for this chip.

use std::env;
use std::path::{Path, PathBuf};

fn main() {
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let folder = package
        .ancestors()
        .find(|folder| folder.join("memory.x").is_file())
        .unwrap_or(Path::new("."));
    println!("cargo:rustc-link-search={}", folder.display());
    println!(
        "cargo:rerun-if-changed={}",
        folder.join("memory.x").display()
    );
    if env::var_os("CARGO_FEATURE_DEFMT_RTT").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}

//! Puts the workspace's `memory.x` where the linker looks for it.

use std::env;
use std::path::PathBuf;

fn main() {
    let workspace =
        PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("set by cargo")).join("../..");
    println!("cargo:rustc-link-search={}", workspace.display());
    println!(
        "cargo:rerun-if-changed={}",
        workspace.join("memory.x").display()
    );
    println!("cargo:rerun-if-changed=build.rs");
}

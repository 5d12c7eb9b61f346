//! A firmware image: where it is, and how much memory it needs.

use super::outcome::{BackendError, Sizes};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind};
use std::env;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// A firmware image that was read.
#[derive(Debug, Clone)]
pub struct Image {
    path: PathBuf,
    bytes: Vec<u8>,
    sizes: Sizes,
    stack_room: u32,
}

/// Largest file that is read, in bytes: at most 128 KiB are flashed, the rest is for debuggers.
const MOST_BYTES: u64 = 64 << 20;

/// Where `cargo firmware` puts its images, relative to the folder of build results.
const BUILT: &str = "thumbv7m-none-eabi/firmware";

impl Image {
    /// Reads the image at `path`, or, without one, the image called `name` of this build.
    ///
    /// # Errors
    ///
    /// [`BackendError::NoImage`] where there is none, [`BackendError::BadImage`] where the file is no
    /// program for a microcontroller.
    pub fn load(path: Option<&Path>, name: &str) -> Result<Self, BackendError> {
        let path = path.map_or_else(|| built(name), Path::to_path_buf);
        let unreadable = |error: io::Error| BackendError::NoImage {
            path: path.clone(),
            why: error.to_string(),
        };
        let bad = |why: &str| BackendError::BadImage {
            path: path.clone(),
            why: why.to_owned(),
        };
        let mut bytes = Vec::new();
        // One byte more than the limit shows a file that is too long, or an endless device.
        File::open(&path)
            .and_then(|file| file.take(MOST_BYTES + 1).read_to_end(&mut bytes))
            .map_err(unreadable)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(bad("it is over 64 MiB"));
        }
        if bytes.is_empty() {
            return Err(bad("it is empty"));
        }
        if !bytes.starts_with(b"\x7fELF") {
            return Err(bad("it is no ELF file"));
        }
        let parsed = object::File::parse(&*bytes);
        let file = parsed.map_err(|_error| bad("its ELF headers are damaged or cut short"))?;
        let sizes = sizes(&file);
        let symbol = |name| file.symbols().find(|symbol| symbol.name() == Ok(name));
        let (Some(top), Some(bottom)) = (symbol("_stack_start"), symbol("__sheap")) else {
            return Err(bad("it has no stack"));
        };
        let stack_room = top.address().saturating_sub(bottom.address());
        let stack_room = u32::try_from(stack_room);
        let stack_room = stack_room.map_err(|_error| bad("its stack lies beyond the memory"))?;
        Ok(Self {
            path,
            sizes,
            stack_room,
            bytes,
        })
    }

    /// Returns the path of the image.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the file's bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the memory that the image needs.
    #[must_use]
    pub const fn sizes(&self) -> Sizes {
        self.sizes
    }

    /// Returns the bytes between the variables and the top of the stack.
    #[must_use]
    pub const fn stack_room(&self) -> u32 {
        self.stack_room
    }
}

/// Returns the path of this build's image `name`: beside the folder of the running program.
fn built(name: &str) -> PathBuf {
    let program = env::current_exe().unwrap_or_default();
    let results = program
        .ancestors()
        .find(|folder| folder.join(BUILT).is_dir());
    results
        .unwrap_or(Path::new("target"))
        .join(BUILT)
        .join(name)
}

/// Sums up the sections that are loaded: initialised variables are in both memories.
fn sizes(file: &object::File<'_>) -> Sizes {
    let (mut flash, mut ram) = (0_u64, 0_u64);
    for section in file.sections() {
        let size = section.size();
        match section.kind() {
            SectionKind::Text | SectionKind::ReadOnlyData | SectionKind::ReadOnlyString => {
                flash += size;
            }
            SectionKind::Data => {
                flash += size;
                ram += size;
            }
            SectionKind::UninitializedData => ram += size,
            _ => {}
        }
    }
    let whole = |bytes| u32::try_from(bytes).unwrap_or(u32::MAX);
    Sizes {
        flash_bytes: whole(flash),
        static_ram_bytes: whole(ram),
    }
}

//! Place of the manufacturer's library.

use std::path::{Path, PathBuf};

/// The library is at none of the usual places.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "Force Dimension's library {NAME} is in none of {}; install the SDK from forcedimension.com, and set FDSDK to its \
     folder or name the library",
    .0.iter().map(|folder| folder.display().to_string()).collect::<Vec<_>>().join(", ")
)]
pub struct LibraryNotFound(pub Vec<PathBuf>);

const NAME: &str = if cfg!(windows) {
    "drd64.dll"
} else if cfg!(target_os = "macos") {
    "libdrd.dylib"
} else {
    "libdrd.so"
};

/// Finds the library: in the SDK's folder that the environment variable `FDSDK` names, `~/.local/lib`,
/// `/usr/local/lib` and `/usr/lib`. Of several versions in one folder it takes the one whose name is last.
///
/// # Errors
/// It is in none of these folders.
pub fn find() -> Result<PathBuf, LibraryNotFound> {
    let of = |variable| std::env::var_os(variable).map(PathBuf::from);
    let folders = folders(of("FDSDK").as_deref(), of("HOME").as_deref());
    let found = folders.iter().find_map(|folder| in_folder(folder));
    found.ok_or(LibraryNotFound(folders))
}

fn folders(sdk: Option<&Path>, home: Option<&Path>) -> Vec<PathBuf> {
    let mut folders = Vec::new();
    if let Some(sdk) = sdk {
        let release = sdk.join("lib/release");
        match std::env::consts::OS {
            "windows" => folders.push(sdk.join("bin")),
            "macos" => folders.extend(children(&release)),
            _ => folders.push(release.join(format!("lin-{}-gcc", std::env::consts::ARCH))),
        }
    }
    folders.extend(home.map(|home| home.join(".local/lib")));
    folders.extend(["/usr/local/lib", "/usr/lib"].map(PathBuf::from));
    folders
}

/// Returns the entries of a folder.
fn children(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect()
}

/// Returns the library in a folder; its name may end with a version.
fn in_folder(folder: &Path) -> Option<PathBuf> {
    let is_it = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let stem = NAME.trim_end_matches(".dylib");
        name.starts_with(stem) && (stem == NAME || name.ends_with(".dylib"))
    };
    children(folder).into_iter().filter(is_it).max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_library_of_the_sdk_comes_first_and_a_missing_one_says_where() {
        let sdk = tempfile::tempdir().unwrap();
        let folders = folders(Some(sdk.path()), Some(Path::new("/home/me")));
        assert!(folders[0].starts_with(sdk.path()));
        assert_eq!(folders[1], Path::new("/home/me/.local/lib"));
        std::fs::create_dir_all(&folders[0]).unwrap();
        assert_eq!(in_folder(&folders[0]), None);
        for name in ["libdrd.so.3.16.0", "libdrd.so.3.17.1", "libdhd.so.3.18.0"] {
            std::fs::write(folders[0].join(name), "").unwrap();
        }
        let found = in_folder(&folders[0]).unwrap();
        assert_eq!(found.file_name().unwrap(), "libdrd.so.3.17.1");
        let missing = LibraryNotFound(folders).to_string();
        assert!(
            missing.contains("/home/me/.local/lib, /usr/local/lib"),
            "{missing}"
        );
    }
}

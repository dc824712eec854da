//! Representations of a mesh for contacts with shapes other than spheres: a shell of points, and a distance grid that
//! may be saved in a file.

use std::path::{Component, Path, PathBuf};

use palpate_record::files::atomic;
use palpate_record::files::bounded::DISTANCE_GRID;
use palpate_world::{DistanceGrid, Mesh, PointShell};
use serde::Deserialize;

/// Keys of a shell of points.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawShell {
    points: usize,
    shared_by: Option<usize>,
}

impl RawShell {
    /// Returns the mesh with the shell, and a description of the shell.
    pub fn onto(self, mesh: Mesh) -> Result<(Mesh, String), String> {
        let shell = PointShell::over(&mesh, self.points);
        let shell = match self.shared_by {
            Some(points) => shell.and_then(|shell| shell.shared_by(points)),
            None => shell,
        };
        let shell = shell.map_err(|error| error.to_string())?;
        let words = format!(
            "a shell of {} points, of which {} share a law, at most {:.3} mm from any point of the surface",
            shell.points().len(),
            shell.sharers(),
            1e3 * shell.widest_gap()
        );
        Ok((mesh.with_shell(shell), words))
    }
}

/// Keys of a grid of distances.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDistanceGrid {
    spacing_m: f64,
    file: Option<String>,
}

impl RawDistanceGrid {
    /// Returns the mesh with the grid, and a description of the grid. The grid file is relative to `folder`. If it is
    /// missing, or belongs to another mesh or spacing, the grid is computed and saved there.
    pub fn onto(&self, mesh: Mesh, folder: &Path) -> Result<(Mesh, String), String> {
        let spacing = self.spacing_m;
        let make = || DistanceGrid::new(&mesh, spacing).map_err(|error| error.to_string());
        let (grid, whence) = match &self.file {
            None => (make()?, String::new()),
            Some(name) => {
                let path = beside(folder, name)?;
                match kept(&path, &mesh, spacing)? {
                    Kept::Grid(grid) => (*grid, format!(", from {name}")),
                    other => {
                        let grid = make()?;
                        let why = match other {
                            Kept::OfAnother => {
                                ", recomputed because the saved one is of another mesh or spacing,"
                            }
                            _ => ",",
                        };
                        let put = atomic::write(&path, |file| file.write_all(&grid.to_bytes()));
                        let whence = match put {
                            Ok(()) => format!("{why} saved in {name}"),
                            // The scene is whole without the file; next time it takes as long again.
                            Err(error) => format!("{why} not saved: {error}"),
                        };
                        (grid, whence)
                    }
                }
            }
        };
        let [x, y, z] = grid.counts();
        let error = grid.error();
        let words = format!(
            "a distance grid of {x} x {y} x {z} nodes{whence}; its surface deviates from the mesh by up to {:.3} mm, \
             {:.4} mm root mean square",
            1e3 * error.largest,
            1e3 * error.root_mean_square
        );
        let mesh = mesh.with_grid(grid).map_err(|error| error.to_string())?;
        Ok((mesh, words))
    }
}

/// Returns the path of a file in a folder or below. A scene may be untrusted, so it must not write elsewhere.
fn beside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    let is_below = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    let has_name = Path::new(name).file_name().is_some();
    if !(has_name && Path::new(name).components().all(is_below)) {
        return Err(format!(
            "distance_grid.file is {name:?}, but must be a relative path without '..', in the scene's folder or \
             below"
        ));
    }
    let mut path = folder.to_owned();
    for part in Path::new(name).components() {
        path.push(part);
        if path
            .symlink_metadata()
            .is_ok_and(|found| found.is_symlink())
        {
            return Err(format!(
                "distance_grid.file is {name:?}, but {} is a symbolic link; name a file in the scene's \
                 folder or below",
                path.display()
            ));
        }
    }
    Ok(path)
}

/// Content of a grid file.
enum Kept {
    /// The requested grid.
    Grid(Box<DistanceGrid>),
    /// The grid of another mesh or spacing.
    OfAnother,
    /// There is no file.
    Nothing,
}

fn kept(path: &Path, mesh: &Mesh, spacing: f64) -> Result<Kept, String> {
    let shown = path.display();
    let bytes = match DISTANCE_GRID.bytes(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Kept::Nothing),
        // A target without files has none to keep it in.
        Err(error) if error.kind() == std::io::ErrorKind::Unsupported => return Ok(Kept::Nothing),
        Err(error) => return Err(format!("{shown}: {error}")),
    };
    match DistanceGrid::from_bytes(&bytes, mesh, spacing) {
        Ok(Some(grid)) => Ok(Kept::Grid(Box::new(grid))),
        Ok(None) => Ok(Kept::OfAnother),
        Err(error) => Err(format!(
            "{shown}: {error}; remove it, or name another file for the distance grid"
        )),
    }
}

//! Methods for worlds, by name.

use core::ffi::c_char;
use core::ptr;
use std::ffi::CString;
use std::sync::LazyLock;

use palpate_scene::world::WorldScene;

use super::as_c;

static NAMES: LazyLock<[CString; WorldScene::METHODS.len()]> =
    LazyLock::new(|| WorldScene::METHODS.map(as_c));

/// Returns the number of methods for worlds.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_world_method_count() -> usize {
    NAMES.len()
}

/// Returns the name of the world method with the 0-based index `method`, as accepted by `method` of
/// palpate_world_params, or NULL if there is no such method. The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_world_method_name(method: usize) -> *const c_char {
    let name = NAMES.get(method);
    name.map_or(ptr::null(), |name| name.as_ptr())
}

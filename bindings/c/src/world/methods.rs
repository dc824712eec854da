//! The methods for worlds by name.

use core::ffi::c_char;
use core::ptr;
use std::ffi::CString;
use std::sync::LazyLock;

use palpate_scene::world::WorldScene;

use super::as_c;

static NAMES: LazyLock<[CString; WorldScene::METHODS.len()]> =
    LazyLock::new(|| WorldScene::METHODS.map(as_c));

/// Number of methods for worlds.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_world_method_count() -> usize {
    NAMES.len()
}

/// Name of method number `method` for worlds, counted from 0, which `method` of palpate_world_params takes; NULL where there is
/// none. Nobody has to free it.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_world_method_name(method: usize) -> *const c_char {
    let name = NAMES.get(method);
    name.map_or(ptr::null(), |name| name.as_ptr())
}

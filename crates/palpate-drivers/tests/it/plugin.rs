//! Shared libraries with a device: the example, and libraries with one fault each, compiled by `cc`.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::channel;

use palpate_device::clock::SteppedClock;
use palpate_device::{Device, DeviceErrorKind, Wrench};
use palpate_drivers::plugin::{Plugin, PluginError};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Compiles the example after the changes of `edits`.
fn library(folder: &Path, edits: &[(&str, &str)]) -> PathBuf {
    let example = root().join("examples/own_device/my_device.c");
    let mut text = std::fs::read_to_string(example).unwrap();
    for (from, to) in edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let (source, library) = (folder.join("device.c"), folder.join("libdevice.so"));
    std::fs::write(&source, text).unwrap();
    let made = Command::new("cc")
        .args([
            "-shared",
            "-fPIC",
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
        ])
        .args(["-I".as_ref(), root().join("bindings/c/include").as_os_str()])
        .args([source.as_os_str(), "-o".as_ref(), library.as_os_str()])
        .status();
    assert!(made.unwrap().success());
    library
}

fn open(path: &Path) -> Result<Plugin<SteppedClock>, PluginError> {
    Plugin::open(path, "argument", SteppedClock::new(), |_| {})
}

/// Opens the example with changes.
fn changed(edits: &[(&str, &str)]) -> Result<Plugin<SteppedClock>, PluginError> {
    let folder = tempfile::tempdir().unwrap();
    // A loaded library does not need its file.
    open(&library(folder.path(), edits))
}

/// Compiles the example in Rust.
fn library_in_rust(folder: &Path) -> PathBuf {
    let library = folder.join("libdevice.so");
    let made = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .args([
            "--edition",
            "2024",
            "--crate-type",
            "cdylib",
            "-D",
            "warnings",
            "-o",
        ])
        .args([
            library.as_os_str(),
            root().join("examples/own_device/my_device.rs").as_os_str(),
        ])
        .status();
    assert!(made.unwrap().success());
    library
}

#[test]
fn the_example_in_c_is_a_device() {
    is_the_device(changed(&[]).unwrap());
}

#[test]
fn the_example_in_rust_is_the_same_device() {
    let folder = tempfile::tempdir().unwrap();
    is_the_device(open(&library_in_rust(folder.path())).unwrap());
}

fn is_the_device(mut device: Plugin<SteppedClock>) {
    let can = device.capabilities();
    assert_eq!(
        (can.name.as_str(), can.axes, can.torque_axes),
        ("my device", 1, 0)
    );
    assert_eq!(
        (can.largest_force, can.effective_mass),
        (Some(5.0), Some(0.2))
    );
    assert_eq!(can.largest_stiffness, None);
    let first = device.read().unwrap().position;
    let held = device.write(Wrench::of_force([-9.0, 1.0, 0.0])).unwrap();
    assert_eq!(held, Wrench::of_force([-5.0, 0.0, 0.0]));
    let positions = [(); 50].map(|()| device.read().unwrap().position[0]);
    // -5 N against a spring of 500 N/m: from 5 mm to -5 mm.
    assert!(first[0] > 0.0 && positions[49] < 0.0, "{positions:?}");
    assert!(device.zero_writer().is_none());
}

#[test]
fn a_device_holds_what_it_says_and_zero_works_beside_it() {
    let mut device = changed(&[
        ("(void)held;", "held->force_n[0] = 0.5 * wrench->force_n[0];"),
        (
            "void palpate_device_close",
            "void palpate_device_zero(PalpateDevice *device) { device->force = 0.0; }\nvoid palpate_device_close",
        ),
    ])
    .unwrap();
    let held = device.write(Wrench::of_force([2.0, 0.0, 0.0])).unwrap();
    assert_eq!(held.force, [1.0, 0.0, 0.0]);
    device.zero_writer().unwrap().write_zero();
}

#[test]
fn an_unusable_library_is_named() {
    let error = |edits: &[(&str, &str)]| changed(edits).unwrap_err().to_string();
    let no_such = open(Path::new("/no/such/libdevice.so"))
        .unwrap_err()
        .to_string();
    assert!(no_such.contains("/no/such/libdevice.so"), "{no_such}");
    let identity = "PALPATE_DEVICE_IDENTITY\n";
    let sizes = "uint32_t palpate_device_version(void) { return 1u; }\n\
                 uint32_t palpate_device_size(uint32_t n) { return n == 1u ? 8u : n == 0u ? 72u : 56u; }\n";
    let old = "uint32_t palpate_device_version(void) { return 0u; }\n";
    for (from, to, words) in [
        (identity, old, "version 0 of the interface; allowed: 1"),
        (
            identity,
            sizes,
            "PalpateDeviceSample has 8 bytes; allowed: 72",
        ),
        (identity, "", "no function palpate_device_version"),
        (
            "int palpate_device_read(",
            "int other_read(",
            "no function palpate_device_read",
        ),
        (
            "can->axes = 1;",
            "can->axes = 7;",
            "axes is 7; allowed: 1 to 3",
        ),
        ("can->axes = 1;", "", "axes is 0; allowed: 1 to 3"),
        (
            "can->mass_kg = 0.2;",
            "can->mass_kg = -1.0;",
            "mass_kg is -1; allowed: 0 for unknown",
        ),
        (
            "can->axes = 1;",
            "can->axes = can->torque_axes = 1;",
            "torque_axes is 1; allowed: 0 without has_orientation",
        ),
        (
            "*device = calloc(1, sizeof **device);",
            "*device = argument[0] == 'a' ? 0 : calloc(1, sizeof **device);",
            "cannot open the device (code 3): no memory",
        ),
    ] {
        // The functions are declared, so one that is missing is another name.
        let mut edits = vec![(from, to)];
        if to.contains("other_read") {
            edits.push((
                "#include <stdlib.h>",
                "#include <stdlib.h>\nint other_read(PalpateDevice *, PalpateDeviceSample *);",
            ));
        }
        let said = error(&edits);
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// Other systems do not link such a library.
#[cfg(target_os = "linux")]
#[test]
fn a_library_that_calls_a_missing_function_is_refused_at_opening() {
    let number = "sample->position_m[0] = device->position;";
    let folder = tempfile::tempdir().unwrap();
    let path = library(
        folder.path(),
        &[
            (
                "#include <stdlib.h>",
                "#include <stdlib.h>\ndouble no_such_sensor(void);",
            ),
            (number, "sample->position_m[0] = no_such_sensor();"),
        ],
    );
    let error = open(&path).unwrap_err().to_string();
    assert!(error.contains("no_such_sensor"), "{error}");
}

#[test]
fn wrong_values_and_codes_are_no_samples_and_the_reason_is_said() {
    let number = "sample->position_m[0] = device->position;";
    for (to, kind, words) in [
        (
            "sample->position_m[0] = 0.0 / (device->position * 0.0);",
            DeviceErrorKind::Interrupted,
            "is no number",
        ),
        (
            "(void)sample; return 1;",
            DeviceErrorKind::NothingNew,
            "no new sample",
        ),
        (
            "(void)sample; return 2;",
            DeviceErrorKind::Disconnected,
            "is gone",
        ),
        (
            "(void)sample; return 99;",
            DeviceErrorKind::Interrupted,
            "reports an error",
        ),
        (
            "sample->has_time = 1; sample->time_s = 1.0 / (device->position * 0.0);",
            DeviceErrorKind::Interrupted,
            "time that is no number",
        ),
    ] {
        let mut device = changed(&[(number, to)]).unwrap();
        let error = device.read().unwrap_err();
        assert_eq!(error.kind, kind, "{to}");
        assert!(error.what.contains(words), "{to}: {error}");
    }
    let held = (
        "(void)held;",
        "held->force_n[0] = 1.0 / (device->force * 0.0);",
    );
    let error = changed(&[held]).unwrap().write(Wrench::NONE).unwrap_err();
    assert_eq!(error.kind, DeviceErrorKind::Interrupted);
    let folder = tempfile::tempdir().unwrap();
    let path = library(
        folder.path(),
        &[
            (number, "(void)sample; return 2;"),
            ("return device ? 0", "return device ? \"the cable is out\""),
        ],
    );
    let (told, hears) = channel();
    let tell = move |text| told.send(text).unwrap();
    let mut device = Plugin::open(&path, "", SteppedClock::new(), tell).unwrap();
    device.read().unwrap_err();
    drop(device);
    assert!(hears.recv().unwrap().contains("the cable is out"));
}

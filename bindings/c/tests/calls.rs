//! Calls the C functions from Rust, so that `cargo +nightly miri test --test calls` checks every pointer access for
//! bounds.

use std::ffi::{CStr, c_void};
use std::mem::MaybeUninit;
use std::ptr;

use palpate_c::*;

fn loop_params() -> LoopParams {
    let mut params = MaybeUninit::uninit();
    // SAFETY: the stated number of bytes can be written.
    let status = unsafe { palpate_loop_params_init(params.as_mut_ptr(), size_of::<LoopParams>()) };
    assert_eq!(status, Status::Ok);
    // SAFETY: all of it has been written.
    let mut params = unsafe { params.assume_init() };
    params.period = 0.001;
    params
}

fn contact_params(method: &CStr) -> ContactParams {
    let mut params = MaybeUninit::uninit();
    // SAFETY: the stated number of bytes can be written.
    let status =
        unsafe { palpate_contact_params_init(params.as_mut_ptr(), size_of::<ContactParams>()) };
    assert_eq!(status, Status::Ok);
    // SAFETY: all of it has been written.
    let mut params: ContactParams = unsafe { params.assume_init() };
    params.stiffness = 1000.0;
    params.method = method.as_ptr();
    params
}

fn sample<S: From<u8>>(device_position: S) -> Sample<S> {
    Sample {
        struct_size: size_of::<Sample<S>>(),
        device_position,
        elapsed: S::from(0),
        virtual_force: S::from(0),
        has_elapsed: 0,
        reserved: 0,
    }
}

fn last_error() -> &'static str {
    // SAFETY: the text is terminated by a 0 and is not modified before the comparison.
    unsafe { CStr::from_ptr(palpate_last_error()) }
        .to_str()
        .unwrap()
}

#[test]
fn a_contact_lives_from_new_to_free() {
    let (params, loop_params) = (contact_params(c"basic"), loop_params());
    let mut contact = ptr::null_mut();
    let mut output = MaybeUninit::<Output<f64>>::uninit();
    // SAFETY: every pointer points to a value of its type, and `contact` is not used after it is freed.
    unsafe {
        output
            .as_mut_ptr()
            .cast::<usize>()
            .write(size_of::<Output<f64>>());
        assert_eq!(
            palpate_contact_new(&params, &loop_params, &mut contact),
            Status::Ok
        );
        let force = palpate_contact_step(contact, &sample(0.001), output.as_mut_ptr());
        assert_eq!(force, -1.0);
        let output = output.assume_init();
        assert_eq!(
            (output.force_on_device, output.phase),
            (-1.0, Phase::Contact)
        );
        let mut stiffer = params;
        stiffer.stiffness = 2000.0;
        assert_eq!(
            palpate_contact_change(contact, &stiffer, &loop_params),
            Status::Ok
        );
        let force = palpate_contact_step(contact, &sample(0.001), ptr::null_mut());
        assert!(-1.02 < force && force < -1.0, "{force}");
        assert_eq!(palpate_contact_report_sent(contact, force), Status::Ok);
        assert_eq!(palpate_contact_teleport(contact, 0.0, 0.0), Status::Ok);
        palpate_contact_free(contact);
    }
}

#[test]
fn a_contact_in_memory_of_the_callers_is_made_nowhere_else() {
    let (params, loop_params) = (contact_params(c"hfcr"), loop_params());
    let mut memory: Vec<MaybeUninit<f64>> =
        vec![MaybeUninit::uninit(); PALPATE_CONTACT_SIZE_MAX / 8];
    let size = palpate_contact_size();
    let mut contact = ptr::null_mut();
    // SAFETY: `size` bytes can be written, and every other pointer points to a value of its type.
    unsafe {
        let memory = memory.as_mut_ptr().cast::<c_void>();
        assert_eq!(
            palpate_contact_place(memory, size, &params, &loop_params, &mut contact),
            Status::Ok
        );
        assert_eq!(contact.cast(), memory);
        for tick in 0..20 {
            let position = 1e-4 * f64::from(tick);
            assert!(palpate_contact_step(contact, &sample(position), ptr::null_mut()) <= 0.0);
        }
        // The caller owns the memory, so this frees nothing.
        palpate_contact_free(contact);
        let shifted = memory.cast::<u8>().add(1).cast();
        let status = palpate_contact_place(shifted, size, &params, &loop_params, &mut contact);
        assert_eq!(status, Status::Memory);
        assert!(contact.is_null());
    }
}

#[test]
fn a_contact_in_float_lives_in_less_memory() {
    let (params, loop_params) = (contact_params(c"basic"), loop_params());
    let size = palpate_contact_f32_size();
    assert!(size < palpate_contact_size());
    let mut memory: Vec<MaybeUninit<f64>> = vec![MaybeUninit::uninit(); size.div_ceil(8)];
    let mut output = MaybeUninit::<Output<f32>>::uninit();
    let mut contact = ptr::null_mut();
    // SAFETY: `size` bytes can be written, and every other pointer points to a value of its type.
    unsafe {
        let memory = memory.as_mut_ptr().cast::<c_void>();
        let less = palpate_contact_f32_place(memory, size - 1, &params, &loop_params, &mut contact);
        assert_eq!(less, Status::Memory);
        assert!(contact.is_null());
        let status = palpate_contact_f32_place(memory, size, &params, &loop_params, &mut contact);
        assert_eq!(status, Status::Ok);
        let room = output.as_mut_ptr().cast::<usize>();
        room.write(size_of::<Output<f32>>());
        let force = palpate_contact_f32_step(contact, &sample(0.001_f32), output.as_mut_ptr());
        // The float nearest to 1000 N/m times 1 mm.
        assert_eq!(force, -(1000.0_f32 * 0.001_f32));
        let output = output.assume_init();
        assert_eq!(
            (output.force_on_device, output.phase),
            (force, Phase::Contact)
        );
        // The caller owns the memory, so this frees nothing.
        palpate_contact_f32_free(contact);
        assert_eq!(
            palpate_contact_f32_step(contact, &sample(0.0_f32), ptr::null_mut()),
            0.0
        );
    }
}

#[test]
fn what_is_no_number_in_float_is_refused() {
    let (mut params, of_loop) = (contact_params(c"basic"), loop_params());
    let mut contact: *mut Contact<f32> = ptr::null_mut();
    // Finite in double but not in float.
    params.object_mass = 1e39;
    // SAFETY: every pointer points to a value of its type.
    let status = unsafe { palpate_contact_f32_new(&params, &of_loop, &mut contact) };
    assert_eq!(status, Status::Parameter);
    assert!(
        last_error().starts_with("object_mass is inf kg"),
        "{}",
        last_error()
    );
}

#[test]
fn settings_are_read_as_far_as_their_count_says() {
    let mut params = contact_params(c"coupled");
    let mut of_loop = loop_params();
    of_loop.device_mass = 0.25;
    let settings = [
        Setting {
            key: c"placement".as_ptr(),
            number: 0.0,
            word: c"false".as_ptr(),
        },
        Setting {
            key: c"no such key".as_ptr(),
            number: 0.0,
            word: ptr::null(),
        },
    ];
    params.settings = settings.as_ptr();
    params.setting_count = 1;
    let mut contact = ptr::null_mut();
    let mut text = [0; 200];
    // SAFETY: every pointer points to a value of its type.
    unsafe {
        let status = palpate_contact_new(&params, &of_loop, &mut contact);
        assert_eq!(status, Status::Ok, "{}", last_error());
        let length = palpate_contact_describe(contact, text.as_mut_ptr(), text.len());
        let said = CStr::from_ptr(text.as_ptr()).to_str().unwrap();
        assert_eq!(said.len(), length);
        assert!(said.contains("placement false"), "{said}");
        palpate_contact_free(contact);
        params.setting_count = 2;
        let status = palpate_contact_new(&params, &of_loop, &mut contact);
        assert_eq!(status, Status::Setting);
    }
    assert_eq!(
        last_error(),
        "coupled has no setting \"no such key\"; it has placement, correction"
    );
}

#[test]
fn a_text_is_cut_to_the_room_there_is() {
    for size in 0..8 {
        let mut text = [0x7f; 8];
        // SAFETY: `size` bytes can be written.
        let length = unsafe { palpate_method_text(0, 0, text.as_mut_ptr(), size) };
        assert_eq!(length, "basic".len());
        let kept = size.saturating_sub(1).min(length);
        let bytes: Vec<u8> = text.iter().map(|byte| byte.to_ne_bytes()[0]).collect();
        assert_eq!(&bytes[..kept], &b"basic"[..kept]);
        if size > 0 {
            assert_eq!(bytes[kept], 0);
        }
        assert!(bytes[size..].iter().all(|byte| *byte == 0x7f), "{size}");
    }
}

#[test]
fn an_error_is_that_of_its_thread() {
    let status = report_to_nothing();
    assert_eq!(status, Status::Null);
    assert_eq!(last_error(), "contact is NULL");
    std::thread::spawn(|| assert_eq!(last_error(), ""))
        .join()
        .unwrap();
}

fn report_to_nothing() -> Status {
    // SAFETY: NULL is allowed.
    unsafe { palpate_contact_report_sent(ptr::null_mut(), 1.0) }
}

#[test]
fn a_line_hold_gives_a_mean_and_a_slope() {
    let (params, mut loop_params) = (contact_params(c"coupled"), loop_params());
    loop_params.hold = HoldKind::Line as u32;
    loop_params.device_mass = 0.25;
    let (mass, period) = (loop_params.device_mass, loop_params.period);
    let mut contact = ptr::null_mut();
    let mut output = MaybeUninit::<Output<f64>>::uninit();
    // A free device flies into a wall of 1 kN/m.
    let (mut position, mut speed) = (-0.00095, 0.1);
    let mut largest: f64 = 0.0;
    // SAFETY: every pointer points to a value of its type, and `contact` is not used after it is freed.
    unsafe {
        output
            .as_mut_ptr()
            .cast::<usize>()
            .write(size_of::<Output<f64>>());
        let status = palpate_contact_new(&params, &loop_params, &mut contact);
        assert_eq!(status, Status::Ok, "{}", last_error());
        for _ in 0..40 {
            let force = palpate_contact_step(contact, &sample(position), output.as_mut_ptr());
            let slope = output.assume_init().slope_on_device;
            assert_eq!(output.assume_init().force_on_device, force);
            let status = palpate_contact_report_sent_line(contact, force, slope);
            assert_eq!(status, Status::Ok);
            let start = force - 0.5 * slope * period;
            position +=
                speed * period + (0.5 * start + slope * period / 6.0) * period * period / mass;
            speed += force * period / mass;
            if start < -0.2 && position > 0.0002 {
                // The line ends at the force of the spring; a constant would be K v T/2 = 0.05 N off.
                let end = force + 0.5 * slope * period;
                assert!((end + 1000.0 * position).abs() < 0.003, "{end} {position}");
                largest = largest.max(slope.abs());
            }
        }
        assert!(largest > 80.0, "{largest}");
        // A force without its slope is not the line that the renderer plans with.
        let force = palpate_contact_step(contact, &sample(0.001), ptr::null_mut());
        assert_eq!(force, 0.0);
        assert_eq!(last_error(), "output, which has the slope, is NULL");
        let status = palpate_contact_report_sent_line(contact, 0.0, f64::NAN);
        assert_eq!(status, Status::Parameter);
        assert_eq!(
            last_error(),
            "slope_on_device is NaN, but must be finite [N/s]"
        );
        palpate_contact_free(contact);
    }
}

//! Force Dimension's library `libdrd` by the names of its C interface.
//!
//! Results of calls are those of the interface: 0 is success, -1 an error, and 1 or 2 a result with a meaning of its own.

use std::cell::Cell;
use std::ffi::{c_char, c_int, c_uchar};
use std::marker::PhantomData;
use std::path::Path;

use libloading::Library;

use super::{LibraryError, function, load, text};

/// Number of joint angles that the interface takes.
pub const JOINTS: usize = 8;
/// Number of values of a status.
pub const STATUS: usize = 17;

/// Declares the functions of the interface with their names and types.
macro_rules! functions {
    ($($field:ident $name:literal ($($parameter:ty),*) -> $result:ty;)*) => {
        #[derive(Debug)]
        struct Functions {
            $($field: unsafe extern "C" fn($($parameter),*) -> $result,)*
        }

        impl Functions {
            fn of(library: &Library) -> Result<Self, LibraryError> {
                Ok(Self {
                    $($field: function(library, $name).map_err(|_| LibraryError::OldSdk($name))?,)*
                })
            }
        }
    };
}

functions! {
    available "dhdGetAvailableCount" () -> c_int;
    open_id "dhdOpenID" (c_char) -> c_int;
    open_serial "dhdOpenSerial" (c_int) -> c_int;
    close "dhdClose" (c_char) -> c_int;
    stop "dhdStop" (c_char) -> c_int;
    system_type "dhdGetSystemType" (c_char) -> c_int;
    status "dhdGetStatus" (*mut c_int, c_char) -> c_int;
    enable_force "dhdEnableForce" (bool, c_char) -> c_int;
    position "dhdGetPosition" (*mut f64, *mut f64, *mut f64, c_char) -> c_int;
    frame "dhdGetPositionAndOrientationFrame" (*mut f64, *mut f64, *mut f64, *mut [f64; 3], c_char) -> c_int;
    velocity "dhdGetLinearVelocity" (*mut f64, *mut f64, *mut f64, c_char) -> c_int;
    force "dhdSetForce" (f64, f64, f64, c_char) -> c_int;
    torque "dhdSetForceAndTorque" (f64, f64, f64, f64, f64, f64, c_char) -> c_int;
    gripper_force "dhdSetForceAndTorqueAndGripperForce" (f64, f64, f64, f64, f64, f64, f64, c_char) -> c_int;
    gripper_gap "dhdGetGripperGap" (*mut f64, c_char) -> c_int;
    gravity "dhdSetGravityCompensation" (bool, c_char) -> c_int;
    max_force "dhdSetMaxForce" (f64, c_char) -> c_int;
    max_torque "dhdSetMaxTorque" (f64, c_char) -> c_int;
    brakes "dhdSetBrakes" (bool, c_char) -> c_int;
    expert "dhdEnableExpertMode" () -> c_int;
    joints "dhdGetJointAngles" (*mut f64, c_char) -> c_int;
    inertia "dhdJointAnglesToInertiaMatrix" (*mut f64, *mut [f64; 6], c_char) -> c_int;
    set_watchdog "dhdSetWatchdog" (c_uchar, c_char) -> c_int;
    watchdog "dhdGetWatchdog" (*mut c_uchar, c_char) -> c_int;
    error "dhdErrorGetLastStr" () -> *const c_char;
}

/// The library. It is used by one thread at a time, since the interface promises nothing else.
#[derive(Debug)]
pub struct Dhd {
    functions: Functions,
    /// After the functions, which it contains.
    _library: Library,
    one_thread: PhantomData<Cell<()>>,
}

/// An open device, closed on drop.
#[derive(Debug)]
pub struct DhdDevice {
    dhd: Dhd,
    id: c_char,
}

/// A command of forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forces {
    /// Force `[N]`.
    pub force: [f64; 3],
    /// Torque, for a device with a driven wrist `[N m]`.
    pub torque: Option<[f64; 3]>,
    /// Force of the gripper, for a device with a driven one `[N]`.
    pub gripper: Option<f64>,
}

impl Dhd {
    /// Loads the library at `path`.
    pub fn load(path: &Path) -> Result<Self, LibraryError> {
        let library = load(path)?;
        Ok(Self {
            functions: Functions::of(&library)?,
            _library: library,
            one_thread: PhantomData,
        })
    }

    /// Returns the number of devices that can be opened, or -1.
    pub fn available(&self) -> i32 {
        // SAFETY: The manufacturer declares this signature.
        unsafe { (self.functions.available)() }
    }

    /// Opens the first device, or the one with a serial number. An error has the library's words.
    pub fn open(self, serial: Option<i32>) -> Result<DhdDevice, String> {
        // SAFETY: The manufacturer declares these signatures.
        let id = unsafe {
            match serial {
                Some(serial) => (self.functions.open_serial)(serial),
                None => (self.functions.open_id)(0),
            }
        };
        match c_char::try_from(id) {
            Ok(open) if id >= 0 => Ok(DhdDevice {
                dhd: self,
                id: open,
            }),
            _ => Err(self.error()),
        }
    }

    /// Returns the last error in the library's words.
    fn error(&self) -> String {
        // SAFETY: The manufacturer declares this signature; the text is copied at once.
        text(unsafe { (self.functions.error)() }).unwrap_or_else(|| "no reason is given".to_owned())
    }
}

impl DhdDevice {
    /// Returns the number of the device.
    pub fn id(&self) -> i32 {
        self.id.into()
    }

    /// Returns the last error in the library's words.
    pub fn error(&self) -> String {
        self.dhd.error()
    }

    /// Returns the type of the device, or -1.
    pub fn system_type(&self) -> i32 {
        // SAFETY: The device is open; the manufacturer declares this signature.
        unsafe { (self.dhd.functions.system_type)(self.id) }
    }

    /// Returns the status, if it can be had.
    pub fn status(&self) -> Option<[i32; STATUS]> {
        // Room for the entries of later versions.
        let mut found = [0; 2 * STATUS];
        // SAFETY: The device is open, and the array is longer than the interface demands.
        let result = unsafe { (self.dhd.functions.status)(found.as_mut_ptr(), self.id) };
        (result >= 0).then(|| std::array::from_fn(|entry| found.get(entry).copied().unwrap_or(0)))
    }

    /// Returns the result and the position `[m]`.
    pub fn position(&self) -> (i32, [f64; 3]) {
        let [mut x, mut y, mut z] = [f64::NAN; 3];
        // SAFETY: The device is open, and the pointers are valid for the call.
        let result =
            unsafe { (self.dhd.functions.position)(&raw mut x, &raw mut y, &raw mut z, self.id) };
        (result, [x, y, z])
    }

    /// Returns the result, the position `[m]` and the matrix that rotates the handle's axes into those of the device.
    pub fn frame(&self) -> (i32, [f64; 3], [[f64; 3]; 3]) {
        let [mut x, mut y, mut z] = [f64::NAN; 3];
        let mut matrix = [[f64::NAN; 3]; 3];
        // SAFETY: The device is open, and the pointers are valid for the call.
        let result = unsafe {
            (self.dhd.functions.frame)(
                &raw mut x,
                &raw mut y,
                &raw mut z,
                matrix.as_mut_ptr(),
                self.id,
            )
        };
        (result, [x, y, z], matrix)
    }

    /// Returns the velocity, if it can be had `[m/s]`.
    pub fn velocity(&self) -> Option<[f64; 3]> {
        let [mut x, mut y, mut z] = [f64::NAN; 3];
        // SAFETY: The device is open, and the pointers are valid for the call.
        let result =
            unsafe { (self.dhd.functions.velocity)(&raw mut x, &raw mut y, &raw mut z, self.id) };
        (result >= 0).then_some([x, y, z])
    }

    /// Returns the result and the gap of the gripper `[m]`.
    pub fn gripper_gap(&self) -> (i32, f64) {
        let mut gap = f64::NAN;
        // SAFETY: The device is open, and the pointer is valid for the call.
        let result = unsafe { (self.dhd.functions.gripper_gap)(&raw mut gap, self.id) };
        (result, gap)
    }

    /// Commands forces by the function for the axes of the device, and returns its result.
    pub fn command(&self, forces: &Forces) -> i32 {
        let [x, y, z] = forces.force;
        let functions = &self.dhd.functions;
        // SAFETY: The device is open; the manufacturer declares these signatures.
        unsafe {
            match (forces.torque, forces.gripper) {
                (None, None) => (functions.force)(x, y, z, self.id),
                (Some([a, b, c]), None) => (functions.torque)(x, y, z, a, b, c, self.id),
                (torque, Some(gripper)) => {
                    let [a, b, c] = torque.unwrap_or_default();
                    (functions.gripper_force)(x, y, z, a, b, c, gripper, self.id)
                }
            }
        }
    }

    /// Switches the forces and returns the result.
    pub fn enable_force(&self, on: bool) -> i32 {
        // SAFETY: The device is open; the manufacturer declares this signature.
        unsafe { (self.dhd.functions.enable_force)(on, self.id) }
    }

    /// Switches the gravity compensation and returns the result.
    pub fn set_gravity_compensation(&self, on: bool) -> i32 {
        // SAFETY: As above.
        unsafe { (self.dhd.functions.gravity)(on, self.id) }
    }

    /// Switches the electromagnetic brakes and returns the result.
    pub fn set_brakes(&self, on: bool) -> i32 {
        // SAFETY: As above.
        unsafe { (self.dhd.functions.brakes)(on, self.id) }
    }

    /// Sets the library's own limits `[N]`, `[N m]` and returns the worse result.
    pub fn set_limits(&self, force: f64, torque: Option<f64>) -> i32 {
        // SAFETY: As above.
        let of_force = unsafe { (self.dhd.functions.max_force)(force, self.id) };
        // SAFETY: As above.
        let of_torque = torque.map_or(0, |torque| unsafe {
            (self.dhd.functions.max_torque)(torque, self.id)
        });
        of_force.min(of_torque)
    }

    /// Sets the firmware's watchdog to a number of 125 us and returns the number that it then has.
    pub fn set_watchdog(&self, number: u8) -> Option<u8> {
        let mut found = 0;
        let functions = &self.dhd.functions;
        // SAFETY: The device is open, and the pointer is valid for the call.
        let is_set = unsafe {
            (functions.expert)() >= 0
                && (functions.set_watchdog)(number, self.id) >= 0
                && (functions.watchdog)(&raw mut found, self.id) >= 0
        };
        is_set.then_some(found)
    }

    /// Returns the matrix of inertia at the present pose, along and about the device's axes `[kg]`, `[kg m]`,
    /// `[kg m^2]`, if it can be had.
    pub fn inertia(&self) -> Option<[[f64; 6]; 6]> {
        let mut joints = [0.0; JOINTS];
        let mut matrix = [[f64::NAN; 6]; 6];
        let functions = &self.dhd.functions;
        // SAFETY: The device is open, and the arrays have the sizes that the interface demands.
        let is_known = unsafe {
            (functions.expert)() >= 0
                && (functions.joints)(joints.as_mut_ptr(), self.id) >= 0
                && (functions.inertia)(joints.as_mut_ptr(), matrix.as_mut_ptr(), self.id) >= 0
        };
        is_known.then_some(matrix)
    }
}

impl Drop for DhdDevice {
    fn drop(&mut self) {
        // SAFETY: The device is open, and this is the last use of it.
        unsafe {
            (self.dhd.functions.stop)(self.id);
            (self.dhd.functions.close)(self.id);
        }
    }
}

/*
 * palpate: contact forces for haptic devices, at the loop rate of the device.
 * SI units: positions in m, times in s, masses in kg, forces in N, energies in J. docs/integrate/c.md
 *
 * Made from bindings/c/src by cbindgen; do not edit. License: MIT OR Apache-2.0
 */

#pragma once

#include <stddef.h>
#include <stdint.h>

/*
 Version of this interface. It increases with changes that break compiled programs; pure additions
 do not change it.
 */
#define PALPATE_ABI_VERSION 1

/*
 Largest size of a contact in bytes, for statically allocated memory; palpate_contact_size() returns the
 actual size.
 */
#define PALPATE_CONTACT_SIZE_MAX 4608

/*
 Largest alignment of a contact in bytes; palpate_contact_align() returns the actual alignment.
 */
#define PALPATE_CONTACT_ALIGN_MAX 8

/*
 Largest size of a contact in float in bytes, for statically allocated memory; palpate_contact_f32_size()
 returns the actual size. Its alignment is at most PALPATE_CONTACT_ALIGN_MAX.
 */
#define PALPATE_CONTACT_F32_SIZE_MAX 2304

/*
 Value of `first_body` and `second_body` if the object is a device.
 */
#define PALPATE_NO_BODY UINT32_MAX

/*
 Value of `fault_device` if the fault does not belong to one device.
 */
#define PALPATE_NO_DEVICE UINT32_MAX

/*
 Result of a call. `palpate_last_error` returns the message, palpate_status_name the name.

 A status names the kind of the wrong argument, for every function: NULL, STRUCT_SIZE and MEMORY a pointer and its
 target, PARAMETER a number, SETTING a text, COUNT an index or a number of elements, SCENE the content of a scene,
 CHANGE an active contact or world, RECORDING a file of ticks. Of several errors the first one is returned.

 A rejected call changes nothing, with three exceptions: a function that creates an object sets its output to NULL,
 palpate_recorder_close always frees the recorder, and after INTERNAL all objects involved can only be freed.
 */
enum palpate_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Success.
   */
  PALPATE_STATUS_OK = 0,
  /*
   A required pointer is NULL.
   */
  PALPATE_STATUS_NULL = 1,
  /*
   A struct_size is too small, or larger than this library knows and an unknown field is not 0.
   */
  PALPATE_STATUS_STRUCT_SIZE = 2,
  /*
   A number of the call, of a struct or of an array is outside its range, including choices, switches and nonzero
   reserved fields.
   */
  PALPATE_STATUS_PARAMETER = 3,
  /*
   A text is not UTF-8 or is not a known method, setting or word; a setting is given twice or is missing.
   */
  PALPATE_STATUS_SETTING = 4,
  /*
   An active contact or world cannot change to this: another period, side or set of devices, or motion of a
   fixed body.
   */
  PALPATE_STATUS_CHANGE = 5,
  /*
   The given memory is too small or misaligned, an array cannot have this many elements, or the system is out of
   memory.
   */
  PALPATE_STATUS_MEMORY = 6,
  /*
   A defect in the library was caught. Please report it.
   */
  PALPATE_STATUS_INTERNAL = 7,
  /*
   A scene cannot be read, is not a world or cannot be rendered; a name is unknown or exists already.
   */
  PALPATE_STATUS_SCENE = 8,
  /*
   An index, or a number of devices or bodies, is out of range.
   */
  PALPATE_STATUS_COUNT = 9,
  /*
   A recording cannot be started or written, or a tick belongs to another object than the recorded one.
   */
  PALPATE_STATUS_RECORDING = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_status palpate_status;
#else
typedef uint32_t palpate_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Predicted contact phase of the object in the coming interval.
 */
enum palpate_phase
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   No contact.
   */
  PALPATE_PHASE_FREE = 0,
  /*
   In contact throughout.
   */
  PALPATE_PHASE_CONTACT = 1,
  /*
   Contact begins within the interval.
   */
  PALPATE_PHASE_ENTERS = 2,
  /*
   Contact ends within the interval.
   */
  PALPATE_PHASE_LEAVES = 3,
  /*
   Waiting after a fault: the object is held still.
   */
  PALPATE_PHASE_WAITING = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_phase palpate_phase;
#else
typedef uint32_t palpate_phase;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Reason for rejecting a sample. The force is then 0; rendering resumes at the next valid sample.
 */
enum palpate_fault
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   The sample was accepted.
   */
  PALPATE_FAULT_NONE = 0,
  /*
   The device position is not a finite number.
   */
  PALPATE_FAULT_POSITION_NOT_FINITE = 1,
  /*
   The virtual force is not a finite number.
   */
  PALPATE_FAULT_VIRTUAL_FORCE_NOT_FINITE = 2,
  /*
   The time since the previous sample is not positive.
   */
  PALPATE_FAULT_ELAPSED_NOT_POSITIVE = 3,
  /*
   The time since the previous sample exceeds the largest gap.
   */
  PALPATE_FAULT_GAP_TOO_LONG = 4,
  /*
   The device position jumped faster than the speed limit.
   */
  PALPATE_FAULT_JUMP_TOO_FAST = 5,
  /*
   The force or the object's motion would not be a finite number.
   */
  PALPATE_FAULT_OVERFLOW = 6,
  /*
   The device orientation is not a unit quaternion.
   */
  PALPATE_FAULT_ORIENTATION_NOT_UNIT = 7,
  /*
   A fault that a newer core defines.
   */
  PALPATE_FAULT_OTHER = 99,
  /*
   An argument is wrong, and no tick was executed: the contact, world, sample or an array is NULL, a
   struct_size is too small, the number of poses or wrenches differs from the number of devices, has_elapsed
   is neither 0 nor 1, or a reserved field is not 0. palpate_last_error has the details.
   */
  PALPATE_FAULT_ARGUMENT = 100,
  /*
   A defect in the library was caught. Please report it.
   */
  PALPATE_FAULT_INTERNAL = 101,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_fault palpate_fault;
#else
typedef uint32_t palpate_fault;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Reason for rejecting a model. The loop keeps the previous model.
 */
enum palpate_model_refusal
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   The model was accepted, or none was published.
   */
  PALPATE_MODEL_REFUSAL_NONE = 0,
  /*
   The model is for a future tick.
   */
  PALPATE_MODEL_REFUSAL_NOT_YET = 1,
  /*
   The model is for an earlier tick than the previous model.
   */
  PALPATE_MODEL_REFUSAL_OUT_OF_ORDER = 2,
  /*
   The model is older than stale_after.
   */
  PALPATE_MODEL_REFUSAL_TOO_OLD = 3,
  /*
   The model is from another simulator.
   */
  PALPATE_MODEL_REFUSAL_OTHER_HOST = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_model_refusal palpate_model_refusal;
#else
typedef uint32_t palpate_model_refusal;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Contact state of two surfaces at a point.
 */
enum palpate_touch
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   No contact.
   */
  PALPATE_TOUCH_FREE = 0,
  /*
   In contact and sticking, or without friction.
   */
  PALPATE_TOUCH_STICKS = 1,
  /*
   In contact and sliding.
   */
  PALPATE_TOUCH_SLIDES = 2,
  /*
   Overlapping without force: the surfaces separate faster than the material recovers.
   */
  PALPATE_TOUCH_PARTS = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_touch palpate_touch;
#else
typedef uint32_t palpate_touch;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Side of the device on which the object lies.
 */
enum palpate_side
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   In the direction of increasing device position: penetration = device - object.
   */
  PALPATE_SIDE_POSITIVE = 0,
  /*
   In the direction of decreasing device position: penetration = object - device.
   */
  PALPATE_SIDE_NEGATIVE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_side palpate_side;
#else
typedef uint32_t palpate_side;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Mode of the guard, which bounds the energy that held forces generate.
 */
enum palpate_guard
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   The guard is off.
   */
  PALPATE_GUARD_OFF = 0,
  /*
   A force beyond the bound is held and reported.
   */
  PALPATE_GUARD_REPORT = 1,
  /*
   Forces are limited to the bound.
   */
  PALPATE_GUARD_LIMIT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_guard palpate_guard;
#else
typedef uint32_t palpate_guard;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Force that the actuator holds for each command, over one period.
 */
enum palpate_hold
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   A constant: zero-order hold.
   */
  PALPATE_HOLD_CONSTANT = 0,
  /*
   A line: `force_on_device + slope_on_device (t - T/2)` for t from 0 to the period T, then its last value. It
   requires coupled rendering and an output at each tick, and excludes a lag, a slew limit and a guard.
   */
  PALPATE_HOLD_LINE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_hold palpate_hold;
#else
typedef uint32_t palpate_hold;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Texts that palpate_method_text returns for a method.
 */
enum palpate_about_method
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Name, as accepted by `method` of palpate_contact_params.
   */
  PALPATE_ABOUT_METHOD_NAME = 0,
  /*
   Short description.
   */
  PALPATE_ABOUT_METHOD_SUMMARY = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_about_method palpate_about_method;
#else
typedef uint32_t palpate_about_method;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Texts that palpate_setting_text returns for a setting.
 */
enum palpate_about_setting
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Key.
   */
  PALPATE_ABOUT_SETTING_KEY = 0,
  /*
   Unit symbol; "" for words, switches and dimensionless numbers.
   */
  PALPATE_ABOUT_SETTING_UNIT = 1,
  /*
   Short description that continues the method's name.
   */
  PALPATE_ABOUT_SETTING_HELP = 2,
  /*
   Default value.
   */
  PALPATE_ABOUT_SETTING_DEFAULT = 3,
  /*
   Accepted words, separated by commas; "" if the setting accepts only numbers.
   */
  PALPATE_ABOUT_SETTING_WORDS = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_about_setting palpate_about_setting;
#else
typedef uint32_t palpate_about_setting;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Limits that changed the force, and PALPATE_LIMIT_BEYOND_GUARD, which changes none: bits of `limited`.
 */
enum palpate_limit
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   A pulling force was removed, because the contact may only push.
   */
  PALPATE_LIMIT_PULL = 1,
  /*
   The force exceeded the force limit.
   */
  PALPATE_LIMIT_FORCE = 2,
  /*
   The force changed faster than the slew limit.
   */
  PALPATE_LIMIT_SLEW = 4,
  /*
   The force exceeded the guard's bound: it could generate more energy than the balance allows.
   */
  PALPATE_LIMIT_GUARD = 8,
  /*
   A torque exceeded the torque limit (worlds only).
   */
  PALPATE_LIMIT_TORQUE = 16,
  /*
   The proxy offset of a tool was clamped to its limit (worlds only).
   */
  PALPATE_LIMIT_OFFSET = 32,
  /*
   The soft start after a start or a fault reduced the force (worlds only).
   */
  PALPATE_LIMIT_SOFT_START = 64,
  /*
   Safety stop: held forces have generated energy, and all wrenches stay 0 (worlds only). To resume, free the
   world and create it again.
   */
  PALPATE_LIMIT_STOPPED = 128,
  /*
   The device accelerated beyond guard_acceleration in the interval that this sample ends. For the next force the
   guard uses its bound by speed.
   */
  PALPATE_LIMIT_BEYOND_GUARD = 256,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_limit palpate_limit;
#else
typedef uint32_t palpate_limit;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Kind of a shape.
 */
enum palpate_shape_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   A sphere of `radius`; for a tool, radius 0 is a point.
   */
  PALPATE_SHAPE_KIND_SPHERE = 0,
  /*
   The half-space behind the plane with normal `normal` at distance `offset`; for fixed bodies.
   */
  PALPATE_SHAPE_KIND_HALF_SPACE = 1,
  /*
   A box of `half_extents`.
   */
  PALPATE_SHAPE_KIND_BOX = 2,
  /*
   All points within `radius` of a segment of length 2 `half_length` along z.
   */
  PALPATE_SHAPE_KIND_CAPSULE = 3,
  /*
   A cylinder of `radius` and a length of 2 `half_length` along z.
   */
  PALPATE_SHAPE_KIND_CYLINDER = 4,
  /*
   The triangles `faces` between `points`; for bodies.
   */
  PALPATE_SHAPE_KIND_MESH = 5,
  /*
   The convex hull of `points`; for bodies.
   */
  PALPATE_SHAPE_KIND_HULL = 6,
  /*
   A sphere of `radius` at each of `points`; for tools.
   */
  PALPATE_SHAPE_KIND_SPHERES = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_shape_kind palpate_shape_kind;
#else
typedef uint32_t palpate_shape_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Degree of freedom of a joint.
 */
enum palpate_joint
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Rotation about the axis only.
   */
  PALPATE_JOINT_HINGE = 0,
  /*
   Translation along the axis only.
   */
  PALPATE_JOINT_SLIDER = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_joint palpate_joint;
#else
typedef uint32_t palpate_joint;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 A rendered contact. Its ticks are in double, or in float if the name ends with f32. Only one thread may use it
 at a time.
 */
typedef struct palpate_contact_f32 palpate_contact_f32;

/*
 A rendered contact. Its ticks are in double, or in float if the name ends with f32. Only one thread may use it
 at a time.
 */
typedef struct palpate_contact palpate_contact;

/*
 Loop side of a multirate local model: renders the published bodies and contacts. Only one thread may use it at a
 time.
 */
typedef struct palpate_local_world palpate_local_world;

/*
 Simulator side of a multirate local model, for a low-rate simulator such as a 60 Hz physics engine. Only one
 thread may use it at a time.

 The simulator repeats four steps: read the progress; integrate over the time since the previous progress with
 palpate_mean_wrench() on each body; detect contacts near the proxy; publish its bodies and contacts for the tick
 of the progress.
 */
typedef struct palpate_low_rate_simulator palpate_low_rate_simulator;

/*
 A recording in progress. Only one thread may use it at a time.
 */
typedef struct palpate_recorder palpate_recorder;

/*
 Description of a world: its loop, devices, bodies, contact laws and joints. A scene renders nothing. A world is
 created from it or changed to it, and is independent of it afterwards. Only one thread may use it at a time.
 */
typedef struct palpate_scene palpate_scene;

/*
 A rendered world. Only one thread may use it at a time.
 */
typedef struct palpate_world palpate_world;

/*
 A method setting, by its key in files: {"damping_n_s_per_m", 0.5, NULL}, or {"placement", 0, "false"}.
 */
typedef struct palpate_setting {
  /*
   Key, such as "damping_n_s_per_m"; palpate_setting_text lists the keys of each method.
   */
  const char *key;
  /*
   Value in the unit of the key; used if `word` is NULL.
   */
  double number;
  /*
   Value as a word: a word of this setting, "auto", or "true" and "false" for a switch. NULL: `number` is used.
   */
  const char *word;
} palpate_setting;

/*
 One contact between the device's end-point and a virtual object along one axis, and the method that
 renders it. palpate_contact_params_default() fills it.
 */
typedef struct palpate_contact_params {
  /*
   Size of this struct; palpate_contact_params_default() sets it.
   */
  size_t struct_size;
  /*
   Contact stiffness K [N/m], greater than 0. It has no default.
   */
  double stiffness;
  /*
   Mass M of the object [kg], greater than 0. INFINITY, the default: a wall.
   */
  double object_mass;
  /*
   Initial position of the object's surface, or the fixed position of a wall [m]. Default: 0.
   */
  double object_position;
  /*
   Initial velocity of the object [m/s]; 0 for a wall. Default: 0.
   */
  double object_velocity;
  /*
   Virtual force f_V on the object, for instance its weight, positive along the axis [N]. The virtual force
   of a sample is added. Default: 0.
   */
  double virtual_force;
  /*
   Name of the method; palpate_method_text lists all names. NULL, the default: coupled rendering.
   */
  const char *method;
  /*
   Settings of the method; a missing setting has its default. NULL if there are none.
   */
  const struct palpate_setting *settings;
  /*
   Number of settings.
   */
  size_t setting_count;
  /*
   A palpate_side. Default: PALPATE_SIDE_POSITIVE.
   */
  uint32_t side;
  /*
   1: the contact may only push. Default: 0, as in the paper, whose methods may pull for a part of an
   interval.
   */
  uint32_t unilateral;
} palpate_contact_params;

/*
 Parameters of the loop and its device, and the limits. palpate_loop_params_default() fills it.
 */
typedef struct palpate_loop_params {
  /*
   Size of this struct; palpate_loop_params_default() sets it.
   */
  size_t struct_size;
  /*
   Nominal time T between samples [s], greater than 0: 0.001 is 1 ms. It has no default.
   */
  double period;
  /*
   Largest allowed time between two samples [s]; a longer gap is a fault. 0: 20 periods.
   */
  double largest_gap;
  /*
   Largest accepted device speed [m/s]; a faster jump is a fault. INFINITY: no limit.
   Default: 100.
   */
  double speed_limit;
  /*
   Largest held force [N]. INFINITY: no limit. Default: 20.
   */
  double force_limit;
  /*
   Largest rate of change of the held force [N/s]. INFINITY, the default: no limit.
   */
  double slew_limit;
  /*
   Delay from a sample to the start of its force [s], at most 8 periods. Default: 0.
   */
  double delay;
  /*
   Standard deviation of the delay, including its variation between commands [s], at most 8 periods.
   */
  double delay_deviation;
  /*
   Time constant of the actuator [s]. Default: 0.
   */
  double lag;
  /*
   Standard deviation of the lag [s], at most 8 periods.
   */
  double lag_deviation;
  /*
   Ratio of delivered to commanded force, greater than 0. Default: 1.
   */
  double gain;
  /*
   Standard deviation of the gain, at most the gain.
   */
  double gain_deviation;
  /*
   Effective mass of the device at its end-point [kg], within a factor of 2; coupled rendering needs
   it. 0, the default: unknown. INFINITY: the device is position-driven by a recording.
   */
  double device_mass;
  /*
   Quantum of the position sensor [m]. 0, the default: unknown or none.
   */
  double encoder_quantum;
  /*
   Largest device speed for which the guard's bound holds [m/s].
   */
  double guard_speed;
  /*
   Energy that the guard allows beyond the energy balance [J].
   */
  double guard_allowance;
  /*
   Largest acceleration of the device by everything except the rendered force [m/s^2]: see HandBound. 0, the
   default: none. Else guard_mass is needed. Without it and guard_hand_force the guard bounds by speed only.
   */
  double guard_acceleration;
  /*
   Largest force on the device by everything except the rendered force [N], instead of guard_acceleration, which is
   then this force over guard_mass. 0, the default: none.
   */
  double guard_hand_force;
  /*
   Least mass of the device for the bound by acceleration [kg], greater than 0.
   */
  double guard_mass;
  /*
   Power by which the guard forgives energy that may have been given out unnoticed [W]. Default: 0.
   */
  double guard_recovery;
  /*
   A palpate_guard. Default: PALPATE_GUARD_OFF.
   */
  uint32_t guard;
  /*
   A palpate_hold: what the actuator holds. Default: PALPATE_HOLD_CONSTANT.
   */
  uint32_t hold;
  /*
   1: the motion may raise guard_mass; the mass must be the same in every pose. Default: 0.
   */
  uint32_t guard_learns_mass;
  /*
   Must be 0.
   */
  uint32_t reserved;
} palpate_loop_params;

/*
 One sample of the device. palpate_sample_at() fills it, palpate_sample_f32_at() one in float.
 */
typedef struct palpate_sample {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Measured position of the device's end-point along the contact's axis [m].
   */
  double device_position;
  /*
   Time since the previous sample [s]; used if `has_elapsed` is 1.
   */
  double elapsed;
  /*
   Virtual force on the object over the coming interval, in addition to that of the contact [N].
   */
  double virtual_force;
  /*
   1: `elapsed` is the measured time. 0: one period has elapsed.
   */
  uint32_t has_elapsed;
  /*
   Must be 0.
   */
  uint32_t reserved;
} palpate_sample;

/*
 Result of a tick, along the contact's axis. palpate_output_empty() returns an empty one to be filled,
 palpate_output_f32_empty() one in float.
 */
typedef struct palpate_output {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Force on the device: command it to the motor and hold it until the next sample [N].
   */
  double force_on_device;
  /*
   Opposite force, on the object [N].
   */
  double force_on_object;
  /*
   Slope of the force on the device [N/s]: with PALPATE_HOLD_LINE command `force_on_device + slope_on_device (t -
   T/2)` for t from 0 to the period T, and hold the last value if no command follows. Otherwise 0.
   */
  double slope_on_device;
  /*
   Position of the object's surface at this sample [m].
   */
  double object_position;
  /*
   Velocity of the object at this sample [m/s].
   */
  double object_velocity;
  /*
   Penetration of the device into the object at this sample, positive in contact for either side [m].
   */
  double penetration;
  /*
   Time from this sample to the predicted transition [s]; 0 if there is none.
   */
  double transition_after;
  /*
   Shift of the object by coupled rendering over the last interval [m]; subtract it before drawing
   the object.
   */
  double proxy_shift;
  /*
   Predicted contact phase in the coming interval.
   */
  palpate_phase phase;
  /*
   Reason for rejecting the sample.
   */
  palpate_fault fault;
  /*
   Active limits: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   Unused; 0.
   */
  uint32_t reserved;
} palpate_output;

/*
 Energy ledger of the object, positive into the object. At every sample it balances: stored energy less
 initial stored energy = port_work + virtual_force_work + outside_work + held_leak.
 palpate_ledger_empty() returns an empty one to be filled, palpate_ledger_f32_empty() one in float.
 */
typedef struct palpate_ledger {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Kinetic energy of the object and elastic energy of the contact at the last sample [J].
   */
  double stored;
  /*
   Work of the held force on the object [J].
   */
  double port_work;
  /*
   Work of the virtual force on the object [J].
   */
  double virtual_force_work;
  /*
   Energy added by teleporting the object, by parameter changes and during faults [J].
   */
  double outside_work;
  /*
   Remaining leak: energy generated by the held force, less energy dissipated by it [J].
   */
  double held_leak;
  /*
   Remaining leak over the last closed interval [J].
   */
  double held_leak_last;
  /*
   Sum of the absolute remaining leaks of all closed intervals [J].
   */
  double held_leak_absolute;
  /*
   Original leak: energy that the sampled spring would have generated over the same motion [J].
   */
  double original_leak;
  /*
   Original leak over the last closed interval [J].
   */
  double original_leak_last;
  /*
   Sum of the absolute original leaks of all closed intervals [J].
   */
  double original_leak_absolute;
} palpate_ledger;

/*
 One sample of the device. palpate_sample_at() fills it, palpate_sample_f32_at() one in float.
 */
typedef struct palpate_sample_f32 {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Measured position of the device's end-point along the contact's axis [m].
   */
  float device_position;
  /*
   Time since the previous sample [s]; used if `has_elapsed` is 1.
   */
  float elapsed;
  /*
   Virtual force on the object over the coming interval, in addition to that of the contact [N].
   */
  float virtual_force;
  /*
   1: `elapsed` is the measured time. 0: one period has elapsed.
   */
  uint32_t has_elapsed;
  /*
   Must be 0.
   */
  uint32_t reserved;
} palpate_sample_f32;

/*
 Result of a tick, along the contact's axis. palpate_output_empty() returns an empty one to be filled,
 palpate_output_f32_empty() one in float.
 */
typedef struct palpate_output_f32 {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Force on the device: command it to the motor and hold it until the next sample [N].
   */
  float force_on_device;
  /*
   Opposite force, on the object [N].
   */
  float force_on_object;
  /*
   Slope of the force on the device [N/s]: with PALPATE_HOLD_LINE command `force_on_device + slope_on_device (t -
   T/2)` for t from 0 to the period T, and hold the last value if no command follows. Otherwise 0.
   */
  float slope_on_device;
  /*
   Position of the object's surface at this sample [m].
   */
  float object_position;
  /*
   Velocity of the object at this sample [m/s].
   */
  float object_velocity;
  /*
   Penetration of the device into the object at this sample, positive in contact for either side [m].
   */
  float penetration;
  /*
   Time from this sample to the predicted transition [s]; 0 if there is none.
   */
  float transition_after;
  /*
   Shift of the object by coupled rendering over the last interval [m]; subtract it before drawing
   the object.
   */
  float proxy_shift;
  /*
   Predicted contact phase in the coming interval.
   */
  palpate_phase phase;
  /*
   Reason for rejecting the sample.
   */
  palpate_fault fault;
  /*
   Active limits: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   Unused; 0.
   */
  uint32_t reserved;
} palpate_output_f32;

/*
 Energy ledger of the object, positive into the object. At every sample it balances: stored energy less
 initial stored energy = port_work + virtual_force_work + outside_work + held_leak.
 palpate_ledger_empty() returns an empty one to be filled, palpate_ledger_f32_empty() one in float.
 */
typedef struct palpate_ledger_f32 {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Kinetic energy of the object and elastic energy of the contact at the last sample [J].
   */
  float stored;
  /*
   Work of the held force on the object [J].
   */
  float port_work;
  /*
   Work of the virtual force on the object [J].
   */
  float virtual_force_work;
  /*
   Energy added by teleporting the object, by parameter changes and during faults [J].
   */
  float outside_work;
  /*
   Remaining leak: energy generated by the held force, less energy dissipated by it [J].
   */
  float held_leak;
  /*
   Remaining leak over the last closed interval [J].
   */
  float held_leak_last;
  /*
   Sum of the absolute remaining leaks of all closed intervals [J].
   */
  float held_leak_absolute;
  /*
   Original leak: energy that the sampled spring would have generated over the same motion [J].
   */
  float original_leak;
  /*
   Original leak over the last closed interval [J].
   */
  float original_leak_last;
  /*
   Sum of the absolute original leaks of all closed intervals [J].
   */
  float original_leak_absolute;
} palpate_ledger_f32;

/*
 The loop, its device, and capacities for the published model. palpate_local_params_default() fills it.
 */
typedef struct palpate_local_params {
  /*
   Size of this struct; palpate_local_params_default() sets it.
   */
  size_t struct_size;
  /*
   Nominal sampling period of the loop, above 0 [s]: 0.001 is 1 ms. It has no default.
   */
  double period;
  /*
   Effective mass of the device along each world axis, above 0 [kg]; an error of a factor of 2 is acceptable.
   INFINITY: the device lacks this axis. It has no default.
   */
  double device_mass[3];
  /*
   Radius of the spherical tool, not below 0 [m]. Default: 0, a point.
   */
  double tool_radius;
  /*
   Age of the newest model beyond which its contacts fade [s]: 1 to 1000 periods of the loop. Default: 0.2.
   */
  double stale_after;
  /*
   Time over which these contacts fade out, or back in, above 0 [s]. Default: 0.1.
   */
  double fade;
  /*
   Time over which changes of an active contact are blended in, above 0 [s]. Default: 0.01.
   */
  double settle;
  /*
   Time over which the loop's copy of a body returns to the simulator's body, above 0 [s]. Default: 1.
   */
  double return_time;
  /*
   Quantum of the position sensor, not below 0 [m]. Default: 0.
   */
  double quantum;
  /*
   Delay from a sample to the start of its command, not below 0 [s]. Default: 0.
   */
  double delay;
  /*
   Time constant of the first-order lag after the delay, not below 0 [s]. Default: 0.
   */
  double lag;
  /*
   Ratio of delivered to commanded force, above 0. Default: 1.
   */
  double gain;
  /*
   Largest force on the device, by its norm, above 0 [N]. INFINITY: no limit. Default: 20.
   */
  double force_limit;
  /*
   Ramp time of the force if a start or a recovery is in contact, not below 0 [s]. Default: 0.2.
   */
  double soft_start;
  /*
   Number of the simulator's bodies, at most 16. 0, the default: contacts only with fixed surfaces.
   */
  uint32_t bodies;
  /*
   Largest number of contacts of a model, 1 to 64. Default: 8.
   */
  uint32_t contacts;
} palpate_local_params;

/*
 Pose of a device. The struct is an array element, so it has no struct_size and its layout is fixed.
 */
typedef struct palpate_pose {
  /*
   Measured position of the tool in world axes [m].
   */
  double position[3];
  /*
   Measured orientation of a device of six axes: the unit quaternion w, x, y, z that rotates the tool's axes to the
   world's. Ignored for a device of three axes.
   */
  double orientation[4];
} palpate_pose;

/*
 One sample of all devices of a world. palpate_world_sample_at() fills it.
 */
typedef struct palpate_world_sample {
  /*
   Size of this struct; palpate_world_sample_at() sets it.
   */
  size_t struct_size;
  /*
   Poses of the devices in the order of the scene.
   */
  const struct palpate_pose *poses;
  /*
   Number of poses: palpate_world_device_count().
   */
  size_t pose_count;
  /*
   Time since the previous sample [s]; used if `has_elapsed` is 1.
   */
  double elapsed;
  /*
   1: `elapsed` is the measured time. 0: one period has elapsed.
   */
  uint32_t has_elapsed;
  /*
   Must be 0.
   */
  uint32_t reserved;
} palpate_world_sample;

/*
 Wrench of a device on the hand, to be held until the next sample. The struct is an array element, so it has no
 struct_size and its layout is fixed.
 */
typedef struct palpate_wrench {
  /*
   Force in world axes [N].
   */
  double force[3];
  /*
   Torque about the tool's centre of mass in world axes [N m]; 0 for a device of three axes.
   */
  double torque[3];
  /*
   Slope of the force [N/s]: with PALPATE_HOLD_LINE the force is `force + slope (t - T/2)` for t from 0 to the
   period T, then its last value. Otherwise 0.
   */
  double slope[3];
} palpate_wrench;

/*
 Output of a local-model tick, in addition to the force. palpate_local_output_empty() returns an empty one to be
 filled.
 */
typedef struct palpate_local_output {
  /*
   Size of this struct; palpate_local_output_empty() sets it.
   */
  size_t struct_size;
  /*
   Age of the newest model [s]; INFINITY if there is none.
   */
  double age;
  /*
   Reason for rejecting the sample. The force is then 0.
   */
  palpate_fault fault;
  /*
   Limits that changed the force: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   1: the contacts fade or have faded, because there is no model or it is too old.
   */
  uint32_t is_stale;
  /*
   Reason for rejecting the model that arrived since the last tick.
   */
  palpate_model_refusal refusal;
  /*
   Number of sub-steps, including replaced ones.
   */
  uint32_t sub_steps;
  /*
   Number of sub-steps that were replaced by finer ones, at the start or end of a contact or of slip.
   */
  uint32_t refined;
  /*
   Number of such sub-steps that were not refined, because the limit was reached.
   */
  uint32_t unrefined;
  /*
   1: the fastest contact needs more sub-steps than a tick allows. Reduce the stiffness or the period.
   */
  uint32_t too_fast;
} palpate_local_output;

/*
 Progress of the loop: inputs for the simulator's next step. palpate_progress_empty() returns an empty one to be
 filled.
 */
typedef struct palpate_progress {
  /*
   Size of this struct; palpate_progress_empty() sets it.
   */
  size_t struct_size;
  /*
   Number of elapsed periods, rendered and missed. A model that includes all impulses of this progress has this
   tick.
   */
  uint64_t tick;
  /*
   Sampling period of the loop [s].
   */
  double period;
  /*
   Proxy position of the tool at the end of the last period [m]; the simulator detects contacts near it.
   */
  double position[3];
  /*
   Proxy velocity [m/s].
   */
  double velocity[3];
  /*
   Tick of the newest model, if `has_model` is 1.
   */
  uint64_t model_tick;
  /*
   1: a model has been accepted.
   */
  uint32_t has_model;
  /*
   1: the contacts fade or have faded, because there is no model or it is too old.
   */
  uint32_t is_stale;
  /*
   Reason for rejecting the last model.
   */
  palpate_model_refusal refusal;
  /*
   Unused; 0.
   */
  uint32_t reserved;
} palpate_progress;

/*
 Impulses of the tool on a body of the simulator. The struct is an array element, so it has no struct_size and its
 layout is fixed.
 */
typedef struct palpate_body_progress {
  /*
   Impulse of the tool on the body since the start [N s].
   */
  double impulse[3];
  /*
   Moment of the impulse about the body's reference point [N m s].
   */
  double moment[3];
  /*
   Position of the loop's copy of the body [m].
   */
  double copy[3];
} palpate_body_progress;

/*
 A body of the simulator at a tick, in world axes. Torques are about its reference point, usually the centre of
 mass. The struct is an array element, so it has no struct_size and its layout is fixed. palpate_host_body_fixed()
 returns an immovable body.
 */
typedef struct palpate_host_body {
  /*
   Position of the reference point, and orientation of the body.
   */
  struct palpate_pose pose;
  /*
   Velocity of the reference point [m/s].
   */
  double velocity[3];
  /*
   Angular velocity [rad/s].
   */
  double angular_velocity[3];
  /*
   Acceleration of the reference point over the simulator's step, without the tool's contribution [m/s^2].
   */
  double acceleration[3];
  /*
   Angular acceleration without the tool's contribution [rad/s^2].
   */
  double angular_acceleration[3];
  /*
   Mobility matrix: rows are accelerations, columns force [N] and torque about the reference point [N m]. For a
   free body of mass m, the first three diagonal entries are 1/m, and the last three rows and columns are the
   inverse inertia; for an immovable body all entries are 0.
   */
  double mobility[6][6];
} palpate_host_body;

/*
 A potential contact of a sphere (the tool or a part of a body) with a surface, in world axes at the bodies' poses
 in the model. The surface is a plane or, with a curvature, a sphere; it is attached to its body and unbounded.
 The struct is an array element, so it has no struct_size and its layout is fixed. palpate_host_contact_at_gap()
 returns one for the tool, palpate_host_contact_none() an empty one.
 */
typedef struct palpate_host_contact {
  /*
   A point of the surface, usually the closest to the sphere [m].
   */
  double place[3];
  /*
   Unit normal out of the surface at this point.
   */
  double normal[3];
  /*
   Curvature of the surface [1/m]: 1/r for a ball of radius r, -1/r for its inside, 0 for a plane.
   */
  double curvature;
  /*
   Stiffness, above 0 [N/m]. 0: this array element has no contact.
   */
  double stiffness;
  /*
   Damping, not below 0 [N s/m].
   */
  double damping;
  /*
   Coefficient of friction, not below 0.
   */
  double friction;
  /*
   Tangential stiffness of friction, above 0 [N/m]; 0: equal to `stiffness`.
   */
  double friction_stiffness;
  /*
   Damping of friction [N s/m]; 0: `damping` times `friction_stiffness` over `stiffness`; below 0: no damping.
   */
  double friction_damping;
  /*
   Centre of a body's sphere [m]. Ignored for the tool.
   */
  double centre[3];
  /*
   Radius of a body's sphere, not below 0 [m]. Ignored for the tool.
   */
  double radius;
  /*
   Index of the body with the surface; PALPATE_NO_BODY: a fixed surface.
   */
  uint32_t on;
  /*
   Index of the body with the sphere; PALPATE_NO_BODY: the tool.
   */
  uint32_t of;
} palpate_host_contact;

/*
 Parameters of a recording. palpate_recorder_params_default() returns the defaults.
 */
typedef struct palpate_recorder_params {
  /*
   Size of this struct; palpate_recorder_params_default() sets it.
   */
  size_t struct_size;
  /*
   Name of the device, in UTF-8; NULL: unknown.
   */
  const char *device;
  /*
   Text of a scene file of the rendered contact, in UTF-8; `palpate replay` of a contact needs it. NULL: none.
   */
  const char *scene;
  /*
   Capacity of the queue to the disk in ticks of one contact, 1 to 2^24. Each takes about 1 KiB, allocated at
   the start: PALPATE_STATUS_MEMORY if the system has too little. 0: 65536.
   */
  size_t room;
} palpate_recorder_params;

/*
 Result of a recording. palpate_recorded_empty() returns an empty one to be filled.
 */
typedef struct palpate_recorded {
  /*
   Size of this struct; palpate_recorded_empty() sets it.
   */
  size_t struct_size;
  /*
   Ticks that the loop made.
   */
  uint64_t ticks_made;
  /*
   Ticks in the file; 0 if the file could not be completed.
   */
  uint64_t ticks;
  /*
   Ticks dropped because the queue was full. The file lists them.
   */
  uint64_t lost;
} palpate_recorded;

/*
 Output of a world tick, in addition to the wrenches. palpate_world_output_empty() returns an empty one to be filled.
 */
typedef struct palpate_world_output {
  /*
   Size of this struct; palpate_world_output_empty() sets it.
   */
  size_t struct_size;
  /*
   Reason for rejecting the sample. All wrenches are then 0.
   */
  palpate_fault fault;
  /*
   Index of the device with the faulty sample; PALPATE_NO_DEVICE if the fault does not belong to one device.
   */
  uint32_t fault_device;
  /*
   Active limits: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   Number of sub-steps, including replaced ones.
   */
  uint32_t sub_steps;
  /*
   Number of sub-steps that were replaced by finer ones, at the start or end of a contact or of slip.
   */
  uint32_t refined;
  /*
   Number of such sub-steps that were not refined, because the limit was reached.
   */
  uint32_t unrefined;
  /*
   1: the fastest contact needs more sub-steps than a tick allows. Reduce the stiffness or the period.
   */
  uint32_t too_fast;
  /*
   Number of mesh triangles and mesh contacts that exceeded the capacity of a sub-step.
   */
  uint32_t left_out;
} palpate_world_output;

/*
 The loop of a scene and the settings of methods. palpate_scene_params_default() fills it.
 */
typedef struct palpate_scene_params {
  /*
   Size of this struct; palpate_scene_params_default() sets it.
   */
  size_t struct_size;
  /*
   Nominal sampling period, above 0 [s]: 0.001 is 1 ms. It has no default.
   */
  double period;
  /*
   Delay from a sample to the start of its command, not below 0 [s]. Default: 0.
   */
  double delay;
  /*
   Time constant of the first-order lag after the delay, not below 0 [s]. Default: 0.
   */
  double lag;
  /*
   Ratio of delivered to commanded force, above 0. Default: 1.
   */
  double gain;
  /*
   Damping of the methods with damping [N s/m]; 0, the default: unset.
   */
  double damping;
  /*
   Rotational damping of the methods with damping [N m s/rad].
   */
  double rotational_damping;
  /*
   Stiffness of virtual-coupling and god-object [N/m]; 0, the default: unset.
   */
  double coupling_stiffness;
  /*
   Proxy mass of virtual-coupling [kg]; 0, the default: unset.
   */
  double coupling_mass;
  /*
   Rotational stiffness of virtual-coupling [N m/rad].
   */
  double coupling_rotational_stiffness;
  /*
   Proxy moment of inertia of virtual-coupling [kg m^2].
   */
  double coupling_inertia;
  /*
   A palpate_hold: what the actuators hold. Default: PALPATE_HOLD_CONSTANT.
   */
  uint32_t hold;
  /*
   Must be 0.
   */
  uint32_t reserved;
} palpate_scene_params;

/*
 Model values of a device. palpate_device_params_default() fills it.
 */
typedef struct palpate_device_params {
  /*
   Size of this struct; palpate_device_params_default() sets it.
   */
  size_t struct_size;
  /*
   Effective mass along each axis, above 0 [kg]; an error of a factor of 2 is acceptable. It has no default.
   */
  double mass[3];
  /*
   Quantum of the position sensor along each axis, not below 0 [m]. Default: 0.
   */
  double quantum[3];
  /*
   Moments of inertia along the tool's axes, above 0 [kg m^2]; for devices that measure six axes.
   */
  double inertia[3];
  /*
   Quantum of the angles, not below 0 [rad]; for devices that measure six axes. Default: 0.
   */
  double angle_quantum;
  /*
   0, the default: a device of three axes. 1: a device of six axes. 2: a device that measures six axes but gives no
   torque, so only the hand rotates the tool.
   */
  uint32_t turns;
  /*
   Must be 0.
   */
  uint32_t reserved;
} palpate_device_params;

/*
 A shape, in the axes of its tool or body. palpate_shape_default() fills it. Functions that take a shape copy its
 arrays.
 */
typedef struct palpate_shape {
  /*
   Size of this struct; palpate_shape_default() sets it.
   */
  size_t struct_size;
  /*
   One of palpate_shape_kind. Default: PALPATE_SHAPE_KIND_SPHERE.
   */
  uint32_t kind;
  /*
   Must be 0.
   */
  uint32_t reserved;
  /*
   Radius [m]. Default: 0.
   */
  double radius;
  /*
   Half the length of a capsule's segment or a cylinder [m].
   */
  double half_length;
  /*
   Half the length of a box along each axis [m].
   */
  double half_extents[3];
  /*
   Outward normal of a half-space, of any length above 0. Default: z.
   */
  double normal[3];
  /*
   Position of a half-space's surface along its normal [m].
   */
  double offset;
  /*
   Points of a mesh or hull, or centres of spheres: three numbers per point [m].
   */
  const double *points;
  /*
   Number of points.
   */
  size_t point_count;
  /*
   Triangles of a mesh: three point indices each, counter-clockwise as seen from outside.
   */
  const uint32_t *faces;
  /*
   Number of triangles.
   */
  size_t face_count;
} palpate_shape;

/*
 A body. palpate_body_params_default() fills it.
 */
typedef struct palpate_body_params {
  /*
   Size of this struct; palpate_body_params_default() sets it.
   */
  size_t struct_size;
  /*
   Initial pose; the position of a moving body is its centre of mass. Default: the origin.
   */
  struct palpate_pose pose;
  /*
   Mass, above 0 [kg]. INFINITY, the default: a fixed body, which must not have a velocity.
   */
  double mass;
  /*
   Moments of inertia about the centre of mass along the body axes [kg m^2]. All 0, the default: those of a
   homogeneous solid of its shape.
   */
  double inertia[3];
  /*
   Initial velocity of the centre of mass [m/s]. Default: 0.
   */
  double velocity[3];
  /*
   Initial angular velocity in world axes [rad/s]. Default: 0.
   */
  double angular_velocity[3];
  /*
   Constant force at the centre of mass, for instance its weight [N]. Default: 0.
   */
  double force[3];
} palpate_body_params;

/*
 Guard of a world. palpate_guard_params_default() fills it. The values of the hand are 0 by default: the guard
 bounds by speed only.
 */
typedef struct palpate_guard_params {
  /*
   Size of this struct; palpate_guard_params_default() sets it.
   */
  size_t struct_size;
  /*
   Largest speed of each device for which the bound holds, above 0 [m/s]. Default: 1.
   */
  double speed;
  /*
   Largest angular speed of each device that turns, above 0 [rad/s]. Default: 10.
   */
  double turning_speed;
  /*
   Energy that the guard allows beyond the energy balance, not below 0 [J]. Default: 0.05.
   */
  double allowance;
  /*
   Power by which the guard forgives energy that may have been given out unnoticed, not below 0 [W]. Default: 0.02.
   */
  double recovery;
  /*
   Largest acceleration of a device by everything except the rendered force [m/s^2]. It excludes hand_force.
   */
  double acceleration;
  /*
   Largest angular acceleration of a device that turns [rad/s^2], with acceleration.
   */
  double turning_acceleration;
  /*
   Largest force on a device by everything except the rendered force [N].
   */
  double hand_force;
  /*
   Largest torque on a device that turns by everything except the rendered torque [N m], with hand_force.
   */
  double hand_torque;
  /*
   Least mass of each device along each axis [kg]. 0: half of its model mass.
   */
  double least_mass;
  /*
   Least moment of inertia of each device that turns [kg m^2]. 0: half of the least model inertia.
   */
  double least_inertia;
  /*
   Delay of the forces beyond that of the scene, in samples, at most 8; 0 with a bound of the hand. Default: 0.
   */
  uint32_t late_samples;
  /*
   A palpate_guard. Default: PALPATE_GUARD_LIMIT.
   */
  uint32_t mode;
} palpate_guard_params;

/*
 Contact law: normal force and friction of two overlapping surfaces. palpate_contact_law_default() fills it.
 */
typedef struct palpate_contact_law {
  /*
   Size of this struct; palpate_contact_law_default() sets it.
   */
  size_t struct_size;
  /*
   Stiffness, above 0 [N/m]. It has no default.
   */
  double stiffness;
  /*
   Material damping, not below 0 [N s/m]. Default: 0.
   */
  double damping;
  /*
   Coefficient of friction, not below 0. Default: 0.
   */
  double friction;
  /*
   Stiffness of the friction bristle [N/m]. 0, the default: `stiffness`.
   */
  double friction_stiffness;
  /*
   Damping of the bristle [N s/m]. 0, the default: `damping` times `friction_stiffness` over `stiffness`. Below
   0: no damping.
   */
  double friction_damping;
} palpate_contact_law;

/*
 A joint: a bearing made of springs, stiff in all directions except one. palpate_joint_params_default() fills it.
 */
typedef struct palpate_joint_params {
  /*
   Size of this struct; palpate_joint_params_default() sets it.
   */
  size_t struct_size;
  /*
   A palpate_joint.
   */
  uint32_t kind;
  /*
   1: stops at `limits`. 0, the default: no stops.
   */
  uint32_t has_limits;
  /*
   Centre of the bearing in world axes, at the bodies' poses when the world is created or changed [m].
   */
  double point[3];
  /*
   Direction of the axis, of any length above 0. Default: z.
   */
  double axis[3];
  /*
   Stiffness in the constrained directions, above 0 [N/m]. It has no default.
   */
  double stiffness;
  /*
   Damping in the constrained directions, not below 0 [N s/m]. Default: 0.
   */
  double damping;
  /*
   Length of the bearing, above 0 [m]. It has no default.
   */
  double span;
  /*
   Stiffness of a spring along or about the axis, not below 0 [N/m], for a hinge [N m/rad]. Default: 0.
   */
  double spring;
  /*
   Rest position of that spring [m], for a hinge [rad]. Default: 0, the initial pose.
   */
  double rest;
  /*
   Damping along or about the axis, not below 0 [N s/m], for a hinge [N m s/rad]. Default: 0.
   */
  double along_damping;
  /*
   Positions of the stops [m], for a hinge [rad].
   */
  double limits[2];
} palpate_joint_params;

/*
 Overrides of the rendering parameters of a scene. palpate_world_params_default() fills it.
 */
typedef struct palpate_world_params {
  /*
   Size of this struct; palpate_world_params_default() sets it.
   */
  size_t struct_size;
  /*
   Name of the method, see palpate_world_method_name(). NULL, the default: that of the scene.
   */
  const char *method;
  /*
   Largest norm of the force on each device [N]. INFINITY: no limit, and no torque limit unless one is given. 0,
   the default: the limit of the scene, or 20 N, or that of the weakest motor if less.
   */
  double force_limit;
  /*
   Largest norm of the torque on each device [N m]. INFINITY: no limit. 0, the default: the limit of the scene,
   or 1 N m.
   */
  double torque_limit;
  /*
   Ramp time of the force if a start or a recovery is in contact, not below 0 [s]. Default: 0.2.
   */
  double soft_start;
} palpate_world_params;

/*
 A body at the last sample. palpate_body_state_empty() returns an empty one to be filled.
 */
typedef struct palpate_body_state {
  /*
   Size of this struct; palpate_body_state_empty() sets it.
   */
  size_t struct_size;
  /*
   Position of the centre of mass, and orientation.
   */
  struct palpate_pose pose;
  /*
   Velocity of the centre of mass [m/s].
   */
  double velocity[3];
  /*
   Angular velocity in world axes [rad/s].
   */
  double angular_velocity[3];
} palpate_body_state;

/*
 A potential contact point at the last sample. palpate_contact_state_empty() returns an empty one to be filled.
 */
typedef struct palpate_contact_state {
  /*
   Size of this struct; palpate_contact_state_empty() sets it.
   */
  size_t struct_size;
  /*
   Index of the first device; PALPATE_NO_DEVICE if the first object is a body.
   */
  uint32_t first_device;
  /*
   Index of the first body; PALPATE_NO_BODY if the first object is a device.
   */
  uint32_t first_body;
  /*
   Index of the second device; PALPATE_NO_DEVICE if the second object is a body.
   */
  uint32_t second_device;
  /*
   Index of the second body; PALPATE_NO_BODY if the second object is a device.
   */
  uint32_t second_body;
  /*
   Contact state.
   */
  palpate_touch touch;
  /*
   Unused; 0.
   */
  uint32_t reserved;
  /*
   Point of application of the force [m].
   */
  double point[3];
  /*
   Unit normal from the second to the first object.
   */
  double normal[3];
  /*
   Force on the first object [N].
   */
  double force[3];
  /*
   Penetration; 0 without overlap [m].
   */
  double penetration;
} palpate_contact_state;

/*
 Tool of a device at the last sample. palpate_device_state_empty() returns an empty one to be filled.
 */
typedef struct palpate_device_state {
  /*
   Size of this struct; palpate_device_state_empty() sets it.
   */
  size_t struct_size;
  /*
   Device pose as estimated by the method.
   */
  struct palpate_pose pose;
  /*
   Proxy pose, with which the world collides. Draw the tool here.
   */
  struct palpate_pose proxy;
  /*
   Velocity of the device [m/s].
   */
  double velocity[3];
  /*
   Velocity of the proxy [m/s].
   */
  double proxy_velocity[3];
} palpate_device_state;

/*
 Sums of a world's energy ledger up to the last sample. palpate_world_ledger_empty() returns an empty one to be
 filled.
 */
typedef struct palpate_world_ledger {
  /*
   Size of this struct; palpate_world_ledger_empty() sets it.
   */
  size_t struct_size;
  /*
   Kinetic energy of the bodies [J].
   */
  double kinetic;
  /*
   Potential energy of the bodies' constant forces, 0 at the start [J].
   */
  double potential;
  /*
   Elastic energy of contacts and joints [J].
   */
  double stored;
  /*
   Energy dissipated by damping and friction [J]; it never decreases.
   */
  double dissipated;
  /*
   Work of the devices' forces on the hands [J].
   */
  double port_work;
  /*
   Energy generated by held forces [J]: the gain of hands, bodies, contacts and dissipation together that no input
   supplied.
   */
  double created;
} palpate_world_ledger;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Returns the interface version of the library. It must equal `PALPATE_ABI_VERSION` of the header; otherwise
 header and library are incompatible.
 */
uint32_t palpate_abi_version(void);

/*
 Returns the version of the library, such as "0.1.0".
 */
const char *palpate_version(void);

/*
 Creates a contact and stores it in `*contact`, or NULL on an error. Free it with palpate_contact_free.
 Not in the firmware library.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_contact_new(const struct palpate_contact_params *params,
                                   const struct palpate_loop_params *loop_params,
                                   struct palpate_contact **contact);

/*
 Frees a contact of palpate_contact_new. NULL and a contact in caller-owned memory are ignored.
 Not in the firmware library.

 # Safety
 `contact` is NULL or a contact, and is not used afterwards.
 */
void palpate_contact_free(struct palpate_contact *contact);

/*
 Returns the size of a contact in bytes.
 */
size_t palpate_contact_size(void);

/*
 Returns the alignment of a contact in bytes.
 */
size_t palpate_contact_align(void);

/*
 Creates a contact in `size` bytes of caller-owned memory and stores its address in `*contact`, or NULL on
 an error. The contact lives as long as the memory and need not be freed.

 # Safety
 `memory` is NULL, or `size` bytes can be written there. Each other pointer is NULL or points to a value of its
 type; the first field of each struct is its size.
 */
palpate_status palpate_contact_place(void *memory,
                                     size_t size,
                                     const struct palpate_contact_params *params,
                                     const struct palpate_loop_params *loop_params,
                                     struct palpate_contact **contact);

/*
 Executes one tick: takes a sample and returns the force on the device [N], to be held until the next tick.

 It cannot fail: the force is finite for any input, and 0 if the sample is rejected or an argument is
 wrong. It does not allocate, lock, wait, or loop without bound. `output` may be NULL, except with
 PALPATE_HOLD_LINE, whose force is the mean of a line; otherwise its `fault` is the reason for rejecting a sample. PALPATE_FAULT_ARGUMENT means that an argument is wrong: no tick was
 executed, and the contact is unchanged.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
double palpate_contact_step(struct palpate_contact *contact,
                            const struct palpate_sample *sample,
                            struct palpate_output *output);

/*
 Reports the force that was actually sent to the device for the last tick, for example after saturation [N].
 A non-finite force is rejected.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_report_sent(struct palpate_contact *contact, double force_on_device);

/*
 Reports the line that was actually sent to the device for the last tick: its mean [N] and its slope [N/s]. With
 PALPATE_HOLD_LINE palpate_contact_report_sent reports a constant. A non-finite value is rejected.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_report_sent_line(struct palpate_contact *contact,
                                                double force_on_device,
                                                double slope_on_device);

/*
 Reports the measured mean force on the device since the last sample [N]. A non-finite force is rejected.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_report_held(struct palpate_contact *contact, double force_on_device);

/*
 Changes the rendering from the next tick on, without a step in the force: stiffness, mass, virtual force
 and the difference between two methods are blended over 0.1 s. The energy of the change is recorded as
 outside work. The object's position does not change (see palpate_contact_teleport), nor do the period and
 the side. On an error nothing changes.

 It does not allocate or wait, so the loop thread can call it between two ticks.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_contact_change(struct palpate_contact *contact,
                                      const struct palpate_contact_params *params,
                                      const struct palpate_loop_params *loop_params);

/*
 Moves the object's surface to `position` [m] with velocity `velocity` [m/s] at the next sample. The energy
 of the move is recorded as outside work.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_teleport(struct palpate_contact *contact, double position, double velocity);

/*
 Writes the energy ledger up to the last sample to `*ledger`.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_contact_ledger(const struct palpate_contact *contact, struct palpate_ledger *ledger);

/*
 Writes a description of the rendering to `memory`, truncated to `size` bytes and terminated by a 0.
 Returns the untruncated length without the 0, or 0 if `contact` is NULL.

 # Safety
 `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_contact_describe(const struct palpate_contact *contact, char *memory, size_t size);

/*
 As palpate_contact_new, in float: the parameters are rounded once. Not in the firmware library.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_contact_f32_new(const struct palpate_contact_params *params,
                                       const struct palpate_loop_params *loop_params,
                                       struct palpate_contact_f32 **contact);

/*
 As palpate_contact_free, in float. Not in the firmware library.

 # Safety
 `contact` is NULL or a contact, and is not used afterwards.
 */
void palpate_contact_f32_free(struct palpate_contact_f32 *contact);

/*
 As palpate_contact_size, in float.
 */
size_t palpate_contact_f32_size(void);

/*
 As palpate_contact_align, in float.
 */
size_t palpate_contact_f32_align(void);

/*
 As palpate_contact_place, in float: the parameters are rounded once.

 # Safety
 `memory` is NULL, or `size` bytes can be written there. Each other pointer is NULL or points to a value of its
 type; the first field of each struct is its size.
 */
palpate_status palpate_contact_f32_place(void *memory,
                                         size_t size,
                                         const struct palpate_contact_params *params,
                                         const struct palpate_loop_params *loop_params,
                                         struct palpate_contact_f32 **contact);

/*
 As palpate_contact_step, in float.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
float palpate_contact_f32_step(struct palpate_contact_f32 *contact,
                               const struct palpate_sample_f32 *sample,
                               struct palpate_output_f32 *output);

/*
 As palpate_contact_report_sent, in float.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_f32_report_sent(struct palpate_contact_f32 *contact, float force_on_device);

/*
 As palpate_contact_report_sent_line, in float.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_f32_report_sent_line(struct palpate_contact_f32 *contact,
                                                    float force_on_device,
                                                    float slope_on_device);

/*
 As palpate_contact_report_held, in float.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_f32_report_held(struct palpate_contact_f32 *contact, float force_on_device);

/*
 As palpate_contact_change, in float.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_contact_f32_change(struct palpate_contact_f32 *contact,
                                          const struct palpate_contact_params *params,
                                          const struct palpate_loop_params *loop_params);

/*
 As palpate_contact_teleport, in float.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_f32_teleport(struct palpate_contact_f32 *contact,
                                            float position,
                                            float velocity);

/*
 As palpate_contact_ledger, in float.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_contact_f32_ledger(const struct palpate_contact_f32 *contact,
                                          struct palpate_ledger_f32 *ledger);

/*
 As palpate_contact_describe, in float.

 # Safety
 `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_contact_f32_describe(const struct palpate_contact_f32 *contact, char *memory, size_t size);

/*
 Fills contact parameters with the defaults. `struct_size` is sizeof(palpate_contact_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_contact_params_init(struct palpate_contact_params *params, size_t struct_size);

/*
 Returns the message of the last failed call in UTF-8: what is wrong, the value, and the allowed range.
 Returns "" before the first failure. Each thread has its own message; the firmware library has one for the
 whole program. The text is valid until the next failed call, and not after the end of its thread.
 */
const char *palpate_last_error(void);

/*
 Creates both sides of a local model and stores them in `*world` and `*host`, or NULL on an error. The loop side
 belongs to the thread that samples the device, the simulator side to the thread of the simulator; neither waits
 for the other. Free them, in any order, with palpate_local_world_free and palpate_low_rate_simulator_free.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_local_world_new(const struct palpate_local_params *params,
                                       struct palpate_local_world **world,
                                       struct palpate_low_rate_simulator **host);

/*
 Frees the loop side of a local model. NULL is allowed.

 # Safety
 `world` is NULL or a loop side, and is not used afterwards.
 */
void palpate_local_world_free(struct palpate_local_world *world);

/*
 Executes one tick with the newest published model: takes a device sample with one pose and writes the wrench to
 hold until the next tick to `*wrench`. The orientation is ignored, and the torque is 0.

 It cannot fail: the wrench is finite for any input, and 0 if the sample is rejected or an argument is wrong; the
 return value is the reason. It does not allocate, lock, wait, or loop without bound. `output` may be NULL.
 PALPATE_FAULT_ARGUMENT means that an argument is wrong and no tick was executed.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_fault palpate_local_world_step(struct palpate_local_world *world,
                                       const struct palpate_world_sample *sample,
                                       struct palpate_wrench *wrench,
                                       struct palpate_local_output *output);

/*
 Reports the force that was actually sent to the device for the last tick, for example after saturation. A non-finite
 force is rejected.

 # Safety
 Each pointer is NULL or points to a value of its type.
 */
palpate_status palpate_local_world_report_sent(struct palpate_local_world *world,
                                               const struct palpate_wrench *sent);

/*
 Frees the simulator side of a local model. NULL is allowed. The loop fades out the last published model.

 # Safety
 `host` is NULL or a simulator side, and is not used afterwards.
 */
void palpate_low_rate_simulator_free(struct palpate_low_rate_simulator *host);

/*
 Writes the progress of the loop at its last tick to `*progress`, and the impulses of the tool on each body at the
 same tick to `bodies`. `body_count` is the number of bodies of the local model.

 # Safety
 Each pointer is NULL or points to a value of its type, `bodies` to `body_count` of them; the first field of each
 sized struct is its size.
 */
palpate_status palpate_low_rate_simulator_progress(struct palpate_low_rate_simulator *host,
                                                   struct palpate_progress *progress,
                                                   struct palpate_body_progress *bodies,
                                                   size_t body_count);

/*
 Publishes the simulator's bodies and contacts for a tick: the tick of the progress whose impulses the bodies
 include. The loop renders them from its next tick on. The index in `contacts` identifies a contact: the same
 index in the next model is the same, moved contact. On an error, whose message lists all faults, the previous
 model stays. The next progress reports a model that the loop rejects.

 # Safety
 Each pointer is NULL or points to a value of its type, `bodies` and `contacts` to `body_count` and
 `contact_count` of them.
 */
palpate_status palpate_low_rate_simulator_publish(struct palpate_low_rate_simulator *host,
                                                  uint64_t tick,
                                                  const struct palpate_host_body *bodies,
                                                  size_t body_count,
                                                  const struct palpate_host_contact *contacts,
                                                  size_t contact_count);

/*
 Fills local-model parameters with the defaults. `struct_size` is sizeof(palpate_local_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_local_params_init(struct palpate_local_params *params, size_t struct_size);

/*
 Fills loop parameters with the defaults. `struct_size` is sizeof(palpate_loop_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_loop_params_init(struct palpate_loop_params *params, size_t struct_size);

/*
 Returns the number of methods.
 */
size_t palpate_method_count(void);

/*
 Returns the number of settings of the method with the 0-based index `method`; 0 if there is no such method.
 */
size_t palpate_method_setting_count(size_t method);

/*
 Writes a text about the method with the 0-based index `method` to `memory`, truncated to `size` bytes and
 terminated by a 0. `what` is a palpate_about_method. Returns the untruncated length without the 0, or 0 if
 there is no such method or text.

 # Safety
 `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_method_text(size_t method, uint32_t what, char *memory, size_t size);

/*
 Writes a text about the setting with the 0-based index `setting` of the method with the 0-based index
 `method`, as palpate_method_text does. `what` is a palpate_about_setting.

 # Safety
 `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_setting_text(size_t method, size_t setting, uint32_t what, char *memory, size_t size);

/*
 Returns the name of a palpate_status, such as "struct-size", or "unknown". The text is static.
 */
const char *palpate_status_name(uint32_t status);

/*
 Returns the name of a palpate_fault as in files of the program, such as "gap-too-long", or "unknown".
 The text is static.
 */
const char *palpate_fault_name(uint32_t fault);

/*
 Starts the recording of a contact in a new file at `path` and stores the recorder in `*recorder`, or NULL on an
 error, which leaves no file. An existing file is not replaced. End the recording with palpate_recorder_close.
 `params` may be NULL: all defaults. Not in the firmware library.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_recorder_of_contact(const struct palpate_contact *contact,
                                           const char *path,
                                           const struct palpate_recorder_params *params,
                                           struct palpate_recorder **recorder);

/*
 Starts the recording of a world of one device, as palpate_recorder_of_contact does for a contact. `palpate
 replay` renders the motion again; it looks for mesh files beside the recording. For a world of several devices
 use palpate_recorder_of_device.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_recorder_of_world(const struct palpate_world *world,
                                         const char *path,
                                         const struct palpate_recorder_params *params,
                                         struct palpate_recorder **recorder);

/*
 Starts the recording of one device of a world, given by its index in the scene, with all contacts and bodies of
 the world. For several devices use one recorder and file each; a tick has the same number in every file.
 Otherwise as palpate_recorder_of_contact.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_recorder_of_device(const struct palpate_world *world,
                                          size_t device,
                                          const char *path,
                                          const struct palpate_recorder_params *params,
                                          struct palpate_recorder **recorder);

/*
 Returns the number of ticks dropped so far because the disk was slower than the loop; 0 if `recorder` is NULL.

 # Safety
 `recorder` is NULL or a recorder.
 */
uint64_t palpate_recorder_lost(const struct palpate_recorder *recorder);

/*
 Ends a recording: waits until all data is passed to the system, writes the number of ticks of the loop, and
 always frees the recorder. Returns PALPATE_STATUS_RECORDING if writing failed; the data written before is
 readable. `recorded` may be NULL. A NULL recorder is ignored.

 # Safety
 Each pointer is NULL or points to a value of its type; the recorder is not used afterwards.
 */
palpate_status palpate_recorder_close(struct palpate_recorder *recorder, struct palpate_recorded *recorded);

/*
 Fills recording parameters with the defaults. `struct_size` is sizeof(palpate_recorder_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_recorder_params_init(struct palpate_recorder_params *params, size_t struct_size);

/*
 Records a tick of the recorder's contact after its palpate_contact_step: the sample, the output, and the force
 that was actually sent to the device [N], or NaN if it is unknown. A tick of another contact is rejected.

 It does not allocate, lock or wait, so the loop thread can call it. If the queue is full, the tick is dropped and
 counted. Call it once for each tick, including rejected ones.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_recorder_contact_tick(struct palpate_recorder *recorder,
                                             const struct palpate_contact *contact,
                                             const struct palpate_sample *sample,
                                             const struct palpate_output *output,
                                             double sent_force,
                                             double sent_slope);

/*
 Records a tick of the recorder's world after its palpate_world_step: the sample, the output, and the wrench that was
 actually sent to the recorded device. A tick of another world, or of a world that was changed since the start of the
 recording, is rejected. Otherwise as palpate_recorder_contact_tick.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_recorder_world_tick(struct palpate_recorder *recorder,
                                           const struct palpate_world *world,
                                           const struct palpate_world_sample *sample,
                                           const struct palpate_world_output *output,
                                           const struct palpate_wrench *sent);

/*
 Creates a scene without devices, bodies, laws and joints and stores it in `*scene`, or NULL on an error. Free it
 with palpate_scene_free.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_new(const struct palpate_scene_params *params,
                                 struct palpate_scene **scene);

/*
 Creates a scene from a scene file, to be changed by calls. Otherwise as palpate_scene_new and
 palpate_world_open.

 # Safety
 Each pointer is NULL or points to a value of its type.
 */
palpate_status palpate_scene_open(const char *path, struct palpate_scene **scene);

/*
 Frees a scene. Worlds created from it stay valid. NULL is ignored.

 # Safety
 `scene` is NULL or a scene, and is not used afterwards.
 */
void palpate_scene_free(struct palpate_scene *scene);

/*
 Adds a device and the shape of its tool: a sphere, several spheres, a box, a capsule or a cylinder. The order of
 the calls determines its index in samples and wrenches. The name must not be "", "*", "world" or the name of
 another device or body, and must not contain a comma, quotation mark or control character.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_add_device(struct palpate_scene *scene,
                                        const char *name,
                                        const struct palpate_device_params *params,
                                        const struct palpate_shape *shape);

/*
 Adds a body. The order of the calls determines its index, unless an earlier body is removed.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_add_body(struct palpate_scene *scene,
                                      const char *name,
                                      const struct palpate_body_params *params,
                                      const struct palpate_shape *shape);

/*
 Writes the parameters of a body to `*params`. For a moving mesh or hull the position is its centre of mass.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_body(struct palpate_scene *scene,
                                  const char *name,
                                  struct palpate_body_params *params);

/*
 Replaces the parameters of a body. If `shape` is NULL, the shape is kept. On an error nothing changes.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_set_body(struct palpate_scene *scene,
                                      const char *name,
                                      const struct palpate_body_params *params,
                                      const struct palpate_shape *shape);

/*
 Removes a body with its joints and the laws that name it. The indices of later bodies decrease by one.

 # Safety
 Each pointer is NULL or points to a value of its type.
 */
palpate_status palpate_scene_remove_body(struct palpate_scene *scene, const char *name);

/*
 Returns the number of bodies of the scene; 0 if `scene` is NULL.

 # Safety
 `scene` is NULL or a scene.
 */
size_t palpate_scene_body_count(struct palpate_scene *scene);

/*
 Returns the number of devices of the scene; 0 if `scene` is NULL.

 # Safety
 `scene` is NULL or a scene.
 */
size_t palpate_scene_device_count(struct palpate_scene *scene);

/*
 Sets the guard of a scene, which worlds created from it have. It replaces an earlier guard.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_set_guard(struct palpate_scene *scene,
                                       const struct palpate_guard_params *params);

/*
 Fills guard parameters with the defaults. `struct_size` is sizeof(palpate_guard_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_guard_params_init(struct palpate_guard_params *params, size_t struct_size);

/*
 Sets the contact law of a pair and replaces a previous one. `one` and `other` are names of devices or bodies, or
 "*" for any. The most specific law applies: two names, then a name and "*", then "*" twice. Pairs without a law
 do not collide.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_set_law(struct palpate_scene *scene,
                                     const char *one,
                                     const char *other,
                                     const struct palpate_contact_law *law);

/*
 Writes the law of exactly this pair of names or "*" to `*law`.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_law(struct palpate_scene *scene,
                                 const char *one,
                                 const char *other,
                                 struct palpate_contact_law *law);

/*
 Removes the law of exactly this pair of names or "*".

 # Safety
 Each pointer is NULL or points to a value of its type.
 */
palpate_status palpate_scene_remove_law(struct palpate_scene *scene, const char *one, const char *other);

/*
 Adds a joint between a body and another one, or the world if `against` is NULL. The order of the calls determines
 its index, unless an earlier joint is removed.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_add_joint(struct palpate_scene *scene,
                                       const char *body,
                                       const char *against,
                                       const struct palpate_joint_params *params);

/*
 Replaces the parameters of a joint; its bodies stay the same. On an error nothing changes.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_scene_set_joint(struct palpate_scene *scene,
                                       size_t joint,
                                       const struct palpate_joint_params *params);

/*
 Removes a joint. The indices of later joints decrease by one.

 # Safety
 `scene` is NULL or a scene.
 */
palpate_status palpate_scene_remove_joint(struct palpate_scene *scene, size_t joint);

/*
 Returns the number of joints of the scene; 0 if `scene` is NULL.

 # Safety
 `scene` is NULL or a scene.
 */
size_t palpate_scene_joint_count(struct palpate_scene *scene);

/*
 Fills scene parameters with the defaults. `struct_size` is sizeof(palpate_scene_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_scene_params_init(struct palpate_scene_params *params, size_t struct_size);

/*
 Fills device parameters with the defaults. `struct_size` is sizeof(palpate_device_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_device_params_init(struct palpate_device_params *params, size_t struct_size);

/*
 Fills body parameters with the defaults. `struct_size` is sizeof(palpate_body_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_body_params_init(struct palpate_body_params *params, size_t struct_size);

/*
 Fills a contact law with the defaults. `struct_size` is sizeof(palpate_contact_law).

 # Safety
 `law` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_contact_law_init(struct palpate_contact_law *law, size_t struct_size);

/*
 Fills joint parameters with the defaults. `struct_size` is sizeof(palpate_joint_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_joint_params_init(struct palpate_joint_params *params, size_t struct_size);

/*
 Fills a shape with the defaults. `struct_size` is sizeof(palpate_shape).

 # Safety
 `shape` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_shape_init(struct palpate_shape *shape, size_t struct_size);

/*
 Creates the world of a scene file and stores it in `*world`, or NULL on an error. Free it with
 palpate_world_free. Mesh files are searched beside the scene. `params` may be NULL: all defaults.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_open(const char *path,
                                  const struct palpate_world_params *params,
                                  struct palpate_world **world);

/*
 Creates a world from the text of a scene. `name` is the path of the scene for messages, and mesh files
 are searched beside it; NULL: the working directory. Otherwise as palpate_world_open.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_new(const char *scene,
                                 const char *name,
                                 const struct palpate_world_params *params,
                                 struct palpate_world **world);

/*
 Creates the world of a scene and stores it in `*world`, or NULL on an error. Free it with palpate_world_free. The
 scene is not modified, and later changes of the scene do not affect the world. `params` may be NULL: all
 defaults.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_of_scene(struct palpate_scene *scene,
                                      const struct palpate_world_params *params,
                                      struct palpate_world **world);

/*
 Frees a world. NULL is ignored.

 # Safety
 `world` is NULL or a world, and is not used afterwards.
 */
void palpate_world_free(struct palpate_world *world);

/*
 Changes to another scene from the next tick on. A body with an existing name keeps its pose and velocity and
 takes shape, mass, force and fixedness from the scene. A body with a new name starts as in the scene, and a body
 that is not in the scene is removed. The laws are those of the scene. A joint with the same bodies, kind, point,
 axis and span continues; a new one starts at the current poses. The devices must be the same in the same order,
 except for the shapes of their tools. Method, period, limits and the model values of the devices do not change.
 On an error nothing changes.

 The wrenches are blended over 0.1 s, without a step; the energy of the change is recorded as outside work. The
 call allocates and takes as long as creating a world; a tick does not. Afterwards, indices of bodies may differ,
 names returned earlier are invalid, and recorders of the world must be closed.

 # Safety
 Each pointer is NULL or points to a value of its type.
 */
palpate_status palpate_world_change(struct palpate_world *world,
                                    struct palpate_scene *scene);

/*
 Moves a body from the next tick on to the pose and velocities of `state`; a fixed body must have zero velocity.
 `body` is its index. The wrenches are blended over 0.1 s, without a step; the energy of the move is recorded as
 outside work. It does not allocate, so the loop thread can call it between two ticks. On an error nothing
 changes.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_place(struct palpate_world *world,
                                   size_t body,
                                   const struct palpate_body_state *state);

/*
 Writes the index of the body with this name to `*body`. It is valid until the world is changed.

 # Safety
 Each pointer is NULL or points to a value of its type.
 */
palpate_status palpate_world_body_named(const struct palpate_world *world, const char *name, size_t *body);

/*
 Returns the number of potential contact points of the world, active or not; 0 if `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
size_t palpate_world_contact_count(const struct palpate_world *world);

/*
 Writes the state of a contact point to `*state`. `contact` is its 0-based index; a change of the world changes
 the indices.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_contact_state(const struct palpate_world *world,
                                           size_t contact,
                                           struct palpate_contact_state *state);

/*
 Writes the tool state of a device to `*state`. `device` is its index in the scene.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_device_state(const struct palpate_world *world,
                                          size_t device,
                                          struct palpate_device_state *state);

/*
 Returns the number of methods for worlds.
 */
size_t palpate_world_method_count(void);

/*
 Returns the name of the world method with the 0-based index `method`, as accepted by `method` of
 palpate_world_params, or NULL if there is no such method. The text is static.
 */
const char *palpate_world_method_name(size_t method);

/*
 Fills world parameters with the defaults. `struct_size` is sizeof(palpate_world_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_world_params_init(struct palpate_world_params *params, size_t struct_size);

/*
 Returns the number of devices; 0 if `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
size_t palpate_world_device_count(const struct palpate_world *world);

/*
 Returns the name of the device with this index in the scene, in UTF-8, or NULL. It is valid as long as the world.

 # Safety
 `world` is NULL or a world.
 */
const char *palpate_world_device_name(const struct palpate_world *world,
                                      size_t device);

/*
 Returns 1 for a device of six axes, 2 for a device that measures six axes but gives no torque, and 0 for a device
 of three axes or an invalid index.

 # Safety
 `world` is NULL or a world.
 */
uint32_t palpate_world_device_turns(const struct palpate_world *world,
                                    size_t device);

/*
 Returns the number of bodies, including fixed ones; 0 if `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
size_t palpate_world_body_count(const struct palpate_world *world);

/*
 Returns the name of the body with this index in the scene, in UTF-8, or NULL. It is valid until the world is
 changed or freed.

 # Safety
 `world` is NULL or a world.
 */
const char *palpate_world_body_name(const struct palpate_world *world, size_t body);

/*
 Returns the nominal sampling period [s]; 0 if `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
double palpate_world_period(const struct palpate_world *world);

/*
 Writes pose and velocities of a body to `*state`. `body` is its index in the scene.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_body_state(const struct palpate_world *world,
                                        size_t body,
                                        struct palpate_body_state *state);

/*
 Writes the sums of the energy ledger up to the last sample to `*ledger`.

 # Safety
 Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
 */
palpate_status palpate_world_ledger_of(const struct palpate_world *world,
                                       struct palpate_world_ledger *ledger);

/*
 Executes one tick: takes a sample of all devices and writes the wrenches to hold until the next tick to `wrenches`.
 `wrench_count` is the number of devices.

 It cannot fail: the wrenches are finite for any input, and all 0 if the sample is rejected or an argument is
 wrong; the return value is the reason. It does not allocate, lock, wait, or loop without bound. `output` may be
 NULL. PALPATE_FAULT_ARGUMENT means that an argument is wrong: no tick was executed, and the world is unchanged.

 # Safety
 Each pointer is NULL or points to a value of its type, `wrenches` to `wrench_count` of them; the first field of
 each sized struct is its size.
 */
palpate_fault palpate_world_step(struct palpate_world *world,
                                 const struct palpate_world_sample *sample,
                                 struct palpate_wrench *wrenches,
                                 size_t wrench_count,
                                 struct palpate_world_output *output);

/*
 Reports the wrench that was actually sent to a device for the last tick, for example after saturation. A non-finite
 wrench is rejected.

 # Safety
 Each pointer is NULL or points to a value of its type.
 */
palpate_status palpate_world_report_sent(struct palpate_world *world,
                                         size_t device,
                                         const struct palpate_wrench *sent);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#ifdef __cplusplus
extern "C" {
#endif

/*
 Defined by a firmware only: sets the motor forces to zero and does not return. A panic of the library
 calls it; a tick does not panic.
 */
void palpate_panicked(void);

#ifdef __cplusplus
}
#endif

/* Returns the default loop parameters: no period, force limit 20 N. */
static inline palpate_loop_params palpate_loop_params_default(void) {
  palpate_loop_params params;
  palpate_loop_params_init(&params, sizeof params);
  return params;
}

/* Returns the default contact parameters: a wall at 0 m, no stiffness. */
static inline palpate_contact_params palpate_contact_params_default(void) {
  palpate_contact_params params;
  palpate_contact_params_init(&params, sizeof params);
  return params;
}

/* Returns a sample at `device_position` [m], one period after the previous one. */
static inline palpate_sample palpate_sample_at(double device_position) {
  palpate_sample sample = {sizeof(palpate_sample), device_position, 0.0, 0.0, 0, 0};
  return sample;
}

/* Returns an empty output for palpate_contact_step. */
static inline palpate_output palpate_output_empty(void) {
  palpate_output output = {
      sizeof(palpate_output), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, PALPATE_PHASE_WAITING, PALPATE_FAULT_NONE, 0, 0};
  return output;
}

/* palpate_sample_at, in float. */
static inline palpate_sample_f32 palpate_sample_f32_at(float device_position) {
  palpate_sample_f32 sample = {sizeof(palpate_sample_f32), device_position, 0.0f, 0.0f, 0, 0};
  return sample;
}

/* palpate_output_empty, in float. */
static inline palpate_output_f32 palpate_output_f32_empty(void) {
  palpate_output_f32 output = {sizeof(palpate_output_f32), 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
                               PALPATE_PHASE_WAITING, PALPATE_FAULT_NONE, 0, 0};
  return output;
}

/* palpate_ledger_empty, in float. */
static inline palpate_ledger_f32 palpate_ledger_f32_empty(void) {
  palpate_ledger_f32 ledger = {
      sizeof(palpate_ledger_f32), 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  return ledger;
}

/* Returns an empty energy ledger for palpate_contact_ledger. */
static inline palpate_ledger palpate_ledger_empty(void) {
  palpate_ledger ledger = {
      sizeof(palpate_ledger), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  return ledger;
}

/* Returns the default world parameters: values of the scene; force limit 20 N if the scene has none. */
static inline palpate_world_params palpate_world_params_default(void) {
  palpate_world_params params;
  palpate_world_params_init(&params, sizeof params);
  return params;
}

/* Returns a sample of `count` devices, one period after the previous one. */
static inline palpate_world_sample palpate_world_sample_at(const palpate_pose *poses, size_t count) {
  palpate_world_sample sample = {sizeof(palpate_world_sample), poses, count, 0.0, 0, 0};
  return sample;
}

/* Returns an empty output for palpate_world_step. */
static inline palpate_world_output palpate_world_output_empty(void) {
  palpate_world_output output = {
      sizeof(palpate_world_output), PALPATE_FAULT_NONE, PALPATE_NO_DEVICE, 0, 0, 0, 0, 0, 0};
  return output;
}

/* Returns the default recording parameters: no device name, no scene, a queue of 65536 ticks. */
static inline palpate_recorder_params palpate_recorder_params_default(void) {
  palpate_recorder_params params;
  palpate_recorder_params_init(&params, sizeof params);
  return params;
}

/* Returns an empty result for palpate_recorder_close. */
static inline palpate_recorded palpate_recorded_empty(void) {
  palpate_recorded recorded = {sizeof(palpate_recorded), 0, 0, 0};
  return recorded;
}

/* Returns an empty body state for palpate_world_body_state. */
static inline palpate_body_state palpate_body_state_empty(void) {
  palpate_body_state state = {
      sizeof(palpate_body_state), {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  return state;
}

/* Returns the default scene parameters: no period. */
static inline palpate_scene_params palpate_scene_params_default(void) {
  palpate_scene_params params;
  palpate_scene_params_init(&params, sizeof params);
  return params;
}

/* Returns the default guard parameters: a limit by speed. */
static inline palpate_guard_params palpate_guard_params_default(void) {
  palpate_guard_params params;
  palpate_guard_params_init(&params, sizeof params);
  return params;
}

/* Returns the default device parameters: three axes, no mass. */
static inline palpate_device_params palpate_device_params_default(void) {
  palpate_device_params params;
  palpate_device_params_init(&params, sizeof params);
  return params;
}

/* Returns the default body parameters: fixed at the origin. */
static inline palpate_body_params palpate_body_params_default(void) {
  palpate_body_params params;
  palpate_body_params_init(&params, sizeof params);
  return params;
}

/* Returns the default shape: a point. */
static inline palpate_shape palpate_shape_default(void) {
  palpate_shape shape;
  palpate_shape_init(&shape, sizeof shape);
  return shape;
}

/* Returns the default contact law: no stiffness. */
static inline palpate_contact_law palpate_contact_law_default(void) {
  palpate_contact_law law;
  palpate_contact_law_init(&law, sizeof law);
  return law;
}

/* Returns the default joint parameters: a hinge about z at the origin, no stiffness and no span. */
static inline palpate_joint_params palpate_joint_params_default(void) {
  palpate_joint_params params;
  palpate_joint_params_init(&params, sizeof params);
  return params;
}

/* Returns an empty contact state for palpate_world_contact_state. */
static inline palpate_contact_state palpate_contact_state_empty(void) {
  palpate_contact_state state = {sizeof(palpate_contact_state),
                                 PALPATE_NO_DEVICE,
                                 PALPATE_NO_BODY,
                                 PALPATE_NO_DEVICE,
                                 PALPATE_NO_BODY,
                                 PALPATE_TOUCH_FREE,
                                 0,
                                 {0.0, 0.0, 0.0},
                                 {0.0, 0.0, 0.0},
                                 {0.0, 0.0, 0.0},
                                 0.0};
  return state;
}

/* Returns an empty tool state for palpate_world_device_state. */
static inline palpate_device_state palpate_device_state_empty(void) {
  palpate_device_state state = {sizeof(palpate_device_state),
                                {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}},
                                {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}},
                                {0.0, 0.0, 0.0},
                                {0.0, 0.0, 0.0}};
  return state;
}

/* Returns the default local-model parameters: no period and no device mass. */
static inline palpate_local_params palpate_local_params_default(void) {
  palpate_local_params params;
  palpate_local_params_init(&params, sizeof params);
  return params;
}

/* Returns an empty output for palpate_local_world_step. */
static inline palpate_local_output palpate_local_output_empty(void) {
  palpate_local_output output = {
      sizeof(palpate_local_output), 0.0, PALPATE_FAULT_NONE, 0, 0, PALPATE_MODEL_REFUSAL_NONE, 0, 0, 0, 0};
  return output;
}

/* Returns an empty progress for palpate_low_rate_simulator_progress. */
static inline palpate_progress palpate_progress_empty(void) {
  palpate_progress progress = {sizeof(palpate_progress), 0, 0.0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0, 0, 0,
                               PALPATE_MODEL_REFUSAL_NONE, 0};
  return progress;
}

/* Returns the mean wrench of the tool on a body over `time` [s] between two progresses, which the simulator holds over its
   step. Returns 0 if `time` is not positive. */
static inline palpate_wrench palpate_mean_wrench(const palpate_body_progress *then, const palpate_body_progress *now,
                                                 double time) {
  palpate_wrench wrench = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  int axis;
  for (axis = 0; axis < 3 && time > 0.0; axis++) {
    wrench.force[axis] = (now->impulse[axis] - then->impulse[axis]) / time;
    wrench.torque[axis] = (now->moment[axis] - then->moment[axis]) / time;
  }
  return wrench;
}

/* Returns an immovable body at rest at x, y, z [m] with the identity orientation. */
static inline palpate_host_body palpate_host_body_fixed(double x, double y, double z) {
  palpate_host_body body = {{{x, y, z}, {1.0, 0.0, 0.0, 0.0}},
                            {0.0, 0.0, 0.0},
                            {0.0, 0.0, 0.0},
                            {0.0, 0.0, 0.0},
                            {0.0, 0.0, 0.0},
                            {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}}};
  return body;
}

/* Returns an empty array element: no contact. */
static inline palpate_host_contact palpate_host_contact_none(void) {
  palpate_host_contact contact = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
                                  {0.0, 0.0, 0.0}, 0.0, PALPATE_NO_BODY, PALPATE_NO_BODY};
  return contact;
}

/* Returns a contact of the tool with a flat surface of the body with index `on`, or PALPATE_NO_BODY, from the distance query of
   most engines: the signed `gap` [m] between the surface and the tool, a sphere of `radius` [m], with the tool's centre at
   `centre` [m]. A negative gap is a penetration. `normal` is the outward unit normal. Damping and friction are 0. */
static inline palpate_host_contact palpate_host_contact_at_gap(const double centre[3], double radius, uint32_t on, double gap,
                                                               const double normal[3], double stiffness) {
  palpate_host_contact contact = palpate_host_contact_none();
  int axis;
  for (axis = 0; axis < 3; axis++) {
    contact.place[axis] = centre[axis] - normal[axis] * (gap + radius);
    contact.normal[axis] = normal[axis];
  }
  contact.stiffness = stiffness;
  contact.on = on;
  return contact;
}

/* Returns an empty energy ledger for palpate_world_ledger_of. */
static inline palpate_world_ledger palpate_world_ledger_empty(void) {
  palpate_world_ledger ledger = {sizeof(palpate_world_ledger), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  return ledger;
}
